// Times that a GPU's users wait: a forward pass with one relit view, and a training step, for any preset.
// usage: gpu_steps PRESET [VIEWS RESOLUTION [PERCEPTUAL]]
#include "bench/gpu_timing.h"
#include "core/base/call.h"
#include "engine/render/pass.h"
#include "lab/train/mirror.h"

struct Bench {
    FfpTrainConfig config;
    FfpMirror *mirror;
    const FfpScene *scene;
    FfpTrainStep *stepper;
    FfpRun *run;
    FfpViewPass *pass;
    FfpImage picture;
    real *grad;
    int64_t step;
    FfpLosses losses;
    FfpError err;
};

static void report(const char *name, Bench *b, void (*run)(Bench *)) {
    gpu_report(name, gpu_seconds(run, b, 1), 0, 0);
}

static void forward(Bench *b) {
    ffp_model_forward_prepared(&b->mirror->model, b->run, b->scene->prepared, &b->err);
}

static void relight(Bench *b) {
    const FfpView *view = &b->scene->capture.views[b->scene->inputs.n_views];
    ffp_view_pass_draw(b->pass, &b->run->gaussians, &view->camera, &view->projector);
    if (!b->picture.data) b->picture = ffp_view_pass_picture_new(b->pass);
    ffp_view_pass_shade(b->pass, b->scene->capture.intensity, &b->scene->patterns[b->scene->active],
                        &b->picture);
}

static void both(Bench *b) {
    forward(b);
    relight(b);
}

static void gradient(Bench *b) {
    ffp_memory_zero(b->grad, (size_t)b->mirror->model.count * sizeof(real));
    if (!ffp_train_step_loss(b->stepper, &b->mirror->model, b->scene, b->step++, &b->losses, b->grad,
                             &b->err))
        printf("%s\n", b->err.text);
}

static void update(Bench *b) {
    bool skipped;
    ffp_adam_update(&b->mirror->adam, &b->mirror->model, b->grad, &b->config, &skipped);
}

static void step(Bench *b) {
    gradient(b);
    update(b);
}

static void tell_parts(const FfpLosses *l) {
    printf("  ms:");
    for (int i = 0; i < FFP_PHASES; i++) printf(" %s %.2f", ffp_step_phase_names[i], 1e3 * l->seconds[i]);
    printf("\n");
}

typedef struct Opening {
    FfpScene *scene;
    const FfpTrainConfig *config;
} Opening;

static bool open_scene(void *argument, FfpError *err) {
    const Opening *o = argument;
    return ffp_scene_open(o->scene, o->config, NULL, "train", 0, err);
}

static bool open_bench(Bench *b, int argc, char **argv) {
    char text[512];
    snprintf(text, sizeof text,
             "{\"model\": \"%s\", \"views\": %s, \"resolution\": %s, \"lollipops\": 3, \"perceptual\": 0.05,"
             " \"perceptual_from\": 0, \"supervised_inputs\": 1, \"supervised_targets\": 3,"
             " \"truth_albedo\": 0.05, \"truth_normal\": 0.02, \"polish_share\": 0, \"polish_steps\": 24}",
             argc > 1 ? argv[1] : "small", argc > 3 ? argv[2] : "8", argc > 3 ? argv[3] : "128");
    FfpError *err = &b->err;
    if (!ffp_train_config_parse(&b->config, text, "bench", err)) return false;
    static FfpScene scene;
    const FfpDevice *device = ffp_cuda_device(err);
    if (!device) return false;
    FfpContext context = {.device = device}; // the scene is made ready for it
    double begin = ffp_seconds();
    if (!ffp_call_run(&context, open_scene, &(Opening){&scene, &b->config}, err)) return false;
    printf("scene made by the CPU in %.2f s\n", ffp_seconds() - begin);
    FfpModel *model = ffp_model_new(&b->config.model, 1, err);
    if (!model) return false;
    b->config.model = model->config;
    FfpAdam adam = ffp_adam_new(model);
    FfpPerceptual *perceptual = argc > 4 ? ffp_perceptual_read(argv[4], err) : NULL;
    if (argc > 4 && !perceptual) return false;
    ffp_device_use(device);
    printf("%s\n%s: %.1f million values\n", ffp_cuda_describe(), argc > 1 ? argv[1] : "small",
           (double)model->count / 1e6);
    b->mirror = ffp_mirror_new(model, &adam, &b->config);
    begin = ffp_seconds();
    b->scene = ffp_mirror_scene(b->mirror, 0, true, &scene);
    device->synchronise();
    printf("%lld Gaussians, brought there in %.3f s\n", (long long)ffp_prepared_count(b->scene->prepared),
           ffp_seconds() - begin);
    b->stepper = ffp_train_step_new(&b->config, perceptual);
    b->run = ffp_run_new(true);
    const FfpRenderSettings settings =
        ffp_render_settings(ffp_model_is_paper_form(&model->config), model->config.samples);
    b->pass = ffp_view_pass_new(&settings);
    b->grad = ffp_memory_new((size_t)model->count, sizeof(real));
    return true;
}

int main(int argc, char **argv) {
    static Bench b;
    if (!open_bench(&b, argc, argv)) {
        fprintf(stderr, "error: %s\n", b.err.text);
        return 1;
    }
    report("forward pass", &b, forward);
    report("a relit view", &b, relight);
    report("forward pass and a relit view", &b, both);
    report("gradient of a step", &b, gradient);
    tell_parts(&b.losses);
    report("update", &b, update);
    report("step", &b, step);
    b.config.polish_share = 1;
    report("gradient of a step through the polish", &b, gradient);
    tell_parts(&b.losses);
    return 0;
}
