#include "core/base/device.h"
#include <stddef.h>

static _Thread_local const FfpDevice *in_use;

const FfpDevice *ffp_device(void) {
    return in_use;
}

const FfpDevice *ffp_device_use(const FfpDevice *device) {
    const FfpDevice *before = in_use;
    in_use = device;
    return before;
}
