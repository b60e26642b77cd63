#include "core/base/frame.h"
#include <omp.h>
#include <stdio.h>
#include <stdlib.h>

_Thread_local FfpFrame *ffp_frame;

FfpContext *ffp_call_context(void) {
    return ffp_call() ? ffp_call()->context : NULL;
}

_Noreturn void ffp_leave(FfpErrorCode code, size_t bytes) {
    FfpCall *call = ffp_call();
    if (!call || call->ending || omp_get_level() != ffp_frame->level) {
        // Only inside the library: a test or a benchmark called a function that is not public.
        fprintf(stderr, "ffprocams: error: out of memory outside of any call (%zu bytes)\n", bytes);
        abort();
    }
    int none = FFP_OK;
    if (atomic_compare_exchange_strong(&call->failed, &none, (int)code)) call->wanted = bytes;
    longjmp(ffp_frame->jump, 1);
}

void ffp_check(bool right, const char *what) {
#if !defined(NDEBUG) || defined(FFP_SANITIZED)
    if (right) return;
    fprintf(stderr, "ffprocams: %s\n", what);
    abort();
#else
    (void)right;
    (void)what;
#endif
}
