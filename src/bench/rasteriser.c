// Rasterising and shading one view of 131,072 splats, from opaque to translucent.
#include <stdio.h>
#include "bench/bench.h"
#include "bench/raster_times.h"

enum { SIDE = 128, REPEATS = 15 };

// The least of an image to write is no bound that means anything here: rows without a share.
static void add(FfpBenchTable *table, const char *name, const char *shape, double ms) {
    FfpBenchRow row = {.name = name, .ms = ms};
    snprintf(row.shape, sizeof row.shape, "%s", shape);
    ffp_bench_add(table, &row);
}

void ffp_bench_rasteriser(FfpBenchTable *table) {
    static const real opacities[] = {0.95F, 0.5F, 0.2F, 0.05F};
    const FfpCamera camera = ffp_bench_camera(SIDE);
    for (size_t i = 0; i < sizeof opacities / sizeof *opacities; i++) {
        FfpGaussians splats = ffp_bench_splats(SIDE, opacities[i], 1);
        const FfpRasterTimes t = ffp_time_raster(&splats, &camera, REPEATS);
        char shape[64];
        snprintf(shape, sizeof shape, "%ld splats, opacity %g, shaded", (long)splats.count,
                 (double)opacities[i]);
        add(table, "rasterise_forward", shape, t.rasterise + t.shade);
        add(table, "rasterise_backward", shape, t.rasterise_backward + t.shade_backward);
        ffp_gaussians_free(&splats);
    }
}
