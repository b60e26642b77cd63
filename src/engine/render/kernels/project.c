// Gaussians as a camera sees them: EWA projection (Zwicker et al. 2001) in the form of 3D Gaussian Splatting,
// and back. Gaussians are taken in batches, each number of a batch in a column of its own, and go through
// every formula a vector at a time.
#include "engine/render/kernels/frame.h"

// The appearance of a batch of Gaussians.
typedef struct Seen {
    Column x, y, power[3], opacity, depth, normal[3];
    Column x0, y0, x1, y1; // whole pixels; x0 = x1: not drawn
} Seen;

// No less than log2 of a positive number, by at most 0.02: the exponent, and a parabola for the mantissa.
ALWAYS_INLINE Lanes log2_above(Lanes x) {
#ifdef FFP_REAL_DOUBLE
    for (int l = 0; l < LANES; l++) x[l] = log2(x[l]);
    return x + 0.01F;
#else
    const LaneBits bits = (LaneBits)x;
    const Lanes exponent = __builtin_convertvector((Where)(bits >> 23) - 127, Lanes);
    const Lanes f = (Lanes)((bits & 0x7FFFFFU) | 0x3F800000U) - 1.0F;
    return exponent + f + 0.3465736F * f * (1.0F - f) + 0.01F;
#endif
}

// Whole numbers in [0, limit]; anything that is not a number becomes 0.
ALWAYS_INLINE Lanes clamp_index(Lanes value, int limit) {
    const Lanes held = lanes_min(lanes_max(value, (Lanes){0}), lanes_all((real)limit));
    return __builtin_convertvector(__builtin_convertvector(held, Where), Lanes);
}

// The pixels where alpha can reach 1/255: those with their centre in the box around that ellipse.
ALWAYS_INLINE void bound_splats(const Frame *f, const View *view, int group, Seen *seen) {
    const FfpCamera *camera = &view->camera;
    const Lanes opacity = seen->opacity.group[group] * (1 + view->firmness), // alpha is below that, times exp
        x = seen->x.group[group], y = seen->y.group[group];
    const Where drawn = f->drawn & (opacity > lanes_all(FFP_ALPHA_MIN));
    const Lanes squared = (real)(2 / LOG2_E) * log2_above(lanes_pick(drawn, 255 * opacity, lanes_all(1)));
    const Lanes rx = lanes_sqrt(squared * f->a), ry = lanes_sqrt(squared * f->c);
    seen->x0.group[group] = clamp_index(x - rx + 0.5F, camera->width);
    seen->y0.group[group] = clamp_index(y - ry + 0.5F, camera->height);
    seen->x1.group[group] = lanes_keep(clamp_index(x + rx + 0.5F, camera->width), drawn);
    seen->y1.group[group] = lanes_keep(clamp_index(y + ry + 0.5F, camera->height), drawn);
}

static void see_group(const Batch *in, int group, const View *view, Seen *seen) {
    const FfpCamera *camera = &view->camera;
    const Frame f = make_frame(in, group, view);
    const Lanes given = lanes_min(in->opacity.group[group], lanes_all(1));
    seen->opacity.group[group] = view->compensation ? given * compensation(&f) : given;
    seen->x.group[group] = camera->fx * f.t[0] * f.per_z + camera->cx;
    seen->y.group[group] = camera->fy * f.t[1] * f.per_z + camera->cy;
    seen->depth.group[group] = f.t[2];
    const Lanes scale = (real)(-0.5 * LOG2_E) * f.per_det;
    seen->power[0].group[group] = scale * f.c;
    seen->power[1].group[group] = -2 * scale * f.b;
    seen->power[2].group[group] = scale * f.a;
    for (int k = 0; k < 3; k++) seen->normal[k].group[group] = f.normal[k];
    bound_splats(&f, view, group, seen);
}

static FfpSplat make_splat(const Seen *seen, int l, const FfpGaussians *g, int64_t i) {
    static const real none[3] = {0};
    const real *albedo = g->albedo + 3 * i, *ambient = g->ambient + 3 * i,
               *scattered = g->scatters ? g->scattered + 3 * i : none;
    return (FfpSplat){.x = seen->x.at[l],
                      .y = seen->y.at[l],
                      .power = {seen->power[0].at[l], seen->power[1].at[l], seen->power[2].at[l]},
                      .opacity = seen->opacity.at[l],
                      .value = {1, seen->depth.at[l], seen->normal[0].at[l], seen->normal[1].at[l],
                                seen->normal[2].at[l], albedo[0], albedo[1], albedo[2], g->roughness[i],
                                ambient[0], ambient[1], ambient[2], scattered[0], scattered[1], scattered[2]},
                      .gaussian = (int32_t)i,
                      .x0 = (int32_t)seen->x0.at[l],
                      .y0 = (int32_t)seen->y0.at[l],
                      .x1 = (int32_t)seen->x1.at[l],
                      .y1 = (int32_t)seen->y1.at[l]};
}

static void draw_batch(Batch *batch, const FfpGaussians *g, const View *view, FfpSplat *splats,
                       int32_t *drawn) {
    Seen seen;
    if (batch->count == 0) return;
    for (int group = 0; group * LANES < batch->count; group++) see_group(batch, group, view, &seen);
    for (int l = 0; l < batch->count; l++)
        if (seen.x0.at[l] < seen.x1.at[l] && seen.y0.at[l] < seen.y1.at[l])
            splats[(*drawn)++] = make_splat(&seen, l, g, batch->index[l]);
    batch->count = 0;
}

void FFP_K(project_chunk)(FfpRaster *raster, const FfpGaussians *g, const FfpCamera *camera,
                          const FfpRenderSettings *settings, FfpChunk *chunk) {
    const View view = {*camera, settings->blur, settings->compensation, settings->firmness};
    FfpSplat *splats = raster->splats + chunk->first;
    Batch batch = {0};
    chunk->drawn = 0;
    for (int64_t i = chunk->begin; i < chunk->end; i++) {
        if (!(g->opacity[i] >= FFP_ALPHA_MIN)) continue;
        add_to_batch(g, i, &batch);
        if (batch.count == BATCH) draw_batch(&batch, g, &view, splats, &chunk->drawn);
    }
    draw_batch(&batch, g, &view, splats, &chunk->drawn);
}
