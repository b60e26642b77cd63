#include "world/synth/natural.h"
#include <math.h>
#include <stdbool.h>
#include <stdio.h>
#include "core/base/rng.h"
#include "world/shapes/noise.h"
#include "world/shapes/scalar.h"
#include "world/synth/stroke.h"

// All painters work in sRGB values on a canvas whose smaller side is `size` pixels.
typedef struct Canvas {
    FfpImage image;
    float size;
    FfpRng rng;
    uint32_t noise;
} Canvas;

static float draw(Canvas *c, float low, float high) {
    return ffp_rng_range(&c->rng, low, high);
}

static void draw_colour(Canvas *c, float low, float high, real colour[3]) {
    for (int k = 0; k < 3; k++) colour[k] = (real)draw(c, low, high);
}

static void draw_point(Canvas *c, float p[2]) {
    p[0] = draw(c, 0, (float)c->image.width);
    p[1] = draw(c, 0, (float)c->image.height);
}

static real *pixel_at(const Canvas *c, int x, int y) {
    return c->image.data + 3 * ((size_t)y * (size_t)c->image.width + (size_t)x);
}

static void fill(const Canvas *c, const real colour[3]) {
    for (int y = 0; y < c->image.height; y++)
        for (int x = 0; x < c->image.width; x++)
            for (int k = 0; k < 3; k++) pixel_at(c, x, y)[k] = colour[k];
}

static FfpPen pen_of(Canvas *c, float width, const real colour[3]) {
    return (FfpPen){&c->image, ffp_max(1, width * c->size), {colour[0], colour[1], colour[2]}};
}

// Colours at a few points, blended by their distance (Shepard 1968).
static void paint_gradient(Canvas *c) {
    enum { POINTS = 6 };
    float at[POINTS][2];
    real colour[POINTS][3];
    for (int i = 0; i < POINTS; i++) {
        draw_point(c, at[i]);
        draw_colour(c, 0, 1, colour[i]);
    }
    const float near = 0.02F * c->size * c->size;
#pragma omp parallel for schedule(static)
    for (int y = 0; y < c->image.height; y++)
        for (int x = 0; x < c->image.width; x++) {
            real *p = pixel_at(c, x, y);
            float total = 0, sum[3] = {0, 0, 0};
            for (int i = 0; i < POINTS; i++) {
                const float dx = (float)x + 0.5F - at[i][0], dy = (float)y + 0.5F - at[i][1];
                const float square = dx * dx + dy * dy + near, weight = 1 / (square * square);
                total += weight;
                for (int k = 0; k < 3; k++) sum[k] += weight * (float)colour[i][k];
            }
            for (int k = 0; k < 3; k++) p[k] = (real)(sum[k] / total);
        }
}

static const char *const words[] = {"LIGHT", "falls", "on",     "stone", "AND",   "clay",  "a",
                                    "lamp",  "moves", "over",   "hills", "the",   "RIVER", "turns",
                                    "white", "paper", "shadow", "of",    "trees", "in",    "June",
                                    "1824",  "north", "WIND",   "seven", "doors", "open,", "gently",
                                    "stage", "to",    "red",    "glass", "9:45",  "quiet", "music"};
enum { WORDS = sizeof words / sizeof words[0] };

static const char *draw_word(Canvas *c) {
    return words[ffp_rng_below(&c->rng, WORDS)];
}

// A page: a heading, lines of words in sizes between large print and poster, and one word across it.
static void paint_text(Canvas *c) {
    const bool dark = draw(c, 0, 1) < 0.4F; // light letters on a dark page
    real ground[3];
    draw_colour(c, dark ? 0 : 0.75F, dark ? 0.25F : 1, ground);
    fill(c, ground);
    const float margin = 0.06F * c->size;
    for (float y = margin; y < (float)c->image.height - margin;) {
        const float height = c->size * (y <= margin ? 0.09F : draw(c, 0.022F, 0.06F));
        real ink[3];
        draw_colour(c, dark ? 0.5F : 0, dark ? 1 : 0.5F, ink);
        const FfpPen pen = pen_of(c, 0.16F * height / c->size, ink);
        for (float x = margin; x < (float)c->image.width - margin;) {
            const char *word = draw_word(c);
            if (x + ffp_stroke_length(height, word) > (float)c->image.width) break;
            x += ffp_stroke_text(&pen, (float[2]){x, y}, height, 0, word) + 0.6F * height;
        }
        y += 1.7F * height;
    }
    real across[3];
    draw_colour(c, 0, 1, across);
    const FfpPen stamp = pen_of(c, 0.03F, across);
    const float x = draw(c, 0.1F, 0.3F) * c->size, y = draw(c, 0.3F, 0.6F) * c->size;
    ffp_stroke_text(&stamp, (float[2]){x, y}, 0.14F * c->size, draw(c, -0.5F, 0.5F), draw_word(c));
}

// 1/f noise: brightness of all frequencies down to two pixels, and colour that changes more slowly.
static void paint_noise(const Canvas *c, const real middle[3], float contrast) {
    const float unit = 3 / c->size;
#pragma omp parallel for schedule(static)
    for (int y = 0; y < c->image.height; y++)
        for (int x = 0; x < c->image.width; x++) {
            real *p = pixel_at(c, x, y);
            const float q[3] = {unit * (float)x, unit * (float)y, 0.5F};
            const float bright = contrast * ffp_fbm(q, c->noise, 8);
            for (uint32_t k = 0; k < 3; k++)
                p[k] = middle[k] + (real)(bright + 0.22F * ffp_fbm(q, c->noise + 11 + k, 4));
        }
}

// One object in front of what is painted: its own colour, shaded towards a side, over the noise behind it.
static void paint_leaf(Canvas *c, const float centre[2], float radius, const real colour[3]) {
    const float power = draw(c, 1.2F, 6), squash = draw(c, 0.4F, 1), turn = draw(c, 0, 6.28F),
                cosine = cosf(turn), sine = sinf(turn);
    const float shade = draw(c, -0.35F, 0.35F), reach = 1.42F * radius + 1;
    const int left = (int)ffp_max(0, centre[0] - reach), top = (int)ffp_max(0, centre[1] - reach);
    for (int y = top; y < c->image.height && (float)y < centre[1] + reach; y++)
        for (int x = left; x < c->image.width && (float)x < centre[0] + reach; x++) {
            const float dx = ((float)x + 0.5F - centre[0]) / radius,
                        dy = ((float)y + 0.5F - centre[1]) / radius;
            const float u = cosine * dx + sine * dy, v = (cosine * dy - sine * dx) / squash;
            const float cover = ffp_min(
                1,
                ffp_max(0, 0.5F + radius * squash *
                                      (1 - powf(powf(fabsf(u), power) + powf(fabsf(v), power), 1 / power))));
            real *p = pixel_at(c, x, y);
            for (int k = 0; k < 3 && cover > 0; k++) {
                const real own = colour[k] + (real)(shade * (u + v)) + (p[k] - (real)0.5) * (real)0.3;
                p[k] += (real)cover * (own - p[k]);
            }
        }
}

// Dead leaves (Matheron 1968; Lee, Mumford and Huang 2001): objects of all sizes that hide each other have
// the edges and the spectrum of photographs.
static void paint_photograph(Canvas *c) {
    real middle[3];
    draw_colour(c, 0.35F, 0.65F, middle);
    paint_noise(c, middle, 0.6F);
    const int leaves = 60 + (int)draw(c, 0, 80);
    for (int i = 0; i < leaves; i++) {
        float at[2];
        draw_point(c, at);
        real colour[3];
        draw_colour(c, 0, 1, colour);
        const float bright = draw(c, 0.1F, 0.9F); // muted, as most things are
        for (int k = 0; k < 3; k++) colour[k] = (real)bright + (real)0.45 * (colour[k] - (real)0.5);
        paint_leaf(c, at, c->size * 0.05F / sqrtf(draw(c, 0.03F, 1)), colour); // 0.05 to 0.29 of the side
    }
}

static void spoke(const FfpPen *pen, const float centre[2], float turn, float from, float to) {
    const float x = sinf(6.2831853F * turn), y = -cosf(6.2831853F * turn);
    ffp_stroke_line(pen, (float[2]){centre[0] + from * x, centre[1] + from * y},
                    (float[2]){centre[0] + to * x, centre[1] + to * y});
}

static void paint_clock(Canvas *c) {
    real wall[3], face[3], ink[3], hand[3];
    draw_colour(c, 0.1F, 0.8F, wall);
    draw_colour(c, 0.75F, 1, face);
    draw_colour(c, 0, 0.35F, ink);
    draw_colour(c, 0, 0.8F, hand);
    paint_noise(c, wall, 0.3F);
    const float centre[2] = {0.5F * (float)c->image.width, 0.5F * (float)c->image.height};
    const float r = 0.46F * c->size;
    const FfpPen rim = pen_of(c, 0.01F, ink), plate = pen_of(c, 0.01F, face),
                 pointer = pen_of(c, 0.028F, hand);
    ffp_stroke_disc(&rim, centre, r);
    ffp_stroke_disc(&plate, centre, 0.93F * r);
    for (int minute = 0; minute < 60; minute++) {
        const FfpPen tick = pen_of(c, minute % 5 ? 0.006F : 0.016F, ink);
        spoke(&tick, centre, (float)minute / 60, minute % 5 ? 0.87F * r : 0.8F * r, 0.9F * r);
    }
    const FfpPen figure = pen_of(c, 0.012F, ink);
    for (int hour = 1; hour <= 12; hour++) {
        char text[8];
        snprintf(text, sizeof text, "%d", hour);
        const float height = 0.075F * c->size, angle = 6.2831853F * (float)hour / 12;
        const float half = 0.5F * (ffp_stroke_length(height, text) - height / 3);
        const float at[2] = {centre[0] + 0.66F * r * sinf(angle) - half,
                             centre[1] - 0.66F * r * cosf(angle) - 0.5F * height};
        ffp_stroke_text(&figure, at, height, 0, text);
    }
    const float time = draw(c, 0, 12);
    const FfpPen thin = pen_of(c, 0.008F, ink);
    spoke(&pointer, centre, time / 12, -0.1F * r, 0.48F * r);
    spoke(&pointer, centre, time - floorf(time), -0.12F * r, 0.75F * r);
    spoke(&thin, centre, draw(c, 0, 1), -0.15F * r, 0.82F * r);
    ffp_stroke_disc(&rim, centre, 0.05F * r);
}

// The map's colour at a point: land of a district, its border, or water.
static void map_colour(const Canvas *c, int x, int y, const real land[6][3], real out[3]) {
    static const real border[3] = {(real)0.25, (real)0.2, (real)0.25},
                      water[3] = {(real)0.45, (real)0.68, (real)0.9};
    const float unit = 6 / c->size, px = unit * (float)x, py = unit * (float)y;
    const float flat[3] = {px, py, 0.5F}, warp = 0.35F * ffp_fbm(flat, c->noise, 4);
    const float bent[3] = {px + warp, py - warp, 0.5F};
    const FfpCells cell = ffp_cells(bent, c->noise + 1);
    const float line = 1 - ffp_min(1, ffp_max(0, (cell.second - cell.nearest - 0.02F) / 0.02F));
    const float slow[3] = {0.22F * px, 0.22F * py, 2.5F}, level = ffp_fbm(slow, c->noise + 2, 5);
    const float river = ffp_min(1, ffp_max(0, (0.035F - fabsf(level)) / 0.01F));
    const float sea = ffp_min(1, ffp_max(0, (level - 0.38F) / 0.01F)), wet = ffp_max(river, sea);
    for (int k = 0; k < 3; k++) {
        const real dry = land[cell.id % 6U][k] + (real)line * (border[k] - land[cell.id % 6U][k]);
        out[k] = dry + (real)wet * (water[k] - dry);
    }
}

static void paint_map(Canvas *c) {
    real land[6][3];
    for (int i = 0; i < 6; i++) draw_colour(c, 0.5F, 1, land[i]);
#pragma omp parallel for schedule(static)
    for (int y = 0; y < c->image.height; y++)
        for (int x = 0; x < c->image.width; x++)
            map_colour(c, x, y, (const real(*)[3])land, pixel_at(c, x, y));
    const real casing[3] = {(real)0.3, (real)0.15, (real)0.1}, road[3] = {(real)0.98, (real)0.8, (real)0.25};
    const FfpPen outer = pen_of(c, 0.012F, casing), inner = pen_of(c, 0.007F, road);
    const FfpPen name = pen_of(c, 0.005F, (real[3]){0, 0, (real)0.1});
    float town[9][2];
    for (int i = 0; i < 9; i++) draw_point(c, town[i]);
    for (int i = 0; i < 8; i++) ffp_stroke_line(&outer, town[i], town[i + 1]);
    for (int i = 0; i < 8; i++) ffp_stroke_line(&inner, town[i], town[i + 1]);
    for (int i = 0; i < 9; i++) {
        ffp_stroke_disc(&outer, town[i], 0.014F * c->size);
        const float at[2] = {town[i][0] + 0.02F * c->size, town[i][1] - 0.04F * c->size};
        ffp_stroke_text(&name, at, 0.028F * c->size, 0, draw_word(c));
    }
}

static const struct Painter {
    const char *name;
    void (*paint)(Canvas *canvas);
} painters[FFP_NATURAL_KINDS] = {
    {"gradient", paint_gradient}, {"text", paint_text}, {"photograph", paint_photograph},
    {"clock", paint_clock},       {"map", paint_map},
};

const char *ffp_natural_name(int index) {
    return painters[index % FFP_NATURAL_KINDS].name;
}

FfpImage ffp_natural_pattern(int width, int height, int index, uint64_t seed) {
    Canvas canvas = {.image = ffp_image_new(width, height, 3),
                     .size = (float)(width < height ? width : height),
                     .rng = ffp_rng(seed, 0x7a1e0000ULL + (uint64_t)index)};
    canvas.noise = ffp_rng_u32(&canvas.rng);
    painters[index % FFP_NATURAL_KINDS].paint(&canvas);
    const size_t values = (size_t)width * (size_t)height * 3;
    for (size_t i = 0; i < values; i++) {
        const float encoded = ffp_min(1, ffp_max(0, (float)canvas.image.data[i]));
        canvas.image.data[i] = ffp_srgb_decode((real)(roundf(255 * encoded) / 255));
    }
    return canvas.image;
}
