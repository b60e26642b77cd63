#include "engine/match/stereo.h"
#include <string.h>
#include <tgmath.h>
#include "core/base/arena.h"
#include "core/base/call.h"
#include "engine/match/kernels/kernels.h"
#include "engine/match/line.h"

enum { NEIGHBOURS = 4, ALIKE = 2 };
#define UNKNOWN 0.5F // cost where no neighbour sees the point

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
    const FfpStereo *stereo;
    int view, width, height;
    const FfpForeground *foreground;
    const FfpPlanes *planes;
    Neighbours neighbours;
    real *lines;  // [NEIGHBOURS, 6, foreground] FfpLine's numbers
    real *single; // [h,w] cost of one plane and neighbour at each pixel; -1: unseen
    real *rows;   // [h,w] the same summed over three pixels of a row, and how many there are
    unsigned char *counts;
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

static void sum_rows(const Sweep *w) {
    for (int y = 0; y < w->height; y++) {
        const size_t first = (size_t)y * (size_t)w->width;
        for (int x = 0; x < w->width; x++) {
            real sum = 0;
            int count = 0;
            for (int i = x > 0 ? x - 1 : 0; i <= x + 1 && i < w->width; i++) {
                const real c = w->single[first + (size_t)i];
                sum += c >= 0 ? c : 0;
                count += c >= 0;
            }
            w->rows[first + (size_t)x] = sum;
            w->counts[first + (size_t)x] = (unsigned char)count;
        }
    }
}

// Mean over 3 x 3 pixels; -1 where the pixel itself is unseen.
static real window_mean(const Sweep *w, size_t i) {
    const size_t width = (size_t)w->width, y = i / width;
    if (w->single[i] < 0) return -1;
    real sum = w->rows[i];
    int count = w->counts[i];
    if (y > 0) sum += w->rows[i - width], count += w->counts[i - width];
    if (y + 1 < (size_t)w->height) sum += w->rows[i + width], count += w->counts[i + width];
    return sum / (real)count;
}

// least [foreground, ALIKE]: the least costs of the plane so far, ascending; 2 where there are fewer.
static void add_neighbour(const Sweep *w, int n, int plane, real *least) {
    const FfpForeground *foreground = w->foreground;
    const real at = w->planes->first + (real)plane * w->planes->step;
    const FfpStereoPlane seen = plane_seen(w, n, at);
    ffp_stereo_plane(w->single, &seen);
    sum_rows(w);
    for (size_t slot = 0; slot < foreground->count; slot++) {
        const real cost = window_mean(w, foreground->pixel[slot]);
        real *here = least + ALIKE * slot;
        if (cost < 0 || cost >= here[1]) continue;
        here[1] = cost < here[0] ? here[0] : cost;
        here[0] = cost < here[0] ? cost : here[0];
    }
}

static void add_plane(real *cost, const Sweep *w, int plane, real share, real *least) {
    const size_t count = w->foreground->count;
    for (size_t i = 0; i < ALIKE * count; i++) least[i] = 2;
    for (int n = 0; n < w->neighbours.count; n++) add_neighbour(w, n, plane, least);
    for (size_t slot = 0; slot < count; slot++) {
        const real first = least[ALIKE * slot], second = least[ALIKE * slot + 1];
        const real mean = first > 1 ? UNKNOWN : second > 1 ? first : (first + second) / 2;
        cost[slot * (size_t)w->planes->count + (size_t)plane] += share * mean;
    }
}

void ffp_stereo_costs(real *cost, const FfpStereo *stereo, int view, const FfpForeground *foreground,
                      const FfpPlanes *planes, real share) {
    const FfpCamera *camera = &stereo->capture->views[view].camera;
    const size_t width = (size_t)camera->width, area = width * (size_t)camera->height;
    Sweep w = {stereo,
               view,
               camera->width,
               camera->height,
               foreground,
               planes,
               find_neighbours(stereo->capture, view),
               ffp_alloc(NEIGHBOURS * 6 * (foreground->count + 1), sizeof *w.lines),
               ffp_alloc(area, sizeof(real)),
               ffp_alloc(area, sizeof(real)),
               ffp_alloc(area, 1)};
    real *least = ffp_alloc(ALIKE * (foreground->count + 1), sizeof *least);
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
        add_plane(cost, &w, plane, share, least);
        ffp_cancel_point();
    }
    ffp_free(least);
    ffp_free(w.lines);
    ffp_free(w.single);
    ffp_free(w.rows);
    ffp_free(w.counts);
}
