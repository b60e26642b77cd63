// The limits of the light, and how near the pictures come to their targets.
#include <string.h>
#include <tgmath.h>
#include "engine/apply/encoded.h"
#include "engine/apply/solve.h"
#include "engine/loss/metrics.h"

#define STEP (1.0F / 255) // of an 8-bit picture, encoded
// Gains that are tried: 2^-6 to 2^6.
#define GAINS_PER_DOUBLING 8
#define GAINS (12 * GAINS_PER_DOUBLING + 1)

// Linear radiance with every projection at white, without what is scattered.
static void brightest_at(const FfpProCams *procams, int camera_view, int p, real out[3]) {
    memcpy(out, procams->camera_views[camera_view].ambient.data + 3 * p, 3 * sizeof *out);
    for (int k = 0; k < procams->n_projections; k++)
        for (int c = 0; c < 3; c++)
            out[c] += ffp_procams_link(procams, camera_view, k)->response.data[3 * p + c];
}

// By direct light; *bright: the radiance with every projection at white.
static bool is_lit(const FfpProCams *procams, int camera_view, int p, real bright[3]) {
    const FfpCameraView *view = &procams->camera_views[camera_view];
    const real *dark = view->ambient.data + 3 * p;
    bool lit = false;
    brightest_at(procams, camera_view, p, bright);
    for (int c = 0; c < 3; c++) {
        lit = lit || ffp_srgb_encode(bright[c]) - ffp_srgb_encode(dark[c]) >= 2 * STEP;
        if (view->scattered.data) bright[c] += view->scattered.data[3 * p + c];
    }
    return lit;
}

FfpImage ffp_procams_lit(const FfpProCams *procams, int camera_view) {
    const FfpImage *weight = &procams->camera_views[camera_view].weight;
    FfpImage lit = ffp_image_new(weight->width, weight->height, 1);
    const int pixels = weight->width * weight->height;
    real bright[3];
    for (int p = 0; p < pixels; p++)
        lit.data[p] = weight->data[p] > 0.5F && is_lit(procams, camera_view, p, bright);
    return lit;
}

FfpGamut ffp_procams_gamut(const FfpProCams *procams) {
    FfpGamut gamut = {0};
    int unlit = 0, dark = 0, bright = 0;
    for (int s = 0; s < procams->n_camera_views; s++) {
        const FfpCameraView *camera_view = &procams->camera_views[s];
        const int pixels = camera_view->weight.width * camera_view->weight.height;
        FfpImage floor = ffp_procams_floor(procams, s);
        for (int p = 0; p < pixels; p++) {
            real most[3];
            bool below = false, above = false;
            if (!(camera_view->weight.data[p] > 0.5F)) continue;
            const bool lit = is_lit(procams, s, p, most);
            gamut.pixels++;
            unlit += !lit;
            for (int c = 0; lit && c < 3; c++) {
                const real wanted = ffp_srgb_encode(camera_view->target.data[3 * p + c]);
                below |= wanted < ffp_srgb_encode(floor.data[3 * p + c]) - STEP;
                above |=
                    camera_view->target.data[3 * p + c] > most[c] &&
                    (wanted > ffp_srgb_encode(most[c]) + STEP || camera_view->target.data[3 * p + c] > 1);
            }
            dark += below;
            bright += above;
        }
        ffp_image_free(&floor);
    }
    const double whole = gamut.pixels ? gamut.pixels : 1;
    gamut.unlit = unlit / whole;
    gamut.too_dark = dark / whole;
    gamut.too_bright = bright / whole;
    return gamut;
}

// How far the targets, times a gain, lie from what light can reach: root mean square over the lit pixels of
// the encoded distance. A camera shows nothing above 1.
static double distance_at(const FfpProCams *procams, real gain) {
    double sum = 0, count = 0;
    for (int s = 0; s < procams->n_camera_views; s++) {
        const FfpCameraView *camera_view = &procams->camera_views[s];
        for (int p = 0; p < camera_view->weight.width * camera_view->weight.height; p++) {
            real most[3], slope;
            if (!(camera_view->weight.data[p] > 0.5F) || !is_lit(procams, s, p, most)) continue;
            for (int c = 0; c < 3; c++) {
                const real wanted = ffp_encode_on(gain * camera_view->target.data[3 * p + c], &slope);
                const real low = ffp_srgb_encode(camera_view->ambient.data[3 * p + c]),
                           high = ffp_srgb_encode(most[c]);
                const real off = wanted < low ? low - wanted : wanted > high ? wanted - high : 0;
                sum += (double)off * (double)off;
                count++;
            }
        }
    }
    return count > 0 ? sqrt(sum / count) : 0;
}

real ffp_procams_brightest(const FfpProCams *procams) {
    double distance[GAINS], least = INFINITY;
    for (int k = 0; k < GAINS; k++) {
        distance[k] = distance_at(procams, exp2((real)(k - GAINS / 2) / GAINS_PER_DOUBLING));
        least = fmin(least, distance[k]);
    }
    int k = GAINS - 1;
    while (distance[k] > least + (double)STEP) k--;
    // black targets and unlit objects are as near with any gain
    return k == GAINS - 1 ? 1 : exp2((real)(k - GAINS / 2) / GAINS_PER_DOUBLING);
}

double ffp_procams_psnr(const FfpProCams *procams) {
    double sum = 0;
    int counted = 0;
    for (int s = 0; s < procams->n_camera_views; s++) {
        FfpImage picture = ffp_procams_picture(procams, s),
                 target = ffp_image_copy(&procams->camera_views[s].target);
        FfpImage lit = ffp_procams_lit(procams, s);
        ffp_image_to_srgb(&picture);
        ffp_image_to_srgb(&target);
        const double psnr = ffp_psnr_masked(&picture, &target, &lit);
        if (isfinite(psnr)) {
            sum += psnr;
            counted++;
        }
        ffp_image_free(&picture);
        ffp_image_free(&target);
        ffp_image_free(&lit);
    }
    return counted ? sum / counted : NAN;
}

void ffp_procams_quantise(FfpProCams *procams) {
    for (int k = 0; k < procams->n_projections; k++) {
        FfpImage *pattern = &procams->projections[k].pattern;
        const size_t count = (size_t)pattern->width * (size_t)pattern->height * 3;
        for (size_t i = 0; i < count; i++)
            pattern->data[i] = ffp_srgb_decode(round(ffp_srgb_encode(pattern->data[i]) * 255) / 255);
    }
}
