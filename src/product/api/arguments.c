#include "product/api/arguments.h"
#include <stdio.h>
#include <string.h>
#include "core/base/error.h"
#include "core/capture/capture.h"
#include "engine/render/render.h"

bool ffp_need(const void *thing, const char *name, FfpError *err) {
    return thing || ffp_fail(err, FFP_ERROR_ARGUMENT, name, "is required, but is NULL");
}

void ffp_give_defaults(void *options, size_t size, const void *defaults, size_t known) {
    if (size < sizeof size) return;
    memset(options, 0, size);
    memcpy(options, defaults, size < known ? size : known);
    memcpy(options, &size, sizeof size);
}

bool ffp_take_options(void *own, const void *options, const char *name, FfpError *err) {
    size_t known, given;
    if (!ffp_need(options, "options", err)) return false;
    memcpy(&known, own, sizeof known);
    memcpy(&given, options, sizeof given);
    if (given < sizeof given)
        return ffp_fail(err, FFP_ERROR_ARGUMENT, name, "its size is %zu: start from its defaults", given);
    if (given > known)
        return ffp_fail(err, FFP_ERROR_ARGUMENT, name,
                        "its size is %zu, but %zu in this library, version %s: it is that of a later one",
                        given, known, FFP_VERSION);
    memcpy(own, options, given);
    memcpy(own, &known, sizeof known);
    return true;
}

bool ffp_need_photographs(const FfpCapture *capture, FfpError *err) {
    if (!ffp_need(capture, "capture", err)) return false;
    return (capture->n_views > 0 && capture->views[0].coverage.data) ||
           ffp_fail(err, FFP_ERROR_ARGUMENT, "capture",
                    "its photographs were left in their files (FFP_READ_NONE): open all of it");
}

bool ffp_need_texts(const char *const *texts, int n, const char *name, FfpError *err) {
    if (n < 0) return ffp_fail(err, FFP_ERROR_ARGUMENT, name, "invalid count %d", n);
    if (n > 0 && !ffp_need(texts, name, err)) return false;
    for (int i = 0; i < n; i++) {
        char place[64];
        snprintf(place, sizeof place, "%s[%d]", name, i);
        if (!ffp_need(texts[i], place, err)) return false;
    }
    return true;
}

bool ffp_check_drawing(FfpDrawing drawing, FfpError *err) {
    if ((unsigned)drawing.form > FFP_FORM_GS_PROCAMS)
        return ffp_fail(err, FFP_ERROR_ARGUMENT, "drawing.form", "invalid value %d", (int)drawing.form);
    return (drawing.samples >= 0 && drawing.samples <= FFP_SAMPLES_MAX) ||
           ffp_fail(err, FFP_ERROR_ARGUMENT, "drawing.samples",
                    "%d samples per side of a pixel: expected 1 to %d, or 0 for the default", drawing.samples,
                    FFP_SAMPLES_MAX);
}
