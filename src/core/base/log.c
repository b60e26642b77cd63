#include "core/base/log.h"
#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <time.h>
#include "core/base/frame.h"

static void say(FfpLogLevel level, const char *format, va_list arguments) {
    FfpCall *call = ffp_call();
    const FfpContext *context = ffp_call_context();
    if (!context || !context->settings.log) return;
    char text[2048];
    vsnprintf(text, sizeof text, format, arguments);
    const locale_t ours = uselocale(call->locale);
    pthread_mutex_lock(&call->lock);
    context->settings.log(context->settings.user, level, text);
    pthread_mutex_unlock(&call->lock);
    uselocale(ours);
}

void ffp_note(const char *format, ...) {
    va_list arguments;
    va_start(arguments, format);
    say(FFP_LOG_NOTE, format, arguments);
    va_end(arguments);
}

void ffp_warning(const char *format, ...) {
    va_list arguments;
    va_start(arguments, format);
    say(FFP_LOG_WARNING, format, arguments);
    va_end(arguments);
}

bool ffp_tell_finding(const FfpFinding *finding) {
    FfpCall *call = ffp_call();
    const FfpContext *context = ffp_call_context();
    if (!context || !context->settings.finding) return false;
    const locale_t ours = uselocale(call->locale);
    pthread_mutex_lock(&call->lock);
    context->settings.finding(context->settings.user, finding);
    pthread_mutex_unlock(&call->lock);
    uselocale(ours);
    return true;
}

double ffp_seconds(void) {
    struct timespec now = {0};
    clock_gettime(CLOCK_MONOTONIC, &now);
    return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

double ffp_share_spent(int64_t step, int64_t steps, double started, double seconds) {
    double share = 0;
    if (steps > 0) share = (double)step / (double)steps;
    if (seconds > 0) share = fmax(share, (ffp_seconds() - started) / seconds);
    return fmin(share, 1);
}
