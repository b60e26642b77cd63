#include "rig/import/shade.h"
#include <tgmath.h>
#include "core/base/alloc.h"
#include "core/numerics/rank.h"
#include "rig/import/local_mean.h"
#include "rig/import/mask.h"

#define SMOOTH 0.8        // pixels
#define COLOUR_SMOOTH 2.0 // under black, which is noisy
#define OBJECT_SMOOTH 6.0 // how far away the object's colour is looked for
#define DARK 0.25         // of the light that white adds to the stage: less is dark
#define LIT 10            // times the noise: the stage must have this much light to lose
#define UMBRA_MOST 0.15   // of white on the stage: shadows elsewhere count up to this
#define DARKNESS 1.6      // times the median of these
#define NO_COLOUR 1.2     // the same where black says nothing
#define COLOUR_OFF 0.02   // by which the stage's chromaticity must fit better than the object's
#define COLOUR_LEAST 1.5  // times the noise that black must have
#define UMBRA_LEAST 30    // pixels
#define PIECE_LEAST 12    // pixels of a shadow

typedef struct Shade {
    int width, height;
    unsigned char *dark;                       // [height*width]
    FfpImage black, stage_black, object_black; // local means, 4 channels
    FfpImage *white, *stage_white;             // of views[0], [1]
    double noise;
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
    return sum_of(s->white, pixel) / fmax(sum_of(s->stage_white, pixel), 1e-6);
}

// What white adds is far less than on the stage, and the pixel is neither stage nor object for sure.
static void mark_dark(Shade *s, const FfpView *view, const FfpEmptyStage *stage, const FfpCapture *capture,
                      const FfpCompared *compared) {
    FfpImage images[4] = {view->images[capture->white], view->images[capture->black],
                          stage->images[capture->white], stage->images[capture->black]};
    for (int k = 0; k < 4; k++) images[k] = ffp_local_mean(&images[k], SMOOTH);
    for (ptrdiff_t i = 0; i < (ptrdiff_t)s->width * s->height; i++) {
        const double here = sum_of(&images[0], i) - sum_of(&images[1], i),
                     there = sum_of(&images[2], i) - sum_of(&images[3], i);
        const bool sure = compared->kinds[i] == FFP_PIXEL_STAGE || compared->kinds[i] == FFP_PIXEL_DIM_STAGE;
        s->dark[i] = !sure && there > 3 * LIT * compared->noise && here < DARK * there;
    }
    for (int k = 0; k < 4; k++) ffp_image_free(&images[k]);
}

// Chromaticity under black: above 0 where the stage's fits better than the object's; 0 where black is too
// dark to say.
static double stage_colour(const Shade *s, ptrdiff_t pixel) {
    const double least = 3 * COLOUR_LEAST * s->noise;
    if (sum_of(&s->stage_black, pixel) < least || !(s->object_black.data[4 * pixel + 3] > 0)) return 0;
    return colour_off(&s->black, &s->object_black, pixel) - colour_off(&s->black, &s->stage_black, pixel);
}

static void drop_specks(const unsigned char *keep, unsigned char *marks, int width, int height) {
    FfpImage pieces = ffp_image_new(width, height, 1);
    const ptrdiff_t pixels = (ptrdiff_t)width * height;
    for (ptrdiff_t i = 0; i < pixels; i++) pieces.data[i] = keep[i] || marks[i];
    ffp_mask_drop_specks(&pieces, PIECE_LEAST);
    for (ptrdiff_t i = 0; i < pixels; i++) marks[i] = marks[i] && pieces.data[i] > 0;
    ffp_image_free(&pieces);
}

// The median darkness of the shadow where it surely is one; 0: there is too little of it.
static double umbra_of(const Shade *s, const unsigned char *around) {
    const ptrdiff_t pixels = (ptrdiff_t)s->width * s->height;
    double *levels = ffp_alloc((size_t)pixels + 1, sizeof *levels);
    size_t n = 0;
    for (ptrdiff_t i = 0; i < pixels; i++)
        if (around[i] && s->dark[i] && darkness(s, i) < UMBRA_MOST) levels[n++] = darkness(s, i);
    const double out = n >= UMBRA_LEAST ? ffp_median(levels, n) : 0;
    ffp_free(levels);
    return out;
}

static unsigned char *mark_shade(const Shade *s, const unsigned char *mask, const unsigned char *around) {
    const ptrdiff_t pixels = (ptrdiff_t)s->width * s->height;
    const double umbra = umbra_of(s, around);
    unsigned char *out = ffp_alloc((size_t)pixels, 1), *sure = ffp_alloc((size_t)pixels, 1);
    for (ptrdiff_t i = 0; i < pixels; i++) {
        sure[i] = around[i] && s->dark[i];
        if (!mask[i] || !s->dark[i]) continue;
        const double colour = stage_colour(s, i);
        out[i] = darkness(s, i) < (colour == 0 ? NO_COLOUR : DARKNESS) * umbra &&
                 (colour == 0 || colour > COLOUR_OFF);
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

unsigned char *ffp_shade_find(const FfpCapture *capture, int view, const FfpEmptyStage *stage,
                              const FfpCompared *compared, const unsigned char *mask,
                              const unsigned char *around) {
    const FfpView *of = &capture->views[view];
    const FfpImage *black = &of->images[capture->black], *stage_black = &stage->images[capture->black];
    Shade s = {.width = black->width, .height = black->height, .noise = compared->noise};
    s.dark = ffp_alloc((size_t)s.width * (size_t)s.height, 1);
    mark_dark(&s, of, stage, capture, compared);
    unsigned char *object = inside(compared, s.width, s.height);
    s.black = ffp_local_mean_where(black, s.dark, COLOUR_SMOOTH);
    s.stage_black = ffp_local_mean_where(stage_black, s.dark, COLOUR_SMOOTH);
    s.object_black = ffp_local_mean_where(black, object, OBJECT_SMOOTH);
    FfpImage white = ffp_local_mean_where(&of->images[capture->white], s.dark, SMOOTH),
             stage_white = ffp_local_mean_where(&stage->images[capture->white], s.dark, SMOOTH);
    s.white = &white, s.stage_white = &stage_white;
    unsigned char *out = mark_shade(&s, mask, around);
    ffp_image_free(&white), ffp_image_free(&stage_white);
    ffp_image_free(&s.black), ffp_image_free(&s.stage_black), ffp_image_free(&s.object_black);
    ffp_free(s.dark), ffp_free(object);
    return out;
}
