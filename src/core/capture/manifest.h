// The description of a capture before its pixels are read: poses, names, and the source of each picture. The
// readers of both kinds of JSON and memory.c fill it in; load.c reads the pixels.
#ifndef FFP_CAPTURE_MANIFEST_H
#define FFP_CAPTURE_MANIFEST_H

#include "core/base/arena.h"
#include "core/capture/capture.h"
#include "core/capture/node.h"
#include "core/image/raw.h"

// Where a picture comes from: a file, or the caller's memory.
typedef struct FfpSource {
    const char *path;  // to open, or a name for messages; NULL: there is no picture
    const FfpRaw *raw; // NULL: the file
    bool applied;      // a mask by which the pictures are already over black
} FfpSource;

typedef struct FfpViewFiles {
    FfpSource *images; // [FFP_PATTERNS_MAX]
    FfpSource coverage, correspondence, depth, normal, albedo, roughness, direct_white;
} FfpViewFiles;

// The pictures that a reconstruction looks at: black, white, and the pictures under n named patterns, or, if
// n is 0, under the one that it takes then.
typedef struct FfpWanted {
    const char *const *patterns;
    int n;
} FfpWanted;

typedef struct FfpManifest {
    FfpCapture *capture;
    // NULL: everything is read.
    const FfpWanted *wanted;
    bool targets;        // poses to predict: views may lack black and white, or any image
    bool poses;          // likewise, and the pictures named need not exist: none is read
    bool keep;           // of poses: the places of the photographs stay with the capture (photographs.h)
    double values_most;  // more numbers than these in the photographs, and they are left in their files, if
                         // the file says intensity and bounds; 0: they are read
    int known_patterns;  // the first patterns have their images already (copied from the reference)
    const char *file;    // the JSON, or a name, for messages
    const char *folder;  // that contains it
    FfpArena *arena;     // owns all paths
    FfpSource *patterns; // [FFP_PATTERNS_MAX]; none: black or white without a file
    FfpViewFiles *views; // [n_views]
    int pattern_width, pattern_height; // 0: as the pattern files are ...
    int other_width, other_height;     // ... or as here, where there are none; 0: an error
    bool mask_is_given; // views[].coverage was named in the JSON, so it outranks an alpha channel
    real depth_scale;   // world units per unit of the depth files
    bool has_bounds;    // centre and radius were given
} FfpManifest;

// Both take the parsed root; sizes, numbers, names and poses are checked, and files are known to exist
// afterwards.
bool ffp_manifest_from_scene(FfpManifest *manifest, const FfpNode *root, FfpError *err);
bool ffp_manifest_from_render_poses(FfpManifest *manifest, const FfpNode *root, FfpError *err);

// Shared by the two: allocates n views; the index of a pattern, added if new (-1 with an error if there are
// too many); a camera's numbers from the keys of either kind; refuses a second view of the same name.
void ffp_manifest_new_views(FfpManifest *manifest, int n);
int ffp_manifest_pattern(FfpManifest *manifest, const char *name, const FfpNode *field, FfpError *err);
bool ffp_manifest_view_id(FfpManifest *manifest, int view, const FfpNode *field, FfpError *err);
// "folder/name" in the manifest's memory (NULL: too long); the second returns NULL if no such file exists.
const char *ffp_manifest_join(FfpManifest *manifest, const char *folder, const char *name);
const char *ffp_manifest_path(FfpManifest *manifest, const char *folder, const char *name);

#define FFP_PIXELS_MAX 1e7 // of focal lengths and principal points, which may lie far outside the image
#define FFP_CAMERA_SIDE_MIN 8
#define FFP_PATTERN_SIDE_MIN 2

// Reads all pixels, checks sizes, and completes the capture: coverage, bounds, intensity.
bool ffp_manifest_load(FfpManifest *manifest, FfpError *err);

#endif
