// Gaussians as a camera sees them: EWA projection (Zwicker et al. 2001) in the form of 3D Gaussian Splatting,
// and back; one thread a Gaussian. The formulas are those of engine/render/kernels/frame.h, project.c and
// project_backward.c, without their vectors.
#include "engine/cuda/launch.h"
#include "engine/cuda/raster.h"

#define LOG2_E 1.4426950408889634F

enum { BLOCK = 128 };

// Everything between a Gaussian and its shadow on the image plane. M M^T = covariance before the blur.
typedef struct Frame {
    bool drawn;             // in front of the camera, and all numbers sane
    float q[4], per_length; // unit quaternion, and 1 / the given one's length
    float R[9];             // splat axes to world
    float K[9];             // splat axes to camera
    float scale[3];         // as given
    float t[3], per_z;      // centre in the camera's frame, 1 / t[2]
    float slope_x, slope_y; // t[0] / z, t[1] / z, held inside the field of view for the Jacobian's sake
    bool held_x, held_y;
    float J[4];             // J00, J02, J11, J12; the others are 0
    float M[6];             // J K diag(scale)
    float a, b, c, per_det; // blurred covariance, 1 / its determinant
    float ratio;            // determinant before the blur / after
    bool shortest[3];       // which axis is
    float turn;             // 1 where the shortest axis looks to the camera, else -1
    float normal[3];        // the shortest axis in the world, turned to the camera
} Frame;

// x/z held between the image's edges and a margin, wherever the principal point lies.
static __device__ inline float hold(float slope, float principal, float focal, float side, bool *held) {
    const float margin = FFP_HOLD_MARGIN * side;
    const float low = (-principal - margin) / focal, high = (side - principal + margin) / focal;
    const float within = slope < low ? low : slope > high ? high : slope;
    *held = within != slope;
    return within;
}

static __device__ inline void make_axes(const float rotation[4], const FfpCamera *camera, Frame *f) {
    float squares = 0;
    for (int k = 0; k < 4; k++) squares += rotation[k] * rotation[k];
    const float length = sqrtf(squares);
    f->per_length = 1 / length;
    f->drawn = length > 0;
    for (int k = 0; k < 4; k++) f->q[k] = rotation[k] * f->per_length;
    ffp_quaternion_matrix(f->q, f->R);
    for (int r = 0; r < 3; r++)
        for (int k = 0; k < 3; k++)
            f->K[3 * r + k] = camera->pose[r] * f->R[k] + camera->pose[4 + r] * f->R[3 + k] +
                              camera->pose[8 + r] * f->R[6 + k];
}

static __device__ inline void make_jacobian(const float centre[3], const FfpCamera *camera, Frame *f) {
    float d[3];
    for (int k = 0; k < 3; k++) d[k] = centre[k] - camera->pose[4 * k + 3];
    for (int k = 0; k < 3; k++)
        f->t[k] = camera->pose[k] * d[0] + camera->pose[4 + k] * d[1] + camera->pose[8 + k] * d[2];
    const float z = f->t[2];
    // Closer than its own deviation the affine approximation means nothing.
    f->drawn = f->drawn && z > f->scale[0] && z > f->scale[1] && z > f->scale[2] && z > 0;
    f->per_z = 1 / z;
    f->slope_x = hold(f->t[0] * f->per_z, camera->cx, camera->fx, (float)camera->width, &f->held_x);
    f->slope_y = hold(f->t[1] * f->per_z, camera->cy, camera->fy, (float)camera->height, &f->held_y);
    f->J[0] = camera->fx * f->per_z, f->J[1] = -f->J[0] * f->slope_x;
    f->J[2] = camera->fy * f->per_z, f->J[3] = -f->J[2] * f->slope_y;
}

static __device__ inline void make_covariance(float blur, Frame *f) {
    for (int k = 0; k < 3; k++) {
        f->M[k] = (f->J[0] * f->K[k] + f->J[1] * f->K[6 + k]) * f->scale[k];
        f->M[3 + k] = (f->J[2] * f->K[3 + k] + f->J[3] * f->K[6 + k]) * f->scale[k];
    }
    const float *m = f->M;
    const float a = m[0] * m[0] + m[1] * m[1] + m[2] * m[2], c = m[3] * m[3] + m[4] * m[4] + m[5] * m[5];
    f->b = m[0] * m[3] + m[1] * m[4] + m[2] * m[5];
    // det(M M^T) as the sum of squared minors (Cauchy-Binet): never negative, where a c - b^2 would cancel.
    const float m0 = m[0] * m[4] - m[1] * m[3], m1 = m[0] * m[5] - m[2] * m[3],
                m2 = m[1] * m[5] - m[2] * m[4];
    const float before = m0 * m0 + m1 * m1 + m2 * m2, det = before + blur * (a + c) + blur * blur;
    f->a = a + blur;
    f->c = c + blur;
    f->per_det = 1 / det;
    f->ratio = before * f->per_det;
    f->drawn = f->drawn && det > 0 && f->a < 1e12F && f->c < 1e12F;
}

// The first of the shortest axes.
static __device__ inline void make_normal(Frame *f) {
    const float *s = f->scale;
    float along = 0;
    f->shortest[0] = s[0] <= s[1] && s[0] <= s[2];
    f->shortest[1] = !f->shortest[0] && s[1] <= s[2];
    f->shortest[2] = !f->shortest[0] && !f->shortest[1];
    for (int r = 0; r < 3; r++) {
        f->normal[r] = f->shortest[0] ? f->R[3 * r] : f->shortest[1] ? f->R[3 * r + 1] : f->R[3 * r + 2];
        along += f->t[r] * (f->shortest[0]   ? f->K[3 * r]
                            : f->shortest[1] ? f->K[3 * r + 1]
                                             : f->K[3 * r + 2]);
    }
    f->turn = along > 0 ? -1 : 1;
    for (int r = 0; r < 3; r++) f->normal[r] *= f->turn;
}

static __device__ inline void make_frame(const FfpGaussians *g, size_t i, const FfpDeviceView *view,
                                         Frame *f) {
    const float rotation[4] = {g->rotation[4 * i], g->rotation[4 * i + 1], g->rotation[4 * i + 2],
                               g->rotation[4 * i + 3]};
    const float centre[3] = {g->centre[3 * i], g->centre[3 * i + 1], g->centre[3 * i + 2]};
    for (size_t k = 0; k < 3; k++) f->scale[k] = g->scale[3 * i + k];
    make_axes(rotation, &view->camera, f);
    make_jacobian(centre, &view->camera, f);
    make_covariance(view->blur, f);
    make_normal(f);
}

static __device__ inline float compensation(const Frame *f) {
    return fmaxf(sqrtf(f->ratio), FFP_COMPENSATION_MIN);
}

// Whole numbers in [0, limit]; anything that is not a number becomes 0.
static __device__ inline int clamp_index(float value, int limit) {
    return (int)fminf(fmaxf(value, 0), (float)limit);
}

// The pixels where alpha can reach 1/255: those with their centre in the box around that ellipse, which is
// taken a little too large (by a hundredth of a power of 2 of density).
static __device__ inline int4 bound_splat(const Frame *f, const FfpDeviceView *view, float x, float y,
                                          float opacity) {
    const FfpCamera *camera = &view->camera;
    const float most = opacity * (1 + view->firmness); // alpha is below that, times exp
    if (!(f->drawn && most > FFP_ALPHA_MIN)) return int4{0, 0, 0, 0};
    const float squared = 2 / LOG2_E * (log2f(255 * most) + 0.01F);
    const float rx = sqrtf(squared * f->a), ry = sqrtf(squared * f->c);
    const int4 box = {clamp_index(x - rx + 0.5F, camera->width), clamp_index(y - ry + 0.5F, camera->height),
                      clamp_index(x + rx + 0.5F, camera->width), clamp_index(y + ry + 0.5F, camera->height)};
    return box.x < box.z && box.y < box.w ? box : int4{0, 0, 0, 0};
}

static __device__ inline void write_splat(const Frame *f, const FfpGaussians *g, size_t i, float x, float y,
                                          float opacity, FfpDeviceSplat *out) {
    const float scale = -0.5F * LOG2_E * f->per_det;
    const float *albedo = g->albedo + 3 * i, *ambient = g->ambient + 3 * i, *n = f->normal;
    float4 *quads = (float4 *)out;
    quads[0] = float4{x, y, scale * f->c, -2 * scale * f->b};
    quads[1] = float4{scale * f->a, opacity, f->t[2], n[0]};
    quads[2] = float4{n[1], n[2], albedo[0], albedo[1]};
    quads[3] = float4{albedo[2], g->roughness[i], ambient[0], ambient[1]};
    quads[4] = float4{ambient[2], 0, 0, 0};
    if (!g->scatters) return;
    const float *scattered = g->scattered + 3 * i;
    quads[4] = float4{ambient[2], scattered[0], scattered[1], scattered[2]};
}

static __global__ void __launch_bounds__(BLOCK)
    project_splats(FfpTiling t, FfpGaussians g, const __grid_constant__ FfpDeviceView view) {
    const size_t i = ffp_thread();
    if (i > (size_t)t.gaussians) return;
    int4 box = {0, 0, 0, 0};
    if (i < (size_t)t.gaussians && g.opacity[i] >= FFP_ALPHA_MIN) {
        Frame f;
        make_frame(&g, i, &view, &f);
        const float given = fminf(g.opacity[i], 1);
        const float opacity = view.compensation ? given * compensation(&f) : given;
        const float x = view.camera.fx * f.t[0] * f.per_z + view.camera.cx;
        const float y = view.camera.fy * f.t[1] * f.per_z + view.camera.cy;
        box = bound_splat(&f, &view, x, y, opacity);
        if (box.x < box.z) write_splat(&f, &g, i, x, y, opacity, &t.splats[i]);
    }
    const int4 tiles = ffp_box_tiles(box);
    t.counts[i] = (int64_t)(tiles.z - tiles.x) * (tiles.w - tiles.y);
    t.boxes[i] = box;
}

void ffp_cuda_project(const FfpTiling *tiling, const FfpGaussians *gaussians, const FfpDeviceView *view) {
    const unsigned blocks = ffp_blocks((size_t)tiling->gaussians + 1, BLOCK);
    ffp_launch(project_splats, dim3(blocks), dim3(BLOCK), *tiling, *gaussians, *view);
}

// Gradients on the way from the covariance to the attributes.
typedef struct Chain {
    float G[3]; // for the blurred covariance, as a full symmetric matrix: G00, G01 = G10, G11
    float dM[6], dK[9], dt[3];
} Chain;

// The unit quaternion's gradient from that for its matrix.
static __device__ inline void rotation_matrix_backward(const float q[4], const float d[9], float dq[4]) {
    const float w = q[0], x = q[1], y = q[2], z = q[3];
    dq[0] = 2 * (x * (d[7] - d[5]) + y * (d[2] - d[6]) + z * (d[3] - d[1]));
    dq[1] = 2 * (y * (d[1] + d[3]) + z * (d[2] + d[6]) + w * (d[7] - d[5]) - 2 * x * (d[4] + d[8]));
    dq[2] = 2 * (x * (d[1] + d[3]) + z * (d[5] + d[7]) + w * (d[2] - d[6]) - 2 * y * (d[0] + d[8]));
    dq[3] = 2 * (x * (d[2] + d[6]) + y * (d[5] + d[7]) + w * (d[3] - d[1]) - 2 * z * (d[0] + d[4]));
}

// From the moments to the covariance: sigma = (A dx^2 + C dy^2) / 2 + B dx dy with (A, B, C) its inverse.
static __device__ inline void conic_backward(const Frame *f, const FfpDeviceSplatGrad *d, float G[3]) {
    const float A = f->c * f->per_det, B = -f->b * f->per_det, C = f->a * f->per_det;
    const float h = 0.5F * d->gxy, dA = 0.5F * d->gxx, dC = 0.5F * d->gyy;
    const float p = A * dA + B * h, q = A * h + B * dC, r = B * dA + C * h, s = B * h + C * dC;
    G[0] = -(p * A + q * B);
    G[1] = -(p * B + q * C);
    G[2] = -(r * B + s * C);
}

// Through opacity = given * sqrt(ratio): adds to G, returns the gradient for the given opacity.
static __device__ inline float compensation_backward(const Frame *f, float given, float blur, float d,
                                                     float G[3]) {
    const float root = compensation(f);
    if (root > FFP_COMPENSATION_MIN) {
        const float step = d * given * f->per_det / (2 * root);
        G[0] += step * (f->c - blur - f->ratio * f->c);
        G[1] -= step * (1 - f->ratio) * f->b;
        G[2] += step * (f->a - blur - f->ratio * f->a);
    }
    return d * root;
}

// density = opacity exp(-sigma): its slope by the opacity is -g / opacity. Adds to G.
static __device__ inline float opacity_backward(const Frame *f, const FfpDeviceView *view, float given,
                                                float g, float G[3]) {
    const float held = fminf(given, 1);
    float d = -g / held;
    if (view->compensation) d = compensation_backward(f, held, view->blur, -g / (held * compensation(f)), G);
    return given <= 1 ? d : 0;
}

// From M = J K diag(scale) back to scale, K and (through J) the centre in the camera's frame.
static __device__ inline void axes_backward(const Frame *f, const FfpCamera *camera, Chain *c, float ds[3]) {
    const float *dM = c->dM;
    float dJ[4] = {0, 0, 0, 0};
    for (int k = 0; k < 3; k++) {
        const float d[3] = {f->J[0] * dM[k], f->J[2] * dM[3 + k], f->J[1] * dM[k] + f->J[3] * dM[3 + k]};
        const float s = f->scale[k];
        ds[k] = d[0] * f->K[k] + d[1] * f->K[3 + k] + d[2] * f->K[6 + k];
        for (int r = 0; r < 3; r++) c->dK[3 * r + k] = d[r] * s;
        dJ[0] += dM[k] * f->K[k] * s, dJ[1] += dM[k] * f->K[6 + k] * s;
        dJ[2] += dM[3 + k] * f->K[3 + k] * s, dJ[3] += dM[3 + k] * f->K[6 + k] * s;
    }
    const float x = camera->fx * f->per_z * f->per_z, y = camera->fy * f->per_z * f->per_z;
    // Where x/z is held, tx moves with z, which takes one of the two powers of z away.
    c->dt[0] = f->held_x ? 0 : -x * dJ[1];
    c->dt[1] = f->held_y ? 0 : -y * dJ[3];
    c->dt[2] = -x * dJ[0] - y * dJ[2] + (f->held_x ? 1 : 2) * x * f->slope_x * dJ[1] +
               (f->held_y ? 1 : 2) * y * f->slope_y * dJ[3];
}

// From the position in the image and the depth to the centre in the camera's frame.
static __device__ inline void position_backward(const Frame *f, const FfpCamera *camera,
                                                const FfpDeviceSplatGrad *d, float dt[3]) {
    const float dx = (f->c * d->gx - f->b * d->gy) * f->per_det;
    const float dy = (f->a * d->gy - f->b * d->gx) * f->per_det, per_z = f->per_z;
    dt[0] += camera->fx * per_z * dx, dt[1] += camera->fy * per_z * dy;
    dt[2] += d->value[FFP_CHANNEL_DEPTH - 1] -
             (camera->fx * f->t[0] * dx + camera->fy * f->t[1] * dy) * per_z * per_z;
}

// From the splat's axes in the camera's frame, and its normal, to the quaternion as given.
static __device__ inline void rotation_backward(const Frame *f, const FfpCamera *camera, const Chain *c,
                                                const float d_normal[3], float d_rotation[4]) {
    float dR[9], dq[4], along = 0;
    for (int r = 0; r < 3; r++) {
        const float *w = camera->pose + 4 * r;
        for (int k = 0; k < 3; k++)
            dR[3 * r + k] = w[0] * c->dK[k] + w[1] * c->dK[3 + k] + w[2] * c->dK[6 + k] +
                            (f->shortest[k] ? f->turn * d_normal[r] : 0);
    }
    rotation_matrix_backward(f->q, dR, dq);
    for (int k = 0; k < 4; k++) along += dq[k] * f->q[k];
    for (int k = 0; k < 4; k++) d_rotation[k] = (dq[k] - along * f->q[k]) * f->per_length;
}

// Sums the splat's slots in order; false when no tile touched it.
static __device__ inline bool sum_slots(const FfpTiling *t, size_t i, FfpDeviceSplatGrad *sum) {
    bool any = false;
    float4 *to = (float4 *)sum;
    for (int q = 0; q < FFP_SPLAT_QUADS; q++) to[q] = float4{0, 0, 0, 0};
    for (int64_t j = t->first[i]; j < t->first[i + 1]; j++) {
        if (!t->touched[j]) continue;
        any = true;
        const float4 *from = (const float4 *)&t->slots[j];
        for (int q = 0; q < FFP_SPLAT_QUADS; q++) {
            const float4 part = from[q];
            to[q] = float4{to[q].x + part.x, to[q].y + part.y, to[q].z + part.z, to[q].w + part.w};
        }
    }
    return any;
}

static __device__ inline void geometry_backward(const FfpGaussians *g, size_t i, const FfpDeviceView *view,
                                                const FfpDeviceSplatGrad *d, const FfpGaussians *grad) {
    Frame f;
    Chain c;
    float ds[3], dq[4];
    make_frame(g, i, view, &f);
    conic_backward(&f, d, c.G);
    grad->opacity[i] += opacity_backward(&f, view, g->opacity[i], d->g, c.G);
    for (int k = 0; k < 3; k++) {
        c.dM[k] = 2 * (c.G[0] * f.M[k] + c.G[1] * f.M[3 + k]);
        c.dM[3 + k] = 2 * (c.G[1] * f.M[k] + c.G[2] * f.M[3 + k]);
    }
    axes_backward(&f, &view->camera, &c, ds);
    position_backward(&f, &view->camera, d, c.dt);
    rotation_backward(&f, &view->camera, &c, d->value + FFP_CHANNEL_NORMAL - 1, dq);
    for (size_t k = 0; k < 3; k++) {
        const float *w = view->camera.pose + 4 * k;
        grad->scale[3 * i + k] += ds[k];
        grad->centre[3 * i + k] += w[0] * c.dt[0] + w[1] * c.dt[1] + w[2] * c.dt[2];
    }
    for (size_t k = 0; k < 4; k++) grad->rotation[4 * i + k] += dq[k];
}

static __global__ void __launch_bounds__(BLOCK)
    project_splats_backward(FfpTiling t, FfpGaussians g, const __grid_constant__ FfpDeviceView view,
                            FfpGaussians grad) {
    const size_t i = ffp_thread();
    FfpDeviceSplatGrad sum;
    if (i >= (size_t)t.gaussians || !sum_slots(&t, i, &sum)) return;
    for (size_t k = 0; k < 3; k++) {
        grad.albedo[3 * i + k] += sum.value[FFP_CHANNEL_ALBEDO - 1 + k];
        grad.ambient[3 * i + k] += sum.value[FFP_CHANNEL_AMBIENT - 1 + k];
        if (g.scatters) grad.scattered[3 * i + k] += sum.value[FFP_CHANNEL_SCATTERED - 1 + k];
    }
    grad.roughness[i] += sum.value[FFP_CHANNEL_ROUGHNESS - 1];
    geometry_backward(&g, i, &view, &sum, &grad);
}

void ffp_cuda_project_backward(const FfpTiling *tiling, const FfpGaussians *gaussians,
                               const FfpDeviceView *view, FfpGaussians *grad) {
    const unsigned blocks = ffp_blocks((size_t)tiling->gaussians, BLOCK);
    ffp_launch(project_splats_backward, dim3(blocks), dim3(BLOCK), *tiling, *gaussians, *view, *grad);
}
