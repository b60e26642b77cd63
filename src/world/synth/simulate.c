#include "world/synth/simulate.h"
#include <math.h>
#include <omp.h>
#include <stdlib.h>
#include <string.h>
#include "core/base/arena.h"
#include "core/base/brdf.h"
#include "core/base/call.h"
#include "world/synth/room.h"
#include "world/synth/sensor.h"
#include "world/synth/simulate_work.h"

enum { CELL = 4, LOOKUPS_MAX = 16 };
static const float FACING = 0.02F; // least cosine between shading normal and view

// The lookups that a sample's cell of the pixel asks for: the cell's image on the tangent plane, projected,
// spread evenly over so many that their tents overlap. Converges to one lookup as samples grow.
typedef struct Spread {
    int count, inside; // inside: how many of them lie in the rectangle
    FfpTexel texel[LOOKUPS_MAX];
} Spread;

static void pattern_slope(const FfpViewWork *w, const FfpIncoming *a, const float step[3], float side,
                          float *du, float *dv) {
    const FfpTracedDevice *p = &w->projector;
    float local[3];
    for (int k = 0; k < 3; k++) local[k] = ffp_along(p->axes + 3 * k, step);
    const float z = a->local[2], s = side / (z * z);
    *du = s * p->fx * (local[0] * z - a->local[0] * local[2]);
    *dv = s * p->fy * (local[1] * z - a->local[1] * local[2]);
}

static void spread_lookups(const FfpViewWork *w, const FfpIncoming *a, const FfpHit *hit, const float ray[3],
                           Spread *out) {
    const FfpTracedDevice *c = &w->camera;
    const float side = 1 / sqrtf((float)w->sim->samples);
    const float facing = ffp_along(hit->facet, ray);
    const float steep = fabsf(facing) < 0.05F ? copysignf(0.05F, facing) : facing;
    float du[2], dv[2];
    int n[2];
    for (int axis = 0; axis < 2;
         axis++) { // the hit's motion on its tangent plane as the pixel position moves
        const float *move = c->axes + 3 * axis, f = axis ? c->fy : c->fx;
        const float along = ffp_along(hit->facet, move) / steep;
        float step[3];
        for (int k = 0; k < 3; k++) step[k] = hit->t / f * (move[k] - along * ray[k]);
        pattern_slope(w, a, step, side, &du[axis], &dv[axis]);
        n[axis] = (int)ffp_max(1, ffp_min(4, ceilf(hypotf(du[axis], dv[axis]) / 2.5F)));
    }
    out->count = n[0] * n[1], out->inside = 0;
    for (int j = 0; j < n[1]; j++)
        for (int i = 0; i < n[0]; i++) {
            const float x = ((float)i + 0.5F) / (float)n[0] - 0.5F,
                        y = ((float)j + 0.5F) / (float)n[1] - 0.5F;
            out->inside +=
                ffp_light_texel(w->sim->light->width, w->sim->light->height, a->u + x * du[0] + y * du[1],
                                a->v + x * dv[0] + y * dv[1], &out->texel[out->inside]);
        }
}

// Light of the projector that reaches a sample and goes on to the camera.
static void light_sample(const FfpViewWork *w, size_t pixel, const FfpSample *s, const FfpIncoming *a) {
    const float scale = -1 / sqrtf(ffp_along(s->ray, s->ray)),
                to_camera[3] = {s->ray[0] * scale, s->ray[1] * scale, s->ray[2] * scale};
    const float specular = ffp_brdf_specular(s->normal, a->towards, to_camera, s->roughness),
                cosine = ffp_along(s->normal, a->towards);
    float colour[3];
    for (int c = 0; c < 3; c++) {
        colour[c] = (s->albedo[c] / FFP_PI + specular) * cosine * a->fall * w->sim->intensity[c];
        w->view->direct_white.data[3 * pixel + (size_t)c] += colour[c];
    }
    Spread spread;
    spread_lookups(w, a, &s->hit, s->ray, &spread);
    for (int c = 0; c < 3; c++) colour[c] /= (float)spread.count;
    const FfpLight *light = w->sim->light;
    float *sum = ffp_lanes_of(w, w->sums.direct, pixel);
    const float soft =
        light->soft ? ffp_sensor_softness(w->sim->sensor, light->width, w->focus, a->local[2]) : 0;
    for (int i = 0; i < spread.inside; i++)
        if (soft > 0)
            ffp_light_add_soft(light, &spread.texel[i], soft, colour, sum);
        else
            ffp_light_add(light, &spread.texel[i], colour, sum);
}

static void direct_light(const FfpViewWork *w, size_t pixel, const FfpSample *samples, int count) {
    FfpRays shadow = {.count = 0};
    FfpIncoming arrivals[FFP_RAYS];
    const FfpSample *lit[FFP_RAYS];
    int dark = 0, n = 0; // dark: by their cosine, not by a shadow
    for (int i = 0; i < count; i++) {
        const FfpSample *s = &samples[i];
        float way[3];
        for (int k = 0; k < 3; k++) way[k] = w->projector.origin[k] - s->hit.point[k];
        if (ffp_along(way, s->normal) <= 0)
            dark++;
        else if (ffp_arrive(w, &s->hit, s->normal, &arrivals[n], &shadow))
            lit[n++] = s;
    }
    const unsigned blocked = ffp_trace_blocked(w->sim->tracer, &shadow);
    int reached = 0;
    for (int i = 0; i < n; i++) {
        if (blocked >> i & 1) continue;
        light_sample(w, pixel, lit[i], &arrivals[i]);
        reached++;
    }
    if (w->visibility) w->visibility->data[pixel] += (real)(dark + reached);
}

// Looks up what lies at a sample's hit, and adds it to the truth maps.
static void look_at_sample(const FfpViewWork *w, size_t pixel, FfpSample *s) {
    FfpView *view = w->view;
    const float cell = s->hit.t / (w->camera.fx * sqrtf((float)w->sim->samples));
    memcpy(s->normal, s->hit.normal, sizeof s->normal);
    ffp_surface_look(w->sim, &s->hit, cell, s->albedo, &s->roughness);
    ffp_surface_bump(w->sim, &s->hit, cell, s->normal);
    const float length = sqrtf(ffp_along(s->ray, s->ray)), facing = -ffp_along(s->normal, s->ray) / length;
    if (facing < FACING) { // seen from behind by interpolation or bump: tilt it to the camera
        float square = 0;
        for (int k = 0; k < 3; k++)
            s->normal[k] -= (FACING - facing) * s->ray[k] / length, square += s->normal[k] * s->normal[k];
        for (int k = 0; k < 3; k++) s->normal[k] /= sqrtf(square);
    }
    for (int c = 0; c < 3; c++) {
        const size_t i = 3 * pixel + (size_t)c;
        view->albedo.data[i] += s->albedo[c];
        view->normal.data[i] += s->normal[c];
        w->sums.point[i] += s->hit.point[c];
        w->sums.smooth[i] += s->hit.normal[c];
    }
    view->roughness.data[pixel] += s->roughness;
}

static void divide(real *data, int count, float by) {
    for (int i = 0; i < count; i++) data[i] = (real)(data[i] / by);
}
static void divide_sums(float *data, int count, float by) {
    for (int i = 0; i < count; i++) data[i] /= by;
}
static void unit(real v[3]) {
    const float n = sqrtf((float)(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]));
    if (n > 0) divide(v, 3, n);
}

// How many samples of a pixel hit anything, and how many of those the object.
typedef struct Counts {
    int hits, own;
} Counts;

// FfpViewSums to means over the samples that hit.
static void finish_pixel(const FfpViewWork *w, size_t pixel, Counts counts, int samples) {
    FfpView *view = w->view;
    const float hits = (float)counts.hits;
    w->sums.hits[pixel] = hits;
    w->sums.share[pixel] = roundf(255 * hits / (float)samples) / 255;
    view->coverage.data[pixel] = (real)(roundf(255 * (float)counts.own / (float)samples) / 255);
    divide(view->albedo.data + 3 * pixel, 3, hits);
    divide(view->direct_white.data + 3 * pixel, 3, hits);
    divide(view->roughness.data + pixel, 1, hits);
    if (w->visibility) divide(w->visibility->data + pixel, 1, hits);
    unit(view->normal.data + 3 * pixel);
    divide_sums(w->sums.point + 3 * pixel, 3, hits);
    float *smooth = w->sums.smooth + 3 * pixel;
    divide_sums(smooth, 3, ffp_max(sqrtf(ffp_along(smooth, smooth)), 1e-6F));
    const float rays = hits * (float)w->sim->ambient_rays;
    const int lanes = 3 * w->sim->light->lanes;
    divide_sums(ffp_lanes_of(w, w->sums.direct, pixel), lanes, hits);
    if (rays > 0) divide_sums(ffp_lanes_of(w, w->sums.bounce, pixel), lanes, rays);
    if (rays > 0)
        divide_sums(w->sums.ambient + 3 * pixel, 3, rays);
    else
        for (int c = 0; c < 3; c++) w->sums.ambient[3 * pixel + (size_t)c] = w->sim->ambient;
}

// Samples first..last - 1 of a pixel, side by side.
static void trace_samples(const FfpViewWork *w, int x, int y, int first, int last, Counts *counts) {
    const size_t pixel = (size_t)y * (size_t)w->view->camera.width + (size_t)x;
    FfpRays rays = {.count = 0};
    FfpHit hits[FFP_RAYS];
    FfpSample samples[FFP_RAYS] = {0};
    const uint32_t shift = ffp_hash32(w->seed ^ ffp_hash32((uint32_t)pixel));
    for (int s = first; s < last; s++) {
        float i, j, ray[3];
        ffp_even_pair((uint32_t)s, shift, &i, &j);
        ffp_camera_ray(&w->camera, (float)x + i, (float)y + j, ray);
        ffp_rays_add(&rays, w->camera.origin, ray);
    }
    const unsigned found = ffp_trace_hits(w->sim->tracer, &rays, true, hits);
    int count = 0;
    for (int i = 0; i < rays.count; i++) {
        FfpSample *s = &samples[count];
        for (int k = 0; k < 3; k++) s->ray[k] = rays.direction[k][i];
        if (!(found >> i & 1) || ffp_along(hits[i].facet, s->ray) >= 0) continue;
        s->hit = hits[i], s->index = (uint32_t)(first + i);
        look_at_sample(w, pixel, s);
        counts->own += w->sim->whole || !ffp_around_has(w->sim->around, &s->hit);
        count++;
    }
    if (count == 0) return;
    counts->hits += count;
    direct_light(w, pixel, samples, count);
    ffp_indirect_light(w, pixel, samples, count, shift);
}

static void trace_pixel(const FfpViewWork *w, int x, int y) {
    const size_t pixel = (size_t)y * (size_t)w->view->camera.width + (size_t)x;
    const int samples = w->sim->samples;
    int limit = samples;
    Counts counts = {0, 0};
    for (int s = 0; s < limit;) {
        const int end = s < samples ? samples : limit, last = s + FFP_RAYS < end ? s + FFP_RAYS : end;
        trace_samples(w, x, y, s, last, &counts);
        s = last;
        // a silhouette's share is a mean of zeros and ones: it takes more samples than a colour
        if (s == samples && counts.own > 0 && counts.own < s) limit *= 4;
    }
    if (counts.hits == 0) return;
    finish_pixel(w, pixel, counts, limit);
    FfpRays centre = {.count = 0};
    FfpHit hit[FFP_RAYS];
    float ray[3];
    ffp_camera_ray(&w->camera, (float)x + 0.5F, (float)y + 0.5F, ray);
    ffp_rays_add(&centre, w->camera.origin, ray);
    if (ffp_trace_hits(w->sim->tracer, &centre, true, hit)) w->view->depth.data[pixel] = (real)hit->t;
}

// Which CELL x CELL blocks of pixels any triangle's bounding box touches: most of an image is background.
static size_t busy_cells(const FfpViewWork *w, int **cells) {
    const FfpMesh *mesh = w->sim->mesh;
    const int across = (w->view->camera.width + CELL - 1) / CELL,
              down = (w->view->camera.height + CELL - 1) / CELL;
    float *xy = ffp_alloc((size_t)mesh->n_vertices * 2, sizeof *xy);
    uint8_t *busy = ffp_alloc((size_t)across * (size_t)down, 1);
    const FfpTracedDevice *c = &w->camera;
    bool behind = false;
    for (int i = 0; i < mesh->n_vertices; i++) {
        float d[3];
        for (int k = 0; k < 3; k++) d[k] = mesh->positions[3 * (size_t)i + (size_t)k] - c->origin[k];
        const float z = ffp_along(c->axes + 6, d);
        behind |= z < 1e-3F;
        ffp_device_pixel(c, ffp_along(c->axes, d), ffp_along(c->axes + 3, d), z, &xy[2 * i], &xy[2 * i + 1]);
        xy[2 * i] /= CELL, xy[2 * i + 1] /= CELL;
    }
    for (int t = 0; t < mesh->n_triangles && !behind; t++) {
        const uint32_t *v = mesh->triangles + 3 * (size_t)t;
        int low[2], high[2];
        for (int a = 0; a < 2; a++) {
            const float p = xy[2 * v[0] + a], q = xy[2 * v[1] + a], r = xy[2 * v[2] + a];
            const float last = (float)((a ? down : across) - 1);
            low[a] = (int)ffp_max(0, ffp_min(p, ffp_min(q, r)) - 0.01F),
            high[a] = (int)ffp_min(last, ffp_max(p, ffp_max(q, r)) + 0.01F);
        }
        for (int j = low[1]; j <= high[1]; j++)
            for (int i = low[0]; i <= high[0]; i++) busy[j * across + i] = 1;
    }
    *cells = ffp_alloc((size_t)across * (size_t)down, sizeof **cells);
    size_t count = 0;
    for (int i = 0; i < across * down; i++)
        if (busy[i] || behind) (*cells)[count++] = i;
    ffp_free(xy);
    ffp_free(busy);
    return count;
}

static void trace_cell(const FfpViewWork *w, int cell) {
    const int width = w->view->camera.width, height = w->view->camera.height,
              across = (width + CELL - 1) / CELL, left = cell % across * CELL, top = cell / across * CELL;
    for (int y = top; y < top + CELL && y < height; y++)
        for (int x = left; x < left + CELL && x < width; x++) trace_pixel(w, x, y);
}

// As tasks, which any thread of the team takes that has nothing else to do.
static void trace_cells(const FfpViewWork *w, const int *cells, size_t count) {
#pragma omp taskloop grainsize(8)
    for (size_t i = 0; i < count; i++) trace_cell(w, cells[i]);
}

// A team that makes a scene a thread shares the last scenes' views; without a team there is one for this
// view.
static void trace_all(const FfpViewWork *w) {
    int *cells;
    const size_t count = busy_cells(w, &cells);
    if (omp_in_parallel()) {
        trace_cells(w, cells, count);
    } else {
#pragma omp parallel
#pragma omp single
        trace_cells(w, cells, count);
    }
    ffp_free(cells);
}

// Indirect light is smooth over a surface, and a few rays a pixel are noisy: average it over neighbours that
// lie in the same plane and face the same way. Not done once enough rays make it superfluous.
static int filter_radius(const FfpSimulation *sim) {
    const int rays = sim->samples * sim->ambient_rays;
    return rays == 0 || rays >= 128 ? 0 : rays >= 64 ? 1 : rays >= 24 ? 2 : 3;
}

static float neighbour_weight(const FfpViewSums *s, size_t i, size_t j) {
    if (s->hits[j] <= 0) return 0;
    const float *n = s->smooth + 3 * i, *a = s->point + 3 * i, *b = s->point + 3 * j;
    const float d[3] = {b[0] - a[0], b[1] - a[1], b[2] - a[2]};
    const float plane = 1 - fabsf(ffp_along(n, d)) / 0.04F, cosine = ffp_along(n, s->smooth + 3 * j);
    if (plane <= 0 || cosine <= 0.5F) return 0;
    const float same = cosine * cosine * cosine * cosine;
    return plane * same * same * ffp_min(s->hits[j], 4);
}

static void add_weighted(float *to, const float *from, float weight, int count) {
    for (int k = 0; k < count; k++) to[k] += weight * from[k];
}

// One row of the filtered ambient and bounced light.
static void filter_row(const FfpViewWork *w, int y, float *ambient, float *bounce) {
    const int width = w->view->camera.width, height = w->view->camera.height, r = filter_radius(w->sim),
              lanes = 3 * w->sim->light->lanes;
    for (int x = 0; x < width; x++) {
        const size_t i = (size_t)y * (size_t)width + (size_t)x;
        if (w->sums.hits[i] <= 0) continue;
        float total = 0, *bounce_here = ffp_lanes_of(w, bounce, i);
        for (int v = y - r < 0 ? 0 : y - r; v <= y + r && v < height; v++)
            for (int u = x - r < 0 ? 0 : x - r; u <= x + r && u < width; u++) {
                const size_t j = (size_t)v * (size_t)width + (size_t)u;
                const float weight = neighbour_weight(&w->sums, i, j);
                if (weight <= 0) continue;
                total += weight;
                add_weighted(ambient + 3 * i, w->sums.ambient + 3 * j, weight, 3);
                add_weighted(bounce_here, ffp_lanes_of(w, w->sums.bounce, j), weight, lanes);
            }
        divide_sums(ambient + 3 * i, 3, total);
        divide_sums(bounce_here, lanes, total);
    }
}

static void smooth_indirect(FfpViewWork *w) {
    ffp_cancel_point();
    if (filter_radius(w->sim) == 0) return;
    const int height = w->view->camera.height;
    const size_t pixels = (size_t)w->view->camera.width * (size_t)height;
    float *ambient = ffp_alloc(pixels * 3, sizeof(float));
    float *bounce = ffp_alloc(pixels * 3 * (size_t)w->sim->light->lanes, sizeof(float));
#pragma omp parallel for schedule(static)
    for (int y = 0; y < height; y++) filter_row(w, y, ambient, bounce);
    ffp_free(w->sums.ambient);
    ffp_free(w->sums.bounce);
    w->sums.ambient = ambient;
    w->sums.bounce = bounce;
}

// The light of a pixel: direct and indirect; of an object alone its own, whatever share of the pixel it has.
static void light_pixel(const FfpViewWork *w, size_t pixel, int pattern) {
    real *colour = w->view->images[pattern].data + 3 * pixel;
    const real *albedo = w->view->albedo.data + 3 * pixel, cover = (real)w->sums.share[pixel];
    const int lanes = w->sim->light->lanes, lane = w->sim->light->lane[pattern];
    const float *ambient = w->sums.ambient + 3 * pixel;
    const float *direct = ffp_lanes_of(w, w->sums.direct, pixel),
                *bounce = ffp_lanes_of(w, w->sums.bounce, pixel);
    for (int c = 0; c < 3; c++) {
        const int at = c * lanes + lane;
        const float lit = lane < 0 ? 0 : direct[at], incoming = ambient[c] + (lane < 0 ? 0 : bounce[at]);
        const float own = (float)(lit + albedo[c] * incoming);
        colour[c] = (real)(w->sim->photograph ? (float)cover * own : own);
    }
}

// The camera's lens on the light of a picture. Of an object alone it is the light of its share of the pixels.
static void see_picture(const FfpViewWork *w, int pattern) {
    FfpImage *image = &w->view->images[pattern];
    const size_t values = (size_t)image->width * (size_t)image->height * 3;
    for (size_t i = 0; i < values && !w->sim->photograph; i++) image->data[i] *= (real)w->sums.share[i / 3];
    ffp_sensor_see(image, w->sim->sensor, &w->view->camera);
    for (size_t i = 0; i < values && !w->sim->photograph; i++)
        image->data[i] = w->sums.share[i / 3] > 0 ? image->data[i] / (real)w->sums.share[i / 3] : 0;
}

// Adds the noise, and passes the colour through what a PNG would keep of it. `decoded`: the linear values of
// the 256 there are.
static void record_pixel(const FfpViewWork *w, size_t pixel, int pattern, const real decoded[256]) {
    real *colour = w->view->images[pattern].data + 3 * pixel;
    const real cover = (real)w->sums.share[pixel];
    const uint32_t key = (uint32_t)(w->sim->first_pattern + pattern) + 1;
    const bool whole = w->sim->photograph; // the pixel's light, not the share that is the object's
    for (int c = 0; c < 3; c++) {
        const float light = (float)colour[c];
        const float seen = ffp_sensor_noise(light, w->sim->shot, w->sim->read,
                                            (uint32_t)(3 * pixel) + (uint32_t)c, w->seed + 0x3c6ef372U * key);
        const float encoded = roundf(255 * (float)ffp_srgb_encode((real)seen));
        colour[c] =
            cover == 1 || whole ? decoded[(int)encoded] : ffp_srgb_decode((real)(encoded / 255) * cover);
    }
}

// Pixels without light are left as they are, but for those of a photograph.
static void compose_row(const FfpViewWork *w, int y, const real *decoded) {
    const int width = w->view->camera.width;
    for (int x = 0; x < width; x++) {
        const size_t pixel = (size_t)y * (size_t)width + (size_t)x;
        if (w->sums.hits[pixel] <= 0 && !w->sim->photograph) continue;
        for (int p = 0; p < w->sim->light->n_patterns; p++)
            if (decoded)
                record_pixel(w, pixel, p, decoded);
            else
                light_pixel(w, pixel, p);
    }
}

static void compose(const FfpViewWork *w) {
    const int height = w->view->camera.height;
    real decoded[256];
    for (int i = 0; i < 256; i++) decoded[i] = ffp_srgb_decode((real)i / 255);
#pragma omp parallel for schedule(static)
    for (int y = 0; y < height; y++) compose_row(w, y, NULL);
    if (w->sim->light_only) return;
    for (int p = 0; p < w->sim->light->n_patterns; p++)
        if (w->sim->sensor && ffp_sensor_has_lens(w->sim->sensor)) see_picture(w, p);
#pragma omp parallel for schedule(static)
    for (int y = 0; y < height; y++) compose_row(w, y, decoded);
}

static void work_begin(FfpViewWork *w) {
    const size_t pixels = (size_t)w->view->camera.width * (size_t)w->view->camera.height,
                 lanes = (size_t)w->sim->light->lanes;
    w->sums.direct = ffp_alloc(pixels * 3 * lanes, sizeof(float));
    w->sums.bounce = ffp_alloc(pixels * 3 * lanes, sizeof(float));
    w->sums.ambient = ffp_alloc(pixels * 3, sizeof(float));
    w->sums.point = ffp_alloc(pixels * 3, sizeof(float));
    w->sums.smooth = ffp_alloc(pixels * 3, sizeof(float));
    w->sums.hits = ffp_alloc(pixels, sizeof(float));
    w->sums.share = ffp_alloc(pixels, sizeof(float));
}

static void work_end(FfpViewWork *w) {
    ffp_free(w->sums.direct);
    ffp_free(w->sums.bounce);
    ffp_free(w->sums.ambient);
    ffp_free(w->sums.point);
    ffp_free(w->sums.smooth);
    ffp_free(w->sums.hits);
    ffp_free(w->sums.share);
}

static float focus_of(const FfpViewWork *w) {
    const float origin = -ffp_along(w->projector.axes + 6, w->projector.origin);
    return w->sim->sensor ? w->sim->sensor->focus_at * origin : 0;
}

void ffp_simulate_view(const FfpSimulation *simulation, FfpView *view, uint32_t stream,
                       FfpImage *visibility) {
    const int width = view->camera.width, height = view->camera.height;
    const int n_patterns = simulation->light->n_patterns;
    view->images = ffp_alloc((size_t)n_patterns, sizeof *view->images);
    for (int p = 0; p < n_patterns; p++) view->images[p] = ffp_image_new(width, height, 3);
    view->coverage = ffp_image_new(width, height, 1);
    view->depth = ffp_image_new(width, height, 1);
    view->normal = ffp_image_new(width, height, 3);
    view->albedo = ffp_image_new(width, height, 3);
    view->roughness = ffp_image_new(width, height, 1);
    view->direct_white = ffp_image_new(width, height, 3);
    if (visibility) *visibility = ffp_image_new(width, height, 1);
    FfpViewWork w = {.sim = simulation,
                     .view = view,
                     .visibility = visibility,
                     .camera = ffp_device_of(&view->camera, simulation->camera_lens),
                     .projector = ffp_device_of(&view->projector, simulation->projector_lens),
                     .seed =
                         ffp_hash32((uint32_t)simulation->seed ^
                                    ffp_hash32((uint32_t)(simulation->seed >> 32) ^ ffp_hash32(stream + 1)))};
    w.focus = focus_of(&w);
    work_begin(&w);
    trace_all(&w);
    smooth_indirect(&w);
    compose(&w);
    work_end(&w);
}
