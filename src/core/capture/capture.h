// A capture: the photographs of one object by a projector-camera rig. See docs/reference/formats/capture.md
// for the files.
#ifndef FFP_CAPTURE_CAPTURE_H
#define FFP_CAPTURE_CAPTURE_H

#include <stdbool.h>
#include "core/base/error.h"
#include "core/image/framing.h"
#include "core/image/image.h"

#define FFP_NAME_MAX 96
#define FFP_PATTERNS_MAX 512

// A pinhole device, camera or projector alike (a projector is a camera whose light runs backwards).
// Axes are OpenCV's: x right, y down, z forward. Pixel centres at integer + 0.5.
typedef struct FfpCamera {
    int width, height;
    real fx, fy, cx, cy; // pixels; the principal point may lie outside the image
    real pose[16];       // row-major 4x4, device to world (c2w, p2w), rigid
} FfpCamera;

typedef struct FfpPattern {
    char name[FFP_NAME_MAX];
    FfpImage image; // linear RGB, 3 channels, size of the projector
    bool novel;     // held out for testing: never used for a reconstruction unless requested by name
} FfpPattern;

typedef struct FfpView {
    char id[FFP_NAME_MAX];
    FfpCamera camera, projector;
    real near, far; // of a whole scene: camera depths between which surfaces are looked for; 0: not known yet
    int frame_width, frame_height; // the upper left part of the picture that the camera saw; 0: all of it.
                                   // Pixels beyond it are not known to be empty
    FfpImage
        *images; // [n_patterns] linear RGB over black, camera size; .data is NULL where this view has none
    FfpImage coverage;       // 1 channel in [0,1]: the object's share of each pixel (alpha); always there
    FfpImage correspondence; // 3 channels: the projector's pixel position (x, y) that Gray codes found for
                             // the pixel's centre, and a confidence in [0,1]; 0: unknown. .data NULL: this
                             // view has none
    // Truth, where the capture has it (.data NULL otherwise). Same size as the images:
    FfpImage depth;  // 1 channel, camera z in world units at the pixel's centre, 0 where there is no surface
    FfpImage normal; // 3 channels, world, unit
    FfpImage albedo; // 3 channels, linear
    FfpImage roughness; // 1 channel
    FfpImage
        direct_white; // 3 channels, linear: direct projector light only, under the white pattern (generator)
} FfpView;

// The real projector behind the ideal ones of the views, for which a picture must be adjusted before it is
// shown. A ray (x, y, 1) in the projector's frame leaves the panel at (cx + fx x', cy + fy y'), where x', y'
// are x, y distorted by the lens (core/base/lens.h); a value v of a picture sent to it becomes light in
// proportion to v^gamma, or to the sRGB curve of v.
typedef struct FfpPanel {
    bool known;
    int width, height;   // pixels that the projector is sent
    real fx, fy, cx, cy; // pixels of the panel
    real lens[5];        // k1 k2 p1 p2 k3 of OpenCV's Brown-Conrady model
    bool power;          // light is v^gamma ...
    real gamma[3];       // ... per channel; otherwise the sRGB curve of v
    real
        blur; // deviation of the Gaussian, in pixels of the ideal projector, through which its pictures reach
              // the surface and the camera; the capture's patterns are filtered by it. 0: none is known
    real spread[3];    // share of its light, per channel, that lenses and material spread widely around ...
    real spread_reach; // ... by a Gaussian of this deviation, in pixels of the ideal projector; the capture's
                       // patterns hold it. 0: none is known
} FfpPanel;

typedef struct FfpCapture {
    char name[FFP_NAME_MAX];
    char folder[1024];
    int n_patterns, n_views;
    FfpPattern *patterns;
    int n_codes; // how many of the patterns, the last, are Gray codes that were photographed for depth: all
                 // of them novel, further photographs for a fit, and neither shown nor scored unless named
    FfpView *views;
    int black, white;  // indices into patterns
    real intensity[3]; // projector radiant intensity at pattern value 1, W/sr in world units (I of the light
                       // model)
    bool intensity_known;
    FfpPanel panel; // the real projector, if an import recorded it
    bool scene; // a whole scene: all that is in view belongs to it, and depth has no bounds but those that
                // the photographs give
    real centre[3],
        radius; // the object's bounding sphere, world units (given, or estimated from poses and masks)
    struct FfpPhotographFiles *files; // of photographs that were left in them (photographs.h); NULL: none
} FfpCapture;

// Reads CAPTURE: a folder (scene.json preferred, otherwise render_poses.json) or a JSON file of either kind.
// Everything is checked: rigid matrices, positive finite intrinsics, image sizes, files, 1..FFP_VIEWS_MAX
// views, a black and a white pattern in every view. Errors name file and field.
bool ffp_capture_read(FfpCapture *capture, const char *path, FfpError *err);
// The same as a block of its own: ffp_capture_free, then ffp_free.
FfpCapture *ffp_capture_load(const char *path, FfpError *err);
// The same, but photographs of more than `values` numbers are left in their files, as by
// ffp_capture_load_devices, if the file says intensity and sphere.
FfpCapture *ffp_capture_load_most(const char *path, double values, FfpError *err);
// The same without the pictures that a reconstruction from these patterns (n names, 0: the one it takes then)
// and from Gray codes does not look at, nor the ground truth. A capture whose file lacks the object's sphere,
// whose photographs have neither alpha nor masks, or that is a whole scene, is read as a whole.
FfpCapture *ffp_capture_load_wanted(const char *path, const char *const *patterns, int n, FfpError *err);
// Devices and patterns, for work that looks at few photographs or none: they stay in their files, and views
// have neither pictures nor coverage (photographs.h reads a view's). A value that the file lacks (the
// intensity, a pattern's picture, and with `sphere` the object's) takes reading it all, as ffp_capture_load
// does. Without `sphere` it is the file's (radius 0: none).
FfpCapture *ffp_capture_load_devices(const char *path, bool sphere, FfpError *err);
// As above for a targets file (poses to be predicted): views need not have black and white. Patterns are
// looked up in the capture that it belongs to: `targets` gets copies of all patterns of `reference`, at the
// same indices, and then those that are new in the file; centre, radius and intensity are the reference's. A
// view without any image has coverage 0. `path` is the file, or a folder with targets.json.
bool ffp_capture_read_targets(FfpCapture *targets, const char *path, const FfpCapture *reference,
                              FfpError *err);
// The devices only, from a targets file or a capture's JSON (or a folder with one) whose photographs need not
// exist: views have no pictures and no coverage. Patterns have images if their files exist; black and white
// always do. Intensity (intensity_known) and sphere (radius 0: none) are those of the file. `width` and
// `height` are the projector's if the file gives neither its size nor a pattern; 0: an error.
bool ffp_capture_read_poses(FfpCapture *poses, const char *path, int width, int height, FfpError *err);
void ffp_capture_free(FfpCapture *capture);
void ffp_view_free(FfpView *view, int n_patterns); // what it holds

// Writes folder/scene.json, images (8-bit sRGB PNG with alpha), depth (float EXR) and the other truth maps it
// has, and patterns/ (8-bit sRGB PNG). scene.json is written last: a folder without it is not a capture.
bool ffp_capture_write(const FfpCapture *capture, const char *folder, FfpError *err);

// The same into a folder that is new or empty, completely or not at all: written beside it, completed by
// `finish` (NULL: nothing more to do), read back, and then renamed. Errors: the folder is not empty; the
// capture written cannot be read back.
bool ffp_capture_write_whole(const FfpCapture *capture, const char *folder,
                             bool (*finish)(const char *part, void *context, FfpError *err), void *context,
                             FfpError *err);

// Checks before the work that the folder is new or empty; an old folder stays intact until the final
// renaming.
bool ffp_capture_probe(const char *folder, FfpError *err);

int ffp_capture_find_pattern(const FfpCapture *capture, const char *name); // index, or -1
int ffp_capture_find_view(const FfpCapture *capture, const char *id);      // index, or -1
// "000, 045, 090 and 61 more": the existing names, for errors about an unknown one,
// ffp_list_views(capture).text
enum { FFP_LISTED_MAX = 256 };
typedef struct FfpListed {
    char text[FFP_LISTED_MAX];
} FfpListed;
FfpListed ffp_list_views(const FfpCapture *capture);
FfpListed ffp_list_patterns(const FfpCapture *capture);
// "folder/name" where name is "<view>_<rest>"; names come from files, so those that would leave the folder
// are refused.
bool ffp_picture_path(char *out, size_t size, const char *folder, const char *view, const char *rest,
                      FfpError *err);
// An image file as a pattern for a projector: linear RGB over black, named after the file. Notes how it was
// made to fit the projector's frame.
bool ffp_pattern_read(FfpPattern *pattern, const char *path, const FfpCamera *projector, FfpFraming framing,
                      FfpError *err);

// The structured-light pattern a reconstruction uses: the named one, or (name NULL) the first that is neither
// black, white nor novel and that every view has. -1 with an error when there is none.
int ffp_capture_active_pattern(const FfpCapture *capture, const char *name, FfpError *err);
// The photographs that a reconstruction is made from: black, white, and the n structured-light patterns named
// (n 0: the one chosen as above), in their order, into chosen [FFP_PATTERNS_MAX]. Every view has a photograph
// under the first, and at least one view under each of the others. Returns their number, or -1 with an error.
int ffp_capture_photographs(const FfpCapture *capture, const char *const *names, int n, int *chosen,
                            FfpError *err);

// The first patterns that are held out and of which some view has a photograph, those chosen [n] left out,
// into unseen [FFP_UNSEEN_MAX]: what a reconstruction is judged by. Returns their number.
enum { FFP_UNSEEN_MAX = 2 };
int ffp_capture_unseen(const FfpCapture *capture, const int *chosen, int n, int *unseen);

// The least-squares intersection of all camera and projector axes, or if these are nearly parallel the centre
// of the lit surfaces found from the projected colours (coarse_depth.h); and the radius that the masks cover
// around it (the largest distance between the centre and a foreground pixel's ray, over all views, plus 2 %,
// so that rays along a silhouette pass through the sphere instead of just touching it). Writes centre and
// radius.
void ffp_capture_estimate_bounds(FfpCapture *capture);
// Those of a whole scene from n lit points of the world, [n,3], which are known.
void ffp_capture_bound_scene(FfpCapture *capture, real (*points)[3], int n);

// The depths near and far of those views of a whole scene that have none, from the colours projected on lit
// surfaces, with room for what is not lit. ffp_capture_estimate_bounds does it too.
void ffp_capture_estimate_ranges(FfpCapture *capture);

// World <- (world - centre) / radius for everything in the capture (poses, depth); the intensity is divided
// by radius^2, which leaves I / d^2 as it was. The result has centre 0 and radius 1. `centre`/`radius` come
// from the argument capture.
void ffp_capture_normalise(FfpCapture *capture, const real centre[3], real radius);

// (x, y in pixels, z = camera depth) of a world point; returns z. Behind the device z <= 0 and x, y are
// meaningless.
real ffp_project(const FfpCamera *camera, const real point[3], real *x, real *y);
// True if two devices have the same pose and lens: every number of the poses equal to within 1e-4, which is
// far below a pixel in a normalised capture, and focal lengths and principal points to within a hundredth of
// a pixel.
bool ffp_same_device(const FfpCamera *a, const FfpCamera *b);
// Unit world direction of the ray through pixel position (x, y); returns its z component in the camera's
// frame, so that camera depth z = t * returned value.
real ffp_pixel_ray(const FfpCamera *camera, real x, real y, real direction[3]);

// The patterns before the Gray codes: those that are looked at unless a name asks for more.
static inline int ffp_patterns_shown(const FfpCapture *capture) {
    return capture->n_patterns - capture->n_codes;
}

// The part of a view's picture that its camera saw (frame_width), pixels.
static inline int ffp_frame_width(const FfpView *view) {
    return view->frame_width > 0 ? view->frame_width : view->camera.width;
}
static inline int ffp_frame_height(const FfpView *view) {
    return view->frame_height > 0 ? view->frame_height : view->camera.height;
}

#endif
