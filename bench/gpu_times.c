// Milliseconds of what docs/design/performance.md says of a GPU: passes and steps of training, stages of a
// reconstruction, drawing, losses, the polish, and products against the chip's own rate. On the emulation
// everything is tiny, once, and times mean nothing.
//   gpu_times [PRESET]     of the passes and steps: small
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include "core/base/call.h"
#include "core/base/log.h"
#include "core/base/rng.h"
#include "core/capture/uploaded.h"
#include "core/tensor/tensor.h"
#include "engine/cuda/cuda.h"
#include "engine/cuda/products.h"
#include "engine/loss/metrics.h"
#include "engine/loss/perceptual_net.h"
#include "engine/network/layout.h"
#include "engine/pipeline/reconstruct.h"
#include "engine/refine/refine.h"
#include "engine/render/pass.h"
#include "lab/train/mirror.h"
#include "tests/ball.h"
#include "tests/random_perceptual.h"

enum { REPEATS = 15, WARM = 3, PICTURES = 3 };

static const FfpDevice *device;
static bool tiny; // on the emulation

static void fail(const FfpError *err) {
    fprintf(stderr, "gpu_times: error: %s\n", err->text);
    exit(1);
}

static int ascending(const void *a, const void *b) {
    const double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

// Median seconds of one of `times` runs queued one behind the other and waited for together.
static double seconds_of(void (*run)(void *), void *work, int times) {
    const int repeats = tiny ? 1 : REPEATS;
    double seconds[REPEATS];
    if (tiny) times = 1;
    for (int i = 0; i < (tiny ? 0 : WARM); i++) run(work);
    for (int r = 0; r < repeats; r++) {
        device->synchronise();
        const double begin = ffp_seconds();
        for (int i = 0; i < times; i++) run(work);
        device->synchronise();
        seconds[r] = (ffp_seconds() - begin) / times;
    }
    qsort(seconds, (size_t)repeats, sizeof *seconds, ascending);
    return seconds[repeats / 2];
}

static void report(const char *name, void (*run)(void *), void *work, int times) {
    printf("%-40s %9.4f ms\n", name, 1e3 * seconds_of(run, work, times));
    fflush(stdout);
}

// A product, by its operations as a share of the peak.
static void report_share(const char *name, void (*run)(void *), void *work, double operations, double peak) {
    const double rate = operations / seconds_of(run, work, 30);
    printf("%-40s %8.2f TFLOP/s, %.1f %%\n", name, rate / 1e12, 100 * rate / peak);
    fflush(stdout);
}

static float *numbers(size_t count, uint64_t seed, float low, float high) {
    FfpRng rng = ffp_rng(seed, 0);
    float *values = ffp_alloc(count, sizeof *values);
    for (size_t i = 0; i < count; i++) values[i] = ffp_rng_range(&rng, low, high);
    float *there = ffp_memory_uploaded(values, count, sizeof *values);
    ffp_free(values);
    return there;
}

// --- Passes and steps of the network. ---

typedef struct Training {
    FfpTrainConfig config;
    FfpModel *model; // the host's, as `made`
    FfpScene made;
    const FfpScene *scene;
    FfpMirror *mirror;
    FfpTrainStep *stepper;
    FfpRun *run;
    FfpViewPass *pass;
    FfpImage picture;
    real *grad;
    int64_t step;
} Training;

static bool make_scene(void *training, FfpError *err) {
    Training *t = training;
    return ffp_scene_open(&t->made, &t->config, NULL, "train", 0, err);
}

static void open_training(Training *t, const char *preset) {
    char text[512];
    FfpError err = {0};
    snprintf(text, sizeof text,
             "{\"model\": %s, \"views\": %d, \"resolution\": %d, \"lollipops\": 3, \"perceptual\": 0,"
             " \"supervised_inputs\": 1, \"supervised_targets\": 3, \"truth_albedo\": 0.05,"
             " \"truth_normal\": 0.02, \"polish_share\": 0, \"polish_steps\": %d}",
             tiny ? "{\"preset\": \"small\", \"dim\": 64, \"modules\": \"MT\"}" : preset, tiny ? 2 : 8,
             tiny ? 32 : 128, tiny ? 1 : 24);
    FfpContext context = {.device = device}; // the scene is made ready for it
    if (!ffp_train_config_parse(&t->config, text, "gpu_times", &err) ||
        !ffp_call_run(&context, make_scene, t, &err))
        fail(&err);
    FfpModel *model = t->model = ffp_model_new(&t->config.model, 1, &err);
    if (!model) fail(&err);
    t->config.model = model->config;
    FfpAdam adam = ffp_adam_new(model);
    ffp_device_use(device);
    t->mirror = ffp_mirror_new(model, &adam, &t->config);
    t->scene = ffp_mirror_scene(t->mirror, 0, true, &t->made);
    t->stepper = ffp_train_step_new(&t->config, NULL);
    t->run = ffp_run_new(true);
    const FfpRenderSettings settings =
        ffp_render_settings(ffp_model_is_paper_form(&model->config), model->config.samples);
    t->pass = ffp_view_pass_new(&settings);
    t->grad = ffp_memory_new((size_t)model->count, sizeof(real));
    printf("%.1f million parameters, %lld Gaussians\n", (double)model->count / 1e6,
           (long long)ffp_prepared_count(t->scene->prepared));
}

static void forward(void *training) {
    Training *t = training;
    FfpError err = {0};
    if (!ffp_model_forward_prepared(&t->mirror->model, t->run, t->scene->prepared, &err)) fail(&err);
}

static void forward_and_relit(void *training) {
    Training *t = training;
    const FfpView *view = &t->scene->capture.views[t->scene->inputs.n_views];
    forward(t);
    ffp_view_pass_draw(t->pass, &t->run->gaussians, &view->camera, &view->projector);
    if (!t->picture.data) t->picture = ffp_view_pass_picture_new(t->pass);
    ffp_view_pass_shade(t->pass, t->scene->capture.intensity, &t->scene->patterns[t->scene->active],
                        &t->picture);
}

static void step(void *training) {
    Training *t = training;
    FfpLosses losses;
    FfpError err = {0};
    bool skipped;
    ffp_memory_zero(t->grad, (size_t)t->mirror->model.count * sizeof(real));
    if (!ffp_train_step_loss(t->stepper, &t->mirror->model, t->scene, t->step++, &losses, t->grad, &err))
        fail(&err);
    ffp_adam_update(&t->mirror->adam, &t->mirror->model, t->grad, &t->config, &skipped);
}

enum { STAGES = 4, RECONSTRUCTIONS = 5 };
typedef struct Reconstructing {
    const Training *of;
    double seconds[STAGES][RECONSTRUCTIONS];
} Reconstructing;

static bool reconstruct(void *reconstructing, FfpError *err) {
    Reconstructing *r = reconstructing;
    const FfpReconstruction options = {.model = r->of->model,
                                       .polish = tiny ? 2 : FFP_POLISH_STEPS,
                                       .noise = 0.002,
                                       .layers = FFP_LAYERS_AUTO};
    FfpReconstructionStats stats;
    for (int i = -1; i < (tiny ? 1 : RECONSTRUCTIONS); i++) { // the first is to warm up
        FfpGaussians *g = ffp_reconstruction_run(&r->of->made.inputs, &options, &stats, err);
        if (!g) return false;
        ffp_gaussians_free(g);
        ffp_free(g);
        const double stages[STAGES] = {stats.denoise_s, stats.initialisation_s, stats.network_s,
                                       stats.polish_s};
        for (int s = 0; s < STAGES && i >= 0; s++) r->seconds[s][i] = stages[s];
    }
    return true;
}

// Stages of reconstructions by the GPU, and by the CPU alone. The weights are untrained: the fit begins where
// the classical start is.
static void time_stages(const Training *t) {
    const char *const names[STAGES] = {"noise", "matching", "network", "fit"};
    const int n = tiny ? 1 : RECONSTRUCTIONS;
    for (int cpu = 0; cpu < 2; cpu++) {
        Reconstructing r = {.of = t};
        FfpContext context = {.device = cpu ? NULL : device};
        FfpError err = {0};
        ffp_device_use(NULL);
        if (!ffp_call_run(&context, reconstruct, &r, &err)) fail(&err);
        printf("a reconstruction by the %s:", cpu ? "CPU" : "GPU");
        for (int s = 0; s < STAGES; s++) {
            qsort(r.seconds[s], (size_t)n, sizeof **r.seconds, ascending);
            printf("%s %s %.1f", s ? "," : "", names[s], 1e3 * r.seconds[s][n / 2]);
        }
        printf(" ms\n");
    }
    fflush(stdout);
    ffp_device_use(device);
}

static void time_training(const char *preset) {
    static Training t;
    open_training(&t, preset);
    report("forward pass of a prepared capture", forward, &t, 1);
    report("forward pass and one relit view", forward_and_relit, &t, 1);
    report("training step, 4 views, 3 pictures each", step, &t, 1);
    t.config.polish_share = 1;
    report("step through a polish", step, &t, 1);
    time_stages(&t);
}

// --- Drawing and the polish. ---

typedef struct Drawing {
    FfpRenderSettings settings;
    FfpCamera fine; // a pixel for each sample
    FfpCapture capture;
    FfpGaussians gaussians, grad; // on the device, as what follows
    FfpSummed light;
    FfpImage picture;
    FfpRaster *raster;
    FfpGbuffer samples, grad_samples, shadow;
    FfpViewPass *pass;
} Drawing;

static void rasterise(void *drawing) {
    Drawing *d = drawing;
    ffp_rasterise(d->raster, &d->gaussians, &d->fine, &d->settings, &d->samples);
}
static void rasterise_backward(void *drawing) {
    Drawing *d = drawing;
    ffp_rasterise_backward(d->raster, &d->gaussians, &d->fine, &d->settings, &d->samples, &d->grad_samples,
                           &d->grad);
}
static void shadow_map(void *drawing) {
    Drawing *d = drawing;
    ffp_gbuffer_free(&d->shadow);
    d->shadow = ffp_shadow_map(d->raster, &d->gaussians, &d->capture.views[0].projector, &d->settings);
}
static void view_and_pictures(void *drawing) {
    Drawing *d = drawing;
    ffp_view_pass_draw(d->pass, &d->gaussians, &d->capture.views[0].camera, &d->capture.views[0].projector);
    if (!d->picture.data) d->picture = ffp_view_pass_picture_new(d->pass);
    for (int p = 0; p < PICTURES; p++)
        ffp_view_pass_shade(d->pass, d->capture.intensity, p ? &d->light : NULL, &d->picture);
}
static void polish(void *drawing) {
    Drawing *d = drawing;
    FfpRefineSettings settings = ffp_polish_defaults(tiny ? 2 : 24);
    FfpRefineResult result;
    FfpError err = {0};
    FfpGaussians g = ffp_gaussians_copy(&d->gaussians);
    settings.quiet = true;
    if (!ffp_refine(&g, &d->capture, ball_patterns, BALL_PATTERNS, &settings, &result, &err)) fail(&err);
    ffp_gaussians_free(&g);
}

static void time_drawing(void) {
    const int64_t count = tiny ? 300 : 45000;
    const int side = tiny ? 16 : 128, panel = tiny ? 32 : 256;
    Drawing d = {.settings = ffp_render_defaults()};
    if (tiny) d.settings.shadow_side = 20;
    const int fine = d.settings.samples * side;
    ffp_device_use(NULL); // the scene is made by the CPU
    FfpCapture capture = ball_capture(count, tiny ? 2 : 8, side, side, panel);
    FfpGaussians start = ball_disturbed(count);
    FfpSummed light = ffp_summed_new(&capture.patterns[BALL_STRIPES].image);
    ffp_device_use(device);
    d.capture = ffp_capture_uploaded(&capture, NULL, 0);
    d.gaussians = ffp_gaussians_uploaded(&start);
    d.light = ffp_summed_uploaded(&light);
    d.grad = ffp_gaussians_new(count);
    d.fine = ball_device(0, 0.3F, 2.5F, fine, fine);
    d.raster = ffp_raster_new();
    d.samples = ffp_gbuffer_new(fine, fine);
    d.grad_samples = ffp_gbuffer_new(fine, fine);
    d.pass = ffp_view_pass_new(&d.settings);
    printf("%lld splats, views of %dx%d with %dx%d samples\n", (long long)count, side, side,
           d.settings.samples, d.settings.samples);
    report("rasterise", rasterise, &d, 20);
    report("rasterise backward", rasterise_backward, &d, 20);
    report("shadow map", shadow_map, &d, 20);
    report("a view with its three pictures", view_and_pictures, &d, 10);
    report(tiny ? "a polish of 2 steps" : "a polish of 24 steps", polish, &d, 1);
}

// --- Losses. ---

typedef struct Losses {
    FfpImage a, b, grad; // on the device
    FfpPerceptual *net;
} Losses;

static void ssim(void *losses) {
    Losses *l = losses;
    ffp_ssim_loss(&l->a, &l->b, 1, &l->grad);
}
static void perceptual(void *losses) {
    Losses *l = losses;
    ffp_perceptual_loss(l->net, &l->a, &l->b, 1, &l->grad);
}

static void time_losses(void) {
    const int side = tiny ? 33 : 128;
    const size_t count = 3 * (size_t)side * side;
    FfpImage images[3];
    for (int i = 0; i < 3; i++) images[i] = (FfpImage){side, side, 3, numbers(count, (uint64_t)i + 1, 0, 1)};
    Losses l = {images[0], images[1], images[2], random_perceptual(FFP_PERCEPTUAL_SQUEEZE)};
    report("SSIM and its gradient", ssim, &l, 20);
    report("LPIPS (SqueezeNet) and its gradient", perceptual, &l, 5);
    ffp_perceptual_free(l.net);
    for (int i = 0; i < 3; i++) ffp_memory_free(images[i].data);
}

// --- Products. ---

typedef struct Products {
    int rows, dim, wide; // [rows, dim] to [rows, wide]
    float *a, *b, *c, *d, *weight, *dweight, *gain, *dgain, *sums, *scratch;
    FfpAttentionShape shape;
} Products;

static void large_product(void *products) {
    Products *p = products;
    ffp_cuda_product(&(FfpCudaProduct){.operands = FFP_OPERANDS_BF16,
                                       .m = p->rows,
                                       .n = p->rows,
                                       .k = p->rows,
                                       .alpha = 1,
                                       .a = {p->a, p->rows, false},
                                       .b = {p->b, p->rows, true},
                                       .beta = 0,
                                       .c = p->c,
                                       .ldc = p->rows});
}
static void linear(void *products) {
    Products *p = products;
    ffp_linear_forward(p->c, p->a, p->weight, NULL, p->rows, p->dim, p->wide);
}
static void linear_backward(void *products) {
    Products *p = products;
    ffp_linear_backward(p->c, p->dweight, NULL, p->b, p->a, p->weight, p->rows, p->dim, p->wide);
}
static void attention(void *products) {
    Products *p = products;
    ffp_attention_forward(p->c, p->sums, &p->shape, &(FfpAttentionInput){p->a, p->gain, p->gain}, p->scratch);
}
static void attention_backward(void *products) {
    Products *p = products;
    ffp_attention_backward(&(FfpAttentionGradient){p->d, p->dgain, p->dgain + FFP_HEAD_DIM}, &p->shape,
                           &(FfpAttentionInput){p->a, p->gain, p->gain}, p->c, p->sums, p->b, p->scratch);
}

static Products products_new(int rows, int dim) {
    Products p = {.rows = rows, .dim = dim, .wide = FFP_MLP_RATIO * dim};
    const size_t most = (size_t)(rows > dim ? rows : dim) * (size_t)(rows > p.wide ? rows : p.wide);
    p.shape = (FfpAttentionShape){.rows = rows, .heads = dim / FFP_HEAD_DIM, .head_dim = FFP_HEAD_DIM};
    float **const arrays[] = {&p.a, &p.b, &p.c, &p.d, &p.weight, &p.dweight};
    for (size_t i = 0; i < sizeof arrays / sizeof *arrays; i++)
        *arrays[i] = numbers(most, i + 1, -0.1F, 0.1F);
    p.gain = numbers((size_t)dim, 7, 0.9F, 1.1F);
    p.dgain = numbers((size_t)(dim > 2 * FFP_HEAD_DIM ? dim : 2 * FFP_HEAD_DIM), 8, 0, 0);
    p.sums = numbers((size_t)rows * (size_t)p.shape.heads, 9, 0, 1);
    p.scratch = ffp_memory_new(ffp_attention_scratch(&p.shape), sizeof(float));
    return p;
}

static void products_free(Products *p) {
    float *const arrays[] = {p->a,       p->b,    p->c,     p->d,    p->weight,
                             p->dweight, p->gain, p->dgain, p->sums, p->scratch};
    for (size_t i = 0; i < sizeof arrays / sizeof *arrays; i++) ffp_memory_free(arrays[i]);
}

// Numbers of 0.5 to 1 and either sign, as bf16.
static float *halves(size_t count, uint64_t seed) {
    FfpRng rng = ffp_rng(seed, 0);
    uint16_t *values = ffp_alloc(count, sizeof *values);
    for (size_t i = 0; i < count; i++) values[i] = (uint16_t)(0x3f00U | (ffp_rng_u32(&rng) & 0x807fU));
    float *there = ffp_memory_uploaded(values, count, sizeof *values);
    ffp_free(values);
    return there;
}

static void time_products(void) {
    const int side = tiny ? 64 : 8192;
    const size_t count = (size_t)side * (size_t)side;
    Products large = {.rows = side, .a = halves(count, 1), .b = halves(count, 2)};
    large.c = ffp_memory_new(count, sizeof(float));
    const double peak = 2.0 * side * side * side / seconds_of(large_product, &large, 30);
    ffp_memory_free(large.a);
    ffp_memory_free(large.b);
    ffp_memory_free(large.c);
    Products p = products_new(tiny ? 70 : 2048, tiny ? 64 : 1024);
    const double layer = 2.0 * p.rows * p.dim * p.wide, pairs = 2.0 * p.rows * p.rows * p.dim;
    printf("product of %d^3 in bf16: %.0f TFLOP/s; %d tokens of width %d:\n", side, peak / 1e12, p.rows,
           p.dim);
    report_share("linear layer", linear, &p, layer, peak);
    report_share("linear layer, back", linear_backward, &p, 2 * layer, peak);
    report_share("attention", attention, &p, 2 * pairs, peak);
    report_share("attention, back", attention_backward, &p, 5 * pairs, peak);
    products_free(&p);
}

int main(int argc, char **argv) {
    char preset[64];
    FfpError err = {0};
    if (!(device = ffp_cuda_device(&err))) fail(&err);
    tiny = strstr(ffp_cuda_describe(), "emulated") != NULL;
    printf("%s\n", ffp_cuda_describe());
    snprintf(preset, sizeof preset, "\"%s\"", argc > 1 ? argv[1] : "small");
    time_training(preset);
    time_drawing();
    time_losses();
    time_products();
    return 0;
}
