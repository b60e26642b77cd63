// The search for depth on the GPU, a view at a time: hull, costs of planes, the paths of semi-global
// aggregation, the choice, and the fine search.
#include "engine/cuda/launch.h"
#include "engine/cuda/warp.h"
extern "C" {
#include "engine/cuda/cuda.h"
#include "engine/match/matching.h"
#include "engine/match/table.h"
}
#include "engine/match/fine_formula.h"
#include "engine/match/plane_formula.h"

enum { THREADS = 128, WARPS = THREADS / FFP_WARP };
const int EACH = FFP_SEARCH_PLANES_MAX / (int)FFP_WARP; // planes a lane at most

static size_t cells_of(const FfpSearch *s) {
    return s->foreground.count * (size_t)s->planes.count;
}

// The ray through the pixel at `slot` as a device sees it.
static __device__ FfpLine line_of(const FfpSearch *s, size_t slot, const FfpCamera *device) {
    const size_t pixel = s->foreground.pixel[slot], width = (size_t)s->foreground.width;
    return ffp_line(&s->camera, (real)(pixel % width) + 0.5F, (real)(pixel / width) + 0.5F, device);
}

// One thread a hypothesis, as in what follows.
static __global__ void hull_kernel(size_t cells, unsigned char *inside, FfpSearch s) {
    const size_t i = ffp_thread();
    if (i >= cells) return;
    const int k = (int)(i % (size_t)s.planes.count);
    unsigned char in = 1;
    for (int o = 0; o < s.seers && in; o++) {
        const FfpSeer *seer = &s.seer[o];
        const FfpLine line = line_of(&s, i / (size_t)s.planes.count, &seer->camera);
        real u, v;
        ffp_line_positions(&line, s.planes.first, s.planes.step, k, &u, &v);
        const bool seen = u >= 0 && v >= 0 && u < (real)seer->width && v < (real)seer->height;
        in = seer->wide[seen ? (int)v * seer->width + (int)u : seer->width * seer->height];
    }
    inside[i] = in;
}

static void hull(unsigned char *inside, const FfpSearch *s) {
    ffp_launch_each(cells_of(s), hull_kernel, inside, *s);
}

static __global__ void sweep_kernel(size_t cells, real *cost, const unsigned char *inside, FfpSearch s) {
    const size_t i = ffp_thread();
    if (i >= cells) return;
    const size_t slot = i / (size_t)s.planes.count, pixel = s.foreground.pixel[slot];
    const real outside = FFP_OUTSIDE_COST * (real)s.observed.count, *w = s.observed.weight + 3 * pixel;
    cost[i] = outside;
    if (!inside[i]) return;
    const FfpLine line = line_of(&s, slot, &s.projector);
    real u, v;
    FfpCellPlaces cells_at;
    ffp_line_positions(&line, s.planes.first, s.planes.step, (int)(i % (size_t)s.planes.count), &u, &v);
    ffp_find_cells(&cells_at, &s.patterns, &u, &v);
    FfpCell sum = {{0, 0, 0, 0}};
    for (int p = 0; p < s.observed.count && cells_at.first[0] >= 0; p++) {
        const FfpObservedPixel here = ffp_observed_pixel(&s.observed, &s.patterns, p, pixel);
        sum = sum + ffp_blurred_cost(&here, s.patterns.stride, &cells_at, 0);
    }
    cost[i] = cells_at.first[0] >= 0 ? ffp_sum_channels(sum) : outside * ((w[0] + w[1]) + w[2]);
}

static void sweep(real *cost, const unsigned char *inside, const FfpSearch *s) {
    ffp_launch_each(cells_of(s), sweep_kernel, cost, inside, *s);
}

// The pixel at which a line of the picture begins; false when there is no such line. Those that lean begin
// along the row that they leave and then down the column.
static __device__ bool begin_line(int *x, int *y, int dx, int dy, int line, int width, int height) {
    const int first_x = dx < 0 ? width - 1 : 0, first_y = dy < 0 ? height - 1 : 0;
    if (dx == 0 || dy == 0) {
        *x = dx == 0 ? line : first_x;
        *y = dx == 0 ? first_y : line;
        return line < (dx == 0 ? width : height);
    }
    *x = line < width ? line : first_x;
    *y = line < width ? first_y : first_y + dy * (line - width + 1);
    return line < width + height - 1;
}

// A warp walks along a line in direction blockIdx.y, its lanes the planes: L(k) = C(k) + min(L'(k), L'(k -+
// 1) + small, min L' + large) - min L'. A path that comes from off the object starts again.
static __global__ void paths_kernel(real *paths, const real *cost, FfpSearch s) {
    const int ways[4][2] = {{1, 0}, {0, 1}, {1, 1}, {-1, 1}};
    const int way = (int)blockIdx.y, sign = way < 4 ? 1 : -1, lane = ffp_lane(), count = s.planes.count;
    const int dx = sign * ways[way % 4][0], dy = sign * ways[way % 4][1];
    const int width = s.foreground.width, height = s.foreground.height;
    int x, y;
    if (!begin_line(&x, &y, dx, dy, (int)(blockIdx.x * WARPS + threadIdx.x / FFP_WARP), width, height))
        return;
    const int each = (count + (int)FFP_WARP - 1) / (int)FFP_WARP; // planes a lane, one after the other
    real path[EACH], least = 0;
#pragma unroll
    for (int e = 0; e < EACH; e++) path[e] = 0;
    real *out = paths + (size_t)way * s.foreground.count * (size_t)count;
    for (; x >= 0 && y >= 0 && x < width && y < height; x += dx, y += dy) {
        const size_t slot = s.foreground.slot[(size_t)y * (size_t)width + (size_t)x];
        real last = path[0], lowest = FFP_FAR_COST;
#pragma unroll
        for (int e = 1; e < EACH; e++)
            if (e < each) last = path[e];
        real below = __shfl_up_sync(0xffffffffu, last, 1);
        const real next = __shfl_down_sync(0xffffffffu, path[0], 1), jump = least + FFP_LARGE_STEP;
        if (lane == 0) below = FFP_FAR_COST;
#pragma unroll
        for (int e = 0; e < EACH; e++) {
            const int k = lane * each + e;
            if (e >= each || k >= count) break;
            const size_t cell = slot * (size_t)count + (size_t)k;
            const real before = path[e], above = k + 1 == count ? FFP_FAR_COST
                                                 : e + 1 < EACH && e + 1 < each
                                                     ? path[e + 1 < EACH ? e + 1 : e]
                                                     : next;
            path[e] = 0;
            if (slot == FFP_OFF) continue;
            const real beside = (below < above ? below : above) + FFP_SMALL_STEP;
            const real near = before < beside ? before : beside;
            path[e] = cost[cell] + (near < jump ? near : jump) - least;
            out[cell] = path[e];
            lowest = path[e] < lowest ? path[e] : lowest;
            below = before;
        }
        least = slot == FFP_OFF ? 0 : -ffp_warp_max(-lowest);
    }
}

static void walk(real *paths, const real *cost, const FfpSearch *s) {
    const size_t lines = (size_t)s->foreground.width + (size_t)s->foreground.height - 1;
    ffp_launch_blocks(paths_kernel, dim3(ffp_blocks(lines, WARPS), FFP_SEARCH_WAYS), dim3(THREADS), 0, paths,
                      cost, *s);
}

static __device__ real total_of(const real *paths, size_t cells, size_t cell) {
    real sum = 0;
    for (int w = 0; w < FFP_SEARCH_WAYS; w += 4) {
        const real *p = paths + (size_t)w * cells + cell;
        sum += (p[0] + p[cells]) + (p[2 * cells] + p[3 * cells]);
    }
    return sum;
}

// The first of the least values that the lanes have; all lanes get it.
static __device__ int first_least(real value, int index) {
    const real least = -ffp_warp_max(-value);
    int first = value == least ? index : FFP_SEARCH_PLANES_MAX;
    for (int other = FFP_WARP / 2; other > 0; other /= 2)
        first = min(first, __shfl_xor_sync(0xffffffffu, first, other));
    return first;
}

static __device__ int least_total(const real *paths, size_t cells, size_t first, int count) {
    real least = INFINITY;
    int best = 0;
    for (int k = ffp_lane(); k < count; k += FFP_WARP) {
        const real total = total_of(paths, cells, first + (size_t)k);
        if (!(total < least)) continue;
        least = total;
        best = k;
    }
    return first_least(least, best);
}

// ffp_window_costs, a lane for every 32nd plane.
static __device__ real window_costs(real *sum, const real *cost, const FfpSearch *s, int x, int y) {
    const int width = s->observed.width, height = s->observed.height, count = s->planes.count;
    real weight = 0;
    for (int k = ffp_lane(); k < count; k += FFP_WARP) sum[k] = 0;
    for (int j = y > 0 ? y - 1 : y; j <= y + 1 && j < height; j++)
        for (int i = x > 0 ? x - 1 : x; i <= x + 1 && i < width; i++) {
            const size_t pixel = (size_t)j * (size_t)width + (size_t)i, slot = s->foreground.slot[pixel];
            if (slot == FFP_OFF) continue;
            for (int k = ffp_lane(); k < count; k += FFP_WARP)
                sum[k] += cost[slot * (size_t)count + (size_t)k];
            weight += (real)(3 * s->observed.count) * s->observed.lit[pixel];
        }
    return weight;
}

// ffp_rival_cost
static __device__ real rival_cost(const real *sum, int count, int chosen) {
    real least = FFP_FAR_COST, greatest = 0;
    for (int k = ffp_lane(); k < count; k += FFP_WARP) {
        const bool minimum = (k == 0 || sum[k - 1] >= sum[k]) && (k + 1 == count || sum[k + 1] >= sum[k]);
        if (minimum && (k <= chosen - FFP_RIVAL_APART || k >= chosen + FFP_RIVAL_APART) && sum[k] < least)
            least = sum[k];
        greatest = fmaxf(greatest, sum[k]);
    }
    least = -ffp_warp_max(-least);
    greatest = ffp_warp_max(greatest);
    return least < FFP_FAR_COST ? least : greatest;
}

// A warp for each pixel on the object.
static __global__ void choose_kernel(real *depth, real *confidence, const real *paths, const real *cost,
                                     FfpSearch s) {
    __shared__ real sums[WARPS][FFP_SEARCH_PLANES_MAX];
    const size_t slot = (size_t)blockIdx.x * WARPS + threadIdx.x / FFP_WARP;
    if (slot >= s.foreground.count) return;
    const int count = s.planes.count, width = s.observed.width;
    const size_t pixel = s.foreground.pixel[slot];
    real *sum = sums[threadIdx.x / FFP_WARP];
    const int best = least_total(paths, s.foreground.count * (size_t)count, slot * (size_t)count, count);
    const real weight =
        window_costs(sum, cost, &s, (int)(pixel % (size_t)width), (int)(pixel / (size_t)width));
    __syncwarp();
    const real second = rival_cost(sum, count, best), lit = s.observed.lit[pixel];
    if (ffp_lane() != 0) return;
    depth[pixel] = s.planes.first + (real)best * s.planes.step;
    const bool fits = lit >= FFP_LIT_MIN && sum[best] <= FFP_FITTING_COST * weight;
    confidence[pixel] = fits && second > 0 ? fmaxf(1 - sum[best] / second, 0) * lit : 0;
}

static void choose(real *depth, real *confidence, const real *paths, const real *cost, const FfpSearch *s) {
    ffp_launch_blocks(choose_kernel, dim3(ffp_blocks(s->foreground.count, WARPS)), dim3(THREADS), 0, depth,
                      confidence, paths, cost, *s);
}

// One thread a pixel of the picture: its place in the sheet.
static __global__ void sheet_kernel(size_t pixels, FfpSheet sheet, const real *depth, const real *weight) {
    const size_t i = ffp_thread();
    if (i >= pixels) return;
    const size_t to = (i / (size_t)sheet.width + (size_t)sheet.reach) * (size_t)sheet.stride +
                      i % (size_t)sheet.width + (size_t)sheet.reach;
    const real z = depth[i] > 0 ? depth[i] : 0;
    sheet.depth[to] = z;
    sheet.inverse[to] = z > 0 ? 1 / z : 0;
    sheet.weight[to] = z > 0 && weight[i] > 0 ? weight[i] : 0;
}

// Planes of the pixels that are searched; q0 is 0 at others.
static __global__ void planes_kernel(size_t pixels, FfpPlane *planes, FfpSheet sheet, const real *weight) {
    const size_t i = ffp_thread();
    if (i >= pixels) return;
    planes[i].q0 = 0;
    if (weight[i] > 0)
        ffp_planes_at(&planes[i], &sheet, (int)(i % (size_t)sheet.width), (int)(i / (size_t)sheet.width));
}

enum { ABREAST = 16, PIXELS = THREADS / ABREAST }; // threads a pixel, and pixels a block
static __global__ void fine_kernel(real *out, const real *depth, const FfpPlane *planes, FfpSearch s,
                                   int steps, real range) {
    FFP_DYNAMIC_SHARED(real, costs); // [PIXELS, steps]
    const size_t pixels = (size_t)s.camera.width * (size_t)s.camera.height;
    const size_t i = (size_t)blockIdx.x * PIXELS + threadIdx.x / ABREAST;
    const bool searched = i < pixels && planes[i].q0 > 0;
    const FfpFineSearch search = {&s.camera, &s.projector, &s.observed, &s.patterns, steps, false};
    const FfpPlane plane = searched ? planes[i] : FfpPlane();
    const real step = range * plane.q0 * plane.q0 / (real)(steps / 2);
    real *cost = costs + threadIdx.x / ABREAST * (unsigned)steps;
    for (int k = (int)threadIdx.x % ABREAST; searched && k < steps; k += ABREAST) {
        FfpCell channels = {{0, 0, 0, 0}};
        cost[k] = 0;
        ffp_fine_costs(cost + k, &channels, &search, &plane, (int)(i % (size_t)s.camera.width),
                       (int)(i / (size_t)s.camera.width), FfpFineSpan{k, k + 1, step});
    }
    __syncthreads();
    if (i >= pixels || threadIdx.x % ABREAST != 0) return;
    const real q = searched ? plane.q0 + (ffp_fine_least(cost, steps) - (real)(steps / 2)) * step : 0;
    out[i] = q > 0 ? 1 / q : depth[i];
}

static void refine(real *out, const real *depth, const real *weight, const FfpSearch *s,
                   const FfpSheet *sheet, FfpPlane *planes, int steps, real range) {
    const size_t pixels = (size_t)s->camera.width * (size_t)s->camera.height;
    ffp_launch_each(pixels, sheet_kernel, *sheet, depth, weight);
    ffp_launch_each(pixels, planes_kernel, planes, *sheet, weight);
    ffp_launch_blocks(fine_kernel, dim3(ffp_blocks(pixels, PIXELS)), dim3(THREADS),
                      PIXELS * (size_t)steps * sizeof(real), out, depth, planes, *s, steps, range);
}

extern "C" const FfpMatchTable ffp_cuda_match = {
    .hull = hull, .sweep = sweep, .paths = walk, .choose = choose, .refine = refine};
