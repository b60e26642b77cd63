#include "engine/pipeline/scattered.h"

#define PATTERNS_LEAST 2 // beside black and white: one alone is explained by albedo as well
#define SHARE 0.001F     // of white's light
#define LIT_LEAST 0.01F  // what white adds to a lit pixel, linear

// The mean of the light that white adds to lit pixels.
static void mean_of_white(const FfpCapture *capture, double mean[3]) {
    double count = 0;
    for (int k = 0; k < 3; k++) mean[k] = 0;
    for (int v = 0; v < capture->n_views; v++) {
        const FfpView *view = &capture->views[v];
        const real *white = view->images[capture->white].data, *black = view->images[capture->black].data;
        const ptrdiff_t pixels = (ptrdiff_t)view->camera.width * view->camera.height;
        for (ptrdiff_t i = 0; i < pixels; i++) {
            if (!(white[3 * i + 1] - black[3 * i + 1] > LIT_LEAST)) continue;
            for (int k = 0; k < 3; k++) mean[k] += (double)(white[3 * i + k] - black[3 * i + k]);
            count++;
        }
    }
    for (int k = 0; k < 3; k++) mean[k] /= count > 0 ? count : 1;
}

void ffp_scattered_start(FfpGaussians *gaussians, const FfpCapture *capture, const int *patterns, int n) {
    double mean[3];
    int telling = 0;
    for (int i = 0; i < n; i++) telling += patterns[i] != capture->black && patterns[i] != capture->white;
    if (telling < PATTERNS_LEAST) return;
    mean_of_white(capture, mean);
    for (int64_t i = 0; i < 3 * gaussians->count; i++) {
        gaussians->scattered[i] = SHARE * (real)(mean[i % 3] > 0 ? mean[i % 3] : 0);
        gaussians->scatters |= gaussians->scattered[i] > 0;
    }
}
