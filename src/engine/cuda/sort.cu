#include "engine/cuda/launch.h"
#include "engine/cuda/memory.h"
#include "engine/cuda/sort.h"

#ifdef __CUDACC__

#include <cub/device/device_radix_sort.cuh>
#include <cub/device/device_scan.cuh>

void ffp_cuda_sums_before(const int64_t *counts, int64_t *sums, size_t count, FfpSortScratch *scratch) {
    size_t bytes = 0;
    const int64_t n = (int64_t)count;
    ffp_cuda_check(cub::DeviceScan::ExclusiveSum(NULL, bytes, counts, sums, n, ffp_cuda_stream()), "scan");
    ffp_cuda_grow(&scratch->block, &scratch->capacity, bytes);
    ffp_cuda_check(cub::DeviceScan::ExclusiveSum(scratch->block, bytes, counts, sums, n, ffp_cuda_stream()),
                   "scan");
}

void ffp_cuda_sort_pairs(const uint64_t *keys, uint64_t *sorted_keys, const uint32_t *values,
                         uint32_t *sorted_values, size_t count, int bits, FfpSortScratch *scratch) {
    size_t bytes = 0;
    const int64_t n = (int64_t)count;
    ffp_cuda_check(cub::DeviceRadixSort::SortPairs(NULL, bytes, keys, sorted_keys, values, sorted_values, n,
                                                   0, bits, ffp_cuda_stream()),
                   "sort");
    ffp_cuda_grow(&scratch->block, &scratch->capacity, bytes);
    ffp_cuda_check(cub::DeviceRadixSort::SortPairs(scratch->block, bytes, keys, sorted_keys, values,
                                                   sorted_values, n, 0, bits, ffp_cuda_stream()),
                   "sort");
}

#else

#include <algorithm>
#include <vector>

void ffp_cuda_sums_before(const int64_t *counts, int64_t *sums, size_t count, FfpSortScratch *) {
    int64_t sum = 0;
    ffp_emulated_memory(true);
    for (size_t i = 0; i < count; i++) {
        const int64_t here = counts[i];
        sums[i] = sum;
        sum += here;
    }
    ffp_emulated_memory(false);
}

void ffp_cuda_sort_pairs(const uint64_t *keys, uint64_t *sorted_keys, const uint32_t *values,
                         uint32_t *sorted_values, size_t count, int bits, FfpSortScratch *) {
    const uint64_t mask = bits < 64 ? ((uint64_t)1 << bits) - 1 : UINT64_MAX;
    std::vector<size_t> order(count);
    for (size_t i = 0; i < count; i++) order[i] = i;
    ffp_emulated_memory(true);
    std::stable_sort(order.begin(), order.end(),
                     [=](size_t a, size_t b) { return (keys[a] & mask) < (keys[b] & mask); });
    for (size_t i = 0; i < count; i++) {
        sorted_keys[i] = keys[order[i]];
        sorted_values[i] = values[order[i]];
    }
    ffp_emulated_memory(false);
}

#endif
