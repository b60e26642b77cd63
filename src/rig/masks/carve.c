#include "rig/masks/carve.h"
#include <string.h>
#include <tgmath.h>
#include "core/base/arena.h"
#include "core/base/call.h"
#include "core/base/rigid.h"
#include "rig/checks/chord.h"
#include "rig/masks/limits.h"

enum {
    SIDE = 112,       // voxels
    MAP = 160,        // cells of a projector's map
    SAMPLES = 160,    // along a ray
    BEHIND = 3,       // voxels that a point must lie behind what shadows it
    ROUNDS = 3,       // the hull's own shadows are known after the first
    STAGE_MOST = 2,   // as many views that show dim stage carve,
    THROUGH_MOST = 2, // as many cameras and projectors that see through a point,
    UNLIT_MOST = 2    // and so many more views that show a point unlit, in no shadow, than that show object
};

// --- The sphere. ---

// Adds I - d d^T and its product with the point that the ray of direction d begins at.
static void add_ray(double a[3][3], double b[3], const real origin[3], const real d[3]) {
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++) {
            const double m = (i == j) - (double)d[i] * (double)d[j];
            a[i][j] += m, b[i] += m * (double)origin[j];
        }
}

// Cramer's rule; false when it is singular.
static bool solve(const double a[3][3], const double b[3], double x[3]) {
    double c[3][3];
    for (int i = 0; i < 3; i++) ffp_cross(a[(i + 1) % 3], a[(i + 2) % 3], c[i]);
    const double det = ffp_dot(a[0], c[0]), trace = a[0][0] + a[1][1] + a[2][2];
    for (int i = 0; i < 3; i++) x[i] = (c[0][i] * b[0] + c[1][i] * b[1] + c[2][i] * b[2]) / det;
    return det > 1e-9 * trace * trace * trace;
}

static void origin_of(const FfpCamera *camera, real origin[3]) {
    for (int i = 0; i < 3; i++) origin[i] = camera->pose[4 * i + 3];
}

// The middle of what a view shows as object; false when it shows none.
static bool middle_of(const FfpView *view, const FfpCompared *compared, real direction[3]) {
    const int width = view->camera.width, height = view->camera.height;
    double n = 0, x = 0, y = 0;
    for (int i = 0; i < width * height; i++) {
        if (compared->kinds[i] != FFP_PIXEL_OBJECT) continue;
        n++, x += i % width + 0.5, y += i / width + 0.5;
    }
    if (!(n > 0)) return false;
    ffp_pixel_ray(&view->camera, (real)(x / n), (real)(y / n), direction);
    return true;
}

// The largest distance between the sphere's middle and the ray of an object's pixel.
static double reach_of(const FfpView *view, const FfpCompared *compared, const double centre[3]) {
    const int width = view->camera.width, height = view->camera.height;
    double worst = 0, to[3], across[3], ray[3];
    real origin[3], d[3];
    origin_of(&view->camera, origin);
    for (int k = 0; k < 3; k++) to[k] = centre[k] - (double)origin[k];
    for (int i = 0; i < width * height; i++) {
        if (compared->kinds[i] != FFP_PIXEL_OBJECT) continue;
        ffp_pixel_ray(&view->camera, (real)(i % width) + 0.5F, (real)(i / width) + 0.5F, d);
        for (int k = 0; k < 3; k++) ray[k] = (double)d[k];
        ffp_cross(to, ray, across);
        worst = fmax(worst, ffp_dot(across, across));
    }
    return sqrt(worst);
}

bool ffp_hull_bounds(FfpCapture *capture, const FfpCompared *compared) {
    double a[3][3] = {{0}}, b[3] = {0}, centre[3], radius = 0;
    int views = 0;
    for (int v = 0; v < capture->n_views; v++) {
        real origin[3], direction[3] = {0};
        if (!middle_of(&capture->views[v], &compared[v], direction)) continue;
        origin_of(&capture->views[v].camera, origin);
        add_ray(a, b, origin, direction);
        views++;
    }
    if (views == 0) return false;
    if (!solve(a, b, centre)) return false;
    for (int v = 0; v < capture->n_views; v++)
        radius = fmax(radius, reach_of(&capture->views[v], &compared[v], centre));
    for (int k = 0; k < 3; k++) capture->centre[k] = (real)centre[k];
    capture->radius = (real)(REACH * radius);
    return radius > 0;
}

// --- The voxels. ---

typedef struct Evidence { // of the views about a point
    int seen, object, stage, through, unlit;
} Evidence;

// True if a pixel and the eight around it are lit stage: outlines are known to a pixel.
static bool is_stage(const FfpView *view, const unsigned char *kinds, int x, int y) {
    for (int k = 0; k < 9; k++) {
        const int px = x + k % 3 - 1, py = y + k / 3 - 1;
        if (px < 0 || py < 0 || px >= view->camera.width || py >= view->camera.height) continue;
        if (kinds[(size_t)py * (size_t)view->camera.width + (size_t)px] != FFP_PIXEL_STAGE) return false;
    }
    return true;
}

// True if a surface at a point would get the projector's light, as far as the hull's shadows are known.
static bool would_be_lit(const FfpHull *h, int v, const real point[3]) {
    int cell;
    real z;
    if (!ffp_depth_map_find(&h->shadows[v], point, &cell, &z)) return false;
    return z <= h->shadows[v].z[cell] + BEHIND * h->voxels.step;
}

// Adds what a view shows at a point; false where it is stage for sure.
static bool ask(const FfpHull *h, int v, const real point[3], bool with_shadows, Evidence *e) {
    const FfpView *view = &h->capture->views[v];
    real x, y;
    if (!(ffp_project(&view->camera, point, &x, &y) > 0) || x < 0 || y < 0 ||
        x >= (real)ffp_frame_width(view) || y >= (real)ffp_frame_height(view))
        return true;
    const size_t pixel = (size_t)y * (size_t)view->camera.width + (size_t)x;
    const unsigned char *kinds = h->compared[v].kinds, kind = kinds[pixel];
    if (h->shaded[v][pixel]) return false;
    if (kind == FFP_PIXEL_STAGE && is_stage(view, kinds, (int)x, (int)y)) return false;
    e->seen++, e->object += kind == FFP_PIXEL_OBJECT || kind == FFP_PIXEL_LIT,
        e->stage += kind == FFP_PIXEL_DIM_STAGE;
    e->through += ffp_free_space_votes(h->space, v, point, (real)CARVE_MARGIN * h->capture->radius);
    if (with_shadows && (kind == FFP_PIXEL_UNKNOWN || kind == FFP_PIXEL_DIM_STAGE))
        e->unlit += would_be_lit(h, v, point);
    return true;
}

// True if a point of the world can be the object's.
static bool is_possible(const FfpHull *h, const real point[3], bool with_shadows) {
    const int n = h->capture->n_views;
    Evidence e = {0};
    for (int v = 0; v < n; v++)
        if (!ask(h, v, point, with_shadows, &e)) return false;
    return e.seen >= CARVE_SEEN_SHARE * n && e.stage < STAGE_MOST && e.through < THROUGH_MOST &&
           e.unlit < UNLIT_MOST + e.object;
}

static void draw_shadows(FfpHull *h) {
#pragma omp parallel for schedule(static)
    for (int v = 0; v < h->capture->n_views; v++) ffp_voxels_draw(&h->voxels, &h->shadows[v]);
}

FfpHull ffp_hull_new(const FfpCapture *capture, const FfpCompared *compared, unsigned char *const *shaded,
                     const FfpFreeSpace *space) {
    const int n = capture->n_views;
    FfpHull h = {capture, compared, shaded, space, ffp_voxels_new(capture, SIDE), NULL};
    h.shadows = ffp_alloc((size_t)n, sizeof *h.shadows);
    for (int v = 0; v < n; v++) h.shadows[v] = ffp_depth_map_new(&capture->views[v].projector, MAP, MAP);
    for (int round = 0; round < ROUNDS; round++) {
        ffp_cancel_point();
        if (round > 0) draw_shadows(&h);
#pragma omp parallel for schedule(dynamic, SIDE *SIDE)
        for (int i = 0; i < SIDE * SIDE * SIDE; i++) {
            real point[3];
            if (round > 0 && !h.voxels.solid[i]) continue;
            ffp_voxels_point(&h.voxels, i, point);
            h.voxels.solid[i] = is_possible(&h, point, round > 0);
        }
    }
    return h;
}

void ffp_hull_free(FfpHull *hull) {
    for (int v = 0; v < hull->capture->n_views; v++) ffp_depth_map_free(&hull->shadows[v]);
    ffp_free(hull->shadows);
    ffp_voxels_free(&hull->voxels);
    *hull = (FfpHull){0};
}

double ffp_hull_length(const FfpHull *hull, int view, size_t pixel) {
    const FfpCapture *capture = hull->capture;
    FfpChord chord;
    int inside = 0;
    if (!ffp_chord(capture, &capture->views[view].camera, pixel, &chord)) return 0;
    for (int k = 0; k < SAMPLES; k++) {
        real point[3];
        ffp_chord_point(&chord, k, SAMPLES, point);
        inside += hull->voxels.solid[ffp_voxels_find(&hull->voxels, point)];
    }
    return inside * (double)(chord.far - chord.near) / (SAMPLES * (double)capture->radius);
}
