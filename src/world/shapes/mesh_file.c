// Users' meshes, through Assimp. Some of its readers loop for ever or fall over on damaged files, so it works
// in a process of its own, with a limit on its time, and what it hands over is checked before it comes back.
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
#include "core/base/arena.h"
#include "core/base/call.h"
#include "core/base/file.h"
#include "core/base/log.h"
#include "world/shapes/assimp_module.h"
#include "world/shapes/scalar.h"

enum { HEADER_LINES = 1000 };
static const long long FILE_MAX = 1 << 30;       // bytes
static const long long BYTES_A_SECOND = 1 << 20; // slower than this no good file is read

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
    return found || ffp_fail(err, FFP_ERROR_FILE, path, "is not a PLY file: its header has no end");
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

static const FfpAssimpModule *load_assimp(FfpError *err) {
    static FfpModule module = {.name = "assimp",
                               .version = FFP_ASSIMP_MODULE_VERSION,
                               .purpose = "meshes are read by Assimp",
                               .origin = "the package ffprocams-world, or a build with libassimp-dev"};
    return ffp_module_load(&module, err);
}

// --- The process that reads. ---

// The file to read, and how.
typedef struct Task {
    const char *path;
    const Format *format;
    long long size;
    const FfpAssimpModule *assimp;
} Task;

typedef struct Report { // comes through the pipe first, the arrays behind it
    bool ok, with_uv;
    int n_vertices, n_triangles;
    char why[400];
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

static void read_and_send(int pipe_end, const Task *task) {
    const rlim_t time = (rlim_t)(1 + task->size / BYTES_A_SECOND);
    const struct rlimit none = {0, 0}, seconds = {time, time + 1};
    ffp_call_forget();
    signal(SIGPIPE, SIG_DFL); // nobody left to tell
    FILE *to = fdopen(pipe_end, "wb");
    if (!to || setrlimit(RLIMIT_CORE, &none) != 0 || setrlimit(RLIMIT_CPU, &seconds) != 0) return;
    FfpMesh mesh = {0};
    Report report = {0};
    report.ok = task->assimp->read(&mesh, task->path, task->format->facets, report.why);
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
static Reader *start_reader(const Task *task, FfpError *err) {
    Reader *reader = ffp_alloc(1, sizeof *reader);
    int ends[2];
    const char *lacking = "no pipe";
    if (pipe(ends) == 0) {
        // Its buffers are copies of ours; it leaves without writing what is in them.
        reader->pid = (reader->from = fdopen(ends[0], "rb")) ? fork() : -1;
        if (reader->pid == 0) {
            close(ends[0]);
            read_and_send(ends[1], task);
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
    ffp_fail(err, FFP_ERROR_IO, task->path, "cannot be read: %s", lacking);
    return NULL;
}

static void allocate(FfpMesh *mesh, bool with_uv) {
    const size_t vertices = (size_t)mesh->n_vertices;
    mesh->positions = ffp_alloc(vertices * 3 + 4, sizeof(float));
    mesh->normals = ffp_alloc(vertices * 3 + 4, sizeof(float));
    mesh->triangles = ffp_alloc((size_t)mesh->n_triangles * 3, sizeof(uint32_t));
    if (with_uv) mesh->uv = ffp_alloc(vertices * 2, sizeof(float));
}

// False without an error when the other side fell silent.
static bool receive(FfpMesh *mesh, FILE *from, bool *silent, const Task *task, FfpError *err) {
    Report report;
    *silent = fread(&report, sizeof report, 1, from) != 1;
    if (*silent) return false;
    if (!report.ok) return ffp_fail(err, FFP_ERROR_FILE, task->path, "%s", report.why);
    mesh->n_vertices = report.n_vertices, mesh->n_triangles = report.n_triangles;
    allocate(mesh, report.with_uv);
    *silent = !receive_arrays(mesh, from);
    return !*silent;
}

static bool read_apart(FfpMesh *mesh, const Task *task, FfpError *err) {
    bool silent;
    Reader *reader = start_reader(task, err);
    if (!reader) return false;
    const bool ok = receive(mesh, reader->from, &silent, task, err);
    ffp_disown(reader);
    const int status = end_reader(reader);
    if (!silent) return ok;
    const bool slow = WIFSIGNALED(status) && (WTERMSIG(status) == SIGXCPU || WTERMSIG(status) == SIGKILL);
    return ffp_fail(err, FFP_ERROR_FILE, task->path, "is not a readable %s file: %s", task->format->ending,
                    slow ? "its reader took too long" : "its reader crashed");
}

bool ffp_mesh_read(FfpMesh *mesh, const char *path, FfpError *err) {
    *mesh = (FfpMesh){.two_sided = true};
    const Format *format = format_of(path);
    Task task = {.path = path, .format = format};
    if (!format) return ffp_fail(err, FFP_ERROR_FILE, path, "is not an .obj, .ply, .stl, .gltf or .glb file");
    if (!check_file(path, &task.size, err) || !check_header(path, format, err)) return false;
    task.assimp = load_assimp(err);
    if (!task.assimp || !read_apart(mesh, &task, err)) {
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
