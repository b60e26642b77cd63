#include "engine/match/material.h"
#include <tgmath.h>
#include "core/base/arena.h"
#include "core/base/brdf.h"
#include "core/base/call.h"
#include "core/numerics/rank.h"
#include "engine/match/line.h"
#include "engine/match/observe.h"
#include "engine/match/thresholds.h"

#define COSINE_MIN 0.15F // n.l below this is not believed
#define LIT_FULL 0.25F   // as FFP_LIT_MIN: there the lit estimate begins to count, here it counts alone
#define ALBEDO_MAX 1.0F
#define ROUGHNESS 0.525F // of the classical splats: 0.05 + 0.95 / 2

// How much of the estimate comes from the projector's light, [0,1].
static real light_share(real lit) {
    return fmin(fmax((lit - FFP_LIT_MIN) / (LIT_FULL - FFP_LIT_MIN), 0), 1);
}

// The glossy term D F V at the roughness that the classical splats have.
static real gloss(const real normal[3], const real to_light[3], const real to_eye[3], real cosine) {
    real half[3] = {to_light[0] + to_eye[0], to_light[1] + to_eye[1], to_light[2] + to_eye[2]};
    ffp_normalise3(half);
    const FfpLobe lobe = ffp_lobe(ROUGHNESS, cosine, fmax(ffp_dot3(normal, to_eye), 0),
                                  fmax(ffp_dot3(normal, half), 0), ffp_dot3(to_eye, half));
    return lobe.D * lobe.F * lobe.V;
}

static void lit_albedo(real albedo[3], const FfpInitialisation *start, const FfpCapture *capture,
                       const FfpView *view, size_t i, const real point[3], const real light[3]) {
    const real *lamp = view->projector.pose, *eye = view->camera.pose, *normal = start->normal + 3 * i;
    real to_light[3] = {lamp[3] - point[0], lamp[7] - point[1], lamp[11] - point[2]};
    real to_eye[3] = {eye[3] - point[0], eye[7] - point[1], eye[11] - point[2]};
    const real d = ffp_normalise3(to_light), cosine = fmax(ffp_dot3(normal, to_light), COSINE_MIN);
    ffp_normalise3(to_eye);
    const real glossy = gloss(normal, to_light, to_eye, cosine);
    for (int c = 0; c < 3; c++) {
        const real reflected = d * d * light[c] / (fmax(capture->intensity[c], 1e-6F) * cosine);
        albedo[c] = fmin(fmax(FFP_PI * (reflected - glossy), 0), ALBEDO_MAX);
    }
}

static void view_colours(FfpInitialisation *start, const FfpCapture *capture, int v) {
    const FfpView *view = &capture->views[v];
    const real *black = view->images[capture->black].data, *white = view->images[capture->white].data;
    for (int y = 0; y < start->height; y++) {
        for (int x = 0; x < start->width; x++) {
            const size_t p = (size_t)y * (size_t)start->width + (size_t)x;
            const size_t i = (size_t)v * (size_t)start->width * (size_t)start->height + p;
            if (start->t[i] <= 0) continue;
            real direction[3], point[3], light[3], *ambient = start->ambient + 3 * i;
            ffp_own_radiance(ambient, black + 3 * p, view->coverage.data[p]);
            ffp_own_radiance(light, white + 3 * p, view->coverage.data[p]);
            ffp_pixel_ray(&view->camera, (real)x + 0.5F, (real)y + 0.5F, direction);
            for (int c = 0; c < 3; c++) {
                point[c] = view->camera.pose[4 * c + 3] + start->t[i] * direction[c];
                light[c] -= ambient[c];
            }
            lit_albedo(start->albedo + 3 * i, start, capture, view, i, point, light);
        }
    }
}

// The capture's median of ambient / albedo over fully lit pixels: the ambient light that albedo reflects. 0:
// none is lit.
static real ambient_light(const FfpInitialisation *start, size_t channel) {
    const size_t pixels = (size_t)start->views * (size_t)start->width * (size_t)start->height;
    real *ratio = ffp_alloc(pixels, sizeof(real));
    size_t count = 0;
    for (size_t i = 0; i < pixels; i++) {
        const real albedo = start->albedo[3 * i + channel];
        if (start->t[i] > 0 && start->lit[i] >= LIT_FULL && albedo > 1e-3F)
            ratio[count++] = start->ambient[3 * i + channel] / albedo;
    }
    const real median = ffp_median(ratio, count);
    ffp_free(ratio);
    return median;
}

// Unlit pixels reflect the ambient light; one channel.
static void unlit_albedo(void *argument, int64_t channel) {
    FfpInitialisation *start = argument;
    const size_t c = (size_t)channel,
                 pixels = (size_t)start->views * (size_t)start->width * (size_t)start->height;
    const real ambient = ambient_light(start, c);
    if (ambient <= 0) return;
    for (size_t i = 0; i < pixels; i++) {
        const real share = light_share(start->lit[i]),
                   unlit = fmin(start->ambient[3 * i + c] / ambient, ALBEDO_MAX);
        if (start->t[i] > 0)
            start->albedo[3 * i + c] = share * start->albedo[3 * i + c] + (1 - share) * unlit;
    }
}

void ffp_initialisation_materials(FfpInitialisation *start, const FfpCapture *capture) {
#pragma omp parallel for schedule(static)
    for (int v = 0; v < start->views; v++) view_colours(start, capture, v);
    ffp_parallel_for(3, 0, unlit_albedo, start);
}
