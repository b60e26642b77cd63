// How the sums of the losses' kernels are added, and values that nobody waits for yet.
#include "engine/cuda/loss_sums.h"
#include "engine/cuda/memory.h"
extern "C" {
#include "engine/cuda/cuda.h"
}
#include "engine/cuda/loss_room.h"

enum { MOST = FFP_DEFERRED_MAX, QUANTITIES = FFP_SUM_QUANTITIES };

// Values that nobody waits for yet.
static struct {
    bool on;
    int count;
    double *totals;                    // [MOST, QUANTITIES], the device's
    double scale[MOST], divisor[MOST]; // divisor 0: the second total
} late;

static double mean_of(const double *totals, double scale, double divisor) {
    const double count = divisor > 0 ? divisor : totals[1];
    return count > 0 ? scale * (totals[0] / count) : 0;
}

void ffp_cuda_losses_defer(bool on) {
    if (!late.totals) late.totals = (double *)ffp_cuda_alloc(MOST * QUANTITIES * sizeof(double));
    late.on = on;
    late.count = 0;
}

int ffp_cuda_deferred_count(void) {
    return late.count;
}

void ffp_cuda_deferred_values(double *values) {
    static double totals[MOST * QUANTITIES];
    ffp_cuda_download(totals, late.totals, (size_t)late.count * QUANTITIES * sizeof(double));
    for (int i = 0; i < late.count; i++)
        values[i] = mean_of(totals + i * QUANTITIES, late.scale[i], late.divisor[i]);
    late.count = 0;
}

// Where the totals of the next value go.
static double *late_place(void) {
    if (late.count < MOST) return late.totals + late.count * QUANTITIES;
    fprintf(stderr, "ffprocams: too many losses are late\n");
    abort();
}

bool ffp_cuda_losses_are_deferred(void) {
    return late.on;
}

FfpPartials ffp_cuda_loss_partials(int quantities, unsigned blocks) {
    static void *scratch;
    static size_t capacity;
    ffp_cuda_grow(&scratch, &capacity, (FFP_SUM_QUANTITIES + (size_t)quantities * blocks) * sizeof(double));
    double *total = (double *)scratch, *partial = total + FFP_SUM_QUANTITIES;
    return FfpPartials{late.on ? late_place() : total, partial, blocks, quantities};
}

static __global__ void add_partials(FfpPartials sums) {
    const double *partial = sums.partial + (size_t)blockIdx.x * sums.blocks;
    double mine = 0;
    for (unsigned i = threadIdx.x; i < sums.blocks; i += blockDim.x) mine += partial[i];
    mine = ffp_block_sum(mine);
    if (threadIdx.x == 0) sums.total[blockIdx.x] = mine;
}

void ffp_cuda_loss_add(const FfpPartials *sums) {
    ffp_launch_blocks(add_partials, dim3((unsigned)sums->quantities), dim3(FFP_SUM_THREADS), 0, *sums);
}

void ffp_cuda_loss_totals(double *totals, const FfpPartials *sums, bool add) {
    if (add) ffp_cuda_loss_add(sums);
    ffp_cuda_download(totals, sums->total, (size_t)sums->quantities * sizeof *totals);
}

double ffp_cuda_mean(const FfpPartials *sums, bool add, double scale, double count) {
    if (late.on) {
        if (add) ffp_cuda_loss_add(sums);
        late.scale[late.count] = scale;
        late.divisor[late.count++] = count;
        return 0;
    }
    double totals[FFP_SUM_QUANTITIES];
    ffp_cuda_loss_totals(totals, sums, add);
    return mean_of(totals, scale, count);
}
