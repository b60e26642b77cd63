// The perceptual networks as data: a list of layers between numbered slots of activations. Private to this
// room and its kernels; the tests build networks without a file through it.
#ifndef FFP_LOSS_PERCEPTUAL_NET_H
#define FFP_LOSS_PERCEPTUAL_NET_H

#include <stdbool.h>
#include <stddef.h>
#include "core/base/device.h"
#include "core/base/real.h"
#include "core/image/image.h"
#include "engine/loss/conv.h"
#include "engine/loss/loss.h"

enum { FFP_PERCEPTUAL_LAYERS = 28, FFP_PERCEPTUAL_SLOTS = 24, FFP_PERCEPTUAL_TAPS = 7 };

typedef enum FfpPerceptualKind {
    FFP_PERCEPTUAL_ALEX,
    FFP_PERCEPTUAL_SQUEEZE,
    FFP_PERCEPTUAL_VGG16
} FfpPerceptualKind;

typedef struct FfpLayer {
    bool is_pool;  // max pooling; otherwise convolution + ReLU
    char name[40]; // tensors "<name>.weight", "<name>.bias"; empty for a pool
    int from, to;  // slots
    int channel;   // first channel of `to` written: two layers with one `to` are a concatenation
    int in, out, kernel, stride, pad;
    bool round_up;       // pools, see FfpPool
    real *weight, *bias; // [out, in, kernel, kernel], [out]; owned
} FfpLayer;

typedef struct FfpTap { // where features are compared
    int slot;
    real *head; // LPIPS: [channels] weights of the squared differences; owned; NULL for VGG16
} FfpTap;

// The weights on the device that worked with them last; none at first.
typedef struct FfpPerceptualCopy {
    const FfpDevice *device;
    void *weights;
} FfpPerceptualCopy;

struct FfpPerceptual {
    FfpPerceptualKind kind;
    real gain[3], offset[3]; // network input = gain * encoded colour + offset
    int layer_count, slot_count, tap_count;
    FfpLayer layers[FFP_PERCEPTUAL_LAYERS];
    int channels[FFP_PERCEPTUAL_SLOTS]; // slot 0 is the input
    FfpTap taps[FFP_PERCEPTUAL_TAPS];
    FfpPerceptualCopy *copy; // owned
};

// The architecture with all weights zero. Freed by ffp_perceptual_free.
FfpPerceptual *ffp_perceptual_new(FfpPerceptualKind kind);

// Activations of a pair of images, and the gradient of the first one's.
typedef struct FfpFeatures {
    int width[FFP_PERCEPTUAL_SLOTS], height[FFP_PERCEPTUAL_SLOTS];
    size_t size[FFP_PERCEPTUAL_SLOTS]; // channels * height * width
    real *value[FFP_PERCEPTUAL_SLOTS]; // [2, channels, height, width]
    real *grad[FFP_PERCEPTUAL_SLOTS];  // [channels, height, width]; NULL without backward
} FfpFeatures;

// Sides of every slot for an input size; false when the picture is too small for the network.
bool ffp_features_plan(FfpFeatures *features, const FfpPerceptual *net, int width, int height);
void ffp_features_forward(FfpFeatures *features, const FfpPerceptual *net, const FfpImage *a,
                          const FfpImage *b);
void ffp_features_new_gradient(FfpFeatures *features, const FfpPerceptual *net); // zeroed
// From the gradients at the taps' slots down to the image: ADDS to grad.
void ffp_features_backward(FfpFeatures *features, const FfpPerceptual *net, FfpImage *grad);
void ffp_features_free(FfpFeatures *features);

#endif
