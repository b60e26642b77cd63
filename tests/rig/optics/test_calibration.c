// Calibration files: the real ones with the figures that stand in them, and broken ones.
#include <math.h>
#include "core/base/rng.h"
#include "rig/optics/calibration.h"
#include "rig/optics/document.h"
#include "rig/optics/matrix.h"
#include "scratch.h"

static FfpCalibration calibration;
static FfpError err;

static void write_text(const char *name, const char *text) {
    assert_true(ffp_write_file(in_scratch(name), text, strlen(text), NULL));
}

// Without waiting for the disk, as there are thousands.
static void write_bytes(const char *name, const char *bytes, size_t size) {
    FILE *out = fopen(in_scratch(name), "wb");
    assert_non_null(out);
    assert_int_equal(fwrite(bytes, 1, size, out), size);
    assert_int_equal(fclose(out), 0);
}

static void must_read(const char *const *files, int n) {
    if (!ffp_calibration_read(&calibration, files, n, "calib", &err)) fail_msg("%s", err.text);
}

// An error with these words and the place; nothing is kept.
static void must_fail(const char *const *files, int n, const char *what) {
    const bool ok = ffp_calibration_read(&calibration, files, n, "calib", &err);
    ffp_calibration_free(&calibration);
    if (ok || !strstr(err.text, what)) printf("expected \"%s\", got: %s\n", what, ok ? "no error" : err.text);
    assert_false(ok);
    assert_non_null(strstr(err.text, what));
    assert_non_null(strrchr(err.text, '('));
}

static void near(double value, double expected) {
    if (!(fabs(value - expected) <= 1e-6 * fmax(1, fabs(expected))))
        printf("%.12g is not %.12g\n", value, expected);
    assert_true(fabs(value - expected) <= 1e-6 * fmax(1, fabs(expected)));
}

static void check_optics(const FfpOptics *optics, const double figures[9]) {
    near(optics->fx, figures[0]);
    near(optics->fy, figures[1]);
    near(optics->cx, figures[2] + 0.5); // these tools put pixel centres at integers
    near(optics->cy, figures[3] + 0.5);
    for (int i = 0; i < 5; i++) near(optics->lens[i], figures[4 + i]);
}

// X_projector = R X_camera + T, as projector to camera.
static void check_motion(const double r[9], const double t[3]) {
    for (int i = 0; i < 3; i++) {
        double back = 0;
        for (int j = 0; j < 3; j++) {
            assert_true(fabs(calibration.p2c[4 * i + j] - r[3 * j + i]) < 1e-6);
            back -= r[3 * j + i] * t[j];
        }
        assert_true(fabs(calibration.p2c[4 * i + 3] - back) < 1e-3); // of some hundred millimetres, in float
    }
}

// --- Real files. ---

static void test_kamino(void **state) {
    (void)state;
    char path[1024];
    if (!shared_path(path, "real/kamino410/calibration_result.xml")) skip();
    const char *files[1] = {path};
    must_read(files, 1);
    static const double camera[9] = {3452.3929068729908,      3449.9242930993751,     587.17314727289579,
                                     521.44602565518824,      -0.22226531001384053,   -0.86613346033377336,
                                     -0.00072783909763891115, -0.0016883927279082831, 3.1254596570907323};
    static const double projector[9] = {3953.6715586677710,     3893.2555903450616,    737.17018407542582,
                                        1357.8282322407788,     -0.017162592057261047, -0.44380955516981602,
                                        -0.0093888885948872104, -0.021299637587114260, 1.6984855309227804};
    static const double r[9] = {9.9995961310770576e-01,  8.9872990011441688e-03,  2.4701242572249633e-05,
                                -8.9613393813132575e-03, 9.9685483491258131e-01,  7.8740920161649047e-02,
                                6.8304464003145823e-04,  -7.8737961416805169e-02, 9.9689511328020131e-01};
    static const double t[3] = {85.737214348908466, -630.45718819563251, -100.84398390544085};
    check_optics(&calibration.camera, camera);
    check_optics(&calibration.projector, projector);
    check_motion(r, t);
    assert_int_equal(calibration.camera.width, 1280);
    assert_int_equal(calibration.camera.height, 1024);
    assert_int_equal(calibration.projector.width, 0); // the file does not hold it
    ffp_calibration_free(&calibration);
}

static void test_kamino_camera(void **state) {
    (void)state;
    char path[1024];
    if (!shared_path(path, "real/kamino410/camera_config.json")) skip();
    const char *files[1] = {path};
    assert_false(ffp_calibration_read(&calibration, files, 1, "calib", &err));
    assert_non_null(strstr(err.text, "no projector"));
    static const double camera[9] = {744.28131657550921,     741.75005593111871,     634.20304411679251,
                                     473.02271766788994,     0.10413316741390001,    -0.19298568692969287,
                                     -0.0024351534498466571, -0.0037207368895754681, 0.045958660060315654};
    check_optics(&calibration.camera, camera);
    assert_int_equal(calibration.camera.width, 1280);
    assert_int_equal(calibration.camera.height, 960);
    ffp_calibration_free(&calibration);
}

static void test_single_shot(void **state) {
    (void)state;
    char path[1024];
    if (!shared_path(path, "real/single-shot/calibration.yml")) skip();
    const char *files[1] = {path};
    must_read(files, 1); // and calib-info.yml beside it
    static const double camera[9] = {1062.3851647961446,    1058.5049687961705,   377.41808850498359,
                                     240.86524964821305,    0.14419662804711039,  -0.28467981864303266,
                                     0.0039616833166099151, 0.021863720048648814, 0};
    static const double projector[9] = {1565.7493424076338,    1573.5165998191626,    425.05597178389257,
                                        634.44386408130072,    0.042019404871502367,  -0.065585907442399657,
                                        0.0062781979188117881, 0.0048493906228291583, 0};
    static const double r[9] = {9.4799711626424188e-01,  5.8075043831443442e-02, -3.1293570719663422e-01,
                                -5.7701632411279187e-02, 9.9827904706478798e-01, 1.0462590907243025e-02,
                                3.1300477499833013e-01,  8.1383951363050017e-03, 9.4971668267586529e-01};
    static const double t[3] = {419.69102944735272, -247.25117517463349, 80.292682326192221};
    check_optics(&calibration.camera, camera);
    check_optics(&calibration.projector, projector); // its principal point lies below its 600 rows
    check_motion(r, t);
    assert_int_equal(calibration.camera.width, 640);
    assert_int_equal(calibration.camera.height, 480);
    assert_int_equal(calibration.projector.width, 800);
    assert_int_equal(calibration.projector.height, 600);
    ffp_calibration_free(&calibration);
    char simulated[1024];
    assert_true(shared_path(simulated, "real/single-shot/simulation_ground_truth.yml"));
    files[0] = simulated;
    must_read(files, 1);
    near(calibration.camera.fx, 625.64839371505070);
    near(calibration.projector.cy, 554.76959823121729 + 0.5);
    ffp_calibration_free(&calibration);
}

// --- Broken ones. ---

static const char good[] = "%YAML:1.0\n---\n"
                           "camK: !!opencv-matrix\n   rows: 3\n   cols: 3\n   dt: d\n"
                           "   data: [ 100., 0., 31.5, 0., 100., 23.5, 0., 0., 1. ]\n"
                           "camKc: !!opencv-matrix\n   rows: 1\n   cols: 4\n   dt: d\n"
                           "   data: [ 0.1, 0.2, 0., 0. ]\n"
                           "prjK: [ [ 90, 0, 15 ], [ 0, 90, 11 ], [ 0, 0, 1 ] ]\n"
                           "R: [ 1, 0, 0, 0, 1, 0, 0, 0, 1 ]\nT: [ 1, 0, 0 ]\n";

// The good file with the first `old` replaced.
static void must_refuse(const char *old, const char *fresh, const char *what) {
    char text[4096];
    const char *place = strstr(good, old), *files[1] = {in_scratch("bad.yml")};
    assert_non_null(place);
    snprintf(text, sizeof text, "%.*s%s%s", (int)(place - good), good, fresh, place + strlen(old));
    write_text("bad.yml", text);
    must_fail(files, 1, what);
    assert_non_null(strstr(err.text, "bad.yml"));
}

static void test_good(void **state) {
    (void)state;
    write_text("good.yml", good);
    const char *files[1] = {in_scratch("good.yml")};
    must_read(files, 1);
    near(calibration.camera.cx, 32);
    near(calibration.projector.fy, 90);
    near(calibration.p2c[3], -1);
    ffp_calibration_free(&calibration);
    write_text("good.yml",
               "camK: [ '100,0,31.5; 0,100,23.5; 0,0,1' ]\nprjK: [ '90, 0,15', '0.0, 90.0,11.0', '0 0 1' ]\n"
               "R: [ 1, 0, 0, 0, 1, 0, 0, 0, 1 ]\nT: [ '1,0,0' ]\n");
    must_read(files, 1);
    near(calibration.camera.cx, 32);
    near(calibration.projector.fy, 90);
    ffp_calibration_free(&calibration);
}

static void test_bad_fields(void **state) {
    (void)state;
    must_refuse("100., 0., 31.5", "0., 0., 31.5", "camK");
    must_refuse("100., 0., 31.5", ".nan, 0., 31.5", "camK.data[0]");
    must_refuse("100., 0., 31.5", "1e400, 0., 31.5", "camK.data[0]");
    must_refuse("100., 0., 31.5", "1e300, 0., 31.5", "camK.data[0]");
    must_refuse("100., 0., 31.5", "-100., 0., 31.5", "focal lengths");
    must_refuse("100., 0., 31.5", "100., 3., 31.5", "skewed");
    must_refuse("100., 0., 31.5", "100., 0., 1e8", "principal point");
    must_refuse("0., 0., 1. ]", "0., 1., 1. ]", "not a camera matrix");
    must_refuse("rows: 3", "rows: 4", "holds 9 numbers");
    must_refuse("rows: 3", "rows: 4000000000", "camK.rows");
    must_refuse("rows: 3", "rows: -3", "camK.rows");
    must_refuse("rows: 3", "rows: three", "must be a number");
    must_refuse("   rows: 3\n", "", "missing field");
    must_refuse("dt: d", "dt: \"2d\"", "single-channel");
    must_refuse("[ 0.1, 0.2, 0., 0. ]", "[ 0.1, 0.2, 0. ]", "holds 3 numbers");
    must_refuse("cols: 4\n   dt: d\n   data: [ 0.1, 0.2, 0., 0. ]",
                "cols: 8\n   dt: d\n   data: [ 0.1, 0.2, 0., 0., 0., 1., 0., 0. ]",
                "unknown distortion model");
    must_refuse("100., 0., 31.5", "100,5, 0., 31,5",
                "holds 11 numbers, but the matrix has 3 x 3: decimals take a point");
    must_refuse("[ [ 90, 0, 15 ]", "[ [ '90,5', 0, 15 ]", "prjK[0][0]");
    must_refuse("[ [ 90, 0, 15 ]", "[ [ '90,5', 0, 15 ]", "decimals take a point");
    must_refuse("[ 0.1, 0.2, 0., 0. ]", "\"0,1 0,2\"", "decimals take a point");
    must_refuse("[ 0, 90, 11 ]", "[ 0, 90 ]", "different lengths");
    must_refuse("R: [ 1, 0", "R: [ 1, 0.3", "not rigid");
    must_refuse("R: [ 1,", "R: [ -1,", "mirrors");
    must_refuse("R: [ 1, 0, 0, 0, 1, 0, 0, 0, 1 ]\n", "", "without a rotation");
    must_refuse("T: [ 1, 0, 0 ]\n", "", "without a translation");
    must_refuse("T: [ 1, 0, 0 ]", "T: [ 1, 0 ]", "expected 3 x ");
    must_refuse("T: [ 1, 0, 0 ]", "T: { a: 1 }", "T.rows");
    must_refuse("R: [", "rotation: [1]\nR: [", "means the same as rotation");
    must_refuse("prjK: [ [ 90, 0, 15 ], [ 0, 90, 11 ], [ 0, 0, 1 ] ]\n", "", "no projector");
    must_refuse("R: [ 1, 0, 0, 0, 1, 0, 0, 0, 1 ]\nT: [ 1, 0, 0 ]\n", "", "stereo-calibrate");
    must_refuse("camK:", "prjK:", "key is repeated");
    must_refuse("camK:", "Q:", "without a camera matrix");
}

// Keys of tools that nobody told us of: by what they hold, and whose they are.
static void test_unknown_keys(void **state) {
    (void)state;
#define OF_CAMERA "[[100, 0, 31.5], [0, 100, 23.5], [0, 0, 1]]"
#define OF_PROJECTOR "[[90, 0, 15], [0, 90, 11], [0, 0, 1]]"
#define NO_TURN "[[1, 0, 0], [0, 1, 0], [0, 0, 1]]"
    static const char *const texts[] = {
        ("pro_K: [90, 0, 15, 0, 90, 11, 0, 0, 1]\npro_kc: [0, 0, 0, 0]\npro_size: [30, 22]\n"
         "cam_K: " OF_CAMERA "\ncam_kc: [0.1, 0, 0, 0]\ncam_size: [64, 48]\n"
         "R1: " NO_TURN "\nR: [1, 0, 0, 0, 1, 0, 0, 0, 1]\nR2: " NO_TURN "\nT: [1, 0, 0]\nerror: 0.3\n"),
        ("projector_matrix: " OF_PROJECTOR "\nCameraMatrix: " OF_CAMERA "\nrot_cam_to_proj: " NO_TURN
         "\ntrans_cam_to_proj: [1, 0, 0]\ndate: today\n"),
        ("{\"K_left\": " OF_CAMERA ", \"K_right\": " OF_PROJECTOR ", \"om\": " NO_TURN ", \"t\": [1, 0, 0]}"),
        ("{\"cam_K_1280\": " OF_CAMERA ", \"proj_K_1920\": " OF_PROJECTOR ", \"R\": " NO_TURN
         ", \"T\": [1, 0, 0]}")};
    const char *files[1] = {in_scratch("other.yml")};
    for (size_t i = 0; i < sizeof texts / sizeof *texts; i++) {
        write_text("other.yml", texts[i]);
        must_read(files, 1);
        near(calibration.camera.cx, 32);
        near(calibration.projector.fy, 90);
        near(calibration.p2c[3], -1);
        assert_int_equal(calibration.projector.width, i == 0 ? 30 : 0);
        ffp_calibration_free(&calibration);
    }
    write_text("other.yml", "intrinsics: [[90, 0, 15], [0, 90, 11], [0, 0, 1]]\nRT: [1, 2]\n");
    must_fail(files, 1, "intrinsics, RT: none of the keys");
}

static void test_bad_documents(void **state) {
    (void)state;
    static const struct {
        const char *text, *what;
    } cases[] = {
        {"", "empty"},
        {"\n\n", "empty"},
        {"%YAML:1.0\n---\n", "contains no keys"},
        {"just words", "contains no keys"},
        {"a: 1\n---\nb: 2\n", "second document"},
        {"a: 1\nb: 2\n", "none of the keys"},
        {"camK: [1, 2", "broken YAML"},
        {"camK: &m [1]\nprjK: *m\n", "aliases"},
        {"a: [[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[", "broken YAML"},
        {"? [a]\n: 1\n", "a key must be a string"},
        {"{\"camK\": ", "broken JSON"},
        {"{\"camK\": 1, \"camK\": 2}", "broken JSON"},
        {"[]", "missing item"},
        {"<a><b></a>", "broken XML"},
        {"<opencv_storage><camK><rows>3</rows>", "broken XML"},
        {"<a>text<b>1</b></a>", "both text and elements"},
        {"<a><b>1</b><b>2</b></a>", "duplicate element"},
        {"<a><_>1</_><b>2</b></a>", "items called _"},
        {"<!DOCTYPE a [<!ENTITY x \"xxxx\">]><a>&x;</a>", "entities"},
        {"<a>1 2 3</a>", "1 entries"},
        {"<a>nothing</a>", "contains no keys"},
        {"\xff\xfe\x01", "UTF-16"},
        {"\xfd\x01", "broken YAML"},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        write_text("bad.any", cases[i].text);
        const char *files[1] = {in_scratch("bad.any")};
        const bool ok = ffp_calibration_read(&calibration, files, 1, "calib", &err);
        ffp_calibration_free(&calibration);
        // A list of numbers is not a list of cameras, in whatever words.
        if (ok || (i != 19 && !strstr(err.text, cases[i].what)))
            printf("%s: expected \"%s\", got: %s\n", cases[i].text, cases[i].what, err.text);
        assert_false(ok);
        assert_true(i == 19 || strstr(err.text, cases[i].what));
        assert_non_null(strstr(err.text, "bad.any"));
    }
}

// Every prefix of the good file, and of it as XML, is read or refused without harm.
static void test_truncated(void **state) {
    (void)state;
    static const char xml[] =
        "<?xml version=\"1.0\"?><opencv_storage><img_shape type_id=\"opencv-matrix\"><rows>2</rows><cols>1"
        "</cols><dt>d</dt><data>48. 64.</data></img_shape><cam_int><rows>3</rows><cols>3</cols><dt>d</dt>"
        "<data>1 0 0 0 1 0 0 0 1</data></cam_int></opencv_storage>";
    const char *const texts[2] = {good, xml};
    for (int k = 0; k < 2; k++) {
        int refused = 0;
        const size_t length = strlen(texts[k]);
        for (size_t n = 0; n < length; n++) {
            write_bytes("cut", texts[k], n);
            const char *files[1] = {in_scratch("cut")};
            refused += !ffp_calibration_read(&calibration, files, 1, "calib", &err);
            ffp_calibration_free(&calibration);
        }
        // A file cut after the last bracket or within the last line's space is still complete.
        assert_true(refused >= (int)length - 2);
    }
}

// Random bytes changed, doubled and dropped: read or refused with a place, without harm.
static void test_mutated(void **state) {
    (void)state;
    static const char lists[] =
        "[{\"view_id\": 1, \"width\": 8, \"height\": 8, \"K\": [[9,0,4],[0,9,4],[0,0,1]], "
        "\"rotation\": [[1,0,0],[0,1,0],[0,0,1]], \"position\": [0,0,-3]}]";
    static const char frames[] =
        "{\"K_cam\": [[9,0,4],[0,9,4],[0,0,1]], \"K_proj\": [[9,0,4],[0,9,4],[0,0,1]], \"frames\": "
        "[{\"view_id\": "
        "\"0000\", \"file_path\": \"a\", \"RT\": [[1,0,0,0],[0,1,0,0],[0,0,1,0],[0,0,0,1]]}], "
        "\"blender_matrix_world_proj\": [[1,0,0,0],[0,1,0,0],[0,0,1,0],[0,0,0,1]]}";
    static const char xml[] =
        "<?xml version=\"1.0\"?><o><cam_int><rows>3</rows><cols>3</cols><dt>d</dt><data>9 0 4 0 9 "
        "4 0 0 1</data></cam_int><cam_dist><_>0.1</_><_>0</_><_>0</_><_>0</_></cam_dist></o>";
    const char *const texts[4] = {good, lists, frames, xml};
    FfpRng rng = ffp_rng(11, 0);
    for (int i = 0; i < 1200; i++) {
        char text[2048];
        size_t length = strlen(texts[i % 4]);
        memcpy(text, texts[i % 4], length);
        for (int k = 0; k < 1 + i % 5; k++) {
            const size_t at = ffp_rng_below(&rng, (uint32_t)length), kind = ffp_rng_below(&rng, 3);
            if (kind == 0) text[at] = (char)ffp_rng_below(&rng, 256);
            if (kind == 1) memmove(text + at, text + at + 1, --length - at);
            if (kind == 2) memmove(text + at + 1, text + at, length++ - at);
        }
        write_bytes("mutant", text, length);
        const char *files[1] = {in_scratch("mutant")};
        err.text[0] = 0;
        const bool ok = ffp_calibration_read(&calibration, files, 1, "calib", &err);
        ffp_calibration_free(&calibration);
        assert_true(ok || strstr(err.text, "mutant"));
    }
}

static void test_two_files(void **state) {
    (void)state;
    write_text("good.yml", good);
    write_text("sizes.yml", "camW: 64\ncamH: 48\nprjW: 32\nprjH: 24\n");
    write_text("other.yml", "camW: 65\ncamH: 48\n");
    char paths[3][64];
    static const char *const names[3] = {"good.yml", "sizes.yml", "other.yml"};
    for (int i = 0; i < 3; i++) snprintf(paths[i], sizeof paths[i], "%s", in_scratch(names[i]));
    const char *files[3] = {paths[0], paths[1], paths[2]};
    must_read(files, 2);
    assert_int_equal(calibration.camera.width, 64);
    assert_int_equal(calibration.projector.height, 24);
    ffp_calibration_free(&calibration);
    must_fail(files, 3, "64 x 48 were given before");
    const char *const twice[2] = {paths[0], paths[0]};
    must_fail(twice, 2, "already given by another file");
    const char *const none[1] = {"no/such/file.yml"};
    must_fail(none, 1, "no/such/file.yml");
    const char *const folder[1] = {"."};
    must_fail(folder, 1, "cameras.txt");
}

// --- Other tools' files of a camera and a projector, each with the same figures. ---

static void check_pair(void) {
    static const double camera[9] = {272, 273, 135.5, 97.75, -0.125, 0.05, 0.001, -0.002},
                        projector[9] = {254, 255, 157.5, 109.5};
    static const double r[9] = {0, -1, 0, 1, 0, 0, 0, 0, 1}, t[3] = {-100, 90, 35};
    check_optics(&calibration.camera, camera);
    check_optics(&calibration.projector, projector);
    check_motion(r, t);
    ffp_calibration_free(&calibration);
}

#define MATRIX(name, rows, cols, data)                                                                       \
    name ":\n  rows: " #rows "\n  cols: " #cols "\n  dt: d\n  data: [" data "]\n"
#define CAMERA "272, 0, 135.5, 0, 273, 97.75, 0, 0, 1"
#define PROJECTOR "254, 0, 157.5, 0, 255, 109.5, 0, 0, 1"
#define LENS "-0.125, 0.05, 0.001, -0.002, 0"
#define R "0, -1, 0, 1, 0, 0, 0, 0, 1"
#define T "-100, 90, 35"

static void test_other_tools(void **state) {
    (void)state;
    const char *one[3] = {in_scratch("a.yaml")};
    char first[256], second[256];
    // OpenCV's stereo sample: two files.
    snprintf(first, sizeof first, "%s", in_scratch("intrinsics.yml"));
    snprintf(second, sizeof second, "%s", in_scratch("extrinsics.yml"));
    const char *two[2] = {first, second};
    write_text("intrinsics.yml", "%YAML:1.0\n---\n" MATRIX("M1", 3, 3, CAMERA) MATRIX("D1", 1, 5, LENS)
                                     MATRIX("M2", 3, 3, PROJECTOR) MATRIX("D2", 1, 4, "0, 0, 0, 0"));
    write_text("extrinsics.yml", "%YAML:1.0\n---\n" MATRIX("R", 3, 3, R) MATRIX("T", 3, 1, T));
    must_read(two, 2);
    check_pair();
    write_text("intrinsics.yml", MATRIX("cameraMatrix1", 3, 3, CAMERA) MATRIX("distCoeffs1", 1, 5, LENS)
                                     MATRIX("cameraMatrix2", 3, 3, PROJECTOR));
    must_read(two, 2);
    check_pair();
    // ROS: a file for each device, by its name or in their order, and the motion from elsewhere.
    char ros[3][256];
    for (int named = 0; named < 2; named++) {
        snprintf(ros[0], sizeof ros[0], "%s", in_scratch("camera.yaml"));
        snprintf(ros[1], sizeof ros[1], "%s", in_scratch("projector.yaml"));
        const char *files[3] = {named ? ros[1] : ros[0], named ? ros[0] : ros[1], second};
        write_text("camera.yaml",
                   "image_width: 267\nimage_height: 200\ncamera_name: left\n" MATRIX(
                       "camera_matrix", 3, 3,
                       CAMERA) "distortion_model: plumb_bob\n" MATRIX("distortion_coefficients", 1, 5, LENS));
        write_text("projector.yaml", "image_width: 320\nimage_height: 200\ncamera_name: projector\n" MATRIX(
                                         "camera_matrix", 3, 3, PROJECTOR));
        must_read(files, 3);
        assert_true(calibration.camera.width == 267 && calibration.projector.width == 320);
        check_pair();
        must_fail(files, 2, "give the file that has R and T");
    }
    write_text("camera.yaml", MATRIX("camera_matrix", 3, 3, CAMERA) "distortion_model: equidistant\n");
    two[0] = ros[0];
    must_fail(two, 2, "distortion_model");
    snprintf(first, sizeof first, "%s", in_scratch("a.yaml"));
    one[0] = first;
    write_text("a.yaml",
               "cam0:\n  distortion_model: radtan\n  distortion_coeffs: [-0.125, 0.05, 0.001, -0.002]\n"
               "  intrinsics: [272, 273, 135.5, 97.75]\n  resolution: [267, 200]\n"
               "cam1:\n  T_cn_cnm1:\n  - [0, -1, 0, -100]\n  - [1, 0, 0, 90]\n  - [0, 0, 1, 35]\n"
               "  - [0, 0, 0, 1]\n  intrinsics: [254, 255, 157.5, 109.5]\n  resolution: [320, 200]\n");
    must_read(one, 1);
    assert_true(calibration.camera.height == 200 && calibration.projector.width == 320);
    check_pair();
    write_text("a.yaml", "cam0:\n  distortion_model: equidistant\n  intrinsics: [272, 273, 135.5, 97.75]\n"
                         "cam1:\n  intrinsics: [254, 255, 157.5, 109.5]\n");
    must_fail(one, 1, "distortion_model");
    write_text("a.yaml",
               "cam0:\n  camera_model: omni\n  intrinsics: [1, 272, 273, 135.5, 97.75]\ncam1: {}\n");
    must_fail(one, 1, "camera_model");
    write_text("a.yaml",
               MATRIX("Kc", 3, 3, CAMERA) MATRIX("kc", 1, 5, LENS) MATRIX("Kp", 3, 3, PROJECTOR)
                   MATRIX("kp", 1, 5, "0, 0, 0, 0, 0") MATRIX("Rp", 3, 3, R)
                       MATRIX("Tp", 3, 1,
                              T) "frameWidth: 267\nframeHeight: 200\nscreenResX: 320\nscreenResY: 200\n");
    must_read(one, 1);
    assert_true(calibration.camera.width == 267 && calibration.projector.height == 200);
    check_pair();
    write_bytes("a.yaml", "PK\3\4\24\0\0\0", 8);
    must_fail(one, 1, "is a numpy archive");
    write_text("a.yaml", "x: 1\n");
    must_fail(one, 1, "camKc, prjKc");
}

// --- COLMAP. ---

// The lens of OpenCV with more terms, of which the further ones are 0; views in folders of their own.
static void test_colmap_in_folders(void **state) {
    (void)state;
    char folder[256];
    snprintf(folder, sizeof folder, "%s", scratch);
    const char *const file = folder;
    write_text("cameras.txt", "1 FULL_OPENCV 64 48 50 51 32 24 0.1 0.02 0.003 0.004 0.05 0 0 0\n");
    write_text("images.txt",
               "1 1 0 0 0 0 0 0 1 000/white.png\n1.5 2 -1 3 4.5 7\n2 1 0 0 0 1 0 0 1 045/white.png\n\n"
               "3 1 0 0 0 2 0 0 1 calib.png\n\n");
    must_read(&file, 1);
    assert_int_equal(calibration.n_stops, 2);
    assert_string_equal(calibration.stops[0].id, "000");
    assert_string_equal(calibration.stops[1].id, "045");
    near(calibration.stops[0].camera.lens[4], 0.05);
    ffp_calibration_free(&calibration);
    write_text("cameras.txt", "1 FULL_OPENCV 64 48 50 51 32 24 0.1 0.02 0.003 0.004 0.05 0 0.1 0\n");
    must_fail(&file, 1, "k4, k5 or k6");
}

static void must_refuse_colmap(const char *cameras, const char *images, const char *what) {
    assert_true(ffp_make_folders(in_scratch("model"), NULL));
    write_text("model/cameras.txt", cameras);
    write_text("model/images.txt", images);
    const char *files[1] = {in_scratch("model")};
    must_fail(files, 1, what);
}

// A camera of a model that is not read matters where an image has it.
static void test_unused_camera_of_colmap(void **state) {
    (void)state;
    static const char unused[] = "1 PINHOLE 64 48 50 51 32 24\n3 FOV 9 9 5 5 4 4 0.9\n";
    static const char images[] = "1 1 0 0 0 0 0 0 1 calib.png\n\n2 1 0 0 0 0 0 1 %d a.png\n\n";
    const char *const folder[1] = {in_scratch("model")};
    char text[sizeof images];
    snprintf(text, sizeof text, images, 3);
    must_refuse_colmap(unused, text, "FOV");
    snprintf(text, sizeof text, images, 1);
    write_text("model/images.txt", text);
    must_read(folder, 1);
    ffp_calibration_free(&calibration);
}

static void test_bad_colmap(void **state) {
    (void)state;
    static const char cameras[] = "# a comment\n1 PINHOLE 64 48 50 51 32 24\n";
    static const char images[] = "1 1 0 0 0 0 0 0 1 calib.png\n\n2 1 0 0 0 0 0 1 1 a.png\n\n";
    must_refuse_colmap("", images, "no camera");
    must_refuse_colmap(cameras, "", "no image");
    must_refuse_colmap("1 OPENCV_FISHEYE 64 48 50 50 32 24 0 0 0 0\n", images, "OPENCV_FISHEYE");
    must_refuse_colmap("1 PINHOLE 64 48 50 51 32\n", images, "wrong number of camera parameters");
    must_refuse_colmap("1 PINHOLE 64 48 50 51 32 nan\n", images, "not a number");
    must_refuse_colmap("1 PINHOLE 64 48 0 51 32 24\n", images, "not positive");
    must_refuse_colmap("1 PINHOLE 99999999999999999999 48 50 51 32 24\n", images, "invalid width or height");
    must_refuse_colmap(cameras, "1 1 0 0 0 0 0 0 1 a.png\n\n", "0 images are called 'calib'");
    must_refuse_colmap(cameras, "1 1 0 0 0 0 0 0 1 calib.png\n\n2 1 0 0 0 0 0 1 1 a/calib.png\n\n",
                       "2 images");
    must_refuse_colmap(cameras, "1 1 0 0 0 0 0 0 1 calib.png\n\n", "0 views");
    must_refuse_colmap(cameras, "1 1 0 0 0 0 0 0 7 calib.png\n\n2 1 0 0 0 0 0 1 1 a.png\n\n", "camera 7");
    must_refuse_colmap(cameras, "1 3 0 0 0 0 0 0 1 calib.png\n\n", "quaternion");
    must_refuse_colmap(cameras, "1 1 0 0 0 inf 0 0 1 calib.png\n\n", "seven numbers");
    must_refuse_colmap(cameras, "1 1 0 0\n", "seven numbers");
    must_refuse_colmap(cameras,
                       "1 1 0 0 0 0 0 0 1 calib.png\n2 1 0 0 0 0 0 1 1 a.png\n3 1 0 0 0 0 0 1 1 b.png\n",
                       "or an empty line");
    must_refuse_colmap(
        cameras, "1 1 0 0 0 0 0 0 1 calib.png\n\n2 1 0 0 0 0 0 1 1 a.png\n\n3 1 0 0 0 0 0 1 1 a.jpg\n\n",
        "duplicate view 'a'");
}

// --- Lists of cameras and frames. ---

static const char projector_list[] =
    "[{\"width\": 32, \"height\": 24, \"R\": [[1,0,0],[0,1,0],[0,0,1]], \"T\": [0,0,0], "
    "\"K\": [[30,0,16],[0,30,12],[0,0,1]]}]";

static void test_bad_lists(void **state) {
    (void)state;
    static const struct {
        const char *text, *what;
    } cases[] = {
        {"[{\"rotation\": 1}]", "[0].view_id"},
        {"[{\"rotation\": 1, \"view_id\": 1}]", "[0].width"},
        {"[{\"rotation\": [[1,0,0],[0,1,0],[0,0,2]], \"position\": [0,0,0], \"view_id\": \"a\", \"width\": "
         "8, "
         "\"height\": 8, \"K\": [[1,0,0],[0,1,0],[0,0,1]]}]",
         "not rigid"},
        {"[{\"rotation\": [[1,0,0],[0,1,0],[0,0,1]], \"position\": [0,0], \"view_id\": \"a\", \"width\": 8, "
         "\"height\": 8, \"K\": [[1,0,0],[0,1,0],[0,0,1]]}]",
         "[0].position"},
        {"{\"frames\": []}", "0 entries"},
        {"{\"frames\": [{}]}", "K_cam"},
        {"{\"frames\": 7}", "must be an array"},
    };
    write_text("projector.json", projector_list);
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        write_text("bad.json", cases[i].text);
        char bad[64], lamp[64];
        snprintf(bad, sizeof bad, "%s", in_scratch("bad.json"));
        snprintf(lamp, sizeof lamp, "%s", in_scratch("projector.json"));
        const char *const files[2] = {bad, lamp};
        must_fail(files, 2, cases[i].what);
    }
    const char *const alone[1] = {in_scratch("projector.json")};
    must_fail(alone, 1, "no camera");
}

// An id is what it says; a file's name gives one without folder and ending.
static void test_names_of_views(void **state) {
    (void)state;
    static const struct {
        const char *key, *names[2], *ids[2];
    } cases[] = {{"view_id", {"cam.1", "cam.2"}, {"cam.1", "cam.2"}},
                 {"id", {"0.5m", "0.7m"}, {"0.5m", "0.7m"}},
                 {"img_name", {"a/img.1.png", "b/img.2.png"}, {"img.1", "img.2"}}};
    char list[64], lamp[64], text[1024];
    write_text("projector.json", projector_list);
    snprintf(list, sizeof list, "%s", in_scratch("list.json"));
    snprintf(lamp, sizeof lamp, "%s", in_scratch("projector.json"));
    const char *const files[2] = {list, lamp};
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        int length = 0;
        for (int k = 0; k < 2; k++)
            length +=
                snprintf(text + length, sizeof text - (size_t)length,
                         "%s{\"%s\": \"%s\", \"width\": 8, \"height\": 8, \"K\": [[9,0,4],[0,9,4],[0,0,1]], "
                         "\"rotation\": [[1,0,0],[0,1,0],[0,0,1]], \"position\": [%d,0,-3]}%s",
                         k ? ", " : "[", cases[i].key, cases[i].names[k], k, k ? "]" : "");
        write_text("list.json", text);
        must_read(files, 2);
        for (int k = 0; k < 2; k++) assert_string_equal(calibration.stops[k].id, cases[i].ids[k]);
        ffp_calibration_free(&calibration);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_kamino),        cmocka_unit_test(test_kamino_camera),
        cmocka_unit_test(test_single_shot),   cmocka_unit_test(test_good),
        cmocka_unit_test(test_bad_fields),    cmocka_unit_test(test_unknown_keys),
        cmocka_unit_test(test_bad_documents), cmocka_unit_test(test_truncated),
        cmocka_unit_test(test_two_files),     cmocka_unit_test(test_mutated),
        cmocka_unit_test(test_other_tools),   cmocka_unit_test(test_colmap_in_folders),
        cmocka_unit_test(test_bad_colmap),    cmocka_unit_test(test_unused_camera_of_colmap),
        cmocka_unit_test(test_bad_lists),     cmocka_unit_test(test_names_of_views),
    };
    return cmocka_run_group_tests(tests, scratch_setup, scratch_teardown);
}
