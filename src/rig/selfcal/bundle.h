// All devices at once: the bundle adjustment of a camera at several places and a projector that stands still
// (Triggs et al. 2000). A spot of the panel is seen along one ray of the projector, so a point of the surface
// is one number, its nearness along that ray; it is solved for within each step, and the devices' numbers are
// all that is left to the fit (variable projection: Golub and Pereyra 1973).
#ifndef FFP_SELFCAL_BUNDLE_H
#define FFP_SELFCAL_BUNDLE_H

#include "rig/selfcal/devices.h"

typedef struct FfpBundle {
    const FfpTracks *tracks;
    double optics[FFP_BUNDLE_OPTICS];
    FfpRigid *places; // [n_places] projector's frame to the camera's there
    bool *known;      // [n_places] has a pose
    double *nearness; // [tracks->n] 1 / z along the projector's ray; 0: none
    FfpKnownFocal focal;
    double *deviation; // [FFP_BUNDLE_OPTICS + 6 n_places] of each number; NULL until it is judged
    double rms;        // of the sightings used, pixels
} FfpBundle;

// Where the camera at a place sees a point of the projector's frame; false: behind it.
bool ffp_bundle_see(const FfpBundle *bundle, int place, const double point[3], double at[2]);
// The point of a track; false where it has none.
bool ffp_bundle_point(const FfpBundle *bundle, int track, double point[3]);

// Solves every track's nearness for the devices as they are, from its sightings in places that are known.
void ffp_bundle_triangulate(FfpBundle *bundle);
// Fits all that is known, every `stride`-th track, and takes sightings out that lie `far` times the median
// away (0: none). The unit of length is kept: the first known place is as far from the projector as it was.
void ffp_bundle_fit(FfpBundle *bundle, int stride, double far, bool deviations);

#endif
