// Where numbers live and what works on them: the seam behind which a GPU stands. A thread works on the CPU
// unless it says otherwise. While it works on a device, the rooms' functions that dispatch (tensor, render,
// loss, network, refine: their headers say which) take pointers to that device's memory, and memory
// comes from it. Structs (images, G-buffers, Gaussians, cameras) stay on the host: only the arrays they point
// to move.
#ifndef FFP_BASE_DEVICE_H
#define FFP_BASE_DEVICE_H

#include <stddef.h>

// Work is queued in order; upload, copy and zero are queued too, download waits for everything before it. A
// failure of the device ends the program with a message: what was queued cannot be told apart any more.
typedef struct FfpDevice {
    const char *name;
    void *(*alloc)(size_t bytes); // contents undefined; NULL when there is no room
    void (*release)(void *block); // NULL is allowed
    void (*upload)(void *to, const void *from_host, size_t bytes);
    void (*download)(void *to_host, const void *from, size_t bytes);
    void (*copy)(void *to, const void *from, size_t bytes);
    void (*zero)(void *block, size_t bytes);
    void (*synchronise)(void);
    // The rooms' functions on this device; the types are the rooms' own.
    const struct FfpKernels *tensor;
    const struct FfpImageTable *image;
    const struct FfpRenderTable *render;
    const struct FfpLossTable *loss;
    const struct FfpNetworkTable *network;
    const struct FfpRefineTable *refine;
} FfpDevice;

// What this thread works on; NULL: the CPU. Threads begin on the CPU.
const FfpDevice *ffp_device(void);
// Returns what was in use before, to be set again.
const FfpDevice *ffp_device_use(const FfpDevice *device);

// The device that long work (training, reconstruction) of the call at work (core/base/call.h) is to use, as
// its context has it; NULL: the CPU.
const FfpDevice *ffp_device_offered(void);

// Memory of what this thread works on. new: count * size bytes, zeroed, as ffp_alloc on the CPU.
void *ffp_memory_new(size_t count, size_t size);
void ffp_memory_free(void *block); // by who works on the device it came from; NULL is allowed
void ffp_memory_zero(void *block, size_t bytes);
void ffp_memory_copy(void *to, const void *from, size_t bytes);
void ffp_memory_upload(void *to, const void *from_host, size_t bytes);
void ffp_memory_download(void *to_host, const void *from, size_t bytes);
// A new block with the host's numbers; NULL stays NULL.
void *ffp_memory_uploaded(const void *from_host, size_t count, size_t size);

#endif
