// The search for depth on a device (core/base/device.h): what ffp_match_view does on the CPU, a kernel a
// step. All arrays are the device's.
#ifndef FFP_MATCH_TABLE_H
#define FFP_MATCH_TABLE_H

#include "engine/match/consistency.h"
#include "engine/match/foreground.h"
#include "engine/match/observe.h"
#include "engine/match/refine.h"
#include "engine/match/surface.h"
#include "engine/match/sweep.h"

enum {
    FFP_SEARCH_WAYS = 8,         // paths that semi-global aggregation adds at a pixel
    FFP_SEARCH_PLANES_MAX = 256, // hypotheses
};

typedef struct FfpSeer { // a view that is asked about another view's points
    FfpCamera camera;
    int width, height;         // of its frame
    const unsigned char *wide; // ffp_hull_widened
} FfpSeer;

typedef struct FfpSearch { // a view, and what it is matched with
    FfpCamera camera, projector;
    FfpPlanes planes;
    FfpForeground foreground;
    FfpObservation observed;
    FfpBlurred patterns;
    int seers;
    FfpSeer seer[FFP_ASKED - 1];
} FfpSearch;

typedef struct FfpMatchTable {
    void (*hull)(unsigned char *inside, const FfpSearch *search); // ffp_hull
    void (*sweep)(real *cost, const unsigned char *inside, const FfpSearch *search);
    // The paths of ffp_semi_global [FFP_SEARCH_WAYS, foreground, planes], each as it is.
    void (*paths)(real *paths, const real *cost, const FfpSearch *search);
    // Depth and confidence of the pixels on the object, from the paths' sums; the others are left alone.
    void (*choose)(real *depth, real *confidence, const real *paths, const real *cost,
                   const FfpSearch *search);
    // ffp_refine_depth, with `steps` hypotheses of camera depth. sheet: of the picture's size, its arrays
    // empty but for nearness and jump; planes [h,w]: working memory.
    void (*refine)(real *out, const real *depth, const real *weight, const FfpSearch *search,
                   const FfpSheet *sheet, FfpPlane *planes, int steps, real range);
} FfpMatchTable;

#endif
