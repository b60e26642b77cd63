// A camera and a projector that stand still before a turntable, as one would set them up: lenses that
// distort, principal points beside the middle, a panel that is not a square.
#ifndef FFP_SYNTH_BARE_RIG_H
#define FFP_SYNTH_BARE_RIG_H

#include "core/capture/capture.h"
#include "world/synth/chessboard.h"

#define FFP_BARE_RIG_UNIT 100.0 // millimetres of a world unit, in what is written of the rig

typedef struct FfpBareRig {
    FfpCamera camera, projector; // poses: in the world, whose z is the turntable's axis
    double camera_lens[5], projector_lens[5];
    float intensity, ambient; // of the projector, W/sr; radiance
    double square;            // of its boards
} FfpBareRig;

// For pictures height * 4/3 x height and a panel of any size.
FfpBareRig ffp_bare_rig(int height, int panel_width, int panel_height);
// Puts another projector in the place of the rig's, on the other side of the camera and farther away, with
// another lens and as many pixels.
void ffp_bare_rig_exchange(FfpBareRig *rig);
// Size and intrinsics of a device: focal length and the principal point's distance from the middle, in units
// of the shorter side.
void ffp_bare_rig_optics(FfpCamera *device, int width, int height, double focal, double off_x, double off_y);
// The devices in the frame of an object that has turned by `angle` degrees.
void ffp_bare_rig_devices(const FfpBareRig *rig, double angle, FfpCamera *camera, FfpCamera *projector);
// A board that is held before both devices, wholly seen and lit; another way for every index and seed.
FfpChessboard ffp_bare_rig_attitude(const FfpBareRig *rig, int index, uint64_t seed);
// One that leans on the turntable, facing the camera at angle 0.
FfpChessboard ffp_bare_rig_turntable_board(const FfpBareRig *rig);
// That board's angles, degrees: -40, -20, 0, 20, 40.
enum { FFP_BOARD_STOPS = 5 };
static inline double ffp_board_angle(int stop) {
    return 20 * (stop - (FFP_BOARD_STOPS - 1) / 2);
}
// A point of the world, or a direction, in the frame of a device; lengths in millimetres.
void ffp_bare_rig_in_frame(const FfpCamera *device, const double v[3], bool is_point, double out[3]);
// Where a device has a point of the world, pixels; false: behind it or beyond its frame.
bool ffp_bare_rig_pixel(const FfpCamera *device, const double lens[5], const float point[3], double pixel[2]);

#endif
