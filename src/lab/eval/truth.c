// The Gaussians compared with the capture's ground truth: depth and albedo of the input views.
#include <tgmath.h>
#include "core/base/arena.h"
#include "core/numerics/rank.h"
#include "lab/eval/subject.h"

#define FILLED 0.999F // coverage of a pixel that counts
#define LIT 0.01F     // mean over channels of white - black, linear, from which a pixel counts as lit
#define SURFACE 0.5F  // opacity from which there is a surface

// Of the pixels that the projector lights, or of the others.
typedef struct Errors {
    double *depth; // [count] % of the radius
    int64_t count;
    double albedo; // sum of squares
    int64_t albedo_count;
} Errors;

typedef struct Tally {
    Errors lit, unlit;
} Tally;

static bool is_lit(const FfpCapture *capture, const FfpView *view, int p) {
    const real *white = view->images[capture->white].data, *black = view->images[capture->black].data;
    real sum = 0;
    for (int k = 0; k < 3; k++) sum += white[3 * p + k] - black[3 * p + k];
    return sum / 3 > LIT;
}

static void measure_view(Tally *tally, const FfpCapture *capture, const FfpView *view, const FfpGbuffer *g) {
    for (int p = 0; p < g->width * g->height; p++) {
        if (view->coverage.data[p] < FILLED) continue;
        const bool shown = g->opacity[p] >= SURFACE;
        Errors *errors = is_lit(capture, view, p) ? &tally->lit : &tally->unlit;
        if (view->depth.data && view->depth.data[p] > 0) {
            const real off =
                shown ? fabs(g->depth[p] / g->opacity[p] - view->depth.data[p]) : capture->radius;
            errors->depth[errors->count++] = 100 * (double)(off / capture->radius);
        }
        for (int k = 0; view->albedo.data && shown && k < 3; k++) {
            const double off = (double)(g->albedo[3 * p + k] / g->opacity[p] - view->albedo.data[3 * p + k]);
            errors->albedo += off * off;
            errors->albedo_count++;
        }
    }
}

static double quantile(const Errors *errors, double share) {
    return errors->count ? ffp_quantile(errors->depth, (size_t)errors->count, share) : NAN;
}

static double mean_albedo(double sum, int64_t count) {
    return count ? sum / (double)count : NAN;
}

void ffp_measure_truth(FfpSubject *subject, FfpScore *score) {
    const FfpCapture *capture = subject->capture;
    Tally tally = {0};
    size_t most = 0;
    for (int v = 0; v < capture->n_views; v++)
        most += (size_t)capture->views[v].camera.width * (size_t)capture->views[v].camera.height;
    tally.lit.depth = ffp_alloc(most, sizeof(double));
    tally.unlit.depth = ffp_alloc(most, sizeof(double));
    for (int v = 0; v < capture->n_views; v++) {
        const FfpView *view = &capture->views[v];
        if (!view->images[capture->white].data || !view->images[capture->black].data) continue;
        ffp_subject_draw(subject, &view->camera, &view->projector);
        measure_view(&tally, capture, view, ffp_subject_gbuffer(subject));
    }
    score->depth_lit_median = quantile(&tally.lit, 0.5);
    score->depth_lit_p90 = quantile(&tally.lit, 0.9);
    score->depth_unlit_median = quantile(&tally.unlit, 0.5);
    score->depth_unlit_p90 = quantile(&tally.unlit, 0.9);
    const Errors *lit = &tally.lit, *unlit = &tally.unlit;
    score->albedo_mse = mean_albedo(lit->albedo + unlit->albedo, lit->albedo_count + unlit->albedo_count);
    score->albedo_lit_mse = mean_albedo(lit->albedo, lit->albedo_count);
    score->albedo_unlit_mse = mean_albedo(unlit->albedo, unlit->albedo_count);
    ffp_free(tally.lit.depth);
    ffp_free(tally.unlit.depth);
}
