// Memory that belongs to the current call (call.h): a call that fails releases everything it has allocated;
// if it succeeds, the remaining blocks belong to whoever received them. Blocks are zeroed (but those of
// ffp_take), 64-byte aligned and released with ffp_free. In a parallel region only the bodies of
// ffp_parallel_for may allocate.
#ifndef FFP_BASE_ALLOC_H
#define FFP_BASE_ALLOC_H

#include <stddef.h>

#ifdef __cplusplus
extern "C" {
#endif

// count * size bytes; if memory runs out or the product overflows, the call ends with FFP_ERROR_MEMORY.
void *ffp_alloc(size_t count, size_t size);
// The same, with undefined contents: for memory that is written before it is read. Its pages are not touched
// before.
void *ffp_take(size_t count, size_t size);
// As ffp_alloc and ffp_take, but they return NULL in that case. For code that holds something only it can
// release.
void *ffp_try_alloc(size_t count, size_t size);
void *ffp_try_take(size_t count, size_t size);
// Enlarges a block (or NULL), keeping its contents and zeroing the rest. If that fails, the old one is
// unchanged.
void *ffp_grow(void *memory, size_t count, size_t size);
void *ffp_try_grow(void *memory, size_t count, size_t size);
// Gives back the end of a block of which count * size bytes are kept: in place, unless the allocator moves
// it; a block from the caller's allocator stays as it is.
void *ffp_shrink(void *memory, size_t count, size_t size);
// Ends the call as ffp_alloc does: for functions that can fail only for lack of memory.
void ffp_no_memory(size_t bytes);
char *ffp_copy_text(const char *text);
void ffp_free(void *memory); // NULL is allowed

// Memory that outlives the call however it ends: a thread's own, kept from one call to the next.
void *ffp_alloc_kept(size_t count, size_t size);

// For arena.c and device_memory.c: a block of undefined contents; count * size rounded up to the alignment,
// never 0, or the call ends; a device's block that the call has taken, and one that it gives back.
void *ffp_alloc_undefined(size_t bytes);
size_t ffp_checked_bytes(size_t count, size_t size);
struct FfpDevice;
void *ffp_alloc_on_device(const struct FfpDevice *device, size_t bytes);
void ffp_free_on_device(const struct FfpDevice *device, void *memory);

#ifdef __cplusplus
}
#endif

#endif
