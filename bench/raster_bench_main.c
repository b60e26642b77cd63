// Prints the tables of docs/performance.md, "Rasteriser":
//   raster_bench [FILE.ply ...]    the synthetic sets, then the Gaussians of each file
#include <omp.h>
#include <stdio.h>
#include "base/cpu.h"
#include "bench/raster_bench.h"

enum { SIDE = 128, REPEATS = 25 };

static void print_times(const char *name, const FfpGaussians *g) {
    const FfpCamera camera = ffp_bench_camera(SIDE);
    const FfpRasterTimes t = ffp_time_raster(g, &camera, REPEATS);
    printf("| %s | %ld | %ld | %.2f (%.2f + %.2f + %.2f) | %.2f | %.2f | %.2f (%.2f + %.2f) | %.2f |\n", name,
           (long)t.splats, (long)t.instances, t.rasterise, t.project, t.bin, t.blend, t.shade, t.map,
           t.rasterise_backward, t.blend_backward, t.project_backward, t.shade_backward);
}

static bool print_file(const char *path) {
    FfpError err = {0};
    FfpGaussians g = {0};
    if (!ffp_gaussians_read(&g, path, &err)) {
        fprintf(stderr, "raster_bench: cannot read %s\n", path);
        return false;
    }
    print_times(path, &g);
    ffp_gaussians_free(&g);
    return true;
}

int main(int argc, char **argv) {
    static const real opacity[] = {0.95F, 0.9F, 0.5F, 0.2F, 0.05F, 0.2F, 0.05F},
                      size[] = {1, 1, 1, 1, 1, 4, 4};
    printf("%dx%d view, %d threads, %s, least of %d, ms\n\n", SIDE, SIDE, omp_get_max_threads(),
           ffp_cpu_name(ffp_cpu_level()), REPEATS);
    printf("| splats | drawn | pairs | rasterise (project + bin + blend) | shade | map | backward (blend + "
           "project) | shade backward |\n|---|---|---|---|---|---|---|---|\n");
    for (size_t i = 0; i < sizeof opacity / sizeof *opacity; i++) {
        char name[80];
        FfpGaussians g = ffp_bench_splats(SIDE, opacity[i], size[i]);
        snprintf(name, sizeof name, "deviation %g px, opacity %g", 0.5 * (double)size[i], (double)opacity[i]);
        print_times(name, &g);
        ffp_gaussians_free(&g);
    }
    for (int i = 1; i < argc; i++)
        if (!print_file(argv[i])) return 1;
    return 0;
}
