// A capture whose views have two sizes, neither of whole patches, through every command that reads one.
#include <jansson.h>
#include "core/capture/capture.h"
#include "product/cli/program.h"

static ProgramRun run;

// The upper left part of a picture.
static void cut(FfpImage *image, int width, int height) {
    if (!image->data) return;
    FfpImage out = ffp_image_new(width, height, image->channels);
    const size_t row = (size_t)width * (size_t)image->channels;
    for (int y = 0; y < height; y++)
        memcpy(out.data + (size_t)y * row, image->data + (size_t)(y * image->width * image->channels),
               row * sizeof(real));
    ffp_image_free(image);
    *image = out;
}

// Every second view of the sample loses pixels to the right and below.
static int setup(void **state) {
    FfpCapture capture;
    if (scratch_setup(state) != 0 || !ffp_capture_read(&capture, FFP_SOURCE_DIR "/data/sample", NULL))
        return -1;
    for (; capture.n_views > 3; capture.n_views--)
        ffp_view_free(&capture.views[capture.n_views - 1], capture.n_patterns);
    for (int v = 0; v < capture.n_views; v++) {
        FfpView *view = &capture.views[v];
        const int width = v % 2 ? 125 : 128, height = v % 2 ? 109 : 117;
        FfpImage *const images[] = {&view->coverage, &view->depth};
        for (int p = 0; p < capture.n_patterns; p++) cut(&view->images[p], width, height);
        for (int i = 0; i < 2; i++) cut(images[i], width, height);
        view->camera.width = width, view->camera.height = height;
    }
    const bool ok = ffp_capture_write(&capture, in_scratch("two"), NULL);
    ffp_capture_free(&capture);
    return ok ? 0 : -1;
}

static void must_run(const char *arguments) {
    char line[1024];
    snprintf(line, sizeof line, arguments, scratch, scratch, scratch, scratch);
    run_program(&run, line);
    if (run.status != 0) printf("%s\n%s", line, run.err);
    assert_int_equal(run.status, 0);
}

static void check_size(const char *name, int width, int height) {
    int w = 0, h = 0;
    assert_true(ffp_image_read_size(&w, &h, in_scratch(name), NULL));
    assert_int_equal(w, width);
    assert_int_equal(h, height);
}

static void files_hold_whole_patches(void **state) {
    (void)state;
    must_run("info %s/two");
    assert_non_null(strstr(run.out, "camera 128 x 117 (padded to 128 x 120, whole patches)"));
    assert_non_null(strstr(run.out, "camera 125 x 109 (padded to 128 x 112, whole patches)"));
    check_size("two/path_0_theta000_all_white.png", 128, 120);
    check_size("two/path_0_theta045_all_white.png", 128, 112);
}

static void every_command_takes_them(void **state) {
    (void)state;
    must_run("reconstruct %s/two -o %s/two.ply --polish 6");
    must_run("render %s/two.ply -c %s/two --maps -o %s/pictures");
    check_size("pictures/path_0_theta000_all_white.png", 128, 117); // as the camera saw it
    check_size("pictures/path_0_theta045_all_white.png", 125, 109);
    must_run("evaluate %s/two --gaussians %s/two.ply --json %s/rows.json");
    json_t *root = json_load_file(in_scratch("rows.json"), 0, NULL);
    const json_t *row = json_array_get(json_object_get(root, "rows"), 0);
    assert_true(json_number_value(json_object_get(row, "psnr")) > 25);
    json_decref(root);
    must_run("refine %s/two.ply -c %s/two -o %s/finer.ply --steps 8");
    must_run("map %s/two.ply -c %s/two -o %s/maps");
    check_size("maps/path_0_theta000_camera_to_projector.exr", 128, 117);
    check_size("maps/path_0_theta045_camera_to_projector.exr", 125, 109);
    must_run("compensate %s/two.ply -c %s/two --view path_0_theta045 --target "
             "%s/pictures/path_0_theta045_all_white.png --steps 2 -o %s/pattern.png");
    check_size("pattern_seen_path_0_theta045.png", 125, 109);
    must_run("align %s/two -o %s/aligned");
    check_size("aligned/path_0_theta045_all_white.png", 128, 112);
}

static void must_be_same(const char *a, const char *b) {
    FfpImage images[2] = {{0}};
    const char *const names[2] = {a, b};
    for (int k = 0; k < 2; k++)
        assert_true(ffp_image_read(&images[k], in_scratch(names[k]), FFP_COLOUR_ENCODED, NULL));
    assert_true(images[0].width == images[1].width && images[0].height == images[1].height);
    assert_memory_equal(images[0].data, images[1].data,
                        (size_t)(images[0].width * images[0].height * images[0].channels) * sizeof(real));
    ffp_image_free(&images[0]), ffp_image_free(&images[1]);
}

// Views above two million pixels are drawn in strips, under several patterns at once.
static void large_pictures_are_the_same_together_and_alone(void **state) {
    (void)state;
    must_run("reconstruct %s/two -o %s/large.ply --model none --polish 0");
    must_run(
        "render %s/large.ply -c %s/two -v path_0_theta000 -v path_0_theta045 -p lollipop_0 -p lollipop_1 "
        "--size 1500x1400 -o %s/together");
    must_run("render %s/large.ply -c %s/two -v path_0_theta045 -p lollipop_1 --size 1500x1400 -o %s/alone");
    must_run("render %s/large.ply -c %s/two -v path_0_theta000 -p lollipop_0 --size 1500x1400 -o %s/alone");
    must_be_same("together/path_0_theta045_lollipop_1.png", "alone/path_0_theta045_lollipop_1.png");
    must_be_same("together/path_0_theta000_lollipop_0.png", "alone/path_0_theta000_lollipop_0.png");
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(files_hold_whole_patches),
                                       cmocka_unit_test(every_command_takes_them),
                                       cmocka_unit_test(large_pictures_are_the_same_together_and_alone)};
    return cmocka_run_group_tests(tests, setup, scratch_teardown);
}
