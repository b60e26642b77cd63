// Devices: where arrays are stored and which processor works on them, the interface to a GPU. A thread works
// on the CPU unless it chooses a device. While it works on a device, the rooms' functions that dispatch
// (tensor, match, render, loss, network, refine: their headers say which) take pointers to that device's
// memory, and memory is allocated there. Structs (images, G-buffers, Gaussians, cameras) stay on the host:
// only the arrays they point to move.
#ifndef FFP_BASE_DEVICE_H
#define FFP_BASE_DEVICE_H

#include <stddef.h>

// Work is queued in order; upload, copy and zero are queued too, and download waits for everything before it.
// A failure of the device ends the program with a message, since it cannot be traced to one of the queued
// operations.
typedef struct FfpDevice {
    const char *name;
    void *(*alloc)(size_t bytes); // contents undefined; NULL if memory runs out
    void (*release)(void *block); // NULL is allowed
    void (*upload)(void *to, const void *from_host, size_t bytes);
    void (*download)(void *to_host, const void *from, size_t bytes);
    void (*copy)(void *to, const void *from, size_t bytes);
    void (*zero)(void *block, size_t bytes);
    void (*synchronise)(void);
    // The rooms' functions on this device; the types are the rooms' own.
    const struct FfpKernels *tensor;
    const struct FfpImageTable *image;
    const struct FfpMatchTable *match;
    const struct FfpRenderTable *render;
    const struct FfpLossTable *loss;
    const struct FfpNetworkTable *network;
    const struct FfpRefineTable *refine;
} FfpDevice;

// The device that this thread works on; NULL: the CPU. Threads begin on the CPU.
const FfpDevice *ffp_device(void);
// Returns the device in use before, to be restored.
const FfpDevice *ffp_device_use(const FfpDevice *device);

// The device of the context of the current call (core/base/call.h), for long work (training, reconstruction);
// NULL: the CPU.
const FfpDevice *ffp_device_offered(void);

// Memory of the device that this thread works on. new: count * size bytes, zeroed, as ffp_alloc on the CPU.
void *ffp_memory_new(size_t count, size_t size);
void ffp_memory_free(void *block); // by who works on the device it came from; NULL is allowed
void ffp_memory_zero(void *block, size_t bytes);
void ffp_memory_copy(void *to, const void *from, size_t bytes);
void ffp_memory_upload(void *to, const void *from_host, size_t bytes);
void ffp_memory_download(void *to_host, const void *from, size_t bytes);
// A new block with the host's numbers; NULL stays NULL.
void *ffp_memory_uploaded(const void *from_host, size_t count, size_t size);

#endif
