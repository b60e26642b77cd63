// FF-ProCams in C: turns eight photographed views of an object into relightable 3D Gaussians, and renders
// them under any pattern, camera pose and projector pose. This is the only public header.
//
// Every function that can fail returns false or NULL and writes "WHAT (WHERE)" to the FfpError passed to it
// (which may be NULL). Passing NULL for a required argument (a handle, the options, an output file) fails
// with FFP_ERROR_ARGUMENT, which names it. Functions that take long, log or allocate much take an FfpContext
// first (NULL: silent, all processors, no GPU). Handles are freed by their *_close functions, which accept
// NULL. Handles share no state. Captures, models, fields and Gaussians may be used by several threads at a
// time as long as none of them changes or closes the handle: calls that take it as const only read it. A
// renderer belongs to one thread at a time. Files are written under a temporary name and then renamed, so an
// old file stays intact until the new one is complete. Numbers in files and texts use a decimal point
// regardless of setlocale().
#ifndef FFPROCAMS_H
#define FFPROCAMS_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include "ffprocams/api.h"
#include "ffprocams/context.h"
#include "ffprocams/error.h"
#include "ffprocams/findings.h"

#ifdef __cplusplus
extern "C" {
#endif

FFP_API const char *ffp_version(void); // "0.3.0"

// Checks that the environment variable FFPROCAMS_CPU (portable, avx2, avx512, avx512bf16 or amx; unset: the
// best supported) names kernels that this processor can run. Without this check an invalid value is ignored
// and the best kernels are used.
FFP_API bool ffp_cpu_check(FfpError *err);

// --- Captures: views of one object, each under a black, a white and further patterns. ---

typedef struct FfpCapture FfpCapture;

// Reads a folder with scene.json or render_poses.json, or such a file, and checks all of its contents.
FFP_API FfpCapture *ffp_capture_open(FfpContext *context, const char *path, FfpError *err);
// Looks for what is wrong with a capture, and returns what it found (release with ffp_free), *count findings,
// those that are ok among them, as `info` lists them, and those for which a reconstruction would be refused.
// NULL on failure.
FFP_API FfpFinding *ffp_capture_check(FfpContext *context, const FfpCapture *capture, int *count,
                                      FfpError *err);
// As ffp_capture_open, for a reconstruction alone, without the photographs that ffp_reconstruct does not use
// with these patterns, as its settings have them (`n_patterns` 0: the first), and without ground truth. All
// are read if the file lacks the object's sphere, the photographs have neither alpha nor masks, or it is a
// whole scene.
FFP_API FfpCapture *ffp_capture_open_wanted(FfpContext *context, const char *path,
                                            const char *const *patterns, int n_patterns, FfpError *err);
// The same with the photographs left in their files: a capture of many megapixels then takes hardly any
// memory. It is enough for rendering, maps, exporting, the page and compensation, which read the few
// photographs that they need; reconstructing, fitting, aligning and saving refuse it (FFP_ERROR_ARGUMENT).
// All photographs are read if the file lacks the projector's intensity or a pattern's picture, or, with
// `sphere`, the object's sphere, which an orbit, a mesh, the page and compensation need.
FFP_API FfpCapture *ffp_capture_open_devices(FfpContext *context, const char *path, bool sphere,
                                             FfpError *err);
FFP_API void ffp_capture_close(FfpCapture *capture);

// A picture in the caller's memory, which the library only reads. No pointer to it is kept after the call.
typedef enum FfpPixelType {
    FFP_PIXELS_U8,       // sRGB-encoded, 0 to 255, straight alpha: as in PNG files
    FFP_PIXELS_U16,      // the same, 0 to 65535
    FFP_PIXELS_F32,      // linear light, premultiplied alpha: as in EXR files
    FFP_PIXELS_RADIANCE, // for results of ffp_renderer_shade alone: F32, linear radiance, not clipped
} FfpPixelType;
typedef struct FfpPicture {
    const void *data;            // rows from the top; NULL: no picture
    int width, height, channels; // 1 grey, 3 RGB, 4 RGB and alpha
    FfpPixelType type;
    size_t row_bytes; // from one row to the next; 0: rows are contiguous
} FfpPicture;

// A camera without lens distortion, or a projector, modelled as a camera with light travelling the other way.
// Axes: x right, y down, z forward; pixel centres at integer + 0.5.
typedef struct FfpPinhole {
    int width, height;     // pixels
    double fx, fy, cx, cy; // pixels; the principal point may lie outside the image
    double pose[16];       // row-major 4x4, device to world, rigid
} FfpPinhole;

// A capture in memory, with the same contents as a capture folder (docs/reference/formats/capture.md).
typedef struct FfpPatternData {
    const char *name;
    FfpPicture picture; // of the projector's size; may be empty for black and white
    bool held_out;      // for testing only: never used for a reconstruction unless requested by name
} FfpPatternData;
typedef struct FfpViewData {
    const char *id;
    FfpPinhole camera, projector;
    const FfpPicture *photographs; // [n_patterns], of the camera's size; data is NULL where there is none
    // One channel: the object's share of each pixel. Empty: the photographs' alpha, or without alpha the
    // pixels that white brightens.
    FfpPicture mask;
    // The photographs already show the object over black, so the mask is used only as the object's share.
    bool masked;
    // F32, three channels, may be empty: the position in the projector's picture (pixels) that each pixel's
    // light comes from, decoded from Gray codes, and a confidence from 0 (unknown) to 1.
    FfpPicture correspondence;
    // Ground truth for evaluation, F32, one channel, may be empty: camera z in world units, 0 where there is
    // no surface.
    FfpPicture depth;
} FfpViewData;
typedef struct FfpCaptureData {
    const char *name;
    int n_patterns, n_views;
    const FfpPatternData *patterns;
    const FfpViewData *views;
    int black, white; // indices of these patterns
    // The projector's radiant intensity per channel at pattern value 1, W/sr with distances in world units;
    // all 0: estimated.
    double intensity[3];
    double centre[3], radius; // sphere around the object, world units; radius 0: estimated
} FfpCaptureData;

// Copies and checks everything. Errors name the view, pattern or field.
FFP_API FfpCapture *ffp_capture_from_memory(FfpContext *context, const FfpCaptureData *data, FfpError *err);

// Contents of a capture: the numbers of views and patterns, ids and names. An index out of range gives NULL
// or false.
FFP_API int ffp_capture_views(const FfpCapture *capture);
FFP_API int ffp_capture_patterns(const FfpCapture *capture);
FFP_API const char *ffp_capture_view_id(const FfpCapture *capture, int view);
FFP_API const char *ffp_capture_pattern_name(const FfpCapture *capture, int pattern);
// The role of a pattern; an index out of range gives FFP_PATTERN_ACTIVE.
typedef enum FfpPatternRole {
    FFP_PATTERN_ACTIVE, // can be used as structured light
    FFP_PATTERN_BLACK,
    FFP_PATTERN_WHITE,
    FFP_PATTERN_HELD_OUT, // for testing only
} FfpPatternRole;
FFP_API FfpPatternRole ffp_capture_pattern_role(const FfpCapture *capture, int pattern);
// `camera` and `projector` may be NULL.
FFP_API bool ffp_capture_view_devices(const FfpCapture *capture, int view, FfpPinhole *camera,
                                      FfpPinhole *projector);
// Linear RGB in the library's memory, valid until the capture is closed; data is NULL if the view has no such
// picture. View -1: the pattern itself.
FFP_API FfpPicture ffp_capture_picture(const FfpCapture *capture, int view, int pattern);
// The object's share of each pixel: one channel, from 0 to 1, likewise.
FFP_API FfpPicture ffp_capture_coverage(const FfpCapture *capture, int view);
// As in FfpCaptureData, given or estimated.
FFP_API void ffp_capture_intensity(const FfpCapture *capture, double intensity[3]);
FFP_API void ffp_capture_bounds(const FfpCapture *capture, double centre[3], double *radius);

// --- Weights. ---

typedef struct FfpModel FfpModel;

// `path` NULL: the shipped weights, small.safetensors. They are searched for in the folder named by the
// environment variable FFPROCAMS_MODELS or, if it is unset, in share/ffprocams/models of the prefix in which
// the library is installed (the program's prefix, if linked statically), in models/ beside it, and in models/
// of the current folder. Errors list the places searched.
FFP_API FfpModel *ffp_model_open(FfpContext *context, const char *path, FfpError *err);
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
} FfpDrawing;

// --- The reconstruction. ---

typedef struct FfpGaussians FfpGaussians;

typedef struct FfpReconstruction {
    const FfpModel *model; // NULL: the classical initialisation alone, without weights
    // Names of the structured-light patterns to use. Every view must have the first, which the network sees;
    // matching and the polish use all that a view has photographs under. None: the first that every view has.
    const char *const *patterns;
    int n_patterns;
    // Gradient steps, one view each, that fit the prediction to the photographs it was made from, under
    // black, white and the patterns. 0: the forward pass alone. Or FFP_POLISH_AUTO.
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
} FfpReconstruction;
#define FFP_POLISH_STEPS 72
#define FFP_POLISH_AUTO (-1) // FFP_POLISH_STEPS, or 9 steps per view with more than 8; scenes: 2.5 times that
#define FFP_NOISE_ESTIMATED (-1.0)
#define FFP_LAYERS_AUTO (-1.0) // all for up to 200,000 splats, otherwise two; scenes: one

// The shipped model's drawing; automatic polish, noise and layers. Set `model` afterwards.
FFP_API FfpReconstruction ffp_reconstruction_defaults(void);

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
} FfpReconstructionStats;

// One forward pass and a short fit, each scored on the photographs: a prediction that reproduces them clearly
// worse than the classical initialisation is replaced by it, and a fit that makes them worse is discarded;
// the log says so. The Gaussians are in the capture's world units. Fails with FFP_ERROR_MEMORY before any
// work if the machine does not have enough memory. `stats` may be NULL.
FFP_API FfpGaussians *ffp_reconstruct(FfpContext *context, const FfpCapture *capture,
                                      const FfpReconstruction *options, FfpReconstructionStats *stats,
                                      FfpError *err);

// Binary PLY with the 3DGS property names, plus base_color_0..2 and roughness
// (docs/reference/formats/gaussians.md). Plain splats are opened too (PLY of 3DGS, 2DGS and gsplat,
// compressed PLY, SPZ, .splat, glTF with KHR_gaussian_splatting): their colour is taken as albedo and as
// ambient colour, the roughness is 0.5, and a note says so. Splats that cannot be used are left out with a
// note; it is an error if they are more than a tenth. Gaussians too faint to be visible (opacity below 1/255)
// are omitted; it is an error if all of them are.
FFP_API FfpGaussians *ffp_gaussians_open(FfpContext *context, const char *path, FfpError *err);
FFP_API bool ffp_gaussians_save(FfpContext *context, const FfpGaussians *gaussians, const char *path,
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
// array and row.
typedef struct FfpGaussianArrays {
    int64_t count;
    float *centre;    // [count,3] world
    float *scale;     // [count,3] standard deviations along the rotated axes, world units, above 0
    float *rotation;  // [count,4] unit quaternion w x y z: the splat's axes to the world
    float *opacity;   // [count] in [0,1]
    float *albedo;    // [count,3] linear diffuse albedo
    float *roughness; // [count] in [0,1]
    float *ambient;   // [count,3] linear radiance with the projector black
} FfpGaussianArrays;
FFP_API FfpGaussianArrays ffp_gaussians_arrays(FfpGaussians *gaussians);
// Copies the caller's arrays and checks them (finite, in range), normalising rotations. Errors name array and
// row.
FFP_API FfpGaussians *ffp_gaussians_from_arrays(FfpContext *context, const FfpGaussianArrays *arrays,
                                                FfpError *err);

// --- Drawing into memory. ---

// One view of Gaussians, rasterised once and shaded under any number of patterns.
typedef struct FfpRenderer FfpRenderer;
FFP_API FfpRenderer *ffp_renderer_new(FfpContext *context, FfpDrawing drawing, FfpError *err);
FFP_API void ffp_renderer_close(FfpRenderer *renderer);
// Rasterises for a camera and maps the visible surface to a projector; the Gaussians are not accessed
// afterwards. Each side may have 1 to 16384 pixels.
FFP_API bool ffp_renderer_aim(FfpContext *context, FfpRenderer *renderer, const FfpGaussians *gaussians,
                              const FfpPinhole *camera, const FfpPinhole *projector, FfpError *err);
// The camera's picture of the object over black under `pattern` (of the projector's size; data NULL: a dark
// projector), for a projector of the given radiant intensity (as in FfpCaptureData). out [height,width,3],
// sRGB-encoded: U8 rounded as in files, F32 in [0,1]; or RADIANCE, linear and not clipped, premultiplied by
// opacity. `row_bytes` 0: rows are contiguous.
FFP_API bool ffp_renderer_shade(FfpContext *context, FfpRenderer *renderer, const FfpPicture *pattern,
                                const double intensity[3], void *out, FfpPixelType type, size_t row_bytes,
                                FfpError *err);
// G-buffers: averages over each pixel, F32 [height,width,channels].
typedef enum FfpMap {
    FFP_MAP_OPACITY,   // 1 channel, in [0,1]
    FFP_MAP_DEPTH,     // 1: camera z in world units, 0 where the opacity is below one half
    FFP_MAP_NORMAL,    // 3: world, unit length, facing the camera; 0 off the object
    FFP_MAP_ALBEDO,    // 3: linear
    FFP_MAP_ROUGHNESS, // 1
    FFP_MAP_AMBIENT,   // 3: linear radiance, premultiplied by opacity
    // 1: sum_ij W_i W_j |z_i - z_j| of the weights and depths of the splats at the pixel, world units: how
    // far apart they are along the ray (FF-ProCams, Eq. 22). For losses; not written to files.
    FFP_MAP_DISTORTION,
    FFP_MAP_COUNT
} FfpMap;
FFP_API int ffp_map_channels(FfpMap map); // 1 or 3
// A map of the view that was aimed at, of the camera's size.
FFP_API bool ffp_renderer_map(FfpContext *context, FfpRenderer *renderer, FfpMap map, float *out,
                              FfpError *err);

// --- Drawing with gradients. ---

// Views of one set of Gaussians under the same patterns, drawn together: each is rasterised once, whatever
// the number of patterns, and several are worked on at the same time. All arrays are the caller's.
typedef struct FfpRenderBatch {
    // Checked as by ffp_gaussians_from_arrays, but rotations may have any length other than 0. Not copied:
    // the arrays must stay unchanged until the last ffp_renderer_backward for this drawing.
    FfpGaussianArrays gaussians;
    int n_views;
    const FfpPinhole *cameras, *projectors; // [n_views]; all cameras of one size, all projectors of one size
    int n_patterns;                         // may be 0, for maps alone
    const FfpPicture *patterns;             // [n_patterns] of the projectors' size; data NULL: dark
    bool same_patterns; // those of the renderer's last ffp_renderer_forward; `patterns` is ignored
    double intensity[3];
    bool linear;    // pictures are linear radiance over black, not clipped; otherwise sRGB-encoded in [0,1]
    bool gradients; // ffp_renderer_backward may follow: what it needs is kept
} FfpRenderBatch;
// Draws pictures [n_views,n_patterns,height,width,3] (NULL without patterns) and, where not NULL, maps
// [n_views,height,width,channels], indexed by FfpMap (`maps` NULL: none), F32. The view of ffp_renderer_aim
// is unaffected. If the call fails, the contents of pictures and maps are undefined.
FFP_API bool ffp_renderer_forward(FfpContext *context, FfpRenderer *renderer, const FfpRenderBatch *batch,
                                  float *pictures, float *const *maps, FfpError *err);

// Gradients of a loss, in the caller's arrays, which they replace; NULL: not wanted. Gaussians: with respect
// to the numbers as given, rotations of any length. `count` is ignored. Poses: with respect to xi in exp(xi)
// pose at xi = 0 (se(3), perturbed from the left): translation x y z (world units), rotation x y z (radians).
typedef struct FfpRenderGradients {
    FfpGaussianArrays gaussians;
    float *patterns;                          // [n_patterns,height,width,3]; 0 where a pattern is dark
    double *intensity;                        // [3]
    double *cameras, *projectors;             // [n_views,6]
    double *camera_focals, *projector_focals; // [n_views,2]: fx, fy
} FfpRenderGradients;
// From the gradients of the pictures and maps of the last ffp_renderer_forward (which must have announced
// them; arrays of the same shapes, NULL where there are none) to those of everything that was drawn from. May
// be called again.
//
// Constants of the backward pass: how much light a point gets past what stands in its way (shadows), and
// whether it is inside the pattern; the size of a pixel's footprint in the pattern; the order of the splats,
// which of them a pixel sees, and the side from which a normal is seen; which axis of a splat is its
// shortest; whether a map's pixel has a surface; in the form of GS-ProCams, the distance of the light.
// Gradients of pixels that are clipped (encoded pictures only) are 0.
FFP_API bool ffp_renderer_backward(FfpContext *context, FfpRenderer *renderer, const float *pictures,
                                   const float *const *maps, const FfpRenderGradients *out, FfpError *err);

// --- For training and fitting in other programs. ---

// A model's configuration (docs/reference/formats/weights.md, "Weights").
typedef struct FfpModelForm {
    const char *modules; // one letter per block: M = Mamba2, T = Transformer
    int dim, patch, state, chunk, pixel_features, pixel_hidden;
    bool residual, match_input, pixel_skip, context_inputs, appearance_cnn;
    int looks; // rounds in which the input views are drawn and the splats corrected
} FfpModelForm;
FFP_API FfpModelForm ffp_model_form(const FfpModel *model);
// The weights by number, from 0 to one less than the count, in the file's order. They are the model's own
// memory and may be written to between calls; the caller answers for finite numbers.
typedef struct FfpWeights {
    const char *name;
    int64_t rows, columns; // columns 0: a vector
    float *values;         // [rows,columns]
} FfpWeights;
FFP_API int ffp_model_weights_count(const FfpModel *model);
FFP_API FfpWeights ffp_model_weights(FfpModel *model, int number); // all 0: no such number
// Writes safetensors that ffp_model_open reads; `exact`: matrices in F32, not in bf16. The file's record of
// its training is kept.
FFP_API bool ffp_model_save(FfpContext *context, const FfpModel *model, const char *path, bool exact,
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
// looks.
FFP_API bool ffp_prepared_look(FfpContext *context, const FfpPrepared *prepared, const float *raw,
                               float *seen, FfpError *err);
FFP_API void ffp_prepared_close(FfpPrepared *prepared);

// The loss of sRGB-encoded pictures that all fits here share (FF-ProCams, Eqs. 18, 19):
// l1 mean |P - T| + ssim (1 - mean SSIM(P, T)), SSIM by Wang et al. 2004 with an 11 x 11 Gaussian of
// sigma 1.5 and zero padding.
typedef struct FfpPictureLoss {
    int count, width, height; // at least 1
    const float *pictures;    // [count,height,width,3] in [0,1]
    const float *targets;     // likewise
    double l1, ssim;          // weights
    float *gradients;         // [count,height,width,3] with respect to `pictures`, replaced; NULL: not wanted
} FfpPictureLoss;
FFP_API bool ffp_picture_loss(FfpContext *context, const FfpPictureLoss *pictures, double *loss,
                              FfpError *err);

// --- Pictures. ---

// How a picture goes into a frame of another shape (width over height), always centred: COVER fills the frame
// and cuts off what is beyond it, CONTAIN shows all of the picture, with black beside it, STRETCH distorts
// it, PIXEL shows it pixel for pixel, cut off or with black around it. Where the shapes differ by at most 1
// %, the first three only change its size.
typedef enum FfpFraming {
    FFP_FRAMING_COVER,
    FFP_FRAMING_CONTAIN,
    FFP_FRAMING_STRETCH,
    FFP_FRAMING_PIXEL
} FfpFraming;

// Makes one full turn around the object's centre: the camera, the projector, or the object itself (both
// devices turning the other way).
typedef enum FfpOrbit { FFP_ORBIT_NONE, FFP_ORBIT_CAMERA, FFP_ORBIT_PROJECTOR, FFP_ORBIT_OBJECT } FfpOrbit;

typedef struct FfpPictures {
    // File of camera and projector poses (targets.json or scene.json); NULL: the capture's.
    const char *poses;
    const char *const *views; // ids of the views to render; none: all
    int n_views;
    // Names of the capture's patterns, image files, or folders of image files; none: the white pattern.
    const char *const *patterns;
    int n_patterns;
    FfpFraming framing; // of image files in the projector's frame
    // Size of the pictures. The width scales them; an aspect ratio other than the camera's shows more or less
    // above and below, and the principal point keeps its relative height. 0, 0: the camera's size; height 0:
    // the camera's aspect ratio.
    int width, height;
    // The projector's radiant intensity at pattern value 1; all 0: the capture's, or that of the file of
    // poses.
    double intensity[3];
    FfpOrbit orbit; // starting from the given view (at most one), or from the first
    int frames;     // of the orbit, divided evenly among the patterns
    // File for a video of all pictures in order, or NULL: an animated PNG (.png, .apng), or .gif, .mp4,
    // .webm, .mkv, encoded by the program ffmpeg.
    const char *video;
    int rate; // frames per second of the video, 1 to 1000
    // Folder for <view>_<pattern>.png, or frame_<number>.png with an orbit or a video; created if necessary.
    const char *folder;
    // Also write the G-buffers: <view>_depth.exr and .png, _opacity, _normal, _albedo, _roughness, _ambient.
    bool maps;
    FfpDrawing drawing;
} FfpPictures;

FFP_API FfpPictures ffp_pictures_defaults(void); // all views under white, 15 frames a second

// Renders views under patterns to 8-bit sRGB files over black, rasterising each view once for all patterns.
// Two pictures with the same file name are an error, reported before rendering; only frames may repeat a
// view. `capture` may be NULL if `poses` names a file: views, projector size, intensity and patterns then
// come from that file, whose photographs need not exist. Missing values are taken from the options: the
// intensity, and the size of the first pattern that is an image file. Returns the number of pictures written,
// or -1, in which case there is no video, and a file INCOMPLETE in the folder says that pictures are missing.
FFP_API int ffp_render_pictures(FfpContext *context, const FfpGaussians *gaussians, const FfpCapture *capture,
                                const FfpPictures *options, FfpError *err);

// Named float images returned by a call.
typedef struct FfpImages FfpImages;
typedef struct FfpNamedImage {
    const char *name;
    int width, height, channels;
    const float *data; // [height,width,channels], the library's, valid until the images are closed
} FfpNamedImage;
FFP_API int ffp_images_count(const FfpImages *images);
// An index out of range or an unknown name gives an image whose name is NULL.
FFP_API FfpNamedImage ffp_images_at(const FfpImages *images, int index);
FFP_API FfpNamedImage ffp_images_find(const FfpImages *images, const char *name);
FFP_API void ffp_images_close(FfpImages *images);

// --- Viewer page. ---

typedef struct FfpPage {
    const char *file;  // output: one self-contained HTML file
    const char *poses; // file of additional poses to jump to (targets.json or scene.json), or NULL
    int photographs;   // longest side, in pixels, of the photographs to include; 0: none
    FfpDrawing drawing;
} FfpPage;
FFP_API FfpPage ffp_page_defaults(void); // photographs of 512 pixels

typedef struct FfpPageStats {
    int64_t gaussians;
    long long bytes;           // file size
    int patterns, photographs; // included; a note is logged if there was no room for all
} FfpPageStats;
// Writes a page that draws Gaussians in the browser (WebGL 2) as ffp_render_pictures does, with camera and
// projectors that can be moved (docs/guide/page.md). `capture` is required; `stats` may be NULL. Fails with
// FFP_ERROR_UNSUPPORTED for the GS-ProCams form, whose light model the page does not implement.
FFP_API bool ffp_write_page(FfpContext *context, const FfpGaussians *gaussians, const FfpCapture *capture,
                            const FfpPage *options, FfpPageStats *stats, FfpError *err);

// --- Fitting to the photographs of one object. ---

typedef struct FfpRefinement {
    // Structured-light patterns to use in addition to black and white, as FfpReconstruction.patterns.
    const char *const *patterns;
    int n_patterns;
    int64_t steps;  // of one view each; 0: no limit
    double seconds; // of wall clock; 0: no limit. With neither limit: 30 s
    double noise;   // as FfpReconstruction.noise
    uint64_t seed;  // for the order of views
    // File for one line of JSON per round of all views (step, seconds, loss, psnr, gaussians), or NULL.
    const char *metrics;
    FfpDrawing drawing;
    bool force; // as FfpReconstruction.force
} FfpRefinement;

FFP_API FfpRefinement ffp_refinement_defaults(void); // 30 seconds, noise estimated

typedef struct FfpRefinementStats {
    double psnr_before, psnr_after; // dB over the fitted pictures
    int64_t steps, gaussians;
    double seconds;
    bool stopped; // by the progress callback; the best state so far was kept
    bool dropped; // the fit made the pictures worse and was discarded; the Gaussians are unchanged
} FfpRefinementStats;

// Fits the Gaussians to the capture's pictures, keeping them close to where they started; on failure they are
// unchanged. `stats` may be NULL. Cancelling a fit is not a failure (`stopped`). If only the number of steps
// is limited, the same seed and number of threads give identical bits.
FFP_API bool ffp_refine_gaussians(FfpContext *context, FfpGaussians *gaussians, const FfpCapture *capture,
                                  const FfpRefinement *options, FfpRefinementStats *stats, FfpError *err);

// --- Applications: compensated projections and correspondence maps. ---

typedef struct FfpCompensation {
    const char *poses; // as FfpPictures.poses
    // Ids of the views whose cameras see a target, with all their projectors shining at once; none: all.
    const char *const *views;
    int n_views;
    const char *const *targets; // image files in the cameras' frames: one for all views, or one for each
    const FfpPicture *pictures; // or targets from memory, in the same number
    int n_targets;
    FfpFraming framing;    // of targets in the cameras' frames
    bool transparent_free; // transparent parts of a target are unconstrained; otherwise they are black
    // File for the pattern (PNG), or <pattern>_<view>.png for each of several projectors. Written beside it:
    // <pattern>_seen_<view>.png, the predicted picture, and <pattern>_target_<view>.png.
    const char *pattern;
    // With a film as the only target, for one view and one projector: the corrected film (as
    // FfpPictures.video), of `rate` frames a second (0: 15); `pattern` and what is beside it show its first
    // frame, the figures are means over the frames. NULL: targets are pictures.
    const char *video;
    int rate;
    double gain; // factor on the linear targets; 0: the brightest that light allows
    bool paint;  // targets are light on the object: 0 its look under black, 1 its look under white (no gain)
    // Of gradient descent after the closed form, which then is at up to four times the camera's pixels a
    // side; 0: none, and the closed form is that of the live page.
    int steps;
    // Take ambient light and response from the Gaussians even if the view has photographs under black and
    // white.
    bool gaussians_only;
    // Make patterns for the real projector, at its panel's size, with its lens distortion and gamma, which
    // the capture must contain (docs/reference/formats/capture.md, projector.device).
    bool for_device;
    FfpDrawing drawing;
} FfpCompensation;

FFP_API FfpCompensation ffp_compensation_defaults(void); // all views, gain 1, 30 steps

typedef struct FfpCompensationStats {
    double gain; // the gain used
    // Shares of the object's pixels that the targets constrain: those that no projector lights, and those
    // whose target is darker or brighter than projected light can reach.
    double unlit, too_dark, too_bright;
    // dB over the lit ones: with dark projectors, after the closed form, at the end.
    double psnr_dark, psnr_closed, psnr;
    int patterns;
    double seconds;
} FfpCompensationStats;

// Finds the patterns under which the cameras see their targets as closely as light allows. Returns linear
// images named pattern_<view> (of the projector's size, or its panel's, one per projector), seen_<view> and
// target_<view> (of the camera's size). Ignores `pattern` of the options. `stats` may be NULL.
FFP_API FfpImages *ffp_compensate_images(FfpContext *context, const FfpGaussians *gaussians,
                                         const FfpCapture *capture, const FfpCompensation *options,
                                         FfpCompensationStats *stats, FfpError *err);
// The same, written to files. `stats` may be NULL.
FFP_API bool ffp_compensate(FfpContext *context, const FfpGaussians *gaussians, const FfpCapture *capture,
                            const FfpCompensation *options, FfpCompensationStats *stats, FfpError *err);

typedef struct FfpMaps {
    const char *poses;        // as FfpPictures.poses
    const char *const *views; // ids; none: all
    int n_views;
    const char *folder; // for the files (docs/reference/formats/pictures.md); created if necessary
    FfpDrawing drawing;
} FfpMaps;

FFP_API FfpMaps ffp_maps_defaults(void); // all views

typedef struct FfpMapStats { // of one view
    char view[96];
    // Camera pixels whose round trip to the projector succeeded, and lit ones for which it failed.
    int lit_pixels, lost_pixels;
    // Error of the round trip: the share within half a pixel; the median and the maximum, pixels.
    double within_half, median, most;
    double lit_share; // share of the projector's pixels that fall on the object
} FfpMapStats;
enum { FFP_MAP_STATS = 512 }; // the maximum number of views

// Correspondences and projected light for one camera and one projector: linear images named like the files
// (docs/reference/formats/pictures.md): camera_to_projector, projector_to_camera, projector_sees, lit,
// incidence, density, resolution, illuminance. `stats` may be NULL.
FFP_API FfpImages *ffp_map_images(FfpContext *context, const FfpGaussians *gaussians,
                                  const FfpCapture *capture, const FfpPinhole *camera,
                                  const FfpPinhole *projector, FfpDrawing drawing, FfpMapStats *stats,
                                  FfpError *err);
// The same for the views of a capture or a file of poses, written to files. Returns the number of files, or
// -1. `stats` may be NULL; otherwise it must have room for all views.
FFP_API int ffp_write_maps(FfpContext *context, const FfpGaussians *gaussians, const FfpCapture *capture,
                           const FfpMaps *options, FfpMapStats *stats, FfpError *err);

// --- Export to other programs. ---

typedef struct FfpExport {
    // The extension selects the format: splats as .ply (the layout of 3DGS), .spz, .gltf or .glb
    // (KHR_gaussian_splatting); a mesh as .glb, .gltf or .obj.
    const char *file;
    bool mesh;      // a closed surface with albedo and roughness instead of splats
    int resolution; // of the mesh: cells along its longest side, 16 to 512
    // Light baked into the splats. NULL or "ambient": ambient light only. "white", the name of one of the
    // capture's patterns or an image file: also the projector showing it, by the light model at each
    // Gaussian, with shadows.
    const char *light;
    FfpFraming framing;         // of an image file in the projector's frame
    const char *poses;          // as FfpPictures.poses
    const char *projector_view; // view whose projector shines; NULL: the first
    const char *camera_view;    // view for whose camera highlights are baked in; NULL: no highlights
    FfpUp up;                   // of the Gaussians' world; files use the axes of their format
    FfpForm form;               // in which the Gaussians are drawn
    // Plain splats may replace a PLY of relightable Gaussians. Otherwise such a file is left alone, with
    // FFP_ERROR_ARGUMENT, because its albedo and roughness would be lost.
    bool force;
} FfpExport;
FFP_API FfpExport ffp_export_defaults(void); // ambient light, z up, a mesh of 128 cells

typedef struct FfpExportStats {
    int64_t splats, triangles, bytes; // written
} FfpExportStats;
// Writes Gaussians for programs that do not simulate projectors. `capture` may be NULL for splats in ambient
// light; a mesh is made from what its cameras see. `stats` may be NULL.
FFP_API bool ffp_export(FfpContext *context, const FfpGaussians *gaussians, const FfpCapture *capture,
                        const FfpExport *options, FfpExportStats *stats, FfpError *err);

// --- Evaluation. ---

typedef enum FfpPredictor {
    FFP_PREDICT_GAUSSIANS, // reconstruct (or read) Gaussians and render them
    FFP_PREDICT_DEPTH,     // black + (white - black) * pattern, looked up at the capture's true depth
    FFP_PREDICT_MATCH,     // the same, at the depth found by projector matching
} FfpPredictor;

typedef struct FfpEvaluation {
    const char *const *captures; // folders or JSON files
    int n_captures;
    FfpPredictor predictor;
    const FfpModel *model;  // NULL: the classical initialisation
    const char *model_name; // name of the predictor in JSON and report; NULL: its file, or its kind
    const char *gaussians;  // PLY to evaluate instead of reconstructing; NULL: reconstruct
    const char *field;      // file of a neural field to evaluate instead; NULL: none
    // Pose files for novel_pose: none, one per capture, or one path that is looked up in each capture.
    const char *const *targets;
    int n_targets;
    const char *const *patterns; // as FfpReconstruction.patterns
    int n_patterns;
    int64_t polish;     // as FfpReconstruction.polish
    double noise;       // as FfpReconstruction.noise
    double layers;      // as FfpReconstruction.layers
    const char *save;   // folder for every prediction, <capture>/<view>_<pattern>.png, or NULL
    const char *json;   // file for the rows, or NULL
    const char *report; // file for a self-contained HTML report, or NULL
    // Image file: the report also shows views under it (without truth or figures), or NULL.
    const char *show_pattern;
    const char *viewer;     // page for the report to link to, relative to it, or NULL
    const char *perceptual; // safetensors with LPIPS weights, or NULL
    FfpDrawing drawing;
    bool force; // as FfpReconstruction.force
    // JSON files of earlier evaluations: their rows are used, and no capture is evaluated.
    const char *const *merged;
    int n_merged;
} FfpEvaluation;

FFP_API FfpEvaluation ffp_evaluation_defaults(void); // as ffp_reconstruction_defaults

// One row of results: a capture under a protocol, in this order. `novel_pattern`: held-out patterns at the
// input poses; `novel_pose`: all pictures of the targets; `rendering`: black, white and lollipops at the
// input poses, before it `unseen`, those of them that the predictor was not given, and after it `given`,
// those that it was. Measured on the 8-bit prediction against the truth over black, sRGB-encoded. NAN where a
// figure does not apply. PSNR is in dB, and 100 for identical pictures; SSIM is that of Wang et al. 2004,
// LPIPS that of Zhang et al. 2018.
typedef struct FfpScore {
    char capture[96];
    const char *protocol;
    // Means over the images; foreground: pixels covered by the object.
    double psnr, psnr_foreground, ssim, lpips;
    double psnr_gloss; // under white, over pixels whose true specular part exceeds 0.05 (linear radiance)
    double psnr_unseen_lollipops; // `rendering` only: lollipops not given to the predictor
    int images, images_unseen;
    double reconstruct_s, render_s; // seconds: for the reconstruction; for all pictures of the row
    // `rendering` of Gaussians only, if the capture has ground truth; over the pixels of the input views that
    // are covered completely. Depth error in % of the object's radius, separately for pixels lit and not lit
    // by the white pattern; a pixel without a surface counts as 100.
    double depth_lit_median, depth_lit_p90, depth_unlit_median, depth_unlit_p90;
    double albedo_mse, albedo_lit_mse, albedo_unlit_mse; // linear; separately likewise
} FfpScore;

// Returns the rows (release with ffp_free) and their number, or NULL. With several captures, their means
// follow as rows whose capture is "mean". JSON and report are written at the end. The ranks of a context
// divide the captures among themselves and all return all rows; rank 0 writes the files. A report requires a
// single process.
FFP_API FfpScore *ffp_evaluate(FfpContext *context, const FfpEvaluation *options, int *n_scores,
                               FfpError *err);

// --- Training and generated data. ---

typedef struct FfpTraining {
    const char *out;        // folder for checkpoint.safetensors, weights.safetensors, metrics.jsonl, pictures
    const char *config;     // JSON file, or NULL for the defaults
    const char *initial;    // weights to start from with a fresh optimiser, or NULL
    const char *perceptual; // safetensors for the perceptual loss; NULL: off
    // Folder of captures for fine-tuning `initial` (NULL: the shipped weights) to your own devices; only
    // their photographs are used. Every fourth capture is held out, and the weights written are those that
    // predict its photographs best, the initial ones included. NULL: scenes are generated or read.
    const char *captures;
    int64_t steps;   // -1: as in the configuration
    int64_t stop_at; // stop at this step with a checkpoint, as if cancelled; 0: run to the end
    bool resume;     // continue from the checkpoint in `out`, with the configuration that it contains
} FfpTraining;
FFP_API FfpTraining ffp_training_defaults(void); // the configuration's values, to the end
// Runs to the end or until cancelled; cancelling writes a checkpoint first and is not a failure.
FFP_API bool ffp_train_model(FfpContext *context, const FfpTraining *options, FfpError *err);

// Split of the generated objects; no mesh is in two splits.
typedef enum FfpSplit { FFP_SPLIT_ALL, FFP_SPLIT_TRAIN, FFP_SPLIT_VALIDATION, FFP_SPLIT_TEST } FfpSplit;

// 8 views of 128 x 128 pixels and 6 lollipops; small and quick; as generated by training itself.
typedef enum FfpPreset { FFP_PRESET_PAPER, FFP_PRESET_SMOKE, FFP_PRESET_TRAINING } FfpPreset;

// The object turns before a fixed camera and projector; each view has separate devices, all around the
// object; or the camera spirals around a fixed object and projector; or a whole scene, with one projector or
// two, before which the camera walks along an arc (docs/design/data.md, "Rigs").
typedef enum FfpRig {
    FFP_RIG_TURNTABLE,
    FFP_RIG_FREE,
    FFP_RIG_SPHERE,
    FFP_RIG_WALK,
    FFP_RIG_WALK_TWO
} FfpRig;

// Imperfections of the devices (docs/design/data.md, "Sensor model"). All 0: none.
typedef struct FfpSensorFaults {
    double exposure;    // of the camera, stops, -8 to 8
    double shot, read;  // noise of a linear value v: variance shot * v + read^2; 0 to 1 each
    double defocus;     // of the projector: standard deviation in its pixels, 0 to 64
    double gamma;       // the projector sends value^(1 + gamma), -0.9 to 4 ...
    double black_level; // ... and this share of white where a pattern is black, 0 to 0.9
    double turn_error;  // standard deviation of the written poses' rotation about each axis, degrees, 0 to 28
    double shift_error; // and of their positions, world units, 0 to 0.5
} FfpSensorFaults;

typedef struct FfpGeneration {
    const char *folder; // output: one capture folder per scene
    FfpSplit split;
    FfpPreset preset;
    int64_t first, count; // scenes of the split; count -1: to the end, or one with `mesh`
    int resolution;       // image size; 0: the preset's
    FfpRig rig;           // of the input views
    int views;            // input views, 1 to 360; 0: the preset's
    uint64_t seed;        // at most INT64_MAX
    const char *mesh;     // OBJ, PLY, STL or glTF file to use instead of the generated meshes; NULL: none
    const char *material; // folder of basecolor, roughness and normal maps to use; NULL: none
    // Or folder of pictures, each of which is a material, the base colour; so is each folder of such maps in
    // it. A scene's seed draws one and lays it on the object in its own way (docs/design/data.md, "Materials
    // from pictures"). NULL: none.
    const char *materials;
    // Folder of pictures that the projector shows in place of all lollipops but the first: a scene's seed
    // draws them, and which part of each (docs/design/data.md, "Patterns from pictures"). With one lollipop
    // there is none to replace; with `photographs` it is an error. NULL: none.
    const char *patterns;
    FfpSensorFaults sensor;
    // Folder of patterns (ffp_write_patterns): instead of captures, write photographs of one object on a
    // turntable under all of them, and of a chessboard, taken by a rig with lenses, to `folder`, which must
    // be new or empty (docs/design/data.md, "Photographs"). Only the preset's samples are used; `resolution`
    // is the photographs' height (0: 480). With FFP_RIG_WALK of a whole scene, from `views` places of the
    // camera. NULL: write captures.
    const char *photographs;
    int attitudes; // of the chessboard, at most 64; 0: no chessboard
    // One folder of the photographs, the same as among all of them: view-DDD (DDD being one of `views` even
    // angles in degrees), attitude-NN, turntable or empty. NULL: all.
    const char *only;
    // The photographs are taken in a real room, with platter, table, wall, boxes and a lamp that the seed
    // decides, as JPEG files of this quality (1 to 100), beside two turns and two patterns that are held out
    // and pictures without noise (docs/design/data.md, "Rooms"). Needs `photographs`.
    bool room;
    int quality;
    bool check; // generate nothing; fail with an error naming the scenes that are missing or incomplete
} FfpGeneration;
FFP_API FfpGeneration ffp_generation_defaults(void); // all scenes of all splits by the paper's preset
// Existing scenes are kept; a scene appears under its name only when it is complete. Any number of processes
// may share a job, each with its own range of scenes; the ranks of a context take scenes in turn.
FFP_API bool ffp_generate(FfpContext *context, const FfpGeneration *options, FfpError *err);

// --- Patterns to project while taking photographs. ---

typedef struct FfpPatterns {
    const char *folder; // for the pictures, README.txt and show.html; must be new or empty
    int width, height;  // of the projector's panel, pixels, 64 to 16384
    int lollipops;      // number of the paper's structured-light patterns of coloured rings, 0 to 100
    bool focus;         // a chart for focusing and for placing the object
    bool capture;       // black, white and the lollipops: what a reconstruction needs
    bool gray_codes;    // of columns and rows, each with its inverse
    // The chessboard on paper, chessboard.pdf and chessboard.svg at true size, beside Gray codes: inner
    // corners, 3 to 64 each way (0: no paper), and the side of a square, 1 to 500 mm.
    int columns, rows;
    double square;
} FfpPatterns;

FFP_API FfpPatterns ffp_patterns_defaults(void); // everything, one lollipop, 1920 x 1080; 9 x 6, 25 mm
// Writes <number>_<name>.png in display order (the number is that of the photograph; the focus chart has 0),
// instructions as text, and a page that shows them full screen in a browser. Written completely or not at
// all. Returns the number of pictures, or -1.
FFP_API int ffp_write_patterns(FfpContext *context, const FfpPatterns *options, FfpError *err);

// --- Calibration of a rig. ---

// Terms of a device to hold fixed: lens terms at 0, the principal point at the middle, fx = fy. They
// may be combined with |.
enum {
    FFP_FIX_K1 = 1,
    FFP_FIX_K2 = 2,
    FFP_FIX_K3 = 4,
    FFP_FIX_TANGENTIAL = 8, // p1 and p2
    FFP_FIX_CENTRE = 16,
    FFP_FIX_ASPECT = 32
};

typedef struct FfpRigCalibration {
    // Folders of one attitude of the board each, or folders of such folders (docs/guide/own-rig.md). None:
    // only the turntable's board is used.
    const char *const *attitudes;
    int n_attitudes;
    int columns, rows; // inner corners of the board, where four squares meet
    double square;     // side of a square, which sets the unit of length of all results
    int width, height; // of the projector's panel, pixels, 64 to 16384
    // Folder of ffp_write_patterns, which then gives width and height: a folder of photographs may contain
    // one of each of its patterns, of which black, white and the codes are used. NULL: black, white and the
    // codes alone.
    const char *shown;
    unsigned fix_camera, fix_projector; // FFP_FIX_K1 and so on
    const char *file;                   // for the calibration: OpenCV FileStorage, XML or (.yml, .yaml) YAML
    const char *report;                 // for an HTML page, or NULL
    // The turntable's axis is found from a chessboard on it, photographed at known angles.
    const char *turntable_board; // folder of photographs in the order of the angles, or NULL
    const double *angles;        // of the table, degrees
    int n_angles;
    const char *turntable_file;      // for the axis in the format read by `import` (JSON)
    const char *const *calibrations; // without attitudes: files containing the camera's calibration
    int n_calibrations;
    // JSON file for where the board is in photographs: `attitudes` are files then, one photograph of the
    // board each, and nothing is calibrated. NULL: not wanted
    const char *seen;
} FfpRigCalibration;
FFP_API FfpRigCalibration ffp_rig_calibration_defaults(void); // nothing named or fixed, 1920 x 1080

typedef struct FfpRigCalibrationStats { // errors in pixels are root mean squares
    int attitudes, used;
    double camera, projector; // errors of the separate fits
    double both;              // error of all corners in both devices, with one pose of the board for both
    int corners, left_out;    // their number in camera and projector together, in the attitudes used
    int open_terms;           // terms that the photographs do not determine; warnings name them
    bool has_axis;            // the turntable's axis was found; the following fields describe it
    double axis[3], point[3]; // camera coordinates; points up in the picture
    bool reversed;            // the angles are left-handed about it: clockwise as seen from above
    int stops, stops_used;
    double stops_rms, tilt, shift; // standard deviations: degrees, unit of `square`
} FfpRigCalibrationStats;
// Calibrates camera and projector from photographs of a chessboard under Gray codes in at least three
// attitudes (Moreno and Taubin 2012), and finds a turntable's axis. Nothing is written until everything has
// been found. Fails with FFP_ERROR_UNSUPPORTED if the library was built without OpenCV. `stats` may be NULL.
FFP_API bool ffp_calibrate_rig(FfpContext *context, const FfpRigCalibration *options,
                               FfpRigCalibrationStats *stats, FfpError *err);

// Without a board: a projector that stands still, and either a camera at two places or more before anything
// that is not flat, or one that stands still too, and an object on a turntable.
typedef struct FfpSelfCalibration {
    // Folders of the photographs of one place of the camera, or of one stop of the turntable, each; or
    // folders of such folders, as FfpRigCalibration.attitudes: black, white and the Gray codes.
    const char *const *places;
    int n_places; // up to 64
    // By which the turntable has turned at each stop, in the order of `places`, degrees; they may be off by a
    // few. NULL: the camera walks.
    const double *angles;
    int n_angles;
    int width, height; // of the projector's panel, pixels, 64 to 16384
    const char *shown; // as FfpRigCalibration.shown, or NULL
    double focal_35mm; // the camera's focal length as that of a 35 mm camera, mm; 0: what its files tell
    // Distance of the first two places, or of projector and camera before a turntable, in the unit that is
    // wanted; 0: it is the unit.
    double length;
    const char *folder; // for the calibration of a walk: COLMAP's text model, in a new or empty folder
    // For that of a turntable, as those of FfpRigCalibration: OpenCV FileStorage, and the axis with the
    // angles that were found.
    const char *file, *turntable_file;
} FfpSelfCalibration;
FFP_API FfpSelfCalibration ffp_self_calibration_defaults(void); // nothing named, 1920 x 1080

typedef struct FfpSelfCalibrationStats {
    int places, used, points;                     // of the camera; of the surface
    double rms;                                   // of the points in the photographs, pixels
    double camera_focal, projector_focal;         // pixels
    double camera_uncertain, projector_uncertain; // standard deviations, as shares of them
    double turn_uncertain;                        // of the places' directions, degrees, the largest
    // Degrees between the rays by which the outermost cameras, or projector and camera before a turntable,
    // see a point, median.
    double parallax;
    bool has_axis;            // the following fields describe a turntable
    double axis[3], point[3]; // camera coordinates; points up in the picture
    bool reversed;            // the angles are left-handed about it: clockwise as seen from above
    double tilt, shift;       // standard deviations: degrees; share of the distance of the camera
    double surface;           // median distance of points that were turned to other stops, pixels there
    double angle_off;         // of the angles, degrees, the largest
} FfpSelfCalibrationStats;
// Finds optics and poses of projector and camera from the positions that the codes give, without a board. All
// places of a camera that walks see the same points of the surface by the same codes, which a bundle
// adjustment explains (Triggs et al. 2000); before a turntable, the surface of each stop turns into those of
// the others about one axis. Nothing is written until everything has been found. Fails where the photographs
// do not determine it, and says what to photograph; with FFP_ERROR_UNSUPPORTED if the library was built
// without OpenCV. `stats` may be NULL.
FFP_API bool ffp_self_calibrate(FfpContext *context, const FfpSelfCalibration *options,
                                FfpSelfCalibrationStats *stats, FfpError *err);

// --- Import of photographs and calibrations from other tools. ---

// How pictures relate to the size at which a device was calibrated: the same, scaled, or cut out of it.
typedef enum FfpFit { FFP_FIT_EXACT, FFP_FIT_SCALED, FFP_FIT_CROPPED } FfpFit;

typedef struct FfpCalibratedAt {
    int width, height; // pixels at calibration; 0: given by the calibration's files
    FfpFit fit;
    int left, top; // FFP_FIT_CROPPED: pixels cut off
} FfpCalibratedAt;

// Photographs under one pattern or several. `files` is a path containing {view}, {pattern}, {index} (from 0,
// among all views of the calibration), {number} (from 1) or {number:3} (zero-padded), which are substituted
// first. * matches the remaining files in order, img_9 before img_10: all patterns of the first view, then
// those of the second. Masks and Gray codes are named likewise.
typedef struct FfpImportImages {
    const char *const *patterns; // names: black, white, and the caller's names for the others
    int n_patterns; // 0: those of FfpImport.shown, in their order, with the Gray codes or without
    const char *files;
} FfpImportImages;

// The image that was sent to the projector.
typedef struct FfpImportPattern {
    const char *name, *file;
} FfpImportPattern;

typedef enum FfpMasks {
    FFP_MASKS_FROM_ALPHA, // the photographs' alpha channels if present, otherwise as below
    // All light, where nothing but the object is bright. Otherwise white minus black (Otsu 1979), with
    // shadows completed from four or more views; where these masks contradict each other and a turntable's
    // stops share a lit background: from what stays the same.
    FFP_MASKS_FROM_LIGHT,
    FFP_MASKS_FROM_FILES
} FfpMasks;

// An object that turned in front of a fixed camera and projector and was photographed at several stops, in
// camera coordinates (x right, y down, z forward) and the calibration's unit; angles in degrees, right-handed
// about the axis.
typedef struct FfpImportTurntable {
    // JSON or YAML {"axis", "point", "angles"}, or "count" and "step" instead of angles, or that of
    // ffp_calibrate_rig; NULL: the fields below.
    const char *file;
    double axis[3], point[3]; // direction, and any point on the axis
    const double *angles;     // rotation of the object at each stop; they replace those of the file
    int n_angles;             // 0, without a file: no turntable, and a fixed rig has one view
    bool find_axis;           // find axis and point from the pictures, ignoring those of the file
    bool guessed;             // start the search at `axis` and `point`
} FfpImportTurntable;

typedef struct FfpImport {
    const char *const *calibrations; // files (and folders) of one calibration
    int n_calibrations;
    const char *projector_image; // COLMAP: the image that stands for the projector; NULL: "calib"
    FfpImportTurntable turntable;
    const FfpImportImages *images; // none: the pictures named by the calibration
    int n_images;
    // Folder of ffp_write_patterns, which then says what the projector showed under each name. NULL:
    // `patterns` and `held_out` alone.
    const char *shown;
    const FfpImportPattern *patterns; // every pattern other than black and white
    int n_patterns;
    const FfpImportPattern *held_out; // likewise, for testing only
    int n_held_out;
    // Photographs of the Gray codes of `ffp_write_patterns` in their order, as FfpImportImages.files, where
    // {pattern} stands for gray_x_00, gray_x_00_inverse and so on. The capture then holds the projector
    // position that each pixel's light comes from. Without any other pattern besides black and white, one of
    // the codes becomes the pattern. NULL: none.
    const char *gray_codes;
    // The stage without the object, photographed like the views under black, white and, better, every other
    // pattern: what looks like it is background. On a turntable one picture each serves all views; elsewhere
    // `files` tells views apart. None: masks as below. Not with FFP_MASKS_FROM_FILES.
    const FfpImportImages *empty;
    int n_empty;
    FfpMasks masks;
    const char *mask_files;   // FFP_MASKS_FROM_FILES: as FfpImportImages.files, white on black
    const char *const *views; // ids to import; none: all
    int n_views;
    // Of the Gray codes, how many photographs a view keeps for fits: those whose stripes the capture's pixels
    // resolve, and that are not the same as a pattern above or its inverse. 0 to 32; 0: none. Default: 8.
    int kept_codes;
    FfpCalibratedAt camera, projector;
    int width; // of the imported pictures; 0: unchanged. Sides are padded to multiples of 8 pixels
    // Estimate the projector's gamma and black level from the pictures, and convert the patterns to the light
    // that it emitted, if that explains views better that are held out from the estimate.
    bool fit_response;
    // Integer PNG, JPEG and TIFF files hold linear light instead of sRGB: photographs; patterns.
    bool linear_images, linear_patterns;
    double exposure;  // exposure adjustment of linear values, in stops
    double object[4]; // centre and radius of a sphere around the object; radius 0: estimated
    // A whole scene, before which the projector stands and the camera walks: everything in view belongs to
    // it, lit or not. No masks, no turntable; depth is looked for without a sphere.
    bool scene;
    const char *name;   // of the capture; NULL: that of the folder
    const char *folder; // for the capture; must be new or empty
} FfpImport;
FFP_API FfpImport ffp_import_defaults(void); // nothing named, pictures unchanged, eight codes kept
// Writes a capture folder, completely or not at all: poses in the object's frame, pictures and patterns
// without lens distortion, masks applied.
FFP_API bool ffp_import_capture(FfpContext *context, const FfpImport *options, FfpError *err);

typedef struct FfpAlignmentStats {
    bool turntable; // the views come from a fixed rig around a turning object, and share a common pose
    double evened;  // rotation needed to share it: root mean square about a device's axis, degrees
    // Rotation of the camera in all views, degrees: towards the projector and across (the projector rotates
    // by as much the other way), and sideways (both together).
    double depth, across, side;
    bool own;      // each view received separate poses, in which case:
    double turned; // their rotation, root mean square about a device's axis, degrees
    // Before and after: root mean square distance between the camera's rays and the projector pixels that
    // they see, pixels of the projector.
    double off[2];
    double apart[2]; // before and after: distance between surfaces of different views, pixels of the camera
    double focal[2]; // factors on the focal lengths of camera and projector; 1: unchanged
    double before, after; // disagreement of the pictures: mean difference of pattern values, 0 to 1
    double seconds;       // of wall clock
    // With FfpAlignment.gaussians, when `before` and `after` compare photographs with drawn pictures,
    // sRGB-encoded: how far camera and projector were rotated about their centres, degrees, and moved, world
    // units; means over the views.
    bool known;
    double camera_turned, camera_moved, projector_turned, projector_moved;
} FfpAlignmentStats;
typedef struct FfpAlignment {
    const char *pattern; // name of the structured-light pattern to use; NULL: the first that every view has
    bool focal_lengths;  // also correct those of camera and projector, by the same factors in all views
    // The object as it is known, in the capture's world: each view's camera and projector are found again by
    // it, from that view's photographs alone, so one view is enough. Not with focal_lengths; `pattern` is
    // ignored. NULL: the poses are found from what the views have in common.
    const FfpGaussians *gaussians;
} FfpAlignment;
FFP_API FfpAlignment ffp_alignment_defaults(void); // only poses
// Corrects the poses of all cameras and projectors from the photographs, in place. Takes as long as about 75
// projector matchings, or with Gaussians as some 600 drawings of each view. `stats` may be NULL.
FFP_API bool ffp_align_poses(FfpContext *context, FfpCapture *capture, const FfpAlignment *options,
                             FfpAlignmentStats *stats, FfpError *err);

// Writes a capture folder (docs/reference/formats/capture.md), completely or not at all; it must be new or
// empty.
FFP_API bool ffp_capture_save(FfpContext *context, const FfpCapture *capture, const char *folder,
                              FfpError *err);
// Checks that the folder is new or empty, so that errors show before the work rather than after it.
FFP_API bool ffp_can_save_capture(const char *folder, FfpError *err);

// Measures kernels and whole steps against the limits of this machine. Returns readable tables (release with
// ffp_free), or NULL on failure, and writes JSON to a file unless `json` is NULL. Takes about a minute.
FFP_API char *ffp_benchmark(FfpContext *context, const char *json, FfpError *err);

// Describes a capture, a weights file or Gaussians (PLY, SPZ, glTF) in readable text (release with ffp_free);
// NULL on failure.
FFP_API char *ffp_info(FfpContext *context, const char *path, FfpError *err);
// Writes the same of a capture as an HTML page, with a contact sheet of its masks in which doubtful views are
// marked. Errors: `path` is not a capture.
FFP_API bool ffp_info_report(FfpContext *context, const char *path, const char *html, FfpError *err);
// The same as JSON (release with ffp_free): {"text": what ffp_info returns, "findings": [as
// ffp_finding_json]}, the latter for a capture.
FFP_API char *ffp_info_json(FfpContext *context, const char *path, FfpError *err);

#ifdef __cplusplus
}
#endif

#endif
