#include "synth/trace.h"

#include <math.h>
#include <stdlib.h>
#include "base/arena.h"
#include "base/call.h"
#include "synth/scalar.h"

#if __has_include(<embree4/rtcore.h>)
#include <embree4/rtcore.h>
#else
#include <embree3/rtcore.h>
#endif

struct FfpTracer {
    RTCDevice device;
    RTCScene scene;
    const FfpMesh *mesh;
};

static void release(void *thing) {
    FfpTracer *tracer = thing;
    rtcReleaseScene(tracer->scene);
    rtcReleaseDevice(tracer->device);
    ffp_free(tracer);
}

FfpTracer *ffp_tracer_new(const FfpMesh *mesh, FfpError *err) {
    // Scattered rays are a little slower with AVX-512, and without it more processors make the same pixels.
    RTCDevice device = rtcNewDevice("threads=1,set_affinity=0,max_isa=avx2");
    FfpTracer *tracer = ffp_try_alloc(1, sizeof *tracer);
    if (!tracer) {
        if (device) rtcReleaseDevice(device);
        ffp_fail(err, FFP_ERROR_MEMORY, NULL, "out of memory");
        return NULL;
    }
    if (!device) {
        ffp_free(tracer);
        ffp_fail(err, FFP_ERROR_UNSUPPORTED, NULL, "Embree cannot start (error %d)",
                 (int)rtcGetDeviceError(NULL));
        return NULL;
    }
    *tracer = (FfpTracer){device, rtcNewScene(device), mesh};
    ffp_own(tracer, release);
    RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE);
    rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, mesh->positions, 0,
                               3 * sizeof(float), (size_t)mesh->n_vertices);
    rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, mesh->triangles, 0,
                               3 * sizeof(uint32_t), (size_t)mesh->n_triangles);
    rtcCommitGeometry(geometry);
    rtcAttachGeometry(tracer->scene, geometry);
    rtcReleaseGeometry(geometry);
    rtcCommitScene(tracer->scene);
    const enum RTCError error = rtcGetDeviceError(device);
    if (error != RTC_ERROR_NONE) {
        ffp_fail(err, error == RTC_ERROR_OUT_OF_MEMORY ? FFP_ERROR_MEMORY : FFP_ERROR_UNSUPPORTED, NULL,
                 "Embree cannot build its tree (error %d)", (int)error);
        ffp_tracer_free(tracer);
        return NULL;
    }
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

// Which of the FFP_RAYS lanes hold a ray, as Embree wants to know it.
static void set_valid(const FfpRays *rays, int valid[FFP_RAYS]) {
    for (int k = 0; k < FFP_RAYS; k++) valid[k] = k < rays->count ? -1 : 0;
}

static void set_rays(const FfpRays *rays, float far, struct RTCRay8 *out) {
    for (int k = 0; k < FFP_RAYS; k++) {
        out->org_x[k] = rays->origin[0][k], out->dir_x[k] = rays->direction[0][k];
        out->org_y[k] = rays->origin[1][k], out->dir_y[k] = rays->direction[1][k];
        out->org_z[k] = rays->origin[2][k], out->dir_z[k] = rays->direction[2][k];
        out->tnear[k] = 0, out->tfar[k] = far, out->time[k] = 0;
        out->mask[k] = 0xffffffffU, out->id[k] = (unsigned)k, out->flags[k] = 0;
    }
}

static void intersect(const FfpTracer *tracer, const int *valid, bool coherent, struct RTCRayHit8 *rays) {
#if RTC_VERSION_MAJOR >= 4
    struct RTCIntersectArguments arguments;
    rtcInitIntersectArguments(&arguments);
    arguments.flags = coherent ? RTC_RAY_QUERY_FLAG_COHERENT : RTC_RAY_QUERY_FLAG_INCOHERENT;
    rtcIntersect8(valid, tracer->scene, rays, &arguments);
#else
    struct RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    context.flags = coherent ? RTC_INTERSECT_CONTEXT_FLAG_COHERENT : RTC_INTERSECT_CONTEXT_FLAG_INCOHERENT;
    rtcIntersect8(valid, tracer->scene, &context, rays);
#endif
}

// Turns facet and normal to the side that the ray came from.
static void face(const float direction[3], FfpHit *hit) {
    float along = 0, agree = 0;
    for (int a = 0; a < 3; a++) along += hit->facet[a] * direction[a];
    for (int a = 0; a < 3 && along > 0; a++) hit->facet[a] = -hit->facet[a];
    for (int a = 0; a < 3; a++) agree += hit->facet[a] * hit->normal[a];
    for (int a = 0; a < 3 && agree < 0; a++) hit->normal[a] = -hit->normal[a];
}

// What lies where ray k met the mesh.
static void describe(const FfpTracer *tracer, const FfpRays *rays, const struct RTCRayHit8 *found, int k,
                     FfpHit *hit) {
    hit->t = found->ray.tfar[k];
    hit->triangle = found->hit.primID[k], hit->u = found->hit.u[k], hit->v = found->hit.v[k];
    const uint32_t *corner = tracer->mesh->triangles + 3 * (size_t)hit->triangle;
    const float u = hit->u, v = hit->v, w = 1 - u - v;
    const float facet[3] = {found->hit.Ng_x[k], found->hit.Ng_y[k], found->hit.Ng_z[k]};
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
    _Alignas(32) int valid[FFP_RAYS];
    struct RTCRayHit8 found;
    set_valid(rays, valid);
    set_rays(rays, INFINITY, &found.ray);
    for (int k = 0; k < FFP_RAYS; k++)
        found.hit.geomID[k] = found.hit.primID[k] = found.hit.instID[0][k] = RTC_INVALID_GEOMETRY_ID;
    intersect(tracer, valid, coherent, &found);
    unsigned mask = 0;
    for (int k = 0; k < rays->count; k++) {
        if (found.hit.geomID[k] == RTC_INVALID_GEOMETRY_ID) continue;
        mask |= 1U << k;
        describe(tracer, rays, &found, k, &hits[k]);
    }
    return mask;
}

unsigned ffp_trace_blocked(const FfpTracer *tracer, const FfpRays *rays) {
    _Alignas(32) int valid[FFP_RAYS];
    struct RTCRay8 shadow;
    set_valid(rays, valid);
    set_rays(rays, 1, &shadow);
#if RTC_VERSION_MAJOR >= 4
    struct RTCOccludedArguments arguments;
    rtcInitOccludedArguments(&arguments);
    rtcOccluded8(valid, tracer->scene, &shadow, &arguments);
#else
    struct RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    rtcOccluded8(valid, tracer->scene, &context, &shadow);
#endif
    unsigned mask = 0;
    for (int k = 0; k < rays->count; k++) mask |= (shadow.tfar[k] < 0 ? 1U : 0U) << k;
    return mask;
}
