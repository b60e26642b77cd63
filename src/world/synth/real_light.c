// Light as projectors, lenses and cameras spread, bend and lose it: real_light and the rest of FfpSensor.
#include <math.h>
#include "world/synth/sensor.h"

// The ranges that are drawn hold the rigs that were measured (docs/design/data.md, "Real light").
enum { STREAM = 0x7ea11 };
#define PANEL 800.0F // wide, of which reaches and blurs are pixels
static const float SPREAD_REACH = 12, GLARE_REACH = 0.15F;

// --- Drawing. ---

static void unless_set(float *value, float drawn) {
    if (*value == 0) *value = drawn;
}

// One share, of which the channels lack more or less.
static void draw_spread(FfpSensor *s, FfpRng *rng) {
    const bool set = s->spread[0] > 0 || s->spread[1] > 0 || s->spread[2] > 0;
    const float share = s->real_light * ffp_rng_range(rng, 0.01F, 0.08F), tint = ffp_rng_uniform(rng);
    for (int c = 0; c < 3; c++) {
        const float drawn = share * (1 - tint * ffp_rng_uniform(rng));
        if (!set) s->spread[c] = drawn;
    }
    unless_set(&s->spread_reach, 4 * powf(7.5F, ffp_rng_uniform(rng)));
}

static void draw(FfpSensor *s, uint64_t seed) {
    FfpRng rng = ffp_rng(seed, STREAM);
    const float strength = s->real_light;
    draw_spread(s, &rng);
    unless_set(&s->glare, strength * ffp_rng_range(&rng, 0, 0.03F));
    unless_set(&s->glare_reach, ffp_rng_range(&rng, 0.05F, 0.3F));
    const float power = ffp_rng_range(&rng, 1.5F, 2.4F);
    if (s->gamma == 0) unless_set(&s->power, power);
    unless_set(&s->black_level, strength * ffp_rng_range(&rng, 0, 0.05F));
    unless_set(&s->vignetting, strength * ffp_rng_range(&rng, 0, 0.3F));
    unless_set(&s->throw_fall, strength * ffp_rng_range(&rng, 0, 0.3F));
    unless_set(&s->focus_blur, strength * ffp_rng_range(&rng, 0, 2));
    unless_set(&s->focus_at, ffp_rng_range(&rng, 0.93F, 1.07F));
}

void ffp_sensor_settle(FfpSensor *s, uint64_t seed) {
    if (s->real_light > 0) draw(s, seed);
    if (s->spread[0] > 0 || s->spread[1] > 0 || s->spread[2] > 0) unless_set(&s->spread_reach, SPREAD_REACH);
    if (s->glare > 0) unless_set(&s->glare_reach, GLARE_REACH);
    if (s->focus_blur > 0) unless_set(&s->focus_at, 1);
}

// --- Spread. ---

void ffp_sensor_spread(FfpImage *light, const FfpSensor *s) {
    const real share[3] = {(real)s->spread[0], (real)s->spread[1], (real)s->spread[2]};
    if (share[0] > 0 || share[1] > 0 || share[2] > 0)
        ffp_image_spread(light, share, (real)(s->spread_reach * (float)light->width / PANEL));
}

// --- Vignetting. ---

float ffp_sensor_vignette(float fall, const FfpCamera *device, float u, float v) {
    const float x = u - (float)device->cx, y = v - (float)device->cy, w = (float)device->width,
                h = (float)device->height;
    return fmaxf(0, 1 - fall * 4 * (x * x + y * y) / (w * w + h * h));
}

bool ffp_sensor_has_lens(const FfpSensor *s) {
    return s->vignetting > 0 || s->glare > 0;
}

void ffp_sensor_see(FfpImage *light, const FfpSensor *s, const FfpCamera *camera) {
    const real share[3] = {(real)s->glare, (real)s->glare, (real)s->glare};
    const int longer = light->width > light->height ? light->width : light->height;
    real *to = light->data;
    for (int y = 0; y < light->height && s->vignetting > 0; y++)
        for (int x = 0; x < light->width; x++, to += 3) {
            const float left = ffp_sensor_vignette(s->vignetting, camera, (float)x + 0.5F, (float)y + 0.5F);
            for (int c = 0; c < 3; c++) to[c] *= (real)left;
        }
    if (s->glare > 0) ffp_image_spread(light, share, (real)(s->glare_reach * (float)longer));
}

// --- Focus. ---

// A thin lens blurs by |1/z - 1/focus|; near the focal plane focus^2 times that is the distance from it.
float ffp_sensor_softness(const FfpSensor *s, int panel_width, float focus, float z) {
    return s->focus_blur * (float)panel_width / PANEL * fabsf(focus * focus / z - focus);
}

// --- Truth. ---

json_t *ffp_sensor_truth(const FfpSensor *s) {
    const bool light = s->power > 0 || s->throw_fall > 0 || s->focus_blur > 0 || ffp_sensor_has_lens(s) ||
                       s->spread[0] > 0 || s->spread[1] > 0 || s->spread[2] > 0;
    if (!light) return NULL;
    return json_pack("{s:[f,f,f], s:f, s:f, s:f, s:f, s:f, s:f, s:f, s:f, s:f}", "spread",
                     (double)s->spread[0], (double)s->spread[1], (double)s->spread[2], "spread_reach",
                     (double)s->spread_reach, "glare", (double)s->glare, "glare_reach",
                     (double)s->glare_reach, "power", (double)s->power, "black_level", (double)s->black_level,
                     "vignetting", (double)s->vignetting, "throw_fall", (double)s->throw_fall, "focus_blur",
                     (double)s->focus_blur, "focus_at", (double)s->focus_at);
}
