// `ffprocams import`: a rig whose true poses are known (data/sample) is written down the way each calibration
// tool writes it, imported, and must then explain its own pictures by pattern lookup at the true depth.
// Labels: slow
#include <math.h>
#include "core/capture/capture.h"
#include "engine/loss/metrics.h"
#include "engine/match/match.h"
#include "product/cli/program.h"
#include "rig/optics/lens.h"
#include "rig/optics/matrix.h"

#define SAMPLE FFP_SOURCE_DIR "/data/sample"
#define SIZES "--camera-size 128x128 --projector-size 800x800 "
#define SHOTS                                                                                                \
    "-i 'all_black=" SAMPLE "/path_0_theta{view}_all_black.png' -i 'all_white=" SAMPLE                       \
    "/path_0_theta{view}_all_white.png' -i 'lollipop_0=" SAMPLE "/path_0_theta{view}_lollipop_0.png' "
#define PATTERN "-p lollipop_0=" SAMPLE "/patterns/lollipop_0.png "
// The sample's camera goes round by +45 degrees a view about z, which is up: its object turns the other way.
#define FIRST_TWO "-v 000 -v 045 " // where only the calibration is written otherwise
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
    snprintf(line, sizeof line, "--events 1 import %s -o %s/%s", arguments, scratch, name);
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

// As many views as asked for (from the first on), the sample's optics and poses, and pictures explained as
// well as its.
static void check_import(const char *name, int views, double tolerance_db) {
    FfpCapture capture;
    FfpError err = {0};
    if (!ffp_capture_read(&capture, in_scratch(name), &err)) fail_msg("%s", err.text);
    assert_int_equal(capture.n_views, views);
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

static void import_rig(const char *name, const char *calibration, const char *more) {
    char arguments[3000];
    snprintf(arguments, sizeof arguments, "-c %s/%s %s", scratch, calibration, more);
    import(name, arguments);
    check_import(name, strstr(more, FIRST_TWO) ? 2 : sample.n_views, 0.1);
}

static void test_single_shot(void **state) {
    (void)state;
    write_opencv("cal.yml", &single_shot, false, no_lens, no_lens);
    import_rig("single_shot", "cal.yml", SIZES TURNTABLE SHOTS PATTERN);
    char info[256];
    snprintf(info, sizeof info, "info %s/single_shot", scratch);
    run_program(&run, info);
    assert_int_equal(run.status, 0);
    assert_non_null(strstr(run.out, "ok   silhouettes"));
    assert_non_null(strstr(run.out, "ok   pattern "));
    // The sizes from the file that this tool writes beside it, which is found where it is not named.
    FILE *out = create("calib-info.yml");
    fputs("%YAML:1.0\ncamW: 128\ncamH: 128\nprjW: 800\nprjH: 800\nboardSize: [7, 10]\nsqSize: 24\n", out);
    fclose(out);
    import_rig("single_shot_info", "cal.yml", TURNTABLE FIRST_TWO SHOTS PATTERN);
    assert_int_equal(remove(in_scratch("calib-info.yml")), 0);
}

static void test_procam_calibration(void **state) {
    (void)state;
    const Keys keys = {"cam_int", "cam_dist", "proj_int", "proj_dist", "roration", "translation"};
    write_opencv("cal.xml", &keys, true, no_lens, no_lens);
    import_rig("procam", "cal.xml", "--projector-size 800x800 " TURNTABLE FIRST_TWO SHOTS PATTERN);
    const Keys mended = {"cam_int", "cam_dist", "proj_int", "proj_dist", "rotation", "translation"};
    write_opencv("cal.xml", &mended, true, no_lens, no_lens);
    import_rig("procam_mended", "cal.xml", "--projector-size 800x800 " TURNTABLE FIRST_TWO SHOTS PATTERN);
}

static void test_calibrator(void **state) {
    (void)state;
    const Keys keys = {"cam_K", "cam_kc", "proj_K", "proj_kc", "R", "T"};
    write_opencv("cal.yml", &keys, false, no_lens, no_lens);
    // The same turntable the other way up: the object turns by -45 degrees about the axis that points up.
    import_rig("calibrator", "cal.yml",
               SIZES "-t 0,-1,0,0,0,3,0,-45,-90,-135,-180,-225,-270,-315 " PATTERN "-i 'all_black=" SAMPLE
                     "/path_0_theta*_all_black.png' -i 'all_white=" SAMPLE
                     "/path_0_theta*_all_white.png' -i 'lollipop_0=" SAMPLE
                     "/path_0_theta*_lollipop_0.png' ");
}

static void test_opencv_samples(void **state) {
    (void)state;
    const Keys keys = {"cam1_intrinsics", "cam1_distorsion", "cam2_intrinsics", "cam2_distorsion", "R", "T"};
    write_opencv("cal.yml", &keys, false, no_lens, no_lens);
    FILE *out = create("table.json");
    fputs("{\"axis\": [0, 2, 0], \"point\": [0, -0.25, 3], \"count\": 8, \"step\": 45}", out);
    fclose(out);
    char plain[2500];
    snprintf(plain, sizeof plain, SIZES "-t %s/table.json " FIRST_TWO SHOTS PATTERN, scratch);
    import_rig("samples", "cal.yml", plain);
}

#define BY_NAME "-i 'all_black,all_white,lollipop_0=" SAMPLE "/{view}_{pattern}.png' "

// A turntable whose stops were found from their photographs: views by name, one of them left out.
static void test_named_stops(void **state) {
    (void)state;
    write_opencv("cal.yml", &single_shot, false, no_lens, no_lens);
    FILE *out = create("stops.json");
    fputs("{\"axis\": [0, 1, 0], \"point\": [0, 0, 3],\n \"views\": [", out);
    for (int v = 0; v < sample.n_views; v++) fprintf(out, "%s\"%s\"", v > 0 ? ", " : "", sample.views[v].id);
    fprintf(out, "],\n \"left_out\": [\"%s\"],\n \"count\": 8, \"step\": 45}",
            sample.views[sample.n_views - 1].id);
    fclose(out);
    char arguments[3000];
    snprintf(arguments, sizeof arguments, "-c %s/cal.yml " SIZES "-t %s/stops.json " BY_NAME PATTERN, scratch,
             scratch);
    import("stops", arguments);
    check_import("stops", sample.n_views - 1, 0.1);
}

// Placeholders and * in one name: * stands for whatever the placeholders do not.
static void test_names_of_files(void **state) {
    (void)state;
    static const char *const ways[] = {
        // {view} and *: the files of a view, here one
        "-i 'all_black=" SAMPLE "/path_0_theta{view}_*black.png' -i 'all_white=" SAMPLE
        "/path_0_theta{view}_*white.png' -i 'lollipop_0=" SAMPLE "/path_0_theta{view}_*_0.png' ",
        // and here two, in order
        "-i 'all_black,all_white=" SAMPLE "/path_0_theta{view}_all_*.png' -i 'lollipop_0=" SAMPLE
        "/path_0_theta{view}_lollipop_0.png' ",
        // {pattern} and *: the views under a pattern
        "-i 'all_black,all_white,lollipop_0=" SAMPLE "/path_0_theta*_{pattern}.png' ",
        // both, and *
        "-i 'all_black,all_white,lollipop_0=" SAMPLE "/path_?_theta{view}_{pattern}.png' ",
    };
    write_opencv("cal.yml", &single_shot, false, no_lens, no_lens);
    for (size_t i = 0; i < sizeof ways / sizeof *ways; i++) {
        char name[32], arguments[2500];
        snprintf(name, sizeof name, "names_%zu", i);
        snprintf(arguments, sizeof arguments, SIZES TURNTABLE "%s" PATTERN, ways[i]);
        import_rig(name, "cal.yml", arguments);
    }
}

// DeProCams has one view, and rows of text.
static void test_deprocams(void **state) {
    (void)state;
    double c2p[16], k[9], p[9];
    motion(c2p);
    intrinsics(&sample.views[0].camera, 0.5, k);
    intrinsics(&sample.views[0].projector, 0.5, p);
    FILE *out = create("params.yml");
    const double *const matrices[2] = {k, p};
    static const char *const names[2] = {"camK", "prjK"}, *const lenses[2] = {"camKc", "prjKc"};
    for (int d = 0; d < 2; d++) {
        fprintf(out, "%s:\n", names[d]);
        for (int i = 0; i < 3; i++)
            fprintf(out, "  - \"%.9f, %.9f, %.9f\"\n", matrices[d][3 * i], matrices[d][3 * i + 1],
                    matrices[d][3 * i + 2]);
        fprintf(out, "%s:\n  - \"0, 0, 0, 0\"\n", lenses[d]);
    }
    fputs("camRT:\n  - \"1, 0, 0, 0\"\n  - \"0, 1, 0, 0\"\n  - \"0, 0, 1, 0\"\nprjRT:\n", out);
    for (int i = 0; i < 3; i++)
        fprintf(out, "  - \"%.9f, %.9f, %.9f, %.9f\"\n", c2p[4 * i], c2p[4 * i + 1], c2p[4 * i + 2],
                c2p[4 * i + 3]);
    fclose(out);
    char arguments[2500];
    snprintf(arguments, sizeof arguments, "-c %s/params.yml " SIZES SHOTS PATTERN, scratch);
    import("deprocams", arguments);
    FfpCapture capture;
    assert_true(ffp_capture_read(&capture, in_scratch("deprocams"), NULL));
    assert_int_equal(capture.n_views, 1);
    assert_string_equal(capture.views[0].id, "000");
    check_poses(&capture);
    assert_true(explained(&capture, 0, sample.views[0].depth.data) >
                explained(&sample, 0, sample.views[0].depth.data) - 0.1);
    ffp_capture_free(&capture);
}

// --- Photographs that others make pictures of. ---

// A film of the white photographs, one a second, stands for all of them: "@AT" chooses.
static void test_films(void **state) {
    (void)state;
    if (system("ffmpeg -version >/dev/null 2>&1") != 0) {
        printf("skipped: ffmpeg is not here\n");
        skip();
    }
    char arguments[3000], command[1024];
    write_opencv("cal.yml", &single_shot, false, no_lens, no_lens);
    snprintf(command, sizeof command,
             "cat " SAMPLE
             "/path_0_theta???_all_white.png | ffmpeg -loglevel error -y -f image2pipe -framerate 1 "
             "-i - -c:v ffv1 -pix_fmt bgr0 %s/white.mkv -pix_fmt rgb24 %s/white_%%d.png",
             scratch, scratch);
    assert_int_equal(system(command), 0);
    for (int film = 0; film < 2; film++) {
        snprintf(arguments, sizeof arguments,
                 "-c %s/cal.yml " SIZES TURNTABLE "-v 045 -v 090 -v 180 -m otsu -i 'all_black=" SAMPLE
                 "/path_0_theta{view}_all_black.png' -i 'lollipop_0=" SAMPLE
                 "/path_0_theta{view}_lollipop_0.png' " PATTERN "-i 'all_white=%s/white%s' ",
                 scratch, scratch, film ? ".mkv@{index}" : "_{number}.png");
        import(film ? "by_film" : "by_picture", arguments);
        assert_int_equal(strstr(run.err, "3 films read by ffmpeg") != NULL, film);
    }
    FfpCapture by_picture, by_film;
    assert_true(ffp_capture_read(&by_picture, in_scratch("by_picture"), NULL));
    assert_true(ffp_capture_read(&by_film, in_scratch("by_film"), NULL));
    for (int v = 0; v < 3; v++)
        for (int p = 0; p < 3; p++)
            assert_memory_equal(by_picture.views[v].images[p].data, by_film.views[v].images[p].data,
                                3 * 128 * 128 * sizeof(real));
    ffp_capture_free(&by_picture);
    ffp_capture_free(&by_film);
}

// --- The turntable's axis from the pictures. ---

// The world's z axis before the first camera: where its origin lies across it, and its direction.
static void axis_of(const FfpCapture *capture, double direction[3], double point[3]) {
    double c2w[16], w2c[16];
    for (int i = 0; i < 16; i++) c2w[i] = (double)capture->views[0].camera.pose[i];
    ffp_pose_inverse(c2w, w2c);
    for (int i = 0; i < 3; i++) direction[i] = w2c[4 * i + 2], point[i] = w2c[4 * i + 3];
    for (int i = 0; i < 3; i++) point[i] -= point[1] / direction[1] * direction[i]; // at the camera's height
}

static void test_fit_axis(void **state) {
    (void)state;
    char arguments[3000];
    write_opencv("cal.yml", &single_shot, false, no_lens, no_lens);
    snprintf(arguments, sizeof arguments, "-c %s/cal.yml " SIZES "-t 8x45 --fit-axis " SHOTS PATTERN,
             scratch);
    import("fitted", arguments);
    assert_non_null(strstr(run.err, "axis found: direction and point "));
    assert_non_null(strstr(run.err, "the object turned the other way"));
    FfpCapture capture;
    double found[2][3], truth[2][3], cosine = 0, off = 0;
    assert_true(ffp_capture_read(&capture, in_scratch("fitted"), NULL));
    axis_of(&capture, found[0], found[1]);
    axis_of(&sample, truth[0], truth[1]);
    for (int i = 0; i < 3; i++) {
        cosine += found[0][i] * truth[0][i];
        off += (found[1][i] - truth[1][i]) * (found[1][i] - truth[1][i]);
    }
    assert_true(acos(fmin(cosine, 1)) < 0.15 * acos(-1.0) / 180);
    assert_true(sqrt(off) < 0.002 * 3);
    // Views keep the names of the angles that were given.
    assert_string_equal(capture.views[1].id, "045");
    for (int v = 0; v < 8; v += 3)
        assert_true(explained(&capture, v, sample.views[v].depth.data) >
                    explained(&sample, v, sample.views[v].depth.data) - 1);
    ffp_capture_free(&capture);
}

static void must_fail(const char *arguments, const char *what) {
    char line[3500], folder[128];
    snprintf(folder, sizeof folder, "%s/refused", scratch);
    snprintf(line, sizeof line, "import %s -o %s/new", arguments, folder);
    assert_true(ffp_make_folders(folder, NULL));
    run_program(&run, line);
    if (run.status != 1 || !strstr(run.err, what))
        printf("expected \"%s\", got %d: %s", what, run.status, run.err);
    assert_int_equal(run.status, 1);
    assert_non_null(strstr(run.err, what));
    assert_int_equal(rmdir(folder), 0); // nothing was left in it
}

// A note reports pixels that an exposure clips, and nothing is noted if it clips none.
static void test_what_is_cut_off_is_told(void **state) {
    (void)state;
    char arguments[3000];
    write_opencv("cal.yml", &single_shot, false, no_lens, no_lens);
    snprintf(arguments, sizeof arguments, "-c %s/cal.yml " SIZES TURNTABLE FIRST_TWO SHOTS PATTERN, scratch);
    import("dim", arguments);
    assert_false(has_told(&run, "values-clipped"));
    strcat(arguments, "--exposure 5 ");
    import("bright", arguments);
    assert_true(has_told(&run, "values-clipped"));
}

static void test_masks_that_leave_nothing_are_refused(void **state) {
    (void)state;
    char arguments[3000];
    FfpImage black = ffp_image_new(128, 128, 3);
    write_opencv("cal.yml", &single_shot, false, no_lens, no_lens);
    for (int v = 0; v < 2; v++)
        assert_true(ffp_image_write_png(&black, in_scratch(v ? "mask_045.png" : "mask_000.png"), NULL));
    ffp_image_free(&black);
    snprintf(arguments, sizeof arguments,
             "-c %s/cal.yml " SIZES TURNTABLE FIRST_TWO SHOTS PATTERN "-m '%s/mask_{view}.png'", scratch,
             scratch);
    must_fail(arguments, "the masks of all views are black: they must be white on the object (");
    assert_int_equal(run_format(&run, "--events 1 import %s -o %s/none", arguments, scratch), 1);
    assert_true(has_told(&run, "masks-empty"));
}

// sRGB's curve is nearly the power 2.2, and another answer is no better: patterns stay as they are.
static void test_a_response_that_does_not_help(void **state) {
    (void)state;
    char arguments[3000], *text = NULL;
    size_t size = 0;
    write_opencv("cal.yml", &single_shot, false, no_lens, no_lens);
    snprintf(arguments, sizeof arguments, "-c %s/cal.yml " SIZES TURNTABLE "--fit-response " SHOTS PATTERN,
             scratch);
    import("as_it_was", arguments);
    assert_true(has_told(&run, "response-not-kept"));
    assert_true(ffp_read_file(in_scratch("as_it_was/scene.json"), 1 << 20, &text, &size, NULL));
    assert_null(strstr(text, "\"response\""));
    ffp_free(text);
}

// A projector of gamma 3.3 that was sent a paler pattern: patterns become light by what was found, which the
// file keeps.
static void test_fit_response(void **state) {
    (void)state;
    char arguments[3000], *text = NULL;
    size_t size = 0;
    FfpImage pattern = {0};
    FfpError err = {0};
    write_opencv("cal.yml", &single_shot, false, no_lens, no_lens);
    assert_true(ffp_image_read(&pattern, SAMPLE "/patterns/lollipop_0.png", FFP_COLOUR_ENCODED, &err));
    const size_t count = (size_t)pattern.width * (size_t)pattern.height * (size_t)pattern.channels;
    for (size_t i = 0; i < count; i++)
        if (pattern.channels < 4 || i % 4 < 3) pattern.data[i] = powf(pattern.data[i], 2 / 3.0F);
    assert_true(ffp_image_write_png(&pattern, in_scratch("pale.png"), &err));
    ffp_image_free(&pattern);
    snprintf(arguments, sizeof arguments,
             "-c %s/cal.yml " SIZES TURNTABLE "--fit-response -v 000 -v 045 -v 090 " SHOTS
             "-p lollipop_0=%s/pale.png",
             scratch, scratch);
    import("response", arguments);
    assert_non_null(strstr(run.err, "projector gamma 3."));
    assert_non_null(strstr(run.err, "black level at most 0."));
    assert_true(ffp_read_file(in_scratch("response/scene.json"), 1 << 20, &text, &size, NULL));
    assert_non_null(strstr(text, "\"response\""));
    assert_non_null(strstr(text, "\"black_level_known\": false"));
    ffp_free(text);
    FfpCapture capture;
    assert_true(ffp_capture_read(&capture, in_scratch("response"), NULL));
    assert_int_equal(capture.n_views, 3);
    assert_true(capture.intensity_known);
    assert_true(explained(&capture, 0, sample.views[0].depth.data) >
                explained(&sample, 0, sample.views[0].depth.data) - 1);
    ffp_capture_free(&capture);
}

// --- Wrong usage and wrong files, as a user meets them. ---

static void test_usage(void **state) {
    (void)state;
    static const char *const wrong[] = {"import",
                                        "import -c cal.yml",
                                        "import -o out",
                                        "import -c cal.yml -o out --camera-size 640",
                                        "import -c cal.yml -o out --camera-fit crop=1",
                                        "import -c cal.yml -o out --projector-fit squeezed",
                                        "import -c cal.yml -o out --width 3",
                                        "import -c cal.yml -o out --linear colours",
                                        "import -c cal.yml -o out --exposure bright",
                                        "import -c cal.yml -o out --object 0,0,0",
                                        "import -c cal.yml -o out --object 0,0,0,-1",
                                        "import -c cal.yml -o out photographs.png",
                                        "import -c cal.yml -o out --angles 8x0",
                                        "import -c cal.yml -o out --fitting"};
    for (size_t i = 0; i < sizeof wrong / sizeof *wrong; i++) {
        run_program(&run, wrong[i]);
        if (run.status != 2) printf("%s: exit %d\n", wrong[i], run.status);
        assert_int_equal(run.status, 2);
        assert_non_null(strstr(run.err, "see: ffprocams import --help"));
    }
    run_program(&run, "import --help");
    assert_int_equal(run.status, 0);
    assert_non_null(strstr(run.out, "calibration_result.xml"));
}

static void test_refusals(void **state) {
    (void)state;
    char arguments[3000];
    write_opencv("cal.yml", &single_shot, false, no_lens, no_lens);
    static const struct {
        const char *more, *what;
    } cases[] = {
        {TURNTABLE SHOTS PATTERN, "--projector-size WxH"},
        {"--projector-size 800x800 " TURNTABLE SHOTS PATTERN, "--camera-size WxH"},
        {"--camera-size 64x64 --projector-size 800x800 " TURNTABLE SHOTS PATTERN, "calibrated at 64 x 64"},
        {"--camera-size 128x128 --projector-size 1024x768 " TURNTABLE SHOTS PATTERN, "--projector-fit"},
        {"--camera-size 128x128 --projector-size 1024x768 --projector-fit scaled " TURNTABLE SHOTS PATTERN,
         "ratio differs"},
        {"--camera-size 130x128 --camera-fit crop=3,0 --projector-size 800x800 " TURNTABLE SHOTS PATTERN,
         "do not lie within"},
        {SIZES "-t 0,0,0,0,0,3,8x45 " SHOTS PATTERN, "axis has no direction"},
        {SIZES "-t 0,1,0,0,0,3 " SHOTS PATTERN, "missing angles"},
        {SIZES "-t 0,1,0,0,0,3,1e9 " SHOTS PATTERN, "invalid angle: "},
        {SIZES TURNTABLE "--angles 8x45 " SHOTS PATTERN, "--angles gives the angles already"},
        {SIZES TURNTABLE SHOTS "--shown nowhere",
         "cannot read the patterns' folder: No such file or directory (nowhere)"},
        {SIZES "-t 0,1,0,0,0,3,999x1 " SHOTS PATTERN, "must begin with a number of stops"},
        {SIZES "-t 0,1,0,0,0,3,8x0 " SHOTS PATTERN, "'8x0' puts all stops at the same angle"},
        {SIZES "-t 0,1,0,0,0,3,0x45 " SHOTS PATTERN, "'0x45' must begin with a number of stops"},
        {SIZES "-t 0,1,0,0,0,3,8x " SHOTS PATTERN, "'8x' is not a number"},
        {SIZES "-t 0,1,0,0,0,3,400x1,400x1 " SHOTS PATTERN, "exceeds the limit of 512 angles"},
        {SIZES "-t 0,1,0,0,0,3,0,45, " SHOTS PATTERN, "is not a number"},
        {SIZES "-t 0,1,zero,0,0,3,8x45 " SHOTS PATTERN, "zero"},
        {SIZES "--fit-axis " SHOTS PATTERN, "no rotation angles of the object given (turntable)"},
        {SIZES "-t 8x45 --fit-axis=0,1,0 " SHOTS PATTERN, "six numbers"},
        {SIZES "-t 8x45 --fit-axis=0,0,0,0,0,3 " SHOTS PATTERN, "axis has no direction"},
        {SIZES "-t 8x45,zero --fit-axis " SHOTS PATTERN, "zero"},
        {SIZES TURNTABLE SHOTS, "--pattern NAME=FILE"},
        {SIZES TURNTABLE PATTERN, "--images"},
        {SIZES TURNTABLE SHOTS "-p other=" SAMPLE "/patterns/lollipop_0.png",
         "no picture under pattern 'other'"},
        {SIZES TURNTABLE SHOTS PATTERN "-m 'masks/{view}.png'", "masks/000.png"},
        {SIZES TURNTABLE SHOTS PATTERN "-v 17", "no view '17'"},
        {SIZES "-t 0,1,0,0,0,3,7x45 " PATTERN "-i 'black=" SAMPLE "/path*_all_black.png'", "8 files match"},
        {SIZES TURNTABLE PATTERN "-i 'black=" SAMPLE "/{angle}.png'", "placeholders"},
        {SIZES TURNTABLE PATTERN "-i 'black=" SAMPLE "/none_*.png'", "no file matches"},
        {SIZES TURNTABLE PATTERN "-i 'black=" SAMPLE "/patterns/lollipop_0.png'", "one file for 8 views"},
        {SIZES TURNTABLE PATTERN "-i 'black=" SAMPLE "/path_0_theta{view}_all_*.png'",
         "2 files match, but a view has 1 photographs"},
        {SIZES TURNTABLE SHOTS PATTERN "-m '" SAMPLE "/path_0_theta0*_all_white.png'",
         "3 files match, but 8 views have 8 masks"},
        {SIZES TURNTABLE PATTERN "-i 'black=shots/*.mp4@1-2'", "cannot be combined with parts of films (@)"},
        {SIZES TURNTABLE PATTERN "-i 'black=" SAMPLE "/scene.json@1x'", "one file for 8 views"},
        {SIZES TURNTABLE SHOTS "-p lollipop_0,lollipop_1=" SAMPLE "/patterns/lollipop_0.png",
         "repeat -p for several: -p A -p B"},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        snprintf(arguments, sizeof arguments, "-c %s/cal.yml %s", scratch, cases[i].more);
        must_fail(arguments, cases[i].what);
    }
    // A quotation of an option tells nothing of the place.
    snprintf(arguments, sizeof arguments, "-c %s/cal.yml " SIZES "-t '0,1,0,0,0,3,(width)' " SHOTS PATTERN,
             scratch);
    must_fail(arguments, "(width)");
    assert_null(strstr(run.err, "--width W"));
    // A folder that holds something is not written over.
    snprintf(arguments, sizeof arguments, "import -c %s/cal.yml " SIZES TURNTABLE SHOTS PATTERN "-o %s",
             scratch, scratch);
    run_program(&run, arguments);
    assert_int_equal(run.status, 1);
    assert_non_null(strstr(run.err, "not empty"));
}

// Everything in view belongs to a whole scene, which has depths instead of masks.
static void test_whole_scene(void **state) {
    (void)state;
    FfpCapture capture;
    FfpError err = {0};
    char arguments[3000];
    write_opencv("cal.yml", &single_shot, false, no_lens, no_lens);
    snprintf(arguments, sizeof arguments, "-c %s/cal.yml " SIZES TURNTABLE SHOTS PATTERN "--scene", scratch);
    import("scene", arguments);
    if (!ffp_capture_read(&capture, in_scratch("scene"), &err)) fail_msg("%s", err.text);
    assert_true(capture.scene);
    for (int v = 0; v < capture.n_views; v++) {
        const FfpView *view = &capture.views[v];
        for (int i = 0; i < 128 * 128; i++) assert_float_equal(view->coverage.data[i], 1, 0);
        // The range holds the object.
        for (int i = 0; i < 128 * 128; i++) {
            const real z = sample.views[v].depth.data[i];
            if (sample.views[v].coverage.data[i] >= 1) assert_true(z > view->near && z < view->far);
        }
    }
    ffp_capture_free(&capture);
    strcat(arguments, " -m otsu");
    must_fail(arguments, "a whole scene has no masks (masks)");
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_what_is_cut_off_is_told),
        cmocka_unit_test(test_masks_that_leave_nothing_are_refused),
        cmocka_unit_test(test_single_shot),
        cmocka_unit_test(test_whole_scene),
        cmocka_unit_test(test_procam_calibration),
        cmocka_unit_test(test_calibrator),
        cmocka_unit_test(test_opencv_samples),
        cmocka_unit_test(test_named_stops),
        cmocka_unit_test(test_names_of_files),
        cmocka_unit_test(test_deprocams),
        cmocka_unit_test(test_films),
        cmocka_unit_test(test_fit_axis),
        cmocka_unit_test(test_a_response_that_does_not_help),
        cmocka_unit_test(test_fit_response),
        cmocka_unit_test(test_usage),
        cmocka_unit_test(test_refusals),
    };
    return cmocka_run_group_tests(tests, setup, teardown);
}
