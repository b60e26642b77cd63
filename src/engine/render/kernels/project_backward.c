// From the tiles' gradients of the splats to those of the Gaussians (see project.c).
#include "engine/render/kernels/frame.h"

// A batch's gradients: of what the tiles gathered, and of the Gaussians' attributes.
typedef struct BatchGrad {
    Column g, gx, gy, gxx, gxy, gyy, depth, normal[3];
    Column centre[3], scale[3], rotation[4], opacity;
} BatchGrad;

// Gradients on the way from the covariance to the attributes.
typedef struct Chain {
    Lanes G[3]; // for the blurred covariance, as a full symmetric matrix: G00, G01 = G10, G11
    Lanes dM[6], dK[9], dt[3];
} Chain;

// The unit quaternion's gradient from that for its matrix.
ALWAYS_INLINE void rotation_matrix_backward(const Lanes q[4], const Lanes d[9], Lanes dq[4]) {
    const Lanes w = q[0], x = q[1], y = q[2], z = q[3];
    dq[0] = 2 * (x * (d[7] - d[5]) + y * (d[2] - d[6]) + z * (d[3] - d[1]));
    dq[1] = 2 * (y * (d[1] + d[3]) + z * (d[2] + d[6]) + w * (d[7] - d[5]) - 2 * x * (d[4] + d[8]));
    dq[2] = 2 * (x * (d[1] + d[3]) + z * (d[5] + d[7]) + w * (d[2] - d[6]) - 2 * y * (d[0] + d[8]));
    dq[3] = 2 * (x * (d[2] + d[6]) + y * (d[5] + d[7]) + w * (d[3] - d[1]) - 2 * z * (d[0] + d[4]));
}

// From the moments to the covariance: sigma = (A dx^2 + C dy^2) / 2 + B dx dy with (A, B, C) its inverse.
ALWAYS_INLINE void conic_backward(const Frame *f, Lanes gxx, Lanes gxy, Lanes gyy, Lanes G[3]) {
    const Lanes A = f->c * f->per_det, B = -f->b * f->per_det, C = f->a * f->per_det;
    const Lanes h = 0.5F * gxy, dA = 0.5F * gxx, dC = 0.5F * gyy;
    const Lanes p = A * dA + B * h, q = A * h + B * dC, r = B * dA + C * h, s = B * h + C * dC;
    G[0] = -(p * A + q * B);
    G[1] = -(p * B + q * C);
    G[2] = -(r * B + s * C);
}

// Through opacity = given * sqrt(ratio): adds to G, returns the gradient for the given opacity.
ALWAYS_INLINE Lanes compensation_backward(const Frame *f, Lanes given, real blur, Lanes d, Lanes G[3]) {
    const Lanes root = compensation(f);
    const Where moves = root > lanes_all(FFP_COMPENSATION_MIN);
    const Lanes step = lanes_keep(d * given * f->per_det / (2 * root), moves);
    G[0] += step * (f->c - blur - f->ratio * f->c);
    G[1] -= step * (1 - f->ratio) * f->b;
    G[2] += step * (f->a - blur - f->ratio * f->a);
    return d * root;
}

// From M = J K diag(scale) back to scale, K and (through J) the centre in the camera's frame.
ALWAYS_INLINE void axes_backward(const Frame *f, const FfpCamera *camera, Chain *c, Lanes ds[3]) {
    const Lanes *dM = c->dM, none = {0};
    Lanes dJ[4] = {none, none, none, none};
    for (int k = 0; k < 3; k++) {
        const Lanes d[3] = {f->J[0] * dM[k], f->J[2] * dM[3 + k], f->J[1] * dM[k] + f->J[3] * dM[3 + k]};
        const Lanes s = f->scale[k];
        ds[k] = d[0] * f->K[k] + d[1] * f->K[3 + k] + d[2] * f->K[6 + k];
        for (int r = 0; r < 3; r++) c->dK[3 * r + k] = d[r] * s;
        dJ[0] += dM[k] * f->K[k] * s, dJ[1] += dM[k] * f->K[6 + k] * s;
        dJ[2] += dM[3 + k] * f->K[3 + k] * s, dJ[3] += dM[3 + k] * f->K[6 + k] * s;
    }
    const Lanes x = camera->fx * f->per_z * f->per_z, y = camera->fy * f->per_z * f->per_z;
    const Lanes one = lanes_all(1), two = lanes_all(2);
    // Where x/z is held, tx moves with z, which takes one of the two powers of z away.
    c->dt[0] = lanes_pick(f->held_x, none, -x * dJ[1]);
    c->dt[1] = lanes_pick(f->held_y, none, -y * dJ[3]);
    c->dt[2] = -x * dJ[0] - y * dJ[2] + lanes_pick(f->held_x, one, two) * x * f->slope_x * dJ[1] +
               lanes_pick(f->held_y, one, two) * y * f->slope_y * dJ[3];
}

// From the position in the image and the depth to the centre in the camera's frame.
ALWAYS_INLINE void position_backward(const Frame *f, const FfpCamera *camera, const BatchGrad *d, int group,
                                     Lanes dt[3]) {
    const Lanes gx = d->gx.group[group], gy = d->gy.group[group];
    const Lanes dx = (f->c * gx - f->b * gy) * f->per_det, dy = (f->a * gy - f->b * gx) * f->per_det;
    const Lanes per_z = f->per_z;
    dt[0] += camera->fx * per_z * dx, dt[1] += camera->fy * per_z * dy;
    dt[2] += d->depth.group[group] - (camera->fx * f->t[0] * dx + camera->fy * f->t[1] * dy) * per_z * per_z;
}

// From the splat's axes in the camera's frame, and its normal, to the quaternion as given.
ALWAYS_INLINE void rotation_backward(const Frame *f, const FfpCamera *camera, const Chain *c, int group,
                                     BatchGrad *d) {
    Lanes dR[9], dq[4], along = {0};
    for (int r = 0; r < 3; r++) {
        const real *w = camera->pose + 4 * r;
        const Lanes normal = f->turn * d->normal[r].group[group];
        for (int k = 0; k < 3; k++)
            dR[3 * r + k] = w[0] * c->dK[k] + w[1] * c->dK[3 + k] + w[2] * c->dK[6 + k] +
                            lanes_keep(normal, f->shortest[k]);
    }
    rotation_matrix_backward(f->q, dR, dq);
    for (int k = 0; k < 4; k++) along += dq[k] * f->q[k];
    for (int k = 0; k < 4; k++) d->rotation[k].group[group] = (dq[k] - along * f->q[k]) * f->per_length;
}

// density = opacity exp(-sigma): its slope by the opacity is -g / opacity. Adds to G.
ALWAYS_INLINE Lanes opacity_backward(const Frame *f, const View *view, Lanes given, Lanes g, Lanes G[3]) {
    const Lanes held = lanes_min(given, lanes_all(1));
    Lanes d;
    if (view->compensation)
        d = compensation_backward(f, held, view->blur, -g / (held * compensation(f)), G);
    else
        d = -g / held;
    return lanes_keep(d, given <= lanes_all(1));
}

// From the moments to the opacity and, by G, to M.
ALWAYS_INLINE void moments_backward(const Batch *in, int group, const View *view, const Frame *f,
                                    BatchGrad *d, Chain *c) {
    conic_backward(f, d->gxx.group[group], d->gxy.group[group], d->gyy.group[group], c->G);
    d->opacity.group[group] = opacity_backward(f, view, in->opacity.group[group], d->g.group[group], c->G);
    for (int k = 0; k < 3; k++) {
        c->dM[k] = 2 * (c->G[0] * f->M[k] + c->G[1] * f->M[3 + k]);
        c->dM[3 + k] = 2 * (c->G[1] * f->M[k] + c->G[2] * f->M[3 + k]);
    }
}

static void group_backward(const Batch *in, int group, const View *view, BatchGrad *d) {
    const FfpCamera *camera = &view->camera;
    const Frame f = make_frame(in, group, view);
    Chain c;
    Lanes ds[3];
    moments_backward(in, group, view, &f, d, &c);
    axes_backward(&f, camera, &c, ds);
    position_backward(&f, camera, d, group, c.dt);
    rotation_backward(&f, camera, &c, group, d);
    for (int k = 0; k < 3; k++) {
        const real *w = camera->pose + 4 * k;
        d->scale[k].group[group] = ds[k];
        d->centre[k].group[group] = w[0] * c.dt[0] + w[1] * c.dt[1] + w[2] * c.dt[2];
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
        sum->g += part->g;
        sum->gx += part->gx;
        sum->gy += part->gy;
        sum->gxx += part->gxx;
        sum->gxy += part->gxy;
        sum->gyy += part->gyy;
        for (int k = 1; k < raster->channels; k++) sum->value[k] += part->value[k];
    }
    return any;
}

static void add_to_grads(const FfpSplatGrad *sum, int l, BatchGrad *d) {
    d->g.at[l] = sum->g;
    d->gx.at[l] = sum->gx;
    d->gy.at[l] = sum->gy;
    d->gxx.at[l] = sum->gxx;
    d->gxy.at[l] = sum->gxy;
    d->gyy.at[l] = sum->gyy;
    d->depth.at[l] = sum->value[FFP_CHANNEL_DEPTH];
    for (int k = 0; k < 3; k++) d->normal[k].at[l] = sum->value[FFP_CHANNEL_NORMAL + k];
}

static void batch_backward(Batch *batch, const View *view, BatchGrad *d, FfpGaussians *grad) {
    for (int group = 0; group * LANES < batch->count; group++) group_backward(batch, group, view, d);
    for (int l = 0; l < batch->count; l++) {
        const int64_t i = batch->index[l];
        for (int k = 0; k < 3; k++) {
            grad->centre[3 * i + k] += d->centre[k].at[l];
            grad->scale[3 * i + k] += d->scale[k].at[l];
        }
        for (int k = 0; k < 4; k++) grad->rotation[4 * i + k] += d->rotation[k].at[l];
        grad->opacity[i] += d->opacity.at[l];
    }
    batch->count = 0;
}

void FFP_K(project_chunk_backward)(const FfpRaster *raster, const FfpGaussians *g, const FfpCamera *camera,
                                   const FfpRenderSettings *settings, const FfpChunk *chunk,
                                   FfpGaussians *grad) {
    const View view = {*camera, settings->blur, settings->compensation, settings->firmness};
    Batch batch = {0};
    BatchGrad d = {0};
    for (int32_t s = chunk->first; s < chunk->first + chunk->drawn; s++) {
        FfpSplatGrad sum;
        if (!sum_slots(raster, s, &sum)) continue;
        const int64_t i = raster->splats[s].gaussian;
        for (int k = 0; k < 3; k++) {
            grad->albedo[3 * i + k] += sum.value[FFP_CHANNEL_ALBEDO + k];
            grad->ambient[3 * i + k] += sum.value[FFP_CHANNEL_AMBIENT + k];
            if (raster->channels == FFP_CHANNELS)
                grad->scattered[3 * i + k] += sum.value[FFP_CHANNEL_SCATTERED + k];
        }
        grad->roughness[i] += sum.value[FFP_CHANNEL_ROUGHNESS];
        add_to_grads(&sum, batch.count, &d);
        add_to_batch(g, i, &batch);
        if (batch.count == BATCH) batch_backward(&batch, &view, &d, grad);
    }
    batch_backward(&batch, &view, &d, grad);
}

// x = fx t0 / z + cx, and the row of M that fx scales: all of it, or where t0 / z is held at the edge, which
// moves with fx the other way, its first part alone.
ALWAYS_INLINE void focal_group(const Batch *in, int group, const View *view, BatchGrad *d, Lanes focal[2]) {
    const Frame f = make_frame(in, group, view);
    const Lanes gx = d->gx.group[group], gy = d->gy.group[group], none = {0};
    Chain c;
    moments_backward(in, group, view, &f, d, &c);
    Lanes along_x = (f.c * gx - f.b * gy) * f.per_det * f.t[0],
          along_y = (f.a * gy - f.b * gx) * f.per_det * f.t[1];
    for (int k = 0; k < 3; k++) {
        const Lanes s = f.scale[k];
        along_x += c.dM[k] * s * (f.K[k] - lanes_pick(f.held_x, none, f.slope_x) * f.K[6 + k]);
        along_y += c.dM[3 + k] * s * (f.K[3 + k] - lanes_pick(f.held_y, none, f.slope_y) * f.K[6 + k]);
    }
    focal[0] = along_x * f.per_z, focal[1] = along_y * f.per_z;
}

static void focal_batch(Batch *batch, const View *view, BatchGrad *d, double focal[2]) {
    for (int group = 0; group * LANES < batch->count; group++) {
        Lanes part[2];
        focal_group(batch, group, view, d, part);
        for (int l = 0; l < LANES && group * LANES + l < batch->count; l++)
            for (int k = 0; k < 2; k++) focal[k] += (double)part[k][l];
    }
    batch->count = 0;
}

void FFP_K(focal_chunk)(const FfpRaster *raster, const FfpGaussians *g, const FfpCamera *camera,
                        const FfpRenderSettings *settings, const FfpChunk *chunk, double focal[2]) {
    const View view = {*camera, settings->blur, settings->compensation, settings->firmness};
    Batch batch = {0};
    BatchGrad d = {0};
    for (int32_t s = chunk->first; s < chunk->first + chunk->drawn; s++) {
        FfpSplatGrad sum;
        if (!sum_slots(raster, s, &sum)) continue;
        add_to_grads(&sum, batch.count, &d);
        add_to_batch(g, raster->splats[s].gaussian, &batch);
        if (batch.count == BATCH) focal_batch(&batch, &view, &d, focal);
    }
    focal_batch(&batch, &view, &d, focal);
}
