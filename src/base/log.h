// Words to the user: everything goes to stderr, results of commands go to stdout.
#ifndef FFP_BASE_LOG_H
#define FFP_BASE_LOG_H

#include <stdint.h>

void ffp_note(const char *format, ...) __attribute__((format(printf, 1, 2)));    // "ffprocams: ..."
void ffp_warning(const char *format, ...) __attribute__((format(printf, 1, 2))); // "ffprocams: warning: ..."

// Progress with rate and time left: a line redrawn on a terminal, a plain line every few seconds otherwise.
typedef struct FfpProgress {
    const char *what; // e.g. "rendering"
    int64_t total, done;
    double started, shown; // seconds, ffp_seconds()
} FfpProgress;
FfpProgress ffp_progress(const char *what, int64_t total);
void ffp_progress_step(FfpProgress *progress, int64_t done, const char *extra); // extra may be NULL
void ffp_progress_end(FfpProgress *progress);

double ffp_seconds(void); // monotonic clock

#endif
