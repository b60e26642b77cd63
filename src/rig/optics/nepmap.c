// nepmap's transforms.json: one frame a picture, Blender or OpenCV poses, one projector fixed in the world.
// Frames of one pose are one view. Blender's principal points count from the image's corner, as ours.
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include "core/base/arena.h"
#include "core/base/file.h"
#include "rig/optics/calibration.h"
#include "rig/optics/matrix.h"

#define CENTRE 0.0
#define FRAMES_MAX 8192
#define SAME_POSE 1e-5 // of every number of two matrices

// A pose under `key`, or under `blender_key` in Blender's axes.
static bool read_pose(const FfpNode *parent, const char *key, const char *blender_key, double pose[16],
                      FfpError *err) {
    FfpNode field;
    const bool plain = key && ffp_node_find(parent, key, &field);
    real checked[16];
    if (!plain && !ffp_node_get(parent, blender_key, &field, err)) return false;
    if (!ffp_node_pose(&field, !plain, checked, err)) return false;
    for (int i = 0; i < 16; i++) pose[i] = (double)checked[i];
    return true;
}

static int find_stop(const FfpCalibration *calibration, const double pose[16]) {
    for (int i = 0; i < calibration->n_stops; i++) {
        bool same = true;
        for (int k = 0; k < 12 && same; k++)
            same = fabs(calibration->stops[i].c2w[k] - pose[k]) <= SAME_POSE * (1 + fabs(pose[k]));
        if (same) return i;
    }
    return -1;
}

// A picture's file is looked for below the JSON's folder, then there under its base name.
static bool find_picture(const FfpNode *file, const char *folder, char path[FFP_PATH_MAX], FfpError *err) {
    static const char *const endings[2] = {"", ".png"};
    const char *name = NULL;
    if (!ffp_node_text(file, &name, err)) return false;
    const char *const names[2] = {ffp_is_inner_path(name) ? name : ffp_basename(name), ffp_basename(name)};
    for (int i = 0; i < 4; i++) {
        char full[FFP_PATH_MAX];
        if ((size_t)snprintf(full, sizeof full, "%s%s", names[i / 2], endings[i % 2]) < sizeof full &&
            ffp_is_inner_path(full) && ffp_join_path(path, folder, full) && ffp_is_file(path)) {
            return true;
        }
    }
    return ffp_node_fail(file, err, "no such file '%.200s'", name);
}

static bool add_pictures(FfpCalibration *calibration, const FfpNode *frame, int stop, const char *folder,
                         FfpError *err) {
    FfpNode list, name, file;
    int n = 0;
    if (!ffp_node_find(frame, "patterns", &list)) return true;
    if (!ffp_node_count(&list, 0, 1, &n, err) || n == 0) return n == 0;
    FfpNamedPicture *picture = &calibration->pictures[calibration->n_pictures];
    picture->stop = stop;
    if (!ffp_node_item(&list, 0, &name, err) || !ffp_node_name(&name, picture->pattern, err) ||
        !ffp_node_get(frame, "file_path", &file, err) || !find_picture(&file, folder, picture->path, err)) {
        return false;
    }
    for (int i = 0; i < calibration->n_pictures; i++) {
        const FfpNamedPicture *other = &calibration->pictures[i];
        if (other->stop == stop && strcmp(other->pattern, picture->pattern) == 0) return true; // seen again
    }
    calibration->n_pictures++;
    return true;
}

static bool read_frame(FfpCalibration *calibration, const FfpNode *frame, const FfpOptics *camera,
                       const char *folder, FfpError *err) {
    double c2w[16];
    if (!read_pose(frame, "RT", "blender_matrix_world", c2w, err)) return false;
    int stop = find_stop(calibration, c2w);
    if (stop < 0) {
        FfpNode field;
        if (calibration->n_stops == FFP_VIEWS_MAX)
            return ffp_node_fail(frame, err, "more than %d camera poses", FFP_VIEWS_MAX);
        stop = calibration->n_stops++;
        FfpStop *to = &calibration->stops[stop];
        to->camera = *camera;
        memcpy(to->c2w, c2w, sizeof to->c2w);
        const char *name = NULL;
        const bool called = ffp_node_find(frame, "view_id", &field);
        if (!ffp_node_get(frame, called ? "view_id" : "file_path", &field, err) ||
            !ffp_node_text(&field, &name, err) ||
            !(called ? ffp_name_stop : ffp_name_stop_by_file)(calibration, stop, &field, name, err)) {
            return false;
        }
    }
    return add_pictures(calibration, frame, stop, folder, err);
}

// Sizes are in the file when other tools wrote it (w, h); nepmap's own pictures tell them.
static bool read_size(const FfpNode *root, FfpOptics *camera, FfpError *err) {
    FfpNode field;
    if (!ffp_node_find(root, "w", &field) && !ffp_node_find(root, "h", &field)) return true;
    return ffp_get_whole(root, "w", 1, FFP_IMAGE_SIDE_MAX, &camera->width, err) &&
           ffp_get_whole(root, "h", 1, FFP_IMAGE_SIDE_MAX, &camera->height, err);
}

static void folder_of(const char *file, char folder[FFP_PATH_MAX]) {
    const char *base = ffp_basename(file);
    snprintf(folder, FFP_PATH_MAX, "%.*s", (int)(base - file), file);
    if (folder[0] == 0) snprintf(folder, FFP_PATH_MAX, ".");
}

bool ffp_read_nepmap(FfpCalibration *calibration, const FfpNode *root, FfpError *err) {
    FfpNode frames, field;
    FfpOptics camera = {0};
    double p2w[16];
    char folder[FFP_PATH_MAX];
    int n = 0;
    folder_of(root->file, folder);
    if (!ffp_node_get(root, "frames", &frames, err) || !ffp_node_count(&frames, 1, FRAMES_MAX, &n, err) ||
        !ffp_calibration_new_stops(calibration, &frames, FFP_VIEWS_MAX, err)) {
        return false;
    }
    calibration->n_stops = 0; // so far: there is room for all
    if (calibration->has_projector)
        return ffp_node_fail(root, err, "the projector was already given by another file");
    if (!ffp_node_get(root, "K_cam", &field, err) || !ffp_node_intrinsics(&field, CENTRE, &camera, err) ||
        !read_size(root, &camera, err) || !ffp_node_get(root, "K_proj", &field, err) ||
        !ffp_node_intrinsics(&field, CENTRE, &calibration->projector, err) ||
        !read_pose(root, NULL, "blender_matrix_world_proj", p2w, err)) {
        return false;
    }
    calibration->pictures = ffp_alloc((size_t)n, sizeof *calibration->pictures);
    for (int i = 0; i < n; i++) {
        if (!ffp_node_item(&frames, i, &field, err) ||
            !read_frame(calibration, &field, &camera, folder, err)) {
            return false;
        }
    }
    ffp_place_projector(calibration, p2w);
    calibration->has_projector = true;
    if (!ffp_join_path(calibration->pattern_folder, folder, "projector"))
        return ffp_fail(err, FFP_ERROR_FILE, folder, "the path is too long");
    return true;
}
