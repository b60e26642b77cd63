// A camera and a projector as the numbers that are fitted, and what both see of one point.
#ifndef FFP_SELFCAL_DEVICES_H
#define FFP_SELFCAL_DEVICES_H

#include "core/base/rigid.h"
#include "rig/chessboard/opencv.h"
#include "rig/selfcal/places.h"

// Numbers of the optics. Principal points and lenses are as far from their usual values as the photographs
// make likely: what these do not determine stays usual, and its deviation says so.
enum {
    FFP_BUNDLE_CAMERA_FOCAL, // logarithm, pixels
    FFP_BUNDLE_CAMERA_X,     // principal point, from the middle, of the width
    FFP_BUNDLE_CAMERA_Y,
    FFP_BUNDLE_CAMERA_K1,
    FFP_BUNDLE_CAMERA_K2,
    FFP_BUNDLE_CAMERA_P1,
    FFP_BUNDLE_CAMERA_P2,
    FFP_BUNDLE_CAMERA_ASPECT, // how much longer the focal length is along y, relative
    FFP_BUNDLE_PROJECTOR_FOCAL,
    FFP_BUNDLE_PROJECTOR_X,
    FFP_BUNDLE_PROJECTOR_Y,
    FFP_BUNDLE_PROJECTOR_K1,
    FFP_BUNDLE_PROJECTOR_K2,
    FFP_BUNDLE_PROJECTOR_P1,
    FFP_BUNDLE_PROJECTOR_P2,
    FFP_BUNDLE_PROJECTOR_ASPECT,
    FFP_BUNDLE_PROJECTOR_SKEW, // how far x moves along y, of the focal length: corrected keystone
    FFP_BUNDLE_OPTICS
};
enum { FFP_BUNDLE_PRIORS = FFP_BUNDLE_OPTICS + 1 };

// By how much the camera of one place differs from that of all: its axis, of the width, and the logarithm of
// its focal length. Lenses that focus, stabilisers and a second body of the same model are such. Where every
// place is known to have its own camera, so does the lens.
enum { FFP_OWN_X, FFP_OWN_Y, FFP_OWN_FOCAL, FFP_OWN_K1, FFP_OWN };
typedef double FfpOwn[FFP_OWN];
#define FFP_PANEL_WIDE 0.3   // deviation of the aspect and skew of a projector that may correct its picture
#define FFP_FOCAL_HELD 1e-4  // deviation of a focal length that is not to move
#define FFP_BUNDLE_NOISE 0.3 // pixels: what a sighting is off by at first, next to which usual values count

typedef struct FfpKnownFocal { // of the camera, where a lens or a file says it
    double log;                // the logarithm, pixels
    double deviation;          // relative; 0: nothing is known
} FfpKnownFocal;

typedef struct FfpBundleDevice {
    double fx, fy, x, y, lens[5]; // pixels; as FfpOptics
    double skew;                  // pixels that x moves for one along y
} FfpBundleDevice;

FfpBundleDevice ffp_bundle_camera(const FfpTracks *tracks, const double optics[FFP_BUNDLE_OPTICS]);
// The camera as it is at a place with numbers of its own.
FfpBundleDevice ffp_bundle_camera_at(const FfpTracks *tracks, const double optics[FFP_BUNDLE_OPTICS],
                                     const double own[FFP_OWN]);
FfpBundleDevice ffp_bundle_projector(const FfpTracks *tracks, const double optics[FFP_BUNDLE_OPTICS]);
// The ray (x, y, 1) of a pixel; false, and (x, y, 0), where the lens has none.
bool ffp_bundle_ray(const FfpBundleDevice *device, const double pixel[2], double ray[3]);
// The pixel of a point in the device's frame; false: behind it.
bool ffp_bundle_pixel(const FfpBundleDevice *device, const double point[3], double at[2]);

void ffp_rigid_apply(const FfpRigid *motion, const double point[3], double out[3]);

typedef struct FfpDevices {         // as they are tried
    const FfpBundleDevice *cameras; // [of the tracks] at each place
    FfpBundleDevice projector;
    const FfpRigid *places; // [of the tracks] projector's frame to the camera's there
    const bool *known;      // those that count
} FfpDevices;

// From a sighting to where a point at a nearness along a ray of the projector is seen, pixels, and how that
// moves with the nearness. False, with a difference that is far too large and no slope: behind the camera.
bool ffp_devices_miss(const FfpDevices *devices, const double ray[3], const FfpSighting *sighting,
                      double nearness, double off[2], double slope[2]);

// True if a sighting takes part.
bool ffp_devices_count(const FfpDevices *devices, const FfpSighting *sighting);

// The nearness 1 / z along a ray of the projector that fits n sightings best, from `start` (0: from nothing);
// 0: none. differences [n,2] or NULL: from the sightings to where that puts them, pixels; of those that do
// not count it stays.
double ffp_devices_nearness(const FfpDevices *devices, const double ray[3], const FfpSighting *sightings,
                            int n, double start, double *differences);

// Optics as they are expected.
typedef struct FfpUsual {
    FfpKnownFocal focal;
    double panel; // deviation of the projector's aspect and skew; 0: the usual one, of pixels that are square
} FfpUsual;

// FFP_BUNDLE_PRIORS differences that keep to what is usual: the optics', times `firm`, and that of the unit
// of length, which no photograph tells: `distance`, relative to what it was.
void ffp_optics_unusual(const double optics[FFP_BUNDLE_OPTICS], const FfpUsual *beforehand, double firm,
                        double distance, double *out);

// Both devices as other programs have them, in OpenCV's pixels; deviation [FFP_BUNDLE_OPTICS].
void ffp_optics_to_cv(const FfpTracks *tracks, const double optics[FFP_BUNDLE_OPTICS],
                      const double *deviation, FfpCvDevice devices[2]);

#endif
