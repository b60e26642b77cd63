#include <tgmath.h>
#include "core/base/alloc.h"
#include "rig/masks/limits.h"
#include "rig/masks/local_mean.h"
#include "rig/masks/steps.h"

typedef struct Sample {          // of one picture at a pixel
    bool known;                  // there is object as well as background nearby
    double object[3], behind[3]; // the object's light; the stage's, as bright as it is around
} Sample;

typedef struct Edge {
    int n;
    size_t count;      // pixels within EDGE_BAND of an outline, where the stage is known
    ptrdiff_t *pixels; // [count]
    bool *deep;        // [count] object, but not at the outline itself
    Sample **samples;  // [n][count] of each pattern; NULL where view or stage lack its picture
} Edge;

static unsigned char *marks_of(const FfpImage *mask, bool of_object, int shrink) {
    const ptrdiff_t pixels = (ptrdiff_t)mask->width * mask->height;
    unsigned char *out = ffp_alloc((size_t)pixels, 1);
    for (ptrdiff_t i = 0; i < pixels; i++) out[i] = (mask->data[i] >= 0.5F) == of_object;
    ffp_marks_shrink(out, mask->width, mask->height, shrink);
    return out;
}

// A picture at the pixels of an edge. Local means of whole pictures are large: only one pattern's exist at a
// time.
static Sample *sample(const Edge *e, const FfpImage *picture, const FfpImage *stage,
                      const unsigned char *inner, const unsigned char *outer) {
    Sample *out = ffp_alloc(e->count + 1, sizeof *out);
    FfpImage object = ffp_local_mean_where(picture, inner, EDGE_SIGMA),
             around = ffp_local_mean_where(picture, outer, EDGE_SIGMA),
             then = ffp_local_mean_where(stage, outer, EDGE_SIGMA);
    for (size_t k = 0; k < e->count; k++) {
        const ptrdiff_t i = e->pixels[k];
        out[k].known = object.data[4 * i + 3] > 1e-4F && around.data[4 * i + 3] > 1e-4F;
        for (int c = 0; c < 3; c++) {
            const double before = (double)then.data[4 * i + c], now = (double)around.data[4 * i + c];
            out[k].object[c] = (double)object.data[4 * i + c];
            out[k].behind[c] =
                (double)stage->data[3 * i + c] * fmin(fmax(now / fmax(before, 1e-4), 0), EDGE_BRIGHTEST);
        }
    }
    ffp_image_free(&object), ffp_image_free(&around), ffp_image_free(&then);
    return out;
}

static void find_pixels(Edge *e, const FfpImage *mask, const FfpEmptyStage *stage, const unsigned char *inner,
                        const unsigned char *outer) {
    const ptrdiff_t pixels = (ptrdiff_t)mask->width * mask->height;
    unsigned char *deep = marks_of(mask, true, 1);
    for (int round = 0; round < 2; round++) { // counts, then lists
        e->count = 0;
        for (ptrdiff_t i = 0; i < pixels; i++) {
            if (inner[i] || outer[i] || (stage->known.data && !(stage->known.data[i] > 0))) continue;
            if (e->pixels) e->pixels[e->count] = i, e->deep[e->count] = deep[i];
            e->count++;
        }
        if (e->pixels) break;
        e->pixels = ffp_alloc(e->count + 1, sizeof *e->pixels);
        e->deep = ffp_alloc(e->count + 1, sizeof *e->deep);
    }
    ffp_free(deep);
}

static Edge edge_of(const FfpCapture *capture, const FfpView *view, const FfpEmptyStage *stage) {
    const FfpImage *mask = &view->coverage;
    unsigned char *inner = marks_of(mask, true, EDGE_BAND), *outer = marks_of(mask, false, EDGE_BAND);
    Edge e = {.n = capture->n_patterns};
    find_pixels(&e, mask, stage, inner, outer);
    e.samples = ffp_alloc((size_t)e.n, sizeof *e.samples);
    for (int p = 0; p < e.n; p++)
        if (view->images[p].data && stage->images[p].data)
            e.samples[p] = sample(&e, &view->images[p], &stage->images[p], inner, outer);
    ffp_free(inner), ffp_free(outer);
    return e;
}

static void free_edge(Edge *e) {
    for (int p = 0; p < e->n; p++) ffp_free(e->samples[p]);
    ffp_free(e->samples), ffp_free(e->pixels), ffp_free(e->deep);
}

// The share of the k-th pixel, and how sure it is, from 0 to 1.
static double share_of(const Edge *e, const FfpView *view, double noise, size_t k, double *sure) {
    double across = 0, square = 0, contrast = 0;
    *sure = 0;
    for (int i = 0; i < 3 * e->n; i++) {
        if (!e->samples[i / 3]) continue;
        const Sample *at = &e->samples[i / 3][k];
        if (!at->known) return 0;
        const double object = at->object[i % 3], back = at->behind[i % 3];
        const double here = (double)view->images[i / 3].data[3 * e->pixels[k] + i % 3],
                     most = fmax(object, back);
        const double s = noise * noise + pow(EDGE_UNEVEN * most, 2);
        across += (here - back) * (object - back) / s, square += pow(object - back, 2) / s;
        contrast += pow(object - back, 2) / (noise * noise + pow(EDGE_RELATIVE * most, 2));
    }
    *sure = fmin(fmax(sqrt(contrast) / EDGE_CONTRAST - 0.5, 0), 1);
    const double share = square > 0 ? fmin(fmax(across / square, 0), 1) : 0;
    return e->deep[k] ? fmax(share, EDGE_INSIDE) : share;
}

// Takes the stage's share out of a picture: what is left is the object's own light, within what it has
// nearby.
static void take_out(const Edge *e, const Sample *samples, const FfpImage *mask, FfpImage *picture) {
    for (size_t k = 0; k < e->count; k++) {
        const ptrdiff_t i = e->pixels[k];
        const double share = (double)mask->data[i];
        if (!(share > 0) || share >= 1) continue;
        for (int c = 0; c < 3; c++) {
            const double here = (double)picture->data[3 * i + c],
                         own = (here - (1 - share) * samples[k].behind[c]) / share;
            picture->data[3 * i + c] = (real)fmin(fmax(own, 0), fmax(2 * samples[k].object[c], here));
        }
    }
}

static void set_shares(const Edge *e, FfpView *view, double noise) {
    for (size_t k = 0; k < e->count; k++) {
        real *at = &view->coverage.data[e->pixels[k]];
        double sure;
        const double share = share_of(e, view, noise, k, &sure),
                     mixed = sure * share + (1 - sure) * (double)*at;
        *at = (real)(mixed < EDGE_SHARE_LEAST ? 0 : mixed > 1 - EDGE_SHARE_LEAST ? 1 : mixed);
    }
}

void ffp_soften_mask(const FfpCapture *capture, FfpView *view, const FfpEmptyStage *stage, double noise) {
    Edge e = edge_of(capture, view, stage);
    set_shares(&e, view, noise);
    free_edge(&e);
}

void ffp_soften_edges(const FfpCapture *capture, FfpView *view, const FfpEmptyStage *stage, double noise) {
    Edge e = edge_of(capture, view, stage);
    set_shares(&e, view, noise);
    for (int p = 0; p < e.n; p++)
        if (e.samples[p]) take_out(&e, e.samples[p], &view->coverage, &view->images[p]);
    free_edge(&e);
}
