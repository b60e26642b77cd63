// Bump memory: many allocations, one free. Not thread safe: allocate outside parallel regions.
#ifndef FFP_BASE_ARENA_H
#define FFP_BASE_ARENA_H

#include <stddef.h>

typedef struct FfpArena FfpArena;

// Its blocks come from the device that the thread works on (base/device.h) now, and stay there.
FfpArena *ffp_arena_new(void);
void ffp_arena_free(FfpArena *arena); // NULL is allowed
// count * size bytes, 64-byte aligned, zeroed. Aborts with a message when the product overflows or memory is
// out: sizes from outside are checked by the readers long before they come here.
void *ffp_arena_alloc(FfpArena *arena, size_t count, size_t size);
void ffp_arena_reset(FfpArena *arena);              // keeps the memory for the next step
size_t ffp_arena_high_water(const FfpArena *arena); // bytes, the most ever in use

// The same for a single block that lives by itself: zeroed, 64-byte aligned, released with free().
void *ffp_alloc(size_t count, size_t size);
// What that would take: count * size rounded up to the alignment, never 0. Aborts as above.
size_t ffp_checked_bytes(size_t count, size_t size);

#endif
