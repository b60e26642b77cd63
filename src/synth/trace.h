// Rays against one mesh, by Embree 3 or 4.
#ifndef FFP_SYNTH_TRACE_H
#define FFP_SYNTH_TRACE_H

#include <stdbool.h>
#include "base/error.h"
#include "synth/mesh.h"

typedef struct FfpTracer FfpTracer;

typedef struct FfpHit {
    float t;         // in units of the direction's length
    float point[3];  // where
    float facet[3];  // unit normal of the triangle, outward
    float normal[3]; // unit interpolated normal, outward
    uint32_t triangle;
    float u, v; // barycentric: the weights of the triangle's second and third corner
} FfpHit;

// The mesh must live as long as the tracer. One build thread, so that the same mesh always gives the same
// tree.
FfpTracer *ffp_tracer_new(const FfpMesh *mesh, FfpError *err);
void ffp_tracer_free(FfpTracer *tracer); // NULL is allowed
// Nearest hit along origin + t direction, t > 0. Thread safe, as is the next one.
bool ffp_trace_hit(const FfpTracer *tracer, const float origin[3], const float direction[3], bool coherent,
                   FfpHit *hit);
// Whether anything lies between t = 0 and t = 1.
bool ffp_trace_blocked(const FfpTracer *tracer, const float origin[3], const float direction[3]);

#endif
