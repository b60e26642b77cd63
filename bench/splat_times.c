// The rasteriser alone on made-up splats, once for every line that is asked for: what other libraries' is
// compared with, in turns (bench/peers/compare_splats).
//   splat_times SIDE OPACITY SIZE
// 8 SIDE^2 splats as ffp_bench_splats lays them (lab/bench/raster_times.h), seen by a camera of SIDE x SIDE
// pixels in the paper's form of drawing (blur 0.3 px^2, alpha the splat's own density), one sample a pixel.
// Says "ready", the CPU level and the number of splats, then reads lines: `run` is answered with the seconds
// of processor time and wall clock of the forward pass, and of the backward pass; `write FILE` with
// "written": float32, one after another: fx, fy, cx, cy, the camera's pose [4, 4]; of all splats the centres
// [N, 3], scales [N, 3], rotations [N, 4], opacities [N], albedos [N, 3]; the gradients given for the sums of
// albedo [SIDE, SIDE, 3] and opacity [SIDE, SIDE]; these sums; the gradients of the splats in the order
// above.
#include <stdlib.h>
#include "core/base/cpu.h"
#include "core/base/rng.h"
#include "lab/bench/raster_times.h"
#include "on_request.h"

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

static void timed_run(void *scene) {
    Scene *s = scene;
    const Moment begin = moment_now();
    ffp_rasterise(s->raster, &s->splats, &s->camera, &s->settings, &s->out);
    print_since(&begin, ' ');
    const Moment drawn = moment_now();
    clear_gradient(&s->grad);
    ffp_rasterise_backward(s->raster, &s->splats, &s->camera, &s->settings, &s->out, &s->grad_out, &s->grad);
    print_since(&drawn, '\n');
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

static void write_scene(const void *scene, FILE *out) {
    const Scene *s = scene;
    const FfpCamera *c = &s->camera;
    const real intrinsics[4] = {c->fx, c->fy, c->cx, c->cy};
    fwrite(intrinsics, sizeof(real), 4, out);
    fwrite(c->pose, sizeof(real), 16, out);
    write_splats(&s->splats, out);
    write_planes(&s->grad_out, out);
    write_planes(&s->out, out);
    write_splats(&s->grad, out);
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
        printf("ready %s %lld\n", ffp_cpu_name(ffp_cpu_level()), (long long)scene.splats.count);
        ok = serve(&(Requests){&scene, timed_run, write_scene}, &err);
        scene_free(&scene);
    }
    if (!ok) fprintf(stderr, "splat_times: error: %s\n", err.text);
    return !ok;
}
