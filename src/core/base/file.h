// Files: read whole with a size limit, written to a temporary name and renamed.
#ifndef FFP_BASE_FILE_H
#define FFP_BASE_FILE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include "core/base/alloc.h"
#include "core/base/error.h"

#define FFP_PATH_MAX 1024

// Opens a regular file; a folder, a FIFO or a device is refused, without waiting for its other end.
FILE *ffp_open_to_read(const char *path, FfpError *err);
// Bytes of a file that was opened so; -1: unknown.
int64_t ffp_file_size(FILE *stream);
// Opens a file that is written in place, line by line, creating it if necessary; `append`: after its
// contents.
FILE *ffp_open_to_grow(const char *path, bool append, FfpError *err);
// Reads the whole file (at most max_bytes) into *data (released with ffp_free, one zero byte after the end)
// and its size.
bool ffp_read_file(const char *path, size_t max_bytes, char **data, size_t *size, FfpError *err);
// The same for text, which must be UTF-8: a byte order mark is skipped, and one of another encoding is an
// error.
bool ffp_read_text(const char *path, size_t max_bytes, char **text, size_t *size, FfpError *err);

// A file or folder being written, under a name beside its own, "<target>.<pid>.tmp", until commit renames it;
// abort removes it. Symbolic links are written through: the link stays, its target is replaced. An existing
// file's permissions are kept; what is not a regular file (a device, a FIFO) is refused.
typedef struct FfpOutput {
    FILE *stream;                      // of a file
    char path[FFP_PATH_MAX];           // as given by the caller
    char temporary[FFP_PATH_MAX + 32]; // the name written to; "": not open
    size_t target;                     // length of the final name, with which `temporary` begins
    struct FfpTemporary *owned; // by the call at work (core/base/call.h): it leaves no temporary behind
} FfpOutput;
bool ffp_output_open(FfpOutput *out, const char *path, FfpError *err);
// A folder to be filled under out->temporary, with its parents. An existing one is filled in place, and then
// abort leaves it alone; if it must be `fresh`, it has to be empty, which the commit checks.
bool ffp_output_open_folder(FfpOutput *out, const char *path, bool fresh, FfpError *err);
bool ffp_output_commit(FfpOutput *out, FfpError *err); // flush, fsync, rename; on failure removes and reports
void ffp_output_abort(FfpOutput *out);                 // safe after commit or a failed open
// Checks that the file or folder could be written, before the work rather than after it. NULL: nothing to
// write.
bool ffp_output_probe(const char *path, FfpError *err);
bool ffp_output_probe_folder(const char *path, FfpError *err);
// The same for a file whose folders are made if they do not exist: for figures, which name no input to be
// beside.
bool ffp_output_prepare(const char *path, FfpError *err);

// The current call closes the file if it is aborted (core/base/call.h); otherwise it is closed here: as
// fclose.
void ffp_own_file(FILE *file);
int ffp_close_file(FILE *file);

bool ffp_write_file(const char *path, const void *data, size_t size, FfpError *err); // open + write + commit

bool ffp_make_folders(const char *path, FfpError *err); // like mkdir -p; creates the target of a link
void ffp_remove_tree(const char *folder);               // with all its contents; links are not followed
bool ffp_is_file(const char *path);
bool ffp_is_folder(const char *path);
// "folder/name" into out; false when it does not fit FFP_PATH_MAX
bool ffp_join_path(char out[FFP_PATH_MAX], const char *folder, const char *name);
// The folder of the file that this code is in: the shared library, or the program that it is linked into.
bool ffp_own_folder(char out[FFP_PATH_MAX]);
const char *ffp_basename(const char *path); // the part after the last '/'

#endif
