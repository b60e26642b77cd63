#include "engine/align/photo_consistency.h"
#include <math.h>
#include <stdlib.h>
#include "core/base/arena.h"
#include "engine/match/match.h"
#include "engine/match/observe.h"
#include "engine/network/network.h"
#include "engine/render/pass.h"

#define SURFACE 0.5F // opacity from which there is a surface
#define HOLE 0.3     // difference that counts where there is none
// Splats are looked at wider than they are drawn. As they are drawn, surfaces that lie too deep agree best,
// because the rims of what other views saw stick out less; so wide, right poses do (the notebook,
// docs/lab/notebook/alignment.md).
#define WIDER 1.25F

struct FfpPhotoConsistency {
    const FfpCapture *capture;
    int active;
    FfpSummed light;
    FfpObservation *seen; // [views]; NULL until a match said that all pictures are there
    FfpViewPass *pass;
};

FfpPhotoConsistency *ffp_photo_consistency_new(const FfpCapture *capture, int active) {
    FfpRenderSettings render = ffp_render_defaults();
    render.samples = 1;     // whose places in the pattern are looked up, one a pixel
    render.shadows = false; // what was not lit has no weight
    FfpPhotoConsistency *l = ffp_alloc(1, sizeof *l);
    *l = (FfpPhotoConsistency){.capture = capture, .active = active, .pass = ffp_view_pass_new(&render)};
    l->light = ffp_summed_new(&capture->patterns[active].image);
    return l;
}

void ffp_photo_consistency_free(FfpPhotoConsistency *l) {
    if (!l) return;
    for (int v = 0; l->seen && v < l->capture->n_views; v++) ffp_observation_free(&l->seen[v]);
    ffp_free(l->seen);
    ffp_summed_free(&l->light);
    ffp_view_pass_free(l->pass);
    ffp_free(l);
}

static void observe_once(FfpPhotoConsistency *l) {
    if (l->seen) return;
    l->seen = ffp_alloc((size_t)l->capture->n_views, sizeof *l->seen);
    for (int v = 0; v < l->capture->n_views; v++) l->seen[v] = ffp_observe(l->capture, v, &l->active, 1);
}

// Sum over the channels of a pixel that the object fills.
static double pixel_difference(const FfpPhotoConsistency *l, const FfpObservation *seen, int pixel) {
    const FfpMapping *m = ffp_view_pass_mapping(l->pass);
    const bool surface = ffp_view_pass_gbuffer(l->pass)->opacity[pixel] > SURFACE;
    const real *weight = seen->weight + (ptrdiff_t)3 * pixel, *ratio = seen->ratio + (ptrdiff_t)3 * pixel;
    const real *uv = m->uv + (ptrdiff_t)2 * pixel, *extent = m->extent + (ptrdiff_t)2 * pixel;
    real colour[3] = {0};
    double sum = 0;
    if (m->visibility[pixel] > 0) ffp_lookup(&l->light, uv[0], uv[1], extent[0], extent[1], colour);
    for (int c = 0; c < 3; c++) {
        const double difference = surface ? fabs((double)(colour[c] - ratio[c])) : HOLE;
        sum += difference * (double)weight[c];
    }
    return sum;
}

bool ffp_photo_consistency(FfpPhotoConsistency *l, double *disagreement, FfpError *err) {
    const FfpMatchSettings matching = ffp_match_defaults();
    FfpInitialisation start;
    if (!ffp_initialisation_new(&start, l->capture, &l->active, 1, &matching, err)) return false;
    FfpGaussians splats = ffp_initialisation_gaussians(l->capture, &start);
    double sum = 0, count = 0;
    for (int64_t i = 0; i < 3 * splats.count; i++) splats.scale[i] *= WIDER;
    observe_once(l);
    for (int v = 0; v < start.views; v++) {
        const FfpView *view = &l->capture->views[v];
        const int pixels = start.width * start.height;
        ffp_view_pass_draw(l->pass, &splats, &view->camera, &view->projector);
        for (int p = 0; p < pixels; p++) {
            if (!(view->coverage.data[p] >= 1)) continue;
            sum += pixel_difference(l, &l->seen[v], p);
            count += 3;
        }
    }
    ffp_gaussians_free(&splats);
    ffp_initialisation_free(&start);
    *disagreement = sum / fmax(count, 1);
    return true;
}
