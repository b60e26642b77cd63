// The reader of users' meshes by Assimp: a module (core/base/module.h), loaded by mesh_file.c.
#ifndef FFP_SHAPES_ASSIMP_MODULE_H
#define FFP_SHAPES_ASSIMP_MODULE_H

#include "core/base/module.h"
#include "world/shapes/mesh.h"

enum { FFP_ASSIMP_MODULE_VERSION = 1 }; // of the table below

typedef struct FfpAssimpModule {
    int version;
    // Triangles in one frame, with normals, checked; the arrays are malloc's, and stay where they are:
    // whoever asks is a process that ends with them. `facets`: the file's own normals are of no use. False,
    // and why.
    bool (*read)(FfpMesh *mesh, const char *path, bool facets, char why[400]);
} FfpAssimpModule;

extern FFP_MODULE_EXPORT const FfpAssimpModule ffp_assimp_module;

#endif
