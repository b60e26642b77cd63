// People's mistakes with photographs and calibrations, tried on a capture that contradicts itself: each
// is undone as if it had happened, and what remains of the contradiction is measured again.
#ifndef FFP_RIG_CHECKS_HYPOTHESES_H
#define FFP_RIG_CHECKS_HYPOTHESES_H

#include "rig/checks/measure.h"
#include "rig/findings/tell.h"

// The kind of contradiction, and its measure.
typedef enum FfpEvidence {
    FFP_VIEW_BY_SHAPE,   // one view, by silhouettes
    FFP_VIEWS_BY_SHAPE,  // all
    FFP_VIEWS_BY_LIGHT,  // all, by the structured light
    FFP_VIEW_BY_LIGHT,   // one
    FFP_VALUES_BY_LIGHT, // what the values of all photographs stand for
    FFP_VIEW_BY_DEPTH,   // one, by the surfaces that each view's light gives: the pairs that lie apart
    FFP_VIEWS_BY_DEPTH,  // all
} FfpEvidence;

typedef struct FfpCase {
    const FfpCapture *capture;
    int active;                   // the structured light's pattern; -1: none
    const FfpSummed *pattern;     // its picture
    int view;                     // the one view
    const FfpSilhouettes *shapes; // by silhouettes
    int compared;                 // by depth: pairs of neighbours that show enough of one surface
    double error, chance;         // by light: as it is, and by chance
    double enough;                // share of the pixels or error that is an explanation
} FfpCase;

// Of the error by chance: less, and the pattern explains a photograph.
#define FFP_LIGHT_EXPLAINED 0.7

// Adds the fault that explains the case best of those of the first kind that does. False: one did.
bool ffp_hypotheses_try(FfpFindings *found, FfpEvidence evidence, const FfpCase *c);

#endif
