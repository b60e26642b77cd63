#include "rig/masks/layers.h"
#include <tgmath.h>
#include "core/base/alloc.h"
#include "core/numerics/rank.h"
#include "rig/masks/limits.h"
#include "rig/masks/local_mean.h"

static FfpImage difference(const FfpImage *image, const FfpImage *black) {
    FfpImage out = ffp_image_copy(image);
    const ptrdiff_t count = (ptrdiff_t)image->width * image->height * 3;
    for (ptrdiff_t i = 0; i < count; i++) out.data[i] -= black->data[i];
    return out;
}

FfpLayers *ffp_layers_new(const FfpCapture *capture, const FfpImage *images, const FfpImage *others) {
    FfpLayers *out = ffp_alloc(1, sizeof *out);
    out->width = images[capture->black].width, out->height = images[capture->black].height;
    out->of[out->n++] = ffp_local_mean(&images[capture->black], SMOOTH);
    for (int k = -1; k < capture->n_patterns; k++) {
        const int p = k < 0 ? capture->white : k;
        if (k >= 0 && (p == capture->black || p == capture->white)) continue;
        if (!images[p].data || !others[p].data) continue;
        FfpImage added = difference(&images[p], &images[capture->black]);
        out->of[out->n++] = ffp_local_mean(&added, SMOOTH);
        ffp_image_free(&added);
    }
    return out;
}

void ffp_layers_free(FfpLayers *layers) {
    for (int k = 0; k < layers->n; k++) ffp_image_free(&layers->of[k]);
    ffp_free(layers);
}

double ffp_layers_noise(const FfpLayers *a, const FfpLayers *b) {
    const size_t count = 3 * (size_t)a->width * (size_t)a->height;
    double *off = ffp_alloc(count, sizeof *off);
    for (size_t i = 0; i < count; i++) off[i] = fabs((double)(a->of[0].data[i] - b->of[0].data[i]));
    const double deviation = 1.4826 * ffp_median(off, count);
    ffp_free(off);
    return fmax(LAYER_NOISE_FACTOR * deviation, LAYER_NOISE_LEAST);
}

double ffp_layers_variance(double noise, double light, double edge) {
    return noise * noise + LAYER_RELATIVE * LAYER_RELATIVE * light * light +
           LAYER_EDGE * LAYER_EDGE * edge * edge;
}
