// The picture of one view's camera: direct projector light with hard shadows, uniform ambient light with
// occlusion, one diffuse interreflection of both; in a room (room.h) a lamp's light, too, and two
// interreflections. One set of rays serves every pattern.
#ifndef FFP_SYNTH_SIMULATE_H
#define FFP_SYNTH_SIMULATE_H

#include <stdint.h>
#include "core/capture/capture.h"
#include "world/synth/light.h"
#include "world/synth/material.h"
#include "world/synth/synth.h"
#include "world/synth/texture.h"
#include "world/synth/trace.h"

typedef struct FfpSimulation {
    const FfpTracer *tracer;
    const FfpMesh *mesh;
    const FfpMaterial *material;
    const FfpTextures *textures; // instead of the material; NULL: none
    const FfpLight *light;       // every pattern, of the projectors' size
    float intensity[3], ambient; // projector W/sr at pattern value 1; ambient radiance
    int samples, ambient_rays; // primary rays a pixel (four times as many on silhouettes); ambient rays a hit
    float shot, read;          // noise of the images (ffp_sensor_noise)
    uint64_t seed;
    // Real devices; all NULL or 0: ideal ones.
    const FfpSensor *sensor; // settled; what is real light in it. The light is soft if it has focus_blur
    const double *camera_lens, *projector_lens; // core/base/lens.h
    const struct FfpChessboard *board;          // instead of material and textures
    const struct FfpSurroundings *around;       // the mesh goes on with a room; NULL: the object is alone
    bool whole;        // what is around is not the object's room but part of it: all of it has coverage
    bool photograph;   // images are what a camera without alpha takes: light, then noise, of every pixel
    bool light_only;   // of a photograph: images are linear light, before the camera's lens, without noise
    int first_pattern; // of the light's among all that are photographed: by it noise is drawn
} FfpSimulation;

// Fills images (all patterns), coverage (the object's share of each pixel, not the room's) and the truth maps
// of a view whose cameras are set. Colours and truth maps are means over the samples that hit, depth belongs
// to the pixel's centre. The images pass through 8-bit sRGB with straight 8-bit alpha, as a file would carry
// them, so that a scene in memory equals the same scene read back from disk. visibility (may be NULL)
// receives the share of covered samples that lie in the projector's rectangle and in nobody's shadow; one
// that faces away from it counts, with a cosine of 0. The result depends on the seed, `stream` and the
// arguments alone, not on the number of threads.
void ffp_simulate_view(const FfpSimulation *simulation, FfpView *view, uint32_t stream, FfpImage *visibility);

#endif
