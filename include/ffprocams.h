// FF-ProCams in C: from eight photographed views of an object to relightable 3D Gaussians, and pictures of
// them under any pattern, camera pose and projector pose. This is the one public header.
//
// Every function that can fail returns false or NULL and leaves "WHAT (WHERE)" in the FfpError it was given
// (NULL is allowed). Handles are freed with their *_close; NULL is allowed there. Nothing is shared between
// handles: one handle, one thread at a time. Files are written to a temporary name and renamed, so an old
// file stays whole until the new one is.
#ifndef FFPROCAMS_H
#define FFPROCAMS_H

#include <stdbool.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

typedef struct FfpError {
    char text[768]; // "WHAT (WHERE)", WHERE being a file, "FILE: FIELD", or empty; "" when nothing failed
} FfpError;

const char *ffp_version(void); // "0.1.0"

// Whether the environment variable FFPROCAMS_CPU (portable, avx2, avx512, avx512bf16 or amx; unset: the best
// that runs here) names kernels that this processor can run. Without the check the best are used.
bool ffp_cpu_check(FfpError *err);

// --- What a rig saw: views of one object, each under a black, a white and further patterns. ---

typedef struct FfpCapture FfpCapture;

// `path` is a folder with scene.json or render_poses.json, or such a file. Everything in it is checked.
FfpCapture *ffp_capture_open(const char *path, FfpError *err);
void ffp_capture_close(FfpCapture *capture);

// --- Weights. ---

typedef struct FfpModel FfpModel;

// `path` NULL: the shipped weights, models/small.safetensors, looked up beside the program's folder, then in
// the current folder. An error says where it was looked for.
FfpModel *ffp_model_open(const char *path, FfpError *err);
void ffp_model_close(FfpModel *model);

// How Gaussians are drawn. The form: as the shipped model means them (firm splats, footprint lookup,
// shadows), or in the paper's plain form (blur 0.3 px, bilinear lookup, no shadows); a model knows its own.
typedef enum FfpForm { FFP_FORM_OURS, FFP_FORM_PAPER } FfpForm;
typedef struct FfpDrawing {
    FfpForm form;
    int samples; // a side of the grid of samples in each pixel, 1 to 4; 0: as the model has it, without one
                 // 2, or 1 in the paper's form
} FfpDrawing;

// --- The reconstruction. ---

typedef struct FfpGaussians FfpGaussians;

typedef struct FfpReconstruction {
    const FfpModel *model; // NULL: the classical start alone, without weights
    const char *pattern;   // name of the structured-light pattern to use; NULL: the first that every view has
    int64_t polish; // gradient steps, of one view each, that fit the prediction to the photographs it was
                    // made from: black, white and the pattern; 0: the forward pass alone; FFP_POLISH_AUTO
    double noise;   // deviation of the photographs' noise, linear, of values up to 1, to be taken away before
                    // all else; 0: none; FFP_NOISE_ESTIMATED: what the photographs tell
    double layers;  // how many times splats may describe a place of the surface, those of the views that see
                    // it finest; 0: a splat for every pixel of every view; FFP_LAYERS_AUTO: by their number
    FfpDrawing drawing; // of the polish
} FfpReconstruction;
#define FFP_POLISH_STEPS 100
#define FFP_POLISH_AUTO (-1) // FFP_POLISH_STEPS, and of more than 8 views 12.5 steps a view
#define FFP_NOISE_ESTIMATED (-1.0)
#define FFP_LAYERS_AUTO (-1.0) // all of up to 200,000 splats, else two layers

typedef struct FfpReconstructionStory { // how it went; seconds of wall clock
    char pattern[96];                   // the pattern that was used
    int64_t gaussians;
    double start_s, network_s;            // projector matching and the classical estimates; the network
    double polish_s;                      // with the choice of the splats that are polished
    double noise, denoise_s;              // deviation of what was taken away
    bool network_dropped, polish_dropped; // what made the photographs worse was left out
} FfpReconstructionStory;

// One forward pass and a short fit. Each is scored on the photographs: a prediction that shows them clearly
// worse than the classical start is dropped for it, and a fit that shows them worse than what it began with
// is left out; a line on stderr says so. The Gaussians are in the capture's world units. `story` may be NULL.
FfpGaussians *ffp_reconstruct(const FfpCapture *capture, const FfpReconstruction *options,
                              FfpReconstructionStory *story, FfpError *err);

// Binary PLY with the 3DGS property names, plus base_color_0..2 and roughness (docs/formats.md).
FfpGaussians *ffp_gaussians_open(const char *path, FfpError *err);
bool ffp_gaussians_save(const FfpGaussians *gaussians, const char *path, FfpError *err);
// Whether a file could be written there, told before the work rather than after it.
bool ffp_can_write(const char *path, FfpError *err);
int64_t ffp_gaussians_count(const FfpGaussians *gaussians);
void ffp_gaussians_close(FfpGaussians *gaussians);

// --- Pictures. ---

// What goes once round the object's centre: the camera, the projector, or the object itself (both devices
// the other way round).
typedef enum FfpOrbit { FFP_ORBIT_NONE, FFP_ORBIT_CAMERA, FFP_ORBIT_PROJECTOR, FFP_ORBIT_OBJECT } FfpOrbit;

typedef struct FfpPictures {
    const char *poses; // file of camera and projector poses (targets.json or scene.json); NULL: the capture's
    const char *const *views; // ids of the views to render; none: all
    int n_views;
    const char *const *patterns; // names of the capture's patterns, image files, or folders of these; none:
    int n_patterns;              // the white pattern
    FfpOrbit orbit;              // from the view given (at most one), else from the first
    int frames;                  // of the orbit; patterns follow each other evenly through it
    const char *video;           // animated PNG of all pictures in order, or NULL
    int rate;                    // its frames a second, 1 to 1000
    const char *folder; // where <view>_<pattern>.png goes, or with an orbit or a video frame_<number>.png;
                        // made when it is not there
    bool maps; // also the G-buffers: <view>_depth.exr and .png, _opacity, _normal, _albedo, _roughness,
               // _ambient
    FfpDrawing drawing;
} FfpPictures;

// Renders views under patterns into 8-bit sRGB files over black. One rasterisation a view serves all its
// patterns. Returns the number of pictures written, or -1. When it fails there is no video.
int ffp_render_pictures(const FfpGaussians *gaussians, const FfpCapture *capture, const FfpPictures *options,
                        FfpError *err);

// --- Fitting to one object's photographs. ---

typedef struct FfpRefinement {
    const char *const *patterns; // structured-light patterns to use beside black and white, which every view
    int n_patterns;              // must have; none: the one that a reconstruction would take
    int64_t steps;               // of one view each; 0: no limit
    double seconds;      // of wall clock; 0: no limit. With neither limit: 30 s, or 20000 steps from scratch
    double noise;        // as FfpReconstruction.noise
    uint64_t seed;       // of the order of views, and of the points that a fit from scratch starts from
    const char *metrics; // file for a line of JSON a round (step, seconds, loss, psnr, gaussians), or NULL
    FfpDrawing drawing;
} FfpRefinement;

typedef struct FfpRefinementStory {
    double psnr_before, psnr_after; // dB over the pictures fitted
    int64_t steps, gaussians;
    double seconds;
    bool stopped; // by SIGINT or SIGTERM: the best state so far is kept
    bool dropped; // the fit made the pictures worse: the Gaussians are what they were
} FfpRefinementStory;

// Fits the Gaussians, which stay near to what they were, to the capture's pictures. `story` may be NULL.
// With a limit in steps alone the same seed and number of threads give the same bits.
bool ffp_refine_gaussians(FfpGaussians *gaussians, const FfpCapture *capture, const FfpRefinement *options,
                          FfpRefinementStory *story, FfpError *err);
// The same without a prediction, the way GS-ProCams does it: points in the visual hull that grow, divide and
// vanish. For comparison: it takes far longer.
FfpGaussians *ffp_fit_from_scratch(const FfpCapture *capture, const FfpRefinement *options,
                                   FfpRefinementStory *story, FfpError *err);

// --- What to do with it: compensated projections and correspondence maps. ---

typedef struct FfpCompensation {
    const char *poses; // as FfpPictures.poses
    const char *const
        *views;  // ids of the views whose cameras are to see a target, all projectors shining at once;
    int n_views; // none: all
    const char *const *targets; // image files in the cameras' frames: one for all views, or one for each
    int n_targets;              // in their order; where a target is transparent it asks for nothing
    const char
        *pattern; // file for the pattern (PNG). Of several projectors, <pattern>_<view>.png each. Beside it
                  // <pattern>_seen_<view>.png, the picture predicted, and <pattern>_target_<view>.png
    double gain;  // factor of the linear targets; 0: the brightest that light allows
    bool paint;   // targets are light on the object: 0 its look under black, 1 its look under white (no gain)
    int steps;    // of gradient descent after the closed form; 0: none
    bool gaussians_only; // ambient light and response from the Gaussians even where the view has photographs
                         // under black and white
    FfpDrawing drawing;
} FfpCompensation;

typedef struct FfpCompensationStory {
    double gain;                        // that was used
    double unlit, too_dark, too_bright; // shares of the object's pixels that the targets ask about
    double psnr_dark, psnr_closed,
        psnr; // dB over the lit ones: with dark projectors, in closed form, at the end
    int patterns;
    double seconds;
} FfpCompensationStory;

// Finds the patterns under which the cameras see their targets as nearly as light allows. `story` may be
// NULL.
bool ffp_compensate(const FfpGaussians *gaussians, const FfpCapture *capture, const FfpCompensation *options,
                    FfpCompensationStory *story, FfpError *err);

typedef struct FfpMaps {
    const char *poses;        // as FfpPictures.poses
    const char *const *views; // ids; none: all
    int n_views;
    const char *folder; // for the files (docs/formats.md); made when it is not there
    FfpDrawing drawing;
} FfpMaps;

typedef struct FfpMapStory { // of one view
    char view[96];
    int lit_pixels,
        lost_pixels; // camera pixels that found the way to the projector and back; lit ones that did not
    double within_half, median, most; // of the former: share that came back within half a pixel; pixels
    double lit_share;                 // of the projector's pixels that fall on the object
} FfpMapStory;
enum { FFP_MAP_STORIES = 512 }; // as many views as there can be

// Writes correspondences and what the projector lights. Returns the number of files, or -1. `stories` is NULL
// or has room for all views.
int ffp_write_maps(const FfpGaussians *gaussians, const FfpCapture *capture, const FfpMaps *options,
                   FfpMapStory *stories, FfpError *err);

// --- Evaluation. ---

typedef enum FfpPredictor {
    FFP_PREDICT_GAUSSIANS, // reconstruct (or read) Gaussians and render them
    FFP_PREDICT_DEPTH,     // black + (white - black) * pattern, looked up at the capture's true depth
    FFP_PREDICT_MATCH,     // the same at the depth that projector matching finds
} FfpPredictor;

typedef struct FfpEvaluation {
    const char *const *captures; // folders or JSON files
    int n_captures;
    FfpPredictor predictor;
    const FfpModel *model;  // NULL: the classical start
    const char *model_name; // what the table and the report call it
    const char *gaussians;  // PLY to evaluate instead of reconstructing; NULL: reconstruct
    const char *const
        *targets; // pose files of novel_pose: none, one a capture, or one path looked up in each capture
    int n_targets;
    const char *pattern; // as FfpReconstruction.pattern
    int64_t polish;      // as FfpReconstruction.polish
    double noise;        // as FfpReconstruction.noise
    double layers;       // as FfpReconstruction.layers
    const char *save;    // folder for <capture>/<view>_<pattern>.png of every prediction, or NULL
    const char *json;    // file for the rows, or NULL
    const char *report;  // file for a self-contained HTML report, or NULL
    const char
        *show_pattern; // image file: the report also shows views under it (no truth, no figures), or NULL
    const char *perceptual; // safetensors with LPIPS weights, or NULL
    FfpDrawing drawing;
} FfpEvaluation;

// One row: a capture under a protocol. `rendering`: black, white and lollipops at the input poses;
// `novel_pattern`: every other pattern there; `novel_pose`: all pictures of the targets. Measured on the
// 8-bit prediction against the truth over black, sRGB-encoded. NAN where a figure does not apply. PSNR of
// identical pictures is 100.
typedef struct FfpScore {
    char capture[96];
    const char *protocol;
    double psnr, psnr_foreground, ssim, lpips; // means over the images; foreground: pixels the object covers
    double psnr_gloss; // under white, pixels whose specular part is above 0.05 (linear radiance) by the truth
    double psnr_unseen_lollipops; // `rendering` only: the lollipops that the predictor was not given
    int images, images_unseen;
    double reconstruct_s, render_s; // seconds: of the reconstruction; of all the row's pictures together
    // `rendering` of Gaussians only, where the capture holds the truth; over the input views' pixels that the
    // object fills. Depth: % of the object's radius, apart for pixels that the white pattern lights and those
    // that it does not; a pixel that shows no surface counts as 100.
    double depth_lit_median, depth_lit_p90, depth_unlit_median, depth_unlit_p90;
    double albedo_mse, albedo_lit_mse, albedo_unlit_mse; // linear; apart likewise
} FfpScore;

// Returns the rows (release with free) and their number, or NULL. Behind the rows of several captures stand
// those of their means, whose capture is "mean". JSON and report are written when all is
// done.
FfpScore *ffp_evaluate(const FfpEvaluation *options, int *n_scores, FfpError *err);

// --- Devices. ---

// What training runs on from now on: "cpu" (as at first) or "cuda", the first NVIDIA GPU. For the whole
// process. Errors: no such device, none found, a library built without it.
bool ffp_device_open(const char *name, FfpError *err);

// --- Training and its data. ---

typedef struct FfpTraining {
    const char *out;        // folder for checkpoint.safetensors, weights.safetensors, metrics.jsonl, pictures
    const char *config;     // JSON file, or NULL for the defaults
    const char *initial;    // weights to start from with a fresh optimiser, or NULL
    const char *perceptual; // safetensors of the perceptual term, or NULL: off
    int64_t steps;          // -1: as the configuration says
    int64_t stop_at;        // stop at this step with a checkpoint, as a signal would; 0: go to the end
    bool resume;            // go on from the checkpoint in `out`, with the configuration that stands in it
} FfpTraining;
// Runs to the end, or until SIGINT or SIGTERM, which write a checkpoint first.
bool ffp_train_model(const FfpTraining *options, FfpError *err);

typedef struct FfpGeneration {
    const char *folder;   // one capture folder a scene goes here
    const char *split;    // "train", "validation", "test"; NULL: all
    const char *preset;   // "paper", "smoke" or "training"
    int64_t first, count; // scenes of the split; count -1: to the end
    int resolution;       // image side; 0: as the preset says
    const char *rig;      // of the input views: "turntable" (NULL too) or "free" (docs/data.md, "Rigs")
    int views;            // input views, 1..64; 0: as the preset says
    uint64_t seed;
    const char *mesh;     // a user's OBJ, PLY, STL or glTF file instead of the generated meshes; NULL: none
    const char *material; // a user's folder of basecolor, roughness and normal maps; NULL: none
    const char *const *sensor; // "NAME=VALUE": faults of the devices (docs/data.md, "Sensor model")
    int n_sensor;
} FfpGeneration;
// Scenes that are there already are kept; one appears under its name only when it is whole. Any number of
// processes may share a job, each with its own range of scenes.
bool ffp_generate(const FfpGeneration *options, FfpError *err);

// --- Photographs and calibrations of other tools. ---

// How pictures came from the size that a device was calibrated at.
typedef enum FfpFit { FFP_FIT_EXACT, FFP_FIT_SCALED, FFP_FIT_CROPPED } FfpFit;

typedef struct FfpCalibratedAt {
    int width, height; // pixels at calibration, where its files do not say them; 0: they do
    FfpFit fit;
    int left, top; // FFP_FIT_CROPPED: pixels cut off
} FfpCalibratedAt;

typedef struct FfpImport {
    const char *const *calibrations; // files (and folders) of one calibration
    int n_calibrations;
    const char *projector_image; // COLMAP: the image that is the projector; NULL: "calib"
    const char *turntable; // "AX,AY,AZ,PX,PY,PZ,ANGLES" in camera coordinates, or a JSON file; NULL: none
    // Finds the axis from the pictures; `turntable` then has angles alone. "" or a first guess
    // "AX,AY,AZ,PX,PY,PZ"; NULL: not
    const char *fit_axis;
    // "NAME[,NAME..]=FILES", see ffprocams import --help; none: the pictures that the calibration names
    const char *const *images;
    int n_images;
    const char *const *patterns; // "NAME=FILE": what was projected
    int n_patterns;
    const char *const *held_out; // likewise, only ever to be predicted
    int n_held_out;
    const char *mask;         // files, like `images` without names; "otsu"; NULL: alpha channels, else Otsu
    const char *const *views; // ids to import; none: all
    int n_views;
    FfpCalibratedAt camera, projector;
    int width; // of the imported pictures; 0: as they are
    // Finds the projector's gamma and black level from the pictures, and makes the patterns the light that it
    // made of them
    bool fit_response;
    // PNG and JPEG files hold linear light instead of sRGB: the photographs; the patterns
    bool linear_images, linear_patterns;
    double exposure;    // stops by which linear values are brightened; 0: as they are
    double object[4];   // centre and radius of a sphere around the object; radius 0: estimated
    const char *name;   // of the capture; NULL: the folder's
    const char *folder; // the capture goes here; it must not hold anything yet
} FfpImport;
// Writes a capture folder, whole or not at all: poses in the object's frame, pictures and patterns without
// lens distortion, masks applied.
bool ffp_import_capture(const FfpImport *options, FfpError *err);

typedef struct FfpAlignStory {
    bool turntable; // the views are those of a fixed rig around a turning object, and share what is common to
                    // their poses
    double evened;  // turns that took: root mean square about a device's axis, degrees
    double depth, across,
        side;             // turns of the camera in all views, degrees: along the line to the projector and
                          // across it (the projector turns as much against it), and sideways (with it)
    double before, after; // disagreement of the pictures: mean difference of pattern values, 0 to 1
    double seconds;
} FfpAlignStory;
// Corrects the directions of all cameras and projectors from the photographs, in place. `pattern` as in
// FfpReconstruction. Takes some seventy-five projector matchings. `story` may be NULL.
bool ffp_align_poses(FfpCapture *capture, const char *pattern, FfpAlignStory *story, FfpError *err);

// Writes a capture folder (docs/formats.md), whole or not at all; it must be new or empty.
bool ffp_capture_save(const FfpCapture *capture, const char *folder, FfpError *err);
// Whether the folder is new or empty, told before the work rather than after it.
bool ffp_can_save_capture(const char *folder, FfpError *err);

// Measures kernels and whole steps against this machine's own limits, prints tables, and writes them as JSON
// too unless `json` is NULL. Takes about a minute.
bool ffp_benchmark(const char *json, FfpError *err);

// What a capture, a weights file or a PLY holds, as text for people (release with free); NULL on failure.
char *ffp_info(const char *path, FfpError *err);

#ifdef __cplusplus
}
#endif

#endif
