// The tracer of rays by Embree 3 or 4: a module (core/base/module.h), loaded by trace.c.
#ifndef FFP_SYNTH_EMBREE_MODULE_H
#define FFP_SYNTH_EMBREE_MODULE_H

#include "core/base/module.h"
#include "world/synth/trace.h"

enum { FFP_EMBREE_MODULE_VERSION = 1 }; // of the table below

// Embree's handles of a mesh and the tree over its triangles.
typedef struct FfpTree {
    void *device, *scene;
} FfpTree;

typedef enum FfpTreeOutcome { FFP_TREE_BUILT, FFP_TREE_FAILED, FFP_TREE_NO_MEMORY } FfpTreeOutcome;

// Where rays met the mesh: lane k is ray k's, if it did.
typedef struct FfpMet {
    float t[FFP_RAYS], u[FFP_RAYS], v[FFP_RAYS], facet[3][FFP_RAYS]; // facets' normals are of any length
    uint32_t triangle[FFP_RAYS];
} FfpMet;

typedef struct FfpEmbreeModule {
    int version;
    // *code is Embree's, of an error; what was built until then is released.
    FfpTreeOutcome (*build)(FfpTree *tree, const FfpMesh *mesh, int *code);
    void (*release)(FfpTree *tree);
    // As ffp_trace_hits and ffp_trace_blocked.
    unsigned (*hits)(const FfpTree *tree, const FfpRays *rays, bool coherent, FfpMet *met);
    unsigned (*blocked)(const FfpTree *tree, const FfpRays *rays);
} FfpEmbreeModule;

extern FFP_MODULE_EXPORT const FfpEmbreeModule ffp_embree_module;

#endif
