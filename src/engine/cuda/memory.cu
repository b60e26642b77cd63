// Memory of the GPU: taken from and given back to the stream, so that neither waits for it.
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include "engine/cuda/launch.h"
#include "engine/cuda/memory.h"
extern "C" {
#include "core/base/alloc.h"
#include "engine/cuda/cuda.h"
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
        cudaGetLastError(); // must not appear as an error of what follows
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
unsigned char *base, *top;                              // where kernels see it; the end of what was taken
unsigned char *behind;                                  // where it lies while it is closed
std::map<size_t, std::multimap<size_t, void *>> unused; // by pages
std::map<void *, size_t> blocks;                        // pages of each block's place
int open_depth;

void fail() {
    perror("emulated device memory");
    abort();
}

unsigned char *reserve_range(int rights) {
    // Twice as long, to begin where tables of pages do, which then move as wholes.
    void *range = mmap(NULL, 2 * RANGE, rights, MAP_PRIVATE | MAP_ANONYMOUS | MAP_NORESERVE, -1, 0);
    if (range == MAP_FAILED) fail();
    return (unsigned char *)(((uintptr_t)range + RANGE - 1) / RANGE * RANGE);
}

void reserve() {
    if (base) return;
    base = top = reserve_range(PROT_NONE);
    behind = reserve_range(PROT_READ | PROT_WRITE);
}

// Moves all memory from one range to the other: mprotect would take as long as kernels do, since it asks
// every page.
void move_pages(unsigned char *from, unsigned char *to) {
    if (mremap(from, RANGE, RANGE, MREMAP_MAYMOVE | MREMAP_FIXED | MREMAP_DONTUNMAP, to) == MAP_FAILED)
        fail();
}

} // namespace

void ffp_emulated_memory(bool open) {
    reserve();
    if (open && open_depth++ == 0) move_pages(behind, base);
    if (open || --open_depth > 0) return;
    move_pages(base, behind);
    if (mprotect(base, RANGE, PROT_NONE) != 0) fail();
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
    memset(place, 0xff, pages * PAGE); // NaN: nobody may rely on its contents
    ffp_emulated_memory(false);
    return place;
}

void ffp_cuda_release(void *block) {
    if (!block) return;
    auto at = blocks.find(block);
    if (at == blocks.end()) {
        fprintf(stderr, "emulated device memory: %p was not allocated from it\n", block);
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
