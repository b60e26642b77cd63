#include "match/refute.h"

#include <stdlib.h>
#include <tgmath.h>

#include "base/arena.h"
#include "match/beams.h"
#include "match/consistency.h"
#include "match/reduce.h"

#define SLACK 2.0F      // footprints, or cells of a projector's picture
#define FREE_TRUST 0.3F // trust, beyond that of views that agree, that it takes to call a point seen through

static bool off_silhouette(const FfpView *view, real u, real v) {
    if (!(u >= 0 && v >= 0 && u < (real)ffp_frame_width(view) && v < (real)ffp_frame_height(view)))
        return false;
    return view->coverage.data[(size_t)v * (size_t)view->coverage.width + (size_t)u] <= 0;
}

static bool refuted(const FfpWitnesses *witnesses, const FfpBeams *beams, const real point[3]) {
    const FfpDepths *depths = witnesses->depths;
    real past = 0, agree = 0;
    for (int v = 0; v < depths->capture->n_views; v++) {
        const FfpView *view = &depths->capture->views[v];
        real x, y, z = ffp_project(&view->camera, point, &x, &y);
        if (z > 0 && off_silhouette(view, x, y)) return true;
        if (z > 0) {
            const FfpHeard seen = ffp_heard_at(witnesses, v, x, y);
            ffp_hear(&past, &agree, &seen, z, SLACK * z / view->camera.fx);
        }
        z = ffp_project(&view->projector, point, &x, &y);
        if (!(z > 0)) continue;
        const FfpHeard lit = ffp_beams_at(&beams[v], x, y);
        if (z < lit.low - SLACK * z / (view->projector.fx * beams[v].scale)) past += lit.trust;
    }
    return past > FREE_TRUST + agree;
}

int64_t ffp_refute(real *opacity, const real *centre, int64_t count, const FfpCapture *capture,
                   const FfpStart *start) {
    if (start->reduced != NULL)
        return ffp_refute(opacity, centre, count, &start->reduced->capture, &start->reduced->start);
    const size_t area = (size_t)start->width * (size_t)start->height, views = (size_t)start->views;
    FfpDepths depths = {capture, start->width, start->height, ffp_alloc(views * area, sizeof(real)),
                        start->confidence};
    for (size_t i = 0; i < views * area; i++)
        depths.depth[i] = start->footprint[i] * capture->views[i / area].camera.fx;
    FfpWitnesses witnesses = ffp_witnesses_new(&depths);
    FfpBeams *beams = ffp_alloc(views, sizeof *beams);
    for (size_t v = 0; v < views; v++) beams[v] = ffp_beams_new(&depths, (int)v);
    int64_t count_refuted = 0;
#pragma omp parallel for schedule(static) reduction(+ : count_refuted)
    for (int64_t i = 0; i < count; i++) {
        if (opacity[i] > 0 && refuted(&witnesses, beams, centre + 3 * i)) opacity[i] = 0, count_refuted++;
    }
    for (size_t v = 0; v < views; v++) ffp_beams_free(&beams[v]);
    free(beams), free(depths.depth);
    ffp_witnesses_free(&witnesses);
    return count_refuted;
}
