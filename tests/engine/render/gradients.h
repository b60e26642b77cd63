// Analytic gradients against central differences, in double.
#ifndef FFP_TESTS_RENDER_GRADIENTS_H
#define FFP_TESTS_RENDER_GRADIENTS_H

#include "engine/render/scenes.h"
#include "support.h"

#define STEP 1e-6
// Largest accepted error, as a share of the number itself or of a hundredth of the field's largest gradient.
#define TOLERANCE 1e-5

typedef double (*Loss)(void *context);

// Every entry of the field: analytic[i] against (loss(x + h) - loss(x - h)) / 2h.
static inline void check_field(const char *what, const Field *field, const real *analytic, Loss loss,
                               void *context) {
    double largest = 0, worst = 0;
    for (int64_t i = 0; i < field->count; i++) {
        assert_true(isfinite(analytic[i]));
        largest = fmax(largest, fabs(analytic[i]));
    }
    for (int64_t i = 0; i < field->count; i++) {
        const real kept = field->data[i];
        field->data[i] = kept + STEP;
        const double above = loss(context);
        field->data[i] = kept - STEP;
        const double below = loss(context);
        field->data[i] = kept;
        const double numeric = (above - below) / (2 * STEP);
        const double scale = fmax(fmax(fabs(numeric), fabs(analytic[i])), fmax(0.01 * largest, 1e-3));
        const double error = fabs(numeric - analytic[i]) / scale;
        if (!(error <= TOLERANCE))
            print_message("%s %s[%ld]: analytic %.10g, numeric %.10g\n", what, field->name, (long)i,
                          analytic[i], numeric);
        worst = worse(worst, error);
    }
    if (!(worst <= TOLERANCE)) fail_msg("%s: %s is off by %.3g", what, field->name, worst);
}

static inline double weighted(const FfpGbuffer *g, const FfpGbuffer *weights) {
    Field a[FIELDS], b[FIELDS];
    gbuffer_fields(g, a);
    gbuffer_fields(weights, b);
    double sum = 0;
    for (int k = 0; k < FIELDS; k++)
        for (int64_t i = 0; i < a[k].count; i++) sum += a[k].data[i] * b[k].data[i];
    return sum;
}

#endif
