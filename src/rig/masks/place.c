#include "rig/masks/place.h"
#include <string.h>
#include <tgmath.h>
#include "core/base/alloc.h"
#include "core/base/call.h"
#include "core/image/lookup.h"
#include "rig/masks/layers.h"
#include "rig/masks/limits.h"
#include "rig/masks/local_mean.h"

enum { SIDE = 5, EVEN_LEAST = 16 }; // of so many times so many pixels, as many at least
enum { DEPTHS = 288, HEIGHTS = 200 };
enum { AROUND = 4, CLOSED = 2 }; // pixels about marks that count as marked; half the width of gaps in them

typedef struct Places {    // of each pixel
    real *cost, *beyond;   // of the best depth within reach; of the best other one
    real *z, (*points)[3]; // of the former: depth, and place in the world
} Places;

typedef struct Sweep {
    const FfpCapture *capture;
    const FfpView *view;
    ptrdiff_t pixels;
    int n;                             // patterns
    FfpImage ratios[FFP_PATTERNS_MAX]; // what each adds, in parts of what white adds; 3 channels
    FfpSummed patterns[FFP_PATTERNS_MAX];
    const real *known;        // above 0 where the stage is known
    FfpImage lights, weights; // what white adds; of a squared difference of ratios; 3 channels
    double noise;
    real footprint; // of a pixel of the camera in the projector's picture, pixels
} Sweep;

static FfpImage added(const FfpImage *image, const FfpImage *black) {
    FfpImage out = ffp_local_mean(image, PLACE_SMOOTH), dark = ffp_local_mean(black, PLACE_SMOOTH);
    for (ptrdiff_t i = 0; i < 3 * (ptrdiff_t)out.width * out.height; i++) out.data[i] -= dark.data[i];
    ffp_image_free(&dark);
    return out;
}

static double distance_of(const FfpCapture *capture, const FfpCamera *device) {
    double square = 0;
    for (int i = 0; i < 3; i++) {
        const double to = (double)device->pose[4 * i + 3] - (double)capture->centre[i];
        square += to * to;
    }
    return sqrt(square);
}

// The difference of two views where both show the same.
static double noise_of(const FfpCapture *capture) {
    const FfpImage *one = capture->views[0].images, *two = capture->views[capture->n_views / 2].images;
    FfpLayers *a = ffp_layers_new(capture, one, two), *b = ffp_layers_new(capture, two, one);
    const double noise = ffp_layers_noise(a, b);
    ffp_layers_free(a), ffp_layers_free(b);
    return noise;
}

static Sweep new_sweep(const FfpCapture *capture, const FfpEmptyStage *stage) {
    const FfpView *view = &capture->views[0];
    const FfpImage *black = &stage->images[capture->black];
    Sweep s = {.capture = capture,
               .view = view,
               .pixels = (ptrdiff_t)black->width * black->height,
               .known = stage->known.data,
               .noise = noise_of(capture)};
    s.footprint = (real)fmax(1, PLACE_BLUR * distance_of(capture, &view->camera) / (double)view->camera.fx *
                                    (double)view->projector.fx / distance_of(capture, &view->projector));
    const ptrdiff_t count = 3 * s.pixels;
    s.lights = added(&stage->images[capture->white], black);
    s.weights = ffp_image_new(black->width, black->height, 3);
    for (ptrdiff_t i = 0; i < count; i++) {
        const double white = fmax((double)s.lights.data[i], 0);
        s.weights.data[i] =
            (real)(white * white / (s.noise * s.noise + PLACE_RELATIVE * PLACE_RELATIVE * white * white));
    }
    for (int p = 0; p < capture->n_patterns; p++) {
        if (p == capture->black || p == capture->white) continue;
        if (!stage->images[p].data || !capture->patterns[p].image.data) continue;
        s.patterns[s.n] = ffp_summed_new(&capture->patterns[p].image);
        s.ratios[s.n] = added(&stage->images[p], black);
        for (ptrdiff_t i = 0; i < count; i++) s.ratios[s.n].data[i] /= fmax(s.lights.data[i], 1e-6F);
        s.n++;
    }
    return s;
}

static void free_sweep(Sweep *s) {
    for (int k = 0; k < s->n; k++) ffp_image_free(&s->ratios[k]), ffp_summed_free(&s->patterns[k]);
    ffp_image_free(&s->lights), ffp_image_free(&s->weights);
}

static void point_at(const Sweep *s, ptrdiff_t pixel, double z, real point[3]) {
    const FfpCamera *camera = &s->view->camera;
    real direction[3];
    const real x = (real)(pixel % camera->width) + 0.5F, y = (real)(pixel / camera->width) + 0.5F;
    ffp_pixel_ray(camera, x, y, direction);
    for (int i = 0; i < 3; i++) point[i] = camera->pose[4 * i + 3] + (real)z * direction[i];
}

// How badly the patterns explain a pixel's look at a depth.
static real cost_at(const Sweep *s, ptrdiff_t pixel, double z) {
    const FfpCamera *projector = &s->view->projector;
    real point[3], u, v, colour[3];
    double sum = 0;
    point_at(s, pixel, z, point);
    if (!(ffp_project(projector, point, &u, &v) > 0) || u < 0 || v < 0 || u >= (real)projector->width ||
        v >= (real)projector->height)
        return PLACE_COST_LIMIT;
    for (int k = 0; k < s->n; k++) {
        ffp_lookup(&s->patterns[k], u, v, s->footprint, s->footprint, colour);
        for (int i = 0; i < 3; i++) {
            const double off = (double)s->ratios[k].data[3 * pixel + i] - (double)colour[i];
            sum += (double)s->weights.data[3 * pixel + i] * off * off / s->n;
        }
    }
    return (real)fmin(sum, PLACE_COST_LIMIT);
}

// True if the object's sphere, turned about the axis, reaches as far from it as a point.
static bool is_within(const Sweep *s, const real point[3]) {
    const real *centre = s->capture->centre;
    return hypot(point[0], point[1]) < s->capture->radius + hypot(centre[0], centre[1]);
}

static void sweep(const Sweep *s, Places *places) {
    const int width = s->view->camera.width, height = s->view->camera.height;
    const ptrdiff_t pixels = s->pixels;
    const double away = distance_of(s->capture, &s->view->camera);
    FfpImage costs = ffp_image_new(width, height, 1);
    for (ptrdiff_t i = 0; i < pixels; i++) places->cost[i] = places->beyond[i] = INFINITY;
    for (int k = 0; k < DEPTHS; k++) {
        const double share = (k + 0.5) / DEPTHS,
                     z = away / ((1 - share) / PLACE_NEAREST + share / PLACE_FARTHEST);
        ffp_cancel_point();
#pragma omp parallel for schedule(static)
        for (ptrdiff_t i = 0; i < pixels; i++) costs.data[i] = cost_at(s, i, z);
        FfpImage means = ffp_local_mean(&costs, PLACE_WINDOW);
#pragma omp parallel for schedule(static)
        for (ptrdiff_t i = 0; i < pixels; i++) {
            real point[3];
            point_at(s, i, z, point);
            real *least = is_within(s, point) ? &places->cost[i] : &places->beyond[i];
            if (!(means.data[i] < *least)) continue;
            *least = means.data[i];
            if (least == &places->cost[i])
                places->z[i] = (real)z, memcpy(places->points[i], point, sizeof point);
        }
        ffp_image_free(&means);
    }
    ffp_image_free(&costs);
}

// Height along the axis, which is the world's z, in the direction that is up for the camera.
static double height_of(const Sweep *s, const Places *places, ptrdiff_t pixel) {
    return (s->view->camera.pose[9] > 0 ? -1 : 1) * (double)places->points[pixel][2];
}

// The greatest height at which half as many marked pixels lie as at the commonest one: a table around the
// platter is seen as well. False where too few do.
static bool find_platter(const Sweep *s, const Places *places, const unsigned char *marks, double *platter) {
    const double bin = PLACE_BIN * (double)s->capture->radius;
    int64_t counts[HEIGHTS + 2] = {0}, near[HEIGHTS + 2] = {0}, all = 0, most = 0;
    for (ptrdiff_t i = 0; i < s->pixels; i++) {
        const double at = height_of(s, places, i) / bin + HEIGHTS / 2;
        if (!marks[i] || !(at >= 0) || at >= HEIGHTS) continue;
        counts[1 + (int)at]++, all++;
    }
    for (int k = 1; k <= HEIGHTS; k++) {
        near[k] = counts[k - 1] + counts[k] + counts[k + 1];
        most = near[k] > most ? near[k] : most;
    }
    for (int k = HEIGHTS; k >= 1; k--) {
        if (near[k] < PLACE_AS_MANY * (double)most || near[k] < near[k - 1]) continue;
        *platter = (k - 0.5 - HEIGHTS / 2) * bin;
        break;
    }
    return (double)most > PLACE_PLATTER_LEAST * (double)all;
}

static bool is_lit(const Sweep *s, ptrdiff_t pixel) {
    double light = 0;
    for (int i = 0; i < 3; i++) light += (double)s->lights.data[3 * pixel + i] / 3;
    return light > PLACE_LIT * s->noise;
}

// True if most of the pixels around one lie as far away as it does; depths found by chance do not.
static bool is_smooth(const Sweep *s, const Places *places, ptrdiff_t pixel) {
    const int width = s->view->camera.width, height = s->view->camera.height;
    const int x = (int)(pixel % width), y = (int)(pixel / width);
    int near = 0;
    for (int k = 0; k < SIDE * SIDE; k++) {
        const int px = x + k % SIDE - SIDE / 2, py = y + k / SIDE - SIDE / 2;
        if (px < 0 || py < 0 || px >= width || py >= height) continue;
        const ptrdiff_t i = (ptrdiff_t)py * width + px;
        near += places->cost[i] < places->beyond[i] &&
                fabs((double)(places->z[i] - places->z[pixel])) < PLACE_EVEN * (double)s->capture->radius;
    }
    return near >= EVEN_LEAST;
}

// Marks what stands above the platter; false where there is none.
static bool mark(unsigned char *marks, const Sweep *s, const Places *places) {
    const double radius = (double)s->capture->radius;
    double platter = 0;
    for (ptrdiff_t i = 0; i < s->pixels; i++)
        marks[i] = s->known[i] > 0 && is_lit(s, i) && (double)places->cost[i] < PLACE_COST_MOST &&
                   places->cost[i] < places->beyond[i];
    if (!find_platter(s, places, marks, &platter)) return false;
    for (ptrdiff_t i = 0; i < s->pixels; i++) {
        const double above = height_of(s, places, i) - platter;
        marks[i] = marks[i] &&
                   ((double)places->cost[i] < PLACE_CLEARLY * (double)places->beyond[i] ||
                    is_smooth(s, places, i)) &&
                   above > PLACE_ABOVE * radius && above < 2 * radius;
    }
    return true;
}

// True if all views show a point within their masks, or marked.
static bool is_in_all(const FfpCapture *capture, const unsigned char *marks, const real point[3]) {
    for (int v = 0; v < capture->n_views; v++) {
        const FfpView *view = &capture->views[v];
        real x, y;
        if (!(ffp_project(&view->camera, point, &x, &y) > 0) || x < 0 || y < 0 ||
            x >= (real)view->camera.width || y >= (real)view->camera.height)
            return false;
        const ptrdiff_t at = (ptrdiff_t)y * view->camera.width + (ptrdiff_t)x;
        if (!marks[at] && view->coverage.data[at] < 0.5F) return false;
    }
    return true;
}

// An object that looks the same from all sides is round: keeps marks whose points are the object's from all
// sides.
static void keep_round(unsigned char *marks, const Sweep *s, const Places *places) {
    unsigned char *around = ffp_alloc((size_t)s->pixels, 1);
    memcpy(around, marks, (size_t)s->pixels);
    ffp_marks_grow(around, s->view->camera.width, s->view->camera.height, AROUND);
    for (ptrdiff_t i = 0; i < s->pixels; i++)
        marks[i] = marks[i] && is_in_all(s->capture, around, places->points[i]);
    ffp_marks_grow(marks, s->view->camera.width, s->view->camera.height, CLOSED);
    ffp_marks_shrink(marks, s->view->camera.width, s->view->camera.height, CLOSED);
    ffp_free(around);
}

double ffp_place_above(unsigned char *marks, const FfpCapture *capture, const FfpEmptyStage *stage) {
    Sweep s = new_sweep(capture, stage);
    Places places = {.cost = ffp_alloc((size_t)s.pixels, sizeof *places.cost),
                     .beyond = ffp_alloc((size_t)s.pixels, sizeof *places.beyond),
                     .z = ffp_alloc((size_t)s.pixels, sizeof *places.z),
                     .points = ffp_alloc((size_t)s.pixels, sizeof *places.points)};
    double found = 0, covered = 0;
    if (s.n > 0) sweep(&s, &places);
    if (s.n > 0 && mark(marks, &s, &places)) {
        keep_round(marks, &s, &places);
        for (ptrdiff_t i = 0; i < s.pixels; i++) {
            found += marks[i];
            for (int v = 0; v < capture->n_views; v++)
                covered += (capture->views[v].coverage.data[i] >= 0.5F) / (double)capture->n_views;
        }
    }
    ffp_free(places.cost), ffp_free(places.beyond), ffp_free(places.points), ffp_free(places.z);
    free_sweep(&s);
    return found / fmax(covered, 1);
}
