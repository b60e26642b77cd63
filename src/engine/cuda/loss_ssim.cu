// Structural similarity (engine/loss/ssim.c says what it is): a block takes 16x16 pixels of a channel, with
// what the window reaches around them, through both passes of the separable window in shared memory.
#include "engine/cuda/loss_room.h"
#include "engine/cuda/loss_sums.h"
#include "engine/cuda/memory.h"
extern "C" {
#include "engine/loss/terms.h"
}

enum { RADIUS = 5, TAPS = 2 * RADIUS + 1, TILE = 16, WIDE = TILE + 2 * RADIUS, MOMENTS = 5, SLOPES = 3 };

// Passed to the kernels by value.
typedef struct Window {
    int width, height, channels;
    float taps[TAPS];
} Window;

static Window window_for(const FfpImage *image) {
    Window window = {image->width, image->height, image->channels, {0}};
    float sum = 0;
    for (int k = 0; k < TAPS; k++) {
        const float x = (float)(k - RADIUS) / 1.5F;
        sum += window.taps[k] = expf(-0.5F * x * x);
    }
    for (int k = 0; k < TAPS; k++) window.taps[k] /= sum;
    return window;
}

// The block's tile and its surroundings, zero outside the map; values of a map lie `stride` apart.
static __device__ void load(float tile[WIDE][WIDE], const float *map, int stride, const Window &window) {
    const int left = (int)blockIdx.x * TILE - RADIUS, top = (int)blockIdx.y * TILE - RADIUS;
    for (int k = (int)(threadIdx.y * TILE + threadIdx.x); k < WIDE * WIDE; k += TILE * TILE) {
        const int x = left + k % WIDE, y = top + k / WIDE;
        const bool inside = x >= 0 && y >= 0 && x < window.width && y < window.height;
        tile[k / WIDE][k % WIDE] = inside ? map[((size_t)y * window.width + x) * stride] : 0;
    }
}

// The moments' blur along the rows of the tile.
static __device__ void blur_across(float across[MOMENTS][WIDE][TILE], const float a[WIDE][WIDE],
                                   const float b[WIDE][WIDE], const Window &window) {
    for (int k = (int)(threadIdx.y * TILE + threadIdx.x); k < WIDE * TILE; k += TILE * TILE) {
        const int row = k / TILE, column = k % TILE;
        float moment[MOMENTS] = {0, 0, 0, 0, 0};
#pragma unroll
        for (int t = 0; t < TAPS; t++) {
            const float tap = window.taps[t], va = a[row][column + t], vb = b[row][column + t];
            moment[0] += tap * va;
            moment[1] += tap * vb;
            moment[2] += tap * (va * va);
            moment[3] += tap * (vb * vb);
            moment[4] += tap * (va * vb);
        }
        for (int m = 0; m < MOMENTS; m++) across[m][row][column] = moment[m];
    }
}

// The thread's pixel of a map blurred along its rows: the blur down the columns.
static __device__ float blur_down(const float across[WIDE][TILE], const Window &window) {
    float sum = 0;
#pragma unroll
    for (int t = 0; t < TAPS; t++) sum += window.taps[t] * across[threadIdx.y + t][threadIdx.x];
    return sum;
}

// The index's sum, and its slopes by E[a], E[aa], E[ab] into slopes [SLOPES, channels, height, width] unless
// that is NULL.
static __global__ void __launch_bounds__(TILE *TILE)
    compare(FfpPartials sums, float *slopes, const float *a, const float *b, Window window) {
    __shared__ float tile_a[WIDE][WIDE], tile_b[WIDE][WIDE], across[MOMENTS][WIDE][TILE];
    const int x = (int)(blockIdx.x * TILE + threadIdx.x), y = (int)(blockIdx.y * TILE + threadIdx.y);
    load(tile_a, a + blockIdx.z, window.channels, window);
    load(tile_b, b + blockIdx.z, window.channels, window);
    __syncthreads();
    blur_across(across, tile_a, tile_b, window);
    __syncthreads();
    float moment[MOMENTS], slope[SLOPES], index = 0;
    if (x < window.width && y < window.height) {
        for (int m = 0; m < MOMENTS; m++) moment[m] = blur_down(across[m], window);
        index =
            ffp_ssim_term(moment[0], moment[1], moment[2], moment[3], moment[4], slope, slope + 1, slope + 2);
        const size_t plane = (size_t)window.width * window.height, map = plane * window.channels;
        const size_t at = blockIdx.z * plane + (size_t)y * window.width + x;
        for (int s = 0; slopes && s < SLOPES; s++) slopes[s * map + at] = slope[s];
    }
    ffp_store_partial(sums, 0, index);
}

// grad += scale (blur(slope_a) + 2 a blur(slope_aa) + b blur(slope_ab))
static __global__ void __launch_bounds__(TILE *TILE)
    add_gradient(const float *slopes, const float *a, const float *b, float scale, float *grad,
                 Window window) {
    __shared__ float tile[SLOPES][WIDE][WIDE], across[SLOPES][WIDE][TILE];
    const size_t plane = (size_t)window.width * window.height, map = plane * window.channels;
    const int x = (int)(blockIdx.x * TILE + threadIdx.x), y = (int)(blockIdx.y * TILE + threadIdx.y);
    for (int s = 0; s < SLOPES; s++) load(tile[s], slopes + s * map + blockIdx.z * plane, 1, window);
    __syncthreads();
    for (int k = (int)(threadIdx.y * TILE + threadIdx.x); k < SLOPES * WIDE * TILE; k += TILE * TILE) {
        const int s = k / (WIDE * TILE), row = k / TILE % WIDE, column = k % TILE;
        float sum = 0;
#pragma unroll
        for (int t = 0; t < TAPS; t++) sum += window.taps[t] * tile[s][row][column + t];
        across[s][row][column] = sum;
    }
    __syncthreads();
    if (x >= window.width || y >= window.height) return;
    const size_t i = ((size_t)y * window.width + x) * window.channels + blockIdx.z;
    grad[i] += scale * (blur_down(across[0], window) + 2 * a[i] * blur_down(across[1], window) +
                        b[i] * blur_down(across[2], window));
}

double ffp_cuda_ssim(const FfpImage *a, const FfpImage *b, real scale, FfpImage *grad) {
    static void *slopes;
    static size_t capacity;
    const Window window = window_for(a);
    const size_t map = (size_t)a->width * a->height * a->channels;
    const dim3 tiles(ffp_blocks((size_t)a->width, TILE), ffp_blocks((size_t)a->height, TILE),
                     (unsigned)a->channels);
    const FfpPartials sums = ffp_cuda_loss_partials(1, tiles.x * tiles.y * tiles.z);
    if (grad) ffp_cuda_grow(&slopes, &capacity, SLOPES * map * sizeof(float));
    ffp_launch_blocks(compare, tiles, dim3(TILE, TILE), 0, sums, grad ? (float *)slopes : NULL, a->data,
                      b->data, window);
    if (grad)
        ffp_launch_blocks(add_gradient, tiles, dim3(TILE, TILE), 0, (const float *)slopes, a->data, b->data,
                          scale, grad->data, window);
    return ffp_cuda_mean(&sums, true, 1, (double)map);
}
