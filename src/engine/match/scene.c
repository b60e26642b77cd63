// Matching of a whole scene's view: by the patterns where they reach, by the other views' photographs
// everywhere.
#include <string.h>
#include <tgmath.h>
#include "core/base/arena.h"
#include "core/base/call.h"
#include "engine/match/coded.h"
#include "engine/match/matching.h"
#include "engine/match/refine.h"
#include "engine/match/thresholds.h"

#define STEREO_SHARE 1.0F // cost of a photograph that is quite unlike; of a pattern's channel it is 1 too
#define SMALL_STEP 0.03F  // smoothness: cost of a step of one plane between neighbours
#define LARGE_STEP 0.3F   // and of any longer one
#define STEREO_TRUST 0.5F // of a depth that only the photographs tell
#define ROUNDS 2          // of the fine search
#define WINDOW 9          // pixels that costs are summed over
// A depth is clear by how much less it costs than its rival, as a share of the rival's cost; costs a pixel
// that count as nothing, since noise is as large, and shares from which on a depth is believed.
#define VAGUE_LIT 0.05F
#define VAGUE 0.3F
#define CLEAR_LIT 0.2F
#define CLEAR 0.15F
#define ALIKE 0.3F // cost a pixel of photographs that show the same, at most

// The plane of least total with its fraction, by the parabola through it and its neighbours.
static real parabola_at(const real *total, int best, int count) {
    if (best == 0 || best == count - 1) return (real)best;
    const real a = total[best - 1], b = total[best + 1], bend = a - 2 * total[best] + b;
    return (real)best + (bend > 0 ? 0.5F * (a - b) / bend : 0);
}

// lit_trust [h,w]: the confidence of those pixels that the pattern tells, 0 elsewhere.
static void choose(real *depth, real *confidence, real *lit_trust, const real *total, const real *cost,
                   const FfpForeground *foreground, const FfpObservation *observed, const FfpPlanes *planes) {
    const int count = planes->count;
    real *row = ffp_alloc((size_t)count + 2, sizeof(real)), *sum = row + 1;
    row[0] = row[count + 1] = FFP_FAR_COST;
    for (size_t slot = 0; slot < foreground->count; slot++) {
        const size_t i = foreground->pixel[slot];
        const int x = (int)(i % (size_t)observed->width), y = (int)(i / (size_t)observed->width);
        const real *here = total + slot * (size_t)count;
        const int best = ffp_least_cost(here, count);
        depth[i] = ffp_plane_depth(planes, parabola_at(here, best, count));
        ffp_window_costs(sum, cost, foreground, observed, x, y, count);
        const real second = ffp_rival_cost(sum, count, best), lead = fmax(second - sum[best], 0);
        const real lit = observed->lit[i] >= FFP_LIT_MIN ? observed->lit[i] : 0;
        const real by_pattern = lit > 0 ? lead / (second + VAGUE_LIT * WINDOW * lit) : 0,
                   by_photographs = lead / (second + VAGUE * WINDOW);
        const bool alike = sum[best] <= ALIKE * WINDOW && by_photographs >= CLEAR;
        lit_trust[i] = by_pattern >= CLEAR_LIT ? by_pattern * lit : 0;
        confidence[i] = fmax(lit_trust[i], alike ? STEREO_TRUST * by_photographs : 0);
    }
    ffp_free(row);
}

void ffp_match_scene_view(real *depth, real *confidence, const FfpStereo *stereo, int view,
                          const FfpObservation *observed, const FfpBlurred *patterns,
                          const FfpMatchSettings *settings) {
    const FfpCapture *capture = stereo->capture;
    const FfpPlanes planes = ffp_planes(capture, view, settings);
    const size_t pixels = (size_t)observed->width * (size_t)observed->height;
    FfpForeground foreground = ffp_foreground_new(&capture->views[view].coverage);
    const size_t cells = foreground.count * (size_t)planes.count;
    real *cost = ffp_alloc(cells, sizeof(real)), *total = ffp_alloc(cells, sizeof(real));
    unsigned char *inside = ffp_alloc(cells, 1);
    memset(inside, 1, cells);
    ffp_sweep(cost, &capture->views[view], &foreground, observed, patterns, &planes, inside);
    ffp_free(inside);
    ffp_stereo_costs(cost, stereo, view, &foreground, &planes, STEREO_SHARE);
    ffp_coded_costs(cost, capture, view, &foreground, &planes);
    ffp_cancel_point();
    ffp_semi_global(total, cost, &foreground, planes.count,
                    &(FfpSteps){.small = SMALL_STEP, .large = LARGE_STEP});
    real *finer = ffp_alloc(pixels, sizeof(real)), *lit_trust = ffp_alloc(pixels, sizeof(real));
    memset(depth, 0, pixels * sizeof(real));
    memset(confidence, 0, pixels * sizeof(real));
    choose(depth, confidence, lit_trust, total, cost, &foreground, observed, &planes);
    ffp_free(total);
    ffp_free(cost);
    ffp_foreground_free(&foreground);
    const int steps =
        settings->fine_steps < FFP_REFINE_STEPS_MAX ? settings->fine_steps : FFP_REFINE_STEPS_MAX;
    const FfpFineSearch fine = {
        &capture->views[view].camera, &capture->views[view].projector, observed, patterns, steps, true};
    real span = 2 * planes.step;
    for (int round = 0; round < ROUNDS; round++) {
        ffp_cancel_point();
        ffp_refine_depth(finer, depth, lit_trust, &fine, span);
        memcpy(depth, finer, pixels * sizeof(real));
        span /= 2;
    }
    ffp_coded_depths(depth, confidence, capture, view, settings->bounds);
    ffp_free(finer);
    ffp_free(lit_trust);
}
