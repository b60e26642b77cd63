// Masks of all views from the stage behind the object.
#ifndef FFP_RIG_STAGE_MASKS_H
#define FFP_RIG_STAGE_MASKS_H

#include "rig/masks/stage.h"

typedef struct FfpStageMasks {
    double stage, object, decided; // mean shares of the pictures: stage, object for sure, and object by the
                                   // hull or in it
    double shade;                  // and stage in the object's shadow that the hull allowed the object
    double gain_least, gain_most;  // of a view over the stage
    double noise[FFP_VIEWS_MAX];   // in each view, for ffp_soften_edges
} FfpStageMasks;

// Fills in the coverage of all views with 0 and 1; their pictures are not masked yet. stages [n_views];
// `paths` [n_views] names the views' pictures for errors. Where poses are known (`posed`) and three views or
// more, what is neither stage nor object for sure is object where the rays run through a hull that the stage
// carves. Errors: a view shows hardly anything of the stage, or no view an object.
bool ffp_stage_masks(FfpStageMasks *report, FfpCapture *capture, const FfpEmptyStage *const *stages,
                     bool posed, const char *const *paths, FfpError *err);

#endif
