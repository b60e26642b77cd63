// Memory of the GPU: taken from and given back to the stream, so that neither waits for it.
#include "cuda/memory.h"

#include <stdio.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>
#include "cuda/launch.h"
extern "C" {
#include "base/alloc.h"
#include "cuda/cuda.h"
}

#ifdef __CUDACC__

void ffp_cuda_check(cudaError_t error, const char *what) {
    if (error == cudaSuccess) return;
    fprintf(stderr, "ffprocams: error: GPU: %s (%s)\n", cudaGetErrorString(error), what);
    abort();
}

cudaStream_t ffp_cuda_stream(void) {
    static cudaStream_t stream;
    if (!stream) ffp_cuda_check(cudaStreamCreateWithFlags(&stream, cudaStreamNonBlocking), "stream");
    return stream;
}

// Freed memory stays in the pool: a step asks for the same blocks again and again.
static void keep_memory(void) {
    static bool kept;
    if (kept) return;
    cudaMemPool_t pool;
    uint64_t all = UINT64_MAX;
    ffp_cuda_check(cudaDeviceGetDefaultMemPool(&pool, 0), "memory pool");
    ffp_cuda_check(cudaMemPoolSetAttribute(pool, cudaMemPoolAttrReleaseThreshold, &all), "memory pool");
    kept = true;
}

static void *take(size_t bytes) {
    void *block = NULL;
    keep_memory();
    const cudaError_t error = cudaMallocAsync(&block, bytes ? bytes : 1, ffp_cuda_stream());
    if (error == cudaErrorMemoryAllocation) {
        cudaGetLastError(); // is no error of what comes next
        return NULL;
    }
    ffp_cuda_check(error, "memory");
    return block;
}

void ffp_cuda_release(void *block) {
    if (block) ffp_cuda_check(cudaFreeAsync(block, ffp_cuda_stream()), "release");
}

// From pageable memory: returns when the host's numbers have been read.
void ffp_cuda_upload(void *to, const void *from_host, size_t bytes) {
    ffp_cuda_check(cudaMemcpyAsync(to, from_host, bytes, cudaMemcpyHostToDevice, ffp_cuda_stream()),
                   "upload");
}

void ffp_cuda_download(void *to_host, const void *from, size_t bytes) {
    ffp_cuda_check(cudaMemcpyAsync(to_host, from, bytes, cudaMemcpyDeviceToHost, ffp_cuda_stream()),
                   "download");
    ffp_cuda_synchronise();
}

void ffp_cuda_copy(void *to, const void *from, size_t bytes) {
    ffp_cuda_check(cudaMemcpyAsync(to, from, bytes, cudaMemcpyDeviceToDevice, ffp_cuda_stream()), "copy");
}

void ffp_cuda_zero(void *block, size_t bytes) {
    ffp_cuda_check(cudaMemsetAsync(block, 0, bytes, ffp_cuda_stream()), "zero");
}

void ffp_cuda_synchronise(void) {
    ffp_cuda_check(cudaStreamSynchronize(ffp_cuda_stream()), "synchronise");
}

#else

#include <map>
#include <sys/mman.h>

// Addresses that the host may touch only while kernels and copies run. Blocks end where a page ends, with a
// closed page behind, so that reading past one is seen.
namespace {

constexpr size_t RANGE = (size_t)1 << 36, PAGE = 4096;
unsigned char *base, *top;
std::map<size_t, std::multimap<size_t, void *>> unused; // by pages
std::map<void *, size_t> blocks;                        // pages of each block's place
int open_depth;

void reserve() {
    if (base) return;
    void *range = mmap(NULL, RANGE, PROT_NONE, MAP_PRIVATE | MAP_ANONYMOUS | MAP_NORESERVE, -1, 0);
    if (range == MAP_FAILED) {
        perror("emulated device memory");
        abort();
    }
    base = top = (unsigned char *)range;
}

void protect(int rights) {
    if (top > base && mprotect(base, (size_t)(top - base), rights) != 0) {
        perror("emulated device memory");
        abort();
    }
}

} // namespace

void ffp_emulated_memory(bool open) {
    if (open && open_depth++ == 0) protect(PROT_READ | PROT_WRITE);
    if (!open && --open_depth == 0) protect(PROT_NONE);
}

static void *take(size_t bytes) {
    reserve();
    const size_t pages = (bytes + PAGE - 1) / PAGE + 1;
    unsigned char *place;
    auto kept = unused.find(pages);
    if (kept != unused.end() && !kept->second.empty()) {
        place = (unsigned char *)kept->second.begin()->second;
        kept->second.erase(kept->second.begin());
    } else {
        place = top;
        top += pages * PAGE;
        if (top > base + RANGE) abort();
    }
    blocks[place] = pages;
    ffp_emulated_memory(true);
    memset(place, 0xff, pages * PAGE); // NaN: nobody may count on what is there
    ffp_emulated_memory(false);
    return place;
}

void ffp_cuda_release(void *block) {
    if (!block) return;
    auto at = blocks.find(block);
    if (at == blocks.end()) {
        fprintf(stderr, "emulated device memory: %p was not taken from it\n", block);
        abort();
    }
    unused[at->second].insert({0, block});
    blocks.erase(at);
}

static void move(void *to, const void *from, size_t bytes) {
    ffp_emulated_memory(true);
    memmove(to, from, bytes);
    ffp_emulated_memory(false);
}
void ffp_cuda_upload(void *to, const void *from_host, size_t bytes) {
    move(to, from_host, bytes);
}
void ffp_cuda_download(void *to_host, const void *from, size_t bytes) {
    move(to_host, from, bytes);
}
void ffp_cuda_copy(void *to, const void *from, size_t bytes) {
    move(to, from, bytes);
}
void ffp_cuda_zero(void *block, size_t bytes) {
    ffp_emulated_memory(true);
    memset(block, 0, bytes);
    ffp_emulated_memory(false);
}
void ffp_cuda_synchronise(void) {}

#endif

static long long blocks_left = -1; // negative: no end

void ffp_cuda_memory_ends(long long count) {
    blocks_left = count;
}

void *ffp_cuda_try_alloc(size_t bytes) {
    if (blocks_left >= 0 && blocks_left-- == 0) return NULL;
    return take(bytes);
}

void *ffp_cuda_alloc(size_t bytes) {
    void *block = ffp_cuda_try_alloc(bytes);
    if (!block) ffp_no_memory(bytes);
    return block;
}
