// Faults of a capture, as values: of the check, of a call that is refused, and as JSON.
#include <jansson.h>
#include <math.h>
#include "core/capture/capture.h"
#include "ffprocams.h"
#include "support.h"
#include "world/synth/dataset.h"

static FfpCapture *capture;
static FfpFinding *findings;
static int count, called;
static char last[64], logged[512];

static int setup(void **state) {
    (void)state;
    capture = ffp_capture_open(NULL, FFP_SOURCE_DIR "/data/sample", NULL, NULL);
    return capture == NULL;
}

static int teardown(void **state) {
    (void)state;
    ffp_capture_close(capture);
    ffp_free(findings);
    findings = NULL;
    return 0;
}

static const FfpFinding *find(const char *code) {
    FfpError err = {0};
    ffp_free(findings);
    findings = ffp_capture_check(NULL, capture, &count, &err);
    if (!findings) fail_msg("%s", err.text);
    for (int i = 0; i < count; i++)
        if (strcmp(findings[i].code, code) == 0) return &findings[i];
    fail_msg("%s is not found", code);
    return NULL;
}

// Black and white in one view.
static void exchange(void) {
    FfpView *view = &capture->views[3];
    const FfpImage kept = view->images[capture->black];
    view->images[capture->black] = view->images[capture->white];
    view->images[capture->white] = kept;
}

// Spanners: neighbouring views see different sides of a handle, and of a head so little that its planes say
// nothing about motions.
static void thin_things_have_not_moved(void **state) {
    FfpCapture *const sample = capture, made;
    (void)state;
    for (int scene = 11; scene <= 131; scene += 120) {
        FfpSceneSpec spec = ffp_scene_defaults();
        spec.resolution = 128, spec.views = 8, spec.targets = 0;
        spec.lollipops = 1, spec.pattern_side = 800, spec.ambient_rays = 1;
        ffp_dataset_scene("test", scene, 0, &spec);
        assert_true(ffp_scene_make(&made, &spec, NULL));
        capture = &made;
        find("surfaces");
        ffp_capture_free(&made);
    }
    capture = sample;
}

static void a_check_gives_values(void **state) {
    (void)state;
    const FfpFinding *f = find("silhouettes");
    assert_int_equal(f->severity, FFP_FINDING_OK);
    assert_true(f->figure >= 0 && f->figure < 0.01 && f->limit == 0.03);
    assert_true(!f->view && !f->advice && count > 15);
    assert_int_equal(find("clipped")->severity, FFP_FINDING_DOUBT);
    assert_non_null(find("clipped")->advice);
    assert_true(isnan(find("surfaces")->figure));
    exchange();
    f = find("photographs-exchanged");
    assert_int_equal(f->severity, FFP_FINDING_FAULT);
    assert_string_equal(f->view, capture->views[3].id);
    assert_string_equal(f->setting, "force");
}

static void on_finding(void *user, const FfpFinding *finding) {
    called++;
    assert_ptr_equal(user, &called);
    snprintf(last, sizeof last, "%s", finding->code);
}

static void on_log(void *user, FfpLogLevel level, const char *text) {
    (void)user, (void)level;
    snprintf(logged, sizeof logged, "%s", text);
}

static void a_refused_call_tells_why(void **state) {
    (void)state;
    FfpError err = {0};
    FfpContextSettings settings = ffp_context_defaults();
    const FfpReconstruction options = ffp_reconstruction_defaults();
    settings.user = &called, settings.log = on_log, settings.finding = on_finding;
    exchange();
    FfpContext *context = ffp_context_new(&settings, &err);
    assert_null(ffp_reconstruct(context, capture, &options, NULL, &err));
    assert_int_equal(err.code, FFP_ERROR_FAULT);
    assert_int_equal(called, 1);
    assert_string_equal(last, "photographs-exchanged");
    assert_string_equal(logged, "");
    ffp_context_free(context);
    settings.finding = NULL; // then notes are lines of the log
    exchange();
    for (int i = 0; i < 3 * 128 * 128; i++)
        capture->views[2].images[capture->white].data[i] = capture->views[1].images[capture->white].data[i];
    context = ffp_context_new(&settings, &err);
    assert_null(ffp_reconstruct(context, capture, &options, NULL, &err));
    assert_non_null(strstr(logged, capture->views[2].id));
    assert_int_equal(called, 1);
    ffp_context_free(context);
}

static const char *text_of(const json_t *object, const char *key) {
    return json_string_value(json_object_get(object, key));
}

static void json_holds_the_same(void **state) {
    (void)state;
    FfpError err = {0};
    const FfpFinding odd = {.code = "a",
                            .severity = FFP_FINDING_NOTE,
                            .view = "M\xfcnchen\"",
                            .figure = NAN,
                            .limit = 2,
                            .subject = "b",
                            .text = "c\n"};
    const FfpFinding foreign = {.code = "odd", .severity = (FfpSeverity)9};
    assert_null(ffp_finding_json(&foreign));
    char *text = ffp_finding_json(&odd);
    json_t *read = json_loads(text, 0, NULL);
    assert_string_equal(text_of(read, "view"), "M?nchen\"");
    assert_string_equal(text_of(read, "severity"), "note");
    assert_true(!json_object_get(read, "figure") && !json_object_get(read, "advice"));
    json_decref(read);
    ffp_free(text);
    text = ffp_info_json(NULL, FFP_SOURCE_DIR "/data/sample", &err);
    read = json_loads(text, 0, NULL);
    assert_non_null(strstr(text_of(read, "text"), "checks\n"));
    size_t i;
    json_t *one, *list = json_object_get(read, "findings");
    bool clipped = false;
    json_array_foreach(list, i, one) clipped = clipped || strcmp(text_of(one, "code"), "clipped") == 0;
    assert_true(clipped && json_array_size(list) > 15);
    json_decref(read);
    ffp_free(text);
    assert_null(ffp_info_json(NULL, "/nowhere", &err));
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(thin_things_have_not_moved, setup, teardown),
        cmocka_unit_test_setup_teardown(a_check_gives_values, setup, teardown),
        cmocka_unit_test_setup_teardown(a_refused_call_tells_why, setup, teardown),
        cmocka_unit_test_setup_teardown(json_holds_the_same, setup, teardown),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
