// Gradients of the three norms in double.
#include "core/base/alloc.h"
#include "core/tensor/gradient.h"
#include "core/tensor/tensor.h"

typedef struct Norm {
    real *x, *z, *gain, *y, *mean, *rstd, *weights, *dx, *dz, *dgain;
    size_t count;
    int rows, dim, ldz;
} Norm;

static Norm make_norm(int rows, int dim) {
    FfpRng rng = ffp_rng(2, (uint64_t)(rows * 1000 + dim));
    const size_t count = (size_t)rows * (size_t)dim;
    const int ldz = dim + 3;
    const size_t z_count = (size_t)rows * (size_t)ldz;
    return (Norm){random_reals(&rng, count, 1, 0.3),
                  random_reals(&rng, z_count, 1, 0),
                  random_reals(&rng, (size_t)dim, 0.5, 1),
                  random_reals(&rng, count, 1, 0),
                  random_reals(&rng, (size_t)rows, 1, 0),
                  random_reals(&rng, (size_t)rows, 1, 0),
                  random_reals(&rng, count, 1, 0),
                  random_reals(&rng, count, 1, 0),
                  random_reals(&rng, z_count, 0, 2),
                  random_reals(&rng, (size_t)dim, 0, 2),
                  count,
                  rows,
                  dim,
                  ldz};
}

static void free_norm(Norm *n) {
    real *all[] = {n->x, n->z, n->gain, n->y, n->mean, n->rstd, n->weights, n->dx, n->dz, n->dgain};
    for (size_t i = 0; i < sizeof(all) / sizeof(all[0]); i++) ffp_free(all[i]);
}

static double layer_loss(void *context) {
    Norm *n = context;
    ffp_layernorm_forward(n->y, n->mean, n->rstd, n->x, n->gain, n->rows, n->dim);
    return dot_reals(n->y, n->weights, n->count);
}

static double rms_loss(void *context) {
    Norm *n = context;
    ffp_rmsnorm_forward(n->y, n->rstd, n->x, n->gain, n->rows, n->dim);
    return dot_reals(n->y, n->weights, n->count);
}

static FfpGatedNorm gated_input(const Norm *n) {
    return (FfpGatedNorm){n->x, n->z, n->ldz, n->gain, n->rows, n->dim};
}

static double gated_loss(void *context) {
    Norm *n = context;
    const FfpGatedNorm in = gated_input(n);
    ffp_gated_norm_forward(n->y, n->rstd, &in);
    return dot_reals(n->y, n->weights, n->count);
}

static const int shapes[][2] = {{5, 7}, {3, 1}, {2, 67}, {35, 33}};
enum { SHAPES = sizeof(shapes) / sizeof(shapes[0]) };

static void layernorm_gradients(void **state) {
    (void)state;
    for (int i = 0; i < SHAPES; i++) {
        if (shapes[i][1] == 1) continue; // the mean of one number leaves nothing
        Norm n = make_norm(shapes[i][0], shapes[i][1]);
        layer_loss(&n);
        ffp_layernorm_backward(n.dx, n.dgain, n.weights, n.x, n.mean, n.rstd, n.gain, n.rows, n.dim);
        check_gradient("layernorm x", layer_loss, &n, n.x, n.dx, 0, 1, n.count, n.count);
        check_gradient("layernorm gain", layer_loss, &n, n.gain, n.dgain, 2, 1, (size_t)n.dim, (size_t)n.dim);
        free_norm(&n);
    }
}

static void rmsnorm_gradients(void **state) {
    (void)state;
    for (int i = 0; i < SHAPES; i++) {
        Norm n = make_norm(shapes[i][0], shapes[i][1]);
        rms_loss(&n);
        ffp_rmsnorm_backward(n.dx, n.dgain, n.weights, n.x, n.rstd, n.gain, n.rows, n.dim);
        check_gradient("rmsnorm x", rms_loss, &n, n.x, n.dx, 0, 1, n.count, n.count);
        check_gradient("rmsnorm gain", rms_loss, &n, n.gain, n.dgain, 2, 1, (size_t)n.dim, (size_t)n.dim);
        free_norm(&n);
    }
}

static void gated_norm_gradients(void **state) {
    (void)state;
    for (int i = 0; i < SHAPES; i++) {
        Norm n = make_norm(shapes[i][0], shapes[i][1]);
        gated_loss(&n);
        const FfpGatedNorm in = gated_input(&n);
        ffp_gated_norm_backward(&(FfpGatedNormGradient){n.dx, n.dz, n.ldz, n.dgain}, &in, n.weights, n.rstd);
        check_gradient("gated norm x", gated_loss, &n, n.x, n.dx, 0, 1, n.count, n.count);
        check_gradient("gated norm z", gated_loss, &n, n.z, n.dz, 2, (size_t)n.rows, (size_t)n.dim,
                       (size_t)n.ldz);
        check_gradient("gated norm gain", gated_loss, &n, n.gain, n.dgain, 2, 1, (size_t)n.dim,
                       (size_t)n.dim);
        for (int t = 0; t < n.rows; t++) // what lies between the rows is left alone
            for (int j = n.dim; j < n.ldz; j++) assert_true(n.dz[t * n.ldz + j] == 2);
        free_norm(&n);
    }
}

// The numbers themselves, from the definitions.
static void norm_values(void **state) {
    (void)state;
    Norm n = make_norm(4, 9);
    for (int kind = 0; kind < 3; kind++) {
        if (kind == 0) layer_loss(&n);
        if (kind == 1) rms_loss(&n);
        if (kind == 2) gated_loss(&n);
        for (int t = 0; t < n.rows; t++) {
            double in[9], mean = 0, square = 0;
            for (int i = 0; i < 9; i++) {
                const double z = n.z[t * n.ldz + i];
                in[i] = n.x[t * 9 + i] * (kind == 2 ? z / (1 + exp(-z)) : 1);
                mean += kind == 0 ? in[i] / 9 : 0;
            }
            for (int i = 0; i < 9; i++) square += (in[i] - mean) * (in[i] - mean) / 9;
            for (int i = 0; i < 9; i++) {
                const double expected = (in[i] - mean) / sqrt(square + 1e-5) * n.gain[i];
                assert_true(fabs(expected - n.y[t * 9 + i]) < 1e-6); // the epsilon is a fp32 constant
            }
        }
    }
    free_norm(&n);
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(norm_values), cmocka_unit_test(layernorm_gradients),
                                       cmocka_unit_test(rmsnorm_gradients),
                                       cmocka_unit_test(gated_norm_gradients)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
