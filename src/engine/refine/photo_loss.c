// A view under black, white and the patterns, against its photographs.
#include <omp.h>
#include <stdlib.h>
#include "core/base/arena.h"
#include "core/base/call.h"
#include "core/base/device.h"
#include "core/base/vec.h"
#include "engine/loss/loss.h"
#include "engine/loss/metrics.h"
#include "engine/refine/fit.h"
#include "engine/refine/table.h"
#include "engine/render/pass.h"

typedef struct Hand { // what one view is worked on with
    FfpViewPass *pass;
    FfpImage picture, grad; // remade when their size changes
} Hand;

struct FfpPhotoLoss {
    const FfpCapture *capture;
    const FfpRefineSettings *settings;
    int n_patterns;
    const int *patterns;
    FfpSummed *light;    // [n_patterns]
    FfpImage *targets;   // [n_views,n_patterns] encoded; .data NULL where the view has no photograph
    int *shown;          // [n_views] how many it has, the codes not among them
    int *coded;          // [n_views] how many of the codes
    FfpGbuffer *shadows; // [n_views] kept shadow maps
    int *looks;          // [n_views] at each view so far
    Hand hands[2];       // the second for a view at the same time, its buffers made by the first such look
};

FfpSummed ffp_pattern_summed(const FfpImage *pattern) {
    return ffp_device() ? ffp_device()->refine->summed_new(pattern) : ffp_summed_new(pattern);
}

FfpPhotoLoss *ffp_photo_loss_new(const FfpCapture *capture, const int *patterns, int n_patterns,
                                 const FfpRefineSettings *settings) {
    FfpPhotoLoss *v = ffp_alloc(1, sizeof *v);
    *v = (FfpPhotoLoss){.capture = capture,
                        .settings = settings,
                        .n_patterns = n_patterns,
                        .patterns = patterns,
                        .light = ffp_alloc((size_t)n_patterns, sizeof *v->light),
                        .targets = ffp_alloc((size_t)capture->n_views * n_patterns, sizeof *v->targets),
                        .shown = ffp_alloc((size_t)capture->n_views, sizeof *v->shown),
                        .coded = ffp_alloc((size_t)capture->n_views, sizeof *v->coded),
                        .shadows = ffp_alloc((size_t)capture->n_views, sizeof *v->shadows),
                        .looks = ffp_alloc((size_t)capture->n_views, sizeof *v->looks)};
    for (int h = 0; h < 2; h++) {
        v->hands[h].pass = ffp_view_pass_new(&settings->render);
        ffp_view_pass_expect_gradients(v->hands[h].pass);
    }
    for (int p = 0; p < n_patterns; p++)
        if (patterns[p] != capture->black)
            v->light[p] = ffp_pattern_summed(&capture->patterns[patterns[p]].image);
    for (int i = 0; i < capture->n_views * n_patterns; i++) {
        const FfpImage *photograph = &capture->views[i / n_patterns].images[patterns[i % n_patterns]];
        if (!photograph->data) continue;
        v->targets[i] = ffp_image_copy(photograph);
        ffp_image_to_srgb(&v->targets[i]);
        (i % n_patterns < n_patterns - settings->codes ? v->shown : v->coded)[i / n_patterns]++;
    }
    return v;
}

void ffp_photo_loss_free(FfpPhotoLoss *v) {
    if (!v) return;
    for (int p = 0; p < v->n_patterns; p++) ffp_summed_free(&v->light[p]);
    for (int i = 0; i < v->capture->n_views * v->n_patterns; i++) ffp_image_free(&v->targets[i]);
    for (int i = 0; i < v->capture->n_views; i++) ffp_gbuffer_free(&v->shadows[i]);
    ffp_free(v->shadows);
    ffp_free(v->looks);
    ffp_free(v->light);
    ffp_free(v->targets);
    ffp_free(v->shown);
    ffp_free(v->coded);
    for (int h = 0; h < 2; h++) {
        ffp_view_pass_free(v->hands[h].pass);
        ffp_image_free(&v->hands[h].picture);
        ffp_image_free(&v->hands[h].grad);
    }
    ffp_free(v);
}

static void fit_pictures(Hand *hand, int width, int height) {
    if (hand->picture.width == width && hand->picture.height == height) return;
    ffp_image_free(&hand->picture);
    ffp_image_free(&hand->grad);
    hand->picture = ffp_image_new(width, height, 3);
    hand->grad = ffp_image_new(width, height, 3);
}

// NULL: black.
static const FfpSummed *light_of(const FfpPhotoLoss *v, int p) {
    return v->patterns[p] == v->capture->black ? NULL : &v->light[p];
}

static const FfpView *draw(const FfpPhotoLoss *v, Hand *hand, const FfpGaussians *gaussians, int view_index) {
    const FfpView *view = &v->capture->views[view_index];
    fit_pictures(hand, view->camera.width, view->camera.height);
    ffp_view_pass_draw(hand->pass, gaussians, &view->camera, &view->projector);
    return view;
}

// Shades the view drawn last under pattern p; adds the picture's terms, and takes their gradient back.
// `counts`: its share of the PSNR.
static void compare(const FfpPhotoLoss *v, Hand *hand, int p, const FfpImage *target, real share, real counts,
                    FfpFitLoss *loss) {
    const FfpRefineSettings *s = v->settings;
    const real *intensity = v->capture->intensity;
    const FfpSummed *light = light_of(v, p);
    ffp_view_pass_shade(hand->pass, intensity, light, &hand->picture);
    ffp_memory_zero(hand->grad.data, sizeof(real) * (size_t)hand->grad.width * hand->grad.height * 3);
    ffp_loss_add(&loss->pictures, 1, ffp_l1_loss(&hand->picture, target, share * s->l1, &hand->grad));
    if (s->square > 0)
        ffp_loss_add(&loss->pictures, 1,
                     ffp_square_loss(&hand->picture, target, share * s->square, &hand->grad));
    ffp_loss_add(&loss->pictures, 1, ffp_ssim_loss(&hand->picture, target, share * s->ssim, &hand->grad));
    if (counts > 0) ffp_loss_add(&loss->psnr, (double)counts, ffp_psnr(&hand->picture, target));
    ffp_view_pass_shade_backward(hand->pass, intensity, light, &hand->grad, NULL, NULL);
}

// A view that is looked at again and again keeps its shadow map for some looks.
static void keep_shadow(FfpPhotoLoss *v, Hand *hand, int view) {
    if (v->settings->shadow_looks < 2) return;
    if (v->looks[view]++ % v->settings->shadow_looks == 0) ffp_gbuffer_free(&v->shadows[view]);
    ffp_view_pass_keep_shadow(hand->pass, &v->shadows[view]);
}

// The terms that look at G-buffers.
static void regularise(const FfpPhotoLoss *v, Hand *hand, const FfpView *view, int64_t step,
                       FfpFitLoss *loss) {
    const FfpRefineSettings *s = v->settings;
    const FfpGbuffer *g = ffp_view_pass_gbuffer(hand->pass);
    FfpGbuffer *d = ffp_view_pass_grad_gbuffer(hand->pass);
    const int pixels = g->width * g->height;
    const real *mask = view->coverage.data;
    double *total = &loss->maps;
    ffp_loss_add(total, 1, ffp_mask_loss(g->opacity, mask, pixels, s->mask, d->opacity));
    if (s->roughness_smooth > 0)
        ffp_loss_add(total, 1,
                     ffp_roughness_loss(g->roughness, g->albedo, g->opacity, mask, g->width, g->height,
                                        s->roughness_smooth, d->roughness, d->opacity));
    if (s->normal_smooth > 0)
        ffp_loss_add(
            total, 1,
            ffp_normal_smooth_loss(g->normal, mask, g->width, g->height, s->normal_smooth, d->normal));
    if (s->distortion > 0 && step >= s->distortion_from)
        ffp_loss_add(total, 1, ffp_distortion_loss(g->distortion, pixels, s->distortion, d->distortion));
}

// Of one view: the patterns' sum.
static void add_psnr(FfpPhotoLoss *v, const FfpGaussians *gaussians, int view, double *sum) {
    Hand *hand = &v->hands[0];
    draw(v, hand, gaussians, view);
    for (int p = 0; p < v->n_patterns; p++) {
        const FfpImage *target = &v->targets[view * v->n_patterns + p];
        if (!target->data) continue;
        ffp_view_pass_shade(hand->pass, v->capture->intensity, light_of(v, p), &hand->picture);
        ffp_loss_add(sum, 1, ffp_psnr(&hand->picture, target));
    }
}

double ffp_photo_loss_psnr(FfpPhotoLoss *v, const FfpGaussians *gaussians) {
    const int n = v->capture->n_views;
    double *of_view = ffp_alloc((size_t)n, sizeof *of_view), sum = 0;
    ffp_losses_defer();
    for (int i = 0; i < n; i++) add_psnr(v, gaussians, i, &of_view[i]);
    ffp_losses_collect();
    for (int i = 0; i < n; i++) sum += of_view[i] / (v->shown[i] + v->coded[i]);
    ffp_free(of_view);
    return sum / n;
}

#define HOLD_SCALE 0.1F // of a camera's pixel on the pattern, were both devices equally far from the surface

static void hold(const FfpPhotoLoss *v, Hand *hand, const FfpView *view, FfpFitLoss *loss) {
    const real scale = HOLD_SCALE * view->projector.fx / view->camera.fx;
    ffp_loss_add(&loss->maps, 1,
                 (double)ffp_view_pass_hold(hand->pass, &view->correspondence, scale, v->settings->hold));
}

// The pattern whose turn it is among the codes that the view has; -1: none.
static int code_in_turn(const FfpPhotoLoss *v, const FfpFitView *l) {
    if (v->coded[l->view] == 0) return -1;
    int left = (int)((l->step - 1) / v->capture->n_views % v->coded[l->view]);
    int p = v->n_patterns - v->settings->codes;
    while (!v->targets[l->view * v->n_patterns + p].data || left-- > 0) p++;
    return p;
}

// The weight of a picture's terms. A code takes its share from the other lit pictures: with less weight on
// black, ambient colour would begin to explain the light that bounces.
static real share_of(const FfpPhotoLoss *v, int p, int shown, int code) {
    const real each = 1 / (real)shown;
    if (v->settings->one_picture) return 1;
    return code < 0 || v->patterns[p] == v->capture->black ? each : (1 - each) * each;
}

static void look(FfpPhotoLoss *v, Hand *hand, const FfpGaussians *gaussians, const FfpFitView *l) {
    keep_shadow(v, hand, l->view);
    const FfpView *view = draw(v, hand, gaussians, l->view);
    ffp_view_pass_keep_shadow(hand->pass, NULL);
    const int shown = v->shown[l->view], turn = (int)(l->step % shown), code = code_in_turn(v, l);
    const bool one = v->settings->one_picture;
    for (int p = 0, nth = 0; p < v->n_patterns; p++) {
        const FfpImage *target = &v->targets[l->view * v->n_patterns + p];
        if (!target->data || (p >= v->n_patterns - v->settings->codes && p != code)) continue;
        const real counts = one ? 1 : p == code ? 0 : 1 / (real)shown;
        if (!one || nth == turn) compare(v, hand, p, target, share_of(v, p, shown, code), counts, l->loss);
        nth++;
    }
    if (v->settings->hold > 0 && view->correspondence.data && !ffp_device()) hold(v, hand, view, l->loss);
    regularise(v, hand, view, l->step, l->loss);
    ffp_view_pass_backward(hand->pass, l->grad);
}

typedef struct AtOnce {
    FfpPhotoLoss *viewer;
    const FfpGaussians *gaussians;
    const FfpFitView *looks;
} AtOnce;

static void render_by_hand(void *argument, int64_t i) {
    const AtOnce *a = argument;
    look(a->viewer, &a->viewer->hands[i], a->gaussians, &a->looks[i]);
}

// Two or three threads do better with a view each than with half of one: they need not wait for each other
// within it. Of large pictures the second hand's buffers are not worth it.
static bool at_once(const FfpPhotoLoss *v, const FfpFitView *looks) {
    const int threads = omp_get_max_threads();
    const FfpCamera *a = &v->capture->views[looks[0].view].camera,
                    *b = &v->capture->views[looks[1].view].camera;
    return !ffp_device() && threads > 1 && threads < 4 &&
           (int64_t)a->width * a->height <= FFP_AT_ONCE_PIXELS &&
           (int64_t)b->width * b->height <= FFP_AT_ONCE_PIXELS;
}

void ffp_photo_loss_backward(FfpPhotoLoss *v, const FfpGaussians *gaussians, const FfpFitView *looks, int n) {
    if (n == 2 && at_once(v, looks))
        ffp_parallel_for(n, 0, render_by_hand, &(AtOnce){v, gaussians, looks});
    else
        for (int i = 0; i < n; i++) look(v, &v->hands[0], gaussians, &looks[i]);
}

double ffp_photographs_psnr(const FfpGaussians *gaussians, const FfpCapture *capture, const int *patterns,
                            int n_patterns, const FfpRenderSettings *render) {
    const FfpRefineSettings settings = {.render = *render};
    FfpPhotoLoss *viewer = ffp_photo_loss_new(capture, patterns, n_patterns, &settings);
    const double psnr = ffp_photo_loss_psnr(viewer, gaussians);
    ffp_photo_loss_free(viewer);
    return psnr;
}
