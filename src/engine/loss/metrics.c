// Peak signal-to-noise ratio, over a whole picture or its foreground.
#include "engine/loss/metrics.h"
#include <assert.h>
#include <math.h>
#include "core/base/device.h"
#include "engine/loss/deferred.h"
#include "engine/loss/table.h"

static double squared_error(const FfpImage *a, const FfpImage *b, const FfpImage *mask, size_t *count) {
    const size_t pixels = (size_t)a->width * a->height, channels = a->channels;
    double sum = 0;
    *count = 0;
    for (size_t i = 0; i < pixels; i++) {
        if (mask && !(mask->data[i] > 0.5F)) continue;
        for (size_t k = i * channels; k < (i + 1) * channels; k++) {
            const double difference = (double)a->data[k] - b->data[k];
            sum += difference * difference;
        }
        *count += channels;
    }
    return sum;
}

// mask may be NULL: every pixel counts.
static double psnr(const FfpImage *a, const FfpImage *b, const FfpImage *mask) {
    assert(a->width == b->width && a->height == b->height && a->channels == b->channels);
    assert(!mask || (mask->width == a->width && mask->height == a->height && mask->channels == 1));
    size_t count;
    const double sum = ffp_device() ? ffp_device()->loss->squared_error(a, b, mask, &count)
                                    : squared_error(a, b, mask, &count);
    if (!mask && ffp_loss_deferred_as(FFP_DEFERRED_PSNR, 1)) return 0;
    if (count == 0) return NAN;
    return ffp_psnr_of(sum / (double)count);
}

double ffp_psnr(const FfpImage *a, const FfpImage *b) {
    return psnr(a, b, NULL);
}

double ffp_psnr_masked(const FfpImage *a, const FfpImage *b, const FfpImage *mask) {
    return psnr(a, b, mask);
}
