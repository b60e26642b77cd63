// Two contexts in two threads give the bits that each gives alone.
// Labels: threads
#include <pthread.h>
#include "core/gaussians/gaussians.h"
#include "small.h"

enum { ROUNDS = 2, PIXELS = 3 * SMALL_SIDE * SMALL_SIDE };

// One caller: its own handles, its own context, its own words.
typedef struct Caller {
    const char *weights; // NULL: none
    int threads;
    int notes; // that were heard
    pthread_t id;
    FfpGaussians *made, *refined;
    unsigned char picture[PIXELS];
    FfpError err;
} Caller;

static void on_note(void *user, FfpLogLevel level, const char *text) {
    (void)level, (void)text;
    ((Caller *)user)->notes++;
}

static bool draw(Caller *c, FfpContext *context, const FfpCapture *capture) {
    FfpPinhole camera, projector;
    const double intensity[3] = {5, 5, 5};
    const FfpPicture pattern = ffp_capture_picture(capture, -1, 2);
    FfpRenderer *renderer = ffp_renderer_new(context, (FfpDrawing){0}, &c->err);
    const bool ok = renderer && ffp_capture_view_devices(capture, 0, &camera, &projector) &&
                    ffp_renderer_aim(context, renderer, c->refined, &camera, &projector, &c->err) &&
                    ffp_renderer_shade(context, renderer, &pattern, intensity, c->picture, PIXELS,
                                       FFP_PIXELS_U8, 0, &c->err);
    ffp_renderer_close(renderer);
    return ok;
}

static bool work(Caller *c) {
    FfpContextSettings settings = ffp_context_defaults();
    settings.user = c;
    settings.log = on_note;
    settings.threads = c->threads;
    FfpContext *context = ffp_context_new(&settings, &c->err);
    char folder[FFP_PATH_MAX];
    snprintf(folder, sizeof folder, "%s/capture", scratch);
    FfpCapture *capture = ffp_capture_open(context, folder, NULL, &c->err);
    FfpModel *model = c->weights ? ffp_model_open(context, c->weights, NULL, &c->err) : NULL;
    const FfpReconstruction how = {
        .size = sizeof how, .model = model, .polish = 6, .noise = FFP_NOISE_ESTIMATED};
    const FfpRefinement further = {.size = sizeof further, .steps = 6, .seed = 5};
    bool ok = capture && (model || !c->weights);
    c->made = ok ? ffp_reconstruct(context, capture, &how, NULL, &c->err) : NULL;
    c->refined = c->made ? ffp_reconstruct(context, capture, &how, NULL, &c->err) : NULL;
    ok = c->refined && ffp_refine_gaussians(context, c->refined, capture, &further, NULL, &c->err) &&
         draw(c, context, capture);
    ffp_model_close(model);
    ffp_capture_close(capture);
    ffp_context_free(context);
    return ok;
}

static void *in_thread(void *argument) {
    return work(argument) ? argument : NULL;
}

static void close_caller(Caller *c) {
    ffp_gaussians_close(c->made);
    ffp_gaussians_close(c->refined);
}

static void assert_same_gaussians(FfpGaussians *a, FfpGaussians *b) {
    const FfpGaussianArrays x = ffp_gaussians_arrays(a), y = ffp_gaussians_arrays(b);
    const size_t n = (size_t)x.count;
    assert_true(n > 0);
    assert_int_equal(x.count, y.count);
    assert_memory_equal(x.centre, y.centre, 3 * n * sizeof(float));
    assert_memory_equal(x.rotation, y.rotation, 4 * n * sizeof(float));
    assert_memory_equal(x.opacity, y.opacity, n * sizeof(float));
    assert_memory_equal(x.albedo, y.albedo, 3 * n * sizeof(float));
    assert_memory_equal(x.ambient, y.ambient, 3 * n * sizeof(float));
}

static void two_at_a_time_are_as_each_alone(void **state) {
    (void)state;
    char weights[FFP_PATH_MAX];
    snprintf(weights, sizeof weights, "%s/weights", scratch);
    const Caller begin[2] = {{.weights = weights, .threads = 1}, {.threads = 2}};
    Caller alone[2] = {begin[0], begin[1]};
    for (int i = 0; i < 2; i++)
        if (!work(&alone[i])) fail_msg("%s", alone[i].err.text);
    for (int round = 0; round < ROUNDS; round++) {
        Caller together[2] = {begin[0], begin[1]};
        for (int i = 0; i < 2; i++)
            assert_int_equal(pthread_create(&together[i].id, NULL, in_thread, &together[i]), 0);
        for (int i = 0; i < 2; i++) {
            void *done;
            pthread_join(together[i].id, &done);
            if (!done) fail_msg("%s", together[i].err.text);
            assert_same_gaussians(together[i].made, alone[i].made);
            assert_same_gaussians(together[i].refined, alone[i].refined);
            assert_memory_equal(together[i].picture, alone[i].picture, PIXELS);
            assert_int_equal(together[i].notes, alone[i].notes);
            close_caller(&together[i]);
        }
    }
    assert_true(alone[0].notes > 0); // three views are few, and a note says so
    for (int i = 0; i < 2; i++) close_caller(&alone[i]);
}

// --- Handles that threads share. ---

enum { SHARERS = 4 };

typedef struct Shared {
    const FfpCapture *capture;
    const FfpModel *model;
    const FfpGaussians *gaussians;
} Shared;

typedef struct Sharer {
    const Shared *shared;
    pthread_t id;
    FfpGaussians *made;
    unsigned char picture[PIXELS];
    FfpError err;
} Sharer;

// Reads all three handles: a reconstruction from capture and model, and a picture of the Gaussians.
static void *share(void *argument) {
    Sharer *s = argument;
    FfpContextSettings settings = ffp_context_defaults();
    settings.threads = 1;
    FfpContext *context = ffp_context_new(&settings, &s->err);
    const FfpReconstruction how = {.size = sizeof how, .model = s->shared->model};
    FfpPinhole camera, projector;
    const double intensity[3] = {5, 5, 5};
    const FfpPicture pattern = ffp_capture_picture(s->shared->capture, -1, 2);
    FfpRenderer *renderer = ffp_renderer_new(context, (FfpDrawing){0}, &s->err);
    s->made = ffp_reconstruct(context, s->shared->capture, &how, NULL, &s->err);
    const bool ok = s->made && renderer &&
                    ffp_capture_view_devices(s->shared->capture, 0, &camera, &projector) &&
                    ffp_renderer_aim(context, renderer, s->shared->gaussians, &camera, &projector, &s->err) &&
                    ffp_renderer_shade(context, renderer, &pattern, intensity, s->picture, PIXELS,
                                       FFP_PIXELS_U8, 0, &s->err);
    ffp_renderer_close(renderer);
    ffp_context_free(context);
    return ok ? s : NULL;
}

static void threads_share_what_they_read(void **state) {
    (void)state;
    char path[FFP_PATH_MAX];
    FfpError err = {0};
    snprintf(path, sizeof path, "%s/capture", scratch);
    FfpCapture *capture = ffp_capture_open(NULL, path, NULL, &err);
    snprintf(path, sizeof path, "%s/weights", scratch);
    FfpModel *model = ffp_model_open(NULL, path, NULL, &err);
    assert_true(capture && model);
    FfpGaussians *gaussians = ffp_reconstruct(
        NULL, capture, &(FfpReconstruction){.size = sizeof(FfpReconstruction), .model = model}, NULL, &err);
    assert_non_null(gaussians);
    const Shared shared = {capture, model, gaussians};
    Sharer sharers[SHARERS] = {0};
    for (int i = 0; i < SHARERS; i++) {
        sharers[i].shared = &shared;
        assert_int_equal(pthread_create(&sharers[i].id, NULL, share, &sharers[i]), 0);
    }
    for (int i = 0; i < SHARERS; i++) {
        void *done;
        pthread_join(sharers[i].id, &done);
        if (!done) fail_msg("%s", sharers[i].err.text);
        assert_same_gaussians(sharers[i].made, sharers[0].made);
        assert_memory_equal(sharers[i].picture, sharers[0].picture, PIXELS);
    }
    for (int i = 0; i < SHARERS; i++) ffp_gaussians_close(sharers[i].made);
    ffp_gaussians_close(gaussians);
    ffp_model_close(model);
    ffp_capture_close(capture);
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(two_at_a_time_are_as_each_alone),
                                       cmocka_unit_test(threads_share_what_they_read)};
    return cmocka_run_group_tests(tests, small_setup, scratch_teardown);
}
