#include "engine/network/inputs.h"
#include <stdio.h>
#include "core/base/vec.h"
#include "engine/network/layout.h"

enum { RAY_CHANNEL = 9 };

static bool check_image(const FfpImage *image, const FfpCamera *camera, const char *what, const FfpView *view,
                        FfpError *err) {
    if (!image->data) return ffp_fail(err, FFP_ERROR_ARGUMENT, view->id, "the view has no %s image", what);
    if (image->width != camera->width || image->height != camera->height || image->channels != 3)
        return ffp_fail(err, FFP_ERROR_ARGUMENT, view->id, "the %s image does not have the camera's size",
                        what);
    return true;
}

bool ffp_inputs_check(const FfpModelConfig *config, const FfpInputSource *source, FfpError *err) {
    const FfpCapture *capture = source->capture;
    const FfpInitialisation *start = source->start;
    if (source->views < 1 || source->views > capture->n_views)
        return ffp_fail(err, FFP_ERROR_ARGUMENT, capture->name, "no input views");
    if (!start && (config->residual || config->match_input))
        return ffp_fail(err, FFP_ERROR_ARGUMENT, capture->name,
                        "this model needs the classical initialisation");
    if (source->active < 0 || source->active >= capture->n_patterns)
        return ffp_fail(err, FFP_ERROR_ARGUMENT, capture->name, "no such active pattern");
    const int width = capture->views[0].camera.width, height = capture->views[0].camera.height;
    for (int v = 0; v < source->views; v++) {
        const FfpView *view = &capture->views[v];
        const FfpCamera *camera = &view->camera;
        if (camera->width != width || camera->height != height)
            return ffp_fail(err, FFP_ERROR_ARGUMENT, view->id, "the network needs views of one size");
        if (!check_image(&view->images[capture->black], camera, "black", view, err) ||
            !check_image(&view->images[capture->white], camera, "white", view, err) ||
            !check_image(&view->images[source->active], camera, capture->patterns[source->active].name, view,
                         err))
            return false;
    }
    if (start && (start->width != width || start->height != height))
        return ffp_fail(err, FFP_ERROR_ARGUMENT, capture->name,
                        "the classical initialisation does not have the images' size");
    return true;
}

static real centred(real linear) {
    return 2 * ffp_srgb_encode(linear) - 1;
}

static void start_channels(real *out, const FfpInitialisation *start, int64_t pixel, real nearest) {
    if (start->coverage[pixel] <= 0) {
        for (int i = 0; i < FFP_INITIALISATION_CHANNELS; i++) out[i] = 0;
        return;
    }
    out[0] = start->t[pixel] - nearest;
    out[1] = start->confidence[pixel];
    out[2] = start->lit[pixel];
    out[3] = start->coverage[pixel];
    out[4] = start->agreement[pixel];
    out[5] = start->violation[pixel];
    for (int i = 0; i < 3; i++) {
        out[6 + i] = start->normal[3 * pixel + i];
        out[9 + i] = centred(start->albedo[3 * pixel + i]);
        out[12 + i] = centred(start->ambient[3 * pixel + i]);
    }
}

static void pixel_channels(real *out, const FfpCapture *capture, const FfpView *view, int x, int y,
                           int active) {
    const int shown[3] = {capture->black, capture->white, active};
    for (int k = 0; k < 3; k++) {
        const FfpImage *image = &view->images[shown[k]];
        const real *rgb = image->data + ((size_t)y * image->width + x) * 3;
        for (int i = 0; i < 3; i++) out[3 * k + i] = centred(rgb[i]);
    }
    real *ray = out + RAY_CHANNEL;
    ffp_pixel_ray(&view->camera, x + 0.5F, y + 0.5F, ray);
    const real *pose = view->camera.pose;
    const real origin[3] = {pose[3], pose[7], pose[11]}, nearest = -ffp_dot3(origin, ray);
    for (int i = 0; i < 3; i++) ray[3 + i] = origin[i] + nearest * ray[i];
}

void ffp_pixel_inputs(real *out, const FfpModelConfig *config, const FfpInputSource *source, int64_t pixel) {
    const FfpCamera *first = &source->capture->views[0].camera;
    const int64_t row = pixel / first->width;
    const FfpView *view = &source->capture->views[row / first->height];
    pixel_channels(out, source->capture, view, (int)(pixel % first->width), (int)(row % first->height),
                   source->active);
    if (!config->match_input) return;
    const real *pose = view->camera.pose, origin[3] = {pose[3], pose[7], pose[11]};
    start_channels(out + FFP_PLAIN_CHANNELS, source->start, pixel, -ffp_dot3(origin, out + RAY_CHANNEL));
}

void ffp_inputs(real *out, const FfpModelConfig *config, const FfpInputSource *source) {
    const FfpCamera *camera = &source->capture->views[0].camera;
    const int patch = config->patch, channels = ffp_input_channels(config), across = camera->width / patch;
#pragma omp parallel for schedule(static)
    for (int row = 0; row < source->views * camera->height; row++) {
        for (int x = 0; x < camera->width; x++) { // sides are multiples of the patch: views fall into place
            const int64_t token = (int64_t)(row / patch) * across + x / patch;
            real *pixel = out + ((token * patch + row % patch) * patch + x % patch) * channels;
            ffp_pixel_inputs(pixel, config, source, (int64_t)row * camera->width + x);
        }
    }
}
