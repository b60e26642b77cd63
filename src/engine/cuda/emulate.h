// Blocks and threads of CUDA on a plain CPU, for tests: slow, exact about who waits for whom. Threads of
// ffp_launch run one after another and may not meet; those of ffp_launch_blocks are fibers, and a meeting
// that not all come to ends the program with a message, as does host code that touches device memory.
#ifndef FFP_CUDA_EMULATE_H
#define FFP_CUDA_EMULATE_H

// clang-format off
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <functional>

#define __global__
#define __device__
#define __host__
#define __shared__ static
#define __forceinline__ inline
#define __launch_bounds__(...)
#define __grid_constant__

struct dim3 {
    unsigned x, y, z;
    dim3(unsigned width = 1, unsigned height = 1, unsigned depth = 1) : x(width), y(height), z(depth) {}
};
extern dim3 threadIdx, blockIdx, blockDim, gridDim;

struct float2 { float x, y; };
struct float3 { float x, y, z; };
struct alignas(16) float4 { float x, y, z, w; };
struct int2 { int x, y; };
struct alignas(16) int4 { int x, y, z, w; };
struct uint2 { unsigned x, y; };
struct alignas(16) [[gnu::may_alias]] uint4 { unsigned x, y, z, w; }; // copies numbers of other types
static inline float2 make_float2(float x, float y) { return {x, y}; }
static inline float3 make_float3(float x, float y, float z) { return {x, y, z}; }
static inline float4 make_float4(float x, float y, float z, float w) { return {x, y, z, w}; }
static inline int2 make_int2(int x, int y) { return {x, y}; }
static inline uint2 make_uint2(unsigned x, unsigned y) { return {x, y}; }

static inline float rsqrtf(float x) { return 1 / sqrtf(x); }
#define __expf(x) expf(x)
#define __logf(x) logf(x)
static inline float __fdividef(float x, float y) { return x / y; }
static inline float __saturatef(float x) { return x < 0 ? 0 : x > 1 ? 1 : x; }
static inline float __uint_as_float(unsigned x) { float y; memcpy(&y, &x, 4); return y; }
static inline unsigned __float_as_uint(float x) { unsigned y; memcpy(&y, &x, 4); return y; }
static inline int __popc(unsigned x) { return __builtin_popcount(x); }
static inline int __clz(int x) { return x ? __builtin_clz((unsigned)x) : 32; }
static inline int __ffs(int x) { return __builtin_ffs(x); }
template <typename T> static inline T __ldg(const T *p) { return *p; }
template <typename T> static inline T min(T a, T b) { return b < a ? b : a; }
template <typename T> static inline T max(T a, T b) { return a < b ? b : a; }
template <typename T> static inline T atomicAdd(T *p, T x) { const T before = *p; *p += x; return before; }
template <typename T> static inline T atomicMax(T *p, T x) { const T before = *p; if (x > before) *p = x; return before; }
template <typename T> static inline T atomicMin(T *p, T x) { const T before = *p; if (x < before) *p = x; return before; }
template <typename T> static inline T atomicOr(T *p, T x) { const T before = *p; *p |= x; return before; }

void __syncthreads();
void __syncwarp(unsigned mask = 0xffffffffu);
// Every lane of the warp that has not ended puts 8 bytes there and gets what `lane` has put.
uint64_t ffp_emulated_exchange(uint64_t mine, int lane);
// Every lane shows four numbers, and sees those of all: [32][4], until the warp's next meeting but one.
const uint64_t (*ffp_emulated_show(const uint64_t mine[4]))[4];
unsigned __ballot_sync(unsigned mask, int predicate);
static inline int __any_sync(unsigned mask, int predicate) { return __ballot_sync(mask, predicate) != 0; }
int __all_sync(unsigned mask, int predicate);

template <typename T> static inline T ffp_emulated_from(T mine, int lane) {
    static_assert(sizeof(T) <= 8, "a shuffled value has up to 8 bytes");
    uint64_t bits = 0;
    memcpy(&bits, &mine, sizeof mine);
    bits = ffp_emulated_exchange(bits, lane);
    memcpy(&mine, &bits, sizeof mine);
    return mine;
}
int ffp_emulated_lane();
template <typename T> static inline T __shfl_sync(unsigned, T x, int lane, int width = 32) {
    const int me = ffp_emulated_lane();
    return ffp_emulated_from(x, (me & ~(width - 1)) + (lane & (width - 1)));
}
template <typename T> static inline T __shfl_xor_sync(unsigned, T x, int other, int width = 32) {
    (void)width;
    return ffp_emulated_from(x, ffp_emulated_lane() ^ other);
}
template <typename T> static inline T __shfl_down_sync(unsigned, T x, int by, int width = 32) {
    const int me = ffp_emulated_lane();
    return ffp_emulated_from(x, (me & (width - 1)) + by < width ? me + by : me);
}
template <typename T> static inline T __shfl_up_sync(unsigned, T x, int by, int width = 32) {
    const int me = ffp_emulated_lane();
    return ffp_emulated_from(x, (me & (width - 1)) - by >= 0 ? me - by : me);
}

void ffp_emulate(dim3 grid, dim3 block, const std::function<void()> &thread);
void ffp_emulate_blocks(dim3 grid, dim3 block, size_t shared, const std::function<void()> &thread);
extern unsigned char ffp_emulated_shared[];
#define FFP_DYNAMIC_SHARED(type, name) type *name = reinterpret_cast<type *>(ffp_emulated_shared)

template <typename... P, typename... A>
static void ffp_launch(void (*kernel)(P...), dim3 grid, dim3 block, A... arguments) {
    ffp_emulate(grid, block, [=] { kernel(static_cast<P>(arguments)...); });
}
template <typename... P, typename... A>
static void ffp_launch_blocks(void (*kernel)(P...), dim3 grid, dim3 block, size_t shared, A... arguments) {
    ffp_emulate_blocks(grid, block, shared, [=] { kernel(static_cast<P>(arguments)...); });
}

// Device memory is closed to the host but while kernels and copies run.
void ffp_emulated_memory(bool open);

#endif
