#include "engine/pipeline/normalised.h"
#include "core/base/alloc.h"
#include "engine/denoise/denoise.h"

FfpCapture ffp_normalised_alias(const FfpCapture *capture) {
    FfpCapture alias = *capture;
    alias.views = ffp_alloc(capture->n_views, sizeof *alias.views);
    for (int v = 0; v < capture->n_views; v++) {
        alias.views[v] = capture->views[v];
        if (alias.views[v].depth.data) alias.views[v].depth = ffp_image_copy(&capture->views[v].depth);
    }
    ffp_capture_normalise(&alias, capture->centre, capture->radius);
    return alias;
}

void ffp_normalised_alias_free(FfpCapture *alias) {
    for (int v = 0; v < alias->n_views; v++) ffp_image_free(&alias->views[v].depth);
    ffp_free(alias->views);
    alias->views = NULL;
}

FfpImage *ffp_denoise_capture(FfpCapture *alias, const int *photographs, int n, double *noise) {
    if (n < FFP_PHOTOGRAPHS) return NULL;
    if (*noise < 0) *noise = ffp_noise_estimate(alias, photographs);
    return *noise > 0 ? ffp_denoise(alias, photographs, n, *noise) : NULL;
}
