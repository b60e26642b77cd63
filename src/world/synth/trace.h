// Rays against one mesh, by Embree (embree_module.h).
#ifndef FFP_SYNTH_TRACE_H
#define FFP_SYNTH_TRACE_H

#include <stdbool.h>
#include "core/base/error.h"
#include "world/shapes/mesh.h"

typedef struct FfpTracer FfpTracer;

typedef struct FfpHit {
    float t;         // in units of the direction's length
    float point[3];  // where
    float facet[3];  // unit normal of the triangle, outward
    float normal[3]; // unit interpolated normal, outward
    uint32_t triangle;
    float u, v; // barycentric: the weights of the triangle's second and third corner
} FfpHit;

// False with an error that says what to install: there is no Embree.
bool ffp_tracer_available(FfpError *err);

// The mesh must live as long as the tracer. One build thread, so that the same mesh always gives the same
// tree.
FfpTracer *ffp_tracer_new(const FfpMesh *mesh, FfpError *err);
void ffp_tracer_free(FfpTracer *tracer); // NULL is allowed

// Up to FFP_RAYS rays that are traced side by side. Directions need no unit length.
enum { FFP_RAYS = 8 };
typedef struct FfpRays {
    int count;
    float origin[3][FFP_RAYS], direction[3][FFP_RAYS];
} FfpRays;
// Appends a ray; there must be room.
void ffp_rays_add(FfpRays *rays, const float origin[3], const float direction[3]);

// Nearest hit of each ray along origin + t direction, t > 0. Bit k of the result tells whether ray k hits;
// hits[k] is set where it does. `coherent`: the rays lie close to each other. Thread safe, as is the next
// one.
unsigned ffp_trace_hits(const FfpTracer *tracer, const FfpRays *rays, bool coherent, FfpHit hits[FFP_RAYS]);
// Bit k of the result tells whether anything lies between t = 0 and t = 1 on ray k.
unsigned ffp_trace_blocked(const FfpTracer *tracer, const FfpRays *rays);

#endif
