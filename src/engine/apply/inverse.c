// A camera's correspondences, inverted: cells of four neighbouring pixels are drawn into the projector.
#include <stdlib.h>
#include <tgmath.h>
#include "core/base/arena.h"
#include "engine/apply/procams.h"
#include "engine/apply/surface.h"

typedef struct Corner {
    real u, v, z; // in the projector; z 0: nothing there
    real x, y;    // in the camera
} Corner;

static Corner corner_at(const FfpImage *lit, const FfpCamera *camera, const FfpCamera *projector, int x,
                        int y) {
    const real z = lit->data[(size_t)y * (size_t)lit->width + (size_t)x];
    Corner corner = {.x = (real)x + 0.5F, .y = (real)y + 0.5F};
    if (!(z > 0)) return corner;
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
static bool is_whole(const FfpImage *lit, const FfpCamera *camera, int x, int y, const Corner cell[4]) {
    const real *depth = lit->data + (size_t)y * (size_t)lit->width + (size_t)x;
    real near = INFINITY, far = 0;
    for (int k = 0; k < 4; k++) {
        if (!(cell[k].z > 0)) return false;
        const real z = depth[(k >> 1) * lit->width + (k & 1)];
        near = fmin(near, z);
        far = fmax(far, z);
    }
    return far - near <= ffp_depth_jump(camera, far);
}

FfpImage ffp_procams_lit_depth(const FfpProCams *procams, int camera_view, int projection) {
    const FfpImage *depth = &procams->camera_views[camera_view].depth;
    const FfpLink *link = ffp_procams_link(procams, camera_view, projection);
    const size_t pixels = (size_t)depth->width * (size_t)depth->height;
    FfpImage lit = ffp_image_new(depth->width, depth->height, 1);
#pragma omp parallel for schedule(static)
    for (size_t p = 0; p < pixels; p++) {
        const real *response = link->response.data + 3 * p;
        if (link->mapping.visibility[p] >= 0.5F && (response[0] > 0 || response[1] > 0 || response[2] > 0))
            lit.data[p] = depth->data[p];
    }
    return lit;
}

FfpImage ffp_inverse_new(const FfpCamera *projector) {
    FfpImage out = ffp_image_new(projector->width, projector->height, 3);
    const size_t pixels = (size_t)out.width * (size_t)out.height;
    for (size_t p = 0; p < pixels; p++) out.data[3 * p] = out.data[3 * p + 1] = -1;
    return out;
}

// A row of corners, in the whole picture's pixels.
static void fill_corners(Corner *corners, const FfpImage *lit, const FfpCamera *camera,
                         const FfpCamera *projector, int y, int top) {
#pragma omp parallel for schedule(static)
    for (int x = 0; x < lit->width; x++) {
        corners[x] = corner_at(lit, camera, projector, x, y);
        corners[x].y += (real)top;
    }
}

void ffp_inverse_draw(FfpImage *inverse, const FfpImage *lit, const FfpCamera *camera,
                      const FfpCamera *projector, int top) {
    const size_t width = (size_t)lit->width;
    Corner *corners = ffp_alloc(2 * width, sizeof *corners), *above = corners, *below = corners + width;
    fill_corners(above, lit, camera, projector, 0, top);
    for (int y = 0; y + 1 < lit->height; y++) {
        fill_corners(below, lit, camera, projector, y + 1, top);
        for (int x = 0; x + 1 < lit->width; x++) {
            const Corner cell[4] = {above[x], above[x + 1], below[x], below[x + 1]};
            if (!is_whole(lit, camera, x, y, cell)) continue;
            draw_triangle(inverse, &cell[0], &cell[1], &cell[2]);
            draw_triangle(inverse, &cell[1], &cell[3], &cell[2]);
        }
        Corner *const done = above;
        above = below;
        below = done;
    }
    ffp_free(corners);
}

FfpImage ffp_procams_inverse(const FfpProCams *procams, int camera_view, int projection) {
    const FfpCamera *projector = &procams->projections[projection].view->projector;
    FfpImage lit = ffp_procams_lit_depth(procams, camera_view, projection), out = ffp_inverse_new(projector);
    ffp_inverse_draw(&out, &lit, &procams->camera_views[camera_view].view->camera, projector, 0);
    ffp_image_free(&lit);
    return out;
}
