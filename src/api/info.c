// What a file holds, as text for people.
#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <tgmath.h>
#include "api/arguments.h"
#include "base/arena.h"
#include "base/call.h"
#include "base/text.h"
#include "base/file.h"
#include "base/kind.h"
#include "ffprocams.h"
#include "capture/capture.h"
#include "capture/pad.h"
#include "field/field.h"
#include "gaussians/gaussians.h"
#include "network/network.h"
#include "rig/checks.h"

#define HISTOGRAM_BINS 10
#define HISTOGRAM_WIDTH 50 // characters of the longest bar

// Strings from files may hold anything; a terminal should see only text.
static void put_text(FILE *out, const char *text) {
    for (; *text; text++) fputc((unsigned char)*text < ' ' && *text != '\n' ? '?' : *text, out);
}

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
        put_text(out, view->id);
        fprintf(out, ": camera %d x %d", view->camera.width, view->camera.height);
        const FfpCamera whole = ffp_whole_camera(&view->camera);
        if (whole.width != view->camera.width || whole.height != view->camera.height)
            fprintf(out, " (filled up to %d x %d, whole patches)", whole.width, whole.height);
        fprintf(out, ", f %.1f; projector %d x %d, f %.1f; %d pictures\n", (double)view->camera.fx,
                view->projector.width, view->projector.height, (double)view->projector.fx, pictures);
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
    put_text(out, active < 0 ? "nothing: no pattern but black and white is in every view"
                             : capture->patterns[active].name);
    const char *before = "; --pattern adds";
    for (int p = 0; active >= 0 && p < capture->n_patterns; p++) {
        const int views = views_under(capture, p);
        if (p == active || p == capture->black || p == capture->white || capture->patterns[p].novel ||
            views == 0)
            continue;
        fprintf(out, "%s ", before);
        before = "";
        put_text(out, capture->patterns[p].name);
        if (views < capture->n_views) fprintf(out, " (%d of %d views)", views, capture->n_views);
    }
}

static bool print_capture(FILE *out, const char *path, FfpError *err) {
    FfpCapture capture;
    if (!ffp_capture_read(&capture, path, err)) return false;
    fputs("capture      ", out);
    put_text(out, capture.name);
    fprintf(out, "\nviews        %d\npatterns     %d:", capture.n_views, capture.n_patterns);
    for (int p = 0; p < capture.n_patterns; p++) {
        fputc(' ', out);
        put_text(out, capture.patterns[p].name);
        if (capture.patterns[p].novel) fputs(" (held back)", out);
    }
    print_structured_light(out, &capture);
    fprintf(out, "\nbounds       centre %.4g %.4g %.4g, radius %.4g\n", (double)capture.centre[0],
            (double)capture.centre[1], (double)capture.centre[2], (double)capture.radius);
    fprintf(out, "intensity    %.4g %.4g %.4g (%s)\n", (double)capture.intensity[0],
            (double)capture.intensity[1], (double)capture.intensity[2],
            capture.intensity_known ? "given" : "unknown: estimated or assumed");
    print_truth(out, &capture);
    print_views(out, &capture);
    ffp_rig_checks(&capture, out);
    ffp_capture_free(&capture);
    return true;
}

static bool print_model(FILE *out, const char *path, FfpError *err) {
    FfpModel *model = ffp_model_read(path, err);
    if (!model) return false;
    const FfpModelConfig *config = &model->config;
    fprintf(out, "model        %s\nmodules      %s (%zu blocks, M = Mamba2, T = Transformer)\n", config->name,
            config->modules, strlen(config->modules));
    fprintf(out, "width        %d, patch %d, state %d, chunk %d, up to %d tokens\n", config->dim,
            config->patch, config->state, config->chunk, config->tokens);
    fprintf(out, "heads        %s%s%s%s, drawn as %s with %d x %d samples a pixel\n",
            config->residual ? "residuals around the classical start" : "plain",
            config->match_input ? ", matched depth among the inputs" : "",
            config->pixel_skip ? config->context_inputs ? ", pixel skip with context" : ", pixel skip" : "",
            config->appearance_cnn ? ", convolutional appearance" : "", config->render, config->samples,
            config->samples);
    fprintf(out, "parameters   %" PRId64 " in %d tensors\n", model->count, model->n_parameters);
    for (int i = 0; i < model->metadata_count; i++) {
        put_text(out, model->metadata[2 * i]);
        fputs(": ", out);
        put_text(out, model->metadata[2 * i + 1]);
        fputc('\n', out);
    }
    ffp_model_free(model);
    return true;
}

static void print_histogram(FILE *out, const FfpGaussians *gaussians) {
    int64_t bins[HISTOGRAM_BINS] = {0}, most = 1;
    for (int64_t i = 0; i < gaussians->count; i++) {
        const int bin = (int)(gaussians->opacity[i] * HISTOGRAM_BINS);
        bins[bin < 0 ? 0 : bin >= HISTOGRAM_BINS ? HISTOGRAM_BINS - 1 : bin]++;
    }
    for (int b = 0; b < HISTOGRAM_BINS; b++) most = bins[b] > most ? bins[b] : most;
    fputs("opacity\n", out);
    for (int b = 0; b < HISTOGRAM_BINS; b++) {
        fprintf(out, "  %.1f - %.1f %10" PRId64 " ", (double)b / HISTOGRAM_BINS,
                (double)(b + 1) / HISTOGRAM_BINS, bins[b]);
        for (int64_t i = 0; i < bins[b] * HISTOGRAM_WIDTH / most; i++) fputc('#', out);
        fputc('\n', out);
    }
}

static bool print_gaussians(FILE *out, const char *path, FfpError *err) {
    FfpGaussians gaussians;
    if (!ffp_gaussians_read(&gaussians, path, err)) return false;
    real low[3] = {INFINITY, INFINITY, INFINITY}, high[3] = {-INFINITY, -INFINITY, -INFINITY};
    for (int64_t i = 0; i < 3 * gaussians.count; i++) {
        low[i % 3] = fmin(low[i % 3], gaussians.centre[i]);
        high[i % 3] = fmax(high[i % 3], gaussians.centre[i]);
    }
    fprintf(out, "Gaussians    %" PRId64 "%s\n", gaussians.count,
            gaussians.count ? "" : ": there is nothing to draw");
    for (const char *at = gaussians.made_from; *at; at = strchr(at, '\n') + 1) {
        char name[FFP_MADE_FROM];
        snprintf(name, sizeof name, "%.*s", (int)strcspn(at, "\n"), at);
        fputs(at == gaussians.made_from ? "made from    " : ", ", out);
        put_text(out, name);
    }
    if (gaussians.made_from[0]) fputc('\n', out);
    if (gaussians.count) {
        fprintf(out, "centres      %.4g %.4g %.4g to %.4g %.4g %.4g\n", (double)low[0], (double)low[1],
                (double)low[2], (double)high[0], (double)high[1], (double)high[2]);
        print_histogram(out, &gaussians);
    }
    ffp_gaussians_free(&gaussians);
    return true;
}

static bool print_field(FILE *out, const char *path, FfpError *err) {
    FfpNeuralField field;
    if (!ffp_neural_field_read(&field, path, err)) return false;
    fprintf(out, "neural field %" PRId64 " numbers, of these %" PRId64 " of a hash grid of %d levels\n",
            field.layout.count, field.layout.grid, FFP_FIELD_LEVELS);
    fprintf(out, "sphere       centre %.4g %.4g %.4g, radius %.4g\n", (double)field.centre[0],
            (double)field.centre[1], (double)field.centre[2], (double)field.radius);
    fprintf(out, "density      in %.1f %% of %d x %d x %d cells around it; rays step by %.4g of the radius\n",
            100 * ffp_field_filled(&field), FFP_FIELD_CELLS, FFP_FIELD_CELLS, FFP_FIELD_CELLS,
            (double)field.step);
    fputs("read by      info, evaluate --field\n", out);
    ffp_neural_field_free(&field);
    return true;
}

static bool tell(FILE *out, const char *path, FfpError *err) {
    switch (ffp_file_kind(path)) {
    case FFP_KIND_FOLDER:
    case FFP_KIND_JSON:
        return print_capture(out, path, err);
    case FFP_KIND_PLY:
        return print_gaussians(out, path, err);
    case FFP_KIND_WEIGHTS:
        return print_model(out, path, err);
    case FFP_KIND_FIELD:
        return print_field(out, path, err);
    case FFP_KIND_IMAGE:
        return ffp_fail(err, FFP_ERROR_FILE, path,
                        "is a picture: not a capture, a model, Gaussians or a field");
    default:
        break;
    }
    FILE *stream = ffp_open_to_read(path, err);
    if (!stream) return false;
    fclose(stream);
    return ffp_fail(err, FFP_ERROR_FILE, path,
                    "is neither a capture, nor a model, nor Gaussians, nor a field");
}

static char *describe(const char *path, FfpError *err) {
    FfpText *text = ffp_text_new();
    if (tell(ffp_text_stream(text), path, err)) return ffp_text_end(text);
    ffp_text_free(text);
    return NULL;
}

typedef struct Call {
    const char *path;
    char *text;
} Call;

static bool work(void *argument, FfpError *err) {
    Call *call = argument;
    call->text = describe(call->path, err);
    return call->text != NULL;
}

char *ffp_info(FfpContext *context, const char *path, FfpError *err) {
    Call call = {path, NULL};
    if (!ffp_need(path, "path", err)) return NULL;
    return ffp_call_run(context, work, &call, err) ? call.text : NULL;
}
