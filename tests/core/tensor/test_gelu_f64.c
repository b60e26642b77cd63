// GELU in double: values by libm's erf, gradient.
#include "core/base/alloc.h"
#include "core/tensor/gradient.h"
#include "core/tensor/tensor.h"

typedef struct Gelu {
    real *x, *y, *weights;
    size_t count;
} Gelu;

static double gelu_loss(void *context) {
    Gelu *g = context;
    ffp_gelu_forward(g->y, g->x, g->count);
    return dot_reals(g->y, g->weights, g->count);
}

static void gelu_gradients(void **state) {
    (void)state;
    FfpRng rng = ffp_rng(3, 0);
    const size_t count = 203;
    Gelu g = {random_reals(&rng, count, 2, 0), random_reals(&rng, count, 1, 0),
              random_reals(&rng, count, 1, 0), count};
    real *dx = random_reals(&rng, count, 1, 0);
    gelu_loss(&g);
    for (size_t i = 0; i < count; i++)
        assert_true(fabs(g.y[i] - 0.5 * g.x[i] * (1 + erf(g.x[i] / sqrt(2.0)))) < 1e-13);
    ffp_gelu_backward(dx, g.weights, g.x, count);
    check_gradient("gelu", gelu_loss, &g, g.x, dx, 0, 1, count, count);
    real *all[] = {g.x, g.y, g.weights, dx};
    for (size_t i = 0; i < sizeof(all) / sizeof(all[0]); i++) ffp_free(all[i]);
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(gelu_gradients)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
