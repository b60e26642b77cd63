#include "core/gaussians/elsewhere.h"
#include <math.h>
#include <string.h>
#include "core/base/file.h"
#include "core/base/log.h"

#define ROUGHNESS 0.5F   // neither gloss nor chalk
#define FLAT 0.01        // thickness of discs, as a share of their smallest radius
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

static void note(const FfpSplatSet *set) {
    const char *name = ffp_basename(set->path);
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
        note(set);
    } else {
        ffp_gaussians_free(set->gaussians);
    }
    return ok;
}
