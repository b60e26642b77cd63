// The common state of simulate.c, surface.c, devices.c and indirect.c while they trace one view.
#ifndef FFP_SYNTH_SIMULATE_WORK_H
#define FFP_SYNTH_SIMULATE_WORK_H

#include "world/shapes/noise.h"
#include "world/shapes/scalar.h"
#include "world/synth/simulate.h"

#define FFP_RAY_OFFSET 1e-3F // secondary rays start this far off the surface

typedef struct FfpTracedDevice { // a camera or projector in float
    float origin[3], axes[9];    // rows: x, y, z axis in the world
    float fx, fy, cx, cy, width, height;
    const double *lens; // NULL: none
} FfpTracedDevice;

// Sums of one view before composition; [height, width, .] each.
typedef struct FfpViewSums {
    float *ambient;        // 3: incoming ambient radiance, cosine-weighted mean
    float *bounce;         // 3 x lanes: the same of the projector's light off other surfaces, every pattern's
    float *direct;         // 3 x lanes: what the samples send back of the projector's own light
    float *point, *smooth; // 3: mean position and unbumped normal
    float *hits;           // covered samples
    float *share;          // of the pixel that they are
} FfpViewSums;

typedef struct FfpViewWork {
    const FfpSimulation *sim;
    FfpView *view;
    FfpImage *visibility;
    FfpTracedDevice camera, projector;
    float focus; // depth of the projector's focal plane
    FfpViewSums sums;
    uint32_t seed;
} FfpViewWork;

// Where a ray of the camera met the surface, and what lies there.
typedef struct FfpSample {
    uint32_t index; // of the pixel's samples
    float ray[3];
    FfpHit hit;
    float albedo[3], roughness, normal[3]; // the normal with its relief
} FfpSample;

// Light that leaves the projector towards a point, before the pattern and shadows: I / d^2 within its
// rectangle.
typedef struct FfpIncoming {
    float u, v;       // where in the pattern
    float towards[3]; // unit, to the projector
    float fall;       // 1 / d^2
    float local[3];   // the point in the projector's frame
} FfpIncoming;

static inline float ffp_along(const float a[3], const float b[3]) {
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

// A pixel's values in an array of [height, width, 3, lanes].
static inline float *ffp_lanes_of(const FfpViewWork *w, float *values, size_t pixel) {
    return values + pixel * 3 * (size_t)w->sim->light->lanes;
}

// The R2 sequence (Roberts 2018): any run of it covers the unit square evenly; shifted per pixel.
static inline void ffp_even_pair(uint32_t index, uint32_t shift, float *x, float *y) {
    const uint32_t a = shift + index * 3242174889U, b = ffp_hash32(shift ^ 0x68bc21ebU) + index * 2447445414U;
    *x = (float)(a >> 8) * (1.0F / 16777216.0F), *y = (float)(b >> 8) * (1.0F / 16777216.0F);
}

// --- devices.c ---

FfpTracedDevice ffp_device_of(const FfpCamera *c, const double *lens);
// Where the device has the point (x, y, z) of its frame, pixels.
void ffp_device_pixel(const FfpTracedDevice *c, float x, float y, float z, float *u, float *v);
// World direction through pixel position (x, y) with camera z = 1, so that a hit's t is its depth.
void ffp_camera_ray(const FfpTracedDevice *c, float x, float y, float d[3]);
// False where no light of the projector arrives. Otherwise the ray along which something may stand in the
// way is added to `shadow`.
bool ffp_arrive(const FfpViewWork *w, const FfpHit *hit, const float normal[3], FfpIncoming *a,
                FfpRays *shadow);

// --- surface.c ---

// Albedo and roughness at a hit, over about `footprint` world units.
void ffp_surface_look(const FfpSimulation *sim, const FfpHit *hit, float footprint, float albedo[3],
                      float *roughness);
// Bends the unit normal there by the relief.
void ffp_surface_bump(const FfpSimulation *sim, const FfpHit *hit, float footprint, float normal[3]);

// --- indirect.c ---

// Adds to the pixel's sums of ambient and bounced light what reaches these samples; ambient_rays each.
// `shift` keys the pixel's random numbers.
void ffp_indirect_light(const FfpViewWork *w, size_t pixel, const FfpSample *samples, int count,
                        uint32_t shift);

#endif
