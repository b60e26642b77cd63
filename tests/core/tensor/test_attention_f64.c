// Attention in double: against the softmax written out, and gradients of q, k, v and both gains.
#include "core/base/alloc.h"
#include "core/tensor/gradient.h"
#include "core/tensor/naive_attention.h"
#include "core/tensor/tensor.h"

typedef struct Attention {
    FfpAttentionShape shape;
    real *qkv, *q_gain, *k_gain, *out, *log_sum, *weights, *scratch;
} Attention;

static double attention_loss(void *context) {
    Attention *a = context;
    const FfpAttentionShape *s = &a->shape;
    const FfpAttentionInput in = {a->qkv, a->q_gain, a->k_gain};
    ffp_attention_forward(a->out, a->log_sum, s, &in, a->scratch);
    return dot_reals(a->out, a->weights, (size_t)s->rows * (size_t)s->heads * (size_t)s->head_dim);
}

static Attention make_attention(int rows, int heads, int dim) {
    FfpRng rng = ffp_rng(7, (uint64_t)(rows * 100 + heads));
    const size_t count = (size_t)rows * (size_t)heads * (size_t)dim;
    const FfpAttentionShape shape = {rows, heads, dim};
    return (Attention){shape,
                       random_reals(&rng, 3 * count, 1, 0),
                       random_reals(&rng, (size_t)dim, 0.4, 1),
                       random_reals(&rng, (size_t)dim, 0.4, 1),
                       random_reals(&rng, count, 1, 0),
                       random_reals(&rng, (size_t)rows * (size_t)heads, 1, 0),
                       random_reals(&rng, count, 1, 0),
                       random_reals(&rng, ffp_attention_scratch(&shape), 1, 0)};
}

static void free_attention(Attention *a) {
    real *all[] = {a->qkv, a->q_gain, a->k_gain, a->out, a->log_sum, a->weights, a->scratch};
    for (size_t i = 0; i < sizeof(all) / sizeof(all[0]); i++) ffp_free(all[i]);
}

// Everything is perturbed and compared when `every` is 1;
// large cases take each every-th row of q, k and v only.
static void check_attention(int rows, int heads, int dim, size_t every) {
    Attention a = make_attention(rows, heads, dim);
    FfpRng rng = ffp_rng(8, 0);
    const size_t count = (size_t)rows * (size_t)heads * (size_t)dim, width = 3 * (size_t)heads * (size_t)dim;
    real *dqkv = random_reals(&rng, 3 * count, 1, 0);
    real *dq_gain = random_reals(&rng, (size_t)dim, 0, 2), *dk_gain = random_reals(&rng, (size_t)dim, 0, 2);
    printf("rows %d heads %d of %d\n", rows, heads, dim);
    attention_loss(&a);
    NaiveAttention naive = naive_attention(a.weights, a.qkv, a.q_gain, a.k_gain, rows, heads, dim);
    for (size_t i = 0; i < count; i++) assert_true(fabs(naive.out[i] - a.out[i]) < 1e-11);
    for (size_t i = 0, n = ffp_attention_scratch(&a.shape); i < n; i++) a.scratch[i] = NAN;
    const FfpAttentionInput in = {a.qkv, a.q_gain, a.k_gain};
    const FfpAttentionGradient grad = {dqkv, dq_gain, dk_gain};
    ffp_attention_backward(&grad, &a.shape, &in, a.out, a.log_sum, a.weights, a.scratch);
    for (size_t i = 0; i < 3 * count; i++) assert_true(fabs(naive.dqkv[i] - dqkv[i]) < 1e-11);
    const size_t checked = ((size_t)rows + every - 1) / every;
    check_gradient("attention q, k, v", attention_loss, &a, a.qkv, dqkv, 0, checked, width, every * width);
    if (rows > 1) {
        check_gradient("attention q gain", attention_loss, &a, a.q_gain, dq_gain, 2, 1, (size_t)dim,
                       (size_t)dim);
        check_gradient("attention k gain", attention_loss, &a, a.k_gain, dk_gain, 2, 1, (size_t)dim,
                       (size_t)dim);
    }
    ffp_free(dqkv), ffp_free(dq_gain), ffp_free(dk_gain);
    free_naive_attention(&naive);
    free_attention(&a);
}

static void attention_gradients(void **state) {
    (void)state;
    check_attention(13, 3, 5, 1);
    check_attention(1, 1, 4, 1);
    check_attention(3, 2, 7, 1); // fewer rows than segments of keys
}

// More than one block of queries and of keys, neither filling its last block.
static void attention_blocks(void **state) {
    (void)state;
    check_attention(1301, 1, 3, 400);
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(attention_gradients),
                                       cmocka_unit_test(attention_blocks)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
