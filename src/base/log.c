#include "base/log.h"

#include <stdarg.h>
#include <stdio.h>
#include <time.h>
#include <unistd.h>

void ffp_note(const char *format, ...) {
    va_list arguments;
    va_start(arguments, format);
    fputs("ffprocams: ", stderr);
    vfprintf(stderr, format, arguments);
    fputc('\n', stderr);
    va_end(arguments);
}

void ffp_warning(const char *format, ...) {
    va_list arguments;
    va_start(arguments, format);
    fputs("ffprocams: warning: ", stderr);
    vfprintf(stderr, format, arguments);
    fputc('\n', stderr);
    va_end(arguments);
}

double ffp_seconds(void) {
    struct timespec now = {0};
    clock_gettime(CLOCK_MONOTONIC, &now);
    return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

static const double terminal_interval = 0.2, file_interval = 10.0; // seconds between two updates

// "1:02:03", "2:03" or "3 s"
static void print_duration(double seconds, char *text, size_t size) {
    const long s = seconds > 0 && seconds < 1e9 ? (long)(seconds + 0.5) : 0;
    if (s >= 3600)
        snprintf(text, size, "%ld:%02ld:%02ld", s / 3600, s / 60 % 60, s % 60);
    else if (s >= 60)
        snprintf(text, size, "%ld:%02ld", s / 60, s % 60);
    else
        snprintf(text, size, "%ld s", s);
}

FfpProgress ffp_progress(const char *what, int64_t total) {
    const double now = ffp_seconds();
    return (FfpProgress){.what = what, .total = total, .started = now, .shown = now};
}

static void show(FfpProgress *progress, double now, const char *extra) {
    const double spent = now - progress->started;
    const double rate = spent > 0 ? (double)progress->done / spent : 0;
    char left[32] = "?";
    if (rate > 0) print_duration((double)(progress->total - progress->done) / rate, left, sizeof left);
    const int terminal = isatty(STDERR_FILENO);
    fprintf(stderr, "%sffprocams: %s %lld/%lld, %.3g/s, %s left%s%s%s", terminal ? "\r\033[K" : "",
            progress->what, (long long)progress->done, (long long)progress->total, rate, left,
            extra != NULL ? ", " : "", extra != NULL ? extra : "", terminal ? "" : "\n");
    fflush(stderr);
    progress->shown = now;
}

void ffp_progress_step(FfpProgress *progress, int64_t done, const char *extra) {
    progress->done = done;
    const double now = ffp_seconds();
    if (now - progress->shown >= (isatty(STDERR_FILENO) ? terminal_interval : file_interval))
        show(progress, now, extra);
}

void ffp_progress_end(FfpProgress *progress) {
    // Work that was over before the first line needs none.
    if (progress->shown > progress->started && isatty(STDERR_FILENO)) fputs("\r\033[K", stderr);
    progress->done = progress->total;
}
