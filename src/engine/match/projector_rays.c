#include "engine/match/projector_rays.h"
#include <stdlib.h>
#include <tgmath.h>
#include "core/base/arena.h"
#include "engine/match/line.h"
#include "engine/match/observe.h"

static void widen(FfpDepthBounds *to, const FfpDepthBounds *by) {
    if (by->high <= 0) return;
    to->low = to->low > 0 ? fmin(to->low, by->low) : by->low;
    to->high = fmax(to->high, by->high);
    to->trust = fmax(to->trust, by->trust);
}

// The least and greatest depth of the points of each cell.
static void gather(const FfpProjectorRays *projector_rays, FfpDepthBounds *cells, const FfpDepths *depths,
                   int view) {
    const FfpView *self = &depths->capture->views[view];
    size_t i = (size_t)view * (size_t)depths->width * (size_t)depths->height, cell;
    for (int y = 0; y < depths->height; y++) {
        for (int x = 0; x < depths->width; x++, i++) {
            if (depths->trust[i] <= 0 || depths->depth[i] <= 0) continue;
            real point[3], u, v;
            ffp_point_at(&self->camera, (real)x + 0.5F, (real)y + 0.5F, depths->depth[i], point);
            const real z = ffp_project(&self->projector, point, &u, &v);
            if (z > 0 && ffp_projector_rays_cell(projector_rays, u * projector_rays->scale,
                                                 v * projector_rays->scale, &cell))
                widen(&cells[cell], &(FfpDepthBounds){z, z, depths->trust[i]});
        }
    }
}

FfpProjectorRays ffp_projector_rays_new(const FfpDepths *depths, int view) {
    const FfpCamera *projector = &depths->capture->views[view].projector;
    const real box = ffp_typical_footprint(depths->capture, view);
    FfpProjectorRays out = {(int)((real)projector->width / box) + 1, (int)((real)projector->height / box) + 1,
                            1 / box, NULL};
    const size_t width = (size_t)out.width, count = width * (size_t)out.height;
    FfpDepthBounds *cells = ffp_alloc(count, sizeof *cells);
    gather(&out, cells, depths, view);
    out.bounds = ffp_alloc(count, sizeof *out.bounds);
    for (size_t i = 0; i + width + 1 < count; i++) {
        const size_t around[4] = {i, i + 1, i + width, i + width + 1};
        for (int n = 0; n < 4 && (i + 1) % width > 0; n++) widen(&out.bounds[i], &cells[around[n]]);
    }
    ffp_free(cells);
    return out;
}

void ffp_projector_rays_free(FfpProjectorRays *projector_rays) {
    ffp_free(projector_rays->bounds);
    *projector_rays = (FfpProjectorRays){0};
}
