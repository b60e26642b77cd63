// A camera's correspondences, inverted: cells of four neighbouring pixels are drawn into the projector.
#include <stdlib.h>
#include <tgmath.h>
#include "core/base/arena.h"
#include "engine/apply/stage.h"
#include "engine/apply/surface.h"

typedef struct Corner {
    real u, v, z; // in the projector; z 0: nothing there
    real x, y;    // in the camera
} Corner;

static Corner corner_at(const FfpCameraView *camera_view, const FfpLink *link, const FfpCamera *projector,
                        int x, int y) {
    const FfpCamera *camera = &camera_view->view->camera;
    const int p = y * camera->width + x;
    const real *response = link->response.data + 3 * p, z = camera_view->depth.data[p];
    Corner corner = {.x = (real)x + 0.5F, .y = (real)y + 0.5F};
    if (!(z > 0) || !(link->mapping.visibility[p] >= 0.5F) ||
        !(response[0] > 0 || response[1] > 0 || response[2] > 0))
        return corner;
    real ray[3], point[3];
    const real along = ffp_pixel_ray(camera, corner.x, corner.y, ray);
    for (int k = 0; k < 3; k++) point[k] = camera->pose[4 * k + 3] + z / along * ray[k];
    corner.z = ffp_project(projector, point, &corner.u, &corner.v);
    return corner;
}

// Twice the signed area of the triangle a b (u,v).
static real area(const Corner *a, const Corner *b, real u, real v) {
    return (b->u - a->u) * (v - a->v) - (b->v - a->v) * (u - a->u);
}

static int first_pixel(real low) {
    return low > 0 ? (int)floor(low) : 0;
}

static int end_pixel(real high, int size) {
    return high < (real)size ? (int)floor(high) + 1 : size;
}

static void draw_triangle(FfpImage *out, const Corner *a, const Corner *b, const Corner *c) {
    const real whole = area(a, b, c->u, c->v);
    if (!(fabs(whole) > 0)) return;
    const int x0 = first_pixel(fmin(a->u, fmin(b->u, c->u))), y0 = first_pixel(fmin(a->v, fmin(b->v, c->v)));
    const int x1 = end_pixel(fmax(a->u, fmax(b->u, c->u)), out->width),
              y1 = end_pixel(fmax(a->v, fmax(b->v, c->v)), out->height);
    for (int y = y0; y < y1; y++)
        for (int x = x0; x < x1; x++) {
            const real u = (real)x + 0.5F, v = (real)y + 0.5F;
            const real wa = area(b, c, u, v) / whole, wb = area(c, a, u, v) / whole, wc = 1 - wa - wb;
            if (wa < 0 || wb < 0 || wc < -1e-5F) continue;
            real *pixel = out->data + 3 * ((size_t)y * (size_t)out->width + (size_t)x);
            const real z = wa * a->z + wb * b->z + wc * c->z;
            if (pixel[2] > 0 && pixel[2] <= z) continue;
            pixel[0] = wa * a->x + wb * b->x + wc * c->x;
            pixel[1] = wa * a->y + wb * b->y + wc * c->y;
            pixel[2] = z;
        }
}

// One surface, as far as the depths of its corners tell.
static bool is_whole(const FfpCameraView *camera_view, int x, int y, const Corner cell[4]) {
    const FfpCamera *camera = &camera_view->view->camera;
    const real *depth = camera_view->depth.data + (size_t)y * (size_t)camera->width + (size_t)x;
    real near = INFINITY, far = 0;
    for (int k = 0; k < 4; k++) {
        if (!(cell[k].z > 0)) return false;
        const real z = depth[(k >> 1) * camera->width + (k & 1)];
        near = fmin(near, z);
        far = fmax(far, z);
    }
    return far - near <= ffp_depth_jump(camera, far);
}

FfpImage ffp_stage_inverse(const FfpStage *stage, int camera_view_index, int projection) {
    const FfpCameraView *camera_view = &stage->camera_views[camera_view_index];
    const FfpLink *link = ffp_stage_link(stage, camera_view_index, projection);
    const FfpCamera *camera = &camera_view->view->camera,
                    *projector = &stage->projections[projection].view->projector;
    const int width = camera->width, height = camera->height;
    FfpImage out = ffp_image_new(projector->width, projector->height, 3);
    for (int p = 0; p < out.width * out.height; p++) out.data[3 * p] = out.data[3 * p + 1] = -1;
    Corner *corners = ffp_alloc((size_t)width * (size_t)height, sizeof *corners);
#pragma omp parallel for schedule(static)
    for (int y = 0; y < height; y++)
        for (int x = 0; x < width; x++)
            corners[y * width + x] = corner_at(camera_view, link, projector, x, y);
    for (int y = 0; y + 1 < height; y++)
        for (int x = 0; x + 1 < width; x++) {
            const Corner *at = corners + y * width + x;
            const Corner cell[4] = {at[0], at[1], at[width], at[width + 1]};
            if (!is_whole(camera_view, x, y, cell)) continue;
            draw_triangle(&out, &cell[0], &cell[1], &cell[2]);
            draw_triangle(&out, &cell[1], &cell[3], &cell[2]);
        }
    ffp_free(corners);
    return out;
}
