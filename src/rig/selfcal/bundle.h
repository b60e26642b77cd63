// All devices at once: the bundle adjustment of a camera at several places and a projector that stands still
// (Triggs et al. 2000). A spot of the panel is seen along one ray of the projector, so a point of the surface
// is one number, its nearness along that ray; it is solved for within each step, and the devices' numbers are
// all that is left to the fit (variable projection: Golub and Pereyra 1973).
#ifndef FFP_SELFCAL_BUNDLE_H
#define FFP_SELFCAL_BUNDLE_H

#include "core/numerics/least_squares.h"
#include "rig/findings/rules.h"
#include "rig/selfcal/devices.h"

typedef struct FfpBundle {
    const FfpTracks *tracks;
    double optics[FFP_BUNDLE_OPTICS];
    FfpRigid *places; // [n_places] projector's frame to the camera's there
    bool *known;      // [n_places] has a pose
    FfpOwn *own;      // [n_places] of the camera there
    double *nearness; // [tracks->n] 1 / z along the projector's ray; 0: none
    FfpUsual usual;
    double *deviation;     // [FFP_BUNDLE_OPTICS + 6 n_places] of each number; NULL until it is judged
    bool each;             // every place has its own camera: nothing but its files tell how much they differ
    FfpOwn own_usual;      // deviations that the cameras' own numbers are taken to have; 0: they are held
    FfpOwn *own_deviation; // [n_places] of each; NULL until it is judged
    double *focal_deviation; // [n_places] of the logarithm of its camera's focal length, likewise
    double apart; // of the two places that a start began with, degrees that turning leaves between their rays
    FfpRuleId refused; // why a start led nowhere; 0: it did not, or for an error
    FfpFitEnd end;     // why the last fit that was judged ended
    double rms, noise; // of the sightings used, and of it what neighbours do not share, pixels; 0: not fitted
} FfpBundle;

// How many places have a pose.
int ffp_bundle_places(const FfpBundle *bundle);

// How far the logarithm of a place's focal length is expected from that of all, if each has its own camera.
double ffp_bundle_expected(const FfpBundle *bundle, int place);

// The logarithm of the camera's focal length as it is at most places.
double ffp_bundle_focal(const FfpBundle *bundle);

// Where the camera at a place sees a point of the projector's frame; false: behind it.
bool ffp_bundle_see(const FfpBundle *bundle, int place, const double point[3], double at[2]);
// The point of a track; false where it has none.
bool ffp_bundle_point(const FfpBundle *bundle, int track, double point[3]);

// Solves every track's nearness for the devices as they are, from its sightings in places that are known.
void ffp_bundle_triangulate(FfpBundle *bundle);
// Fits all that is known, every `stride`-th track, and takes sightings out that lie `far` times the median
// away (0: none). The unit of length is kept: the first known place is as far from the projector as it was.
void ffp_bundle_fit(FfpBundle *bundle, int stride, double far, bool deviations);

// The same (freedoms.c), with all that may differ from the usual free where the photographs say so: a camera
// of its own at each place, and a panel whose pixels are not square. How much cameras differ, the places
// themselves say (empirical Bayes: Efron and Morris 1973), from the widest that is usual down; what they
// cannot say stays wide, and every deviation with it. False: the panel's pixels are not square, which is left
// free; begin again if it was not.
bool ffp_bundle_fit_freely(FfpBundle *bundle, int stride, double far);
// Tells of each place whose camera differs from those of the others; true if there are any.
bool ffp_bundle_tell_own(const FfpBundle *bundle);
// Fits one camera for all places where these hardly differ; the deviations stay those of the free fit.
void ffp_bundle_join(FfpBundle *bundle, int stride);

#endif
