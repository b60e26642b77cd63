// A run's share of the work among ranks (FfpRanks of ffprocams/context.h): data parallelism with a sharded
// optimiser (stage 1 of ZeRO, Rajbhandari et al. 2020). Every rank has all weights and makes gradients of its
// own scenes; gradients are added up while the backward pass goes on (Li et al. 2020, PyTorch's DDP); then
// each rank updates the weights whose moments and averages it keeps, and all gather the weights. For a
// single process everything here costs nothing.
#ifndef FFP_TRAIN_SHARD_H
#define FFP_TRAIN_SHARD_H

#include "ffprocams/context.h"
#include "lab/train/train.h"

typedef struct FfpShard {
    const FfpRanks *ranks; // NULL: alone
    FfpRank turn;
    int64_t weights;
    int64_t *first; // [count + 1] the first weight of each rank's state
    // Of the current step:
    real *grad;    // [weights] the sum is taken here; on a device a copy of its gradient, on the host
    real *there;   // the device's; NULL on the CPU
    int64_t begun; // sums of all from here on have been begun
} FfpShard;

// For the ranks of the current call, and a model with this number of weights.
void ffp_shard_open(FfpShard *share, int64_t weights);
void ffp_shard_close(FfpShard *share); // safe on {0}
// Checks that the run can be shared: fails if the ranks cannot draw disjoint scenes, or see different runs.
bool ffp_shard_check(const FfpShard *share, const FfpTrainConfig *config, int64_t step, FfpError *err);

int64_t ffp_shard_first(const FfpShard *share); // this rank's part of the weights
int64_t ffp_shard_count(const FfpShard *share);

// A step's gradient, in order: begin, ready as the gradient of the step's last scene becomes complete (as
// FfpRun.ready, with the share as `argument`), finish. Then grad, of the device in use if there is one, is
// the sum in this rank's part.
void ffp_shard_reduce_begin(FfpShard *share, real *grad);
void ffp_shard_reduce_ready(void *argument, int64_t first);
bool ffp_shard_reduce_finish(FfpShard *share, FfpError *err);
// Adds a few numbers up over the ranks.
bool ffp_shard_sum(const FfpShard *share, double *values, int count, FfpError *err);
// Every rank's part of the weights, of the device in use if there is one, to all.
bool ffp_shard_gather_weights(FfpShard *share, real *values, FfpError *err);

// The state of all weights, on rank 0: *whole, which the others have zeroed. Alone it is `adam` itself. With
// `average_only` it lacks the moments.
bool ffp_shard_gather_state(const FfpShard *share, const FfpAdam *adam, bool average_only, FfpAdam *whole,
                            FfpError *err);
void ffp_shard_state_free(const FfpShard *share, FfpAdam *whole);

#endif
