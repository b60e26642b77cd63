// A random but valid capture and start, filled by hand: the network's tests need no files and no matching.
#ifndef FFP_TESTS_NETWORK_SCENE_H
#define FFP_TESTS_NETWORK_SCENE_H

#include <tgmath.h>
#include "core/base/arena.h"
#include "core/base/rng.h"
#include "core/base/vec.h"
#include "core/capture/capture.h"
#include "engine/match/match.h"
#include "engine/network/network.h"
#include "support.h"

typedef struct Scene {
    FfpArena *arena;
    FfpCapture capture;
    FfpInitialisation start;
    FfpPixelContext context; // of a test that makes one
} Scene;

enum { SCENE_ACTIVE = 2 };

static inline real *random_map(Scene *s, FfpRng *rng, int64_t count, real low, real high) {
    real *map = ffp_arena_alloc(s->arena, (size_t)count, sizeof(real));
    for (int64_t i = 0; i < count; i++) map[i] = (real)ffp_rng_range(rng, (float)low, (float)high);
    return map;
}

// On a circle of radius 3 around the origin, looking at it, z up.
static inline FfpCamera circle_camera(int width, int height, double angle) {
    const real c = (real)cos(angle), s = (real)sin(angle);
    const real right[3] = {-s, c, 0}, down[3] = {0, 0, -1}, forward[3] = {-c, -s, 0};
    FfpCamera camera = {.width = width,
                        .height = height,
                        .fx = 1.4F * width,
                        .fy = 1.4F * width,
                        .cx = width / 2.0F,
                        .cy = height / 2.0F,
                        .pose = {[15] = 1}};
    for (int i = 0; i < 3; i++) {
        camera.pose[4 * i] = right[i];
        camera.pose[4 * i + 1] = down[i];
        camera.pose[4 * i + 2] = forward[i];
        camera.pose[4 * i + 3] = -3 * forward[i];
    }
    return camera;
}

static inline void fill_start(Scene *s, FfpRng *rng, int views, int width, int height) {
    const int64_t area = (int64_t)width * height, n = views * area;
    FfpInitialisation *start = &s->start;
    *start = (FfpInitialisation){.views = views,
                                 .width = width,
                                 .height = height,
                                 .t = random_map(s, rng, n, 0, 0),
                                 .confidence = random_map(s, rng, n, 0, 1),
                                 .lit = random_map(s, rng, n, 0, 1),
                                 .coverage = random_map(s, rng, n, -0.5F, 1),
                                 .agreement = random_map(s, rng, n, 0, 1),
                                 .violation = random_map(s, rng, n, 0, 1),
                                 .footprint = random_map(s, rng, n, 0.01F, 0.03F),
                                 .normal = random_map(s, rng, 3 * n, -1, 1),
                                 .albedo = random_map(s, rng, 3 * n, 0.05F, 0.9F),
                                 .ambient = random_map(s, rng, 3 * n, 0.05F, 0.9F)};
    for (int64_t p = 0; p < n; p++) {
        const FfpCamera *camera = &s->capture.views[p / area].camera;
        real d[3];
        ffp_pixel_ray(camera, p % width + 0.5F, p % area / width + 0.5F, d);
        const real origin[3] = {camera->pose[3], camera->pose[7], camera->pose[11]};
        start->t[p] = -ffp_dot3(origin, d) - (real)ffp_rng_range(rng, -0.3F, 0.9F);
        start->coverage[p] = fmax(start->coverage[p], (real)0); // about a third is background
        ffp_normalise3(start->normal + 3 * p);
    }
}

static inline void scene_new(Scene *s, int views, int width, int height, uint64_t seed) {
    FfpRng rng = ffp_rng(seed, 1);
    *s = (Scene){.arena = ffp_arena_new()};
    FfpCapture *c = &s->capture;
    snprintf(c->name, sizeof c->name, "scene");
    c->n_patterns = 3;
    c->n_views = views;
    c->black = 0;
    c->white = 1;
    c->radius = 1;
    c->patterns = ffp_arena_alloc(s->arena, 3, sizeof *c->patterns);
    c->views = ffp_arena_alloc(s->arena, (size_t)views, sizeof *c->views);
    for (int i = 0; i < 3; i++) {
        snprintf(c->patterns[i].name, FFP_NAME_MAX, "pattern_%d", i);
        c->patterns[i].image = (FfpImage){4, 4, 3, random_map(s, &rng, 48, 0, 1)};
        c->intensity[i] = 8;
    }
    for (int v = 0; v < views; v++) {
        FfpView *view = &c->views[v];
        snprintf(view->id, sizeof view->id, "view_%d", v);
        view->camera = view->projector = circle_camera(width, height, 6.2831853 * v / views);
        view->images = ffp_arena_alloc(s->arena, 3, sizeof *view->images);
        for (int i = 0; i < 3; i++)
            view->images[i] = (FfpImage){width, height, 3, random_map(s, &rng, 3LL * width * height, 0, 1)};
        view->coverage = (FfpImage){width, height, 1, random_map(s, &rng, (int64_t)width * height, 1, 1)};
    }
    fill_start(s, &rng, views, width, height);
}

static inline void scene_free(Scene *s) {
    ffp_arena_free(s->arena);
}

// Moves every parameter off its first value, the zeros of the last layers too.
static inline void shake(FfpModel *model, uint64_t seed) {
    FfpRng rng = ffp_rng(seed, 2);
    for (int i = 0; i < model->n_parameters; i++) {
        const FfpParameter *p = &model->parameters[i];
        for (int64_t k = 0; k < p->count; k++)
            model->values[p->offset + k] += (p->rank == 2 ? 0.05F : 0.1F) * (real)ffp_rng_normal(&rng);
    }
}

#endif
