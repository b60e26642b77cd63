// Every call fails with "no memory" wherever memory runs out in it, and with "cancelled" wherever its caller
// says so; nothing is left of it (the build with AddressSanitizer tells), and the next one gives the same
// bits.
// Labels: slow
#include <dirent.h>
#include "core/base/call.h"
#include "small.h"

#define POLISH 2

typedef struct Caller {
    int asked, stop_at; // 0: never
} Caller;

static bool on_progress(void *user, const FfpProgress *progress) {
    Caller *caller = user;
    (void)progress;
    return ++caller->asked != caller->stop_at;
}

static FfpContext *context_new(Caller *caller, int threads) {
    FfpError err = {0};
    FfpContextSettings settings = ffp_context_defaults();
    settings.user = caller;
    settings.progress = on_progress;
    settings.interval_s = 0;
    settings.threads = threads;
    FfpContext *context = ffp_context_new(&settings, &err);
    if (!context) fail_msg("%s", err.text);
    return context;
}

// --- Works. Each leaves a file, whose bits tell whether it is the same as ever. ---

typedef bool Work(FfpContext *context, const char *out, FfpError *err);

static bool reconstruct(FfpContext *context, const char *weights, const char *out, FfpError *err) {
    FfpCapture *capture = ffp_capture_open(context, in_scratch("capture"), NULL, err);
    FfpModel *model = capture && weights ? ffp_model_open(context, weights, NULL, err) : NULL;
    const FfpReconstruction how = {
        .size = sizeof how, .model = model, .polish = POLISH, .noise = FFP_NOISE_ESTIMATED};
    FfpGaussians *gaussians =
        capture && (model || !weights) ? ffp_reconstruct(context, capture, &how, NULL, err) : NULL;
    const bool ok = gaussians && ffp_gaussians_save(context, gaussians, out, err);
    ffp_gaussians_close(gaussians);
    ffp_model_close(model);
    ffp_capture_close(capture);
    return ok;
}

static bool classical(FfpContext *context, const char *out, FfpError *err) {
    return reconstruct(context, NULL, out, err);
}

static bool by_network(FfpContext *context, const char *out, FfpError *err) {
    return reconstruct(context, in_scratch("weights"), out, err);
}

static bool prepare(FfpContext *context, const char *out, FfpError *err) {
    FfpCapture *capture = ffp_capture_open(context, in_scratch("capture"), NULL, err);
    FfpModel *model = capture ? ffp_model_open(context, in_scratch("weights"), NULL, err) : NULL;
    const FfpReconstruction how = {.size = sizeof how, .model = model};
    FfpPrepared *prepared = model ? ffp_prepare(context, capture, &how, err) : NULL;
    const FfpPreparedArrays a = prepared ? ffp_prepared_arrays(prepared) : (FfpPreparedArrays){0};
    const size_t size = (size_t)a.tokens * (size_t)a.token_width * sizeof *a.inputs;
    const bool ok = prepared && ffp_write_file(out, a.inputs, size, err);
    ffp_prepared_close(prepared);
    ffp_model_close(model);
    ffp_capture_close(capture);
    return ok;
}

static FfpGaussians *given(FfpContext *context, FfpError *err) {
    return ffp_gaussians_open(context, in_scratch("given.ply"), NULL, err);
}

static bool keep_in_memory(FfpContext *context, const char *out, FfpError *err) {
    FfpGaussians *gaussians = given(context, err), *again = NULL;
    FfpModel *model = gaussians ? ffp_model_open(context, in_scratch("weights"), NULL, err) : NULL;
    FfpBytes splats = {0}, weights = {0};
    splats.data = model ? ffp_gaussians_bytes(context, gaussians, &splats.size, err) : NULL;
    weights.data = splats.data ? ffp_model_bytes(context, model, false, &weights.size, err) : NULL;
    ffp_model_close(model);
    model = weights.data ? ffp_model_open(context, NULL, &weights, err) : NULL;
    again = model ? ffp_gaussians_open(context, NULL, &splats, err) : NULL;
    const bool ok = again && ffp_gaussians_save(context, again, out, err);
    ffp_free((void *)splats.data);
    ffp_free((void *)weights.data);
    ffp_model_close(model);
    ffp_gaussians_close(gaussians);
    ffp_gaussians_close(again);
    return ok;
}

static bool refine(FfpContext *context, const char *out, FfpError *err) {
    FfpCapture *capture = ffp_capture_open(context, in_scratch("capture"), NULL, err);
    FfpGaussians *gaussians = capture ? given(context, err) : NULL;
    const FfpRefinement how = {.size = sizeof how, .steps = 3, .metrics = in_scratch("metrics")};
    const bool ok = gaussians && ffp_refine_gaussians(context, gaussians, capture, &how, NULL, err) &&
                    ffp_gaussians_save(context, gaussians, out, err);
    ffp_gaussians_close(gaussians);
    ffp_capture_close(capture);
    return ok;
}

static bool render(FfpContext *context, const char *out, FfpError *err) {
    FfpCapture *capture = ffp_capture_open(context, in_scratch("capture"), NULL, err);
    FfpGaussians *gaussians = capture ? given(context, err) : NULL;
    const FfpPictures how = {.size = sizeof how,
                             .orbit = FFP_ORBIT_OBJECT,
                             .frames = 2,
                             .video = out,
                             .rate = 1,
                             .folder = in_scratch("pictures")};
    const bool ok = gaussians && ffp_render_pictures(context, gaussians, capture, &how, err) > 0;
    ffp_gaussians_close(gaussians);
    ffp_capture_close(capture);
    return ok;
}

// The same renderer over and over, whatever has happened to it before.
static FfpRenderer *renderer;

static bool draw(FfpContext *context, const char *out, FfpError *err) {
    FfpCapture *capture = ffp_capture_open(context, in_scratch("capture"), NULL, err);
    FfpGaussians *gaussians = capture ? given(context, err) : NULL;
    bool ok = gaussians && (renderer || (renderer = ffp_renderer_new(context, (FfpDrawing){0}, err)));
    for (int side = 12; ok && side <= 16; side += 4) { // what is kept does not fit
        FfpPinhole camera, projector;
        const double intensity[3] = {5, 5, 5};
        unsigned char pixels[3 * 16 * 16];
        const FfpPicture pattern = ffp_capture_picture(capture, -1, 2);
        ffp_capture_view_devices(capture, 0, &camera, &projector);
        camera.width = camera.height = side;
        ok = ffp_renderer_aim(context, renderer, gaussians, &camera, &projector, err) &&
             ffp_renderer_shade(context, renderer, &pattern, intensity, pixels, sizeof pixels, FFP_PIXELS_U8,
                                0, err) &&
             (side < 16 || ffp_write_file(out, pixels, sizeof pixels, err));
    }
    ffp_gaussians_close(gaussians);
    ffp_capture_close(capture);
    return ok;
}

// Two views, and the gradients of one number.
static bool differentiate(FfpContext *context, const char *out, FfpError *err) {
    FfpCapture *capture = ffp_capture_open(context, in_scratch("capture"), NULL, err);
    FfpGaussians *gaussians = capture ? given(context, err) : NULL;
    bool ok = gaussians && (renderer || (renderer = ffp_renderer_new(context, (FfpDrawing){0}, err)));
    enum { NUMBERS = 2 * 2 * 3 * SMALL_SIDE * SMALL_SIDE };
    static float pictures[NUMBERS];
    double intensity[3], poses[12];
    FfpPinhole cameras[2], projectors[2];
    const FfpPicture patterns[2] = {{.data = NULL},
                                    capture ? ffp_capture_picture(capture, -1, 2) : (FfpPicture){0}};
    for (int v = 0; ok && v < 2; v++) ffp_capture_view_devices(capture, v, &cameras[v], &projectors[v]);
    const FfpRenderGradients grad = {.intensity = intensity, .cameras = poses};
    if (ok) {
        const FfpRenderBatch batch = {.gaussians = ffp_gaussians_arrays(gaussians),
                                      .n_views = 2,
                                      .cameras = cameras,
                                      .projectors = projectors,
                                      .n_patterns = 2,
                                      .patterns = patterns,
                                      .intensity = {5, 5, 5},
                                      .gradients = true};
        ok = ffp_renderer_forward(context, renderer, &batch, pictures, NUMBERS, NULL, 0, err) &&
             ffp_renderer_backward(context, renderer, pictures, NUMBERS, NULL, 0, &grad, err) &&
             ffp_write_file(out, poses, sizeof poses, err);
    }
    ffp_gaussians_close(gaussians);
    ffp_capture_close(capture);
    return ok;
}

static bool compensate(FfpContext *context, const char *out, FfpError *err) {
    FfpCapture *capture = ffp_capture_open(context, in_scratch("capture"), NULL, err);
    FfpGaussians *gaussians = capture ? given(context, err) : NULL;
    const char *id = capture ? ffp_capture_view_id(capture, 0) : NULL, *target = in_scratch("target.png");
    const FfpCompensation how = {.size = sizeof how,
                                 .views = &id,
                                 .n_views = 1,
                                 .targets = &target,
                                 .n_targets = 1,
                                 .paint = true,
                                 .steps = 2,
                                 .pattern = out};
    const bool ok = gaussians && ffp_compensate(context, gaussians, capture, &how, NULL, err);
    ffp_gaussians_close(gaussians);
    ffp_capture_close(capture);
    return ok;
}

static bool map(FfpContext *context, const char *out, FfpError *err) {
    FfpCapture *capture = ffp_capture_open(context, in_scratch("capture"), NULL, err);
    FfpGaussians *gaussians = capture ? given(context, err) : NULL;
    const char *id = capture ? ffp_capture_view_id(capture, 0) : NULL;
    const FfpWarps how = {.size = sizeof how, .views = &id, .n_views = 1, .folder = in_scratch("maps")};
    const bool ok = gaussians && ffp_write_warps(context, gaussians, capture, &how, NULL, 0, err) > 0 &&
                    ffp_gaussians_save(context, gaussians, out, err);
    ffp_gaussians_close(gaussians);
    ffp_capture_close(capture);
    return ok;
}

static bool page(FfpContext *context, const char *out, FfpError *err) {
    FfpCapture *capture = ffp_capture_open(context, in_scratch("capture"), NULL, err);
    FfpGaussians *gaussians = capture ? given(context, err) : NULL;
    const FfpPage how = {
        .size = sizeof how, .file = out, .poses = in_scratch("capture/scene.json"), .photographs = 8};
    const bool ok = gaussians && ffp_write_page(context, gaussians, capture, &how, NULL, err);
    ffp_gaussians_close(gaussians);
    ffp_capture_close(capture);
    return ok;
}

static bool evaluate(FfpContext *context, const char *out, FfpError *err) {
    const char *capture = in_scratch("capture");
    int count;
    const FfpEvaluation how = {.size = sizeof how,
                               .captures = &capture,
                               .n_captures = 1,
                               .gaussians = in_scratch("given.ply"),
                               .report = in_scratch("report.html"),
                               .save = in_scratch("saved")};
    FfpScore *scores = ffp_evaluate(context, &how, &count, err);
    const bool ok = scores && ffp_write_file(out, &scores->psnr, sizeof scores->psnr, err);
    ffp_free(scores);
    return ok;
}

static bool export_to(FfpContext *context, const char *name, FfpExport how, const char *out, FfpError *err) {
    char file[FFP_PATH_MAX], to[FFP_PATH_MAX]; // in_scratch's own are good for three more
    snprintf(file, sizeof file, "%s/%s", scratch, name);
    snprintf(to, sizeof to, "%s", out);
    how.file = file;
    FfpCapture *capture = ffp_capture_open(context, in_scratch("capture"), NULL, err);
    FfpGaussians *gaussians = capture ? given(context, err) : NULL;
    char *bytes = NULL;
    size_t size;
    const bool ok = gaussians && ffp_export(context, gaussians, capture, &how, NULL, err) &&
                    ffp_read_file(file, SIZE_MAX / 2, &bytes, &size, err) &&
                    ffp_write_file(to, bytes, size, err);
    ffp_free(bytes);
    ffp_gaussians_close(gaussians);
    ffp_capture_close(capture);
    return ok;
}

static bool export_ply(FfpContext *context, const char *out, FfpError *err) {
    return export_to(context, "splats.ply", (FfpExport){.size = sizeof(FfpExport), .light = "white"}, out,
                     err);
}

static bool export_spz(FfpContext *context, const char *out, FfpError *err) {
    return export_to(context, "splats.spz", (FfpExport){.size = sizeof(FfpExport)}, out, err);
}

static bool export_gltf(FfpContext *context, const char *out, FfpError *err) {
    return export_to(context, "splats.gltf", (FfpExport){.size = sizeof(FfpExport)}, out, err);
}

static bool export_obj(FfpContext *context, const char *out, FfpError *err) {
    return export_to(context, "mesh.obj",
                     (FfpExport){.size = sizeof(FfpExport), .mesh = true, .resolution = 16}, out, err);
}

static bool export_mesh(FfpContext *context, const char *out, FfpError *err) {
    return export_to(context, "mesh.glb",
                     (FfpExport){.size = sizeof(FfpExport), .mesh = true, .resolution = 16}, out, err);
}

static bool inform(FfpContext *context, const char *out, FfpError *err) {
    char *text = ffp_info(context, in_scratch("capture"), err);
    const bool ok = text && ffp_write_file(out, text, strlen(text), err);
    ffp_free(text);
    return ok;
}

static bool inform_as_a_page(FfpContext *context, const char *out, FfpError *err) {
    return ffp_info_report(context, in_scratch("capture"), out, err);
}

static bool copy_capture(FfpContext *context, const char *out, FfpError *err) {
    char command[FFP_PATH_MAX + 16];
    const char *copy = in_scratch("copy");
    FfpCapture *capture = ffp_capture_open(context, in_scratch("capture"), NULL, err);
    const bool ok =
        capture && ffp_capture_save(context, capture, copy, err) && ffp_write_file(out, "saved", 5, err);
    ffp_capture_close(capture);
    snprintf(command, sizeof command, "rm -rf -- '%s'", copy);
    assert_int_equal(system(command), 0);
    return ok;
}

static bool align(FfpContext *context, const char *out, FfpError *err) {
    FfpCapture *capture = ffp_capture_open(context, in_scratch("capture"), NULL, err);
    const bool ok =
        capture &&
        ffp_align_poses(context, capture, &(FfpAlignment){.size = sizeof(FfpAlignment)}, NULL, err) &&
        ffp_write_file(out, &capture->views[0].camera, sizeof capture->views[0].camera, err);
    ffp_capture_close(capture);
    return ok;
}

static bool generate(FfpContext *context, const char *out, FfpError *err) {
    char command[FFP_PATH_MAX + 16];
    const char *made = in_scratch("made");
    const FfpGeneration how = {.size = sizeof how,
                               .folder = made,
                               .split = FFP_SPLIT_TRAIN,
                               .preset = FFP_PRESET_SMOKE,
                               .count = 2,
                               .resolution = 8,
                               .views = 1};
    const bool ok = ffp_generate(context, &how, err) && ffp_write_file(out, "made", 4, err);
    snprintf(command, sizeof command, "rm -rf -- '%s'", made);
    assert_int_equal(system(command), 0);
    return ok;
}

static bool train_by(FfpContext *context, const char *config, int steps, const char *out, FfpError *err) {
    char command[FFP_PATH_MAX + 16];
    const char *run = in_scratch("run");
    const FfpTraining how = {.size = sizeof how, .out = run, .config = config, .steps = steps};
    const bool ok = ffp_train_model(context, &how, err) && ffp_write_file(out, "done", 4, err);
    snprintf(command, sizeof command, "rm -rf -- '%s'", run);
    assert_int_equal(system(command), 0);
    return ok;
}

static bool train(FfpContext *context, const char *out, FfpError *err) {
    return train_by(context, in_scratch("config.json"), 2, out, err);
}

// --- What is asked of them. ---

static void assert_nothing_unfinished(const char *folder) {
    DIR *entries = opendir(folder);
    assert_non_null(entries);
    for (struct dirent *entry; (entry = readdir(entries)) != NULL;)
        if (strstr(entry->d_name, ".tmp") || strstr(entry->d_name, ".part"))
            fail_msg("left: %s", entry->d_name);
    closedir(entries);
}

static void assert_as_ever(FfpContext *context, Work *work) {
    FfpError err = {0};
    char *before, *after;
    size_t size, size_after;
    if (!work(context, in_scratch("after.png"), &err)) fail_msg("%s", err.text);
    assert_true(ffp_read_file(in_scratch("before.png"), SIZE_MAX / 2, &before, &size, &err));
    assert_true(ffp_read_file(in_scratch("after.png"), SIZE_MAX / 2, &after, &size_after, &err));
    assert_int_equal(size, size_after);
    assert_memory_equal(before, after, size);
    ffp_free(before), ffp_free(after);
}

#ifdef FFP_SANITIZED // everything takes ten times as long there
#define STRIDES 5
#else
#define STRIDES 1
#endif

// Fails each allocation, or every `stride`-th; sanitized, fewer.
static void without_memory(Work *work, int threads, int stride) {
    Caller caller = {0};
    FfpError err = {0};
    FfpContext *context = context_new(&caller, threads);
    if (!work(context, in_scratch("before.png"), &err)) fail_msg("%s", err.text);
    long long n = 1;
    for (;; n += (long long)STRIDES * stride) {
        err = (FfpError){0};
        ffp_context_fail_at(context, n);
        const bool ok = work(context, in_scratch("after.png"), &err);
        if (ok && context->allocations < context->fail) break;
        if (ok) fail_msg("allocation %lld failed, and nothing came of it", n);
        if (err.code != FFP_ERROR_MEMORY) fail_msg("allocation %lld: %d, %s", n, (int)err.code, err.text);
        assert_nothing_unfinished(scratch);
    }
    ffp_context_fail_at(context, 0);
    assert_as_ever(context, work);
    printf("%lld allocations\n", n);
    ffp_context_free(context);
}

static void cancelled(Work *work, int threads) {
    Caller caller = {0};
    FfpContext *context = context_new(&caller, threads);
    FfpError err = {0};
    if (!work(context, in_scratch("before.png"), &err)) fail_msg("%s", err.text);
    int k = 1;
    for (;; k++) {
        caller = (Caller){.stop_at = k};
        err = (FfpError){0};
        const bool ok = work(context, in_scratch("after.png"), &err);
        if (ok && caller.asked < k) break;
        if (ok) fail_msg("the %d-th answer was not heard", k);
        if (err.code != FFP_ERROR_CANCELLED) fail_msg("answer %d: %d, %s", k, (int)err.code, err.text);
        assert_int_equal(caller.asked, k); // nobody is asked again
        assert_nothing_unfinished(scratch);
    }
    caller = (Caller){0};
    assert_as_ever(context, work);
    printf("asked %d times\n", k - 1);
    ffp_context_free(context);
}

static void no_memory_for_a_reconstruction(void **state) {
    (void)state;
    without_memory(classical, 2, 1);
}

static void no_memory_for_the_network(void **state) {
    (void)state;
    without_memory(by_network, 2, 1);
}

static void no_memory_elsewhere(void **state) {
    (void)state;
    static const struct {
        Work *work;
        int stride;
    } works[] = {
        {prepare, 11},      {refine, 3},           {render, 3},       {draw, 1},       {keep_in_memory, 1},
        {differentiate, 1}, {compensate, 3},       {map, 3},          {page, 1},       {evaluate, 7},
        {export_ply, 1},    {export_spz, 1},       {export_gltf, 1},  {export_obj, 3}, {export_mesh, 3},
        {inform, 1},        {inform_as_a_page, 3}, {copy_capture, 3}, {align, 199},    {generate, 13},
        {train, 29}};
    for (size_t i = 0; i < sizeof works / sizeof *works; i++)
        without_memory(works[i].work, 2, works[i].stride);
    ffp_renderer_close(renderer);
    renderer = NULL;
}

// --- Training, whose threads count their allocations apart. ---

typedef struct Training {
    FfpContext *context;
    long long n;
} Training;

static void on_first_step(void *user, FfpLogLevel level, const char *text) {
    const Training *training = user;
    (void)level;
    if (strncmp(text, "step 0/", 7) == 0) ffp_context_fail_at(training->context, training->n);
}

// A thread that makes scenes comes to the failing number before the trainer does where both count from the
// beginning. Here only the trainer lacks memory, with scenes taken, made and in the making.
static void no_memory_for_the_trainer_alone(void **state) {
    (void)state;
    Training training = {.n = 1};
    FfpContextSettings settings = ffp_context_defaults();
    FfpError err = {0};
    settings.user = &training, settings.log = on_first_step, settings.threads = 2;
    training.context = ffp_context_new(&settings, &err);
    if (!training.context) fail_msg("%s", err.text);
    while (!train_by(training.context, in_scratch("busy.json"), 6, in_scratch("after.png"), &err)) {
        if (err.code != FFP_ERROR_MEMORY)
            fail_msg("allocation %lld: %d, %s", training.n, (int)err.code, err.text);
        err = (FfpError){0};
        ffp_context_fail_at(training.context, 0);
        training.n *= 4;
    }
    assert_true(training.n > 64);
    ffp_context_free(training.context);
}

static void cancelled_anywhere(void **state) {
    (void)state;
    Work *const works[] = {classical, by_network, render, compensate, page, evaluate, export_mesh, generate};
    for (size_t i = 0; i < sizeof works / sizeof *works; i++) cancelled(works[i], 2);
}

static int setup(void **state) {
#define CONFIG(reuse, generators)                                                                            \
    "{\"model\": \"tiny\", \"resolution\": 16, \"views\": 2, \"targets\": 1, \"lollipops\": 1,"              \
    " \"pattern_side\": 64, \"samples\": 1, \"ambient_rays\": 1, \"supervised_inputs\": 1,"                  \
    " \"supervised_targets\": 1, \"validate_every\": 0, \"log_every\": 1, \"pool\": 2, \"reuse\": " reuse    \
    ", \"generators\": " generators ", \"queue\": 2}"
    static const char config[] = CONFIG("20", "1"), busy[] = CONFIG("1", "2");
    FfpError err = {0};
    if (small_setup(state) != 0) return -1;
    FfpImage target = ffp_image_new(SMALL_SIDE, SMALL_SIDE, 3);
    const bool ok = classical(NULL, in_scratch("given.ply"), &err) &&
                    ffp_image_write_png(&target, in_scratch("target.png"), &err) &&
                    ffp_write_file(in_scratch("config.json"), config, strlen(config), &err) &&
                    ffp_write_file(in_scratch("busy.json"), busy, strlen(busy), &err);
    ffp_image_free(&target);
    if (!ok) fprintf(stderr, "%s\n", err.text);
    return ok ? 0 : -1;
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(no_memory_for_a_reconstruction),
        cmocka_unit_test(no_memory_for_the_network),
        cmocka_unit_test(no_memory_elsewhere),
        cmocka_unit_test(no_memory_for_the_trainer_alone),
        cmocka_unit_test(cancelled_anywhere),
    };
    return cmocka_run_group_tests(tests, setup, scratch_teardown);
}
