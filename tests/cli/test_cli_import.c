// `ffprocams import`: a rig whose true poses are known (data/sample) is written down the way each calibration
// tool writes it, imported, and must then explain its own pictures by pattern lookup at the true depth.
#include <math.h>
#include "cli/program.h"
#include "capture/capture.h"
#include "loss/metrics.h"
#include "match/match.h"
#include "rig/lens.h"
#include "rig/matrix.h"

#define SAMPLE FFP_SOURCE_DIR "/data/sample"
#define SIZES "--camera-size 128x128 --projector-size 800x800 "
#define SHOTS                                                                                                \
    "-i 'all_black=" SAMPLE "/path_0_theta{view}_all_black.png' -i 'all_white=" SAMPLE                       \
    "/path_0_theta{view}_all_white.png' -i 'lollipop_0=" SAMPLE "/path_0_theta{view}_lollipop_0.png' "
#define PATTERN "-p lollipop_0=" SAMPLE "/patterns/lollipop_0.png "
// The sample's camera goes round by +45 degrees a view about z, which is up: its object turns the other way.
#define TURNTABLE "-t 0,1,0,0,0,3,8x45 "

static FfpCapture sample;
static ProgramRun run;
static const int n_shown = 3;

static int setup(void **state) {
    return scratch_setup(state) != 0 || !ffp_capture_read(&sample, SAMPLE, NULL);
}

static int teardown(void **state) {
    ffp_capture_free(&sample);
    return scratch_teardown(state);
}

// --- Writing calibrations. ---

static FILE *create(const char *name) {
    FILE *out = fopen(in_scratch(name), "w");
    assert_non_null(out);
    return out;
}

// Projector coordinates from camera coordinates, of the first view.
static void motion(double c2p[16]) {
    double c2w[16], p2w[16], w2p[16];
    for (int i = 0; i < 16; i++) {
        c2w[i] = (double)sample.views[0].camera.pose[i];
        p2w[i] = (double)sample.views[0].projector.pose[i];
    }
    ffp_pose_inverse(p2w, w2p);
    ffp_pose_product(w2p, c2w, c2p);
}

static void put_matrix(FILE *out, const char *name, int rows, int cols, const double *values) {
    fprintf(out, "%s: !!opencv-matrix\n   rows: %d\n   cols: %d\n   dt: d\n   data: [ ", name, rows, cols);
    for (int i = 0; i < rows * cols; i++) fprintf(out, "%s%.16e", i > 0 ? ", " : "", values[i]);
    fputs(" ]\n", out);
}

static void put_xml(FILE *out, const char *name, int rows, int cols, const double *values) {
    fprintf(out, "<%s type_id=\"opencv-matrix\">\n <rows>%d</rows>\n <cols>%d</cols>\n <dt>d</dt>\n <data>\n",
            name, rows, cols);
    for (int i = 0; i < rows * cols; i++) fprintf(out, " %.16e%s", values[i], i % 3 == 2 ? "\n" : "");
    fprintf(out, "</data></%s>\n", name);
}

// A camera matrix in the tools' convention, centres at integers + 0.5 - shift.
static void intrinsics(const FfpCamera *device, double shift, double k[9]) {
    const double values[9] = {(double)device->fx,
                              0,
                              (double)device->cx - shift,
                              0,
                              (double)device->fy,
                              (double)device->cy - shift,
                              0,
                              0,
                              1};
    memcpy(k, values, sizeof values);
}

typedef struct Keys {
    const char *camera, *camera_lens, *projector, *projector_lens, *rotation, *translation;
} Keys;

static void write_opencv(const char *name, const Keys *keys, bool xml, const double lens[5],
                         const double projector_lens[5]) {
    double k[9], p[9], c2p[16], r[9], t[3];
    FILE *out = create(name);
    void (*put)(FILE *, const char *, int, int, const double *) = xml ? put_xml : put_matrix;
    intrinsics(&sample.views[0].camera, 0.5, k);
    intrinsics(&sample.views[0].projector, 0.5, p);
    motion(c2p);
    for (int i = 0; i < 9; i++) r[i] = c2p[4 * (i / 3) + i % 3];
    for (int i = 0; i < 3; i++) t[i] = c2p[4 * i + 3];
    const double shape[2] = {128, 128};
    fputs(xml ? "<?xml version=\"1.0\"?>\n<opencv_storage>\n" : "%YAML:1.0\n---\n", out);
    if (xml) put(out, "img_shape", 2, 1, shape);
    put(out, keys->camera, 3, 3, k);
    put(out, keys->camera_lens, 1, 5, lens);
    put(out, keys->projector, 3, 3, p);
    put(out, keys->projector_lens, 1, xml ? 5 : 4, projector_lens);
    put(out, keys->rotation, 3, 3, r);
    put(out, keys->translation, 3, 1, t);
    if (xml) fputs("</opencv_storage>\n", out);
    fclose(out);
}

// --- What an import must be. ---

static void import(const char *name, const char *arguments) {
    char line[3500];
    snprintf(line, sizeof line, "import %s -o %s/%s", arguments, scratch, name);
    run_program(&run, line);
    if (run.status != 0) printf("%s", run.err);
    assert_int_equal(run.status, 0);
}

// PSNR between the imported picture under the lollipop and what lookup at the true depth says it must be.
static double explained(const FfpCapture *capture, int view, const real *depth) {
    const int active = ffp_capture_find_pattern(capture, "lollipop_0");
    assert_true(active >= 0);
    FfpImage predicted = ffp_predict_by_lookup(capture, view, active, depth);
    FfpImage truth = ffp_image_copy(&capture->views[view].images[active]);
    ffp_image_to_srgb(&truth);
    const double psnr = ffp_psnr(&predicted, &truth);
    ffp_image_free(&predicted);
    ffp_image_free(&truth);
    return psnr;
}

// Every view's rig is the sample's (projector in the camera's frame), and the views stand to each other as
// the sample's do.
static void check_poses(const FfpCapture *capture) {
    double first[2][16];
    for (int v = 0; v < capture->n_views; v++) {
        double relative[2][2][16];
        for (int k = 0; k < 2; k++) {
            const FfpView *view = k == 0 ? &capture->views[v] : &sample.views[v];
            double c2w[16], p2w[16], w2c[16];
            for (int i = 0; i < 16; i++)
                c2w[i] = (double)view->camera.pose[i], p2w[i] = (double)view->projector.pose[i];
            if (v == 0) memcpy(first[k], c2w, sizeof c2w);
            ffp_pose_inverse(c2w, w2c);
            ffp_pose_product(w2c, p2w, relative[k][0]);
            ffp_pose_product(w2c, first[k], relative[k][1]);
        }
        for (int i = 0; i < 32; i++)
            assert_true(fabs(relative[0][i / 16][i % 16] - relative[1][i / 16][i % 16]) < 2e-5);
    }
}

// As many views as the sample has, its optics and poses, and pictures explained as well as the sample's.
static void check_import(const char *name, double tolerance_db) {
    FfpCapture capture;
    FfpError err = {0};
    if (!ffp_capture_read(&capture, in_scratch(name), &err)) fail_msg("%s", err.text);
    assert_int_equal(capture.n_views, sample.n_views);
    assert_int_equal(capture.n_patterns, n_shown);
    check_poses(&capture);
    for (int v = 0; v < capture.n_views; v++) {
        const FfpCamera *const pairs[2][2] = {{&capture.views[v].camera, &sample.views[v].camera},
                                              {&capture.views[v].projector, &sample.views[v].projector}};
        for (int k = 0; k < 2; k++) {
            assert_int_equal(pairs[k][0]->width, pairs[k][1]->width);
            assert_true(fabs((double)(pairs[k][0]->fx - pairs[k][1]->fx)) < 1e-3);
            assert_true(fabs((double)(pairs[k][0]->cx - pairs[k][1]->cx)) < 1e-3);
            assert_true(fabs((double)(pairs[k][0]->cy - pairs[k][1]->cy)) < 1e-3);
        }
        const double before = explained(&sample, v, sample.views[v].depth.data);
        const double after = explained(&capture, v, sample.views[v].depth.data);
        if (!(after > before - tolerance_db))
            printf("%s, view %d: %.2f dB, was %.2f\n", name, v, after, before);
        assert_true(after > before - tolerance_db);
    }
    ffp_capture_free(&capture);
}

// --- Fixed rigs on a turntable. ---

static const double no_lens[5] = {0};
static const Keys single_shot = {"camK", "camKc", "prjK", "prjKc", "R", "T"};

static void test_single_shot(void **state) {
    (void)state;
    char arguments[2000];
    write_opencv("cal.yml", &single_shot, false, no_lens, no_lens);
    snprintf(arguments, sizeof arguments, "-c %s/cal.yml " SIZES TURNTABLE SHOTS PATTERN, scratch);
    import("single_shot", arguments);
    check_import("single_shot", 0.1);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_single_shot),
    };
    return cmocka_run_group_tests(tests, setup, teardown);
}
