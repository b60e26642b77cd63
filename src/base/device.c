#include "base/device.h"

#include <stddef.h>
#include "base/call.h"

static _Thread_local const FfpDevice *in_use;

const FfpDevice *ffp_device(void) {
    return in_use;
}

const FfpDevice *ffp_device_use(const FfpDevice *device) {
    const FfpDevice *before = in_use;
    in_use = device;
    return before;
}

const FfpDevice *ffp_device_offered(void) {
    const FfpContext *context = ffp_call_context();
    return context ? context->device : NULL;
}
