#include <tgmath.h>
#include "core/base/arena.h"
#include "core/numerics/rank.h"
#include "rig/findings/tell.h"
#include "rig/masks/layers.h"
#include "rig/masks/limits.h"
#include "rig/masks/steps.h"

typedef struct Comparison {
    const FfpLayers *view, *stage;
    const FfpImage *known;      // of the stage; .data NULL: everywhere
    double noise, gain, bright; // what white adds where the stage is well lit
} Comparison;

static double grey(const FfpImage *image, ptrdiff_t pixel) {
    const real *p = image->data + 3 * pixel;
    return ((double)p[0] + (double)p[1] + (double)p[2]) / 3;
}

// The median of what white adds here over what it adds to the stage: most of a picture is stage.
static double find_gain(const Comparison *c) {
    const ptrdiff_t pixels = (ptrdiff_t)c->view->width * c->view->height;
    double *ratios = ffp_alloc((size_t)pixels + 1, sizeof *ratios);
    size_t n = 0;
    for (ptrdiff_t i = 0; i < pixels; i++) {
        const double there = grey(&c->stage->of[1], i), here = grey(&c->view->of[1], i);
        if (there > LIT_NOISE * c->noise && here > 0.5 * there && here < 2 * there)
            ratios[n++] = here / there;
    }
    const double gain = n > 0 ? ffp_median(ratios, n) : 1;
    ffp_free(ratios);
    return fmin(fmax(gain, 1 / STAGE_GAIN_MOST), STAGE_GAIN_MOST);
}

static double bright_of(const FfpLayers *stage) {
    const size_t pixels = (size_t)stage->width * (size_t)stage->height;
    double *levels = ffp_alloc(pixels + 1, sizeof *levels);
    for (size_t i = 0; i < pixels; i++) levels[i] = grey(&stage->of[1], (ptrdiff_t)i);
    const double out = ffp_quantile(levels, pixels, 0.95);
    ffp_free(levels);
    return out;
}

// How much a layer of the stage varies in one channel around a pixel.
static double spread(const FfpImage *image, int x, int y, int channel) {
    double least = INFINITY, most = -INFINITY;
    for (int k = 0; k < 9; k++) {
        const int px = x + k % 3 - 1, py = y + k / 3 - 1;
        if (px < 0 || py < 0 || px >= image->width || py >= image->height) continue;
        const double value = (double)image->data[3 * ((ptrdiff_t)py * image->width + px) + channel];
        least = fmin(least, value), most = fmax(most, value);
    }
    return most - least;
}

typedef struct Values { // of one pixel, layer by layer and channel by channel; black first
    int n;
    double view[3 * FFP_LAYERS_MAX], stage[3 * FFP_LAYERS_MAX], spread[3 * FFP_LAYERS_MAX];
} Values;

static void take_values(const Comparison *c, int x, int y, Values *v) {
    const ptrdiff_t at = 3 * ((ptrdiff_t)y * c->view->width + x);
    v->n = 3 * c->view->n;
    for (int i = 0; i < v->n; i++) {
        const double gain = i < 3 ? 1 : c->gain;
        v->view[i] = (double)c->view->of[i / 3].data[at + i % 3];
        v->stage[i] = gain * (double)c->stage->of[i / 3].data[at + i % 3];
        v->spread[i] = gain * spread(&c->stage->of[i / 3], x, y, i % 3);
    }
}

// The factor by which the stage's light explains the first n values' best, and the mean squared error left.
static double explain(const Values *v, int n, double noise, double *error) {
    double across = 0, square = 0, sum = 0;
    for (int i = 3; i < n; i++) {
        const double s = ffp_layers_variance(noise, fmax(v->view[i], v->stage[i]), v->spread[i]);
        across += v->view[i] * v->stage[i] / s, square += v->stage[i] * v->stage[i] / s;
    }
    const double a = square > 0 ? fmin(fmax(across / square, 0), STAGE_FULL_MOST) : 0;
    for (int i = 3; i < n; i++) {
        const double off = v->view[i] - a * v->stage[i];
        sum += off * off / ffp_layers_variance(noise, fmax(v->view[i], a * v->stage[i]), a * v->spread[i]);
    }
    *error = sum / (n - 3);
    return a;
}

// True if white looks as it does in a shadow of the projector, which light from other surfaces reaches: their
// mixture of a pattern is not the pattern's colour here. The room's own light is left.
static bool may_be_shadow(const Values *v, double noise) {
    double error, here = 0, there = 0;
    for (int i = 0; i < 3; i++) here += v->view[i], there += v->stage[i];
    return here > STAGE_ROOM_LEAST * there && explain(v, 6, noise, &error) < STAGE_SHADOW_MOST &&
           error < ALIKE;
}

// How the pictures themselves differ, whatever lit them.
static double difference_of(const Values *v, double noise) {
    double sum = 0;
    for (int i = 0; i < v->n; i++) {
        const double black = i < 3 ? 0 : 1;
        const double here = v->view[i] + black * v->view[i % 3],
                     there = v->stage[i] + black * v->stage[i % 3];
        sum += (here - there) * (here - there) / ffp_layers_variance(0.67 * noise, there, v->spread[i]);
    }
    return sum / v->n;
}

static bool is_alike_under_black(const Values *v, double noise) {
    double sum = 0;
    for (int i = 0; i < 3; i++) {
        const double off = v->view[i] - v->stage[i];
        sum += off * off / ffp_layers_variance(noise, v->stage[i], v->spread[i]);
    }
    return sum < 3 * ALIKE;
}

// True if what white adds is as on the stage around, where the stage itself is not known.
static bool continues(const Comparison *c, ptrdiff_t pixel) {
    for (int i = 0; i < 3; i++) {
        const double here = (double)c->view->of[1].data[3 * pixel + i],
                     there = c->gain * (double)c->stage->of[1].data[3 * pixel + i];
        if (fabs(here - there) > c->noise + STAGE_CONTINUES * fmax(here, there)) return false;
    }
    return true;
}

static FfpPixelKind kind_of(const Comparison *c, int x, int y) {
    const ptrdiff_t at = (ptrdiff_t)y * c->view->width + x;
    const bool lit = grey(&c->view->of[1], at) > LIT_NOISE * c->noise;
    if (c->known->data && c->known->data[at] < 0 && lit) return FFP_PIXEL_OBJECT;
    if (c->known->data && !(c->known->data[at] > 0))
        return lit && !continues(c, at) ? FFP_PIXEL_LIT : FFP_PIXEL_UNKNOWN;
    const bool stage_lit = grey(&c->stage->of[1], at) > LIT_NOISE * c->noise;
    Values v = {0};
    double error;
    take_values(c, x, y, &v);
    const double a = explain(&v, v.n, c->noise, &error);
    if (stage_lit && a > STAGE_FULL_LEAST && error < ALIKE) return FFP_PIXEL_STAGE;
    if (lit && error > STAGE_OTHER && !may_be_shadow(&v, c->noise)) return FFP_PIXEL_OBJECT;
    if (grey(&c->stage->of[1], at) < STAGE_INDIRECT * c->bright && a > STAGE_DIMMED && error < ALIKE &&
        is_alike_under_black(&v, c->noise))
        return FFP_PIXEL_DIM_STAGE;
    return difference_of(&v, c->noise) < ALIKE ? FFP_PIXEL_DIM_STAGE : FFP_PIXEL_UNKNOWN;
}

static void compare_pixels(FfpCompared *out, const Comparison *c, const FfpView *view) {
    const int width = c->view->width, height = c->view->height;
    int64_t alike = 0;
    out->kinds = ffp_alloc((size_t)width * (size_t)height, 1);
#pragma omp parallel for schedule(static) reduction(+ : alike)
    for (int y = 0; y < height; y++)
        for (int x = 0; x < width; x++) {
            const FfpPixelKind kind = kind_of(c, x, y);
            out->kinds[(ptrdiff_t)y * width + x] = (unsigned char)kind;
            alike += kind == FFP_PIXEL_STAGE || kind == FFP_PIXEL_DIM_STAGE;
        }
    out->stage = (double)alike / ((double)ffp_frame_width(view) * ffp_frame_height(view));
}

bool ffp_stage_compare(FfpCompared *compared, const FfpCapture *capture, int view, const FfpEmptyStage *stage,
                       const char *where, FfpError *err) {
    const FfpView *of = &capture->views[view];
    FfpLayers *mine = ffp_layers_new(capture, of->images, stage->images),
              *theirs = ffp_layers_new(capture, stage->images, of->images);
    Comparison c = {mine, theirs, &stage->known, ffp_layers_noise(mine, theirs), 1, bright_of(theirs)};
    c.gain = find_gain(&c);
    *compared = (FfpCompared){.noise = c.noise, .gain = c.gain};
    if (c.noise <= STAGE_NOISE_MOST) compare_pixels(compared, &c, of);
    ffp_layers_free(mine), ffp_layers_free(theirs);
    if (c.noise > STAGE_NOISE_MOST)
        return ffp_fail_by(FFP_RULE_STAGE_DIFFERS, &(FfpFacts){.figure = c.noise, .limit = STAGE_NOISE_MOST},
                           where, err);
    if (compared->stage >= STAGE_SEEN_LEAST) return true;
    ffp_free(compared->kinds);
    compared->kinds = NULL;
    return ffp_fail_by(FFP_RULE_STAGE_UNLIKE,
                       &(FfpFacts){.figure = compared->stage, .limit = STAGE_SEEN_LEAST}, where, err);
}
