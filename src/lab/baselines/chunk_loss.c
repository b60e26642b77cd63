// The loss of a chunk's rays, and back to what the networks put out.
#include <string.h>
#include <tgmath.h>
#include "core/base/alloc.h"
#include "engine/render/resolve_pixel.h"
#include "lab/baselines/chunk.h"

enum { ROW = FFP_CHUNK_ROW, COVERAGE_SIDE = 2 }; // any side above 1: the opacity tells the coverage

// One point of the ray at hand.
typedef struct Point {
    FfpFieldPoint says;
    FfpLit lit;
    bool is_lit;
    real factor[3], A[3];
    real weight, through; // W, and the transmittance behind the point
    bool on_pattern;
    real uv[2], extent;
    FfpFieldPointGrad d;
    real d_weight, dA[3];
    real texture[3]; // of the pattern at hand
} Point;

// A ray, and what it is compared with.
typedef struct Ray {
    const FfpChunkRay *at;
    const FfpView *view;
    int count;
    Point point[FFP_FIELD_ON_RAY];
    real opacity, d_opacity;
} Ray;

static void look_up(const FfpFieldPattern *pattern, Point *p) {
    real *out = p->texture;
    out[0] = out[1] = out[2] = 0;
    if (!p->on_pattern) return;
    if (pattern->flat)
        memcpy(p->texture, pattern->colour, sizeof p->texture);
    else
        ffp_box_mean(&pattern->summed, p->uv[0], p->uv[1], p->extent, p->extent, out);
}

static void light_point(const FfpFieldChunk *c, const FfpNeuralField *field, const FfpFieldScene *scene,
                        Ray *ray, int i, real *through) {
    const int64_t at = ray->at->first + i;
    const real place[3] = {c->position[at], c->position[ROW + at], c->position[2 * ROW + at]};
    const FfpView *view = ray->view;
    Point *p = &ray->point[i];
    const real density = ffp_field_density(c->geometry[FFP_GEOMETRY_DENSITY * ROW + at]);
    const real alpha = 1 - exp(-density * field->step);
    p->weight = *through * alpha;
    *through *= 1 - alpha;
    p->through = *through;
    p->says = ffp_field_point(c->geometry + at, c->material + at, ROW, place);
    p->is_lit = ffp_field_lit(&p->says, place, ray->at->ray.direction, &view->projector,
                              scene->capture->intensity, ray->at->visibility, &p->lit, p->factor, p->A);
    const real across = c->distance[at] * ray->at->ray.ahead / view->camera.fx;
    p->on_pattern = p->is_lit && ffp_field_texel(&view->projector, place, across, p->uv, &p->extent);
    p->d = (FfpFieldPointGrad){0};
    p->d_weight = 0;
    for (int k = 0; k < 3; k++) p->dA[k] = 0;
}

// One pattern's picture of the ray, compared: half the square of the difference, as smooth L1 is of numbers
// up to 1, a mean over the channels and patterns that count.
static void compare_pattern(FfpFieldChunk *c, const FfpFieldScene *scene, Ray *ray, int pattern,
                            real weight) {
    const FfpImage *truth = &ray->view->images[scene->chosen[pattern]];
    const real *wanted = truth->data + 3 * (size_t)ray->at->pixel;
    const FfpFieldPattern *shown = &scene->patterns[pattern];
    real mean[3] = {0, 0, 0}, picture[3], grad[3], d_mean[3];
    for (int i = 0; i < ray->count; i++) {
        Point *p = &ray->point[i];
        look_up(shown, p);
        for (int k = 0; k < 3; k++) mean[k] += p->weight * (p->says.ambient[k] + p->A[k] * p->texture[k]);
    }
    ffp_resolve_pixel(mean, ray->opacity, COVERAGE_SIDE, picture);
    for (int k = 0; k < 3; k++) {
        const real off = picture[k] - ffp_srgb_encode(wanted[k]);
        grad[k] = weight * off;
        c->loss.pictures += (double)(weight * off * off / 2);
        c->loss.square += (double)(off * off);
    }
    c->loss.numbers += 3;
    ffp_resolve_pixel_backward(mean, ray->opacity, COVERAGE_SIDE, grad, d_mean, &ray->d_opacity);
    for (int i = 0; i < ray->count; i++) {
        Point *p = &ray->point[i];
        for (int k = 0; k < 3; k++) {
            p->d_weight += d_mean[k] * (p->says.ambient[k] + p->A[k] * p->texture[k]);
            p->d.ambient[k] += d_mean[k] * p->weight;
            p->dA[k] += d_mean[k] * p->weight * p->texture[k];
        }
    }
}

// Normals that look away from the camera (Verbin et al. 2022, Eq. 11) or not along the density's (Eq. 10).
// The weights are held.
static void compare_normals(FfpFieldChunk *c, const FfpFieldSettings *s, Ray *ray, real per_ray) {
    for (int i = 0; i < ray->count; i++) {
        Point *p = &ray->point[i];
        const real held = c->held[ray->at->first + i] * per_ray;
        const real away = ffp_dot3(p->says.normal, ray->at->ray.direction);
        if (away > 0) {
            c->loss.facing += (double)(s->facing * held * away * away);
            for (int k = 0; k < 3; k++)
                p->d.normal[k] += 2 * s->facing * held * away * ray->at->ray.direction[k];
        }
        for (int k = 0; k < 3 && ray->at->probed; k++) {
            const real off = p->says.normal[k] - ray->at->normal[k];
            c->loss.match += (double)(s->match * held * off * off);
            p->d.normal[k] += 2 * s->match * held * off;
        }
    }
}

// From dW to the densities: with W_i = T_i alpha_i, dL/d density_i = step (T_{i+1} dW_i - sum_{j>i} W_j
// dW_j).
static void ray_backward(FfpFieldChunk *c, const FfpNeuralField *field, Ray *ray) {
    real behind = 0;
    for (int i = ray->count - 1; i >= 0; i--) {
        Point *p = &ray->point[i];
        const int64_t at = ray->at->first + i;
        const real d_weight = p->d_weight + ray->d_opacity,
                   raw = c->geometry[FFP_GEOMETRY_DENSITY * ROW + at];
        const real d_density = field->step * (p->through * d_weight - behind);
        behind += p->weight * d_weight;
        if (p->is_lit) ffp_field_lit_backward(&p->lit, p->factor, p->dA, &p->d);
        ffp_field_point_backward(&p->says, c->material + at, &p->d, ROW, c->d_geometry + at,
                                 c->d_material + at);
        c->d_geometry[FFP_GEOMETRY_DENSITY * ROW + at] =
            raw < FFP_FIELD_LOG_MAX ? d_density * ffp_field_density(raw) : 0;
    }
}

static void ray_loss(FfpFieldChunk *c, const FfpNeuralField *field, const FfpFieldScene *scene,
                     const FfpFieldSettings *s, int n_patterns, real per_ray, Ray *ray) {
    real through = 1;
    ray->count = ray->at->count;
    ray->d_opacity = 0;
    for (int i = 0; i < ray->count; i++) light_point(c, field, scene, ray, i, &through);
    ray->opacity = 1 - through;
    for (int p = 0; p < n_patterns; p++) compare_pattern(c, scene, ray, p, per_ray / (real)(3 * n_patterns));
    const real off = ray->opacity - ray->view->coverage.data[ray->at->pixel];
    c->loss.mask += (double)(s->mask * per_ray * off * off / 2);
    ray->d_opacity += s->mask * per_ray * off;
    compare_normals(c, s, ray, per_ray);
    ray_backward(c, field, ray);
}

// The visibility network beside the transmittance that the densities have.
static void look_loss(FfpFieldChunk *c, const FfpFieldSettings *s, real per_ray) {
    for (int64_t i = 0; i < c->looks; i++) {
        const FfpChunkRay *ray = &c->rays[i / FFP_CHUNK_LOOKS];
        const real weight = ray->opacity > 0.5F ? s->visibility * per_ray / FFP_CHUNK_LOOKS : 0;
        const real value = ffp_field_sigmoid(c->look[i]), off = value - c->look_target[i];
        c->loss.visibility += (double)(weight * off * off / 2);
        c->d_look[i] = weight * off * value * (1 - value);
    }
}

// 0 in the columns that only fill up.
static void clear_padding(real *d, int count, int64_t from) {
    for (int r = 0; r < count; r++)
        for (int64_t i = from; i < ROW; i++) d[r * ROW + i] = 0;
}

void ffp_field_chunk_loss(FfpFieldChunk *c, const FfpNeuralField *field, const FfpFieldScene *scene,
                          const FfpFieldSettings *settings, int n_patterns, real per_ray) {
    Ray ray;
    c->loss = (FfpChunkLoss){0};
    for (int r = 0; r < c->n_rays; r++) {
        ray.at = &c->rays[r];
        ray.view = &scene->capture->views[ray.at->view];
        ray_loss(c, field, scene, settings, n_patterns, per_ray, &ray);
    }
    look_loss(c, settings, per_ray);
    clear_padding(c->d_geometry, FFP_GEOMETRY_OUTPUTS, c->points);
    clear_padding(c->d_material, FFP_MATERIAL_OUTPUTS, c->points);
    clear_padding(c->d_look, 1, c->looks);
}
