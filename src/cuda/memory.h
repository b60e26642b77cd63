// Memory of the device, for the other sources of this room.
#ifndef FFP_CUDA_MEMORY_H
#define FFP_CUDA_MEMORY_H

#include <stddef.h>

void *ffp_cuda_try_alloc(size_t bytes); // NULL when there is no room
void *ffp_cuda_alloc(size_t bytes);     // of the room's own; never NULL
void ffp_cuda_release(void *block);
void ffp_cuda_upload(void *to, const void *from_host, size_t bytes);
void ffp_cuda_download(void *to_host, const void *from, size_t bytes);
void ffp_cuda_copy(void *to, const void *from, size_t bytes);
void ffp_cuda_zero(void *block, size_t bytes);
void ffp_cuda_synchronise(void);

// Memory of `bytes` at least that a caller keeps from call to call: *block, *capacity (0 at first) grow when
// needed. What was in it is lost then.
void ffp_cuda_grow(void **block, size_t *capacity, size_t bytes);

#endif
