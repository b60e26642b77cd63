// The library's words, its progress and the signals that end its work: everything goes to stderr, results of
// commands go to stdout.
#define _XOPEN_SOURCE 700 // SA_RESETHAND
#include <signal.h>
#include <stdatomic.h>
#include <stdio.h>
#include <string.h>
#include <time.h>
#include <unistd.h>
#include "cli.h"

static const double terminal_interval = 0.2, file_interval = 10.0; // seconds between two lines of progress

static FfpContext *context;
static FfpDeviceKind device_kind;         // of it
static volatile sig_atomic_t interrupted; // the signal
static atomic_bool shown;                 // a line of progress stands on the terminal
static double shown_at;                   // seconds
static bool findings_seen;                // the command prints them itself

static void on_signal(int number) {
    interrupted = number;
}

void ffp_cli_clear_progress(void) {
    if (atomic_exchange(&shown, false)) fputs("\r\033[K", stderr);
}

static void write_line(void *user, FfpLogLevel level, const char *text) {
    (void)user;
    const bool warning = level == FFP_LOG_WARNING;
    ffp_cli_event_log(level, text);
    if (!warning && ffp_cli_ranks() && ffp_cli_ranks()->rank > 0) return;
    ffp_cli_clear_progress();
    fprintf(stderr, "ffprocams: %s%s%s\n", warning ? ffp_cli_rank_name() : "", warning ? "warning: " : "",
            text);
}

// "fix=camera.k3 camera.p" as it is given on the command line; of "exposure" the option.
static void print_setting(const char *setting) {
    const char *equals = setting ? strchr(setting, '=') : NULL;
    if (setting && !equals) fprintf(stderr, "ffprocams:   the option is --%s\n", setting);
    if (!equals) return;
    fputs("ffprocams:   run it again with", stderr);
    for (const char *word = equals + 1; *word; word += strcspn(word, " "), word += *word == ' ')
        fprintf(stderr, " --%.*s %.*s", (int)(equals - setting), setting, (int)strcspn(word, " "), word);
    fputc('\n', stderr);
}

static void write_finding(void *user, const FfpFinding *f) {
    const bool warning = f->severity == FFP_FINDING_DOUBT;
    (void)user;
    ffp_cli_event_finding(f);
    if (findings_seen || f->severity == FFP_FINDING_OK || f->severity == FFP_FINDING_FAULT) return;
    if (!warning && ffp_cli_ranks() && ffp_cli_ranks()->rank > 0) return;
    ffp_cli_clear_progress();
    fprintf(stderr, "ffprocams: %s%s%s%s%s\n", warning ? ffp_cli_rank_name() : "", warning ? "warning: " : "",
            f->text, f->advice ? ": " : "", f->advice ? f->advice : "");
    print_setting(f->setting);
}

void ffp_cli_findings_are_printed(void) {
    findings_seen = true;
}

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

static void show(const FfpProgress *p, bool terminal) {
    char left[32] = "?";
    if (p->left_s >= 0) print_duration(p->left_s, left, sizeof left);
    if (p->total == 0)
        fprintf(stderr, "%sffprocams: %s%s", terminal ? "\r\033[K" : "", p->stage, terminal ? "" : "\n");
    else
        fprintf(stderr, "%sffprocams: %s %lld/%lld, %.3g/s, %s left%s%s%s", terminal ? "\r\033[K" : "",
                p->stage, (long long)p->done, (long long)p->total,
                p->elapsed_s > 0 ? (double)p->done / p->elapsed_s : 0, left, p->extra ? ", " : "",
                p->extra ? p->extra : "", terminal ? "" : "\n");
    fflush(stderr);
    shown = terminal;
}

static double now(void) {
    struct timespec time = {0};
    clock_gettime(CLOCK_MONOTONIC, &time);
    return (double)time.tv_sec + 1e-9 * (double)time.tv_nsec;
}

// A line redrawn on a terminal, a plain line every few seconds otherwise; none for work that is soon over.
static bool on_progress(void *user, const FfpProgress *p) {
    (void)user;
    const bool terminal = isatty(STDERR_FILENO);
    const double interval = terminal ? terminal_interval : file_interval;
    ffp_cli_event_progress(p);
    if (ffp_cli_events() >= 0) return !interrupted;
    if (ffp_cli_ranks() && ffp_cli_ranks()->rank > 0) return !interrupted;
    if (!p->stage) {
        ffp_cli_clear_progress();
    } else if (p->elapsed_s >= interval && now() - shown_at >= interval) {
        show(p, terminal);
        shown_at = now();
    }
    return !interrupted;
}

bool ffp_cli_open_context(FfpDeviceKind device, FfpError *err) {
    FfpContextSettings settings = ffp_context_defaults();
    settings.log = write_line;
    settings.progress = on_progress;
    settings.finding = write_finding;
    settings.device = device;
    settings.ranks = ffp_cli_ranks();
    device_kind = device;
    ffp_context_free(context);
    context = ffp_context_new(&settings, err);
    struct sigaction action = {.sa_handler = on_signal, .sa_flags = (int)(SA_RESETHAND | SA_RESTART)};
    sigaction(SIGINT, &action, NULL);
    sigaction(SIGTERM, &action, NULL);
    signal(SIGXFSZ, SIG_IGN); // a file that grows beyond ulimit -f: an error where it is written
    return context != NULL;
}

bool ffp_cli_use_device(const char *name, FfpError *err) {
    const FfpDeviceKind kind = name && strcmp(name, "cuda") == 0 ? FFP_DEVICE_CUDA : FFP_DEVICE_CPU;
    return !name || ffp_cli_open_context(kind, err);
}

bool ffp_cli_use_ranks(FfpError *err) {
    return ffp_cli_join_ranks(err) && (!ffp_cli_ranks() || ffp_cli_open_context(device_kind, err));
}

FfpContext *ffp_cli_context(void) {
    return context;
}

void ffp_cli_clear_interrupt(void) {
    interrupted = 0;
}

void ffp_cli_close_context(void) {
    ffp_context_free(context);
    context = NULL;
    if (!interrupted) return;
    signal(interrupted, SIG_DFL);
    raise(interrupted);
}
