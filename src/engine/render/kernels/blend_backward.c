// The gradient of blending, front to back as forward: the transmittance is then exactly what it was, and the
// sum over the splats behind is the whole less those in front. A batch of splats goes through one block after
// the other: first what each of them covers there, which is a long chain of operations that many splats can
// be on at once, then the gradients of those that cover anything.
#include "engine/render/kernels/blocks.h"

enum { ROW = 16, MOMENTS = 8, BATCH = 64 };

typedef real Row __attribute__((vector_size(ROW * sizeof(real))));
typedef real Moments __attribute__((vector_size(MOMENTS * sizeof(real))));

// The state of a block's pixels.
typedef struct Pixels {
    Lanes grad[FFP_CHANNELS], spread;   // of the loss; spread: twice that of the distortion
    Lanes opacity, depth;               // whole sums over the splats: A_tot, E_tot
    Lanes opacity_so_far, depth_so_far; // sums over the splats in front: A, E
    Lanes rest;                         // sum of w_j dL/dw_j over the splats behind
    Lanes transmittance;
    Row channels[LANES]; // grad again, pixel by pixel
} Pixels;

// Known when this is compiled: whether the loss has a gradient by the distortion, and how many channels are
// blended.
typedef struct Form {
    bool spreads;
    int channels;
} Form;

// A splat's gradient at a block's pixels: dL/dsigma, weight, and the distortion's share of w dL/dz.
typedef struct Local {
    Lanes g, weight, depth;
} Local;

// The splats of a batch that cover some of a block's pixels: which of the batch, and how (as Cover).
typedef struct Covering {
    int count;
    uint8_t place[BATCH];
    unsigned lanes[BATCH]; // where alpha > 0
    Lanes density[BATCH], covered[BATCH], alpha[BATCH], before[BATCH];
} Covering;

// 1, x, y, x^2, x y, y^2 of every lane, from the block's middle.
typedef struct Monomials {
    Moments lane[LANES];
} Monomials;

#define MIDDLE_X (0.5F * (BLOCK_WIDTH - 1))
#define MIDDLE_Y (0.5F * (BLOCK_HEIGHT - 1))

static Monomials lane_monomials(void) {
    Monomials m;
    for (int l = 0; l < LANES; l++) {
        const real x = (real)(l % BLOCK_WIDTH) - MIDDLE_X, y = (real)(l / BLOCK_WIDTH) - MIDDLE_Y;
        m.lane[l] = (Moments){1, x, y, x * x, x * y, y * y, 0, 0};
    }
    return m;
}

// `count` pixels from `pixel` on into the block's lanes from `lane` on.
ALWAYS_INLINE void load_pixels(const FfpGbuffer *out, const FfpGbuffer *grad, int64_t pixel, int lane,
                               const int count, const int channels, Pixels *p) {
    const Planes values = gbuffer_planes(out, channels), grads = gbuffer_planes(grad, channels);
    // The distortion is of second degree in w, the rest of first: sum w dL/dw, by Euler.
    for (int l = 0; l < count; l++) {
        p->spread[lane + l] = 2 * grad->distortion[pixel + l];
        p->rest[lane + l] = p->spread[lane + l] * out->distortion[pixel + l];
        p->opacity[lane + l] = out->opacity[pixel + l];
        p->depth[lane + l] = out->depth[pixel + l];
    }
    FFP_UNROLL(16)
    for (int k = 0; k < channels; k++)
        for (int l = 0; l < count; l++) {
            const int64_t at = (pixel + l) * grads.stride[k];
            p->grad[k][lane + l] = p->channels[lane + l][k] = grads.plane[k][at];
            p->rest[lane + l] += grads.plane[k][at] * values.plane[k][at];
        }
}

ALWAYS_INLINE void load_block(const FfpRaster *raster, const Tile *tile, int b, const FfpGbuffer *out,
                              const FfpGbuffer *grad, const int channels, Pixels *p) {
    const int x = lane_x(b, 0), wide = tile->width - x < BLOCK_WIDTH ? tile->width - x : BLOCK_WIDTH;
    for (int row = 0; row < BLOCK_HEIGHT && lane_y(b, row * BLOCK_WIDTH) < tile->height; row++) {
        const int lane = row * BLOCK_WIDTH;
        const int64_t pixel = (int64_t)(tile->y0 + lane_y(b, lane)) * raster->width + tile->x0 + x;
        if (wide == BLOCK_WIDTH)
            load_pixels(out, grad, pixel, lane, BLOCK_WIDTH, channels, p);
        else
            load_pixels(out, grad, pixel, lane, wide, channels, p);
    }
}

// Those of `count` splats of the batch that cover anything. A splat that covers nothing is written over by
// the next: no branch has to guess.
ALWAYS_INLINE void cover_batch(const FfpSplat *splats, const int32_t *batch, const uint8_t *places, int count,
                               Lanes columns, Lanes rows, real firmness, Lanes *transmittance,
                               Covering *out) {
    Lanes T = *transmittance;
    int n = 0;
    for (int i = 0; i < count; i++) {
        const Cover c = cover_block(&splats[batch[places[i]]], columns, rows, firmness, &T);
        const unsigned lanes = lanes_positive(c.alpha);
        out->place[n] = places[i];
        out->lanes[n] = lanes;
        out->density[n] = c.density;
        out->covered[n] = c.covered;
        out->alpha[n] = c.alpha;
        out->before[n] = c.before;
        n += lanes != 0;
    }
    out->count = n;
    *transmittance = T;
}

// dL/dalpha_i = T_i dL/dw_i - sum_{j>i} w_j dL/dw_j / (1 - alpha_i).
ALWAYS_INLINE Local splat_in_block(const FfpSplat *s, const Covering *c, int i, real firmness,
                                   const Form form, Pixels *p) {
    const Lanes none = {0}, alpha = c->alpha[i], before = c->before[i], density = c->density[i];
    const real z = s->value[FFP_CHANNEL_DEPTH];
    Local d;
    Lanes slope = p->grad[0];
    FFP_UNROLL(16)
    for (int k = 1; k < form.channels; k++) slope += s->value[k] * p->grad[k];
    const Lanes w = d.weight = alpha * before;
    Lanes dw = slope;
    if (form.spreads) {
        // weight in front less weight behind
        const Lanes balance = 2 * p->opacity_so_far + w - p->opacity;
        dw += p->spread * (z * (balance - w) + p->depth - 2 * p->depth_so_far);
        d.depth = w * p->spread * balance;
        p->opacity_so_far += w;
        p->depth_so_far += z * w;
    }
    const Lanes rest = p->rest - w * dw;
    p->rest = rest;
    const Lanes d_alpha = before * dw - rest / (1 - alpha);
    const Where moves = (alpha > none) & (c->covered[i] <= lanes_all(FFP_ALPHA_MAX));
    const Lanes steepness = 1.0F + firmness * (1.0F - 2 * density);
    d.g = lanes_keep(-density * steepness * d_alpha, moves);
    return d;
}

// A splat's sums over the blocks, as in FfpSplatGrad; depth: the distortion's share of that channel.
typedef struct Gathered {
    real g, gx, gy, gxx, gxy, gyy, depth;
    bool touched; // by any pixel
    Row value;
} Gathered;

// Lanes that nothing touches add nothing: with few of them that is cheaper than to look which they are.
ALWAYS_INLINE void add_all_lanes(const Local *d, const bool spreads, const Row *channels,
                                 const Monomials *monomials, Moments *m, Gathered *sum) {
    Moments moments[2] = {{0}, {0}};
    Row rows[2] = {{0}, {0}};
    real weight[LANES], g[LANES];
    memcpy(weight, &d->weight, sizeof weight);
    memcpy(g, &d->g, sizeof g);
    FFP_UNROLL(8)
    for (int l = 0; l < LANES; l++) {
        rows[l % 2] += weight[l] * channels[l];
        moments[l % 2] += g[l] * monomials->lane[l];
        if (spreads) sum->depth += d->depth[l];
    }
    sum->value += rows[0] + rows[1];
    *m = moments[0] + moments[1];
}

// Adds a block's part; (x, y) leads from the block's middle to the splat.
ALWAYS_INLINE void gather_block(const Local *d, unsigned touched, const bool spreads, const Row *channels,
                                const Monomials *monomials, real x, real y, Gathered *sum) {
    Moments m = {0};
    if (sizeof(Lanes) <= 32) {
        add_all_lanes(d, spreads, channels, monomials, &m, sum);
    } else {
        for (unsigned lanes = touched; lanes; lanes &= lanes - 1) {
            const int l = __builtin_ctz(lanes);
            sum->value += d->weight[l] * channels[l];
            m += d->g[l] * monomials->lane[l];
            if (spreads) sum->depth += d->depth[l];
        }
    }
    sum->g += m[0];
    sum->gx += x * m[0] - m[1];
    sum->gy += y * m[0] - m[2];
    sum->gxx += x * (x * m[0] - 2 * m[1]) + m[3];
    sum->gxy += x * (y * m[0] - m[2]) - y * m[1] + m[4];
    sum->gyy += y * (y * m[0] - 2 * m[2]) + m[5];
}

// Where the gradient of splat s in this tile is kept.
static int64_t slot_of(const FfpRaster *raster, int32_t s, const Tile *tile) {
    const FfpTiles tiles = ffp_splat_tiles(&raster->splats[s]);
    const int row = tile->y0 / FFP_TILE - tiles.y0, column = tile->x0 / FFP_TILE - tiles.x0;
    return raster->first[s] + (int64_t)row * (tiles.x1 - tiles.x0) + column;
}

// A batch's splats in one block: adds to their sums.
ALWAYS_INLINE void add_block(const FfpSplat *splats, const int32_t *batch, const Tile *tile, int b,
                             const Covering *c, const Monomials *monomials, const Form form, Pixels *pixels,
                             Gathered *sums) {
    const real middle_x = (real)(tile->x0 + lane_x(b, 0)) + (0.5F + MIDDLE_X);
    const real middle_y = (real)(tile->y0 + lane_y(b, 0)) + (0.5F + MIDDLE_Y);
    for (int i = 0; i < c->count; i++) {
        const FfpSplat *s = &splats[batch[c->place[i]]];
        Gathered *sum = &sums[c->place[i]];
        const Local d = splat_in_block(s, c, i, tile->firmness, form, pixels);
        sum->touched = true;
        gather_block(&d, c->lanes[i], form.spreads, pixels->channels, monomials, s->x - middle_x,
                     s->y - middle_y, sum);
    }
}

ALWAYS_INLINE void block_backward(const FfpSplat *splats, const int32_t *batch, const Tile *tile, int b,
                                  const Covering *c, const Monomials *monomials, const int channels,
                                  Pixels *pixels, Gathered *sums) {
    const unsigned spreads = lanes_positive(pixels->spread) | lanes_positive(-pixels->spread);
    if (spreads)
        add_block(splats, batch, tile, b, c, monomials, (Form){true, channels}, pixels, sums);
    else
        add_block(splats, batch, tile, b, c, monomials, (Form){false, channels}, pixels, sums);
}

static void fill_slot(const Gathered *sum, int channels, FfpSplatGrad *slot) {
    slot->g = sum->g;
    slot->gx = sum->gx;
    slot->gy = sum->gy;
    slot->gxx = sum->gxx;
    slot->gxy = sum->gxy;
    slot->gyy = sum->gyy;
    for (int k = 1; k < channels; k++) slot->value[k] = sum->value[k];
    slot->value[FFP_CHANNEL_DEPTH] = sum->value[FFP_CHANNEL_DEPTH] + sum->depth;
}

// Splats [first, first + count) of the tile's order.
ALWAYS_INLINE void batch_backward(FfpRaster *raster, const Tile *tile, int64_t first, int count,
                                  uint64_t open, const Monomials *monomials, const int channels,
                                  Pixels *pixels) {
    const int32_t *batch = tile->order + first;
    Gathered sums[BATCH];
    Covering covering;
    Lists lists;
    memset(sums, 0, (size_t)count * sizeof *sums);
    list_batch(raster, tile, first, count, open, &lists);
    for (int b = 0; b < BLOCKS; b++) {
        if (!lists.count[b]) continue;
        cover_batch(raster->splats, batch, lists.place[b], lists.count[b], block_columns(tile, b),
                    block_rows(tile, b), tile->firmness, &pixels[b].transmittance, &covering);
        block_backward(raster->splats, batch, tile, b, &covering, monomials, channels, &pixels[b], sums);
    }
    for (int i = 0; i < count; i++) {
        if (!sums[i].touched) continue;
        const int64_t slot = slot_of(raster, batch[i], tile);
        fill_slot(&sums[i], channels, &raster->slots[slot]);
        raster->touched[slot] = true;
    }
}

static uint64_t find_open(const Pixels *pixels) {
    uint64_t open = 0;
    for (int b = 0; b < BLOCKS; b++)
        if (lanes_positive(pixels[b].transmittance)) open |= (uint64_t)1 << b;
    return open;
}

ALWAYS_INLINE void channels_backward(FfpRaster *raster, const Tile *tile, const FfpGbuffer *out,
                                     const FfpGbuffer *grad, const int channels) {
    Pixels pixels[BLOCKS];
    memset(pixels, 0, sizeof pixels);
    for (int b = 0; b < BLOCKS; b++) {
        pixels[b].transmittance = start_transmittance(raster, tile, b);
        load_block(raster, tile, b, out, grad, channels, &pixels[b]);
    }
    const Monomials monomials = lane_monomials();
    for (int64_t first = 0; first < tile->count; first += BATCH) {
        const uint64_t open = find_open(pixels);
        if (!open) break;
        const int count = tile->count - first < BATCH ? (int)(tile->count - first) : BATCH;
        batch_backward(raster, tile, first, count, open, &monomials, channels, pixels);
    }
}

void FFP_K(blend_tile_backward)(FfpRaster *raster, int t, const FfpGbuffer *out, const FfpGbuffer *grad) {
    const Tile tile = find_tile(raster, t);
    if (tile.count == 0) return;
    if (raster->channels == FFP_CHANNELS)
        channels_backward(raster, &tile, out, grad, FFP_CHANNELS);
    else
        channels_backward(raster, &tile, out, grad, FFP_DIRECT_CHANNELS);
}
