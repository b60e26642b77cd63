// Architectures: AlexNet (Krizhevsky 2014), SqueezeNet 1.1 (Iandola et al. 2016), VGG16 (Simonyan, Zisserman
// 2015), as far as LPIPS v0.1 (Zhang et al. 2018) or relu2_2 needs them; then their forward and backward
// walk.
#include "engine/loss/perceptual_net.h"
#include <assert.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include "core/base/arena.h"
#include "core/base/call.h"
#include "engine/loss/table.h"

static int add_slot(FfpPerceptual *net, int channels) {
    assert(net->slot_count < FFP_PERCEPTUAL_SLOTS);
    net->channels[net->slot_count] = channels;
    return net->slot_count++;
}

static FfpLayer *add_layer(FfpPerceptual *net, int from, int to) {
    assert(net->layer_count < FFP_PERCEPTUAL_LAYERS);
    FfpLayer *layer = &net->layers[net->layer_count++];
    layer->from = from;
    layer->to = to;
    layer->in = net->channels[from];
    return layer;
}

// Writes channels [channel, channel + out) of slot `to`.
static void add_conv_into(FfpPerceptual *net, int from, int to, int channel, const char *name, int out,
                          int kernel, int stride, int pad) {
    FfpLayer *layer = add_layer(net, from, to);
    snprintf(layer->name, sizeof layer->name, "%s", name);
    layer->channel = channel;
    layer->out = out;
    layer->kernel = kernel;
    layer->stride = stride;
    layer->pad = pad;
    layer->weight = ffp_alloc((size_t)out * layer->in * kernel * kernel, sizeof *layer->weight);
    layer->bias = ffp_alloc(out, sizeof *layer->bias);
}

static int add_conv(FfpPerceptual *net, int from, const char *name, int out, int kernel, int stride,
                    int pad) {
    const int to = add_slot(net, out);
    add_conv_into(net, from, to, 0, name, out, kernel, stride, pad);
    return to;
}

static int add_pool(FfpPerceptual *net, int from, int kernel, bool round_up) {
    const int to = add_slot(net, net->channels[from]);
    FfpLayer *layer = add_layer(net, from, to);
    layer->is_pool = true;
    layer->out = layer->in;
    layer->kernel = kernel;
    layer->stride = 2;
    layer->round_up = round_up;
    return to;
}

// SqueezeNet's module: 1x1 down to `squeeze` channels, then 1x1 and 3x3 up to `expand` channels each, side by
// side.
static int add_fire(FfpPerceptual *net, int from, int index, int squeeze, int expand) {
    char name[40];
    snprintf(name, sizeof name, "features.%d.squeeze", index);
    const int middle = add_conv(net, from, name, squeeze, 1, 1, 0), to = add_slot(net, 2 * expand);
    snprintf(name, sizeof name, "features.%d.expand1x1", index);
    add_conv_into(net, middle, to, 0, name, expand, 1, 1, 0);
    snprintf(name, sizeof name, "features.%d.expand3x3", index);
    add_conv_into(net, middle, to, expand, name, expand, 3, 1, 1);
    return to;
}

static void add_tap(FfpPerceptual *net, int slot) {
    assert(net->tap_count < FFP_PERCEPTUAL_TAPS);
    FfpTap *tap = &net->taps[net->tap_count++];
    tap->slot = slot;
    if (net->kind != FFP_PERCEPTUAL_VGG16) tap->head = ffp_alloc(net->channels[slot], sizeof *tap->head);
}

static void build_alex(FfpPerceptual *net, int slot) {
    add_tap(net, slot = add_conv(net, slot, "features.0", 64, 11, 4, 2));
    slot = add_pool(net, slot, 3, false);
    add_tap(net, slot = add_conv(net, slot, "features.3", 192, 5, 1, 2));
    slot = add_pool(net, slot, 3, false);
    add_tap(net, slot = add_conv(net, slot, "features.6", 384, 3, 1, 1));
    add_tap(net, slot = add_conv(net, slot, "features.8", 256, 3, 1, 1));
    add_tap(net, add_conv(net, slot, "features.10", 256, 3, 1, 1));
}

static void build_squeeze(FfpPerceptual *net, int slot) {
    add_tap(net, slot = add_conv(net, slot, "features.0", 64, 3, 2, 0));
    slot = add_pool(net, slot, 3, true);
    slot = add_fire(net, slot, 3, 16, 64);
    add_tap(net, slot = add_fire(net, slot, 4, 16, 64));
    slot = add_pool(net, slot, 3, true);
    slot = add_fire(net, slot, 6, 32, 128);
    add_tap(net, slot = add_fire(net, slot, 7, 32, 128));
    slot = add_pool(net, slot, 3, true);
    add_tap(net, slot = add_fire(net, slot, 9, 48, 192));
    add_tap(net, slot = add_fire(net, slot, 10, 48, 192));
    add_tap(net, slot = add_fire(net, slot, 11, 64, 256));
    add_tap(net, add_fire(net, slot, 12, 64, 256));
}

static void build_vgg16(FfpPerceptual *net, int slot) {
    slot = add_conv(net, slot, "features.0", 64, 3, 1, 1);
    add_tap(net, slot = add_conv(net, slot, "features.2", 64, 3, 1, 1));
    slot = add_pool(net, slot, 2, false);
    slot = add_conv(net, slot, "features.5", 128, 3, 1, 1);
    add_tap(net, add_conv(net, slot, "features.7", 128, 3, 1, 1));
}

// LPIPS takes ((2 x - 1) - shift) / scale, VGG16 (x - mean) / deviation with ImageNet's values.
static void set_input(FfpPerceptual *net) {
    static const real shift[3] = {-0.030F, -0.088F, -0.188F}, scale[3] = {0.458F, 0.448F, 0.450F};
    static const real mean[3] = {0.485F, 0.456F, 0.406F}, deviation[3] = {0.229F, 0.224F, 0.225F};
    for (int c = 0; c < 3; c++) {
        const bool vgg = net->kind == FFP_PERCEPTUAL_VGG16;
        net->gain[c] = vgg ? 1 / deviation[c] : 2 / scale[c];
        net->offset[c] = vgg ? -mean[c] / deviation[c] : -(1 + shift[c]) / scale[c];
    }
}

FfpPerceptual *ffp_perceptual_new(FfpPerceptualKind kind) {
    FfpPerceptual *net = ffp_alloc(1, sizeof *net);
    net->kind = kind;
    net->copy = ffp_alloc(1, sizeof *net->copy);
    set_input(net);
    const int input = add_slot(net, 3);
    switch (kind) {
    case FFP_PERCEPTUAL_ALEX:
        build_alex(net, input);
        break;
    case FFP_PERCEPTUAL_SQUEEZE:
        build_squeeze(net, input);
        break;
    case FFP_PERCEPTUAL_VGG16:
        build_vgg16(net, input);
        break;
    }
    return net;
}

void ffp_perceptual_free(FfpPerceptual *net) {
    if (!net) return;
    ffp_disown(net->copy->weights);
    if (net->copy->weights) net->copy->device->loss->perceptual_release(net->copy->weights);
    ffp_free(net->copy);
    for (int i = 0; i < net->layer_count; i++) {
        ffp_free(net->layers[i].weight);
        ffp_free(net->layers[i].bias);
    }
    for (int i = 0; i < net->tap_count; i++) ffp_free(net->taps[i].head);
    ffp_free(net);
}

static int side_after(const FfpLayer *layer, int side) {
    return layer->is_pool ? ffp_pool_side(side, layer->kernel, layer->stride, layer->round_up)
                          : ffp_conv_side(side, layer->kernel, layer->stride, layer->pad);
}

bool ffp_features_plan(FfpFeatures *features, const FfpPerceptual *net, int width, int height) {
    *features = (FfpFeatures){.width = {width}, .height = {height}};
    if (width < 1 || height < 1) return false;
    for (int i = 0; i < net->layer_count; i++) {
        const FfpLayer *layer = &net->layers[i];
        features->width[layer->to] = side_after(layer, features->width[layer->from]);
        features->height[layer->to] = side_after(layer, features->height[layer->from]);
        if (features->width[layer->to] < 1 || features->height[layer->to] < 1) return false;
    }
    for (int s = 0; s < net->slot_count; s++)
        features->size[s] = (size_t)net->channels[s] * features->width[s] * features->height[s];
    return true;
}

static void to_planes(real *planes, const FfpPerceptual *net, const FfpImage *image) {
    const size_t pixels = (size_t)image->width * image->height;
    for (int c = 0; c < 3; c++)
        for (size_t i = 0; i < pixels; i++)
            planes[c * pixels + i] = net->gain[c] * image->data[i * image->channels + c] + net->offset[c];
}

static FfpConv conv_of(const FfpLayer *layer, const FfpFeatures *features) {
    return (FfpConv){.in = layer->in,
                     .out = layer->out,
                     .kernel = layer->kernel,
                     .stride = layer->stride,
                     .pad = layer->pad,
                     .width = features->width[layer->from],
                     .height = features->height[layer->from]};
}

static FfpPool pool_of(const FfpLayer *layer, const FfpFeatures *features, int images) {
    return (FfpPool){.channels = layer->in * images,
                     .kernel = layer->kernel,
                     .stride = layer->stride,
                     .round_up = layer->round_up,
                     .width = features->width[layer->from],
                     .height = features->height[layer->from]};
}

// Where a layer's own channels begin inside an image of its slot `to`.
static size_t start_of(const FfpLayer *layer, const FfpFeatures *features) {
    return (size_t)layer->channel * features->width[layer->to] * features->height[layer->to];
}

void ffp_features_forward(FfpFeatures *features, const FfpPerceptual *net, const FfpImage *a,
                          const FfpImage *b) {
    for (int s = 0; s < net->slot_count; s++)
        features->value[s] = ffp_alloc(2 * features->size[s], sizeof(real));
    to_planes(features->value[0], net, a);
    to_planes(features->value[0] + features->size[0], net, b);
    for (int i = 0; i < net->layer_count; i++) {
        const FfpLayer *layer = &net->layers[i];
        const real *from = features->value[layer->from];
        real *to = features->value[layer->to];
        if (layer->is_pool) {
            const FfpPool pool = pool_of(layer, features, 2);
            ffp_maxpool_forward(to, from, &pool);
        } else {
            const FfpConv conv = conv_of(layer, features);
            ffp_conv2d_forward(to + start_of(layer, features), features->size[layer->to], from,
                               features->size[layer->from], layer->weight, layer->bias, &conv, 2);
        }
    }
}

void ffp_features_new_gradient(FfpFeatures *features, const FfpPerceptual *net) {
    for (int s = 0; s < net->slot_count; s++) features->grad[s] = ffp_alloc(features->size[s], sizeof(real));
}

void ffp_features_backward(FfpFeatures *features, const FfpPerceptual *net, FfpImage *grad) {
    for (int i = net->layer_count - 1; i >= 0; i--) {
        const FfpLayer *layer = &net->layers[i];
        real *dx = features->grad[layer->from], *dy = features->grad[layer->to];
        if (layer->is_pool) {
            const FfpPool pool = pool_of(layer, features, 1);
            ffp_maxpool_backward(dx, dy, features->value[layer->from], &pool);
        } else {
            const FfpConv conv = conv_of(layer, features);
            const size_t start = start_of(layer, features);
            ffp_conv2d_backward(dx, dy + start, features->value[layer->to] + start, layer->weight, &conv);
        }
    }
    const size_t pixels = (size_t)grad->width * grad->height;
    for (size_t i = 0; i < pixels; i++)
        for (int c = 0; c < 3; c++)
            grad->data[i * grad->channels + c] += net->gain[c] * features->grad[0][c * pixels + i];
}

void ffp_features_free(FfpFeatures *features) {
    for (int s = 0; s < FFP_PERCEPTUAL_SLOTS; s++) {
        ffp_free(features->value[s]);
        ffp_free(features->grad[s]);
        features->value[s] = features->grad[s] = NULL;
    }
}
