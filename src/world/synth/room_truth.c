#include "world/synth/room_truth.h"
#include <stdio.h>
#include "core/base/file.h"
#include "core/base/rigid.h"

static void print_matrix(FILE *f, const char *name, int rows, int columns, const double *values) {
    fprintf(f,
            "<%s type_id=\"opencv-matrix\">\n  <rows>%d</rows>\n  <cols>%d</cols>\n  <dt>d</dt>\n  <data>\n"
            "    ",
            name, rows, columns);
    for (int i = 0; i < rows * columns; i++) fprintf(f, "%s%.12g", i > 0 ? " " : "", values[i]);
    fprintf(f, "</data></%s>\n", name);
}

static void print_device(FILE *f, const char *name, const FfpCamera *device, const double lens[5]) {
    const double matrix[9] = {(double)device->fx,
                              0,
                              (double)device->cx - 0.5,
                              0,
                              (double)device->fy,
                              (double)device->cy - 0.5,
                              0,
                              0,
                              1};
    char text[32];
    snprintf(text, sizeof text, "%s_int", name);
    print_matrix(f, text, 3, 3, matrix);
    snprintf(text, sizeof text, "%s_dist", name);
    print_matrix(f, text, 1, 5, lens);
}

static void print_calibration(FILE *f, const FfpBareRig *rig) {
    const FfpRigid camera = ffp_rigid_from_pose(rig->camera.pose),
                   projector = ffp_rigid_from_pose(rig->projector.pose);
    double r[9], t[3];
    ffp_rotation_difference(projector.r, camera.r, r);
    ffp_bare_rig_in_frame(&rig->projector, camera.t, true, t);
    fprintf(f, "<?xml version=\"1.0\"?>\n<opencv_storage>\n<camW>%d</camW>\n<camH>%d</camH>\n",
            rig->camera.width, rig->camera.height);
    fprintf(f, "<prjW>%d</prjW>\n<prjH>%d</prjH>\n", rig->projector.width, rig->projector.height);
    print_device(f, "cam", &rig->camera, rig->camera_lens);
    print_device(f, "proj", &rig->projector, rig->projector_lens);
    print_matrix(f, "rotation", 3, 3, r);
    print_matrix(f, "translation", 3, 1, t);
    fputs("</opencv_storage>\n", f);
}

static void print_axis(FILE *f, const FfpBareRig *rig, int views) {
    const double up[3] = {0, 0, 1}, middle[3] = {0, 0, 0};
    double axis[3], point[3];
    ffp_bare_rig_in_frame(&rig->camera, up, false, axis);
    ffp_bare_rig_in_frame(&rig->camera, middle, true, point);
    fprintf(f, "{\n \"axis\": [%.9g, %.9g, %.9g],\n \"point\": [%.9g, %.9g, %.9g],\n \"angles\": [", axis[0],
            axis[1], axis[2], point[0], point[1], point[2]);
    for (int i = 0; i < views; i++) fprintf(f, "%s%.9g", i > 0 ? ", " : "", 360.0 * i / views);
    fputs("]\n}\n", f);
}

// One of the files; `views` 0: the calibration.
static bool write_one(const FfpBareRig *rig, int views, const char *folder, const char *name, FfpError *err) {
    char path[FFP_PATH_MAX];
    FfpOutput out;
    if (!ffp_join_path(path, folder, name))
        return ffp_fail(err, FFP_ERROR_ARGUMENT, folder, "the path is too long");
    if (!ffp_output_open(&out, path, err)) return false;
    if (views == 0)
        print_calibration(out.stream, rig);
    else
        print_axis(out.stream, rig, views);
    const bool ok = ffp_output_commit(&out, err);
    ffp_output_abort(&out);
    return ok;
}

bool ffp_room_truth_write(const FfpBareRig *rig, int views, const char *folder, FfpError *err) {
    return write_one(rig, 0, folder, "calibration.xml", err) &&
           write_one(rig, 0, folder, "true_calibration.xml", err) &&
           write_one(rig, views, folder, "axis.json", err) &&
           write_one(rig, views, folder, "true_axis.json", err);
}
