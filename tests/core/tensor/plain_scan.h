// The plain recurrence of the state-space scan, in the room's own numbers.
#ifndef FFP_TESTS_TENSOR_PLAIN_SCAN_H
#define FFP_TESTS_TENSOR_PLAIN_SCAN_H

#include <tgmath.h>
#include "core/tensor/tensor.h"

// One state entry at a time: slow, needs no memory, and follows the definition word by word.
static inline void scan_forward_reference(real *y, const FfpScanShape *shape, const FfpScanInput *in) {
    const int width = shape->heads * shape->head_dim;
#pragma omp parallel for schedule(static)
    for (int column = 0; column < width; column++) {
        const int head = column / shape->head_dim;
        const real rate = -exp(in->a_log[head]);
        for (int t = 0; t < shape->rows; t++)
            y[(size_t)t * width + column] = in->d[head] * in->x[(size_t)t * in->ld + column];
        for (int n = 0; n < shape->state; n++) {
            real state = 0;
            for (int i = 0; i < shape->rows; i++) {
                const int t = shape->reverse ? shape->rows - 1 - i : i;
                const size_t row = (size_t)t * in->ld;
                const real raw = in->dt_raw[(size_t)t * in->lddt + head] + in->dt_bias[head];
                const real dt = raw > 20 ? raw : log1p(exp(raw));
                state = exp(dt * rate) * state + dt * in->x[row + column] * in->b[row + n];
                y[(size_t)t * width + column] += state * in->c[row + n];
            }
        }
    }
}

#endif
