#include "product/export/splats.h"
#include <tgmath.h>
#include "core/base/alloc.h"
#include "core/image/image.h"
#include "product/export/quaternion.h"

#define OPACITY_MIN (1.0F / 255)

static void take(FfpSplats *out, int64_t n, const FfpGaussians *g, int64_t i, const real colour[3],
                 const real turn[4]) {
    ffp_quaternion_rotate(turn, g->centre + 3 * i, out->centre + 3 * n);
    ffp_quaternion_product(turn, g->rotation + 4 * i, out->rotation + 4 * n);
    out->opacity[n] = g->opacity[i];
    for (int k = 0; k < 3; k++) {
        out->scale[3 * n + k] = g->scale[3 * i + k];
        out->colour[3 * n + k] = ffp_srgb_encode(colour[k] > 0 ? colour[k] : 0);
    }
}

FfpSplats ffp_splats_new(const FfpGaussians *gaussians, const real *colour, const real turn[4]) {
    FfpSplats out = {0};
    for (int64_t i = 0; i < gaussians->count; i++) out.count += gaussians->opacity[i] >= OPACITY_MIN;
    const size_t room = (size_t)out.count + 1;
    out.centre = ffp_alloc(room, 3 * sizeof(real));
    out.scale = ffp_alloc(room, 3 * sizeof(real));
    out.rotation = ffp_alloc(room, 4 * sizeof(real));
    out.opacity = ffp_alloc(room, sizeof(real));
    out.colour = ffp_alloc(room, 3 * sizeof(real));
    int64_t n = 0;
    for (int64_t i = 0; i < gaussians->count; i++)
        if (gaussians->opacity[i] >= OPACITY_MIN) take(&out, n++, gaussians, i, colour + 3 * i, turn);
    return out;
}

void ffp_splats_free(FfpSplats *splats) {
    ffp_free(splats->centre);
    ffp_free(splats->scale);
    ffp_free(splats->rotation);
    ffp_free(splats->opacity);
    ffp_free(splats->colour);
    *splats = (FfpSplats){0};
}
