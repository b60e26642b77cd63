// Times of the losses on the GPU: values and gradients of pictures and maps of 128x128 and 256x256. With an
// argument, or on the emulation, of tiny ones.
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include "bench/gpu_timing.h"
#include "core/base/arena.h"
#include "core/base/rng.h"
#include "engine/loss/metrics.h"
#include "engine/loss/perceptual_net.h"

struct Bench {
    int side;
    FfpImage a, b, grad;                        // on the device, as all below
    real *opacity, *mask, *depth, *truth, *map; // maps; map [side,side,3]
    FfpPerceptual *net;
};

static void report(const char *name, Bench *b, void (*run)(Bench *), int times, double work) {
    gpu_report(name, gpu_seconds(run, b, times), 0, work);
}

static void l1(Bench *b) {
    ffp_l1_loss(&b->a, &b->b, 1, &b->grad);
}
static void ssim(Bench *b) {
    ffp_ssim(&b->a, &b->b);
}
static void ssim_loss(Bench *b) {
    ffp_ssim_loss(&b->a, &b->b, 1, &b->grad);
}
static void psnr(Bench *b) {
    ffp_psnr(&b->a, &b->b);
}
static void to_srgb(Bench *b) {
    ffp_image_to_srgb(&b->grad);
}
static void mask(Bench *b) {
    ffp_mask_loss(b->opacity, b->mask, b->side * b->side, 1, b->grad.data);
}
static void depth(Bench *b) {
    ffp_depth_loss(b->depth, b->opacity, b->truth, b->side * b->side, 1, b->grad.data, b->grad.data);
}
static void distortion(Bench *b) {
    ffp_distortion_loss(b->depth, b->side * b->side, 1, b->grad.data);
}
static void normal_smooth(Bench *b) {
    ffp_normal_smooth_loss(b->map, b->mask, b->side, b->side, 1, b->grad.data);
}
static void roughness(Bench *b) {
    ffp_roughness_loss(b->depth, b->map, b->opacity, b->mask, b->side, b->side, 1, b->grad.data,
                       b->grad.data);
}
static void perceptual(Bench *b) {
    ffp_perceptual_loss(b->net, &b->a, &b->b, 1, NULL);
}
static void perceptual_gradient(Bench *b) {
    ffp_perceptual_loss(b->net, &b->a, &b->b, 1, &b->grad);
}

static real *random_there(size_t count, uint64_t seed, float low, float high) {
    FfpRng rng = ffp_rng(seed, 0);
    real *values = ffp_alloc(count, sizeof *values);
    for (size_t i = 0; i < count; i++) values[i] = ffp_rng_range(&rng, low, high);
    real *there = ffp_memory_uploaded(values, count, sizeof *values);
    ffp_free(values);
    return there;
}

static FfpPerceptual *random_network(FfpPerceptualKind kind) {
    FfpPerceptual *net = ffp_perceptual_new(kind);
    FfpRng rng = ffp_rng(5, kind);
    for (int i = 0; i < net->layer_count; i++) {
        const FfpLayer *layer = &net->layers[i];
        const int fan = layer->in * layer->kernel * layer->kernel;
        for (int k = 0; !layer->is_pool && k < fan * layer->out; k++)
            layer->weight[k] = ffp_rng_range(&rng, -2, 2) / (real)fan;
    }
    return net;
}

// Operations of the products for one picture: a multiply-add is two.
static double operations(const FfpPerceptual *net, int side) {
    FfpFeatures features;
    double sum = 0;
    if (!ffp_features_plan(&features, net, side, side)) return 0;
    for (int i = 0; i < net->layer_count; i++) {
        const FfpLayer *layer = &net->layers[i];
        if (layer->is_pool) continue;
        sum += 2.0 * layer->in * layer->kernel * layer->kernel * layer->out * features.width[layer->to] *
               features.height[layer->to];
    }
    return sum;
}

static void networks(Bench *b) {
    const char *names[] = {"AlexNet", "SqueezeNet", "VGG16"};
    for (int kind = FFP_PERCEPTUAL_ALEX; kind <= FFP_PERCEPTUAL_VGG16; kind++) {
        char name[64];
        b->net = random_network(kind);
        const double work = operations(b->net, b->side);
        snprintf(name, sizeof name, "%s", names[kind]);
        report(name, b, perceptual, 5, 2 * work);
        snprintf(name, sizeof name, "%s and gradient", names[kind]);
        report(name, b, perceptual_gradient, 5, 3 * work);
        ffp_perceptual_free(b->net);
    }
}

static void measure(int side) {
    const size_t pixels = (size_t)side * side;
    Bench b = {.side = side,
               .a = {side, side, 3, random_there(3 * pixels, 1, 0, 1)},
               .b = {side, side, 3, random_there(3 * pixels, 2, 0, 1)},
               .grad = {side, side, 3, random_there(3 * pixels, 3, 0, 1)},
               .opacity = random_there(pixels, 4, 0, 1),
               .mask = random_there(pixels, 5, 0, 1),
               .depth = random_there(pixels, 6, 1, 2),
               .truth = random_there(pixels, 7, -1, 2),
               .map = random_there(3 * pixels, 8, -1, 1)};
    printf("%dx%d\n", side, side);
    report("L1", &b, l1, 20, 0);
    report("SSIM", &b, ssim, 20, 0);
    report("SSIM and gradient", &b, ssim_loss, 20, 0);
    report("PSNR", &b, psnr, 20, 0);
    report("to sRGB", &b, to_srgb, 20, 0);
    report("mask", &b, mask, 20, 0);
    report("depth", &b, depth, 20, 0);
    report("distortion", &b, distortion, 20, 0);
    report("normal smoothness", &b, normal_smooth, 20, 0);
    report("roughness", &b, roughness, 20, 0);
    networks(&b);
    real *all[] = {b.a.data, b.b.data, b.grad.data, b.opacity, b.mask, b.depth, b.truth, b.map};
    for (size_t i = 0; i < sizeof all / sizeof *all; i++) ffp_memory_free(all[i]);
}

int main(int argc, char **argv) {
    if (!gpu_open()) return 1;
    (void)argv;
    printf("%s\n", ffp_cuda_describe());
    if (argc > 1 || gpu_emulated()) {
        measure(33);
    } else {
        measure(128);
        measure(256);
    }
    return 0;
}
