// Numbers of a device against numbers of the CPU.
#ifndef FFP_TESTS_CUDA_COMPARE_H
#define FFP_TESTS_CUDA_COMPARE_H

#include <math.h>
#include "core/base/arena.h"
#include "core/base/real.h"
#include "engine/cuda/cuda.h"
#include "support.h"

// The device, or NULL with a line that says that all is skipped.
static inline const FfpDevice *find_device(void) {
    FfpError err = {0};
    const FfpDevice *device = ffp_cuda_device(&err);
    if (device) return device;
    printf("skipped: %s\n", err.text);
    return NULL;
}

// |a - b| / |b|
static inline double distance(const real *a, const real *b, int64_t count) {
    double difference = 0, size = 0;
    for (int64_t i = 0; i < count; i++) {
        difference += ((double)a[i] - b[i]) * ((double)a[i] - b[i]);
        size += (double)b[i] * b[i];
    }
    return difference == 0 ? 0 : sqrt(difference / (size > 0 ? size : 1e-300));
}

// there: on the device in use.
static inline void assert_close(const real *there, const real *here, int64_t count, double tolerance,
                                const char *what) {
    real *copy = ffp_alloc((size_t)count + 1, sizeof *copy);
    ffp_memory_download(copy, there, (size_t)count * sizeof *copy);
    const double d = distance(copy, here, count);
    print_message("%s: %.2g\n", what, d);
    ffp_free(copy);
    if (!(d <= tolerance)) fail_msg("%s: relative difference %g, allowed %g", what, d, tolerance);
}

#endif
