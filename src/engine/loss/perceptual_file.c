// Perceptual networks out of safetensors files (docs/reference/formats/weights.md;
// python/ffprocams/perceptual.py writes them).
#include <stdio.h>
#include <tgmath.h>
#include "core/tensor/safetensors.h"
#include "engine/loss/loss.h"
#include "engine/loss/perceptual_net.h"

// Which network a file holds, by what it has and what it lacks.
static bool recognise(FfpPerceptualKind *kind, const FfpSafetensors *file) {
    const bool heads = ffp_safetensors_find(file, "lin0.weight") != NULL;
    if (heads && ffp_safetensors_find(file, "features.3.squeeze.weight"))
        *kind = FFP_PERCEPTUAL_SQUEEZE;
    else if (heads && ffp_safetensors_find(file, "features.3.weight"))
        *kind = FFP_PERCEPTUAL_ALEX;
    else if (!heads && ffp_safetensors_find(file, "features.2.weight"))
        *kind = FFP_PERCEPTUAL_VGG16;
    else
        return false;
    return true;
}

// Copies tensor `name` of exactly this shape into `out`.
static bool fill(real *out, const FfpSafetensors *file, const char *path, const char *name,
                 const int64_t *shape, int rank, FfpError *err) {
    const FfpPlace where = ffp_place(path, name);
    const FfpTensor *tensor = ffp_safetensors_find(file, name);
    if (!tensor) return ffp_fail(err, FFP_ERROR_FILE, where.text, "no such tensor");
    bool same = tensor->rank == rank;
    for (int i = 0; same && i < rank; i++) same = tensor->shape[i] == shape[i];
    if (!same) return ffp_fail(err, FFP_ERROR_FILE, where.text, "tensor of the wrong shape");
    if (!ffp_tensor_to_real(tensor, out))
        return ffp_fail(err, FFP_ERROR_FILE, where.text, "tensor of the wrong type");
    for (int64_t i = 0; i < tensor->count; i++)
        if (!isfinite(out[i]))
            return ffp_fail(err, FFP_ERROR_FILE, where.text, "a weight is not a finite number");
    return true;
}

static bool fill_layer(FfpLayer *layer, const FfpSafetensors *file, const char *path, FfpError *err) {
    char name[FFP_TENSOR_NAME_MAX];
    const int64_t shape[4] = {layer->out, layer->in, layer->kernel, layer->kernel};
    snprintf(name, sizeof name, "%s.weight", layer->name);
    if (!fill(layer->weight, file, path, name, shape, 4, err)) return false;
    snprintf(name, sizeof name, "%s.bias", layer->name);
    return fill(layer->bias, file, path, name, shape, 1, err);
}

static bool fill_network(FfpPerceptual *net, const FfpSafetensors *file, const char *path, FfpError *err) {
    for (int i = 0; i < net->layer_count; i++)
        if (!net->layers[i].is_pool && !fill_layer(&net->layers[i], file, path, err)) return false;
    for (int i = 0; i < net->tap_count; i++) {
        char name[FFP_TENSOR_NAME_MAX];
        const int64_t shape[4] = {1, net->channels[net->taps[i].slot], 1, 1};
        snprintf(name, sizeof name, "lin%d.weight", i);
        if (net->taps[i].head && !fill(net->taps[i].head, file, path, name, shape, 4, err)) return false;
    }
    return true;
}

FfpPerceptual *ffp_perceptual_read(const char *path, FfpError *err) {
    FfpSafetensors file;
    if (!ffp_safetensors_read(&file, path, err)) return NULL;
    FfpPerceptualKind kind;
    FfpPerceptual *net = NULL;
    if (!recognise(&kind, &file))
        ffp_fail(err, FFP_ERROR_FILE, path, "not LPIPS with AlexNet or SqueezeNet, nor VGG16");
    else
        net = ffp_perceptual_new(kind);
    if (net && !fill_network(net, &file, path, err)) {
        ffp_perceptual_free(net);
        net = NULL;
    }
    ffp_safetensors_free(&file);
    return net;
}
