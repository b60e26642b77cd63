#include "engine/match/observe.h"
#include <stdlib.h>
#include <tgmath.h>
#include "core/base/arena.h"
#include "core/base/vec.h"
#include "core/image/lookup.h"

#define LIGHT_MIN 1e-3F // linear radiance below which a ratio says nothing
#define RATIO_MAX 1.2F  // noise and gloss may lift a ratio above 1, not far
#define SLANT 1.35F     // mean of 1 / cos over the slants at which surfaces are seen
#define CELLS_A_BOX 4   // grid cells across the box that the pattern is averaged over

// Mean of (white - black) over the object and the channels.
static real typical_light(const real *light, const FfpImage *coverage, size_t pixels) {
    double sum = 0, area = 0;
    for (size_t i = 0; i < pixels; i++) {
        const double share = (double)coverage->data[i];
        for (size_t c = 3 * i; share > 0 && c < 3 * i + 3; c++) sum += share * fmax((double)light[c], 0.0);
        area += 3 * share;
    }
    return (real)fmax(sum / fmax(area, 1.0), (double)LIGHT_MIN);
}

// light [pixels,3]: white - black of the object's own share of each pixel; ratio likewise.
static void own_light(real *light, real *ratio, const FfpCapture *capture, const FfpView *view, int pattern,
                      size_t pixels) {
    const int pictures[3] = {capture->black, capture->white, pattern};
    for (size_t i = 0; i < pixels; i++) {
        const real coverage = view->coverage.data[i];
        if (coverage <= 0) continue;
        real own[3][3];
        for (int p = 0; p < 3; p++)
            ffp_own_radiance(own[p], view->images[pictures[p]].data + 3 * i, coverage);
        for (size_t c = 0; c < 3; c++) {
            light[3 * i + c] = own[1][c] - own[0][c];
            ratio[3 * i + c] =
                fmin(fmax((own[2][c] - own[0][c]) / fmax(light[3 * i + c], LIGHT_MIN), 0), RATIO_MAX);
        }
    }
}

FfpObservation ffp_observe(const FfpCapture *capture, int view_index, const int *patterns, int n) {
    const FfpView *view = &capture->views[view_index];
    const size_t pixels = (size_t)view->camera.width * (size_t)view->camera.height;
    FfpObservation out = {.width = view->camera.width, .height = view->camera.height};
    out.asked = ffp_alloc((size_t)n, sizeof *out.asked);
    for (int k = 0; k < n; k++)
        if (view->images[patterns[k]].data) out.asked[out.count++] = k;
    out.ratio = ffp_alloc(3 * pixels, (size_t)out.count * sizeof(real));
    out.weight = ffp_alloc(3 * pixels, sizeof(real));
    out.lit = ffp_alloc(pixels, sizeof(real));
    real *light = ffp_alloc(3 * pixels, sizeof(real));
    for (int k = 0; k < out.count; k++)
        own_light(light, out.ratio + (size_t)k * 3 * pixels, capture, view, patterns[out.asked[k]], pixels);
    const real typical = typical_light(light, &view->coverage, pixels);
    for (size_t c = 0; c < 3 * pixels; c++) {
        out.weight[c] = view->coverage.data[c / 3] * fmin(fmax(light[c] / typical, 0), 1);
        out.lit[c / 3] += out.weight[c] / 3;
    }
    ffp_free(light);
    return out;
}

void ffp_observation_free(FfpObservation *observation) {
    ffp_free(observation->asked);
    ffp_free(observation->ratio);
    ffp_free(observation->weight);
    ffp_free(observation->lit);
    *observation = (FfpObservation){0};
}

static void blur(real *cells, const FfpImage *pattern, int width, int height, real scale, real box) {
    const size_t stride = (size_t)width + 2;
    FfpSummed summed = ffp_summed_new(pattern);
#pragma omp parallel for schedule(static)
    for (int y = 0; y < height + 2; y++) {
        const real v = fmin(fmax((real)y - 0.5F, 0.5F), (real)height - 0.5F) / scale;
        for (int x = 0; x < width + 2; x++) {
            const real u = fmin(fmax((real)x - 0.5F, 0.5F), (real)width - 0.5F) / scale;
            ffp_lookup(&summed, u, v, box, box, cells + 4 * ((size_t)y * stride + (size_t)x));
        }
    }
    ffp_summed_free(&summed);
}

FfpBlurred ffp_blurred_new(const FfpCapture *capture, const int *patterns, int n, real box) {
    const FfpImage *first = &capture->patterns[patterns[0]].image;
    const real scale = fmin(CELLS_A_BOX / fmax(box, 1), 1);
    const int width = (int)ceil((real)first->width * scale), height = (int)ceil((real)first->height * scale);
    FfpBlurred out = {.stride = width + 2,
                      .patterns = n,
                      .area = ((size_t)width + 2) * ((size_t)height + 2),
                      .scale = scale,
                      .width = (real)first->width,
                      .height = (real)first->height};
    out.cells = ffp_alloc((size_t)n * out.area, 4 * sizeof(real));
    for (int k = 0; k < n; k++)
        blur(out.cells + 4 * (size_t)k * out.area, &capture->patterns[patterns[k]].image, width, height,
             scale, box);
    return out;
}

void ffp_blurred_free(FfpBlurred *blurred) {
    ffp_free(blurred->cells);
    *blurred = (FfpBlurred){0};
}

real ffp_typical_footprint(const FfpCapture *capture, int view) {
    const FfpCamera *camera = &capture->views[view].camera, *projector = &capture->views[view].projector;
    real x, y;
    const real near = 0.1F * capture->radius; // a device inside the object would make the ratio meaningless
    const real pixel = fmax(ffp_project(camera, capture->centre, &x, &y), near) / camera->fx;
    return fmax(SLANT * pixel * projector->fx / fmax(ffp_project(projector, capture->centre, &x, &y), near),
                1);
}
