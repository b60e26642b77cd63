// Rasterising and shading one view of 131,072 splats, from opaque to translucent.
#include <stdio.h>
#include "lab/bench/bench.h"
#include "lab/bench/raster_times.h"

enum { SIDE = 128, REPEATS = 15 };

// The least of an image to write is not a bound that means anything here: rows without a share.
static void add(FfpBenchTable *table, const char *name, const char *shape, double ms) {
    FfpBenchRow row = {.name = name, .ms = ms};
    snprintf(row.shape, sizeof row.shape, "%s", shape);
    ffp_bench_add(table, &row);
}

static void add_parts(FfpBenchTable *table, const FfpRasterTimes *t) {
    add(table, "  project", "forward", t->project);
    add(table, "  bin", "forward", t->bin);
    add(table, "  blend", "forward", t->blend);
    add(table, "  shade", "forward, one pattern", t->shade);
    add(table, "  map", "to the projector, with its shadow map", t->map);
    add(table, "  blend back", "backward", t->blend_backward);
    add(table, "  project back", "backward", t->project_backward);
    add(table, "  shade back", "backward, one pattern", t->shade_backward);
}

void ffp_bench_rasteriser(FfpBenchTable *table) {
    static const struct {
        real opacity, size;
    } sets[] = {{0.95F, 1}, {0.5F, 1}, {0.2F, 1}, {0.05F, 1}, {0.5F, 4}, {0.2F, 4}, {0.05F, 4}};
    const FfpCamera camera = ffp_bench_camera(SIDE);
    const bool once = ffp_bench_clock.exact;
    for (size_t i = 0; i < (once ? 1 : sizeof sets / sizeof *sets); i++) {
        FfpGaussians splats = ffp_bench_splats(SIDE, sets[i].opacity, sets[i].size);
        const FfpRasterTimes t = ffp_time_raster(&splats, &camera, once ? 1 : REPEATS);
        char shape[64];
        snprintf(shape, sizeof shape, "%ld, %g px, opacity %g, shaded", (long)splats.count,
                 0.5 * (double)sets[i].size, (double)sets[i].opacity);
        add(table, "rasterise_forward", shape, t.rasterise + t.shade);
        add(table, "rasterise_backward", shape, t.rasterise_backward + t.shade_backward);
        if (i == 0) add_parts(table, &t);
        ffp_gaussians_free(&splats);
    }
}
