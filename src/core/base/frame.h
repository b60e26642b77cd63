// The state of the current call (call.h), private to the files that implement it: call.c begins and ends it,
// blocks.c keeps its blocks, alloc.c allocates them, and progress.c and log.c call its callbacks.
#ifndef FFP_BASE_FRAME_H
#define FFP_BASE_FRAME_H

#include <locale.h>
#include <setjmp.h>
#include "core/base/call.h"

typedef struct FfpCall {
    FfpContext *context;
    FfpBlocks blocks;
    pthread_mutex_t lock;       // of the log callback
    atomic_int failed;          // an FfpErrorCode
    atomic_size_t wanted;       // bytes that could not be allocated
    atomic_bool cancelled;      // by the caller
    bool ending;                // everything still held is being released
    bool held_off;              // when cancelled, the work itself comes to an end
    FfpProgress progress;       // of the innermost task, except for:
    atomic_llong done;          // its steps
    char extra[128];            // the text of its last step
    double began, asked;        // ffp_seconds() when that task began, and at the last progress callback
    const FfpDevice *device;    // that the thread worked on before
    int threads;                // of OpenMP, before
    locale_t locale;            // of the thread, before: the callbacks' own
    struct FfpMemoryFile *file; // one that it has in memory; NULL: none
} FfpCall;

// The target of a jump: the call's own frame, or that of a body of ffp_parallel_for.
typedef struct FfpFrame {
    jmp_buf jump;
    FfpCall *call;     // NULL: in a region of a thread that is in no call
    FfpBlocks *blocks; // whose memory is taken
    struct FfpFrame *outer;
    int level;   // of OpenMP's regions
    bool caller; // in the thread that made the call
} FfpFrame;

extern _Thread_local FfpFrame *ffp_frame; // the innermost of this thread; NULL: it is in none

// The call that this thread is in; NULL: in none.
static inline FfpCall *ffp_call(void) {
    return ffp_frame ? ffp_frame->call : NULL;
}

// Jumps to the frame; the first to do so in a call says why.
_Noreturn void ffp_leave(FfpErrorCode code, size_t bytes);

// Checks against mistakes inside the library itself, in builds for tests.
void ffp_check(bool right, const char *what);

#endif
