#include "lab/eval/scores.h"
#include <jansson.h>
#include <math.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include "core/base/alloc.h"
#include "core/base/file.h"
#include "core/capture/node.h"

const char *const ffp_protocols[FFP_PROTOCOLS] = {"novel_pattern", "novel_pose", FFP_UNSEEN, "rendering",
                                                  FFP_GIVEN};

static const struct {
    const char *name;
    size_t offset; // of a double in FfpScore
    enum {
        OF_ALL,  // captures: one without it leaves their mean without it
        OF_SOME, // those without it do not count in a mean
        TOTAL    // of the row's pictures, as their number is: added up
    } over;
} figures[] = {
#define FIGURE(name, over)                                                                                   \
    { #name, offsetof(FfpScore, name), over }
    FIGURE(psnr, OF_ALL),
    FIGURE(psnr_foreground, OF_ALL),
    FIGURE(psnr_gloss, OF_SOME),
    FIGURE(psnr_unseen_lollipops, OF_ALL),
    FIGURE(ssim, OF_ALL),
    FIGURE(lpips, OF_ALL),
    FIGURE(reconstruct_s, OF_ALL),
    FIGURE(render_s, TOTAL),
    FIGURE(depth_lit_median, OF_ALL),
    FIGURE(depth_lit_p90, OF_ALL),
    FIGURE(depth_unlit_median, OF_ALL),
    FIGURE(depth_unlit_p90, OF_ALL),
    FIGURE(albedo_mse, OF_ALL),
    FIGURE(albedo_lit_mse, OF_ALL),
    FIGURE(albedo_unlit_mse, OF_ALL),
#undef FIGURE
};
enum { FIGURES = sizeof figures / sizeof *figures };

static double *figure_of(FfpScore *score, int i) {
    return (double *)((char *)score + figures[i].offset);
}

// False where the text is not UTF-8: jansson has no value for it then, and leaves the field out.
static bool put_text(json_t *object, const char *key, const char *text, const char *path, FfpError *err) {
    return json_object_set_new(object, key, json_string(text)) == 0 ||
           ffp_fail(err, FFP_ERROR_ARGUMENT, ffp_place(path, key).text, "'%.100s' is not UTF-8", text);
}

static bool add_row(json_t *rows, FfpScore score, const char *path, FfpError *err) {
    json_t *row = json_object();
    json_array_append_new(rows, row);
    if (*score.capture && !put_text(row, "capture", score.capture, path, err)) return false;
    if (!put_text(row, "protocol", score.protocol, path, err)) return false;
    json_object_set_new(row, "images", json_integer(score.images));
    for (int i = 0; i < FIGURES; i++) {
        const double value = *figure_of(&score, i);
        json_object_set_new(row, figures[i].name, isfinite(value) ? json_real(value) : json_null());
    }
    return true;
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
            if (figures[i].over == OF_SOME && !isfinite(value)) continue;
            *figure_of(mean, i) += value;
            having[i]++;
        }
    }
    for (int i = 0; i < FIGURES; i++)
        if (figures[i].over != TOTAL) *figure_of(mean, i) /= having[i]; // 0 / 0: no figure
    return rows;
}

static bool add_all(json_t *root, const FfpScore *scores, int n_scores, const FfpEvaluation *options,
                    FfpError *err) {
    const char *path = options->json, *name = options->model_name ? options->model_name : "unnamed";
    json_t *rows = json_array(), *means = json_array();
    bool ok =
        put_text(root, "version", FFP_VERSION, path, err) && put_text(root, "predictor", name, path, err);
    json_object_set_new(root, "rows", rows);
    json_object_set_new(root, "means", means);
    for (int i = 0; ok && i < n_scores; i++) ok = add_row(rows, scores[i], path, err);
    for (int i = 0; ok && i < FFP_PROTOCOLS; i++) {
        FfpScore mean;
        if (ffp_scores_mean(&mean, scores, n_scores, ffp_protocols[i])) ok = add_row(means, mean, path, err);
    }
    return ok;
}

bool ffp_scores_write(const FfpScore *scores, int n_scores, const FfpEvaluation *options, FfpError *err) {
    json_t *root = json_object();
    const bool made = add_all(root, scores, n_scores, options, err);
    char *text = made ? json_dumps(root, JSON_INDENT(1) | JSON_REAL_PRECISION(8)) : NULL;
    json_decref(root);
    if (!made) return false;
    if (!text) return ffp_fail(err, FFP_ERROR_MEMORY, options->json, "out of memory");
    const bool ok = ffp_write_file(options->json, text, strlen(text), err);
    free(text);
    return ok;
}

// --- Reading them back. ---

static bool read_protocol(const FfpNode *row, FfpScore *score, FfpError *err) {
    FfpNode field;
    const char *text = NULL;
    if (!ffp_node_get(row, "protocol", &field, err) || !ffp_node_text(&field, &text, err)) return false;
    for (int i = 0; i < FFP_PROTOCOLS; i++)
        if (strcmp(text, ffp_protocols[i]) == 0) score->protocol = ffp_protocols[i];
    return score->protocol || ffp_node_fail(&field, err, "unknown protocol '%.40s'", text);
}

static bool read_row(const FfpNode *row, FfpScore *score, FfpError *err) {
    FfpNode field;
    *score = (FfpScore){0};
    if (!ffp_node_get(row, "capture", &field, err) || !ffp_node_name(&field, score->capture, err) ||
        !read_protocol(row, score, err) || !ffp_get_whole(row, "images", 1, 1 << 30, &score->images, err))
        return false;
    for (int i = 0; i < FIGURES; i++) {
        double *to = figure_of(score, i);
        *to = NAN;
        if (!ffp_node_find(row, figures[i].name, &field)) continue;
        if (!json_is_number(field.value)) return ffp_node_fail(&field, err, "expected a number");
        *to = json_number_value(field.value);
    }
    return true;
}

static bool is_known(const FfpScore *scores, int n_scores, const FfpScore *score) {
    for (int i = 0; i < n_scores; i++)
        if (strcmp(scores[i].capture, score->capture) == 0 && scores[i].protocol == score->protocol)
            return true;
    return false;
}

static bool read_rows(FfpScore **scores, int *n_scores, const FfpNode *rows, FfpError *err) {
    int count = 0;
    if (!ffp_node_count(rows, 0, 1 << 20, &count, err)) return false;
    *scores = ffp_grow(*scores, (size_t)*n_scores + (size_t)count + 1, sizeof **scores);
    for (int i = 0; i < count; i++) {
        FfpNode row;
        FfpScore *score = *scores + *n_scores;
        if (!ffp_node_item(rows, i, &row, err) || !read_row(&row, score, err)) return false;
        if (is_known(*scores, *n_scores, score))
            return ffp_node_fail(&row, err, "duplicate row: %s under %s", score->capture, score->protocol);
        (*n_scores)++;
    }
    return true;
}

bool ffp_scores_read(FfpScore **scores, int *n_scores, char **predictor, const char *path, FfpError *err) {
    FfpNode root, name, rows;
    const char *text = NULL;
    *predictor = NULL;
    if (!ffp_node_open(&root, path, err)) return false;
    const bool ok = ffp_node_get(&root, "predictor", &name, err) && ffp_node_text(&name, &text, err) &&
                    ffp_node_get(&root, "rows", &rows, err) && read_rows(scores, n_scores, &rows, err);
    if (ok) *predictor = ffp_copy_text(text);
    ffp_node_close(&root);
    return ok;
}
