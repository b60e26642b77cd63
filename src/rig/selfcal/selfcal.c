#include "rig/selfcal/selfcal.h"
#include <math.h>
#include <stdio.h>
#include <string.h>
#include "core/base/alloc.h"
#include "core/base/file.h"
#include "core/base/log.h"
#include "core/image/photograph.h"
#include "core/numerics/rank.h"
#include "rig/chessboard/opencv.h"
#include "rig/findings/tell.h"
#include "rig/graycode/graycode.h"
#include "rig/selfcal/start.h"
#include "rig/shots/folders.h"

enum { PLACES_LEAST = 2, SIDE_MIN = 64, SIDE_MAX = 16384, FIT_TRACKS = 2500 };
#define PIXELS_LEFT 1.5   // of a photograph to one of the panel, along a side: more is averaged when read
#define FAR 5             // times the median
#define FOCAL_OPEN 0.1    // share of the focal length by which it may be uncertain
#define FOCAL_VAGUE 0.01  // and where that is worth a warning
#define PARALLAX 1.0      // degrees between the outermost places' rays that can be worked with
#define KNOWN_OFF 2.5     // deviations that a focal length may be off what was known
#define FOCAL_KNOWN 0.03  // deviation of a focal length that a lens or a file says
#define FULL_FRAME 43.267 // diagonal of 36 x 24, mm

static bool check(const FfpSelfCalibration *o, FfpError *err) {
    if (o->n_places == 0) return ffp_fail(err, FFP_ERROR_ARGUMENT, "places", "no photographs given");
    if (!o->folder) return ffp_fail(err, FFP_ERROR_ARGUMENT, "output", "no folder to write to");
    if (!(o->focal_35mm == 0 || (o->focal_35mm >= 5 && o->focal_35mm <= 2000)))
        return ffp_fail(err, FFP_ERROR_ARGUMENT, "focal", "%g mm is not in 5 to 2000", o->focal_35mm);
    if (!(o->length >= 0 && o->length < 1e9))
        return ffp_fail(err, FFP_ERROR_ARGUMENT, "length", "invalid length: %g", o->length);
    return o->shown ||
           (o->width >= SIDE_MIN && o->width <= SIDE_MAX && o->height >= SIDE_MIN && o->height <= SIDE_MAX) ||
           ffp_fail(err, FFP_ERROR_ARGUMENT, "projector", "a side of %d x %d is not in %d to %d pixels",
                    o->width, o->height, SIDE_MIN, SIDE_MAX);
}

// --- Reading. ---

typedef struct Reading {
    FfpTracks *tracks;
    FfpShotFolders folders;
    FfpImage *maps;   // [n]
    FfpImage *whites; // [n] as they look, [h,w,1]
    int shrink;
    double step;
} Reading;

// Errors of one place's photographs leave it out; all others end the call.
static bool leave_out(FfpCameraPlace *place, const FfpError *error, FfpError *err) {
    if (error->code == FFP_ERROR_FILE || error->code == FFP_ERROR_IO ||
        error->code == FFP_ERROR_UNSUPPORTED) {
        snprintf(place->problem, sizeof place->problem, "%s", error->text);
        return true;
    }
    if (err) *err = *error;
    return false;
}

static bool read_place(Reading *r, int index, FfpError *err) {
    const FfpShotFolder *folder = &r->folders.folders[index];
    FfpCameraPlace *place = &r->tracks->places[index];
    FfpGrayCache cache = {.n = 0}; // each photograph is read once
    FfpGrayPhotographs photographs = {.width = r->tracks->panel_width,
                                      .height = r->tracks->panel_height,
                                      .shrink = r->shrink,
                                      .cache = &cache};
    FfpGrayReport report;
    FfpError error = {0};
    int width, height;
    snprintf(place->name, sizeof place->name, "%s", folder->name);
    if (folder->problem) snprintf(place->problem, sizeof place->problem, "%s", folder->problem);
    if (place->problem[0]) return true;
    if (!ffp_photograph_read_size(&width, &height, folder->files[0], &error))
        return leave_out(place, &error, err);
    if (width != r->tracks->width || height != r->tracks->height) {
        snprintf(place->problem, sizeof place->problem,
                 "its photographs are %d x %d, those of the others %d x %d", width, height, r->tracks->width,
                 r->tracks->height);
        return true;
    }
    const bool ok = ffp_gray_find_plain(&photographs, folder->files, folder->n_files, &error) &&
                    ffp_gray_decode_view(&r->maps[index], &report, &photographs, &error);
    for (int i = 0; i < cache.n && !r->whites[index].data; i++) {
        r->whites[index] = cache.files[i].luma;
        cache.files[i].luma = (FfpImage){0};
    }
    ffp_gray_cache_free(&cache);
    if (!ok) return leave_out(place, &error, err);
    ffp_note("%s: codes read at %.0f %% of the lit pixels", place->name, 100.0 * report.decoded / report.lit);
    r->step = fmax(r->step, report.step);
    return true;
}

static bool read_sizes(Reading *r, FfpError *err) {
    FfpTracks *t = r->tracks;
    for (int i = 0; i < r->folders.n; i++)
        if (!r->folders.folders[i].problem && r->folders.folders[i].n_files > 0) {
            if (!ffp_photograph_read_size(&t->width, &t->height, r->folders.folders[i].files[0], err))
                return false;
            const double over =
                sqrt((double)t->width * t->height / ((double)t->panel_width * t->panel_height));
            for (r->shrink = 1; r->shrink < 8 && over / (2 * r->shrink) >= PIXELS_LEFT;) r->shrink *= 2;
            return true;
        }
    return ffp_fail(err, FFP_ERROR_FILE, NULL, "%s: %s", r->folders.folders[0].name,
                    r->folders.folders[0].problem);
}

static bool read_places(Reading *r, FfpError *err) {
    FfpTracks *t = r->tracks;
    const int n = r->folders.n;
    if (n > FFP_PLACES_MAX)
        return ffp_fail(err, FFP_ERROR_ARGUMENT, "places", "%d are more than %d", n, FFP_PLACES_MAX);
    t->n_places = n;
    t->places = ffp_alloc((size_t)n, sizeof *t->places);
    r->maps = ffp_alloc((size_t)n, sizeof *r->maps);
    r->whites = ffp_alloc((size_t)n, sizeof *r->whites);
    const FfpTask task = ffp_task("reading places", n);
    bool ok = read_sizes(r, err);
    for (int i = 0; ok && i < n; i++) {
        ok = read_place(r, i, err);
        ffp_task_step(&task, i + 1, t->places[i].name);
    }
    ffp_task_end(&task);
    if (ok) ffp_tracks_find(t, r->maps, r->whites, r->shrink, r->step);
    for (int i = 0; i < n; i++) ffp_image_free(&r->maps[i]), ffp_image_free(&r->whites[i]);
    ffp_free(r->maps), ffp_free(r->whites);
    return ok;
}

static bool read_all(const FfpSelfCalibration *o, FfpTracks *tracks, FfpError *err) {
    Reading r = {.tracks = tracks, .shrink = 1};
    tracks->panel_width = o->width, tracks->panel_height = o->height;
    bool ok = ffp_shot_folders_find(&r.folders, o->places, o->n_places, err) &&
              (!o->shown || ffp_shot_folders_take(&r.folders, o->shown, &tracks->panel_width,
                                                  &tracks->panel_height, err)) &&
              read_places(&r, err);
    ffp_shot_folders_free(&r.folders);
    return ok;
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
    return angle >= PARALLAX || ffp_fail(err, FFP_ERROR_FILE, NULL,
                                         "the places of the camera are too near to each other for what they "
                                         "see (%.1f degrees between their "
                                         "rays): walk 10 to 20 degrees from one to the next",
                                         angle);
}

static bool judge_focal(const FfpBundle *b, int number, const char *device, FfpError *err) {
    const double open = b->deviation[number];
    if (!(open < FOCAL_OPEN))
        return ffp_fail(
            err, FFP_ERROR_FILE, NULL,
            "the %s's focal length (%.0f pixels) is uncertain by %.0f %%: photograph from places farther "
            "apart, with things at different depths in view, or say what lens it was",
            device, exp(b->optics[number]), fmin(999, 100 * open));
    if (open > FOCAL_VAGUE)
        ffp_tell(FFP_RULE_PLACES_FOCAL, &(FfpFacts){.a = device, .figure = open, .limit = FOCAL_VAGUE});
    return true;
}

// A lens that the photographs contradict is not believed.
static void judge_known(FfpBundle *b, int stride) {
    const double off = b->optics[FFP_BUNDLE_CAMERA_FOCAL] - b->focal;
    if (!(b->focal_known > 0) || fabs(off) < KNOWN_OFF * b->focal_known) return;
    b->focal_known = 0;
    ffp_bundle_fit(b, stride, FAR, true);
    ffp_tell(FFP_RULE_LENS_DIFFERS,
             &(FfpFacts){.figure = fabs(exp(b->optics[FFP_BUNDLE_CAMERA_FOCAL] - b->focal) - 1),
                         .limit = KNOWN_OFF * FOCAL_KNOWN});
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

bool ffp_self_calibration_run(const FfpSelfCalibration *o, FfpSelfCalibrationStats *stats, FfpError *err) {
    FfpTracks tracks = {0};
    if (!check(o, err) || !ffp_cv_available(err) || !ffp_output_probe_folder(o->folder, err) ||
        !read_all(o, &tracks, err))
        return false;
    FfpBundle b = {.tracks = &tracks,
                   .places = ffp_alloc((size_t)tracks.n_places, sizeof *b.places),
                   .known = ffp_alloc((size_t)tracks.n_places, sizeof *b.known),
                   .nearness = ffp_alloc((size_t)tracks.n + 1, sizeof *b.nearness)};
    if (o->focal_35mm > 0) {
        b.focal = log(o->focal_35mm / FULL_FRAME * hypot(tracks.width, tracks.height));
        b.focal_known = FOCAL_KNOWN;
    }
    const bool ok =
        ffp_self_calibration_fit(&b, err) &&
        ffp_self_calibration_write(&b, (o->length > 0 ? o->length : 1) / first_step(&b), o->folder, err);
    if (ok && stats) fill_stats(&b, stats);
    ffp_free(b.places), ffp_free(b.known), ffp_free(b.nearness), ffp_free(b.deviation);
    ffp_tracks_free(&tracks);
    return ok;
}
