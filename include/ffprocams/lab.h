// For research: evaluation, training, generated data, other methods to compare with, and measurements of this
// machine.
#ifndef FFPROCAMS_LAB_H
#define FFPROCAMS_LAB_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include "ffprocams/reconstruct.h"

#ifdef __cplusplus
extern "C" {
#endif

// --- Evaluation. ---

typedef enum FfpPredictor {
    FFP_PREDICT_GAUSSIANS, // reconstruct (or read) Gaussians and render them
    FFP_PREDICT_DEPTH,     // black + (white - black) * pattern, looked up at the capture's true depth
    FFP_PREDICT_MATCH,     // the same, at the depth found by projector matching
} FfpPredictor;

typedef struct FfpEvaluation {
    size_t size;                 // set by ffp_evaluation_defaults
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
    const char *save;   // folder for every prediction, CAPTURE/VIEW_PATTERN.png, or NULL
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

FFP_DEFAULTS(FfpEvaluation, ffp_evaluation_defaults) // as ffp_reconstruction_defaults

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
    FFP_RESERVED;
} FfpScore;

// Returns the rows (release with ffp_free) and their number, or NULL. With several captures, their means
// follow as rows whose capture is "mean". JSON and report are written at the end. The ranks of a context
// divide the captures among themselves and all return all rows; rank 0 writes the files. A report requires a
// single process.
FFP_API FfpScore *ffp_evaluate(FfpContext *context, const FfpEvaluation *options, int *n_scores,
                               FfpError *err);

// --- Training and generated data. ---

typedef struct FfpTraining {
    size_t size;            // set by ffp_training_defaults
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
FFP_DEFAULTS(FfpTraining, ffp_training_defaults) // the configuration's values, to the end
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
    FFP_RESERVED;
} FfpSensorFaults;

// Faults of the devices that change light (docs/design/data.md, "Real light"). All 0: none.
typedef struct FfpLightFaults {
    double real_light;   // strength, 0 to 1, at which the seed draws all below that is 0
    double spread;       // share of the projector's light that is spread by a Gaussian, 0 to 0.5 ...
    double spread_reach; // ... of this standard deviation, pixels of a panel 800 wide, 0 to 200; 0: 12
    double glare;        // share of the camera's light likewise, 0 to 0.5 ...
    double glare_reach;  // ... share of the picture's longer side, 0 to 1; 0: 0.15
    double power;        // the projector sends value^power of the file's values, to 5; 0: sRGB and `gamma`
    double vignetting;   // share of the light that the camera loses at half a diagonal, 0 to 0.9
    double throw_fall;   // and the projector
    double focus_blur;   // standard deviation a world unit off the focal plane, pixels of a panel 800 wide
    double focus_at;     // that plane's distance, relative to the middle of the scene; 0: 1
    FFP_RESERVED;
} FfpLightFaults;

typedef struct FfpGeneration {
    size_t size;        // set by ffp_generation_defaults
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
    FfpLightFaults light;
    // The light of the photographs comes from another projector, on the other side of the camera. Needs
    // `photographs`, and no room.
    bool other_projector;
} FfpGeneration;
FFP_DEFAULTS(FfpGeneration, ffp_generation_defaults) // all scenes of all splits by the paper's preset
// Existing scenes are kept; a scene appears under its name only when it is complete. Any number of processes
// may share a job, each with its own range of scenes; the ranks of a context take scenes in turn.
FFP_API bool ffp_generate(FfpContext *context, const FfpGeneration *options, FfpError *err);

// --- Other methods, for comparison: fits to one object's photographs without a prediction, which take far
// longer than ffp_refine_gaussians, whose options and statistics they share. And a figure to compare any
// method by. ---

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

// --- Measurements of this machine. ---

// Measures kernels and whole steps against the limits of this machine. Returns readable tables (release with
// ffp_free), or NULL on failure, and writes JSON to a file unless `json` is NULL. Takes about a minute.
FFP_API char *ffp_benchmark(FfpContext *context, const char *json, FfpError *err);

#ifdef __cplusplus
}
#endif

#endif
