// A network of the perceptual term with random weights, for tests: a measure of pictures like any other.
#ifndef FFP_TESTS_RANDOM_PERCEPTUAL_H
#define FFP_TESTS_RANDOM_PERCEPTUAL_H

#include <math.h>
#include "core/base/rng.h"
#include "engine/loss/perceptual_net.h"

static inline void fill_at_random(real *values, size_t count, FfpRng *rng, real low, real high) {
    for (size_t i = 0; i < count; i++) values[i] = ffp_rng_range(rng, low, high);
}

// Weights of the size that keeps activations' variance through a ReLU (He et al. 2015), some bias, positive
// heads.
static inline FfpPerceptual *random_perceptual(FfpPerceptualKind kind) {
    FfpPerceptual *net = ffp_perceptual_new(kind);
    FfpRng rng = ffp_rng(5, kind);
    for (int i = 0; i < net->layer_count; i++) {
        FfpLayer *layer = &net->layers[i];
        if (layer->is_pool) continue;
        const int fan = layer->in * layer->kernel * layer->kernel;
        const real limit = (real)sqrtf(6.0F / (float)fan);
        fill_at_random(layer->weight, (size_t)fan * layer->out, &rng, -limit, limit);
        fill_at_random(layer->bias, layer->out, &rng, -0.1F, 0.1F);
    }
    for (int i = 0; i < net->tap_count; i++)
        if (net->taps[i].head)
            fill_at_random(net->taps[i].head, net->channels[net->taps[i].slot], &rng, 0, 1);
    return net;
}

#endif
