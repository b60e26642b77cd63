// Focal lengths: what a lens says of one, and whether the photographs tell it.
#include <math.h>
#include "core/base/log.h"
#include "rig/findings/tell.h"
#include "rig/selfcal/selfcal.h"

#define FOCAL_OPEN 0.1    // share of the focal length by which it may be uncertain
#define FOCAL_VAGUE 0.02  // and where that is worth a warning
#define KNOWN_OFF 2.5     // deviations that a focal length may be off what was known
#define FOCAL_KNOWN 0.03  // deviation of a focal length that a lens or a file says
#define FULL_FRAME 43.267 // diagonal of 36 x 24, mm

FfpKnownFocal ffp_known_focal(double focal_35mm, const FfpTracks *t) {
    if (!(focal_35mm > 0) && t->focal_35mm >= FFP_FOCAL_35MM_LEAST && t->focal_35mm <= FFP_FOCAL_35MM_MOST) {
        focal_35mm = t->focal_35mm;
        ffp_note("the photographs' files say a focal length of %.0f mm (35 mm film)", focal_35mm);
    }
    if (!(focal_35mm > 0)) return (FfpKnownFocal){0};
    return (FfpKnownFocal){log(focal_35mm / FULL_FRAME * hypot(t->width, t->height)), FOCAL_KNOWN};
}

bool ffp_judge_known_focal(FfpKnownFocal *known, double found) {
    if (!(known->deviation > 0) || fabs(found - known->log) < KNOWN_OFF * known->deviation) return false;
    known->deviation = 0;
    return true;
}

void ffp_tell_known_focal(const FfpKnownFocal *known, double found) {
    ffp_tell(FFP_RULE_LENS_DIFFERS,
             &(FfpFacts){.figure = fabs(exp(found - known->log) - 1), .limit = KNOWN_OFF * FOCAL_KNOWN});
}

bool ffp_judge_focal(double log_focal, double deviation, const char *device, int doubt, FfpError *err) {
    if (!(deviation < FOCAL_OPEN))
        return ffp_fail(
            err, FFP_ERROR_FILE, NULL,
            "the %s's focal length (%.0f pixels) is uncertain by %.0f %%: %s, or say what lens it "
            "was",
            device, exp(log_focal), fmin(999, 100 * deviation), ffp_rule((FfpRuleId)doubt)->advice);
    if (deviation > FOCAL_VAGUE)
        ffp_tell((FfpRuleId)doubt, &(FfpFacts){.a = device, .figure = deviation, .limit = FOCAL_VAGUE});
    return true;
}
