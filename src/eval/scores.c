#include <math.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>
#include <jansson.h>
#include "base/file.h"
#include "eval/scores.h"

const char *const ffp_protocols[FFP_PROTOCOLS] = {"rendering", "novel_pattern", "novel_pose"};

static const struct {
    const char *name;
    size_t offset; // of a double in FfpScore
    bool of_some;  // captures: the others do not count in a mean
} figures[] = {
#define FIGURE(name, of_some)                                                                                \
    { #name, offsetof(FfpScore, name), of_some }
    FIGURE(psnr, false),
    FIGURE(psnr_foreground, false),
    FIGURE(psnr_gloss, true),
    FIGURE(psnr_unseen_lollipops, false),
    FIGURE(ssim, false),
    FIGURE(lpips, false),
    FIGURE(reconstruct_s, false),
    FIGURE(render_s, false),
    FIGURE(depth_lit_median, false),
    FIGURE(depth_lit_p90, false),
    FIGURE(depth_unlit_median, false),
    FIGURE(depth_unlit_p90, false),
    FIGURE(albedo_mse, false),
    FIGURE(albedo_lit_mse, false),
    FIGURE(albedo_unlit_mse, false),
#undef FIGURE
};
enum { FIGURES = sizeof figures / sizeof *figures };

static double *figure_of(FfpScore *score, int i) {
    return (double *)((char *)score + figures[i].offset);
}

static json_t *row_json(FfpScore score) {
    json_t *row = json_object();
    if (*score.capture) json_object_set_new(row, "capture", json_string(score.capture));
    json_object_set_new(row, "protocol", json_string(score.protocol));
    json_object_set_new(row, "images", json_integer(score.images));
    for (int i = 0; i < FIGURES; i++) {
        const double value = *figure_of(&score, i);
        json_object_set_new(row, figures[i].name, isfinite(value) ? json_real(value) : json_null());
    }
    return row;
}

int ffp_scores_mean(FfpScore *mean, const FfpScore *scores, int n_scores, const char *protocol) {
    int rows = 0, having[FIGURES] = {0};
    *mean = (FfpScore){.protocol = protocol};
    for (int s = 0; s < n_scores; s++) {
        FfpScore score = scores[s];
        if (strcmp(score.protocol, protocol) != 0) continue;
        rows++;
        mean->images += score.images;
        for (int i = 0; i < FIGURES; i++) {
            const double value = *figure_of(&score, i);
            if (figures[i].of_some && !isfinite(value)) continue;
            *figure_of(mean, i) += value;
            having[i]++;
        }
    }
    for (int i = 0; i < FIGURES; i++) *figure_of(mean, i) /= having[i]; // 0 / 0: no figure
    return rows;
}

bool ffp_scores_write(const FfpScore *scores, int n_scores, const FfpEvaluation *options, FfpError *err) {
    json_t *root = json_object(), *rows = json_array(), *means = json_array();
    for (int i = 0; i < n_scores; i++) json_array_append_new(rows, row_json(scores[i]));
    for (int i = 0; i < FFP_PROTOCOLS; i++) {
        FfpScore mean;
        if (ffp_scores_mean(&mean, scores, n_scores, ffp_protocols[i]))
            json_array_append_new(means, row_json(mean));
    }
    json_object_set_new(root, "version", json_string(ffp_version()));
    json_object_set_new(root, "predictor",
                        json_string(options->model_name ? options->model_name : "unnamed"));
    json_object_set_new(root, "rows", rows);
    json_object_set_new(root, "means", means);
    char *text = json_dumps(root, JSON_INDENT(1) | JSON_REAL_PRECISION(8));
    json_decref(root);
    if (!text) return ffp_fail(err, FFP_ERROR_ARGUMENT, options->json, "names in it are not UTF-8");
    const bool ok = ffp_write_file(options->json, text, strlen(text), err);
    free(text);
    return ok;
}
