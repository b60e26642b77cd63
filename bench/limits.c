// The limits of a reconstruction, before and after the fit: the generator's truth is put in for one part of
// it at a time, into the splats or into the maps drawn from them, and the pictures are scored again; and what
// a network would have to predict to do without the fit: one attribute at a time as the fit leaves it. Prints
// a table in Markdown: dB of the first row, gains of the others.
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

// Parts that may be true: of the splats or, with MAPS, of what is drawn. From FITTED on: attributes as the
// fit leaves them.
enum {
    DEPTH = 1,
    NORMAL = 2,
    ALBEDO = 4,
    ROUGHNESS = 8,
    AMBIENT = 16, // of the maps alone
    SILHOUETTE = 32,
    NO_SHADOWS = 64,
    OPAQUE = 128,
    MAPS = 256,
    FITTED = 512
};
#define FIT(attribute) ((unsigned)FITTED << FFP_##attribute)
#define SHAPE (FIT(CENTRE) | FIT(SCALE) | FIT(ROTATION) | FIT(OPACITY))
#define LOOKS (FIT(ALBEDO) | FIT(ROUGHNESS) | FIT(AMBIENT))
#define ALL_MAPS (DEPTH | NORMAL | ALBEDO | ROUGHNESS | AMBIENT | MAPS)

static const struct {
    const char *name;
    unsigned parts;
} rows[] = {
    {"as predicted", 0},
    {"true depth", DEPTH},
    {"true normal", NORMAL},
    {"true albedo", ALBEDO},
    {"true roughness", ROUGHNESS},
    {"true depth, normal, albedo, roughness", DEPTH | NORMAL | ALBEDO | ROUGHNESS},
    {"all splats opaque", OPAQUE},
    {"no shadows at all", NO_SHADOWS},
    {"drawn: true depth", DEPTH | MAPS},
    {"drawn: true normal", NORMAL | MAPS},
    {"drawn: true albedo", ALBEDO | MAPS},
    {"drawn: true roughness", ROUGHNESS | MAPS},
    {"drawn: true ambient colour", AMBIENT | MAPS},
    {"drawn: true silhouette", SILHOUETTE},
    {"drawn: all but the silhouette", ALL_MAPS},
    {"drawn: all", ALL_MAPS | SILHOUETTE},
    {"fitted centres", FIT(CENTRE)},
    {"fitted scales and rotations", FIT(SCALE) | FIT(ROTATION)},
    {"fitted opacities", FIT(OPACITY)},
    {"fitted centres, scales, rotations, opacities", SHAPE},
    {"fitted albedo", FIT(ALBEDO)},
    {"fitted roughness", FIT(ROUGHNESS)},
    {"fitted ambient colour", FIT(AMBIENT)},
    {"fitted albedo, roughness, ambient colour", LOOKS},
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

// The generator's maps in place of some of those drawn, where a pixel's centre shows a surface.
static void put_maps(FfpGbuffer *g, const FfpView *view, const FfpImage *black, unsigned parts) {
    for (int i = 0; i < g->width * g->height; i++) {
        const int p = pixel_of(g, i, black);
        const real coverage = view->coverage.data[p];
        if (!(view->depth.data[p] > 0 && coverage > 0)) continue;
        if (parts & SILHOUETTE) g->opacity[i] = coverage;
        const real o = g->opacity[i];
        if (parts & DEPTH) g->depth[i] = o * view->depth.data[p];
        if (parts & ROUGHNESS) g->roughness[i] = o * view->roughness.data[p];
        for (int k = 0; k < 3; k++) {
            const int at = 3 * i + k, from = 3 * p + k;
            if (parts & NORMAL) g->normal[at] = o * view->normal.data[from];
            if (parts & ALBEDO) g->albedo[at] = o * view->albedo.data[from];
            if (parts & AMBIENT)
                g->ambient[at] = o * ffp_srgb_decode(ffp_srgb_encode(black->data[from]) / coverage);
        }
    }
}

// Input poses under lollipops that were not given, new poses under all patterns but black, which true maps
// would show exactly.
static void score_view(Viewer *v, const FfpScene *scene, int index, const FfpGaussians *g, unsigned parts,
                       Score *score) {
    const FfpCapture *capture = &scene->capture;
    const FfpView *view = &capture->views[index];
    const int target = index >= scene->inputs.n_views;
    FfpViewPass *pass = v->pass[!(parts & NO_SHADOWS)];
    ffp_view_pass_draw(pass, g, &view->camera, &view->projector);
    if (parts & SILHOUETTE)
        put_silhouette(ffp_view_pass_samples(pass), ffp_view_pass_gbuffer(pass), &view->coverage);
    if (parts & MAPS) put_maps(ffp_view_pass_samples(pass), view, &view->images[capture->black], parts);
    if (parts & (MAPS | SILHOUETTE)) ffp_view_pass_samples_changed(pass);
    for (int p = 0; p < capture->n_patterns; p++) {
        if (p == capture->black || (!target && (p == capture->white || p == scene->active))) continue;
        ffp_view_pass_shade(pass, capture->intensity, &scene->patterns[p], &v->picture);
        FfpImage truth = ffp_image_copy(&view->images[p]);
        ffp_image_to_srgb(&truth);
        score->sum[target] += ffp_psnr(&v->picture, &truth);
        score->count[target]++;
        ffp_image_free(&truth);
    }
}

static bool polish(FfpGaussians *g, const FfpScene *scene, FfpError *err) {
    const FfpRenderSettings settings = ffp_render_defaults();
    FfpTrainConfig config = ffp_train_defaults();
    config.polish_steps = FFP_POLISH_STEPS;
    return ffp_scene_polish(g, &config, &settings, scene, 1, err);
}

// The splats of a row, alone and polished, from those of the first.
static bool make_splats(FfpGaussians of[STAGES], const FfpGaussians first[STAGES], const FfpRun *run,
                        const FfpScene *scene, unsigned parts, FfpError *err) {
    const bool moved = !(parts & MAPS) && parts & (DEPTH | NORMAL | ALBEDO | ROUGHNESS | OPAQUE);
    of[ALONE] = ffp_gaussians_copy(&first[ALONE]);
    if (moved) put_truth(&of[ALONE], run, scene, parts);
    of[POLISHED] = ffp_gaussians_copy(moved ? &of[ALONE] : &first[POLISHED]);
    for (int k = 0; k < FFP_ATTRIBUTES; k++) {
        const FfpAttribute to = ffp_attribute(&of[ALONE], k), from = ffp_attribute(&first[POLISHED], k);
        if (parts & (unsigned)FITTED << k)
            memcpy(to.data, from.data, (size_t)first->count * (size_t)to.width * sizeof *to.data);
    }
    return !moved || polish(&of[POLISHED], scene, err);
}

static bool score_scene(Viewer *viewer, const FfpScene *scene, const FfpRun *run, Score scores[ROWS][STAGES],
                        FfpError *err) {
    FfpGaussians first[STAGES] = {ffp_gaussians_copy(&run->gaussians), ffp_gaussians_copy(&run->gaussians)};
    bool ok = polish(&first[POLISHED], scene, err);
    for (int row = 0; row < ROWS && ok; row++) {
        const unsigned parts = rows[row].parts;
        FfpGaussians g[STAGES];
        ok = make_splats(g, first, run, scene, parts, err);
        for (int stage = 0; stage < (parts < FITTED ? STAGES : POLISHED) && ok; stage++)
            for (int v = 0; v < scene->capture.n_views; v++)
                score_view(viewer, scene, v, &g[stage], parts, &scores[row][stage]);
        for (int stage = 0; stage < STAGES; stage++) ffp_gaussians_free(&g[stage]);
    }
    for (int stage = 0; stage < STAGES; stage++) ffp_gaussians_free(&first[stage]);
    return ok;
}

static bool run_scenes(const FfpModel *model, int count, int first, Score scores[ROWS][STAGES],
                       FfpError *err) {
    const FfpTrainConfig config = ffp_train_defaults();
    const int side = config.resolution;
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
        if (ok) ok = score_scene(&viewer, &scene, run, scores, err);
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

static double mean_of(const Score *score, int target) {
    return score->sum[target] / score->count[target];
}

static void print_score(Score scores[ROWS][STAGES], int row, int stage, int target) {
    const Score *score = &scores[row][stage];
    if (score->count[target] == 0)
        printf(" |");
    else if (row == 0)
        printf(" %.2f |", mean_of(score, target));
    else
        printf(" %+.2f |", mean_of(score, target) - mean_of(&scores[0][stage], target));
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
    printf("| %d validation scenes | alone: rendering | novel pose | polished: rendering | novel pose |\n"
           "|---|---|---|---|---|\n",
           count);
    for (int row = 0; row < ROWS; row++) {
        printf("| %s |", rows[row].name);
        for (int stage = 0; stage < STAGES; stage++)
            for (int target = 0; target < 2; target++) print_score(scores, row, stage, target);
        putchar('\n');
    }
    return 0;
}
