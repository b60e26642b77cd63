// A call at work (call.h), as the files share it that make it: call.c begins and ends it, blocks.c keeps what
// it has taken, alloc.c takes that, progress.c and log.c speak with its caller. Private to these.
#ifndef FFP_BASE_FRAME_H
#define FFP_BASE_FRAME_H

#include <locale.h>
#include <setjmp.h>
#include "core/base/call.h"

typedef struct FfpCall {
    FfpContext *context;
    FfpBlocks blocks;
    pthread_mutex_t lock;    // of the log callback
    atomic_int failed;       // an FfpErrorCode
    atomic_size_t wanted;    // bytes that could not be allocated
    atomic_bool cancelled;   // by the caller
    bool ending;             // everything still held is being released
    bool held_off;           // when cancelled, the work itself comes to an end
    FfpProgress progress;    // of the innermost task, but for:
    atomic_llong done;       // of it
    char extra[128];         // what was said with its last step
    double began, asked;     // ffp_seconds(): that task; the progress callback, last
    const FfpDevice *device; // that the thread worked on before
    int threads;             // of OpenMP, before
    locale_t locale;         // of the thread, before: the callbacks' own
} FfpCall;

// Where a jump leads: the call's own frame, or that of a body of ffp_parallel_for.
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

// What only the library itself can get wrong: seen where it is built for tests.
void ffp_check(bool right, const char *what);

#endif
