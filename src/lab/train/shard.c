#include "lab/train/shard.h"
#include <stdlib.h>
#include <string.h>
#include "core/base/arena.h"
#include "core/base/call.h"
#include "core/base/device.h"
#include "core/base/hash.h"

#define BUCKET ((int64_t)1 << 20) // numbers that are added up at a time
#define ALIGNMENT 16              // weights; parts begin at cache lines

// The call is left in the middle of things (core/base/call.h): the others would wait for ever.
static void leave(void *ranks) {
    ((FfpRanks *)ranks)->leave(((FfpRanks *)ranks)->user);
}

void ffp_shard_open(FfpShard *share, int64_t weights) {
    const FfpContext *context = ffp_call_context();
    const FfpRanks *ranks = context ? context->settings.ranks : NULL;
    *share = (FfpShard){.turn = {0, 1}, .weights = weights};
    if (!ranks || ranks->count < 2) return;
    ffp_own((void *)ranks, leave);
    share->ranks = ranks;
    share->turn = (FfpRank){ranks->rank, ranks->count};
    share->first = ffp_alloc((size_t)ranks->count + 1, sizeof *share->first);
    for (int r = 0; r <= ranks->count; r++)
        share->first[r] = r == ranks->count ? weights : weights / ranks->count * r / ALIGNMENT * ALIGNMENT;
}

void ffp_shard_close(FfpShard *share) {
    ffp_disown((void *)share->ranks);
    ffp_free(share->first);
    if (share->there) ffp_free(share->grad);
    *share = (FfpShard){0};
}

// That all ranks have read the same: the configuration, and the checkpoint's step.
static bool check_same(const FfpShard *share, const FfpTrainConfig *config, int64_t step, FfpError *err) {
    char *text = ffp_train_config_print(config, err);
    if (!text) return false;
    const uint64_t own[2] = {ffp_hash_text(FFP_HASH_NONE, text), (uint64_t)step};
    ffp_free(text);
    uint64_t first[2] = {own[0], own[1]};
    if (!share->ranks->broadcast(share->ranks->user, first, sizeof first, 0, err)) return false;
    double differ = memcmp(own, first, sizeof own) != 0;
    const bool mine = differ > 0;
    if (!ffp_shard_sum(share, &differ, 1, err)) return false;
    if (differ == 0) return true;
    if (mine)
        return ffp_fail(err, FFP_ERROR_ARGUMENT, NULL,
                        "rank %d sees a different configuration or checkpoint from rank 0: all ranks need "
                        "the same folder",
                        share->turn.rank);
    return ffp_fail(err, FFP_ERROR_ARGUMENT, NULL,
                    "other ranks see a different configuration or checkpoint: all ranks need the same "
                    "folder");
}

bool ffp_shard_check(const FfpShard *share, const FfpTrainConfig *config, int64_t step, FfpError *err) {
    const int count = share->turn.count;
    if (!share->ranks) return true;
    if (config->batch % count)
        return ffp_fail(err, FFP_ERROR_ARGUMENT, "batch",
                        "%d scenes per step cannot be divided among %d ranks: use a multiple of their number",
                        config->batch, count);
    if (config->pool % count)
        return ffp_fail(err, FFP_ERROR_ARGUMENT, "pool",
                        "%d scenes cannot be divided among %d ranks: use a multiple of their number",
                        config->pool, count);
    return check_same(share, config, step, err);
}

int64_t ffp_shard_first(const FfpShard *share) {
    return share->ranks ? share->first[share->turn.rank] : 0;
}

int64_t ffp_shard_count(const FfpShard *share) {
    return share->ranks ? share->first[share->turn.rank + 1] - share->first[share->turn.rank]
                        : share->weights;
}

void ffp_shard_reduce_begin(FfpShard *share, real *grad) {
    if (!share->ranks) return;
    share->begun = share->weights;
    if (!ffp_device()) {
        share->grad = grad;
        return;
    }
    if (!share->there) share->grad = ffp_alloc((size_t)share->weights, sizeof(real));
    share->there = grad;
}

static void begin_sum(FfpShard *share, int64_t count) {
    const int64_t first = share->begun - count;
    if (share->there)
        ffp_memory_download(share->grad + first, share->there + first, (size_t)count * sizeof(real));
    share->ranks->sum_begin(share->ranks->user, share->grad + first, count);
    share->begun = first;
}

// Sums are of the same parts on all ranks, however the gradient becomes ready.
void ffp_shard_reduce_ready(void *argument, int64_t first) {
    FfpShard *share = argument;
    while (share->begun - first >= BUCKET) begin_sum(share, BUCKET);
    if (first == 0 && share->begun > 0) begin_sum(share, share->begun);
}

bool ffp_shard_reduce_finish(FfpShard *share, FfpError *err) {
    if (!share->ranks) return true;
    ffp_shard_reduce_ready(share, 0); // of a rank whose step failed: the others wait for it
    if (!share->ranks->sum_finish(share->ranks->user, err)) return false;
    const int64_t first = ffp_shard_first(share);
    if (share->there)
        ffp_memory_upload(share->there + first, share->grad + first,
                          (size_t)ffp_shard_count(share) * sizeof(real));
    return true;
}

bool ffp_shard_sum(const FfpShard *share, double *values, int count, FfpError *err) {
    return !share->ranks || share->ranks->sum(share->ranks->user, values, count, err);
}

// On a device the host's copy of the gradient, which is done with, holds the weights on their way.
bool ffp_shard_gather_weights(FfpShard *share, real *values, FfpError *err) {
    if (!share->ranks) return true;
    const FfpRanks *ranks = share->ranks;
    const int64_t first = ffp_shard_first(share);
    if (!share->there) return ranks->gather(ranks->user, values + first, values, share->first, -1, err);
    const size_t part = (size_t)ffp_shard_count(share) * sizeof(real);
    ffp_memory_download(share->grad + first, values + first, part);
    if (!ranks->gather(ranks->user, share->grad + first, share->grad, share->first, -1, err)) return false;
    ffp_memory_upload(values, share->grad, (size_t)share->weights * sizeof(real));
    return true;
}

static bool gather(const FfpShard *share, const real *part, real **whole, FfpError *err) {
    if (share->turn.rank == 0) *whole = ffp_alloc((size_t)share->weights, sizeof(real));
    return share->ranks->gather(share->ranks->user, part, *whole, share->first, 0, err);
}

bool ffp_shard_gather_state(const FfpShard *share, const FfpAdam *adam, bool average_only, FfpAdam *whole,
                            FfpError *err) {
    *whole = *adam;
    if (!share->ranks) return true;
    *whole = (FfpAdam){.count = share->weights, .step = adam->step};
    return gather(share, adam->ema, &whole->ema, err) &&
           (average_only ||
            (gather(share, adam->m, &whole->m, err) && gather(share, adam->v, &whole->v, err)));
}

void ffp_shard_state_free(const FfpShard *share, FfpAdam *whole) {
    if (share->ranks) ffp_adam_free(whole);
}
