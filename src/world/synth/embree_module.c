#include "world/synth/embree_module.h"
#include <math.h>
#include <string.h>

#if __has_include(<embree4/rtcore.h>)
#include <embree4/rtcore.h>
#else
#include <embree3/rtcore.h>
#endif

static void release(FfpTree *tree) {
    if (tree->scene) rtcReleaseScene(tree->scene);
    if (tree->device) rtcReleaseDevice(tree->device);
}

static FfpTreeOutcome failed(FfpTree *tree, enum RTCError error, int *code) {
    release(tree);
    *code = (int)error;
    return error == RTC_ERROR_OUT_OF_MEMORY ? FFP_TREE_NO_MEMORY : FFP_TREE_FAILED;
}

static FfpTreeOutcome build(FfpTree *tree, const FfpMesh *mesh, int *code) {
    // Scattered rays are a little slower with AVX-512, and without it more processors make the same pixels.
    RTCDevice device = rtcNewDevice("threads=1,set_affinity=0,max_isa=avx2");
    *tree = (FfpTree){.device = device};
    if (!device) return failed(tree, rtcGetDeviceError(NULL), code);
    RTCScene scene = tree->scene = rtcNewScene(device);
    RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE);
    rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, mesh->positions, 0,
                               3 * sizeof(float), (size_t)mesh->n_vertices);
    rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, mesh->triangles, 0,
                               3 * sizeof(uint32_t), (size_t)mesh->n_triangles);
    rtcCommitGeometry(geometry);
    rtcAttachGeometry(scene, geometry);
    rtcReleaseGeometry(geometry);
    rtcCommitScene(scene);
    const enum RTCError error = rtcGetDeviceError(device);
    return error == RTC_ERROR_NONE ? FFP_TREE_BUILT : failed(tree, error, code);
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

static void intersect(const FfpTree *tree, const int *valid, bool coherent, struct RTCRayHit8 *rays) {
#if RTC_VERSION_MAJOR >= 4
    struct RTCIntersectArguments arguments;
    rtcInitIntersectArguments(&arguments);
    arguments.flags = coherent ? RTC_RAY_QUERY_FLAG_COHERENT : RTC_RAY_QUERY_FLAG_INCOHERENT;
    rtcIntersect8(valid, tree->scene, rays, &arguments);
#else
    struct RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    context.flags = coherent ? RTC_INTERSECT_CONTEXT_FLAG_COHERENT : RTC_INTERSECT_CONTEXT_FLAG_INCOHERENT;
    rtcIntersect8(valid, tree->scene, &context, rays);
#endif
}

static unsigned hits(const FfpTree *tree, const FfpRays *rays, bool coherent, FfpMet *met) {
    _Alignas(32) int valid[FFP_RAYS];
    struct RTCRayHit8 found;
    set_valid(rays, valid);
    set_rays(rays, INFINITY, &found.ray);
    for (int k = 0; k < FFP_RAYS; k++)
        found.hit.geomID[k] = found.hit.primID[k] = found.hit.instID[0][k] = RTC_INVALID_GEOMETRY_ID;
    intersect(tree, valid, coherent, &found);
    unsigned mask = 0;
    for (int k = 0; k < rays->count; k++)
        mask |= (found.hit.geomID[k] != RTC_INVALID_GEOMETRY_ID ? 1U : 0U) << k;
    memcpy(met->t, found.ray.tfar, sizeof met->t);
    memcpy(met->u, found.hit.u, sizeof met->u);
    memcpy(met->v, found.hit.v, sizeof met->v);
    memcpy(met->facet[0], found.hit.Ng_x, sizeof met->facet[0]);
    memcpy(met->facet[1], found.hit.Ng_y, sizeof met->facet[1]);
    memcpy(met->facet[2], found.hit.Ng_z, sizeof met->facet[2]);
    memcpy(met->triangle, found.hit.primID, sizeof met->triangle);
    return mask;
}

static unsigned blocked(const FfpTree *tree, const FfpRays *rays) {
    _Alignas(32) int valid[FFP_RAYS];
    struct RTCRay8 shadow;
    set_valid(rays, valid);
    set_rays(rays, 1, &shadow);
#if RTC_VERSION_MAJOR >= 4
    struct RTCOccludedArguments arguments;
    rtcInitOccludedArguments(&arguments);
    rtcOccluded8(valid, tree->scene, &shadow, &arguments);
#else
    struct RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    rtcOccluded8(valid, tree->scene, &context, &shadow);
#endif
    unsigned mask = 0;
    for (int k = 0; k < rays->count; k++) mask |= (shadow.tfar[k] < 0 ? 1U : 0U) << k;
    return mask;
}

const FfpEmbreeModule ffp_embree_module = {FFP_EMBREE_MODULE_VERSION, build, release, hits, blocked};
