// progress CAPTURE SECONDS: a reconstruction that reports its progress, and ends after SECONDS seconds
// whether it is done or not. A window with a bar and a button would do the same with its own two functions.
#include <stdio.h>
#include <stdlib.h>
#include <time.h>
#include "ffprocams.h"

typedef struct Watch {
    double end; // seconds of the clock at which patience ends
    long calls;
} Watch;

static double clock_seconds(void) {
    struct timespec now;
    timespec_get(&now, TIME_UTC);
    return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

static void on_log(void *user, FfpLogLevel level, const char *text) {
    (void)user;
    printf("%s%s\n", level == FFP_LOG_WARNING ? "warning: " : "", text);
}

static bool on_progress(void *user, const FfpProgress *progress) {
    Watch *watch = user;
    watch->calls++;
    if (progress->stage && progress->total > 0)
        printf("%s: %lld of %lld\n", progress->stage, (long long)progress->done, (long long)progress->total);
    return clock_seconds() < watch->end; // false: stop as soon as you can
}

int main(int argc, char **argv) {
    FfpError err = {0};
    if (argc != 3) {
        fprintf(stderr, "usage: progress CAPTURE SECONDS\n");
        return 2;
    }
    Watch watch = {clock_seconds() + strtod(argv[2], NULL), 0};
    FfpContextSettings settings = ffp_context_defaults();
    settings.user = &watch, settings.log = on_log, settings.progress = on_progress;
    settings.interval_s = 0.02;
    FfpContext *context = ffp_context_new(&settings, &err);
    FfpCapture *capture = context ? ffp_capture_open(context, argv[1], NULL, &err) : NULL;
    FfpModel *model = capture ? ffp_model_open(context, NULL, NULL, &err) : NULL;
    FfpReconstruction options = ffp_reconstruction_defaults();
    options.model = model;
    FfpGaussians *gaussians = model ? ffp_reconstruct(context, capture, &options, NULL, &err) : NULL;
    if (gaussians)
        printf("done: %lld Gaussians, asked %ld times\n", (long long)ffp_gaussians_count(gaussians),
               watch.calls);
    else if (err.code == FFP_ERROR_CANCELLED)
        printf("stopped after %s s, asked %ld times\n", argv[2], watch.calls);
    else
        fprintf(stderr, "progress: %s\n", err.text);
    const bool failed = !gaussians && err.code != FFP_ERROR_CANCELLED;
    ffp_gaussians_close(gaussians);
    ffp_model_close(model);
    ffp_capture_close(capture);
    ffp_context_free(context);
    return failed ? 1 : 0;
}
