// FF-ProCams in C: from eight photographed views of an object to relightable 3D Gaussians, and pictures of
// them under any pattern, camera pose and projector pose. This is the one public header.
//
// Every function that can fail returns false or NULL and leaves "WHAT (WHERE)" in the FfpError it was given
// (NULL is allowed). What must not be left out (a handle, the options, a file to write) and is NULL is an
// FFP_ERROR_ARGUMENT that names it. What works long, says something or needs memory takes an FfpContext first
// (NULL: silent, all processors, no GPU). Handles are freed with their *_close; NULL is allowed there.
// Nothing is shared between handles: one handle, one thread at a time. Files are written to a temporary name
// and renamed, so an old file stays whole until the new one is. Numbers in files and texts have points
// whatever setlocale() was told.
#ifndef FFPROCAMS_H
#define FFPROCAMS_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include "ffprocams/api.h"
#include "ffprocams/context.h"
#include "ffprocams/error.h"

#ifdef __cplusplus
extern "C" {
#endif

FFP_API const char *ffp_version(void); // "0.2.0"

// Whether the environment variable FFPROCAMS_CPU (portable, avx2, avx512, avx512bf16 or amx; unset: the best
// that runs here) names kernels that this processor can run. Without the check the best are used.
FFP_API bool ffp_cpu_check(FfpError *err);

// --- What a rig saw: views of one object, each under a black, a white and further patterns. ---

typedef struct FfpCapture FfpCapture;

// `path` is a folder with scene.json or render_poses.json, or such a file. Everything in it is checked.
FFP_API FfpCapture *ffp_capture_open(FfpContext *context, const char *path, FfpError *err);
FFP_API void ffp_capture_close(FfpCapture *capture);

// A picture in the caller's memory, only ever read. The library keeps no pointer to it after the call.
typedef enum FfpPixelType {
    FFP_PIXELS_U8,  // sRGB-encoded, 0 to 255, straight alpha: as in PNG files
    FFP_PIXELS_U16, // the same, 0 to 65535
    FFP_PIXELS_F32, // linear light, colours multiplied by alpha already: as in EXR files
} FfpPixelType;
typedef struct FfpPicture {
    const void *data;            // rows from the top; NULL: no picture
    int width, height, channels; // 1 grey, 3 RGB, 4 RGB and alpha
    FfpPixelType type;
    size_t row_bytes; // from one row to the next; 0: rows follow each other
} FfpPicture;

// A camera without lens distortion; a projector is one whose light runs backwards. Axes: x right, y down, z
// forward; pixel centres at integer + 0.5.
typedef struct FfpPinhole {
    int width, height;     // pixels
    double fx, fy, cx, cy; // pixels; the principal point may lie outside the image
    double pose[16];       // row-major 4x4, device to world, rigid
} FfpPinhole;

// A capture from memory: what the files of a capture folder say (docs/formats.md).
typedef struct FfpPatternData {
    const char *name;
    FfpPicture picture; // of the projector's size; none: black or white without a picture
    bool held_out;      // only ever to be predicted: never chosen for a reconstruction unless it is named
} FfpPatternData;
typedef struct FfpViewData {
    const char *id;
    FfpPinhole camera, projector;
    const FfpPicture *photographs; // [n_patterns], of the camera's size; no data where there is none
    FfpPicture mask; // one channel: the object's share of each pixel; none: alpha of the photographs, else
                     // what white brightens
    bool masked;     // the photographs are over black already: the mask only says how much is the object's
    FfpPicture correspondence; // F32, three channels: where in the projector's picture (pixels) each pixel's
                               // light comes from, as Gray codes tell, and how far that is trusted, 0
                               // (unknown) to 1; none
    FfpPicture depth; // truth for evaluation, F32, one channel: camera z in world units, 0 where there is no
                      // surface; none
} FfpViewData;
typedef struct FfpCaptureData {
    const char *name;
    int n_patterns, n_views;
    const FfpPatternData *patterns;
    const FfpViewData *views;
    int black, white;         // which patterns
    double intensity[3];      // the projector's radiant intensity at pattern value 1; all 0: estimated
    double centre[3], radius; // sphere around the object, world units; radius 0: estimated
} FfpCaptureData;

// Copies and checks everything. Errors name the view, pattern or number.
FFP_API FfpCapture *ffp_capture_from_memory(FfpContext *context, const FfpCaptureData *data, FfpError *err);

// What a capture holds. Indices out of range: NULL, false.
FFP_API int ffp_capture_views(const FfpCapture *capture);
FFP_API int ffp_capture_patterns(const FfpCapture *capture);
FFP_API const char *ffp_capture_view_id(const FfpCapture *capture, int view);
FFP_API const char *ffp_capture_pattern_name(const FfpCapture *capture, int pattern);
// What a pattern is there for; an index out of range: FFP_PATTERN_ACTIVE.
typedef enum FfpPatternRole {
    FFP_PATTERN_ACTIVE, // may serve as structured light
    FFP_PATTERN_BLACK,
    FFP_PATTERN_WHITE,
    FFP_PATTERN_HELD_OUT, // only ever to be predicted
} FfpPatternRole;
FFP_API FfpPatternRole ffp_capture_pattern_role(const FfpCapture *capture, int pattern);
// `camera` or `projector` may be NULL: it is not asked for.
FFP_API bool ffp_capture_view_devices(const FfpCapture *capture, int view, FfpPinhole *camera,
                                      FfpPinhole *projector);
// Linear RGB of the library's own, valid until the capture is closed; a picture without data where the view
// has none. View -1: the pattern itself.
FFP_API FfpPicture ffp_capture_picture(const FfpCapture *capture, int view, int pattern);
FFP_API FfpPicture ffp_capture_coverage(const FfpCapture *capture,
                                        int view); // the object's share of each pixel
FFP_API void ffp_capture_intensity(const FfpCapture *capture, double intensity[3]);
FFP_API void ffp_capture_bounds(const FfpCapture *capture, double centre[3], double *radius);

// --- Weights. ---

typedef struct FfpModel FfpModel;

// `path` NULL: the shipped weights, small.safetensors. They are looked for in the folder that the environment
// variable FFPROCAMS_MODELS names, and if it names none in share/ffprocams/models of the prefix where the
// library is installed (the program, where it is linked into one), in models/ beside it, and in models/ of
// the current folder. An error says where it was looked for.
FFP_API FfpModel *ffp_model_open(FfpContext *context, const char *path, FfpError *err);
FFP_API void ffp_model_close(FfpModel *model);

// How Gaussians are drawn. The form: as the shipped model means them (firm splats, footprint lookup,
// shadows), or in the paper's plain form (blur 0.3 px, bilinear lookup, no shadows); a model knows its own.
// Or as GS-ProCams' released program does: the paper's form, in light without cosine and falloff.
typedef enum FfpForm { FFP_FORM_OURS, FFP_FORM_PAPER, FFP_FORM_GS_PROCAMS } FfpForm;
typedef struct FfpDrawing {
    FfpForm form;
    int samples; // a side of the grid of samples in each pixel, 1 to 4; 0: as the model has it, without one
                 // 2, or 1 in the paper's form
} FfpDrawing;

// --- The reconstruction. ---

typedef struct FfpGaussians FfpGaussians;

typedef struct FfpReconstruction {
    const FfpModel *model;       // NULL: the classical start alone, without weights
    const char *const *patterns; // names of the structured-light patterns to use. Every view has the first,
                                 // which the network sees; matching and the polish look at all of them, where
                                 // a view has photographs under them
    int n_patterns;              // none: the first pattern that every view has
    int64_t polish; // gradient steps, of one view each, that fit the prediction to the photographs it was
                    // made from: black, white and the patterns; 0: the forward pass alone; FFP_POLISH_AUTO
    double noise;   // deviation of the photographs' noise, linear, of values up to 1, to be taken away before
                    // all else; 0: none; FFP_NOISE_ESTIMATED: what the photographs tell
    double layers;  // how many times splats may describe a place of the surface, those of the views that see
                    // it finest; 0: a splat for every pixel of every view; FFP_LAYERS_AUTO: by their number
    FfpDrawing drawing; // of the polish
} FfpReconstruction;
#define FFP_POLISH_STEPS 88
#define FFP_POLISH_AUTO (-1) // FFP_POLISH_STEPS, and of more than 8 views 11 steps a view
#define FFP_NOISE_ESTIMATED (-1.0)
#define FFP_LAYERS_AUTO (-1.0) // all of up to 200,000 splats, else two layers

// The shipped model's drawing, automatic polish, noise and layers; `model` is to be set.
FFP_API FfpReconstruction ffp_reconstruction_defaults(void);

typedef struct FfpReconstructionStats { // how it went; seconds of wall clock
    char pattern[96];                   // the pattern that was used, of several the first
    int patterns;                       // how many were
    int64_t gaussians;
    double start_s, network_s;            // projector matching and the classical estimates; the network
    double polish_s;                      // with the choice of the splats that are polished
    double noise, denoise_s;              // deviation of what was taken away
    bool network_dropped, polish_dropped; // what made the photographs worse was left out
} FfpReconstructionStats;

// One forward pass and a short fit. Each is scored on the photographs: a prediction that shows them clearly
// worse than the classical start is dropped for it, and a fit that shows them worse than what it began with
// is left out; a note says so. The Gaussians are in the capture's world units. `stats` may be NULL.
FFP_API FfpGaussians *ffp_reconstruct(FfpContext *context, const FfpCapture *capture,
                                      const FfpReconstruction *options, FfpReconstructionStats *stats,
                                      FfpError *err);

// Binary PLY with the 3DGS property names, plus base_color_0..2 and roughness (docs/formats.md). Gaussians
// too faint ever to be drawn (opacity below 1/255) are left out; when all of them are, that is an error.
FFP_API FfpGaussians *ffp_gaussians_open(FfpContext *context, const char *path, FfpError *err);
FFP_API bool ffp_gaussians_save(FfpContext *context, const FfpGaussians *gaussians, const char *path,
                                FfpError *err);
// Whether a file could be written there, told before the work rather than after it.
FFP_API bool ffp_can_write(const char *path, FfpError *err);
FFP_API int64_t ffp_gaussians_count(const FfpGaussians *gaussians);
FFP_API void ffp_gaussians_close(FfpGaussians *gaussians);

// The numbers themselves, one row a Gaussian. Pointers are the library's, valid until the Gaussians are
// closed, refined or given other numbers; they may be written to.
typedef struct FfpGaussianArrays {
    int64_t count;
    float *centre;    // [count,3] world
    float *scale;     // [count,3] standard deviations along the rotated axes, world units, above 0
    float *rotation;  // [count,4] unit quaternion w x y z: the splat's axes to the world
    float *opacity;   // [count] in [0,1]
    float *albedo;    // [count,3] linear diffuse albedo
    float *roughness; // [count] in [0,1]
    float *ambient;   // [count,3] linear radiance shown when the projector is black
} FfpGaussianArrays;
FFP_API FfpGaussianArrays ffp_gaussians_arrays(FfpGaussians *gaussians);
// A copy of the caller's numbers, checked: finite, in range, rotations normalised. Errors name array and row.
FFP_API FfpGaussians *ffp_gaussians_from_arrays(FfpContext *context, const FfpGaussianArrays *arrays,
                                                FfpError *err);

// --- Drawing into memory. ---

// One view of Gaussians, rasterised once and shown under any number of patterns.
typedef struct FfpRenderer FfpRenderer;
FFP_API FfpRenderer *ffp_renderer_new(FfpContext *context, FfpDrawing drawing, FfpError *err);
FFP_API void ffp_renderer_close(FfpRenderer *renderer);
// Rasterises for a camera and maps what it sees to a projector. The Gaussians are not looked at again. Any
// sizes from 1 to 16384 a side.
FFP_API bool ffp_renderer_aim(FfpContext *context, FfpRenderer *renderer, const FfpGaussians *gaussians,
                              const FfpPinhole *camera, const FfpPinhole *projector, FfpError *err);
// The camera's picture of the object over black under `pattern` (of the projector's size; no data: a dark
// projector), for a projector of the given radiant intensity. out [height,width,3], sRGB-encoded: U8 rounded
// as files are, F32 in [0,1]; `row_bytes` 0: rows follow each other.
FFP_API bool ffp_renderer_shade(FfpContext *context, FfpRenderer *renderer, const FfpPicture *pattern,
                                const double intensity[3], void *out, FfpPixelType type, size_t row_bytes,
                                FfpError *err);
// Means over each pixel, F32 [height,width,channels].
typedef enum FfpMap {
    FFP_MAP_OPACITY,   // 1 channel, in [0,1]
    FFP_MAP_DEPTH,     // 1: camera z in world units, 0 where the opacity is below one half
    FFP_MAP_NORMAL,    // 3: world, unit length, facing the camera; 0 where there is none
    FFP_MAP_ALBEDO,    // 3: linear
    FFP_MAP_ROUGHNESS, // 1
    FFP_MAP_AMBIENT,   // 3: linear radiance, premultiplied by opacity
    FFP_MAP_COUNT
} FfpMap;
FFP_API int ffp_map_channels(FfpMap map);
FFP_API bool ffp_renderer_map(FfpContext *context, FfpRenderer *renderer, FfpMap map, float *out,
                              FfpError *err);

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
    int width, height; // of the pictures; 0: as the camera's. The width is a scale; another shape shows more
                       // or less above and below, the principal point keeping its share of the height.
                       // height 0: of the camera's shape
    double intensity[3]; // of the projector, radiant, at pattern value 1; all 0: as the capture says, or
                         // without one the file of poses
    FfpOrbit orbit;      // from the view given (at most one), else from the first
    int frames;          // of the orbit; patterns follow each other evenly through it
    const char *video;   // film of all pictures in order, or NULL: an animated PNG (.png, .apng), or by
                         // the program ffmpeg .gif, .mp4, .webm, .mkv
    int rate;            // its frames a second, 1 to 1000
    const char *folder;  // where <view>_<pattern>.png goes, or with an orbit or a video frame_<number>.png;
                         // made when it is not there
    bool maps; // also the G-buffers: <view>_depth.exr and .png, _opacity, _normal, _albedo, _roughness,
               // _ambient
    FfpDrawing drawing;
} FfpPictures;

FFP_API FfpPictures ffp_pictures_defaults(void); // all views under white, 15 frames a second

// Renders views under patterns into 8-bit sRGB files over black. One rasterisation a view serves all its
// patterns. Two files of one name are an error before the work; only frames may show a view twice. `capture`
// may be NULL where `poses` names a file: then the views, the projector's size and intensity and the patterns
// are that file's, whose photographs need not be there. What it does not say comes from here: the intensity,
// and the size of the first pattern that is an image file. Returns the number of pictures written, or -1.
// When it fails there is no video.
FFP_API int ffp_render_pictures(FfpContext *context, const FfpGaussians *gaussians, const FfpCapture *capture,
                                const FfpPictures *options, FfpError *err);

// Named float images that a call has made.
typedef struct FfpImages FfpImages;
typedef struct FfpNamedImage {
    const char *name; // NULL: no such image
    int width, height, channels;
    const float *data; // [height,width,channels], the library's, valid until the images are closed
} FfpNamedImage;
FFP_API int ffp_images_count(const FfpImages *images);
FFP_API FfpNamedImage ffp_images_at(const FfpImages *images, int index);
FFP_API FfpNamedImage ffp_images_find(const FfpImages *images, const char *name);
FFP_API void ffp_images_close(FfpImages *images);

// --- A page to look at. ---

typedef struct FfpViewing {
    const char *file;  // the page, one HTML file that needs nothing else
    const char *poses; // file of more poses to jump to (targets.json or scene.json), or NULL
    int photographs;   // longest side, pixels, of the photographs that go into it; 0: none
    FfpDrawing drawing;
} FfpViewing;
FFP_API FfpViewing ffp_viewing_defaults(void); // photographs of 512 pixels

typedef struct FfpViewingStats {
    int64_t gaussians;
    long long bytes;           // of the file
    int patterns, photographs; // in it; a note says when there was no room for all
} FfpViewingStats;
// Writes a page on which Gaussians are drawn by the browser (WebGL 2) as ffp_render_pictures draws them,
// while camera and projectors are moved (docs/view.md). `capture` must not be NULL. `stats` may be NULL.
// FFP_ERROR_UNSUPPORTED: the form is GS-ProCams', whose light the page does not know.
FFP_API bool ffp_view(FfpContext *context, const FfpGaussians *gaussians, const FfpCapture *capture,
                      const FfpViewing *options, FfpViewingStats *stats, FfpError *err);

// --- Fitting to one object's photographs. ---

typedef struct FfpRefinement {
    const char *const *patterns; // structured-light patterns to use beside black and white, as
    int n_patterns;              // FfpReconstruction.patterns; of a neural field every view has all of them
    int64_t steps;               // of one view each; 0: no limit
    double seconds;      // of wall clock; 0: no limit. With neither limit: 30 s, or 20000 steps from scratch
    double noise;        // as FfpReconstruction.noise
    uint64_t seed;       // of the order of views, and of the points that a fit from scratch starts from
    const char *metrics; // file for a line of JSON a round (step, seconds, loss, psnr, gaussians), or NULL
    const char *checkpoint; // ffp_fit_neural_field only: file that is written every two minutes and at the
                            // end, and from which the same fit goes on if it is there; or NULL
    FfpDrawing drawing;
} FfpRefinement;

FFP_API FfpRefinement ffp_refinement_defaults(void); // 30 seconds, noise estimated

typedef struct FfpRefinementStats {
    double psnr_before, psnr_after; // dB over the pictures fitted
    int64_t steps, gaussians;
    double seconds;
    bool stopped; // by the progress callback: the best state so far is kept
    bool dropped; // the fit made the pictures worse: the Gaussians are what they were
} FfpRefinementStats;

// Fits the Gaussians, which stay near to what they were, to the capture's pictures; when it fails they are
// what they were. `stats` may be NULL. A fit that is cancelled has succeeded (`stopped`). With a limit in
// steps alone the same seed and number of threads give the same bits.
FFP_API bool ffp_refine_gaussians(FfpContext *context, FfpGaussians *gaussians, const FfpCapture *capture,
                                  const FfpRefinement *options, FfpRefinementStats *stats, FfpError *err);
// The same without a prediction, the way GS-ProCams does it: points in the visual hull that grow, divide and
// vanish. For comparison: it takes far longer. Cancelled before there are points, it has failed.
FFP_API FfpGaussians *ffp_fit_from_scratch(FfpContext *context, const FfpCapture *capture,
                                           const FfpRefinement *options, FfpRefinementStats *stats,
                                           FfpError *err);

// A neural reflectance field, the form of Nepmap: density, material and what light reaches each point by
// small networks. For comparison too: it is drawn by ffp_evaluate alone.
typedef struct FfpNeuralField FfpNeuralField;
// Fits one to the capture's pictures: `drawing` is not looked at; without a limit 300 s. Stats: psnr_before
// and gaussians are 0, psnr_after is of up to 16 views. With a limit in steps alone the same seed gives the
// same bits.
FFP_API FfpNeuralField *ffp_fit_neural_field(FfpContext *context, const FfpCapture *capture,
                                             const FfpRefinement *options, FfpRefinementStats *stats,
                                             FfpError *err);
FFP_API FfpNeuralField *ffp_neural_field_open(FfpContext *context, const char *path, FfpError *err);
FFP_API bool ffp_neural_field_save(FfpContext *context, const FfpNeuralField *field, const char *path,
                                   FfpError *err);
FFP_API void ffp_neural_field_close(FfpNeuralField *field);

// --- What to do with it: compensated projections and correspondence maps. ---

typedef struct FfpCompensation {
    const char *poses; // as FfpPictures.poses
    const char *const
        *views;  // ids of the views whose cameras are to see a target, all projectors shining at once;
    int n_views; // none: all
    const char *const *targets; // image files in the cameras' frames: one for all views, or one for each
    const FfpPicture *pictures; // targets from memory instead of files, as many
    int n_targets;              // in their order; where a target is transparent it asks for nothing
    const char
        *pattern; // file for the pattern (PNG). Of several projectors, <pattern>_<view>.png each. Beside it
                  // <pattern>_seen_<view>.png, the picture predicted, and <pattern>_target_<view>.png
    double gain;  // factor of the linear targets; 0: the brightest that light allows
    bool paint;   // targets are light on the object: 0 its look under black, 1 its look under white (no gain)
    int steps;    // of gradient descent after the closed form; 0: none
    bool gaussians_only; // ambient light and response from the Gaussians even where the view has photographs
                         // under black and white
    bool for_device;     // patterns for the real projector, which the capture must know (docs/formats.md,
                         // projector.device): of its panel's size, with its lens's distortion and gamma
    FfpDrawing drawing;
} FfpCompensation;

FFP_API FfpCompensation ffp_compensation_defaults(void); // all views, gain 1, 30 steps

typedef struct FfpCompensationStats {
    double gain;                        // that was used
    double unlit, too_dark, too_bright; // shares of the object's pixels that the targets ask about
    double psnr_dark, psnr_closed,
        psnr; // dB over the lit ones: with dark projectors, in closed form, at the end
    int patterns;
    double seconds;
} FfpCompensationStats;

// Finds the patterns under which the cameras see their targets as nearly as light allows: linear images
// called pattern_<view> (of the projector's size, or its panel's, one for each projector), seen_<view> and
// target_<view> (of the camera's). `pattern` of the options is not looked at. `stats` may be NULL.
FFP_API FfpImages *ffp_compensate_images(FfpContext *context, const FfpGaussians *gaussians,
                                         const FfpCapture *capture, const FfpCompensation *options,
                                         FfpCompensationStats *stats, FfpError *err);
// The same into files. `stats` may be NULL.
FFP_API bool ffp_compensate(FfpContext *context, const FfpGaussians *gaussians, const FfpCapture *capture,
                            const FfpCompensation *options, FfpCompensationStats *stats, FfpError *err);

typedef struct FfpMaps {
    const char *poses;        // as FfpPictures.poses
    const char *const *views; // ids; none: all
    int n_views;
    const char *folder; // for the files (docs/formats.md); made when it is not there
    FfpDrawing drawing;
} FfpMaps;

FFP_API FfpMaps ffp_maps_defaults(void); // all views

typedef struct FfpMapStats { // of one view
    char view[96];
    int lit_pixels,
        lost_pixels; // camera pixels that found the way to the projector and back; lit ones that did not
    double within_half, median, most; // of the former: share that came back within half a pixel; pixels
    double lit_share;                 // of the projector's pixels that fall on the object
} FfpMapStats;
enum { FFP_MAP_STATS = 512 }; // as many views as there can be

// Correspondences and what the projector lights, for one camera and one projector: linear images called as
// the files are (docs/formats.md): camera_to_projector, projector_to_camera, projector_sees, lit, incidence,
// density, resolution, illuminance. `stats` may be NULL.
FFP_API FfpImages *ffp_map_images(FfpContext *context, const FfpGaussians *gaussians,
                                  const FfpCapture *capture, const FfpPinhole *camera,
                                  const FfpPinhole *projector, FfpDrawing drawing, FfpMapStats *stats,
                                  FfpError *err);
// The same for views of a capture or of poses, into files. Returns the number of files, or -1. `stats` is
// NULL or has room for all views.
FFP_API int ffp_write_maps(FfpContext *context, const FfpGaussians *gaussians, const FfpCapture *capture,
                           const FfpMaps *options, FfpMapStats *stats, FfpError *err);

// --- For other programs. ---

// The world's axis that points up.
typedef enum FfpUp { FFP_UP_Z, FFP_UP_Y, FFP_UP_MINUS_Y } FfpUp;

typedef struct FfpExport {
    const char *file; // what it is, its ending says: splats as .ply (the layout of 3DGS), .spz, .gltf or .glb
                      // (KHR_gaussian_splatting); a mesh as .glb, .gltf or .obj
    bool mesh;        // a closed surface with albedo and roughness in place of splats
    int resolution;   // of the mesh: cells along its longest side, 16 to 512
    // The colour that splats get: NULL or "ambient": ambient light alone; "white", the name of one of the
    // capture's patterns or an image file: under that pattern too, by the light model at each Gaussian, with
    // shadows
    const char *light;
    const char *poses;          // as FfpPictures.poses
    const char *projector_view; // whose projector shines; NULL: the first
    const char *camera_view;    // from whose camera highlights are seen; NULL: no highlights
    FfpUp up;                   // of the Gaussians' world; files have the axes that their format asks for
    FfpForm form;               // in which the Gaussians are drawn
} FfpExport;
FFP_API FfpExport ffp_export_defaults(void); // ambient light, z up, a mesh of 128 cells

typedef struct FfpExportStats {
    int64_t splats, triangles, bytes; // written
} FfpExportStats;
// Writes Gaussians for programs that know nothing of projectors. `capture` may be NULL for splats in ambient
// light; a mesh is made of what its cameras see. `stats` may be NULL.
FFP_API bool ffp_export(FfpContext *context, const FfpGaussians *gaussians, const FfpCapture *capture,
                        const FfpExport *options, FfpExportStats *stats, FfpError *err);

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
    const char *model_name; // what JSON and report call the predictor; NULL: its file, or what it is
    const char *gaussians;  // PLY to evaluate instead of reconstructing; NULL: reconstruct
    const char *field;      // file of a neural field to evaluate instead; NULL: none
    const char *const
        *targets; // pose files of novel_pose: none, one a capture, or one path looked up in each capture
    int n_targets;
    const char *const *patterns; // as FfpReconstruction.patterns
    int n_patterns;
    int64_t polish;     // as FfpReconstruction.polish
    double noise;       // as FfpReconstruction.noise
    double layers;      // as FfpReconstruction.layers
    const char *save;   // folder for <capture>/<view>_<pattern>.png of every prediction, or NULL
    const char *json;   // file for the rows, or NULL
    const char *report; // file for a self-contained HTML report, or NULL
    const char
        *show_pattern;  // image file: the report also shows views under it (no truth, no figures), or NULL
    const char *viewer; // page that the report links to, relative to it, or NULL
    const char *perceptual; // safetensors with LPIPS weights, or NULL
    FfpDrawing drawing;
    const char *const *merged; // files that earlier evaluations wrote as `json`: their rows are taken, and no
    int n_merged;              // capture is evaluated
} FfpEvaluation;

FFP_API FfpEvaluation ffp_evaluation_defaults(void); // as ffp_reconstruction_defaults

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

// Returns the rows (release with ffp_free) and their number, or NULL. Behind the rows of several captures
// stand those of their means, whose capture is "mean". JSON and report are written when all is done. Ranks of
// a context share the captures out, and all return all rows; rank 0 writes. A report is one process's.
FFP_API FfpScore *ffp_evaluate(FfpContext *context, const FfpEvaluation *options, int *n_scores,
                               FfpError *err);

// --- Training and its data. ---

typedef struct FfpTraining {
    const char *out;        // folder for checkpoint.safetensors, weights.safetensors, metrics.jsonl, pictures
    const char *config;     // JSON file, or NULL for the defaults
    const char *initial;    // weights to start from with a fresh optimiser, or NULL
    const char *perceptual; // safetensors of the perceptual term, or NULL: off
    // Folder of captures, of which only the photographs are learnt from: fine-tuning of `initial` (NULL: of
    // the shipped weights) to one's own devices. Every fourth capture is held out, and the weights that are
    // written are those that predict its photographs best, the first included. NULL: scenes are generated or
    // read
    const char *captures;
    int64_t steps;   // -1: as the configuration says
    int64_t stop_at; // stop at this step with a checkpoint, as a signal would; 0: go to the end
    bool resume;     // go on from the checkpoint in `out`, with the configuration that stands in it
} FfpTraining;
FFP_API FfpTraining ffp_training_defaults(void); // the configuration's own, to the end
// Runs to the end, or until it is cancelled: then it writes a checkpoint first, and has succeeded.
FFP_API bool ffp_train_model(FfpContext *context, const FfpTraining *options, FfpError *err);

// Which of the generated objects: no mesh is in two of the splits.
typedef enum FfpSplit { FFP_SPLIT_ALL, FFP_SPLIT_TRAIN, FFP_SPLIT_VALIDATION, FFP_SPLIT_TEST } FfpSplit;

// 8 views of 128 x 128 pixels and 6 lollipops; small and quick; what training makes for itself.
typedef enum FfpPreset { FFP_PRESET_PAPER, FFP_PRESET_SMOKE, FFP_PRESET_TRAINING } FfpPreset;

// Camera and projector stay and the object turns; each view has devices of its own, all around the object; or
// object and projector stay and the camera goes around in a spiral (docs/data.md, "Rigs").
typedef enum FfpRig { FFP_RIG_TURNTABLE, FFP_RIG_FREE, FFP_RIG_SPHERE } FfpRig;

// Faults of the devices (docs/data.md, "Sensor model"). All 0: none.
typedef struct FfpSensorFaults {
    double exposure;    // of the camera, stops, -8 to 8
    double shot, read;  // noise of a linear value v: variance shot * v + read^2; 0 to 1 each
    double defocus;     // of the projector: deviation, in its pixels, 0 to 64
    double gamma;       // the projector sends value^(1 + gamma), -0.9 to 4 ...
    double black_level; // ... and this share of white where a pattern is black, 0 to 0.9
    double turn_error;  // deviation of the written poses' turns on each axis, degrees, 0 to 28
    double shift_error; // and of their places, world units, 0 to 0.5
} FfpSensorFaults;

typedef struct FfpGeneration {
    const char *folder; // one capture folder a scene goes here
    FfpSplit split;
    FfpPreset preset;
    int64_t first, count; // scenes of the split; count -1: to the end, of an own mesh one
    int resolution;       // image side; 0: as the preset says
    FfpRig rig;           // of the input views
    int views;            // input views, 1..360; 0: as the preset says
    uint64_t seed;
    const char *mesh;     // a user's OBJ, PLY, STL or glTF file instead of the generated meshes; NULL: none
    const char *material; // a user's folder of basecolor, roughness and normal maps; NULL: none
    FfpSensorFaults sensor;
    // Folder of patterns (ffp_write_patterns): instead of captures, photographs of one object on a turntable
    // under all of them and of a chessboard, by a rig with lenses, go into `folder`, which is to be new or
    // empty (docs/data.md, "Photographs"). Of the preset only the samples count; resolution is their height
    // (0: 480). NULL: captures
    const char *photographs;
    int attitudes; // in which the chessboard is held; 0: without one; 64 at most
    bool check;    // make nothing: an error that names the scenes which are not there, whole
} FfpGeneration;
FFP_API FfpGeneration ffp_generation_defaults(void); // all scenes of all splits by the paper's preset
// Scenes that are there already are kept; one appears under its name only when it is whole. Any number of
// processes may share a job, each with its own range of scenes; ranks of a context each make those whose turn
// it is.
FFP_API bool ffp_generate(FfpContext *context, const FfpGeneration *options, FfpError *err);

// --- What a projector shows while it is photographed. ---

typedef struct FfpPatterns {
    const char *folder; // for the pictures, README.txt and show.html; must be new or empty
    int width, height;  // of the projector's panel, pixels, 64 to 16384
    int lollipops;      // 0 to 100
    bool focus;         // a chart to focus and to place the object by
    bool capture;       // black, white and the lollipops
    bool gamma;         // 16 steps of grey
    bool gray_codes;    // of columns and rows, each with its inverse
} FfpPatterns;

FFP_API FfpPatterns ffp_patterns_defaults(void); // everything, three lollipops, 1920 x 1080
// Writes <number>_<name>.png in the order to show them, a text that says how, and a page that shows them full
// screen in a browser. Whole or not at all. Returns the number of pictures, or -1.
FFP_API int ffp_write_patterns(FfpContext *context, const FfpPatterns *options, FfpError *err);

// --- The rig's own calibration. ---

// Terms of a device that are not fitted: lens terms are 0 then, the principal point the middle, fx = fy.
enum {
    FFP_FIX_K1 = 1,
    FFP_FIX_K2 = 2,
    FFP_FIX_K3 = 4,
    FFP_FIX_TANGENTIAL = 8, // p1 and p2
    FFP_FIX_CENTRE = 16,
    FFP_FIX_ASPECT = 32
};

typedef struct FfpRigCalibration {
    const char *const
        *attitudes;    // folders of one attitude of the board each, or folders of such (docs/calibrate.md)
    int n_attitudes;   // none: only the turntable's board is looked at
    int columns, rows; // corners inside the board, where four squares meet
    double square;     // side of a square: the unit of length of all that comes out
    int width, height; // of the projector's panel, pixels, 64 to 16384
    unsigned fix_camera, fix_projector;
    const char *file;   // for the calibration: OpenCV's FileStorage, XML or (.yml, .yaml) YAML
    const char *report; // for an HTML page, or NULL
    // A chessboard on the turntable, photographed at known angles, tells its axis.
    const char *turntable_board; // folder of photographs in the order of the angles, or NULL
    const double *angles;        // degrees by which the table had turned
    int n_angles;
    const char *turntable_file;      // for axis and angles as `import` reads them (JSON)
    const char *const *calibrations; // without attitudes: files that hold the camera's calibration
    int n_calibrations;
} FfpRigCalibration;
FFP_API FfpRigCalibration ffp_rig_calibration_defaults(void); // nothing named or fixed, 1920 x 1080

typedef struct FfpRigCalibrationStats { // pixels are root mean squares
    int attitudes, used;
    double camera, projector; // each one's fit alone
    double both;              // of all corners in both, with one pose of the board for both
    int corners, left_out;    // of the attitudes used, in camera and projector
    int open_terms;           // that the photographs do not determine; warnings name them
    bool has_axis;            // and so on: of the turntable
    double axis[3], point[3]; // camera coordinates; points up in the picture
    bool reversed;            // the angles are left-handed about it: their signs change in the file
    int stops, stops_used;
    double stops_rms, tilt, shift; // standard deviations: degrees, the square's unit
} FfpRigCalibrationStats;
// Calibrates camera and projector from photographs of a chessboard under Gray codes in at least three
// attitudes (Moreno and Taubin 2012), and finds a turntable's axis. Nothing is written before all is found.
// FFP_ERROR_UNSUPPORTED: the library was built without OpenCV. `stats` may be NULL.
FFP_API bool ffp_calibrate_rig(FfpContext *context, const FfpRigCalibration *options,
                               FfpRigCalibrationStats *stats, FfpError *err);

// --- Photographs and calibrations of other tools. ---

// How pictures came from the size that a device was calibrated at.
typedef enum FfpFit { FFP_FIT_EXACT, FFP_FIT_SCALED, FFP_FIT_CROPPED } FfpFit;

typedef struct FfpCalibratedAt {
    int width, height; // pixels at calibration, where its files do not say them; 0: they do
    FfpFit fit;
    int left, top; // FFP_FIT_CROPPED: pixels cut off
} FfpCalibratedAt;

// Photographs under one pattern or several. `files` is a path with {view}, {pattern}, {index} (from 0, among
// all views of the calibration), {number} (from 1) or {number:3} (with zeros) in it, which are filled in
// first; what they do not tell apart is told by *, whose files are taken in order, img_9 before img_10: all
// patterns of the first view, then of the second. Masks and Gray codes are named likewise.
typedef struct FfpImportImages {
    const char *const *patterns; // names: black, white, and what the caller calls the others
    int n_patterns;
    const char *files;
} FfpImportImages;

// What the projector showed, as it was sent to it.
typedef struct FfpImportPattern {
    const char *name, *file;
} FfpImportPattern;

typedef enum FfpMasks {
    FFP_MASKS_FROM_ALPHA, // the photographs' alpha channels where there are, else as below
    FFP_MASKS_FROM_LIGHT, // what white adds to black (Otsu 1979), and shadows by what four or more views show
    FFP_MASKS_FROM_FILES
} FfpMasks;

// An object that turned before a fixed camera and projector, in camera coordinates (x right, y down, z
// forward) and the calibration's unit; angles in degrees, right-handed about the axis.
typedef struct FfpImportTurntable {
    const char *file; // JSON or YAML {"axis", "point", "angles"}, or "count" and "step" for the latter; NULL:
                      // the numbers below
    double axis[3], point[3]; // direction, and any point of the axis
    const double *angles;     // by which the object had turned at each stop
    int n_angles;             // 0, and no file: there is no turntable, and a fixed rig has one view
    bool find_axis;           // axis and point are found from the pictures; a file's own are passed over
    bool guessed;             // the search begins at `axis` and `point`
} FfpImportTurntable;

typedef struct FfpImport {
    const char *const *calibrations; // files (and folders) of one calibration
    int n_calibrations;
    const char *projector_image; // COLMAP: the image that is the projector; NULL: "calib"
    FfpImportTurntable turntable;
    const FfpImportImages *images; // none: the pictures that the calibration names
    int n_images;
    const FfpImportPattern *patterns; // every pattern besides black and white
    int n_patterns;
    const FfpImportPattern *held_out; // likewise, only ever to be predicted
    int n_held_out;
    // Photographs of the Gray codes of `ffp_write_patterns` in their order, as FfpImportImages.files,
    // {pattern} being gray_x_00, gray_x_00_inverse and so on: then the capture holds where in the projector
    // each pixel's light comes from. Without any pattern besides black and white one of the codes becomes the
    // pattern. NULL: none
    const char *gray_codes;
    FfpMasks masks;
    const char *mask_files;   // FFP_MASKS_FROM_FILES: as FfpImportImages.files, white on black
    const char *const *views; // ids to import; none: all
    int n_views;
    FfpCalibratedAt camera, projector;
    int width; // of the imported pictures; 0: as they are. Sides are filled up to whole patches of 8 pixels
    // Finds the projector's gamma and black level from the pictures, and makes the patterns the light that it
    // made of them
    bool fit_response;
    // PNG, JPEG and TIFF of integers hold linear light instead of sRGB: the photographs; the patterns
    bool linear_images, linear_patterns;
    double exposure;    // stops by which linear values are brightened; 0: as they are
    double object[4];   // centre and radius of a sphere around the object; radius 0: estimated
    const char *name;   // of the capture; NULL: the folder's
    const char *folder; // the capture goes here; it must not hold anything yet
} FfpImport;
FFP_API FfpImport ffp_import_defaults(void); // nothing named, everything as it is
// Writes a capture folder, whole or not at all: poses in the object's frame, pictures and patterns without
// lens distortion, masks applied.
FFP_API bool ffp_import_capture(FfpContext *context, const FfpImport *options, FfpError *err);

typedef struct FfpAlignStats {
    bool turntable; // the views are those of a fixed rig around a turning object, and share what is common to
                    // their poses
    double evened;  // turns that took: root mean square about a device's axis, degrees
    double depth, across,
        side;             // turns of the camera in all views, degrees: along the line to the projector and
                          // across it (the projector turns as much against it), and sideways (with it)
    bool own;             // each view got poses of its own; then:
    double turned;        // by how much, root mean square about a device's axis, degrees
    double off[2];        // before and after: root mean square by which the camera's rays pass what they show
                          // of the pattern, pixels of the projector
    double apart[2];      // and by which surfaces of different views lie apart, pixels of the camera
    double focal[2];      // factors by which the focal lengths of camera and projector grew; 1: they stayed
    double before, after; // disagreement of the pictures: mean difference of pattern values, 0 to 1
    double seconds;
} FfpAlignStats;
typedef struct FfpAligning {
    const char *pattern; // name of the structured-light pattern to use; NULL: the first that every view has
    bool focal_lengths;  // those of camera and projector are corrected too, the same in all views
} FfpAligning;
FFP_API FfpAligning ffp_aligning_defaults(void); // poses alone
// Corrects the poses of all cameras and projectors from the photographs, in place. Takes some seventy-five
// projector matchings. `stats` may be NULL.
FFP_API bool ffp_align_poses(FfpContext *context, FfpCapture *capture, const FfpAligning *options,
                             FfpAlignStats *stats, FfpError *err);

// Writes a capture folder (docs/formats.md), whole or not at all; it must be new or empty.
FFP_API bool ffp_capture_save(FfpContext *context, const FfpCapture *capture, const char *folder,
                              FfpError *err);
// Whether the folder is new or empty, told before the work rather than after it.
FFP_API bool ffp_can_save_capture(const char *folder, FfpError *err);

// Measures kernels and whole steps against this machine's own limits: tables as text for people (release with
// ffp_free), and as JSON in a file unless `json` is NULL. NULL on failure. Takes about a minute.
FFP_API char *ffp_benchmark(FfpContext *context, const char *json, FfpError *err);

// What a capture, a weights file or a PLY holds, as text for people (release with ffp_free); NULL on failure.
FFP_API char *ffp_info(FfpContext *context, const char *path, FfpError *err);

#ifdef __cplusplus
}
#endif

#endif
