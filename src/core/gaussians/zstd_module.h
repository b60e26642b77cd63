// Zstandard: a module (core/base/module.h), loaded by spz.c for files of version 4.
#ifndef FFP_GAUSSIANS_ZSTD_MODULE_H
#define FFP_GAUSSIANS_ZSTD_MODULE_H

#include <stddef.h>
#include "core/base/module.h"

enum { FFP_ZSTD_MODULE_VERSION = 1 }; // of the table below

typedef struct FfpZstdModule {
    int version;
    size_t (*decompress)(void *out, size_t room, const void *data, size_t size); // ZSTD_decompress
} FfpZstdModule;

extern FFP_MODULE_EXPORT const FfpZstdModule ffp_zstd_module;

#endif
