// Sorting and running sums on the device: CUB's, or plain loops in the emulation.
#ifndef FFP_CUDA_SORT_H
#define FFP_CUDA_SORT_H

#include <stddef.h>
#include <stdint.h>

// Memory that such calls work in, kept from call to call: {NULL, 0} at first, its block released by the
// owner.
typedef struct FfpSortScratch {
    void *block;
    size_t capacity;
} FfpSortScratch;

// sums[i] = counts[0] + ... + counts[i - 1].
void ffp_cuda_sums_before(const int64_t *counts, int64_t *sums, size_t count, FfpSortScratch *scratch);
// Sorts by the lowest `bits` bits of the keys, equal ones in the order given, and carries the values along.
void ffp_cuda_sort_pairs(const uint64_t *keys, uint64_t *sorted_keys, const uint32_t *values,
                         uint32_t *sorted_values, size_t count, int bits, FfpSortScratch *scratch);

#endif
