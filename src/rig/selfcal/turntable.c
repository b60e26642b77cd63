// A turntable without a board, from what its stops see to files.
#include <math.h>
#include <stdio.h>
#include <string.h>
#include "core/base/alloc.h"
#include "core/base/call.h"
#include "core/base/log.h"
#include "core/capture/node.h"
#include "core/numerics/rank.h"
#include "rig/calibrate/calibrate.h"
#include "rig/findings/tell.h"
#include "rig/selfcal/selfcal.h"

enum { STOPS_LEAST = 3, ROUNDS = 8, ROUNDS_HELD = 2, STEPS = 8, FEW_SIGHTINGS = 2000, FIT_SIGHTINGS = 8000 };
#define ANGLES_OFF 2.0  // degrees: deviation of an angle that is given
#define ANGLES_MOST 6.0 // degrees that one may be off
#define SCALE_FIRST 2.0 // pixels
#define SCALE_LEAST 0.5 // pixels
#define SCALE_MEDIANS 3.0
#define AGREES_LEAST 0.4 // of what the median stop has, of a stop's points that are seen where they turn to
#define ERRS 3.0         // times the others' errors, and
#define ERRS_LEAST 0.25  // pixels: camera and projector do not see alike
#define STILL 0.7        // pixels within which a spot is where it was
#define STILL_SHARE 0.8  // of the spots that two stops see: between these nothing turned
#define SPOTS_LEAST 50   // that two stops must both see to tell
#define SAME_FOCAL 0.01  // of its logarithm: the fit went back to where it began
#define SETTLED 1e-4     // by which a focal length moves when there is nothing more to gain
#define TILT_OPEN 3.0    // degrees, the axis' deviation

// --- Fitting. ---

// To a part of the sightings, until nothing moves.
static void settle(FfpTurning *t, int rounds) {
    const int few = t->tracks->n_sightings / FEW_SIGHTINGS + 1;
    double before = INFINITY, scale = SCALE_FIRST;
    for (int round = 0; round < rounds; round++) {
        ffp_turning_fit(t, few, scale, STEPS, false);
        scale = fmax(SCALE_MEDIANS * t->surface, SCALE_LEAST);
        const double now = t->optics[FFP_BUNDLE_CAMERA_FOCAL];
        if (fabs(now - before) < SETTLED) break;
        before = now;
    }
}

static void fit_well(FfpTurning *t) {
    const int all = t->tracks->n_sightings / FIT_SIGHTINGS + 1;
    settle(t, ROUNDS);
    const double scale = fmax(SCALE_MEDIANS * t->surface, SCALE_LEAST);
    ffp_turning_fit(t, all, scale, STEPS, false);
    ffp_turning_fit(t, all, scale, STEPS, true);
}

// --- The best of several fits: focal length and distance do much the same, and in between a fit may stay
// where the surfaces agree only in part. ---

typedef struct Fitted {
    double optics[FFP_BUNDLE_OPTICS], off[FFP_PLACES_MAX], disagreement;
    FfpRigid camera;
    FfpAxis axis;
} Fitted;

static Fitted keep(FfpTurning *t) {
    const int stride = t->tracks->n_sightings / FIT_SIGHTINGS + 1;
    Fitted f = {.camera = t->camera, .axis = t->axis};
    memcpy(f.optics, t->optics, sizeof f.optics);
    memcpy(f.off, t->off, (size_t)t->tracks->n_places * sizeof *f.off);
    ffp_turning_triangulate(t, stride);
    f.disagreement = ffp_turning_disagreement(t, stride, SCALE_LEAST);
    return f;
}

static void restore(FfpTurning *t, const Fitted *f) {
    memcpy(t->optics, f->optics, sizeof f->optics);
    memcpy(t->off, f->off, (size_t)t->tracks->n_places * sizeof *f->off);
    t->camera = f->camera, t->axis = f->axis;
}

// Fits with the focal length held at first, to keep what lies beyond the nearest bottom of the valley.
static Fitted fit_from(FfpTurning *t, const Fitted *start, double log_focal) {
    const FfpKnownFocal known = t->usual.focal;
    restore(t, start);
    t->usual.focal = (FfpKnownFocal){log_focal, FFP_FOCAL_HELD};
    settle(t, ROUNDS_HELD);
    t->usual.focal = known;
    settle(t, ROUNDS);
    return keep(t);
}

// The best of fits from several focal lengths; the farther ones are tried unless both near ones lead back.
static void fit_best(FfpTurning *t) {
    static const double steps[] = {-0.07, 0.07, -0.14, 0.14}; // of the logarithm, nearest first
    enum { STARTS = sizeof steps / sizeof *steps };
    settle(t, ROUNDS);
    const Fitted first = keep(t);
    const double focal = first.optics[FFP_BUNDLE_CAMERA_FOCAL];
    Fitted best = first;
    bool returned = true;
    for (int i = 0; i < STARTS && (i < STARTS / 2 || !returned); i++) {
        const Fitted other = fit_from(t, &first, focal + steps[i]);
        returned = returned && fabs(other.optics[FFP_BUNDLE_CAMERA_FOCAL] - focal) < SAME_FOCAL;
        if (other.disagreement < best.disagreement) best = other;
        ffp_cancel_point();
    }
    restore(t, &best);
    fit_well(t);
}

// --- Stops. ---

// The median of what stops have; below 0: they have none.
static double usual_of(const double *values, int stops) {
    real sorted[FFP_PLACES_MAX];
    size_t n = 0;
    for (int p = 0; p < stops; p++)
        if (values[p] >= 0) sorted[n++] = (real)values[p];
    return n > 0 ? (double)ffp_median(sorted, n) : 0;
}

// Where camera and projector themselves do not see alike at a stop, what it saw is of another rig.
static void drop_sightings(const FfpTracks *t, int stop) {
    for (int i = 0; i < t->n_sightings; i++)
        if (t->sightings[i].place == stop) t->sightings[i].used = false;
}

// Leaves out stops whose surface is not where the others turn to; true if there are any.
static bool drop_stops(FfpTurning *t) {
    const FfpTracks *tracks = t->tracks;
    double shares[FFP_PLACES_MAX], errors[FFP_PLACES_MAX];
    ffp_turning_agreement(t, fmax(SCALE_MEDIANS * t->surface, SCALE_LEAST), shares);
    ffp_turning_triangulate(t, 1);
    ffp_turning_stop_errors(t, errors);
    const double usual = usual_of(shares, tracks->n_places), error = usual_of(errors, tracks->n_places);
    bool any = false;
    for (int p = 0; p < tracks->n_places; p++) {
        if (shares[p] < 0 || shares[p] >= AGREES_LEAST * usual) continue;
        const bool rig_moved = errors[p] > fmax(ERRS * error, ERRS_LEAST);
        any = true;
        if (rig_moved) drop_sightings(tracks, p);
        snprintf(tracks->places[p].problem, sizeof tracks->places[p].problem,
                 "of what it and the stops beside it see, %.0f %% agree, and elsewhere %.0f %%: %s",
                 100 * shares[p], 100 * usual,
                 rig_moved ? "the camera or the projector moved, was zoomed or focused again"
                           : "its angle is another, or the object moved");
    }
    if (any) ffp_turning_set_stops(t);
    return any;
}

// How many spots two stops both see, and how many of them at the same pixel.
static void count_still(const FfpTracks *t, int first, int second, int *both, int *still) {
    *both = *still = 0;
    for (int i = 0; i < t->n; i++) {
        const FfpSighting *s = t->sightings + t->tracks[i].first, *seen[2] = {NULL, NULL};
        for (int k = 0; k < t->tracks[i].n; k++) {
            if (s[k].place == first) seen[0] = &s[k];
            if (s[k].place == second) seen[1] = &s[k];
        }
        if (!seen[0] || !seen[1]) continue;
        ++*both;
        *still += hypot(seen[0]->at[0] - seen[1]->at[0], seen[0]->at[1] - seen[1]->at[1]) < STILL;
    }
}

// Leaves out stops at which the object stands as at another before them. Where most stops are such, it is
// round, which other checks report.
static void drop_twins(const FfpTracks *t) {
    int twin[FFP_PLACES_MAX], twins = 0;
    for (int q = 0; q < t->n_places; q++) {
        twin[q] = -1;
        for (int p = 0, both, still; p < q && twin[q] < 0; p++) {
            count_still(t, p, q, &both, &still);
            if (both >= SPOTS_LEAST && still >= STILL_SHARE * both) twin[q] = p, twins++;
        }
    }
    for (int q = 0; q < t->n_places && 2 * twins < t->n_places; q++)
        if (twin[q] >= 0 && t->places[q].problem[0] == 0)
            snprintf(t->places[q].problem, sizeof t->places[q].problem,
                     "the object stands as at the stop '%s': it did not turn between them, or these are the "
                     "same photographs",
                     t->places[twin[q]].name);
}

static int stops_used(const FfpTracks *t) {
    int n = 0;
    for (int p = 0; p < t->n_places; p++) n += t->places[p].problem[0] == 0;
    return n;
}

static bool check_stops(const FfpTracks *t, FfpError *err) {
    const int used = stops_used(t);
    return used >= STOPS_LEAST ||
           ffp_places_refuse_few(t, used, STOPS_LEAST, "stops of the turntable can be used", err);
}

// Angles that are farther off than a hand turns wrongly may belong to another way round.
static bool check_angles(const FfpTurning *t, FfpError *err) {
    for (int p = 0; p < t->tracks->n_places; p++) {
        const double off = t->off[p] * 180 / FFP_PI_DOUBLE;
        if (t->tracks->places[p].problem[0] == 0 && fabs(off) > ANGLES_MOST)
            return ffp_turning_check_parallax(t, FFP_PARALLAX_CLEAR, err) &&
                   ffp_refuse(FFP_RULE_STOP_ANGLE,
                              &(FfpFacts){.view = t->tracks->places[p].name,
                                          .figure = fabs(off),
                                          .limit = ANGLES_MOST},
                              NULL, err);
    }
    return true;
}

// With aspect and skew of the panel free, which stay so if they are certain.
static void try_panel(FfpTurning *t) {
    FfpTurning square = *t;
    const Fitted fitted = keep(t);
    t->usual.panel = FFP_PANEL_WIDE;
    fit_well(t);
    if (ffp_panel_unsquare(t->optics, t->deviation)) return;
    restore(&square, &fitted);
    *t = square;
    ffp_turning_triangulate(t, 1);
}

// Up in the picture.
static void orient(FfpTurning *t) {
    if (t->axis.direction[1] <= 0) return;
    for (int k = 0; k < 3; k++) t->axis.direction[k] = -t->axis.direction[k];
    for (int p = 0; p < t->tracks->n_places; p++) t->off[p] = -t->off[p];
    t->reversed = !t->reversed;
}

// The axis' point to where the object is.
static void settle_point(FfpTurning *t) {
    const int n = t->tracks->n_sightings;
    real *along = ffp_alloc((size_t)n + 1, sizeof *along);
    size_t found = 0;
    for (int i = 0; i < n; i++) {
        double point[3];
        if (!ffp_turning_point(t, i, point)) continue;
        for (int k = 0; k < 3; k++) point[k] -= t->axis.point[k];
        along[found++] = (real)ffp_dot(point, t->axis.direction);
    }
    const double by = found > 0 ? (double)ffp_median(along, found) : 0;
    for (int k = 0; k < 3; k++) t->axis.point[k] += by * t->axis.direction[k];
    ffp_free(along);
}

static bool find(FfpTurning *t, FfpError *err) {
    t->angles_known = 0;
    if (!ffp_turning_start(t, err)) return false;
    t->angles_known = ANGLES_OFF * FFP_PI_DOUBLE / 180;
    fit_best(t);
    return true;
}

// A lens that the photographs contradict is not believed, unless they hardly tell.
static bool find_without(FfpTurning *t, const FfpKnownFocal *lens, FfpError *err) {
    const double *focal = &t->optics[FFP_BUNDLE_CAMERA_FOCAL];
    t->usual.focal.deviation = 0;
    if (!find(t, err)) return false;
    if (ffp_focal_contradicts(lens, *focal, t->deviation[FFP_BUNDLE_CAMERA_FOCAL])) {
        ffp_tell_known_focal(lens, *focal);
        return true;
    }
    t->usual.focal = *lens;
    return find(t, err);
}

static bool turn(FfpTurning *t, FfpError *err) {
    drop_twins(t->tracks);
    ffp_turning_set_stops(t);
    ffp_turning_drop_still(t);
    if (!check_stops(t->tracks, err) || !find(t, err)) return false;
    const FfpKnownFocal lens = t->usual.focal;
    if (ffp_focal_contradicts(&lens, t->optics[FFP_BUNDLE_CAMERA_FOCAL], 0) && !find_without(t, &lens, err))
        return false;
    if (drop_stops(t) && stops_used(t->tracks) >= STOPS_LEAST) fit_well(t);
    if (!check_stops(t->tracks, err)) return false;
    try_panel(t);
    if (!ffp_turning_check_parallax(t, FFP_PARALLAX_LEAST, err) || !check_angles(t, err)) return false;
    orient(t);
    settle_point(t);
    const double tilt = t->tilt * 180 / FFP_PI_DOUBLE;
    if (!(tilt < TILT_OPEN))
        return ffp_refuse(FFP_RULE_STOPS_AXIS_OPEN,
                          &(FfpFacts){.figure = fmin(tilt, 180), .limit = TILT_OPEN}, NULL, err);
    ffp_tell_end(t->end);
    ffp_tell_misfit(t->rms, t->noise, FFP_RULE_STOPS_MISFIT);
    return ffp_judge_panel(t->optics, t->deviation, err) &&
           ffp_judge_focal(t->deviation[FFP_BUNDLE_CAMERA_FOCAL], "camera", FFP_RULE_STOPS_FOCAL, err) &&
           ffp_judge_focal(t->deviation[FFP_BUNDLE_PROJECTOR_FOCAL], "projector", FFP_RULE_STOPS_FOCAL, err);
}

bool ffp_self_calibration_turn(FfpTurning *t, FfpError *err) {
    const bool ok = turn(t, err);
    for (int p = 0; p < t->tracks->n_places; p++) {
        const FfpCameraPlace *stop = &t->tracks->places[p];
        if (stop->problem[0])
            ffp_tell(FFP_RULE_STOP_LEFT_OUT, &(FfpFacts){.view = stop->name, .a = stop->problem});
    }
    return ok;
}

// --- Files. ---

// The angle of a stop as it was found, degrees.
static double angle_found(const FfpTurning *t, int stop) {
    return (t->given[stop] + (t->reversed ? -1 : 1) * t->off[stop]) * 180 / FFP_PI_DOUBLE;
}

// Stops go by the names of their folders or, where names of views cannot be that or are not different, by
// their numbers.
static void name_stops(const FfpTracks *t, FfpTableStop *stops) {
    bool names = true;
    for (int p = 0; p < t->n_places; p++) {
        const char *name = t->places[p].name;
        names = names && ffp_is_name(name) && !strchr(name, '"');
        for (int q = 0; q < p; q++) names = names && strcmp(name, t->places[q].name) != 0;
    }
    for (int p = 0; p < t->n_places; p++) {
        stops[p].left_out = t->places[p].problem[0] != 0;
        if (names)
            snprintf(stops[p].view, sizeof stops[p].view, "%.*s", FFP_NAME_MAX - 1, t->places[p].name);
        else
            snprintf(stops[p].view, sizeof stops[p].view, "%d", p + 1);
    }
}

static bool write(const FfpTurning *t, const FfpSelfCalibration *o, FfpError *err) {
    FfpRigFit *fit = ffp_alloc(1, sizeof *fit);
    FfpTableFit *table = ffp_alloc(1, sizeof *table);
    double *angles = ffp_alloc((size_t)t->tracks->n_places, sizeof *angles);
    FfpTableStop *stops = ffp_alloc((size_t)t->tracks->n_places, sizeof *stops);
    const double unit = o->length > 0 ? o->length : 1;
    FfpRigid back;
    ffp_rigid_inverse(&t->camera, &back);
    memcpy(fit->r, back.r, sizeof fit->r);
    for (int k = 0; k < 3; k++) fit->t[k] = unit * back.t[k];
    fit->rms = fit->devices[0].rms = t->rms;
    ffp_optics_to_cv(t->tracks, t->optics, t->deviation, fit->devices);
    table->axis = t->axis;
    for (int k = 0; k < 3; k++) table->axis.point[k] *= unit;
    table->reversed = t->reversed;
    table->n = t->tracks->n_places;
    for (int p = 0; p < table->n; p++) angles[p] = angle_found(t, p);
    name_stops(t->tracks, stops);
    table->stops = stops, table->angles = angles;
    table->rms = t->surface, table->tilt = t->tilt * 180 / FFP_PI_DOUBLE;
    table->shift = t->shift * unit * sqrt(ffp_dot(t->axis.point, t->axis.point));
    const bool ok =
        ffp_write_calibration(fit, o->file, err) && ffp_write_table(table, o->turntable_file, err);
    ffp_free(stops), ffp_free(angles), ffp_free(table), ffp_free(fit);
    return ok;
}

static void fill(const FfpTurning *t, const FfpSelfCalibration *o, FfpSelfCalibrationStats *s) {
    const double unit = o->length > 0 ? o->length : 1;
    *s = (FfpSelfCalibrationStats){.places = t->tracks->n_places,
                                   .used = stops_used(t->tracks),
                                   .rms = t->rms,
                                   .camera_focal = exp(t->optics[FFP_BUNDLE_CAMERA_FOCAL]),
                                   .camera_uncertain = t->deviation[FFP_BUNDLE_CAMERA_FOCAL],
                                   .projector_focal = exp(t->optics[FFP_BUNDLE_PROJECTOR_FOCAL]),
                                   .projector_uncertain = t->deviation[FFP_BUNDLE_PROJECTOR_FOCAL],
                                   .has_axis = true,
                                   .reversed = t->reversed,
                                   .tilt = t->tilt * 180 / FFP_PI_DOUBLE,
                                   .shift = t->shift,
                                   .surface = t->surface,
                                   .parallax = ffp_turning_parallax(t)};
    for (int i = 0; i < t->tracks->n_sightings; i++) s->points += t->nearness[i] > 0;
    for (int k = 0; k < 3; k++) s->axis[k] = t->axis.direction[k], s->point[k] = unit * t->axis.point[k];
    double turn = 0;
    for (int k = 0; k < 3; k++) turn = fmax(turn, t->deviation[FFP_BUNDLE_OPTICS + k]);
    s->turn_uncertain = turn * 180 / FFP_PI_DOUBLE;
    for (int p = 0; p < t->tracks->n_places; p++)
        s->angle_off = fmax(s->angle_off, fabs(t->off[p]) * 180 / FFP_PI_DOUBLE);
}

bool ffp_self_calibration_turntable(const FfpSelfCalibration *o, FfpTracks *tracks,
                                    FfpSelfCalibrationStats *stats, FfpError *err) {
    if (o->n_angles != tracks->n_places)
        return ffp_fail(err, FFP_ERROR_ARGUMENT, "angles", "%d angles, but %d folders of stops", o->n_angles,
                        tracks->n_places);
    double *radians = ffp_alloc((size_t)o->n_angles, sizeof *radians);
    for (int i = 0; i < o->n_angles; i++) radians[i] = o->angles[i] * FFP_PI_DOUBLE / 180;
    FfpTurning t = ffp_turning_new(tracks, radians);
    t.usual.focal = ffp_known_focal(o->focal_35mm, tracks);
    const bool ok = ffp_self_calibration_turn(&t, err) && write(&t, o, err);
    if (ok && stats) fill(&t, o, stats);
    ffp_turning_free(&t);
    ffp_free(radians);
    return ok;
}
