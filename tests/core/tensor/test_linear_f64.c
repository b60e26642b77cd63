// Matrix product and linear layer in double: against sums written out, and gradients.
#include "core/base/alloc.h"
#include "core/tensor/gradient.h"
#include "core/tensor/tensor.h"

typedef struct Linear {
    real *x, *w, *bias, *y, *weights;
    int rows, in, out;
} Linear;

static double linear_loss(void *context) {
    Linear *l = context;
    ffp_linear_forward(l->y, l->x, l->w, l->bias, l->rows, l->in, l->out);
    return dot_reals(l->y, l->weights, (size_t)l->rows * (size_t)l->out);
}

static void check_linear(int rows, int in, int out, bool with_bias) {
    FfpRng rng = ffp_rng(1, (uint64_t)rows);
    const size_t nx = (size_t)rows * (size_t)in, nw = (size_t)in * (size_t)out,
                 ny = (size_t)rows * (size_t)out;
    Linear l = {random_reals(&rng, nx, 1, 0),
                random_reals(&rng, nw, 1, 0),
                with_bias ? random_reals(&rng, (size_t)out, 1, 0) : NULL,
                random_reals(&rng, ny, 1, 0),
                random_reals(&rng, ny, 1, 0),
                rows,
                in,
                out};
    real *dx = random_reals(&rng, nx, 1, 0), *dw = random_reals(&rng, nw, 0, 3),
         *dbias = random_reals(&rng, (size_t)out, 0, 3);
    linear_loss(&l);
    for (int t = 0; t < rows; t++) {
        for (int o = 0; o < out; o++) {
            double expected = with_bias ? l.bias[o] : 0;
            for (int i = 0; i < in; i++) expected += l.x[t * in + i] * l.w[o * in + i];
            assert_true(fabs(expected - l.y[t * out + o]) < 1e-10);
        }
    }
    ffp_linear_backward(dx, dw, with_bias ? dbias : NULL, l.weights, l.x, l.w, rows, in, out);
    check_gradient("linear x", linear_loss, &l, l.x, dx, 0, 1, nx, nx);
    check_gradient("linear w", linear_loss, &l, l.w, dw, 3, 1, nw, nw);
    if (with_bias)
        check_gradient("linear bias", linear_loss, &l, l.bias, dbias, 3, 1, (size_t)out, (size_t)out);
    // without dx the rest is the same
    real *dw_again = random_reals(&rng, nw, 0, 3);
    ffp_linear_backward(NULL, dw_again, NULL, l.weights, l.x, l.w, rows, in, out);
    assert_memory_equal(dw, dw_again, nw * sizeof(real));
    real *all[] = {l.x, l.w, l.bias, l.y, l.weights, dx, dw, dbias, dw_again};
    for (size_t i = 0; i < sizeof(all) / sizeof(all[0]); i++) ffp_free(all[i]);
}

static void linear_gradients(void **state) {
    (void)state;
    check_linear(7, 5, 3, true);
    check_linear(1, 1, 1, false);
    check_linear(33, 13, 37, true);
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(linear_gradients)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
