// Front-to-back blending of every tile's splats, and its gradient. A tile row is sixteen lanes, worked on
// together.
#include "base/arena.h"
#include "render/raster.h"
#include <string.h>

enum { PIXELS = FFP_TILE * FFP_TILE };

// The planes of a G-buffer in channel order; each value is plane[k][pixel * stride[k]].
typedef struct Planes {
    real *plane[FFP_CHANNELS];
    int stride[FFP_CHANNELS];
} Planes;

static Planes gbuffer_planes(const FfpGbuffer *g, int channels) {
    Planes p = {.plane = {g->opacity, g->depth}, .stride = {1, 1, 3, 3, 3, 3, 3, 3, 1, 3, 3, 3}};
    if (channels <= FFP_SHADOW_CHANNELS) return p;
    for (int k = 0; k < 3; k++) {
        p.plane[FFP_CHANNEL_NORMAL + k] = g->normal + k;
        p.plane[FFP_CHANNEL_ALBEDO + k] = g->albedo + k;
        p.plane[FFP_CHANNEL_AMBIENT + k] = g->ambient + k;
    }
    p.plane[FFP_CHANNEL_ROUGHNESS] = g->roughness;
    return p;
}

// exp(x) for x <= 0, written so that it vectorises in fp32: 2^n from the exponent's bits, 2^f from its series
// (relative error below 2e-7). Below -87 it is as good as 0.
static inline real exp_negative(real x) {
    if (sizeof(real) != sizeof(float)) return exp(x);
    const float t = (float)(x > -87 ? x : -87) * 1.44269504F, n = floorf(t + 0.5F), f = t - n;
    const float series =
        1 + f * (0.693147181F +
                 f * (0.240226507F + f * (0.0555041087F +
                                          f * (0.00961812911F + f * (0.00133335581F + f * 1.54035304e-4F)))));
    const int32_t bits = ((int32_t)n + 127) * (1 << 23);
    float power;
    memcpy(&power, &bits, sizeof power);
    return series * power;
}

typedef struct Tile {
    int x0, y0, width, height; // pixels; width and height below FFP_TILE at the image's right and bottom
    const int32_t *order;
    int64_t count;
} Tile;

static Tile find_tile(const FfpRaster *raster, int t) {
    const int x0 = t % raster->tiles_x * FFP_TILE, y0 = t / raster->tiles_x * FFP_TILE;
    const int width = raster->width - x0, height = raster->height - y0;
    return (Tile){x0,
                  y0,
                  width < FFP_TILE ? width : FFP_TILE,
                  height < FFP_TILE ? height : FFP_TILE,
                  raster->order + raster->tile_first[t],
                  raster->tile_first[t + 1] - raster->tile_first[t]};
}

// 1 inside the image, 0 (nothing can be added) outside.
static void start_transmittance(const Tile *tile, real *transmittance) {
    for (int y = 0; y < FFP_TILE; y++)
        for (int x = 0; x < FFP_TILE; x++)
            transmittance[y * FFP_TILE + x] = x < tile->width && y < tile->height ? 1 : 0;
}

// Which of a tile's rows have a pixel that is not at its end; false when none has.
static bool find_open_rows(const real *transmittance, bool open[FFP_TILE]) {
    bool any = false;
    for (int y = 0; y < FFP_TILE; y++) {
        real most = 0;
#pragma omp simd reduction(max : most)
        for (int x = 0; x < FFP_TILE; x++) {
            const real T = transmittance[y * FFP_TILE + x];
            most = most > T ? most : T;
        }
        open[y] = most > 0;
        any |= open[y];
    }
    return any;
}

// One splat over a row: its density o exp(-sigma), and alpha, 0 where below 1/255 or where the pixel has come
// to its end. Moves the transmittance on; `before` keeps what it was. A pixel whose transmittance would fall
// to 1e-4 stops, without this splat, and is marked by 0.
static inline void cover_row(const FfpSplat *s, real x_first, real dy, real *restrict transmittance,
                             real *restrict density, real *restrict alpha, real *restrict before) {
    const real A = 0.5F * s->conic[0], Bdy = s->conic[1] * dy, Cdy2 = 0.5F * s->conic[2] * dy * dy,
               o = s->opacity;
#pragma omp simd
    for (int x = 0; x < FFP_TILE; x++) {
        const real dx = s->x - (x_first + (real)x);
        const real sigma = (A * dx + Bdy) * dx + Cdy2;
        const real d = o * exp_negative(-(sigma > 0 ? sigma : 0));
        const real a = d < FFP_ALPHA_MIN ? 0 : d > FFP_ALPHA_MAX ? (real)FFP_ALPHA_MAX : d;
        const real T = transmittance[x], next = T * (1 - a);
        const bool open = next > FFP_TRANSMITTANCE_MIN;
        density[x] = d;
        alpha[x] = open ? a : 0;
        before[x] = T;
        transmittance[x] = open ? next : 0;
    }
}

typedef struct Rows {
    int first, end;
} Rows;

static Rows splat_rows(const FfpSplat *s, const Tile *tile) {
    const int first = s->y0 - tile->y0, end = s->y1 - tile->y0;
    return (Rows){first > 0 ? first : 0, end < tile->height ? end : tile->height};
}

// A tile's pixels while they are blended.
typedef struct Sums {
    real value[FFP_CHANNELS][PIXELS], distortion[PIXELS], transmittance[PIXELS];
} Sums;

static void blend_row(const FfpSplat *s, const Tile *tile, int y, int channels, Sums *restrict sums) {
    const int row = y * FFP_TILE;
    const real dy = s->y - ((real)(tile->y0 + y) + 0.5F), z = s->value[FFP_CHANNEL_DEPTH];
    real density[FFP_TILE], alpha[FFP_TILE], before[FFP_TILE], weight[FFP_TILE];
    cover_row(s, (real)tile->x0 + 0.5F, dy, sums->transmittance + row, density, alpha, before);
    // Distortion, each pair with those in front of it, twice: 2 w (z sum w_j - sum w_j z_j).
#pragma omp simd
    for (int x = 0; x < FFP_TILE; x++) {
        weight[x] = alpha[x] * before[x];
        sums->distortion[row + x] += 2 * weight[x] * (z * sums->value[0][row + x] - sums->value[1][row + x]);
    }
    for (int k = 0; k < channels; k++) {
        const real value = s->value[k];
#pragma omp simd
        for (int x = 0; x < FFP_TILE; x++) sums->value[k][row + x] += weight[x] * value;
    }
}

static void blend_tile(const FfpRaster *raster, const Tile *tile, int channels, Sums *sums) {
    bool open[FFP_TILE];
    start_transmittance(tile, sums->transmittance);
    for (int64_t i = 0; i < tile->count; i++) {
        if (i % FFP_TILE == 0 && !find_open_rows(sums->transmittance, open)) break;
        const FfpSplat *s = &raster->splats[tile->order[i]];
        const Rows rows = splat_rows(s, tile);
        for (int y = rows.first; y < rows.end; y++)
            if (open[y]) blend_row(s, tile, y, channels, sums);
    }
}

void ffp_blend(const FfpRaster *raster, int channels, FfpGbuffer *out) {
    const Planes planes = gbuffer_planes(out, channels);
    const int tiles = raster->tiles_x * raster->tiles_y;
#pragma omp parallel for schedule(dynamic)
    for (int t = 0; t < tiles; t++) {
        const Tile tile = find_tile(raster, t);
        Sums sums;
        memset(&sums, 0, sizeof sums);
        blend_tile(raster, &tile, channels, &sums);
        for (int y = 0; y < tile.height; y++)
            for (int x = 0; x < tile.width; x++) {
                const size_t pixel = (size_t)(tile.y0 + y) * (size_t)raster->width + (size_t)(tile.x0 + x);
                const int i = y * FFP_TILE + x;
                for (int k = 0; k < channels; k++)
                    planes.plane[k][pixel * (size_t)planes.stride[k]] = sums.value[k][i];
                if (out->distortion) out->distortion[pixel] = sums.distortion[i];
            }
    }
}

// What the backward pass knows of a tile's pixels.
typedef struct Pixels {
    real grad[FFP_CHANNELS][PIXELS], grad_distortion[PIXELS]; // of the loss
    real opacity[PIXELS], depth[PIXELS];                      // whole sums over the splats: A_tot, E_tot
    real opacity_so_far[PIXELS], depth_so_far[PIXELS];        // sums over the splats in front: A, E
    real rest[PIXELS];                                        // sum of w_j dL/dw_j over the splats behind
    real transmittance[PIXELS];
} Pixels;

// Sums over the rows, lane by lane, for one splat in one tile. With dL/dsigma = g: g, g dy, g dy^2; and w
// dL/d(channel).
typedef struct Lanes {
    real g[FFP_TILE], g_dy[FFP_TILE], g_dy2[FFP_TILE];
    real value[FFP_CHANNELS][FFP_TILE];
} Lanes;

static void load_pixels(const FfpRaster *raster, const Tile *tile, const FfpGbuffer *out,
                        const FfpGbuffer *grad, Pixels *p) {
    const Planes values = gbuffer_planes(out, FFP_CHANNELS), grads = gbuffer_planes(grad, FFP_CHANNELS);
    memset(p, 0, sizeof *p);
    for (int y = 0; y < tile->height; y++)
        for (int x = 0; x < tile->width; x++) {
            const size_t pixel = (size_t)(tile->y0 + y) * (size_t)raster->width + (size_t)(tile->x0 + x);
            const int i = y * FFP_TILE + x;
            // The distortion is of second degree in w, the rest of first: sum w dL/dw, by Euler.
            real total = 2 * grad->distortion[pixel] * out->distortion[pixel];
            for (int k = 0; k < FFP_CHANNELS; k++) {
                const size_t at = pixel * (size_t)grads.stride[k];
                p->grad[k][i] = grads.plane[k][at];
                total += grads.plane[k][at] * values.plane[k][at];
            }
            p->grad_distortion[i] = grad->distortion[pixel];
            p->opacity[i] = out->opacity[pixel], p->depth[i] = out->depth[pixel];
            p->rest[i] = total;
        }
    start_transmittance(tile, p->transmittance);
}

// Front to back, as forward: T is then exactly what it was, and the sum over the splats behind is the whole
// less those in front. dL/dalpha_i = T_i dL/dw_i - sum_{j>i} w_j dL/dw_j / (1 - alpha_i).
static void blend_row_backward(const FfpSplat *s, const Tile *tile, int y, Pixels *restrict p,
                               Lanes *restrict lanes) {
    const int row = y * FFP_TILE;
    const real dy = s->y - ((real)(tile->y0 + y) + 0.5F), z = s->value[FFP_CHANNEL_DEPTH];
    real density[FFP_TILE], alpha[FFP_TILE], before[FFP_TILE], weight[FFP_TILE];
    cover_row(s, (real)tile->x0 + 0.5F, dy, p->transmittance + row, density, alpha, before);
#pragma omp simd
    for (int x = 0; x < FFP_TILE; x++) {
        const int i = row + x;
        real slope = 0;
        for (int k = 0; k < FFP_CHANNELS; k++) slope += p->grad[k][i] * s->value[k];
        const real w = weight[x] = alpha[x] * before[x];
        // weight in front less weight behind
        const real balance = 2 * p->opacity_so_far[i] + w - p->opacity[i];
        const real spread = 2 * p->grad_distortion[i];
        const real dw = slope + spread * (z * balance + p->depth[i] - 2 * p->depth_so_far[i] - w * z);
        p->rest[i] -= w * dw;
        p->opacity_so_far[i] += w;
        p->depth_so_far[i] += w * z;
        const real d_alpha = before[x] * dw - p->rest[i] / (1 - alpha[x]);
        const bool moves = alpha[x] > 0 && density[x] <= FFP_ALPHA_MAX;
        const real g = moves ? -density[x] * d_alpha : 0;
        lanes->g[x] += g;
        lanes->g_dy[x] += g * dy;
        lanes->g_dy2[x] += g * dy * dy;
        lanes->value[FFP_CHANNEL_DEPTH][x] += w * spread * balance;
    }
    for (int k = 1; k < FFP_CHANNELS; k++)
#pragma omp simd
        for (int x = 0; x < FFP_TILE; x++) lanes->value[k][x] += weight[x] * p->grad[k][row + x];
}

static real sum_lanes(const real *v) {
    real sum = 0;
#pragma omp simd reduction(+ : sum)
    for (int x = 0; x < FFP_TILE; x++) sum += v[x];
    return sum;
}

static void gather_lanes(const FfpSplat *s, const Tile *tile, const Lanes *lanes, FfpSplatGrad *out) {
    real g = 0, gx = 0, gy = 0, gxx = 0, gxy = 0, gyy = 0;
#pragma omp simd reduction(+ : g, gx, gy, gxx, gxy, gyy)
    for (int x = 0; x < FFP_TILE; x++) {
        const real dx = s->x - ((real)(tile->x0 + x) + 0.5F);
        g += lanes->g[x], gy += lanes->g_dy[x], gyy += lanes->g_dy2[x];
        gx += dx * lanes->g[x], gxy += dx * lanes->g_dy[x], gxx += dx * dx * lanes->g[x];
    }
    out->x = s->conic[0] * gx + s->conic[1] * gy;
    out->y = s->conic[1] * gx + s->conic[2] * gy;
    out->conic[0] = 0.5F * gxx, out->conic[1] = gxy, out->conic[2] = 0.5F * gyy;
    out->opacity = -g / s->opacity;
    out->value[0] = 0;
    for (int k = 1; k < FFP_CHANNELS; k++) out->value[k] = sum_lanes(lanes->value[k]);
}

// Where the gradient of splat s in this tile is kept: a splat's tiles lie row by row behind first[s].
static FfpSplatGrad *slot_of(const FfpRaster *raster, int32_t s, const Tile *tile) {
    const FfpSplat *splat = &raster->splats[s];
    const int64_t row = tile->y0 / FFP_TILE - splat->tile_y0, column = tile->x0 / FFP_TILE - splat->tile_x0;
    return &raster->slots[raster->first[s] + row * (splat->tile_x1 - splat->tile_x0) + column];
}

static void blend_tile_backward(const FfpRaster *raster, const Tile *tile, Pixels *pixels) {
    bool open[FFP_TILE], any = true;
    for (int64_t i = 0; i < tile->count; i++) {
        const FfpSplat *s = &raster->splats[tile->order[i]];
        FfpSplatGrad *slot = slot_of(raster, tile->order[i], tile);
        if (i % FFP_TILE == 0 && any) any = find_open_rows(pixels->transmittance, open);
        if (!any) {
            memset(slot, 0, sizeof *slot);
            continue;
        }
        Lanes lanes;
        memset(&lanes, 0, sizeof lanes);
        const Rows rows = splat_rows(s, tile);
        for (int y = rows.first; y < rows.end; y++)
            if (open[y]) blend_row_backward(s, tile, y, pixels, &lanes);
        gather_lanes(s, tile, &lanes, slot);
    }
}

void ffp_blend_backward(FfpRaster *raster, const FfpGbuffer *out, const FfpGbuffer *grad_out) {
    const int tiles = raster->tiles_x * raster->tiles_y;
    const size_t instances = (size_t)raster->first[raster->n_splats];
    ffp_raster_reserve((void **)&raster->slots, &raster->slots_size, instances + 1, sizeof(FfpSplatGrad));
#pragma omp parallel for schedule(dynamic)
    for (int t = 0; t < tiles; t++) {
        const Tile tile = find_tile(raster, t);
        if (tile.count == 0) continue;
        Pixels pixels;
        load_pixels(raster, &tile, out, grad_out, &pixels);
        blend_tile_backward(raster, &tile, &pixels);
    }
}
