#include "product/describe/describe.h"
#include <inttypes.h>
#include <string.h>
#include <tgmath.h>
#include "core/base/arena.h"
#include "core/base/file.h"
#include "core/base/kind.h"
#include "core/base/text.h"
#include "core/gaussians/elsewhere.h"
#include "core/numerics/rank.h"
#include "engine/network/network.h"
#include "lab/baselines/field.h"

#define HISTOGRAM_BINS 10
#define HISTOGRAM_WIDTH 50 // characters of the longest bar

static bool print_model(FILE *out, const char *path, FfpError *err) {
    FfpModel *model = ffp_model_read(path, err);
    if (!model) return false;
    const FfpModelConfig *config = &model->config;
    fprintf(out, "model        %s\nmodules      %s (%zu blocks, M = Mamba2, T = Transformer)\n", config->name,
            config->modules, strlen(config->modules));
    fprintf(out, "width        %d, patch %d, state %d, chunk %d, up to %d tokens\n", config->dim,
            config->patch, config->state, config->chunk, config->tokens);
    fprintf(out, "heads        %s%s%s%s, drawn as %s with %d x %d samples per pixel\n",
            config->residual ? "residuals around the classical initialisation" : "plain",
            config->match_input ? ", matched depth among the inputs" : "",
            config->pixel_skip ? config->context_inputs ? ", pixel skip with context" : ", pixel skip" : "",
            config->appearance_cnn ? ", convolutional appearance" : "", config->render, config->samples,
            config->samples);
    if (config->looks)
        fprintf(out, "looks        %d, %d hidden units: input views are drawn and splats corrected\n",
                config->looks, config->look_hidden);
    fprintf(out, "parameters   %" PRId64 " in %d tensors\n", model->count, model->n_parameters);
    for (int i = 0; i < model->metadata_count; i++) {
        ffp_put_plain(out, model->metadata[2 * i]);
        fputs(": ", out);
        ffp_put_plain(out, model->metadata[2 * i + 1]);
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

// Each by its largest scale.
static void print_sizes(FILE *out, const FfpGaussians *gaussians) {
    real *sizes = ffp_take((size_t)gaussians->count, sizeof *sizes), least = INFINITY, most = 0;
    for (int64_t i = 0; i < gaussians->count; i++) {
        const real *scale = gaussians->scale + 3 * i;
        sizes[i] = fmax(fmax(scale[0], scale[1]), scale[2]);
        least = fmin(least, sizes[i]);
        most = fmax(most, sizes[i]);
    }
    fprintf(out, "sizes        %.4g to %.4g, median %.4g\n", (double)least, (double)most,
            (double)ffp_median(sizes, (size_t)gaussians->count));
    ffp_free(sizes);
}

static bool print_gaussians(FILE *out, const char *path, FfpError *err) {
    FfpGaussians gaussians;
    if (!ffp_gaussians_read(&gaussians, path, err)) return false;
    real low[3] = {INFINITY, INFINITY, INFINITY}, high[3] = {-INFINITY, -INFINITY, -INFINITY};
    for (int64_t i = 0; i < 3 * gaussians.count; i++) {
        low[i % 3] = fmin(low[i % 3], gaussians.centre[i]);
        high[i % 3] = fmax(high[i % 3], gaussians.centre[i]);
    }
    fprintf(out, "Gaussians    %" PRId64 "%s\n", gaussians.count, gaussians.count ? "" : ": nothing to draw");
    for (const char *at = gaussians.made_from; *at; at = strchr(at, '\n') + 1) {
        char name[FFP_MADE_FROM];
        snprintf(name, sizeof name, "%.*s", (int)strcspn(at, "\n"), at);
        fputs(at == gaussians.made_from ? "made from    " : ", ", out);
        ffp_put_plain(out, name);
    }
    if (gaussians.made_from[0]) fputc('\n', out);
    if (gaussians.count) {
        fprintf(out, "centres      %.4g %.4g %.4g to %.4g %.4g %.4g\n", (double)low[0], (double)low[1],
                (double)low[2], (double)high[0], (double)high[1], (double)high[2]);
        print_sizes(out, &gaussians);
        print_histogram(out, &gaussians);
    }
    ffp_gaussians_free(&gaussians);
    return true;
}

static bool print_field(FILE *out, const char *path, FfpError *err) {
    FfpNeuralField field;
    if (!ffp_neural_field_read(&field, path, err)) return false;
    fprintf(out, "neural field %" PRId64 " numbers, %" PRId64 " of them in a hash grid of %d levels\n",
            field.layout.count, field.layout.grid, FFP_FIELD_LEVELS);
    fprintf(out, "sphere       centre %.4g %.4g %.4g, radius %.4g\n", (double)field.centre[0],
            (double)field.centre[1], (double)field.centre[2], (double)field.radius);
    fprintf(out, "density      in %.1f %% of %d x %d x %d cells around it; rays step by %.4g of the radius\n",
            100 * ffp_field_filled(&field), FFP_FIELD_CELLS, FFP_FIELD_CELLS, FFP_FIELD_CELLS,
            (double)field.step);
    fputs("read by      info, evaluate\n", out);
    ffp_neural_field_free(&field);
    return true;
}

bool ffp_describe(FILE *out, const char *path, FfpFindings *found, FfpError *err) {
    switch (ffp_file_kind(path)) {
    case FFP_KIND_FOLDER:
    case FFP_KIND_JSON:
        return ffp_describe_capture(out, path, found, err);
    case FFP_KIND_PLY:
    case FFP_KIND_SPZ:
    case FFP_KIND_GLTF:
    case FFP_KIND_SPLAT:
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
    return ffp_refuse_splats(path, err);
}
