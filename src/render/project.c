// A Gaussian as a camera sees it: EWA projection (Zwicker et al. 2001) in the form of 3D Gaussian Splatting,
// and back.
#include <string.h>
#include "render/raster.h"

// The least compensation: its square root has no slope at 0, where a flat splat is seen edge-on.
#define COMPENSATION_MIN 0.005F

// Everything between a Gaussian's attributes and its 2D covariance. M M^T = covariance before the blur.
typedef struct Frame {
    real q[4], length; // unit quaternion, and the given one's length
    real R[9];         // splat axes to world
    real K[9];         // splat axes to camera
    real t[3];         // centre in the camera's frame
    real tx, ty;       // t[0], t[1], held inside the field of view for the Jacobian's sake
    bool held_x, held_y;
    real J[4];         // J00, J02, J11, J12; the others are 0
    real M[6];         // J K diag(scale)
    real a, b, c, det; // blurred covariance and its determinant
    real ratio;        // det before the blur / det after
} Frame;

static void rotation_matrix(const real q[4], real R[9]) {
    const real w = q[0], x = q[1], y = q[2], z = q[3];
    R[0] = 1 - 2 * (y * y + z * z), R[1] = 2 * (x * y - w * z), R[2] = 2 * (x * z + w * y);
    R[3] = 2 * (x * y + w * z), R[4] = 1 - 2 * (x * x + z * z), R[5] = 2 * (y * z - w * x);
    R[6] = 2 * (x * z - w * y), R[7] = 2 * (y * z + w * x), R[8] = 1 - 2 * (x * x + y * y);
}

// dq += gradient for the unit quaternion from that for its matrix.
static void rotation_matrix_backward(const real q[4], const real d[9], real dq[4]) {
    const real w = q[0], x = q[1], y = q[2], z = q[3];
    dq[0] += 2 * (x * (d[7] - d[5]) + y * (d[2] - d[6]) + z * (d[3] - d[1]));
    dq[1] += 2 * (y * (d[1] + d[3]) + z * (d[2] + d[6]) + w * (d[7] - d[5]) - 2 * x * (d[4] + d[8]));
    dq[2] += 2 * (x * (d[1] + d[3]) + z * (d[5] + d[7]) + w * (d[2] - d[6]) - 2 * y * (d[0] + d[8]));
    dq[3] += 2 * (x * (d[2] + d[6]) + y * (d[5] + d[7]) + w * (d[3] - d[1]) - 2 * z * (d[0] + d[4]));
}

// x/z held between the image's edges and a margin of 0.3 half widths, wherever the principal point lies: far
// outside the image the affine approximation of the perspective would grow without bound.
static real hold(real value, real z, real principal, real focal, real side, bool *held) {
    const real margin = 0.15F * side;
    const real low = (-principal - margin) / focal, high = (side - principal + margin) / focal;
    const real slope = value / z;
    *held = slope < low || slope > high;
    return z * (slope < low ? low : slope > high ? high : slope);
}

// False when the Gaussian cannot be drawn: at or behind the camera, or without a rotation.
static bool make_frame(const FfpGaussians *g, int64_t i, const FfpCamera *camera, real blur, Frame *f) {
    const real *q = g->rotation + 4 * i, *s = g->scale + 3 * i;
    ffp_inverse_transform_point(camera->pose, g->centre + 3 * i, f->t);
    const real z = f->t[2];
    const real largest = fmax(s[0], fmax(s[1], s[2]));
    // Closer than its own deviation the affine approximation means nothing.
    if (!(z > largest) || !(z > 0)) return false;
    f->length = sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
    if (!(f->length > 0)) return false;
    for (int k = 0; k < 4; k++) f->q[k] = q[k] / f->length;
    rotation_matrix(f->q, f->R);
    for (int r = 0; r < 3; r++)
        for (int k = 0; k < 3; k++)
            f->K[3 * r + k] = camera->pose[r] * f->R[k] + camera->pose[4 + r] * f->R[3 + k] +
                              camera->pose[8 + r] * f->R[6 + k];
    f->tx = hold(f->t[0], z, camera->cx, camera->fx, (real)camera->width, &f->held_x);
    f->ty = hold(f->t[1], z, camera->cy, camera->fy, (real)camera->height, &f->held_y);
    f->J[0] = camera->fx / z, f->J[1] = -camera->fx * f->tx / (z * z);
    f->J[2] = camera->fy / z, f->J[3] = -camera->fy * f->ty / (z * z);
    for (int k = 0; k < 3; k++) {
        f->M[k] = (f->J[0] * f->K[k] + f->J[1] * f->K[6 + k]) * s[k];
        f->M[3 + k] = (f->J[2] * f->K[3 + k] + f->J[3] * f->K[6 + k]) * s[k];
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
    return f->det > 0 && f->a < 1e12F && f->c < 1e12F;
}

static int shortest(const real s[3]) {
    return s[0] <= s[1] && s[0] <= s[2] ? 0 : s[1] <= s[2] ? 1 : 2;
}

// +1 when the axis looks back to the camera, else -1.
static real facing(const FfpCamera *camera, const real centre[3], const real R[9], int axis) {
    real along = 0;
    for (int r = 0; r < 3; r++) along += R[3 * r + axis] * (centre[r] - camera->pose[4 * r + 3]);
    return along > 0 ? -1 : 1;
}

// Floor clamped to [0, limit]; anything that is no number becomes 0.
static int32_t clamp_index(real value, int limit) {
    if (!(value > 0)) return 0;
    return value >= (real)limit ? limit : (int32_t)value;
}

// Pixels and tiles where alpha can reach 1/255: the box around that ellipse. False when it misses the image.
static bool splat_bounds(const FfpRaster *raster, const Frame *f, FfpSplat *splat) {
    const real reach = sqrt(2 * log(255 * splat->opacity));
    const real rx = reach * sqrt(f->a), ry = reach * sqrt(f->c);
    const int x0 = clamp_index(floor(splat->x - rx), raster->width),
              x1 = clamp_index(ceil(splat->x + rx), raster->width);
    splat->y0 = clamp_index(floor(splat->y - ry), raster->height);
    splat->y1 = clamp_index(ceil(splat->y + ry), raster->height);
    splat->tile_x0 = x0 / FFP_TILE, splat->tile_x1 = (x1 + FFP_TILE - 1) / FFP_TILE;
    splat->tile_y0 = splat->y0 / FFP_TILE, splat->tile_y1 = (splat->y1 + FFP_TILE - 1) / FFP_TILE;
    return x0 < x1 && splat->y0 < splat->y1;
}

static void project_splat(const FfpRaster *raster, const FfpGaussians *g, const FfpCamera *camera,
                          const FfpRenderSettings *settings, FfpSplat *splat) {
    const int64_t i = splat->gaussian;
    Frame f;
    splat->opacity = 0;
    if (!make_frame(g, i, camera, settings->blur, &f)) return;
    const real compensation = settings->compensation ? fmax(sqrt(f.ratio), (real)COMPENSATION_MIN) : 1;
    const real opacity = fmin(g->opacity[i], (real)1) * compensation;
    if (!(opacity > FFP_ALPHA_MIN)) return;
    splat->opacity = opacity;
    splat->x = camera->fx * f.t[0] / f.t[2] + camera->cx;
    splat->y = camera->fy * f.t[1] / f.t[2] + camera->cy;
    splat->conic[0] = f.c / f.det, splat->conic[1] = -f.b / f.det, splat->conic[2] = f.a / f.det;
    if (!splat_bounds(raster, &f, splat)) {
        splat->opacity = 0;
        return;
    }
    const int axis = shortest(g->scale + 3 * i);
    const real sign = facing(camera, g->centre + 3 * i, f.R, axis);
    splat->value[0] = 1;
    splat->value[FFP_CHANNEL_DEPTH] = f.t[2];
    splat->value[FFP_CHANNEL_ROUGHNESS] = g->roughness[i];
    for (int k = 0; k < 3; k++) {
        splat->value[FFP_CHANNEL_NORMAL + k] = sign * f.R[3 * k + axis];
        splat->value[FFP_CHANNEL_ALBEDO + k] = g->albedo[3 * i + k];
        splat->value[FFP_CHANNEL_AMBIENT + k] = g->ambient[3 * i + k];
    }
}

void ffp_project_splats(FfpRaster *raster, const FfpGaussians *gaussians, const FfpCamera *camera,
                        const FfpRenderSettings *settings) {
    int32_t count = 0;
    for (int64_t i = 0; i < gaussians->count; i++) count += gaussians->opacity[i] >= FFP_ALPHA_MIN;
    ffp_raster_reserve((void **)&raster->splats, &raster->splats_size, (size_t)count + 1, sizeof(FfpSplat));
    raster->n_splats = count;
    int32_t next = 0;
    for (int64_t i = 0; i < gaussians->count; i++)
        if (gaussians->opacity[i] >= FFP_ALPHA_MIN) raster->splats[next++].gaussian = (int32_t)i;
#pragma omp parallel for schedule(static)
    for (int32_t s = 0; s < count; s++)
        project_splat(raster, gaussians, camera, settings, &raster->splats[s]);
}

// Gradient for the blurred covariance (as a full symmetric matrix: G00, G01 = G10, G11) from that for its
// inverse.
static void conic_backward(const real conic[3], const real d[3], real G[3]) {
    const real A = conic[0], B = conic[1], C = conic[2], h = 0.5F * d[1];
    const real p = A * d[0] + B * h, q = A * h + B * d[2], r = B * d[0] + C * h, s = B * h + C * d[2];
    G[0] = -(p * A + q * B);
    G[1] = -(p * B + q * C);
    G[2] = -(r * B + s * C);
}

// Through opacity = given * sqrt(ratio): adds to G, returns the gradient for the given opacity.
static real compensation_backward(const Frame *f, real opacity, real blur, real d, real G[3]) {
    const real compensation = fmax(sqrt(f->ratio), (real)COMPENSATION_MIN);
    if (compensation > COMPENSATION_MIN) {
        const real step = d * opacity / (2 * compensation * f->det);
        G[0] += step * (f->c - blur - f->ratio * f->c);
        G[1] -= step * (1 - f->ratio) * f->b;
        G[2] += step * (f->a - blur - f->ratio * f->a);
    }
    return d * compensation;
}

// From M = J K diag(scale) back to scale, K and (through J) the centre in the camera's frame.
static void axes_backward(const Frame *f, const FfpCamera *camera, const real s[3], const real dM[6],
                          real ds[3], real dK[9], real dt[3]) {
    real dJ[4] = {0};
    for (int k = 0; k < 3; k++) {
        const real d[3] = {f->J[0] * dM[k], f->J[2] * dM[3 + k], f->J[1] * dM[k] + f->J[3] * dM[3 + k]};
        for (int r = 0; r < 3; r++) {
            ds[k] += d[r] * f->K[3 * r + k];
            dK[3 * r + k] = d[r] * s[k];
        }
        dJ[0] += dM[k] * f->K[k] * s[k], dJ[1] += dM[k] * f->K[6 + k] * s[k];
        dJ[2] += dM[3 + k] * f->K[3 + k] * s[k], dJ[3] += dM[3 + k] * f->K[6 + k] * s[k];
    }
    const real z = f->t[2], z2 = z * z;
    const real x3 = camera->fx * f->tx / (z2 * z), y3 = camera->fy * f->ty / (z2 * z);
    // Where x/z is held, tx moves with z, which takes one of the two powers of z away.
    if (!f->held_x) dt[0] -= camera->fx / z2 * dJ[1];
    if (!f->held_y) dt[1] -= camera->fy / z2 * dJ[3];
    dt[2] += -(f->J[0] * dJ[0] + f->J[2] * dJ[2]) / z + (f->held_x ? 1 : 2) * x3 * dJ[1] +
             (f->held_y ? 1 : 2) * y3 * dJ[3];
}

// dq += J^T dR for q / |q|.
static void quaternion_backward(const Frame *f, const real dR[9], real dq[4]) {
    real d[4] = {0};
    rotation_matrix_backward(f->q, dR, d);
    const real along = d[0] * f->q[0] + d[1] * f->q[1] + d[2] * f->q[2] + d[3] * f->q[3];
    for (int k = 0; k < 4; k++) dq[k] += (d[k] - along * f->q[k]) / f->length;
}

static void splat_backward(const FfpSplat *splat, const FfpSplatGrad *d, const FfpGaussians *g,
                           const FfpCamera *camera, const FfpRenderSettings *settings, FfpGaussians *grad) {
    const int64_t i = splat->gaussian;
    const real *s = g->scale + 3 * i;
    Frame f;
    if (!make_frame(g, i, camera, settings->blur, &f)) return;
    real G[3], dM[6], dK[9], dR[9], dt[3] = {0};
    conic_backward(splat->conic, d->conic, G);
    const real given = fmin(g->opacity[i], (real)1);
    const real d_opacity =
        settings->compensation ? compensation_backward(&f, given, settings->blur, d->opacity, G) : d->opacity;
    if (g->opacity[i] <= 1) grad->opacity[i] += d_opacity;
    for (int k = 0; k < 3; k++) {
        dM[k] = 2 * (G[0] * f.M[k] + G[1] * f.M[3 + k]);
        dM[3 + k] = 2 * (G[1] * f.M[k] + G[2] * f.M[3 + k]);
    }
    axes_backward(&f, camera, s, dM, grad->scale + 3 * i, dK, dt);
    const real z = f.t[2];
    dt[0] += camera->fx / z * d->x, dt[1] += camera->fy / z * d->y;
    dt[2] +=
        d->value[FFP_CHANNEL_DEPTH] - (camera->fx * f.t[0] * d->x + camera->fy * f.t[1] * d->y) / (z * z);
    real d_centre[3];
    ffp_rotate(camera->pose, dt, d_centre);

    const int axis = shortest(s);
    const real sign = facing(camera, g->centre + 3 * i, f.R, axis);
    for (int r = 0; r < 3; r++) {
        const real *w = camera->pose + 4 * r;
        for (int k = 0; k < 3; k++) dR[3 * r + k] = w[0] * dK[k] + w[1] * dK[3 + k] + w[2] * dK[6 + k];
        dR[3 * r + axis] += sign * d->value[FFP_CHANNEL_NORMAL + r];
        grad->centre[3 * i + r] += d_centre[r];
        grad->albedo[3 * i + r] += d->value[FFP_CHANNEL_ALBEDO + r];
        grad->ambient[3 * i + r] += d->value[FFP_CHANNEL_AMBIENT + r];
    }
    quaternion_backward(&f, dR, grad->rotation + 4 * i);
    grad->roughness[i] += d->value[FFP_CHANNEL_ROUGHNESS];
}

void ffp_project_splats_backward(const FfpRaster *raster, const FfpGaussians *gaussians,
                                 const FfpCamera *camera, const FfpRenderSettings *settings,
                                 FfpGaussians *grad) {
#pragma omp parallel for schedule(static)
    for (int32_t s = 0; s < raster->n_splats; s++) {
        if (raster->first[s] == raster->first[s + 1]) continue;
        FfpSplatGrad sum = raster->slots[raster->first[s]];
        for (int64_t j = raster->first[s] + 1; j < raster->first[s + 1]; j++) {
            const FfpSplatGrad *part = &raster->slots[j];
            sum.x += part->x, sum.y += part->y, sum.opacity += part->opacity;
            for (int k = 0; k < 3; k++) sum.conic[k] += part->conic[k];
            for (int k = 1; k < FFP_CHANNELS; k++) sum.value[k] += part->value[k];
        }
        splat_backward(&raster->splats[s], &sum, gaussians, camera, settings, grad);
    }
}
