#include "engine/match/unlit.h"
#include <stdlib.h>
#include <string.h>
#include <tgmath.h>
#include "core/base/arena.h"
#include "core/base/call.h"
#include "engine/match/observe.h"
#include "engine/match/sweep.h"
#include "engine/match/unlit_work.h"

#define UNLIKE 0.25F // difference of encoded colours beyond which they are of different surfaces
#define COMPARED 2   // views that see a point best: of the others something may hide it
#define AGREED 0.1F  // cost at a trusted point of another view,
#define EMPTY 1.0F   // and where views see past, or off a silhouette
#define SLACK 1.0F   // as FFP_SUPPORT_SLACK; planes lie closer than that
#define LEAN 0.04F   // cost of lying LEAN_REACH or more off the filled depth
#define LEAN_REACH 0.1F
#define SMALL_STEP 0.02F // smoothness, as in matching
#define LARGE_STEP 0.4F
#define MARGIN 0.8F // of the aggregated costs by which a plane must be better than the filled depth's

// The other views' evidence on a point of a ray.
typedef struct Said {
    FfpSupport support;    // those who see past it, and those with a surface there
    real unlike[COMPARED]; // least differences to what unlit pixels of other views show, [0,1], ascending
    int compared;
} Said;

static inline real at_most(real x, real most) {
    return x < most ? x : most;
}

// Puts a difference in its place among the least.
static void keep_least(Said *said, real unlike) {
    int k = said->compared < COMPARED ? said->compared++ : COMPARED;
    for (; k > 0 && said->unlike[k - 1] > unlike; k--)
        if (k < COMPARED) said->unlike[k] = said->unlike[k - 1];
    if (k < COMPARED) said->unlike[k] = unlike;
}

// Compares with the colour between the four pixels from `first` on, of those on the object; (a, b) is the
// way to the right and down.
static void compare(Said *said, const FfpUnlit *scene, const real *colour, int other, size_t first, real a,
                    real b) {
    const size_t width = (size_t)scene->depths->width, height = (size_t)scene->depths->height;
    const real *coverage = scene->depths->capture->views[other].coverage.data + first,
               *shown = scene->encoded + 3 * ((size_t)other * width * height + first);
    const size_t around[4] = {0, 1, width, width + 1};
    const real share[4] = {(1 - a) * (1 - b), a * (1 - b), (1 - a) * b, a * b};
    real sum = 0, rgb[3] = {0, 0, 0}, off = 0;
    for (int n = 0; n < 4; n++) {
        if (coverage[around[n]] <= 0) continue;
        sum += share[n];
        for (int c = 0; c < 3; c++) rgb[c] += share[n] * shown[3 * around[n] + (size_t)c];
    }
    if (sum < 0.1F) return;
    for (int c = 0; c < 3; c++) off += fabs(rgb[c] / sum - colour[c]) / 3;
    keep_least(said, at_most(off / UNLIKE, 1));
}

static void ask_camera(Said *said, const FfpUnlit *scene, const FfpUnlitRay *ray, int other, real z) {
    const int width = scene->depths->width, height = scene->depths->height;
    const FfpView *seer = &scene->depths->capture->views[other];
    real u = -1, v = -1;
    const real depth = ffp_line_at(&ray->camera[other], z, &u, &v);
    u -= 0.5F;
    v -= 0.5F;
    if (!(u >= 0 && v >= 0 && u < (real)(ffp_frame_width(seer) - 1) &&
          v < (real)(ffp_frame_height(seer) - 1)))
        return;
    const int x = (int)u, y = (int)v;
    const size_t first = (size_t)y * (size_t)width + (size_t)x;
    const FfpDepthBounds *bounds =
        &scene->support_views.bounds[(size_t)other * (size_t)width * (size_t)height + first];
    const real slack = SLACK * depth / seer->camera.fx;
    ffp_support_count(&said->support, bounds, depth, slack);
    if (bounds->high <= 0) compare(said, scene, ray->colour, other, first, u - (real)x, v - (real)y);
}

static void ask_projector(Said *said, const FfpUnlit *scene, const FfpUnlitRay *ray, int other, real z) {
    const FfpProjectorRays *projector_rays = &scene->projector_rays[other];
    real u = -1, v = -1;
    const real depth = ffp_line_at(&ray->projector[other], z, &u, &v);
    const FfpDepthBounds bounds = ffp_projector_rays_at(projector_rays, u, v);
    const real slack =
        SLACK * depth / (scene->depths->capture->views[other].projector.fx * projector_rays->scale);
    if (depth < bounds.low - slack) said->support.trust_past += bounds.trust;
}

real ffp_unlit_cost(const FfpUnlit *scene, const FfpUnlitRay *ray, real z) {
    Said said = {0};
    const FfpAsked *asked = &scene->support_views.asked[ray->view];
    for (int k = 0; k < asked->count; k++) {
        const int other = asked->view[k];
        if (other != ray->view) ask_camera(&said, scene, ray, other, z);
        ask_projector(&said, scene, ray, other, z);
    }
    if (ffp_support_is_free_space(&said.support)) return EMPTY;
    real cost = 0;
    for (int k = 0; k < said.compared; k++) cost += said.unlike[k] / (real)said.compared;
    if (said.compared == 0) cost = FFP_UNLIT_UNKNOWN;
    return said.support.trust_agree > said.support.trust_past ? at_most(cost, AGREED) : cost;
}

FfpUnlitRay ffp_unlit_ray(const FfpUnlit *scene, int view, size_t pixel, FfpLine *lines) {
    const FfpCapture *capture = scene->depths->capture;
    const FfpCamera *camera = &capture->views[view].camera;
    const size_t width = (size_t)scene->depths->width, area = width * (size_t)scene->depths->height;
    const size_t views = (size_t)capture->n_views;
    const real x = (real)(pixel % width) + 0.5F, y = (real)(pixel / width) + 0.5F;
    const FfpAsked *asked = &scene->support_views.asked[view];
    for (int k = 0; k < asked->count; k++) {
        const size_t other = (size_t)asked->view[k];
        lines[other] = ffp_line(camera, x, y, &capture->views[other].camera);
        lines[views + other] = ffp_line(camera, x, y, &capture->views[other].projector);
    }
    return (FfpUnlitRay){view, scene->encoded + 3 * ((size_t)view * area + pixel), lines, lines + views};
}

// Costs of an unlit pixel's planes; `at` is the plane of its filled depth.
static void ray_costs(real *cost, const FfpUnlit *scene, const FfpUnlitRay *ray, const unsigned char *inside,
                      const FfpPlanes *planes, real at) {
    for (int k = 0; k < planes->count; k++) {
        const real off = fabs((real)k - at) * planes->step;
        cost[k] = inside[k] ? ffp_unlit_cost(scene, ray, planes->first + (real)k * planes->step) : EMPTY;
        cost[k] += LEAN * at_most(off / LEAN_REACH, 1);
    }
}

// Costs of all planes of a view's pixels. Trusted ones hold their plane.
static void view_costs(real *cost, const FfpUnlit *scene, int view, const FfpForeground *foreground,
                       const FfpPlanes *planes, const unsigned char *inside, const real *filled) {
    const FfpCapture *capture = scene->depths->capture;
    const size_t area = (size_t)foreground->width * (size_t)foreground->height;
    const size_t views = (size_t)capture->n_views, count = (size_t)planes->count;
    FfpLine *lines = ffp_alloc(2 * views, sizeof *lines);
    for (size_t slot = 0; slot < foreground->count; slot++) {
        const size_t i = foreground->pixel[slot], pixel = (size_t)view * area + i;
        const real at = (filled[pixel] - planes->first) / planes->step;
        real *row = cost + slot * count;
        if (scene->depths->trust[pixel] > 0) {
            for (size_t k = 0; k < count; k++) row[k] = at_most(fabs((real)k - at), 1);
            continue;
        }
        const FfpUnlitRay ray = ffp_unlit_ray(scene, view, i, lines);
        ray_costs(row, scene, &ray, inside + slot * count, planes, at);
    }
    ffp_free(lines);
}

// Depth of the plane of least total, by the parabola through it and its neighbours; the filled one unless
// that is clearly worse.
static real choose(const real *total, const FfpPlanes *planes, real filled) {
    const int last = planes->count - 1;
    int best = 0;
    for (int k = 1; k <= last; k++)
        if (total[k] < total[best]) best = k;
    const real at = fmin(fmax((filled - planes->first) / planes->step, 0), (real)last);
    if (total[(int)round(at)] - total[best] <= MARGIN) return filled;
    real shift = 0;
    if (best > 0 && best < last) {
        const real a = total[best - 1], b = total[best + 1], bend = a - 2 * total[best] + b;
        shift = bend > 0 ? 0.5F * (a - b) / bend : 0;
    }
    return planes->first + ((real)best + shift) * planes->step;
}

static void find_view(real *out, const FfpUnlit *scene, int view, const real *filled,
                      const unsigned char *hull, const FfpMatchSettings *settings) {
    const FfpCapture *capture = scene->depths->capture;
    const FfpPlanes planes = ffp_planes(capture, view, settings);
    FfpForeground foreground = ffp_foreground_new(&capture->views[view].coverage);
    const size_t count = (size_t)planes.count, cells = foreground.count * count,
                 first = (size_t)view * (size_t)foreground.width * (size_t)foreground.height;
    real *cost = ffp_alloc(cells, sizeof(real)), *total = ffp_alloc(cells, sizeof(real));
    unsigned char *own = NULL;
    const unsigned char *inside = hull;
    if (!inside) {
        inside = own = ffp_alloc(cells, 1);
        ffp_hull(own, capture, view, &foreground, &planes);
    }
    view_costs(cost, scene, view, &foreground, &planes, inside, filled);
    ffp_semi_global(total, cost, &foreground, planes.count,
                    &(FfpSteps){.small = SMALL_STEP, .large = LARGE_STEP});
    for (size_t slot = 0; slot < foreground.count; slot++) {
        const size_t i = first + foreground.pixel[slot];
        if (scene->depths->trust[i] <= 0) out[i] = choose(total + slot * count, &planes, filled[i]);
    }
    ffp_free(own);
    ffp_free(total);
    ffp_free(cost);
    ffp_foreground_free(&foreground);
}

typedef struct Views {
    FfpUnlit *scene;
    real *out;
    const real *filled;
    unsigned char *const *hulls;
    const FfpMatchSettings *settings;
} Views;

static void prepare_view(void *argument, int64_t v) {
    const FfpUnlit *scene = ((const Views *)argument)->scene;
    const FfpDepths *depths = scene->depths;
    const FfpView *view = &depths->capture->views[v];
    const size_t area = (size_t)depths->width * (size_t)depths->height;
    scene->projector_rays[v] = ffp_projector_rays_new(depths, (int)v);
    for (size_t i = 0; i < area; i++) {
        real *rgb = scene->encoded + 3 * ((size_t)v * area + i);
        ffp_own_radiance(rgb, view->images[depths->capture->black].data + 3 * i, view->coverage.data[i]);
        for (int c = 0; c < 3; c++) rgb[c] = ffp_srgb_encode(rgb[c]);
    }
}

static void find_one(void *argument, int64_t view) {
    const Views *v = argument;
    find_view(v->out, v->scene, (int)view, v->filled, v->hulls ? v->hulls[view] : NULL, v->settings);
    ffp_cancel_point();
}

FfpUnlit ffp_unlit_new(const FfpDepths *depths) {
    const FfpCapture *capture = depths->capture;
    const size_t views = (size_t)capture->n_views, area = (size_t)depths->width * (size_t)depths->height;
    FfpUnlit out = {depths, ffp_support_views_new(depths), ffp_alloc(views, sizeof(FfpProjectorRays)),
                    ffp_alloc(views * area, 3 * sizeof(real))};
    ffp_parallel_for(capture->n_views, 0, prepare_view, &(Views){.scene = &out});
    return out;
}

void ffp_unlit_free(FfpUnlit *scene) {
    for (int v = 0; v < scene->depths->capture->n_views; v++)
        ffp_projector_rays_free(&scene->projector_rays[v]);
    ffp_free(scene->projector_rays);
    ffp_free(scene->encoded);
    ffp_support_views_free(&scene->support_views);
}

void ffp_unlit_depths(real *out, const FfpDepths *depths, const real *filled, unsigned char *const *hulls,
                      const FfpMatchSettings *settings, int threads) {
    const int views = depths->capture->n_views;
    FfpUnlit scene = ffp_unlit_new(depths);
    memcpy(out, filled, (size_t)views * (size_t)depths->width * (size_t)depths->height * sizeof(real));
    ffp_parallel_for(views, threads, find_one, &(Views){&scene, out, filled, hulls, settings});
    ffp_unlit_free(&scene);
}
