#include <math.h>
#include <stdlib.h>
#include <string.h>
#include "core/base/alloc.h"
#include "core/base/call.h"
#include "core/numerics/rank.h"
#include "rig/checks/chord.h"
#include "rig/checks/measure.h"

#define LIT 0.02       // what white adds to a pixel that it lights, and a difference that counts;
#define LIT_SHARE 0.05 // in dark photographs less, as a share of what it makes of a view's bright pixels
#define LIT_IN_THE_MEAN 0.005F // likewise over the channels
#define CLIPPED (254.5 / 255)  // encoded
#define DARKER_SHARE 0.25      // of a view's object pixels
#define BRIGHTER_MOST 0.1      // of them, that are brighter all the same
#define CHORD_PARTS 24

static real brightest(const real rgb[3]) {
    return (real)fmax((double)rgb[0], fmax((double)rgb[1], (double)rgb[2]));
}

static real mean_of(const real rgb[3]) {
    return (rgb[0] + rgb[1] + rgb[2]) / 3;
}

bool ffp_rig_is_darker(const FfpView *view, int a, int b) {
    const ptrdiff_t pixels = (ptrdiff_t)view->camera.width * view->camera.height;
    const real *one = view->images[a].data, *other = view->images[b].data;
    double object = 0, darker = 0, brighter = 0;
    for (ptrdiff_t i = 0; i < pixels; i++) {
        if (view->coverage.data[i] < 0.5F) continue;
        const real difference = mean_of(other + 3 * i) - mean_of(one + 3 * i);
        object++;
        darker += difference > (real)LIT;
        brighter += difference < (real)-LIT;
    }
    return darker > DARKER_SHARE * object && brighter < BRIGHTER_MOST * object;
}

// True if any point of the pixel's ray within the object's sphere lies in the projector's frustum.
static bool can_be_lit(const FfpCapture *capture, const FfpView *view, size_t pixel) {
    FfpChord chord;
    const int parts = ffp_chord(capture, &view->camera, pixel, &chord) ? CHORD_PARTS : 0;
    for (int k = 0; k < parts; k++) {
        real point[3];
        ffp_chord_point(&chord, k, parts, point);
        if (ffp_rig_falls_into(&view->projector, point)) return true;
    }
    return false;
}

static double added_by_white(const FfpCapture *capture, const FfpView *view, size_t pixel) {
    return (double)brightest(view->images[capture->white].data + 3 * pixel) -
           (double)brightest(view->images[capture->black].data + 3 * pixel);
}

FfpTold ffp_rig_told(const FfpCapture *capture, const FfpView *view, size_t pixel, double least) {
    const real *codes = view->correspondence.data;
    if (codes && codes[3 * pixel + 2] > 0) return FFP_TOLD;
    if (added_by_white(capture, view, pixel) <= least) return FFP_TOLD_UNLIT;
    return codes ? FFP_TOLD_REFUSED : FFP_TOLD;
}

// Of lit pixels.
typedef struct Lit {
    float *white, *share; // brightest channel under white; of it under black
    size_t count;
} Lit;

typedef struct Looking {
    const FfpCapture *capture;
    bool reach;
    FfpObjectLight *views; // [n_views]
    Lit *lit;              // [n_views]
} Looking;

// 95 % of the object's pixels are darker under white.
static float bright_of(const FfpView *view, int white) {
    const size_t pixels = (size_t)view->camera.width * (size_t)view->camera.height;
    float *values = ffp_alloc(pixels, sizeof *values);
    size_t n = 0;
    for (size_t i = 0; i < pixels; i++)
        if (!(view->coverage.data[i] < 0.5F))
            values[n++] = (float)brightest(view->images[white].data + 3 * i);
    const float bright = ffp_quantile(values, n, 0.95);
    ffp_free(values);
    return bright;
}

static void look_at_view(void *argument, int64_t index) {
    const Looking *looking = argument;
    const FfpCapture *capture = looking->capture;
    const FfpView *view = &capture->views[index];
    const size_t pixels = (size_t)view->camera.width * (size_t)view->camera.height;
    FfpObjectLight out = {.bright = bright_of(view, capture->white)};
    Lit *lit = &looking->lit[index];
    out.least = fmin(LIT, LIT_SHARE * (double)out.bright);
    for (size_t i = 0; i < pixels; i++) {
        const real *black = view->images[capture->black].data + 3 * i,
                   *white = view->images[capture->white].data + 3 * i;
        if (view->coverage.data[i] < 0.5F) continue;
        const double w = (double)brightest(white), b = (double)brightest(black);
        const real added = mean_of(white) - mean_of(black);
        out.object++;
        out.black += (double)mean_of(black);
        out.added += (double)added;
        out.brightened += added > LIT_IN_THE_MEAN;
        out.clipped += (double)ffp_srgb_encode((real)w) >= CLIPPED;
        out.reversed += w < b - LIT;
        out.guessed += ffp_rig_told(capture, view, i, out.least) != FFP_TOLD;
        if (w - b <= out.least) continue;
        out.lit++;
        out.unreached += looking->reach && !can_be_lit(capture, view, i);
        if (w - b <= LIT) continue;
        lit->white[lit->count] = (float)w;
        lit->share[lit->count++] = (float)(b / w);
    }
    looking->views[index] = out;
    ffp_cancel_point();
}

// Each view's part of the arrays, one after the other; afterwards the first holds the lit pixels of all.
static Lit *lit_of_views(const FfpCapture *capture) {
    const size_t views = (size_t)capture->n_views;
    Lit *lit = ffp_alloc(views + 1, sizeof *lit);
    size_t pixels = 1, first = 0;
    for (size_t v = 0; v < views; v++)
        pixels += (size_t)capture->views[v].camera.width * (size_t)capture->views[v].camera.height;
    float *white = ffp_alloc(pixels, sizeof *white), *share = ffp_alloc(pixels, sizeof *share);
    for (size_t v = 0; v < views; v++) {
        lit[v] = (Lit){white + first, share + first, 0};
        first += (size_t)capture->views[v].camera.width * (size_t)capture->views[v].camera.height;
    }
    return lit;
}

static void put_together(Lit *lit, int views) {
    for (int v = 1; v < views; v++) {
        memmove(lit->white + lit->count, lit[v].white, lit[v].count * sizeof *lit->white);
        memmove(lit->share + lit->count, lit[v].share, lit[v].count * sizeof *lit->share);
        lit->count += lit[v].count;
    }
}

FfpLights ffp_rig_lights(const FfpCapture *capture, bool reach) {
    FfpLights out = {.views = ffp_alloc((size_t)capture->n_views, sizeof *out.views)};
    Lit *lit = lit_of_views(capture);
    ffp_parallel_for(capture->n_views, 0, look_at_view, &(Looking){capture, reach, out.views, lit});
    for (int v = 0; v < capture->n_views; v++) {
        const FfpObjectLight *own = &out.views[v];
        out.all.object += own->object, out.all.lit += own->lit, out.all.brightened += own->brightened;
        out.all.clipped += own->clipped, out.all.reversed += own->reversed;
        out.all.unreached += own->unreached, out.all.guessed += own->guessed;
        out.all.black += own->black, out.all.added += own->added;
        out.all.bright = fmaxf(out.all.bright, own->bright);
    }
    put_together(lit, capture->n_views);
    out.bright = ffp_quantile(lit->white, lit->count, 0.95);
    out.ambient = ffp_quantile(lit->share, lit->count, 0.5);
    ffp_free(lit->white);
    ffp_free(lit->share);
    ffp_free(lit);
    return out;
}

void ffp_rig_lights_free(FfpLights *lights) {
    ffp_free(lights->views);
    *lights = (FfpLights){0};
}

double ffp_rig_unreached(const FfpCapture *capture) {
    FfpLights lights = ffp_rig_lights(capture, true);
    const double share = lights.all.lit > 0 ? lights.all.unreached / lights.all.lit : 0;
    ffp_rig_lights_free(&lights);
    return share;
}
