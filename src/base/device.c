#include "base/device.h"

#include <stddef.h>

static _Thread_local const FfpDevice *in_use;
static const FfpDevice *offered;

const FfpDevice *ffp_device(void) {
    return in_use;
}

const FfpDevice *ffp_device_use(const FfpDevice *device) {
    const FfpDevice *before = in_use;
    in_use = device;
    return before;
}

void ffp_device_offer(const FfpDevice *device) {
    offered = device;
}

const FfpDevice *ffp_device_offered(void) {
    return offered;
}
