#include <stdlib.h>
#include "core/base/call.h"
#include "core/base/log.h"
#include "ffprocams.h"
#include "product/api/arguments.h"
#ifdef FFP_WITH_CUDA
#include "engine/cuda/cuda.h"
#endif

#define INTERVAL 0.05 // seconds
enum { THREADS_MAX = 4096 };

void ffp_context_defaults_into(FfpContextSettings *options, size_t size) {
    ffp_give_defaults(options, size, &(FfpContextSettings){.interval_s = INTERVAL},
                      sizeof(FfpContextSettings));
}

static bool open_cuda(void *argument, FfpError *err) {
#ifdef FFP_WITH_CUDA
    FfpContext *context = argument;
    context->device = ffp_cuda_device(err);
    if (context->device) ffp_note("%s", ffp_cuda_describe());
    return context->device != NULL;
#else
    (void)argument;
    return ffp_fail(err, FFP_ERROR_UNSUPPORTED, "cuda",
                    "this library was built without GPU support (cmake -DFFPROCAMS_CUDA=ON)");
#endif
}

static bool check_ranks(const FfpRanks *r, FfpError *err) {
    if (r->count < 1 || r->rank < 0 || r->rank >= r->count)
        return ffp_fail(err, FFP_ERROR_ARGUMENT, "ranks", "rank %d of %d", r->rank, r->count);
    return (r->sum_begin && r->sum_finish && r->sum && r->gather && r->broadcast && r->leave) ||
           ffp_fail(err, FFP_ERROR_ARGUMENT, "ranks", "a function is NULL: all are required");
}

static bool check(const FfpContextSettings *settings, FfpError *err) {
    if (settings->threads < 0 || settings->threads > THREADS_MAX)
        return ffp_fail(err, FFP_ERROR_ARGUMENT, "threads", "%d threads: expected 0 to %d", settings->threads,
                        THREADS_MAX);
    if (!(settings->interval_s >= 0))
        return ffp_fail(err, FFP_ERROR_ARGUMENT, "interval_s", "%g seconds are not 0 or more",
                        settings->interval_s);
    if (!ffp_check_choice((int)settings->device, FFP_DEVICE_CUDA, "device", err) ||
        (settings->ranks && !check_ranks(settings->ranks, err)))
        return false;
    if (!settings->allocate != !settings->release)
        return ffp_fail(err, FFP_ERROR_ARGUMENT, "allocate", "allocate and release go together");
    return true;
}

FfpContext *ffp_context_new(const FfpContextSettings *settings, FfpError *err) {
    FfpContextSettings own = ffp_context_defaults();
    if (!ffp_need(settings, "settings", err) ||
        !ffp_take_options(&own, settings, "FfpContextSettings", err) || !check(&own, err))
        return NULL;
    FfpContext *context = calloc(1, sizeof *context);
    if (!context) {
        ffp_fail(err, FFP_ERROR_MEMORY, NULL, "out of memory");
        return NULL;
    }
    context->settings = own;
    if (own.device == FFP_DEVICE_CPU || ffp_call_run(context, open_cuda, context, err)) return context;
    free(context);
    return NULL;
}

void ffp_context_free(FfpContext *context) {
    free(context);
}
