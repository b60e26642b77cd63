// The ground truth of a rig that was photographed.
#include <string.h>
#include "core/base/rigid.h"
#include "world/synth/photographing.h"
#include "world/synth/sensor.h"

static void print_numbers(FILE *f, const char *name, const double *values, int count) {
    fprintf(f, "  \"%s\": [", name);
    for (int i = 0; i < count; i++) fprintf(f, "%s%.9g", i > 0 ? ", " : "", values[i]);
    fputs("],\n", f);
}

// Intrinsics as OpenCV has them: pixel centres at integers.
static void print_device(FILE *f, const char *name, const FfpCamera *device, const double lens[5]) {
    char lens_name[16];
    snprintf(lens_name, sizeof lens_name, "%skc", name);
    fprintf(f, "  \"%sK\": [[%.9g, 0, %.9g], [0, %.9g, %.9g], [0, 0, 1]],\n", name, (double)device->fx,
            (double)device->cx - 0.5, (double)device->fy, (double)device->cy - 0.5);
    print_numbers(f, lens_name, lens, 5);
    const char *size = strcmp(name, "cam_") == 0 ? "cam" : "prj";
    fprintf(f, "  \"%sW\": %d,\n  \"%sH\": %d,\n", size, device->width, size, device->height);
}

// X_p = R X_c + T.
static void print_motion(FILE *f, const FfpBareRig *rig) {
    const FfpRigid camera = ffp_rigid_from_pose(rig->camera.pose),
                   projector = ffp_rigid_from_pose(rig->projector.pose);
    double r[9], t[3];
    ffp_rotation_difference(projector.r, camera.r, r);
    ffp_bare_rig_in_frame(&rig->projector, camera.t, true, t);
    fputs("  \"R\": [", f);
    for (int i = 0; i < 3; i++)
        fprintf(f, "%s[%.12g, %.12g, %.12g]", i > 0 ? ", " : "", r[3 * i], r[3 * i + 1], r[3 * i + 2]);
    fputs("],\n", f);
    print_numbers(f, "T", t, 3);
}

static void print_turntable(FILE *f, const FfpPhotographing *job) {
    const double up[3] = {0, 0, 1}, middle[3] = {0, 0, 0};
    double axis[3], point[3], stops[FFP_BOARD_STOPS];
    ffp_bare_rig_in_frame(&job->room.rig.camera, up, false, axis);
    ffp_bare_rig_in_frame(&job->room.rig.camera, middle, true, point);
    print_numbers(f, "axis", axis, 3);
    print_numbers(f, "point", point, 3);
    fputs("  \"angles\": [", f);
    for (int i = 0; i < job->spec->views; i++)
        fprintf(f, "%s%.9g", i > 0 ? ", " : "", 360.0 * i / job->spec->views);
    fputs("],\n", f);
    for (int i = 0; i < FFP_BOARD_STOPS; i++) stops[i] = ffp_board_angle(i);
    if (job->options->attitudes > 0 && job->shown.n_codes > 0)
        print_numbers(f, "board_angles", stops, FFP_BOARD_STOPS);
}

// The board's first corner and the directions of its rows and columns, in the camera's frame.
static void print_board(FILE *f, const FfpPhotographing *job, const FfpPhotographed *subject,
                        const char *between) {
    const FfpChessboard *b = &subject->board;
    FfpCamera camera, projector;
    double numbers[9];
    ffp_bare_rig_devices(&job->room.rig, subject->angle, &camera, &projector);
    const float *const from[3] = {b->origin, b->right, b->down};
    for (int i = 0; i < 3; i++) {
        const double v[3] = {(double)from[i][0], (double)from[i][1], (double)from[i][2]};
        ffp_bare_rig_in_frame(&camera, v, i == 0, numbers + 3 * i);
    }
    fprintf(f, "%s    {\"folder\": \"%s\", \"origin_right_down\": [", between, subject->name);
    for (int i = 0; i < 9; i++) fprintf(f, "%s%.9g", i > 0 ? ", " : "", numbers[i]);
    fputs("]}", f);
}

static void print_light(FILE *f, const FfpSensor *sensor) {
    json_t *light = ffp_sensor_truth(sensor);
    if (!light) return;
    fputs(",\n  \"light\": ", f);
    json_dumpf(light, f, JSON_REAL_PRECISION(6));
    json_decref(light);
}

bool ffp_photographing_truth(const FfpPhotographing *job, FfpError *err) {
    char path[FFP_PATH_MAX];
    FfpOutput out;
    if (!ffp_photographing_path(job, "truth.json", path, err) || !ffp_output_open(&out, path, err))
        return false;
    FILE *f = out.stream;
    fputs("{\n", f);
    print_device(f, "cam_", &job->room.rig.camera, job->room.rig.camera_lens);
    print_device(f, "proj_", &job->room.rig.projector, job->room.rig.projector_lens);
    print_motion(f, &job->room.rig);
    print_turntable(f, job);
    const FfpChessboard board = ffp_bare_rig_turntable_board(&job->room.rig);
    fprintf(f, "  \"board\": {\"corners\": [%d, %d], \"square\": %.9g},\n  \"boards\": [\n", board.columns,
            board.rows, (double)board.square * FFP_BARE_RIG_UNIT);
    const char *between = "";
    for (int s = 0; s < job->n_subjects; s++)
        if (job->subjects[s].board.columns > 0) {
            print_board(f, job, &job->subjects[s], between);
            between = ",\n";
        }
    fputs("\n  ]", f);
    print_light(f, &job->sensor);
    fputs("\n}\n", f);
    const bool ok = ffp_output_commit(&out, err);
    ffp_output_abort(&out);
    return ok;
}
