#include "engine/match/stereo.h"
#include <string.h>
#include <tgmath.h>
#include "core/base/arena.h"
#include "core/base/call.h"
#include "engine/match/kernels/kernels.h"
#include "engine/match/line.h"

enum { NEIGHBOURS = 4, ALIKE = 2 };
#define UNKNOWN 0.5F // cost where no neighbour sees the point
#define UNSEEN 2     // above all costs

// Views that a view is compared with.
typedef struct Neighbours {
    int count, view[NEIGHBOURS];
    FfpStereoCell weight[NEIGHBOURS]; // of the channels; their sum is 1
} Neighbours;

static void fill_view(void *argument, int64_t v) {
    const FfpStereo *stereo = ((FfpStereo *const *)argument)[0];
    const int pattern = *((const int *const *)argument)[1];
    const FfpCapture *capture = stereo->capture;
    const FfpView *view = &capture->views[v];
    const size_t area = (size_t)view->camera.width * (size_t)view->camera.height;
    const real *black = view->images[capture->black].data, *white = view->images[capture->white].data,
               *active = view->images[pattern].data;
    FfpStereoCell *cells = stereo->cells + (size_t)v * area;
    for (size_t i = 0; i < area; i++) {
        FfpStereoCell cell = {0};
        for (size_t c = 0; c < 3; c++) {
            cell[c] = ffp_srgb_encode(black[3 * i + c]);
            cell[3 + c] = ffp_srgb_encode(active[3 * i + c]);
            cell[6] += ffp_srgb_encode(white[3 * i + c]) / 3;
        }
        cells[i] = cell;
    }
}

FfpStereo ffp_stereo_new(const FfpCapture *capture, int pattern) {
    const FfpCamera *camera = &capture->views[0].camera;
    const size_t area = (size_t)camera->width * (size_t)camera->height;
    FfpStereo out = {capture, ffp_alloc((size_t)capture->n_views * area, sizeof *out.cells)};
    const void *work[2] = {&out, &pattern};
    ffp_parallel_for(capture->n_views, 0, fill_view, work);
    return out;
}

void ffp_stereo_free(FfpStereo *stereo) {
    ffp_free(stereo->cells);
    *stereo = (FfpStereo){0};
}

// --- Neighbours. ---

static real apart(const FfpCamera *a, const FfpCamera *b) {
    real square = 0;
    for (int k = 3; k < 12; k += 4) square += (a->pose[k] - b->pose[k]) * (a->pose[k] - b->pose[k]);
    return sqrt(square);
}

static bool same_projector(const FfpCapture *capture, int a, int b) {
    return ffp_same_device(&capture->views[a].projector, &capture->views[b].projector);
}

static bool is_taken(const FfpCapture *capture, const Neighbours *chosen, int view) {
    for (int n = 0; n < chosen->count; n++)
        if (ffp_same_device(&capture->views[chosen->view[n]].camera, &capture->views[view].camera))
            return true;
    return false;
}

// The nearest of those that are left; of views of one camera, that which the same projector lights. -1: none.
static int next_neighbour(const FfpCapture *capture, int view, const Neighbours *chosen) {
    const FfpCamera *own = &capture->views[view].camera;
    int best = -1;
    real least = 0;
    for (int other = 0; other < capture->n_views; other++) {
        const FfpCamera *camera = &capture->views[other].camera;
        if (ffp_same_device(own, camera) || is_taken(capture, chosen, other)) continue;
        const real away = apart(own, camera) * (same_projector(capture, view, other) ? 1 : 1.01F);
        if (best >= 0 && away >= least) continue;
        best = other;
        least = away;
    }
    return best;
}

static Neighbours find_neighbours(const FfpCapture *capture, int view) {
    Neighbours out = {0};
    while (out.count < NEIGHBOURS) {
        const int other = next_neighbour(capture, view, &out);
        if (other < 0) break;
        const bool lit_alike = same_projector(capture, view, other);
        FfpStereoCell *weight = &out.weight[out.count];
        for (int c = 0; c < 7; c++) (*weight)[c] = c < 3 || lit_alike ? (real)1 / (lit_alike ? 7 : 3) : 0;
        out.view[out.count++] = other;
    }
    return out;
}

// --- Costs. ---

typedef struct Sweep {
    Neighbours neighbours;
    const FfpStereo *stereo;
    const FfpForeground *foreground;
    const FfpPlanes *planes;
    real *lines;         // [NEIGHBOURS, 6, foreground] FfpLine's numbers
    real *single;        // [h,w] cost of one plane and neighbour at each pixel; -1: unseen
    real *sums, *counts; // [h,w] of those seen of a row's three pixels around each
    real *least; // [ALIKE,h,w] the least means over 3 x 3 pixels, ascending; UNSEEN where there are fewer
    int view, width, height;
} Sweep;

void ffp_stereo_plane(real *single, const FfpStereoPlane *plane) {
    ffp_match_kernels()->stereo_plane(single, plane);
}

static FfpStereoPlane plane_seen(const Sweep *w, int n, real at) {
    const FfpView *seer = &w->stereo->capture->views[w->neighbours.view[n]];
    const size_t area = (size_t)w->width * (size_t)w->height, count = w->foreground->count;
    FfpStereoPlane plane = {.count = count,
                            .pixel = w->foreground->pixel,
                            .at = at,
                            .own = w->stereo->cells + (size_t)w->view * area,
                            .theirs = w->stereo->cells + (size_t)w->neighbours.view[n] * area,
                            .weight = w->neighbours.weight[n],
                            .width = w->width,
                            .right = (real)(ffp_frame_width(seer) - 1),
                            .bottom = (real)(ffp_frame_height(seer) - 1)};
    for (size_t k = 0; k < 6; k++) plane.line[k] = w->lines + (6 * (size_t)n + k) * count;
    return plane;
}

static inline void add_three(const Sweep *w, size_t i, real left, real right) {
    const real own = w->single[i];
    w->sums[i] = ((left >= 0 ? left : 0) + (own >= 0 ? own : 0)) + (right >= 0 ? right : 0);
    w->counts[i] = (real)((left >= 0) + (own >= 0) + (right >= 0));
}

static void sum_rows(const Sweep *w) {
    for (int y = 0; y < w->height; y++) {
        const size_t first = (size_t)y * (size_t)w->width, last = first + (size_t)w->width - 1;
        add_three(w, first, -1, w->width > 1 ? w->single[first + 1] : -1);
        for (size_t i = first + 1; i < last; i++) add_three(w, i, w->single[i - 1], w->single[i + 1]);
        if (last > first) add_three(w, last, w->single[last - 1], -1);
    }
}

// Keeps the means over 3 x 3 pixels of a row, of pixels that are seen, if they are among the least.
static void keep_least(const Sweep *w, int y) {
    const size_t width = (size_t)w->width, first = (size_t)y * width, area = width * (size_t)w->height;
    const size_t above = y > 0 ? width : 0, below = y + 1 < w->height ? width : 0;
    const real over = above > 0, under = below > 0;
    real *restrict least = w->least + first, *restrict second = w->least + area + first;
    const real *sum = w->sums + first, *count = w->counts + first, *single = w->single + first;
    for (size_t x = 0; x < width; x++) {
        const real total = sum[x] + over * sum[x - above] + under * sum[x + below];
        const real seen = count[x] + over * count[x - above] + under * count[x + below];
        const real mean = single[x] < 0 ? UNSEEN : total / seen;
        const real more = mean < least[x] ? least[x] : mean;
        second[x] = more < second[x] ? more : second[x];
        least[x] = mean < least[x] ? mean : least[x];
    }
}

static void add_neighbour(const Sweep *w, int n, int plane) {
    const FfpStereoPlane seen = plane_seen(w, n, w->planes->first + (real)plane * w->planes->step);
    ffp_stereo_plane(w->single, &seen);
    sum_rows(w);
    for (int y = 0; y < w->height; y++) keep_least(w, y);
}

static void add_plane(real *cost, const Sweep *w, int plane, real share) {
    const FfpForeground *foreground = w->foreground;
    const size_t area = (size_t)w->width * (size_t)w->height;
    for (size_t i = 0; i < ALIKE * area; i++) w->least[i] = UNSEEN;
    for (int n = 0; n < w->neighbours.count; n++) add_neighbour(w, n, plane);
    for (size_t slot = 0; slot < foreground->count; slot++) {
        const real *least = w->least + foreground->pixel[slot], first = least[0], second = least[area];
        const real mean = first > 1 ? UNKNOWN : second > 1 ? first : (first + second) / 2;
        cost[slot * (size_t)w->planes->count + (size_t)plane] += share * mean;
    }
}

void ffp_stereo_costs(real *cost, const FfpStereo *stereo, int view, const FfpForeground *foreground,
                      const FfpPlanes *planes, real share) {
    const FfpCamera *camera = &stereo->capture->views[view].camera;
    const size_t width = (size_t)camera->width, area = width * (size_t)camera->height;
    Sweep w = {.neighbours = find_neighbours(stereo->capture, view),
               .stereo = stereo,
               .foreground = foreground,
               .planes = planes,
               .lines = ffp_alloc(NEIGHBOURS * 6 * (foreground->count + 1), sizeof *w.lines),
               .single = ffp_alloc(area, sizeof(real)),
               .sums = ffp_alloc(area, sizeof(real)),
               .counts = ffp_alloc(area, sizeof(real)),
               .least = ffp_alloc(ALIKE * area, sizeof(real)),
               .view = view,
               .width = camera->width,
               .height = camera->height};
    for (size_t i = 0; i < area; i++) w.single[i] = -1;
    for (int n = 0; n < w.neighbours.count; n++)
        for (size_t slot = 0; slot < foreground->count; slot++) {
            const real x = (real)(foreground->pixel[slot] % width) + 0.5F,
                       y = (real)(foreground->pixel[slot] / width) + 0.5F;
            const FfpLine line = ffp_plane_line(
                planes, ffp_line(camera, x, y, &stereo->capture->views[w.neighbours.view[n]].camera));
            const real numbers[6] = {line.u[0], line.u[1], line.v[0], line.v[1], line.w[0], line.w[1]};
            for (size_t k = 0; k < 6; k++)
                w.lines[(6 * (size_t)n + k) * foreground->count + slot] = numbers[k];
        }
    for (int plane = 0; plane < planes->count && w.neighbours.count > 0; plane++) {
        add_plane(cost, &w, plane, share);
        ffp_cancel_point();
    }
    ffp_free(w.least);
    ffp_free(w.lines);
    ffp_free(w.single);
    ffp_free(w.sums);
    ffp_free(w.counts);
}
