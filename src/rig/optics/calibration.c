#include "rig/optics/calibration.h"
#include <string.h>
#include "core/base/arena.h"
#include "core/base/file.h"
#include "core/base/log.h"
#include "rig/optics/colmap_write.h"
#include "rig/optics/document.h"

void ffp_calibration_pose_views(const FfpCalibration *calibration, FfpCapture *capture) {
    for (int v = 0; v < capture->n_views; v++) {
        const FfpStop *stop = &calibration->stops[v];
        for (int i = 0; i < 16; i++) {
            capture->views[v].camera.pose[i] = (real)stop->c2w[i];
            capture->views[v].projector.pose[i] = (real)stop->p2w[i];
        }
    }
}

void ffp_calibration_free(FfpCalibration *calibration) {
    if (!calibration) return;
    ffp_free(calibration->stops);
    ffp_free(calibration->pictures);
    *calibration = (FfpCalibration){0};
}

static bool read_object(FfpCalibration *calibration, const FfpNode *root, FfpError *err) {
    FfpNode field;
    if (ffp_node_find(root, "frames", &field)) return ffp_read_nepmap(calibration, root, err);
    if (ffp_node_find(root, "cam0", &field)) return ffp_read_kalibr(calibration, root, err);
    return ffp_read_opencv(calibration, root, err);
}

// GS-ProCams writes two lists; the projector's entries have no "rotation".
static bool read_list(FfpCalibration *calibration, const FfpNode *root, FfpError *err) {
    FfpNode first, field;
    if (!ffp_node_item(root, 0, &first, err)) return false;
    return ffp_node_find(&first, "rotation", &field) ? ffp_read_procams_cameras(calibration, root, err)
                                                     : ffp_read_procams_projector(calibration, root, err);
}

static bool read_document(FfpCalibration *calibration, const char *path, FfpError *err) {
    FfpNode root, field;
    if (!ffp_document_open(&root, path, err)) return false;
    bool ok = false;
    if (json_is_array(root.value))
        ok = read_list(calibration, &root, err);
    else if (ffp_node_find(&root, "FoVx", &field)) // one projector, not in a list
        ok = ffp_read_procams_projector(calibration, &root, err);
    else
        ok = read_object(calibration, &root, err);
    ffp_node_close(&root);
    return ok;
}

// COLMAP: the folder of the model, the folder above "sparse/0", or a file of the model.
static bool colmap_folder(const char *path, char folder[FFP_PATH_MAX]) {
    static const char *const inner[2] = {".", "sparse/0"};
    const char *base = ffp_basename(path);
    if (strcmp(base, "cameras.txt") == 0 || strcmp(base, "images.txt") == 0) {
        snprintf(folder, FFP_PATH_MAX, "%.*s", (int)(base - path), path);
        if (folder[0] == 0) snprintf(folder, FFP_PATH_MAX, ".");
        return true;
    }
    for (int i = 0; i < 2 && ffp_is_folder(path); i++) {
        char file[FFP_PATH_MAX];
        if (!ffp_join_path(folder, path, inner[i]) || !ffp_join_path(file, folder, "cameras.txt"))
            return false;
        if (ffp_is_file(file)) return true;
    }
    return false;
}

static bool read_one(FfpCalibration *calibration, const char *path, const char *projector_image,
                     FfpError *err) {
    char folder[FFP_PATH_MAX];
    if (strlen(path) >= FFP_PATH_MAX)
        return ffp_fail(err, FFP_ERROR_FILE, "calibrations", "a path is too long");
    if (colmap_folder(path, folder)) return ffp_read_colmap(calibration, folder, projector_image, err);
    if (ffp_is_folder(path))
        return ffp_fail(err, FFP_ERROR_FILE, path,
                        "the folder holds no cameras.txt (COLMAP's text form; from .bin: colmap "
                        "model_converter --output_type TXT)");
    return read_document(calibration, path, err);
}

// single-shot-pro-cam-calib writes the sizes into a file of its own beside the calibration.
static bool read_neighbour(FfpCalibration *calibration, const char *path, FfpError *err) {
    char folder[FFP_PATH_MAX], info[FFP_PATH_MAX];
    const char *base = ffp_basename(path);
    if (calibration->camera.width > 0 && calibration->projector.width > 0) return true;
    snprintf(folder, sizeof folder, "%.*s", (int)(base - path), path);
    if (!ffp_join_path(info, folder[0] != 0 ? folder : ".", "calib-info.yml") || !ffp_is_file(info))
        return true;
    ffp_note("%s: sizes of camera and projector taken from this file", info);
    return read_document(calibration, info, err);
}

bool ffp_calibration_read(FfpCalibration *calibration, const char *const *files, int n_files,
                          const char *projector_image, FfpError *err) {
    *calibration = (FfpCalibration){0};
    if (!projector_image) projector_image = FFP_COLMAP_PROJECTOR;
    if (n_files < 1) return ffp_fail(err, FFP_ERROR_FILE, "calibrations", "no calibration given");
    for (int i = 0; i < n_files; i++) {
        if (!read_one(calibration, files[i], projector_image, err)) return false;
    }
    if (n_files == 1 && calibration->n_stops == 0 && !ffp_is_folder(files[0]) &&
        !read_neighbour(calibration, files[0], err)) {
        return false;
    }
    const char *where = files[n_files - 1];
    if (!calibration->has_camera && calibration->n_stops == 0)
        return ffp_fail(err, FFP_ERROR_FILE, where,
                        "no camera in the calibration: also give the file that contains it");
    if (!calibration->has_projector)
        return ffp_fail(err, FFP_ERROR_FILE, where,
                        "no projector in the calibration: also give the file that contains it");
    if (!calibration->has_projector_pose)
        return ffp_fail(err, FFP_ERROR_FILE, where,
                        "the calibration does not relate camera and projector to each "
                        "other (rotation R and translation T): stereo-calibrate them, and give the file that "
                        "has R and T, too");
    for (int i = 0; i < calibration->n_stops; i++) {
        memcpy(calibration->stops[i].p2w, calibration->p2c, sizeof calibration->p2c);
    }
    return true;
}
