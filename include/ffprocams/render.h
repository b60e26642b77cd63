// Drawing Gaussians into memory and files, and what is made of that: the viewer page, compensated
// projections, correspondence maps, files for other programs.
#ifndef FFPROCAMS_RENDER_H
#define FFPROCAMS_RENDER_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include "ffprocams/reconstruct.h"

#ifdef __cplusplus
extern "C" {
#endif

// --- Drawing into memory. ---

// One view of Gaussians, rasterised once and shaded under any number of patterns. Outlines are smoothed where
// its pixels are finer than the photographs', as in files; those of gradients.h and linear light are not.
typedef struct FfpRenderer FfpRenderer;
FFP_API FfpRenderer *ffp_renderer_new(FfpContext *context, FfpDrawing drawing, FfpError *err);
FFP_API void ffp_renderer_close(FfpRenderer *renderer);
// Rasterises for a camera and maps the visible surface to a projector; the Gaussians are not accessed
// afterwards. Each side may have 1 to 16384 pixels.
FFP_API bool ffp_renderer_aim(FfpContext *context, FfpRenderer *renderer, const FfpGaussians *gaussians,
                              const FfpPinhole *camera, const FfpPinhole *projector, FfpError *err);
// The camera's picture of the object over black under `pattern` (of the projector's size; NULL, or its data
// NULL: a dark projector), for a projector of the given radiant intensity (as in FfpCaptureData). out
// [height,width,3], sRGB-encoded: U8 rounded as in files, F32 in [0,1]; or RADIANCE, linear and not clipped,
// premultiplied by opacity. `size` bytes are out's; `row_bytes` (of floats, whole numbers of them) 0: rows
// are contiguous. Pictures are written to files by ffp_render_pictures, or by any image library from U8.
FFP_API bool ffp_renderer_shade(FfpContext *context, FfpRenderer *renderer, const FfpPicture *pattern,
                                const double intensity[3], void *out, size_t size, FfpPixelType type,
                                size_t row_bytes, FfpError *err);
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
// A map of the view that was aimed at, of the camera's size, into `out`, which has room for `count` numbers.
FFP_API bool ffp_renderer_map(FfpContext *context, FfpRenderer *renderer, FfpMap map, float *out,
                              size_t count, FfpError *err);

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
    size_t size; // set by ffp_pictures_defaults
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
    // Folder for VIEW_PATTERN.png, or frame_NUMBER.png with an orbit or a video; created if necessary.
    const char *folder;
    // Also write the G-buffers: <view>_depth.exr and .png, _opacity, _normal, _albedo, _roughness, _ambient.
    bool maps;
    FfpDrawing drawing;
} FfpPictures;

FFP_DEFAULTS(FfpPictures, ffp_pictures_defaults) // all views under white, 15 frames a second

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
    FFP_RESERVED;
} FfpNamedImage;
FFP_API int ffp_images_count(const FfpImages *images);
// An index out of range, and a name that is unknown or NULL, give an image whose name is NULL.
FFP_API FfpNamedImage ffp_images_at(const FfpImages *images, int index);
FFP_API FfpNamedImage ffp_images_find(const FfpImages *images, const char *name);
FFP_API void ffp_images_close(FfpImages *images);

// --- Viewer page. ---

typedef struct FfpPage {
    size_t size;       // set by ffp_page_defaults
    const char *file;  // output: one self-contained HTML file
    const char *poses; // file of additional poses to jump to (targets.json or scene.json), or NULL
    int photographs;   // longest side, in pixels, of the photographs to include; 0: none
    FfpDrawing drawing;
} FfpPage;
FFP_DEFAULTS(FfpPage, ffp_page_defaults) // photographs of 512 pixels

typedef struct FfpPageStats {
    int64_t gaussians;
    int64_t bytes;             // file size
    int patterns, photographs; // included; a note is logged if there was no room for all
    FFP_RESERVED;
} FfpPageStats;
// Writes a page that draws Gaussians in the browser (WebGL 2) as ffp_render_pictures does, with camera and
// projectors that can be moved (docs/guide/page.md). `capture` is required; `stats` may be NULL. Fails with
// FFP_ERROR_UNSUPPORTED for the GS-ProCams form, whose light model the page does not implement.
FFP_API bool ffp_write_page(FfpContext *context, const FfpGaussians *gaussians, const FfpCapture *capture,
                            const FfpPage *options, FfpPageStats *stats, FfpError *err);

// --- Applications: compensated projections and correspondence maps. ---

typedef struct FfpCompensation {
    size_t size;       // set by ffp_compensation_defaults
    const char *poses; // as FfpPictures.poses
    // Ids of the views whose cameras see a target, with all their projectors shining at once; none: all.
    const char *const *views;
    int n_views;
    const char *const *targets; // image files in the cameras' frames: one for all views, or one for each
    const FfpPicture *pictures; // or, with `targets` NULL, pictures in memory, in the same number
    int n_targets;
    FfpFraming framing;    // of targets in the cameras' frames
    bool transparent_free; // transparent parts of a target are unconstrained; otherwise they are black
    // File for the pattern (PNG), or <pattern>_<view>.png for each of several projectors. Written beside it:
    // <pattern>_seen_<view>.png, the predicted picture, and <pattern>_target_<view>.png.
    const char *pattern;
    // With a film as the only target, for one view and one projector: the corrected film (as
    // FfpPictures.video), of `rate` frames a second (0: the film's own), with its sound; `pattern` and what
    // is beside it show its first frame, the figures are means over the frames. NULL: targets are pictures.
    const char *video;
    int rate;
    double gain; // factor on the linear targets; 0: the brightest that light allows
    bool paint;  // targets are light on the object: 0 its look under black, 1 under white, shared where
                 // projectors overlap (no gain)
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
    // The share of its white that a dark projector still gives, in [0, 0.1]: where projectors overlap, that
    // adds up, and the dark beside is lifted to it. It comes on top of what photographs under black show.
    // 0: projectors that are dark give nothing.
    double black_level;
    bool sharpen; // patterns so sharp that they arrive as they should through the projector's blur
} FfpCompensation;

FFP_DEFAULTS(FfpCompensation, ffp_compensation_defaults) // all views, gain 1, 30 steps

typedef struct FfpCompensationStats {
    double gain; // the gain used
    // Shares of the object's pixels that the targets constrain: those that no projector lights, and those
    // whose target is darker or brighter than projected light can reach.
    double unlit, too_dark, too_bright;
    // dB over the lit ones: with dark projectors, after the closed form, at the end.
    double psnr_dark, psnr_closed, psnr;
    int patterns;
    double elapsed_s;
    FFP_RESERVED;
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

typedef struct FfpWarps {
    size_t size;              // set by ffp_warps_defaults
    const char *poses;        // as FfpPictures.poses
    const char *const *views; // ids; none: all
    int n_views;
    const char *folder; // for the files (docs/reference/formats/pictures.md); created if necessary
    FfpDrawing drawing;
} FfpWarps;

FFP_DEFAULTS(FfpWarps, ffp_warps_defaults) // all views

typedef struct FfpWarpStats { // of one view
    char view[96];
    // Camera pixels whose round trip to the projector succeeded, and lit ones for which it failed.
    int lit_pixels, lost_pixels;
    // Error of the round trip: the share within half a pixel; the median and the maximum, pixels.
    double within_half, median, most;
    double lit_share; // share of the projector's pixels that fall on the object
    FFP_RESERVED;
} FfpWarpStats;

// Correspondences and projected light for one camera and one projector: linear images named like the files
// (docs/reference/formats/pictures.md): camera_to_projector, of the camera's size, and of the projector's
// projector_to_camera and projector_sees (these have 3 channels), lit, incidence, density, resolution and
// illuminance (1). `stats` may be NULL; its view is "view".
FFP_API FfpImages *ffp_warp_images(FfpContext *context, const FfpGaussians *gaussians,
                                   const FfpCapture *capture, const FfpPinhole *camera,
                                   const FfpPinhole *projector, FfpDrawing drawing, FfpWarpStats *stats,
                                   FfpError *err);
// The same for the views of a capture or a file of poses, written to files. Returns the number of files, or
// -1. `stats` may be NULL; otherwise it has room for `n_stats` views (FFP_VIEWS_MAX are enough), and if they
// are more, nothing is written.
FFP_API int ffp_write_warps(FfpContext *context, const FfpGaussians *gaussians, const FfpCapture *capture,
                            const FfpWarps *options, FfpWarpStats *stats, int n_stats, FfpError *err);

// --- Export to other programs. ---

typedef struct FfpExport {
    size_t size; // set by ffp_export_defaults
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
FFP_DEFAULTS(FfpExport, ffp_export_defaults) // ambient light, z up, a mesh of 128 cells

typedef struct FfpExportStats {
    int64_t splats, triangles, bytes; // written
    FFP_RESERVED;
} FfpExportStats;
// Writes Gaussians for programs that do not simulate projectors. `capture` may be NULL for splats in ambient
// light; a mesh is made from what its cameras see. `stats` may be NULL.
FFP_API bool ffp_export(FfpContext *context, const FfpGaussians *gaussians, const FfpCapture *capture,
                        const FfpExport *options, FfpExportStats *stats, FfpError *err);

#ifdef __cplusplus
}
#endif

#endif
