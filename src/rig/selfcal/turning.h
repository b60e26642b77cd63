// A camera and a projector that stand still, and an object that turns before them: at each stop both see its
// surface, and about the right axis the surface of one stop turns into that of the next. Every point is
// carried along: turned to the next stop it falls on a spot of the panel and on a pixel, and the codes of
// that stop say at which pixel that spot really is (point-to-projection registration: Blais and Levine 1995).
#ifndef FFP_SELFCAL_TURNING_H
#define FFP_SELFCAL_TURNING_H

#include "core/numerics/least_squares.h"
#include "rig/selfcal/devices.h"
#include "rig/turntable/axis.h"

enum { FFP_TURNING_NEXT = 3 };
#define FFP_PARALLAX_CLEAR 6.0 // degrees, from which on it leaves nothing unclear
#define FFP_PARALLAX_LEAST 4.0

typedef struct FfpTurning {
    const FfpTracks *tracks; // places are stops
    const double *given;     // [n_places] radians
    bool reversed;           // they are left-handed about the axis
    double angles_known;     // radians: how far an angle may be off; 0: not at all
    double *off;             // [n_places] how far each is, right-handed about the axis; the first is not
    double optics[FFP_BUNDLE_OPTICS];
    FfpRigid camera; // the projector's frame to the camera's; the distance between them is the unit
    FfpAxis axis;    // in the camera's frame
    FfpUsual usual;
    int *track;                    // [n_sightings]
    double *nearness;              // [n_sightings] 1 / z along the projector's ray; 0: none
    int (*next)[FFP_TURNING_NEXT]; // [n_places] the stops that a stop's points are turned to; -1: none
    FfpFitEnd end;                 // why the last fit that was judged ended
    double rms, noise;             // of the sightings in their pixels; of it what neighbours do not share
    double surface;                // median distance of what was turned from where it is seen, pixels
    double deviation[FFP_BUNDLE_OPTICS + 6]; // of the optics and of the camera's turn and place
    double tilt, shift; // standard deviations of the axis: direction, radians; place, share of its distance
} FfpTurning;

FfpTurning ffp_turning_new(const FfpTracks *tracks, const double *angles);
void ffp_turning_free(FfpTurning *turning);

// Leaves out sightings of what does not turn: spots that most stops see at the same pixel.
void ffp_turning_drop_still(FfpTurning *turning);

// The point of a sighting in the camera's frame; false: it has none.
bool ffp_turning_point(const FfpTurning *turning, int sighting, double point[3]);

// Decides which stops are compared, of those without a problem.
void ffp_turning_set_stops(FfpTurning *turning);

// Median angle between the rays by which projector and camera see a point, degrees.
double ffp_turning_parallax(const FfpTurning *turning);
// Checks that it is at least `least`: FFP_PARALLAX_CLEAR where something is unclear, FFP_PARALLAX_LEAST
// anyway.
bool ffp_turning_check_parallax(const FfpTurning *turning, double least, FfpError *err);

// Solves the nearness of every `stride`-th sighting for the devices as they are.
void ffp_turning_triangulate(FfpTurning *turning, int stride);
// How badly every `stride`-th sighting, turned to the next stop, agrees with that stop, 0 to 1; `scale`:
// pixels, beyond which distances count less and less. A sighting that falls on nothing counts 1.
double ffp_turning_disagreement(const FfpTurning *turning, int stride, double scale);

// How alike the light is of points before and after they are turned, of those that lie within `far` pixels of
// where they are seen: the correlation of its logarithm, -1 to 1; 0: too few to tell.
double ffp_turning_likeness(const FfpTurning *turning, double far);

// shares [n_places]: of the points that a stop exchanges with others, how many lie within `far` pixels of
// where they are seen; -1: it exchanges none.
void ffp_turning_agreement(const FfpTurning *turning, double far, double *shares);

// errors [n_places]: the median distance of a stop's sightings, each alone, from where camera and projector
// together can see a point; -1: it has none.
void ffp_turning_stop_errors(const FfpTurning *turning, double *errors);

// Fits devices, axis and, where they may be off, angles to every `stride`-th sighting.
void ffp_turning_fit(FfpTurning *turning, int stride, double scale, int steps, bool deviations);

// From nothing but the angles: tries optics, the motion between the devices by their essential matrix, and
// axes all around, and fits the best. Errors (where: NULL): too few sightings turn; no axis; several.
bool ffp_turning_start(FfpTurning *turning, FfpError *err);

#endif
