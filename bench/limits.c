// What limits a reconstruction: the generator's truth is put in for one part of it at a time, and the
// pictures are scored again, before and after a polish of what is then there. Prints a table in Markdown.
//   limits [MODEL.safetensors|none] [SCENES] [FIRST]
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include "core/base/arena.h"
#include "core/base/vec.h"
#include "engine/loss/metrics.h"
#include "engine/render/pass.h"
#include "ffprocams.h"
#include "lab/train/train.h"

// Parts that may be true.
enum {
    DEPTH = 1,
    NORMAL = 2,
    ALBEDO = 4,
    ROUGHNESS = 8,
    SILHOUETTE = 16,
    NO_SHADOWS = 32,
    OPAQUE = 64,
    MAPS = 128
};

static const struct {
    const char *name;
    unsigned parts;
} rows[] = {
    {"as predicted", 0},
    {"true depth", DEPTH},
    {"true normal", NORMAL},
    {"true albedo", ALBEDO},
    {"true roughness", ROUGHNESS},
    {"true silhouette", SILHOUETTE},
    {"all splats opaque", OPAQUE},
    {"no shadows at all", NO_SHADOWS},
    {"true depth and normal", DEPTH | NORMAL},
    {"true depth, normal, albedo, roughness", DEPTH | NORMAL | ALBEDO | ROUGHNESS},
    {"all of these, true silhouette", DEPTH | NORMAL | ALBEDO | ROUGHNESS | SILHOUETTE},
    {"true maps instead of splats", DEPTH | NORMAL | ALBEDO | ROUGHNESS | MAPS},
};
enum { ROWS = sizeof rows / sizeof *rows };

typedef struct Score {
    double sum[2]; // rendering, novel pose
    int count[2];
} Score;
enum { ALONE, POLISHED, STAGES };

typedef struct Viewer {
    FfpViewPass *pass[2]; // without shadows, with
    FfpImage picture;
} Viewer;

// Puts the truth of the splat's own pixel in for some parts.
static void put_truth(FfpGaussians *g, const FfpRun *run, const FfpScene *scene, unsigned parts) {
    const int pixels = scene->start.width * scene->start.height;
    for (int64_t i = 0; i < g->count; i++) {
        const FfpView *view = &scene->capture.views[run->pixel[i] / pixels];
        const int p = (int)(run->pixel[i] % pixels);
        const real t = ffp_true_t(view, p);
        if (!(t > 0)) continue;
        for (int k = 0; k < 3; k++) {
            const real eye = view->camera.pose[4 * k + 3];
            if (parts & DEPTH) g->centre[3 * i + k] = eye + (g->centre[3 * i + k] - eye) * t / run->t[i];
            if (parts & ALBEDO) g->albedo[3 * i + k] = view->albedo.data[3 * p + k];
        }
        if (parts & NORMAL) ffp_normal_frame(view->normal.data + 3 * p, g->rotation + 4 * i);
        if (parts & ROUGHNESS) g->roughness[i] = view->roughness.data[p];
        if (parts & OPAQUE) g->opacity[i] = 1;
    }
}

// Pixel of the view that a sample belongs to.
static int pixel_of(const FfpGbuffer *samples, int sample, const FfpImage *view) {
    const int side = samples->width / view->width;
    return sample / samples->width / side * view->width + sample % samples->width / side;
}

// The samples' sums scaled so that each pixel's opacity is its true coverage.
static void put_silhouette(FfpGbuffer *g, const FfpGbuffer *means, const FfpImage *coverage) {
    for (int i = 0; i < g->width * g->height; i++) {
        const int p = pixel_of(g, i, coverage);
        if (means->opacity[p] <= 1e-3F) continue;
        const real scale = coverage->data[p] / means->opacity[p];
        g->opacity[i] *= scale;
        g->depth[i] *= scale;
        g->roughness[i] *= scale;
        for (int k = 0; k < 3; k++) {
            g->normal[3 * i + k] *= scale;
            g->albedo[3 * i + k] *= scale;
            g->ambient[3 * i + k] *= scale;
        }
    }
}

// The generator's maps in place of what was rasterised: what shading, ambient and shadows alone cost.
static void put_maps(FfpGbuffer *g, const FfpView *view, const FfpImage *black) {
    for (int i = 0; i < g->width * g->height; i++) {
        const int p = pixel_of(g, i, black);
        const real c = view->depth.data[p] > 0 ? view->coverage.data[p] : 0;
        g->opacity[i] = c;
        g->depth[i] = c * view->depth.data[p];
        g->roughness[i] = c * view->roughness.data[p];
        for (int k = 0; k < 3; k++) {
            g->normal[3 * i + k] = c * view->normal.data[3 * p + k];
            g->albedo[3 * i + k] = c * view->albedo.data[3 * p + k];
            if (c > 0)
                g->ambient[3 * i + k] = c * ffp_srgb_decode(ffp_srgb_encode(black->data[3 * p + k]) / c);
        }
    }
}

static void score_view(Viewer *v, const FfpScene *scene, int index, const FfpGaussians *g, unsigned parts,
                       Score *score) {
    const FfpCapture *capture = &scene->capture;
    const FfpView *view = &capture->views[index];
    const int target = index >= scene->inputs.n_views;
    FfpViewPass *pass = v->pass[!(parts & NO_SHADOWS)];
    ffp_view_pass_draw(pass, g, &view->camera, &view->projector);
    if (parts & MAPS) put_maps(ffp_view_pass_samples(pass), view, &view->images[capture->black]);
    if (parts & SILHOUETTE)
        put_silhouette(ffp_view_pass_samples(pass), ffp_view_pass_gbuffer(pass), &view->coverage);
    if (parts & (MAPS | SILHOUETTE)) ffp_view_pass_samples_changed(pass);
    for (int p = 0; p < capture->n_patterns; p++) {
        if (!target && (p == capture->black || p == capture->white || p == scene->active)) continue;
        ffp_view_pass_shade(pass, capture->intensity, p == capture->black ? NULL : &scene->patterns[p],
                            &v->picture);
        FfpImage truth = ffp_image_copy(&view->images[p]);
        ffp_image_to_srgb(&truth);
        score->sum[target] += ffp_psnr(&v->picture, &truth);
        score->count[target]++;
        ffp_image_free(&truth);
    }
}

static bool score_scene(Viewer *viewer, const FfpScene *scene, const FfpTrainConfig *config,
                        const FfpRun *run, Score scores[ROWS][STAGES], FfpError *err) {
    const FfpRenderSettings settings = ffp_render_defaults();
    bool ok = true;
    for (int row = 0; row < ROWS && ok; row++) {
        FfpGaussians g = ffp_gaussians_copy(&run->gaussians);
        put_truth(&g, run, scene, rows[row].parts);
        for (int stage = 0; stage < STAGES && ok; stage++) {
            if (stage == POLISHED) ok = ffp_scene_polish(&g, config, &settings, scene, 1, err);
            for (int v = 0; v < scene->capture.n_views && ok; v++)
                score_view(viewer, scene, v, &g, rows[row].parts, &scores[row][stage]);
        }
        ffp_gaussians_free(&g);
    }
    return ok;
}

static bool run_scenes(const FfpModel *model, int count, int first, Score scores[ROWS][STAGES],
                       FfpError *err) {
    FfpTrainConfig config = ffp_train_defaults();
    const int side = config.resolution;
    config.polish_steps = FFP_POLISH_STEPS;
    FfpRenderSettings settings = ffp_render_defaults();
    Viewer viewer = {.picture = ffp_image_new(side, side, 3)};
    for (int shadows = 0; shadows < 2; shadows++) {
        settings.shadows = shadows;
        viewer.pass[shadows] = ffp_view_pass_new(&settings);
    }
    FfpRun *run = ffp_run_new(false);
    bool ok = true;
    for (int i = first; i < first + count && ok; i++) {
        FfpScene scene;
        if (!(ok = ffp_scene_open(&scene, &config, NULL, "validation", i, err))) break;
        ok = ffp_model_forward(model, run, &scene.inputs, &scene.start, &scene.context, scene.active, err);
        if (ok) ok = score_scene(&viewer, &scene, &config, run, scores, err);
        ffp_scene_close(&scene);
    }
    ffp_run_free(run);
    ffp_image_free(&viewer.picture);
    for (int shadows = 0; shadows < 2; shadows++) ffp_view_pass_free(viewer.pass[shadows]);
    return ok;
}

// Weights, or an untrained residual network, which gives the classical initialisation.
static FfpModel *open_model(const char *path, FfpError *err) {
    FfpModelConfig config;
    if (strcmp(path, "none") != 0) return ffp_model_read(path, err);
    ffp_model_preset(&config, "tiny");
    return ffp_model_new(&config, 1, err);
}

int main(int argc, char **argv) {
    const int count = argc > 2 ? atoi(argv[2]) : 4, first = argc > 3 ? atoi(argv[3]) : 0;
    Score scores[ROWS][STAGES] = {0};
    FfpError err = {0};
    FfpModel *model = open_model(argc > 1 ? argv[1] : "none", &err);
    const bool ok = model && run_scenes(model, count, first, scores, &err);
    ffp_model_free(model);
    if (!ok) {
        fprintf(stderr, "limits: error: %s\n", err.text);
        return 1;
    }
    printf("| %d validation scenes | rendering | novel pose | polished: rendering | novel pose |\n"
           "|---|---|---|---|---|\n",
           count);
    for (int row = 0; row < ROWS; row++) {
        printf("| %s |", rows[row].name);
        for (int stage = 0; stage < STAGES; stage++)
            for (int target = 0; target < 2; target++)
                printf(" %.2f |", scores[row][stage].sum[target] / scores[row][stage].count[target]);
        putchar('\n');
    }
    return 0;
}
