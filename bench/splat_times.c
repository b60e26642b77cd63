// The rasteriser alone on made-up splats, once for every line that is asked for: what other libraries' is
// compared with, in turns (bench/peers/compare_splats).
//   splat_times SIDE OPACITY SIZE
// 8 SIDE^2 splats as ffp_bench_splats lays them (bench/raster_times.h), seen by a camera of SIDE x SIDE
// pixels in the paper's form of drawing (blur 0.3 px^2, alpha the splat's own density), one sample a pixel.
// Says "ready", the CPU level and the number of splats, then reads lines: `run` is answered with the seconds
// of processor time and wall clock of the forward pass, and of the backward pass; `write FILE` with
// "written": float32, one after another: fx, fy, cx, cy, the camera's pose [4, 4]; of all splats the centres
// [N, 3], scales [N, 3], rotations [N, 4], opacities [N], albedos [N, 3]; the gradients given for the sums of
// albedo [SIDE, SIDE, 3] and opacity [SIDE, SIDE]; these sums; the gradients of the splats in the order
// above.
#include <omp.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>
#include "base/cpu.h"
#include "base/file.h"
#include "base/rng.h"
#include "bench/raster_times.h"

typedef struct Scene {
    FfpCamera camera;
    FfpGaussians splats, grad;
    FfpRenderSettings settings;
    FfpRaster *raster;
    FfpGbuffer out, grad_out;
} Scene;

static Scene scene_new(int side, real opacity, real size) {
    Scene s = {.camera = ffp_bench_camera(side),
               .splats = ffp_bench_splats(side, opacity, size),
               .settings = ffp_render_paper(),
               .raster = ffp_raster_new(),
               .out = ffp_gbuffer_new(side, side),
               .grad_out = ffp_gbuffer_new(side, side)};
    s.grad = ffp_gaussians_new(s.splats.count);
    FfpRng rng = ffp_rng(3, 2);
    for (int i = 0; i < 3 * side * side; i++) s.grad_out.albedo[i] = ffp_rng_range(&rng, -1, 1);
    for (int i = 0; i < side * side; i++) s.grad_out.opacity[i] = ffp_rng_range(&rng, -1, 1);
    return s;
}

static void scene_free(Scene *s) {
    ffp_gaussians_free(&s->splats);
    ffp_gaussians_free(&s->grad);
    ffp_raster_free(s->raster);
    ffp_gbuffer_free(&s->out);
    ffp_gbuffer_free(&s->grad_out);
}

static double processor_seconds(void) {
    struct timespec time;
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &time);
    return (double)time.tv_sec + 1e-9 * (double)time.tv_nsec;
}

static void clear_gradient(FfpGaussians *g) {
    const size_t n = (size_t)g->count * sizeof(real);
    memset(g->centre, 0, 3 * n);
    memset(g->scale, 0, 3 * n);
    memset(g->rotation, 0, 4 * n);
    memset(g->opacity, 0, n);
    memset(g->albedo, 0, 3 * n);
    memset(g->roughness, 0, n);
    memset(g->ambient, 0, 3 * n);
}

static void timed_run(Scene *s) {
    double wall[3], processor[3];
    wall[0] = omp_get_wtime(), processor[0] = processor_seconds();
    ffp_rasterise(s->raster, &s->splats, &s->camera, &s->settings, &s->out);
    wall[1] = omp_get_wtime(), processor[1] = processor_seconds();
    clear_gradient(&s->grad);
    ffp_rasterise_backward(s->raster, &s->splats, &s->camera, &s->settings, &s->out, &s->grad_out, &s->grad);
    wall[2] = omp_get_wtime(), processor[2] = processor_seconds();
    for (int i = 0; i < 2; i++)
        printf("%.6f %.6f%c", processor[i + 1] - processor[i], wall[i + 1] - wall[i], i ? '\n' : ' ');
}

static void write_splats(const FfpGaussians *g, FILE *to) {
    const size_t n = (size_t)g->count;
    fwrite(g->centre, sizeof(real), 3 * n, to);
    fwrite(g->scale, sizeof(real), 3 * n, to);
    fwrite(g->rotation, sizeof(real), 4 * n, to);
    fwrite(g->opacity, sizeof(real), n, to);
    fwrite(g->albedo, sizeof(real), 3 * n, to);
}

static void write_planes(const FfpGbuffer *g, FILE *to) {
    const size_t pixels = (size_t)g->width * (size_t)g->height;
    fwrite(g->albedo, sizeof(real), 3 * pixels, to);
    fwrite(g->opacity, sizeof(real), pixels, to);
}

static bool write_results(const Scene *s, const char *path, FfpError *err) {
    FfpOutput out;
    const FfpCamera *c = &s->camera;
    const real intrinsics[4] = {c->fx, c->fy, c->cx, c->cy};
    if (!ffp_output_open(&out, path, err)) return false;
    fwrite(intrinsics, sizeof(real), 4, out.stream);
    fwrite(c->pose, sizeof(real), 16, out.stream);
    write_splats(&s->splats, out.stream);
    write_planes(&s->grad_out, out.stream);
    write_planes(&s->out, out.stream);
    write_splats(&s->grad, out.stream);
    return ffp_output_commit(&out, err);
}

static bool serve(Scene *s, FfpError *err) {
    char line[4096];
    printf("ready %s %lld\n", ffp_cpu_name(ffp_cpu_level()), (long long)s->splats.count);
    while (fflush(stdout) == 0 && fgets(line, sizeof line, stdin)) {
        line[strcspn(line, "\n")] = 0;
        if (strcmp(line, "run") == 0) {
            timed_run(s);
        } else if (strncmp(line, "write ", 6) == 0) {
            if (!write_results(s, line + 6, err)) return false;
            puts("written");
        } else {
            return ffp_fail(err, FFP_ERROR_ARGUMENT, line, "neither `run` nor `write FILE`");
        }
    }
    return true;
}

int main(int argc, char **argv) {
    const int side = argc == 4 ? atoi(argv[1]) : 0;
    const double opacity = argc == 4 ? atof(argv[2]) : 0, size = argc == 4 ? atof(argv[3]) : 0;
    if (side < 16 || side > 1024 || !(opacity > 0 && opacity <= 1) || !(size > 0 && size <= 100)) {
        fputs("usage: splat_times SIDE OPACITY SIZE     16..1024, above 0 to 1, above 0 to 100\n", stderr);
        return 2;
    }
    FfpError err = {0};
    bool ok = ffp_cpu_check(&err);
    if (ok) {
        Scene scene = scene_new(side, (real)opacity, (real)size);
        ok = serve(&scene, &err);
        scene_free(&scene);
    }
    if (!ok) fprintf(stderr, "splat_times: error: %s\n", err.text);
    return !ok;
}
