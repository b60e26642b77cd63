// The perceptual networks' walk on the GPU: both pictures go forward together, the prediction's gradient
// comes back. Activations lie in scratch memory that is kept from call to call.
#include "engine/cuda/loss_room.h"
#include "engine/cuda/loss_sums.h"
#include "engine/cuda/memory.h"
#include "engine/cuda/perceptual_taps.h"
extern "C" {
#include "core/base/alloc.h"
#include "engine/cuda/perceptual_conv.h"
#include "engine/loss/perceptual_net.h"
}

enum { IMAGES = 2 };                                // prediction, target
static const size_t COLUMNS_MOST = (size_t)1 << 26; // values of unfolded input at a time: 256 MB

// A network's weights on the device, in one block of memory.
typedef struct Weights {
    float *block;
    float *weight[FFP_PERCEPTUAL_LAYERS];
    float *bias[FFP_PERCEPTUAL_SLOTS]; // of all layers that write a slot; NULL for the input and pools
    float *head[FFP_PERCEPTUAL_TAPS];  // NULL for VGG16
} Weights;

// Cuts parts off a block of memory; with block NULL it only counts.
typedef struct Cutter {
    float *block;
    size_t used;
} Cutter;

static float *cut(Cutter *cutter, size_t count) {
    float *part = cutter->block ? cutter->block + cutter->used : NULL;
    cutter->used += (count + 63) / 64 * 64; // wide loads want their alignment
    return part;
}

static size_t weight_count(const FfpLayer *layer) {
    return (size_t)layer->out * layer->in * layer->kernel * layer->kernel;
}

static void place(Weights *weights, Cutter *cutter, const FfpPerceptual *net) {
    for (int i = 0; i < net->layer_count; i++) {
        const FfpLayer *layer = &net->layers[i];
        if (layer->is_pool) continue;
        weights->weight[i] = cut(cutter, weight_count(layer));
        if (layer->channel == 0) weights->bias[layer->to] = cut(cutter, (size_t)net->channels[layer->to]);
    }
    for (int i = 0; i < net->tap_count; i++)
        if (net->taps[i].head) weights->head[i] = cut(cutter, (size_t)net->channels[net->taps[i].slot]);
}

static void upload(float *to, const float *from, size_t count) {
    ffp_cuda_upload(to, from, count * sizeof *to);
}

void *ffp_cuda_perceptual_upload(const FfpPerceptual *net) {
    Weights *weights = (Weights *)ffp_alloc(1, sizeof *weights);
    Cutter cutter = {NULL, 0};
    place(weights, &cutter, net);
    weights->block = (float *)ffp_cuda_alloc(cutter.used * sizeof(float));
    cutter = Cutter{weights->block, 0};
    place(weights, &cutter, net);
    for (int i = 0; i < net->layer_count; i++) {
        const FfpLayer *layer = &net->layers[i];
        if (layer->is_pool) continue;
        upload(weights->weight[i], layer->weight, weight_count(layer));
        upload(weights->bias[layer->to] + layer->channel, layer->bias, (size_t)layer->out);
    }
    for (int i = 0; i < net->tap_count; i++)
        if (net->taps[i].head)
            upload(weights->head[i], net->taps[i].head, (size_t)net->channels[net->taps[i].slot]);
    return weights;
}

void ffp_cuda_perceptual_release(void *weights) {
    ffp_cuda_release(((Weights *)weights)->block);
    ffp_free(weights);
}

// A walk through the network. features.value: [channels, IMAGES, height, width]; features.grad: the
// prediction's [channels, height, width].
typedef struct Walk {
    const FfpPerceptual *net;
    const Weights *weights;
    FfpFeatures features;
    FfpColumns columns;
    bool has_gradient[FFP_PERCEPTUAL_SLOTS]; // something was written to grad: add to it
} Walk;

static size_t plane_of(const Walk *walk, int slot) {
    return (size_t)walk->features.width[slot] * walk->features.height[slot];
}

static FfpConv conv_of(const Walk *walk, const FfpLayer *layer) {
    return FfpConv{layer->in,
                   layer->out,
                   layer->kernel,
                   layer->stride,
                   layer->pad,
                   walk->features.width[layer->from],
                   walk->features.height[layer->from]};
}

static FfpPool pool_of(const Walk *walk, const FfpLayer *layer) {
    return FfpPool{layer->in,
                   layer->kernel,
                   layer->stride,
                   layer->round_up,
                   walk->features.width[layer->from],
                   walk->features.height[layer->from]};
}

static size_t columns_needed(const Walk *walk) {
    size_t most = 0;
    for (int i = 0; i < walk->net->layer_count; i++) {
        if (walk->net->layers[i].is_pool) continue;
        const FfpConv conv = conv_of(walk, &walk->net->layers[i]);
        const size_t columns = ffp_cuda_columns(&conv, IMAGES);
        if (columns > most) most = columns;
    }
    return most < COLUMNS_MOST ? most : COLUMNS_MOST;
}

static void lay_out(Walk *walk, Cutter *cutter, bool backward) {
    for (int s = 0; s < walk->net->slot_count; s++) {
        walk->features.value[s] = cut(cutter, IMAGES * walk->features.size[s]);
        walk->features.grad[s] = backward ? cut(cutter, walk->features.size[s]) : NULL;
    }
    walk->columns.capacity = columns_needed(walk);
    walk->columns.values = cut(cutter, walk->columns.capacity);
}

static void take_memory(Walk *walk, bool backward) {
    static void *scratch;
    static size_t capacity;
    Cutter cutter = {NULL, 0};
    lay_out(walk, &cutter, backward);
    ffp_cuda_grow(&scratch, &capacity, cutter.used * sizeof(float));
    cutter = Cutter{(float *)scratch, 0};
    lay_out(walk, &cutter, backward);
}

// Gains and offsets of the three colours.
typedef struct Input {
    float gain[3], offset[3];
} Input;

static Input input_of(const FfpPerceptual *net) {
    Input input;
    for (int c = 0; c < 3; c++) {
        input.gain[c] = net->gain[c];
        input.offset[c] = net->offset[c];
    }
    return input;
}

static __global__ void to_planes(size_t pixels, float *planes, const float *a, int channels_a, const float *b,
                                 int channels_b, Input input) {
    const size_t i = ffp_thread();
    if (i >= pixels) return;
    for (int c = 0; c < 3; c++) {
        planes[(IMAGES * c) * pixels + i] = input.gain[c] * a[i * channels_a + c] + input.offset[c];
        planes[(IMAGES * c + 1) * pixels + i] = input.gain[c] * b[i * channels_b + c] + input.offset[c];
    }
}

static __global__ void from_planes(size_t pixels, float *grad, int channels, const float *planes,
                                   Input input) {
    const size_t i = ffp_thread();
    for (int c = 0; c < 3 && i < pixels; c++)
        grad[i * channels + c] += input.gain[c] * planes[c * pixels + i];
}

static void forward(const Walk *walk) {
    const FfpPerceptual *net = walk->net;
    for (int i = 0; i < net->layer_count; i++) {
        const FfpLayer *layer = &net->layers[i];
        const float *from = walk->features.value[layer->from];
        float *to = walk->features.value[layer->to];
        const size_t row = IMAGES * plane_of(walk, layer->to);
        if (layer->is_pool) {
            const FfpPool pool = pool_of(walk, layer);
            ffp_cuda_maxpool_forward(to, from, &pool, IMAGES);
            continue;
        }
        const FfpConv conv = conv_of(walk, layer);
        ffp_cuda_picture_conv_forward(to + layer->channel * row, from, walk->weights->weight[i], &conv,
                                      IMAGES, walk->columns);
        if (i + 1 == net->layer_count || net->layers[i + 1].to != layer->to) // the slot is complete
            ffp_cuda_bias_relu(to, walk->weights->bias[layer->to], net->channels[layer->to], row);
    }
}

// The distance at all taps, to be added up; weight * its gradients to their slots.
static FfpPartials compare(Walk *walk, real weight) {
    const FfpPerceptual *net = walk->net;
    unsigned blocks = 0;
    for (int i = 0; i < net->tap_count; i++)
        blocks += ffp_cuda_tap_blocks((int)plane_of(walk, net->taps[i].slot));
    const FfpPartials sums = ffp_cuda_loss_partials(1, blocks);
    FfpPartials next = sums;
    for (int i = 0; i < net->tap_count; i++) {
        const int slot = net->taps[i].slot;
        const FfpTapPair pair = {walk->features.value[slot], walk->features.grad[slot],
                                 walk->weights->head[i], net->channels[slot], (int)plane_of(walk, slot)};
        ffp_cuda_tap(next, &pair, weight);
        next.partial += ffp_cuda_tap_blocks(pair.pixels);
        walk->has_gradient[slot] = true;
    }
    return sums;
}

static void backward(Walk *walk) {
    const FfpPerceptual *net = walk->net;
    for (int i = net->layer_count - 1; i >= 0; i--) {
        const FfpLayer *layer = &net->layers[i];
        const float *from = walk->features.value[layer->from];
        float *dx = walk->features.grad[layer->from], *dy = walk->features.grad[layer->to];
        const size_t row = plane_of(walk, layer->to);
        const bool add = walk->has_gradient[layer->from];
        walk->has_gradient[layer->from] = true;
        if (layer->is_pool) {
            const FfpPool pool = pool_of(walk, layer);
            ffp_cuda_maxpool_backward(dx, dy, from, &pool, IMAGES, add);
            continue;
        }
        if (i + 1 == net->layer_count || net->layers[i + 1].to != layer->to)
            ffp_cuda_relu_backward(dy, walk->features.value[layer->to], net->channels[layer->to], IMAGES,
                                   row);
        const FfpConv conv = conv_of(walk, layer);
        ffp_cuda_picture_conv_backward(dx, dy + layer->channel * row, walk->weights->weight[i], &conv, add,
                                       walk->columns);
    }
}

real ffp_cuda_perceptual(const FfpPerceptual *net, const void *weights, const FfpImage *prediction,
                         const FfpImage *target, real weight, FfpImage *grad) {
    Walk walk = {net, (const Weights *)weights, {}, {}, {}};
    if (!ffp_features_plan(&walk.features, net, prediction->width, prediction->height)) return 0;
    take_memory(&walk, grad != NULL);
    const size_t pixels = plane_of(&walk, 0);
    ffp_launch_each(pixels, to_planes, walk.features.value[0], prediction->data, prediction->channels,
                    target->data, target->channels, input_of(net));
    forward(&walk);
    const FfpPartials sums = compare(&walk, weight);
    if (grad) {
        backward(&walk);
        ffp_launch_each(pixels, from_planes, grad->data, grad->channels, walk.features.grad[0],
                        input_of(net));
    }
    return (real)ffp_cuda_mean(&sums, true, weight, 1); // asked for when all is queued
}
