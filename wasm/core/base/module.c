// A page is linked as a whole: nothing is loaded later.
#include "core/base/module.h"
#include <stddef.h>

const void *ffp_module_load(FfpModule *module, FfpError *err) {
    ffp_fail(err, FFP_ERROR_UNSUPPORTED, module->name, "%s, which the page does not have", module->purpose);
    return NULL;
}
