#include "match/surface.h"

#include <string.h>
#include <tgmath.h>

#include "base/vec.h"

#define JUMP 3.0F      // a step of more footprints a pixel is a jump (a slant of 72 degrees)
#define RESIDUAL 0.35F // footprints off the plane at which a neighbour counts half
#define SPREAD 0.35F   // neighbours' weight falls as exp(-SPREAD * distance^2 / reach)
#define REGULAR 1e-3F  // share of the weights that holds the slopes at zero where neighbours say nothing

// Normal equations of weighted least squares in (1, dx, dy): upper triangle and right side.
typedef struct Normal {
    double m[6], r[3];
} Normal;

static void add_sample(Normal *n, double w, double dx, double dy, double q) {
    n->m[0] += w, n->m[1] += w * dx, n->m[2] += w * dy;
    n->m[3] += w * dx * dx, n->m[4] += w * dx * dy, n->m[5] += w * dy * dy;
    n->r[0] += w * q, n->r[1] += w * dx * q, n->r[2] += w * dy * q;
}

static void solve(Normal *n, FfpPlane *plane) {
    // q relative to the mean keeps the elimination well-conditioned; the slopes are held towards zero a
    // little.
    const double w = n->m[0], mx = n->m[1] / w, my = n->m[2] / w, mq = n->r[0] / w,
                 hold = (double)REGULAR * w;
    const double a = n->m[3] - w * mx * mx + hold, b = n->m[4] - w * mx * my,
                 c = n->m[5] - w * my * my + hold;
    const double p = n->r[1] - w * mx * mq, q = n->r[2] - w * my * mq, det = a * c - b * b;
    const double sx = (c * p - b * q) / det, sy = (a * q - b * p) / det;
    *plane = (FfpPlane){(real)(mq - sx * mx - sy * my), (real)sx, (real)sy};
}

bool ffp_fit_plane(FfpPlane *plane, const real *depth, const real *weight, const FfpCamera *camera, int x,
                   int y, int reach) {
    const int width = camera->width, height = camera->height;
    const real z0 = depth[(size_t)y * (size_t)width + (size_t)x];
    *plane = (FfpPlane){0, 0, 0};
    if (z0 <= 0) return false;
    *plane = (FfpPlane){1 / z0, 0, 0};
    const real footprint = z0 / camera->fx, unit = footprint / (z0 * z0); // in depth, and in inverse depth
    for (int round = 0; round < 3; round++) {
        Normal normal = {{0}, {0}};
        for (int dy = -reach; dy <= reach; dy++) {
            for (int dx = -reach; dx <= reach; dx++) {
                if (x + dx < 0 || x + dx >= width || y + dy < 0 || y + dy >= height) continue;
                const size_t i = (size_t)(y + dy) * (size_t)width + (size_t)(x + dx);
                if (depth[i] <= 0 || weight[i] <= 0) continue;
                const real distance = (real)(dx * dx + dy * dy);
                if (fabs(depth[i] - z0) > JUMP * footprint * fmax(sqrt(distance), 1)) continue;
                real w = weight[i] * exp(-SPREAD * distance / (real)reach);
                if (round > 0) {
                    const real off =
                        (1 / depth[i] - plane->q0 - plane->qx * dx - plane->qy * dy) / (RESIDUAL * unit);
                    w /= 1 + off * off;
                }
                add_sample(&normal, (double)w, dx, dy, 1 / (double)depth[i]);
            }
        }
        if (normal.m[0] <= 0) return true;
        solve(&normal, plane);
    }
    return true;
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
