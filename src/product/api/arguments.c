#include "product/api/arguments.h"
#include <stdio.h>
#include <string.h>
#include "core/base/error.h"
#include "core/capture/manifest.h"
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
    if (given < sizeof given || given % sizeof given != 0)
        return ffp_fail(err, FFP_ERROR_ARGUMENT, name, "its size is %zu: start from its defaults", given);
    if (given > known)
        return ffp_fail(err, FFP_ERROR_ARGUMENT, name,
                        "it has %zu bytes, and %zu in this library, version %s: the program was compiled "
                        "for a later one",
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
    if (!ffp_check_choice((int)drawing.form, FFP_FORM_GS_PROCAMS, "drawing.form", err)) return false;
    return (drawing.samples >= 0 && drawing.samples <= FFP_SAMPLES_MAX) ||
           ffp_fail(err, FFP_ERROR_ARGUMENT, "drawing.samples",
                    "%d samples per side of a pixel: expected 1 to %d, or 0 for the default", drawing.samples,
                    FFP_SAMPLES_MAX);
}

// A share of white, or FFP_NOISE_ESTIMATED.
static bool check_noise(double noise, FfpError *err) {
    return noise == FFP_NOISE_ESTIMATED || (noise >= 0 && noise <= 1) ||
           ffp_fail(err, FFP_ERROR_ARGUMENT, "noise", "%g is not in 0 to 1", noise);
}

bool ffp_check_reconstruction(const FfpReconstruction *options, FfpError *err) {
    if (options->polish < 0 && options->polish != FFP_POLISH_AUTO)
        return ffp_fail(err, FFP_ERROR_ARGUMENT, "polish", "%lld steps are below 0",
                        (long long)options->polish);
    if (options->layers != FFP_LAYERS_AUTO && !(options->layers >= 0))
        return ffp_fail(err, FFP_ERROR_ARGUMENT, "layers", "%g is not 0 or more", options->layers);
    if (options->width != 0 && (options->width < FFP_CAMERA_SIDE_MIN || options->width > FFP_IMAGE_SIDE_MAX))
        return ffp_fail(err, FFP_ERROR_ARGUMENT, "width", "%lld is not in %d to %d",
                        (long long)options->width, FFP_CAMERA_SIDE_MIN, FFP_IMAGE_SIDE_MAX);
    return ffp_need_texts(options->patterns, options->n_patterns, "patterns", err) &&
           check_noise(options->noise, err) && ffp_check_drawing(options->drawing, err);
}

bool ffp_check_refinement(const FfpRefinement *options, FfpError *err) {
    if (options->steps < 0)
        return ffp_fail(err, FFP_ERROR_ARGUMENT, "steps", "%lld steps are below 0",
                        (long long)options->steps);
    if (!(options->limit_s >= 0))
        return ffp_fail(err, FFP_ERROR_ARGUMENT, "limit_s", "%g seconds are not 0 or more", options->limit_s);
    return ffp_need_texts(options->patterns, options->n_patterns, "patterns", err) &&
           check_noise(options->noise, err) && ffp_check_drawing(options->drawing, err);
}
