// A room by commands alone: photographed, imported with its true masks and without any, and refused where it
// could not be.
#include "core/capture/capture.h"
#include "product/cli/program.h"

static ProgramRun run;

static int setup(void **state) {
    if (scratch_setup(state) != 0) return -1;
    return run_format(&run, "patterns -o %s/patterns --projector 96x64 --only capture --lollipops 1",
                      scratch);
}

// The options that import a room's stops, all but the masks and the output.
static void import_line(char line[2000], const char *room) {
    snprintf(line, 2000,
             "--events 1 import -c %s/%s/truth.json -t %s/%s/truth.json --shown %s/patterns "
             "-i '%s/%s/view-{view}/*.JPG' -i 'map=%s/%s/truth/held-out/view-{view}/map.png' "
             "--held-out map=%s/%s/held-out/map.png --name room -w 128",
             scratch, room, scratch, room, scratch, scratch, room, scratch, room, scratch, room);
}

static void a_room_is_imported_as_it_stands(void **state) {
    (void)state;
    char line[2000];
    FfpCapture capture;
    FfpError err = {0};
    assert_int_equal(
        run_format(&run,
                   "generate %s/room --photographs %s/patterns --room --seed 3 --views 3 --split "
                   "test --first 15 --resolution 96 --preset smoke",
                   scratch, scratch),
        0);
    import_line(line, "room");
    assert_int_equal(
        run_format(&run, "%s -m '%s/room/masks/view-{view}.png' -o %s/capture", line, scratch, scratch), 0);
    if (!ffp_capture_read(&capture, in_scratch("capture"), &err)) fail_msg("%s", err.text);
    assert_int_equal(capture.n_views, 3);
    assert_int_equal(capture.n_patterns, 4);
    double covered = 0;
    for (int v = 0; v < 3; v++) {
        const FfpImage *mask = &capture.views[v].coverage;
        for (int i = 0; i < mask->width * mask->height; i++) covered += (double)mask->data[i];
    }
    assert_true(covered > 1000); // of 3 x 128 x 96 pixels
    ffp_capture_free(&capture);
}

static void import_masked(FfpCapture *capture, const char *line, const char *name, const char *masks) {
    FfpError err = {0};
    if (run_format(&run, "%s %s -o %s/%s", line, masks, scratch, name) != 0) fail_msg("%s", run.err);
    if (!ffp_capture_read(capture, in_scratch(name), &err)) fail_msg("%s", err.text);
}

// Here the light's masks hold nearly all that is lit, at all stops, and so agree with each other.
static void masks_that_hold_the_room_are_told(void **state) {
    (void)state;
    char line[2000], masks[1100];
    FfpCapture truth, made;
    double missing = 0, surplus = 0, object = 0;
    assert_int_equal(
        run_format(&run,
                   "generate %s/stops --photographs %s/patterns --room --seed 5 --views 8 --split "
                   "test --first 30 --resolution 96 --preset smoke",
                   scratch, scratch),
        0);
    import_line(line, "stops");
    snprintf(masks, sizeof masks, "-m '%s/stops/masks/view-{view}.png'", scratch);
    import_masked(&truth, line, "truth", masks);
    import_masked(&made, line, "made", "");
    assert_true(has_told(&run, "lit-background"));
    for (int v = 0; v < made.n_views; v++) {
        const FfpImage *a = &truth.views[v].coverage, *b = &made.views[v].coverage;
        for (int i = 0; i < a->width * a->height; i++) {
            const bool in_a = a->data[i] >= 0.5F, in_b = b->data[i] >= 0.5F;
            object += in_a, missing += in_a && !in_b, surplus += in_b && !in_a;
        }
    }
    printf("missing %.3f, surplus %.3f\n", missing / object, surplus / object);
    assert_true(missing < 0.3 * object);
    assert_true(surplus < 0.3 * object); // the room is 7 times the object
    ffp_capture_free(&truth), ffp_capture_free(&made);
}

static void wrong_options_are_refused(void **state) {
    (void)state;
    assert_int_equal(run_format(&run, "generate %s/none --room", scratch), 2);
    assert_non_null(strstr(run.err, "--photographs"));
    assert_int_equal(
        run_format(&run, "generate %s/none --photographs %s/patterns --quality 50", scratch, scratch), 2);
    assert_non_null(strstr(run.err, "--room"));
    assert_int_equal(
        run_format(&run, "generate %s/none --photographs %s/patterns --room --quality 0", scratch, scratch),
        2);
    assert_int_equal(run_format(&run, "generate %s/none --photographs %s/nowhere --room", scratch, scratch),
                     1);
    assert_non_null(strstr(run.err, "nowhere"));
    assert_int_equal(
        run_format(&run, "generate %s/none --photographs %s/patterns --room --count 2", scratch, scratch), 1);
    assert_non_null(strstr(run.err, "one object"));
    assert_int_equal(run_format(&run, "generate %s/room --photographs %s/patterns --room", scratch, scratch),
                     1); // is full
    assert_false(ffp_is_folder(in_scratch("none")));
}

// --- Greys. ---

static void import_greys(FfpCapture *capture, const char *name, const char *sensor) {
    FfpError err = {0};
    char line[2000];
    if (run_format(&run,
                   "generate %s/%s --photographs %s/greys --room --seed 6 --views 1 --split test --first 15 "
                   "--resolution 160 --preset smoke --only view-000 --sensor %s",
                   scratch, name, scratch, sensor) != 0)
        fail_msg("%s", run.err);
    snprintf(line, sizeof line,
             "import -c %s/%s/truth.json -t %s/%s/truth.json --angles 0 --shown %s/greys -i "
             "'%s/%s/view-{view}/*.JPG' -m '%s/%s/masks/view-{view}.png' -o %s/of-%s",
             scratch, name, scratch, name, scratch, scratch, name, scratch, name, scratch, name);
    if (run_format(&run, "%s", line) != 0) fail_msg("%s", run.err);
    char folder[64];
    snprintf(folder, sizeof folder, "of-%s", name);
    if (!ffp_capture_read(capture, in_scratch(folder), &err)) fail_msg("%s", err.text);
    assert_int_equal(capture->n_patterns, 3); // without the greys
}

// The generator's exponent is found from photographs of greys in a lit room, with glare, spread and
// vignetting.
static void greys_tell_the_response(void **state) {
    (void)state;
    FfpCapture capture;
    assert_int_equal(
        run_format(&run, "patterns -o %s/greys --projector 96x64 --only capture --greys 4", scratch), 0);
    import_greys(&capture, "bent", "real_light=1 --sensor power=1.61");
    assert_non_null(strstr(run.err, "from 4 greys; on greys left out it is off by 0.00"));
    assert_true(capture.panel.power);
    for (int c = 0; c < 3; c++) assert_float_equal(capture.panel.gamma[c], 1.61, 0.03);
    const FfpImage *sent = &capture.patterns[2].image; // as light, not as sRGB
    double light = 0, shown = 0;
    FfpImage file = {0};
    FfpError err = {0};
    assert_true(ffp_image_read(&file, in_scratch("greys/003_lollipop_0.png"), FFP_COLOUR_LINEAR, &err));
    for (int i = 0; i < sent->width * sent->height * 3; i++) light += (double)sent->data[i];
    for (int i = 0; i < file.width * file.height; i++)
        for (int c = 0; c < 3; c++) shown += (double)file.data[4 * i + c];
    assert_true(light / (sent->width * sent->height) > 1.1 * shown / (file.width * file.height));
    ffp_image_free(&file), ffp_capture_free(&capture);
}

// An sRGB projector's greys change nothing.
static void greys_of_srgb_change_nothing(void **state) {
    (void)state;
    FfpCapture capture;
    import_greys(&capture, "plain", "gamma=0.0001");
    assert_non_null(strstr(run.err, "is not kept"));
    assert_false(capture.panel.power);
    ffp_capture_free(&capture);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_room_is_imported_as_it_stands),
        cmocka_unit_test(masks_that_hold_the_room_are_told), cmocka_unit_test(wrong_options_are_refused),
        cmocka_unit_test(greys_tell_the_response), cmocka_unit_test(greys_of_srgb_change_nothing)};
    return cmocka_run_group_tests(tests, setup, scratch_teardown);
}
