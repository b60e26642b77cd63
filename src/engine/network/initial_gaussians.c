// The classical reconstruction: the residual heads' formulas at zero, so that it is, number for number, what
// an untrained residual network returns.
#include "core/base/arena.h"
#include "core/base/vec.h"
#include "engine/network/network.h"
#include "engine/network/splat.h"

static int64_t all_pixels(const FfpInitialisation *start) {
    return (int64_t)start->views * start->height * start->width;
}

static int64_t count_covered(const FfpInitialisation *start) {
    int64_t count = 0;
    for (int64_t p = 0; p < all_pixels(start); p++) count += start->coverage[p] > 0;
    return count;
}

int64_t *ffp_initialisation_pixels(const FfpInitialisation *start) {
    int64_t *out = ffp_alloc((size_t)count_covered(start) + 1, sizeof *out), count = 0;
    for (int64_t p = 0; p < all_pixels(start); p++)
        if (start->coverage[p] > 0) out[count++] = p;
    return out;
}

FfpGaussians ffp_initialisation_gaussians(const FfpCapture *capture, const FfpInitialisation *start) {
    const real zero[FFP_RESIDUAL_NUMBERS] = {0};
    const int64_t pixels = all_pixels(start);
    int64_t count = 0;
    FfpGaussians out = ffp_gaussians_new(count_covered(start));
    for (int64_t p = 0; p < pixels; p++) {
        if (!(start->coverage[p] > 0)) continue;
        const FfpCamera *camera = &capture->views[p / start->width / start->height].camera;
        const real x = (real)(p % start->width) + 0.5F, y = (real)(p / start->width % start->height) + 0.5F;
        FfpPixelBase base = {.origin = {camera->pose[3], camera->pose[7], camera->pose[11]}};
        FfpPixelSplat splat;
        ffp_pixel_ray(camera, x, y, base.direction);
        base.nearest = -ffp_dot3(base.origin, base.direction);
        ffp_residual_base(&base, start, p);
        ffp_residual_splat(&splat, &base, zero);
        ffp_splat_store(&out, count++, &splat, &base);
    }
    return out;
}
