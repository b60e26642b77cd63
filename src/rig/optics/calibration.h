// The results of a calibration tool for camera and projector, in our conventions
// (docs/reference/formats/calibrations.md).
#ifndef FFP_RIG_CALIBRATION_H
#define FFP_RIG_CALIBRATION_H

#include "core/capture/capture.h"
#include "core/capture/node.h"
#include "core/capture/optics.h"

typedef struct FfpStop { // a camera and a projector around the object, at one stop
    char id[FFP_NAME_MAX];
    FfpOptics camera;
    double c2w[16], p2w[16]; // row-major, OpenCV axes
    double angle;            // of a turntable, degrees
    int index;               // among all that the calibration has, whichever are chosen
    bool left_out;           // by what made the calibration: it is not to be used
} FfpStop;

// A picture that the calibration itself names (nepmap).
typedef struct FfpNamedPicture {
    int stop;
    char pattern[FFP_NAME_MAX];
    char path[1024];
} FfpNamedPicture;

typedef struct FfpCalibration {
    bool has_camera, has_projector; // intrinsics are known
    FfpOptics camera, projector;
    double camera_deviation[4]; // of fx fy cx cy, pixels; 0: the files do not say
    bool has_projector_pose;
    double p2c[16]; // projector to camera of a fixed rig; with stops, projector to world
    int n_stops;    // 0: a fixed rig, which a turntable multiplies
    FfpStop *stops; // owned
    int n_pictures;
    FfpNamedPicture *pictures; // owned
    char pattern_folder[1024]; // where the calibration keeps patterns; "" when it names none
} FfpCalibration;

// Reads all files (COLMAP: also a folder), each of which gives a part; they must not contradict each other.
// `projector_image`: the name, without folder and extension, of the COLMAP image that stands for the
// projector; NULL: "calib". Errors name file and field, or all files if something is missing from them.
bool ffp_calibration_read(FfpCalibration *calibration, const char *const *files, int n_files,
                          const char *projector_image, FfpError *err);
void ffp_calibration_free(FfpCalibration *calibration);
// Gives the views of a capture, one for each stop, the poses of the stops.
void ffp_calibration_pose_views(const FfpCalibration *calibration, FfpCapture *capture);

// --- The formats; each adds to the calibration. ---

// OpenCV FileStorage (YAML, XML or JSON) of kamino410/procam-calibration, single-shot-pro-cam-calib,
// Moreno-Taubin and Calibrator, SLStudio, OpenCV's structured-light, stereo and calibration samples; ROS'
// camera_info; DeProCams' params.yml.
bool ffp_read_opencv(FfpCalibration *calibration, const FfpNode *root, FfpError *err);
// Kalibr's camchain.yaml.
bool ffp_read_kalibr(FfpCalibration *calibration, const FfpNode *root, FfpError *err);
// nepmap's transforms.json.
bool ffp_read_nepmap(FfpCalibration *calibration, const FfpNode *root, FfpError *err);
// GS-ProCams' cameras.json and projector.json.
bool ffp_read_procams_cameras(FfpCalibration *calibration, const FfpNode *root, FfpError *err);
bool ffp_read_procams_projector(FfpCalibration *calibration, const FfpNode *root, FfpError *err);
// cameras.txt and images.txt of COLMAP in a folder.
bool ffp_read_colmap(FfpCalibration *calibration, const char *folder, const char *projector_image,
                     FfpError *err);

// --- Shared by them. ---

// fx, fy, cx, cy out of a 3x3 matrix; `shift` is added to the principal point (0.5 where the tool puts pixel
// centres at integers). Errors: skew, a last row other than 0 0 1, focal lengths that are not positive.
bool ffp_node_intrinsics(const FfpNode *field, double shift, FfpOptics *optics, FfpError *err);
// 4 or 5 coefficients, or more when the further ones are 0.
bool ffp_node_lens(const FfpNode *field, FfpOptics *optics, FfpError *err);
// Sets a size; one that is known already and differs is refused.
bool ffp_settle_size(FfpOptics *optics, const FfpNode *field, int width, int height, FfpError *err);
// Room for n stops; an error when there are some already, or more than FFP_VIEWS_MAX.
bool ffp_calibration_new_stops(FfpCalibration *calibration, const FfpNode *field, int n, FfpError *err);
// A stop's id, as it stands or a file's name without folder and ending; refuses what is not a name, and a
// second of the same.
bool ffp_name_stop(FfpCalibration *calibration, int stop, const FfpNode *field, const char *id,
                   FfpError *err);
bool ffp_name_stop_by_file(FfpCalibration *calibration, int stop, const FfpNode *field, const char *path,
                           FfpError *err);
// The projector of a calibration with stops: it stands still in the world.
void ffp_place_projector(FfpCalibration *calibration, const double p2w[16]);

#endif
