#include "core/capture/panel.h"
#include <math.h>

#define SAMPLES_MAX 64 // a side of a panel's pixel

void ffp_panel_describe(FfpPanel *panel, const FfpOptics *optics) {
    panel->known = true;
    panel->width = optics->width;
    panel->height = optics->height;
    panel->fx = (real)optics->fx;
    panel->fy = (real)optics->fy;
    panel->cx = (real)optics->cx;
    panel->cy = (real)optics->cy;
    for (int i = 0; i < 5; i++) panel->lens[i] = (real)optics->lens[i];
}

void ffp_panel_soften(const FfpPanel *panel, FfpImage *picture) {
    ffp_image_blur(picture, panel->blur);
    ffp_image_spread(picture, panel->spread, panel->spread_reach);
}

static FfpOptics optics_of(const FfpPanel *panel) {
    FfpOptics optics = {.width = panel->width,
                        .height = panel->height,
                        .fx = (double)panel->fx,
                        .fy = (double)panel->fy,
                        .cx = (double)panel->cx,
                        .cy = (double)panel->cy};
    for (int i = 0; i < 5; i++) optics.lens[i] = (double)panel->lens[i];
    return optics;
}

static int samples_across(double panel_focal, double ideal_focal) {
    const double span = ceil(ideal_focal / panel_focal - 1e-6);
    return span < 1 ? 1 : span > SAMPLES_MAX ? SAMPLES_MAX : (int)span;
}

// Adds the pattern's light where the panel's place (u, v) sends its ray.
static void add_sample(const FfpOptics *optics, const FfpCamera *ideal, const FfpImage *pattern, double u,
                       double v, double sum[3]) {
    double ray[2];
    real value[4];
    if (!ffp_lens_undistort(optics->lens, (u - optics->cx) / optics->fx, (v - optics->cy) / optics->fy, ray))
        return;
    const double x = (double)ideal->cx + (double)ideal->fx * ray[0],
                 y = (double)ideal->cy + (double)ideal->fy * ray[1];
    if (!(x >= 0 && y >= 0 && x <= pattern->width && y <= pattern->height)) return;
    ffp_image_sample(pattern, (real)x, (real)y, value);
    for (int c = 0; c < 3; c++) sum[c] += (double)value[c];
}

// The value that makes this light, as the linear number that sRGB encodes as it.
static real value_for(const FfpPanel *panel, int channel, double light) {
    const double within = light < 0 ? 0 : light > 1 ? 1 : light;
    if (!panel->power) return (real)within;
    return ffp_srgb_decode((real)pow(within, 1 / (double)panel->gamma[channel]));
}

bool ffp_panel_picture(FfpImage *out, const FfpPanel *panel, const FfpCamera *ideal, const FfpImage *pattern,
                       const char *where, FfpError *err) {
    const FfpOptics optics = optics_of(panel);
    if (!ffp_optics_check(&optics, where, err)) return false;
    *out = ffp_image_new(panel->width, panel->height, 3);
    const int across = samples_across(optics.fx, (double)ideal->fx);
    const int down = samples_across(optics.fy, (double)ideal->fy);
#pragma omp parallel for schedule(static)
    for (int row = 0; row < out->height; row++) {
        for (int column = 0; column < out->width; column++) {
            double sum[3] = {0};
            for (int k = 0; k < across * down; k++) {
                const double x = column + (k % across + 0.5) / across, y = row + (k / across + 0.5) / down;
                add_sample(&optics, ideal, pattern, x, y, sum);
            }
            real *to = out->data + ((size_t)row * (size_t)out->width + (size_t)column) * 3;
            for (int c = 0; c < 3; c++) to[c] = value_for(panel, c, sum[c] / (across * down));
        }
    }
    return true;
}
