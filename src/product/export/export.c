// Gaussians for other programs: splats with one colour each, or a mesh.
#include "product/export/export.h"
#include <string.h>
#include <strings.h>
#include <sys/stat.h>
#include "core/base/alloc.h"
#include "core/base/file.h"
#include "core/image/framing.h"
#include "engine/pipeline/relight.h"
#include "product/export/light.h"
#include "product/export/mesh.h"
#include "product/export/splats.h"

enum { RESOLUTION_LEAST = 16, RESOLUTION_MOST = 512 };

typedef enum Kind { KIND_PLY, KIND_SPZ, KIND_GLTF, KIND_GLB, KIND_OBJ, KIND_NONE } Kind;

static Kind kind_of(const char *file) {
    static const char *const endings[KIND_NONE] = {".ply", ".spz", ".gltf", ".glb", ".obj"};
    const char *base = ffp_basename(file), *dot = strrchr(base, '.');
    for (int k = 0; dot && k < KIND_NONE; k++)
        if (strcasecmp(dot, endings[k]) == 0) return (Kind)k;
    return KIND_NONE;
}

static bool check(const FfpExport *options, const FfpCapture *capture, FfpError *err) {
    const Kind kind = kind_of(options->file);
    if (!ffp_framing_check(options->framing, err) ||
        !ffp_check_choice((int)options->up, FFP_UP_MINUS_Y, "up", err))
        return false;
    if (options->mesh && (kind == KIND_PLY || kind == KIND_SPZ || kind == KIND_NONE))
        return ffp_fail(err, FFP_ERROR_ARGUMENT, options->file, "a mesh is written as .glb, .gltf or .obj");
    if (!options->mesh && (kind == KIND_OBJ || kind == KIND_NONE))
        return ffp_fail(err, FFP_ERROR_ARGUMENT, options->file,
                        "splats are written as .ply, .spz, .glb or .gltf%s",
                        kind == KIND_OBJ ? "; .obj is for a mesh" : "");
    if (options->mesh && ffp_export_lights(options))
        return ffp_fail(err, FFP_ERROR_ARGUMENT, "light",
                        "a mesh has albedo and roughness, and is lit by the program that shows it");
    if (!capture && (options->mesh || ffp_export_lights(options)))
        return ffp_fail(err, FFP_ERROR_ARGUMENT, options->file,
                        options->mesh ? "a mesh requires the capture, whose cameras saw the object"
                                      : "light requires the capture, with its projector and patterns");
    if (options->mesh && (options->resolution < RESOLUTION_LEAST || options->resolution > RESOLUTION_MOST))
        return ffp_fail(err, FFP_ERROR_ARGUMENT, "resolution", "%d cells are not in %d to %d",
                        options->resolution, RESOLUTION_LEAST, RESOLUTION_MOST);
    if (kind == KIND_PLY && !options->force && ffp_gaussians_are_relightable(options->file))
        return ffp_fail(
            err, FFP_ERROR_ARGUMENT, options->file,
            "exists and holds relightable Gaussians, which plain splats would replace: choose another "
            "name, or force it");
    return true;
}

// --- Axes. ---

#define HALF 0.70710678118654752F

// A quarter turn about x, or more, from the world to axes with y up (glTF, SPZ: x right, y up, z backwards)
// or y down (the PLY of 3DGS, whose worlds are those of photogrammetry: x right, y down, z forward).
static void turn_of(FfpUp up, bool y_down, real turn[4]) {
    static const real y_up[3][4] = {{HALF, -HALF, 0, 0}, {1, 0, 0, 0}, {0, 1, 0, 0}};
    static const real down[3][4] = {{HALF, HALF, 0, 0}, {0, 1, 0, 0}, {1, 0, 0, 0}};
    memcpy(turn, y_down ? down[up] : y_up[up], 4 * sizeof *turn);
}

static bool write_splats(const FfpGaussians *gaussians, const FfpCapture *capture, const FfpExport *options,
                         FfpExportStats *stats, FfpError *err) {
    const Kind kind = kind_of(options->file);
    real turn[4];
    turn_of(options->up, kind == KIND_PLY, turn);
    real *colour = ffp_alloc((size_t)gaussians->count + 1, 3 * sizeof *colour);
    bool ok = ffp_export_bake(gaussians, capture, options, colour, err);
    if (ok) {
        FfpSplats splats = ffp_splats_new(gaussians, colour, turn);
        stats->splats = splats.count;
        if (splats.count == 0)
            ok = ffp_fail(err, FFP_ERROR_ARGUMENT, options->file, "no Gaussian is opaque enough to be seen");
        else if (kind == KIND_PLY)
            ok = ffp_splats_write_ply(&splats, options->file, err);
        else if (kind == KIND_SPZ)
            ok = ffp_splats_write_spz(&splats, options->file, err);
        else
            ok = ffp_splats_write_gltf(&splats, options->file, kind == KIND_GLB, err);
        ffp_splats_free(&splats);
    }
    ffp_free(colour);
    return ok;
}

static bool write_mesh(const FfpGaussians *gaussians, const FfpCapture *capture, const FfpExport *options,
                       FfpExportStats *stats, FfpError *err) {
    const Kind kind = kind_of(options->file);
    const FfpRenderSettings settings = ffp_drawing_settings((FfpDrawing){.form = options->form}, NULL);
    real turn[4];
    turn_of(options->up, false, turn);
    FfpSurface mesh = {0};
    if (!ffp_surface_of_gaussians(&mesh, gaussians, capture, &settings, options->resolution, options->file,
                                  err))
        return false;
    ffp_surface_rotate(&mesh, turn);
    stats->triangles = 2 * (int64_t)mesh.n_quads;
    const bool ok = kind == KIND_OBJ ? ffp_surface_write_obj(&mesh, options->file, err)
                                     : ffp_surface_write_gltf(&mesh, options->file, kind == KIND_GLB, err);
    ffp_surface_free(&mesh);
    return ok;
}

bool ffp_export_run(const FfpGaussians *gaussians, const FfpCapture *capture, const FfpExport *options,
                    FfpExportStats *stats_out, FfpError *err) {
    FfpExportStats stats = {0};
    struct stat info;
    if (!check(options, capture, err) || !ffp_output_probe(options->file, err)) return false;
    if (!(options->mesh ? write_mesh : write_splats)(gaussians, capture, options, &stats, err)) return false;
    if (stat(options->file, &info) == 0) stats.bytes = (int64_t)info.st_size;
    if (stats_out) *stats_out = stats;
    return true;
}
