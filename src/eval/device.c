// Which device long work runs on (ffp_device_open of the public header).
#include <string.h>
#include "base/device.h"
#include "base/error.h"
#include "base/log.h"
#include "ffprocams.h"
#ifdef FFP_WITH_CUDA
#include "cuda/cuda.h"
#endif

static bool open_cuda(FfpError *err) {
#ifdef FFP_WITH_CUDA
    const FfpDevice *device = ffp_cuda_device(err);
    if (!device) return false;
    ffp_note("%s", ffp_cuda_describe());
    ffp_device_offer(device);
    return true;
#else
    return ffp_fail(err, "cuda", "this program was built without GPU support (cmake -DFFPROCAMS_CUDA=ON)");
#endif
}

bool ffp_device_open(const char *name, FfpError *err) {
    if (strcmp(name, "cuda") == 0) return open_cuda(err);
    if (strcmp(name, "cpu") != 0) return ffp_fail(err, name, "no such device: cpu or cuda");
    ffp_device_offer(NULL);
    return true;
}
