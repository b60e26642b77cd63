// Ranks on a device: gradients and weights pass through the host (lab/train/shard.h), and a rank's part of
// the optimiser's state lies there. The other rank is made up: its gradient is what its number says, and its
// weights are 7.
#include "compare.h"
#include "core/base/call.h"
#include "core/base/rng.h"
#include "lab/train/mirror.h"
#include "lab/train/shard.h"

static const FfpDevice *device;
static int sums; // begun, not finished
static int64_t summed;

static void sum_begin(void *user, float *values, int64_t count) {
    (void)user;
    for (int64_t i = 0; i < count; i++) values[i] += 0.5F;
    sums++, summed += count;
}

static bool sum_finish(void *user, FfpError *err) {
    (void)user, (void)err;
    sums = 0;
    return true;
}

static bool sum(void *user, double *values, int count, FfpError *err) {
    (void)user, (void)values, (void)count, (void)err;
    return true;
}

static bool gather(void *user, const float *part, float *whole, const int64_t *first, int to, FfpError *err) {
    (void)user, (void)err;
    assert_int_equal(to, -1);
    assert_ptr_equal(part, whole + first[1]);
    for (int64_t i = 0; i < first[1]; i++) whole[i] = 7;
    return true;
}

typedef struct Both { // the update on the CPU and on the device
    FfpModel *model;
    FfpAdam adam;
    real *grad;
} Both;

static bool compare(void *argument, FfpError *err) {
    Both *b = argument;
    FfpTrainConfig config = ffp_train_defaults();
    config.batch = 2;
    const int64_t n = b->model->count;
    FfpShard share;
    ffp_shard_open(&share, n);
    const int64_t first = ffp_shard_first(&share), count = ffp_shard_count(&share);
    assert_true(first > 0 && first + count == n && first % 16 == 0);
    ffp_adam_keep(&b->adam, first, count);
    for (int64_t i = 0; i < count; i++) b->adam.v[i] = 0.01F;

    const FfpDevice *before = ffp_device_use(device);
    FfpMirror *mirror = ffp_mirror_new(b->model, &b->adam, &config);
    real *grad = ffp_memory_uploaded(b->grad, (size_t)n, sizeof(real));
    bool skipped;
    ffp_shard_reduce_begin(&share, grad);
    ffp_shard_reduce_ready(&share, n / 2);
    ffp_shard_reduce_ready(&share, 0);
    assert_true(sums > 1 && summed == n);
    assert_true(ffp_shard_reduce_finish(&share, err));
    ffp_adam_move_all(&mirror->adam, &mirror->model, grad, &config, 2, &skipped);
    assert_true(!skipped && ffp_shard_gather_weights(&share, mirror->model.values, err));

    real *there = ffp_alloc((size_t)n, sizeof(real));
    ffp_memory_download(there, mirror->model.values, (size_t)n * sizeof(real));
    ffp_memory_free(grad);
    ffp_mirror_free(mirror, &config);
    ffp_device_use(before);
    for (int64_t i = 0; i < n; i++) b->grad[i] += 0.5F;
    ffp_adam_move_all(&b->adam, b->model, b->grad, &config, 2, &skipped);
    for (int64_t i = 0; i < first; i++) assert_true(there[i] == 7);
    for (int64_t i = first; i < n; i++)
        if (!(fabsf(there[i] - b->model->values[i]) <= 1e-6F * (1 + fabsf(there[i]))))
            fail_msg("weight %lld: %g, %g on the CPU", (long long)i, there[i], b->model->values[i]);
    ffp_free(there);
    ffp_shard_close(&share);
    return true;
}

static void a_part_of_the_state_is_the_devices(void **state) {
    (void)state;
    FfpError err = {0};
    FfpModelConfig config;
    assert_true(ffp_model_preset(&config, "tiny"));
    config.dim = 192; // more than one bucket
    Both both = {.model = ffp_model_new(&config, 1, &err)};
    both.adam = ffp_adam_new(both.model);
    both.grad = ffp_alloc((size_t)both.model->count, sizeof(real));
    FfpRng rng = ffp_rng(3, 0);
    for (int64_t i = 0; i < both.model->count; i++) both.grad[i] = (real)ffp_rng_normal(&rng) * 0.01F;
    const FfpRanks ranks = {.rank = 1,
                            .count = 2,
                            .sum_begin = sum_begin,
                            .sum_finish = sum_finish,
                            .sum = sum,
                            .gather = gather};
    FfpContext context = {.settings = {.ranks = &ranks}};
    if (!ffp_call_run(&context, compare, &both, &err)) fail_msg("%s", err.text);
    ffp_adam_free(&both.adam);
    ffp_model_free(both.model);
    ffp_free(both.grad);
}

int main(void) {
    if (!(device = find_device())) return 0;
    const struct CMUnitTest tests[] = {cmocka_unit_test(a_part_of_the_state_is_the_devices)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
