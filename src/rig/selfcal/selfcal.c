#include "rig/selfcal/selfcal.h"
#include <math.h>
#include <stdio.h>
#include <string.h>
#include "core/base/alloc.h"
#include "core/base/file.h"
#include "core/base/log.h"
#include "core/numerics/rank.h"
#include "rig/chessboard/opencv.h"
#include "rig/findings/tell.h"
#include "rig/selfcal/start.h"

enum { PLACES_LEAST = 2, SIDE_MIN = 64, SIDE_MAX = 16384, FIT_TRACKS = 2500 };
#define FAR 5 // times the median

static bool check(const FfpSelfCalibration *o, FfpError *err) {
    if (o->n_places == 0) return ffp_fail(err, FFP_ERROR_ARGUMENT, "places", "no photographs given");
    if (o->n_angles == 0 ? !o->folder : !(o->file && o->turntable_file))
        return ffp_fail(err, FFP_ERROR_ARGUMENT, "output",
                        o->n_angles == 0 ? "no folder to write to" : "no files to write to");
    for (int i = 0; i < o->n_angles; i++)
        if (!(fabs(o->angles[i]) <= 36000))
            return ffp_fail(err, FFP_ERROR_ARGUMENT, "angles", "invalid angle: %g degrees", o->angles[i]);
    if (o->camera_per_folder && o->n_angles > 0)
        return ffp_fail(err, FFP_ERROR_ARGUMENT, "camera_per_folder",
                        "one camera stands before a turntable, at all of its stops");
    if (!(o->focal_35mm == 0 ||
          (o->focal_35mm >= FFP_FOCAL_35MM_LEAST && o->focal_35mm <= FFP_FOCAL_35MM_MOST)))
        return ffp_fail(err, FFP_ERROR_ARGUMENT, "focal", "%g mm is not in %d to %d", o->focal_35mm,
                        FFP_FOCAL_35MM_LEAST, FFP_FOCAL_35MM_MOST);
    if (!(o->length >= 0 && o->length < 1e9))
        return ffp_fail(err, FFP_ERROR_ARGUMENT, "length", "invalid length: %g", o->length);
    return o->shown ||
           (o->width >= SIDE_MIN && o->width <= SIDE_MAX && o->height >= SIDE_MIN && o->height <= SIDE_MAX) ||
           ffp_fail(err, FFP_ERROR_ARGUMENT, "projector", "a side of %d x %d is not in %d to %d pixels",
                    o->width, o->height, SIDE_MIN, SIDE_MAX);
}

// --- Judging. ---

// Places that are left out; before all fails, those that have a reason of their own.
static void tell_places(const FfpBundle *b, bool fails) {
    for (int p = 0; p < b->tracks->n_places; p++)
        if (!b->known[p] && (!fails || b->tracks->places[p].problem[0]))
            ffp_tell(FFP_RULE_PLACE_LEFT_OUT,
                     &(FfpFacts){.view = b->tracks->places[p].name,
                                 .a = b->tracks->places[p].problem[0]
                                          ? b->tracks->places[p].problem
                                          : "it sees nothing that other places see"});
}

// Median over the points of the largest angle between two cameras that see one, degrees.
static double parallax_of(const FfpBundle *b) {
    const FfpTracks *t = b->tracks;
    real *angles = ffp_alloc((size_t)t->n + 1, sizeof *angles);
    size_t n = 0;
    for (int i = 0; i < t->n; i++) {
        double point[3], rays[FFP_PLACES_MAX][3], widest = 0;
        int seen = 0;
        if (!ffp_bundle_point(b, i, point)) continue;
        for (int k = 0; k < t->tracks[i].n; k++) {
            const FfpSighting *s = &t->sightings[t->tracks[i].first + k];
            FfpRigid camera;
            if (!s->used || !b->known[s->place]) continue;
            ffp_rigid_inverse(&b->places[s->place], &camera);
            for (int a = 0; a < 3; a++) rays[seen][a] = camera.t[a] - point[a];
            ffp_unit(rays[seen++]);
        }
        for (int x = 0; x < seen; x++)
            for (int y = 0; y < x; y++) widest = fmax(widest, acos(fmin(1, ffp_dot(rays[x], rays[y]))));
        if (seen > 1) angles[n++] = (real)(widest * 180 / FFP_PI_DOUBLE);
    }
    const double median = n > 0 ? (double)ffp_median(angles, n) : 0;
    ffp_free(angles);
    return median;
}

static bool judge_parallax(const FfpBundle *b, FfpError *err) {
    const double angle = parallax_of(b);
    return angle >= ffp_rule(FFP_RULE_PLACES_NEAR)->limit ||
           ffp_refuse(FFP_RULE_PLACES_NEAR, &(FfpFacts){.figure = angle}, NULL, err);
}

// A lens that the photographs contradict is not believed, unless they hardly tell. It is that of most places;
// where others pull the common focal length away from it, it is not needed.
static void judge_known(FfpBundle *b, int stride) {
    const FfpKnownFocal lens = b->usual.focal;
    const double *common = &b->optics[FFP_BUNDLE_CAMERA_FOCAL];
    if (!ffp_focal_contradicts(&lens, *common, 0)) return;
    b->usual.focal.deviation = 0;
    ffp_bundle_fit_freely(b, stride, FAR);
    const double deviation = b->deviation[FFP_BUNDLE_CAMERA_FOCAL],
                 most = b->each ? *common : ffp_bundle_focal(b); // of most places
    if (ffp_focal_contradicts(&lens, most, deviation)) {
        ffp_tell_known_focal(&lens, most);
    } else if (!ffp_focal_contradicts(&lens, *common, deviation)) {
        b->usual.focal = lens;
        ffp_bundle_fit_freely(b, stride, FAR);
    }
}

// Distance of the first two known places.
static double first_step(const FfpBundle *b) {
    FfpRigid cameras[2] = {{{0}, {0}}};
    int n = 0;
    for (int p = 0; p < b->tracks->n_places && n < 2; p++)
        if (b->known[p]) ffp_rigid_inverse(&b->places[p], &cameras[n++]);
    double step[3];
    for (int k = 0; k < 3; k++) step[k] = cameras[1].t[k] - cameras[0].t[k];
    return ffp_unit(step);
}

// The largest deviation of a place's focal length.
static double camera_uncertain(const FfpBundle *b) {
    double most = b->deviation[FFP_BUNDLE_CAMERA_FOCAL];
    for (int p = 0; b->each && p < b->tracks->n_places; p++)
        if (b->known[p]) most = fmax(most, b->focal_deviation[p]);
    return most;
}

static void fill_stats(const FfpBundle *b, FfpSelfCalibrationStats *s) {
    const FfpTracks *t = b->tracks;
    *s = (FfpSelfCalibrationStats){.places = t->n_places,
                                   .used = ffp_bundle_places(b),
                                   .rms = b->rms,
                                   .camera_focal = exp(ffp_bundle_focal(b)),
                                   .camera_uncertain = camera_uncertain(b),
                                   .projector_focal = exp(b->optics[FFP_BUNDLE_PROJECTOR_FOCAL]),
                                   .projector_uncertain = b->deviation[FFP_BUNDLE_PROJECTOR_FOCAL],
                                   .parallax = parallax_of(b)};
    for (int i = 0; i < t->n; i++) s->points += b->nearness[i] > 0;
    double turn = 0;
    for (int p = 0; p < t->n_places; p++)
        for (int k = 0; b->known[p] && k < 3; k++)
            turn = fmax(turn, b->deviation[FFP_BUNDLE_OPTICS + 6 * (ptrdiff_t)p + k]);
    s->turn_uncertain = turn * 180 / FFP_PI_DOUBLE;
}

// --- All of it. ---

// As it was before the start, which alone has found fault with the `usable` places.
static void begin_again(FfpBundle *b, const bool *usable) {
    for (int p = 0; p < b->tracks->n_places; p++) {
        b->known[p] = false;
        if (usable[p]) b->tracks->places[p].problem[0] = 0;
    }
    for (int i = 0; i < b->tracks->n_sightings; i++) b->tracks->sightings[i].used = true;
    memset(b->own, 0, (size_t)b->tracks->n_places * sizeof *b->own);
    memset(b->own_usual, 0, sizeof b->own_usual);
    memset(b->nearness, 0, (size_t)b->tracks->n * sizeof *b->nearness);
    memset(b->optics, 0, sizeof b->optics);
    b->rms = b->noise = 0;
}

// Where a panel with square pixels explains nothing, or others explain more, all begins again with these.
static bool start_and_fit(FfpBundle *b, int stride, FfpError *err) {
    bool usable[FFP_PLACES_MAX] = {false};
    for (int p = 0; p < b->tracks->n_places; p++) usable[p] = b->tracks->places[p].problem[0] == 0;
    const bool started = ffp_bundle_start(b, err);
    const FfpRuleId refused = b->refused;
    if (started && ffp_bundle_fit_freely(b, stride, FAR)) return true;
    if (!started && !refused) return false;
    begin_again(b, usable);
    b->usual.panel = FFP_PANEL_WIDE;
    const bool again = ffp_bundle_start(b, err);
    if (again && (!ffp_bundle_fit_freely(b, stride, FAR) || started)) return true;
    if (!started && (again || b->refused)) b->refused = refused; // otherwise another error ended it
    return false;
}

static bool refuse_start(const FfpBundle *b, FfpError *err) {
    char why[FFP_LEFT_OUT_SIZE];
    ffp_places_left_out(b->tracks, why);
    return b->refused && ffp_refuse(b->refused, &(FfpFacts){.figure = b->apart, .b = why}, NULL, err);
}

static bool enough_places(const FfpTracks *t, int used, FfpError *err) {
    return used >= PLACES_LEAST ||
           ffp_places_refuse_few(t, used, PLACES_LEAST, "places of the camera can be used", err);
}

static bool judge_cameras(const FfpBundle *b, FfpError *err) {
    char name[300];
    for (int p = 0; b->each && p < b->tracks->n_places; p++) {
        if (!b->known[p]) continue;
        const FfpBundleDevice camera = ffp_bundle_camera_at(b->tracks, b->optics, b->own[p]);
        snprintf(name, sizeof name, "'%s' camera", b->tracks->places[p].name);
        if (!ffp_judge_focal(b->focal_deviation[p], name, FFP_RULE_PLACES_FOCAL, err)) return false;
        ffp_note("%s: focal length %.1f pixels (+- %.2f %%), optical axis at %.1f, %.1f",
                 b->tracks->places[p].name, sqrt(camera.fx * camera.fy), 100 * b->focal_deviation[p],
                 camera.x, camera.y);
    }
    return b->each ||
           ffp_judge_focal(b->deviation[FFP_BUNDLE_CAMERA_FOCAL], "camera", FFP_RULE_PLACES_FOCAL, err);
}

bool ffp_self_calibration_fit(FfpBundle *b, FfpError *err) {
    const int stride = b->tracks->n / FIT_TRACKS + 1;
    int usable = 0;
    for (int p = 0; p < b->tracks->n_places; p++) usable += b->tracks->places[p].problem[0] == 0;
    const bool started = usable >= PLACES_LEAST && start_and_fit(b, stride, err);
    if (!started) {
        tell_places(b, true);
        return enough_places(b->tracks, usable, err) && refuse_start(b, err);
    }
    judge_known(b, stride);
    tell_places(b, false);
    if (!enough_places(b->tracks, ffp_bundle_places(b), err)) return false;
    ffp_tell_end(b->end);
    ffp_tell_misfit(b->rms, b->noise, FFP_RULE_PLACES_MISFIT);
    if (!b->each && !ffp_bundle_tell_own(b)) ffp_bundle_join(b, stride);
    return judge_parallax(b, err) && ffp_judge_panel(b->optics, b->deviation, err) && judge_cameras(b, err) &&
           ffp_judge_focal(b->deviation[FFP_BUNDLE_PROJECTOR_FOCAL], "projector", FFP_RULE_PLACES_FOCAL, err);
}

static bool run_walk(const FfpSelfCalibration *o, FfpTracks *tracks, FfpSelfCalibrationStats *stats,
                     FfpError *err) {
    FfpBundle b = {.tracks = tracks,
                   .each = o->camera_per_folder,
                   .places = ffp_alloc((size_t)tracks->n_places, sizeof *b.places),
                   .known = ffp_alloc((size_t)tracks->n_places, sizeof *b.known),
                   .nearness = ffp_alloc((size_t)tracks->n + 1, sizeof *b.nearness),
                   .own = ffp_alloc((size_t)tracks->n_places, sizeof *b.own),
                   .usual.focal = ffp_known_focal(o->focal_35mm, tracks)};
    const bool ok =
        ffp_self_calibration_fit(&b, err) &&
        ffp_self_calibration_write(&b, (o->length > 0 ? o->length : 1) / first_step(&b), o->folder, err);
    if (ok && stats) fill_stats(&b, stats);
    ffp_free(b.places), ffp_free(b.known), ffp_free(b.nearness), ffp_free(b.deviation), ffp_free(b.own),
        ffp_free(b.own_deviation), ffp_free(b.focal_deviation);
    return ok;
}

static bool probe(const FfpSelfCalibration *o, FfpError *err) {
    if (o->n_angles == 0) return ffp_output_probe_folder(o->folder, err);
    return ffp_output_probe(o->file, err) && ffp_output_probe(o->turntable_file, err);
}

bool ffp_self_calibration_run(const FfpSelfCalibration *o, FfpSelfCalibrationStats *stats, FfpError *err) {
    FfpTracks tracks = {0};
    if (!check(o, err) || !ffp_cv_available(err) || !probe(o, err)) return false;
    const bool ok = ffp_places_read(o, &tracks, err) &&
                    (o->n_angles > 0 ? ffp_self_calibration_turntable(o, &tracks, stats, err)
                                     : run_walk(o, &tracks, stats, err));
    ffp_tracks_free(&tracks);
    return ok;
}
