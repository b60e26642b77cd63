// The renderer against a brute-force one in double, against physics, and against itself.
// Labels: threads
#define _DEFAULT_SOURCE // MAP_NORESERVE
#include <math.h>
#include <omp.h>
#include <sys/mman.h>
#include "core/base/arena.h"
#include "core/base/cpu.h"
#include "engine/render/kernels/kernels.h"
#include "engine/render/pass.h"
#include "engine/render/raster.h"
#include "engine/render/scenes.h"
#include "engine/render/shade_pixel.h"
#include "support.h"

static const real eye[3] = {2.1F, -1.7F, 1.1F}, origin[3] = {0, 0, 0};
#define PI 3.14159265358979324

// A splat as the reference sees it, worked out by itself from the textbook formulas.
typedef struct Reference {
    double x, y, z, inverse[3], opacity, firmness, value[12];
} Reference;

static void reference_rotation(const real given[4], double R[3][3]) {
    double q[4], length = 0;
    for (int k = 0; k < 4; k++) length += (double)given[k] * (double)given[k];
    for (int k = 0; k < 4; k++) q[k] = (double)given[k] / sqrt(length);
    const double w = q[0], x = q[1], y = q[2], z = q[3];
    const double m[3][3] = {{1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)},
                            {2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)},
                            {2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)}};
    memcpy(R, m, sizeof m);
}

// Sigma = R S S R^T taken to the camera, then through the perspective's derivative; all splats well inside
// the image.
static void reference_covariance(const FfpCamera *c, double R[3][3], const real *scale, const double t[3],
                                 double out[3]) {
    double world[3][3] = {{0}}, view[3][3] = {{0}};
    for (int i = 0; i < 9; i++)
        for (int k = 0; k < 3; k++)
            world[i / 3][i % 3] += R[i / 3][k] * R[i % 3][k] * (double)scale[k] * (double)scale[k];
    for (int i = 0; i < 9; i++)
        for (int k = 0; k < 9; k++)
            view[i / 3][i % 3] += (double)c->pose[4 * (k / 3) + i / 3] * world[k / 3][k % 3] *
                                  (double)c->pose[4 * (k % 3) + i % 3];
    const double fx = (double)c->fx, fy = (double)c->fy, z = t[2];
    const double J[2][3] = {{fx / z, 0, -fx * t[0] / (z * z)}, {0, fy / z, -fy * t[1] / (z * z)}};
    out[0] = out[1] = out[2] = 0;
    for (int k = 0; k < 9; k++) {
        out[0] += J[0][k / 3] * view[k / 3][k % 3] * J[0][k % 3];
        out[1] += J[0][k / 3] * view[k / 3][k % 3] * J[1][k % 3];
        out[2] += J[1][k / 3] * view[k / 3][k % 3] * J[1][k % 3];
    }
}

static Reference reference_splat(const FfpGaussians *g, int64_t i, const FfpCamera *c,
                                 const FfpRenderSettings *settings) {
    Reference r = {0};
    double R[3][3], t[3] = {0}, cov[3], along = 0;
    const real *s = g->scale + 3 * i;
    reference_rotation(g->rotation + 4 * i, R);
    for (int k = 0; k < 9; k++)
        t[k / 3] += (double)c->pose[4 * (k % 3) + k / 3] *
                    ((double)g->centre[3 * i + k % 3] - (double)c->pose[4 * (k % 3) + 3]);
    reference_covariance(c, R, s, t, cov);
    r.x = (double)c->fx * t[0] / t[2] + (double)c->cx, r.y = (double)c->fy * t[1] / t[2] + (double)c->cy,
    r.z = t[2];
    const double b = (double)settings->blur, before = cov[0] * cov[2] - cov[1] * cov[1];
    const double det = (cov[0] + b) * (cov[2] + b) - cov[1] * cov[1];
    r.inverse[0] = (cov[2] + b) / det, r.inverse[1] = -cov[1] / det, r.inverse[2] = (cov[0] + b) / det;
    r.firmness = (double)settings->firmness;
    r.opacity = (double)g->opacity[i] * (settings->compensation ? sqrt(fmax(before / det, 2.5e-5)) : 1);
    int axis = 0;
    for (int k = 1; k < 3; k++)
        if (s[k] < s[axis]) axis = k;
    for (int k = 0; k < 3; k++)
        along += R[k][axis] * ((double)g->centre[3 * i + k] - (double)c->pose[4 * k + 3]);
    r.value[0] = 1, r.value[1] = t[2], r.value[8] = (double)g->roughness[i];
    for (int k = 0; k < 3; k++) {
        r.value[2 + k] = along > 0 ? -R[k][axis] : R[k][axis];
        r.value[5 + k] = (double)g->albedo[3 * i + k];
        r.value[9 + k] = (double)g->ambient[3 * i + k];
    }
    return r;
}

static int nearer(const void *a, const void *b) {
    const double x = ((const Reference *)a)->z, y = ((const Reference *)b)->z;
    return (x > y) - (x < y);
}

// All splats at one pixel, near to far: 12 sums and the distortion by its definition, over all ordered pairs.
// Returns whether any decision (1/255, the end of the transmittance) was so near that rounding may turn it.
static bool reference_pixel(const Reference *splats, int count, int x, int y, double out[13]) {
    double T = 1, *w = ffp_alloc((size_t)count, sizeof *w);
    bool near = false;
    memset(out, 0, 13 * sizeof *out);
    for (int i = 0; i < count; i++) {
        const Reference *s = &splats[i];
        const double dx = s->x - (x + 0.5), dy = s->y - (y + 0.5);
        const double sigma =
            0.5 * (s->inverse[0] * dx * dx + s->inverse[2] * dy * dy) + s->inverse[1] * dx * dy;
        const double d = s->opacity * exp(-sigma), alpha = fmin(0.99, d * (1 + s->firmness * (1 - d)));
        near |= fabs(alpha * 255 - 1) < 1e-3;
        if (alpha < 1. / 255) continue;
        near |= fabs(T * (1 - alpha) * 1e4 - 1) < 1e-3;
        if (T * (1 - alpha) <= 1e-4) break;
        w[i] = alpha * T;
        T *= 1 - alpha;
        for (int k = 0; k < 12; k++) out[k] += w[i] * s->value[k];
    }
    for (int i = 0; i < count; i++)
        for (int j = 0; j < count && w[i] > 0; j++) out[12] += w[i] * w[j] * fabs(splats[i].z - splats[j].z);
    ffp_free(w);
    return near;
}

static void gbuffer_pixel(const FfpGbuffer *g, int p, double out[13]) {
    out[0] = (double)g->opacity[p], out[1] = (double)g->depth[p], out[8] = (double)g->roughness[p];
    for (int k = 0; k < 3; k++) {
        out[2 + k] = (double)g->normal[3 * p + k], out[5 + k] = (double)g->albedo[3 * p + k];
        out[9 + k] = (double)g->ambient[3 * p + k];
    }
    out[12] = (double)g->distortion[p];
}

// Every CPU level's picture of the set.
static void rasterise_levels(const FfpGaussians *g, const FfpCamera *camera,
                             const FfpRenderSettings *settings, FfpGbuffer out[FFP_CPU_LEVELS]) {
    const FfpCpuLevel used = ffp_cpu_level();
    FfpRaster *raster = ffp_raster_new();
    for (int level = 0; level <= (int)ffp_cpu_best(); level++) {
        assert_true(ffp_cpu_set_level((FfpCpuLevel)level));
        out[level] = ffp_gbuffer_new(camera->width, camera->height);
        ffp_rasterise(raster, g, camera, settings, &out[level]);
    }
    assert_true(ffp_cpu_set_level(used));
    ffp_raster_free(raster);
}

static void check_against_brute_force(const FfpGaussians *g, FfpCamera camera, FfpRenderSettings settings) {
    FfpGbuffer out[FFP_CPU_LEVELS];
    Reference *splats = ffp_alloc((size_t)g->count, sizeof *splats);
    rasterise_levels(g, &camera, &settings, out);
    for (int64_t i = 0; i < g->count; i++) splats[i] = reference_splat(g, i, &camera, &settings);
    qsort(splats, (size_t)g->count, sizeof *splats, nearer);
    int skipped = 0, pixels = camera.width * camera.height;
    for (int p = 0; p < pixels; p++) {
        double want[13], got[13];
        const bool near = reference_pixel(splats, (int)g->count, p % camera.width, p / camera.width, want);
        skipped += near;
        for (int i = 0; i < 13 * ((int)ffp_cpu_best() + 1); i++) {
            const int k = i % 13, level = i / 13;
            if (k == 0) gbuffer_pixel(&out[level], p, got);
            // fp32: a flat splat's exponent is a difference of large terms
            if (!(fabs(got[k] - want[k]) <= (near ? 0.03 : 5e-5 * (1 + fabs(want[k])))))
                fail_msg("%s, pixel %d channel %d: %g, brute force %g", ffp_cpu_name((FfpCpuLevel)level), p,
                         k, got[k], want[k]);
        }
    }
    assert_true(skipped < pixels / 4);
    ffp_free(splats);
    for (int level = 0; level <= (int)ffp_cpu_best(); level++) ffp_gbuffer_free(&out[level]);
}

static void test_brute_force(void **state) {
    (void)state;
    for (int n = 0; n < 4; n++) {
        // small and opaque; wide and faint; flat; all kinds
        const double low[] = {0.01, 0.05, 0.02, 0.005}, high[] = {0.04, 0.3, 0.1, 0.2};
        const double faint[] = {0.9, 0.05, 0.5, 0.001}, opaque[] = {1, 0.3, 0.99, 1};
        FfpGaussians g =
            random_gaussians(n == 0 ? 900 : 300, 20 + (uint64_t)n, 0.5, low[n], high[n], faint[n], opaque[n]);
        for (int64_t i = 0; n == 2 && i < g.count; i++) g.scale[3 * i + i % 3] *= 0.05F;
        check_against_brute_force(&g, look_at(67, 45, 70, eye, origin),
                                  n % 2 ? ffp_render_paper() : ffp_render_defaults());
        ffp_gaussians_free(&g);
    }
    // More splats a tile than are blended at a time, faint enough that all of them count; odd sizes
    FfpGaussians many = random_gaussians(900, 27, 0.3, 0.02, 0.06, 0.005, 0.05);
    check_against_brute_force(&many, look_at(19, 17, 36, eye, origin), ffp_render_defaults());
    ffp_gaussians_free(&many);
    // And ones that end the transmittance in the middle
    FfpGaussians stacked = random_gaussians(600, 28, 0.3, 0.05, 0.1, 0.3, 1);
    check_against_brute_force(&stacked, look_at(23, 13, 36, eye, origin), ffp_render_defaults());
    ffp_gaussians_free(&stacked);
}

// A camera whose principal point lies outside sees the same as that part of a larger image.
static void test_principal_point_outside(void **state) {
    (void)state;
    FfpGaussians g = random_gaussians(800, 31, 0.8, 0.01, 0.04, 0.2, 1);
    const FfpCamera whole = look_at(160, 96, 110, eye, origin);
    FfpCamera part = whole;
    part.width = 41, part.height = 33;
    part.cx -= 86, part.cy -= 51;
    assert_true(part.cx < 0 && part.cy < 0);
    FfpRaster *raster = ffp_raster_new();
    const FfpRenderSettings settings = ffp_render_defaults();
    FfpGbuffer a = ffp_gbuffer_new(160, 96), b = ffp_gbuffer_new(41, 33);
    ffp_rasterise(raster, &g, &whole, &settings, &a);
    ffp_rasterise(raster, &g, &part, &settings, &b);
    double seen = 0, different = 0;
    for (int y = 0; y < 33; y++)
        for (int x = 0; x < 41; x++) {
            const int p = y * 41 + x, q = (y + 51) * 160 + x + 86;
            seen += b.opacity[p];
            different += fabsf(a.opacity[q] - b.opacity[p]) + fabsf(a.depth[q] - b.depth[p]);
            for (int k = 0; k < 3; k++) different += fabsf(a.albedo[3 * q + k] - b.albedo[3 * p + k]);
        }
    assert_true(seen > 100);
    assert_true(different < 1e-3 * seen);
    ffp_gbuffer_free(&a);
    ffp_gbuffer_free(&b);
    ffp_gaussians_free(&g);
    ffp_raster_free(raster);
}

// Everything that one view gives, forward and backward, as one block of numbers.
static real *everything(const FfpGaussians *g, const FfpCamera *camera, int64_t *count) {
    FfpRaster *raster = ffp_raster_new();
    const FfpRenderSettings settings = ffp_render_defaults();
    FfpGbuffer out = ffp_gbuffer_new(camera->width, camera->height),
               weights = ffp_gbuffer_new(camera->width, camera->height);
    FfpGaussians grad = ffp_gaussians_new(g->count);
    randomise_gbuffer(&weights, 3);
    ffp_rasterise(raster, g, camera, &settings, &out);
    ffp_rasterise_backward(raster, g, camera, &settings, &out, &weights, &grad);
    Field f[2 * FIELDS];
    gbuffer_fields(&out, f);
    gaussian_fields(&grad, f + FIELDS);
    *count = 0;
    for (int k = 0; k < 2 * FIELDS; k++) *count += f[k].count;
    real *all = ffp_alloc((size_t)*count, sizeof(real)), *end = all;
    for (int k = 0; k < 2 * FIELDS; k++) {
        if (f[k].count > 0) memcpy(end, f[k].data, (size_t)f[k].count * sizeof(real));
        end += f[k].count;
    }
    ffp_gbuffer_free(&out);
    ffp_gbuffer_free(&weights);
    ffp_gaussians_free(&grad);
    ffp_raster_free(raster);
    return all;
}

static void test_same_bits(void **state) {
    (void)state;
    FfpGaussians g = random_gaussians(3000, 41, 0.6, 0.005, 0.1, 0.05, 1);
    const FfpCamera camera = look_at(71, 53, 75, eye, origin);
    const int threads = omp_get_max_threads();
    int64_t count;
    real *first = everything(&g, &camera, &count);
    for (int n = 1; n <= 4; n++) {
        omp_set_num_threads(n);
        real *again = everything(&g, &camera, &count);
        assert_memory_equal(first, again, (size_t)count * sizeof(real));
        ffp_free(again);
    }
    omp_set_num_threads(threads);
    ffp_free(first);
    ffp_gaussians_free(&g);
}

// Root mean square of the difference as a share of that of the numbers.
static double share_off(const real *a, const real *b, int64_t count) {
    double off = 0, all = 0;
    for (int64_t i = 0; i < count; i++) {
        const double d = (double)a[i] - (double)b[i];
        off += d * d, all += (double)b[i] * (double)b[i];
    }
    return sqrt(off / all);
}

// Pictures and gradients are those of the portable kernels, but for rounding (5e-7 and 5e-6 of them were
// seen) and for what rounding may turn: a splat whose alpha at a pixel is within rounding of 1/255 counts or
// not.
static void test_levels_agree(void **state) {
    (void)state;
    static const int sizes[][2] = {{71, 53}, {16, 16}, {5, 3}, {130, 33}};
    const FfpCpuLevel used = ffp_cpu_level();
    for (int n = 0; n < 8; n++) {
        FfpGaussians g = random_gaussians(n % 2 ? 3001 : 800, 70 + (uint64_t)n, 0.6, 0.005, 0.1, 0.01, 1);
        const FfpCamera camera = look_at(sizes[n / 2][0], sizes[n / 2][1], 40, eye, origin);
        int64_t count;
        assert_true(ffp_cpu_set_level(FFP_CPU_PORTABLE));
        real *plain = everything(&g, &camera, &count);
        for (int level = 1; level <= (int)ffp_cpu_best(); level++) {
            assert_true(ffp_cpu_set_level((FfpCpuLevel)level));
            real *fast = everything(&g, &camera, &count);
            const int64_t picture = 13 * (int64_t)camera.width * camera.height;
            const double forward = share_off(fast, plain, picture);
            const double backward = share_off(fast + picture, plain + picture, count - picture);
            if (!(forward < 2e-4) || !(backward < 2e-3))
                fail_msg("%s, set %d: picture off by %g, gradients by %g", ffp_cpu_name((FfpCpuLevel)level),
                         n, forward, backward);
            ffp_free(fast);
        }
        ffp_free(plain);
        ffp_gaussians_free(&g);
    }
    assert_true(ffp_cpu_set_level(used));
}

// From the second step on the same views need no more memory.
static void test_no_more_memory(void **state) {
    (void)state;
    FfpGaussians g = random_gaussians(3000, 43, 0.6, 0.005, 0.1, 0.05, 1), grad = ffp_gaussians_new(3000);
    const FfpRenderSettings settings = ffp_render_defaults();
    FfpGbuffer out = ffp_gbuffer_new(71, 53), weights = ffp_gbuffer_new(71, 53);
    FfpRaster *raster = ffp_raster_new(), held;
    randomise_gbuffer(&weights, 3);
    for (int step = 0; step < 6; step++) {
        const real from[3] = {2.1F, step % 2 ? -1.7F : 1.5F, 1.1F};
        const FfpCamera camera = look_at(71, 53, 75, from, origin);
        ffp_rasterise(raster, &g, &camera, &settings, &out);
        ffp_rasterise_backward(raster, &g, &camera, &settings, &out, &weights, &grad);
        if (step == 1) held = *raster;
        if (step < 2) continue;
        assert_ptr_equal(raster->splats, held.splats);
        assert_ptr_equal(raster->first, held.first);
        assert_ptr_equal(raster->counts, held.counts);
        assert_ptr_equal(raster->tile_first, held.tile_first);
        assert_ptr_equal(raster->keys, held.keys);
        assert_ptr_equal(raster->swap, held.swap);
        assert_ptr_equal(raster->order, held.order);
        assert_ptr_equal(raster->slots, held.slots);
        assert_ptr_equal(raster->touched, held.touched);
    }
    ffp_gbuffer_free(&out);
    ffp_gbuffer_free(&weights);
    ffp_gaussians_free(&grad);
    ffp_gaussians_free(&g);
    ffp_raster_free(raster);
}

// Splats that no camera should see, and ones at the edge of what numbers can hold: nothing may become
// infinite.
static void test_hostile_gaussians(void **state) {
    (void)state;
    FfpGaussians g = random_gaussians(64, 51, 0.5, 0.01, 0.1, 0.3, 1);
    const FfpCamera camera = look_at(35, 27, 40, eye, origin);
    for (int64_t i = 0; i < g.count; i++) {
        real *centre = g.centre + 3 * i, *scale = g.scale + 3 * i;
        for (int k = 0; k < 3; k++) {
            if (i % 8 == 0) centre[k] = eye[k] * 2;              // behind the camera
            if (i % 8 == 1) centre[k] = eye[k];                  // in it
            if (i % 8 == 2) scale[k] = i % 16 == 2 ? 0 : 1e-20F; // no size
            if (i % 8 == 3) scale[k] = i % 16 == 3 ? 1e30F : 50; // all the world
            if (i % 8 == 4) centre[k] = k == 0 ? 1e20F : -1e30F; // nowhere near
        }
        for (int k = 0; k < 4; k++)
            if (i % 8 == 5) g.rotation[4 * i + k] = 0;
        if (i % 8 == 6) g.opacity[i] = 0;
        if (i % 8 == 7) scale[i / 8 % 3] = 0; // a flat disk, its edge to the camera now and then
    }
    int64_t count;
    real *all = everything(&g, &camera, &count);
    for (int64_t i = 0; i < count; i++) assert_true(isfinite(all[i]));
    ffp_free(all);
    FfpGaussians none = ffp_gaussians_new(0);
    all = everything(&none, &camera, &count);
    for (int64_t i = 0; i < count; i++) assert_true(all[i] == 0);
    ffp_free(all);
    ffp_gaussians_free(&none);
    ffp_gaussians_free(&g);
}

// A wall through the origin as a G-buffer, seen by a camera; normal n.
static FfpGbuffer wall(const FfpCamera *camera, const real n[3], real albedo, real roughness) {
    FfpGbuffer g = ffp_gbuffer_new(camera->width, camera->height);
    for (int p = 0; p < camera->width * camera->height; p++) {
        const int x = p % camera->width, y = p / camera->width;
        const real ray[3] = {((real)x + 0.5F - camera->cx) / camera->fx,
                             ((real)y + 0.5F - camera->cy) / camera->fy, 1};
        real d[3];
        const real at[3] = {camera->pose[3], camera->pose[7], camera->pose[11]};
        ffp_rotate(camera->pose, ray, d);
        g.opacity[p] = 1;
        g.depth[p] = -ffp_dot3(at, n) / ffp_dot3(d, n);
        g.roughness[p] = roughness;
        for (int k = 0; k < 3; k++) g.normal[3 * p + k] = n[k], g.albedo[3 * p + k] = albedo;
    }
    return g;
}

static FfpImage plain_pattern(int width, int height) {
    FfpImage white = ffp_image_new(width, height, 3);
    for (int i = 0; i < 3 * width * height; i++) white.data[i] = 1;
    return white;
}

// The wall's own light: A/pi I/d^2 cos, by the difference between two albedos; the highlight by its formula
// in double.
static void test_wall_energy(void **state) {
    (void)state;
    const real at[3] = {0, -3, 0}, lamp[3] = {0.9F, -1.9F, 0.4F}, n[3] = {0, -1, 0}, intensity[3] = {3, 5, 8};
    const FfpCamera camera = look_at(21, 15, 30, at, origin), projector = look_at(200, 200, 90, lamp, origin);
    FfpGbuffer light = wall(&camera, n, 0.6F, 0.4F), dark = wall(&camera, n, 0, 0.4F);
    FfpMapping mapping = ffp_mapping_new(21, 15);
    FfpRenderSettings settings = ffp_render_defaults();
    settings.shadows = false;
    FfpImage white = plain_pattern(200, 200), a = ffp_image_new(21, 15, 3), b = ffp_image_new(21, 15, 3);
    FfpSummed pattern = ffp_summed_new(&white);
    FfpGaussians none = ffp_gaussians_new(0);
    ffp_map_to_projector(NULL, &none, &light, &camera, &projector, &settings, &mapping);
    ffp_shade_once(&light, &mapping, &camera, &projector, intensity, &pattern, &a);
    ffp_shade_once(&dark, &mapping, &camera, &projector, intensity, &pattern, &b);
    for (int p = 0; p < 21 * 15; p++) {
        const int x = p % 21, y = p / 21;
        const double z = 3, X = (x + 0.5 - 10.5) / 30 * z, Z = -(y + 0.5 - 7.5) / 30 * z;
        double l[3] = {(double)lamp[0] - X, (double)lamp[1], (double)lamp[2] - Z}, v[3] = {-X, -3, -Z}, h[3];
        const double dd = l[0] * l[0] + l[1] * l[1] + l[2] * l[2], d = sqrt(dd), e = sqrt(X * X + 9 + Z * Z);
        for (int k = 0; k < 3; k++) l[k] /= d, v[k] /= e, h[k] = l[k] + v[k];
        const double hl = sqrt(h[0] * h[0] + h[1] * h[1] + h[2] * h[2]);
        const double nl = -l[1], nv = -v[1], nh = -h[1] / hl,
                     vh = (v[0] * h[0] + v[1] * h[1] + v[2] * h[2]) / hl;
        const double a2 = pow(0.4, 4), k2 = 1.4 * 1.4 / 8, q = nh * nh * (a2 - 1) + 1;
        const double D = a2 / (PI * q * q), F = 0.04 + 0.96 * pow(2, (-5.55473 * vh - 6.98316) * vh);
        const double V = 1 / (4 * (nv * (1 - k2) + k2) * (nl * (1 - k2) + k2));
        for (int k = 0; k < 3; k++) {
            const double reaching = (double)intensity[k] / dd * nl;
            assert_float_equal(a.data[3 * p + k] - b.data[3 * p + k], 0.6 / PI * reaching, 2e-5 * reaching);
            assert_float_equal(b.data[3 * p + k], D * F * V * reaching, 2e-4 * D * F * V * reaching);
        }
    }
    ffp_gaussians_free(&none);
    ffp_summed_free(&pattern);
    ffp_image_free(&white);
    ffp_image_free(&a);
    ffp_image_free(&b);
    ffp_mapping_free(&mapping);
    ffp_gbuffer_free(&light);
    ffp_gbuffer_free(&dark);
}

// Where the normal is the half vector, a rounded cosine is 1 give or take a bit. D is then 1 / (pi rho^4), or
// less by what the last bits of the cosine can do: never infinite.
static void test_highlight_at_its_peak(void **state) {
    (void)state;
    static const real roughness[4] = {FFP_ROUGHNESS_MIN, 0.03F, 0.1F, 0.5F};
    FfpRng rng = ffp_rng(12, 4);
    for (int i = 0; i < 4000; i++) {
        real n[3] = {(real)ffp_rng_normal(&rng), (real)ffp_rng_normal(&rng), (real)ffp_rng_normal(&rng)};
        ffp_normalise3(n);
        const double a2 = pow((double)roughness[i % 4], 4), peak = 1 / (PI * a2), bit = 8e-7;
        const FfpLobe lobe = ffp_lobe(roughness[i % 4], 0.8F, 0.8F, ffp_dot3(n, n), 0.8F);
        assert_true((double)lobe.D <= peak * 1.0001);
        assert_true((double)lobe.D >= peak * pow(a2 / (a2 + bit), 2) * 0.9999);
    }
}

// A mirror that faces half way between eye and lamp in every pixel, under a pattern that is black but for a
// frame: no level's picture or gradient holds infinity or 0 times infinity.
static void test_mirror_under_black(void **state) {
    (void)state;
    enum { W = 33, H = 21, PIXELS = W * H };
    const real at[3] = {0, -3, 0}, lamp[3] = {0.9F, -1.9F, 0.4F}, n[3] = {0, -1, 0}, intensity[3] = {3, 5, 8};
    const FfpCamera camera = look_at(W, H, 30, at, origin), projector = look_at(200, 200, 90, lamp, origin);
    FfpGbuffer g = wall(&camera, n, 0.5F, 0);
    for (int p = 0; p < PIXELS; p++) {
        real point[3], v[3], l[3], *h = g.normal + 3 * (ptrdiff_t)p;
        ffp_surface_point(&camera, (real)(p % W) + 0.5F, (real)(p / W) + 0.5F, g.depth[p], point, v);
        for (int k = 0; k < 3; k++) v[k] = at[k] - point[k], l[k] = lamp[k] - point[k];
        ffp_normalise3(v), ffp_normalise3(l);
        for (int k = 0; k < 3; k++) h[k] = v[k] + l[k];
        ffp_normalise3(h);
    }
    FfpRenderSettings settings = ffp_render_defaults();
    settings.shadows = settings.footprint = false;
    FfpImage dark = ffp_image_new(200, 200, 3), out = ffp_image_new(W, H, 3), d = plain_pattern(W, H);
    dark.data[0] = 1;
    int lit = 0;
    FfpSummed pattern = ffp_summed_new(&dark);
    const FfpCpuLevel used = ffp_cpu_level();
    for (int level = 0; level <= (int)ffp_cpu_best(); level++) {
        assert_true(ffp_cpu_set_level((FfpCpuLevel)level));
        FfpMapping mapping = ffp_mapping_new(W, H);
        FfpTransport light = ffp_transport_new(W, H), d_light = ffp_transport_new(W, H);
        FfpGbuffer grad = ffp_gbuffer_new(W, H);
        ffp_map_with_shadow(&(FfpGbuffer){0}, &g, &camera, &projector, &settings, &mapping);
        ffp_light(&g, &mapping, &camera, &projector, &light);
        ffp_shade(&g, &mapping, &light, intensity, &pattern, &out);
        ffp_shade_backward(&mapping, &light, intensity, &pattern, &d, &grad, &d_light, NULL, NULL);
        for (int i = 0; i < 3 * PIXELS; i++) d_light.factor[i] = 1; // under black the pattern takes it away
        ffp_light_backward(&g, &mapping, &camera, &projector, &d_light, &grad);
        for (int i = 0; i < 3 * PIXELS; i++) {
            assert_true(isfinite(light.factor[i]) && out.data[i] == 0);
            lit += light.factor[i] > 100; // hundreds: the peak
            assert_true(isfinite(grad.normal[i]) && isfinite(grad.albedo[i]) && isfinite(grad.depth[i / 3]));
        }
        ffp_mapping_free(&mapping);
        ffp_transport_free(&light);
        ffp_transport_free(&d_light);
        ffp_gbuffer_free(&grad);
    }
    assert_true(lit > 27 * PIXELS / 10 * ((int)ffp_cpu_best() + 1));
    assert_true(ffp_cpu_set_level(used));
    ffp_summed_free(&pattern);
    ffp_image_free(&dark);
    ffp_image_free(&out);
    ffp_image_free(&d);
    ffp_gbuffer_free(&g);
}

// Camera and projector in one place, the projector four times as fine: pixel (x, y) is pattern pixel (4x, 4y)
// and covers 4 by 4 of them. A jump of depth halfway changes nothing, for the pixels beside it have
// neighbours on their own side.
static void test_mapping_footprint(void **state) {
    (void)state;
    const real at[3] = {0, -3, 0}, lamp[3] = {0.5F, -3, 0}, n[3] = {0, -1, 0};
    const FfpCamera camera = look_at(20, 12, 30, at, origin), same = look_at(80, 48, 120, at, origin);
    FfpCamera beside = look_at(80, 48, 120, lamp, (const real[3]){0.5F, 0, 0});
    FfpGbuffer g = wall(&camera, n, 0.5F, 0.5F);
    FfpMapping mapping = ffp_mapping_new(20, 12);
    FfpGaussians none = ffp_gaussians_new(0);
    FfpRenderSettings settings = ffp_render_defaults();
    settings.shadows = false;
    for (int p = 0; p < 240; p++)
        if (p % 20 >= 10) g.depth[p] = 2.5F;
    ffp_map_to_projector(NULL, &none, &g, &camera, &same, &settings, &mapping);
    for (int p = 0; p < 240; p++) {
        const int x = p % 20, y = p / 20;
        assert_float_equal(mapping.uv[2 * p], 4 * (x + 0.5), 1e-3);
        assert_float_equal(mapping.uv[2 * p + 1], 4 * (y + 0.5), 1e-3);
        assert_float_equal(mapping.extent[2 * p], 4, 1e-3);
        assert_float_equal(mapping.extent[2 * p + 1], 4, 1e-3);
        assert_true(mapping.visibility[p] == 1);
    }
    ffp_map_to_projector(NULL, &none, &g, &camera, &beside, &settings, &mapping);
    int outside = 0;
    for (int p = 0; p < 240; p++) {
        outside += mapping.visibility[p] == 0;
        if (mapping.visibility[p] > 0) assert_float_equal(mapping.extent[2 * p], 4, 1e-3);
    }
    // Half a unit aside: a part of the wall lies beyond the pattern.
    assert_true(outside > 20 && outside < 200);
    settings.footprint = false;
    ffp_map_to_projector(NULL, &none, &g, &camera, &same, &settings, &mapping);
    for (int i = 0; i < 480; i++) assert_true(mapping.extent[i] == 1);
    ffp_gaussians_free(&none);
    ffp_mapping_free(&mapping);
    ffp_gbuffer_free(&g);
}

// --- Pictures of more than 2^31 numbers. ---

// Zeros that take memory only where they are touched; NULL where there is no room even for their addresses.
static real *far_plane(size_t numbers) {
    const int flags = MAP_PRIVATE | MAP_ANONYMOUS | MAP_NORESERVE;
    void *at = mmap(NULL, numbers * sizeof(real), PROT_READ | PROT_WRITE, flags, -1, 0);
    return at == MAP_FAILED ? NULL : at;
}

// The buffers of a row's test, pictures [height,width].
typedef struct RowCase {
    FfpCamera camera;
    FfpGbuffer g, d_g;
    FfpMapping mapping;
    FfpTransport light, d_light;
    FfpImage out;
} RowCase;

static bool row_case(RowCase *c, int width, int height) {
    const size_t n = (size_t)width * (size_t)height;
    real *planes[19];
    static const int sizes[19] = {1, 1, 3, 3, 1, 3, 2, 2, 1, 3, 2, 3, 2, 3, 1, 1, 3, 3, 1};
    for (int k = 0; k < 19; k++)
        if (!(planes[k] = far_plane(n * (size_t)sizes[k]))) return false;
    *c = (RowCase){.camera = {width, height, 20000, 20000, (real)width / 2, (real)height - 2, {0}},
                   .g = {.width = width,
                         .height = height,
                         .opacity = planes[0],
                         .depth = planes[1],
                         .normal = planes[2],
                         .albedo = planes[3],
                         .roughness = planes[4],
                         .ambient = planes[5]},
                   .mapping = {width, height, planes[6], planes[7], 0, {0}, planes[8]},
                   .light = {.width = width, .height = height, .factor = planes[9], .uv = planes[10]},
                   .d_light = {.width = width, .height = height, .factor = planes[11], .uv = planes[12]},
                   .out = {width, height, 3, planes[13]},
                   .d_g = {.width = width,
                           .height = height,
                           .opacity = planes[14],
                           .depth = planes[15],
                           .normal = planes[16],
                           .albedo = planes[17],
                           .roughness = planes[18],
                           .ambient = planes[5]}};
    for (int k = 0; k < 4; k++) c->camera.pose[5 * k] = 1;
    return true;
}

static void row_case_free(RowCase *c) {
    const size_t n = (size_t)c->g.width * (size_t)c->g.height * sizeof(real);
    munmap(c->g.opacity, n), munmap(c->g.depth, n), munmap(c->g.normal, 3 * n), munmap(c->g.albedo, 3 * n);
    munmap(c->g.roughness, n), munmap(c->g.ambient, 3 * n), munmap(c->mapping.uv, 2 * n);
    munmap(c->mapping.extent, 2 * n), munmap(c->mapping.visibility, n), munmap(c->light.factor, 3 * n);
    munmap(c->light.uv, 2 * n), munmap(c->d_light.factor, 3 * n), munmap(c->d_light.uv, 2 * n);
    munmap(c->out.data, 3 * n), munmap(c->d_g.opacity, n), munmap(c->d_g.depth, n);
    munmap(c->d_g.normal, 3 * n), munmap(c->d_g.albedo, 3 * n), munmap(c->d_g.roughness, n);
}

// The last row of the picture: a wall, mapped, lit, shaded and back.
static void through_last_row(RowCase *c, const FfpCamera *projector, const FfpSummed *pattern) {
    const int y = c->g.height - 1, width = c->g.width;
    const size_t row = (size_t)y * (size_t)width;
    const real intensity[3] = {3, 5, 8};
    const FfpRenderSettings settings = ffp_render_defaults();
    const FfpRenderKernels *kernels = ffp_render_kernels();
    for (size_t p = row; p < row + (size_t)width; p++) {
        c->g.opacity[p] = 1, c->g.depth[p] = 3, c->g.roughness[p] = 0.5F;
        c->g.normal[3 * p + 2] = -1;
        for (size_t k = 0; k < 3; k++) c->g.albedo[3 * p + k] = 0.5F, c->d_light.factor[3 * p + k] = 0.2F;
    }
    const FfpMapper mapper = {&c->g, &c->camera, projector, &settings, {0}};
    const FfpLitScene scene = {&c->g, &c->mapping, {&c->camera, projector, 0}};
    const FfpPatternLight light = {&c->light, c->mapping.extent, intensity, pattern, 1, {0}};
    const FfpShadeGrad grad = {&c->out, c->d_g.ambient, NULL, &c->d_light, NULL};
    real grad_intensity[3] = {0, 0, 0};
    kernels->map_row(&mapper, y, &c->mapping);
    kernels->light_row(&scene, y, &c->light);
    kernels->shade_row(&light, y, &c->g, &c->out);
    kernels->shade_row_backward(&light, y, &grad, grad_intensity);
    kernels->light_row_backward(&scene, y, &c->d_light, &c->d_g);
}

// The last row of 720 million samples is that of a picture of its own.
static void test_rows_of_large_pictures(void **state) {
    (void)state;
    enum { WIDTH = 30000, HEIGHT = 24000 };
    RowCase large, small;
    if (!row_case(&large, WIDTH, HEIGHT)) {
        print_message("skipped: no addresses for a picture of 720 million samples\n");
        return;
    }
    assert_true(row_case(&small, WIDTH, 1));
    small.camera.cy = large.camera.cy - (HEIGHT - 1);
    FfpImage plain = ffp_image_new(64, 64, 3);
    for (int i = 0; i < 3 * 64 * 64; i++) plain.data[i] = 0.5F + 0.4F * (real)sin(i);
    FfpSummed pattern = ffp_summed_new(&plain);
    const FfpCamera projector = {64, 64, 40, 40, 32, 32, {1, 0, 0, 0.5F, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1}};
    through_last_row(&large, &projector, &pattern);
    through_last_row(&small, &projector, &pattern);
    const size_t row = (size_t)(HEIGHT - 1) * WIDTH, bytes = WIDTH * sizeof(real);
    assert_true(small.out.data[3 * (WIDTH / 2)] > 0 && small.d_g.albedo[3 * (WIDTH / 2)] != 0);
    assert_memory_equal(large.mapping.uv + 2 * row, small.mapping.uv, 2 * bytes);
    assert_memory_equal(large.light.factor + 3 * row, small.light.factor, 3 * bytes);
    assert_memory_equal(large.out.data + 3 * row, small.out.data, 3 * bytes);
    assert_memory_equal(large.d_light.uv + 2 * row, small.d_light.uv, 2 * bytes);
    assert_memory_equal(large.d_g.normal + 3 * row, small.d_g.normal, 3 * bytes);
    assert_memory_equal(large.d_g.depth + row, small.d_g.depth, bytes);
    row_case_free(&large), row_case_free(&small);
    ffp_summed_free(&pattern);
    ffp_image_free(&plain);
}

// A square patch of flat splats around `centre`, in the plane y = const.
static void lay_patch(FfpGaussians *g, int64_t first, int side, real half, const real centre[3]) {
    for (int i = 0; i < side * side; i++) {
        const int64_t s = first + i;
        const int column = i % side, row = i / side;
        const real step = 2 * half / (real)side;
        g->centre[3 * s] = centre[0] - half + step * ((real)column + 0.5F);
        g->centre[3 * s + 1] = centre[1];
        g->centre[3 * s + 2] = centre[2] - half + step * ((real)row + 0.5F);
        g->scale[3 * s] = g->scale[3 * s + 2] = step * 0.7F, g->scale[3 * s + 1] = step * 0.07F;
        g->rotation[4 * s] = 1, g->opacity[s] = 0.95F, g->roughness[s] = 0.5F;
        for (int k = 0; k < 3; k++) g->albedo[3 * s + k] = 0.5F;
    }
}

// A small patch floats before a wall, out of the camera's line but in the projector's: its shadow falls where
// it must.
static void test_shadow(void **state) {
    (void)state;
    const real at[3] = {0, -3, 0}, lamp[3] = {-2, -2, 0}, half_way[3] = {-1, -1, 0};
    const FfpCamera camera = look_at(64, 64, 90, at, origin),
                    projector = look_at(300, 200, 200, lamp, origin);
    FfpGaussians g = ffp_gaussians_new(80 * 80 + 100);
    lay_patch(&g, 0, 80, 1.2F, origin);
    lay_patch(&g, 80 * 80, 10, 0.1F,
              half_way); // seen from the lamp twice as large at the wall: 0.4 wide, at the origin
    FfpRaster *raster = ffp_raster_new();
    FfpGbuffer out = ffp_gbuffer_new(64, 64);
    FfpMapping mapping = ffp_mapping_new(64, 64);
    FfpRenderSettings settings = ffp_render_defaults();
    ffp_rasterise(raster, &g, &camera, &settings, &out);
    ffp_map_to_projector(raster, &g, &out, &camera, &projector, &settings, &mapping);
    int dark = 0, lit = 0;
    for (int p = 0; p < 64 * 64; p++) {
        const int column = p % 64, row = p / 64;
        const real x = ((real)column - 31.5F) / 30, z = ((real)row - 31.5F) / 30;
        if (x < -0.7F) continue; // the patch itself is there in the picture
        if (fabsf(x) < 0.12F && fabsf(z) < 0.12F) {
            dark++;
            assert_true(mapping.visibility[p] < 0.15F);
        }
        if ((fabsf(x) > 0.35F || fabsf(z) > 0.35F) && fabsf(z) < 0.8F && x < 0.8F) {
            lit++;
            assert_true(mapping.visibility[p] > 0.98F);
        }
    }
    assert_true(dark > 30 && lit > 500);
    g.baked = (FfpBakedShadows){{lamp[0], lamp[1] + 0.2F, lamp[2]}, 0.1F}; // another lamp's
    ffp_map_to_projector(raster, &g, &out, &camera, &projector, &settings, &mapping);
    assert_true(mapping.visibility[32 * 64 + 32] < 0.15F);
    g.baked.light[1] = lamp[1];
    ffp_map_to_projector(raster, &g, &out, &camera, &projector, &settings, &mapping);
    assert_true(mapping.visibility[32 * 64 + 32] == 1);
    g.baked.within = 0;
    settings.shadows = false;
    ffp_map_to_projector(raster, &g, &out, &camera, &projector, &settings, &mapping);
    assert_true(mapping.visibility[32 * 64 + 32] == 1);
    ffp_gbuffer_free(&out);
    ffp_mapping_free(&mapping);
    ffp_gaussians_free(&g);
    ffp_raster_free(raster);
}

// A patch of splats, relit: linear radiance as the wall's formula says, encoded; black outside it.
static void test_render_view(void **state) {
    (void)state;
    const real at[3] = {0, -3, 0}, lamp[3] = {0.3F, -2, 0.2F}, intensity[3] = {4, 4, 4};
    const FfpCamera camera = look_at(48, 40, 50, at, origin), projector = look_at(100, 100, 60, lamp, origin);
    FfpGaussians g = ffp_gaussians_new(60 * 60);
    lay_patch(&g, 0, 60, 0.9F, origin);
    FfpImage white = plain_pattern(100, 100);
    FfpSummed pattern = ffp_summed_new(&white);
    const FfpRenderSettings settings = ffp_render_defaults();
    FfpImage lit = ffp_render_view(&g, &camera, &projector, intensity, &pattern, &settings);
    FfpImage black = ffp_render_view(&g, &camera, &projector, intensity, NULL, &settings);
    // At the patch's middle: normal and view (0, -1, 0), light from the lamp; A = 0.5, roughness 0.5.
    const double dd = 0.3 * 0.3 + 4 + 0.2 * 0.2, nl = 2 / sqrt(dd), hn = sqrt((1 + nl) / 2),
                 k = 1.5 * 1.5 / 8;
    const double a2 = 0.25 * 0.25, round = hn * hn * (a2 - 1) + 1, D = a2 / (PI * round * round);
    const double F = 0.04 + 0.96 * pow(2, (-5.55473 * hn - 6.98316) * hn), vis = 1 / (4 * (nl * (1 - k) + k));
    const double expected = (0.5 / PI + D * F * vis) * 4 / dd * nl;
    const double seen = (double)ffp_srgb_decode(lit.data[3 * (20 * 48 + 24)]);
    print_message("seen %g, expected %g\n", seen, expected);
    assert_true(fabs(seen / expected - 1) < 0.02); // the splats' opacity and shared normals
    assert_true(lit.data[0] == 0 && lit.data[3 * (40 * 48 - 1)] == 0);
    for (int i = 0; i < 3 * 48 * 40; i++) assert_true(black.data[i] == 0);
    ffp_image_free(&lit);
    ffp_image_free(&black);
    ffp_image_free(&white);
    ffp_summed_free(&pattern);
    ffp_gaussians_free(&g);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_brute_force),
        cmocka_unit_test(test_principal_point_outside),
        cmocka_unit_test(test_same_bits),
        cmocka_unit_test(test_hostile_gaussians),
        cmocka_unit_test(test_highlight_at_its_peak),
        cmocka_unit_test(test_mirror_under_black),
        cmocka_unit_test(test_rows_of_large_pictures),
        cmocka_unit_test(test_wall_energy),
        cmocka_unit_test(test_mapping_footprint),
        cmocka_unit_test(test_shadow),
        cmocka_unit_test(test_levels_agree),
        cmocka_unit_test(test_no_more_memory),
        cmocka_unit_test(test_render_view),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
