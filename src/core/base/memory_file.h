// A file that a call has in memory instead of on disk: its readers and writers open it by its path, as any
// other (file.h).
#ifndef FFP_BASE_MEMORY_FILE_H
#define FFP_BASE_MEMORY_FILE_H

#include <stddef.h>

typedef struct FfpMemoryFile {
    const char *path;
    const void *bytes; // to be read; NULL: it will be written
    size_t size;
    void *written; // [size] once its output is committed: released with ffp_free
} FfpMemoryFile;

void ffp_memory_file_use(FfpMemoryFile *file);    // until the call ends
FfpMemoryFile *ffp_memory_file(const char *path); // the call's, if it has this path; NULL: it is on disk

#endif
