#include "core/base/alloc.h"
#include <omp.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include "core/base/blocks.h"
#include "core/base/frame.h"

#define ALIGNMENT ((size_t)64)
#define MAGIC UINT64_C(0x66667063616d7301) // an ffp_free of what is none, or twice, is seen

// --- Taking. ---

static FfpBlocks *owner_of_new(void) {
    return ffp_frame ? ffp_frame->blocks : NULL;
}

// In a region only a body of ffp_parallel_for can be left.
static void check_place(void) {
    ffp_check(omp_get_level() == (ffp_frame ? ffp_frame->level : 0), "allocation in a plain parallel region");
}

void ffp_context_fail_at(FfpContext *context, long long n) {
    context->fail = n > 0 ? context->allocations + n : 0;
}

static bool is_to_fail(void) {
    FfpContext *context = ffp_call_context();
    return context && context->fail && ++context->allocations == context->fail;
}

// Rounded up to the alignment, never 0; false when there cannot be so many.
static bool bytes_of(size_t count, size_t size, size_t *bytes) {
    if (__builtin_mul_overflow(count, size, bytes) || *bytes > SIZE_MAX / 2) return false;
    *bytes = *bytes == 0 ? ALIGNMENT : (*bytes + ALIGNMENT - 1) / ALIGNMENT * ALIGNMENT;
    return true;
}

size_t ffp_checked_bytes(size_t count, size_t size) {
    size_t bytes = 0;
    if (!bytes_of(count, size, &bytes)) ffp_leave(FFP_ERROR_MEMORY, SIZE_MAX);
    return bytes;
}

// By the caller's functions, if it has given any; NULL: there is none.
static FfpBlock *taken(const FfpContextSettings *settings, size_t bytes) {
    FfpBlock *block = settings ? settings->allocate(settings->user, ALIGNMENT, sizeof *block + bytes)
                               : aligned_alloc(ALIGNMENT, sizeof *block + bytes);
    if (!block) return NULL;
    if ((uintptr_t)block % ALIGNMENT != 0) {
        fprintf(stderr, "ffprocams: allocate gave %p, which is not aligned to %zu bytes\n", (void *)block,
                ALIGNMENT);
        abort();
    }
    *block = (FfpBlock){.bytes = bytes, .magic = MAGIC};
    if (settings) {
        block->release = settings->release;
        block->user = settings->user;
    }
    return block;
}

static const FfpContextSettings *callers_own(void) {
    const FfpContext *context = ffp_call_context();
    return context && context->settings.allocate ? &context->settings : NULL;
}

static void *new_block(FfpBlocks *owner, size_t bytes, const FfpContextSettings *settings) {
    check_place();
    FfpBlock *block = is_to_fail() ? NULL : taken(settings, bytes);
    if (!block) return NULL;
    ffp_blocks_add(owner, block);
    return block + 1;
}

void ffp_no_memory(size_t bytes) {
    ffp_leave(FFP_ERROR_MEMORY, bytes);
}

void *ffp_alloc_undefined(size_t bytes) {
    void *memory = new_block(owner_of_new(), bytes, callers_own());
    if (!memory) ffp_leave(FFP_ERROR_MEMORY, bytes);
    return memory;
}

void *ffp_alloc(size_t count, size_t size) {
    const size_t bytes = ffp_checked_bytes(count, size);
    return memset(ffp_alloc_undefined(bytes), 0, bytes);
}

static void *undefined(void *memory, size_t bytes) {
#ifdef FFP_SANITIZED
    if (memory) memset(memory, 0xFF, bytes); // NaN: reading it before it is written shows
#else
    (void)bytes;
#endif
    return memory;
}

void *ffp_take(size_t count, size_t size) {
    const size_t bytes = ffp_checked_bytes(count, size);
    return undefined(ffp_alloc_undefined(bytes), bytes);
}

void *ffp_try_take(size_t count, size_t size) {
    size_t bytes;
    return bytes_of(count, size, &bytes) ? undefined(new_block(owner_of_new(), bytes, callers_own()), bytes)
                                         : NULL;
}

void *ffp_try_alloc(size_t count, size_t size) {
    size_t bytes;
    if (!bytes_of(count, size, &bytes)) return NULL;
    void *memory = new_block(owner_of_new(), bytes, callers_own());
    return memory ? memset(memory, 0, bytes) : NULL;
}

void *ffp_alloc_kept(size_t count, size_t size) {
    const size_t bytes = ffp_checked_bytes(count, size);
    void *memory = new_block(NULL, bytes, NULL);
    if (!memory) ffp_leave(FFP_ERROR_MEMORY, bytes);
    return memset(memory, 0, bytes);
}

char *ffp_copy_text(const char *text) {
    const size_t size = strlen(text) + 1;
    return memcpy(ffp_alloc(size, 1), text, size);
}

// --- Growing, and giving back. ---

static FfpBlock *block_of(void *memory) {
    FfpBlock *block = (FfpBlock *)memory - 1;
    if (block->magic == MAGIC) return block;
    fprintf(stderr, "ffprocams: freeing %p, which was not allocated\n", memory);
    abort();
}

void *ffp_try_grow(void *memory, size_t count, size_t size) {
    void *larger = ffp_try_alloc(count, size);
    if (!larger || !memory) return larger;
    const size_t before = block_of(memory)->bytes, after = block_of(larger)->bytes;
    memcpy(larger, memory, before < after ? before : after);
    ffp_free(memory);
    return larger;
}

void *ffp_grow(void *memory, size_t count, size_t size) {
    void *larger = ffp_try_grow(memory, count, size);
    if (!larger) ffp_leave(FFP_ERROR_MEMORY, ffp_checked_bytes(count, size));
    return larger;
}

void *ffp_shrink(void *memory, size_t count, size_t size) {
    FfpBlock *block = block_of(memory);
    FfpBlocks *owner = block->owner;
    const size_t bytes = ffp_checked_bytes(count, size);
    if (bytes >= block->bytes || block->release) return memory;
    ffp_blocks_remove(block);
    block->bytes = bytes;
    FfpBlock *moved = realloc(block, sizeof *block + bytes);
    if (moved) block = moved;
    if ((uintptr_t)block % ALIGNMENT != 0) {
        moved = aligned_alloc(ALIGNMENT, sizeof *block + bytes);
        if (moved) memcpy(moved, block, sizeof *block + bytes);
        free(block);
        if (!moved) ffp_leave(FFP_ERROR_MEMORY, bytes);
        block = moved;
    }
    ffp_blocks_add(owner, block);
    return block + 1;
}

void ffp_free(void *memory) {
    if (!memory) return;
    FfpBlock *block = block_of(memory);
    ffp_blocks_remove(block);
    ffp_block_release(block);
}

// --- Other things. ---

bool ffp_try_own(void *thing, void (*release)(void *thing)) {
    FfpBlocks *owner = owner_of_new();
    check_place();
    return !owner || (!is_to_fail() && ffp_blocks_own(owner, thing, release));
}

void ffp_own(void *thing, void (*release)(void *thing)) {
    if (ffp_try_own(thing, release)) return;
    release(thing);
    ffp_leave(FFP_ERROR_MEMORY, sizeof(FfpOwned));
}

void ffp_disown(void *thing) {
    if (owner_of_new()) ffp_blocks_disown(owner_of_new(), thing);
}

void *ffp_alloc_on_device(const FfpDevice *device, size_t bytes) {
    void *memory = is_to_fail() ? NULL : device->alloc(bytes);
    if (!memory) ffp_leave(FFP_ERROR_MEMORY, bytes);
    ffp_own(memory, device->release);
    return memory;
}

void ffp_free_on_device(const FfpDevice *device, void *memory) {
    ffp_disown(memory);
    device->release(memory);
}
