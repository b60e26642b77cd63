// The stage behind an object that turns, from the views themselves: what stays the same is background.
#ifndef FFP_RIG_COMMON_STAGE_H
#define FFP_RIG_COMMON_STAGE_H

#include "rig/masks/stage.h"

typedef struct FfpCommon {
    double known; // share of the pixels whose stage was found
    double lit;   // and share of these pixels that white lights
} FfpCommon;

// For views of one camera that stood still, whose pictures are not masked: per pixel the look that most views
// share under all patterns, three and a third of them at least, as the mean over these. A look that is as
// common, or nearly, and twice as bright is taken before a darker one, which then is a shadow. *stage (to be
// freed by ffp_common_stage_free) knows only such pixels. False when there are fewer than five views.
bool ffp_common_stage(FfpEmptyStage *stage, FfpCommon *found, const FfpCapture *capture);
// Finds *stage again, once there are masks made with it (coverage, 0 and 1), if part of what was taken for
// the stage stands above the platter (ffp_place_above), 2 % of the mean mask at least: there the object looks
// the same from all sides. Such pixels then count as the object. False, and nothing is done, if there is
// less.
bool ffp_common_stage_again(FfpEmptyStage *stage, const FfpCapture *capture);
void ffp_common_stage_free(FfpEmptyStage *stage, int n_patterns);

#endif
