// Weights, the reconstruction, the Gaussians that it gives, and fitting these to the photographs of one
// object.
#ifndef FFPROCAMS_RECONSTRUCT_H
#define FFPROCAMS_RECONSTRUCT_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include "ffprocams/capture.h"

#ifdef __cplusplus
extern "C" {
#endif

// --- Weights. ---

typedef struct FfpModel FfpModel;

// `path` NULL: the shipped weights, small.safetensors. They are searched for in the folder named by the
// environment variable FFPROCAMS_MODELS or, if it is unset, in share/ffprocams/models of the prefix in which
// the library is installed (the program's prefix, if linked statically), in models/ beside it, and in models/
// of the current folder. Errors list the places searched.
// `contents` as of ffp_gaussians_open.
FFP_API FfpModel *ffp_model_open(FfpContext *context, const char *path, const FfpBytes *contents,
                                 FfpError *err);
FFP_API void ffp_model_close(FfpModel *model);

// How Gaussians are drawn: in the form of the shipped model (firm splats, patterns averaged over a pixel's
// footprint, shadows), in the paper's plain form (blur 0.3 px, bilinear lookup, no shadows), or in that of
// GS-ProCams' released program (the paper's form, in light without cosine and falloff). Each model records
// its own form (docs/design/architecture.md).
typedef enum FfpForm { FFP_FORM_OURS, FFP_FORM_PAPER, FFP_FORM_GS_PROCAMS } FfpForm;
typedef struct FfpDrawing {
    FfpForm form;
    // Samples per side of a pixel, 1 to 4; 0: the model's setting, or without one 2 (1 in the paper's form).
    int samples;
    FFP_RESERVED;
} FfpDrawing;

// --- The reconstruction. ---

typedef struct FfpGaussians FfpGaussians;

typedef struct FfpReconstruction {
    size_t size;           // set by ffp_reconstruction_defaults
    const FfpModel *model; // NULL: the classical initialisation alone, without weights
    // Names of the structured-light patterns to use. Every view must have the first, which the network sees;
    // matching and the polish use all that a view has photographs under. None: the first that every view has.
    const char *const *patterns;
    int n_patterns;
    // Gradient steps, one view each, that fit the prediction to the photographs it was made from, under
    // black, white and the patterns. 0: the network alone, with its looks. Or FFP_POLISH_AUTO.
    int64_t polish;
    // Standard deviation of the noise to be filtered from the photographs first, in linear values from 0 to
    // 1. 0: no filtering. Or FFP_NOISE_ESTIMATED: estimated from the photographs.
    double noise;
    // How many splats may cover the same place of the surface; those of the views with the finest resolution
    // are kept. 0: a splat for every pixel of every view. Or FFP_LAYERS_AUTO: depends on their number.
    double layers;
    FfpDrawing drawing; // used by the polish
    // Go on although the capture has a fault that makes the result wrong: a device behind or inside the
    // object, black and white exchanged, a view's photographs turned, mirrored or exchanged with another's, a
    // turntable turned the other way. Otherwise such a capture fails with FFP_ERROR_FAULT, which names view
    // and fault.
    bool force;
    // Pictures that are wider are reduced to this width first, pixels, 8 to 16384: a draft. The scores are
    // those on the capture's own pictures. 0: none are.
    int64_t width;
} FfpReconstruction;
#define FFP_POLISH_STEPS 72
#define FFP_POLISH_AUTO (-1) // FFP_POLISH_STEPS, or 9 steps per view with more than 8; scenes: 2.5 times that
#define FFP_NOISE_ESTIMATED (-1.0)
#define FFP_LAYERS_AUTO (-1.0) // all for up to 200,000 splats, otherwise two; scenes: one

// The shipped model's drawing; automatic polish, noise and layers. Set `model` afterwards.
FFP_DEFAULTS(FfpReconstruction, ffp_reconstruction_defaults)

typedef struct FfpReconstructionStats { // times are wall-clock seconds
    char pattern[96];                   // the first pattern used
    int patterns;                       // number of patterns used
    int64_t gaussians;
    double initialisation_s, network_s; // projector matching and the classical estimates; the network
    double polish_s;                    // including the selection of the splats to polish
    double noise, denoise_s;            // standard deviation of the noise that was filtered, and the time
    // The network's prediction, or the polish, made the match with the photographs worse and was discarded.
    bool network_dropped, polish_dropped;
    // How well the Gaussians reproduce the photographs they were made from: PSNR in dB, mean over a view's
    // photographs and over the views; that of the view with the least, and its name; and the time this took.
    double psnr, least_psnr;
    char least_view[96];
    double score_s;
    // How well they predict photographs that no fit has looked at: the number of patterns, the first that
    // the capture holds out (at most 2; 0: it holds none out), and their PSNR as above, else NaN. The lit
    // figures are over the pixels of the object that white lights, of the photographs above and of these.
    int unseen;
    double unseen_psnr, lit_psnr, unseen_lit_psnr;
    FFP_RESERVED;
} FfpReconstructionStats;

// One forward pass and a short fit, each scored on the photographs: a prediction that reproduces them clearly
// worse than the classical initialisation is replaced by it, and a fit that makes them worse is discarded;
// the log says so. The Gaussians are in the capture's world units. Fails with FFP_ERROR_MEMORY before any
// work if the machine does not have enough memory. `stats` may be NULL.
FFP_API FfpGaussians *ffp_reconstruct(FfpContext *context, const FfpCapture *capture,
                                      const FfpReconstruction *options, FfpReconstructionStats *stats,
                                      FfpError *err);

// --- Gaussians. ---

// Binary PLY with the 3DGS property names, plus base_color_0..2 and roughness
// (docs/reference/formats/gaussians.md). Plain splats are opened too (PLY of 3DGS, 2DGS and gsplat,
// compressed PLY, SPZ, .splat, glTF with KHR_gaussian_splatting): their colour is taken as albedo and as
// ambient colour, the roughness is 0.5, and a note says so. Splats that cannot be used are left out with a
// note; it is an error if they are more than a tenth. Gaussians too faint to be visible (opacity below 1/255)
// are omitted; it is an error if all of them are. With `contents` nothing is read from disk: they are those
// of a file, in the caller's memory, and `path`, which may be NULL, is its name in messages (and tells .gltf
// and .splat, which have no other mark). NULL: the file at `path`.
FFP_API FfpGaussians *ffp_gaussians_open(FfpContext *context, const char *path, const FfpBytes *contents,
                                         FfpError *err);
// A PLY of relightable Gaussians, whatever the path ends with; ffp_export (render.h) writes other formats.
FFP_API bool ffp_gaussians_save(FfpContext *context, const FfpGaussians *gaussians, const char *path,
                                FfpError *err);
// The contents of the file that ffp_gaussians_save would write, `size` bytes (release with ffp_free); NULL on
// failure.
FFP_API void *ffp_gaussians_bytes(FfpContext *context, const FfpGaussians *gaussians, size_t *size,
                                  FfpError *err);
// The world axis that points up.
typedef enum FfpUp { FFP_UP_Z, FFP_UP_Y, FFP_UP_MINUS_Y } FfpUp;

// Turns splats of another program about the world's origin, from the axes of the file that they were opened
// from (`path`) into the capture's, whose z is up. `up`: the direction that is up in the file, the inverse of
// FfpExport.up; NULL: of the 24 orders of axes the one that fits the capture's silhouettes and colours, with
// a note, if it is clearly better than the file's; nothing is turned for files of relightable Gaussians.
// Errors: photographs that cannot be read.
FFP_API bool ffp_gaussians_turn(FfpContext *context, FfpGaussians *gaussians, const char *path,
                                const FfpCapture *capture, const FfpUp *up, FfpError *err);
// Checks that a file can be written to this path, so that errors show before the work rather than after it.
FFP_API bool ffp_can_write(const char *path, FfpError *err);
FFP_API int64_t ffp_gaussians_count(const FfpGaussians *gaussians);
FFP_API void ffp_gaussians_close(FfpGaussians *gaussians);

// The parameters, one row per Gaussian. The library owns the arrays, which may be written to and are valid
// until the Gaussians are closed, refined or replaced. Calls that use the Gaussians check what was written:
// numbers that are not finite, opacities outside [0,1], scales of 0 and rotations of 0 are errors that name
// array and row; the other ranges are the caller's to keep.
typedef struct FfpGaussianArrays {
    int64_t count;
    float *centre;    // [count,3] world
    float *scale;     // [count,3] standard deviations along the rotated axes, world units, above 0
    float *rotation;  // [count,4] unit quaternion w x y z: the splat's axes to the world
    float *opacity;   // [count] in [0,1]
    float *albedo;    // [count,3] linear diffuse albedo
    float *roughness; // [count] in [0,1]
    float *ambient;   // [count,3] linear radiance with the projector black
    float *scattered; // [count,3] linear radiance that white adds in other ways than by its direct ray: it
                      // follows the pattern's mean. NULL: none. Where a set has none, zeros that are
                      // written over stay unseen: ffp_gaussians_from_arrays makes a set that has some
    FFP_RESERVED;
} FfpGaussianArrays;
FFP_API FfpGaussianArrays ffp_gaussians_arrays(FfpGaussians *gaussians);
// Copies the caller's arrays, normalising rotations, and checks them: 1 to 50,000,000 rows, finite, centres
// within 1e9, scales from 1e-20 to 1e9, colours from 0 to 1e6, opacity and roughness in [0,1], rotations
// within 1000. Errors name array and row.
FFP_API FfpGaussians *ffp_gaussians_from_arrays(FfpContext *context, const FfpGaussianArrays *arrays,
                                                FfpError *err);

// --- Fitting to the photographs of one object. ---

typedef struct FfpRefinement {
    size_t size; // set by ffp_refinement_defaults
    // Structured-light patterns to use in addition to black and white, as FfpReconstruction.patterns.
    const char *const *patterns;
    int n_patterns;
    int64_t steps;  // of one view each; 0: no limit
    double limit_s; // of wall clock; 0: no limit. With neither limit: FFP_REFINE_SECONDS
    double noise;   // as FfpReconstruction.noise
    uint64_t seed;  // for the order of views
    // File for one line of JSON per round of all views (step, seconds, loss, psnr, gaussians), or NULL.
    const char *metrics;
    FfpDrawing drawing;
    bool force; // as FfpReconstruction.force
} FfpRefinement;

#define FFP_REFINE_SECONDS 30
FFP_DEFAULTS(FfpRefinement, ffp_refinement_defaults) // neither limit, noise estimated

typedef struct FfpRefinementStats {
    double psnr_before, psnr_after; // dB over the fitted pictures
    int64_t steps, gaussians;
    double elapsed_s;
    bool stopped; // by the progress callback; the best state so far was kept
    bool dropped; // the fit made the pictures worse and was discarded; the Gaussians are unchanged
    FFP_RESERVED;
} FfpRefinementStats;

// Fits the Gaussians to the capture's pictures, keeping them close to where they started; on failure they are
// unchanged. `stats` may be NULL. Cancelling a fit is not a failure (`stopped`), unless it has not begun:
// then it is FFP_ERROR_CANCELLED. If only the number of steps is limited, the same seed and number of threads
// give identical bits.
FFP_API bool ffp_refine_gaussians(FfpContext *context, FfpGaussians *gaussians, const FfpCapture *capture,
                                  const FfpRefinement *options, FfpRefinementStats *stats, FfpError *err);

#ifdef __cplusplus
}
#endif

#endif
