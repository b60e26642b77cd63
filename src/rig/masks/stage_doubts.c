// The empty stage beside the views: whether it was photographed from their place and in their light.
#include <tgmath.h>
#include "core/base/alloc.h"
#include "core/numerics/rank.h"
#include "rig/findings/tell.h"
#include "rig/masks/limits.h"
#include "rig/masks/steps.h"

// Names what was bumped or photographed from another place: most views, then it is the stage, or one of them.
static void warn_of_displacement(const FfpMasking *masking) {
    const FfpCapture *capture = masking->capture;
    const int black = masking->capture->black, white = masking->capture->white;
    int count = 0, odd = 0, most[2] = {0, 0};
    for (int v = 0; v < capture->n_views; v++) {
        const FfpImage *images = capture->views[v].images, *stage = masking->stages[v].images;
        int moved[2];
        if (!masking->made[v] || !stage[black].data || !stage[white].data) continue;
        ffp_stage_moved(moved, &images[black], &images[white], &stage[black], &stage[white]);
        if (moved[0] == 0 && moved[1] == 0) continue;
        count++;
        if (hypot(moved[0], moved[1]) > hypot(most[0], most[1]))
            most[0] = moved[0], most[1] = moved[1], odd = v;
    }
    if (count > 0)
        ffp_tell(2 * count > capture->n_views ? FFP_RULE_STAGE_ELSEWHERE : FFP_RULE_VIEW_ELSEWHERE,
                 &(FfpFacts){.view = capture->views[odd].id, .x = most[0], .y = most[1]});
}

static double median_of(const FfpImage *black) {
    const size_t pixels = (size_t)black->width * (size_t)black->height;
    double *levels = ffp_alloc(pixels + 1, sizeof *levels);
    for (size_t i = 0; i < pixels; i++)
        levels[i] = (double)(black->data[3 * i] + black->data[3 * i + 1] + black->data[3 * i + 2]) / 3;
    const double out = ffp_median(levels, pixels);
    ffp_free(levels);
    return out;
}

// Lamps that were switched, and daylight that changed, after the stage was photographed.
static void warn_of_other_room_light(const FfpMasking *masking) {
    const int black = masking->capture->black;
    int odd = -1;
    double here = 0, there = 0, most = 0;
    for (int v = 0; v < masking->capture->n_views; v++) {
        if (!masking->made[v] || !masking->stages[v].images[black].data) continue;
        const double view = median_of(&masking->capture->views[v].images[black]),
                     stage = median_of(&masking->stages[v].images[black]), off = fabs(view - stage);
        if (off > fmax(ROOM_LIGHT_LEAST, LIGHT_CHANGE * fmax(view, stage)) && off > most)
            odd = v, most = off, here = view, there = stage;
    }
    if (odd >= 0)
        ffp_tell(FFP_RULE_STAGE_LIGHT,
                 &(FfpFacts){.view = masking->capture->views[odd].id, .figure = here, .x = there});
}

static bool check_order(const FfpMasking *masking, FfpError *err) {
    for (int v = 0; v < masking->capture->n_views; v++) {
        const FfpImage *black = &masking->stages[v].images[masking->capture->black],
                       *white = &masking->stages[v].images[masking->capture->white];
        if (!black->data || !white->data || ffp_image_mean(black) <= ffp_image_mean(white) + ROOM_LIGHT_LEAST)
            continue;
        return ffp_fail_by(FFP_RULE_STAGE_EXCHANGED,
                           &(FfpFacts){.x = ffp_image_mean(black), .y = ffp_image_mean(white)}, "empty", err);
    }
    return true;
}

bool ffp_masks_check_stage(const FfpMasking *masking, FfpError *err) {
    if (!check_order(masking, err)) return false;
    warn_of_displacement(masking);
    warn_of_other_room_light(masking);
    return true;
}
