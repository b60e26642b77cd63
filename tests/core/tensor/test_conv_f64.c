// Causal convolution in double: against its definition, and gradients, both ways along the tokens.
#include "core/base/alloc.h"
#include "core/tensor/gradient.h"
#include "core/tensor/tensor.h"

typedef struct Conv {
    FfpDepthwise in;
    real *x, *w, *bias; // the input's, to be perturbed
    real *y, *weights;
} Conv;

static double conv_loss(void *context) {
    Conv *c = context;
    ffp_conv_forward(c->y, &c->in);
    return dot_reals(c->y, c->weights, (size_t)c->in.rows * (size_t)c->in.channels);
}

static void check_values(const FfpDepthwise *conv, const real *y) {
    for (int t = 0; t < conv->rows; t++) {
        for (int c = 0; c < conv->channels; c++) {
            double sum = conv->bias[c];
            for (int k = 0; k < conv->taps; k++) {
                const int back = conv->taps - 1 - k, source = conv->reverse ? t + back : t - back;
                if (source >= 0 && source < conv->rows)
                    sum += conv->w[c * conv->taps + k] * conv->x[source * conv->ldx + c];
            }
            assert_true(fabs(sum / (1 + exp(-sum)) - y[t * conv->channels + c]) < 1e-12);
        }
    }
}

static void check_conv(int rows, int channels, int taps, bool reverse) {
    FfpRng rng = ffp_rng(4, (uint64_t)rows);
    const int ldx = channels + 5, lddx = channels + 2;
    const size_t count = (size_t)rows * (size_t)channels, nw = (size_t)channels * (size_t)taps,
                 nc = (size_t)channels;
    Conv conv = {.x = random_reals(&rng, (size_t)rows * (size_t)ldx, 1, 0)};
    conv.w = random_reals(&rng, nw, 0.5, 0);
    conv.bias = random_reals(&rng, nc, 0.5, 0);
    conv.y = random_reals(&rng, count, 1, 0);
    conv.weights = random_reals(&rng, count, 1, 0);
    conv.in = (FfpDepthwise){conv.x, conv.w, conv.bias, ldx, rows, channels, taps, reverse};
    real *dx = random_reals(&rng, (size_t)rows * (size_t)lddx, 0, 2),
         *dx_as_x = random_reals(&rng, (size_t)rows * (size_t)ldx, 0, 0);
    real *dw = random_reals(&rng, nw, 0, 2), *dbias = random_reals(&rng, nc, 0, 2);
    conv_loss(&conv);
    check_values(&conv.in, conv.y);
    ffp_conv_backward(&(FfpDepthwiseGradient){dx, dw, dbias, lddx}, &conv.in, conv.weights);
    for (int t = 0; t < rows; t++) {
        memcpy(dx_as_x + t * ldx, dx + t * lddx, sizeof(real) * nc);
        for (int j = channels; j < lddx; j++) assert_true(dx[t * lddx + j] == 2);
    }
    check_gradient("conv x", conv_loss, &conv, conv.x, dx_as_x, 2, (size_t)rows, nc, (size_t)ldx);
    check_gradient("conv w", conv_loss, &conv, conv.w, dw, 2, 1, nw, nw);
    check_gradient("conv bias", conv_loss, &conv, conv.bias, dbias, 2, 1, nc, nc);
    real *all[] = {conv.x, conv.w, conv.bias, conv.y, conv.weights, dx, dx_as_x, dw, dbias};
    for (size_t i = 0; i < sizeof(all) / sizeof(all[0]); i++) ffp_free(all[i]);
}

static void conv_gradients(void **state) {
    (void)state;
    for (int reverse = 0; reverse < 2; reverse++) {
        check_conv(37, 5, 4, reverse);
        check_conv(3, 67, 4, reverse);
        check_conv(2, 3, 5, reverse); // more taps than rows
        check_conv(35, 1, 1, reverse);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(conv_gradients)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
