// A model's weights, what the network sees of a capture, and the loss of pictures: for training and fitting
// elsewhere.
#include <string.h>
#include "core/base/call.h"
#include "core/image/image.h"
#include "engine/loss/loss.h"
#include "engine/network/layout.h"
#include "engine/network/prepared.h"
#include "engine/pipeline/reconstruct.h"
#include "product/api/arguments.h"
#include "product/api/source.h"
#include "rig/checks/checks.h"

_Static_assert(sizeof(FfpPixelBase) == FFP_PREPARED_BASE * sizeof(float), "the columns of FfpPreparedArrays");

FfpModelForm ffp_model_form(const FfpModel *model) {
    const FfpModelConfig *c = &model->config;
    return (FfpModelForm){.modules = c->modules,
                          .dim = c->dim,
                          .patch = c->patch,
                          .state = c->state,
                          .chunk = c->chunk,
                          .pixel_features = c->pixel_features,
                          .pixel_hidden = c->pixel_hidden,
                          .residual = c->residual,
                          .match_input = c->match_input,
                          .pixel_skip = c->pixel_skip,
                          .context_inputs = c->context_inputs,
                          .appearance_cnn = c->appearance_cnn,
                          .looks = c->looks};
}

int ffp_model_weights_count(const FfpModel *model) {
    return model->n_parameters;
}

FfpWeights ffp_model_weights(FfpModel *model, int number) {
    if (number < 0 || number >= model->n_parameters) return (FfpWeights){0};
    const FfpParameter *p = &model->parameters[number];
    return (FfpWeights){.name = p->name,
                        .rows = p->shape[0],
                        .columns = p->rank == 2 ? p->shape[1] : 0,
                        .values = model->values + p->offset};
}

typedef struct SaveCall {
    const FfpModel *model;
    const char *path; // NULL: to memory
    bool exact;
    FfpMemoryFile memory;
} SaveCall;

static bool save(void *argument, FfpError *err) {
    SaveCall *call = argument;
    const FfpModel *m = call->model;
    if (!call->path) ffp_memory_file_use(&call->memory);
    const bool ok = ffp_model_write(m, call->path ? call->path : call->memory.path, call->exact,
                                    (const char *const *)m->metadata, m->metadata_count, err);
    ffp_memory_file_use(NULL);
    return ok;
}

bool ffp_model_save(FfpContext *context, const FfpModel *model, const char *path, bool exact, FfpError *err) {
    SaveCall call = {.model = model, .path = path, .exact = exact};
    if (!ffp_need(model, "model", err) || !ffp_need(path, "path", err)) return false;
    return ffp_call_run(context, save, &call, err);
}

void *ffp_model_bytes(FfpContext *context, const FfpModel *model, bool exact, size_t *size, FfpError *err) {
    SaveCall call = {.model = model, .exact = exact, .memory = {.path = "weights"}};
    if (!ffp_need(model, "model", err) || !ffp_need(size, "size", err)) return NULL;
    if (!ffp_call_run(context, save, &call, err)) return NULL;
    *size = call.memory.size;
    return call.memory.written;
}

typedef struct PrepareCall {
    const FfpCapture *capture;
    const FfpReconstruction *options;
    FfpPrepared *prepared;
} PrepareCall;

static bool prepare(void *argument, FfpError *err) {
    PrepareCall *call = argument;
    if (!call->options->force && !ffp_rig_suspect(call->capture, err)) return false;
    call->prepared = ffp_reconstruction_inputs(call->capture, call->options, err);
    return call->prepared != NULL;
}

FfpPrepared *ffp_prepare(FfpContext *context, const FfpCapture *capture, const FfpReconstruction *options,
                         FfpError *err) {
    FfpReconstruction own = ffp_reconstruction_defaults();
    PrepareCall call = {capture, &own, NULL};
    if (!ffp_need_photographs(capture, err) || !ffp_take_options(&own, options, "FfpReconstruction", err) ||
        !ffp_need(own.model, "options.model", err) || !ffp_check_reconstruction(&own, err))
        return NULL;
    return ffp_call_run(context, prepare, &call, err) ? call.prepared : NULL;
}

FfpPreparedArrays ffp_prepared_arrays(const FfpPrepared *p) {
    return (FfpPreparedArrays){.tokens = p->tokens,
                               .token_width = (int)(p->inputs_count / (size_t)p->tokens),
                               .count = p->count,
                               .taps = p->taps.taps,
                               .raw_width = ffp_head_numbers(&p->config),
                               .seen_width =
                                   p->photographs ? FFP_LOOK_SEEN + ffp_head_numbers(&p->config) : 0,
                               .n_used = p->n_used,
                               .channels = p->own ? p->channels : 0,
                               .inputs = p->inputs,
                               .used = p->used,
                               .row = p->taps.row,
                               .weight = p->taps.weight,
                               .own = p->own,
                               .context = p->context_inputs,
                               .base = p->base->origin};
}

typedef struct LookCall {
    const FfpPrepared *prepared;
    const float *raw;
    float *seen;
} LookCall;

static bool look(void *argument, FfpError *err) {
    const LookCall *call = argument;
    return ffp_prepared_seen(call->prepared, call->raw, call->seen, err);
}

bool ffp_prepared_look(FfpContext *context, const FfpPrepared *prepared, int64_t count, const float *raw,
                       float *seen, FfpError *err) {
    LookCall call = {prepared, raw, seen};
    if (!ffp_need(prepared, "prepared", err) || !ffp_need(raw, "raw", err) || !ffp_need(seen, "seen", err))
        return false;
    if (count != prepared->count)
        return ffp_fail(err, FFP_ERROR_ARGUMENT, "count", "%lld Gaussians instead of %lld", (long long)count,
                        (long long)prepared->count);
    return ffp_call_run(context, look, &call, err);
}

void ffp_prepared_close(FfpPrepared *prepared) {
    ffp_prepared_free(prepared);
}

typedef struct PerceptualCall {
    FfpFileSource source;
    FfpPerceptual *network;
} PerceptualCall;

static bool open_perceptual(void *argument, FfpError *err) {
    PerceptualCall *call = argument;
    ffp_source_use(&call->source);
    call->network = ffp_perceptual_read(call->source.path, err);
    ffp_memory_file_use(NULL);
    return call->network != NULL;
}

FfpPerceptual *ffp_perceptual_open(FfpContext *context, const char *path, const FfpBytes *contents,
                                   FfpError *err) {
    PerceptualCall call = {0};
    if (!ffp_source_find(&call.source, path, contents, err) || !ffp_need(call.source.path, "path", err))
        return NULL;
    return ffp_call_run(context, open_perceptual, &call, err) ? call.network : NULL;
}

void ffp_perceptual_close(FfpPerceptual *network) {
    if (network) ffp_perceptual_free(network);
}

typedef struct LossCall {
    const FfpPictureLoss *given;
    double *loss;
} LossCall;

static bool picture_loss(void *argument, FfpError *err) {
    (void)err;
    const LossCall *call = argument;
    const FfpPictureLoss *l = call->given;
    const size_t size = (size_t)l->width * (size_t)l->height * 3;
    const double share = 1 / (double)l->count;
    double sum = 0;
    for (int i = 0; i < l->count; i++) {
        const size_t at = size * (size_t)i;
        const FfpImage picture = {l->width, l->height, 3, (real *)(l->pictures + at)}; // only read
        const FfpImage target = {l->width, l->height, 3, (real *)(l->targets + at)};
        FfpImage gradient = {l->width, l->height, 3, l->gradients ? l->gradients + at : NULL};
        FfpImage *wanted = l->gradients ? &gradient : NULL;
        if (wanted) memset(gradient.data, 0, size * sizeof(real));
        if (l->l1 > 0) sum += (double)ffp_l1_loss(&picture, &target, (real)(share * l->l1), wanted);
        if (l->ssim > 0) sum += (double)ffp_ssim_loss(&picture, &target, (real)(share * l->ssim), wanted);
        if (l->perceptual > 0)
            sum += (double)ffp_perceptual_loss(l->network, &picture, &target, (real)(share * l->perceptual),
                                               wanted);
    }
    *call->loss = sum;
    return true;
}

bool ffp_picture_loss(FfpContext *context, const FfpPictureLoss *pictures, double *loss, FfpError *err) {
    LossCall call = {pictures, loss};
    if (!ffp_need(pictures, "pictures", err) || !ffp_need(loss, "loss", err) ||
        !ffp_need(pictures->pictures, "pictures.pictures", err) ||
        !ffp_need(pictures->targets, "pictures.targets", err))
        return false;
    const int width = pictures->width, height = pictures->height;
    if (pictures->count < 1 || width < 1 || height < 1 || width > FFP_IMAGE_SIDE_MAX ||
        height > FFP_IMAGE_SIDE_MAX)
        return ffp_fail(err, FFP_ERROR_ARGUMENT, "pictures", "%d pictures of %d x %d pixels", pictures->count,
                        width, height);
    if (!(pictures->l1 >= 0 && pictures->l1 <= 1e6 && pictures->ssim >= 0 && pictures->ssim <= 1e6))
        return ffp_fail(err, FFP_ERROR_ARGUMENT, "pictures", "weights %g and %g are not in 0 to 1e6",
                        pictures->l1, pictures->ssim);
    if (!(pictures->perceptual >= 0 && pictures->perceptual <= 1e6))
        return ffp_fail(err, FFP_ERROR_ARGUMENT, "pictures.perceptual", "weight %g is not in 0 to 1e6",
                        pictures->perceptual);
    if (pictures->perceptual > 0) {
        if (!ffp_need(pictures->network, "pictures.network", err)) return false;
        const int least = ffp_perceptual_least_side(pictures->network);
        if (width < least || height < least)
            return ffp_fail(err, FFP_ERROR_ARGUMENT, "pictures",
                            "%d x %d pixels are fewer than the network's %d x %d", width, height, least,
                            least);
    }
    return ffp_call_run(context, picture_loss, &call, err);
}
