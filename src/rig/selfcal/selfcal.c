#include "rig/selfcal/selfcal.h"
#include <math.h>
#include <stdio.h>
#include <string.h>
#include "core/base/alloc.h"
#include "core/base/file.h"
#include "core/numerics/rank.h"
#include "rig/chessboard/opencv.h"
#include "rig/findings/tell.h"
#include "rig/selfcal/start.h"

enum { PLACES_LEAST = 2, SIDE_MIN = 64, SIDE_MAX = 16384, FIT_TRACKS = 2500 };
#define FAR 5        // times the median
#define PARALLAX 1.0 // degrees between the outermost places' rays that can be worked with

static bool check(const FfpSelfCalibration *o, FfpError *err) {
    if (o->n_places == 0) return ffp_fail(err, FFP_ERROR_ARGUMENT, "places", "no photographs given");
    if (o->n_angles == 0 ? !o->folder : !(o->file && o->turntable_file))
        return ffp_fail(err, FFP_ERROR_ARGUMENT, "output",
                        o->n_angles == 0 ? "no folder to write to" : "no files to write to");
    for (int i = 0; i < o->n_angles; i++)
        if (!(fabs(o->angles[i]) <= 36000))
            return ffp_fail(err, FFP_ERROR_ARGUMENT, "angles", "invalid angle: %g degrees", o->angles[i]);
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

static int known_places(const FfpBundle *b) {
    int n = 0;
    for (int p = 0; p < b->tracks->n_places; p++) n += b->known[p];
    return n;
}

static void tell_places(const FfpBundle *b) {
    for (int p = 0; p < b->tracks->n_places; p++)
        if (!b->known[p])
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
    return angle >= PARALLAX ||
           ffp_fail(err, FFP_ERROR_FILE, NULL,
                    "the places of the camera are too near to each other for what they "
                    "see (%.1f degrees between their "
                    "rays): walk 10 to 20 degrees from one to the next; before an object that turned "
                    "instead, give its angles",
                    angle);
}

static bool judge_focal(const FfpBundle *b, int number, const char *device, FfpError *err) {
    return ffp_judge_focal(b->optics[number], b->deviation[number], device, FFP_RULE_PLACES_FOCAL, err);
}

// A lens that the photographs contradict is not believed.
static void judge_known(FfpBundle *b, int stride) {
    if (!ffp_judge_known_focal(&b->focal, b->optics[FFP_BUNDLE_CAMERA_FOCAL])) return;
    ffp_bundle_fit(b, stride, FAR, true);
    ffp_tell_known_focal(&b->focal, b->optics[FFP_BUNDLE_CAMERA_FOCAL]);
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

static void fill_stats(const FfpBundle *b, FfpSelfCalibrationStats *s) {
    const FfpTracks *t = b->tracks;
    *s = (FfpSelfCalibrationStats){.places = t->n_places,
                                   .used = known_places(b),
                                   .rms = b->rms,
                                   .camera_focal = exp(b->optics[FFP_BUNDLE_CAMERA_FOCAL]),
                                   .camera_uncertain = b->deviation[FFP_BUNDLE_CAMERA_FOCAL],
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

bool ffp_self_calibration_fit(FfpBundle *b, FfpError *err) {
    if (!ffp_bundle_start(b, err)) return false;
    const int stride = b->tracks->n / FIT_TRACKS + 1;
    ffp_bundle_fit(b, stride, FAR, true);
    judge_known(b, stride);
    tell_places(b);
    if (known_places(b) < PLACES_LEAST)
        return ffp_fail(err, FFP_ERROR_FILE, NULL, "fewer than %d places of the camera can be used",
                        PLACES_LEAST);
    return judge_parallax(b, err) && judge_focal(b, FFP_BUNDLE_CAMERA_FOCAL, "camera", err) &&
           judge_focal(b, FFP_BUNDLE_PROJECTOR_FOCAL, "projector", err);
}

static bool run_walk(const FfpSelfCalibration *o, FfpTracks *tracks, FfpSelfCalibrationStats *stats,
                     FfpError *err) {
    FfpBundle b = {.tracks = tracks,
                   .places = ffp_alloc((size_t)tracks->n_places, sizeof *b.places),
                   .known = ffp_alloc((size_t)tracks->n_places, sizeof *b.known),
                   .nearness = ffp_alloc((size_t)tracks->n + 1, sizeof *b.nearness),
                   .focal = ffp_known_focal(o->focal_35mm, tracks)};
    const bool ok =
        ffp_self_calibration_fit(&b, err) &&
        ffp_self_calibration_write(&b, (o->length > 0 ? o->length : 1) / first_step(&b), o->folder, err);
    if (ok && stats) fill_stats(&b, stats);
    ffp_free(b.places), ffp_free(b.known), ffp_free(b.nearness), ffp_free(b.deviation);
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
