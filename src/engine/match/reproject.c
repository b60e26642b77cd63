#include <stdlib.h>
#include <tgmath.h>
#include "core/base/arena.h"
#include "engine/match/fill.h"
#include "engine/match/line.h"

#define LAYER 2.0F  // footprints behind the nearest point within which points are the same surface
#define FACING 0.1F // least cosine between a point's normal and the direction to the camera
#define REACH 0.75F // pixels to each side that a point covers

typedef struct Arrival { // a point in the receiving view
    real u, v, z, weight;
} Arrival;

// Projects the trusted points of `giver` that face the camera into it.
static size_t project_points(Arrival *to, const FfpDepths *depths, const real *normals, int giver,
                             const FfpCamera *camera) {
    const FfpCamera *from = &depths->capture->views[giver].camera;
    const real eye[3] = {camera->pose[3], camera->pose[7], camera->pose[11]};
    size_t count = 0, i = (size_t)giver * (size_t)depths->width * (size_t)depths->height;
    for (int y = 0; y < depths->height; y++) {
        for (int x = 0; x < depths->width; x++, i++) {
            if (depths->trust[i] <= 0 || depths->depth[i] <= 0) continue;
            real point[3], u, v;
            ffp_point_at(from, (real)x + 0.5F, (real)y + 0.5F, depths->depth[i], point);
            real back[3] = {eye[0] - point[0], eye[1] - point[1], eye[2] - point[2]};
            ffp_normalise3(back);
            const real facing = ffp_dot3(normals + 3 * i, back), z = ffp_project(camera, point, &u, &v);
            if (z > 0 && facing > FACING) to[count++] = (Arrival){u, v, z, depths->trust[i] * facing};
        }
    }
    return count;
}

typedef struct Layer {     // the nearest surface's points that fell on each pixel without depth of its own
    int width, right, low; // pixels a row; the frame that the camera saw
    const real *trust;
    real *nearest, *sum, *weight;
} Layer;

static void put(Layer *layer, const Arrival *point, real slack, bool only_nearest) {
    const int left = (int)ceil(point->u - 0.5F - REACH), right = (int)floor(point->u - 0.5F + REACH);
    const int top = (int)ceil(point->v - 0.5F - REACH), bottom = (int)floor(point->v - 0.5F + REACH);
    for (int y = top > 0 ? top : 0; y <= bottom && y < layer->low; y++) {
        for (int x = left > 0 ? left : 0; x <= right && x < layer->right; x++) {
            const size_t i = (size_t)y * (size_t)layer->width + (size_t)x;
            if (layer->trust[i] > 0) continue;
            if (only_nearest) {
                if (layer->nearest[i] <= 0 || point->z < layer->nearest[i]) layer->nearest[i] = point->z;
            } else if (point->z <= layer->nearest[i] + slack) {
                const real du = point->u - 0.5F - (real)x, dv = point->v - 0.5F - (real)y;
                const real w = point->weight * exp(-2 * (du * du + dv * dv));
                layer->sum[i] += w * point->z;
                layer->weight[i] += w;
            }
        }
    }
}

void ffp_fill_from_others(real *out, const FfpDepths *depths, const real *normals, int view) {
    const FfpCamera *camera = &depths->capture->views[view].camera;
    const size_t area = (size_t)depths->width * (size_t)depths->height;
    const FfpAsked asked = ffp_asked(depths->capture, view);
    Arrival *points = ffp_alloc(area * (size_t)asked.count, sizeof *points);
    size_t count = 0;
    for (int k = 0; k < asked.count; k++)
        if (asked.view[k] != view)
            count += project_points(points + count, depths, normals, asked.view[k], camera);
    const real *depth = depths->depth + (size_t)view * area, *trust = depths->trust + (size_t)view * area;
    Layer layer = {depths->width,
                   ffp_frame_width(&depths->capture->views[view]),
                   ffp_frame_height(&depths->capture->views[view]),
                   trust,
                   ffp_alloc(area, sizeof(real)),
                   ffp_alloc(area, sizeof(real)),
                   ffp_alloc(area, sizeof(real))};
    for (size_t k = 0; k < count; k++) put(&layer, &points[k], 0, true);
    for (size_t k = 0; k < count; k++) put(&layer, &points[k], LAYER * points[k].z / camera->fx, false);
    for (size_t i = 0; i < area; i++)
        out[i] = trust[i] > 0 ? depth[i] : layer.weight[i] > 0 ? layer.sum[i] / layer.weight[i] : 0;
    ffp_free(points);
    ffp_free(layer.nearest);
    ffp_free(layer.sum);
    ffp_free(layer.weight);
}
