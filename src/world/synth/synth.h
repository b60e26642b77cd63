// The training world: shapes, materials, patterns, the rig and the Embree light simulator. A scene is a pure
// function of (mesh, material, seed): the same numbers give the same pixels whatever the thread count, and up
// to floating-point rounding on every machine and compiler.
#ifndef FFP_SYNTH_SYNTH_H
#define FFP_SYNTH_SYNTH_H

#include <stdbool.h>
#include <stdint.h>
#include "core/base/error.h"
#include "core/capture/capture.h"

// Imperfections of real devices. All 0: nothing, bit for bit.
typedef struct FfpSensor {
    float exposure; // of the camera, in stops; lamp and ambient (and the capture's intensity) scale with it
    float shot,
        read;      // noise of a linear pixel value v: variance shot * v + read^2. 1/shot: electrons at v = 1
    float defocus; // of the projector: deviation of a Gaussian, in its pixels
    float gamma;   // the projector sends value^(1 + gamma) ...
    float black_level;             // ... and this share of white where a pattern is black
    float turn_error, shift_error; // of all written poses: deviation, radians and world units on each axis
    // Real light. The projector's pictures are P' = (1 - r) P + r (G * P), the camera's likewise; what is 0
    // and on is as ffp_sensor_settle says.
    float real_light;              // strength at which all below is drawn; 0: only what is set
    float spread[3], spread_reach; // r of each channel; deviation of G, pixels of a panel 800 wide
    float glare, glare_reach;      // r of the camera; deviation of G, share of the picture's longer side
    float power;                   // the projector sends the file's value^power, instead of sRGB and gamma
    float vignetting, throw_fall;  // of camera and projector: light falls by this share at half a diagonal
    float focus_blur, focus_at;    // deviation, pixels of a panel 800 wide a world unit off the focal plane;
                                   // the plane's distance, relative to the origin's
} FfpSensor;

// How the input views are taken.
typedef enum FfpSceneRig {
    FFP_SCENE_TURNTABLE, // camera and projector fixed to each other; the object turns
    FFP_SCENE_FREE,      // every view has a camera and a projector of its own, all around the object
    FFP_SCENE_SPHERE,    // the projector stays before the object, and the camera goes around it in a spiral
    FFP_SCENE_WALK,      // a whole scene around the object (walk.h): a projector stands, the camera walks
    FFP_SCENE_WALK_TWO   // the same with two projectors; two views of each place of the camera
} FfpSceneRig;

typedef struct FfpSceneSpec {
    int mesh, material; // 0 .. ffp_mesh_count()-1, 0 .. ffp_material_count()-1
    uint64_t seed;
    int resolution;            // camera image side
    FfpSceneRig rig;           // of the input views (turntable)
    int views;                 // input views (8)
    int targets;               // further views with new camera and projector poses
    int lollipops;             // patterns besides black and white
    int naturals;              // and natural-looking ones, marked novel: for test scenes only
    int pattern_side;          // 800
    int samples, ambient_rays; // primary samples a pixel; ambient rays a sample
    bool jitter; // training: vary ambient, intensity and a turntable's poses; false: the default rig exactly
    FfpSensor sensor;
    const struct FfpMesh *own_mesh; // instead of a numbered mesh or material; NULL: none
    const struct FfpTextures *own_textures;
    const char *own_name;     // of the capture, with a mesh of the user's
    const char *own_material; // the file that own_textures are of, for the capture's name; NULL: "own"
    const struct FfpPattern
        *own_patterns; // [lollipops - 1] in place of all lollipops but the first; NULL: none
} FfpSceneSpec;
FfpSceneSpec ffp_scene_defaults(void);
// A file's name without folder and ending, with nothing in it that a folder's name had better not have.
void ffp_asset_name(const char *path, char name[FFP_NAME_MAX]);

// Input views first, then targets, in one capture (targets are views with ids "novel_NN"). Every view has
// black, white, all lollipops and all natural patterns (natural.h), coverage, depth, normal, albedo,
// roughness and direct_white. Bounds are exact, intensity known. Images are what a reader gets from 8-bit PNG
// with straight alpha; truth maps are means over the samples that hit (not multiplied by coverage), depth is
// that of the pixel's centre ray. With pose errors the written poses differ from those that images and truth
// maps were made with. Rig and number of views and the resolution change nothing else: object, light,
// patterns and the poses of the targets are those of (mesh, material, seed, jitter); targets of equal
// resolution are equal to the bit.
bool ffp_scene_make(FfpCapture *capture, const FfpSceneSpec *spec, FfpError *err);

int ffp_material_count(void);
const char *ffp_material_name(int material);

#endif
