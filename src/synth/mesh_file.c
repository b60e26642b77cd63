// Users' meshes, through Assimp. Some of its readers loop for ever or fall over on damaged files, so it works
// in a process of its own, with a limit on its time, and what it hands over is checked before it comes back.
#include <assimp/cimport.h>
#include <assimp/config.h>
#include <assimp/postprocess.h>
#include <assimp/scene.h>
#include <errno.h>
#include <math.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>
#include "base/arena.h"
#include "base/call.h"
#include "base/file.h"
#include "base/log.h"
#include "synth/mesh.h"
#include "synth/scalar.h"

enum { TRIANGLES_MAX = 20000000, HEADER_LINES = 1000 };
static const float FURTHEST = 1e15F;             // a coordinate whose square a float can still hold
static const long long FILE_MAX = 1 << 30;       // bytes
static const long long BYTES_A_SECOND = 1 << 20; // slower than this no good file is read
static const float CREASE = 60;                  // degrees: a sharper edge than this stays an edge

typedef struct Format {
    const char *ending;
    bool y_up;   // by its definition or by custom
    bool facets; // its normals are those of the facets, which say nothing about a smooth surface
} Format;
static const Format format_table[] = {{"obj", true, false},
                                      {"ply", false, false},
                                      {"stl", false, true},
                                      {"gltf", true, false},
                                      {"glb", true, false}};
enum { FORMATS = sizeof format_table / sizeof format_table[0] };

static const Format *format_of(const char *path) {
    const char *dot = strrchr(ffp_basename(path), '.');
    for (int i = 0; dot && i < FORMATS; i++)
        if (!strcasecmp(dot + 1, format_table[i].ending)) return &format_table[i];
    return NULL;
}

static bool check_file(const char *path, long long *size, FfpError *err) {
    struct stat about;
    if (stat(path, &about) != 0) return ffp_fail(err, FFP_ERROR_IO, path, "cannot open: no such file");
    if (!S_ISREG(about.st_mode)) return ffp_fail(err, FFP_ERROR_FILE, path, "is not a file");
    if (about.st_size == 0) return ffp_fail(err, FFP_ERROR_FILE, path, "is empty");
    *size = (long long)about.st_size;
    return *size <= FILE_MAX || ffp_fail(err, FFP_ERROR_FILE, path, "is larger than %lld bytes", FILE_MAX);
}

// Assimp searches an unfinished PLY header's end for ever.
static bool check_header(const char *path, const Format *format, FfpError *err) {
    if (strcmp(format->ending, "ply") != 0) return true;
    static const char end[] = "end_header";
    FILE *file = ffp_open_to_read(path, err);
    if (!file) return false;
    char line[512];
    bool found = false;
    for (int i = 0; !found && i < HEADER_LINES && fgets(line, sizeof line, file); i++)
        found = !strncmp(line, end, sizeof end - 1);
    fclose(file);
    return found || ffp_fail(err, FFP_ERROR_FILE, path, "is no PLY file: its header has no end");
}

// Triangles in one frame, with normals. NULL with an error.
static const struct aiScene *import(const char *path, const Format *format, FfpError *err) {
    unsigned steps = aiProcess_Triangulate | aiProcess_SortByPType | aiProcess_PreTransformVertices |
                     aiProcess_GenSmoothNormals | aiProcess_JoinIdenticalVertices |
                     aiProcess_RemoveComponent | aiProcess_ValidateDataStructure;
    if (format->facets) steps |= aiProcess_ForceGenNormals;
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
    if (!scene)
        ffp_fail(err, FFP_ERROR_FILE, path, "cannot be read as %s: %s", format->ending, aiGetErrorString());
    return scene;
}

static bool count_parts(const struct aiScene *scene, FfpMesh *mesh, bool *with_uv, const char *path,
                        FfpError *err) {
    long long vertices = 0, triangles = 0;
    *with_uv = true;
    for (unsigned i = 0; i < scene->mNumMeshes; i++) {
        const struct aiMesh *part = scene->mMeshes[i];
        vertices += part->mNumVertices, triangles += part->mNumFaces;
        *with_uv = *with_uv && part->mTextureCoords[0];
    }
    if (triangles == 0) return ffp_fail(err, FFP_ERROR_FILE, path, "holds no triangle");
    if (triangles > TRIANGLES_MAX || vertices > 3LL * TRIANGLES_MAX)
        return ffp_fail(err, FFP_ERROR_FILE, path, "%lld triangles are more than %d", triangles,
                        TRIANGLES_MAX);
    mesh->n_vertices = (int)vertices, mesh->n_triangles = (int)triangles;
    return true;
}

static bool take_part(const struct aiMesh *part, FfpMesh *mesh, int vertex, int *triangle, const char *path,
                      FfpError *err) {
    for (unsigned i = 0; i < part->mNumVertices; i++) {
        const size_t at = 3 * ((size_t)vertex + i);
        memcpy(mesh->positions + at, &part->mVertices[i], 3 * sizeof(float));
        if (part->mNormals) memcpy(mesh->normals + at, &part->mNormals[i], 3 * sizeof(float));
        for (size_t k = 0; k < 3; k++)
            if (!(fabsf(mesh->positions[at + k]) <= FURTHEST))
                return ffp_fail(err, FFP_ERROR_FILE, path, "vertex %zu is not a finite place", at / 3);
        for (size_t k = 0; mesh->uv && k < 2; k++) {
            const float value = ((const float *)&part->mTextureCoords[0][i])[k];
            mesh->uv[2 * ((size_t)vertex + i) + k] = fabsf(value) < 1e6F ? value : 0;
        }
    }
    for (unsigned f = 0; f < part->mNumFaces; f++) {
        const struct aiFace *face = &part->mFaces[f];
        if (face->mNumIndices != 3) continue; // what was left of a polygon without an area
        uint32_t *corner = mesh->triangles + 3 * (size_t)(*triangle)++;
        for (int k = 0; k < 3; k++) {
            if (face->mIndices[k] >= part->mNumVertices)
                return ffp_fail(err, FFP_ERROR_FILE, path, "a triangle asks for vertex %u of %u",
                                face->mIndices[k], part->mNumVertices);
            corner[k] = (uint32_t)vertex + face->mIndices[k];
        }
    }
    return true;
}

static bool take_parts(const struct aiScene *scene, FfpMesh *mesh, const char *path, FfpError *err) {
    int vertex = 0, triangle = 0;
    for (unsigned i = 0; i < scene->mNumMeshes; i++) {
        if (!take_part(scene->mMeshes[i], mesh, vertex, &triangle, path, err)) return false;
        vertex += (int)scene->mMeshes[i]->mNumVertices;
    }
    mesh->n_triangles = triangle;
    return triangle > 0 || ffp_fail(err, FFP_ERROR_FILE, path, "holds no triangle");
}

// Unit normals; where the file has none of use, the facet's.
static void mend_normals(FfpMesh *mesh) {
    for (int t = 0; t < mesh->n_triangles; t++) {
        const uint32_t *v = mesh->triangles + 3 * (size_t)t;
        const float *p[3];
        for (int k = 0; k < 3; k++) p[k] = mesh->positions + 3 * (size_t)v[k];
        float a[3], b[3];
        for (int k = 0; k < 3; k++) a[k] = p[1][k] - p[0][k], b[k] = p[2][k] - p[0][k];
        const float facet[3] = {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2],
                                a[0] * b[1] - a[1] * b[0]};
        for (int k = 0; k < 3; k++) {
            float *n = mesh->normals + 3 * (size_t)v[k];
            const float length = sqrtf(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]);
            if (!(length > 0.1F && length < 10)) memcpy(n, facet, sizeof facet);
            const float now = sqrtf(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]);
            for (int c = 0; c < 3; c++) n[c] = now > 0 ? n[c] / now : (c == 2 ? 1.0F : 0.0F);
        }
    }
}

static void allocate(FfpMesh *mesh, bool with_uv) {
    const size_t vertices = (size_t)mesh->n_vertices;
    mesh->positions = ffp_alloc(vertices * 3 + 4, sizeof(float));
    mesh->normals = ffp_alloc(vertices * 3 + 4, sizeof(float));
    mesh->triangles = ffp_alloc((size_t)mesh->n_triangles * 3, sizeof(uint32_t));
    if (with_uv) mesh->uv = ffp_alloc(vertices * 2, sizeof(float));
}

static bool has_extent(const FfpMesh *mesh) {
    for (int i = 3; i < 3 * mesh->n_vertices; i++)
        if (fabsf(mesh->positions[i] - mesh->positions[i % 3]) > 1e-12F) return true;
    return false;
}

static bool load(FfpMesh *mesh, const char *path, const Format *format, FfpError *err) {
    const struct aiScene *scene = import(path, format, err);
    if (!scene) return false;
    bool with_uv = false, ok = count_parts(scene, mesh, &with_uv, path, err);
    if (ok) {
        allocate(mesh, with_uv);
        ok = take_parts(scene, mesh, path, err) &&
             (has_extent(mesh) || ffp_fail(err, FFP_ERROR_FILE, path, "all its vertices lie in one place"));
    }
    aiReleaseImport(scene);
    return ok;
}

// --- The process that reads. ---

typedef struct Report { // comes through the pipe first, the arrays behind it
    bool ok, with_uv;
    int n_vertices, n_triangles;
    FfpError err;
} Report;

static bool send_arrays(const FfpMesh *mesh, FILE *to) {
    const size_t vertices = (size_t)mesh->n_vertices, triangles = (size_t)mesh->n_triangles;
    return fwrite(mesh->positions, 3 * sizeof(float), vertices, to) == vertices &&
           fwrite(mesh->normals, 3 * sizeof(float), vertices, to) == vertices &&
           fwrite(mesh->triangles, 3 * sizeof(uint32_t), triangles, to) == triangles &&
           (!mesh->uv || fwrite(mesh->uv, 2 * sizeof(float), vertices, to) == vertices);
}

static bool receive_arrays(FfpMesh *mesh, FILE *from) {
    const size_t vertices = (size_t)mesh->n_vertices, triangles = (size_t)mesh->n_triangles;
    return fread(mesh->positions, 3 * sizeof(float), vertices, from) == vertices &&
           fread(mesh->normals, 3 * sizeof(float), vertices, from) == vertices &&
           fread(mesh->triangles, 3 * sizeof(uint32_t), triangles, from) == triangles &&
           (!mesh->uv || fread(mesh->uv, 2 * sizeof(float), vertices, from) == vertices);
}

static void read_and_send(int pipe_end, const char *path, const Format *format, long long size) {
    const struct rlimit none = {0, 0},
                        seconds = {(rlim_t)(1 + size / BYTES_A_SECOND), (rlim_t)(2 + size / BYTES_A_SECOND)};
    ffp_call_forget();
    signal(SIGPIPE, SIG_DFL); // nobody left to tell
    FILE *to = fdopen(pipe_end, "wb");
    if (!to || setrlimit(RLIMIT_CORE, &none) != 0 || setrlimit(RLIMIT_CPU, &seconds) != 0) return;
    FfpMesh mesh = {0};
    Report report = {0};
    report.ok = load(&mesh, path, format, &report.err);
    report.with_uv = mesh.uv != NULL;
    report.n_vertices = mesh.n_vertices, report.n_triangles = mesh.n_triangles;
    if (fwrite(&report, sizeof report, 1, to) == 1 && (!report.ok || send_arrays(&mesh, to))) fflush(to);
}

// The process as its parent sees it; the call at work owns it.
typedef struct Reader {
    pid_t pid;
    FILE *from;
} Reader;

// How it ended, as waitpid gives it.
static int end_reader(Reader *reader) {
    int status = 0;
    fclose(reader->from);
    while (waitpid(reader->pid, &status, 0) < 0 && errno == EINTR) {
    }
    ffp_free(reader);
    return status;
}

static void stop_reader(void *thing) {
    Reader *reader = thing;
    kill(reader->pid, SIGKILL);
    end_reader(reader);
}

// NULL with an error.
static Reader *start_reader(const char *path, const Format *format, long long size, FfpError *err) {
    Reader *reader = ffp_alloc(1, sizeof *reader);
    int ends[2];
    const char *lacking = "no pipe";
    if (pipe(ends) == 0) {
        // Its buffers are copies of ours; it leaves without writing what is in them.
        reader->pid = (reader->from = fdopen(ends[0], "rb")) ? fork() : -1;
        if (reader->pid == 0) {
            close(ends[0]);
            read_and_send(ends[1], path, format, size);
            _exit(0);
        }
        close(ends[1]);
        if (reader->pid > 0) {
            ffp_own(reader, stop_reader);
            return reader;
        }
        lacking = "no process";
        if (reader->from)
            fclose(reader->from);
        else
            close(ends[0]);
    }
    ffp_free(reader);
    ffp_fail(err, FFP_ERROR_IO, path, "cannot be read: %s", lacking);
    return NULL;
}

// False without an error when the other side fell silent.
static bool receive(FfpMesh *mesh, FILE *from, bool *silent, FfpError *err) {
    Report report;
    *silent = fread(&report, sizeof report, 1, from) != 1;
    if (!*silent && report.ok) {
        mesh->n_vertices = report.n_vertices, mesh->n_triangles = report.n_triangles;
        allocate(mesh, report.with_uv);
        *silent = !receive_arrays(mesh, from);
    } else if (!*silent && err) {
        *err = report.err;
    }
    return !*silent && report.ok;
}

static bool read_apart(FfpMesh *mesh, const char *path, const Format *format, long long size, FfpError *err) {
    bool silent;
    Reader *reader = start_reader(path, format, size, err);
    if (!reader) return false;
    const bool ok = receive(mesh, reader->from, &silent, err);
    ffp_disown(reader);
    const int status = end_reader(reader);
    if (!silent) return ok;
    const bool slow = WIFSIGNALED(status) && (WTERMSIG(status) == SIGXCPU || WTERMSIG(status) == SIGKILL);
    return ffp_fail(err, FFP_ERROR_FILE, path, "is no %s file that can be read: %s", format->ending,
                    slow ? "its reader came to no end" : "its reader broke down");
}

bool ffp_mesh_read(FfpMesh *mesh, const char *path, FfpError *err) {
    *mesh = (FfpMesh){.two_sided = true};
    long long size = 0;
    const Format *format = format_of(path);
    if (!format) return ffp_fail(err, FFP_ERROR_FILE, path, "is not an .obj, .ply, .stl, .gltf or .glb file");
    if (!check_file(path, &size, err) || !check_header(path, format, err)) return false;
    if (!read_apart(mesh, path, format, size, err)) {
        ffp_mesh_free(mesh);
        return false;
    }
    static const float as_it_is[9] = {1, 0, 0, 0, 1, 0, 0, 0, 1}, y_to_z[9] = {1, 0, 0, 0, 0, -1, 0, 1, 0};
    ffp_mesh_place(mesh, format->y_up ? y_to_z : as_it_is);
    mend_normals(mesh);
    ffp_note("%s: %d triangles, %s up, %s; moved and scaled into a ball of radius %g", ffp_basename(path),
             mesh->n_triangles, format->y_up ? "y" : "z",
             mesh->uv ? "with texture coordinates" : "textures from three sides", (double)FFP_MESH_RADIUS);
    return true;
}
