// The pixels of a capture: patterns, pictures, truth. Files are read side by side; of several errors the
// first is told.
#include <stdlib.h>
#include <string.h>
#include <strings.h>
#include <tgmath.h>
#include "core/base/call.h"
#include "core/base/file.h"
#include "core/base/log.h"
#include "core/base/memory.h"
#include "core/capture/coverage.h"
#include "core/capture/manifest.h"
#include "core/capture/pad.h"
#include "core/capture/photograph_files.h"
#include "core/capture/photographs.h"
#include "core/capture/positions.h"

// --- Sources. ---

static bool source_size(const FfpSource *source, int *width, int *height, FfpError *err) {
    if (!source->raw) return ffp_image_read_size(width, height, source->path, err);
    *width = source->raw->width;
    *height = source->raw->height;
    return ffp_raw_check(source->raw, source->path, err);
}

static FfpSize size_of_camera(const FfpManifest *manifest, const FfpView *view) {
    return (FfpSize){view->camera.width, view->camera.height, "camera", ffp_basename(manifest->file)};
}

static bool raw_has_size(const FfpSource *source, const FfpSize *size, FfpError *err) {
    return ffp_raw_check(source->raw, source->path, err) &&
           ffp_size_check(size, source->raw->width, source->raw->height, source->path, err);
}

// Of a source whose pixels nobody asks for.
static bool check_size(const FfpSource *source, const FfpSize *size, FfpError *err) {
    int width = 0, height = 0;
    return source_size(source, &width, &height, err) &&
           ffp_size_check(size, width, height, source->path, err);
}

static bool source_over_black(FfpImage *rgb, FfpImage *alpha, const FfpSource *source, const FfpSize *size,
                              FfpError *err) {
    if (!source->raw) return ffp_image_read_over_black_sized(rgb, alpha, source->path, size, err);
    return raw_has_size(source, size, err) && ffp_raw_over_black(rgb, alpha, source->raw, source->path, err);
}

// One channel of numbers as they stand.
static bool source_numbers(FfpImage *image, const FfpSource *source, const FfpSize *size, FfpError *err) {
    if (!source->raw) return ffp_image_read_raw16(image, source->path, size, err);
    return raw_has_size(source, size, err) && ffp_raw_channel(image, source->raw, source->path, err);
}

static bool source_mask(FfpImage *mask, const FfpSource *source, const FfpSize *size, FfpError *err) {
    if (source->raw)
        return raw_has_size(source, size, err) && ffp_raw_channel(mask, source->raw, source->path, err);
    FfpImage rgba;
    if (!ffp_image_read_sized(&rgba, source->path, FFP_COLOUR_ENCODED, size, err)) return false;
    *mask = ffp_mask_of(&rgba);
    ffp_image_free(&rgba);
    return true;
}

// --- Patterns. ---

// The projector's size: as the JSON says, otherwise as the reference's patterns or the first pattern file
// have it.
static bool settle_pattern_size(FfpManifest *manifest, FfpError *err) {
    FfpCapture *capture = manifest->capture;
    int width = manifest->pattern_width, height = manifest->pattern_height;
    if (manifest->known_patterns > 0) {
        const FfpImage *known = &capture->patterns[0].image;
        if (width > 0 && (width != known->width || height != known->height)) {
            return ffp_fail(err, FFP_ERROR_FILE, manifest->file,
                            "projector of %d x %d, but the capture's has %d x %d", width, height,
                            known->width, known->height);
        }
        width = known->width;
        height = known->height;
    }
    for (int i = 0; i < capture->n_patterns && width == 0; i++) {
        if (!manifest->patterns[i].path) continue;
        if (!source_size(&manifest->patterns[i], &width, &height, err)) return false;
        if (width < FFP_PATTERN_SIDE_MIN || height < FFP_PATTERN_SIDE_MIN) {
            return ffp_fail(err, FFP_ERROR_FILE, manifest->patterns[i].path,
                            "a pattern of %d x %d pixels is too small", width, height);
        }
    }
    if (width == 0) {
        width = manifest->other_width;
        height = manifest->other_height;
    }
    if (width == 0)
        return ffp_fail(err, FFP_ERROR_FILE, manifest->file,
                        "neither a projector size nor a pattern image to take it from");
    for (int v = 0; v < capture->n_views; v++) {
        capture->views[v].projector.width = width;
        capture->views[v].projector.height = height;
    }
    manifest->pattern_width = width;
    manifest->pattern_height = height;
    return true;
}

static bool load_pattern(FfpManifest *manifest, int index, FfpError *err) {
    FfpPattern *pattern = &manifest->capture->patterns[index];
    const int width = manifest->pattern_width, height = manifest->pattern_height;
    const FfpSource *source = &manifest->patterns[index];
    if (source->path) {
        const FfpSize size = {width, height, "projector", ffp_basename(manifest->file)};
        return source_over_black(&pattern->image, NULL, source, &size, err);
    }
    pattern->image = ffp_image_new(width, height, 3);
    const ptrdiff_t count = (ptrdiff_t)width * height * 3;
    for (ptrdiff_t i = 0; i < count; i++) pattern->image.data[i] = index == manifest->capture->white;
    return true;
}

// --- Views. ---

// Depth: 0, negative and 65535 and above are "no surface" in every kind of file.
static bool load_depth(FfpManifest *manifest, FfpImage *depth, const FfpSource *source, const FfpSize *size,
                       FfpError *err) {
    if (!source_numbers(depth, source, size, err)) return false;
    const ptrdiff_t pixels = (ptrdiff_t)depth->width * depth->height;
    for (ptrdiff_t i = 0; i < pixels; i++) {
        const real raw = depth->data[i];
        depth->data[i] = raw > 0 && raw < 65535 ? raw * manifest->depth_scale : 0;
    }
    return true;
}

// Normals are signed, so only an EXR can hold them; an 8-bit file shows itself by lengths that are not 1.
// Roughness from a file of integers shows itself by values above 1.
static bool check_truth(const FfpView *view, const FfpViewFiles *files, FfpError *err) {
    const ptrdiff_t pixels = (ptrdiff_t)view->camera.width * view->camera.height;
    for (ptrdiff_t i = 0; i < pixels && view->normal.data; i++) {
        const real *n = view->normal.data + 3 * i, square = n[0] * n[0] + n[1] * n[1] + n[2] * n[2];
        if (square > 0 && !(fabs(square - 1) < 0.05F)) {
            return ffp_fail(err, FFP_ERROR_FILE, files->normal.path,
                            "normals are not unit vectors (float EXR in world axes, 0 0 0 for none)");
        }
    }
    for (ptrdiff_t i = 0; i < pixels && view->roughness.data; i++) {
        const real value = view->roughness.data[i];
        if (!(value >= 0 && value <= 1))
            return ffp_fail(err, FFP_ERROR_FILE, files->roughness.path, "roughness is outside 0 to 1");
    }
    return true;
}

// Where a trusted position may lie: around the projector's picture, since a lens may have moved it out.
static bool check_correspondence(const FfpView *view, const char *path, FfpError *err) {
    const FfpImage *map = &view->correspondence;
    const real width = (real)view->projector.width, height = (real)view->projector.height;
    const ptrdiff_t pixels = (ptrdiff_t)map->width * map->height;
    for (ptrdiff_t i = 0; i < pixels; i++) {
        const real *p = map->data + 3 * i;
        if (!(p[2] >= 0 && p[2] <= 1))
            return ffp_fail(err, FFP_ERROR_FILE, path, "confidence (the third channel) is outside 0 to 1");
        if (p[2] > 0 && !(p[0] >= -width && p[0] <= 2 * width && p[1] >= -height && p[1] <= 2 * height))
            return ffp_fail(err, FFP_ERROR_FILE, path,
                            "position %g, %g is far outside the projector's %g x %g pixels", (double)p[0],
                            (double)p[1], (double)width, (double)height);
    }
    return true;
}

static bool is_png(const FfpSource *source) {
    const char *dot = source->raw ? NULL : strrchr(source->path, '.');
    return dot && strcasecmp(dot, ".png") == 0;
}

static bool read_positions(FfpView *view, const FfpSource *source, const FfpSize *size, FfpError *err) {
    FfpImage picture;
    if (!ffp_image_read_sized(&picture, source->path, FFP_COLOUR_STORED, size, err)) return false;
    view->correspondence = ffp_positions_decoded(&picture, view->projector.width, view->projector.height);
    ffp_image_free(&picture);
    return true;
}

// Of an EXR or the caller's memory: as they are.
static bool read_numbers(FfpView *view, const FfpSource *source, const FfpSize *size, FfpError *err) {
    return source_over_black(&view->correspondence, NULL, source, size, err);
}

static bool load_correspondence(FfpManifest *manifest, int index, FfpError *err) {
    const FfpSource *source = &manifest->views[index].correspondence;
    FfpView *view = &manifest->capture->views[index];
    if (!source->path) return true;
    const FfpSize size = size_of_camera(manifest, view);
    if (!(is_png(source) ? read_positions : read_numbers)(view, source, &size, err)) return false;
    return check_correspondence(view, source->path, err);
}

static bool load_truth(FfpManifest *manifest, int index, FfpError *err) {
    const FfpViewFiles *files = &manifest->views[index];
    FfpView *view = &manifest->capture->views[index];
    const FfpSource *const sources[5] = {&files->depth, &files->normal, &files->albedo, &files->roughness,
                                         &files->direct_white};
    FfpImage *const images[5] = {&view->depth, &view->normal, &view->albedo, &view->roughness,
                                 &view->direct_white};
    const FfpSize size = size_of_camera(manifest, view);
    for (int i = 0; i < 5; i++) {
        if (!sources[i]->path) continue;
        bool ok = false;
        if (i == 0)
            ok = load_depth(manifest, images[i], sources[i], &size, err);
        else if (i == 3)
            ok = source_numbers(images[i], sources[i], &size, err);
        else
            ok = source_over_black(images[i], NULL, sources[i], &size, err);
        if (!ok) return false;
    }
    return check_truth(view, files, err);
}

bool ffp_manifest_load_view(FfpManifest *manifest, int index, FfpCoverageSource *source, FfpError *err) {
    const FfpCapture *capture = manifest->capture;
    const FfpViewFiles *files = &manifest->views[index];
    FfpView *view = &manifest->capture->views[index];
    FfpImage *alphas = ffp_alloc((size_t)capture->n_patterns, sizeof *alphas);
    FfpImage mask = {0};
    const FfpSize size = size_of_camera(manifest, view);
    bool ok = true;
    for (int i = 0; i < capture->n_patterns && ok; i++) {
        const FfpSource *picture = &files->images[i];
        if (picture->path) ok = source_over_black(&view->images[i], &alphas[i], picture, &size, err);
    }
    if (ok && files->coverage.path) {
        const bool wanted = ffp_wants_mask(capture, alphas, manifest->mask_is_given);
        ok = wanted ? source_mask(&mask, &files->coverage, &size, err)
                    : check_size(&files->coverage, &size, err);
    }
    if (ok) *source = ffp_cover_view(capture, view, alphas, &mask, files->coverage.applied);
    ffp_image_free(&mask);
    for (int i = 0; i < capture->n_patterns; i++) ffp_image_free(&alphas[i]);
    ffp_free(alphas);
    if (!ok || !load_correspondence(manifest, index, err) || !load_truth(manifest, index, err)) return false;
    if (view->frame_width > 0) ffp_cut_to_frame(view, capture->n_patterns);
    return true;
}

// --- All of it. ---

// Of a view's pixels: its coverage, its pictures, and the maps that there are.
static double channels_of(const FfpViewFiles *files, int n_patterns) {
    const FfpSource *const of_three[4] = {&files->correspondence, &files->normal, &files->albedo,
                                          &files->direct_white};
    double channels = 1 + (files->depth.path != NULL) + (files->roughness.path != NULL);
    for (int i = 0; i < 4; i++) channels += of_three[i]->path ? 3 : 0;
    for (int i = 0; i < n_patterns; i++) channels += files->images[i].path ? 4 : 0; // alpha, for a while
    return channels;
}

static double values_of_views(const FfpManifest *manifest) {
    const FfpCapture *capture = manifest->capture;
    double values = 0;
    for (int v = 0; v < capture->n_views; v++)
        values += channels_of(&manifest->views[v], capture->n_patterns) * capture->views[v].camera.width *
                  capture->views[v].camera.height;
    return values;
}

static bool is_to_be_left(const FfpManifest *manifest) {
    return manifest->values_most > 0 && manifest->has_bounds && manifest->capture->intensity_known &&
           values_of_views(manifest) > manifest->values_most;
}

// Refuses what would not fit into memory before any of it is taken.
static bool check_memory(const FfpManifest *manifest, FfpError *err) {
    const double values =
        3.0 * manifest->pattern_width * manifest->pattern_height * manifest->capture->n_patterns +
        values_of_views(manifest);
    return ffp_memory_suffices(values * sizeof(real), "the images", "import narrower ones", manifest->file,
                               err);
}

static bool check_pictures(const FfpManifest *manifest, FfpError *err) {
    const FfpCapture *capture = manifest->capture;
    const int plain[2] = {capture->black, capture->white};
    for (int v = 0; v < capture->n_views && !manifest->targets; v++) {
        for (int k = 0; k < 2; k++) {
            if (manifest->views[v].images[plain[k]].path != NULL) continue;
            char where[FFP_PATH_MAX + 64];
            snprintf(where, sizeof where, "%s: views[%d]", manifest->file, v);
            return ffp_fail(err, FFP_ERROR_FILE, where, "view '%s' has no picture under the %s pattern '%s'",
                            capture->views[v].id, k == 0 ? "black" : "white",
                            capture->patterns[plain[k]].name);
        }
    }
    return true;
}

// The first error of n, in the order of the list.
static bool first_error(const FfpError *errors, const bool *ok, int n, FfpError *err) {
    for (int i = 0; i < n; i++) {
        if (!ok[i]) return ffp_fail(err, errors[i].code, NULL, "%s", errors[i].text);
    }
    return true;
}

typedef struct Loading {
    FfpManifest *manifest;
    FfpCoverageSource *sources;
    FfpError *errors;
    bool *ok;
} Loading;

static void load_one(void *argument, int64_t index) {
    const Loading *l = argument;
    const int i = (int)index, v = i - l->manifest->capture->n_patterns;
    if (i < l->manifest->known_patterns)
        l->ok[i] = true;
    else if (v < 0)
        l->ok[i] = load_pattern(l->manifest, i, &l->errors[i]);
    else
        l->ok[i] = ffp_manifest_load_view(l->manifest, v, &l->sources[v], &l->errors[i]);
    ffp_cancel_point();
}

static bool load_pixels(FfpManifest *manifest, FfpCoverageSource *sources, FfpError *err) {
    FfpCapture *capture = manifest->capture;
    const int n = capture->n_patterns + capture->n_views;
    FfpError *errors = ffp_arena_alloc(manifest->arena, (size_t)n, sizeof *errors);
    bool *ok = ffp_arena_alloc(manifest->arena, (size_t)n, sizeof *ok);
    for (int v = 0; v < capture->n_views; v++) {
        capture->views[v].images = ffp_alloc((size_t)capture->n_patterns, sizeof(FfpImage));
    }
    ffp_parallel_for(n, 0, load_one, &(Loading){manifest, sources, errors, ok});
    return first_error(errors, ok, n, err);
}

// The pattern of one of these names, or a new one of the first.
static int plain_pattern(FfpManifest *manifest, const char *name, const char *other, FfpError *err) {
    const FfpNode file = {.file = manifest->file};
    const int found = ffp_capture_find_pattern(manifest->capture, other);
    return found >= 0 ? found : ffp_manifest_pattern(manifest, name, &file, err);
}

// Devices, and the patterns whose files there are; black and white are always there.
static bool load_poses(FfpManifest *manifest, FfpError *err) {
    FfpCapture *capture = manifest->capture;
    if (capture->black < 0) capture->black = plain_pattern(manifest, "black", "all_black", err);
    if (capture->white < 0) capture->white = plain_pattern(manifest, "white", "all_white", err);
    if (capture->black < 0 || capture->white < 0 || !settle_pattern_size(manifest, err)) return false;
    for (int p = 0; p < capture->n_patterns; p++) {
        const bool there = manifest->patterns[p].path || p == capture->black || p == capture->white;
        if (there && !load_pattern(manifest, p, err)) return false;
    }
    if (manifest->keep) ffp_photographs_leave(manifest);
    for (int v = 0; v < capture->n_views; v++) {
        FfpView *view = &capture->views[v];
        view->images = ffp_alloc((size_t)capture->n_patterns, sizeof(FfpImage));
        view->camera.width = ffp_frame_width(view);
        view->camera.height = ffp_frame_height(view);
        view->frame_width = view->frame_height = 0;
    }
    return true;
}

static bool seen_by_all(const FfpManifest *manifest, int pattern) {
    for (int v = 0; v < manifest->capture->n_views; v++)
        if (!manifest->views[v].images[pattern].path) return false;
    return true;
}

static bool seen_by_any(const FfpManifest *manifest, int pattern) {
    for (int v = 0; v < manifest->capture->n_views; v++)
        if (manifest->views[v].images[pattern].path) return true;
    return false;
}

static bool is_wanted(const FfpManifest *manifest, int pattern) {
    const FfpCapture *capture = manifest->capture;
    const FfpWanted *wanted = manifest->wanted;
    for (int i = 0; i < wanted->n; i++)
        if (strcmp(wanted->patterns[i], capture->patterns[pattern].name) == 0) return true;
    if (pattern == capture->black || pattern == capture->white || pattern >= ffp_patterns_shown(capture))
        return true;
    return wanted->n == 0 && !capture->patterns[pattern].novel && seen_by_all(manifest, pattern);
}

// Forgets the photographs and the truth that nobody wants. False, without an error: other things would be
// taken from them, so that all must be read.
static bool keep_wanted(FfpManifest *manifest) {
    const FfpCapture *capture = manifest->capture;
    if (!manifest->has_bounds || capture->scene) return false;
    bool unwanted[FFP_PATTERNS_MAX], has_default = false;
    int unseen = 0;
    for (int p = 0; p < capture->n_patterns; p++) {
        const bool plain = p == capture->black || p == capture->white;
        const bool code = p >= ffp_patterns_shown(capture);
        unwanted[p] = !is_wanted(manifest, p) || (manifest->wanted->n == 0 && !plain && !code && has_default);
        has_default |= !unwanted[p] && !plain;
        if (unwanted[p] && capture->patterns[p].novel && unseen < FFP_UNSEEN_MAX) // ffp_capture_unseen
            unwanted[p] = false, unseen += seen_by_any(manifest, p);
    }
    for (int v = 0; v < capture->n_views; v++) {
        FfpViewFiles *files = &manifest->views[v];
        for (int p = 0; p < capture->n_patterns; p++)
            if (unwanted[p]) files->images[p].path = NULL;
        files->depth.path = files->normal.path = files->albedo.path = files->roughness.path =
            files->direct_white.path = NULL;
    }
    return true;
}

bool ffp_manifest_load(FfpManifest *manifest, FfpError *err) {
    FfpCapture *capture = manifest->capture;
    if (manifest->wanted && !keep_wanted(manifest)) return false;
    if (manifest->poses) return load_poses(manifest, err);
    if (!settle_pattern_size(manifest, err) || !check_pictures(manifest, err)) return false;
    manifest->keep = is_to_be_left(manifest);
    if (manifest->keep) return load_poses(manifest, err);
    if (!check_memory(manifest, err)) return false;
    FfpCoverageSource *sources = ffp_arena_alloc(manifest->arena, (size_t)capture->n_views, sizeof *sources);
    if (!load_pixels(manifest, sources, err)) return false;
    if (manifest->targets) return true; // bounds and intensity are the reference's
    int guessed = 0;
    for (int v = 0; v < capture->n_views; v++) guessed += sources[v] == FFP_COVERAGE_GUESSED;
    if (guessed > 0 && manifest->wanted) return false; // all photographs tell where the object is
    if (guessed > 0) {
        ffp_note("%s: %d of %d views have neither alpha nor a mask; the object is taken to be what white "
                 "brightens",
                 capture->name, guessed, capture->n_views);
    }
    if (!manifest->has_bounds)
        ffp_capture_estimate_bounds(capture);
    else if (capture->scene)
        ffp_capture_estimate_ranges(capture);
    return capture->intensity_known || ffp_estimate_intensity(capture, manifest->file, err);
}
