#include "core/capture/photographs.h"
#include <string.h>
#include "core/base/file.h"
#include "core/base/log.h"
#include "core/base/memory.h"
#include "core/capture/pad.h"
#include "core/capture/photograph_files.h"
#include "core/capture/reduce.h"

// One view of a capture, by itself, with the files that are wanted of it.
typedef struct Lone {
    FfpCapture capture; // of this view alone
    FfpView view;       // as the file has it
    FfpViewFiles files;
    FfpManifest manifest;
} Lone;

static void isolate(Lone *lone, const FfpCapture *capture, int index) {
    const FfpPhotographFiles *files = capture->files;
    const FfpWholePicture *whole = &files->wholes[index];
    lone->capture = *capture;
    lone->capture.views = &lone->view;
    lone->capture.n_views = 1;
    lone->view = capture->views[index];
    lone->view.camera.width = whole->width;
    lone->view.camera.height = whole->height;
    lone->view.frame_width = whole->frame_width;
    lone->view.frame_height = whole->frame_height;
    lone->view.images = ffp_alloc((size_t)capture->n_patterns, sizeof(FfpImage));
    lone->files = (FfpViewFiles){.images = ffp_alloc((size_t)capture->n_patterns, sizeof(FfpSource)),
                                 .coverage = files->views[index].coverage};
    lone->manifest = (FfpManifest){.capture = &lone->capture,
                                   .file = files->json,
                                   .folder = capture->folder,
                                   .views = &lone->files,
                                   .mask_is_given = files->mask_is_given};
}

static bool check_plain(const FfpCapture *capture, int index, int pattern, FfpError *err) {
    const bool plain = pattern == capture->black || pattern == capture->white;
    return !plain || capture->files->views[index].images[pattern].path ||
           ffp_fail(err, FFP_ERROR_FILE, capture->files->json,
                    "view '%s' has no picture under the %s pattern '%s'", capture->views[index].id,
                    pattern == capture->black ? "black" : "white", capture->patterns[pattern].name);
}

// The files of these patterns alone, and the mask's.
static bool load(FfpView *out, const FfpCapture *capture, int index, const int *patterns, int n,
                 FfpCoverageSource *source, FfpError *err) {
    const FfpPhotographFiles *files = capture->files;
    const double values = (4.0 * n + 3) * files->wholes[index].width * files->wholes[index].height;
    Lone lone;
    if (!ffp_memory_suffices(values * sizeof(real), "the images", "import narrower ones", files->json, err))
        return false;
    isolate(&lone, capture, index);
    for (int k = 0; k < n; k++) lone.files.images[patterns[k]] = files->views[index].images[patterns[k]];
    const bool ok = ffp_manifest_load_view(&lone.manifest, 0, source, err);
    ffp_free(lone.files.images);
    if (!ok) ffp_view_free(&lone.view, capture->n_patterns);
    *out = lone.view;
    return ok;
}

// Without alpha or a mask, the object's silhouette comes from all photographs.
static bool load_all(FfpView *out, const FfpCapture *capture, int index, FfpError *err) {
    FfpCoverageSource source;
    int *all = ffp_alloc((size_t)capture->n_patterns, sizeof *all);
    for (int p = 0; p < capture->n_patterns; p++) all[p] = p;
    const bool ok = load(out, capture, index, all, capture->n_patterns, &source, err);
    ffp_free(all);
    if (ok && source == FFP_COVERAGE_GUESSED)
        ffp_note("%s: view %s has neither alpha nor a mask; the object is taken to be what white brightens",
                 capture->name, out->id);
    return ok;
}

static bool load_whole(FfpView *out, const FfpCapture *capture, int index, const int *patterns, int n,
                       FfpError *err) {
    FfpCoverageSource source;
    if (!load(out, capture, index, patterns, n, &source, err)) return false;
    if (source == FFP_COVERAGE_MASK || source == FFP_COVERAGE_ALPHA) return true;
    ffp_view_free(out, capture->n_patterns);
    return load_all(out, capture, index, err);
}

// A photograph without its alpha, where it is known what the object is: one plane less in memory.
static bool load_colours(FfpView *out, const FfpCapture *capture, int index, int pattern, FfpError *err) {
    const FfpPhotographFiles *files = capture->files;
    Lone lone;
    isolate(&lone, capture, index);
    ffp_free(lone.files.images);
    const FfpSize size = {files->wholes[index].width, files->wholes[index].height, "camera",
                          ffp_basename(files->json)};
    const bool ok = ffp_image_read_over_black_sized(&lone.view.images[pattern], NULL,
                                                    files->views[index].images[pattern].path, &size, err);
    if (ok && lone.view.frame_width > 0) ffp_cut_to_frame(&lone.view, capture->n_patterns);
    if (!ok) ffp_view_free(&lone.view, capture->n_patterns);
    *out = lone.view;
    return ok;
}

// Reduces one photograph after the other, all by the same coverage: `first` is the white one's view.
static bool add_reduced(FfpView *out, const FfpCapture *capture, int index, FfpView *first,
                        const int *patterns, int n, FfpError *err) {
    const bool masked = capture->files->mask_is_given && capture->files->views[index].coverage.path;
    const int width = out->camera.width, height = out->camera.height, n_patterns = capture->n_patterns;
    for (int k = 0; k < n; k++) {
        FfpCoverageSource source;
        FfpView one;
        const int p = patterns[k];
        if (p == capture->white || out->images[p].data || !ffp_photographs_has(capture, index, p)) continue;
        if (!(masked ? load(&one, capture, index, &p, 1, &source, err)
                     : load_colours(&one, capture, index, p, err)))
            return false;
        ffp_image_free(&one.coverage);
        one.coverage = first->coverage;
        FfpView reduced = ffp_view_reduced(&one, n_patterns, &p, 1, width, height);
        one.coverage = (FfpImage){0};
        ffp_view_free(&one, n_patterns);
        out->images[p] = reduced.images[p];
        reduced.images[p] = (FfpImage){0};
        ffp_view_reduced_free(&reduced, n_patterns);
    }
    return true;
}

static bool read_reduced(FfpView *out, const FfpCapture *capture, int index, const int *patterns, int n,
                         int width, int height, FfpError *err) {
    const int white = capture->white, n_patterns = capture->n_patterns;
    FfpCoverageSource source;
    FfpView first;
    if (!load(&first, capture, index, &white, 1, &source, err)) return false;
    bool ok = true;
    if (source == FFP_COVERAGE_MASK || source == FFP_COVERAGE_ALPHA) {
        *out = ffp_view_reduced(&first, n_patterns, &white, 1, width, height);
        ffp_image_free(&first.images[white]);
        ok = add_reduced(out, capture, index, &first, patterns, n, err);
        if (!ok) ffp_view_reduced_free(out, n_patterns);
    } else {
        ffp_view_free(&first, n_patterns);
        if (!load_all(&first, capture, index, err)) return false;
        *out = ffp_view_reduced(&first, n_patterns, patterns, n, width, height);
    }
    ffp_view_free(&first, n_patterns);
    return ok;
}

bool ffp_photographs_read(FfpView *out, const FfpCapture *capture, int view, const int *patterns, int n,
                          int width, int height, FfpError *err) {
    const FfpView *from = &capture->views[view];
    if (!capture->files) {
        *out = ffp_view_reduced(from, capture->n_patterns, patterns, n, width, height);
        return true;
    }
    for (int k = 0; k < n; k++)
        if (!check_plain(capture, view, patterns[k], err)) return false;
    if (width == from->camera.width && height == from->camera.height)
        return load_whole(out, capture, view, patterns, n, err);
    return read_reduced(out, capture, view, patterns, n, width, height, err);
}
