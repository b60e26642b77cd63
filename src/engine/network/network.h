// The hybrid Mamba2-Transformer network: captures in, Gaussians out (docs/design/architecture.md, "network").
#ifndef FFP_NETWORK_NETWORK_H
#define FFP_NETWORK_NETWORK_H

#include <stdbool.h>
#include <stdint.h>
#include "core/base/arena.h"
#include "core/base/error.h"
#include "core/base/real.h"
#include "core/capture/capture.h"
#include "core/gaussians/gaussians.h"
#include "engine/match/match.h"

#define FFP_MODULES_MAX 128
#define FFP_LOOKS_MAX 4

typedef struct FfpModelConfig {
    char name[32];                 // "tiny", "small", "paper", ...
    char modules[FFP_MODULES_MAX]; // one letter per block, first to last: M = Mamba2, T = Transformer
                                   // ("MTMTMTMT")
    int dim;                       // token width D
    int patch;                     // pixels per side of a token (8)
    int tokens;       // maximum for 16 views: larger captures are reduced to fit (FfpPixelContext)
    int state, chunk; // Mamba2: state 64, chunk 64 (expand 2, head_dim 64, conv 4 are fixed)
    bool residual;    // heads are residuals around the classical initialisation; otherwise the paper's plain
                      // heads
    bool match_input; // the start's maps are among the input channels
    bool pixel_skip;  // a small MLP per pixel combines the token's features with the pixel's own inputs
    int pixel_features,
        pixel_hidden;    // widths of that MLP: features a pixel takes from its token, hidden units
    bool context_inputs; // and numbers that distinguish it from the context's pixels (inputs.h)
    bool appearance_cnn; // two 3x3 convolutions over the tokens before albedo, roughness and ambient: the
                         // paper's ablation
    int looks;           // rounds in which the input views are drawn and the splats corrected (look.h)
    int look_hidden;     // hidden units of the layers that correct them
    char render[16];     // "ours" or "paper": the form in which the Gaussians are to be drawn,
    int samples;         // and the samples per side of a pixel
} FfpModelConfig;
// "tiny" (D 128, MTMT), "small", "paper-small" (small, but the paper's plain form), "paper". False: no such
// name.
bool ffp_model_preset(FfpModelConfig *config, const char *name);
bool ffp_model_is_paper_form(const FfpModelConfig *config); // how its Gaussians are meant to be drawn
// Checks ranges and letters; error names the field.
bool ffp_model_config_check(const FfpModelConfig *config, const char *where, FfpError *err);

// How ffp_model_new fills a parameter.
typedef enum FfpInit {
    FFP_INIT_ZERO,
    FFP_INIT_ONE,
    FFP_INIT_NORMAL,  // deviation init_scale
    FFP_INIT_UNIFORM, // +- init_scale
    FFP_INIT_DT_BIAS, // inverse softplus of a step size, log-uniform in [1e-3, 1e-1] (Mamba2)
    FFP_INIT_A_LOG,   // log of a rate, uniform in [1, 16] (Mamba2)
} FfpInit;

typedef struct FfpParameter {
    char name[64];
    int rank;
    int64_t shape[2];
    int64_t offset, count; // into FfpModel.values
    bool decay;            // weight decay applies (2-D weights; not dt_bias, a_log, d, gains, biases)
    FfpInit init;
    float init_scale;
} FfpParameter;

typedef struct FfpModel {
    FfpModelConfig config;
    int n_parameters;
    FfpParameter *parameters;
    int64_t count;            // all values
    real *values;             // [count]
    struct FfpLayout *layout; // where each layer finds its parameters
    int metadata_count;       // pairs: the file's description of the training
    char **metadata;          // key, value, key, value, ...
    char *file;               // as the caller named it (ffp_model_open), or NULL
} FfpModel;

FfpModel *ffp_model_new(const FfpModelConfig *config, uint64_t seed, FfpError *err);
// The same without values (NULL; count is set): for checking a file before memory is allocated.
// `where` names the configuration's file in errors.
FfpModel *ffp_model_table(const FfpModelConfig *config, const char *where, FfpError *err);
void ffp_model_free(FfpModel *model);
// Values of `from` for each parameter that has its name and shape there; the others stay as they are.
void ffp_model_take_over(FfpModel *model, const FfpModel *from);
// Weights file: safetensors with the configuration and metadata_count pairs of `metadata` (key, value, key,
// value, ...). Matrices are bf16, or F32 when `exact`; vectors (gains, biases, Mamba2's rates) F32 always.
// Keys "format", "format_version" and "model.*" are reserved.
bool ffp_model_write(const FfpModel *model, const char *path, bool exact, const char *const *metadata,
                     int metadata_count, FfpError *err);
FfpModel *ffp_model_read(const char *path, FfpError *err);

// Seconds of wall clock by kind of work. heads: all after the last block; products: the blocks' matrix
// products; other: norms, convolutions, GELU, sums.
typedef struct FfpProfileTimes {
    double tokenise, scan, attention, products, other, heads;
} FfpProfileTimes;
typedef struct FfpProfile {
    FfpProfileTimes forward, backward;
} FfpProfile;

// One pass over one capture: activations live in the run until the next forward.
typedef struct FfpRun {
    // Blocks keep only their inputs, and are run again for their gradients (Chen et al. 2016, section 4):
    // about a third more work, the memory of two blocks instead of all, the same bits.
    bool recompute;
    int looks;       // of the model's, how many to take at most. A fit begins before any (ffp_run_new: all)
    bool looks_only; // ffp_model_backward gives the gradients of the looks' layers alone
    // Called repeatedly by ffp_model_backward, or NULL: grad_values is complete from `first` on. `first`
    // decreases down to 0.
    void (*ready)(void *user, int64_t first);
    void *ready_user;
    FfpArena *arena;
    FfpProfile *profile;    // NULL, or where every pass ADDS its seconds
    FfpGaussians gaussians; // the output, in the normalised capture's frame
    int64_t *pixel; // [gaussians.count] index of each Gaussian's pixel: (view * height + y) * width + x
    real *t;        // [gaussians.count] distance along the pixel's ray
    struct FfpActivations *activations;
} FfpRun;
// `backward`: ffp_model_backward may follow a forward pass. Without it blocks share their memory.
FfpRun *ffp_run_new(bool backward);
void ffp_run_free(FfpRun *run);
size_t ffp_run_memory(const FfpRun *run); // bytes, the most that its passes have taken

// The source of the tokens: the capture itself or, if its pixels would give more than config->tokens of them
// or its sides are not multiples of the patch, the same views with fewer pixels and their own start.
typedef struct FfpPixelContext {
    FfpCapture capture;      // the input views
    FfpInitialisation start; // all NULL: none
    bool reduced;            // both are the context's own memory
} FfpPixelContext;
// The maximum number of tokens for this many views: config->tokens, and proportionally more for more than 16
// views, whose matches would otherwise be lost.
double ffp_pixel_context_tokens(const FfpModelConfig *config, int views);
// Sides of the context's views: multiples of the patch, their tokens no more than ffp_pixel_context_tokens
// (one a view at least).
void ffp_pixel_context_size(int *width, int *height, const FfpModelConfig *config, const FfpCapture *capture,
                            int views);
// Of the first start->views views (start NULL: of all, without a start), matched with the n patterns, of
// which the network sees the first. `capture` and `start` must outlive it. Errors: pictures smaller than a
// patch; as ffp_initialisation_new.
bool ffp_pixel_context_new(FfpPixelContext *context, const FfpModelConfig *config, const FfpCapture *capture,
                           const FfpInitialisation *start, const int *patterns, int n, FfpError *err);
void ffp_pixel_context_free(FfpPixelContext *context); // safe on {0}

// Normalised capture (any number of views of one size), its start, its context (NULL: made for this pass
// with the active pattern alone), and the active pattern. The first start->views views are the input.
// Residual form: one Gaussian for each pixel of coverage > 0. Plain form: all. Gaussians are in the order of
// their pixels. start may be NULL when the model neither reads its maps nor builds on them: then all views
// are the input. Errors name the view: missing images, sizes that do not fit; or numbers that overflow.
bool ffp_model_forward(const FfpModel *model, FfpRun *run, const FfpCapture *capture,
                       const FfpInitialisation *start, const FfpPixelContext *context, int active,
                       FfpError *err);
// Capture, start and context of the forward pass must still exist. grad: gradient with respect to
// run->gaussians; grad_t [count] or NULL: extra gradient with respect to
// run->t. ADDS to grad_values [model->count].
void ffp_model_backward(const FfpModel *model, FfpRun *run, const FfpGaussians *grad, const real *grad_t,
                        real *grad_values);

// While the thread works on a device (core/base/device.h), a run created there does its passes there:
// model->values, grad_values and the run's Gaussians and distances are in the device's memory; capture, start
// and context are in the host's. The inputs taken from the capture can be prepared once, by the CPU, and
// copied to the device in use for many passes: as ffp_model_forward, and their sources are no longer needed.
// Further errors: appearance_cnn, which no device has.
typedef struct FfpPrepared FfpPrepared;
FfpPrepared *ffp_prepared_new(const FfpModelConfig *config, const FfpCapture *capture,
                              const FfpInitialisation *start, const FfpPixelContext *context, int active,
                              FfpError *err);
FfpPrepared *ffp_prepared_uploaded(const FfpPrepared *prepared);
void ffp_prepared_free(FfpPrepared *prepared);                   // by who works where it is; NULL is allowed
int64_t ffp_prepared_count(const FfpPrepared *prepared);         // Gaussians
const int64_t *ffp_prepared_pixels(const FfpPrepared *prepared); // [count] as FfpRun.pixel; the host's
bool ffp_model_forward_prepared(const FfpModel *model, FfpRun *run, const FfpPrepared *prepared,
                                FfpError *err);
// The same model with its values on the device: they alone are the copy's own, by ffp_memory_free.
FfpModel ffp_model_uploaded(const FfpModel *model);

// The classical reconstruction as Gaussians, without a model: what an untrained residual network returns.
FfpGaussians ffp_initialisation_gaussians(const FfpCapture *capture, const FfpInitialisation *start);
// [their number] the pixel of each, as FfpRun.pixel; release with ffp_free.
int64_t *ffp_initialisation_pixels(const FfpInitialisation *start);

#endif
