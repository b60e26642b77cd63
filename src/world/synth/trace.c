#include "world/synth/trace.h"
#include <math.h>
#include "core/base/call.h"
#include "world/shapes/scalar.h"
#include "world/synth/embree_module.h"

struct FfpTracer {
    const FfpEmbreeModule *embree;
    FfpTree tree;
    const FfpMesh *mesh;
};

static const FfpEmbreeModule *load(FfpError *err) {
    static FfpModule module = {.name = "embree",
                               .version = FFP_EMBREE_MODULE_VERSION,
                               .purpose = "generated scenes are lit by Embree",
                               .origin = "the package ffprocams-world, or a build with libembree-dev"};
    return ffp_module_load(&module, err);
}

bool ffp_tracer_available(FfpError *err) {
    return load(err) != NULL;
}

static void release(void *thing) {
    FfpTracer *tracer = thing;
    tracer->embree->release(&tracer->tree);
    ffp_free(tracer);
}

FfpTracer *ffp_tracer_new(const FfpMesh *mesh, FfpError *err) {
    const FfpEmbreeModule *embree = load(err);
    if (!embree) return NULL;
    FfpTracer *tracer = ffp_alloc(1, sizeof *tracer);
    int code = 0;
    const FfpTreeOutcome outcome = embree->build(&tracer->tree, mesh, &code);
    if (outcome != FFP_TREE_BUILT) {
        ffp_free(tracer);
        ffp_fail(err, outcome == FFP_TREE_NO_MEMORY ? FFP_ERROR_MEMORY : FFP_ERROR_UNSUPPORTED, NULL,
                 "Embree cannot build its tree (error %d)", code);
        return NULL;
    }
    tracer->embree = embree;
    tracer->mesh = mesh;
    ffp_own(tracer, release);
    return tracer;
}

void ffp_tracer_free(FfpTracer *tracer) {
    ffp_disown(tracer);
    if (tracer) release(tracer);
}

void ffp_rays_add(FfpRays *rays, const float origin[3], const float direction[3]) {
    const int k = rays->count++;
    for (int a = 0; a < 3; a++) rays->origin[a][k] = origin[a], rays->direction[a][k] = direction[a];
}

// Turns facet and normal to the side that the ray came from.
static void face(const float direction[3], FfpHit *hit) {
    float along = 0, agree = 0;
    for (int a = 0; a < 3; a++) along += hit->facet[a] * direction[a];
    for (int a = 0; a < 3 && along > 0; a++) hit->facet[a] = -hit->facet[a];
    for (int a = 0; a < 3; a++) agree += hit->facet[a] * hit->normal[a];
    for (int a = 0; a < 3 && agree < 0; a++) hit->normal[a] = -hit->normal[a];
}

// The surface where ray k met the mesh.
static void describe(const FfpTracer *tracer, const FfpRays *rays, const FfpMet *met, int k, FfpHit *hit) {
    hit->t = met->t[k];
    hit->triangle = met->triangle[k], hit->u = met->u[k], hit->v = met->v[k];
    const uint32_t *corner = tracer->mesh->triangles + 3 * (size_t)hit->triangle;
    const float u = hit->u, v = hit->v, w = 1 - u - v;
    const float facet[3] = {met->facet[0][k], met->facet[1][k], met->facet[2][k]};
    float direction[3], facet_square = 0, square = 0;
    for (int a = 0; a < 3; a++) {
        const float *n = tracer->mesh->normals + a;
        direction[a] = rays->direction[a][k];
        hit->point[a] = rays->origin[a][k] + hit->t * direction[a];
        hit->normal[a] = w * n[3 * corner[0]] + u * n[3 * corner[1]] + v * n[3 * corner[2]];
        square += hit->normal[a] * hit->normal[a];
        facet_square += facet[a] * facet[a];
    }
    const float scale = 1 / sqrtf(ffp_max(square, 1e-20F)),
                facet_scale = 1 / sqrtf(ffp_max(facet_square, 1e-30F));
    for (int a = 0; a < 3; a++) hit->normal[a] *= scale, hit->facet[a] = facet[a] * facet_scale;
    if (tracer->mesh->two_sided) face(direction, hit);
}

unsigned ffp_trace_hits(const FfpTracer *tracer, const FfpRays *rays, bool coherent, FfpHit hits[FFP_RAYS]) {
    FfpMet met;
    const unsigned mask = tracer->embree->hits(&tracer->tree, rays, coherent, &met);
    for (int k = 0; k < rays->count; k++)
        if (mask >> k & 1) describe(tracer, rays, &met, k, &hits[k]);
    return mask;
}

unsigned ffp_trace_blocked(const FfpTracer *tracer, const FfpRays *rays) {
    return tracer->embree->blocked(&tracer->tree, rays);
}
