// Views of a field. Along the rays all is done once; what a pattern changes is the texture at each point.
#include <string.h>
#include <tgmath.h>
#include "core/base/alloc.h"
#include "core/base/call.h"
#include "engine/render/resolve_pixel.h"
#include "lab/baselines/chunk.h"
#include "lab/baselines/kernels/kernels.h"

#define LEAST_WEIGHT 1e-4F // of a point that is kept

typedef struct Kept { // a lit point
    int pixel;
    real uv[2], extent, light[3]; // W A
} Kept;

// Pixels that one thread draws at a time, and what it keeps of them.
typedef struct Part {
    Kept *kept;
    int64_t count, room;
} Part;

struct FfpFieldPass {
    int width, height, n_parts;
    Part *parts;
    FfpGbuffer gbuffer;
};

FfpFieldPass *ffp_field_pass_new(void) {
    return ffp_alloc(1, sizeof(FfpFieldPass));
}

static void clear(FfpFieldPass *pass) {
    for (int i = 0; i < pass->n_parts; i++) ffp_free(pass->parts[i].kept);
    ffp_free(pass->parts);
    if (pass->width) ffp_gbuffer_free(&pass->gbuffer);
    *pass = (FfpFieldPass){0};
}

void ffp_field_pass_free(FfpFieldPass *pass) {
    if (!pass) return;
    clear(pass);
    ffp_free(pass);
}

typedef struct Drawing {
    FfpFieldPass *pass;
    const FfpNeuralField *field;
    const FfpCamera *camera, *projector;
    const real *intensity;
    int rows; // of a part
} Drawing;

static void keep(Part *part, Kept kept) {
    if (part->count == part->room) {
        part->room = part->room ? 2 * part->room : 1024;
        part->kept = ffp_grow(part->kept, (size_t)part->room, sizeof *part->kept);
    }
    part->kept[part->count++] = kept;
}

static void add_point(const FfpFieldPass *pass, int pixel, const FfpFieldPoint *says, real weight, real z) {
    const FfpGbuffer *g = &pass->gbuffer;
    g->depth[pixel] += weight * z;
    g->roughness[pixel] += weight * says->roughness;
    for (int k = 0; k < 3; k++) {
        g->normal[3 * pixel + k] += weight * says->normal[k];
        g->albedo[3 * pixel + k] += weight * says->albedo[k];
        g->ambient[3 * pixel + k] += weight * says->ambient[k];
    }
}

static void draw_ray(const Drawing *d, Part *part, const FfpFieldChunk *c, const FfpChunkRay *ray) {
    real through = 1;
    for (int64_t p = ray->first; p < ray->first + ray->count; p++) {
        const real at[3] = {c->position[p], c->position[FFP_CHUNK_ROW + p],
                            c->position[2 * (int64_t)FFP_CHUNK_ROW + p]};
        const FfpFieldPoint says = ffp_field_point(c->geometry + p, c->material + p, FFP_CHUNK_ROW, at);
        const real weight = c->held[p], z = c->distance[p] * ray->ray.ahead;
        through -= weight;
        add_point(d->pass, ray->pixel, &says, weight, z);
        Kept kept = {.pixel = ray->pixel};
        FfpLit lit;
        real factor[3];
        if (weight < LEAST_WEIGHT ||
            !ffp_field_lit(&says, at, ray->ray.direction, d->projector, d->intensity, ray->visibility, &lit,
                           factor, kept.light) ||
            !ffp_field_texel(d->projector, at, z / d->camera->fx, kept.uv, &kept.extent))
            continue;
        for (int k = 0; k < 3; k++) kept.light[k] *= weight;
        keep(part, kept);
    }
    d->pass->gbuffer.opacity[ray->pixel] = 1 - through;
}

// As many pixels from `pixel` on as the chunk has room for; returns the next.
static int draw_some(const Drawing *d, Part *part, FfpFieldChunk *c, int pixel, int end) {
    c->n_rays = 0;
    c->points = 0;
    for (; pixel < end && c->n_rays < FFP_CHUNK_RAYS; pixel++) {
        if (c->points + FFP_FIELD_ON_RAY > FFP_CHUNK_POINTS) break;
        FfpChunkRay *ray = &c->rays[c->n_rays];
        ray->pixel = pixel;
        ray->first = c->points;
        ray->ray = ffp_field_ray(d->camera, (real)(pixel % d->camera->width) + 0.5F,
                                 (real)(pixel / d->camera->width) + 0.5F);
        ray->count = ffp_field_march(d->field, &ray->ray, 0.5F, false, c->distance + c->points);
        if (ray->count == 0) continue;
        ffp_field_chunk_place(c, ray);
        c->points += ray->count;
        c->n_rays++;
    }
    const real lamp[3] = {d->projector->pose[3], d->projector->pose[7], d->projector->pose[11]};
    ffp_field_chunk_see(c, d->field, lamp);
    for (int r = 0; r < c->n_rays; r++) draw_ray(d, part, c, &c->rays[r]);
    return pixel;
}

static void draw_part(void *argument, int64_t index) {
    const Drawing *d = argument;
    const int width = d->camera->width, first = (int)index * d->rows;
    const int last = first + d->rows < d->camera->height ? first + d->rows : d->camera->height;
    FfpFieldChunk chunk = ffp_field_chunk_new(&d->field->layout);
    for (int pixel = first * width; pixel < last * width;)
        pixel = draw_some(d, &d->pass->parts[index], &chunk, pixel, last * width);
    ffp_field_chunk_free(&chunk);
}

static FfpCamera in_field(const FfpNeuralField *field, const FfpCamera *device) {
    FfpCamera moved = *device;
    for (int k = 0; k < 3; k++)
        moved.pose[4 * k + 3] = (device->pose[4 * k + 3] - field->centre[k]) / field->radius;
    return moved;
}

void ffp_field_pass_draw(FfpFieldPass *pass, const FfpNeuralField *field, const FfpCamera *camera,
                         const FfpCamera *projector, const real intensity[3]) {
    enum { PARTS = 16 };
    const FfpCamera eye = in_field(field, camera), lamp = in_field(field, projector);
    const real square = field->radius * field->radius;
    const real there[3] = {intensity[0] / square, intensity[1] / square, intensity[2] / square};
    Drawing drawing = {pass, field, &eye, &lamp, there, (camera->height + PARTS - 1) / PARTS};
    clear(pass);
    pass->width = camera->width;
    pass->height = camera->height;
    pass->gbuffer = ffp_gbuffer_new(camera->width, camera->height);
    pass->parts = ffp_alloc(PARTS, sizeof *pass->parts);
    pass->n_parts = PARTS;
    ffp_parallel_for(PARTS, 0, draw_part, &drawing);
    for (int i = 0; i < camera->width * camera->height; i++) pass->gbuffer.depth[i] *= field->radius;
}

FfpImage ffp_field_pass_shade(const FfpFieldPass *pass, const FfpSummed *pattern) {
    FfpImage picture = ffp_image_new(pass->width, pass->height, 3);
    const size_t pixels = (size_t)pass->width * (size_t)pass->height;
    memcpy(picture.data, pass->gbuffer.ambient, 3 * pixels * sizeof(real));
    for (int i = 0; pattern && i < pass->n_parts; i++)
        for (int64_t n = 0; n < pass->parts[i].count; n++) {
            const Kept *kept = &pass->parts[i].kept[n];
            real texture[3];
            ffp_box_mean(pattern, kept->uv[0], kept->uv[1], kept->extent, kept->extent, texture);
            for (int k = 0; k < 3; k++) picture.data[3 * kept->pixel + k] += kept->light[k] * texture[k];
        }
    for (size_t i = 0; i < pixels; i++) {
        const real *at = picture.data + 3 * i, mean[3] = {at[0], at[1], at[2]};
        ffp_resolve_pixel(mean, pass->gbuffer.opacity[i], 2, picture.data + 3 * i);
    }
    return picture;
}

const FfpGbuffer *ffp_field_pass_gbuffer(const FfpFieldPass *pass) {
    return &pass->gbuffer;
}
