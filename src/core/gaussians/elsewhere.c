#include "core/gaussians/elsewhere.h"
#include <math.h>
#include <string.h>
#include "core/base/file.h"
#include "core/base/log.h"

#define ROUGHNESS 0.5F   // neither gloss nor chalk
#define FLAT 0.01        // thickness of discs, as a share of their smallest radius
#define FEW 16           // splats may be as large as all they show
#define LARGE 0.1        // of the whole: where a splat is that large, it shows nothing
#define BRIGHT 100.0     // radiance that no splat of 0 to 1 has
#define LOG_ZERO (-80.0) // logarithms below are of scales that no float holds when squared

void ffp_splats_begin(FfpSplatSet *set, FfpGaussians *gaussians, int64_t count, const char *path) {
    *gaussians = ffp_gaussians_new(count);
    *set = (FfpSplatSet){.gaussians = gaussians, .path = path};
}

double ffp_opacity_logit(double share) {
    return share <= 0 ? -INFINITY : share >= 1 ? INFINITY : log(share / (1 - share));
}

static void complete(FfpGaussians *gaussians, int64_t index) {
    real *albedo = gaussians->albedo + 3 * index;
    for (int c = 0; c < 3; c++) {
        const real colour = gaussians->ambient[3 * index + c];
        albedo[c] = colour < 0 ? 0 : colour > 1 ? 1 : colour;
    }
    gaussians->roughness[index] = ROUGHNESS;
}

// Logarithms of scales, of which one that is nothing gets a thickness.
static void thicken(float scale[3]) {
    double least = INFINITY;
    for (int k = 0; k < 3; k++)
        if ((double)scale[k] > LOG_ZERO) least = fmin(least, (double)scale[k]);
    for (int k = 0; k < 3; k++)
        if ((double)scale[k] <= LOG_ZERO && least < INFINITY) scale[k] = (float)(least + log(FLAT));
}

void ffp_splats_add(FfpSplatSet *set, const float given[FFP_ROW_NUMBERS]) {
    FfpGaussians *gaussians = set->gaussians;
    const int64_t at = set->offered++ - set->bad;
    float row[FFP_ROW_NUMBERS];
    memcpy(row, given, sizeof row);
    thicken(row + FFP_ROW_SCALE);
    const int bad = ffp_row_decode(row, gaussians, at);
    if (bad >= 0) {
        if (set->bad++ > 0) return;
        set->first_bad = set->offered - 1;
        set->bad_number = bad;
        return;
    }
    for (int k = 0; set->linear && k < 3; k++) // it was decoded as if it were encoded
        gaussians->ambient[3 * at + k] = (real)(0.5 + FFP_SH_C0 * (double)row[FFP_ROW_AMBIENT + k]);
    if (!set->relightable) complete(gaussians, at);
}

// None of it is negative; notes whether there is any.
static void settle_scattered(FfpGaussians *gaussians) {
    gaussians->scatters = false;
    for (int64_t i = 0; i < 3 * gaussians->count; i++) {
        gaussians->scattered[i] = fmax(gaussians->scattered[i], (real)0);
        gaussians->scatters |= gaussians->scattered[i] > 0;
    }
}

void ffp_splats_note_rest(const char *path, int64_t bytes) {
    ffp_note("%s: %lld bytes after its last splat are left out", ffp_basename(path), (long long)bytes);
}

// Some exporters write sizes and opacities themselves in place of their logarithms and logits: sizes are then
// 1 and more, and opacities between those of the logits 0 and 1.
static void note_plain_numbers(const FfpGaussians *gaussians, const char *name) {
    real low[3] = {INFINITY, INFINITY, INFINITY}, high[3] = {-INFINITY, -INFINITY, -INFINITY}, whole = 0;
    int64_t large = 0, middling = 0, bright = 0;
    for (int64_t i = 0; i < 3 * gaussians->count; i++) {
        low[i % 3] = fmin(low[i % 3], gaussians->centre[i]);
        high[i % 3] = fmax(high[i % 3], gaussians->centre[i]);
    }
    for (int k = 0; k < 3; k++) whole += (high[k] - low[k]) * (high[k] - low[k]);
    whole = sqrt(whole);
    for (int64_t i = 0; i < gaussians->count; i++) {
        const real *scale = gaussians->scale + 3 * i, opacity = gaussians->opacity[i];
        large += fmax(fmax(scale[0], scale[1]), scale[2]) > (real)LARGE * whole;
        bright += gaussians->ambient[3 * i + 1] > (real)BRIGHT;
        middling += opacity >= (real)0.5 && opacity < (real)0.7311;
    }
    if (gaussians->count < FEW) return;
    if (2 * large > gaussians->count)
        ffp_note("%s: most splats are larger than a tenth of the whole: were sizes written in place of their "
                 "logarithms?",
                 name);
    if (2 * bright > gaussians->count)
        ffp_note("%s: most colours are far above 1: were they written from 0 to 255?", name);
    if (middling == gaussians->count)
        ffp_note("%s: all opacities are between 0.5 and 0.73: were they written in place of their logits?",
                 name);
}

static void note(const FfpSplatSet *set) {
    const char *name = ffp_basename(set->path);
    if (!set->relightable) note_plain_numbers(set->gaussians, name);
    if (!set->relightable)
        ffp_note("%s: splats without material: their colour is taken as albedo and as ambient colour, "
                 "roughness as %g",
                 name, (double)ROUGHNESS);
    if (set->bad > 0)
        ffp_note(
            "%s: left out %lld of %lld splats that cannot be used (the first: Gaussian %lld, invalid %s)",
            name, (long long)set->bad, (long long)set->offered, (long long)set->first_bad,
            ffp_row_names[set->bad_number]);
    if (set->harmonics)
        ffp_note("%s: its spherical harmonics are left out: each splat has the same colour from all sides",
                 name);
    if (set->filtered)
        ffp_note("%s: its filters (filter_3D, of Mip-Splatting) are left out: save it with the filter fused",
                 name);
}

bool ffp_splats_end(FfpSplatSet *set, bool ok, FfpError *err) {
    if (ok && 10 * set->bad > set->offered)
        ok = ffp_fail(err, FFP_ERROR_FILE, set->path,
                      "Gaussian %lld: invalid %s (%lld of %lld cannot be used)", (long long)set->first_bad,
                      ffp_row_names[set->bad_number], (long long)set->bad, (long long)set->offered);
    if (ok) {
        set->gaussians->count = set->offered - set->bad;
        settle_scattered(set->gaussians);
        note(set);
    } else {
        ffp_gaussians_free(set->gaussians);
    }
    return ok;
}
