#include "match/consistency.h"

#include <stdlib.h>
#include <string.h>
#include <tgmath.h>

#include "base/arena.h"
#include "match/line.h"

#define SLACK 2.0F      // footprints
#define FREE_STEPS 256  // pixel footprints that are tried along a ray
#define FREE_TRUST 0.3F // trust, beyond that of views that agree, that it takes to call a point seen through
#define OUTSIDE 0.2F    // coverage at another view's outline up to which a point counts as outside it,
#define INSIDE 0.6F     // and from which as inside: a surface point on the very outline shows about one half

// How much of a point at (u, v) the silhouette leaves: interpolated coverage, with a soft threshold.
static real share_inside(const FfpImage *coverage, real u, real v) {
    const int x = (int)(u - 0.5F), y = (int)(v - 0.5F);
    const real a = u - 0.5F - (real)x, b = v - 0.5F - (real)y;
    const real *p = coverage->data + (size_t)y * (size_t)coverage->width + (size_t)x,
               *q = p + coverage->width;
    const real shown = (p[0] * (1 - a) + p[1] * a) * (1 - b) + (q[0] * (1 - a) + q[1] * a) * b;
    return fmin(fmax((shown - OUTSIDE) / (INSIDE - OUTSIDE), 0), 1);
}

static void consult_depth(FfpWitness *out, const FfpDepths *depths, int view, int x, int y, real z) {
    const FfpCamera *camera = &depths->capture->views[view].camera;
    const size_t first = (size_t)view * (size_t)depths->height * (size_t)depths->width;
    real low = 0, high = 0, trust = 0;
    for (int n = 0; n < 4; n++) {
        const size_t i = first + (size_t)(y + n / 2) * (size_t)depths->width + (size_t)(x + n % 2);
        if (depths->depth[i] <= 0 || depths->trust[i] <= 0) continue;
        low = low > 0 ? fmin(low, depths->depth[i]) : depths->depth[i];
        high = fmax(high, depths->depth[i]);
        trust = fmax(trust, depths->trust[i]);
    }
    if (high <= 0) return;
    const real slack = SLACK * z / camera->fx;
    if (z < low - slack)
        out->past++, out->trust_past += trust;
    else if (z <= high + slack)
        out->agree++, out->trust_agree += trust;
}

FfpWitness ffp_consult(const FfpDepths *depths, int view, const real point[3]) {
    FfpWitness out = {.coverage = 1};
    for (int other = 0; other < depths->capture->n_views; other++) {
        if (other == view) continue;
        const FfpView *seer = &depths->capture->views[other];
        real u, v;
        const real z = ffp_project(&seer->camera, point, &u, &v);
        if (z <= 0 || u < 0.5F || v < 0.5F || u >= (real)depths->width - 0.5F ||
            v >= (real)depths->height - 0.5F)
            continue;
        const int x = (int)(u - 0.5F), y = (int)(v - 0.5F);
        if (x + 1 >= depths->width || y + 1 >= depths->height) continue;
        out.views++;
        out.coverage = fmin(out.coverage, share_inside(&seer->coverage, u, v));
        consult_depth(&out, depths, other, x, y, z);
    }
    return out;
}

void ffp_reject_inconsistent(FfpDepths *depths) {
    const size_t area = (size_t)depths->width * (size_t)depths->height;
    const int rows = depths->capture->n_views * depths->height;
    real *kept = ffp_alloc(area * (size_t)depths->capture->n_views, sizeof(real));
#pragma omp parallel for schedule(static)
    for (int row = 0; row < rows; row++) {
        const int view = row / depths->height, y = row % depths->height;
        for (int x = 0; x < depths->width; x++) {
            const size_t i = (size_t)row * (size_t)depths->width + (size_t)x;
            if (depths->trust[i] <= 0) continue;
            real point[3];
            ffp_point_at(&depths->capture->views[view].camera, (real)x + 0.5F, (real)y + 0.5F,
                         depths->depth[i], point);
            const FfpWitness witness = ffp_consult(depths, view, point);
            const bool refuted =
                witness.trust_past > depths->trust[i] + witness.trust_agree || witness.coverage <= 0;
            kept[i] = refuted ? 0 : depths->trust[i];
        }
    }
    memcpy(depths->trust, kept, area * (size_t)depths->capture->n_views * sizeof(real));
    free(kept);
}

void ffp_free_space(real *range, const FfpDepths *depths) {
#pragma omp parallel for schedule(static)
    for (int row = 0; row < depths->capture->n_views * depths->height; row++) {
        const int view = row / depths->height, y = row % depths->height;
        const FfpView *self = &depths->capture->views[view];
        for (int x = 0; x < depths->width; x++) {
            const size_t i = (size_t)row * (size_t)depths->width + (size_t)x;
            if (depths->trust[i] > 0 ||
                self->coverage.data[(size_t)y * (size_t)depths->width + (size_t)x] <= 0)
                continue;
            real z = range[2 * i];
            for (int step = 0; step < FREE_STEPS && z < range[2 * i + 1]; step++) {
                real point[3];
                ffp_point_at(&self->camera, (real)x + 0.5F, (real)y + 0.5F, z, point);
                const FfpWitness witness = ffp_consult(depths, view, point);
                if (witness.trust_past <= FREE_TRUST + witness.trust_agree) break;
                z += z / self->camera.fx;
            }
            range[2 * i] = fmin(z, range[2 * i + 1]);
        }
    }
}
