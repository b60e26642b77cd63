// The header in front of every block of memory, and the lists of an owner's blocks (FfpBlocks, call.h).
#ifndef FFP_BASE_BLOCKS_H
#define FFP_BASE_BLOCKS_H

#include <stdint.h>
#include "core/base/call.h"

typedef struct FfpBlock {
    FfpBlocks *owner; // NULL: nobody's but its holder's
    struct FfpBlock *before, *after;
    size_t bytes;
    void (*release)(void *user, void *memory); // NULL: free
    void *user;
    unsigned char unused[64 - 6 * sizeof(void *) - sizeof(uint64_t)];
    uint64_t magic;
} FfpBlock;
_Static_assert(sizeof(FfpBlock) == 64, "blocks stay aligned");

typedef struct FfpOwned { // resources other than memory
    struct FfpOwned *older;
    void *thing;
    void (*release)(void *thing);
} FfpOwned;

void ffp_blocks_add(FfpBlocks *blocks, FfpBlock *block); // blocks NULL: to none
void ffp_blocks_remove(FfpBlock *block);                 // from its owner's, if it has one
void ffp_block_release(FfpBlock *block);                 // gives its memory back

// False when there is no memory to note it. disown: NULL is allowed.
bool ffp_blocks_own(FfpBlocks *blocks, void *thing, void (*release)(void *thing));
void ffp_blocks_disown(FfpBlocks *blocks, void *thing);

// For all that is left: blocks then belong to their holders, or are released.
void ffp_blocks_set_free(FfpBlocks *blocks);
void ffp_blocks_release(FfpBlocks *blocks);

#endif
