// Light that reaches samples by way of other surfaces: paths of diffuse bounces, with the light of projector,
// lamp and sky at each (Kajiya 1986; next-event estimation).
#include <math.h>
#include <string.h>
#include "world/synth/room.h"
#include "world/synth/simulate_work.h"

enum { BOUNCES = 1, ROOM_BOUNCES = 2 };
static const float CAVITY = 0.75F; // share of the ambient light that reaches the last of a path's surfaces
static const float BLUR = 0.03F;   // of a texture that is seen by way of another surface

// Rays that are traced side by side, each from its path's last surface on.
typedef struct Paths {
    FfpRays rays;
    float weight[FFP_RAYS][3]; // product of the albedos that a path has met
    uint32_t index[FFP_RAYS];  // by which its random numbers are drawn
} Paths;

// Two directions across the unit vector n (Duff et al. 2017).
static void basis(const float n[3], float t[3], float s[3]) {
    const float sign = copysignf(1, n[2]), a = -1 / (sign + n[2]), b = n[0] * n[1] * a;
    t[0] = 1 + sign * n[0] * n[0] * a, t[1] = sign * b, t[2] = -sign * n[0];
    s[0] = b, s[1] = sign + n[1] * n[1] * a, s[2] = -n[1];
}

// A cosine-weighted direction around the normal, turned above the facet where interpolation leads below it.
static void ambient_direction(const FfpHit *hit, float x, float y, float d[3]) {
    float t[3], s[3];
    basis(hit->normal, t, s);
    const float r = sqrtf(x), phi = 6.2831853F * y, up = sqrtf(ffp_max(0, 1 - x)), i = r * cosf(phi),
                j = r * sinf(phi);
    for (int k = 0; k < 3; k++) d[k] = i * t[k] + j * s[k] + up * hit->normal[k];
    const float below = ffp_along(d, hit->facet);
    for (int k = 0; k < 3 && below < 0; k++) d[k] -= 2 * below * hit->facet[k];
}

static void ray_from(const FfpHit *hit, float start[3]) {
    for (int k = 0; k < 3; k++) start[k] = hit->point[k] + FFP_RAY_OFFSET * hit->facet[k];
}

static void add_path(Paths *paths, const FfpHit *from, const float weight[3], uint32_t index,
                     uint32_t shift) {
    float x, y, d[3], start[3];
    const int k = paths->rays.count;
    ffp_even_pair(index, shift, &x, &y);
    ambient_direction(from, x, y, d);
    ray_from(from, start);
    ffp_rays_add(&paths->rays, start, d);
    memcpy(paths->weight[k], weight, sizeof paths->weight[k]);
    paths->index[k] = index;
}

// --- The lamp. ---

// The lamp's light that hits would receive, and the rays along which something may stand in the way.
typedef struct Lamplight {
    FfpRays shadow;
    float light[FFP_RAYS]; // irradiance over pi
    int hit[FFP_RAYS];
} Lamplight;

// A sphere of radius r and radiance L, d away and above the horizon, gives irradiance pi L (r / d)^2 cos
// (Howell, Catalog of Radiation Heat Transfer Configuration Factors, B-38). How much of it is hidden is asked
// of one point of the disc that the sphere shows.
static void ask_lamp(const FfpLamp *lamp, const FfpHit *hit, int number, uint32_t index, uint32_t shift,
                     Lamplight *out) {
    float way[3], unit[3], start[3], t[3], s[3], x, y;
    for (int k = 0; k < 3; k++) way[k] = lamp->centre[k] - hit->point[k];
    const float square = ffp_along(way, way), scale = 1 / sqrtf(square),
                cosine = scale * ffp_along(way, hit->normal);
    if (cosine <= 0) return;
    for (int k = 0; k < 3; k++) unit[k] = scale * way[k];
    basis(unit, t, s);
    ffp_even_pair(index, shift ^ 0x5bd1e995U, &x, &y);
    const float r = lamp->radius * sqrtf(x), i = r * cosf(6.2831853F * y), j = r * sinf(6.2831853F * y);
    ray_from(hit, start);
    for (int k = 0; k < 3; k++) way[k] = lamp->centre[k] + i * t[k] + j * s[k] - start[k];
    const int n = out->shadow.count;
    out->light[n] = lamp->radiance * lamp->radius * lamp->radius / square * cosine;
    out->hit[n] = number;
    ffp_rays_add(&out->shadow, start, way);
}

// The lamp on the samples themselves, weighed as `each` rays of theirs.
static void lamp_light(const FfpViewWork *w, size_t pixel, const FfpSample *samples, int count,
                       uint32_t shift) {
    const float each = (float)w->sim->ambient_rays;
    Lamplight lamp = {.shadow = {.count = 0}};
    for (int i = 0; i < count; i++)
        ask_lamp(&w->sim->around->lamp, &samples[i].hit, i, samples[i].index, shift, &lamp);
    if (lamp.shadow.count == 0) return;
    const unsigned blocked = ffp_trace_blocked(w->sim->tracer, &lamp.shadow);
    for (int n = 0; n < lamp.shadow.count; n++)
        for (size_t c = 0; c < 3 && !(blocked >> n & 1); c++)
            w->sums.ambient[3 * pixel + c] += each * lamp.light[n];
}

// --- Paths. ---

// The projector's light that a surface sends on to the path that has met it.
static void add_bounce(const FfpViewWork *w, size_t pixel, const FfpHit *far, const float weight[3],
                       const FfpIncoming *a) {
    float colour[3];
    const float cosine = ffp_along(far->normal, a->towards);
    for (int c = 0; c < 3; c++) colour[c] = weight[c] / FFP_PI * cosine * a->fall * w->sim->intensity[c];
    const FfpLight *light = w->sim->light;
    FfpTexel texel;
    if (ffp_light_texel(light->coarse_width, light->coarse_height, a->u / FFP_COARSE, a->v / FFP_COARSE,
                        &texel))
        ffp_light_add_coarse(light, &texel, colour, ffp_lanes_of(w, w->sums.bounce, pixel));
}

// The devices' light that the paths' next surfaces receive.
typedef struct Received {
    FfpHit far[FFP_RAYS];
    FfpRays shadow; // of the projector
    FfpIncoming arrivals[FFP_RAYS];
    int lit[FFP_RAYS];
    Lamplight lamp;
} Received;

static void add_received(const FfpViewWork *w, size_t pixel, const Paths *paths, const Received *in) {
    if (in->shadow.count > 0) {
        const unsigned blocked = ffp_trace_blocked(w->sim->tracer, &in->shadow);
        for (int n = 0; n < in->shadow.count; n++)
            if (!(blocked >> n & 1))
                add_bounce(w, pixel, &in->far[in->lit[n]], paths->weight[in->lit[n]], &in->arrivals[n]);
    }
    if (in->lamp.shadow.count > 0) {
        const unsigned blocked = ffp_trace_blocked(w->sim->tracer, &in->lamp.shadow);
        for (int n = 0; n < in->lamp.shadow.count; n++)
            for (size_t c = 0; c < 3 && !(blocked >> n & 1); c++)
                w->sums.ambient[3 * pixel + c] += paths->weight[in->lamp.hit[n]][c] * in->lamp.light[n];
    }
}

static void add_sky(const FfpViewWork *w, size_t pixel, const float weight[3], float share) {
    for (size_t c = 0; c < 3; c++) w->sums.ambient[3 * pixel + c] += weight[c] * share * w->sim->ambient;
}

// One more surface for each path; afterwards `paths` are those that go on from there. The last surface
// receives of the sky what most do.
static void follow(const FfpViewWork *w, size_t pixel, Paths *paths, uint32_t shift, bool last) {
    Received in = {.shadow = {.count = 0}, .lamp = {.shadow = {.count = 0}}};
    Paths next = {.rays = {.count = 0}};
    const unsigned hits = ffp_trace_hits(w->sim->tracer, &paths->rays, false, in.far);
    for (int i = 0; i < paths->rays.count; i++) {
        float *weight = paths->weight[i], albedo[3], roughness;
        if (!(hits >> i & 1)) {
            add_sky(w, pixel, weight, 1);
            continue;
        }
        const FfpHit *far = &in.far[i];
        const float d[3] = {paths->rays.direction[0][i], paths->rays.direction[1][i],
                            paths->rays.direction[2][i]};
        ffp_surface_look(w->sim, far, BLUR, albedo, &roughness);
        for (int c = 0; c < 3; c++) weight[c] *= albedo[c];
        if (last) add_sky(w, pixel, weight, CAVITY);
        if (ffp_along(far->facet, d) > 0) continue;
        const int n = in.shadow.count;
        if (ffp_arrive(w, far, far->normal, &in.arrivals[n], &in.shadow)) in.lit[n] = i;
        if (w->sim->around) ask_lamp(&w->sim->around->lamp, far, i, paths->index[i], shift, &in.lamp);
        if (!last) add_path(&next, far, weight, paths->index[i], ffp_hash32(shift));
    }
    add_received(w, pixel, paths, &in);
    *paths = next;
}

void ffp_indirect_light(const FfpViewWork *w, size_t pixel, const FfpSample *samples, int count,
                        uint32_t shift) {
    static const float whole[3] = {1, 1, 1};
    const int each = w->sim->ambient_rays, bounces = w->sim->around ? ROOM_BOUNCES : BOUNCES;
    Paths paths = {.rays = {.count = 0}};
    if (w->sim->around) lamp_light(w, pixel, samples, count, shift);
    for (int i = 0; i < count * each; i++) {
        const FfpSample *s = &samples[i / each];
        const uint32_t index = s->index * (uint32_t)each + (uint32_t)(i % each);
        uint32_t key = shift ^ 0x1b56c4e9U;
        add_path(&paths, &s->hit, whole, index, key);
        if (paths.rays.count < FFP_RAYS && i + 1 < count * each) continue;
        for (int b = 0; b < bounces && paths.rays.count > 0; b++, key = ffp_hash32(key))
            follow(w, pixel, &paths, key, b + 1 == bounces);
        paths.rays.count = 0;
    }
}
