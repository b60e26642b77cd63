// Sums and GELU (exact form: y = x Phi(x) with the normal distribution Phi), number by number.
#include "engine/cuda/launch.h"
extern "C" {
#include "engine/cuda/tensor.h"
}

enum { GROUP = 4 }; // numbers a thread

// Up to a group of x from its place on; beyond the end zeros.
static __device__ inline float4 load_group(const float *x, size_t first, size_t count, bool aligned) {
    if (aligned && first + GROUP <= count) return *(const float4 *)(x + first);
    return make_float4(x[first], first + 1 < count ? x[first + 1] : 0, first + 2 < count ? x[first + 2] : 0,
                       first + 3 < count ? x[first + 3] : 0);
}

static __device__ inline void store_group(float *y, float4 v, size_t first, size_t count, bool aligned) {
    if (aligned && first + GROUP <= count) {
        *(float4 *)(y + first) = v;
        return;
    }
    const float numbers[GROUP] = {v.x, v.y, v.z, v.w};
    for (int i = 0; i < GROUP && first + i < count; i++) y[first + i] = numbers[i];
}

static bool all_aligned(const void *a, const void *b, const void *c) {
    return ((uintptr_t)a | (uintptr_t)b | (uintptr_t)c) % 16 == 0;
}

static __global__ void add_groups(size_t groups, float *y, const float *x, size_t count, bool aligned) {
    const size_t first = ffp_thread() * GROUP;
    if (ffp_thread() >= groups) return;
    const float4 a = load_group(y, first, count, aligned), b = load_group(x, first, count, aligned);
    store_group(y, make_float4(a.x + b.x, a.y + b.y, a.z + b.z, a.w + b.w), first, count, aligned);
}

void ffp_cuda_add(float *y, const float *x, size_t count) {
    const size_t groups = (count + GROUP - 1) / GROUP;
    ffp_launch_each(groups, add_groups, y, x, count, all_aligned(y, x, x));
}

static __device__ inline float normal_below(float x) {
    return 0.5f * erfcf(-0.70710678f * x);
}

static __device__ inline float gelu_slope(float x) {
    return normal_below(x) + x * 0.398942280f * expf(-0.5f * x * x);
}

static __global__ void gelu_groups(size_t groups, float *y, const float *x, size_t count, bool aligned) {
    const size_t first = ffp_thread() * GROUP;
    if (ffp_thread() >= groups) return;
    float4 v = load_group(x, first, count, aligned);
    v.x *= normal_below(v.x), v.y *= normal_below(v.y), v.z *= normal_below(v.z), v.w *= normal_below(v.w);
    store_group(y, v, first, count, aligned);
}

void ffp_cuda_gelu_forward(float *y, const float *x, size_t count) {
    const size_t groups = (count + GROUP - 1) / GROUP;
    ffp_launch_each(groups, gelu_groups, y, x, count, all_aligned(y, x, x));
}

// dy/dx = Phi(x) + x phi(x)
static __global__ void gelu_back_groups(size_t groups, float *dx, const float *dy, const float *x,
                                        size_t count, bool aligned) {
    const size_t first = ffp_thread() * GROUP;
    if (ffp_thread() >= groups) return;
    const float4 v = load_group(x, first, count, aligned);
    float4 g = load_group(dy, first, count, aligned);
    g.x *= gelu_slope(v.x), g.y *= gelu_slope(v.y), g.z *= gelu_slope(v.z), g.w *= gelu_slope(v.w);
    store_group(dx, g, first, count, aligned);
}

void ffp_cuda_gelu_backward(float *dx, const float *dy, const float *x, size_t count) {
    const size_t groups = (count + GROUP - 1) / GROUP;
    ffp_launch_each(groups, gelu_back_groups, dx, dy, x, count, all_aligned(dx, dy, x));
}
