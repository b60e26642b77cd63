// Another program that works for a call: ffmpeg, dcraw_emu. We hold one end of a pipe to its stdin or its
// stdout; aborting the call kills it.
#ifndef FFP_BASE_PROCESS_H
#define FFP_BASE_PROCESS_H

#include <stdbool.h>
#include <stddef.h>
#include "core/base/error.h"

enum { FFP_PROCESS_SAID = 256 };

typedef struct FfpProcess FfpProcess;

typedef enum FfpProcessEnd {
    FFP_PROCESS_STDIN, // we write, what it prints is lost
    FFP_PROCESS_STDOUT // we read, its stdin is empty
} FfpProcessEnd;

// True if a program of this name is in one of the folders of PATH.
bool ffp_program_exists(const char *name);

// Starts arguments[0] (NULL after the last), found on PATH, in its own process group: Ctrl-C is for the
// caller. `where` is for the error.
bool ffp_process_start(FfpProcess **process, const char *const arguments[], FfpProcessEnd end,
                       const char *where, FfpError *err);
bool ffp_process_write(FfpProcess *process, const void *bytes, size_t size); // false: it takes no more
// Returns the number of bytes read: fewer than `size` only at the end.
size_t ffp_process_read(FfpProcess *process, void *bytes, size_t size);
// Waits for its end; true if it ended with status 0. *process becomes NULL, `said` the last line that it
// wrote to stderr, or "" if there is none.
bool ffp_process_finish(FfpProcess **process, char said[FFP_PROCESS_SAID]);
void ffp_process_kill(FfpProcess **process); // safe after finish, and when it was never started

#endif
