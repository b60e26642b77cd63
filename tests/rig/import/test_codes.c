// Photographs of Gray codes on a ball, seen through two lenses: positions, depth, and what is wrong with
// them.
#include <math.h>
#include <stdio.h>
#include <unistd.h>
#include "core/base/alloc.h"
#include "core/base/rigid.h"
#include "core/base/rng.h"
#include "core/numerics/least_squares.h"
#include "core/numerics/rank.h"
#include "core/patterns/lollipop.h"
#include "core/patterns/patterns.h"
#include "engine/match/coded.h"
#include "engine/match/line.h"
#include "engine/match/match.h"
#include "named.h"
#include "rig/graycode/graycode.h"
#include "rig/import/import.h"
#include "rig/optics/lens.h"
#include "rig/optics/matrix.h"
#include "scratch.h"

enum { WIDTH = 160, HEIGHT = 120, PANEL_WIDTH = 120, PANEL_HEIGHT = 90 };

static FfpError err;
static const FfpOptics camera = {.width = WIDTH,
                                 .height = HEIGHT,
                                 .fx = 190,
                                 .fy = 189,
                                 .cx = 79,
                                 .cy = 61,
                                 .lens = {-0.12, 0.05, 0.002, -0.001, 0}};
static const FfpOptics projector = {.width = PANEL_WIDTH,
                                    .height = PANEL_HEIGHT,
                                    .fx = 150,
                                    .fy = 151,
                                    .cx = 58,
                                    .cy = 47,
                                    .lens = {0.05, -0.04, 0.001, 0.002, 0}};
static const double centre[3] = {0.05, -0.02, 3}, radius = 0.85;
static double p2c[16]; // the projector half a unit to the right, turned towards the ball

// --- The ball. ---

// Where the ray (x, y, 1) of the camera's frame meets the ball; false where it does not.
static bool meet(double x, double y, double point[3]) {
    const double d[3] = {x, y, 1}, a = x * x + y * y + 1;
    double b = 0, c = -radius * radius;
    for (int i = 0; i < 3; i++) b += d[i] * centre[i], c += centre[i] * centre[i];
    if (b * b < a * c) return false;
    const double z = (b - sqrt(b * b - a * c)) / a;
    for (int i = 0; i < 3; i++) point[i] = z * d[i];
    return true;
}

// The projector's ray (x, y, 1) to a point, and whether it lights it.
static bool lights(const double point[3], double ray[2], double *strength) {
    double c2p[16], local[3], towards = 0, square = 0;
    ffp_pose_inverse(p2c, c2p);
    for (int i = 0; i < 3; i++) {
        local[i] =
            c2p[4 * i] * point[0] + c2p[4 * i + 1] * point[1] + c2p[4 * i + 2] * point[2] + c2p[4 * i + 3];
        const double to = p2c[4 * i + 3] - point[i];
        towards += to * (point[i] - centre[i]) / radius, square += to * to;
    }
    ray[0] = local[0] / local[2], ray[1] = local[1] / local[2];
    *strength = fmax(towards, 0) / sqrt(square) * 6 / square;
    return towards > 0;
}

// Radiance under a pattern along the camera's ray: a speckled ball before a dark wall.
static double radiance(const FfpImage *pattern, double x, double y) {
    double point[3], ray[2], u, v, strength;
    if (!meet(x, y, point) || !lights(point, ray, &strength)) return 0.003;
    ffp_lens_distort(projector.lens, ray[0], ray[1], &u, &v);
    u = projector.cx + projector.fx * u, v = projector.cy + projector.fy * v;
    const double albedo = 0.5 + 0.3 * sin(23 * point[0]) * cos(19 * point[1]);
    if (u < 0 || v < 0 || u >= PANEL_WIDTH || v >= PANEL_HEIGHT) return 0.01 * albedo;
    const double light = (double)pattern->data[(int)v * pattern->width + (int)u];
    return albedo * (0.01 + strength * light);
}

// 4 x 4 samples a pixel, a little noise.
static void photograph(const char *name, const FfpImage *pattern, double exposure, uint64_t seed) {
    FfpImage out = ffp_image_new(WIDTH, HEIGHT, 3);
    FfpRng rng = ffp_rng(seed, 9);
    for (int i = 0; i < WIDTH * HEIGHT; i++) {
        double sum = 0;
        for (int k = 0; k < 16; k++) {
            const double u = i % WIDTH + (k % 4 + 0.5) / 4, v = i / WIDTH + (k / 4 + 0.5) / 4;
            double ray[2];
            assert_true(ffp_lens_undistort(camera.lens, (u - camera.cx) / camera.fx,
                                           (v - camera.cy) / camera.fy, ray));
            sum += radiance(pattern, ray[0], ray[1]) / 16;
        }
        const double noise = 0.002 * (double)ffp_rng_normal(&rng);
        for (int c = 0; c < 3; c++) out.data[3 * i + c] = (real)fmax(0, fmin(exposure * sum + noise, 1));
    }
    ffp_image_to_srgb(&out);
    assert_true(ffp_image_write_png(&out, in_scratch(name), NULL));
    ffp_image_free(&out);
}

// Under Gray code `index`.
static void take(int index, const char *file, double exposure) {
    const FfpShow show = {.width = PANEL_WIDTH, .height = PANEL_HEIGHT, .gray_codes = true};
    char title[32];
    FfpShowPart part;
    FfpImage pattern = ffp_show_picture(&show, index, title, &part);
    photograph(file, &pattern, exposure, (uint64_t)index);
    ffp_image_free(&pattern);
}

// Under a lollipop.
static void take_lollipop(const char *file) {
    FfpImage panel = ffp_pattern_round_lollipop(PANEL_WIDTH, PANEL_HEIGHT, 0),
             grey = ffp_image_new(PANEL_WIDTH, PANEL_HEIGHT, 1);
    ffp_image_to_linear(&panel);
    for (int i = 0; i < PANEL_WIDTH * PANEL_HEIGHT; i++) grey.data[i] = panel.data[3 * i];
    photograph(file, &grey, 1, 78);
    ffp_image_free(&panel), ffp_image_free(&grey);
}

static void take_all(void) {
    assert_true(ffp_make_folders(in_scratch("photos"), NULL));
    const int n = ffp_gray_photographs(PANEL_WIDTH, PANEL_HEIGHT);
    for (int i = 0; i < n; i++) {
        char file[64];
        snprintf(file, sizeof file, "photos/%03d.png", i);
        take(i, file, 1);
    }
    take_lollipop("lolly.png");
    for (int grey = 0; grey < 2; grey++) {
        FfpImage plain = ffp_pattern_plain(PANEL_WIDTH, PANEL_HEIGHT, 255 * grey);
        photograph(grey ? "white.png" : "black.png", &plain, 1, 77);
        ffp_image_free(&plain);
    }
}

// A lollipop (-3), black (-2), white (-1) or code number i, in two folders.
static const char *shot(const char *plain, const char *codes, int i) {
    char name[64];
    snprintf(name, sizeof name,
             i == -3   ? "%slolly.png"
             : i == -2 ? "%sblack.png"
             : i == -1 ? "%swhite.png"
                       : "%s%03d.png",
             i < 0 ? plain : codes, i);
    return in_scratch(name);
}

// --- The import. ---

static void put_matrix(FILE *out, const char *name, int rows, int cols, const double *values) {
    fprintf(out, "%s: !!opencv-matrix\n   rows: %d\n   cols: %d\n   dt: d\n   data: [ ", name, rows, cols);
    for (int i = 0; i < rows * cols; i++) fprintf(out, "%s%.16e", i ? ", " : "", values[i]);
    fputs(" ]\n", out);
}

static void write_calibration(void) {
    const FfpOptics *o[2] = {&camera, &projector};
    double c2p[16], r[9], t[3];
    ffp_pose_inverse(p2c, c2p);
    for (int i = 0; i < 9; i++) r[i] = c2p[4 * (i / 3) + i % 3];
    for (int i = 0; i < 3; i++) t[i] = c2p[4 * i + 3];
    FILE *out = fopen(in_scratch("rig.yml"), "w");
    assert_non_null(out);
    fputs("%YAML:1.0\n---\n", out);
    for (int k = 0; k < 2; k++) {
        const double matrix[9] = {o[k]->fx, 0, o[k]->cx - 0.5, 0, o[k]->fy, o[k]->cy - 0.5, 0, 0, 1};
        put_matrix(out, k ? "prjK" : "camK", 3, 3, matrix);
        put_matrix(out, k ? "prjKc" : "camKc", 1, 5, o[k]->lens);
    }
    put_matrix(out, "R", 3, 3, r);
    put_matrix(out, "T", 3, 1, t);
    fprintf(out, "camW: %d\ncamH: %d\nprjW: %d\nprjH: %d\n", WIDTH, HEIGHT, PANEL_WIDTH, PANEL_HEIGHT);
    fclose(out);
}

static int setup(void **state) {
    const double turn = -0.17, c = cos(turn), s = sin(turn);
    const double pose[16] = {c, 0, s, 0.5, 0, 1, 0, 0.1, -s, 0, c, 0, 0, 0, 0, 1};
    memcpy(p2c, pose, sizeof pose);
    if (scratch_setup(state)) return 1;
    take_all();
    write_calibration();
    return 0;
}

typedef struct Call {
    FfpImport options;
    char calibration[200], black[200], white[200], codes[200], folder[200];
    const char *files[1];
    FfpImportImages images[2];
} Call;
static const char *const black[1] = {"black"}, *const white[1] = {"white"};

static Call *call_of(const char *folder) {
    static Call call;
    call = (Call){0};
    snprintf(call.calibration, sizeof call.calibration, "%s/rig.yml", scratch);
    snprintf(call.black, sizeof call.black, "%s/black.png", scratch);
    snprintf(call.white, sizeof call.white, "%s/white.png", scratch);
    snprintf(call.codes, sizeof call.codes, "%s/photos/*.png", scratch);
    snprintf(call.folder, sizeof call.folder, "%s/%s", scratch, folder);
    call.files[0] = call.calibration;
    call.images[0] = (FfpImportImages){.patterns = black, .n_patterns = 1, .files = call.black};
    call.images[1] = (FfpImportImages){.patterns = white, .n_patterns = 1, .files = call.white};
    call.options = (FfpImport){.size = sizeof(FfpImport),
                               .calibrations = call.files,
                               .n_calibrations = 1,
                               .images = call.images,
                               .n_images = 2,
                               .masks = FFP_MASKS_FROM_LIGHT,
                               .gray_codes = call.codes,
                               .folder = call.folder};
    return &call;
}

static void import(FfpCapture *capture, Call *call) {
    if (!ffp_import(&call->options, &err)) fail_msg("%s", err.text);
    if (!ffp_capture_read(capture, call->folder, &err)) fail_msg("%s", err.text);
}

// Median distance of the correspondences from where the ball has them, pixels of the ideal projector; how
// many.
static int compare(const void *a, const void *b) {
    const double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

static double positions_off(const FfpView *view, double rank, int *known) {
    const FfpCamera *c = &view->camera, *p = &view->projector;
    double *offs = ffp_alloc((size_t)c->width * (size_t)c->height, sizeof *offs), point[3], ray[2], strength;
    *known = 0;
    for (int i = 0; i < c->width * c->height; i++) {
        const real *at = view->correspondence.data + 3 * i;
        const double x = (i % c->width + 0.5 - (double)c->cx) / (double)c->fx,
                     y = (i / c->width + 0.5 - (double)c->cy) / (double)c->fy;
        if (!(at[2] > 0) || !meet(x, y, point) || !lights(point, ray, &strength)) continue;
        offs[(*known)++] = hypot((double)(p->cx + p->fx * (real)ray[0] - at[0]),
                                 (double)(p->cy + p->fy * (real)ray[1] - at[1]));
    }
    qsort(offs, (size_t)*known, sizeof *offs, compare);
    const double off = *known > 0 ? offs[(int)(rank * (*known - 1))] : INFINITY;
    ffp_free(offs);
    return off;
}

// --- The tests. ---

static void test_positions(void **state) {
    (void)state;
    FfpCapture capture;
    int known = 0;
    import(&capture, call_of("ball"));
    const FfpView *view = &capture.views[0];
    const double middle = positions_off(view, 0.5, &known), most = positions_off(view, 0.99, &known);
    int shown = 0;
    for (int i = 0; i < WIDTH * HEIGHT; i++) shown += view->coverage.data[i] > 0.5F;
    printf("%d of %d pixels decoded, off by %.3f (median), %.3f (99 %%) pixels of the projector\n", known,
           shown, middle, most);
    assert_true(known > 0.8 * shown && middle < 0.06 && most < 0.5);
    // Its own pattern: one of the codes, whose picture the codes explain.
    assert_int_equal(capture.n_patterns, 3);
    assert_string_equal(capture.patterns[2].name, "gray_x_05");
    ffp_capture_free(&capture);
}

// Smaller pictures take the same positions along.
static void test_narrower(void **state) {
    (void)state;
    FfpCapture capture;
    Call *call = call_of("narrow");
    int known = 0;
    call->options.width = WIDTH / 2;
    import(&capture, call);
    const double middle = positions_off(&capture.views[0], 0.5, &known);
    printf("half as wide: %d pixels, off by %.3f\n", known, middle);
    assert_true(known > 1200 && middle < 0.06);
    ffp_capture_free(&capture);
}

// A pattern cut out of what the panel shows: the codes are the whole panel's, positions those in the pattern.
static void test_cropped_pattern(void **state) {
    (void)state;
    enum { LEFT = 20, TOP = 8, CUT_WIDTH = 90, CUT_HEIGHT = 70 }; // 26 codes would be enough for so many
    static const char *const lollipop[1] = {"lollipop"};
    static char files[2][1100];
    FfpImage cut = ffp_lollipop_pattern(CUT_WIDTH, CUT_HEIGHT, 3),
             panel = ffp_image_new(PANEL_WIDTH, PANEL_HEIGHT, 1);
    for (int i = 0; i < CUT_WIDTH * CUT_HEIGHT; i++)
        panel.data[(TOP + i / CUT_WIDTH) * PANEL_WIDTH + LEFT + i % CUT_WIDTH] =
            ffp_srgb_decode(cut.data[(size_t)cut.channels * (size_t)i]);
    assert_true(ffp_image_write_png(&cut, in_scratch("cut.png"), NULL));
    photograph("lollipop.png", &panel, 1, 78);
    snprintf(files[0], sizeof files[0], "%s/cut.png", scratch);
    snprintf(files[1], sizeof files[1], "%s/lollipop.png", scratch);
    const FfpImportPattern pattern = {.name = lollipop[0], .file = files[0]};
    Call *call = call_of("cropped");
    FfpImportImages images[3] = {
        call->images[0], call->images[1], {.patterns = lollipop, .n_patterns = 1, .files = files[1]}};
    call->options.images = images, call->options.n_images = 3;
    call->options.patterns = &pattern, call->options.n_patterns = 1;
    call->options.projector = (FfpCalibratedAt){.fit = FFP_FIT_CROPPED, .left = LEFT, .top = TOP};
    FfpCapture capture;
    int known = 0;
    import(&capture, call);
    assert_int_equal(capture.views[0].projector.width, CUT_WIDTH);
    const double middle = positions_off(&capture.views[0], 0.5, &known);
    printf("cropped: %d pixels, off by %.3f\n", known, middle);
    assert_true(known > 4000 && middle < 0.06);
    ffp_capture_free(&capture);
    ffp_image_free(&cut), ffp_image_free(&panel);
}

// Characters that wildcards are made of, in the names of files and folders.
static void test_names_with_brackets(void **state) {
    (void)state;
    FfpCapture capture;
    Call *call = call_of("brackets");
    static char places[3][1100], command[5000];
    snprintf(
        command, sizeof command,
        "cd %s && mkdir 'set[1]' 'set1' && cp photos/*.png 'set[1]' && cp white.png 'set[1]/white?.png' && "
        "cp black.png 'set[1]/[black].png' && cp white.png set1/000.png",
        scratch);
    assert_int_equal(system(command), 0);
    snprintf(places[0], sizeof places[0], "%s/set[1]/[black].png", scratch);
    snprintf(places[1], sizeof places[1], "%s/set[1]/white?.png", scratch);
    snprintf(places[2], sizeof places[2], "%s/set[1]/0*.png", scratch);
    call->images[0].files = places[0], call->images[1].files = places[1];
    call->options.gray_codes = places[2];
    import(&capture, call);
    ffp_capture_free(&capture);
}

static double depth_off(const FfpCapture *capture, double *share) {
    FfpCapture normalised = *capture;
    FfpView view = capture->views[0];
    const FfpMatchSettings settings = ffp_match_defaults();
    FfpInitialisation start;
    double sum = 0, n = 0, there = 0, point[3];
    normalised.views = &view;
    ffp_capture_normalise(&normalised, capture->centre, capture->radius);
    assert_true(ffp_initialisation_new(&start, &normalised, &(int){2}, 1, &settings, &err));
    for (int i = 0; i < start.width * start.height; i++) {
        const double x = (i % start.width + 0.5 - (double)view.camera.cx) / (double)view.camera.fx,
                     y = (i / start.width + 0.5 - (double)view.camera.cy) / (double)view.camera.fy;
        if (view.coverage.data[i] < 1 || !meet(x, y, point)) continue;
        const double z = (double)(start.footprint[i] * view.camera.fx * capture->radius);
        n++;
        if (!(start.confidence[i] > 0)) continue;
        sum += pow(z - point[2], 2), there++;
    }
    *share = there / n;
    ffp_initialisation_free(&start);
    return sqrt(sum / there);
}

// Matching with codes, and with the one pattern alone.
static void test_depth(void **state) {
    (void)state;
    FfpCapture capture;
    double share, alone;
    import(&capture, call_of("matched"));
    const double coded = depth_off(&capture, &share);
    ffp_image_free(&capture.views[0].correspondence);
    const double matched = depth_off(&capture, &alone);
    printf("depth off by %.4f with codes (%.0f %% of the pixels), %.4f without (%.0f %%)\n", coded,
           100 * share, matched, 100 * alone);
    assert_true(share > 0.8 && coded < 0.012 && coded < 0.3 * matched);
    ffp_capture_free(&capture);
}

// A table that turns about the ball's middle, at two stops.
static FfpImportTurntable turntable(void) {
    static const double angles[2] = {0, 30};
    FfpImportTurntable out = {.axis = {0, -1, 0}, .angles = angles, .n_angles = 2};
    memcpy(out.point, centre, sizeof out.point);
    return out;
}

// Its stops look alike.
static Call *two_turns(const char *folder) {
    Call *call = call_of(folder);
    for (int v = 0; v < 2; v++) {
        char command[512];
        snprintf(command, sizeof command, "cd '%s' && mkdir -p %s && cp photos/*.png black.png white.png %s/",
                 scratch, v ? "030" : "000", v ? "030" : "000");
        assert_int_equal(system(command), 0);
    }
    snprintf(call->black, sizeof call->black, "%s/{view}/black.png", scratch);
    snprintf(call->white, sizeof call->white, "%s/{view}/white.png", scratch);
    snprintf(call->codes, sizeof call->codes, "%s/{view}/[0-9]*.png", scratch);
    call->options.turntable = turntable();
    return call;
}

static void test_views(void **state) {
    (void)state;
    FfpCapture capture;
    import(&capture, two_turns("turned"));
    int known[2] = {0};
    const double first = positions_off(&capture.views[0], 0.5, &known[0]),
                 second = positions_off(&capture.views[1], 0.5, &known[1]);
    assert_true(first < 0.06 && second < 0.06 && known[0] == known[1]);
    ffp_capture_free(&capture);
}

static bool import_call(void *call, FfpError *error) {
    return ffp_import(&((Call *)call)->options, error);
}

// A stop whose photographs are out of order goes without codes; the other keeps its own.
static void test_a_doubtful_stop_is_left_out(void **state) {
    (void)state;
    FfpCapture capture;
    char command[512], said[4096] = "";
    int known = 0;
    FfpContext context = {.settings = {.finding = keep_told, .user = said}};
    Call *call = two_turns("doubtful");
    snprintf(command, sizeof command, "cd '%s/030' && mv 022.png x && mv 023.png 022.png && mv x 023.png",
             scratch);
    assert_int_equal(system(command), 0);
    if (!ffp_call_run(&context, import_call, call, &err)) fail_msg("%s", err.text);
    assert_non_null(strstr(said, "codes-left-out 030: "));
    assert_true(ffp_capture_read(&capture, call->folder, &err));
    assert_true(positions_off(&capture.views[0], 0.5, &known) < 0.06 && known > 1000);
    assert_null(capture.views[1].correspondence.data);
    ffp_capture_free(&capture);
}

static void shell(const char *command) {
    char text[512];
    snprintf(text, sizeof text, "cd '%s' && %s", scratch, command);
    assert_int_equal(system(text), 0);
}

// Missing photographs, also those that a link leads to, beside files of other kinds, are told by their
// numbers: one of a pair can be done without, and where both are missing the finer codes are; and so are all
// inverses.
static void test_missing_photographs(void **state) {
    (void)state;
    static const char *const cases[3] = {
        ("mkdir gaps0 && cp photos/*.png gaps0 && rm gaps0/003.png gaps0/008.png gaps0/017.png && "
         "ln -s nowhere gaps0/017.png && touch gaps0/Thumbs.db gaps0/001.xmp"),
        "mkdir gaps1 && cp photos/*.png gaps1 && rm gaps1/02[4567].png",
        "mkdir gaps2 && n=100; for i in photos/*[02468].png; do cp $i gaps2/c$n.png; n=$((n + 1)); done"};
    for (int k = 0; k < 3; k++) {
        FfpCapture capture;
        char folder[16];
        int known = 0;
        snprintf(folder, sizeof folder, "without%d", k);
        Call *call = call_of(folder);
        shell(cases[k]);
        snprintf(call->codes, sizeof call->codes, "%s/gaps%d/*", scratch, k);
        import(&capture, call);
        const double off = positions_off(&capture.views[0], 0.5, &known);
        printf("case %d: %d pixels, off by %.3f\n", k, known, off);
        assert_true(known > 8500 && off < 0.1);
        ffp_capture_free(&capture);
    }
    Call *call = call_of("without3");
    shell("mkdir gaps3 && cp photos/*[05].png gaps3");
    snprintf(call->codes, sizeof call->codes, "%s/gaps3/*.png", scratch);
    assert_false(ffp_import(&call->options, &err));
    assert_non_null(strstr(err.text, "6 files match, but a view has 28 photographs of Gray codes"));
}

// Photographs that hold linear light are said to.
static void test_linear_photographs(void **state) {
    (void)state;
    Call *call = call_of("as_srgb");
    assert_true(ffp_make_folders(in_scratch("linear"), NULL));
    for (int i = -2; i < ffp_gray_photographs(PANEL_WIDTH, PANEL_HEIGHT); i++) {
        FfpImage image;
        assert_true(ffp_image_read_over_black(&image, NULL, shot("", "photos/", i), NULL));
        // A sixteenth, as 12 bits are in files of 16.
        for (int k = 0; k < 3 * image.width * image.height; k++) image.data[k] /= 16;
        assert_true(ffp_image_write_png(&image, shot("linear/", "linear/", i), NULL));
        ffp_image_free(&image);
    }
    snprintf(call->black, sizeof call->black, "%s/linear/black.png", scratch);
    snprintf(call->white, sizeof call->white, "%s/linear/white.png", scratch);
    snprintf(call->codes, sizeof call->codes, "%s/linear/[0-9]*.png", scratch);
    assert_false(ffp_import(&call->options, &err));
    assert_non_null(strstr(err.text, "hold linear light, not sRGB"));
}

// A dark object in a dark room, with a camera's noise in it and around it, and nobody says where it is.
static void test_noisy_photographs(void **state) {
    (void)state;
    enum { FILES = 2 + 2 * 16 };
    static char paths[FILES][300];
    const char *files[FILES];
    const int n = 2 + ffp_gray_photographs(PANEL_WIDTH, PANEL_HEIGHT);
    FfpRng rng = ffp_rng(11, 3);
    assert_true(n <= FILES && ffp_make_folders(in_scratch("noise"), NULL));
    for (int i = 0; i < n; i++) {
        FfpImage image;
        char name[32];
        assert_true(ffp_image_read_over_black(&image, NULL, shot("", "photos/", i - 2), NULL));
        for (int k = 0; k < 3 * image.width * image.height; k++)
            image.data[k] =
                (real)fmax(0, 0.02 + 0.1 * (double)image.data[k] + 0.005 * (double)ffp_rng_normal(&rng));
        ffp_image_to_srgb(&image);
        snprintf(name, sizeof name, "noise/%03d.png", i);
        snprintf(paths[i], sizeof paths[i], "%s", in_scratch(name));
        files[i] = paths[i];
        assert_true(ffp_image_write_png(&image, paths[i], NULL));
        ffp_image_free(&image);
    }
    FfpGrayPhotographs photographs = {.width = PANEL_WIDTH, .height = PANEL_HEIGHT};
    FfpGrayReport report;
    FfpImage map;
    if (!ffp_gray_find_plain(&photographs, files, n, &err) ||
        !ffp_gray_decode_view(&map, &report, &photographs, &err))
        fail_msg("%s", err.text);
    printf("%d of %d lit pixels have a position\n", report.decoded, report.lit);
    assert_true(report.decoded > 0.8 * report.lit);
    ffp_image_free(&map);
}

// --- Sets of other programs, and damaged ones. ---

typedef enum Inverses { BESIDE, BEHIND_ALL, BEHIND_AXIS, NO_INVERSES } Inverses;

typedef struct Set {
    bool rows_first, finest_first, inverse_first;
    Inverses inverses;
    const char *plain;        // "bw first": b and w before the codes ("bw-", "wb-", "-bw", "")
    int without, twice, lost; // places in the order, from 1: no photograph of it, two of it, none either
    double least,
        apart; // of what the usual order decodes; pixels of the panel by which the middle one differs
} Set;

// Numbers of the photographs in their order, those of black and white being -2 and -1.
static int list_set(const Set *set, int *list) {
    enum { PAIRS = 7 };
    int n = 0, kept = 0, held[64];
    for (const char *c = set->plain; *c && *c != '-'; c++) held[n++] = *c == 'l' ? -3 : *c == 'b' ? -2 : -1;
    for (int k = 0; k < 4 * PAIRS; k++) {
        const int apart = k % (2 * PAIRS);
        const int place = set->inverses == BESIDE        ? k / 2
                          : set->inverses == BEHIND_AXIS ? k / (2 * PAIRS) * PAIRS + apart % PAIRS
                                                         : apart;
        const int second = set->inverses == BESIDE        ? k % 2
                           : set->inverses == BEHIND_AXIS ? apart / PAIRS
                                                          : k / (2 * PAIRS);
        const int axis = (place >= PAIRS) != set->rows_first, bit = place % PAIRS;
        if (set->inverses == NO_INVERSES && second) break;
        held[n++] = 2 * (axis * PAIRS + (set->finest_first ? PAIRS - 1 - bit : bit)) +
                    ((second == 1) != set->inverse_first);
    }
    const char *last = strchr(set->plain, '-');
    for (const char *c = last ? last + 1 : ""; *c; c++) held[n++] = *c == 'b' ? -2 : -1;
    for (int i = 0; i < n; i++) {
        if (i + 1 != set->without && i + 1 != set->lost) list[kept++] = held[i];
        if (i + 1 == set->twice) list[kept++] = held[i];
    }
    return kept;
}

static FfpImage decode_set(const Set *set, int *decoded) {
    static char paths[64][300];
    const char *files[64];
    int list[64];
    FfpGrayCache cache = {.n = 0};
    FfpGrayPhotographs photographs = {.width = PANEL_WIDTH,
                                      .height = PANEL_HEIGHT,
                                      .others = strstr(set->plain, "ll") ? 2 : 0,
                                      .cache = &cache};
    FfpGrayReport report;
    FfpImage map = {0};
    const int n = list_set(set, list);
    for (int i = 0; i < n; i++) {
        snprintf(paths[i], sizeof paths[i], "%s", shot("", "photos/", list[i]));
        files[i] = paths[i];
    }
    if (!ffp_gray_find_plain(&photographs, files, n, &err) ||
        !ffp_gray_decode_view(&map, &report, &photographs, &err))
        fail_msg("%s", err.text);
    assert_true(cache.n > 0);
    ffp_gray_cache_free(&cache);
    *decoded = report.decoded;
    return map;
}

static void write_set_patterns(void) {
    const FfpShow show = {
        .width = PANEL_WIDTH, .height = PANEL_HEIGHT, .lollipops = 2, .capture = true, .gray_codes = true};
    if (!ffp_is_folder(in_scratch("set_patterns")))
        assert_true(ffp_show_write_folder(&show, in_scratch("set_patterns"), &err));
}

// The same photographs, imported as those of a folder of patterns.
static void import_set(FfpCapture *capture, const Set *set, const char *name) {
    static char files[200], patterns[200];
    static FfpImportImages images;
    char from[300], to[300];
    int list[64];
    const int n = list_set(set, list);
    snprintf(from, sizeof from, "sets/%s", name);
    assert_true(ffp_make_folders(in_scratch(from), NULL));
    snprintf(files, sizeof files, "%s/sets/%s/*.png", scratch, name);
    for (int i = 0; i < n; i++) {
        snprintf(from, sizeof from, "%s", shot("", "photos/", list[i]));
        snprintf(to, sizeof to, "%s/sets/%s/%03d.png", scratch, name, i + 1);
        assert_int_equal(link(from, to), 0);
    }
    Call *call = call_of(name);
    images = (FfpImportImages){.files = files};
    snprintf(patterns, sizeof patterns, "%s/set_patterns", scratch);
    call->options.images = &images, call->options.n_images = 1;
    call->options.gray_codes = NULL, call->options.shown = patterns;
    call->options.kept_codes = 8;
    import(capture, call);
}

// Masks (to which the codes that are taken as patterns add), black, white, positions and the photographs that
// are kept are those of the usual order.
static void check_set(const FfpCapture *capture, const FfpCapture *usual, const Set *set) {
    const FfpView *view = &capture->views[0], *expected = &usual->views[0];
    const size_t pixels = (size_t)expected->camera.width * (size_t)expected->camera.height;
    real *apart = ffp_alloc(pixels, sizeof *apart);
    size_t other = 0, known = 0, both = 0;
    for (size_t i = 0; i < pixels; i++) {
        const real *p = view->correspondence.data + 3 * i, *q = expected->correspondence.data + 3 * i;
        other += (view->coverage.data[i] > 0.5F) != (expected->coverage.data[i] > 0.5F);
        known += q[2] > 0;
        if (p[2] > 0 && q[2] > 0) apart[both++] = (real)hypot((double)(p[0] - q[0]), (double)(p[1] - q[1]));
    }
    const double middle = (double)ffp_median(apart, both);
    int same = 0;
    double most = 0;
    for (int p = 0; p < capture->n_patterns; p++) {
        const int k = ffp_capture_find_pattern(usual, capture->patterns[p].name);
        double off = 0;
        for (size_t i = 0; k >= 0 && i < 3 * pixels; i++)
            off +=
                fabs((double)(view->images[p].data[i] - expected->images[k].data[i])) / (double)(3 * pixels);
        same += k >= 0, most = fmax(most, off);
    }
    printf("  import: %zu of %zu known, %.4f apart; %zu pixels of the mask differ; %d photographs by %.4f\n",
           both, known, middle, other, same, most);
    assert_true((double)both >= 0.97 * (double)known && middle <= set->apart + 1e-9);
    assert_true((double)other < 0.02 * (double)known && same >= 5 && most < 0.01);
    ffp_free(apart);
}

// Sets in the orders of other programs, without black and white or inverses, and with one photograph missing
// or too many, are decoded as that of `patterns`.
static void test_sets(void **state) {
    (void)state;
    static const Set
        usual = {.plain = "bw-"},
        sets[] = {
            {.rows_first = true, .plain = "bw-", .least = 1},
            {.finest_first = true, .plain = "-bw", .least = 1},
            {.inverse_first = true, .plain = "wb-", .least = 1},
            {.inverses = BEHIND_ALL, .plain = "bw-", .least = 1},
            {.inverses = BEHIND_AXIS, .rows_first = true, .finest_first = true, .plain = "-wb", .least = 1},
            {.inverses = NO_INVERSES, .plain = "bw-", .least = 0.98, .apart = 0.05},
            {.inverses = NO_INVERSES,
             .finest_first = true,
             .plain = "-bw",
             .without = 1,
             .least = 0.98,
             .apart = 0.05},
            {.plain = "", .least = 0.97, .apart = 0.02},
            {.inverses = BEHIND_ALL, .rows_first = true, .plain = "", .least = 0.97, .apart = 0.02},
            {.plain = "bw-", .without = 1, .least = 0.97, .apart = 0.02},
            {.plain = "bw-", .without = 2, .least = 0.97, .apart = 0.02},
            {.plain = "bw-", .without = 8, .least = 0.98, .apart = 0.02},
            {.plain = "bw-", .twice = 11, .least = 1},
            {.rows_first = true, .plain = "bw-", .without = 5, .least = 0.98, .apart = 0.02},
            {.plain = "bwll-", .without = 12, .least = 0.98, .apart = 0.02},
            {.plain = "bwll-", .without = 8, .lost = 21, .least = 0.98, .apart = 0.02},
            {.plain = "bwll-", .twice = 12, .least = 1},
            {.plain = "b-w", .least = 1},
            {.plain = "b-w", .inverses = BEHIND_ALL, .without = 9, .least = 0.98, .apart = 0.02},
            {.plain = "bw-", .without = 8, .lost = 21, .least = 0.98, .apart = 0.02},
            {.plain = "bw-", .without = 1, .lost = 12, .least = 0.96, .apart = 0.03},
            {.plain = "bw-", .without = 30, .twice = 12, .least = 0.96, .apart = 0.03},
            {.inverses = BEHIND_ALL, .plain = "bw-", .twice = 7, .least = 1}};
    int decoded, usually;
    FfpImage expected = decode_set(&usual, &usually);
    FfpCapture as_usual, capture;
    write_set_patterns();
    import_set(&as_usual, &usual, "set");
    for (size_t i = 0; i < sizeof sets / sizeof *sets; i++) {
        FfpImage map = decode_set(&sets[i], &decoded);
        real *apart = ffp_alloc((size_t)WIDTH * HEIGHT, sizeof *apart);
        size_t both = 0;
        for (int p = 0; p < 3 * WIDTH * HEIGHT; p += 3)
            if (map.data[p + 2] > 0 && expected.data[p + 2] > 0)
                apart[both++] = (real)hypot((double)(map.data[p] - expected.data[p]),
                                            (double)(map.data[p + 1] - expected.data[p + 1]));
        const double middle = (double)ffp_median(apart, both);
        printf("set %zu: %.3f of the pixels, %.4f pixels apart\n", i, decoded / (double)usually, middle);
        assert_true(decoded >= sets[i].least * usually && middle <= sets[i].apart);
        ffp_image_free(&map), ffp_free(apart);
        char name[32];
        snprintf(name, sizeof name, "set_%zu", i);
        import_set(&capture, &sets[i], name);
        check_set(&capture, &as_usual, &sets[i]);
        ffp_capture_free(&capture);
    }
    ffp_image_free(&expected), ffp_capture_free(&as_usual);
}

// Where the object lies beside the edge of the first code, which is then all dark, lollipops do not pass for
// it.
static void test_code_without_edges(void **state) {
    (void)state;
    static char paths[40][300];
    const char *files[40];
    FfpGrayCache cache = {.n = 0};
    FfpGrayPhotographs photographs = {.width = PANEL_WIDTH, .height = PANEL_HEIGHT, .cache = &cache};
    const int before[] = {-2, -1, -3, -3, -2, -1}; // black, white, lollipops, the first code and its inverse
    int n = 0;
    for (size_t i = 0; i < sizeof before / sizeof *before; i++)
        snprintf(paths[n++], sizeof paths[0], "%s", shot("", "photos/", before[i]));
    for (int i = 2; i < ffp_gray_photographs(PANEL_WIDTH, PANEL_HEIGHT); i++)
        snprintf(paths[n++], sizeof paths[0], "%s", shot("", "photos/", i));
    for (int i = 0; i < n; i++) files[i] = paths[i];
    if (!ffp_gray_find_plain(&photographs, files, n, &err)) fail_msg("%s", err.text);
    assert_string_equal(photographs.codes[0], files[4]);
    assert_string_equal(photographs.codes[1], files[5]);
    assert_string_equal(photographs.codes[2], files[6]);
    ffp_gray_cache_free(&cache);
}

// A stray thumbnail is left out; and codes under another light than black and white are said to be.
static void test_strays(void **state) {
    (void)state;
    static char paths[40][300];
    const char *files[40];
    FfpGrayCache cache = {.n = 0};
    FfpGrayPhotographs photographs = {.width = PANEL_WIDTH, .height = PANEL_HEIGHT, .cache = &cache};
    FfpImage thumbnail = ffp_image_new(WIDTH / 4, HEIGHT / 4, 3), lamp;
    int n = 0;
    assert_true(ffp_image_write_png(&thumbnail, in_scratch("thumbnail.png"), NULL));
    snprintf(paths[n++], sizeof paths[0], "%s", in_scratch("thumbnail.png"));
    for (int i = -2; i < ffp_gray_photographs(PANEL_WIDTH, PANEL_HEIGHT); i++)
        snprintf(paths[n++], sizeof paths[0], "%s", shot("", "photos/", i));
    for (int i = 0; i < n; i++) files[i] = paths[i];
    if (!ffp_gray_find_plain(&photographs, files, n, &err)) fail_msg("%s", err.text);
    assert_true(photographs.white == files[2] && photographs.codes[0] == files[3]);
    ffp_gray_cache_free(&cache);
    for (int i = n - 2; i < n; i++) {
        char name[32];
        snprintf(name, sizeof name, "lamp_%d.png", i);
        assert_true(ffp_image_read_over_black(&lamp, NULL, files[i], NULL));
        for (int k = 0; k < 3 * WIDTH * HEIGHT; k++) lamp.data[k] = (real)fmin(1, 0.6 + (double)lamp.data[k]);
        ffp_image_to_srgb(&lamp);
        snprintf(paths[i], sizeof paths[0], "%s", in_scratch(name));
        assert_true(ffp_image_write_png(&lamp, paths[i], NULL));
        ffp_image_free(&lamp);
    }
    assert_false(ffp_gray_find_plain(&photographs, files + 1, n - 1, &err));
    must_be(&err, FFP_RULE_PLAIN_OUTSHONE);
    ffp_gray_cache_free(&cache), ffp_image_free(&thumbnail);
}

// Of codes alone black and white are made, and where the only pattern is held out a code is the one to match.
static void test_codes_alone(void **state) {
    (void)state;
    FfpCapture capture;
    char held[200], file[200], codes[200], patterns[200];
    int known = 0;
    const char *name = "lollipop";
    write_set_patterns();
    snprintf(file, sizeof file, "%s", shot("", "photos/", 3));
    snprintf(codes, sizeof codes, "%s/photos/*.png", scratch);
    snprintf(patterns, sizeof patterns, "%s/set_patterns", scratch);
    snprintf(held, sizeof held, "%s/set_patterns/003_lollipop_0.png", scratch);
    const FfpImportImages images[] = {{.files = codes}, {.patterns = &name, .n_patterns = 1, .files = file}};
    const FfpImportPattern pattern = {.name = name, .file = held};
    for (int by_name = 0; by_name < 2; by_name++) {
        Call *call = call_of(by_name ? "codes_by_name" : "codes_alone");
        call->options.images = images + by_name, call->options.n_images = 2 - by_name;
        call->options.held_out = &pattern, call->options.n_held_out = 1;
        if (!by_name) call->options.gray_codes = NULL, call->options.shown = patterns;
        import(&capture, call);
        const int shown = capture.n_patterns - capture.n_codes;
        assert_true(positions_off(&capture.views[0], 0.5, &known) < 0.06 && known > 8500);
        assert_true(capture.black >= 0 && capture.white >= 0 && shown == 4);
        assert_true(ffp_capture_find_pattern(&capture, "gray_x_05") >= 0);
        ffp_capture_free(&capture);
    }
}

static void enlarge(const char *from, const char *to, int times) {
    FfpImage small, large;
    assert_true(ffp_image_read(&small, from, FFP_COLOUR_ENCODED, NULL));
    large = ffp_image_resize(&small, times * small.width, times * small.height);
    assert_true(ffp_image_write_png(&large, to, NULL));
    ffp_image_free(&small), ffp_image_free(&large);
}

// Photographs with many more pixels than capture and panel are reduced before: the same comes out.
static void test_large_photographs(void **state) {
    (void)state;
    enum { TIMES = 6 };
    FfpCapture capture, large;
    Call *call = call_of("plain");
    int known = 0, known_large = 0;
    call->options.width = WIDTH / 2;
    import(&capture, call);
    assert_true(ffp_make_folders(in_scratch("large"), NULL));
    for (int i = -2; i < ffp_gray_photographs(PANEL_WIDTH, PANEL_HEIGHT); i++)
        enlarge(shot("", "photos/", i), shot("large/", "large/", i), TIMES);
    call = call_of("enlarged");
    snprintf(call->black, sizeof call->black, "%s/large/black.png", scratch);
    snprintf(call->white, sizeof call->white, "%s/large/white.png", scratch);
    snprintf(call->codes, sizeof call->codes, "%s/large/[0-9]*.png", scratch);
    call->options.width = WIDTH / 2;
    call->options.camera.fit = FFP_FIT_SCALED;
    import(&large, call);
    const double off = positions_off(&capture.views[0], 0.5, &known),
                 off_large = positions_off(&large.views[0], 0.5, &known_large);
    printf("%d pixels, off by %.3f; enlarged %d, off by %.3f\n", known, off, known_large, off_large);
    assert_true(known_large > 0.95 * known && off_large < 1.5 * off);
    double sum = 0;
    const size_t values = 3 * (size_t)capture.views[0].camera.width * (size_t)capture.views[0].camera.height;
    for (size_t i = 0; i < values; i++)
        sum += fabs((double)(capture.views[0].images[capture.white].data[i] -
                             large.views[0].images[large.white].data[i]));
    assert_true(sum < 0.004 * (double)values);
    ffp_capture_free(&capture), ffp_capture_free(&large);
}

// Photographs of codes are kept for fits: none of one that the capture has, as its pattern or held out, and
// none that its pixels cannot resolve.
static void test_codes_for_fits(void **state) {
    (void)state;
    static const char *const held[1] = {"stripes"};
    static char files[2][1100];
    FfpCapture capture;
    Call *call = call_of("kept");
    FfpImage same = ffp_pattern_gray_code(PANEL_WIDTH, PANEL_HEIGHT, 0, 3, true);
    snprintf(files[0], sizeof files[0], "%s/stripes.png", scratch);
    snprintf(files[1], sizeof files[1], "%s/photos/007.png", scratch);
    assert_true(ffp_image_write_png(&same, files[0], NULL));
    ffp_image_free(&same);
    const FfpImportImages images[3] = {
        call->images[0], call->images[1], {.patterns = held, .n_patterns = 1, .files = files[1]}};
    const FfpImportPattern held_out = {.name = held[0], .file = files[0]};
    call->options.images = images, call->options.n_images = 3;
    call->options.held_out = &held_out, call->options.n_held_out = 1;
    call->options.kept_codes = 8;
    call->options.width = WIDTH / 2; // some 2 pixels of the panel from one to the next
    import(&capture, call);
    static const char *const names[8] = {"gray_x_04", "gray_y_04", "gray_x_02_inverse", "gray_y_03_inverse",
                                         "gray_x_01", "gray_y_02", "gray_x_00_inverse", "gray_y_01_inverse"};
    assert_int_equal(capture.n_codes, 8);
    for (int k = 0; k < 8; k++) {
        const int p = ffp_patterns_shown(&capture) + k;
        assert_string_equal(capture.patterns[p].name, names[k]);
        assert_true(capture.patterns[p].novel && capture.views[0].images[p].data);
    }
    // The photograph shows the code: lit where the code's picture is, by the correspondence.
    const FfpView *view = &capture.views[0];
    const int code = ffp_patterns_shown(&capture);
    int right = 0, known = 0;
    for (int i = 0; i < view->camera.width * view->camera.height; i++) {
        const real *at = view->correspondence.data + 3 * i, *dark = view->images[capture.black].data + 3 * i,
                   *lit = view->images[capture.white].data + 3 * i;
        if (!(at[2] > 0) || at[0] < 0 || at[1] < 0 || at[0] >= PANEL_WIDTH || at[1] >= PANEL_HEIGHT) continue;
        const real shown = capture.patterns[code].image.data[3 * ((int)at[1] * PANEL_WIDTH + (int)at[0])];
        const real seen = (view->images[code].data[3 * i] - dark[0]) / (lit[0] - dark[0]);
        known++, right += (seen > 0.5F) == (shown > 0.5F);
    }
    assert_true(known > 1000 && right > 0.9 * known);
    ffp_capture_free(&capture);
    call->options.kept_codes = 33;
    snprintf(call->folder, sizeof call->folder, "%s/kept33", scratch);
    assert_false(ffp_import(&call->options, &err));
    assert_non_null(strstr(err.text, "33 is not in 0 to 32 (kept_codes)"));
}

static bool is_held_out(const FfpCapture *capture, const char *name) {
    const int p = ffp_capture_find_pattern(capture, name);
    return p >= 0 && p < ffp_patterns_shown(capture) && capture->patterns[p].novel &&
           capture->views[0].images[p].data;
}

// Of a capture that holds nothing out two codes are: fits have the others, whose photographs are the same,
// and a reconstruction is judged by these two.
static void test_codes_held_out(void **state) {
    (void)state;
    FfpCapture with, without;
    int unseen[FFP_UNSEEN_MAX];
    Call *call = call_of("judged");
    call->options.width = WIDTH / 2;
    call->options.kept_codes = 6;
    import(&with, call);
    assert_int_equal(with.n_codes, 6);
    assert_int_equal(ffp_capture_unseen(&with, NULL, 0, unseen), 2);
    assert_true(is_held_out(&with, "gray_x_00") && is_held_out(&with, "gray_y_00"));
    assert_int_equal(ffp_capture_unseen(&with, unseen, 1, unseen + 1), 1);
    call = call_of("all_kept"); // more than there are: none is left to judge by
    call->options.width = WIDTH / 2;
    call->options.kept_codes = 10;
    import(&without, call);
    assert_true(without.n_codes == 10 && ffp_capture_unseen(&without, NULL, 0, unseen) == 0);
    for (int k = 0; k < 6; k++) {
        const int p = ffp_patterns_shown(&with) + k, q = ffp_patterns_shown(&without) + k;
        assert_string_equal(with.patterns[p].name, without.patterns[q].name);
        assert_memory_equal(with.views[0].images[p].data, without.views[0].images[q].data,
                            3 * sizeof(real) * (size_t)with.views[0].images[p].width *
                                (size_t)with.views[0].images[p].height);
    }
    ffp_capture_free(&with), ffp_capture_free(&without);
}

// The photographs of the pairs from `from` on, in linear light times `gain` and `more`, into other/.
static void change_light(int from, double gain, double more) {
    char name[64];
    assert_true(ffp_make_folders(in_scratch("other"), NULL));
    for (int i = 0; i < ffp_gray_photographs(PANEL_WIDTH, PANEL_HEIGHT); i++) {
        FfpImage image;
        assert_true(ffp_image_read_over_black(&image, NULL, shot("", "photos/", i), NULL));
        for (int k = 0; i / 2 >= from && k < 3 * image.width * image.height; k++)
            image.data[k] = (real)fmin(1, gain * (double)image.data[k] + more);
        ffp_image_to_srgb(&image);
        snprintf(name, sizeof name, "other/%03d.png", i);
        assert_true(ffp_image_write_png(&image, in_scratch(name), NULL));
        ffp_image_free(&image);
    }
}

// A code and its inverse that add up to another light than white are still each other's inverse: positions
// are the same, the finding has the size, and no fit sees them. Fine ones that are dim are left out.
static void test_other_light(void **state) {
    (void)state;
    static const struct {
        int from;
        double gain, more;
        int codes;
        const char *told;
    } cases[] = {{0, 1, 0.1, 0, "codes-light "},
                 {0, 0.65, 0, 0, "codes-light "},
                 {3, 0.6, 0, 3, "codes-light "},
                 {12, 0.6, 0, 6, "codes-dim "}};
    FfpCapture capture;
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        int known = 0;
        char name[32], said[4096] = "";
        FfpContext context = {.settings = {.finding = keep_told, .user = said}};
        snprintf(name, sizeof name, "light_%zu", i);
        change_light(cases[i].from, cases[i].gain, cases[i].more);
        Call *call = call_of(name);
        snprintf(call->codes, sizeof call->codes, "%s/other/[0-9]*.png", scratch);
        call->options.kept_codes = 6;
        call->options.width = WIDTH / 2;
        if (!ffp_call_run(&context, import_call, call, &err)) fail_msg("%s", err.text);
        if (!strstr(said, cases[i].told)) fail_msg("no %s: %s", cases[i].told, said);
        assert_true(ffp_capture_read(&capture, call->folder, &err));
        const double off = positions_off(&capture.views[0], 0.5, &known);
        printf("%s: %d pixels, off by %.3f, %d codes for fits\n", name, known, off, capture.n_codes);
        assert_true(known > 1000 && off < 0.1 && capture.n_codes == cases[i].codes);
        ffp_capture_free(&capture);
    }
}

// All photographs of what `patterns` wrote in one folder, with the codes and without.
static void test_as_shown(void **state) {
    (void)state;
    FfpCapture capture;
    char command[512], files[2][200], patterns[200];
    const FfpShow show = {.width = PANEL_WIDTH,
                          .height = PANEL_HEIGHT,
                          .lollipops = 1,
                          .focus = true,
                          .capture = true,
                          .gray_codes = true};
    int known = 0;
    assert_true(ffp_show_write_folder(&show, in_scratch("shown"), &err));
    assert_true(ffp_make_folders(in_scratch("all"), NULL));
    take_lollipop("all/img_3.png");
    snprintf(command, sizeof command,
             "cd '%s' && cp black.png all/img_1.png && cp white.png all/img_2.png && mkdir few && cp all/* "
             "few/ && "
             "i=4; for f in photos/*.png; do cp $f all/img_$i.png; i=$((i+1)); done",
             scratch);
    assert_int_equal(system(command), 0);
    snprintf(patterns, sizeof patterns, "%s/shown", scratch);
    for (int codes = 0; codes < 2; codes++) {
        Call *call = call_of(codes ? "as_shown" : "as_shown_plain");
        snprintf(files[codes], sizeof files[codes], "%s/%s/*.png", scratch, codes ? "all" : "few");
        const FfpImportImages images = {.files = files[codes]};
        call->options.images = &images;
        call->options.n_images = 1;
        call->options.gray_codes = NULL;
        call->options.shown = patterns;
        import(&capture, call);
        assert_true(capture.n_patterns == 3 && strcmp(capture.patterns[2].name, "lollipop_0") == 0);
        assert_int_equal(capture.views[0].correspondence.data != NULL, codes);
        if (codes) assert_true(positions_off(&capture.views[0], 0.5, &known) < 0.06 && known > 1000);
        ffp_capture_free(&capture);
    }
    // Another number of photographs, and a folder of no patterns.
    Call *call = call_of("as_shown_wrong");
    const FfpImportImages images = {.files = files[1]};
    call->options.images = &images;
    call->options.n_images = 1;
    call->options.shown = patterns;
    assert_false(ffp_import(&call->options, &err)); // codes named as well
    assert_non_null(strstr(err.text, "the photographs include the Gray codes"));
    call->options.gray_codes = NULL;
    // A code's photograph may be missing, by the numbers in the names; a pattern's may not.
    assert_int_equal(remove(in_scratch("all/img_9.png")), 0);
    import(&capture, call);
    assert_true(capture.n_patterns == 3 && positions_off(&capture.views[0], 0.5, &known) < 0.06 &&
                known > 1000);
    ffp_capture_free(&capture);
    snprintf(call->folder, sizeof call->folder, "%s/as_shown_never", scratch);
    assert_int_equal(remove(in_scratch("all/img_3.png")) + remove(in_scratch("all/img_5.png")) +
                         remove(in_scratch("all/img_20.png")),
                     0);
    assert_false(ffp_import(&call->options, &err));
    assert_non_null(strstr(err.text, "27 files match, but a view has 31 photographs"));
    call->options.shown = scratch;
    assert_false(ffp_import(&call->options, &err));
    assert_non_null(strstr(err.text, "no picture is called <number>_<name>.png"));
    call->options.shown = NULL;
    assert_false(ffp_import(&call->options, &err));
    assert_non_null(strstr(err.text, "without names of patterns"));
}

// --- A surface behind bars. ---

// Slanting bars before a wall, nowhere lit by the middle of the panel: where one bit alone changes, it is at
// an outline of a bar, and numbers jump by 13. Columns and rows of the panel at a pixel; false: dark.
static bool bars(int x, int y, int *column, int *row) {
    const bool bar = (x + y) / 4 % 2;
    *column = 20 + x / 2 + (bar ? 13 : 0);
    *row = 10 + y / 2 + (bar ? 8 : 0);
    return *column < 61 || *column > 67;
}

static void test_outlines_are_no_disorder(void **state) {
    (void)state;
    const int n = ffp_gray_photographs(PANEL_WIDTH, PANEL_HEIGHT);
    char files[32][200];
    const char *codes[32];
    assert_true(ffp_make_folders(in_scratch("bars"), NULL) && n + 2 <= 32);
    for (int i = 0; i < n + 2; i++) { // then black and white
        FfpImage out = ffp_image_new(WIDTH, HEIGHT, 3);
        int axis, bit;
        ffp_gray_code_place(PANEL_WIDTH, i, &axis, &bit);
        const int bits = ffp_gray_code_bits(axis ? PANEL_HEIGHT : PANEL_WIDTH);
        for (int p = 0; p < WIDTH * HEIGHT; p++) {
            int at[2];
            const bool lit = bars(p % WIDTH, p / WIDTH, &at[0], &at[1]);
            const unsigned word = (unsigned)at[axis] ^ (unsigned)at[axis] >> 1;
            const bool on = i < n ? (word >> (bits - 1 - bit) & 1U) != (i % 2 == 1) : i == n + 1;
            for (int c = 0; c < 3; c++) out.data[3 * p + c] = lit && on ? 0.8F : 0.05F;
        }
        snprintf(files[i], sizeof files[i], "%s/bars/%03d.png", scratch, i);
        codes[i] = files[i];
        assert_true(ffp_image_write_png(&out, files[i], &err));
        ffp_image_free(&out);
    }
    const FfpGrayPhotographs from = {.width = PANEL_WIDTH,
                                     .height = PANEL_HEIGHT,
                                     .codes = codes,
                                     .black = files[n],
                                     .white = files[n + 1]};
    FfpGrayReport report;
    FfpImage map;
    if (!ffp_gray_decode_view(&map, &report, &from, &err)) fail_msg("%s", err.text);
    assert_true(report.decoded > 0.8 * report.lit);
    ffp_image_free(&map);
}

// Contents that a capture's file may have.
static void test_bad_correspondences(void **state) {
    (void)state;
    FfpCapture capture;
    Call *call = call_of("spoilt");
    char path[300];
    import(&capture, call);
    snprintf(path, sizeof path, "sed -i s/000_correspondence.png/000_correspondence.exr/ %s/scene.json",
             call->folder);
    assert_int_equal(system(path), 0);
    snprintf(path, sizeof path, "%s/000_correspondence.exr", call->folder);
    FfpImage *map = &capture.views[0].correspondence;
    map->data[2] = 1.5F;
    FfpCapture again;
    assert_true(ffp_image_write_exr(map, path, NULL));
    assert_false(ffp_capture_read(&again, call->folder, &err));
    assert_non_null(strstr(err.text, "confidence (the third channel) is outside 0 to 1"));
    assert_non_null(strstr(err.text, "000_correspondence.exr"));
    map->data[2] = 1, map->data[0] = -5000;
    assert_true(ffp_image_write_exr(map, path, NULL));
    assert_false(ffp_capture_read(&again, call->folder, &err));
    assert_non_null(strstr(err.text, "far outside the projector's"));
    FfpImage small = ffp_image_new(8, 8, 3);
    assert_true(ffp_image_write_exr(&small, path, NULL));
    ffp_image_free(&small);
    assert_false(ffp_capture_read(&again, call->folder, &err));
    assert_non_null(strstr(err.text, "image is 8 x 8"));
    ffp_capture_free(&capture);
}

// Root mean square distance of the board's points from their plane, the farthest hundredth left out.
static double board_off(const FfpView *view, int *known) {
    enum { LEFT = 250, TOP = 205, RIGHT = 955, BOTTOM = 765 };
    double a[16] = {0}, b[4] = {0}, x[3], *offs = ffp_alloc((RIGHT - LEFT) * (BOTTOM - TOP), sizeof *offs),
           sum = 0;
    for (int round = 0; round < 2; round++) {
        *known = 0;
        for (int j = TOP; j < BOTTOM; j++)
            for (int i = LEFT; i < RIGHT; i++) {
                real off, point[3];
                const real z =
                    ffp_coded_depth(view, (size_t)j * (size_t)view->camera.width + (size_t)i, &off);
                if (!(z > 0)) continue;
                ffp_point_at(&view->camera, (real)i + 0.5F, (real)j + 0.5F, z, point);
                // z = x0 + x1 u + x2 v in metres, u and v across the board
                const double row[3] = {1, (double)point[0] / 1000, (double)point[1] / 1000};
                const double height = (double)point[2] / 1000 - 3.6;
                if (round == 0)
                    for (int k = 0; k < 3; k++) {
                        b[k] -= row[k] * height;
                        for (int m = 0; m < 3; m++) a[3 * k + m] += row[k] * row[m];
                    }
                else
                    offs[*known] = fabs(height - x[0] - x[1] * row[1] - x[2] * row[2]) /
                                   sqrt(1 + x[1] * x[1] + x[2] * x[2]);
                ++*known;
            }
        if (round == 0) ffp_solve_positive(a, b, 3, x);
    }
    qsort(offs, (size_t)*known, sizeof *offs, compare);
    const int kept = (int)(0.99 * *known);
    for (int i = 0; i < kept; i++) sum += offs[i] * offs[i];
    ffp_free(offs);
    return 1000 * sqrt(sum / kept);
}

// A real board 3.6 m away: millimetres.
static void test_real_board(void **state) {
    (void)state;
    char root[1024], files[4][1100];
    if (!shared_path(root, "real/kamino410/sample")) skip();
    Call *call = call_of("board");
    FfpCapture capture;
    int known = 0;
    static const char *const names[4] = {"opencv_reference.xml", "capture_0/graycode_41.jpg",
                                         "capture_0/graycode_40.jpg", "capture_0/graycode_[0-3]*.jpg"};
    for (int i = 0; i < 4; i++) snprintf(files[i], sizeof files[i], "%s/%s", root, names[i]);
    call->files[0] = files[0];
    call->images[0].files = files[1], call->images[1].files = files[2];
    call->options.gray_codes = files[3];
    call->options.projector = (FfpCalibratedAt){.width = 1024, .height = 768};
    call->options.linear_images = true;
    call->options.width = 1280; // the whole picture, for the places above
    import(&capture, call);
    const double off = board_off(&capture.views[0], &known);
    printf("%d points of the board, %.2f mm from their plane\n", known, off);
    assert_true(known > 300000 && off < 0.9);
    ffp_capture_free(&capture);
}

// --- Faults. ---

// A change to a copy of the photographs, or to the call; the finding that the error must be, and words that
// it must contain, the file or field among them.
typedef struct Fault {
    const char *command; // of the shell, in the copy's folder
    void (*change)(Call *call);
    FfpRuleId rule; // 0: the words alone tell
    const char *words[2];
} Fault;

#define SWAP(a, b) "mv " a ".png x && mv " b ".png " a ".png && mv x " b ".png"
#define TURN(a, b) SWAP("photos/" a, "photos/" b)

static void by_name(Call *call) {
    snprintf(call->codes, sizeof call->codes, "%s/fault/named/{pattern}.png", scratch);
}
static void one_file(Call *call) {
    snprintf(call->codes, sizeof call->codes, "%s/fault/photos/005.png", scratch);
}
static void no_file(Call *call) {
    call->codes[0] = 0;
}
static void nowhere(Call *call) {
    snprintf(call->codes, sizeof call->codes, "%s/fault/nowhere/*.png", scratch);
}
static void same_plain(Call *call) {
    memcpy(call->black, call->white, sizeof call->black);
}
static void other_rig(Call *call) {
    snprintf(call->calibration, sizeof call->calibration, "%s/fault/other.yml", scratch);
}

// Two stops of a table, in the folders 000 and 030.
static void two_stops(Call *call) {
    call->options.turntable = turntable();
    snprintf(call->black, sizeof call->black, "%s/fault/{view}/black.png", scratch);
    snprintf(call->white, sizeof call->white, "%s/fault/{view}/white.png", scratch);
}
static void two_stops_alike(Call *call) {
    two_stops(call);
    snprintf(call->codes, sizeof call->codes, "%s/fault/named/{pattern}.png", scratch);
}
static void two_stops_named(Call *call) {
    two_stops(call);
    snprintf(call->codes, sizeof call->codes, "%s/fault/{view}/[0-9]*.png", scratch);
}
#define STOPS "mkdir 000 && cp photos/*.png black.png white.png 000/ && cp -r 000 030"

static const Fault faults[] = {
    {"rm photos/0[01]?.png", NULL, 0, {"8 files match, but a view has 28 photographs", "photos/*.png"}},
    {"cp photos/005.png photos/005b.png && cp photos/009.png photos/009b.png && cp photos/020.png "
     "photos/a.png",
     NULL,
     0,
     {"31 files match, but a view has 28 photographs"}},
    {"rm -r photos", NULL, 0, {"no file matches", "photos/*.png"}},
    {"true", nowhere, 0, {"no file matches", "nowhere/*.png"}},
    {"true", no_file, 0, {"no file given", "(gray_codes)"}},
    {"true", one_file, 0, {"names one file for 28 Gray codes", "005.png"}},
    {"mkdir named", by_name, 0, {"view '000' under Gray code 'gray_x_00'", "named/gray_x_00.png"}},
    {STOPS, two_stops_alike, 0, {"names one file for 2 views", "{pattern}.png"}},
    {STOPS " && rm 030/0[01]?.png", two_stops_named, 0, {"8 files match", "030/[0-9]*.png"}},
    {STOPS " && rm -r 030", two_stops_named, 0, {"no such file", "030/black.png"}},
    // Numbers.
    {TURN("004", "010") " && " TURN("005", "011"),
     NULL,
     FFP_RULE_CODES_SWAPPED,
     {"the pairs of 004.png and 010.png"}},
    {TURN("006", "007"), NULL, FFP_RULE_CODES_SWAPPED, {"006.png and 007.png", "photos/006.png"}},
    {TURN("022", "023"), NULL, FFP_RULE_CODES_SWAPPED, {"022.png and 023.png", "photos/022.png"}},
    {TURN("008", "020"), NULL, FFP_RULE_CODES_SWAPPED, {"008.png and 020.png", "photos/008.png"}},
    // Two apart: a code and the next finer one, whose inverses stay.
    {TURN("002", "004"), NULL, FFP_RULE_CODES_SWAPPED, {"002.png and 004.png", "photos/002.png"}},
    {TURN("004", "006"), NULL, FFP_RULE_CODES_SWAPPED, {"004.png and 006.png", "photos/004.png"}},
    {TURN("007", "009"), NULL, FFP_RULE_CODES_SWAPPED, {"007.png and 009.png", "photos/006.png"}},
    {TURN("000", "002"), NULL, FFP_RULE_CODES_SWAPPED, {"000.png and 002.png", "photos/000.png"}},
    {TURN("005", "006"), NULL, FFP_RULE_CODES_SWAPPED, {"005.png and 006.png", "photos/004.png"}},
    {"cp photos/009.png photos/008.png && cp photos/015.png photos/014.png",
     NULL,
     FFP_RULE_CODES_NO_PAIR,
     {"photos/008.png"}},
    {"rm photos/000.png photos/010.png && cp photos/027.png photos/028.png && cp photos/027.png "
     "photos/029.png",
     NULL,
     FFP_RULE_CODES_NO_PAIR,
     {"photos/001.png"}},
    // These mirror or turn everything: the calibration tells, or the panel where it ends early.
    {TURN("000", "001"),
     NULL,
     FFP_RULE_CODES_ELSEWHERE,
     {"view '000'", "away from where the calibration puts them"}},
    // Behind the projector all is off by more than the panel.
    {"sed '/^R:/,/^T:/s/data: *.*/data: [ -1, 0, 0, 0, 1, 0, 0, 0, -1 ]/' ../rig.yml > other.yml",
     other_rig,
     FFP_RULE_CODES_ELSEWHERE,
     {"150.0 or more"}},
    {"sed 's/prjW: 120/prjW: 80/' ../rig.yml > other.yml", other_rig, FFP_RULE_PANEL_SIZE, {"columns", "80"}},
    {"sed 's/prjW: 120/prjW: 260/' ../rig.yml > other.yml", other_rig, FFP_RULE_CODES_MISSING, {"28 of 32"}},
    // Light.
    {"cp ../spare/dim.png photos/008.png", NULL, FFP_RULE_CODES_EXPOSURE, {"darker", "photos/008.png"}},
    {"cp ../spare/bright.png photos/009.png", NULL, FFP_RULE_CODES_EXPOSURE, {"brighter", "photos/009.png"}},
    {SWAP("black", "white"), NULL, FFP_RULE_PLAIN_SWAPPED, {"white.png"}},
    {"cp black.png white.png", NULL, FFP_RULE_WHITE_IS_BLACK, {"'black.png' and 'white.png'"}},
    {"true", same_plain, 0, {"is named twice: view '000' under 'black' and under 'white'", "white.png"}},
    {"cp ../spare/full.png white.png && cp ../spare/full.png black.png",
     NULL,
     FFP_RULE_BOTH_CLIPPED,
     {"white.png"}},
    {"rm black.png", NULL, 0, {"no such file", "black.png"}},
    // Files.
    {"cp ../spare/small.png photos/013.png", NULL, 0, {"80 x 120, but the others are 160 x 120", "013.png"}},
    {"printf GIF89a > photos/020.png", NULL, 0, {"photos/020.png"}},
    {"head -c 500 photos/020.png > x && mv x photos/020.png", NULL, 0, {"photos/020.png"}},
    {": > photos/021.png", NULL, 0, {"file is empty", "photos/021.png"}},
};

static void make_spare(void) {
    FfpImage small = ffp_image_new(WIDTH / 2, HEIGHT, 3), full = ffp_image_new(WIDTH, HEIGHT, 3);
    for (int i = 0; i < 3 * WIDTH * HEIGHT; i++) full.data[i] = 1;
    assert_true(ffp_make_folders(in_scratch("spare"), NULL));
    assert_true(ffp_image_write_png(&small, in_scratch("spare/small.png"), NULL));
    assert_true(ffp_image_write_png(&full, in_scratch("spare/full.png"), NULL));
    ffp_image_free(&small), ffp_image_free(&full);
    take(8, "spare/dim.png", 0.5), take(9, "spare/bright.png", 2);
}

static void must_fail(const Fault *fault) {
    Call *call = call_of("never");
    char command[1024];
    snprintf(
        command, sizeof command,
        "cd '%s' && rm -rf fault && mkdir fault && cp -r photos black.png white.png fault/ && cd fault && "
        "(%s)",
        scratch, fault->command);
    assert_int_equal(system(command), 0);
    snprintf(call->black, sizeof call->black, "%s/fault/black.png", scratch);
    snprintf(call->white, sizeof call->white, "%s/fault/white.png", scratch);
    snprintf(call->codes, sizeof call->codes, "%s/fault/photos/*.png", scratch);
    if (fault->change) fault->change(call);
    err = (FfpError){0};
    if (ffp_import(&call->options, &err)) fail_msg("no error after: %s", fault->command);
    must_be(&err, fault->rule);
    for (int i = 0; i < 2 && fault->words[i]; i++)
        if (!strstr(err.text, fault->words[i]))
            fail_msg("no \"%s\" after %s: %s", fault->words[i], fault->command, err.text);
    assert_false(ffp_is_folder(call->folder));
}

static void test_faults(void **state) {
    (void)state;
    make_spare();
    for (size_t i = 0; i < sizeof faults / sizeof *faults; i++) must_fail(&faults[i]);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_positions),
        cmocka_unit_test(test_narrower),
        cmocka_unit_test(test_cropped_pattern),
        cmocka_unit_test(test_names_with_brackets),
        cmocka_unit_test(test_depth),
        cmocka_unit_test(test_views),
        cmocka_unit_test(test_a_doubtful_stop_is_left_out),
        cmocka_unit_test(test_missing_photographs),
        cmocka_unit_test(test_linear_photographs),
        cmocka_unit_test(test_noisy_photographs),
        cmocka_unit_test(test_sets),
        cmocka_unit_test(test_code_without_edges),
        cmocka_unit_test(test_strays),
        cmocka_unit_test(test_codes_alone),
        cmocka_unit_test(test_large_photographs),
        cmocka_unit_test(test_codes_for_fits),
        cmocka_unit_test(test_codes_held_out),
        cmocka_unit_test(test_other_light),
        cmocka_unit_test(test_as_shown),
        cmocka_unit_test(test_outlines_are_no_disorder),
        cmocka_unit_test(test_faults),
        cmocka_unit_test(test_bad_correspondences),
        cmocka_unit_test(test_real_board),
    };
    return cmocka_run_group_tests(tests, setup, scratch_teardown);
}
