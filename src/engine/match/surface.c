#include "engine/match/surface.h"
#include <stdbool.h>
#include <stdlib.h>
#include <tgmath.h>
#include "core/base/arena.h"
#include "core/base/vec.h"
#include "engine/match/kernels/kernels.h"

#define JUMP 3.0F    // a step of more footprints a pixel is a jump (a slant of 72 degrees)
#define SPREAD 0.35F // neighbours' weight falls as exp(-SPREAD * distance^2 / reach)

void ffp_sheet_neighbours(FfpSheet *sheet) {
    const int reach = sheet->reach, side = 2 * reach + 1;
    sheet->nearness = ffp_alloc((size_t)side * (size_t)side, sizeof(real));
    sheet->jump = ffp_alloc((size_t)side * (size_t)side, sizeof(real));
    for (int n = 0; n < side * side; n++) {
        const int dx = n % side - reach, dy = n / side - reach;
        const real distance = (real)(dx * dx + dy * dy);
        sheet->nearness[n] = exp(-SPREAD * distance / (real)reach);
        sheet->jump[n] = JUMP * fmax(sqrt(distance), 1);
    }
}

FfpSheet ffp_sheet_new(const real *depth, const real *weight, const FfpCamera *camera, int reach) {
    FfpSheet out = {.width = camera->width, .height = camera->height, .reach = reach, .focal = camera->fx};
    out.stride = camera->width + 2 * reach + FFP_MATCH_LANES; // the last lanes may begin at the last pixel
    const size_t cells = (size_t)out.stride * (size_t)(camera->height + 2 * reach);
    out.depth = ffp_alloc(cells, sizeof(real));
    out.inverse = ffp_alloc(cells, sizeof(real));
    out.weight = ffp_alloc(cells, sizeof(real));
    for (int y = 0; y < camera->height; y++) {
        const size_t from = (size_t)y * (size_t)camera->width,
                     to = (size_t)(y + reach) * (size_t)out.stride + (size_t)reach;
        for (size_t x = 0; x < (size_t)camera->width; x++) {
            const real z = depth[from + x] > 0 ? depth[from + x] : 0;
            out.depth[to + x] = z;
            out.inverse[to + x] = z > 0 ? 1 / z : 0;
            out.weight[to + x] = z > 0 && weight[from + x] > 0 ? weight[from + x] : 0;
        }
    }
    ffp_sheet_neighbours(&out);
    return out;
}

void ffp_sheet_free(FfpSheet *sheet) {
    ffp_free(sheet->depth);
    ffp_free(sheet->inverse);
    ffp_free(sheet->weight);
    ffp_free(sheet->nearness);
    ffp_free(sheet->jump);
    *sheet = (FfpSheet){0};
}

void ffp_fit_planes(FfpPlane planes[FFP_MATCH_LANES], const FfpSheet *sheet, int x, int y) {
    ffp_match_kernels()->fit_planes(planes, sheet, x, y);
}

void ffp_plane_normal(const FfpPlane *plane, const FfpCamera *camera, real x, real y, real normal[3]) {
    // n . X = 1 on the plane and X = z K^-1 (x, y, 1), so q = n . K^-1 (x, y, 1): read n off q's
    // coefficients. It points away from the camera.
    const real nx = plane->qx * camera->fx, ny = plane->qy * camera->fy;
    const real nz = plane->q0 - (nx * (x - camera->cx) / camera->fx + ny * (y - camera->cy) / camera->fy);
    real local[3] = {-nx, -ny, -nz};
    ffp_normalise3(local);
    ffp_rotate(camera->pose, local, normal);
}
