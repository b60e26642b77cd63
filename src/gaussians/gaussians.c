#include "gaussians/gaussians.h"

#include "base/arena.h"
#include "base/device.h"

FfpGaussians ffp_gaussians_new(int64_t count) {
    const size_t n = (size_t)count;
    return (FfpGaussians){
        .count = count,
        .centre = ffp_memory_new(n, 3 * sizeof(real)),
        .scale = ffp_memory_new(n, 3 * sizeof(real)),
        .rotation = ffp_memory_new(n, 4 * sizeof(real)),
        .opacity = ffp_memory_new(n, sizeof(real)),
        .albedo = ffp_memory_new(n, 3 * sizeof(real)),
        .roughness = ffp_memory_new(n, sizeof(real)),
        .ambient = ffp_memory_new(n, 3 * sizeof(real)),
    };
}

FfpGaussians ffp_gaussians_copy(const FfpGaussians *from) {
    FfpGaussians to = ffp_gaussians_new(from->count);
    const size_t n = (size_t)from->count;
    ffp_memory_copy(to.centre, from->centre, 3 * n * sizeof(real));
    ffp_memory_copy(to.scale, from->scale, 3 * n * sizeof(real));
    ffp_memory_copy(to.rotation, from->rotation, 4 * n * sizeof(real));
    ffp_memory_copy(to.opacity, from->opacity, n * sizeof(real));
    ffp_memory_copy(to.albedo, from->albedo, 3 * n * sizeof(real));
    ffp_memory_copy(to.roughness, from->roughness, n * sizeof(real));
    ffp_memory_copy(to.ambient, from->ambient, 3 * n * sizeof(real));
    return to;
}

void ffp_gaussians_free(FfpGaussians *gaussians) {
    if (gaussians == NULL) return;
    ffp_memory_free(gaussians->centre);
    ffp_memory_free(gaussians->scale);
    ffp_memory_free(gaussians->rotation);
    ffp_memory_free(gaussians->opacity);
    ffp_memory_free(gaussians->albedo);
    ffp_memory_free(gaussians->roughness);
    ffp_memory_free(gaussians->ambient);
    *gaussians = (FfpGaussians){0};
}

FfpGaussians ffp_gaussians_uploaded(const FfpGaussians *host) {
    const size_t n = (size_t)host->count;
    return (FfpGaussians){
        .count = host->count,
        .centre = ffp_memory_uploaded(host->centre, n, 3 * sizeof(real)),
        .scale = ffp_memory_uploaded(host->scale, n, 3 * sizeof(real)),
        .rotation = ffp_memory_uploaded(host->rotation, n, 4 * sizeof(real)),
        .opacity = ffp_memory_uploaded(host->opacity, n, sizeof(real)),
        .albedo = ffp_memory_uploaded(host->albedo, n, 3 * sizeof(real)),
        .roughness = ffp_memory_uploaded(host->roughness, n, sizeof(real)),
        .ambient = ffp_memory_uploaded(host->ambient, n, 3 * sizeof(real)),
    };
}

// One attribute's numbers on the host.
static real *downloaded(const real *from, int64_t count, int width) {
    real *host = ffp_alloc((size_t)count, (size_t)width * sizeof(real));
    ffp_memory_download(host, from, (size_t)count * (size_t)width * sizeof(real));
    return host;
}

FfpGaussians ffp_gaussians_downloaded(const FfpGaussians *g) {
    return (FfpGaussians){
        .count = g->count,
        .centre = downloaded(g->centre, g->count, 3),
        .scale = downloaded(g->scale, g->count, 3),
        .rotation = downloaded(g->rotation, g->count, 4),
        .opacity = downloaded(g->opacity, g->count, 1),
        .albedo = downloaded(g->albedo, g->count, 3),
        .roughness = downloaded(g->roughness, g->count, 1),
        .ambient = downloaded(g->ambient, g->count, 3),
    };
}

void ffp_gaussians_transform(FfpGaussians *gaussians, const real offset[3], real radius) {
    for (int64_t i = 0; i < gaussians->count; i++) {
        for (int c = 0; c < 3; c++) {
            gaussians->centre[3 * i + c] = gaussians->centre[3 * i + c] * radius + offset[c];
            gaussians->scale[3 * i + c] *= radius;
        }
    }
}
