// Drawing with gradients, and what other programs need to train and fit with this renderer and network.
#ifndef FFPROCAMS_GRADIENTS_H
#define FFPROCAMS_GRADIENTS_H

#include <stdbool.h>
#include <stdint.h>
#include "ffprocams/render.h"

#ifdef __cplusplus
extern "C" {
#endif

// --- Drawing with gradients. ---

// Views of one set of Gaussians under the same patterns, drawn together: each is rasterised once, whatever
// the number of patterns, and several are worked on at the same time. All arrays are the caller's.
typedef struct FfpRenderBatch {
    // Checked as by ffp_gaussians_from_arrays, but rotations may have any length other than 0. Not copied:
    // the arrays must stay unchanged until the last ffp_renderer_backward for this drawing.
    FfpGaussianArrays gaussians;
    int n_views;                            // 1 to 65536
    const FfpPinhole *cameras, *projectors; // [n_views]; all cameras of one size, all projectors of one size
    int n_patterns;                         // up to 4096; 0: for maps alone
    // [n_patterns] of the projectors' size; data NULL: dark. Floats may be of any size and sign.
    const FfpPicture *patterns;
    bool same_patterns; // those of the renderer's last ffp_renderer_forward; `patterns` is ignored
    double intensity[3];
    bool linear;    // pictures are linear radiance over black, not clipped; otherwise sRGB-encoded in [0,1]
    bool gradients; // ffp_renderer_backward may follow: what it needs is kept
    FFP_RESERVED;
} FfpRenderBatch;
// Draws pictures [n_views,n_patterns,height,width,3], `count` numbers (0 without patterns), and the first
// `n_maps` of the maps [n_views,height,width,channels], indexed by FfpMap, where not NULL, F32. The view of
// ffp_renderer_aim is unaffected. If the call fails, the contents of pictures and maps are undefined, and
// there is no drawing for ffp_renderer_backward.
FFP_API bool ffp_renderer_forward(FfpContext *context, FfpRenderer *renderer, const FfpRenderBatch *batch,
                                  float *pictures, size_t count, float *const *maps, int n_maps,
                                  FfpError *err);

// Gradients of a loss, in the caller's arrays, which they replace; NULL: not wanted. Gaussians: with respect
// to the numbers as given, rotations of any length. `count` is ignored. Poses: with respect to xi in exp(xi)
// pose at xi = 0 (se(3), perturbed from the left): translation x y z (world units), rotation x y z (radians).
typedef struct FfpRenderGradients {
    FfpGaussianArrays gaussians;
    // [n_patterns,height,width,3] with respect to linear light, premultiplied by alpha, whatever the pixels'
    // type and channels; 0 where a pattern is dark.
    float *patterns;
    double *intensity;                        // [3]
    double *cameras, *projectors;             // [n_views,6]
    double *camera_focals, *projector_focals; // [n_views,2]: fx, fy
    FFP_RESERVED;
} FfpRenderGradients;
// From the gradients of the pictures and maps of the last ffp_renderer_forward (which must have announced
// them; arrays of the shapes that it fills, NULL where there are none, maps that it was not asked for among
// them) to those of everything that was drawn from. May be called again.
//
// Constants of the backward pass: how much light a point gets past what stands in its way (shadows), and
// whether it is inside the pattern; the size of a pixel's footprint in the pattern; the order of the splats,
// which of them a pixel sees, and the side from which a normal is seen; which axis of a splat is its
// shortest; whether a map's pixel has a surface; in the form of GS-ProCams, the distance of the light.
// Gradients of pixels that are clipped (encoded pictures only) are 0.
FFP_API bool ffp_renderer_backward(FfpContext *context, FfpRenderer *renderer, const float *pictures,
                                   size_t count, const float *const *maps, int n_maps,
                                   const FfpRenderGradients *out, FfpError *err);

// --- For training and fitting in other programs. ---

// A model's configuration (docs/reference/formats/weights.md, "Weights").
typedef struct FfpModelForm {
    const char *modules; // one letter per block: M = Mamba2, T = Transformer
    int dim, patch, state, chunk, pixel_features, pixel_hidden;
    bool residual, match_input, pixel_skip, context_inputs, appearance_cnn;
    int looks; // rounds in which the input views are drawn and the splats corrected
    FFP_RESERVED;
} FfpModelForm;
FFP_API FfpModelForm ffp_model_form(const FfpModel *model);
// The weights by number, from 0 to one less than the count, in the file's order. They are the model's own
// memory and may be written to between calls; the caller answers for finite numbers.
typedef struct FfpWeights {
    const char *name;
    int64_t rows, columns; // columns 0: a vector
    float *values;         // [rows,columns]
    FFP_RESERVED;
} FfpWeights;
FFP_API int ffp_model_weights_count(const FfpModel *model);
FFP_API FfpWeights ffp_model_weights(FfpModel *model, int number); // all 0: no such number
// Writes safetensors that ffp_model_open reads; `exact`: matrices in F32, not in bf16. The file's record of
// its training is kept.
FFP_API bool ffp_model_save(FfpContext *context, const FfpModel *model, const char *path, bool exact,
                            FfpError *err);
// The contents of that file, *size bytes (required; release with ffp_free); NULL on failure.
FFP_API void *ffp_model_bytes(FfpContext *context, const FfpModel *model, bool exact, size_t *size,
                              FfpError *err);

// The network's inputs, made from a capture. All arrays are the handle's.
typedef struct FfpPrepared FfpPrepared;
typedef struct FfpPreparedArrays {
    int tokens, token_width;   // token_width: a patch's pixels times `channels` of the inputs
    int64_t count;             // Gaussians, one for each pixel that gets one
    int taps;                  // rows of the map of features that each of them takes
    int raw_width, seen_width; // a Gaussian's raw numbers; its inputs to a look, 0: the model has none
    int n_used, channels;      // tokens that a Gaussian needs; a pixel's own inputs, 0: none
    const float *inputs;       // [tokens,token_width]
    const int32_t *used;       // [n_used] those tokens; the map of features is theirs, a row for each pixel
    const int32_t *row;        // [count,taps] in that map
    const float *weight;       // [count,taps] of the rows, sum 1
    const float *own;          // [count,channels]; NULL: none
    const float *context; // [count,2] what tells a pixel from the tokens' pixels; NULL: they are the same
    // [count,FFP_PREPARED_BASE] what the heads start from, in the capture's bounding sphere
    // (ffp_capture_bounds) as unit: camera 3, unit ray 3, distance of the ray's point nearest to the centre,
    // footprint; and of the classical initialisation: distance, its logit, logit of the opacity,
    // quaternion 4, logits of albedo 3 and ambient colour 3 (src/engine/network/splat_formula.h).
    const float *base;
    FFP_RESERVED;
} FfpPreparedArrays;
#define FFP_PREPARED_BASE 21
// Works as ffp_reconstruct does up to the network of `options->model`: noise filter, matching, classical
// initialisation; `polish`, `layers`, `drawing` are ignored. Errors: as there; a capture of a whole scene, or
// a model with `appearance_cnn` (FFP_ERROR_UNSUPPORTED).
FFP_API FfpPrepared *ffp_prepare(FfpContext *context, const FfpCapture *capture,
                                 const FfpReconstruction *options, FfpError *err);
FFP_API FfpPreparedArrays ffp_prepared_arrays(const FfpPrepared *prepared);
// A look (FfpModelForm.looks): the input views are drawn with the Gaussians of raw [count,raw_width], the
// heads' numbers before their formulas; seen [count,seen_width] receives what each Gaussian's correction
// follows from (src/engine/network/look_formula.h). Errors: a number that is not finite; a model without
// looks; other counts of Gaussians.
FFP_API bool ffp_prepared_look(FfpContext *context, const FfpPrepared *prepared, int64_t count,
                               const float *raw, float *seen, FfpError *err);
FFP_API void ffp_prepared_close(FfpPrepared *prepared);

// Weights for the perceptual term: LPIPS with AlexNet or SqueezeNet, or VGG16 up to relu2_2 (safetensors,
// docs/reference/formats/weights.md). `contents` as of ffp_gaussians_open.
typedef struct FfpPerceptual FfpPerceptual;
FFP_API FfpPerceptual *ffp_perceptual_open(FfpContext *context, const char *path, const FfpBytes *contents,
                                           FfpError *err);
FFP_API void ffp_perceptual_close(FfpPerceptual *network);

// The loss of sRGB-encoded pictures that all fits here share (FF-ProCams, Eqs. 18, 19):
// l1 mean |P - T| + ssim (1 - mean SSIM(P, T)), SSIM by Wang et al. 2004 with an 11 x 11 Gaussian of
// sigma 1.5 and zero padding; and perceptual times the mean distance that `network` finds: LPIPS, or for
// VGG16 the squared distance of features at relu1_2 and relu2_2.
typedef struct FfpPictureLoss {
    int count, width, height; // at least 1
    const float *pictures;    // [count,height,width,3] in [0,1]
    const float *targets;     // likewise
    double l1, ssim;          // weights
    // [count,height,width,3] with respect to `pictures`, replaced, memory of its own; NULL: not wanted.
    float *gradients;
    double perceptual;            // weight; 0: none
    const FfpPerceptual *network; // of pictures of at least 31 x 31 (AlexNet), 17 x 17 or 2 x 2 pixels
    FFP_RESERVED;
} FfpPictureLoss;
FFP_API bool ffp_picture_loss(FfpContext *context, const FfpPictureLoss *pictures, double *loss,
                              FfpError *err);

#ifdef __cplusplus
}
#endif

#endif
