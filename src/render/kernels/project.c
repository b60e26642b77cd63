// Gaussians as a camera sees them: EWA projection (Zwicker et al. 2001) in the form of 3D Gaussian Splatting,
// and back. Gaussians are taken in batches, each number of a batch in an array of its own; the loops over a
// batch have no branch, so that they vectorise.
#include <string.h>
#include "render/kernels/kernels.h"

enum { BATCH = 64 };

// The least compensation: its square root has no slope at 0, where a flat splat is seen edge-on.
#define COMPENSATION_MIN 0.005F
#define LOG2_E 1.4426950408889634074

// Gaussians side by side.
typedef struct Batch {
    int count;
    int64_t index[BATCH];
    real centre[3][BATCH], scale[3][BATCH], rotation[4][BATCH], opacity[BATCH];
} Batch;

// Everything between a Gaussian's attributes and its 2D covariance. M M^T = covariance before the blur.
typedef struct Frame {
    bool drawn;            // in front of the camera, and all numbers sane
    real q[4], per_length; // unit quaternion, and 1 / the given one's length
    real R[9];             // splat axes to world
    real K[9];             // splat axes to camera
    real t[3], per_z;      // centre in the camera's frame, 1 / t[2]
    real slope_x, slope_y; // t[0] / z, t[1] / z, held inside the field of view for the Jacobian's sake
    bool held_x, held_y;
    real J[4];         // J00, J02, J11, J12; the others are 0
    real M[6];         // J K diag(scale)
    real a, b, c, det; // blurred covariance and its determinant
    real ratio;        // det before the blur / det after
    real axis[3];      // the shortest axis in the world, turned to the camera: the normal
    int shortest;
    real turn; // 1 where that axis looks to the camera, else -1
} Frame;

// What a batch of Gaussians looks like.
typedef struct Seen {
    real x[BATCH], y[BATCH], power[3][BATCH], opacity[BATCH], depth[BATCH], normal[3][BATCH];
    int32_t x0[BATCH], y0[BATCH], x1[BATCH], y1[BATCH]; // x0 = x1: not drawn
} Seen;

// Constants of a view.
typedef struct View {
    FfpCamera camera;
    real blur;
    bool compensation;
} View;

static inline real larger(real a, real b) {
    return a > b ? a : b;
}

static void add_to_batch(const FfpGaussians *g, int64_t i, Batch *batch) {
    const int l = batch->count++;
    batch->index[l] = i;
    for (int k = 0; k < 3; k++) {
        batch->centre[k][l] = g->centre[3 * i + k];
        batch->scale[k][l] = g->scale[3 * i + k];
    }
    for (int k = 0; k < 4; k++) batch->rotation[k][l] = g->rotation[4 * i + k];
    batch->opacity[l] = g->opacity[i];
}

// Repeats the last Gaussian up to a full batch: loops then have a fixed length.
static void fill_batch(Batch *batch) {
    for (int l = batch->count; l < BATCH; l++) {
        for (int k = 0; k < 3; k++) {
            batch->centre[k][l] = batch->centre[k][l - 1];
            batch->scale[k][l] = batch->scale[k][l - 1];
        }
        for (int k = 0; k < 4; k++) batch->rotation[k][l] = batch->rotation[k][l - 1];
        batch->opacity[l] = batch->opacity[l - 1];
    }
}

static inline void rotation_matrix(const real q[4], real R[9]) {
    const real w = q[0], x = q[1], y = q[2], z = q[3];
    R[0] = 1 - 2 * (y * y + z * z), R[1] = 2 * (x * y - w * z), R[2] = 2 * (x * z + w * y);
    R[3] = 2 * (x * y + w * z), R[4] = 1 - 2 * (x * x + z * z), R[5] = 2 * (y * z - w * x);
    R[6] = 2 * (x * z - w * y), R[7] = 2 * (y * z + w * x), R[8] = 1 - 2 * (x * x + y * y);
}

// x/z held between the image's edges and a margin of 0.3 half widths, wherever the principal point lies: far
// outside the image the affine approximation of the perspective would grow without bound.
static inline real hold(real slope, real principal, real focal, real side, bool *held) {
    const real margin = 0.15F * side;
    const real low = (-principal - margin) / focal, high = (side - principal + margin) / focal;
    const real above = slope < low ? low : slope, within = above > high ? high : above;
    *held = within != slope;
    return within;
}

static inline void make_axes(const Batch *in, int l, const FfpCamera *camera, Frame *f) {
    real squares = 0;
    for (int k = 0; k < 4; k++) squares += in->rotation[k][l] * in->rotation[k][l];
    const real length = sqrt(squares);
    f->per_length = 1 / length;
    f->drawn = length > 0;
    for (int k = 0; k < 4; k++) f->q[k] = in->rotation[k][l] * f->per_length;
    rotation_matrix(f->q, f->R);
    for (int r = 0; r < 3; r++)
        for (int k = 0; k < 3; k++)
            f->K[3 * r + k] = camera->pose[r] * f->R[k] + camera->pose[4 + r] * f->R[3 + k] +
                              camera->pose[8 + r] * f->R[6 + k];
}

static inline void make_jacobian(const Batch *in, int l, const FfpCamera *camera, Frame *f) {
    real d[3];
    for (int k = 0; k < 3; k++) d[k] = in->centre[k][l] - camera->pose[4 * k + 3];
    for (int k = 0; k < 3; k++)
        f->t[k] = camera->pose[k] * d[0] + camera->pose[4 + k] * d[1] + camera->pose[8 + k] * d[2];
    const real z = f->t[2], largest = larger(in->scale[0][l], larger(in->scale[1][l], in->scale[2][l]));
    // Closer than its own deviation the affine approximation means nothing.
    f->drawn = f->drawn & (z > largest) & (z > 0);
    f->per_z = 1 / z;
    f->slope_x = hold(f->t[0] * f->per_z, camera->cx, camera->fx, (real)camera->width, &f->held_x);
    f->slope_y = hold(f->t[1] * f->per_z, camera->cy, camera->fy, (real)camera->height, &f->held_y);
    f->J[0] = camera->fx * f->per_z, f->J[1] = -f->J[0] * f->slope_x;
    f->J[2] = camera->fy * f->per_z, f->J[3] = -f->J[2] * f->slope_y;
}

static inline void make_covariance(const Batch *in, int l, real blur, Frame *f) {
    for (int k = 0; k < 3; k++) {
        f->M[k] = (f->J[0] * f->K[k] + f->J[1] * f->K[6 + k]) * in->scale[k][l];
        f->M[3 + k] = (f->J[2] * f->K[3 + k] + f->J[3] * f->K[6 + k]) * in->scale[k][l];
    }
    const real *m = f->M;
    const real a = m[0] * m[0] + m[1] * m[1] + m[2] * m[2], c = m[3] * m[3] + m[4] * m[4] + m[5] * m[5];
    f->b = m[0] * m[3] + m[1] * m[4] + m[2] * m[5];
    // det(M M^T) as the sum of squared minors (Cauchy-Binet): never negative, where a c - b^2 would cancel.
    const real m0 = m[0] * m[4] - m[1] * m[3], m1 = m[0] * m[5] - m[2] * m[3], m2 = m[1] * m[5] - m[2] * m[4];
    const real det = m0 * m0 + m1 * m1 + m2 * m2;
    f->a = a + blur, f->c = c + blur;
    f->det = det + blur * (a + c) + blur * blur;
    f->ratio = det / f->det;
    f->drawn = f->drawn & (f->det > 0) & (f->a < 1e12F) & (f->c < 1e12F);
}

static inline void make_normal(const Batch *in, int l, const FfpCamera *camera, Frame *f) {
    const real s0 = in->scale[0][l], s1 = in->scale[1][l], s2 = in->scale[2][l];
    const bool first = (s0 <= s1) & (s0 <= s2), second = s1 <= s2;
    f->shortest = first ? 0 : second ? 1 : 2;
    real along = 0;
    for (int r = 0; r < 3; r++) {
        const real later = second ? f->R[3 * r + 1] : f->R[3 * r + 2];
        f->axis[r] = first ? f->R[3 * r] : later;
        along += f->axis[r] * (in->centre[r][l] - camera->pose[4 * r + 3]);
    }
    f->turn = along > 0 ? -1 : 1;
    for (int r = 0; r < 3; r++) f->axis[r] *= f->turn;
}

static inline void make_frame(const Batch *in, int l, const View *view, Frame *f) {
    make_axes(in, l, &view->camera, f);
    make_jacobian(in, l, &view->camera, f);
    make_covariance(in, l, view->blur, f);
    make_normal(in, l, &view->camera, f);
}

// No less than log2 of a positive number, by at most 0.02: the exponent, and a parabola for the mantissa.
static inline real log2_above(real x) {
    const float narrow = (float)x;
    uint32_t bits;
    memcpy(&bits, &narrow, sizeof bits);
    const int32_t exponent = (int32_t)(bits >> 23) - 127;
    bits = (bits & 0x7FFFFFU) | 0x3F800000U;
    float mantissa;
    memcpy(&mantissa, &bits, sizeof mantissa);
    const real f = mantissa - 1;
    return (real)exponent + f + 0.3465736F * f * (1 - f) + 0.01F;
}

// Whole part held in [0, limit]; anything that is no number becomes 0.
static inline int32_t clamp_index(real value, real limit) {
    const real above = value > 0 ? value : 0;
    return (int32_t)(above < limit ? above : limit);
}

// The pixels where alpha can reach 1/255: those with their centre in the box around that ellipse.
static inline void bound_splat(const Frame *f, const FfpCamera *camera, int l, Seen *seen) {
    const real opacity = seen->opacity[l], x = seen->x[l], y = seen->y[l];
    const bool drawn = f->drawn & (opacity > FFP_ALPHA_MIN);
    const real squared = (real)(2 / LOG2_E) * log2_above(255 * (drawn ? opacity : 1));
    const real rx = sqrt(squared * f->a), ry = sqrt(squared * f->c);
    const real width = (real)camera->width, height = (real)camera->height;
    seen->x0[l] = clamp_index(x - rx + 0.5F, width);
    seen->y0[l] = clamp_index(y - ry + 0.5F, height);
    seen->x1[l] = drawn ? clamp_index(x + rx + 0.5F, width) : 0;
    seen->y1[l] = drawn ? clamp_index(y + ry + 0.5F, height) : 0;
}

static void see_batch(const Batch *restrict in, const View *given, Seen *restrict seen) {
    const View view = *given;
    const FfpCamera *camera = &view.camera;
#pragma omp simd
    for (int l = 0; l < BATCH; l++) {
        Frame f;
        make_frame(in, l, &view, &f);
        const real root = sqrt(f.ratio), least = COMPENSATION_MIN;
        const real compensation = view.compensation ? larger(root, least) : 1;
        const real given_opacity = in->opacity[l];
        seen->opacity[l] = (given_opacity < 1 ? given_opacity : 1) * compensation;
        seen->x[l] = camera->fx * f.t[0] * f.per_z + camera->cx;
        seen->y[l] = camera->fy * f.t[1] * f.per_z + camera->cy;
        seen->depth[l] = f.t[2];
        const real scale = (real)(-0.5 * LOG2_E) / f.det;
        seen->power[0][l] = scale * f.c, seen->power[1][l] = -2 * scale * f.b,
        seen->power[2][l] = scale * f.a;
        for (int k = 0; k < 3; k++) seen->normal[k][l] = f.axis[k];
        bound_splat(&f, camera, l, seen);
    }
}

static FfpSplat make_splat(const Seen *seen, int l, const FfpGaussians *g, int64_t i) {
    const real *albedo = g->albedo + 3 * i, *ambient = g->ambient + 3 * i;
    return (FfpSplat){.x = seen->x[l],
                      .y = seen->y[l],
                      .power = {seen->power[0][l], seen->power[1][l], seen->power[2][l]},
                      .opacity = seen->opacity[l],
                      .value = {1, seen->depth[l], seen->normal[0][l], seen->normal[1][l], seen->normal[2][l],
                                albedo[0], albedo[1], albedo[2], g->roughness[i], ambient[0], ambient[1],
                                ambient[2]},
                      .gaussian = (int32_t)i,
                      .x0 = seen->x0[l],
                      .y0 = seen->y0[l],
                      .x1 = seen->x1[l],
                      .y1 = seen->y1[l]};
}

static void draw_batch(Batch *batch, const FfpGaussians *g, const View *view, FfpSplat *splats,
                       int32_t *drawn) {
    Seen seen;
    if (batch->count == 0) return;
    fill_batch(batch);
    see_batch(batch, view, &seen);
    for (int l = 0; l < batch->count; l++)
        if (seen.x0[l] < seen.x1[l] && seen.y0[l] < seen.y1[l])
            splats[(*drawn)++] = make_splat(&seen, l, g, batch->index[l]);
    batch->count = 0;
}

void FFP_K(project_chunk)(FfpRaster *raster, const FfpGaussians *g, const FfpCamera *camera,
                          const FfpRenderSettings *settings, FfpChunk *chunk) {
    const View view = {*camera, settings->blur, settings->compensation};
    FfpSplat *splats = raster->splats + chunk->first;
    Batch batch;
    batch.count = 0, chunk->drawn = 0;
    for (int64_t i = chunk->begin; i < chunk->end; i++) {
        if (!(g->opacity[i] >= FFP_ALPHA_MIN)) continue;
        add_to_batch(g, i, &batch);
        if (batch.count == BATCH) draw_batch(&batch, g, &view, splats, &chunk->drawn);
    }
    draw_batch(&batch, g, &view, splats, &chunk->drawn);
}

// A batch's gradients: of what the tiles gathered, and of the Gaussians' attributes.
typedef struct BatchGrad {
    real g[BATCH], gx[BATCH], gy[BATCH], gxx[BATCH], gxy[BATCH], gyy[BATCH];
    real depth[BATCH], normal[3][BATCH];
    real centre[3][BATCH], scale[3][BATCH], rotation[4][BATCH], opacity[BATCH];
} BatchGrad;

// Gradients on the way from the covariance to the attributes.
typedef struct Chain {
    real G[3]; // for the blurred covariance, as a full symmetric matrix: G00, G01 = G10, G11
    real dM[6], dK[9], dR[9], dt[3];
} Chain;

// The unit quaternion's gradient from that for its matrix.
static inline void rotation_matrix_backward(const real q[4], const real d[9], real dq[4]) {
    const real w = q[0], x = q[1], y = q[2], z = q[3];
    dq[0] = 2 * (x * (d[7] - d[5]) + y * (d[2] - d[6]) + z * (d[3] - d[1]));
    dq[1] = 2 * (y * (d[1] + d[3]) + z * (d[2] + d[6]) + w * (d[7] - d[5]) - 2 * x * (d[4] + d[8]));
    dq[2] = 2 * (x * (d[1] + d[3]) + z * (d[5] + d[7]) + w * (d[2] - d[6]) - 2 * y * (d[0] + d[8]));
    dq[3] = 2 * (x * (d[2] + d[6]) + y * (d[5] + d[7]) + w * (d[3] - d[1]) - 2 * z * (d[0] + d[4]));
}

// From the moments to the covariance: sigma = (A dx^2 + C dy^2) / 2 + B dx dy with (A, B, C) its inverse.
static inline void conic_backward(const Frame *f, real gxx, real gxy, real gyy, real G[3]) {
    const real A = f->c / f->det, B = -f->b / f->det, C = f->a / f->det;
    const real h = 0.5F * gxy, dA = 0.5F * gxx, dC = 0.5F * gyy;
    const real p = A * dA + B * h, q = A * h + B * dC, r = B * dA + C * h, s = B * h + C * dC;
    G[0] = -(p * A + q * B);
    G[1] = -(p * B + q * C);
    G[2] = -(r * B + s * C);
}

// Through opacity = given * sqrt(ratio): adds to G, returns the gradient for the given opacity.
static inline real compensation_backward(const Frame *f, real given, real blur, real d, real G[3]) {
    const real root = sqrt(f->ratio);
    const bool free = root > COMPENSATION_MIN;
    const real compensation = free ? root : (real)COMPENSATION_MIN;
    const real step = free ? d * given / (2 * compensation * f->det) : 0;
    G[0] += step * (f->c - blur - f->ratio * f->c);
    G[1] -= step * (1 - f->ratio) * f->b;
    G[2] += step * (f->a - blur - f->ratio * f->a);
    return d * compensation;
}

// From M = J K diag(scale) back to scale, K and (through J) the centre in the camera's frame.
static inline void axes_backward(const Frame *f, const FfpCamera *camera, const real s[3], Chain *c,
                                 real ds[3]) {
    real dJ[4] = {0};
    for (int k = 0; k < 3; k++) {
        const real *dM = c->dM;
        const real d[3] = {f->J[0] * dM[k], f->J[2] * dM[3 + k], f->J[1] * dM[k] + f->J[3] * dM[3 + k]};
        ds[k] = 0;
        for (int r = 0; r < 3; r++) {
            ds[k] += d[r] * f->K[3 * r + k];
            c->dK[3 * r + k] = d[r] * s[k];
        }
        dJ[0] += dM[k] * f->K[k] * s[k], dJ[1] += dM[k] * f->K[6 + k] * s[k];
        dJ[2] += dM[3 + k] * f->K[3 + k] * s[k], dJ[3] += dM[3 + k] * f->K[6 + k] * s[k];
    }
    const real x = camera->fx * f->per_z * f->per_z, y = camera->fy * f->per_z * f->per_z;
    // Where x/z is held, tx moves with z, which takes one of the two powers of z away.
    c->dt[0] = f->held_x ? 0 : -x * dJ[1];
    c->dt[1] = f->held_y ? 0 : -y * dJ[3];
    c->dt[2] = -x * dJ[0] - y * dJ[2] + (f->held_x ? 1 : 2) * x * f->slope_x * dJ[1] +
               (f->held_y ? 1 : 2) * y * f->slope_y * dJ[3];
}

// From the position in the image and the depth to the centre in the camera's frame.
static inline void position_backward(const Frame *f, const FfpCamera *camera, const BatchGrad *d, int l,
                                     real dt[3]) {
    const real gx = d->gx[l], gy = d->gy[l];
    const real dx = (f->c * gx - f->b * gy) / f->det, dy = (f->a * gy - f->b * gx) / f->det;
    dt[0] += camera->fx * f->per_z * dx, dt[1] += camera->fy * f->per_z * dy;
    dt[2] += d->depth[l] - (camera->fx * f->t[0] * dx + camera->fy * f->t[1] * dy) * f->per_z * f->per_z;
}

// From the splat's axes in the camera's frame, and its normal, to the quaternion as given.
static inline void turn_backward(const Frame *f, const FfpCamera *camera, Chain *c, BatchGrad *d, int l) {
    real dq[4], along = 0;
    for (int r = 0; r < 3; r++) {
        const real *w = camera->pose + 4 * r, normal = f->turn * d->normal[r][l];
        for (int k = 0; k < 3; k++)
            c->dR[3 * r + k] =
                w[0] * c->dK[k] + w[1] * c->dK[3 + k] + w[2] * c->dK[6 + k] + (f->shortest == k ? normal : 0);
    }
    rotation_matrix_backward(f->q, c->dR, dq);
    for (int k = 0; k < 4; k++) along += dq[k] * f->q[k];
    for (int k = 0; k < 4; k++) d->rotation[k][l] = (dq[k] - along * f->q[k]) * f->per_length;
}

static void see_batch_backward(const Batch *restrict in, const View *given, BatchGrad *restrict d) {
    const View view = *given;
    const FfpCamera *camera = &view.camera;
#pragma omp simd
    for (int l = 0; l < BATCH; l++) {
        Frame f;
        Chain c;
        make_frame(in, l, &view, &f);
        conic_backward(&f, d->gxx[l], d->gxy[l], d->gyy[l], c.G);
        const real opacity = in->opacity[l] < 1 ? in->opacity[l] : 1;
        const real root = sqrt(f.ratio), least = COMPENSATION_MIN;
        // density = opacity exp(-sigma): its slope by the opacity is -g / opacity
        const real drawn_with = opacity * (view.compensation ? larger(root, least) : 1);
        const real d_drawn = -d->g[l] / drawn_with;
        const real d_opacity =
            view.compensation ? compensation_backward(&f, opacity, view.blur, d_drawn, c.G) : d_drawn;
        d->opacity[l] = in->opacity[l] <= 1 ? d_opacity : 0;
        for (int k = 0; k < 3; k++) {
            c.dM[k] = 2 * (c.G[0] * f.M[k] + c.G[1] * f.M[3 + k]);
            c.dM[3 + k] = 2 * (c.G[1] * f.M[k] + c.G[2] * f.M[3 + k]);
        }
        const real scale[3] = {in->scale[0][l], in->scale[1][l], in->scale[2][l]};
        real ds[3];
        axes_backward(&f, camera, scale, &c, ds);
        position_backward(&f, camera, d, l, c.dt);
        turn_backward(&f, camera, &c, d, l);
        for (int k = 0; k < 3; k++) {
            const real *w = camera->pose + 4 * k;
            d->scale[k][l] = ds[k];
            d->centre[k][l] = w[0] * c.dt[0] + w[1] * c.dt[1] + w[2] * c.dt[2];
        }
    }
}

// Sums the splat's slots in order; false when no tile touched it.
static bool sum_slots(const FfpRaster *raster, int32_t s, FfpSplatGrad *sum) {
    const FfpTiles t = ffp_splat_tiles(&raster->splats[s]);
    const int64_t first = raster->first[s], end = first + (int64_t)(t.x1 - t.x0) * (t.y1 - t.y0);
    bool any = false;
    for (int64_t j = first; j < end; j++) {
        if (!raster->touched[j]) continue;
        if (!any) {
            *sum = raster->slots[j];
            any = true;
            continue;
        }
        const FfpSplatGrad *part = &raster->slots[j];
        sum->g += part->g, sum->gx += part->gx, sum->gy += part->gy;
        sum->gxx += part->gxx, sum->gxy += part->gxy, sum->gyy += part->gyy;
        for (int k = 1; k < FFP_CHANNELS; k++) sum->value[k] += part->value[k];
    }
    return any;
}

static void add_to_grads(const FfpSplatGrad *sum, int l, BatchGrad *d) {
    d->g[l] = sum->g, d->gx[l] = sum->gx, d->gy[l] = sum->gy;
    d->gxx[l] = sum->gxx, d->gxy[l] = sum->gxy, d->gyy[l] = sum->gyy;
    d->depth[l] = sum->value[FFP_CHANNEL_DEPTH];
    for (int k = 0; k < 3; k++) d->normal[k][l] = sum->value[FFP_CHANNEL_NORMAL + k];
}

static void batch_backward(Batch *batch, const View *view, BatchGrad *d, FfpGaussians *grad) {
    static const FfpSplatGrad none = {0};
    if (batch->count == 0) return;
    fill_batch(batch);
    for (int l = batch->count; l < BATCH; l++) add_to_grads(&none, l, d);
    see_batch_backward(batch, view, d);
    for (int l = 0; l < batch->count; l++) {
        const int64_t i = batch->index[l];
        for (int k = 0; k < 3; k++) {
            grad->centre[3 * i + k] += d->centre[k][l];
            grad->scale[3 * i + k] += d->scale[k][l];
        }
        for (int k = 0; k < 4; k++) grad->rotation[4 * i + k] += d->rotation[k][l];
        grad->opacity[i] += d->opacity[l];
    }
    batch->count = 0;
}

void FFP_K(project_chunk_backward)(const FfpRaster *raster, const FfpGaussians *g, const FfpCamera *camera,
                                   const FfpRenderSettings *settings, const FfpChunk *chunk,
                                   FfpGaussians *grad) {
    const View view = {*camera, settings->blur, settings->compensation};
    Batch batch;
    BatchGrad d;
    batch.count = 0;
    for (int32_t s = chunk->first; s < chunk->first + chunk->drawn; s++) {
        FfpSplatGrad sum;
        if (!sum_slots(raster, s, &sum)) continue;
        const int64_t i = raster->splats[s].gaussian;
        for (int k = 0; k < 3; k++) {
            grad->albedo[3 * i + k] += sum.value[FFP_CHANNEL_ALBEDO + k];
            grad->ambient[3 * i + k] += sum.value[FFP_CHANNEL_AMBIENT + k];
        }
        grad->roughness[i] += sum.value[FFP_CHANNEL_ROUGHNESS];
        add_to_grads(&sum, batch.count, &d);
        add_to_batch(g, i, &batch);
        if (batch.count == BATCH) batch_backward(&batch, &view, &d, grad);
    }
    batch_backward(&batch, &view, &d, grad);
}
