// Everything between a Gaussian and its shadow on the image plane, for one vector of Gaussians.
#ifndef FFP_RENDER_KERNELS_FRAME_H
#define FFP_RENDER_KERNELS_FRAME_H

#include "engine/render/kernels/kernels.h"
#include "engine/render/kernels/lanes.h"

enum { BATCH = 64, GROUPS = BATCH / LANES };

// One number of every Gaussian of a batch.
typedef union Column {
    Lanes group[GROUPS];
    real at[BATCH];
} Column;

// Gaussians side by side. Behind the last of them stands anything finite.
typedef struct Batch {
    int count;
    int64_t index[BATCH];
    Column centre[3], scale[3], rotation[4], opacity;
} Batch;

// M M^T = covariance before the blur.
typedef struct Frame {
    Where drawn;            // in front of the camera, and all numbers sane
    Lanes q[4], per_length; // unit quaternion, and 1 / the given one's length
    Lanes R[9];             // splat axes to world
    Lanes K[9];             // splat axes to camera
    Lanes scale[3];         // as given
    Lanes t[3], per_z;      // centre in the camera's frame, 1 / t[2]
    Lanes slope_x, slope_y; // t[0] / z, t[1] / z, held inside the field of view for the Jacobian's sake
    Where held_x, held_y;
    Lanes J[4];             // J00, J02, J11, J12; the others are 0
    Lanes M[6];             // J K diag(scale)
    Lanes a, b, c, per_det; // blurred covariance, 1 / its determinant
    Lanes ratio;            // determinant before the blur / after
    Where shortest[3];      // which axis is
    Lanes turn;             // 1 where the shortest axis looks to the camera, else -1
    Lanes normal[3];        // the shortest axis in the world, turned to the camera
} Frame;

// Constants of a view.
typedef struct View {
    FfpCamera camera;
    real blur;
    bool compensation;
    real firmness;
} View;

// ffp_quaternion_matrix of a vector of quaternions.
ALWAYS_INLINE void rotation_matrix(const Lanes q[4], Lanes R[9]) {
    const Lanes w = q[0], x = q[1], y = q[2], z = q[3];
    R[0] = 1 - 2 * (y * y + z * z), R[1] = 2 * (x * y - w * z), R[2] = 2 * (x * z + w * y);
    R[3] = 2 * (x * y + w * z), R[4] = 1 - 2 * (x * x + z * z), R[5] = 2 * (y * z - w * x);
    R[6] = 2 * (x * z - w * y), R[7] = 2 * (y * z + w * x), R[8] = 1 - 2 * (x * x + y * y);
}

// x/z held between the image's edges and a margin of 0.3 half widths, wherever the principal point lies: far
// outside the image the affine approximation of the perspective would grow without bound.
ALWAYS_INLINE Lanes hold(Lanes slope, real principal, real focal, real side, Where *held) {
    const real margin = FFP_HOLD_MARGIN * side;
    const real low = (-principal - margin) / focal, high = (side - principal + margin) / focal;
    const Lanes within = lanes_min(lanes_max(slope, lanes_all(low)), lanes_all(high));
    *held = within != slope;
    return within;
}

ALWAYS_INLINE void make_axes(const Batch *in, int group, const FfpCamera *camera, Frame *f) {
    Lanes squares = {0};
    for (int k = 0; k < 4; k++) squares += in->rotation[k].group[group] * in->rotation[k].group[group];
    const Lanes length = lanes_sqrt(squares);
    f->per_length = 1 / length;
    f->drawn = length > (Lanes){0};
    for (int k = 0; k < 4; k++) f->q[k] = in->rotation[k].group[group] * f->per_length;
    rotation_matrix(f->q, f->R);
    for (int r = 0; r < 3; r++)
        for (int k = 0; k < 3; k++)
            f->K[3 * r + k] = camera->pose[r] * f->R[k] + camera->pose[4 + r] * f->R[3 + k] +
                              camera->pose[8 + r] * f->R[6 + k];
}

ALWAYS_INLINE void make_jacobian(const Batch *in, int group, const FfpCamera *camera, Frame *f) {
    Lanes d[3];
    for (int k = 0; k < 3; k++) {
        d[k] = in->centre[k].group[group] - camera->pose[4 * k + 3];
        f->scale[k] = in->scale[k].group[group];
    }
    for (int k = 0; k < 3; k++)
        f->t[k] = camera->pose[k] * d[0] + camera->pose[4 + k] * d[1] + camera->pose[8 + k] * d[2];
    const Lanes z = f->t[2], largest = lanes_max(f->scale[0], lanes_max(f->scale[1], f->scale[2]));
    // Closer than its own deviation the affine approximation means nothing.
    f->drawn &= (z > largest) & (z > (Lanes){0});
    f->per_z = 1 / z;
    f->slope_x = hold(f->t[0] * f->per_z, camera->cx, camera->fx, (real)camera->width, &f->held_x);
    f->slope_y = hold(f->t[1] * f->per_z, camera->cy, camera->fy, (real)camera->height, &f->held_y);
    f->J[0] = camera->fx * f->per_z, f->J[1] = -f->J[0] * f->slope_x;
    f->J[2] = camera->fy * f->per_z, f->J[3] = -f->J[2] * f->slope_y;
}

ALWAYS_INLINE void make_covariance(real blur, Frame *f) {
    for (int k = 0; k < 3; k++) {
        f->M[k] = (f->J[0] * f->K[k] + f->J[1] * f->K[6 + k]) * f->scale[k];
        f->M[3 + k] = (f->J[2] * f->K[3 + k] + f->J[3] * f->K[6 + k]) * f->scale[k];
    }
    const Lanes *m = f->M;
    const Lanes a = m[0] * m[0] + m[1] * m[1] + m[2] * m[2], c = m[3] * m[3] + m[4] * m[4] + m[5] * m[5];
    f->b = m[0] * m[3] + m[1] * m[4] + m[2] * m[5];
    // det(M M^T) as the sum of squared minors (Cauchy-Binet): never negative, where a c - b^2 would cancel.
    const Lanes m0 = m[0] * m[4] - m[1] * m[3], m1 = m[0] * m[5] - m[2] * m[3],
                m2 = m[1] * m[5] - m[2] * m[4];
    const Lanes before = m0 * m0 + m1 * m1 + m2 * m2, det = before + blur * (a + c) + blur * blur;
    f->a = a + blur;
    f->c = c + blur;
    f->per_det = 1 / det;
    f->ratio = before * f->per_det;
    f->drawn &= (det > (Lanes){0}) & (f->a < lanes_all(1e12F)) & (f->c < lanes_all(1e12F));
}

// The first of the shortest axes.
ALWAYS_INLINE void make_normal(Frame *f) {
    const Lanes *s = f->scale;
    Lanes along = {0};
    f->shortest[0] = (s[0] <= s[1]) & (s[0] <= s[2]);
    f->shortest[1] = ~f->shortest[0] & (s[1] <= s[2]);
    f->shortest[2] = ~f->shortest[0] & ~f->shortest[1];
    for (int r = 0; r < 3; r++) {
        f->normal[r] = lanes_pick(f->shortest[0], f->R[3 * r],
                                  lanes_pick(f->shortest[1], f->R[3 * r + 1], f->R[3 * r + 2]));
        along += f->t[r] * lanes_pick(f->shortest[0], f->K[3 * r],
                                      lanes_pick(f->shortest[1], f->K[3 * r + 1], f->K[3 * r + 2]));
    }
    f->turn = lanes_pick(along > (Lanes){0}, lanes_all(-1), lanes_all(1));
    for (int r = 0; r < 3; r++) f->normal[r] *= f->turn;
}

ALWAYS_INLINE Frame make_frame(const Batch *in, int group, const View *view) {
    Frame f;
    make_axes(in, group, &view->camera, &f);
    make_jacobian(in, group, &view->camera, &f);
    make_covariance(view->blur, &f);
    make_normal(&f);
    return f;
}

ALWAYS_INLINE Lanes compensation(const Frame *f) {
    return lanes_max(lanes_sqrt(f->ratio), lanes_all(FFP_COMPENSATION_MIN));
}

static inline void add_to_batch(const FfpGaussians *g, int64_t i, Batch *batch) {
    const int l = batch->count++;
    batch->index[l] = i;
    for (int k = 0; k < 3; k++) {
        batch->centre[k].at[l] = g->centre[3 * i + k];
        batch->scale[k].at[l] = g->scale[3 * i + k];
    }
    for (int k = 0; k < 4; k++) batch->rotation[k].at[l] = g->rotation[4 * i + k];
    batch->opacity.at[l] = g->opacity[i];
}

#endif
