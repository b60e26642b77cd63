// Times of the polish on the GPU: its own kernels, and whole steps, at training's sizes. With an argument, or
// on the emulation, at tiny ones.
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include "bench/gpu_timing.h"
#include "core/capture/uploaded.h"
#include "engine/refine/fit.h"
#include "engine/refine/table.h"
#include "tests/ball.h"

struct Bench {
    FfpCapture capture;
    FfpGaussians start, decoded, grad; // on the device
    FfpParameters parameters;
    FfpGaussianAdam mover;
    FfpRefineSettings settings;
};

static void clear(Bench *b) {
    ffp_device()->refine->clear(&b->grad);
}
static void encode(Bench *b) {
    ffp_device()->refine->encode(&b->start, true, &b->parameters);
}
static void decode(Bench *b) {
    ffp_parameters_decode(&b->parameters, &b->decoded);
}
static void pull_back(Bench *b) {
    ffp_parameters_pull_back(&b->parameters, &b->decoded, &b->grad);
}
static void move(Bench *b) {
    ffp_gaussian_adam_step(&b->mover, &b->parameters, &b->grad, &b->settings, 0.5);
}
static void summed(Bench *b) {
    FfpSummed table = ffp_pattern_summed(&b->capture.patterns[BALL_STRIPES].image);
    ffp_summed_free(&table);
}

static void fit(Bench *b) {
    FfpRefineResult result;
    FfpError err = {0};
    FfpGaussians g = ffp_gaussians_copy(&b->start);
    if (!ffp_refine(&g, &b->capture, ball_patterns, BALL_PATTERNS, &b->settings, &result, &err)) {
        fprintf(stderr, "%s\n", err.text);
        exit(1);
    }
    ffp_gaussians_free(&g);
}

static void parts(Bench *b) {
    const double set = 18.0 * sizeof(real) * (double)b->start.count, own = 8.0 / 18 * set;
    const FfpImage *pattern = &b->capture.patterns[BALL_STRIPES].image;
    gpu_report_run("clear", b, clear, 20, set);
    gpu_report_run("encode", b, encode, 20, 2 * set + own);
    gpu_report_run("decode", b, decode, 20, 2 * set + own);
    gpu_report_run("pull back", b, pull_back, 20, 3 * set + own);
    gpu_report_run("move", b, move, 20, 8 * set);
    gpu_report_run("summed areas", b, summed, 20, pattern->width * pattern->height * 3 * (4.0 + 3 * 8));
}

static void whole(Bench *b) {
    char name[64];
    if (!ffp_device()->render || !ffp_device()->loss) return;
    snprintf(name, sizeof name, "a fit of %lld steps", (long long)b->settings.steps);
    gpu_report_run(name, b, fit, 1, 0);
}

int main(int argc, char **argv) {
    const FfpDevice *device = gpu_open();
    if (!device) return 1;
    const bool tiny = argc > 1 || gpu_emulated();
    const int64_t count = tiny ? 300 : 45000;
    const int views = tiny ? 2 : 8, side = tiny ? 24 : 128, pattern = tiny ? 32 : 256;
    (void)argv;
    Bench b = {.settings = ffp_polish_defaults(tiny ? 2 : 24)};
    b.settings.quiet = true;
    ffp_device_use(NULL); // the scene is made by the CPU
    FfpCapture capture = ball_capture(count, views, side, side, pattern);
    FfpGaussians start = ball_disturbed(count);
    ffp_device_use(device);
    b.capture = ffp_capture_uploaded(&capture);
    b.start = ffp_gaussians_uploaded(&start);
    b.decoded = ffp_gaussians_new(count);
    b.grad = ffp_gaussians_new(count);
    b.parameters = ffp_parameters_new(&b.start, true, false);
    b.mover = ffp_gaussian_adam_new(&b.parameters, &b.settings);
    printf("%s\n%lld splats, %d views of %dx%d, patterns of %dx%d\n", ffp_cuda_describe(), (long long)count,
           views, side, side, pattern, pattern);
    parts(&b);
    whole(&b);
    return 0;
}
