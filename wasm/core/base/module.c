// A page is linked as a whole: OpenCV with it, and nothing is loaded later.
#include "core/base/module.h"
#include <stddef.h>
#include <string.h>
#include "rig/chessboard/opencv_module.h"

const void *ffp_module_load(FfpModule *module, FfpError *err) {
    if (strcmp(module->name, "opencv") == 0) return &ffp_opencv_module;
    ffp_fail(err, FFP_ERROR_UNSUPPORTED, module->name, "%s, which the page does not have", module->purpose);
    return NULL;
}
