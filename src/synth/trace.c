#include "synth/trace.h"

#include <math.h>
#include <stdlib.h>
#include "base/arena.h"

#if __has_include(<embree4/rtcore.h>)
#include <embree4/rtcore.h>
#else
#include <embree3/rtcore.h>
#include "synth/scalar.h"
#endif

struct FfpTracer {
    RTCDevice device;
    RTCScene scene;
    const FfpMesh *mesh;
};

FfpTracer *ffp_tracer_new(const FfpMesh *mesh, FfpError *err) {
    RTCDevice device = rtcNewDevice("threads=1,set_affinity=0");
    if (!device) {
        ffp_fail(err, NULL, "Embree cannot start (error %d)", (int)rtcGetDeviceError(NULL));
        return NULL;
    }
    FfpTracer *tracer = ffp_alloc(1, sizeof *tracer);
    *tracer = (FfpTracer){device, rtcNewScene(device), mesh};
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
        ffp_fail(err, NULL, "Embree cannot build its tree (error %d)", (int)error);
        ffp_tracer_free(tracer);
        return NULL;
    }
    return tracer;
}

void ffp_tracer_free(FfpTracer *tracer) {
    if (!tracer) return;
    rtcReleaseScene(tracer->scene);
    rtcReleaseDevice(tracer->device);
    free(tracer);
}

static void intersect(const FfpTracer *tracer, bool coherent, struct RTCRayHit *ray) {
#if RTC_VERSION_MAJOR >= 4
    struct RTCIntersectArguments arguments;
    rtcInitIntersectArguments(&arguments);
    arguments.flags = coherent ? RTC_RAY_QUERY_FLAG_COHERENT : RTC_RAY_QUERY_FLAG_INCOHERENT;
    rtcIntersect1(tracer->scene, ray, &arguments);
#else
    struct RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    context.flags = coherent ? RTC_INTERSECT_CONTEXT_FLAG_COHERENT : RTC_INTERSECT_CONTEXT_FLAG_INCOHERENT;
    rtcIntersect1(tracer->scene, &context, ray);
#endif
}

static struct RTCRay ray_of(const float origin[3], const float direction[3], float far) {
    return (struct RTCRay){.org_x = origin[0],
                           .org_y = origin[1],
                           .org_z = origin[2],
                           .dir_x = direction[0],
                           .dir_y = direction[1],
                           .dir_z = direction[2],
                           .tnear = 0,
                           .tfar = far,
                           .mask = 0xffffffffU};
}

// Turns facet and normal to the side that the ray came from.
static void face(const float direction[3], FfpHit *hit) {
    float along = 0, agree = 0;
    for (int a = 0; a < 3; a++) along += hit->facet[a] * direction[a];
    for (int a = 0; a < 3 && along > 0; a++) hit->facet[a] = -hit->facet[a];
    for (int a = 0; a < 3; a++) agree += hit->facet[a] * hit->normal[a];
    for (int a = 0; a < 3 && agree < 0; a++) hit->normal[a] = -hit->normal[a];
}

bool ffp_trace_hit(const FfpTracer *tracer, const float origin[3], const float direction[3], bool coherent,
                   FfpHit *hit) {
    struct RTCRayHit ray = {.ray = ray_of(origin, direction, INFINITY)};
    ray.hit.geomID = ray.hit.primID = RTC_INVALID_GEOMETRY_ID;
    intersect(tracer, coherent, &ray);
    if (ray.hit.geomID == RTC_INVALID_GEOMETRY_ID) return false;
    hit->t = ray.ray.tfar;
    hit->triangle = ray.hit.primID, hit->u = ray.hit.u, hit->v = ray.hit.v;
    const uint32_t *corner = tracer->mesh->triangles + 3 * (size_t)ray.hit.primID;
    const float u = ray.hit.u, v = ray.hit.v, w = 1 - u - v;
    const float facet[3] = {ray.hit.Ng_x, ray.hit.Ng_y, ray.hit.Ng_z};
    float facet_square = 0, square = 0;
    for (int a = 0; a < 3; a++) {
        const float *n = tracer->mesh->normals + a;
        hit->point[a] = origin[a] + hit->t * direction[a];
        hit->normal[a] = w * n[3 * corner[0]] + u * n[3 * corner[1]] + v * n[3 * corner[2]];
        square += hit->normal[a] * hit->normal[a];
        facet_square += facet[a] * facet[a];
    }
    const float scale = 1 / sqrtf(ffp_max(square, 1e-20F)),
                facet_scale = 1 / sqrtf(ffp_max(facet_square, 1e-30F));
    for (int a = 0; a < 3; a++) hit->normal[a] *= scale, hit->facet[a] = facet[a] * facet_scale;
    if (tracer->mesh->two_sided) face(direction, hit);
    return true;
}

bool ffp_trace_blocked(const FfpTracer *tracer, const float origin[3], const float direction[3]) {
    struct RTCRay ray = ray_of(origin, direction, 1);
#if RTC_VERSION_MAJOR >= 4
    struct RTCOccludedArguments arguments;
    rtcInitOccludedArguments(&arguments);
    rtcOccluded1(tracer->scene, &ray, &arguments);
#else
    struct RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    rtcOccluded1(tracer->scene, &context, &ray);
#endif
    return ray.tfar < 0;
}
