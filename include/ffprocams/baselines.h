// Other methods, for comparison: fits to one object's photographs without a prediction. They take far longer
// than ffp_refine_gaussians, whose options and statistics they share. And a figure to compare any method by.
#ifndef FFPROCAMS_BASELINES_H
#define FFPROCAMS_BASELINES_H

#include "ffprocams.h"

#ifdef __cplusplus
extern "C" {
#endif

// Fits Gaussians as GS-ProCams does: points grow, divide and vanish. They are the centres of `points`, at
// least four, or, if that is NULL, drawn in the visual hull (in the form of GS-ProCams in a cube about the
// object). The seed also selects the points that are drawn; the default limit is 20000 steps. Cancelling it
// before there are any points is a failure, FFP_ERROR_CANCELLED. `stats` may be NULL.
FFP_API FfpGaussians *ffp_fit_from_scratch(FfpContext *context, const FfpCapture *capture,
                                           const FfpGaussians *points, const FfpRefinement *options,
                                           FfpRefinementStats *stats, FfpError *err);

// A neural reflectance field in the form of Nepmap: small networks give density, material and the light that
// reaches each point. Only ffp_evaluate draws it.
typedef struct FfpNeuralField FfpNeuralField;
// Fits a field to the capture's pictures. Every view must have a picture under all patterns; `drawing` is
// ignored; the default limit is 300 s. `checkpoint`: a file written every two minutes and at the end, from
// which the same fit resumes if it exists; or NULL. In `stats`, which may be NULL, psnr_before and gaussians
// are 0 and psnr_after covers up to 16 views. If only the number of steps is limited, the same seed gives
// identical bits.
FFP_API FfpNeuralField *ffp_fit_neural_field(FfpContext *context, const FfpCapture *capture,
                                             const FfpRefinement *options, const char *checkpoint,
                                             FfpRefinementStats *stats, FfpError *err);
// A field's file is safetensors (docs/reference/formats/weights.md).
FFP_API FfpNeuralField *ffp_neural_field_open(FfpContext *context, const char *path, FfpError *err);
FFP_API bool ffp_neural_field_save(FfpContext *context, const FfpNeuralField *field, const char *path,
                                   FfpError *err);
FFP_API void ffp_neural_field_close(FfpNeuralField *field);

// LPIPS (Zhang et al. 2018, version 0.1) as in FfpScore, of n pairs of pictures over black, sRGB-encoded:
// distances[i] is that of a[i] and b[i], which have one size; NAN below 31 x 31 pixels (AlexNet) or 17 x 17
// (SqueezeNet). `weights`: safetensors as FfpEvaluation.perceptual. Errors: no weights of LPIPS; other sizes.
FFP_API bool ffp_lpips(FfpContext *context, const char *weights, const FfpPicture *a, const FfpPicture *b,
                       int n, double *distances, FfpError *err);

#ifdef __cplusplus
}
#endif

#endif
