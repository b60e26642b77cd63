// The visual hull: where all silhouettes allow the object to be.
#include <stdlib.h>
#include <string.h>
#include <tgmath.h>
#include "core/base/arena.h"
#include "engine/match/consistency.h"
#include "engine/match/line.h"
#include "engine/match/sweep.h"

unsigned char *ffp_hull_widened(const FfpView *view) {
    const FfpImage *coverage = &view->coverage;
    const size_t width = (size_t)ffp_frame_width(view), height = (size_t)ffp_frame_height(view),
                 stride = (size_t)coverage->width, area = width * height;
    unsigned char *tall = ffp_alloc(area, 1), *wide = ffp_alloc(area + 1, 1);
    for (size_t y = 0; y < height; y++) {
        const real *row = coverage->data + y * stride, *above = y > 0 ? row - stride : row,
                   *below = y + 1 < height ? row + stride : row;
        for (size_t x = 0; x < width; x++)
            tall[y * width + x] = (row[x] > 0) | (above[x] > 0) | (below[x] > 0);
    }
    for (size_t i = 1; i + 1 < area; i++) wide[i] = tall[i - 1] | tall[i] | tall[i + 1];
    for (size_t y = 0; y < height; y++) wide[y * width] = wide[y * width + width - 1] = 1;
    memset(wide, 1, width);
    memset(wide + area - width, 1, width + 1);
    ffp_free(tall);
    return wide;
}

// Takes away the hypotheses of a pixel, of which `seer` shows none at 0 of `wide`.
static void cut(unsigned char *inside, const unsigned char *wide, const FfpView *seer, const FfpLine *line,
                const FfpPlanes *planes) {
    const int width = ffp_frame_width(seer), height = ffp_frame_height(seer), outside = width * height;
    for (int k = 0; k < planes->count; k += FFP_MATCH_LANES) {
        const int lanes = planes->count - k < FFP_MATCH_LANES ? planes->count - k : FFP_MATCH_LANES;
        if (memchr(inside + k, 1, (size_t)lanes) == NULL) continue;
        real u[FFP_MATCH_LANES], v[FFP_MATCH_LANES];
        int cell[FFP_MATCH_LANES];
        ffp_line_positions(line, planes->first, planes->step, k, u, v);
        for (int n = 0; n < FFP_MATCH_LANES; n++) {
            const bool in = (u[n] >= 0) & (v[n] >= 0) & (u[n] < (real)width) & (v[n] < (real)height);
            const int x = (int)(in ? u[n] : 0), y = (int)(in ? v[n] : 0);
            cell[n] = in ? y * width + x : outside;
        }
        for (int n = 0; n < lanes; n++) inside[k + n] &= wide[cell[n]];
    }
}

void ffp_hull(unsigned char *inside, const FfpCapture *capture, int view, const FfpForeground *foreground,
              const FfpPlanes *planes) {
    const FfpCamera *camera = &capture->views[view].camera;
    const size_t width = (size_t)foreground->width, count = (size_t)planes->count;
    memset(inside, 1, foreground->count * count);
    const FfpAsked asked = ffp_asked(capture, view);
    for (int k = 0; k < asked.count; k++) {
        const int other = asked.view[k];
        if (other == view) continue;
        const FfpView *seer = &capture->views[other];
        unsigned char *wide = ffp_hull_widened(seer);
        for (size_t slot = 0; slot < foreground->count; slot++) {
            const real x = (real)(foreground->pixel[slot] % width) + 0.5F,
                       y = (real)(foreground->pixel[slot] / width) + 0.5F;
            const FfpLine line = ffp_line(camera, x, y, &seer->camera);
            cut(inside + slot * count, wide, seer, &line, planes);
        }
        ffp_free(wide);
    }
}

static void pixel_range(real range[2], const unsigned char *inside, const FfpPlanes *planes) {
    const unsigned char *near = memchr(inside, 1, (size_t)planes->count);
    int first = 0, last = planes->count - 1;
    if (near) {
        first = (int)(near - inside);
        while (!inside[last]) last--;
    }
    range[0] = planes->first + (real)first * planes->step;
    range[1] = planes->first + (real)last * planes->step;
}

void ffp_hull_range(real *range, const unsigned char *inside, const FfpForeground *foreground,
                    const FfpPlanes *planes) {
    const size_t area = (size_t)foreground->width * (size_t)foreground->height;
    const real first = planes->first, last = first + (real)(planes->count - 1) * planes->step;
    for (size_t i = 0; i < area; i++) {
        range[2 * i] = first;
        range[2 * i + 1] = last;
    }
    for (size_t slot = 0; slot < foreground->count; slot++)
        pixel_range(range + 2 * foreground->pixel[slot], inside + slot * (size_t)planes->count, planes);
}

void ffp_hull_ranges(real *range, const FfpCapture *capture, int view) {
    const FfpMatchSettings settings = ffp_match_defaults();
    const FfpPlanes planes = ffp_planes(capture, view, &settings);
    FfpForeground foreground = ffp_foreground_new(&capture->views[view].coverage);
    unsigned char *inside = ffp_alloc(foreground.count * (size_t)planes.count, 1);
    ffp_hull(inside, capture, view, &foreground, &planes);
    ffp_hull_range(range, inside, &foreground, &planes);
    ffp_free(inside);
    ffp_foreground_free(&foreground);
}
