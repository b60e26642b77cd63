#include "core/base/arena.h"
#include <string.h>
#include "core/base/device.h"

#define CHUNK_BYTES ((size_t)1 << 20) // the least that is asked of the system at a time

typedef struct Chunk {
    struct Chunk *next;
    size_t capacity, used; // bytes, of the memory at `bytes`
    unsigned char *bytes;
} Chunk;

struct FfpArena {
    const FfpDevice *device; // NULL: the CPU
    Chunk *first, *current;  // chunks behind `current` are empty
    size_t in_use, high_water;
};

FfpArena *ffp_arena_new(void) {
    FfpArena *arena = ffp_alloc(1, sizeof *arena);
    arena->device = ffp_device();
    return arena;
}

static void release(const FfpArena *arena, void *bytes) {
    if (arena->device)
        ffp_free_on_device(arena->device, bytes);
    else
        ffp_free(bytes);
}

void ffp_arena_free(FfpArena *arena) {
    if (!arena) return;
    for (Chunk *chunk = arena->first, *next = NULL; chunk != NULL; chunk = next) {
        next = chunk->next;
        release(arena, chunk->bytes);
        ffp_free(chunk);
    }
    ffp_free(arena);
}

// A chunk with at least `bytes` free: the current one, an empty one kept by a reset, or a new one put behind
// the current.
static Chunk *chunk_for(FfpArena *arena, size_t bytes) {
    Chunk *chunk = arena->current;
    while (chunk && chunk->capacity - chunk->used < bytes && chunk->next) chunk = chunk->next;
    if (!chunk || chunk->capacity - chunk->used < bytes) {
        Chunk *fresh = ffp_alloc(1, sizeof *fresh);
        fresh->capacity = bytes > CHUNK_BYTES ? bytes : CHUNK_BYTES;
        fresh->bytes = arena->device ? ffp_alloc_on_device(arena->device, fresh->capacity)
                                     : ffp_alloc_undefined(fresh->capacity);
        if (!chunk)
            arena->first = fresh;
        else
            chunk->next = fresh;
        chunk = fresh;
    }
    arena->current = chunk;
    return chunk;
}

static void *take(FfpArena *arena, size_t bytes) {
    Chunk *chunk = chunk_for(arena, bytes);
    void *block = chunk->bytes + chunk->used;
    chunk->used += bytes;
    arena->in_use += bytes;
    if (arena->in_use > arena->high_water) arena->high_water = arena->in_use;
    return block;
}

void *ffp_arena_alloc(FfpArena *arena, size_t count, size_t size) {
    const size_t bytes = ffp_checked_bytes(count, size);
    void *block = take(arena, bytes);
    if (!arena->device) return memset(block, 0, bytes);
    arena->device->zero(block, bytes);
    return block;
}

void *ffp_arena_take(FfpArena *arena, size_t count, size_t size) {
    const size_t bytes = ffp_checked_bytes(count, size);
    void *block = take(arena, bytes);
#ifdef FFP_SANITIZED
    if (!arena->device) memset(block, 0xFF, bytes); // NaN: reading it before it is written shows
#endif
    return block;
}

const char *ffp_arena_text(FfpArena *arena, const char *text) {
    const size_t size = strlen(text) + 1;
    return memcpy(ffp_arena_take(arena, size, 1), text, size);
}

void ffp_arena_reset(FfpArena *arena) {
    for (Chunk *chunk = arena->first; chunk != NULL; chunk = chunk->next) chunk->used = 0;
    arena->current = arena->first;
    arena->in_use = 0;
}

size_t ffp_arena_high_water(const FfpArena *arena) {
    return arena->high_water;
}
