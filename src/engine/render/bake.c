#include "engine/render/bake.h"
#include <tgmath.h>
#include "core/base/brdf.h"
#include "core/image/lookup_box.h"
#include "engine/render/map_pixel.h"
#include "engine/render/shade_pixel.h"

#define BOX_SIDE 3.46410162F // a box of this many deviations has their variance: sqrt(12)

typedef struct Place { // a Gaussian as the projector sees it
    real centre[3], n[3], l[3], v[3];
    real distance, cosine, nl, nv, uv[2], depth, side; // cosine: n.l, or 1 in even light
} Place;

static void towards(const real from[3], const real to[3], real out[3], real *distance) {
    for (int k = 0; k < 3; k++) out[k] = to[k] - from[k];
    *distance = ffp_normalise3(out);
}

// False where the projector's light does not reach: behind it, beside its pattern, or on a side turned away.
// `even`: FfpMapping.even.
static bool find_place(const FfpGaussians *g, int64_t i, const FfpBakeLight *light, real even, Place *p) {
    const real *scale = g->scale + 3 * i, *pose = light->projector->pose;
    const real from[3] = {pose[3], pose[7], pose[11]};
    int shortest = 0;
    real unused, axes[9];
    for (int k = 0; k < 3; k++) p->centre[k] = g->centre[3 * i + k];
    for (int k = 1; k < 3; k++) shortest = scale[k] < scale[shortest] ? k : shortest;
    ffp_quaternion_matrix(g->rotation + 4 * i, axes);
    for (int k = 0; k < 3; k++) p->n[k] = axes[3 * k + shortest];
    towards(p->centre, from, p->l, &p->distance);
    if (light->eye)
        towards(p->centre, light->eye, p->v, &unused);
    else
        for (int k = 0; k < 3; k++) p->v[k] = p->l[k];
    const real turn = ffp_dot3(p->n, p->v) < 0 ? -1 : 1;
    for (int k = 0; k < 3; k++) p->n[k] *= turn;
    p->nl = ffp_dot3(p->n, p->l);
    p->nv = ffp_dot3(p->n, p->v);
    p->cosine = p->nl;
    if (even > 0) {
        p->distance = even;
        p->cosine = 1;
        p->nl = fmax(p->nl, FFP_COSINE_MIN);
    }
    p->depth = ffp_project(light->projector, p->centre, &p->uv[0], &p->uv[1]);
    const real a = scale[(shortest + 1) % 3], b = scale[(shortest + 2) % 3];
    p->side = BOX_SIDE * sqrt((a * a + b * b) / 2) * light->projector->fx / p->depth;
    return p->nl > 0 && p->depth > 0 && p->uv[0] >= 0 && p->uv[1] >= 0 &&
           p->uv[0] <= (real)light->projector->width && p->uv[1] <= (real)light->projector->height;
}

static real specular(const Place *p, real roughness) {
    const real rho = roughness > FFP_ROUGHNESS_MIN ? roughness : FFP_ROUGHNESS_MIN;
    return p->nv > 0 ? ffp_brdf_specular(p->n, p->l, p->v, rho) : 0;
}

static void bake_one(const FfpGaussians *g, int64_t i, const FfpBakeLight *light, const FfpMapper *mapper,
                     real even, real out[3]) {
    Place p = {0};
    real texture[3];
    for (int k = 0; k < 3; k++) out[k] = g->ambient[3 * i + k];
    if (!find_place(g, i, light, even, &p)) return;
    const real through = mapper->shadow.width ? ffp_light_through(mapper, p.uv, p.depth) : 1;
    const real side = mapper->settings->footprint && p.side > 1 ? p.side : 1;
    ffp_box_mean(light->pattern, p.uv[0], p.uv[1], side, side, texture);
    const real lobe = light->eye ? specular(&p, g->roughness[i]) : 0;
    for (int k = 0; k < 3; k++) {
        const real arriving =
            through * light->intensity[k] / (p.distance * p.distance) * texture[k] * p.cosine;
        out[k] += (g->albedo[3 * i + k] / FFP_PI + lobe) * arriving;
    }
}

void ffp_bake(const FfpGaussians *gaussians, const FfpBakeLight *light, const FfpRenderSettings *settings,
              real *out) {
    FfpRaster *raster = ffp_raster_new();
    const FfpMapper mapper = {.projector = light->projector,
                              .settings = settings,
                              .shadow = ffp_shadow_map(raster, gaussians, light->projector, settings)};
    const real even = ffp_even_light(gaussians, light->projector, settings);
#pragma omp parallel for schedule(static)
    for (int64_t i = 0; i < gaussians->count; i++) bake_one(gaussians, i, light, &mapper, even, out + 3 * i);
    ffp_raster_free(raster);
}
