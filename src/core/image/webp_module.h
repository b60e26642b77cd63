// Animated WebP by libwebp's demux library: a module (core/base/module.h), loaded by webp.c.
#ifndef FFP_IMAGE_WEBP_MODULE_H
#define FFP_IMAGE_WEBP_MODULE_H

#include <stdbool.h>
#include <stddef.h>
#include "core/base/module.h"

enum { FFP_WEBP_MODULE_VERSION = 1 }; // of the table below

typedef struct FfpWebpModule {
    int version;
    // The film in `bytes`, which stay where they are until it is closed; NULL: it is damaged.
    void *(*open)(const unsigned char *bytes, size_t size);
    bool (*more)(void *film);
    // The next picture, of the whole canvas, RGBA with straight alpha, until the next call, and the time
    // until which it shows, ms. False: it is damaged.
    bool (*next)(void *film, unsigned char **rgba, int *until);
    void (*close)(void *film);
} FfpWebpModule;

extern FFP_MODULE_EXPORT const FfpWebpModule ffp_webp_module;

#endif
