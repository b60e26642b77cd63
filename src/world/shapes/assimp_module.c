#include "world/shapes/assimp_module.h"
#include <assimp/cimport.h>
#include <assimp/config.h>
#include <assimp/postprocess.h>
#include <assimp/scene.h>
#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { TRIANGLES_MAX = 20000000, WHY_MAX = 400 };
static const float FURTHEST = 1e15F; // a coordinate whose square a float can still hold
static const float CREASE = 60;      // degrees: a sharper edge than this stays an edge

// Always false.
__attribute__((format(printf, 2, 3))) static bool fail(char *why, const char *format, ...) {
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(why, WHY_MAX, format, arguments);
    va_end(arguments);
    return false;
}

// Triangles in one frame, with normals; NULL: aiGetErrorString tells why.
static const struct aiScene *import(const char *path, bool facets) {
    unsigned steps = aiProcess_Triangulate | aiProcess_SortByPType | aiProcess_PreTransformVertices |
                     aiProcess_GenSmoothNormals | aiProcess_JoinIdenticalVertices |
                     aiProcess_RemoveComponent | aiProcess_ValidateDataStructure;
    if (facets) steps |= aiProcess_ForceGenNormals;
    struct aiPropertyStore *settings = aiCreatePropertyStore();
    aiSetImportPropertyFloat(settings, AI_CONFIG_PP_GSN_MAX_SMOOTHING_ANGLE, CREASE);
    aiSetImportPropertyInteger(settings, AI_CONFIG_PP_SBP_REMOVE,
                               aiPrimitiveType_POINT | aiPrimitiveType_LINE);
    aiSetImportPropertyInteger(settings, AI_CONFIG_PP_RVC_FLAGS,
                               aiComponent_COLORS | aiComponent_TANGENTS_AND_BITANGENTS |
                                   aiComponent_BONEWEIGHTS | aiComponent_ANIMATIONS | aiComponent_TEXTURES |
                                   aiComponent_LIGHTS | aiComponent_CAMERAS);
    const struct aiScene *scene = aiImportFileExWithProperties(path, steps, NULL, settings);
    aiReleasePropertyStore(settings);
    return scene;
}

static bool count_parts(const struct aiScene *scene, FfpMesh *mesh, bool *with_uv, char *why) {
    long long vertices = 0, triangles = 0;
    *with_uv = true;
    for (unsigned i = 0; i < scene->mNumMeshes; i++) {
        const struct aiMesh *part = scene->mMeshes[i];
        vertices += part->mNumVertices, triangles += part->mNumFaces;
        *with_uv = *with_uv && part->mTextureCoords[0];
    }
    if (triangles == 0) return fail(why, "holds no triangle");
    if (triangles > TRIANGLES_MAX || vertices > 3LL * TRIANGLES_MAX)
        return fail(why, "%lld triangles exceed the limit of %d", triangles, TRIANGLES_MAX);
    mesh->n_vertices = (int)vertices, mesh->n_triangles = (int)triangles;
    return true;
}

static bool allocate(FfpMesh *mesh, bool with_uv, char *why) {
    const size_t vertices = (size_t)mesh->n_vertices;
    mesh->positions = calloc(vertices, 3 * sizeof(float));
    mesh->normals = calloc(vertices, 3 * sizeof(float));
    mesh->triangles = calloc((size_t)mesh->n_triangles, 3 * sizeof(uint32_t));
    if (with_uv) mesh->uv = calloc(vertices, 2 * sizeof(float));
    return (mesh->positions && mesh->normals && mesh->triangles && (mesh->uv || !with_uv)) ||
           fail(why, "out of memory");
}

static bool take_vertices(const struct aiMesh *part, FfpMesh *mesh, int vertex, char *why) {
    for (unsigned i = 0; i < part->mNumVertices; i++) {
        const size_t at = 3 * ((size_t)vertex + i);
        memcpy(mesh->positions + at, &part->mVertices[i], 3 * sizeof(float));
        if (part->mNormals) memcpy(mesh->normals + at, &part->mNormals[i], 3 * sizeof(float));
        for (size_t k = 0; k < 3; k++)
            if (!(fabsf(mesh->positions[at + k]) <= FURTHEST))
                return fail(why, "vertex %zu is not finite", at / 3);
        for (size_t k = 0; mesh->uv && k < 2; k++) {
            const float value = ((const float *)&part->mTextureCoords[0][i])[k];
            mesh->uv[2 * ((size_t)vertex + i) + k] = fabsf(value) < 1e6F ? value : 0;
        }
    }
    return true;
}

static bool take_faces(const struct aiMesh *part, FfpMesh *mesh, int vertex, int *triangle, char *why) {
    for (unsigned f = 0; f < part->mNumFaces; f++) {
        const struct aiFace *face = &part->mFaces[f];
        if (face->mNumIndices != 3) continue; // what was left of a polygon without an area
        uint32_t *corner = mesh->triangles + 3 * (size_t)(*triangle)++;
        for (int k = 0; k < 3; k++) {
            if (face->mIndices[k] >= part->mNumVertices)
                return fail(why, "a triangle refers to vertex %u of %u", face->mIndices[k],
                            part->mNumVertices);
            corner[k] = (uint32_t)vertex + face->mIndices[k];
        }
    }
    return true;
}

static bool take_parts(const struct aiScene *scene, FfpMesh *mesh, char *why) {
    int vertex = 0, triangle = 0;
    for (unsigned i = 0; i < scene->mNumMeshes; i++) {
        const struct aiMesh *part = scene->mMeshes[i];
        if (!take_vertices(part, mesh, vertex, why) || !take_faces(part, mesh, vertex, &triangle, why))
            return false;
        vertex += (int)part->mNumVertices;
    }
    mesh->n_triangles = triangle;
    return triangle > 0 || fail(why, "holds no triangle");
}

static bool has_extent(const FfpMesh *mesh) {
    for (int i = 3; i < 3 * mesh->n_vertices; i++)
        if (fabsf(mesh->positions[i] - mesh->positions[i % 3]) > 1e-12F) return true;
    return false;
}

static bool read_mesh(FfpMesh *mesh, const char *path, bool facets, char why[400]) {
    const struct aiScene *scene = import(path, facets);
    bool with_uv = false;
    if (!scene) return fail(why, "cannot be read: %s", aiGetErrorString());
    const bool ok = count_parts(scene, mesh, &with_uv, why) && allocate(mesh, with_uv, why) &&
                    take_parts(scene, mesh, why) &&
                    (has_extent(mesh) || fail(why, "all its vertices coincide"));
    aiReleaseImport(scene);
    return ok;
}

const FfpAssimpModule ffp_assimp_module = {FFP_ASSIMP_MODULE_VERSION, read_mesh};
