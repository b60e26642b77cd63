#include "engine/refine/pyramid.h"
#include <math.h>
#include <stdio.h>
#include "core/base/device.h"
#include "core/base/log.h"
#include "core/capture/reduce.h"
#include "engine/refine/fit.h"
#include "engine/refine/reduce.h"

#define LEAST_SHARE 0.25 // of the steps, at any size
#define SHADOW_LOOKS 8
#define VIEWS_JUDGED 3

typedef struct Pyramid {
    const FfpOrigin *origin;
    const FfpCapture *capture;
    const int *patterns;
    int n_patterns;
    const FfpRefineSettings *settings;
    int coarsest;      // side of its blocks
    double first_psnr; // of the coarsest fit's first round
    bool gained;       // some coarser fit was kept
} Pyramid;

int ffp_pyramid_side(const FfpCapture *capture) {
    const FfpCamera *camera = &capture->views[0].camera;
    const int longer = camera->width > camera->height ? camera->width : camera->height;
    int side = 1;
    while (longer > FFP_PYRAMID_SIDE * side) side *= 2;
    return side;
}

// Whole rounds, one at least: a fit keeps the state after a round.
static int64_t steps_of(const Pyramid *p, int side) {
    const double part = (double)side / p->coarsest, share = part > LEAST_SHARE ? part : LEAST_SHARE;
    const int64_t views = p->capture->n_views;
    return views * (int64_t)ceil(share * (double)p->settings->steps / (double)views - 1e-9);
}

static bool fit_coarse(const Pyramid *p, FfpGaussians *gaussians, const FfpCapture *small, int side,
                       const FfpRefineSettings *settings, FfpRefineResult *result, FfpError *err) {
    FfpCoarse coarse = ffp_coarse_new(gaussians, p->origin, side);
    FfpGaussians before = ffp_gaussians_copy(&coarse.gaussians);
    const bool ok =
        ffp_refine_offered(&coarse.gaussians, small, p->patterns, p->n_patterns, settings, result, err);
    if (ok && !result->dropped) ffp_coarse_carry(&coarse, &before, p->origin, gaussians);
    ffp_gaussians_free(&before);
    ffp_coarse_free(&coarse);
    return ok;
}

// Of the first views alone: enough to see that a fit has gone astray.
static double score(const Pyramid *p, const FfpGaussians *gaussians, const FfpCapture *pictures) {
    FfpCapture some = *pictures;
    FfpRenderSettings render = p->settings->render;
    render.samples = 1;
    if (some.n_views > VIEWS_JUDGED) some.n_views = VIEWS_JUDGED;
    return ffp_photographs_psnr(gaussians, &some, p->patterns, p->n_patterns, &render);
}

static void swap(FfpGaussians *a, FfpGaussians *b) {
    const FfpGaussians c = *a;
    *a = *b;
    *b = c;
}

// The best state on the way showed the pictures clearly better than the first one of this fit, and than the
// first one of all, in smaller pictures, which splats show better.
static bool has_clearly_gained(const Pyramid *p, const FfpRefineResult *finest) {
    return finest->best_psnr > fmax(p->first_psnr, finest->first_psnr) + FFP_CLEAR_GAIN;
}

// At full size: the last fit, and the judgement on all of them. `first` is what they began with.
static bool fit_finest(const Pyramid *p, FfpGaussians *gaussians, const FfpGaussians *first,
                       const FfpCapture *pictures, const FfpRefineSettings *settings, FfpRefineResult *result,
                       FfpError *err) {
    FfpGaussians coarser = ffp_gaussians_copy(gaussians);
    const bool ok =
        ffp_refine_offered(gaussians, pictures, p->patterns, p->n_patterns, settings, result, err);
    const bool nothing = ok && result->dropped && !p->gained;
    if (ok && !nothing && !has_clearly_gained(p, result)) {
        const double before = score(p, &coarser, pictures), after = score(p, gaussians, pictures);
        if (before > after) swap(gaussians, &coarser);
        result->dropped = fmax(before, after) < score(p, first, pictures);
    }
    ffp_gaussians_free(&coarser);
    return ok;
}

static bool fit_level(const Pyramid *p, FfpGaussians *gaussians, const FfpGaussians *first, int side,
                      FfpRefineResult *result, FfpError *err) {
    FfpCapture pictures = ffp_reduced(p->capture, p->patterns, p->n_patterns, side);
    FfpRefineSettings settings = *p->settings;
    char label[64];
    snprintf(label, sizeof label, "refining 1/%d", side);
    settings.label = label;
    settings.there = NULL;
    settings.steps = steps_of(p, side);
    settings.shadow_looks = SHADOW_LOOKS;
    const bool ok = side > 1 ? fit_coarse(p, gaussians, &pictures, side, &settings, result, err)
                             : fit_finest(p, gaussians, first, &pictures, &settings, result, err);
    ffp_capture_reduced_free(&pictures);
    return ok;
}

static bool fit_levels(Pyramid *p, FfpGaussians *gaussians, const FfpGaussians *first,
                       FfpRefineResult *result, FfpError *err) {
    int64_t steps = 0;
    for (int side = p->coarsest; side > 0; side /= 2) {
        if (!fit_level(p, gaussians, first, side, result, err)) return false;
        if (side == p->coarsest) p->first_psnr = result->first_psnr;
        p->gained |= !result->dropped;
        steps += result->steps;
    }
    result->steps = steps;
    return true;
}

void ffp_pyramid_psnr(const FfpGaussians *const *gaussians, const FfpOrigin *origins, int n,
                      const FfpCapture *capture, const int *patterns, int n_patterns,
                      const FfpRenderSettings *render, double *psnr) {
    FfpRenderSettings one_sample = *render;
    one_sample.samples = 1;
    const int side = ffp_pyramid_side(capture);
    FfpCapture small = {0};
    if (side > 1) small = ffp_reduced(capture, patterns, n_patterns, side);
    for (int i = 0; i < n; i++) {
        if (side == 1 || !origins[i].pixel || gaussians[i]->count < 1) {
            psnr[i] = ffp_photographs_psnr(gaussians[i], capture, patterns, n_patterns, &one_sample);
            continue;
        }
        FfpCoarse coarse = ffp_coarse_new(gaussians[i], &origins[i], side);
        psnr[i] = ffp_photographs_psnr(&coarse.gaussians, &small, patterns, n_patterns, &one_sample);
        ffp_coarse_free(&coarse);
    }
    ffp_capture_reduced_free(&small);
}

bool ffp_refine_pyramid(FfpGaussians *gaussians, const FfpOrigin *origin, const FfpCapture *capture,
                        const int *patterns, int n_patterns, const FfpRefineSettings *settings,
                        FfpRefineResult *result, FfpError *err) {
    Pyramid p = {origin, capture, patterns, n_patterns, settings, ffp_pyramid_side(capture), 0, false};
    if (p.coarsest == 1 || !origin->pixel || settings->steps < capture->n_views || gaussians->count < 1)
        return ffp_refine_offered(gaussians, capture, patterns, n_patterns, settings, result, err);
    if (ffp_device())
        return ffp_fail(err, FFP_ERROR_UNSUPPORTED, capture->folder,
                        "pictures longer than %d pixels are fitted on the CPU only", FFP_PYRAMID_SIDE);
    const double begin = ffp_seconds();
    FfpGaussians first = ffp_gaussians_copy(gaussians);
    const bool ok = fit_levels(&p, gaussians, &first, result, err);
    if (!ok || result->dropped) swap(gaussians, &first);
    ffp_gaussians_free(&first);
    result->gaussians = gaussians->count;
    result->seconds = ffp_seconds() - begin;
    return ok;
}
