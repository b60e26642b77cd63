#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <jansson.h>
#include "base/file.h"
#include "eval/scores.h"

static void set_figure(json_t *row, const char *key, double value) {
    json_object_set_new(row, key, isfinite(value) ? json_real(value) : json_null());
}

static json_t *row_json(const FfpScore *score) {
    json_t *row = json_object();
    if (*score->capture) json_object_set_new(row, "capture", json_string(score->capture));
    json_object_set_new(row, "protocol", json_string(score->protocol));
    set_figure(row, "psnr", score->psnr);
    set_figure(row, "psnr_foreground", score->psnr_foreground);
    set_figure(row, "psnr_unseen_lollipops", score->psnr_unseen_lollipops);
    set_figure(row, "ssim", score->ssim);
    set_figure(row, "lpips", score->lpips);
    json_object_set_new(row, "images", json_integer(score->images));
    set_figure(row, "reconstruct_s", score->reconstruct_s);
    set_figure(row, "render_s", score->render_s);
    return row;
}

// The mean over captures of a protocol's rows. Figures missing from one row are missing from the mean.
static json_t *mean_json(const FfpScore *scores, int n_scores, const char *protocol) {
    FfpScore mean = {.protocol = protocol};
    int rows = 0;
    for (int i = 0; i < n_scores; i++) {
        const FfpScore *score = &scores[i];
        if (strcmp(score->protocol, protocol) != 0) continue;
        rows++;
        mean.images += score->images;
        mean.psnr += score->psnr, mean.psnr_foreground += score->psnr_foreground;
        mean.psnr_unseen_lollipops += score->psnr_unseen_lollipops;
        mean.ssim += score->ssim, mean.lpips += score->lpips;
        mean.reconstruct_s += score->reconstruct_s, mean.render_s += score->render_s;
    }
    if (!rows) return NULL;
    mean.psnr /= rows, mean.psnr_foreground /= rows, mean.psnr_unseen_lollipops /= rows;
    mean.ssim /= rows, mean.lpips /= rows, mean.reconstruct_s /= rows, mean.render_s /= rows;
    return row_json(&mean);
}

bool ffp_scores_write(const FfpScore *scores, int n_scores, const FfpEvaluation *options, FfpError *err) {
    static const char *const protocols[] = {"rendering", "novel_pattern", "novel_pose"};
    json_t *root = json_object(), *rows = json_array(), *means = json_array();
    for (int i = 0; i < n_scores; i++) json_array_append_new(rows, row_json(&scores[i]));
    for (int i = 0; i < 3; i++) {
        json_t *mean = mean_json(scores, n_scores, protocols[i]);
        if (mean) json_array_append_new(means, mean);
    }
    json_object_set_new(root, "version", json_string(ffp_version()));
    json_object_set_new(root, "predictor",
                        json_string(options->model_name ? options->model_name : "unnamed"));
    json_object_set_new(root, "rows", rows);
    json_object_set_new(root, "means", means);
    char *text = json_dumps(root, JSON_INDENT(1) | JSON_REAL_PRECISION(8));
    json_decref(root);
    if (!text) return ffp_fail(err, options->json, "names in it are not UTF-8");
    const bool ok = ffp_write_file(options->json, text, strlen(text), err);
    free(text);
    return ok;
}
