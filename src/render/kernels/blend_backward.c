// The gradient of blending, splat by splat, front to back as forward: the transmittance is then exactly what
// it was, and the sum over the splats behind is the whole less those in front.
#include "render/kernels/blocks.h"

enum { ROW = 16, MOMENTS = 8 };

typedef real Row __attribute__((vector_size(ROW * sizeof(real))));
typedef real Moments __attribute__((vector_size(MOMENTS * sizeof(real))));

// What is known of a block's pixels.
typedef struct Pixels {
    Lanes grad[FFP_CHANNELS], spread;   // of the loss; spread: twice that of the distortion
    Lanes opacity, depth;               // whole sums over the splats: A_tot, E_tot
    Lanes opacity_so_far, depth_so_far; // sums over the splats in front: A, E
    Lanes rest;                         // sum of w_j dL/dw_j over the splats behind
    Lanes transmittance;
    Row channels[LANES]; // grad again, pixel by pixel
} Pixels;

// A splat's gradient at a block's pixels: dL/dsigma, weight, and the distortion's share of w dL/dz.
typedef struct Local {
    Lanes g, weight, depth;
} Local;

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

static void load_pixel(const FfpGbuffer *out, const FfpGbuffer *grad, int64_t pixel, int l, Pixels *p) {
    const Planes values = gbuffer_planes(out, FFP_CHANNELS), grads = gbuffer_planes(grad, FFP_CHANNELS);
    // The distortion is of second degree in w, the rest of first: sum w dL/dw, by Euler.
    real total = 2 * grad->distortion[pixel] * out->distortion[pixel];
    for (int k = 0; k < FFP_CHANNELS; k++) {
        const real d = grads.plane[k][pixel * grads.stride[k]];
        p->grad[k][l] = p->channels[l][k] = d;
        total += d * values.plane[k][pixel * values.stride[k]];
    }
    p->spread[l] = 2 * grad->distortion[pixel];
    p->opacity[l] = out->opacity[pixel], p->depth[l] = out->depth[pixel];
    p->rest[l] = total;
}

// Returns the lanes of weight > 0; where there are none, d is not set.
// dL/dalpha_i = T_i dL/dw_i - sum_{j>i} w_j dL/dw_j / (1 - alpha_i).
ALWAYS_INLINE unsigned block_backward(const FfpSplat *s, Lanes columns, Lanes rows, real firmness, Pixels *p,
                                      Local *d) {
    const Cover c = cover_block(s, columns, rows, firmness, &p->transmittance);
    const Lanes none = {0};
    const unsigned touched = lanes_bits(c.alpha > none);
    if (!touched) return 0;
    const real z = s->value[FFP_CHANNEL_DEPTH];
    Lanes slope = p->grad[0];
#pragma GCC unroll 12
    for (int k = 1; k < FFP_CHANNELS; k++) slope += s->value[k] * p->grad[k];
    const Lanes w = d->weight = c.alpha * c.before;
    // weight in front less weight behind
    const Lanes balance = 2 * p->opacity_so_far + w - p->opacity;
    const Lanes dw = slope + p->spread * (z * (balance - w) + p->depth - 2 * p->depth_so_far);
    const Lanes rest = p->rest - w * dw;
    p->rest = rest;
    p->opacity_so_far += w;
    p->depth_so_far += z * w;
    const Lanes d_alpha = c.before * dw - rest / (1 - c.alpha);
    const Where moves = (c.alpha > none) & (c.covered <= lanes_all(FFP_ALPHA_MAX));
    const Lanes steepness = 1.0F + firmness * (1.0F - 2 * c.density);
    d->g = lanes_keep(-c.density * steepness * d_alpha, moves);
    d->depth = w * p->spread * balance;
    return touched;
}

// A splat's sums over the blocks, as in FfpSplatGrad; depth: the distortion's share of that channel.
typedef struct Gathered {
    real g, gx, gy, gxx, gxy, gyy, depth;
    Row value;
} Gathered;

// Adds a block's part; (x, y) leads from the block's middle to the splat.
ALWAYS_INLINE void gather_block(const Local *d, unsigned touched, const Row *channels,
                                const Monomials *monomials, real x, real y, Gathered *sum) {
    Moments m = {0};
    for (unsigned lanes = touched; lanes; lanes &= lanes - 1) {
        const int l = __builtin_ctz(lanes);
        sum->value += d->weight[l] * channels[l];
        m += d->g[l] * monomials->lane[l];
        sum->depth += d->depth[l];
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

// One splat in one tile: fills the slot, or returns false and leaves it where no pixel saw the splat.
static bool splat_backward(const FfpSplat *s, const Tile *tile, uint64_t blocks, const Monomials *monomials,
                           Pixels *pixels, FfpSplatGrad *slot) {
    bool touched = false;
    Gathered sum = {.depth = 0};
    for (; blocks; blocks &= blocks - 1) {
        const int b = __builtin_ctzll(blocks);
        Local d;
        const unsigned lanes =
            block_backward(s, block_columns(tile, b), block_rows(tile, b), tile->firmness, &pixels[b], &d);
        if (!lanes) continue;
        touched = true;
        const real x = s->x - ((real)(tile->x0 + lane_x(b, 0)) + (0.5F + MIDDLE_X));
        const real y = s->y - ((real)(tile->y0 + lane_y(b, 0)) + (0.5F + MIDDLE_Y));
        gather_block(&d, lanes, pixels[b].channels, monomials, x, y, &sum);
    }
    if (!touched) return false;
    slot->g = sum.g, slot->gx = sum.gx, slot->gy = sum.gy;
    slot->gxx = sum.gxx, slot->gxy = sum.gxy, slot->gyy = sum.gyy;
    for (int k = 1; k < FFP_CHANNELS; k++) slot->value[k] = sum.value[k];
    slot->value[FFP_CHANNEL_DEPTH] = sum.value[FFP_CHANNEL_DEPTH] + sum.depth;
    return true;
}

static uint64_t find_open(const Pixels *pixels) {
    uint64_t open = 0;
    for (int b = 0; b < BLOCKS; b++)
        if (lanes_bits(pixels[b].transmittance > (Lanes){0})) open |= (uint64_t)1 << b;
    return open;
}

void FFP_K(blend_tile_backward)(FfpRaster *raster, int t, const FfpGbuffer *out, const FfpGbuffer *grad) {
    const Tile tile = find_tile(raster, t);
    if (tile.count == 0) return;
    Pixels pixels[BLOCKS];
    memset(pixels, 0, sizeof pixels);
    for (int b = 0; b < BLOCKS; b++) {
        pixels[b].transmittance = start_transmittance(raster, &tile, b);
        for (int l = 0; l < LANES; l++) {
            const int64_t pixel = lane_pixel(raster, &tile, b, l);
            if (pixel >= 0) load_pixel(out, grad, pixel, l, &pixels[b]);
        }
    }
    const Monomials monomials = lane_monomials();
    uint64_t open = 0;
    for (int64_t i = 0; i < tile.count; i++) {
        if (i % 32 == 0) open = find_open(pixels);
        if (!open) break;
        fetch_splat(raster, &tile, i + FETCH_AHEAD);
        const int32_t splat = tile.order[i];
        const FfpSplat *s = &raster->splats[splat];
        const int64_t slot = slot_of(raster, splat, &tile);
        raster->touched[slot] =
            splat_backward(s, &tile, splat_blocks(s, &tile) & open, &monomials, pixels, &raster->slots[slot]);
    }
}
