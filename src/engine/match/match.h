// Projector matching and the classical initialisation: per-pixel estimates without a network
// (docs/design/architecture.md).
#ifndef FFP_MATCH_MATCH_H
#define FFP_MATCH_MATCH_H

#include <stdbool.h>
#include <stdint.h>
#include "core/base/error.h"
#include "core/base/real.h"
#include "core/capture/capture.h"
#include "core/image/lookup.h"

// Per-pixel maps of all views, each [views, height, width(, 3)], background pixels zero. The capture is
// normalised (object in the unit sphere), so all lengths are in that unit.
typedef struct FfpInitialisation {
    int views, width, height;
    real *t; // distance along the unit camera ray to the surface: matched where lit, elsewhere filled or
             // found under black
    real *confidence; // [0,1]: 1 - best cost / second-best minimum's cost, times lit; 0 where the depth was
                      // filled
    real *lit; // [0,1]: weight of the projector's light there, (white - black) against the view's typical
    real *coverage;  // [0,1]: 2 c - 1 of the pixel's own coverage c, and at least c / 5; or what another
                     // view's silhouette leaves of the point, whichever is less
    real *agreement; // [0,1]: of the other views that could see the point, the share whose own depth agrees
    real *violation; // [0,1]: share of the other views that see past the point (their surface is well behind
                     // it)
    real *footprint; // world width of one camera pixel at the point, t_z / fx
    real *normal;    // 3, unit, world, facing the camera
    real *albedo;    // 3, linear, in [0,1]; without the gloss of the classical splats
    real *ambient;   // 3, linear: what the black image shows, of the object's own share of the pixel
    struct FfpReduced
        *reduced; // what a large capture was matched on (engine/match/reduce.h); NULL: its own pictures
    const struct FfpDevice *device; // of the settings, for searches that follow
} FfpInitialisation;

typedef struct FfpMatchSettings {
    int coarse_steps, fine_steps;   // hypotheses over the sphere, then around the best
    real bounds;                    // radius of the sphere searched (1.05)
    const struct FfpDevice *device; // that searches views of objects without codes; NULL: the CPU
} FfpMatchSettings;
FfpMatchSettings ffp_match_defaults(void);

// Runs matching on every view with the n patterns given (indices into the capture's, at least one) and
// derives all maps. The capture must be normalised. Every view has photographs under black, white and the
// first pattern; those under the others count where it has them. Large captures are matched on reduced
// pictures, and depth, confidence, agreement and violation are carried to full size (engine/match/reduce.h,
// engine/match/enlarge.h).
// Errors: a view without one of its first three photographs, views of different sizes.
bool ffp_initialisation_new(FfpInitialisation *initial, const FfpCapture *capture, const int *patterns, int n,
                            const FfpMatchSettings *settings, FfpError *err);
void ffp_initialisation_free(FfpInitialisation *initial);

// Unit quaternion (w x y z) that turns the z axis into the unit vector n by the shortest way; a zero vector
// gives the identity. The splats' frame: their flat third axis lies along the normal.
void ffp_normal_frame(const real n[3], real quaternion[4]);

// The two predictors of the quality table: picture of `view` under `pattern` as
// sRGB(black + (white - black) * lookup(pattern, u_p(depth))), encoded RGB. depth: camera z [height,width].
FfpImage ffp_predict_by_lookup(const FfpCapture *capture, int view, int pattern, const real *depth);
// Matched depth (camera z) of one view for the reference predictor, which uses the best hypothesis at every
// pixel; patterns as for ffp_initialisation_new.
void ffp_match_depth(const FfpCapture *capture, int view, const int *patterns, int n,
                     const FfpMatchSettings *settings, real *depth);

#endif
