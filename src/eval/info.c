// What a file holds, told to people.
#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <tgmath.h>
#include "base/arena.h"
#include "base/file.h"
#include "ffprocams.h"
#include "capture/capture.h"
#include "gaussians/gaussians.h"
#include "network/network.h"
#include "rig/checks.h"

#define HISTOGRAM_BINS 10
#define HISTOGRAM_WIDTH 50 // characters of the longest bar

// Strings from files may hold anything; a terminal should see only text.
static void put_text(FILE *out, const char *text) {
    for (; *text; text++) fputc((unsigned char)*text < ' ' && *text != '\n' ? '?' : *text, out);
}

static void tell_truth(FILE *out, const FfpCapture *capture) {
    const FfpView *view = &capture->views[0];
    fprintf(out, "truth        %s%s%s%s%s%s\n", view->depth.data ? "depth " : "",
            view->normal.data ? "normal " : "", view->albedo.data ? "albedo " : "",
            view->roughness.data ? "roughness " : "", view->direct_white.data ? "direct light " : "",
            view->depth.data || view->normal.data || view->albedo.data ? "" : "none");
}

static void tell_views(FILE *out, const FfpCapture *capture) {
    for (int v = 0; v < capture->n_views; v++) {
        const FfpView *view = &capture->views[v];
        int pictures = 0;
        for (int p = 0; p < capture->n_patterns; p++) pictures += view->images[p].data != NULL;
        fputs("  ", out);
        put_text(out, view->id);
        fprintf(out, ": camera %d x %d, f %.1f; projector %d x %d, f %.1f; %d pictures\n", view->camera.width,
                view->camera.height, (double)view->camera.fx, view->projector.width, view->projector.height,
                (double)view->projector.fx, pictures);
    }
}

static bool tell_capture(FILE *out, const char *path, FfpError *err) {
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
    const int active = ffp_capture_active_pattern(&capture, NULL, NULL);
    fputs("\nreconstructs from ", out);
    put_text(out, active < 0 ? "nothing: no pattern but black and white is in every view"
                             : capture.patterns[active].name);
    fprintf(out, "\nbounds       centre %.4g %.4g %.4g, radius %.4g\n", (double)capture.centre[0],
            (double)capture.centre[1], (double)capture.centre[2], (double)capture.radius);
    fprintf(out, "intensity    %.4g %.4g %.4g (%s)\n", (double)capture.intensity[0],
            (double)capture.intensity[1], (double)capture.intensity[2],
            capture.intensity_known ? "given" : "unknown: estimated or assumed");
    tell_truth(out, &capture);
    tell_views(out, &capture);
    ffp_rig_checks(&capture, out);
    ffp_capture_free(&capture);
    return true;
}

static bool tell_model(FILE *out, const char *path, FfpError *err) {
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

static void tell_histogram(FILE *out, const FfpGaussians *gaussians) {
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

static bool tell_gaussians(FILE *out, const char *path, FfpError *err) {
    FfpGaussians gaussians;
    if (!ffp_gaussians_read(&gaussians, path, err)) return false;
    real low[3] = {INFINITY, INFINITY, INFINITY}, high[3] = {-INFINITY, -INFINITY, -INFINITY};
    for (int64_t i = 0; i < 3 * gaussians.count; i++) {
        low[i % 3] = fmin(low[i % 3], gaussians.centre[i]);
        high[i % 3] = fmax(high[i % 3], gaussians.centre[i]);
    }
    fprintf(out, "Gaussians    %" PRId64 "\n", gaussians.count);
    if (gaussians.count) {
        fprintf(out, "centres      %.4g %.4g %.4g to %.4g %.4g %.4g\n", (double)low[0], (double)low[1],
                (double)low[2], (double)high[0], (double)high[1], (double)high[2]);
        tell_histogram(out, &gaussians);
    }
    ffp_gaussians_free(&gaussians);
    return true;
}

// A capture is a folder or JSON text; a PLY and a safetensors file say what they are in their first bytes.
static bool tell(FILE *out, const char *path, FfpError *err) {
    if (ffp_is_folder(path)) return tell_capture(out, path, err);
    FILE *stream = fopen(path, "rb");
    if (!stream) return ffp_fail(err, path, "cannot open it");
    unsigned char head[9] = {0};
    const size_t size = fread(head, 1, sizeof head, stream);
    fclose(stream);
    if (size >= 4 && memcmp(head, "ply", 3) == 0) return tell_gaussians(out, path, err);
    if (size == sizeof head && !head[7] && head[8] == '{') return tell_model(out, path, err);
    size_t first = 0;
    while (first < size && strchr(" \t\r\n", head[first])) first++;
    if (first < size && head[first] == '{') return tell_capture(out, path, err);
    return ffp_fail(err, path, "is neither a capture, nor a model, nor Gaussians");
}

char *ffp_info(const char *path, FfpError *err) {
    char *text = NULL;
    size_t size = 0;
    FILE *out = open_memstream(&text, &size);
    if (!out) {
        ffp_fail(err, path, "out of memory");
        return NULL;
    }
    const bool ok = tell(out, path, err);
    fclose(out);
    if (ok) return text;
    free(text);
    return NULL;
}
