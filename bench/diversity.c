#include "bench/diversity.h"
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include "core/base/rng.h"
#include "world/shapes/mesh.h"
#include "world/shapes/mesh_measure.h"
#include "world/synth/material.h"
#include "world/synth/rig.h"
#include "world/synth/synth.h"
#include "world/synth/trace.h"

// Three corners and the normal of a triangle; returns twice its area.
static float triangle(const FfpMesh *mesh, int t, const float *corner[3], float normal[3]) {
    float e[2][3], square = 0;
    for (int k = 0; k < 3; k++) corner[k] = mesh->positions + 3 * (size_t)mesh->triangles[3 * t + k];
    for (int k = 0; k < 3; k++) e[0][k] = corner[1][k] - corner[0][k], e[1][k] = corner[2][k] - corner[0][k];
    for (int k = 0; k < 3; k++) {
        normal[k] = e[0][(k + 1) % 3] * e[1][(k + 2) % 3] - e[0][(k + 2) % 3] * e[1][(k + 1) % 3];
        square += normal[k] * normal[k];
    }
    const float length = sqrtf(square);
    for (int k = 0; k < 3 && length > 0; k++) normal[k] /= length;
    return length;
}

// The area that faces the projector of a stop of the default rig but lies in shadow, as a share of all that
// faces it; mean over the eight stops.
static double concavity(const FfpMesh *mesh, const FfpTracer *tracer) {
    const FfpSceneSpec spec = ffp_scene_defaults();
    double facing = 0, shadowed = 0;
    for (int stop = 0; stop < spec.views; stop++) {
        FfpView view = {0};
        ffp_rig_input(&spec, stop, &view);
        for (int t = 0; t < mesh->n_triangles; t++) {
            const float *corner[3];
            float normal[3], start[3], way[3], along = 0;
            const float area = triangle(mesh, t, corner, normal);
            for (int k = 0; k < 3; k++) {
                start[k] = (corner[0][k] + corner[1][k] + corner[2][k]) / 3 + 1e-3F * normal[k];
                way[k] = (float)view.projector.pose[4 * k + 3] - start[k];
                along += way[k] * normal[k];
            }
            if (along <= 0) continue;
            facing += (double)area;
            FfpRays ray = {.count = 0};
            ffp_rays_add(&ray, start, way);
            if (ffp_trace_blocked(tracer, &ray)) shadowed += (double)area;
        }
    }
    return facing > 0 ? shadowed / facing : 0;
}

typedef struct Histogram {
    const char *title;
    double low, step;
    int counts[12], bins, total;
    double sum, least, most;
} Histogram;

static Histogram histogram(const char *title, double low, double step, int bins) {
    return (Histogram){.title = title, .low = low, .step = step, .bins = bins, .least = 1e30, .most = -1e30};
}

static void count(Histogram *h, double value) {
    const int bin = (int)floor((value - h->low) / h->step);
    h->counts[bin < 0 ? 0 : bin >= h->bins ? h->bins - 1 : bin]++;
    h->total++;
    h->sum += value;
    h->least = fmin(h->least, value);
    h->most = fmax(h->most, value);
}

static void print(const Histogram *h, bool whole) {
    if (h->total == 0) return;
    printf("**%s**: mean %.2f, from %.2f to %.2f over %d\n\n| from | count | |\n|---|---|---|\n", h->title,
           h->sum / h->total, h->least, h->most, h->total);
    for (int i = 0; i < h->bins; i++) {
        const bool last = i == h->bins - 1;
        printf(whole ? "| %.0f%s | %d | " : "| %.2f%s | %d | ", h->low + i * h->step, last ? " and more" : "",
               h->counts[i]);
        for (int k = 0; k < (60 * h->counts[i] + h->total - 1) / h->total; k++) putchar('#');
        puts(" |");
    }
    putchar('\n');
}

static bool mesh_tables(FfpError *err) {
    Histogram holes = histogram("Genus of the meshes", 0, 1, 8);
    Histogram shadow = histogram("Share of the area facing the projector that lies in shadow", 0, 0.05, 10);
    Histogram size = histogram("Thousands of triangles", 0, 6, 11);
    for (int m = 0; m < ffp_mesh_count(); m++) {
        FfpMesh mesh = ffp_mesh_make(m);
        FfpTracer *tracer = ffp_tracer_new(&mesh, err);
        if (tracer) {
            int components = 0;
            count(&holes, ffp_mesh_genus(&mesh, &components));
            count(&shadow, concavity(&mesh, tracer));
            count(&size, mesh.n_triangles / 1000.0);
        }
        ffp_tracer_free(tracer);
        ffp_mesh_free(&mesh);
        if (!tracer) return false;
    }
    print(&holes, true);
    print(&shadow, false);
    print(&size, true);
    return true;
}

// Mean, contrast (standard deviation over mean of the luminance), saturation (of the mean colour) and
// roughness of one material over points of the unit ball.
static void measure(const FfpMaterial *material, FfpRng *rng, double out[4]) {
    enum { POINTS = 2000 };
    double sum = 0, square = 0, colour[3] = {0, 0, 0}, rough = 0;
    for (int i = 0; i < POINTS; i++) {
        float p[3], albedo[3], roughness;
        for (int k = 0; k < 3; k++) p[k] = ffp_rng_range(rng, -0.6F, 0.6F);
        ffp_material_look(material, p, albedo, &roughness);
        const double y = 0.2126 * (double)albedo[0] + 0.7152 * (double)albedo[1] + 0.0722 * (double)albedo[2];
        sum += y;
        square += y * y;
        rough += (double)roughness;
        for (int k = 0; k < 3; k++) colour[k] += (double)albedo[k];
    }
    const double mean = sum / POINTS, high = fmax(colour[0], fmax(colour[1], colour[2]));
    out[0] = mean;
    out[1] = sqrt(fmax(0, square / POINTS - mean * mean)) / mean;
    out[2] = 1 - fmin(colour[0], fmin(colour[1], colour[2])) / high;
    out[3] = rough / POINTS;
}

static void material_tables(void) {
    enum { SEEDS = 8 };
    Histogram h[4] = {histogram("Mean albedo (luminance)", 0, 0.1, 9),
                      histogram("Contrast of the albedo (standard deviation over mean)", 0, 0.1, 10),
                      histogram("Saturation of the mean colour (linear)", 0, 0.1, 10),
                      histogram("Mean roughness", 0.15, 0.1, 8)};
    FfpRng rng = ffp_rng(1, 2);
    for (int m = 0; m < ffp_material_count(); m++)
        for (uint64_t seed = 0; seed < SEEDS; seed++) {
            const FfpMaterial material = ffp_material_make(m, seed);
            double figures[4];
            measure(&material, &rng, figures);
            for (int i = 0; i < 4; i++) count(&h[i], figures[i]);
        }
    for (int i = 0; i < 4; i++) print(&h[i], false);
}

bool ffp_print_diversity(FfpError *err) {
    if (!mesh_tables(err)) return false;
    material_tables();
    return true;
}
