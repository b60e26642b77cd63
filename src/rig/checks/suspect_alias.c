#include <string.h>
#include "core/base/alloc.h"
#include "rig/checks/suspect_parts.h"

FfpCapture ffp_rig_alias(const FfpCapture *capture) {
    FfpCapture alias = *capture;
    alias.views = ffp_alloc((size_t)capture->n_views, sizeof *alias.views);
    memcpy(alias.views, capture->views, (size_t)capture->n_views * sizeof *alias.views);
    return alias;
}
