// Files: read whole with a size limit, written to a temporary name and renamed.
#ifndef FFP_BASE_FILE_H
#define FFP_BASE_FILE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdio.h>
#include "core/base/alloc.h"
#include "core/base/error.h"

#define FFP_PATH_MAX 1024

// Opens a regular file; a folder, a FIFO or a device is refused, without waiting for anybody at its other
// end.
FILE *ffp_open_to_read(const char *path, FfpError *err);
// Opens a file that grows line by line where it lies, made if need be; `append`: behind what exists.
FILE *ffp_open_to_grow(const char *path, bool append, FfpError *err);
// Reads the whole file (at most max_bytes) into *data (released with ffp_free, one zero byte behind the end)
// and its size.
bool ffp_read_file(const char *path, size_t max_bytes, char **data, size_t *size, FfpError *err);
// The same for text, which is to be UTF-8: a byte order mark is left out, other encodings that show by theirs
// are refused.
bool ffp_read_text(const char *path, size_t max_bytes, char **text, size_t *size, FfpError *err);

// A file or folder being written, under a name beside its own, "<target>.<pid>.tmp", until commit renames it;
// abort removes it. Symbolic links are written through: the link stays, its target is replaced. An existing
// file's permissions are kept; what is not a regular file (a device, a FIFO) is refused.
typedef struct FfpOutput {
    FILE *stream;                      // of a file
    char path[FFP_PATH_MAX];           // as it was asked for
    char temporary[FFP_PATH_MAX + 32]; // what is written to; "": nothing is held
    size_t target;                     // length of the final name, with which `temporary` begins
    struct FfpTemporary *owned; // by the call at work (core/base/call.h): it leaves no temporary behind
} FfpOutput;
bool ffp_output_open(FfpOutput *out, const char *path, FfpError *err);
// A folder to be filled under out->temporary, with its parents. One that exists is filled where it lies,
// and then abort leaves it alone; if it must be `fresh`, it has to be empty, which the commit finds out.
bool ffp_output_open_folder(FfpOutput *out, const char *path, bool fresh, FfpError *err);
bool ffp_output_commit(FfpOutput *out, FfpError *err); // flush, fsync, rename; on failure removes and reports
void ffp_output_abort(FfpOutput *out);                 // safe after commit or a failed open
// Whether the file or folder could be written, told before the work rather than after it. NULL: nothing is to
// be written.
bool ffp_output_probe(const char *path, FfpError *err);
bool ffp_output_probe_folder(const char *path, FfpError *err);

// The call at work closes the file when it is left (core/base/call.h), or it is closed here: as fclose.
void ffp_own_file(FILE *file);
int ffp_close_file(FILE *file);

bool ffp_write_file(const char *path, const void *data, size_t size, FfpError *err); // open + write + commit

bool ffp_make_folders(const char *path, FfpError *err); // like mkdir -p; makes what a link leads to
void ffp_remove_tree(const char *folder);               // with all that is in it; links are not followed
bool ffp_is_file(const char *path);
bool ffp_is_folder(const char *path);
// "folder/name" into out; false when it does not fit FFP_PATH_MAX
bool ffp_join_path(char out[FFP_PATH_MAX], const char *folder, const char *name);
// The folder of the file that this code is in: the shared library, or the program that it is linked into.
bool ffp_own_folder(char out[FFP_PATH_MAX]);
const char *ffp_basename(const char *path); // the part after the last '/'

#endif
