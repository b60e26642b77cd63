// Focal lengths: what a lens says of one, and whether the photographs tell it.
#include <math.h>
#include <stdio.h>
#include "core/base/log.h"
#include "rig/findings/tell.h"
#include "rig/selfcal/selfcal.h"

#define PLACES_OPEN 0.07  // share of the focal length by which it may be uncertain: of a walk, whose places
#define STOPS_OPEN 0.1    // may have cameras of their own, and of a camera that stands before a turntable
#define FOCAL_VAGUE 0.02  // and where that is worth a warning
#define MISFIT 0.8        // of the noise: errors that neighbours share
#define MISFIT_LEAST 0.1  // pixels
#define UNSQUARE 0.01     // aspect or skew of a panel, and
#define CERTAIN 3.5       // deviations from which on it is one
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

bool ffp_focal_contradicts(const FfpKnownFocal *known, double found, double deviation) {
    return known->deviation > 0 && fabs(found - known->log) > KNOWN_OFF * hypot(known->deviation, deviation);
}

void ffp_tell_known_focal(const FfpKnownFocal *known, double found) {
    ffp_tell(FFP_RULE_LENS_DIFFERS,
             &(FfpFacts){.figure = fabs(exp(found - known->log) - 1), .limit = KNOWN_OFF * FOCAL_KNOWN});
}

bool ffp_judge_focal(double deviation, const char *device, int doubt, FfpError *err) {
    const bool places = doubt == FFP_RULE_PLACES_FOCAL;
    FfpFacts facts = {.a = device, .figure = fmin(9.99, deviation), .limit = FOCAL_VAGUE};
    const double most = places ? PLACES_OPEN : STOPS_OPEN;
    if (!(deviation < most)) {
        facts.limit = most;
        return ffp_refuse(places ? FFP_RULE_PLACES_FOCAL_OPEN : FFP_RULE_STOPS_FOCAL_OPEN, &facts, NULL, err);
    }
    if (deviation > FOCAL_VAGUE) ffp_tell((FfpRuleId)doubt, &facts);
    return true;
}

void ffp_tell_misfit(double rms, double noise, int rule) {
    const double shared = sqrt(fmax(0, rms * rms - noise * noise));
    if (noise > 0 && shared > fmax(MISFIT * noise, MISFIT_LEAST))
        ffp_tell((FfpRuleId)rule, &(FfpFacts){.figure = rms / noise, .limit = hypot(1, MISFIT)});
}

void ffp_tell_end(FfpFitEnd end) {
    if (end != FFP_END_SETTLED)
        ffp_tell(FFP_RULE_FIT_UNSETTLED,
                 &(FfpFacts){.a = end == FFP_END_STUCK ? "no step improved it" : "its steps ran out"});
}

// The place whose reason is told of all that are left out; NULL: none is.
static const FfpCameraPlace *first_left_out(const FfpTracks *t, int *count) {
    const FfpCameraPlace *first = NULL;
    *count = 0;
    for (int p = 0; p < t->n_places; p++) {
        const FfpCameraPlace *place = &t->places[p];
        *count += place->problem[0] != 0;
        if (place->problem[0] && (!first || (place->finding && !first->finding))) first = place;
    }
    return first;
}

void ffp_places_left_out(const FfpTracks *t, char text[FFP_LEFT_OUT_SIZE]) {
    int count;
    const FfpCameraPlace *first = first_left_out(t, &count);
    snprintf(text, FFP_LEFT_OUT_SIZE, "none left out");
    if (first)
        snprintf(text, FFP_LEFT_OUT_SIZE, "%d left out, %.90s: %.500s", count, first->name, first->problem);
}

bool ffp_places_refuse_few(const FfpTracks *t, int used, int least, const char *what, FfpError *err) {
    char why[FFP_LEFT_OUT_SIZE];
    int count;
    const FfpCameraPlace *first = first_left_out(t, &count);
    ffp_places_left_out(t, why);
    ffp_refuse(FFP_RULE_TOO_FEW, &(FfpFacts){.x = used, .y = t->n_places, .z = least, .a = what, .b = why},
               NULL, err);
    if (err && first && first->finding) err->finding = first->finding;
    return false;
}

static bool unsquare(const double *optics, const double *deviation, int number) {
    return fabs(optics[number]) > UNSQUARE && fabs(optics[number]) > CERTAIN * deviation[number];
}

bool ffp_panel_unsquare(const double optics[FFP_BUNDLE_OPTICS], const double *deviation) {
    return unsquare(optics, deviation, FFP_BUNDLE_PROJECTOR_ASPECT) ||
           unsquare(optics, deviation, FFP_BUNDLE_PROJECTOR_SKEW);
}

bool ffp_judge_panel(const double optics[FFP_BUNDLE_OPTICS], const double *deviation, FfpError *err) {
    const double aspect = optics[FFP_BUNDLE_PROJECTOR_ASPECT], skew = optics[FFP_BUNDLE_PROJECTOR_SKEW];
    if (unsquare(optics, deviation, FFP_BUNDLE_PROJECTOR_SKEW))
        return ffp_refuse(FFP_RULE_PANEL_KEYSTONED, &(FfpFacts){.figure = fabs(skew), .limit = UNSQUARE},
                          NULL, err);
    if (unsquare(optics, deviation, FFP_BUNDLE_PROJECTOR_ASPECT))
        ffp_tell(FFP_RULE_PANEL_STRETCHED, &(FfpFacts){.figure = fabs(expm1(aspect)), .limit = UNSQUARE});
    return true;
}
