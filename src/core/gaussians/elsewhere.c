#include "core/gaussians/elsewhere.h"
#include "core/base/file.h"
#include "core/base/log.h"

#define ROUGHNESS 0.5F // neither gloss nor chalk

void ffp_splat_complete(FfpGaussians *gaussians, int64_t index) {
    real *albedo = gaussians->albedo + 3 * index;
    for (int c = 0; c < 3; c++) {
        const real colour = gaussians->ambient[3 * index + c];
        albedo[c] = colour < 0 ? 0 : colour > 1 ? 1 : colour;
    }
    gaussians->roughness[index] = ROUGHNESS;
}

bool ffp_splat_put(FfpGaussians *gaussians, int64_t index, const float row[FFP_ROW_NUMBERS], const char *path,
                   FfpError *err) {
    const int bad = ffp_row_decode(row, gaussians, index);
    if (bad >= 0)
        return ffp_fail(err, FFP_ERROR_FILE, path, "Gaussian %lld: invalid %s", (long long)index,
                        ffp_row_names[bad]);
    ffp_splat_complete(gaussians, index);
    return true;
}

void ffp_splats_note(const char *path) {
    ffp_note("%s: splats without material: their colour is taken as albedo and as ambient colour, roughness "
             "as %g",
             ffp_basename(path), (double)ROUGHNESS);
}
