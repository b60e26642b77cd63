// Where highlights are, by the generator's truth and its own reflectance.
#include <tgmath.h>
#include "core/base/brdf.h"
#include "core/base/vec.h"
#include "lab/eval/subject.h"

#define GLOSS 0.05F // specular radiance under white from which a pixel counts

// D F V max(n.l, 0) / d^2 of the true surface at the pixel's centre: specular radiance for each W/sr of
// light.
static real specular(const FfpView *view, int x, int y) {
    const int p = y * view->camera.width + x;
    const real *n = view->normal.data + 3 * p;
    real v[3], l[3];
    const real distance =
        view->depth.data[p] / ffp_pixel_ray(&view->camera, (real)x + 0.5F, (real)y + 0.5F, v);
    for (int k = 0; k < 3; k++) {
        v[k] = -v[k];
        l[k] = view->projector.pose[4 * k + 3] - (view->camera.pose[4 * k + 3] - distance * v[k]);
    }
    const real d = ffp_normalise3(l), nl = ffp_dot3(n, l);
    if (!(nl > 0) || !(ffp_dot3(n, v) > 0)) return 0;
    return ffp_brdf_specular(n, l, v, view->roughness.data[p]) * nl / (d * d);
}

// Shadows and the pattern's edge count through the direct light, of which the specular part is never more.
static real specular_radiance(const FfpView *view, const real intensity[3], int x, int y) {
    const int p = y * view->camera.width + x;
    if (!(view->depth.data[p] > 0)) return 0;
    const real share = specular(view, x, y);
    real sum = 0;
    for (int k = 0; k < 3; k++) sum += fmin(share * intensity[k], view->direct_white.data[3 * p + k]);
    return sum / 3;
}

FfpImage ffp_gloss_mask(const FfpView *view, const real intensity[3]) {
    const int width = view->camera.width, height = view->camera.height;
    FfpImage mask = ffp_image_new(width, height, 1);
    if (!view->depth.data || !view->normal.data || !view->roughness.data || !view->direct_white.data)
        return mask;
    for (int y = 0; y < height; y++)
        for (int x = 0; x < width; x++)
            mask.data[y * width + x] = specular_radiance(view, intensity, x, y) > GLOSS;
    return mask;
}
