// What a capture holds, and whether it can be reconstructed well.
#include "core/capture/capture.h"
#include <stdio.h>
#include "core/base/text.h"
#include "core/capture/pad.h"
#include "product/describe/print.h"
#include "rig/checks/checks.h"

static void print_truth(FILE *out, const FfpCapture *capture) {
    const FfpView *view = &capture->views[0];
    fprintf(out, "truth        %s%s%s%s%s%s\n", view->depth.data ? "depth " : "",
            view->normal.data ? "normal " : "", view->albedo.data ? "albedo " : "",
            view->roughness.data ? "roughness " : "", view->direct_white.data ? "direct light " : "",
            view->depth.data || view->normal.data || view->albedo.data ? "" : "none");
}

static void print_views(FILE *out, const FfpCapture *capture) {
    for (int v = 0; v < capture->n_views; v++) {
        const FfpView *view = &capture->views[v];
        int pictures = 0;
        for (int p = 0; p < capture->n_patterns; p++) pictures += view->images[p].data != NULL;
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

// What a reconstruction takes by itself, and what else it could be given.
static void print_structured_light(FILE *out, const FfpCapture *capture) {
    const int active = ffp_capture_active_pattern(capture, NULL, NULL);
    fputs("\nreconstructs from ", out);
    ffp_put_plain(out, active < 0 ? "none: no pattern other than black and white is in every view"
                                  : capture->patterns[active].name);
    const char *before = "; --pattern adds";
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

void ffp_print_capture(FILE *out, const FfpCapture *capture) {
    fputs("capture      ", out);
    ffp_put_plain(out, capture->name);
    fprintf(out, "\nviews        %d\npatterns     %d:", capture->n_views, capture->n_patterns);
    for (int p = 0; p < capture->n_patterns; p++) {
        fputc(' ', out);
        ffp_put_plain(out, capture->patterns[p].name);
        if (capture->patterns[p].novel) fputs(" (held back)", out);
    }
    print_structured_light(out, capture);
    fprintf(out, "\nbounds       centre %.4g %.4g %.4g, radius %.4g\n", (double)capture->centre[0],
            (double)capture->centre[1], (double)capture->centre[2], (double)capture->radius);
    fprintf(out, "intensity    %.4g %.4g %.4g (%s)\n", (double)capture->intensity[0],
            (double)capture->intensity[1], (double)capture->intensity[2],
            capture->intensity_known ? "given" : "unknown: estimated or assumed");
    print_truth(out, capture);
    print_views(out, capture);
    ffp_rig_checks(capture, out);
}

bool ffp_describe_capture(FILE *out, const char *path, FfpError *err) {
    FfpCapture capture;
    if (!ffp_capture_read(&capture, path, err)) return false;
    ffp_print_capture(out, &capture);
    ffp_capture_free(&capture);
    return true;
}
