// Pictures from a PLY and a file of poses alone, and of any size.
#include <math.h>
#include "core/image/image.h"
#include "product/cli/program.h"

#define SAMPLE FFP_SOURCE_DIR "/data/sample"

static ProgramRun run;

// The sample's targets.json where nothing lies beside it, and the same without the projector's numbers.
static int setup(void **state) {
    char *text = NULL, *projector;
    size_t size = 0;
    if (scratch_setup(state) != 0) return -1;
    assert_true(ffp_make_folders(in_scratch("poses"), NULL));
    assert_true(ffp_read_file(SAMPLE "/targets.json", 1 << 20, &text, &size, NULL));
    assert_true(ffp_write_file(in_scratch("poses/targets.json"), text, size, NULL));
    assert_non_null(projector = strstr(text, "\"projector\""));
    projector[1] = 'x'; // an unknown key is passed over
    assert_true(ffp_write_file(in_scratch("poses/bare.json"), text, size, NULL));
    ffp_free(text);
    return run_format(&run, "reconstruct " SAMPLE " --model none --polish 0 -o %s/spot.ply", scratch);
}

static FfpImage picture(const char *name) {
    FfpImage image = {0};
    FfpError err = {0};
    if (!ffp_image_read(&image, in_scratch(name), FFP_COLOUR_ENCODED, &err)) fail_msg("%s", err.text);
    return image;
}

static void assert_same(const char *a, const char *b) {
    FfpImage x = picture(a), y = picture(b);
    assert_int_equal(x.width, y.width);
    assert_int_equal(x.height, y.height);
    assert_memory_equal(x.data, y.data, (size_t)(x.width * x.height * x.channels) * sizeof(real));
    ffp_image_free(&x);
    ffp_image_free(&y);
}

static void no_capture_gives_the_same_pictures(void **state) {
    (void)state;
    assert_int_equal(run_format(&run,
                                "render %s/spot.ply -c " SAMPLE " --poses " SAMPLE
                                "/targets.json -p lollipop_0 -o %s/with",
                                scratch, scratch),
                     0);
    assert_int_equal(run_format(&run,
                                "render %s/spot.ply --poses %s/poses -p " SAMPLE
                                "/patterns/lollipop_0.png -o %s/without",
                                scratch, scratch, scratch),
                     0);
    assert_same("with/novel_00_lollipop_0.png", "without/novel_00_lollipop_0.png");
    assert_same("with/novel_01_lollipop_0.png", "without/novel_01_lollipop_0.png");
    // Black and white are there by themselves; a pattern whose file is not is named.
    assert_int_equal(
        run_format(&run, "render %s/spot.ply --poses %s/poses -o %s/white", scratch, scratch, scratch), 0);
    char line[512];
    snprintf(line, sizeof line, "render %s/spot.ply --poses %s/poses -p lollipop_0 -o %s/never", scratch,
             scratch, scratch);
    run_program(&run, line);
    assert_int_equal(run.status, 1);
    assert_non_null(strstr(run.err, "the file of pattern lollipop_0 does not exist"));
    run_program(&run, "render a.ply -o b");
    assert_int_equal(run.status, 2);
}

static void what_the_poses_do_not_say_is_asked_for(void **state) {
    (void)state;
    char line[512];
    static const char bare[] = "render %s/spot.ply --poses %s/poses/bare.json -o %s/bare %s";
    snprintf(line, sizeof line, bare, scratch, scratch, scratch, "");
    run_program(&run, line);
    assert_int_equal(run.status, 1);
    assert_non_null(strstr(run.err, "neither a projector size nor a pattern image"));
    snprintf(line, sizeof line, bare, scratch, scratch, scratch, "-p " SAMPLE "/patterns/lollipop_0.png");
    run_program(&run, line);
    assert_int_equal(run.status, 1);
    assert_non_null(strstr(run.err, "lacks the projector's intensity"));
    assert_int_equal(run_format(&run, bare, scratch, scratch, scratch,
                                "-p " SAMPLE "/patterns/lollipop_0.png --intensity 7.957747154594767"),
                     0);
    assert_same("bare/novel_00_lollipop_0.png", "without/novel_00_lollipop_0.png");
}

static void orbits_go_round_the_gaussians(void **state) {
    (void)state;
    assert_int_equal(run_format(&run,
                                "render %s/spot.ply --poses %s/poses --orbit object,2 --size 32 -o %s/turn",
                                scratch, scratch, scratch),
                     0);
    FfpImage half = picture("turn/frame_0001.png");
    double sum = 0;
    assert_int_equal(half.width, 32);
    for (int i = 0; i < 32 * 32 * half.channels; i++) sum += (double)half.data[i];
    assert_true(sum > 1); // it is still in the picture
    ffp_image_free(&half);
}

static double mean_difference(const FfpImage *a, const FfpImage *b) {
    double sum = 0;
    const int count = a->width * a->height * a->channels;
    assert_true(a->width == b->width && a->height == b->height && a->channels == b->channels);
    for (int i = 0; i < count; i++) sum += fabs((double)a->data[i] - (double)b->data[i]) / count;
    printf("%d x %d: %.4f\n", a->width, a->height, sum);
    return sum;
}

static void sizes_scale_and_cut(void **state) {
    (void)state;
    static const char line[] = "render %s/spot.ply -c " SAMPLE " -v path_0_theta000 --size %s -o %s/%s";
    assert_int_equal(run_format(&run, line, scratch, "64", scratch, "small"), 0);
    assert_int_equal(run_format(&run, line, scratch, "128", scratch, "same"), 0);
    assert_int_equal(run_format(&run, line, scratch, "128x64", scratch, "cut"), 0);
    assert_int_equal(run_format(&run, line, scratch, "300x400", scratch, "tall"), 0);
    FfpImage small = picture("small/path_0_theta000_all_white.png"),
             same = picture("same/path_0_theta000_all_white.png"),
             cut = picture("cut/path_0_theta000_all_white.png"),
             tall = picture("tall/path_0_theta000_all_white.png");
    assert_int_equal(small.height, 64);
    assert_int_equal(cut.height, 64);
    assert_int_equal(tall.width, 300);
    assert_int_equal(tall.height, 400);
    const FfpImage middle = {128, 64, same.channels, same.data + (size_t)(32 * 128 * same.channels)};
    assert_true(mean_difference(&cut, &middle) < 1e-3); // the middle rows
    FfpImage coarser = ffp_image_resize(&same, 64, 64), finer = ffp_image_resize(&same, 300, 300);
    const FfpImage rows = {300, 300, tall.channels, tall.data + (size_t)(50 * 300 * tall.channels)};
    assert_true(mean_difference(&small, &coarser) < 0.01); // the same view
    assert_true(mean_difference(&rows, &finer) < 0.01);    // and more above and below
    ffp_image_free(&coarser), ffp_image_free(&finer);
    ffp_image_free(&small), ffp_image_free(&same), ffp_image_free(&cut), ffp_image_free(&tall);
    static const char *const wrong[] = {"0", "12x", "x12", "axb", "99999", "64x-1"};
    for (size_t i = 0; i < sizeof wrong / sizeof *wrong; i++) {
        char text[128];
        snprintf(text, sizeof text, "render a.ply -c b -o c --size %s", wrong[i]);
        run_program(&run, text);
        assert_int_equal(run.status, 2);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(no_capture_gives_the_same_pictures),
        cmocka_unit_test(what_the_poses_do_not_say_is_asked_for),
        cmocka_unit_test(orbits_go_round_the_gaussians),
        cmocka_unit_test(sizes_scale_and_cut),
    };
    return cmocka_run_group_tests(tests, setup, scratch_teardown);
}
