// The visual hull: where all silhouettes allow the object to be.
#include <stdlib.h>
#include <string.h>
#include <tgmath.h>

#include "base/arena.h"
#include "match/line.h"
#include "match/sweep.h"

// 1 where any coverage is within a pixel, and around the picture's edge: [h,w].
static unsigned char *widen(const FfpImage *coverage) {
    const int width = coverage->width, height = coverage->height;
    unsigned char *wide = ffp_alloc((size_t)width * (size_t)height, 1);
    for (int y = 0; y < height; y++) {
        for (int x = 0; x < width; x++) {
            bool any = x == 0 || y == 0 || x == width - 1 || y == height - 1;
            for (int j = y - 1; !any && j <= y + 1; j++)
                for (int i = x - 1; i <= x + 1; i++)
                    any = any || coverage->data[(size_t)j * (size_t)width + (size_t)i] > 0;
            wide[(size_t)y * (size_t)width + (size_t)x] = any;
        }
    }
    return wide;
}

static void cut(unsigned char *inside, const unsigned char *wide, const FfpCamera *seer, const FfpLine *line,
                const FfpPlanes *planes) {
    for (int k = 0; k < planes->count; k++) {
        real u = -1, v = -1;
        ffp_line_at(line, planes->first + (real)k * planes->step, &u, &v);
        if (u < 0 || v < 0 || u >= (real)seer->width || v >= (real)seer->height) continue;
        inside[k] &= wide[(size_t)v * (size_t)seer->width + (size_t)u];
    }
}

void ffp_hull(unsigned char *inside, const FfpCapture *capture, int view, const FfpPlanes *planes) {
    const FfpView *self = &capture->views[view];
    const size_t pixels = (size_t)self->camera.width * (size_t)self->camera.height,
                 count = (size_t)planes->count;
    for (size_t i = 0; i < pixels; i++) memset(inside + i * count, self->coverage.data[i] > 0, count);
    for (int other = 0; other < capture->n_views; other++) {
        if (other == view) continue;
        const FfpView *seer = &capture->views[other];
        unsigned char *wide = widen(&seer->coverage);
        for (size_t i = 0; i < pixels; i++) {
            if (self->coverage.data[i] <= 0) continue;
            const size_t column = i % (size_t)self->camera.width, row = i / (size_t)self->camera.width;
            const real x = (real)column + 0.5F, y = (real)row + 0.5F;
            const FfpLine line = ffp_line(&self->camera, x, y, &seer->camera);
            cut(inside + i * count, wide, &seer->camera, &line, planes);
        }
        free(wide);
    }
}

void ffp_hull_range(real range[2], const unsigned char *inside, const FfpPlanes *planes) {
    int first = 0, last = planes->count - 1;
    while (first < planes->count && !inside[first]) first++;
    if (first == planes->count)
        first = 0;
    else
        while (!inside[last]) last--;
    range[0] = planes->first + (real)first * planes->step;
    range[1] = planes->first + (real)last * planes->step;
}

void ffp_hull_ranges(real *range, const FfpCapture *capture, int view) {
    const FfpMatchSettings settings = ffp_match_defaults();
    const FfpPlanes planes = ffp_planes(capture, view, &settings);
    const FfpCamera *camera = &capture->views[view].camera;
    const size_t pixels = (size_t)camera->width * (size_t)camera->height, count = (size_t)planes.count;
    unsigned char *inside = ffp_alloc(pixels * count, 1);
    ffp_hull(inside, capture, view, &planes);
    for (size_t i = 0; i < pixels; i++) ffp_hull_range(range + 2 * i, inside + i * count, &planes);
    free(inside);
}
