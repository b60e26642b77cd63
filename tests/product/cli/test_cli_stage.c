// Masks in a rehearsed room (../shared/real-room), whose walls, boxes and platter the projector lights: from
// the empty stage, against the true ones.
#include "core/capture/capture.h"
#include "product/cli/program.h"

static ProgramRun run;
static char room[1024];

// The turntable's option from axis.json.
static void read_turntable(char *out, size_t size) {
    char path[1100];
    double n[6] = {0};
    snprintf(path, sizeof path, "%s/axis.json", room);
    FILE *file = fopen(path, "r");
    assert_non_null(file);
    const int found = fscanf(file, " { \"axis\": [%lf, %lf, %lf], \"point\": [%lf, %lf, %lf]", &n[0], &n[1],
                             &n[2], &n[3], &n[4], &n[5]);
    fclose(file);
    assert_int_equal(found, 6);
    snprintf(out, size, "%.9g,%.9g,%.9g,%.9g,%.9g,%.9g,8x45", n[0], n[1], n[2], n[3], n[4], n[5]);
}

static void import(FfpCapture *capture, const char *name, const char *more) {
    char turntable[300], line[4000];
    FfpError err = {0};
    read_turntable(turntable, sizeof turntable);
    snprintf(line, sizeof line,
             "--events 1 import -c %s/calibration.xml -t %s -i "
             "'black,white,lollipop_0=%s/photographs/{view}/{pattern}.JPG' "
             "-p lollipop_0=%s/patterns/lollipop_0.png -w 240 -o %s/%s %s",
             room, turntable, room, room, scratch, name, more);
    run_program(&run, line);
    if (run.status != 0) fail_msg("%s\n%s", line, run.err);
    if (!ffp_capture_read(capture, in_scratch(name), &err)) fail_msg("%s", err.text);
}

// The least overlap of a view's mask with the true one, and what is missing of all.
static double compare(const FfpCapture *truth, const FfpCapture *made, double *missing) {
    double least = 1, lost = 0, object = 0;
    for (int v = 0; v < made->n_views; v++) {
        const FfpImage *a = &truth->views[v].coverage, *b = &made->views[v].coverage;
        double both = 0, either = 0;
        for (int i = 0; i < a->width * a->height; i++) {
            const bool in_a = a->data[i] >= 0.5F, in_b = b->data[i] >= 0.5F;
            both += in_a && in_b, either += in_a || in_b, lost += in_a && !in_b, object += in_a;
        }
        printf("view %s: overlap %.3f\n", made->views[v].id, both / either);
        least = both / either < least ? both / either : least;
    }
    *missing = lost / object;
    return least;
}

static void the_empty_stage_tells_the_object(void **state) {
    (void)state;
    char masks[1100], empty[3400];
    FfpCapture truth, made;
    double missing;
    if (!shared_path(room, "real-room")) skip();
    snprintf(masks, sizeof masks, "-m '%s/masks/{view}.png'", room);
    snprintf(empty, sizeof empty, "--empty 'black,white,lollipop_0=%s/empty/{pattern}.JPG'", room);
    import(&truth, "truth", masks);
    import(&made, "made", empty);
    assert_non_null(strstr(run.err, "8 masks were made from the empty stage"));
    const double least = compare(&truth, &made, &missing);
    printf("missing %.4f\n", missing);
    assert_true(least > 0.93);
    assert_true(missing < 0.03);
    ffp_capture_free(&truth), ffp_capture_free(&made);
}

static void what_stays_the_same_tells_the_object(void **state) {
    (void)state;
    char masks[1100];
    FfpCapture truth, made;
    double missing;
    if (!shared_path(room, "real-room")) skip();
    snprintf(masks, sizeof masks, "-m '%s/masks/{view}.png'", room);
    import(&truth, "true", masks);
    import(&made, "common", "");
    assert_true(has_told(&run, "lit-background"));
    assert_non_null(strstr(run.err, "agree with the other views' masks"));
    const double least = compare(&truth, &made, &missing);
    printf("missing %.4f\n", missing);
    assert_true(least > 0.75);
    assert_true(missing < 0.04);
    struct stat sheet;
    assert_int_equal(stat(in_scratch("common/masks.png"), &sheet), 0);
    ffp_capture_free(&truth), ffp_capture_free(&made);
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(the_empty_stage_tells_the_object),
                                       cmocka_unit_test(what_stays_the_same_tells_the_object)};
    return cmocka_run_group_tests(tests, scratch_setup, scratch_teardown);
}
