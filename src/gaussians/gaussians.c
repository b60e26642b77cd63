#include "gaussians/gaussians.h"

#include <stdlib.h>
#include <string.h>

#include "base/arena.h"

FfpGaussians ffp_gaussians_new(int64_t count) {
    const size_t n = (size_t)count;
    return (FfpGaussians){
        .count = count,
        .centre = ffp_alloc(n, 3 * sizeof(real)),
        .scale = ffp_alloc(n, 3 * sizeof(real)),
        .rotation = ffp_alloc(n, 4 * sizeof(real)),
        .opacity = ffp_alloc(n, sizeof(real)),
        .albedo = ffp_alloc(n, 3 * sizeof(real)),
        .roughness = ffp_alloc(n, sizeof(real)),
        .ambient = ffp_alloc(n, 3 * sizeof(real)),
    };
}

FfpGaussians ffp_gaussians_copy(const FfpGaussians *from) {
    FfpGaussians to = ffp_gaussians_new(from->count);
    const size_t n = (size_t)from->count;
    memcpy(to.centre, from->centre, 3 * n * sizeof(real));
    memcpy(to.scale, from->scale, 3 * n * sizeof(real));
    memcpy(to.rotation, from->rotation, 4 * n * sizeof(real));
    memcpy(to.opacity, from->opacity, n * sizeof(real));
    memcpy(to.albedo, from->albedo, 3 * n * sizeof(real));
    memcpy(to.roughness, from->roughness, n * sizeof(real));
    memcpy(to.ambient, from->ambient, 3 * n * sizeof(real));
    return to;
}

void ffp_gaussians_free(FfpGaussians *gaussians) {
    if (gaussians == NULL) return;
    free(gaussians->centre);
    free(gaussians->scale);
    free(gaussians->rotation);
    free(gaussians->opacity);
    free(gaussians->albedo);
    free(gaussians->roughness);
    free(gaussians->ambient);
    *gaussians = (FfpGaussians){0};
}

void ffp_gaussians_transform(FfpGaussians *gaussians, const real offset[3], real radius) {
    for (int64_t i = 0; i < gaussians->count; i++) {
        for (int c = 0; c < 3; c++) {
            gaussians->centre[3 * i + c] = gaussians->centre[3 * i + c] * radius + offset[c];
            gaussians->scale[3 * i + c] *= radius;
        }
    }
}
