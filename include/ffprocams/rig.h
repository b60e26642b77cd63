// Rigs of your own: patterns to project, calibration, import of photographs, correction of poses.
#ifndef FFPROCAMS_RIG_H
#define FFPROCAMS_RIG_H

#include <stdbool.h>
#include <stddef.h>
#include "ffprocams/reconstruct.h"

#ifdef __cplusplus
extern "C" {
#endif

// --- Patterns to project while taking photographs. ---

typedef struct FfpPatterns {
    size_t size;        // set by ffp_patterns_defaults
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
    int greys; // even greys between black and white, 0 to 64, by which ffp_import finds the projector's
               // response
    // Files of a calibration, as FfpImport.calibrations: the panel is of the size that they give its
    // projector, and width and height do not count. n_calibrations 0: none
    const char *const *calibrations;
    int n_calibrations;
} FfpPatterns;

FFP_DEFAULTS(FfpPatterns, ffp_patterns_defaults) // everything, one lollipop, 1920 x 1080; 9 x 6, 25 mm
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
    size_t size; // set by ffp_rig_calibration_defaults
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
    bool linear; // integer files of photographs hold linear light instead of sRGB
} FfpRigCalibration;
FFP_DEFAULTS(FfpRigCalibration, ffp_rig_calibration_defaults) // nothing named or fixed, 1920 x 1080

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
    FFP_RESERVED;
} FfpRigCalibrationStats;
// Calibrates camera and projector from photographs of a chessboard under Gray codes in at least three
// attitudes (Moreno and Taubin 2012), and finds a turntable's axis. Nothing is written until everything has
// been found. Fails with FFP_ERROR_UNSUPPORTED if the library was built without OpenCV. `stats` may be NULL.
FFP_API bool ffp_calibrate_rig(FfpContext *context, const FfpRigCalibration *options,
                               FfpRigCalibrationStats *stats, FfpError *err);

// Without a board: a projector that stands still, and either a camera at two places or more before anything
// that is not flat, or one that stands still too, and an object on a turntable.
typedef struct FfpSelfCalibration {
    size_t size; // set by ffp_self_calibration_defaults
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
    bool linear; // as FfpRigCalibration.linear
    // Each place has a camera of its own: another body, or another lens or zoom. False: one camera walked,
    // and where a place seems to have another, a finding says so.
    bool camera_per_folder;
} FfpSelfCalibration;
FFP_DEFAULTS(FfpSelfCalibration, ffp_self_calibration_defaults) // nothing named, 1920 x 1080

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
    FFP_RESERVED;
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
    FFP_RESERVED;
} FfpCalibratedAt;

// Photographs under one pattern or several. `files` is a path containing {view}, {pattern}, {index} (from 0,
// among all views of the calibration), {number} (from 1) or {number:3} (zero-padded), which are substituted
// first. * matches the remaining files in order, img_9 before img_10: all patterns of the first view, then
// those of the second. Masks and Gray codes are named likewise.
typedef struct FfpImportImages {
    const char *const *patterns; // names: black, white, and the caller's names for the others
    int n_patterns; // 0: those of FfpImport.shown, in their order, with the Gray codes or without
    const char *files;
    FFP_RESERVED;
} FfpImportImages;

// The image that was sent to the projector.
typedef struct FfpImportPattern {
    const char *name, *file;
    FFP_RESERVED;
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
    FFP_RESERVED;
} FfpImportTurntable;

#define FFP_IMPORT_SIDE 1024
#define FFP_IMPORT_PIXELS 2000000
#define FFP_IMPORT_SECONDS 180

typedef struct FfpImport {
    size_t size;                     // set by ffp_import_defaults
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
    // resolve, and that are not the same as a pattern above or its inverse. 0 to 32; 0: none. Default: 8. If
    // nothing is held out, two more codes are: ffp_reconstruct says how well it predicts them.
    int kept_codes;
    FfpCalibratedAt camera, projector;
    // Of the imported pictures. 0: as fine as the photographs show the object, as long as its longer side has
    // at most FFP_IMPORT_SIDE pixels, all views show FFP_IMPORT_PIXELS of it, half of the free memory
    // suffices and a reconstruction takes FFP_IMPORT_SECONDS; and cut to the object if that halves them.
    // Sides are padded to multiples of 8 pixels.
    int width;
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
    // The photographs show the light of a projector that the calibration does not describe, whose panel has
    // projector.width x height pixels: its Gray codes are taken as they are, and its place and lens are those
    // of no projector until ffp_find_projector finds them.
    bool other_projector;
} FfpImport;
FFP_DEFAULTS(FfpImport, ffp_import_defaults) // nothing named, pictures unchanged, eight codes kept
// Writes a capture folder, completely or not at all: poses in the object's frame, pictures and patterns
// without lens distortion, masks applied.
FFP_API bool ffp_import_capture(FfpContext *context, const FfpImport *options, FfpError *err);

// --- Correction of poses. ---

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
    double elapsed_s;     // of wall clock
    // With FfpAlignment.gaussians, when `before` and `after` compare photographs with drawn pictures,
    // sRGB-encoded: how far camera and projector were rotated about their centres, degrees, and moved, world
    // units; means over the views.
    bool known;
    double camera_turned, camera_moved, projector_turned, projector_moved;
    // The mean distances between where the surface was and is in the camera's and in the projector's
    // pictures, pixels.
    double camera_pixels, projector_pixels;
    FFP_RESERVED;
} FfpAlignmentStats;
typedef struct FfpAlignment {
    size_t size;         // set by ffp_alignment_defaults
    const char *pattern; // name of the structured-light pattern to use; NULL: the first that every view has
    bool focal_lengths;  // also correct those of camera and projector, by the same factors in all views
    // The object as it is known, in the capture's world: each view's camera and projector are found again by
    // it, from that view's photographs alone (under `pattern` alone, if it is named), so one view is enough.
    // Not with focal_lengths. NULL: the poses are found from what the views have in common.
    const FfpGaussians *gaussians;
} FfpAlignment;
FFP_DEFAULTS(FfpAlignment, ffp_alignment_defaults) // only poses
// Corrects the poses of all cameras and projectors from the photographs, in place. Takes as long as about 75
// projector matchings, or with Gaussians some 3 s of a processor for a view of 256 x 256 pixels. `stats` may
// be NULL.
FFP_API bool ffp_align_poses(FfpContext *context, FfpCapture *capture, const FfpAlignment *options,
                             FfpAlignmentStats *stats, FfpError *err);

// --- A second projector. ---

typedef struct FfpFoundProjector {
    double distance;         // from the object's centre, world units
    double turned, moved;    // standard deviations of its direction, degrees, and place, world units
    double focal, centre[2]; // of its focal length, as a share, and its principal point, pixels
    double rms;              // of the points used, pixels of the projector
    int points, used;        // of the object's surface that have codes; of them no outliers
    FFP_RESERVED;
} FfpFoundProjector;
// Finds place and lens of a projector that no calibration describes: one that showed Gray codes alone on an
// object that is known, photographed and imported with FfpImport.other_projector. `gaussians`: the object, in
// the capture's world, where the capture's cameras are right. Each code on the surface is a point whose pixel
// is known (resection); half of them may be wrong. Sets the projectors of all views, the panel and the
// intensity, in place; lens distortion is not looked for. Numbers that the points do not determine stay as
// usual projectors have them, and their deviations say so. Fails without codes, with fewer than 60 points,
// with points on one plane, and where no place explains half of them. `found` may be NULL.
FFP_API bool ffp_find_projector(FfpContext *context, FfpCapture *capture, const FfpGaussians *gaussians,
                                FfpFoundProjector *found, FfpError *err);

#ifdef __cplusplus
}
#endif

#endif
