// Messages and progress for the caller of the current public function (core/base/call.h); discarded outside
// of one.
#ifndef FFP_BASE_LOG_H
#define FFP_BASE_LOG_H

#include <stdint.h>
#include "ffprocams/context.h"

void ffp_note(const char *format, ...) __attribute__((format(printf, 1, 2)));
void ffp_warning(const char *format, ...) __attribute__((format(printf, 1, 2)));

// Passes a finding on; false: the caller of the current call wants none as values.
bool ffp_tell_finding(const FfpFinding *finding);

// Work that is counted. Tasks may lie inside each other; bodies of ffp_parallel_for may all step in one.
typedef struct FfpTask {
    const char *what; // e.g. "rendering"
    int64_t total;
    double started; // ffp_seconds()
    FfpProgress before;
    double before_began; // of the task around this one
} FfpTask;
FfpTask ffp_task(const char *what, int64_t total);                        // 0: a stage that is not counted
void ffp_task_step(const FfpTask *task, int64_t done, const char *extra); // extra may be NULL
void ffp_task_end(const FfpTask *task);

double ffp_seconds(void); // monotonic clock
// How much of its time or of its steps a fit has used, whichever is more, from 0 to 1. started:
// ffp_seconds(); steps or seconds 0: no such limit.
double ffp_share_spent(int64_t step, int64_t steps, double started, double seconds);

#endif
