// The export of GS-ProCams: cameras.json, a list of cameras with their centre and their rotation to the
// world, and projector.json, whose R is the transpose of the rotation from the world and whose T is the
// translation from the world. Both come from COLMAP: pixel centres at integer + 0.5.
#include <stdio.h>
#include <string.h>
#include "rig/optics/calibration.h"
#include "rig/optics/matrix.h"

#define CENTRE 0.0

static bool read_optics(const FfpNode *entry, FfpOptics *optics, FfpError *err) {
    FfpNode k;
    return ffp_get_whole(entry, "width", 1, FFP_IMAGE_SIDE_MAX, &optics->width, err) &&
           ffp_get_whole(entry, "height", 1, FFP_IMAGE_SIDE_MAX, &optics->height, err) &&
           ffp_node_get(entry, "K", &k, err) && ffp_node_intrinsics(&k, CENTRE, optics, err);
}

// view_id and img_name: a number or a text; the view is called by the first that exists.
static bool read_name(FfpCalibration *calibration, int stop, const FfpNode *entry, FfpError *err) {
    enum { IMAGE = 1 };
    static const char *const keys[3] = {"view_id", [IMAGE] = "img_name", "id"};
    FfpNode field = *entry;
    char number[32];
    const char *text = number;
    int i = 0;
    while (i < 3 && !ffp_node_find(entry, keys[i], &field)) i++;
    if (i == 3) return ffp_node_get(entry, keys[0], &field, err);
    if (json_is_number(field.value)) {
        int whole = 0;
        if (!ffp_node_integer(&field, 0, 1000000000, &whole, err)) return false;
        snprintf(number, sizeof number, "%02d", whole); // as the folders of the views are called
    } else if (!ffp_node_text(&field, &text, err)) {
        return false;
    }
    return (i == IMAGE ? ffp_name_stop_by_file : ffp_name_stop)(calibration, stop, &field, text, err);
}

static bool read_camera(FfpCalibration *calibration, int stop, const FfpNode *entry, FfpError *err) {
    FfpStop *to = &calibration->stops[stop];
    FfpNode rotation, position;
    double r[9], t[3];
    return read_name(calibration, stop, entry, err) && read_optics(entry, &to->camera, err) &&
           ffp_node_get(entry, "rotation", &rotation, err) && ffp_node_matrix_of(&rotation, 3, 3, r, err) &&
           ffp_node_get(entry, "position", &position, err) && ffp_node_matrix_of(&position, 3, 1, t, err) &&
           ffp_pose_from_rotation(&rotation, r, t, to->c2w, err);
}

bool ffp_read_procams_cameras(FfpCalibration *calibration, const FfpNode *root, FfpError *err) {
    int n = 0;
    if (!ffp_node_count(root, 1, FFP_VIEWS_MAX, &n, err) ||
        !ffp_calibration_new_stops(calibration, root, n, err))
        return false;
    for (int i = 0; i < n; i++) {
        FfpNode entry;
        if (!ffp_node_item(root, i, &entry, err) || !read_camera(calibration, i, &entry, err)) return false;
    }
    return true;
}

bool ffp_read_procams_projector(FfpCalibration *calibration, const FfpNode *root, FfpError *err) {
    FfpNode entry = *root, rotation, translation;
    double r[9], t[3], p2w[16];
    int n = 1;
    if (json_is_array(root->value) &&
        (!ffp_node_count(root, 1, 1, &n, err) || !ffp_node_item(root, 0, &entry, err))) {
        return false;
    }
    if (calibration->has_projector)
        return ffp_node_fail(&entry, err, "the projector was already given by another file");
    if (!ffp_node_get(&entry, "R", &rotation, err) || !ffp_node_matrix_of(&rotation, 3, 3, r, err) ||
        !ffp_node_get(&entry, "T", &translation, err) || !ffp_node_matrix_of(&translation, 3, 1, t, err) ||
        !read_optics(&entry, &calibration->projector, err)) {
        return false;
    }
    double centre[3];
    for (int i = 0; i < 3; i++) centre[i] = -(r[3 * i] * t[0] + r[3 * i + 1] * t[1] + r[3 * i + 2] * t[2]);
    if (!ffp_pose_from_rotation(&rotation, r, centre, p2w, err)) return false;
    ffp_place_projector(calibration, p2w);
    calibration->has_projector = true;
    return true;
}
