// From the photographs of each place to what it sees of the panel.
#include <math.h>
#include <stdio.h>
#include "core/base/alloc.h"
#include "core/base/log.h"
#include "core/capture/node.h"
#include "core/image/photograph.h"
#include "core/numerics/rank.h"
#include "rig/findings/tell.h"
#include "rig/graycode/graycode.h"
#include "rig/optics/colmap_write.h"
#include "rig/selfcal/selfcal.h"
#include "rig/shots/folders.h"
#include "rig/shots/tags.h"
#include "rig/shots/taken.h"

#define PIXELS_LEFT 1.5 // of a photograph to one of the panel, along a side: more is averaged when read

typedef struct Reading {
    FfpTracks *tracks;
    FfpShotFolders folders;
    FfpImage *maps;   // [n]
    FfpImage *whites; // [n] as they look, [h,w,1]
    int shrink;
    bool linear;
    double step;
} Reading;

// Errors of one place's photographs leave it out; all others end the call.
static bool leave_out(FfpCameraPlace *place, const FfpError *error, FfpError *err) {
    if (error->code == FFP_ERROR_FILE || error->code == FFP_ERROR_IO ||
        error->code == FFP_ERROR_UNSUPPORTED) {
        snprintf(place->problem, sizeof place->problem, "%s", error->text);
        place->finding = error->finding;
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
                                      .others = folder->others,
                                      .linear = r->linear,
                                      .cache = &cache};
    FfpGrayReport report;
    FfpError error = {0};
    int width, height;
    snprintf(place->name, sizeof place->name, "%s", folder->name);
    if (folder->problem) snprintf(place->problem, sizeof place->problem, "%s", folder->problem);
    if (place->problem[0]) return true;
    if (!ffp_shot_folder_size(folder, &width, &height, &error)) return leave_out(place, &error, err);
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
    ffp_gray_tell_light(&report, place->name);
    ffp_gray_note_clipped(&report, place->name);
    r->step = fmax(r->step, report.step);
    return true;
}

static bool read_sizes(Reading *r, FfpError *err) {
    FfpTracks *t = r->tracks;
    for (int i = 0; i < r->folders.n; i++)
        if (!r->folders.folders[i].problem && r->folders.folders[i].n_files > 0) {
            if (!ffp_shot_folder_size(&r->folders.folders[i], &t->width, &t->height, err)) return false;
            const double over =
                sqrt((double)t->width * t->height / ((double)t->panel_width * t->panel_height));
            for (r->shrink = 1; r->shrink < 8 && over / (2 * r->shrink) >= PIXELS_LEFT;) r->shrink *= 2;
            return true;
        }
    return true; // every place has a problem
}

// Cameras and lenses by all files.
static void ask_cameras(Reading *r, bool one) {
    FfpTracks *t = r->tracks;
    double each[FFP_PLACES_MAX];
    t->focal_35mm = ffp_taken_compare(r->folders.folders, t->n_places, one, each);
    for (int i = 0; i < t->n_places; i++) t->places[i].focal_35mm = each[i];
}

// Leaves out places whose photographs are tagged differently; at the stops of a turntable the camera stands
// still, and all must be tagged alike.
static bool check_tags(Reading *r, bool turns, FfpError *err) {
    int tags[FFP_PLACES_MAX];
    bool ok = true;
    for (int i = 0; ok && i < r->folders.n; i++) {
        const FfpShotFolder *folder = &r->folders.folders[i];
        FfpError mixed = {0};
        tags[i] = ffp_tag_of(folder->files, folder->n_files, NULL, &mixed);
        ok = tags[i] > 0 || leave_out(&r->tracks->places[i], &mixed, err);
    }
    const int usual = ffp_tag_usual(tags, r->folders.n);
    for (int i = 0; ok && turns && i < r->folders.n; i++) {
        FfpError other = {0};
        if (tags[i] == 0 || tags[i] == usual) continue;
        ffp_tag_fail(r->folders.folders[i].name, tags[i], usual, NULL, &other);
        ok = leave_out(&r->tracks->places[i], &other, err);
    }
    return ok;
}

static bool read_places(Reading *r, bool one, bool turns, FfpError *err) {
    FfpTracks *t = r->tracks;
    const int n = r->folders.n;
    if (n > FFP_PLACES_MAX)
        return ffp_fail(err, FFP_ERROR_ARGUMENT, "places", "%d are more than %d", n, FFP_PLACES_MAX);
    t->n_places = n;
    t->places = ffp_alloc((size_t)n, sizeof *t->places);
    r->maps = ffp_alloc((size_t)n, sizeof *r->maps);
    r->whites = ffp_alloc((size_t)n, sizeof *r->whites);
    ask_cameras(r, one);
    const FfpTask task = ffp_task("reading places", n);
    bool ok = read_sizes(r, err) && check_tags(r, turns, err);
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

// Places of a walk become names of pictures and views; calib.jpg among them is the projector.
static bool check_names(const FfpShotFolders *folders, FfpError *err) {
    for (int i = 0; i < folders->n; i++) {
        const char *name = folders->folders[i].name;
        if (!ffp_is_name(name))
            return ffp_fail(
                err, FFP_ERROR_FILE, folders->folders[i].files[0],
                "rename the folder: no view can be called so (up to %d bytes of UTF-8 without \\)",
                FFP_NAME_MAX - 1);
        if (ffp_colmap_is_called(name, FFP_COLMAP_PROJECTOR))
            return ffp_fail(err, FFP_ERROR_FILE, folders->folders[i].files[0],
                            "rename the folder: the projector is called '%s' in the result",
                            FFP_COLMAP_PROJECTOR);
    }
    return true;
}

bool ffp_places_read(const FfpSelfCalibration *o, FfpTracks *tracks, FfpError *err) {
    Reading r = {.tracks = tracks, .shrink = 1, .linear = o->linear};
    tracks->panel_width = o->width, tracks->panel_height = o->height;
    bool ok = ffp_shot_folders_find(&r.folders, o->places, o->n_places, err) &&
              (o->n_angles > 0 || check_names(&r.folders, err)) &&
              (!o->shown || ffp_shot_folders_select_codes(&r.folders, o->shown, &tracks->panel_width,
                                                          &tracks->panel_height, err)) &&
              read_places(&r, !o->camera_per_folder, o->n_angles > 0, err);
    ffp_shot_folders_free(&r.folders);
    return ok;
}
