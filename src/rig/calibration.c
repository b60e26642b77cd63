#include "rig/calibration.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/arena.h"
#include "base/file.h"
#include "base/log.h"
#include "base/real.h"
#include "capture/manifest.h"
#include "rig/document.h"
#include "rig/matrix.h"

void ffp_calibration_free(FfpCalibration *calibration) {
    if (calibration == NULL) return;
    ffp_free(calibration->stops);
    ffp_free(calibration->pictures);
    *calibration = (FfpCalibration){0};
}

// --- Parts that several formats share. ---

bool ffp_field_intrinsics(const FfpField *field, double shift, FfpOptics *optics, FfpError *err) {
    double k[9];
    if (!ffp_field_matrix_of(field, 3, 3, k, err)) return false;
    if (fabs(k[3]) > 0 || fabs(k[6]) > 0 || fabs(k[7]) > 0 || fabs(k[8] - 1) > 1e-6)
        return ffp_field_fail(field, err, "is no camera matrix: rows must be fx 0 cx, 0 fy cy, 0 0 1");
    if (fabs(k[1]) > 1e-6 * fabs(k[0])) return ffp_field_fail(field, err, "skewed pixels are not modelled");
    if (!(k[0] >= 1e-3 && k[4] >= 1e-3 && k[0] <= FFP_PIXELS_MAX && k[4] <= FFP_PIXELS_MAX))
        return ffp_field_fail(field, err, "focal lengths %g, %g are not positive numbers of pixels", k[0],
                              k[4]);
    if (!(fabs(k[2]) <= FFP_PIXELS_MAX && fabs(k[5]) <= FFP_PIXELS_MAX))
        return ffp_field_fail(field, err, "principal point %g, %g is too far away", k[2], k[5]);
    optics->fx = k[0], optics->fy = k[4];
    optics->cx = k[2] + shift, optics->cy = k[5] + shift;
    return true;
}

bool ffp_field_lens(const FfpField *field, FfpOptics *optics, FfpError *err) {
    FfpMatrix lens;
    if (!ffp_field_matrix(field, &lens, err)) return false;
    const int n = lens.rows * lens.cols;
    if (lens.rows != 1 && lens.cols != 1)
        return ffp_field_fail(field, err, "must be one row or column of coefficients");
    if (n < 4) return ffp_field_fail(field, err, "%d coefficients; k1 k2 p1 p2 [k3] are needed", n);
    for (int i = 5; i < n; i++) {
        if (lens.values[i] != 0) {
            return ffp_field_fail(
                field, err,
                "%d coefficients of an unknown distortion model; k1 k2 p1 p2 k3 are removed, "
                "so calibrate without rational, thin-prism or fisheye terms",
                n);
        }
    }
    for (int i = 0; i < 5; i++) optics->lens[i] = i < n ? lens.values[i] : 0;
    return true;
}

bool ffp_settle_size(FfpOptics *optics, const FfpField *field, int width, int height, FfpError *err) {
    if (optics->width > 0 && (optics->width != width || optics->height != height)) {
        return ffp_field_fail(field, err, "%d x %d pixels, but %d x %d were given before", width, height,
                              optics->width, optics->height);
    }
    optics->width = width, optics->height = height;
    return true;
}

bool ffp_start_stops(FfpCalibration *calibration, const FfpField *field, int n, FfpError *err) {
    if (calibration->n_stops > 0) return ffp_field_fail(field, err, "views were given before");
    if (n < 1 || n > FFP_VIEWS_MAX)
        return ffp_field_fail(field, err, "%d views; 1 to %d are allowed", n, FFP_VIEWS_MAX);
    calibration->stops = ffp_alloc((size_t)n, sizeof *calibration->stops);
    calibration->n_stops = n;
    return true;
}

static bool name_stop(FfpCalibration *calibration, int stop, const FfpField *field, const char *name,
                      size_t length, FfpError *err) {
    char *id = calibration->stops[stop].id;
    const bool fits = length < FFP_NAME_MAX;
    memcpy(id, name, fits ? length : 0);
    id[fits ? length : 0] = 0;
    if (!ffp_is_name(id)) return ffp_field_fail(field, err, "'%.100s' gives no name for a view", name);
    for (int i = 0; i < stop; i++) {
        if (strcmp(calibration->stops[i].id, id) == 0)
            return ffp_field_fail(field, err, "view '%s' comes twice", id);
    }
    return true;
}

bool ffp_name_stop(FfpCalibration *calibration, int stop, const FfpField *field, const char *id,
                   FfpError *err) {
    return name_stop(calibration, stop, field, id, strlen(id), err);
}

bool ffp_name_stop_by_file(FfpCalibration *calibration, int stop, const FfpField *field, const char *path,
                           FfpError *err) {
    const char *base = ffp_basename(path), *dot = strrchr(base, '.');
    const size_t length = dot != NULL && dot != base ? (size_t)(dot - base) : strlen(base);
    return name_stop(calibration, stop, field, base, length, err);
}

void ffp_place_projector(FfpCalibration *calibration, const double p2w[16]) {
    memcpy(calibration->p2c, p2w, sizeof calibration->p2c);
    calibration->has_motion = true;
}

// --- Which format a file has. ---

static bool read_object(FfpCalibration *calibration, const FfpField *root, FfpError *err) {
    FfpField field;
    return ffp_field_find(root, "frames", &field) ? ffp_read_nepmap(calibration, root, err)
                                                  : ffp_read_opencv(calibration, root, err);
}

// GS-ProCams writes two lists; the projector's entries have no "rotation".
static bool read_list(FfpCalibration *calibration, const FfpField *root, FfpError *err) {
    FfpField first, field;
    if (!ffp_field_item(root, 0, &first, err)) return false;
    return ffp_field_find(&first, "rotation", &field) ? ffp_read_procams_cameras(calibration, root, err)
                                                      : ffp_read_procams_projector(calibration, root, err);
}

static bool read_document(FfpCalibration *calibration, const char *path, FfpError *err) {
    FfpField root, field;
    if (!ffp_document_open(&root, path, err)) return false;
    bool ok = false;
    if (json_is_array(root.value))
        ok = read_list(calibration, &root, err);
    else if (ffp_field_find(&root, "FoVx", &field)) // one projector, not in a list
        ok = ffp_read_procams_projector(calibration, &root, err);
    else
        ok = read_object(calibration, &root, err);
    ffp_field_close(&root);
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
    ffp_note("%s: sizes of camera and projector are taken from it", info);
    return read_document(calibration, info, err);
}

bool ffp_calibration_read(FfpCalibration *calibration, const char *const *files, int n_files,
                          const char *projector_image, FfpError *err) {
    *calibration = (FfpCalibration){0};
    if (n_files < 1) return ffp_fail(err, FFP_ERROR_FILE, "calibrations", "no calibration was given");
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
                        "no camera in the calibration: give the file that holds it too");
    if (!calibration->has_projector)
        return ffp_fail(err, FFP_ERROR_FILE, where,
                        "no projector in the calibration: give the file that holds it too");
    if (!calibration->has_motion)
        return ffp_fail(err, FFP_ERROR_FILE, where,
                        "the calibration does not say how camera and projector stand to each "
                        "other (rotation R and translation T): stereo-calibrate them");
    for (int i = 0; i < calibration->n_stops; i++) {
        memcpy(calibration->stops[i].p2w, calibration->p2c, sizeof calibration->p2c);
    }
    return true;
}
