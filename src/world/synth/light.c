#include "world/synth/light.h"
#include <stdlib.h>
#include "core/base/arena.h"
#include "world/shapes/scalar.h"

enum { LANES = 8 };

static bool is_even(const FfpImage *image) {
    const size_t values = (size_t)image->width * (size_t)image->height * 3;
    for (size_t i = 3; i < values; i++)
        if (image->data[i] != image->data[i - 3]) return false;
    return true;
}

// One row of box means of one pattern.
static void fill_row(FfpLight *light, const FfpImage *pattern, int lane, int row) {
    const size_t width = (size_t)light->width, lanes = (size_t)light->lanes;
    float *to = light->coarse + (size_t)row * (size_t)light->coarse_width * 3 * lanes + lane;
    const int end = (row + 1) * FFP_COARSE < light->height ? (row + 1) * FFP_COARSE : light->height;
    const size_t rows = (size_t)(end - row * FFP_COARSE), whole = width - width % FFP_COARSE;
    for (int y = row * FFP_COARSE; y < end; y++) {
        const real *from = pattern->data + (size_t)y * width * 3;
        for (size_t x = 0; x < width; x++) {
            const float pixels = (float)(rows * (x < whole ? FFP_COARSE : width - whole)); // of its box
            for (size_t c = 0; c < 3; c++)
                to[(3 * (x / FFP_COARSE) + c) * lanes] += (float)from[3 * x + c] / pixels;
        }
    }
}

FfpLight ffp_light_new(const FfpImage *const *patterns, int n_patterns) {
    const int width = patterns[0]->width, height = patterns[0]->height;
    const size_t n = (size_t)n_patterns;
    FfpLight light = {.width = width,
                      .height = height,
                      .coarse_width = (width + FFP_COARSE - 1) / FFP_COARSE,
                      .coarse_height = (height + FFP_COARSE - 1) / FFP_COARSE,
                      .n_patterns = n_patterns,
                      .lane = ffp_alloc(n, sizeof(int)),
                      .sharp = ffp_alloc(n, sizeof *light.sharp),
                      .even = ffp_alloc(n, sizeof(bool))};
    int used = 0;
    for (int p = 0; p < n_patterns; p++) {
        const real *first = patterns[p]->data;
        light.sharp[p] = patterns[p];
        light.even[p] = is_even(patterns[p]);
        light.lane[p] = light.even[p] && first[0] == 0 && first[1] == 0 && first[2] == 0 ? -1 : used++;
    }
    light.lanes = (used + LANES - 1) / LANES * LANES;
    const size_t boxes = (size_t)light.coarse_width * (size_t)light.coarse_height;
    light.coarse = ffp_alloc(boxes * 3 * (size_t)light.lanes, sizeof(float));
#pragma omp parallel for schedule(static)
    for (int row = 0; row < light.coarse_height; row++)
        for (int p = 0; p < n_patterns; p++)
            if (light.lane[p] >= 0) fill_row(&light, patterns[p], light.lane[p], row);
    return light;
}

// Deviation of a level of softness; level 0 is sharp.
static float deviation_of(int level) {
    return level > 0 ? (float)(1 << (level - 1)) : 0;
}

void ffp_light_soften(FfpLight *light) {
    const int n = light->n_patterns;
    light->soft = ffp_alloc((size_t)FFP_SOFT * (size_t)n, sizeof *light->soft);
    for (int i = 0; i < FFP_SOFT * n; i++) {
        if (light->even[i % n]) continue;
        light->soft[i] = ffp_image_copy(light->sharp[i % n]);
        ffp_image_blur(&light->soft[i], (real)deviation_of(i / n + 1));
    }
}

void ffp_light_free(FfpLight *light) {
    for (int i = 0; light->soft && i < FFP_SOFT * light->n_patterns; i++) ffp_image_free(&light->soft[i]);
    ffp_free(light->soft);
    ffp_free(light->lane);
    ffp_free((void *)light->sharp);
    ffp_free(light->even);
    ffp_free(light->coarse);
    *light = (FfpLight){0};
}

bool ffp_light_texel(int width, int height, float u, float v, FfpTexel *out) {
    if (!(u >= 0 && v >= 0 && u <= (float)width && v <= (float)height)) return false;
    const float x = ffp_max(u - 0.5F, 0), y = ffp_max(v - 0.5F, 0);
    const int i = (int)ffp_min(x, (float)(width - 1)), j = (int)ffp_min(y, (float)(height - 1));
    const float a = x - (float)i, b = y - (float)j;
    *out = (FfpTexel){(size_t)j * (size_t)width + (size_t)i,
                      i + 1 < width ? 1 : 0,
                      j + 1 < height ? (size_t)width : 0,
                      {(1 - a) * (1 - b), a * (1 - b), (1 - a) * b, a * b}};
    return true;
}

// The pictures of a level of softness.
static void add_level(const FfpLight *light, int level, const FfpTexel *texel, const float colour[3],
                      float *sum) {
    const size_t at = 3 * texel->at, right = 3 * texel->right, down = 3 * texel->down;
    const float *weight = texel->weight;
    for (int p = 0; p < light->n_patterns; p++) {
        if (light->lane[p] < 0) continue;
        float *to = sum + light->lane[p];
        const FfpImage *image = level > 0 && !light->even[p]
                                    ? &light->soft[(level - 1) * light->n_patterns + p]
                                    : light->sharp[p];
        const real *from = image->data + (light->even[p] ? 0 : at);
        for (int c = 0; c < 3; c++, from++, to += light->lanes)
            *to += colour[c] * (light->even[p] ? from[0]
                                               : weight[0] * from[0] + weight[1] * from[right] +
                                                     weight[2] * from[down] + weight[3] * from[right + down]);
    }
}

void ffp_light_add(const FfpLight *light, const FfpTexel *texel, const float colour[3], float *sum) {
    add_level(light, 0, texel, colour, sum);
}

void ffp_light_add_soft(const FfpLight *light, const FfpTexel *texel, float deviation, const float colour[3],
                        float *sum) {
    int level = 0;
    while (level + 1 < FFP_SOFT && deviation_of(level + 1) < deviation) level++;
    const float low = deviation_of(level), high = deviation_of(level + 1),
                share = ffp_min(1, (deviation * deviation - low * low) / (high * high - low * low));
    const float sharper[3] = {(1 - share) * colour[0], (1 - share) * colour[1], (1 - share) * colour[2]},
                softer[3] = {share * colour[0], share * colour[1], share * colour[2]};
    add_level(light, level, texel, sharper, sum);
    add_level(light, level + 1, texel, softer, sum);
}

void ffp_light_add_coarse(const FfpLight *light, const FfpTexel *texel, const float colour[3], float *sum) {
    const size_t lanes = (size_t)light->lanes, right = 3 * lanes * texel->right,
                 down = 3 * lanes * texel->down;
    const float *weight = texel->weight, *p = light->coarse + 3 * lanes * texel->at;
    for (size_t c = 0; c < 3; c++)
        for (size_t block = 0; block < lanes; block += LANES, p += LANES, sum += LANES)
            for (size_t k = 0; k < LANES; k++)
                sum[k] += colour[c] * (weight[0] * p[k] + weight[1] * p[k + right] + weight[2] * p[k + down] +
                                       weight[3] * p[k + right + down]);
}
