#include "match/beams.h"

#include <stdlib.h>
#include <tgmath.h>

#include "base/arena.h"
#include "match/line.h"
#include "match/observe.h"

static void widen(FfpHeard *to, const FfpHeard *by) {
    if (by->high <= 0) return;
    to->low = to->low > 0 ? fmin(to->low, by->low) : by->low;
    to->high = fmax(to->high, by->high);
    to->trust = fmax(to->trust, by->trust);
}

static bool cell_of(const FfpBeams *beams, real u, real v, size_t *cell) {
    if (!(u >= 0 && v >= 0 && u < (real)beams->width && v < (real)beams->height)) return false;
    *cell = (size_t)v * (size_t)beams->width + (size_t)u;
    return true;
}

// The least and greatest depth of the points of each cell.
static void gather(const FfpBeams *beams, FfpHeard *cells, const FfpDepths *depths, int view) {
    const FfpView *self = &depths->capture->views[view];
    size_t i = (size_t)view * (size_t)depths->width * (size_t)depths->height, cell;
    for (int y = 0; y < depths->height; y++) {
        for (int x = 0; x < depths->width; x++, i++) {
            if (depths->trust[i] <= 0 || depths->depth[i] <= 0) continue;
            real point[3], u, v;
            ffp_point_at(&self->camera, (real)x + 0.5F, (real)y + 0.5F, depths->depth[i], point);
            const real z = ffp_project(&self->projector, point, &u, &v);
            if (z > 0 && cell_of(beams, u * beams->scale, v * beams->scale, &cell))
                widen(&cells[cell], &(FfpHeard){z, z, depths->trust[i]});
        }
    }
}

FfpBeams ffp_beams_new(const FfpDepths *depths, int view) {
    const FfpCamera *projector = &depths->capture->views[view].projector;
    const real box = ffp_typical_footprint(depths->capture, view);
    FfpBeams out = {(int)((real)projector->width / box) + 1, (int)((real)projector->height / box) + 1,
                    1 / box, NULL};
    const size_t width = (size_t)out.width, count = width * (size_t)out.height;
    FfpHeard *cells = ffp_alloc(count, sizeof *cells);
    gather(&out, cells, depths, view);
    out.heard = ffp_alloc(count, sizeof *out.heard);
    for (size_t i = 0; i + width + 1 < count; i++) {
        const size_t around[4] = {i, i + 1, i + width, i + width + 1};
        for (int n = 0; n < 4 && (i + 1) % width > 0; n++) widen(&out.heard[i], &cells[around[n]]);
    }
    free(cells);
    return out;
}

void ffp_beams_free(FfpBeams *beams) {
    free(beams->heard);
    *beams = (FfpBeams){0};
}

FfpHeard ffp_beams_at(const FfpBeams *beams, real u, real v) {
    size_t cell;
    if (!cell_of(beams, u * beams->scale - 0.5F, v * beams->scale - 0.5F, &cell)) return (FfpHeard){0, 0, 0};
    return beams->heard[cell];
}
