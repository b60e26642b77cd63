#include "core/base/blocks.h"
#include <stdlib.h>

void ffp_blocks_init(FfpBlocks *blocks, void *owner, void (*lost)(void *owner)) {
    *blocks = (FfpBlocks){.owner = owner, .lost = lost};
    pthread_mutex_init(&blocks->lock, NULL);
}

void ffp_blocks_close(FfpBlocks *blocks) {
    ffp_blocks_release(blocks);
    pthread_mutex_destroy(&blocks->lock);
}

void ffp_blocks_add(FfpBlocks *blocks, FfpBlock *block) {
    block->owner = blocks;
    if (!blocks) return;
    pthread_mutex_lock(&blocks->lock);
    block->after = blocks->first;
    if (block->after) block->after->before = block;
    blocks->first = block;
    pthread_mutex_unlock(&blocks->lock);
}

void ffp_block_release(FfpBlock *block) {
    block->magic = 0;
    if (block->release)
        block->release(block->user, block);
    else
        free(block);
}

// From its list; the others there do not know of it any more, or are on their way out too.
static void unlink_block(FfpBlock *block) {
    block->owner = NULL;
    block->before = NULL;
    block->after = NULL;
}

void ffp_blocks_remove(FfpBlock *block) {
    FfpBlocks *blocks = block->owner;
    if (!blocks) return;
    pthread_mutex_lock(&blocks->lock);
    if (block->after) block->after->before = block->before;
    *(block->before ? &block->before->after : &blocks->first) = block->after;
    pthread_mutex_unlock(&blocks->lock);
    unlink_block(block);
}

bool ffp_blocks_own(FfpBlocks *blocks, void *thing, void (*release)(void *thing)) {
    FfpOwned *owned = malloc(sizeof *owned);
    if (!owned) return false;
    pthread_mutex_lock(&blocks->lock);
    *owned = (FfpOwned){blocks->owned, thing, release};
    blocks->owned = owned;
    pthread_mutex_unlock(&blocks->lock);
    return true;
}

void ffp_blocks_disown(FfpBlocks *blocks, void *thing) {
    if (!thing) return;
    pthread_mutex_lock(&blocks->lock);
    FfpOwned **at = &blocks->owned;
    while (*at && (*at)->thing != thing) at = &(*at)->older;
    FfpOwned *owned = *at;
    if (owned) *at = owned->older;
    pthread_mutex_unlock(&blocks->lock);
    free(owned);
}

void ffp_blocks_set_free(FfpBlocks *blocks) {
    for (FfpBlock *block = blocks->first, *next; block; block = next) {
        next = block->after;
        unlink_block(block);
    }
    blocks->first = NULL;
    for (FfpOwned *owned = blocks->owned, *older; owned; owned = older) {
        older = owned->older;
        free(owned);
    }
    blocks->owned = NULL;
}

void ffp_blocks_release(FfpBlocks *blocks) {
    while (blocks->owned) { // its release may take others out
        FfpOwned *owned = blocks->owned;
        blocks->owned = owned->older;
        owned->release(owned->thing);
        free(owned);
    }
    for (FfpBlock *block = blocks->first, *next; block; block = next) {
        next = block->after;
        ffp_block_release(block);
    }
    blocks->first = NULL;
}
