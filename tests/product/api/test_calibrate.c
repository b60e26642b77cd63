// A rig that was rendered is calibrated back to its truth, its turntable's axis too; what is wrong with
// photographs is said of them.
// Labels: slow
#include <stdio.h>
#include <unistd.h>
#include "board_rig.h"
#include "ffprocams.h"
#include "named.h"
#include "rig/optics/calibration.h"
#include "rig/turntable/turntable.h"

enum { ATTITUDES = 6, STOPS = 7 };
static char notes[65536];
static bool without_opencv;

static void keep_note(void *user, FfpLogLevel level, const char *text) {
    (void)user, (void)level;
    strncat(notes, text, sizeof notes - strlen(notes) - 1);
    strncat(notes, "\n", sizeof notes - strlen(notes) - 1);
}

static void keep_finding(void *user, const FfpFinding *finding) {
    char text[256];
    snprintf(text, sizeof text, "%s %s", finding->code, finding->view ? finding->view : "");
    keep_note(user, FFP_LOG_NOTE, text);
    keep_note(user, FFP_LOG_NOTE, finding->text);
    if (finding->advice) keep_note(user, FFP_LOG_NOTE, finding->advice);
}

static FfpContext *listening(void) {
    FfpContextSettings settings = ffp_context_defaults();
    settings.log = keep_note, settings.finding = keep_finding;
    notes[0] = 0;
    return ffp_context_new(&settings, NULL);
}

static Placed attitude(int i) {
    static const double turns[ATTITUDES][3] = {{0.05, 0.1, 0},   {0.55, 0.1, 0.1},   {-0.5, -0.05, -0.2},
                                               {0.1, 0.6, 0.15}, {-0.1, -0.55, 1.4}, {0.4, -0.4, -0.3}};
    static const double places[ATTITUDES][3] = {{0, 0, 620},   {-30, 20, 640}, {20, -25, 600},
                                                {30, 10, 640}, {-10, 0, 600},  {0, -10, 560}};
    return placed(turns[i][0], turns[i][1], turns[i][2], places[i][0], places[i][1], places[i][2]);
}

static FfpRigCalibration settings_of(const char *const *folders, int n) {
    FfpRigCalibration o = ffp_rig_calibration_defaults();
    o.attitudes = folders, o.n_attitudes = n;
    o.columns = COLUMNS, o.rows = ROWS, o.square = SQUARE;
    o.width = PANEL_W, o.height = PANEL_H;
    return o;
}

// The pictures that faults put in place of others.
static void make_spare(void) {
    const Placed board = attitude(2);
    Placed bare = board;
    FfpRng rng = ffp_rng(3, 1);
    Sample *samples = see(&board);
    char path[FFP_PATH_MAX];
    FfpImage small = ffp_image_new(200, 100, 1), full = ffp_image_new(CAMERA_W, CAMERA_H, 1);
    for (int i = 0; i < CAMERA_W * CAMERA_H; i++) full.data[i] = 1;
    assert_true(ffp_image_write_png(&small, in_scratch("small.png"), NULL));
    assert_true(ffp_image_write_png(&full, in_scratch("full.png"), NULL));
    ffp_image_free(&small), ffp_image_free(&full);
    for (int i = 0; i < 2; i++) {
        FfpImage pattern = ffp_pattern_gray_code(PANEL_W, PANEL_H, 0, 3, i == 1);
        snprintf(path, sizeof path, "%s/dim_%d.png", scratch, i);
        photograph(samples, &pattern, 0.45, &rng, path);
        ffp_image_free(&pattern);
    }
    ffp_free(samples);
    bare.no_squares = true;
    snprintf(path, sizeof path, "%s/bare", scratch);
    shoot(&bare, path, false);
}

static int setup(void **state) {
    char path[FFP_PATH_MAX];
    if (scratch_setup(state) != 0) return 1;
    // A missing OpenCV shows before anything else is looked at.
    FfpRigCalibration o = ffp_rig_calibration_defaults();
    FfpError err = {0};
    without_opencv = !ffp_calibrate_rig(NULL, &o, NULL, &err) && err.code == FFP_ERROR_UNSUPPORTED;
    if (without_opencv) {
        printf("skipped: %s\n", err.text);
        return !strstr(err.text, "libopencv-calib3d-dev");
    }
    if (mkdir(in_scratch("shots"), 0777) != 0) return 1;
    for (int i = 0; i < ATTITUDES; i++) {
        const Placed board = attitude(i);
        snprintf(path, sizeof path, "%s/shots/pose_%d", scratch, i);
        shoot(&board, path, i % 2 == 1); // both orders of black and white
    }
    make_spare();
    return 0;
}

#define NEEDS_OPENCV()                                                                                       \
    (void)state;                                                                                             \
    if (without_opencv) skip()

static double relative(double found, double truth) {
    return fabs(found / truth - 1);
}

static double off_degrees(const double a[9], const double b[9]) {
    double d[9], v[3];
    ffp_rotation_difference(a, b, d);
    ffp_rotation_to_vector(d, v);
    return sqrt(ffp_dot(v, v)) * 180 / FFP_PI_DOUBLE;
}

// By how much a device puts a ray elsewhere than the truth does, the farthest over the corners of its picture
// drawn in by a fifth.
static double lens_off(const FfpOptics *found, const Device *truth, int width, int height) {
    double most = 0;
    for (int k = 0; k < 4; k++) {
        double ray[3], u, v;
        undistorted(truth, width * (k % 2 ? 0.8 : 0.2), height * (k / 2 ? 0.8 : 0.2), ray);
        ffp_lens_distort(found->lens, ray[0], ray[1], &u, &v);
        most = worse(most, hypot(found->fx * u + found->cx - 0.5 - width * (k % 2 ? 0.8 : 0.2),
                                 found->fy * v + found->cy - 0.5 - height * (k / 2 ? 0.8 : 0.2)));
    }
    return most;
}

static void check_file(const char *path) {
    FfpCalibration found;
    FfpError err = {0};
    double truth[9], r[9], c2p[9], t[3];
    if (!ffp_calibration_read(&found, &path, 1, NULL, &err)) fail_msg("%s", err.text);
    assert_true(found.camera.width == CAMERA_W && found.camera.height == CAMERA_H);
    assert_true(found.projector.width == PANEL_W && found.projector.height == PANEL_H);
    printf("camera %.2f %.2f %.2f %.2f, projector %.2f %.2f %.2f %.2f; off by %.2f and %.2f pixels\n",
           found.camera.fx, found.camera.fy, found.camera.cx - 0.5, found.camera.cy - 0.5, found.projector.fx,
           found.projector.fy, found.projector.cx - 0.5, found.projector.cy - 0.5,
           lens_off(&found.camera, &camera, CAMERA_W, CAMERA_H),
           lens_off(&found.projector, &projector, PANEL_W, PANEL_H));
    assert_true(relative(found.camera.fx, camera.fx) < 0.005 && relative(found.camera.fy, camera.fy) < 0.005);
    assert_true(relative(found.projector.fx, projector.fx) < 0.01);
    assert_true(relative(found.projector.fy, projector.fy) < 0.01);
    ffp_rotation_from_vector(c2p_turn, truth);
    for (int i = 0; i < 9; i++) r[i] = found.p2c[4 * (i / 3) + i % 3];
    for (int i = 0; i < 9; i++) c2p[i] = r[3 * (i % 3) + i / 3];
    for (int i = 0; i < 3; i++)
        t[i] = -(c2p[3 * i] * found.p2c[3] + c2p[3 * i + 1] * found.p2c[7] + c2p[3 * i + 2] * found.p2c[11]);
    printf("turn off by %.3f degrees, shift by %.2f %.2f %.2f\n", off_degrees(c2p, truth),
           t[0] - c2p_shift[0], t[1] - c2p_shift[1], t[2] - c2p_shift[2]);
    assert_true(off_degrees(c2p, truth) < 0.5);
    for (int i = 0; i < 3; i++) assert_true(fabs(t[i] - c2p_shift[i]) < 4);
    assert_true(lens_off(&found.camera, &camera, CAMERA_W, CAMERA_H) < 3);
    ffp_calibration_free(&found);
}

static void a_rig_comes_back(void **state) {
    NEEDS_OPENCV();
    const char *forms[2] = {"rig.xml", "rig.yml"};
    for (int form = 0; form < 2; form++) {
        char file[FFP_PATH_MAX], report[FFP_PATH_MAX], *text;
        const char *folder = in_scratch("shots");
        size_t size;
        snprintf(file, sizeof file, "%s/%s", scratch, forms[form]);
        snprintf(report, sizeof report, "%s/report.html", scratch);
        FfpRigCalibration o = settings_of(&folder, 1);
        FfpRigCalibrationStats stats;
        FfpError err = {0};
        o.file = file, o.report = report;
        o.fix_camera = o.fix_projector = FFP_FIX_K3;
        if (!ffp_calibrate_rig(NULL, &o, &stats, &err)) fail_msg("%s", err.text);
        assert_true(stats.attitudes == ATTITUDES && stats.used == ATTITUDES && !stats.has_axis);
        printf("rms %.3f (camera %.3f, projector %.3f), %d of %d corners left out\n", stats.both,
               stats.camera, stats.projector, stats.left_out, stats.corners);
        assert_true(stats.camera < 0.12 && stats.projector < 0.12 && stats.both < 0.15);
        assert_true(stats.left_out < stats.corners / 10);
        check_file(file);
        assert_true(ffp_read_text(report, 1 << 24, &text, &size, &err));
        assert_non_null(strstr(text, "pose_5: the camera's errors"));
        assert_null(strstr(text, "http"));
        ffp_free(text);
    }
}

// --- Faults. ---

// Folders good_0, good_1 and bad: two attitudes as they are, and a third to be spoilt, whose name is
// returned.
static const char *three(const char *name) {
    char command[2048];
    snprintf(command, sizeof command,
             "mkdir '%s/%s' && cp -r '%s/shots/pose_0' '%s/%s/good_0' && cp -r '%s/shots/pose_1' "
             "'%s/%s/good_1' && "
             "cp -r '%s/shots/pose_2' '%s/%s/bad'",
             scratch, name, scratch, scratch, name, scratch, scratch, name, scratch, scratch, name);
    assert_int_equal(system(command), 0);
    return in_scratch(name);
}

static void in_folder(const char *folder, const char *format, ...) {
    char command[3072], text[2048];
    va_list list;
    va_start(list, format);
    vsnprintf(text, sizeof text, format, list);
    va_end(list);
    snprintf(command, sizeof command, "cd '%s' && %s", folder, text);
    assert_int_equal(system(command), 0);
}

// The call fails by this rule (0: by none), with all these words in its error. Unless no photograph was read,
// its finding is passed on, or the one of too few attitudes.
static void refused(FfpRigCalibration *o, FfpRuleId rule, const char *const *words) {
    FfpError err = {0};
    char file[FFP_PATH_MAX];
    snprintf(file, sizeof file, "%s/never.xml", scratch);
    if (!o->file && o->n_attitudes > 0) o->file = file;
    FfpContext *context = listening();
    assert_false(ffp_calibrate_rig(context, o, NULL, &err));
    ffp_context_free(context);
    must_be(&err, rule);
    const bool read = rule && rule != FFP_RULE_RAW_AND_JPEG;
    if (read && !strstr(notes, err.finding) && !strstr(notes, "too-few-usable"))
        fail_msg("not told: %s", err.text);
    for (; *words; words++)
        if (!strstr(err.text, *words)) fail_msg("no '%s' in: %s", *words, err.text);
    assert_false(ffp_is_file(in_scratch("never.xml")));
}
#define REFUSED(o, ...) REFUSED_BY(o, 0, __VA_ARGS__)
#define REFUSED_BY(o, rule, ...) refused(o, rule, (const char *const[]){__VA_ARGS__, NULL})

// A change to a copy of one attitude, whose photographs 1 and 2 are black and white, 3 to 18 codes of columns
// and 19 to 34 of rows; the finding that the error must be, and words that it must contain.
typedef struct Fault {
    const char *command;
    FfpRuleId rule; // 0: the words alone tell
    const char *words[3];
} Fault;

#define SHOT(n) "bad/shot_" #n ".png"
#define SWAP(a, b) "mv " SHOT(a) " x && mv " SHOT(b) " " SHOT(a) " && mv x " SHOT(b)
#define LATE_FROM(n) "cd bad && for i in $(seq 34 -1 " #n "); do cp shot_$((i-1)).png shot_$i.png; done"

static const Fault faults[] = {
    // Photographs that are missing, too many, or no photographs.
    {"rm " SHOT(9) " " SHOT(16) " " SHOT(24), FFP_RULE_COUNT, {"bad: 31 ", " 34"}},
    {"for i in b c d; do cp bad/shot_9.png bad/shot_9$i.png; done", FFP_RULE_COUNT, {"bad: 37 ", " 34"}},
    {"rm bad/*", 0, {"no photographs in this folder or its subfolders"}},
    {"rm -r bad", 0, {"no photographs in this folder or its subfolders"}},
    {"head -c 500 bad/shot_5.png > x && mv x bad/shot_5.png", FFP_RULE_TOO_FEW, {"bad: ", "bad/shot_5.png"}},
    {"printf GIF89a > bad/shot_6.png", FFP_RULE_TOO_FEW, {"bad: ", "bad/shot_6.png"}},
    {": > bad/shot_7.png", FFP_RULE_TOO_FEW, {"bad: file is empty", "bad/shot_7.png"}},
    {"for f in bad/*; do : > ${f%.png}.CR2; done", FFP_RULE_RAW_AND_JPEG, {"34 ", "shot_1.CR2"}},
    {"for f in bad/*; do cp $f ${f%.png}.jpg; done", FFP_RULE_RAW_AND_JPEG, {"34 ", "shot_1.jpg"}},
    // Black and white.
    {"mv bad/shot_2.png bad/shot_20b.png", FFP_RULE_NO_PLAIN, {"shot_1.png"}},
    {"mv bad/shot_2.png bad/shot_50.png", FFP_RULE_TOO_FEW, {"1 of 1 attitudes"}}, // white is found
    {"cp bad/shot_2.png bad/shot_1.png",
     FFP_RULE_TOO_FEW,
     {"1 of 1 attitudes"}}, // both are made from the codes
    {"cp bad/shot_2.png bad/shot_1.png && " SWAP(11, 22),
     FFP_RULE_WHITE_IS_BLACK,
     {"shot_1.png", "shot_2.png"}},
    {LATE_FROM(2), FFP_RULE_ONE_LATE, {"shot_2.png"}},
    {LATE_FROM(14), FFP_RULE_TOO_FEW, {"1 of 1 attitudes"}}, // one too many, and the last one lost
    {LATE_FROM(28) " && cd .. && " LATE_FROM(14), FFP_RULE_LATE_FROM, {"shot_14.png"}},
    {LATE_FROM(30) " && cd .. && " LATE_FROM(21), FFP_RULE_LATE_FROM, {"shot_21.png"}},
    {"for f in bad/*; do cp ../shots/pose_2/shot_1.png $f; done", FFP_RULE_NO_PLAIN_LIT, {"shot_1.png"}},
    {"for f in bad/*; do cp ../full.png $f; done", FFP_RULE_PLAIN_CLIPPED, {"shot_2.png"}},
    {"cp ../twelve_1.png " SHOT(1) " && cp ../twelve_2.png " SHOT(2),
     FFP_RULE_CODES_FEW_BITS,
     {"shot_2.png"}},
    // Numbers.
    {SWAP(11, 12), FFP_RULE_CODES_SWAPPED, {"shot_11.png and shot_12.png"}},
    {SWAP(27, 29) " && " SWAP(28, 30), FFP_RULE_CODES_SWAPPED, {"shot_27.png and shot_29.png"}},
    {SWAP(13, 26), FFP_RULE_CODES_SWAPPED, {"shot_13.png and shot_26.png", "bad/shot_13.png"}},
    {"cp bad/shot_13.png bad/shot_14.png && cp bad/shot_27.png bad/shot_28.png",
     FFP_RULE_CODES_NO_PAIR,
     {"shot_14.png", "bad/shot_13.png"}},
    {SWAP(3, 4), FFP_RULE_BOARD_MIRRORED, {"bad"}},
    {"for i in $(seq 3 18); do j=$((i+16)); mv bad/shot_$i.png x; mv bad/shot_$j.png bad/shot_$i.png; mv x "
     "bad/shot_$j.png; done",
     FFP_RULE_TOO_FEW, // rows first are found
     {"1 of 1 attitudes"}},
    // Light, size, board.
    {"cp ../dim_1.png bad/shot_10.png", FFP_RULE_CODES_EXPOSURE, {"darker", "bad/shot_10.png"}},
    {"cp ../small.png bad/shot_20.png", FFP_RULE_TOO_FEW, {"200 x 100", "480 x 360", "bad/shot_20.png"}},
    {"cp ../small.png bad/shot_2.png", FFP_RULE_TOO_FEW, {"200 x 100", "480 x 360", "bad/shot_2.png"}},
    {"rm -r bad && cp -r ../bare bad",
     FFP_RULE_NO_BOARD,
     {"no chessboard with 7 x 5 inner corners in any of 1 attitudes"}},
};

// Black and white as numbers of 12 bits, which are light, in files of 16.
static void write_twelve_bits(void) {
    for (int k = 1; k <= 2; k++) {
        char name[64];
        FfpImage image = {0};
        snprintf(name, sizeof name, "shots/pose_2/shot_%d.png", k);
        assert_true(ffp_image_read_over_black(&image, NULL, in_scratch(name), NULL));
        for (int i = 0; i < 3 * image.width * image.height; i++)
            image.data[i] = fminf(image.data[i], 1) * 4095 / 65535;
        snprintf(name, sizeof name, "twelve_%d.png", k);
        assert_true(ffp_image_write_png16(&image, in_scratch(name), NULL));
        ffp_image_free(&image);
    }
}

static void what_is_wrong_is_named(void **state) {
    NEEDS_OPENCV();
    write_twelve_bits();
    for (size_t i = 0; i < sizeof faults / sizeof *faults; i++) {
        char command[1024], folder[FFP_PATH_MAX];
        const char *named = folder;
        snprintf(command, sizeof command,
                 "cd '%s' && rm -rf fault && mkdir fault && cp -r shots/pose_2 fault/bad && cd fault && (%s)",
                 scratch, faults[i].command);
        assert_int_equal(system(command), 0);
        snprintf(folder, sizeof folder, "%s/fault", scratch);
        FfpRigCalibration o = settings_of(&named, 1);
        const char *words[4] = {faults[i].words[0], faults[i].words[1], faults[i].words[2], NULL};
        refused(&o, faults[i].rule, words);
    }
    const char *sound = in_scratch("shots/pose_2");
    FfpRigCalibration o = settings_of(&sound, 1);
    o.width = 130;
    refused(&o, FFP_RULE_PANEL_SIZE, (const char *const[]){"columns", "130", NULL});
    o.width = 1024;
    refused(&o, FFP_RULE_COUNT, (const char *const[]){"1024 x 190", " 38", NULL});
}

// A whole attitude of another size.
static void mixed_sizes(void **state) {
    NEEDS_OPENCV();
    const char *folder = three("sizes");
    FfpImage image = ffp_image_new(200, 100, 1);
    char path[FFP_PATH_MAX];
    for (int i = 1; i <= 34; i++) {
        snprintf(path, sizeof path, "%s/bad/shot_%d.png", folder, i);
        for (int k = 0; k < 200 * 100; k++) image.data[k] = i % 2 ? 0.1F : 0.8F;
        assert_true(ffp_image_write_png(&image, path, NULL));
    }
    ffp_image_free(&image);
    FfpRigCalibration o = settings_of(&folder, 1);
    // Natural order takes it first: then the others are of another size.
    refused(&o, FFP_RULE_TURNED_PICTURES, (const char *const[]){"480 x 360", "200 x 100", NULL});
}

// A camera's numbers begin again after 9999.
static void numbers_that_begin_again(void **state) {
    NEEDS_OPENCV();
    const char *folder = three("wrap");
    FfpRigCalibrationStats stats;
    FfpError err = {0};
    in_folder(folder,
              "for d in *; do for i in $(seq 34); do n=$((9980 + i)); [ $n -le 9999 ] || n=$((n - 9999)); "
              "mv $d/shot_$i.png $d/IMG_$(printf %%04d $n).png; done; done");
    FfpContext *context = listening();
    FfpRigCalibration o = settings_of(&folder, 1);
    o.file = in_scratch("wrap.xml");
    if (!ffp_calibrate_rig(context, &o, &stats, &err)) fail_msg("%s", err.text);
    ffp_context_free(context);
    assert_int_equal(stats.used, 3);
    assert_non_null(strstr(notes, "numbers-wrap "));
}

static void a_folder_twice(void **state) {
    NEEDS_OPENCV();
    char first[FFP_PATH_MAX], again[FFP_PATH_MAX];
    const char *const folders[2] = {first, again};
    snprintf(first, sizeof first, "%s/shots/pose_1", scratch);
    snprintf(again, sizeof again, "%s/shots/../shots/pose_1/", scratch);
    FfpRigCalibration o = settings_of(folders, 2);
    REFUSED(&o, "the folder is named twice", again);
}

static void another_board(void **state) {
    NEEDS_OPENCV();
    const char *folder = in_scratch("shots");
    FfpRigCalibration o = settings_of(&folder, 1);
    o.columns = 8;
    REFUSED_BY(&o, FFP_RULE_NO_BOARD, "no chessboard with 8 x 5 inner corners", "there is one with 7 x 5");
    o.columns = 6;
    REFUSED_BY(&o, FFP_RULE_TOO_FEW, "0 of 6 attitudes", "more than 6 x 5 corners");
}

// Where the board is in single photographs, with its tilt by a guessed focal length; nothing is calibrated.
static void a_board_is_seen(void **state) {
    NEEDS_OPENCV();
    char photographs[2][FFP_PATH_MAX], file[FFP_PATH_MAX], *text;
    size_t size;
    FfpError err = {0};
    for (int i = 0; i < 2; i++)
        snprintf(photographs[i], sizeof photographs[i], "%s/shots/pose_%d/shot_2.png", scratch, 2 + 2 * i);
    const char *both[2] = {photographs[0], photographs[1]};
    snprintf(file, sizeof file, "%s/seen.json", scratch);
    FfpRigCalibration o = settings_of(both, 2);
    o.seen = file;
    for (int wrong = 0; wrong < 2; wrong++) {
        o.columns = COLUMNS + wrong;
        if (!ffp_calibrate_rig(NULL, &o, NULL, &err)) fail_msg("%s", err.text);
        assert_true(ffp_read_text(file, 1 << 20, &text, &size, &err));
        assert_non_null(strstr(text, wrong ? "there is one with 7 x 5" : "\"found\": true"));
        assert_null(strstr(text, wrong ? "\"found\": true" : "\"found\": false"));
        const char *at = text;
        for (int i = 0; i < 2 && !wrong; i++) {
            const Placed truth = attitude(2 + 2 * i);
            double tilt, towards[2];
            at = strstr(at + 1, "\"tilt\": ");
            assert_int_equal(
                sscanf(at, "\"tilt\": %lf, \"towards\": [%lf, %lf]", &tilt, towards, towards + 1), 3);
            printf("tilt %.1f degrees, truly %.1f\n", tilt, acos(fabs(truth.r[8])) * 180 / FFP_PI_DOUBLE);
            assert_true(fabs(tilt - acos(fabs(truth.r[8])) * 180 / FFP_PI_DOUBLE) < 10);
            const double sense = truth.r[8] < 0 ? -1 : 1; // r's third column is the board's normal
            assert_true(sense * (truth.r[2] * towards[0] + truth.r[5] * towards[1]) > 0);
        }
        ffp_free(text);
    }
    o.file = file;
    REFUSED(&o, "(seen)");
    o = settings_of(NULL, 0), o.seen = file;
    REFUSED(&o, "(seen)");
    snprintf(photographs[0], sizeof photographs[0], "%s/shots", scratch); // a folder
    snprintf(file, sizeof file, "%s/none.json", scratch);
    o = settings_of(both, 1), o.seen = file;
    assert_false(ffp_calibrate_rig(NULL, &o, NULL, &err));
    assert_non_null(strstr(err.text, "shots"));
    assert_int_not_equal(access(file, F_OK), 0);
}

static void too_few_and_too_alike(void **state) {
    NEEDS_OPENCV();
    char path[FFP_PATH_MAX];
    const char *folder = three("few");
    in_folder(folder, "rm -r bad");
    FfpRigCalibration o = settings_of(&folder, 1);
    REFUSED_BY(&o, FFP_RULE_TOO_FEW, "2 of 2 attitudes", "but 3 are needed");
    assert_int_equal(mkdir(in_scratch("parallel"), 0777), 0);
    for (int i = 0; i < 3; i++) {
        const Placed board = placed(0.3, 0.2, 0, 20 * i - 20, 5 * i, 560 + 40 * i);
        snprintf(path, sizeof path, "%s/parallel/%d", scratch, i);
        shoot(&board, path, false);
    }
    folder = in_scratch("parallel");
    REFUSED_BY(&o, FFP_RULE_BOARDS_PARALLEL, "parallel in all attitudes", "tilt it");
}

// One bad attitude among enough others is left out and named.
static void a_bad_one_is_left_out(void **state) {
    NEEDS_OPENCV();
    const char *folder = three("one");
    char command[1024];
    snprintf(command, sizeof command, "cp -r '%s/shots/pose_3' '%s/one/good_3'", scratch, scratch);
    assert_int_equal(system(command), 0);
    in_folder(folder, "rm bad/shot_9.png bad/shot_16.png bad/shot_24.png");
    FfpContext *context = listening();
    FfpRigCalibration o = settings_of(&folder, 1);
    FfpRigCalibrationStats stats;
    FfpError err = {0};
    o.file = in_scratch("one.xml");
    if (!ffp_calibrate_rig(context, &o, &stats, &err)) fail_msg("%s", err.text);
    ffp_context_free(context);
    assert_true(stats.attitudes == 4 && stats.used == 3);
    assert_non_null(strstr(notes, "attitudes-left-out bad\n"));
    assert_non_null(strstr(notes, "31 photographs"));
    assert_non_null(strstr(notes, "lens-terms-untried")); // three attitudes are few for five lens terms
}

// Folders with a photograph of everything that was shown give what black, white and the codes alone do; where
// some are missing, the error names them.
static void everything_that_was_shown(void **state) {
    NEEDS_OPENCV();
    const char *folder = in_scratch("whole"), *plain = in_scratch("shots");
    char file[2][FFP_PATH_MAX], patterns[FFP_PATH_MAX], command[2048], *text[2];
    size_t size[2];
    FfpPatterns show = ffp_patterns_defaults();
    FfpError err = {0};
    snprintf(patterns, sizeof patterns, "%s/patterns", scratch);
    show.folder = patterns, show.width = PANEL_W, show.height = PANEL_H;
    assert_int_equal(ffp_write_patterns(NULL, &show, &err), 2 + 2 + 2 * PAIRS);
    snprintf(command, sizeof command,
             "cp -r '%s' '%s' && cd '%s' && for p in *; do for i in $(seq %d -1 3); do "
             "mv $p/shot_$i.png $p/shot_$((i + 1)).png; done; cp $p/shot_1.png $p/shot_3.png; done",
             plain, folder, folder, 2 * PAIRS + 2);
    assert_int_equal(system(command), 0);
    for (int whole = 0; whole < 2; whole++) {
        FfpRigCalibration o = settings_of(whole ? &folder : &plain, 1);
        FfpRigCalibrationStats stats;
        snprintf(file[whole], sizeof file[whole], "%s/whole_%d.xml", scratch, whole);
        o.file = file[whole], o.width = o.height = 0, o.shown = patterns;
        FfpContext *context = listening();
        if (!ffp_calibrate_rig(context, &o, &stats, &err)) fail_msg("%s", err.text);
        ffp_context_free(context);
        assert_true(stats.used == ATTITUDES);
        assert_true(ffp_read_text(file[whole], 1 << 20, &text[whole], &size[whole], &err));
    }
    assert_string_equal(text[0], text[1]);
    ffp_free(text[0]), ffp_free(text[1]);
    // The terms that are open were tried on boards held out.
    printf("%s", notes);
    assert_non_null(strstr(notes, "lens-terms-to-fix "));
    assert_non_null(strstr(notes, "held out are then off by 0."));
    // By the numbers of the files two are missing.
    snprintf(command, sizeof command, "rm '%s'/pose_[1-4]/shot_8.png '%s'/pose_[1-4]/shot_11.png", folder,
             folder);
    assert_int_equal(system(command), 0);
    FfpRigCalibration o = settings_of(&folder, 1);
    FfpRigCalibrationStats stats;
    o.file = file[0], o.width = o.height = 0, o.shown = patterns;
    FfpContext *context = listening();
    if (!ffp_calibrate_rig(context, &o, &stats, &err)) fail_msg("%s", err.text);
    ffp_context_free(context);
    assert_true(stats.used == ATTITUDES && strstr(notes, "codes-lost "));
}

// --- The turntable. ---

static const double axis_turn[3] = {0.45, 0.1, 0.05}, axis_point[3] = {15, 60, 640};

static void truth_of_axis(double u[3]) {
    double r[9];
    ffp_rotation_from_vector(axis_turn, r);
    for (int i = 0; i < 3; i++) u[i] = -r[3 * i + 1]; // up: against the camera's y, tilted
}

// Photographs of a board that stands on the table, leaning; `lifts` (NULL: none): by how much it has moved
// along the axis.
static void shoot_table(const char *folder, const double *angles, const double *lifts, int n, double sense) {
    double u[3], base[9];
    const double lean[3] = {0.1, 0.5 * sense, 0};
    char path[FFP_PATH_MAX + 32];
    FfpRng rng = ffp_rng(11, 1);
    FfpImage white = ffp_pattern_plain(PANEL_W, PANEL_H, 255);
    truth_of_axis(u);
    ffp_rotation_from_vector(lean, base);
    assert_int_equal(mkdir(folder, 0777), 0);
    for (int i = 0; i < n; i++) {
        const double a = sense * angles[i] * FFP_PI_DOUBLE / 180, v[3] = {a * u[0], a * u[1], a * u[2]};
        const double off[3] = {25 * sense, -95, -20};
        double turn[9];
        Placed board = {.margin = 1};
        ffp_rotation_from_vector(v, turn);
        ffp_rotation_product(turn, base, board.r);
        for (int k = 0; k < 3; k++)
            board.t[k] = axis_point[k] + ffp_dot(turn + 3 * k, off) + (lifts ? lifts[i] * u[k] : 0);
        Sample *samples = see(&board);
        snprintf(path, sizeof path, "%s/%d.png", folder, i);
        photograph(samples, &white, 1, &rng, path);
        ffp_free(samples);
    }
    ffp_image_free(&white);
}

static double degrees_between(const double a[3], const double b[3]) {
    return acos(fmin(1, ffp_dot(a, b))) * 180 / FFP_PI_DOUBLE;
}

static void write_truth(const char *path) {
    FILE *out = fopen(path, "w");
    assert_non_null(out);
    fprintf(out,
            "%%YAML:1.0\n---\ncamW: %d\ncamH: %d\nprjW: %d\nprjH: %d\ncamK: [%g, 0, %g, 0, %g, %g, 0, 0, 1]\n"
            "camKc: [%g, %g, %g, %g, 0]\nprjK: [%g, 0, %g, 0, %g, %g, 0, 0, 1]\nprjKc: [0, 0, 0, 0, 0]\n"
            "R: [1, 0, 0, 0, 1, 0, 0, 0, 1]\nT: [1, 0, 0]\n",
            CAMERA_W, CAMERA_H, PANEL_W, PANEL_H, camera.fx, camera.cx, camera.fy, camera.cy, camera.lens[0],
            camera.lens[1], camera.lens[2], camera.lens[3], projector.fx, projector.cx, projector.fy,
            projector.cy);
    fclose(out);
}

static void a_turntable_comes_back(void **state) {
    NEEDS_OPENCV();
    static const double angles[STOPS] = {-40, -25, -10, 5, 20, 35, 50};
    char truth[FFP_PATH_MAX], table[FFP_PATH_MAX], shots[FFP_PATH_MAX];
    const char *calibration = truth;
    double u[3];
    truth_of_axis(u);
    snprintf(truth, sizeof truth, "%s/truth.yml", scratch);
    snprintf(table, sizeof table, "%s/axis.json", scratch);
    write_truth(truth);
    for (int reversed = 0; reversed < 2; reversed++) {
        FfpRigCalibration o = settings_of(NULL, 0);
        FfpRigCalibrationStats stats;
        FfpTurntable read;
        const FfpImportTurntable given = {.file = table, .angles = angles, .n_angles = STOPS};
        FfpError err = {0};
        snprintf(shots, sizeof shots, "%s/table_%d", scratch, reversed);
        shoot_table(shots, angles, NULL, STOPS, reversed ? -1 : 1);
        o.calibrations = &calibration, o.n_calibrations = 1;
        o.turntable_board = shots, o.angles = angles, o.n_angles = STOPS, o.turntable_file = table;
        FfpContext *context = listening();
        if (!ffp_calibrate_rig(context, &o, &stats, &err)) fail_msg("%s", err.text);
        ffp_context_free(context);
        assert_false(ffp_turntable_take(&read, &(FfpImportTurntable){.file = table}, &err)); // no angles
        if (!ffp_turntable_take(&read, &given, &err)) fail_msg("%s", err.text);
        double across[3], off[3] = {0};
        for (int i = 0; i < 3; i++) off[i] = read.point[i] - axis_point[i];
        ffp_cross(off, u, across);
        printf("%s%d of %d stops, reversed %d: ", notes, stats.stops_used, stats.stops, stats.reversed);
        printf("axis off by %.3f degrees (deviation %.3f) and %.2f units (%.2f), rms %.3f\n",
               degrees_between(read.axis, u), stats.tilt, sqrt(ffp_dot(across, across)), stats.shift,
               stats.stops_rms);
        assert_true(stats.has_axis && stats.stops_used == STOPS && stats.reversed == (reversed == 1));
        assert_true(degrees_between(read.axis, u) < 0.2 && sqrt(ffp_dot(across, across)) < 1.5);
        // The object's angles count as the board's did; the board's are not the object's.
        assert_true(read.clockwise == (reversed == 1) && stats.stops_rms < 0.2);
        assert_true(fabs(ffp_dot(read.zero, read.zero) - 1) < 1e-6 &&
                    fabs(ffp_dot(read.zero, read.axis)) < 1e-6);
    }
}

// The uncertainty of the camera's calibration is part of the axis' uncertainty: a focal length that is known
// to a hundredth puts the axis a hundredth nearer or farther.
static void the_camera_is_uncertain_too(void **state) {
    NEEDS_OPENCV();
    static const double angles[STOPS] = {-40, -25, -10, 5, 20, 35, 50};
    char truth[FFP_PATH_MAX];
    const char *calibration = truth;
    double shift[2];
    snprintf(truth, sizeof truth, "%s/uncertain.yml", scratch);
    for (int known = 0; known < 2; known++) {
        FfpRigCalibration o = settings_of(NULL, 0);
        FfpRigCalibrationStats stats;
        FfpError err = {0};
        write_truth(truth);
        FILE *out = fopen(truth, "a");
        assert_non_null(out);
        if (known)
            fprintf(out, "cam_deviations: [%g, %g, 0.5, 0.5, 0, 0, 0, 0, 0]\n", camera.fx / 100,
                    camera.fy / 100);
        fclose(out);
        o.calibrations = &calibration, o.n_calibrations = 1;
        o.turntable_board = in_scratch("table_0"), o.angles = angles, o.n_angles = STOPS;
        FfpContext *context = listening();
        if (!ffp_calibrate_rig(context, &o, &stats, &err)) fail_msg("%s", err.text);
        ffp_context_free(context);
        assert_int_equal(strstr(notes, "does not say how uncertain it is") == NULL, known);
        shift[known] = stats.shift;
    }
    printf("axis uncertain by %.2f units, with the camera's by %.2f\n", shift[0], shift[1]);
    assert_true(shift[0] < 0.5 && shift[1] > 4 && shift[1] < 9);
}

// Two stops of seven at which the board had moved are left out, and each is told.
static void stops_out_of_line_are_left_out(void **state) {
    NEEDS_OPENCV();
    static const double angles[STOPS] = {-40, -25, -10, 5, 20, 35, 50}, lifts[STOPS] = {[3] = -15, [5] = 23};
    char truth[FFP_PATH_MAX], shots[FFP_PATH_MAX];
    const char *calibration = truth;
    snprintf(truth, sizeof truth, "%s/truth.yml", scratch);
    snprintf(shots, sizeof shots, "%s/table_moved", scratch);
    write_truth(truth);
    shoot_table(shots, angles, lifts, STOPS, 1);
    FfpRigCalibration o = settings_of(NULL, 0);
    FfpRigCalibrationStats stats;
    FfpError err = {0};
    o.calibrations = &calibration, o.n_calibrations = 1;
    o.turntable_board = shots, o.angles = angles, o.n_angles = STOPS;
    FfpContext *context = listening();
    if (!ffp_calibrate_rig(context, &o, &stats, &err)) fail_msg("%s", err.text);
    ffp_context_free(context);
    printf("%s", notes);
    assert_true(stats.stops_used == STOPS - 2 && stats.stops_rms < 0.2);
    assert_non_null(strstr(notes, "attitudes-left-out "));
    assert_true(strstr(notes, "table_moved/3.png\n") && strstr(notes, "table_moved/5.png\n"));
}

// A board that looks the same after half a turn, about its middle.
static void a_board_on_the_axis_tells_no_direction(void **state) {
    NEEDS_OPENCV();
    enum { QUARTERS = 4 };
    static const double angles[QUARTERS] = {0, 90, 180, 270};
    char truth[FFP_PATH_MAX], shots[FFP_PATH_MAX], path[FFP_PATH_MAX + 32];
    const char *calibration = truth;
    FfpRng rng = ffp_rng(12, 1);
    FfpImage white = ffp_pattern_plain(PANEL_W, PANEL_H, 255);
    snprintf(truth, sizeof truth, "%s/truth.yml", scratch);
    snprintf(shots, sizeof shots, "%s/quarters", scratch);
    write_truth(truth);
    assert_int_equal(mkdir(shots, 0777), 0);
    for (int i = 0; i < QUARTERS; i++) {
        const double quarter[3] = {0, 0, angles[i] * FFP_PI_DOUBLE / 180};
        double turn[9];
        const Placed flat = placed(0.5, 0.2, 0, 0, 0, 700);
        Placed board = flat;
        ffp_rotation_from_vector(quarter, turn);
        ffp_rotation_product(flat.r, turn, board.r);
        Sample *samples = see(&board);
        snprintf(path, sizeof path, "%s/%d.png", shots, i);
        photograph(samples, &white, 1, &rng, path);
        ffp_free(samples);
    }
    ffp_image_free(&white);
    FfpRigCalibration o = settings_of(NULL, 0);
    o.calibrations = &calibration, o.n_calibrations = 1;
    o.turntable_board = shots, o.angles = angles, o.n_angles = QUARTERS;
    REFUSED_BY(&o, FFP_RULE_BOARD_HALF_TURN, "direction of rotation is ambiguous");
}

static void wrong_turntables(void **state) {
    NEEDS_OPENCV();
    static const double angles[STOPS] = {-40, -25, -10, 5, 20, 35, 50},
                        others[STOPS] = {0, 60, 10, 90, 25, 70, 5}, alike[STOPS] = {0};
    char truth[FFP_PATH_MAX], shots[FFP_PATH_MAX], folder[FFP_PATH_MAX];
    const char *calibration = truth;
    snprintf(truth, sizeof truth, "%s/truth.yml", scratch);
    snprintf(shots, sizeof shots, "%s/table_0", scratch);
    FfpRigCalibration o = settings_of(NULL, 0);
    FfpError err = {0};
    o.calibrations = &calibration, o.n_calibrations = 1, o.turntable_board = shots;
    o.angles = others, o.n_angles = STOPS;
    REFUSED_BY(&o, FFP_RULE_BOARD_NO_AXIS, "no axis explains");
    o.angles = alike;
    assert_false(ffp_calibrate_rig(NULL, &o, NULL, &err));
    assert_non_null(strstr(err.text, "angles are all equal"));
    o.angles = angles, o.n_angles = STOPS - 1;
    assert_false(ffp_calibrate_rig(NULL, &o, NULL, &err));
    assert_non_null(strstr(err.text, "7 photographs in 1 folders, and 6 angles"));
    o.n_angles = STOPS, o.columns = 8;
    REFUSED_BY(&o, FFP_RULE_TOO_FEW, "0 of 7 photographs show the board");
    o = settings_of(NULL, 0), o.calibrations = &calibration, o.n_calibrations = 1;
    o.turntable_board = folder, o.angles = angles, o.n_angles = 4;
    in_folder(scratch, "mkdir stops && cp table_0/[0-1].png stops/ && cp full.png stops/2.png && "
                       "cp stops/2.png stops/3.png");
    snprintf(folder, sizeof folder, "%s/stops", scratch);
    REFUSED_BY(&o, FFP_RULE_TOO_FEW, "2 of 4 photographs show the board, but 3 are needed", "stops/2.png");
    in_folder(scratch, "cp small.png stops/1.png");
    REFUSED_BY(&o, FFP_RULE_STOP_SIZE, "has 200 x 100 pixels, but the camera was calibrated at 480 x 360",
               "stops/1.png");
    in_folder(scratch, "printf GIF89a > stops/1.png");
    REFUSED(&o, "stops/1.png");
    snprintf(folder, sizeof folder, "%s/nowhere", scratch);
    REFUSED(&o, "(", "nowhere)");
    snprintf(folder, sizeof folder, "%s/table_0", scratch);
    o.n_angles = 2;
    REFUSED(&o, "2 are not in 3 to 512", "(angles)");
}

static void wrong_settings(void **state) {
    NEEDS_OPENCV();
    char nothing[FFP_PATH_MAX], shots[FFP_PATH_MAX];
    const char *folder = shots, *nowhere = nothing;
    snprintf(nothing, sizeof nothing, "%s/nowhere", scratch),
        snprintf(shots, sizeof shots, "%s/shots", scratch);
    FfpRigCalibration o = settings_of(&folder, 1);
    o.square = -1;
    REFUSED(&o, "(square)");
    o = settings_of(&folder, 1), o.columns = 2;
    REFUSED(&o, "(board)");
    o = settings_of(&folder, 1), o.fix_camera = 64;
    REFUSED(&o, "(fix)");
    o = settings_of(&folder, 1), o.height = 20;
    REFUSED(&o, "(projector)");
    o = settings_of(&nowhere, 1);
    REFUSED(&o, "nowhere");
    o = settings_of(&folder, 1), o.turntable_board = folder;
    REFUSED(&o, "(angles)");
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(a_rig_comes_back),
                                       cmocka_unit_test(everything_that_was_shown),
                                       cmocka_unit_test(what_is_wrong_is_named),
                                       cmocka_unit_test(mixed_sizes),
                                       cmocka_unit_test(numbers_that_begin_again),
                                       cmocka_unit_test(a_folder_twice),
                                       cmocka_unit_test(another_board),
                                       cmocka_unit_test(a_board_is_seen),
                                       cmocka_unit_test(too_few_and_too_alike),
                                       cmocka_unit_test(a_bad_one_is_left_out),
                                       cmocka_unit_test(a_turntable_comes_back),
                                       cmocka_unit_test(the_camera_is_uncertain_too),
                                       cmocka_unit_test(stops_out_of_line_are_left_out),
                                       cmocka_unit_test(a_board_on_the_axis_tells_no_direction),
                                       cmocka_unit_test(wrong_turntables),
                                       cmocka_unit_test(wrong_settings)};
    return cmocka_run_group_tests(tests, setup, scratch_teardown);
}
