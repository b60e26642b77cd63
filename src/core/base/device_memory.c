// Memory of what a thread works on (device.h).
#include <stdint.h>
#include <string.h>
#include "core/base/arena.h"
#include "core/base/device.h"

void *ffp_memory_new(size_t count, size_t size) {
    const FfpDevice *device = ffp_device();
    if (!device) return ffp_alloc(count, size);
    const size_t bytes = ffp_checked_bytes(count, size);
    void *block = ffp_alloc_on_device(device, bytes);
    device->zero(block, bytes);
    return block;
}

void ffp_memory_free(void *block) {
    const FfpDevice *device = ffp_device();
    if (device)
        ffp_free_on_device(device, block);
    else
        ffp_free(block);
}

// Large blocks by all threads.
static void clear(char *block, size_t bytes) {
    enum { PART = 65536 };
    const int64_t parts = (int64_t)((bytes + PART - 1) / PART);
#pragma omp parallel for schedule(static) if (parts > 1)
    for (int64_t i = 0; i < parts; i++) {
        const size_t from = (size_t)i * PART, left = bytes - from;
        memset(block + from, 0, left < PART ? left : PART);
    }
}

void ffp_memory_zero(void *block, size_t bytes) {
    const FfpDevice *device = ffp_device();
    if (bytes == 0) return;
    if (device)
        device->zero(block, bytes);
    else
        clear(block, bytes);
}

void ffp_memory_copy(void *to, const void *from, size_t bytes) {
    const FfpDevice *device = ffp_device();
    if (bytes == 0) return;
    if (device)
        device->copy(to, from, bytes);
    else
        memcpy(to, from, bytes);
}

void ffp_memory_upload(void *to, const void *from_host, size_t bytes) {
    const FfpDevice *device = ffp_device();
    if (bytes == 0) return;
    if (device)
        device->upload(to, from_host, bytes);
    else
        memcpy(to, from_host, bytes);
}

void ffp_memory_download(void *to_host, const void *from, size_t bytes) {
    const FfpDevice *device = ffp_device();
    if (bytes == 0) return;
    if (device)
        device->download(to_host, from, bytes);
    else
        memcpy(to_host, from, bytes);
}

void *ffp_memory_uploaded(const void *from_host, size_t count, size_t size) {
    if (!from_host) return NULL;
    void *block = ffp_memory_new(count, size);
    ffp_memory_upload(block, from_host, count * size);
    return block;
}
