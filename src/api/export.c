// Gaussians for other programs: splats with one colour each, or a mesh.
#include "api/arguments.h"
#include "export/mesh.h"
#include "export/splats.h"

#include <string.h>
#include <strings.h>
#include <sys/stat.h>

#include "api/relight.h"
#include "apply/choose.h"
#include "base/alloc.h"
#include "base/call.h"
#include "base/file.h"
#include "base/log.h"
#include "render/bake.h"

enum { RESOLUTION_LEAST = 16, RESOLUTION_MOST = 512 };

typedef enum Kind { KIND_PLY, KIND_SPZ, KIND_GLTF, KIND_GLB, KIND_OBJ, KIND_NONE } Kind;

FfpExport ffp_export_defaults(void) {
    return (FfpExport){.resolution = 128};
}

static Kind kind_of(const char *file) {
    static const char *const endings[KIND_NONE] = {".ply", ".spz", ".gltf", ".glb", ".obj"};
    const char *base = ffp_basename(file), *dot = strrchr(base, '.');
    for (int k = 0; dot && k < KIND_NONE; k++)
        if (strcasecmp(dot, endings[k]) == 0) return (Kind)k;
    return KIND_NONE;
}

static bool lights(const FfpExport *options) {
    return options->light && strcmp(options->light, "ambient") != 0;
}

static bool check(const FfpExport *options, const FfpCapture *capture, FfpError *err) {
    const Kind kind = kind_of(options->file);
    if ((unsigned)options->up > FFP_UP_MINUS_Y)
        return ffp_fail(err, FFP_ERROR_ARGUMENT, "up", "%d is none", (int)options->up);
    if (options->mesh && (kind == KIND_PLY || kind == KIND_SPZ || kind == KIND_NONE))
        return ffp_fail(err, FFP_ERROR_ARGUMENT, options->file, "a mesh is written as .glb, .gltf or .obj");
    if (!options->mesh && (kind == KIND_OBJ || kind == KIND_NONE))
        return ffp_fail(err, FFP_ERROR_ARGUMENT, options->file,
                        "splats are written as .ply, .spz, .glb or .gltf%s",
                        kind == KIND_OBJ ? "; .obj is for a mesh" : "");
    if (options->mesh && lights(options))
        return ffp_fail(err, FFP_ERROR_ARGUMENT, "light",
                        "a mesh has albedo and roughness, and is lit by the program that shows it");
    if (!capture && (options->mesh || lights(options)))
        return ffp_fail(err, FFP_ERROR_ARGUMENT, options->file,
                        options->mesh ? "a mesh needs the capture: the cameras that saw the object"
                                      : "light needs the capture: its projector and patterns");
    if (options->mesh && (options->resolution < RESOLUTION_LEAST || options->resolution > RESOLUTION_MOST))
        return ffp_fail(err, FFP_ERROR_ARGUMENT, "resolution", "%d cells are not in %d to %d",
                        options->resolution, RESOLUTION_LEAST, RESOLUTION_MOST);
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

// --- Light. ---

static bool choose_pattern(FfpPattern *pattern, const FfpCapture *capture, const FfpCamera *projector,
                           const char *name, FfpError *err) {
    const bool white = strcmp(name, "white") == 0;
    const int known = white ? capture->white : ffp_capture_find_pattern(capture, name);
    *pattern = (FfpPattern){0};
    if (known >= 0) {
        pattern->image = ffp_image_copy(&capture->patterns[known].image);
        return true;
    }
    if (!ffp_is_file(name))
        return ffp_fail(
            err, FFP_ERROR_ARGUMENT, capture->folder,
            "%.256s is neither ambient nor white, nor an image file, nor a pattern of the capture, "
            "which are %s",
            name, ffp_list_patterns(capture).text);
    return ffp_pattern_read(pattern, name, projector->width, projector->height, err);
}

static bool bake_views(const FfpGaussians *gaussians, const FfpCapture *capture, const FfpExport *options,
                       const FfpView *light_view, const FfpView *camera_view, real *colour, FfpError *err) {
    FfpPattern pattern;
    const FfpRenderSettings settings = ffp_drawing_settings((FfpDrawing){.form = options->form}, NULL);
    if (!choose_pattern(&pattern, capture, &light_view->projector, options->light, err)) return false;
    FfpSummed summed = ffp_summed_new(&pattern.image);
    const real *pose = camera_view ? camera_view->camera.pose : NULL;
    const real eye[3] = {pose ? pose[3] : 0, pose ? pose[7] : 0, pose ? pose[11] : 0};
    const FfpBakeLight light = {&light_view->projector, capture->intensity, &summed, pose ? eye : NULL};
    ffp_bake(gaussians, &light, &settings, colour);
    ffp_summed_free(&summed);
    ffp_image_free(&pattern.image);
    return true;
}

static bool bake(const FfpGaussians *gaussians, const FfpCapture *capture, const FfpExport *options,
                 real *colour, FfpError *err) {
    if (!lights(options)) {
        memcpy(colour, gaussians->ambient, 3 * (size_t)gaussians->count * sizeof *colour);
        return true;
    }
    FfpChosen light, camera = {0};
    bool ok = ffp_choose_views(&light, capture, options->poses, &options->projector_view,
                               options->projector_view ? 1 : 0, err) &&
              (!options->camera_view ||
               ffp_choose_views(&camera, capture, options->poses, &options->camera_view, 1, err));
    ok = ok && bake_views(gaussians, capture, options, light.views[0], camera.views ? camera.views[0] : NULL,
                          colour, err);
    ffp_chosen_free(&light);
    ffp_chosen_free(&camera);
    return ok;
}

// --- Files. ---

static bool write_splats(const FfpGaussians *gaussians, const FfpCapture *capture, const FfpExport *options,
                         FfpExportStats *stats, FfpError *err) {
    const Kind kind = kind_of(options->file);
    real turn[4];
    turn_of(options->up, kind == KIND_PLY, turn);
    real *colour = ffp_alloc((size_t)gaussians->count + 1, 3 * sizeof *colour);
    bool ok = bake(gaussians, capture, options, colour, err);
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
    ffp_surface_turn(&mesh, turn);
    stats->triangles = 2 * (int64_t)mesh.n_quads;
    const bool ok = kind == KIND_OBJ ? ffp_surface_write_obj(&mesh, options->file, err)
                                     : ffp_surface_write_gltf(&mesh, options->file, kind == KIND_GLB, err);
    ffp_surface_free(&mesh);
    return ok;
}

typedef struct Call {
    const FfpGaussians *gaussians;
    const FfpCapture *capture;
    const FfpExport *options;
    FfpExportStats *stats;
} Call;

static bool work(void *argument, FfpError *err) {
    const Call *call = argument;
    FfpExportStats stats = {0};
    struct stat info;
    if (!check(call->options, call->capture, err) || !ffp_output_probe(call->options->file, err))
        return false;
    if (!(call->options->mesh ? write_mesh : write_splats)(call->gaussians, call->capture, call->options,
                                                           &stats, err))
        return false;
    if (stat(call->options->file, &info) == 0) stats.bytes = (int64_t)info.st_size;
    if (call->stats) *call->stats = stats;
    return true;
}

bool ffp_export(FfpContext *context, const FfpGaussians *gaussians, const FfpCapture *capture,
                const FfpExport *options, FfpExportStats *stats, FfpError *err) {
    Call call = {gaussians, capture, options, stats};
    if (!ffp_need(gaussians, "gaussians", err) || !ffp_need(options, "options", err) ||
        !ffp_need(options->file, "file", err) || !ffp_check_drawing((FfpDrawing){.form = options->form}, err))
        return false;
    return ffp_call_run(context, work, &call, err);
}
