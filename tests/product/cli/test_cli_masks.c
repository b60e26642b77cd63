// Masks made of the light against true ones, by commands alone: a watering can on a turntable, whose handle
// is a ring, photographed by the generator. Its side in shadow is object, and one sees through the handle.
#include <tgmath.h>
#include <unistd.h>
#include "core/base/file.h"
#include "core/capture/capture.h"
#include "product/cli/program.h"

static ProgramRun run;

typedef struct Agreement {
    double common, either, missing, extra; // pixels
} Agreement;

static void must_run(const char *command) {
    char line[3000] = "";
    for (const char *at = command; *at; at++)
        snprintf(line + strlen(line), sizeof line - strlen(line), *at == '@' ? "%s" : "%.1s",
                 *at == '@' ? scratch : at);
    run_program(&run, line);
    if (run.status != 0) fail_msg("%s\n%s", line, run.err);
}

static int setup(void **state) {
    if (scratch_setup(state) != 0) return -1;
    must_run("patterns -o @/patterns --projector 128x80 --only capture --lollipops 1");
    must_run("generate @/shots --photographs @/patterns --views 8 --attitudes 0 --split test --first 9 "
             "--resolution 96 --sensor exposure=1 --sensor read=0.003 --sensor shot=0.0003");
    return 0;
}

static void read_import_of(FfpCapture *capture, const char *shots, const char *name, const char *more) {
    char line[2000];
    FfpError err = {0};
    snprintf(line, sizeof line,
             "import -c @/shots/truth.json -t @/shots/truth.json -i 'black=@/%s001.png' "
             "-i 'white=@/%s002.png' -i 'lollipop_0=@/%s003.png' "
             "-p lollipop_0=@/patterns/003_lollipop_0.png -o @/%s %s",
             shots, shots, shots, name, more);
    must_run(line);
    if (!ffp_capture_read(capture, in_scratch(name), &err)) fail_msg("%s", err.text);
}

static void read_import(FfpCapture *capture, const char *name, const char *more) {
    read_import_of(capture, "shots/view-{view}/", name, more);
}

static Agreement compare(const FfpCapture *truth, const FfpCapture *made) {
    Agreement sum = {0};
    for (int v = 0; v < made->n_views; v++) {
        int like = 0;
        while (strcmp(truth->views[like].id, made->views[v].id) != 0) like++;
        const FfpImage *a = &truth->views[like].coverage, *b = &made->views[v].coverage;
        for (int i = 0; i < a->width * a->height; i++) {
            const bool in_a = a->data[i] >= 0.5F, in_b = b->data[i] >= 0.5F;
            sum.common += in_a && in_b, sum.either += in_a || in_b;
            sum.missing += in_a && !in_b, sum.extra += in_b && !in_a;
        }
    }
    printf("%d views: overlap %.3f, missing %.3f, too much %.3f of the object\n", made->n_views,
           sum.common / sum.either, sum.missing / (sum.common + sum.missing),
           sum.extra / (sum.common + sum.missing));
    return sum;
}

static void masked_pictures_are_black(const FfpCapture *made) {
    for (int v = 0; v < made->n_views; v++)
        for (int i = 0; i < made->views[v].coverage.width * made->views[v].coverage.height; i++)
            assert_true(made->views[v].coverage.data[i] > 0 ||
                        !(made->views[v].images[made->white].data[3 * i] > 0));
}

// The room's weak light shows what the projector does not reach, and outlines are as soft as the camera's.
static void the_dark_shows_the_object(void **state) {
    (void)state;
    FfpCapture truth, made, few, again;
    read_import(&truth, "truth", "-m '@/shots/masks/view-*.png'");
    read_import(&made, "made", "");
    assert_non_null(strstr(run.err, "8 masks were made from all light"));
    read_import(&few, "few", "-v 045 -v 180 -v 270");
    const Agreement eight = compare(&truth, &made), three = compare(&truth, &few);
    assert_true(eight.common > 0.94 * eight.either);
    assert_true(three.common > 0.94 * three.either);
    int soft = 0;
    for (int i = 0; i < made.views[0].coverage.width * made.views[0].coverage.height; i++)
        soft += made.views[0].coverage.data[i] > 0.1F && made.views[0].coverage.data[i] < 0.9F;
    assert_true(soft > 50);
    masked_pictures_are_black(&made);
    read_import(&again, "again", "-m '@/made/masks/{view}.png'"); // as after painting on them
    const Agreement same = compare(&made, &again);
    assert_true(same.common > 0.97 * same.either);
    ffp_capture_free(&truth), ffp_capture_free(&made), ffp_capture_free(&few), ffp_capture_free(&again);
}

// The sum of the differences of two captures' shares, over the object's area.
static double share_errors(const FfpCapture *truth, const FfpCapture *made) {
    double sum = 0, area = 0;
    for (int v = 0; v < made->n_views; v++)
        for (int i = 0; i < made->views[v].coverage.width * made->views[v].coverage.height; i++) {
            const double share = (double)truth->views[v].coverage.data[i];
            sum += fabs(share - (double)made->views[v].coverage.data[i]), area += share;
        }
    printf("shares differ by %.4f of the object\n", sum / area);
    return sum / area;
}

// Where the photographs have twice the capture's pixels, shares are means of theirs.
static void finer_photographs_tell_the_shares(void **state) {
    (void)state;
    FfpCapture truth, made;
    read_import(&truth, "small-truth", "-w 64 -m '@/shots/masks/view-*.png'");
    read_import(&made, "small", "-w 64");
    assert_non_null(strstr(run.err, "8 masks were made from all light"));
    assert_true(share_errors(&truth, &made) < 0.09);
    masked_pictures_are_black(&made);
    ffp_capture_free(&truth), ffp_capture_free(&made);
}

static void the_report_shows_the_masks(void **state) {
    (void)state;
    size_t size;
    char *text = NULL;
    FfpError err = {0};
    must_run("info @/made --report @/made.html");
    if (!ffp_read_file(in_scratch("made.html"), 1 << 24, &text, &size, &err)) fail_msg("%s", err.text);
    assert_non_null(strstr(text, "Masks on the photographs"));
    assert_non_null(strstr(text, "<figcaption>315: "));
    assert_null(strstr(text, "class=look>"));
    ffp_free(text);
    run_format(&run, "info %s/models/small.safetensors --report %s/model.html", FFP_SOURCE_DIR, scratch);
    assert_int_equal(run.status, 1);
    assert_non_null(strstr(run.err, "only captures have a report"));
    assert_int_equal(access(in_scratch("model.html"), F_OK), -1);
}

// Photographs from which what is seen under black was taken out, as without any light of the room.
static void photograph_without_room_light(void) {
    for (int k = 0; k < 24; k++) {
        const int angle = k / 3 * 45, number = k % 3 + 1;
        FfpImage pictures[2] = {{0}};
        FfpError err = {0};
        char path[FFP_PATH_MAX];
        for (int i = 0; i < 2; i++) {
            snprintf(path, sizeof path, "%s/shots/view-%03d/00%d.png", scratch, angle, i == 0 ? 1 : number);
            if (!ffp_image_read(&pictures[i], path, FFP_COLOUR_ENCODED, &err)) fail_msg("%s", err.text);
        }
        FfpImage rgb = ffp_image_new(pictures[0].width, pictures[0].height, 3);
        for (int i = 0; i < 3 * rgb.width * rgb.height; i++) {
            const int at = i / 3 * pictures[0].channels + i % 3;
            const real light =
                ffp_srgb_decode(pictures[1].data[at]) - ffp_srgb_decode(pictures[0].data[at]) + 0.002F;
            rgb.data[i] = ffp_srgb_encode(light > 0 ? light : 0);
        }
        snprintf(path, sizeof path, "%s/unlit-%03d-00%d.png", scratch, angle, number);
        if (!ffp_image_write_png(&rgb, path, &err)) fail_msg("%s", err.text);
        ffp_image_free(&rgb), ffp_image_free(&pictures[0]), ffp_image_free(&pictures[1]);
    }
}

static void shadows_are_object_and_holes_are_none(void **state) {
    (void)state;
    FfpCapture truth, made;
    photograph_without_room_light();
    read_import(&truth, "lit_truth", "-m '@/shots/masks/view-*.png'");
    read_import_of(&made, "unlit-{view}-", "unlit", "");
    assert_non_null(strstr(run.err, "8 masks were made from white minus black"));
    assert_non_null(strstr(run.err, "shadows that the other views show lit were added"));
    const Agreement eight = compare(&truth, &made);
    assert_true(eight.common > 0.88 * eight.either && eight.missing < 0.05 * eight.common);
    masked_pictures_are_black(&made);
    ffp_capture_free(&truth), ffp_capture_free(&made);
}

static void a_lamp_between_views_is_named(void **state) {
    (void)state;
    char path[FFP_PATH_MAX];
    FfpError err = {0};
    for (int angle = 0; angle < 360; angle += 45) {
        FfpImage black = {0};
        snprintf(path, sizeof path, "%s/shots/view-%03d/001.png", scratch, angle);
        if (!ffp_image_read(&black, path, FFP_COLOUR_ENCODED, &err)) fail_msg("%s", err.text);
        FfpImage rgb = ffp_image_new(black.width, black.height, 3);
        for (int i = 0; i < 3 * rgb.width * rgb.height; i++)
            rgb.data[i] = black.data[i / 3 * black.channels + i % 3] + (angle == 135 ? 0.25F : 0);
        snprintf(path, sizeof path, "%s/black-%03d.png", scratch, angle);
        if (!ffp_image_write_png(&rgb, path, &err)) fail_msg("%s", err.text);
        ffp_image_free(&black), ffp_image_free(&rgb);
    }
    static const char form[] =
        "--events 1 import -c @/shots/truth.json -t @/shots/truth.json -i 'black=@/%s.png' "
        "-i 'white=@/shots/view-{view}/002.png' -i 'lollipop_0=@/shots/view-{view}/003.png' "
        "-p lollipop_0=@/patterns/003_lollipop_0.png -o @/%s";
    char line[2000];
    snprintf(line, sizeof line, form, "shots/view-{view}/001", "same_light");
    must_run(line);
    assert_false(has_told(&run, "view-light"));
    snprintf(line, sizeof line, form, "black-{view}", "other_light");
    must_run(line);
    assert_true(has_told(&run, "view-light") && has_told(&run, "135"));
}

// The same bits whatever the number of threads.
static void threads_do_not_matter(void **state) {
    (void)state;
    FfpCapture one, two;
    setenv("OMP_NUM_THREADS", "1", 1);
    read_import(&one, "one", "");
    setenv("OMP_NUM_THREADS", "3", 1);
    read_import(&two, "two", "");
    unsetenv("OMP_NUM_THREADS");
    for (int v = 0; v < one.n_views; v++)
        assert_memory_equal(one.views[v].coverage.data, two.views[v].coverage.data,
                            (size_t)one.views[v].coverage.width * (size_t)one.views[v].coverage.height *
                                sizeof(real));
    ffp_capture_free(&one), ffp_capture_free(&two);
}

static void must_refuse(const char *empty, const char *what) {
    run_format(&run,
               "import -c %s/shots/truth.json -t %s/shots/truth.json -i "
               "'black=%s/shots/view-{view}/001.png' -i 'white=%s/shots/view-{view}/002.png' -o %s/none -i "
               "'lollipop_0=%s/shots/view-{view}/003.png' -p lollipop_0=%s/patterns/003_lollipop_0.png %s",
               scratch, scratch, scratch, scratch, scratch, scratch, scratch, empty);
    assert_int_equal(run.status, 1);
    if (!strstr(run.err, what)) fail_msg("expected \"%s\", got: %s", what, run.err);
}

static void wrong_pictures_of_the_stage_are_refused(void **state) {
    (void)state;
    char text[600];
    must_refuse("--empty black", "expected NAME=FILES");
    must_refuse("--empty black=/none.png", "/none.png");
    snprintf(text, sizeof text, "--empty black=%s/shots/view-000/001.png", scratch);
    must_refuse(text, "no picture of the stage under white");
    snprintf(text, sizeof text, "--empty earth=%s/shots/view-000/001.png", scratch);
    must_refuse(text, "no photographs under pattern 'earth'");
    snprintf(text, sizeof text, "--empty black=%s/shots/view-000/001.png -m %s/shots/masks/view-{view}.png",
             scratch, scratch);
    must_refuse(text, "masks are given, too");
    snprintf(text, sizeof text,
             "--empty black=%s/shots/view-000/001.png --empty white=%s/patterns/002_white.png", scratch,
             scratch);
    must_refuse(text, "002_white.png");
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(the_dark_shows_the_object),
                                       cmocka_unit_test(finer_photographs_tell_the_shares),
                                       cmocka_unit_test(the_report_shows_the_masks),
                                       cmocka_unit_test(shadows_are_object_and_holes_are_none),
                                       cmocka_unit_test(a_lamp_between_views_is_named),
                                       cmocka_unit_test(wrong_pictures_of_the_stage_are_refused),
                                       cmocka_unit_test(threads_do_not_matter)};
    return cmocka_run_group_tests(tests, setup, scratch_teardown);
}
