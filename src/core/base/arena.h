// Bump memory: many allocations, one free. Not thread safe: allocate outside parallel regions.
#ifndef FFP_BASE_ARENA_H
#define FFP_BASE_ARENA_H

#include <stddef.h>
#include "core/base/alloc.h"

typedef struct FfpArena FfpArena;

// Its blocks come from the device that the thread works on (core/base/device.h) now, and stay there.
FfpArena *ffp_arena_new(void);
void ffp_arena_free(FfpArena *arena); // NULL is allowed
// count * size bytes, 64-byte aligned, zeroed; fails as ffp_alloc.
void *ffp_arena_alloc(FfpArena *arena, size_t count, size_t size);
// The same, with undefined contents: for memory that is written before it is read. Its pages are not touched
// before.
void *ffp_arena_take(FfpArena *arena, size_t count, size_t size);
const char *ffp_arena_text(FfpArena *arena, const char *text); // a copy
void ffp_arena_reset(FfpArena *arena);                         // keeps the memory for the next step
size_t ffp_arena_high_water(const FfpArena *arena);            // bytes, the most ever in use

#endif
