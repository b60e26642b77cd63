// Photographs of a rig whose camera's tilt sensor erred: one stop is tagged as upside down, or one
// photograph. And one stop that another camera took.
#include "product/cli/program.h"
#include "rig/shots/tagged.h"

static ProgramRun run;

// A photograph again, as a JPEG with this tag and this number of the camera.
static void tag(const char *view, int photograph, int orientation, const char *serial) {
    char path[FFP_PATH_MAX], jpeg[FFP_PATH_MAX];
    FfpTakenBy by = {.model = "DC-S5"};
    FfpImage image;
    FfpError err = {0};
    snprintf(by.serial, sizeof by.serial, "%s", serial);
    snprintf(path, sizeof path, "%s/shots/view-%s/%03d.png", scratch, view, photograph);
    snprintf(jpeg, sizeof jpeg, "%s/shots/view-%s/%03d.jpg", scratch, view, photograph);
    if (!ffp_image_read(&image, path, FFP_COLOUR_ENCODED, &err)) fail_msg("%s", err.text);
    const int pixels = image.width * image.height;
    unsigned char *bytes = ffp_alloc((size_t)pixels, 3);
    for (int i = 0; i < 3 * pixels; i++)
        bytes[i] = (unsigned char)(255 * image.data[i / 3 * image.channels + i % 3] + 0.5F);
    write_tagged(jpeg, bytes, image.width, image.height, &by, orientation);
    ffp_free(bytes);
    ffp_image_free(&image);
}

static int import(const char *out) {
    static const char shots[] =
        "-c %s/shots/truth.json -t %s/shots/truth.json --angles 4x90 --shown %s/patterns "
        "-i '%s/shots/view-{view}/*.jpg' -w 64 -o %s/%s";
    char command[2048];
    snprintf(command, sizeof command, shots, scratch, scratch, scratch, scratch, scratch, out);
    return run_format(&run, "--events 1 import %s", command);
}

static void tags_that_differ_are_refused(void **state) {
    static const char *const views[4] = {"000", "090", "180", "270"};
    (void)state;
    assert_int_equal(run_format(&run, "patterns -o %s/patterns --projector 128x80 --only capture", scratch),
                     0);
    assert_int_equal(
        run_format(&run,
                   "generate %s/shots --photographs %s/patterns --split test --first 15 --views 4 "
                   "--attitudes 0 --resolution 64",
                   scratch, scratch),
        0);
    for (int v = 0; v < 4; v++)
        for (int k = 1; k <= 3; k++) tag(views[v], k, 1, "A17");
    assert_int_equal(import("sound"), 0);
    assert_false(has_told(&run, "place-camera"));
    for (int k = 1; k <= 3; k++) tag("270", k, 1, "B2");
    assert_int_equal(import("bodies"), 0);
    assert_true(has_told(&run, "place-camera"));
    assert_non_null(strstr(run.err, "the photographs of '270' say a camera with the serial number 'B2'"));
    for (int k = 1; k <= 3; k++) tag("090", k, 3, "A17");
    assert_int_equal(import("turned"), 1);
    assert_true(has_told(&run, "orientation-tags-differ"));
    assert_non_null(strstr(run.err, "view 090 are tagged as turned by 180 degrees"));
    for (int k = 1; k < 3; k++) tag("090", k, 1, "A17");
    assert_int_equal(import("mixed"), 1);
    assert_true(has_told(&run, "orientation-tags-mixed"));
    assert_non_null(strstr(run.err, "view-090/"));
    assert_non_null(strstr(run.err, "'003.jpg' otherwise"));
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(tags_that_differ_are_refused)};
    return cmocka_run_group_tests(tests, scratch_setup, scratch_teardown);
}
