// Files: read whole with a size limit, written to a temporary name and renamed.
#ifndef FFP_BASE_FILE_H
#define FFP_BASE_FILE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdio.h>
#include "base/error.h"

#define FFP_PATH_MAX 1024

// Reads the whole file (at most max_bytes) into *data (malloc'd, one zero byte behind the end) and its size.
bool ffp_read_file(const char *path, size_t max_bytes, char **data, size_t *size, FfpError *err);

// A file being written: `stream` writes to "<path>.<pid>.tmp" until commit renames it. Abort removes it.
typedef struct FfpOutput {
    FILE *stream;
    char path[FFP_PATH_MAX], temporary[FFP_PATH_MAX + 32];
} FfpOutput;
bool ffp_output_open(FfpOutput *out, const char *path, FfpError *err);
bool ffp_output_commit(FfpOutput *out, FfpError *err); // flush, fsync, rename; on failure removes and reports
void ffp_output_abort(FfpOutput *out);                 // safe after commit or a failed open
// Whether the file could be written, told before the work rather than after it. NULL: nothing is to be
// written.
bool ffp_output_probe(const char *path, FfpError *err);

bool ffp_write_file(const char *path, const void *data, size_t size, FfpError *err); // open + write + commit

bool ffp_make_folders(const char *path, FfpError *err); // like mkdir -p
bool ffp_is_file(const char *path);
bool ffp_is_folder(const char *path);
// "folder/name" into out; false when it does not fit FFP_PATH_MAX
bool ffp_join_path(char out[FFP_PATH_MAX], const char *folder, const char *name);
const char *ffp_basename(const char *path); // the part behind the last '/'

#endif
