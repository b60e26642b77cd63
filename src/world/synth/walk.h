// Whole scenes: a corner, a table, columns, a facade or a stage, seen from inside. The projector stands (or
// two of them do), nothing turns, and the camera walks along an arc before it. Everything in view belongs to
// the scene, lit or not.
#ifndef FFP_SYNTH_WALK_H
#define FFP_SYNTH_WALK_H

#include "world/synth/room.h"
#include "world/synth/synth.h"

typedef struct FfpWalk {
    FfpRoom room;    // its parts and its lamp alone; lengths are metres, z is up, and cameras look along -x
    float ambient;   // radiance of the sky
    float intensity; // of each projector, W/sr at pattern value 1
    int n_projectors;
    FfpCamera projector[2];
    double aim[3];               // what cameras look at
    double away, height, degree; // the arc: its radius about the aim, the eye's height, half its angle
    double field;                // of the camera, vertical, degrees
} FfpWalk;

enum { FFP_WALK_KINDS = 5 };
const char *ffp_walk_name(const FfpSceneSpec *spec); // of its kind, which the seed decides

// The scene of (mesh, material, seed): mesh and material are those of its main object. To be freed.
FfpWalk ffp_walk_draw(const FfpSceneSpec *spec);
void ffp_walk_free(FfpWalk *walk);
// Poses, intrinsics and id of input view `index` of spec->views: with two projectors, views 2 k and 2 k + 1
// are one place of the camera. Pictures are 4:3, spec->resolution high, and whole patches wide.
void ffp_walk_input(const FfpWalk *walk, const FfpSceneSpec *spec, int index, FfpView *view);
// Target `index`: a new place of the camera near the arc, and one of the projectors.
void ffp_walk_target(const FfpWalk *walk, const FfpSceneSpec *spec, int index, FfpView *view);

#endif
