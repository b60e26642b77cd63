#include "rig/masks/shade.h"
#include <tgmath.h>
#include "core/base/alloc.h"
#include "core/numerics/rank.h"
#include "rig/masks/limits.h"
#include "rig/masks/local_mean.h"
#include "rig/masks/steps.h"

typedef struct Shade {
    int width, height;
    unsigned char *dark;                       // [height*width]
    FfpImage black, stage_black, object_black; // local means, 4 channels
    FfpImage white, stage_white;               // local means
    FfpImage white_added, pattern_added;       // what these add to black; pattern_added.data NULL: no pattern
    double noise;
    double bounced[3]; // of white's light in the umbra, the pattern's
} Shade;

static double sum_of(const FfpImage *image, ptrdiff_t pixel) {
    const real *p = image->data + pixel * image->channels;
    return (double)p[0] + (double)p[1] + (double)p[2];
}

// How far two chromaticities are apart.
static double colour_off(const FfpImage *a, const FfpImage *b, ptrdiff_t pixel) {
    const double sums[2] = {fmax(sum_of(a, pixel), 1e-5), fmax(sum_of(b, pixel), 1e-5)};
    double off = 0;
    for (int c = 0; c < 3; c++)
        off += fabs((double)a->data[pixel * a->channels + c] / sums[0] -
                    (double)b->data[pixel * b->channels + c] / sums[1]);
    return off;
}

// White as a share of white on the stage.
static double darkness(const Shade *s, ptrdiff_t pixel) {
    return sum_of(&s->white, pixel) / fmax(sum_of(&s->stage_white, pixel), 1e-6);
}

// Marks pixels to which white adds far less than to the stage, and which are neither stage nor object for
// sure.
static void mark_dark(Shade *s, const FfpView *view, const FfpEmptyStage *stage, const FfpCapture *capture,
                      const FfpCompared *compared) {
    FfpImage images[4] = {view->images[capture->white], view->images[capture->black],
                          stage->images[capture->white], stage->images[capture->black]};
    for (int k = 0; k < 4; k++) images[k] = ffp_local_mean(&images[k], SHADE_SMOOTH);
    for (ptrdiff_t i = 0; i < (ptrdiff_t)s->width * s->height; i++) {
        const double here = sum_of(&images[0], i) - sum_of(&images[1], i),
                     there = sum_of(&images[2], i) - sum_of(&images[3], i);
        const bool sure = compared->kinds[i] == FFP_PIXEL_STAGE || compared->kinds[i] == FFP_PIXEL_DIM_STAGE;
        s->dark[i] = !sure && there > 3 * LIT_NOISE * compared->noise && here < SHADE_DARK * there;
    }
    for (int k = 0; k < 4; k++) ffp_image_free(&images[k]);
}

// Chromaticity under black: above 0 where the stage's fits better than the object's; 0 where black is too
// dark to say.
static double stage_colour(const Shade *s, ptrdiff_t pixel) {
    const double least = 3 * SHADE_COLOUR_LEAST * s->noise;
    if (sum_of(&s->stage_black, pixel) < least || !(s->object_black.data[4 * pixel + 3] > 0)) return 0;
    return colour_off(&s->black, &s->object_black, pixel) - colour_off(&s->black, &s->stage_black, pixel);
}

static void drop_specks(const unsigned char *keep, unsigned char *marks, int width, int height) {
    FfpImage pieces = ffp_image_new(width, height, 1);
    const ptrdiff_t pixels = (ptrdiff_t)width * height;
    for (ptrdiff_t i = 0; i < pixels; i++) pieces.data[i] = keep[i] || marks[i];
    ffp_mask_drop_specks(&pieces, SHADE_PIECE_LEAST);
    for (ptrdiff_t i = 0; i < pixels; i++) marks[i] = marks[i] && pieces.data[i] > 0;
    ffp_image_free(&pieces);
}

// The median darkness of the shadow where it surely is one; 0: there is too little of it.
static double umbra_of(const Shade *s, const unsigned char *around) {
    const ptrdiff_t pixels = (ptrdiff_t)s->width * s->height;
    double *levels = ffp_alloc((size_t)pixels + 1, sizeof *levels);
    size_t n = 0;
    for (ptrdiff_t i = 0; i < pixels; i++)
        if (around[i] && s->dark[i] && darkness(s, i) < SHADE_UMBRA_MOST) levels[n++] = darkness(s, i);
    const double out = n >= SHADE_UMBRA_LEAST ? ffp_median(levels, n) : 0;
    ffp_free(levels);
    return out;
}

// The share of white's bounced light under the pattern, from where the shadow surely is one.
static void find_bounced(Shade *s, const unsigned char *around) {
    double pattern[3] = {0}, white[3] = {0};
    for (ptrdiff_t i = 0; i < (ptrdiff_t)s->width * s->height; i++) {
        if (!around[i] || !s->dark[i] || darkness(s, i) >= SHADE_UMBRA_MOST) continue;
        for (int c = 0; c < 3 && s->pattern_added.data; c++) {
            pattern[c] += (double)s->pattern_added.data[4 * i + c];
            white[c] += (double)s->white_added.data[4 * i + c];
        }
    }
    for (int c = 0; c < 3; c++) s->bounced[c] = white[c] > 0 ? pattern[c] / white[c] : 0;
}

// True if the pattern itself is seen: in shadows all patterns look the same but for their means (Nayar et al.
// 2006, "Fast separation of direct and global components").
static bool is_direct(const Shade *s, ptrdiff_t pixel) {
    double sum = 0;
    if (!s->pattern_added.data) return false;
    for (int c = 0; c < 3; c++) {
        const double white = (double)s->white_added.data[4 * pixel + c], share = s->bounced[c],
                     off = (double)s->pattern_added.data[4 * pixel + c] - share * white;
        const double noise = SHADE_DIRECT_NOISE * s->noise, light = SHADE_DIRECT_OFF * white;
        sum += off * off / (noise * noise * (1 + share * share) + light * light);
    }
    return sum > 3 * SHADE_DIRECT;
}

// True if a pixel has the stage's light under black, which shadows of the projector keep. Less than most of
// it needs a surer colour.
static bool keeps_black(const Shade *s, ptrdiff_t pixel, double colour) {
    const double here = sum_of(&s->black, pixel), there = sum_of(&s->stage_black, pixel);
    if (there <= 3 * s->noise) return true;
    if (here > SHADE_KEPT_MOST * there) return false;
    if (here < SHADE_KEPT_EVER * there) return false;
    return here >= SHADE_KEPT_LEAST * there ||
           (here > SHADE_BLACK_SURE * s->noise && colour > SHADE_COLOUR_SURE);
}

static bool is_shade(const Shade *s, ptrdiff_t pixel, double umbra) {
    const double colour = stage_colour(s, pixel);
    return darkness(s, pixel) < (colour == 0 ? SHADE_NO_COLOUR : SHADE_DARKNESS) * umbra &&
           (colour == 0 || colour > SHADE_COLOUR_OFF) && keeps_black(s, pixel, colour) &&
           !is_direct(s, pixel);
}

static unsigned char *mark_shade(Shade *s, const unsigned char *mask, const unsigned char *around) {
    const ptrdiff_t pixels = (ptrdiff_t)s->width * s->height;
    const double umbra = umbra_of(s, around);
    unsigned char *out = ffp_alloc((size_t)pixels, 1), *sure = ffp_alloc((size_t)pixels, 1);
    find_bounced(s, around);
    for (ptrdiff_t i = 0; i < pixels; i++) {
        sure[i] = around[i] && s->dark[i];
        out[i] = mask[i] && s->dark[i] && is_shade(s, i, umbra);
    }
    drop_specks(sure, out, s->width, s->height);
    ffp_free(sure);
    return out;
}

// The object, without its outline.
static unsigned char *inside(const FfpCompared *compared, int width, int height) {
    unsigned char *out = ffp_alloc((size_t)width * (size_t)height, 1);
    for (ptrdiff_t i = 0; i < (ptrdiff_t)width * height; i++) out[i] = compared->kinds[i] == FFP_PIXEL_OBJECT;
    ffp_marks_shrink(out, width, height, 2);
    return out;
}

// The local mean of what a picture adds to black where it is dark.
static FfpImage mean_added(const FfpImage *picture, const FfpImage *black, const unsigned char *dark) {
    FfpImage added = ffp_image_copy(picture);
    for (ptrdiff_t i = 0; i < (ptrdiff_t)3 * added.width * added.height; i++) added.data[i] -= black->data[i];
    FfpImage out = ffp_local_mean_where(&added, dark, SHADE_DIRECT_SMOOTH);
    ffp_image_free(&added);
    return out;
}

static void take_means(Shade *s, const FfpCapture *capture, const FfpView *view, const FfpEmptyStage *stage,
                       const FfpCompared *compared) {
    const FfpImage *black = &view->images[capture->black], *white = &view->images[capture->white];
    const int active = ffp_capture_active_pattern(capture, NULL, NULL);
    unsigned char *object = inside(compared, s->width, s->height);
    s->black = ffp_local_mean_where(black, s->dark, SHADE_COLOUR_SMOOTH);
    s->stage_black = ffp_local_mean_where(&stage->images[capture->black], s->dark, SHADE_COLOUR_SMOOTH);
    s->object_black = ffp_local_mean_where(black, object, SHADE_OBJECT_SMOOTH);
    s->white = ffp_local_mean_where(white, s->dark, SHADE_SMOOTH);
    s->stage_white = ffp_local_mean_where(&stage->images[capture->white], s->dark, SHADE_SMOOTH);
    s->white_added = mean_added(white, black, s->dark);
    if (active >= 0) s->pattern_added = mean_added(&view->images[active], black, s->dark);
    ffp_free(object);
}

unsigned char *ffp_shade_find(const FfpCapture *capture, int view, const FfpEmptyStage *stage,
                              const FfpCompared *compared, const unsigned char *mask,
                              const unsigned char *around) {
    const FfpView *of = &capture->views[view];
    Shade s = {.width = of->camera.width, .height = of->camera.height, .noise = compared->noise};
    s.dark = ffp_alloc((size_t)s.width * (size_t)s.height, 1);
    mark_dark(&s, of, stage, capture, compared);
    take_means(&s, capture, of, stage, compared);
    unsigned char *out = mark_shade(&s, mask, around);
    FfpImage *means[] = {&s.black,       &s.stage_black, &s.object_black, &s.white,
                         &s.stage_white, &s.white_added, &s.pattern_added};
    for (size_t k = 0; k < sizeof means / sizeof *means; k++) ffp_image_free(means[k]);
    ffp_free(s.dark);
    return out;
}
