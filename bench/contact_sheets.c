// Pictures and figures of the generator's meshes and materials, for docs/:
//   contact_sheets meshes FILE.png      every mesh, grey, under the default rig's lamp
//   contact_sheets materials FILE.png   every material on a ball, in the colours of two seeds
//   contact_sheets patterns FILE.png    the natural patterns of the test scenes
//   contact_sheets figures              the table of docs/design/data.md
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include "core/base/alloc.h"
#include "core/base/rng.h"
#include "world/shapes/mesh.h"
#include "world/shapes/mesh_measure.h"
#include "world/synth/material.h"
#include "world/synth/natural.h"
#include "world/synth/rig.h"
#include "world/synth/simulate.h"
#include "world/synth/stroke.h"
#include "world/synth/synth.h"
#include "world/synth/trace.h"

enum { LABEL = 12 };

typedef struct Sheet {
    FfpImage image; // sRGB-encoded
    int columns, cell_width, cell_height, next;
} Sheet;

static Sheet sheet_new(int columns, int rows, int width, int height, int channels) {
    const FfpImage image = ffp_image_new(columns * width, rows * (height + LABEL), channels);
    return (Sheet){image, columns, width, height + LABEL, 0};
}

static void corner(const Sheet *s, int index, int *x, int *y) {
    *x = index % s->columns * s->cell_width;
    *y = index / s->columns * s->cell_height;
}

// A picture (linear) into the current cell, `left` pixels from its edge, on a dark ground.
static void paste(Sheet *s, const FfpImage *picture, const FfpImage *coverage, int left) {
    int x, y;
    corner(s, s->next, &x, &y);
    const size_t channels = (size_t)s->image.channels, row = (size_t)s->image.width;
    for (int j = 0; j < picture->height; j++)
        for (int i = 0; i < picture->width; i++) {
            const size_t from = (size_t)j * (size_t)picture->width + (size_t)i;
            const size_t to = (size_t)(y + j) * row + (size_t)(x + left + i);
            const real ground = coverage ? (1 - coverage->data[from]) * (real)0.02 : 0;
            for (size_t c = 0; c < channels; c++)
                s->image.data[channels * to + c] = ffp_srgb_encode(picture->data[3 * from + c] + ground);
        }
}

static void label(Sheet *s, const char *text) {
    int x, y;
    corner(s, s->next++, &x, &y);
    const FfpPen pen = {&s->image, 1, {1, 1, 1}};
    const float at[2] = {(float)x + 3.5F, (float)(y + s->cell_height - LABEL) + 2.5F};
    ffp_stroke_text(&pen, at, 6, 0, text);
}

static bool finish(Sheet *s, const char *path, FfpError *err) {
    const bool ok = ffp_image_write_png(&s->image, path, err);
    ffp_image_free(&s->image);
    return ok;
}

// Seen a little from above and lit from a side, so that reliefs and openings show: a new pose of the default
// rig.
static bool picture(const FfpMesh *mesh, const FfpMaterial *material, int side, FfpView *view,
                    FfpError *err) {
    FfpTracer *tracer = ffp_tracer_new(mesh, err);
    if (!tracer) return false;
    FfpSceneSpec spec = ffp_scene_defaults();
    spec.resolution = side;
    spec.seed = 58; // camera 64 degrees from the pole, projector 55, and 35 to a side
    FfpImage white = ffp_image_new(spec.pattern_side, spec.pattern_side, 3);
    for (size_t i = 0; i < (size_t)white.width * (size_t)white.height * 3; i++) white.data[i] = 1;
    FfpLight light = ffp_light_new((const FfpImage *[]){&white}, 1);
    const FfpRigLight rig = ffp_rig_light(&spec);
    const FfpSimulation simulation = {.tracer = tracer,
                                      .mesh = mesh,
                                      .material = material,
                                      .light = &light,
                                      .intensity = {rig.intensity[0], rig.intensity[1], rig.intensity[2]},
                                      .ambient = rig.ambient,
                                      .samples = 9,
                                      .ambient_rays = 2};
    *view = (FfpView){0};
    ffp_rig_target(&spec, 0, view);
    ffp_simulate_view(&simulation, view, 0, NULL);
    ffp_light_free(&light);
    ffp_image_free(&white);
    ffp_tracer_free(tracer);
    return true;
}

static void free_view(FfpView *view) {
    FfpImage *const images[] = {&view->images[0], &view->coverage,  &view->depth,       &view->normal,
                                &view->albedo,    &view->roughness, &view->direct_white};
    for (size_t i = 0; i < sizeof images / sizeof images[0]; i++) ffp_image_free(images[i]);
    ffp_free(view->images);
}

static bool mesh_sheet(const char *path, FfpError *err) {
    enum { SIDE = 112, COLUMNS = 15 };
    Sheet s = sheet_new(COLUMNS, (ffp_mesh_count() + COLUMNS - 1) / COLUMNS, SIDE, SIDE, 1);
    FfpMaterial grey = {.rough = {0.8F, 0.8F}, .scale = 1, .axes = {1, 0, 0, 0, 1, 0, 0, 0, 1}};
    for (int i = 0; i < FFP_PALETTE; i++)
        for (int c = 0; c < 3; c++) grey.colour[i][c] = 0.6F;
    for (int m = 0; m < ffp_mesh_count(); m++) {
        FfpMesh mesh = ffp_mesh_make(m);
        FfpView view;
        const bool ok = picture(&mesh, &grey, SIDE, &view, err);
        ffp_mesh_free(&mesh);
        if (!ok) return false;
        paste(&s, &view.images[0], &view.coverage, 0);
        label(&s, ffp_mesh_name(m));
        free_view(&view);
    }
    return finish(&s, path, err);
}

static FfpMesh ball(void) {
    FfpShape *shape = ffp_alloc(sizeof *shape, 1);
    if (!shape) abort();
    ffp_shape_init(shape, 1);
    ffp_add_ellipsoid(shape, ffp_v3(0, 0, 0), ffp_v3(1, 1, 1), 0);
    FfpMesh mesh = ffp_mesh_from_shape(shape);
    ffp_free(shape);
    const float upright[9] = {1, 0, 0, 0, 1, 0, 0, 0, 1};
    ffp_mesh_place(&mesh, upright);
    return mesh;
}

static bool material_sheet(const char *path, FfpError *err) {
    enum { SIDE = 104, COLUMNS = 9, SEEDS = 2 };
    Sheet s = sheet_new(COLUMNS, (ffp_material_count() + COLUMNS - 1) / COLUMNS, SEEDS * SIDE, SIDE, 3);
    FfpMesh mesh = ball();
    bool ok = true;
    for (int m = 0; m < ffp_material_count() && ok; m++) {
        for (int seed = 0; seed < SEEDS && ok; seed++) {
            const FfpMaterial material = ffp_material_make(m, (uint64_t)seed + 1);
            FfpView view;
            ok = picture(&mesh, &material, SIDE, &view, err);
            if (!ok) break;
            paste(&s, &view.images[0], &view.coverage, seed * SIDE);
            free_view(&view);
        }
        label(&s, ffp_material_name(m));
    }
    ffp_mesh_free(&mesh);
    if (ok) return finish(&s, path, err);
    ffp_image_free(&s.image);
    return false;
}

static bool pattern_sheet(const char *path, FfpError *err) {
    enum { SIDE = 240 };
    Sheet s = sheet_new(FFP_NATURAL_KINDS, 2, SIDE, SIDE, 3);
    for (int i = 0; i < 2 * FFP_NATURAL_KINDS; i++) {
        FfpImage large = ffp_natural_pattern(800, 800, i, 5), small = ffp_image_resize(&large, SIDE, SIDE);
        paste(&s, &small, NULL, 0);
        label(&s, ffp_natural_name(i));
        ffp_image_free(&large);
        ffp_image_free(&small);
    }
    return finish(&s, path, err);
}

// --- Figures. ---

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

typedef struct Figure {
    const char *name;
    int count;
    double sum, least, most;
} Figure;

static void add(Figure *f, double value) {
    f->least = f->count ? fmin(f->least, value) : value;
    f->most = f->count ? fmax(f->most, value) : value;
    f->sum += value;
    f->count++;
}

static void print(const Figure *figures, int count) {
    for (int i = 0; i < count; i++)
        printf("| %s | %.2f | %.2f | %.2f |\n", figures[i].name, figures[i].sum / figures[i].count,
               figures[i].least, figures[i].most);
}

static bool mesh_figures(FfpError *err) {
    Figure f[3] = {{.name = "genus of the meshes"},
                   {.name = "share of the area facing the projector that lies in shadow"},
                   {.name = "thousands of triangles"}};
    for (int m = 0; m < ffp_mesh_count(); m++) {
        FfpMesh mesh = ffp_mesh_make(m);
        FfpTracer *tracer = ffp_tracer_new(&mesh, err);
        if (tracer) {
            int components = 0;
            add(&f[0], ffp_mesh_genus(&mesh, &components));
            add(&f[1], concavity(&mesh, tracer));
            add(&f[2], mesh.n_triangles / 1000.0);
        }
        ffp_tracer_free(tracer);
        ffp_mesh_free(&mesh);
        if (!tracer) return false;
    }
    print(f, 3);
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

static bool figures(FfpError *err) {
    enum { SEEDS = 8 };
    Figure f[4] = {{.name = "albedo of the materials (luminance, 8 seeds of each)"},
                   {.name = "its contrast (standard deviation over mean)"},
                   {.name = "saturation of the mean colour"},
                   {.name = "roughness"}};
    FfpRng rng = ffp_rng(1, 2);
    if (!mesh_figures(err)) return false;
    for (int m = 0; m < ffp_material_count(); m++)
        for (uint64_t seed = 0; seed < SEEDS; seed++) {
            const FfpMaterial material = ffp_material_make(m, seed);
            double values[4];
            measure(&material, &rng, values);
            for (int i = 0; i < 4; i++) add(&f[i], values[i]);
        }
    print(f, 4);
    return true;
}

int main(int argc, char **argv) {
    FfpError err = {0};
    bool ok = false;
    if (argc == 2 && !strcmp(argv[1], "figures"))
        ok = figures(&err);
    else if (argc == 3 && !strcmp(argv[1], "meshes"))
        ok = mesh_sheet(argv[2], &err);
    else if (argc == 3 && !strcmp(argv[1], "materials"))
        ok = material_sheet(argv[2], &err);
    else if (argc == 3 && !strcmp(argv[1], "patterns"))
        ok = pattern_sheet(argv[2], &err);
    else {
        fputs("usage: contact_sheets meshes|materials|patterns FILE.png\n       contact_sheets figures\n",
              stderr);
        return 2;
    }
    if (!ok) fprintf(stderr, "contact_sheets: error: %s\n", err.text);
    return ok ? 0 : 1;
}
