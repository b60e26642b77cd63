#include "base/device.h"

#include <stdlib.h>
#include <string.h>
#include "base/arena.h"

static _Thread_local const FfpDevice *in_use;
static const FfpDevice *offered;

const FfpDevice *ffp_device(void) {
    return in_use;
}

const FfpDevice *ffp_device_use(const FfpDevice *device) {
    const FfpDevice *before = in_use;
    in_use = device;
    return before;
}

void ffp_device_offer(const FfpDevice *device) {
    offered = device;
}

const FfpDevice *ffp_device_offered(void) {
    return offered;
}

void *ffp_memory_new(size_t count, size_t size) {
    if (!in_use) return ffp_alloc(count, size);
    const size_t bytes = ffp_checked_bytes(count, size);
    void *block = in_use->alloc(bytes);
    in_use->zero(block, bytes);
    return block;
}

void ffp_memory_free(void *block) {
    if (in_use)
        in_use->release(block);
    else
        free(block);
}

void ffp_memory_zero(void *block, size_t bytes) {
    if (bytes == 0) return;
    if (in_use)
        in_use->zero(block, bytes);
    else
        memset(block, 0, bytes);
}

void ffp_memory_copy(void *to, const void *from, size_t bytes) {
    if (bytes == 0) return;
    if (in_use)
        in_use->copy(to, from, bytes);
    else
        memcpy(to, from, bytes);
}

void ffp_memory_upload(void *to, const void *from_host, size_t bytes) {
    if (bytes == 0) return;
    if (in_use)
        in_use->upload(to, from_host, bytes);
    else
        memcpy(to, from_host, bytes);
}

void ffp_memory_download(void *to_host, const void *from, size_t bytes) {
    if (bytes == 0) return;
    if (in_use)
        in_use->download(to_host, from, bytes);
    else
        memcpy(to_host, from, bytes);
}

void *ffp_memory_uploaded(const void *from_host, size_t count, size_t size) {
    if (!from_host) return NULL;
    void *block = ffp_memory_new(count, size);
    ffp_memory_upload(block, from_host, count * size);
    return block;
}
