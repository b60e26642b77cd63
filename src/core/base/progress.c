// Reports to the caller on the work, and the answer whether it is to go on.
#include <omp.h>
#include <stdio.h>
#include "core/base/frame.h"
#include "core/base/log.h"

// --- Asking. ---

static bool is_asked(void) {
    const FfpContext *context = ffp_call_context();
    return context && context->settings.progress && ffp_frame->caller && !ffp_call()->cancelled;
}

// Tells the caller where the call is, and hears whether it is to go on.
static void ask(double now) {
    FfpCall *call = ffp_call();
    const FfpContextSettings *settings = &call->context->settings;
    FfpProgress p = call->progress;
    p.extra = call->extra[0] ? call->extra : NULL;
    p.done = call->done;
    p.elapsed_s = p.stage ? now - call->began : 0;
    p.left_s = p.done > 0 ? p.elapsed_s * (double)(p.total - p.done) / (double)p.done : -1.0;
    call->asked = now;
    const locale_t ours = uselocale(call->locale);
    if (!settings->progress(settings->user, &p)) call->cancelled = true;
    uselocale(ours);
}

static void ask_in_time(void) {
    if (!is_asked()) return;
    const double now = ffp_seconds();
    if (now - ffp_call()->asked >= ffp_call_context()->settings.interval_s) ask(now);
}

// --- Being cancelled. ---

static void leave_if_cancelled(void) {
    const FfpCall *call = ffp_call();
    if (!call || omp_get_level() != ffp_frame->level) return;
    if (call->failed) ffp_leave((FfpErrorCode)call->failed, 0); // in another body of a region
    if (call->cancelled && !call->held_off) ffp_leave(FFP_ERROR_CANCELLED, 0);
}

void ffp_cancel_point(void) {
    ask_in_time();
    leave_if_cancelled();
}

bool ffp_cancelled(void) {
    ask_in_time();
    return ffp_call() && ffp_call()->cancelled;
}

bool ffp_cancel_hold_off(bool on) {
    FfpCall *call = ffp_call();
    if (!call) return false;
    const bool before = call->held_off;
    call->held_off = on;
    return before;
}

// --- Tasks. ---

// The call, in the thread that made it; NULL elsewhere.
static FfpCall *call_of_caller(void) {
    return ffp_frame && ffp_frame->caller ? ffp_frame->call : NULL;
}

FfpTask ffp_task(const char *what, int64_t total) {
    FfpTask task = {.what = what, .total = total, .started = ffp_seconds()};
    FfpCall *call = call_of_caller();
    if (!call) return task;
    task.before = call->progress;
    task.before.done = call->done;
    task.before_began = call->began;
    call->progress = (FfpProgress){.stage = what, .total = total};
    call->done = 0;
    call->extra[0] = 0;
    call->began = task.started;
    return task;
}

void ffp_task_step(const FfpTask *task, int64_t done, const char *extra) {
    FfpCall *call = ffp_call();
    if (!call) return;
    ffp_check(task->total == call->progress.total, "the task is not the innermost");
    call->done = done;
    if (ffp_frame->caller) snprintf(call->extra, sizeof call->extra, "%s", extra ? extra : "");
    ask_in_time();
    leave_if_cancelled();
}

void ffp_task_end(const FfpTask *task) {
    FfpCall *call = call_of_caller();
    if (!call) return;
    call->progress = task->before;
    call->done = task->before.done;
    call->extra[0] = 0;
    call->began = task->before_began;
    // The task that was shown has ended.
    if (is_asked() && call->asked >= task->started) ask(ffp_seconds());
    leave_if_cancelled();
}
