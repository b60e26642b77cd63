// The contents of a capture, and whether it can be reconstructed well.
#include "core/capture/capture.h"
#include <math.h>
#include <stdio.h>
#include "core/base/alloc.h"
#include "core/base/log.h"
#include "core/base/text.h"
#include "core/capture/pad.h"
#include "core/capture/photographs.h"
#include "core/capture/reduce.h"
#include "product/describe/print.h"
#include "rig/checks/checks.h"

// A side with which all views together have so many numbers.
static int seen_side(const FfpCapture *taken, const FfpCamera *camera, int side, double most) {
    const double values = (3.0 * taken->n_patterns + 1) * camera->width * camera->height,
                 share = most / taken->n_views, scale = values > share ? sqrt(share / values) : 1;
    return (int)fmax(1, floor(side * scale));
}

static bool read_reduced(FfpLooked *looked, double most, FfpError *err) {
    const FfpCapture *taken = looked->taken;
    FfpCapture *seen = &looked->seen;
    int *all = ffp_alloc((size_t)taken->n_patterns, sizeof *all);
    bool ok = true;
    for (int p = 0; p < taken->n_patterns; p++) all[p] = p;
    seen->views = ffp_alloc((size_t)taken->n_views, sizeof *seen->views);
    FfpTask progress = ffp_task("reading", taken->n_views);
    for (seen->n_views = 0; ok && seen->n_views < taken->n_views; seen->n_views += ok) {
        const int v = seen->n_views;
        const FfpCamera *camera = &taken->views[v].camera;
        ok = ffp_photographs_read(&seen->views[v], taken, v, all, taken->n_patterns,
                                  seen_side(taken, camera, camera->width, most),
                                  seen_side(taken, camera, camera->height, most), err);
        ffp_task_step(&progress, v + 1, NULL);
    }
    ffp_task_end(&progress);
    ffp_free(all);
    if (ok && seen->scene) ffp_capture_estimate_ranges(seen);
    return ok;
}

bool ffp_looked_open(FfpLooked *looked, const char *path, double values, FfpError *err) {
    *looked = (FfpLooked){.taken = ffp_capture_load_most(path, values, err)};
    if (!looked->taken) return false;
    looked->seen = *looked->taken;
    looked->reduced = looked->taken->files != NULL;
    if (!looked->reduced || read_reduced(looked, values / 2, err)) return true;
    ffp_looked_free(looked);
    return false;
}

void ffp_looked_free(FfpLooked *looked) {
    if (looked->reduced) ffp_capture_reduced_free(&looked->seen);
    ffp_capture_free(looked->taken);
    ffp_free(looked->taken);
}

static void print_truth(FILE *out, const FfpCapture *capture) {
    static const char *const names[FFP_TRUTHS] = {"depth ", "normal ", "albedo ", "roughness ",
                                                  "direct light "};
    bool any = false;
    fputs("truth        ", out);
    for (int k = 0; k < FFP_TRUTHS; k++) {
        if (!ffp_photographs_truth(capture, 0, k)) continue;
        fputs(names[k], out);
        any = true;
    }
    fputs(any ? "\n" : "none\n", out);
}

static void print_views(FILE *out, const FfpCapture *capture) {
    for (int v = 0; v < capture->n_views; v++) {
        const FfpView *view = &capture->views[v];
        int pictures = 0;
        for (int p = 0; p < capture->n_patterns; p++) pictures += ffp_photographs_has(capture, v, p);
        fputs("  ", out);
        ffp_put_plain(out, view->id);
        fprintf(out, ": camera %d x %d", view->camera.width, view->camera.height);
        const FfpCamera whole = ffp_whole_camera(&view->camera);
        if (whole.width != view->camera.width || whole.height != view->camera.height)
            fprintf(out, " (padded to %d x %d, whole patches)", whole.width, whole.height);
        fprintf(out, ", f %.1f; projector %d x %d, f %.1f; %d picture%s\n", (double)view->camera.fx,
                view->projector.width, view->projector.height, (double)view->projector.fx, pictures,
                pictures == 1 ? "" : "s");
    }
}

static int views_under(const FfpCapture *capture, int pattern) {
    int count = 0;
    for (int v = 0; v < capture->n_views; v++) count += capture->views[v].images[pattern].data != NULL;
    return count;
}

// The patterns that a reconstruction takes by default, and those that it could be given.
static void print_structured_light(FILE *out, const FfpCapture *capture) {
    const int active = ffp_capture_active_pattern(capture, NULL, NULL);
    fputs("\nreconstructs from ", out);
    ffp_put_plain(out, active < 0 ? "none: no pattern other than black and white is in every view"
                                  : capture->patterns[active].name);
    const char *before = "; can add";
    for (int p = 0; active >= 0 && p < capture->n_patterns; p++) {
        const int views = views_under(capture, p);
        if (p == active || p == capture->black || p == capture->white || capture->patterns[p].novel ||
            views == 0)
            continue;
        fprintf(out, "%s ", before);
        before = "";
        ffp_put_plain(out, capture->patterns[p].name);
        if (views < capture->n_views) fprintf(out, " (%d of %d views)", views, capture->n_views);
    }
}

void ffp_print_capture(FILE *out, const FfpLooked *looked, FfpFindings *found) {
    const FfpCapture *capture = looked->taken, *seen = &looked->seen;
    fputs("capture      ", out);
    ffp_put_plain(out, capture->name);
    fprintf(out, "\nviews        %d\npatterns     %d:", capture->n_views, capture->n_patterns);
    for (int p = 0; p < capture->n_patterns; p++) {
        fputc(' ', out);
        ffp_put_plain(out, capture->patterns[p].name);
        if (p >= ffp_patterns_shown(capture))
            fputs(" (code)", out);
        else if (capture->patterns[p].novel)
            fputs(" (held back)", out);
    }
    print_structured_light(out, seen);
    fprintf(out, "\nbounds       centre %.4g %.4g %.4g, radius %.4g\n", (double)capture->centre[0],
            (double)capture->centre[1], (double)capture->centre[2], (double)capture->radius);
    fprintf(out, "intensity    %.4g %.4g %.4g (%s)\n", (double)capture->intensity[0],
            (double)capture->intensity[1], (double)capture->intensity[2],
            capture->intensity_known ? "given" : "unknown: estimated or assumed");
    print_truth(out, capture);
    print_views(out, capture);
    if (looked->reduced)
        fprintf(out, "looked at    photographs reduced to %d x %d\n", seen->views[0].camera.width,
                seen->views[0].camera.height);
    ffp_rig_look(found, seen, &capture->views[0].camera);
    fputs("checks\n", out);
    ffp_findings_page(out, found->items, found->count);
}

bool ffp_describe_capture(FILE *out, const char *path, FfpFindings *found, FfpError *err) {
    FfpLooked looked;
    if (!ffp_looked_open(&looked, path, FFP_LOOKED_VALUES, err)) return false;
    ffp_print_capture(out, &looked, found);
    ffp_looked_free(&looked);
    return true;
}
