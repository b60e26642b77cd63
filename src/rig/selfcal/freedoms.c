// Fits in which the camera need not be the same everywhere, nor the panel's pixels square, and findings from
// what they show.
#include <math.h>
#include <string.h>
#include "core/base/alloc.h"
#include "core/base/call.h"
#include "core/numerics/rank.h"
#include "rig/findings/tell.h"
#include "rig/selfcal/selfcal.h"

enum { ROUNDS = 6, PLACES_FEW = 2 };
#define LEAST 0.2 // of the widest deviation: below it a camera is one
#define ONE 1.5   // times that: and is fitted as one
#define PAIR 1.4  // times the widest, for two places: these may be of two cameras, which nothing else tells
#define MOST 3.0  // and how far it is spread at most
#define SETTLED 0.15  // change of a deviation's logarithm that is none
#define CERTAIN 3.5   // deviations from which on a difference is one
#define ZOOMED 0.01   // of the focal length: less than that is focusing
#define SHIFTED 0.003 // of the width

static const FfpOwn widest = {0.006, 0.006, 0.01}; // stabilisers and lenses that focus
// Of cameras of which nothing is known, and the focal length of those whose files or user say it.
static const FfpOwn of_each = {0.02, 0.02, 0.1, 0.1};
#define EACH_KNOWN 0.03

// --- A camera of its own at each place. ---

// How far the places' own numbers are spread: what each is, and how uncertain it is.
static double spread_of(const FfpBundle *b, int number) {
    double sum = 0;
    for (int p = 0; p < b->tracks->n_places; p++)
        if (b->known[p]) sum += pow(b->own[p][number], 2) + pow(b->own_deviation[p][number], 2);
    return sqrt(sum / fmax(1, ffp_bundle_places(b)));
}

// Takes the deviations that the places show; the largest change of a logarithm.
static double take_spread(FfpBundle *b) {
    const double axis = sqrt(0.5 * (pow(spread_of(b, FFP_OWN_X), 2) + pow(spread_of(b, FFP_OWN_Y), 2)));
    const FfpOwn spread = {axis, axis, spread_of(b, FFP_OWN_FOCAL)};
    double moved = 0;
    for (int k = 0; k <= FFP_OWN_FOCAL; k++) {
        const double usual = fmin(fmax(spread[k], LEAST * widest[k]), MOST * widest[k]);
        moved = fmax(moved, fabs(log(usual / b->own_usual[k])));
        b->own_usual[k] = usual;
    }
    return moved;
}

// True if the user says the lens, or the files of all places that are used.
static bool is_lens_known(const FfpBundle *b) {
    const FfpTracks *t = b->tracks;
    bool all = true;
    for (int p = 0; p < t->n_places; p++) all = all && (!b->known[p] || t->places[p].focal_35mm > 0);
    return b->usual.focal.deviation > 0 && (all || !(t->focal_35mm > 0));
}

static void fit_own(FfpBundle *b, int stride, double far) {
    const double times = ffp_bundle_places(b) > PLACES_FEW ? 1 : PAIR;
    for (int k = 0; k < FFP_OWN; k++) b->own_usual[k] = b->each ? of_each[k] : times * widest[k];
    if (b->each && is_lens_known(b)) b->own_usual[FFP_OWN_FOCAL] = EACH_KNOWN;
    ffp_bundle_fit(b, stride, far, true);
    for (int round = 0;
         round < ROUNDS && !b->each && ffp_bundle_places(b) > PLACES_FEW && take_spread(b) > SETTLED;
         round++) {
        ffp_bundle_fit(b, stride, 0, true);
        ffp_cancel_point();
    }
}

static double median_own(const FfpBundle *b, int number) {
    real values[FFP_PLACES_MAX];
    size_t n = 0;
    for (int p = 0; p < b->tracks->n_places; p++)
        if (b->known[p]) values[n++] = (real)b->own[p][number];
    return n > 0 ? (double)ffp_median(values, n) : 0;
}

double ffp_bundle_focal(const FfpBundle *b) {
    return b->optics[FFP_BUNDLE_CAMERA_FOCAL] + median_own(b, FFP_OWN_FOCAL);
}

// By how much a place's number differs from those of most; 0 where that is not certain.
static double differs(const FfpBundle *b, int place, int number, double least) {
    const double by = b->own[place][number] - median_own(b, number);
    return b->known[place] && fabs(by) > least && fabs(by) > CERTAIN * b->own_deviation[place][number] ? by
                                                                                                       : 0;
}

bool ffp_bundle_tell_own(const FfpBundle *b) {
    bool any = false;
    for (int p = 0; p < b->tracks->n_places; p++) {
        const FfpFacts facts = {.view = b->tracks->places[p].name};
        const double zoomed = differs(b, p, FFP_OWN_FOCAL, ZOOMED),
                     shifted = hypot(differs(b, p, FFP_OWN_X, SHIFTED), differs(b, p, FFP_OWN_Y, SHIFTED));
        if (fabs(zoomed) > 0) {
            FfpFacts more = facts;
            more.figure = expm1(zoomed), more.limit = ZOOMED;
            ffp_tell(FFP_RULE_PLACE_ZOOMED, &more);
        }
        if (shifted > 0) {
            FfpFacts more = facts;
            more.figure = shifted * b->tracks->width, more.limit = SHIFTED * b->tracks->width;
            ffp_tell(FFP_RULE_PLACE_SHIFTED, &more);
        }
        any = any || fabs(zoomed) > 0 || shifted > 0;
    }
    return any;
}

// --- A panel whose pixels are not square. ---

bool ffp_bundle_fit_freely(FfpBundle *b, int stride, double far) {
    const bool square = !(b->usual.panel > 0);
    fit_own(b, stride, far);
    if (square) {
        b->usual.panel = FFP_PANEL_WIDE;
        ffp_bundle_fit(b, stride, 0, true);
    }
    if (ffp_panel_unsquare(b->optics, b->deviation)) return false;
    b->usual.panel = 0;
    ffp_bundle_fit(b, stride, 0, true);
    return true;
}

// --- One camera. ---

void ffp_bundle_join(FfpBundle *b, int stride) {
    for (int k = 0; k <= FFP_OWN_FOCAL; k++)
        if (b->own_usual[k] > ONE * LEAST * widest[k]) return;
    memset(b->own, 0, (size_t)b->tracks->n_places * sizeof *b->own);
    memset(b->own_usual, 0, sizeof b->own_usual);
    ffp_bundle_fit(b, stride, 0, false);
}
