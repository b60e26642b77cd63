// Work whose caller wants it to end at the first moment at which it can, and which has something to show
// then.
#ifndef FFP_TESTS_STOPPED_H
#define FFP_TESTS_STOPPED_H

#include "core/base/call.h"

static inline bool stop_at_once(void *user, const FfpProgress *progress) {
    (void)user, (void)progress;
    return false;
}

typedef struct Stopped {
    bool (*work)(void *argument, FfpError *err);
    void *argument;
} Stopped;

static inline bool hold_off_and_work(void *argument, FfpError *err) {
    const Stopped *stopped = argument;
    ffp_cancel_hold_off(true);
    return stopped->work(stopped->argument, err);
}

// The result of ffp_call_run for `work` in such a call.
static inline bool run_stopped(bool (*work)(void *argument, FfpError *err), void *argument, FfpError *err) {
    FfpContext context = {.settings = {.progress = stop_at_once}};
    return ffp_call_run(&context, hold_off_and_work, &(Stopped){work, argument}, err);
}

#endif
