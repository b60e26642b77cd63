// The networks of a chunk, and what is held for a step.
#include "lab/baselines/chunk.h"
#include <string.h>
#include <tgmath.h>
#include "core/base/alloc.h"
#include "lab/baselines/kernels/kernels.h"

enum {
    ROW = FFP_CHUNK_ROW,
    EXPLORING = 8 // one of so many rays also looks where the grid says that there is nothing: else a surface
                  // that was lost would never come back
};

static real *rows(int count) {
    return ffp_alloc((size_t)count * ROW, sizeof(real));
}

FfpFieldChunk ffp_field_chunk_new(const FfpFieldLayout *layout) {
    FfpFieldChunk c = {.rays = ffp_alloc(FFP_CHUNK_RAYS, sizeof *c.rays),
                       .distance = rows(1),
                       .held = rows(1),
                       .position = rows(3),
                       .encoded = rows(FFP_FIELD_ENCODED),
                       .geometry = rows(FFP_GEOMETRY_OUTPUTS),
                       .material = rows(FFP_MATERIAL_OUTPUTS),
                       .d_encoded = rows(FFP_FIELD_ENCODED),
                       .d_geometry = rows(FFP_GEOMETRY_OUTPUTS),
                       .d_material = rows(FFP_MATERIAL_OUTPUTS),
                       .look_position = rows(3),
                       .look_encoded = rows(FFP_FIELD_ENCODED + FFP_FIELD_DIRECTION),
                       .look = rows(1),
                       .look_target = rows(1),
                       .d_look = rows(1),
                       .d_look_encoded = rows(FFP_FIELD_ENCODED)};
    for (int i = 0; i < 3; i++) c.hidden[i] = rows(FFP_FIELD_WIDTH);
    for (int i = 0; i < 2; i++) {
        c.scratch[i] = rows(FFP_FIELD_WIDTH);
        c.look_hidden[i] = rows(FFP_FIELD_WIDTH);
    }
    c.gradient = ffp_alloc((size_t)(layout->count - layout->grid), sizeof(real));
    return c;
}

void ffp_field_chunk_free(FfpFieldChunk *c) {
    void *const all[] = {
        c->rays,      c->distance,    c->held,       c->position,       c->encoded,        c->geometry,
        c->material,  c->d_encoded,   c->d_geometry, c->d_material,     c->look_position,  c->look_encoded,
        c->look,      c->look_target, c->d_look,     c->d_look_encoded, c->hidden[0],      c->hidden[1],
        c->hidden[2], c->scratch[0],  c->scratch[1], c->look_hidden[0], c->look_hidden[1], c->gradient};
    for (size_t i = 0; i < sizeof all / sizeof *all; i++) ffp_free(all[i]);
    *c = (FfpFieldChunk){0};
}

// --- Rays. ---

void ffp_field_chunk_place(FfpFieldChunk *c, const FfpChunkRay *ray) {
    for (int i = 0; i < ray->count; i++)
        for (int k = 0; k < 3; k++)
            c->position[k * ROW + ray->first + i] =
                ray->ray.origin[k] + c->distance[ray->first + i] * ray->ray.direction[k];
}

void ffp_field_chunk_draw(FfpFieldChunk *c, const FfpNeuralField *field, const FfpFieldScene *scene,
                          int n_rays, FfpRng *rng) {
    const FfpCapture *capture = scene->capture;
    c->n_rays = 0;
    c->points = 0;
    for (int i = 0; i < n_rays && i < FFP_CHUNK_RAYS; i++) {
        if (c->points + FFP_FIELD_ON_RAY > FFP_CHUNK_POINTS) break;
        FfpChunkRay *ray = &c->rays[c->n_rays++];
        ray->view = (int)ffp_rng_below(rng, (uint32_t)capture->n_views);
        ray->pixel = scene->pixels[ray->view][ffp_rng_below(rng, (uint32_t)scene->counts[ray->view])];
        const FfpCamera *camera = &capture->views[ray->view].camera;
        ray->ray = ffp_field_ray(camera, (real)(ray->pixel % camera->width) + 0.5F,
                                 (real)(ray->pixel / camera->width) + 0.5F);
        ray->first = c->points;
        ray->count = ffp_field_march(field, &ray->ray, ffp_rng_uniform(rng), i % EXPLORING == 0,
                                     c->distance + c->points);
        ffp_field_chunk_place(c, ray);
        c->points += ray->count;
    }
}

static FfpNetRows geometry_rows(const FfpFieldChunk *c) {
    return (FfpNetRows){.stride = ROW,
                        .columns = ffp_field_padded(c->points),
                        .in = c->encoded,
                        .hidden = {c->hidden[0]},
                        .out = c->geometry};
}

static FfpNetRows material_rows(const FfpFieldChunk *c) {
    return (FfpNetRows){.stride = ROW,
                        .columns = ffp_field_padded(c->points),
                        .in = c->encoded,
                        .hidden = {c->hidden[1], c->hidden[2]},
                        .out = c->material};
}

static FfpNetRows look_rows(const FfpFieldChunk *c) {
    return (FfpNetRows){.stride = ROW,
                        .columns = ffp_field_padded(c->looks),
                        .in = c->look_encoded,
                        .hidden = {c->look_hidden[0], c->look_hidden[1]},
                        .out = c->look};
}

static void look_forward(FfpFieldChunk *c, const FfpNeuralField *field) {
    const FfpFieldKernels *k = ffp_field_kernels();
    const FfpNetRows look = look_rows(c);
    k->encode(&field->layout, field->parameters, c->look_position, c->looks, ROW, c->look_encoded);
    k->forward(&field->layout.visibility, field->parameters, &look);
}

void ffp_field_chunk_forward(FfpFieldChunk *c, const FfpNeuralField *field) {
    const FfpFieldKernels *k = ffp_field_kernels();
    const FfpNetRows geometry = geometry_rows(c), material = material_rows(c);
    k->encode(&field->layout, field->parameters, c->position, c->points, ROW, c->encoded);
    k->forward(&field->layout.geometry, field->parameters, &geometry);
    k->forward(&field->layout.material, field->parameters, &material);
    if (c->looks > 0) look_forward(c, field);
}

void ffp_field_chunk_backward(FfpFieldChunk *c, const FfpNeuralField *field) {
    const FfpFieldKernels *k = ffp_field_kernels();
    const FfpFieldLayout *layout = &field->layout;
    const FfpNetRows geometry = geometry_rows(c), material = material_rows(c), look = look_rows(c);
    real *grad = c->gradient - layout->grid; // numbers of parameters begin with the grid's
    memset(c->gradient, 0, (size_t)(layout->count - layout->grid) * sizeof(real));
    k->backward(&layout->geometry, field->parameters, &geometry, c->d_geometry, FFP_FIELD_ENCODED, false,
                c->d_encoded, c->scratch, grad);
    k->backward(&layout->material, field->parameters, &material, c->d_material, FFP_FIELD_ENCODED, true,
                c->d_encoded, c->scratch, grad);
    k->backward(&layout->visibility, field->parameters, &look, c->d_look, FFP_FIELD_ENCODED, false,
                c->d_look_encoded, c->scratch, grad);
}

// --- What is held. ---

static void hold_weights(FfpFieldChunk *c, const FfpNeuralField *field, FfpChunkRay *ray) {
    real through = 1, depth = 0;
    for (int i = 0; i < ray->count; i++) {
        const int64_t p = ray->first + i;
        const real density = ffp_field_density(c->geometry[FFP_GEOMETRY_DENSITY * ROW + p]);
        const real alpha = 1 - exp(-density * field->step);
        c->held[p] = through * alpha;
        depth += c->held[p] * c->distance[p];
        through *= 1 - alpha;
    }
    ray->opacity = 1 - through;
    ray->depth = ray->opacity > 0 ? depth / ray->opacity : 0;
}

static void surface_of(const FfpChunkRay *ray, real point[3]) {
    for (int k = 0; k < 3; k++) point[k] = ray->ray.origin[k] + ray->depth * ray->ray.direction[k];
}

// A place where a projector might stand.
static void anywhere(FfpRng *rng, real lamp[3]) {
    do {
        for (int k = 0; k < 3; k++) lamp[k] = ffp_rng_range(rng, -1, 1);
    } while (!(ffp_dot3(lamp, lamp) > 0.01F) || ffp_dot3(lamp, lamp) > 1);
    ffp_normalise3(lamp);
    const real away = ffp_rng_range(rng, 1.7F, 2.6F);
    for (int k = 0; k < 3; k++) lamp[k] *= away;
}

static void look_at(FfpFieldChunk *c, const real point[3], const real lamp[3]) {
    const int64_t at = c->looks++;
    real direction[3];
    for (int k = 0; k < 3; k++) {
        c->look_position[k * ROW + at] = point[k];
        direction[k] = lamp[k] - point[k];
    }
    ffp_normalise3(direction);
    ffp_field_direction(direction, ROW, c->look_encoded + FFP_FIELD_ENCODED * ROW + at);
}

// Columns that nobody asks for are looked at all the same.
static void fill_up_looks(FfpFieldChunk *c) {
    for (int64_t i = c->looks; i < ffp_field_padded(c->looks); i++)
        ffp_field_direction((const real[3]){0, 0, 1}, ROW, c->look_encoded + FFP_FIELD_ENCODED * ROW + i);
}

static void hold_look(FfpFieldChunk *c, const FfpNeuralField *field, const real point[3],
                      const real lamp[3]) {
    c->look_target[c->looks] = ffp_field_transmittance(field, point, lamp);
    look_at(c, point, lamp);
}

static void hold_looks(FfpFieldChunk *c, const FfpNeuralField *field, const FfpFieldScene *scene,
                       FfpRng *rng) {
    c->looks = 0;
    for (int r = 0; r < c->n_rays; r++) {
        const real *pose = scene->capture->views[c->rays[r].view].projector.pose;
        const real lamp[3] = {pose[3], pose[7], pose[11]};
        real point[3], other[3];
        surface_of(&c->rays[r], point);
        anywhere(rng, other);
        hold_look(c, field, point, lamp);
        hold_look(c, field, point, other);
    }
    fill_up_looks(c);
    look_forward(c, field);
    for (int r = 0; r < c->n_rays; r++)
        c->rays[r].visibility = ffp_field_sigmoid(c->look[(int64_t)FFP_CHUNK_LOOKS * r]);
}

// Normals of the density: against the slope of what a step's length of it holds back, by differences between
// four corners of a tetrahedron around the surface. The memory of the looks is free for it before them.
static void hold_normals(FfpFieldChunk *c, const FfpNeuralField *field) {
    static const real corner[4][3] = {{1, -1, -1}, {-1, -1, 1}, {-1, 1, -1}, {1, 1, 1}};
    const FfpFieldKernels *k = ffp_field_kernels();
    const real reach = 0.01F;
    int64_t count = 0;
    for (int r = 0; r < c->n_rays; r++) {
        real point[3];
        c->rays[r].probed = r % FFP_CHUNK_PROBED == 0 && c->rays[r].opacity > 0.5F;
        if (!c->rays[r].probed) continue;
        surface_of(&c->rays[r], point);
        for (int i = 0; i < 4; i++, count++)
            for (int a = 0; a < 3; a++) c->look_position[a * ROW + count] = point[a] + reach * corner[i][a];
    }
    const FfpNetRows probe = {.stride = ROW,
                              .columns = ffp_field_padded(count),
                              .in = c->look_encoded,
                              .hidden = {c->scratch[0]},
                              .out = c->d_geometry};
    k->encode(&field->layout, field->parameters, c->look_position, count, ROW, c->look_encoded);
    k->forward(&field->layout.geometry, field->parameters, &probe);
    const real *raw = c->d_geometry + FFP_GEOMETRY_DENSITY * ROW;
    for (int r = 0; r < c->n_rays; r++) {
        FfpChunkRay *ray = &c->rays[r];
        if (!ray->probed) continue;
        for (int a = 0; a < 3; a++) ray->normal[a] = 0;
        for (int i = 0; i < 4; i++, raw++)
            for (int a = 0; a < 3; a++)
                ray->normal[a] += corner[i][a] * exp(-ffp_field_density(*raw) * field->step);
        ray->probed = ffp_normalise3(ray->normal) > 1e-4F;
    }
}

void ffp_field_chunk_hold(FfpFieldChunk *c, const FfpNeuralField *field, const FfpFieldScene *scene,
                          FfpRng *rng) {
    for (int r = 0; r < c->n_rays; r++) hold_weights(c, field, &c->rays[r]);
    hold_normals(c, field);
    hold_looks(c, field, scene, rng);
}

void ffp_field_chunk_see(FfpFieldChunk *c, const FfpNeuralField *field, const real lamp[3]) {
    c->looks = 0;
    ffp_field_chunk_forward(c, field);
    for (int r = 0; r < c->n_rays; r++) {
        real point[3];
        hold_weights(c, field, &c->rays[r]);
        surface_of(&c->rays[r], point);
        look_at(c, point, lamp);
    }
    fill_up_looks(c);
    look_forward(c, field);
    for (int r = 0; r < c->n_rays; r++) c->rays[r].visibility = ffp_field_sigmoid(c->look[r]);
}
