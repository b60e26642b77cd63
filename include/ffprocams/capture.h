// Captures: photographs of one object from several views, each under a black, a white and further patterns.
#ifndef FFPROCAMS_CAPTURE_H
#define FFPROCAMS_CAPTURE_H

#include <stdbool.h>
#include <stddef.h>
#include "ffprocams/context.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef struct FfpCapture FfpCapture;
#define FFP_VIEWS_MAX 512 // of a capture or a file of poses

// A file's contents in the caller's memory, which the library only reads, and only during the call.
typedef struct FfpBytes {
    const void *data;
    size_t size;
} FfpBytes;

// Which photographs are read.
typedef enum FfpRead {
    FFP_READ_ALL,
    // Those that ffp_reconstruct uses with `patterns`, and no ground truth. All are read if the file lacks
    // the object's sphere, the photographs have neither alpha nor masks, or it is a whole scene.
    FFP_READ_WANTED,
    // None: a capture of many megapixels then takes hardly any memory. It is enough for rendering, maps,
    // exporting, the page and compensation, which read the few photographs that they need; reconstructing,
    // fitting, aligning and saving refuse it (FFP_ERROR_ARGUMENT). All are read if the file lacks the
    // projector's intensity or a pattern's picture, or, with `sphere`, the object's sphere.
    FFP_READ_NONE,
} FfpRead;
typedef struct FfpOpening {
    size_t size; // set by ffp_opening_defaults
    FfpRead photographs;
    // Of FFP_READ_WANTED, as in FfpReconstruction, which tells of unknown ones: opening ignores them.
    const char *const *patterns;
    int n_patterns; // 0: the first
    bool sphere;    // of FFP_READ_NONE: an orbit, a mesh, the page and compensation need the sphere
} FfpOpening;
FFP_DEFAULTS(FfpOpening, ffp_opening_defaults) // all photographs
// Reads a folder with scene.json or render_poses.json, or such a file, and checks all of its contents.
// options NULL: the defaults.
FFP_API FfpCapture *ffp_capture_open(FfpContext *context, const char *path, const FfpOpening *options,
                                     FfpError *err);
// Looks for what is wrong with a capture, and returns what it found (release with ffp_free), *count findings,
// those that are ok among them, as `info` lists them, and those for which a reconstruction would be refused.
// Their texts are part of the same block. NULL on failure.
FFP_API FfpFinding *ffp_capture_check(FfpContext *context, const FfpCapture *capture, int *count,
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
    FFP_RESERVED;
} FfpPicture;

// A camera without lens distortion, or a projector, modelled as a camera with light travelling the other way.
// Axes: x right, y down, z forward; pixel centres at integer + 0.5.
typedef struct FfpPinhole {
    int width, height;     // pixels
    double fx, fy, cx, cy; // pixels; the principal point may lie outside the image
    double pose[16];       // row-major 4x4, device to world, rigid
    FFP_RESERVED;
} FfpPinhole;

// A capture in memory, with the same contents as a capture folder (docs/reference/formats/capture.md).
typedef struct FfpPatternData {
    const char *name;
    FfpPicture picture; // of the projector's size; may be empty for black and white
    bool held_out;      // for testing only: never used for a reconstruction unless requested by name
    FFP_RESERVED;
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
    FFP_RESERVED;
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
    FFP_RESERVED;
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
// As in FfpCaptureData, given or estimated; radius 0: not known, as after FFP_READ_NONE. `centre` and
// `radius` may be NULL.
FFP_API void ffp_capture_intensity(const FfpCapture *capture, double intensity[3]);
FFP_API void ffp_capture_bounds(const FfpCapture *capture, double centre[3], double *radius);

// Writes a capture folder (docs/reference/formats/capture.md), completely or not at all; it must be new or
// empty.
FFP_API bool ffp_capture_save(FfpContext *context, const FfpCapture *capture, const char *folder,
                              FfpError *err);
// Checks that the folder is new or empty, so that errors show before the work rather than after it.
FFP_API bool ffp_can_save_capture(const char *folder, FfpError *err);

// --- Descriptions of files. ---

// Describes a capture, a weights file or Gaussians (PLY, SPZ, glTF) in readable text (release with ffp_free);
// NULL on failure.
FFP_API char *ffp_info(FfpContext *context, const char *path, FfpError *err);
// Writes the same of a capture as an HTML page, with a contact sheet of its masks in which doubtful views are
// marked, and in colours which pixels' depth no pattern tells. Errors: `path` is not a capture.
FFP_API bool ffp_info_report(FfpContext *context, const char *path, const char *html, FfpError *err);
// The same as JSON (release with ffp_free): {"text": what ffp_info returns, "findings": [as
// ffp_finding_json]}, the latter for a capture.
FFP_API char *ffp_info_json(FfpContext *context, const char *path, FfpError *err);

#ifdef __cplusplus
}
#endif

#endif
