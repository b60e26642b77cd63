// Where a call reads a file from: its path, or its contents in the caller's memory.
#ifndef FFP_API_SOURCE_H
#define FFP_API_SOURCE_H

#include "core/base/memory_file.h"
#include "product/api/arguments.h"

typedef struct FfpFileSource {
    const char *path; // the name that messages give it
    FfpMemoryFile memory;
} FfpFileSource;

// `contents` NULL: the file at `path`; otherwise `path` may be NULL.
static inline bool ffp_source_find(FfpFileSource *source, const char *path, const FfpBytes *contents,
                                   FfpError *err) {
    *source = (FfpFileSource){.path = path};
    if (!contents) return true;
    if (!ffp_need(contents->data, "contents.data", err)) return false;
    source->path = path ? path : "contents";
    source->memory = (FfpMemoryFile){.path = source->path, .bytes = contents->data, .size = contents->size};
    return true;
}

// In the call, before the file is read; ffp_memory_file_use(NULL) ends it.
static inline void ffp_source_use(FfpFileSource *source) {
    if (source->memory.path) ffp_memory_file_use(&source->memory);
}

#endif
