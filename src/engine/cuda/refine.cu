// A fit's numbers on the GPU: the maps of engine/refine/maps.h a thread a splat, Adam a thread a number.
#include "engine/cuda/launch.h"
extern "C" {
#include "engine/cuda/cuda.h"
#include "engine/refine/maps.h"
#include "engine/refine/table.h"
}
#include "engine/cuda/refine.h"

namespace { // the launches are templates of these types: no other source may have their names

// Seven arrays that are worked on alike, number by number: blockIdx.y says which.
struct Flat {
    real *data[FFP_ATTRIBUTES];
    size_t count[FFP_ATTRIBUTES];
};

struct Moved {
    FfpGaussianAdamStep move;
    Flat x, mean, square, start, grad; // start: of no elements where nothing pulls
    const real *shared;
    real *cross; // NULL: centres are not coupled
};

} // namespace

static const size_t most = 4; // numbers of a splat's widest attribute

static Flat flat(const FfpGaussians *g) {
    Flat f;
    for (int a = 0; a < FFP_ATTRIBUTES; a++) {
        const FfpAttribute x = ffp_attribute(g, a);
        f.data[a] = x.data;
        f.count[a] = (size_t)g->count * (size_t)x.width;
    }
    return f;
}

static dim3 flat_grid(const FfpGaussians *g) {
    return dim3(ffp_blocks(most * (size_t)g->count, 256), FFP_ATTRIBUTES);
}

static __global__ void clear_kernel(Flat f) {
    const size_t i = ffp_thread();
    if (i < f.count[blockIdx.y]) f.data[blockIdx.y][i] = 0;
}

static void clear(const FfpGaussians *gaussians) {
    ffp_launch(clear_kernel, flat_grid(gaussians), dim3(256), flat(gaussians));
}

static __global__ void encode_kernel(size_t count, FfpGaussians g, bool local, FfpParameters p) {
    const size_t i = ffp_thread();
    if (i < count) ffp_encode(&g, (int64_t)i, local, &p);
}

static void encode(const FfpGaussians *gaussians, bool local, const FfpParameters *out) {
    ffp_launch_each((size_t)gaussians->count, encode_kernel, *gaussians, local, *out);
}

static __global__ void decode_kernel(size_t count, FfpParameters p, FfpGaussians out) {
    const size_t i = ffp_thread();
    if (i < count) ffp_decode(&p, (int64_t)i, &out);
}

static void decode(const FfpParameters *parameters, const FfpGaussians *out) {
    ffp_launch_each((size_t)out->count, decode_kernel, *parameters, *out);
}

static __global__ void pull_back_kernel(size_t count, FfpParameters p, FfpGaussians d, FfpGaussians grad) {
    const size_t i = ffp_thread();
    if (i < count) ffp_pull_back(&p, &d, (int64_t)i, &grad);
}

static void pull_back(const FfpParameters *parameters, const FfpGaussians *decoded,
                      const FfpGaussians *grad) {
    ffp_launch_each((size_t)grad->count, pull_back_kernel, *parameters, *decoded, *grad);
}

static __global__ void average_kernel(Flat numbers, real share, Flat mean) {
    const size_t i = ffp_thread();
    const unsigned a = blockIdx.y;
    if (i < mean.count[a]) ffp_average(numbers.data[a][i], share, mean.data[a] + i);
}

static void average(const FfpGaussians *numbers, real share, const FfpGaussians *mean) {
    ffp_launch(average_kernel, flat_grid(mean), dim3(256), flat(numbers), share, flat(mean));
}

// The gradient to the shared roughness: each block's part of the sum, then one block adds these in order.
enum { SUM_THREADS = 256, SUM_BLOCKS = 128 };
static __device__ double parts[SUM_BLOCKS];

// The block's sum, in thread 0.
static __device__ double block_sum(double mine) {
    __shared__ double sums[SUM_THREADS];
    sums[threadIdx.x] = mine;
    for (unsigned half = SUM_THREADS / 2; half > 0; half /= 2) {
        __syncthreads();
        if (threadIdx.x < half) sums[threadIdx.x] += sums[threadIdx.x + half];
    }
    return sums[threadIdx.x];
}

static __global__ void sum_kernel(size_t count, const real *x) {
    double mine = 0;
    for (size_t i = ffp_thread(); i < count; i += (size_t)gridDim.x * SUM_THREADS) mine += (double)x[i];
    const double sum = block_sum(mine);
    if (threadIdx.x == 0) parts[blockIdx.x] = sum;
}

static __global__ void shared_kernel(unsigned blocks, FfpAdamStep step, real *shared) {
    const double sum = block_sum(threadIdx.x < blocks ? parts[threadIdx.x] : 0);
    if (threadIdx.x == 0) ffp_adam_shared(&step, sum, shared);
}

static void move_shared(const FfpGaussianAdamStep *move, const FfpGaussians *grad, real *shared) {
    const size_t count = (size_t)grad->count;
    const unsigned needed = ffp_blocks(count, SUM_THREADS), most_blocks = SUM_BLOCKS;
    const unsigned blocks = needed < most_blocks ? needed : most_blocks;
    ffp_launch_blocks(sum_kernel, dim3(blocks), dim3(SUM_THREADS), 0, count, grad->roughness);
    ffp_launch_blocks(shared_kernel, dim3(1), dim3(SUM_THREADS), 0, blocks, move->shared, shared);
}

// The centre whose first number is i.
static __device__ void move_centre(const Moved *m, size_t i) {
    const FfpAdamStep *step = &m->move.of[FFP_CENTRE];
    real *x = m->x.data[FFP_CENTRE] + i;
    ffp_adam_coupled(step, m->grad.data[FFP_CENTRE] + i, x, m->mean.data[FFP_CENTRE] + i,
                     m->square.data[FFP_CENTRE] + i, m->cross + i);
    for (int k = 0; k < 3 && m->start.count[FFP_CENTRE]; k++)
        x[k] = ffp_adam_pulled(step, x[k], m->start.data[FFP_CENTRE][i + k]);
}

static __global__ void move_kernel(Moved m) {
    const size_t i = ffp_thread();
    const unsigned a = blockIdx.y;
    if (i >= m.x.count[a]) return;
    if (a == FFP_CENTRE && m.cross) {
        if (i % 3 == 0) move_centre(&m, i);
        return;
    }
    const FfpAdamStep *step = &m.move.of[a];
    real *x = m.x.data[a] + i, *start = m.start.count[a] ? m.start.data[a] + i : NULL;
    ffp_adam_move(step, m.grad.data[a][i], x, m.mean.data[a] + i, m.square.data[a] + i);
    if (start) *x = ffp_adam_pulled(step, *x, *start);
    if (a != FFP_ROUGHNESS || !m.move.shares) return;
    *x += m.shared[FFP_SHARED_MOVED];
    if (start) *start += m.shared[FFP_SHARED_MOVED];
}

static void move(const FfpGaussianAdamStep *move, const FfpGaussians *grad, const FfpGaussians *numbers,
                 const FfpGaussianAdam *mover) {
    if (move->shares) move_shared(move, grad, mover->shared);
    const Moved m = {*move,      flat(numbers), flat(&mover->mean), flat(&mover->square), flat(&mover->start),
                     flat(grad), mover->shared, mover->cross};
    ffp_launch(move_kernel, flat_grid(numbers), dim3(256), m);
}

extern "C" const FfpRefineTable ffp_cuda_refine = {
    .clear = clear,
    .encode = encode,
    .decode = decode,
    .pull_back = pull_back,
    .average = average,
    .move = move,
    .summed_new = ffp_cuda_summed_new,
};
