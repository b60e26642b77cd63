#include <math.h>
#include <string.h>
#include "core/base/alloc.h"
#include "core/base/call.h"
#include "core/base/log.h"
#include "core/numerics/rank.h"
#include "rig/checks/suspect_parts.h"

#define DARKER 0.02F         // linear: a photograph darker by this than one that it cannot be darker than
#define EXCHANGED_SHARE 0.25 // of a view's object pixels
#define BRIGHTER_MOST 0.1    // of them, that are brighter all the same
#define LIT_LEAST 0.02       // of a view's object pixels: fewer, and the projector was dark
#define BORDER_MOST 0.9      // of the frame's edge that a mask may call object
#define LAMP 3               // times the others' median: ambient light that another lamp made
#define CLIPPED 0.998F       // linear
#define CLIPPED_MOST 0.4     // of the object's pixels
#define DARK 0.02F           // linear: brightest channel under white, of the bright pixels
#define AMBIENT_MOST 0.9     // of the light under white, that remains under black

static real mean_of(const real rgb[3]) {
    return (rgb[0] + rgb[1] + rgb[2]) / 3;
}

// Whether a view is darker under pattern a than under b in many of the object's pixels, and brighter in
// hardly any.
static bool is_darker(const FfpView *view, int a, int b) {
    const ptrdiff_t pixels = (ptrdiff_t)view->camera.width * view->camera.height;
    const real *one = view->images[a].data, *other = view->images[b].data;
    double object = 0, darker = 0, brighter = 0;
    for (ptrdiff_t i = 0; i < pixels; i++) {
        if (view->coverage.data[i] < 0.5F) continue;
        const real difference = mean_of(other + 3 * i) - mean_of(one + 3 * i);
        object++;
        darker += difference > DARKER;
        brighter += difference < -DARKER;
    }
    return darker > EXCHANGED_SHARE * object && brighter < BRIGHTER_MOST * object;
}

// Fails if a is darker than b in some or all views, although it cannot be.
static bool check_order(const FfpCapture *capture, int a, int b, FfpError *err) {
    const char *brighter = capture->patterns[a].name, *darker = capture->patterns[b].name;
    int count = 0, first = 0;
    for (int v = 0; v < capture->n_views; v++) {
        if (!is_darker(&capture->views[v], a, b)) continue;
        if (count++ == 0) first = v;
    }
    if (count == 0) return true;
    const bool all = count == capture->n_views && count > 1;
    return ffp_fail(err, FFP_ERROR_FAULT, all ? capture->folder : capture->views[first].id,
                    "the photographs under %s and %s are exchanged: the object is darker under %s", darker,
                    brighter, brighter);
}

static bool same_picture(const FfpImage *a, const FfpImage *b) {
    return a->data && b->data && a->width == b->width && a->height == b->height &&
           memcmp(a->data, b->data, 3 * (size_t)a->width * (size_t)a->height * sizeof *a->data) == 0;
}

static double sum_of(const FfpImage *image) {
    const ptrdiff_t count = (ptrdiff_t)3 * image->width * image->height;
    double sum = 0;
    for (ptrdiff_t i = 0; i < count; i++) sum += (double)image->data[i];
    return sum;
}

// A view that has another's photograph; drawn objects may look the same from two sides. Pictures are compared
// where their sums are equal.
static void note_repeated_views(const FfpCapture *capture) {
    const int white = capture->white;
    double *sums = ffp_alloc((size_t)capture->n_views, sizeof *sums);
    for (int v = 0; v < capture->n_views; v++) {
        const FfpView *view = &capture->views[v];
        sums[v] = sum_of(&view->images[white]);
        for (int w = 0; w < v; w++)
            if (sums[v] == sums[w] && !ffp_same_device(&view->camera, &capture->views[w].camera) &&
                same_picture(&view->images[white], &capture->views[w].images[white]))
                ffp_note("view %s has the photograph under white of view %s: take it again", view->id,
                         capture->views[w].id);
        ffp_cancel_point();
    }
    ffp_free(sums);
}

// A file that was copied, or a photograph taken before the projector had changed.
static bool check_repeated(const FfpCapture *capture, int active, FfpError *err) {
    for (int v = 0; v < capture->n_views; v++) {
        const FfpView *view = &capture->views[v];
        const int shown[3] = {capture->black, capture->white, active};
        for (int k = 0; k < (active >= 0 ? 3 : 1); k++) { // the first two are black and white
            const int a = shown[k], b = shown[(k + 1) % 3];
            if (same_picture(&view->images[a], &view->images[b]))
                return ffp_fail(err, FFP_ERROR_FAULT, view->id,
                                "the photographs under %s and %s are one and the same: take it again",
                                capture->patterns[a].name, capture->patterns[b].name);
        }
    }
    note_repeated_views(capture);
    return true;
}

typedef struct Brightness {
    double object, lit, clipped; // pixels
    double black, light;         // sums over the object: under black, and what white adds
    float bright;                // under white, brightest channel: 95 % are darker
} Brightness;

static Brightness measure(const FfpCapture *capture, const FfpView *view) {
    const size_t pixels = (size_t)view->camera.width * (size_t)view->camera.height;
    const real *black = view->images[capture->black].data, *white = view->images[capture->white].data;
    float *values = ffp_alloc(pixels, sizeof *values);
    Brightness b = {0};
    size_t n = 0;
    for (size_t i = 0; i < pixels; i++) {
        if (view->coverage.data[i] < 0.5F) continue;
        const real *w = white + 3 * i;
        const real brightest = w[0] > w[1] ? (w[0] > w[2] ? w[0] : w[2]) : (w[1] > w[2] ? w[1] : w[2]);
        const real added = mean_of(w) - mean_of(black + 3 * i);
        values[n++] = (float)brightest;
        b.lit += added > DARKER / 4;
        b.clipped += brightest >= CLIPPED;
        b.black += (double)mean_of(black + 3 * i);
        b.light += (double)added;
    }
    b.object = (double)n;
    b.bright = ffp_quantile(values, n, 0.95);
    ffp_free(values);
    ffp_cancel_point();
    return b;
}

static bool check_lit(const FfpCapture *capture, const Brightness *b, FfpError *err) {
    for (int v = 0; v < capture->n_views; v++) {
        if (b[v].object == 0)
            return ffp_fail(err, FFP_ERROR_FAULT, capture->views[v].id,
                            "its mask is empty: no pixel belongs to the object");
        if (!capture->scene && b[v].lit < LIT_LEAST * b[v].object)
            return ffp_fail(err, FFP_ERROR_FAULT, capture->views[v].id,
                            "white adds no light to black: the projector was dark, or its light does not "
                            "reach the object");
    }
    return true;
}

// Share of the frame's edge that the mask calls object.
static double border_share(const FfpView *view) {
    const int w = view->frame_width ? view->frame_width : view->camera.width,
              h = view->frame_height ? view->frame_height : view->camera.height;
    const ptrdiff_t row = view->camera.width;
    double covered = 0;
    for (int x = 0; x < w; x++)
        covered += (view->coverage.data[x] >= 0.5F) + (view->coverage.data[(h - 1) * row + x] >= 0.5F);
    for (int y = 0; y < h; y++)
        covered += (view->coverage.data[y * row] >= 0.5F) + (view->coverage.data[y * row + w - 1] >= 0.5F);
    return covered / (2.0 * (w + h));
}

static bool check_masks(const FfpCapture *capture, FfpError *err) {
    for (int v = 0; v < capture->n_views && !capture->scene; v++)
        if (border_share(&capture->views[v]) > BORDER_MOST)
            return ffp_fail(err, FFP_ERROR_FAULT, capture->views[v].id,
                            "its mask reaches the edge of the picture on all sides: it is inverted, or "
                            "missing");
    return true;
}

// What only makes the result worse.
static void note_light(const FfpCapture *capture, const Brightness *b) {
    const int n = capture->n_views;
    double *ratios = ffp_alloc((size_t)n, sizeof *ratios), clipped = 0, object = 0, black = 0, light = 0;
    float bright = 0;
    for (int v = 0; v < n; v++) {
        ratios[v] = b[v].black / fmax(b[v].light, 1e-9);
        clipped += b[v].clipped;
        object += b[v].object;
        black += b[v].black;
        light += b[v].light;
        bright = fmaxf(bright, b[v].bright);
    }
    const double usual = ffp_median(ratios, (size_t)n);
    for (int v = 0; v < n && n > 2 && !capture->scene; v++)
        if (b[v].black / fmax(b[v].light, 1e-9) > LAMP * usual && b[v].black > 0.05 * b[v].object)
            ffp_note("view %s has much more light under black than the others: was a lamp on?",
                     capture->views[v].id);
    if (clipped > CLIPPED_MOST * object)
        ffp_note("%.0f %% of the object's pixels are at the limit under white: shorten the exposure",
                 100 * clipped / object);
    if (bright < DARK) ffp_note("the photographs under white are very dark: expose longer");
    if (black > AMBIENT_MOST * (black + light))
        ffp_note("%.0f %% of the light under white remains under black: darken the room",
                 100 * black / (black + light));
    ffp_free(ratios);
}

bool ffp_rig_suspect_light(const FfpCapture *capture, int active, FfpError *err) {
    if (!check_masks(capture, err) || !check_order(capture, capture->white, capture->black, err) ||
        !check_repeated(capture, active, err))
        return false;
    Brightness *b = ffp_alloc((size_t)capture->n_views, sizeof *b);
    for (int v = 0; v < capture->n_views; v++) b[v] = measure(capture, &capture->views[v]);
    bool ok = check_lit(capture, b, err);
    if (ok && active >= 0)
        ok = check_order(capture, capture->white, active, err) &&
             check_order(capture, active, capture->black, err);
    if (ok) note_light(capture, b);
    ffp_free(b);
    return ok;
}
