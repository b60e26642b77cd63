// OpenCV FileStorage calibrations and DeProCams' params.yml: the same matrices under the names of many tools.
// Their motion takes camera coordinates to projector coordinates, X_p = R X_c + T, and their pixel centres
// lie at integers.
#include <stdio.h>
#include <string.h>
#include "core/base/log.h"
#include "rig/optics/by_shape.h"
#include "rig/optics/calibration.h"
#include "rig/optics/matrix.h"

#define CENTRE 0.5

static const char *const camera_keys[] = {"cam_int", "camK", "cam_K", "camIntrinsics", "cam1_intrinsics",
                                          "Kc",      "M1",   "K1",    "cameraMatrix1", NULL};
static const char *const camera_lens_keys[] = {
    "cam_dist",        "camKc", "cam_kc", "camDistCoeffs", "cam1_distorsion",
    "cam1_distortion", "kc",    "D1",     "distCoeffs1",   NULL};
static const char *const projector_keys[] = {"proj_int",        "prjK", "proj_K", "projIntrinsics",
                                             "cam2_intrinsics", "Kp",   "M2",     "K2",
                                             "cameraMatrix2",   NULL};
static const char *const projector_lens_keys[] = {
    "proj_dist",       "prjKc", "proj_kc", "projDistCoeffs", "cam2_distorsion",
    "cam2_distortion", "kp",    "D2",      "distCoeffs2",    NULL};
// "roration" is what kamino410/procam-calibration writes.
// Of files of one device.
static const char *const single_keys[] = {"camera_matrix", "Camera_Matrix", "cameraMatrix", "mtx", "K", NULL};
static const char *const single_lens_keys[] = {
    "distortion_coefficients", "Distortion_Coefficients", "distCoeffs", "dist_coeff", "dist", "D", NULL};
static const char *const rotation_keys[] = {"rotation", "roration", "R", "Rp", NULL};
static const char *const translation_keys[] = {"translation", "T", "Tp", NULL};

// The first of the keys that exists. A second one is an error: which is meant?
static bool find_one(const FfpNode *root, const char *const *keys, FfpNode *out, bool *found, FfpError *err) {
    *found = false;
    for (int i = 0; keys[i] != NULL; i++) {
        FfpNode field;
        if (!ffp_node_find(root, keys[i], &field)) continue;
        if (*found) return ffp_node_fail(&field, err, "means the same as %s: keep only one", out->place);
        *out = field;
        *found = true;
    }
    return true;
}

static bool has_key(const FfpNode *root, const char *const *keys) {
    FfpNode field;
    while (*keys && !ffp_node_find(root, *keys, &field)) keys++;
    return *keys != NULL;
}

static bool read_device(const FfpNode *root, const char *const *keys, const char *const *lens_keys,
                        FfpOptics *optics, bool *has, FfpError *err) {
    FfpNode matrix, lens;
    bool found = false, distorted = false;
    if (!find_one(root, keys, &matrix, &found, err) || !find_one(root, lens_keys, &lens, &distorted, err))
        return false;
    if (!found) return !distorted || ffp_node_fail(&lens, err, "lens coefficients without a camera matrix");
    if (*has) return ffp_node_fail(&matrix, err, "was already given by another file");
    *has = true;
    return ffp_node_intrinsics(&matrix, CENTRE, optics, err) &&
           (!distorted || ffp_node_lens(&lens, optics, err));
}

// DeProCams' camRT and prjRT: rows of [R | T], world to device, with or without a fourth row.
static bool read_rows(const FfpNode *field, double pose[16], FfpError *err) {
    FfpMatrix m;
    if (!ffp_node_matrix(field, &m, err)) return false;
    if (m.cols != 4 || (m.rows != 3 && m.rows != 4))
        return ffp_node_fail(field, err, "matrix has %d x %d numbers, expected 3 x 4 or 4 x 4", m.rows,
                             m.cols);
    double r[9], t[3];
    for (int i = 0; i < 12; i++) *(i % 4 < 3 ? &r[3 * (i / 4) + i % 4] : &t[i / 4]) = m.values[i];
    return ffp_pose_from_rotation(field, r, t, pose, err);
}

static bool read_motion_of(FfpCalibration *calibration, const FfpNode *root, const char *const *rotations,
                           const char *const *translations, FfpError *err) {
    FfpNode rotation, translation, camera, projector;
    bool turns = false, moves = false;
    double c2p[16];
    if (!find_one(root, rotations, &rotation, &turns, err) ||
        !find_one(root, translations, &translation, &moves, err)) {
        return false;
    }
    if (ffp_node_find(root, "prjRT", &projector)) {
        double world_to_camera[16], world_to_projector[16], c2w[16];
        if (!ffp_node_get(root, "camRT", &camera, err) || !read_rows(&camera, world_to_camera, err) ||
            !read_rows(&projector, world_to_projector, err)) {
            return false;
        }
        ffp_pose_inverse(world_to_camera, c2w);
        ffp_pose_product(world_to_projector, c2w, c2p);
        rotation = projector;
    } else {
        double r[9], t[3];
        if (!turns && !moves) return true;
        if (!turns) return ffp_node_fail(&translation, err, "a translation without a rotation");
        if (!moves) return ffp_node_fail(&rotation, err, "a rotation without a translation");
        if (!ffp_node_matrix_of(&rotation, 3, 3, r, err) || !ffp_node_matrix_of(&translation, 3, 1, t, err) ||
            !ffp_pose_from_rotation(&rotation, r, t, c2p, err)) {
            return false;
        }
    }
    if (calibration->has_projector_pose)
        return ffp_node_fail(&rotation, err, "was already given by another file");
    calibration->has_projector_pose = true;
    ffp_pose_inverse(c2p, calibration->p2c);
    return true;
}

static bool read_motion(FfpCalibration *calibration, const FfpNode *root, FfpError *err) {
    return read_motion_of(calibration, root, rotation_keys, translation_keys, err);
}

// kamino410's img_shape: the camera's height and width.
static bool read_shape(FfpCalibration *calibration, const FfpNode *root, FfpError *err) {
    FfpNode field;
    double shape[2];
    if (!ffp_node_find(root, "img_shape", &field)) return true;
    if (!ffp_node_matrix_of(&field, 2, 1, shape, err)) return false;
    for (int i = 0; i < 2; i++) {
        if (!(shape[i] >= 1 && shape[i] <= FFP_IMAGE_SIDE_MAX) || shape[i] != (int)shape[i])
            return ffp_node_fail(&field, err, "invalid size %g: expected 1 to %d pixels", shape[i],
                                 FFP_IMAGE_SIDE_MAX);
    }
    return ffp_settle_size(&calibration->camera, &field, (int)shape[1], (int)shape[0], err);
}

// kamino410's camera_config.json: {"camera": {P, distortion, width, height}}.
static bool read_camera_config(FfpCalibration *calibration, const FfpNode *camera, FfpError *err) {
    FfpNode field;
    int width = 0, height = 0;
    if (!ffp_node_get(camera, "P", &field, err)) return false;
    if (calibration->has_camera) return ffp_node_fail(&field, err, "was already given by another file");
    calibration->has_camera = true;
    return ffp_node_intrinsics(&field, CENTRE, &calibration->camera, err) &&
           ffp_node_get(camera, "distortion", &field, err) &&
           ffp_node_lens(&field, &calibration->camera, err) &&
           ffp_get_whole(camera, "width", 1, FFP_IMAGE_SIDE_MAX, &width, err) &&
           ffp_get_whole(camera, "height", 1, FFP_IMAGE_SIDE_MAX, &height, err) &&
           ffp_settle_size(&calibration->camera, camera, width, height, err);
}

// `ffprocams calibrate`: standard deviations of fx fy cx cy k1 k2 p1 p2 k3.
static bool read_deviations(FfpCalibration *calibration, const FfpNode *root, FfpError *err) {
    FfpNode field;
    double deviations[9];
    if (!ffp_node_find(root, "cam_deviations", &field)) return true;
    if (!ffp_node_matrix_of(&field, 1, 9, deviations, err)) return false;
    for (int i = 0; i < 4; i++) {
        if (!(deviations[i] >= 0 && deviations[i] <= FFP_IMAGE_SIDE_MAX))
            return ffp_node_fail(&field, err, "invalid standard deviation %g", deviations[i]);
        calibration->camera_deviation[i] = deviations[i];
    }
    return true;
}

// single-shot's calib-info.yml, SLStudio's calibration.xml, or any file with these keys.
static bool read_sizes(FfpCalibration *calibration, const FfpNode *root, bool *found, FfpError *err) {
    static const char *const keys[4][2] = {
        {"camW", "camH"}, {"prjW", "prjH"}, {"frameWidth", "frameHeight"}, {"screenResX", "screenResY"}};
    FfpOptics *const devices[4] = {&calibration->camera, &calibration->projector, &calibration->camera,
                                   &calibration->projector};
    for (int i = 0; i < 4; i++) {
        FfpNode field;
        int width = 0, height = 0;
        if (!ffp_node_find(root, keys[i][0], &field)) continue;
        *found = true;
        if (!ffp_get_whole(root, keys[i][0], 1, FFP_IMAGE_SIDE_MAX, &width, err) ||
            !ffp_get_whole(root, keys[i][1], 1, FFP_IMAGE_SIDE_MAX, &height, err) ||
            !ffp_settle_size(devices[i], &field, width, height, err)) {
            return false;
        }
    }
    return true;
}

// The device that is meant by a file of one: by its name, otherwise the first is the camera.
static bool take_device(FfpCalibration *calibration, const FfpNode *root, const FfpNode *matrix,
                        FfpOptics **optics, FfpError *err) {
    FfpNode name;
    const bool named = ffp_node_find(root, "camera_name", &name) && json_is_string(name.value);
    const bool projector = named && strstr(json_string_value(name.value), "proj");
    bool *const has =
        projector || calibration->has_camera ? &calibration->has_projector : &calibration->has_camera;
    *optics = has == &calibration->has_camera ? &calibration->camera : &calibration->projector;
    if (*has) return ffp_node_fail(matrix, err, "was already given by another file");
    return *has = true;
}

// ROS' and Kalibr's names of what lens coefficients mean.
static bool check_models(const FfpNode *device, FfpError *err) {
    static const char *const keys[2] = {"camera_model", "distortion_model"},
                             *const read[2] = {" pinhole ", " radtan plumb_bob rational_polynomial none "};
    FfpNode field;
    for (int i = 0; i < 2; i++) {
        char name[64] = "";
        if (!ffp_node_find(device, keys[i], &field)) continue;
        if (json_is_string(field.value))
            snprintf(name, sizeof name, " %.60s ", json_string_value(field.value));
        if (!name[0] || !strstr(read[i], name))
            return ffp_node_fail(
                &field, err,
                "the model%sis not removed: calibrate a pinhole with radtan (plumb_bob), k1 k2 "
                "p1 p2 and k3",
                name[0] ? name : " ");
    }
    return true;
}

// ROS' camera_info and OpenCV's calibration sample: a file for each device, without their motion.
static bool read_single(FfpCalibration *calibration, const FfpNode *root, const FfpNode *matrix,
                        FfpError *err) {
    FfpNode lens, field;
    FfpOptics *optics;
    bool distorted = false;
    int width = 0, height = 0;
    if (!check_models(root, err) || !take_device(calibration, root, matrix, &optics, err) ||
        !ffp_node_intrinsics(matrix, CENTRE, optics, err) ||
        !find_one(root, single_lens_keys, &lens, &distorted, err) ||
        (distorted && !ffp_node_lens(&lens, optics, err)))
        return false;
    if (!ffp_node_find(root, "image_width", &field)) return read_motion(calibration, root, err);
    return ffp_get_whole(root, "image_width", 1, FFP_IMAGE_SIDE_MAX, &width, err) &&
           ffp_get_whole(root, "image_height", 1, FFP_IMAGE_SIDE_MAX, &height, err) &&
           ffp_settle_size(optics, &field, width, height, err) && read_motion(calibration, root, err);
}

// A camera of Kalibr's chain: fx fy cx cy; k1 k2 p1 p2.
static bool read_kalibr_device(const FfpNode *device, FfpOptics *optics, FfpError *err) {
    FfpNode field;
    double numbers[4], size[2];
    if (!check_models(device, err) || !ffp_node_get(device, "intrinsics", &field, err) ||
        !ffp_node_matrix_of(&field, 1, 4, numbers, err))
        return false;
    const double k[9] = {numbers[0], 0, numbers[2], 0, numbers[1], numbers[3], 0, 0, 1};
    json_t *matrix = json_array();
    for (int i = 0; i < 3; i++)
        json_array_append_new(matrix, json_pack("[fff]", k[3 * i], k[3 * i + 1], k[3 * i + 2]));
    FfpNode made = field;
    made.value = matrix;
    const bool ok = ffp_node_intrinsics(&made, CENTRE, optics, err);
    json_decref(matrix);
    if (!ok) return false;
    if (ffp_node_find(device, "distortion_coeffs", &field) && !ffp_node_lens(&field, optics, err))
        return false;
    if (!ffp_node_find(device, "resolution", &field)) return true;
    return ffp_node_matrix_of(&field, 1, 2, size, err) &&
           ((size[0] >= 1 && size[1] >= 1 && size[0] <= FFP_IMAGE_SIDE_MAX &&
             size[1] <= FFP_IMAGE_SIDE_MAX) ||
            ffp_node_fail(&field, err, "invalid size")) &&
           ffp_settle_size(optics, &field, (int)size[0], (int)size[1], err);
}

// Kalibr's camchain.yaml: cam0 is the camera, cam1 the projector; T_cn_cnm1 takes coordinates of the one to
// those of the other.
bool ffp_read_kalibr(FfpCalibration *calibration, const FfpNode *root, FfpError *err) {
    FfpNode camera, projector, motion;
    double c2p[16];
    if (calibration->has_camera || calibration->has_projector)
        return ffp_node_fail(root, err, "camera or projector were already given by another file");
    if (!ffp_node_find(root, "cam1", &projector))
        return ffp_node_fail(root, err, "holds one camera: the projector must be the second, cam1");
    if (!ffp_node_get(root, "cam0", &camera, err) ||
        !read_kalibr_device(&camera, &calibration->camera, err) ||
        !read_kalibr_device(&projector, &calibration->projector, err) ||
        !ffp_node_get(&projector, "T_cn_cnm1", &motion, err) || !read_rows(&motion, c2p, err))
        return false;
    calibration->has_camera = calibration->has_projector = calibration->has_projector_pose = true;
    ffp_pose_inverse(c2p, calibration->p2c);
    return true;
}

static bool read_shaped_device(const FfpNode *root, const char *const keys[FFP_SHAPES], FfpOptics *optics,
                               bool *has, FfpError *err) {
    const char *const matrix[2] = {keys[FFP_SHAPE_MATRIX], NULL}, *const lens[2] = {keys[FFP_SHAPE_LENS],
                                                                                    NULL};
    FfpNode field;
    double size[2];
    if (!read_device(root, matrix, lens, optics, has, err)) return false;
    if (!keys[FFP_SHAPE_SIZE] || !ffp_node_find(root, keys[FFP_SHAPE_SIZE], &field)) return true;
    if (!ffp_node_matrix_of(&field, 2, 1, size, err)) return false;
    if (size[0] > FFP_IMAGE_SIDE_MAX || size[1] > FFP_IMAGE_SIDE_MAX)
        return ffp_node_fail(&field, err, "invalid size: expected 1 to %d pixels", FFP_IMAGE_SIDE_MAX);
    return ffp_settle_size(optics, &field, (int)size[0], (int)size[1], err);
}

// Other tools' keys, by what they hold. Sizes are width, height.
static bool read_by_shape(FfpCalibration *calibration, const FfpNode *root, const FfpShapedKeys *keys,
                          FfpError *err) {
    const char *const rotations[2] = {keys->rotation, NULL}, *const translations[2] = {keys->translation,
                                                                                       NULL};
    if (!read_shaped_device(root, keys->device[0], &calibration->camera, &calibration->has_camera, err) ||
        !read_shaped_device(root, keys->device[1], &calibration->projector, &calibration->has_projector,
                            err) ||
        !read_motion_of(calibration, root, rotations, translations, err))
        return false;
    ffp_note("%s: keys of an unknown tool, taken for what they hold: %s the camera's, %s the projector's, %s "
             "and %s "
             "from the camera to the projector",
             root->file, keys->device[0][FFP_SHAPE_MATRIX], keys->device[1][FFP_SHAPE_MATRIX],
             keys->rotation ? keys->rotation : "no rotation",
             keys->translation ? keys->translation : "no translation");
    return true;
}

// "a, b and c": what the file has at its root.
static const char *list_keys(const FfpNode *root, char *out, size_t size) {
    const char *key;
    json_t *value;
    size_t length = 0;
    out[0] = 0;
    json_object_foreach(root->value, key, value) {
        if (length + 1 < size)
            length += (size_t)snprintf(out + length, size - length, "%s%.40s", length ? ", " : "", key);
    }
    return out;
}

bool ffp_read_opencv(FfpCalibration *calibration, const FfpNode *root, FfpError *err) {
    FfpNode camera;
    FfpShapedKeys shaped;
    char keys[200];
    bool single = false;
    const bool before[3] = {calibration->has_camera, calibration->has_projector,
                            calibration->has_projector_pose};
    bool told = false;
    if (!find_one(root, single_keys, &camera, &single, err)) return false;
    if (single) return read_single(calibration, root, &camera, err);
    if (ffp_node_find(root, "camera", &camera)) return read_camera_config(calibration, &camera, err);
    const bool known = has_key(root, camera_keys) && has_key(root, projector_keys);
    if (!known && ffp_keys_by_shape(root, &shaped)) return read_by_shape(calibration, root, &shaped, err);
    if (!read_sizes(calibration, root, &told, err) ||
        !read_device(root, camera_keys, camera_lens_keys, &calibration->camera, &calibration->has_camera,
                     err) ||
        !read_device(root, projector_keys, projector_lens_keys, &calibration->projector,
                     &calibration->has_projector, err) ||
        !read_motion(calibration, root, err) || !read_shape(calibration, root, err) ||
        !read_deviations(calibration, root, err)) {
        return false;
    }
    told = told || before[0] != calibration->has_camera || before[1] != calibration->has_projector ||
           before[2] != calibration->has_projector_pose;
    return told ||
           ffp_node_fail(root, err,
                         "%s: none of the keys of a known calibration tool; write the matrices as camK, prjK "
                         "(3 x 3), camKc, prjKc (k1 k2 p1 p2 k3), R and T (from camera to projector)",
                         list_keys(root, keys, sizeof keys));
}
