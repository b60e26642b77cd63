// Photographs of a bare rig: what a camera pixel of the board decodes to is where the projector has that
// point, through both lenses; and a folder without patterns is refused by name.
#include <math.h>
#include <unistd.h>
#include "core/base/file.h"
#include "core/patterns/patterns.h"
#include "support.h"
#include "world/synth/bare_rig.h"
#include "world/synth/photographs.h"

enum { HEIGHT = 240, PANEL_WIDTH = 320, PANEL_HEIGHT = 200 };

static char root[64];

static int make_root(void **state) {
    (void)state;
    snprintf(root, sizeof root, "ffp_photographs_XXXXXX");
    return mkdtemp(root) ? 0 : -1;
}

static int remove_root(void **state) {
    (void)state;
    ffp_remove_tree(root);
    return 0;
}

static void path_of(char path[FFP_PATH_MAX], const char *name) {
    assert_true(ffp_join_path(path, root, name));
}

static void draw_patterns(const char *name) {
    char path[FFP_PATH_MAX];
    FfpError err = {0};
    const FfpShow show = {
        .width = PANEL_WIDTH, .height = PANEL_HEIGHT, .focus = true, .capture = true, .gray_codes = true};
    path_of(path, name);
    assert_true(ffp_make_folders(path, &err));
    if (!ffp_show_write(&show, path, &err)) fail_msg("%s", err.text);
}

static bool photograph(const char *to, const char *patterns, const FfpSceneSpec *spec, FfpError *err) {
    char folder[FFP_PATH_MAX], from[FFP_PATH_MAX];
    path_of(folder, to), path_of(from, patterns);
    const FfpPhotographs options = {.folder = folder, .patterns = from, .attitudes = 2};
    return ffp_photographs_write(&options, spec, err);
}

static FfpSceneSpec small_spec(void) {
    FfpSceneSpec spec = ffp_scene_defaults();
    spec.mesh = 2, spec.material = 4, spec.seed = 5, spec.resolution = HEIGHT, spec.views = 1;
    spec.samples = 2, spec.ambient_rays = 1;
    return spec;
}

static FfpImage read_number(const char *subject, int number) {
    char name[64], path[FFP_PATH_MAX];
    FfpError err = {0};
    FfpImage image = {0};
    snprintf(name, sizeof name, "shots/%s/%03d.png", subject, number);
    path_of(path, name);
    if (!ffp_image_read(&image, path, FFP_COLOUR_ENCODED, &err)) fail_msg("%s", err.text);
    return image;
}

// Column (axis 0) or row of the panel that lit each pixel of the attitude. The codes begin behind black and
// white, and each is followed by its inverse.
static int *decode(const char *subject, int axis) {
    const int columns = ffp_gray_code_bits(PANEL_WIDTH),
              bits = axis == 0 ? columns : ffp_gray_code_bits(PANEL_HEIGHT);
    const int first = 3 + (axis == 0 ? 0 : 2 * columns);
    int *code = NULL;
    bool *seen = NULL;
    size_t pixels = 0;
    for (int bit = 0; bit < bits; bit++) {
        FfpImage plain = read_number(subject, first + 2 * bit),
                 inverse = read_number(subject, first + 2 * bit + 1);
        pixels = (size_t)plain.width * (size_t)plain.height;
        if (!seen) seen = calloc(pixels * (size_t)bits, sizeof *seen), code = calloc(pixels, sizeof *code);
        for (size_t i = 0; i < pixels; i++)
            seen[i * (size_t)bits + (size_t)bit] = plain.data[4 * i] > inverse.data[4 * i];
        ffp_image_free(&plain);
        ffp_image_free(&inverse);
    }
    for (size_t i = 0; i < pixels; i++) code[i] = ffp_gray_decode(seen + i * (size_t)bits, bits);
    free(seen);
    return code;
}

// How far, in pixels of the panel, the codes seen where the camera has a white square lie on the average from
// where the projector has it, with these lenses.
static double square_error(const FfpBareRig *rig, const FfpChessboard *board, int i, int j, const int *column,
                           const int *row, const double camera_lens[5], const double projector_lens[5]) {
    enum { SIDE = 7 };
    double x = 0, y = 0;
    for (int k = 0; k < SIDE * SIDE; k++) {
        float point[3];
        double seen[2], lit[2];
        ffp_chessboard_point(board, (float)i + 0.2F + 0.6F * (float)(k % SIDE) / (SIDE - 1),
                             (float)j + 0.2F + 0.6F * (float)(k / SIDE) / (SIDE - 1), point);
        assert_true(ffp_bare_rig_pixel(&rig->camera, camera_lens, point, seen));
        assert_true(ffp_bare_rig_pixel(&rig->projector, projector_lens, point, lit));
        const int at = (int)seen[1] * rig->camera.width + (int)seen[0];
        x += (column[at] + 0.5 - lit[0]) / (SIDE * SIDE), y += (row[at] + 0.5 - lit[1]) / (SIDE * SIDE);
    }
    return hypot(x, y);
}

static double error_of(const FfpBareRig *rig, const FfpChessboard *board, const int *column, const int *row,
                       const double camera_lens[5], const double projector_lens[5]) {
    double off = 0;
    int squares = 0;
    for (int j = -1; j < board->rows; j++)
        for (int i = -1; i < board->columns; i++) {
            if ((i + j) % 2 == 0) continue;
            off += square_error(rig, board, i, j, column, row, camera_lens, projector_lens);
            squares++;
        }
    assert_int_equal(squares, 35);
    return off / squares;
}

static void check_attitude(const FfpBareRig *rig, const char *subject, int index, uint64_t seed) {
    static const double none[5] = {0};
    const FfpChessboard board = ffp_bare_rig_attitude(rig, index, seed);
    int *column = decode(subject, 0), *row = decode(subject, 1);
    const double off = error_of(rig, &board, column, row, rig->camera_lens, rig->projector_lens),
                 straight_camera = error_of(rig, &board, column, row, none, rig->projector_lens),
                 straight_projector = error_of(rig, &board, column, row, rig->camera_lens, none);
    print_message("%s: %.3f panel pixels off, %.3f without the camera's lens, %.3f without the projector's\n",
                  subject, off, straight_camera, straight_projector);
    assert_true(off < 0.3); // a pixel of the camera is about one of the panel
    assert_true(straight_camera > 1.5 * off && straight_projector > 1.5 * off);
    free(column);
    free(row);
}

static void codes_say_where_the_projector_has_a_point(void **state) {
    (void)state;
    FfpError err = {0};
    const FfpSceneSpec spec = small_spec();
    const FfpBareRig rig = ffp_bare_rig(HEIGHT, PANEL_WIDTH, PANEL_HEIGHT);
    draw_patterns("patterns");
    if (!photograph("shots", "patterns", &spec, &err)) fail_msg("%s", err.text);
    check_attitude(&rig, "attitude-00", 0, spec.seed);
    check_attitude(&rig, "attitude-01", 1, spec.seed);
}

// The same light is in a photograph and in its noise, and nothing else.
static void noise_comes_last(void **state) {
    (void)state;
    FfpSceneSpec spec = small_spec();
    FfpError err = {0};
    spec.sensor.read = 0.02F;
    FfpImage clean = read_number("view-000", 2);
    if (!photograph("noisy", "patterns", &spec, &err)) fail_msg("%s", err.text);
    char path[FFP_PATH_MAX];
    FfpImage noisy = {0};
    path_of(path, "noisy/view-000/002.png");
    assert_true(ffp_image_read(&noisy, path, FFP_COLOUR_LINEAR, &err));
    ffp_image_to_linear(&clean);
    double square = 0;
    int counted = 0;
    for (int i = 0; i < clean.width * clean.height; i++) { // where neither end of the range cuts noise off
        const double value = (double)clean.data[4 * i], error = (double)noisy.data[4 * i] - value;
        if (value < 0.08 || value > 0.8) continue;
        square += error * error, counted++;
    }
    print_message("noise of %d pixels: %.4f\n", counted, sqrt(square / counted));
    assert_true(counted > 500);
    assert_true(fabs(sqrt(square / counted) - 0.02) < 0.002);
    ffp_image_free(&clean);
    ffp_image_free(&noisy);
}

static void expect_same_file(const char *a, const char *b) {
    char path[2][FFP_PATH_MAX], *data[2];
    size_t size[2];
    FfpError err = {0};
    path_of(path[0], a), path_of(path[1], b);
    for (int i = 0; i < 2; i++)
        if (!ffp_read_file(path[i], 1 << 24, &data[i], &size[i], &err)) fail_msg("%s", err.text);
    assert_int_equal(size[0], size[1]);
    assert_memory_equal(data[0], data[1], size[0]);
    ffp_free(data[0]);
    ffp_free(data[1]);
}

// One folder alone has the same bits as among all, noise included.
static void one_folder_is_as_among_all(void **state) {
    (void)state;
    FfpSceneSpec spec = small_spec();
    FfpError err = {0};
    char folder[FFP_PATH_MAX], from[FFP_PATH_MAX], path[FFP_PATH_MAX];
    spec.sensor.read = 0.02F;
    path_of(folder, "only"), path_of(from, "patterns");
    const FfpPhotographs only = {.folder = folder, .patterns = from, .attitudes = 2, .only = "attitude-01"},
                         none = {.folder = folder, .patterns = from, .attitudes = 2, .only = "attitude-02"};
    if (!ffp_photographs_write(&only, &spec, &err)) fail_msg("%s", err.text);
    expect_same_file("only/attitude-01/007.png", "noisy/attitude-01/007.png");
    path_of(path, "only/attitude-00");
    assert_false(ffp_is_folder(path));
    path_of(path, "only/empty");
    assert_false(ffp_is_folder(path));
    ffp_remove_tree(folder);
    assert_false(ffp_photographs_write(&none, &spec, &err));
    assert_non_null(strstr(err.text, "attitude-02"));
    assert_false(ffp_is_folder(folder));
}

// The stage without the object: the sensor's noise and nothing else, half of it cut off at black.
static void the_empty_stage_is_dark(void **state) {
    (void)state;
    char path[FFP_PATH_MAX];
    FfpError err = {0};
    for (int number = 1; number <= 2; number++) {
        char name[64];
        FfpImage image = {0};
        snprintf(name, sizeof name, "noisy/empty/%03d.png", number);
        path_of(path, name);
        if (!ffp_image_read(&image, path, FFP_COLOUR_LINEAR, &err)) fail_msg("%s", err.text);
        double sum = 0;
        const int pixels = image.width * image.height;
        for (int i = 0; i < pixels; i++) sum += (double)image.data[4 * i];
        assert_true(fabs(sum / pixels - 0.02 / sqrt(2 * 3.14159265)) < 0.001); // mean of max(0, N(0, 0.02))
        ffp_image_free(&image);
    }
    path_of(path, "noisy/empty/003.png");
    assert_false(ffp_is_file(path));
}

static void refused(const char *patterns, const FfpSceneSpec *spec, const char *text) {
    FfpError err = {0};
    char folder[FFP_PATH_MAX];
    path_of(folder, "refused");
    assert_false(photograph("refused", patterns, spec, &err));
    if (!strstr(err.text, text)) fail_msg("'%s' does not say '%s'", err.text, text);
    assert_false(ffp_is_folder(folder));
}

static void copy_file(const char *from, const char *to) {
    char a[FFP_PATH_MAX], b[FFP_PATH_MAX];
    FfpError err = {0};
    char *data;
    size_t size;
    path_of(a, from), path_of(b, to);
    assert_true(ffp_read_file(a, 1 << 20, &data, &size, &err) && ffp_write_file(b, data, size, &err));
    ffp_free(data);
}

static void what_is_no_set_of_patterns_is_refused(void **state) {
    (void)state;
    FfpSceneSpec spec = small_spec();
    FfpError err = {0};
    char path[FFP_PATH_MAX];
    refused("nowhere", &spec, "cannot read the patterns' folder");
    path_of(path, "empty");
    assert_true(ffp_make_folders(path, &err));
    refused("empty", &spec, "no picture is called");
    copy_file("patterns/002_white.png", "empty/003_white.png");
    copy_file("patterns/001_black.png", "empty/003_black.png");
    refused("empty", &spec, "has the same number as 003_");
    path_of(path, "mixed");
    assert_true(ffp_make_folders(path, &err));
    copy_file("patterns/002_white.png", "mixed/003_white.png");
    copy_file("shots/view-000/002.png", "mixed/002_black.png");
    refused("mixed", &spec, "003_white.png");
    spec.sensor.turn_error = 0.01F;
    refused("patterns", &spec, "turn_error");
    spec = small_spec(), spec.resolution = 20;
    refused("patterns", &spec, "resolution");
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(codes_say_where_the_projector_has_a_point),
        cmocka_unit_test(noise_comes_last),
        cmocka_unit_test(one_folder_is_as_among_all),
        cmocka_unit_test(the_empty_stage_is_dark),
        cmocka_unit_test(what_is_no_set_of_patterns_is_refused),
    };
    return cmocka_run_group_tests(tests, make_root, remove_root);
}
