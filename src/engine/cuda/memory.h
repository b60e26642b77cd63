// Memory of the device, for the other sources of this room.
#ifndef FFP_CUDA_MEMORY_H
#define FFP_CUDA_MEMORY_H

#include <stddef.h>

void *ffp_cuda_try_alloc(size_t bytes); // NULL when there is no room
void *ffp_cuda_alloc(size_t bytes);     // of the room's own; without room the call ends (core/base/alloc.h)
void ffp_cuda_release(void *block);
void ffp_cuda_upload(void *to, const void *from_host, size_t bytes);
void ffp_cuda_download(void *to_host, const void *from, size_t bytes);
void ffp_cuda_copy(void *to, const void *from, size_t bytes);
void ffp_cuda_zero(void *block, size_t bytes);
void ffp_cuda_synchronise(void);

// At least `bytes` of memory that a caller keeps from call to call: *block and *capacity (0 at first) grow
// when needed. Growing loses the contents, and leaves the block NULL if memory runs out.
template <typename T> void ffp_cuda_grow(T **block, size_t *capacity, size_t bytes) {
    if (bytes <= *capacity) return;
    ffp_cuda_release(*block);
    *block = NULL;
    *capacity = 0;
    *block = (T *)ffp_cuda_alloc(bytes);
    *capacity = bytes;
}

#endif
