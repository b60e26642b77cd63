#include <stdlib.h>
#include <tgmath.h>
#include "core/base/arena.h"
#include "core/base/call.h"
#include "rig/checks/chord.h"
#include "rig/masks/limits.h"
#include "rig/masks/steps.h"
#include "rig/masks/voxels.h"

// RUN: of a ray's samples in a row that must be possible, 7 % of the object's width: the hull is larger than
// the object where rays touch it.
enum { CELLS = 96, MAP = 192, SAMPLES = 128, RUN = 8, ROUNDS = 4, SIDE_MAX = 256 };

enum { OUT, LIT, HOLE, DARK }; // what a view shows at a point

typedef struct Hull {
    const FfpCapture *capture;
    const FfpImage *holes;
    FfpVoxels voxels;
    FfpDepthMap *nearest; // [n_views] what the projectors see
} Hull;

static int shown(const Hull *h, int v, const real point[3]) {
    const FfpView *view = &h->capture->views[v];
    const FfpImage *mask = &view->coverage;
    real x, y;
    if (!(ffp_project(&view->camera, point, &x, &y) > 0) || x < 0 || y < 0 || x >= (real)mask->width ||
        y >= (real)mask->height)
        return OUT;
    const size_t pixel = (size_t)y * (size_t)mask->width + (size_t)x;
    if (h->holes[v].data && h->holes[v].data[pixel] > 0) return HOLE;
    return mask->data[pixel] >= 0.5F ? LIT : DARK;
}

static bool in_shadow(const Hull *h, int v, const real point[3]) {
    int cell;
    real far;
    if (!ffp_depth_map_find(&h->nearest[v], point, &cell, &far)) return true;
    return far > h->nearest[v].z[cell] + GROW_NEAR * h->voxels.step;
}

// True if the views but one (-1: all) allow the object at a point; without shadows all must show it.
static bool is_possible(const Hull *h, const real point[3], int but, bool with_shadows) {
    int lit = 0, dark = 0;
    for (int v = 0; v < h->capture->n_views; v++) {
        const int what = v == but ? OUT : shown(h, v, point);
        lit += what == LIT, dark += what == DARK;
        if (what == DARK && (!with_shadows || !in_shadow(h, v, point))) return false;
    }
    return lit > 0 && lit >= GROW_LIT_SHARE * dark;
}

// --- The hull and its shadows. ---

static void cast_all(Hull *h) {
#pragma omp parallel for schedule(static)
    for (int v = 0; v < h->capture->n_views; v++) ffp_voxels_draw(&h->voxels, &h->nearest[v]);
}

// First what all views show, then also what lies in its shadows.
static void build_hull(Hull *h) {
    for (int round = 0; round <= ROUNDS; round++) {
        int added = 0;
        ffp_cancel_point();
#pragma omp parallel for schedule(static) reduction(+ : added)
        for (int i = 0; i < CELLS * CELLS * CELLS; i++) {
            real point[3];
            if (h->voxels.solid[i]) continue;
            ffp_voxels_point(&h->voxels, i, point);
            h->voxels.solid[i] = is_possible(h, point, -1, round > 0);
            added += h->voxels.solid[i];
        }
        cast_all(h);
        if (added == 0) break;
    }
}

// --- Pixels. ---

// True if some part of a pixel's ray is possible.
static bool has_part(const Hull *h, int v, size_t pixel, bool with_shadows) {
    FfpChord chord;
    int run = 0;
    if (!ffp_chord(h->capture, &h->capture->views[v].camera, pixel, &chord)) return false;
    for (int k = 0; k < SAMPLES; k++) {
        real point[3];
        ffp_chord_point(&chord, k, SAMPLES, point);
        const bool here = (!with_shadows || in_shadow(h, v, point)) && is_possible(h, point, v, with_shadows);
        run = here ? run + 1 : 0;
        if (run == RUN) return true;
    }
    return false;
}

// Blocks of pixels in larger pictures share what is found at their middles.
static FfpImage possible_pixels(const Hull *h, int v) {
    const FfpImage *mask = &h->capture->views[v].coverage, *hole = &h->holes[v];
    const int longest = mask->width > mask->height ? mask->width : mask->height;
    const int block = (longest + SIDE_MAX - 1) / SIDE_MAX, width = mask->width, height = mask->height;
    FfpImage out = ffp_image_new(width, height, 1);
#pragma omp parallel for schedule(dynamic, 1)
    for (int row = 0; row < height; row += block)
        for (int column = 0; column < width; column += block) {
            const int y = row + block / 2 < height ? row + block / 2 : row,
                      x = column + block / 2 < width ? column + block / 2 : column;
            const size_t pixel = (size_t)y * (size_t)width + (size_t)x;
            const bool in_hole = hole->data[pixel] > 0;
            if (mask->data[pixel] >= 0.5F && !in_hole && block == 1) continue;
            if (!has_part(h, v, pixel, !in_hole)) continue;
            for (int j = row; j < row + block && j < height; j++)
                for (int i = column; i < column + block && i < width; i++)
                    out.data[(size_t)j * (size_t)width + (size_t)i] = 1;
        }
    return out;
}

// How many pixels of a view are lit, or, of what is possible, new.
static int64_t count(const FfpView *view, const FfpImage *possible) {
    const size_t pixels = (size_t)view->coverage.width * (size_t)view->coverage.height;
    int64_t sum = 0;
    for (size_t i = 0; i < pixels; i++) {
        const bool lit = view->coverage.data[i] >= 0.5F;
        sum += !possible ? lit : !lit && possible->data[i] > 0;
    }
    return sum;
}

// True if so little of the object is lit that the views know too little of each other.
static bool too_dark(const FfpCapture *capture, const bool *made, const FfpImage *possible) {
    int64_t lit = 0, added = 0;
    for (int v = 0; v < capture->n_views; v++) {
        if (!made[v]) continue;
        lit += count(&capture->views[v], NULL);
        added += count(&capture->views[v], &possible[v]);
    }
    return (double)added > GROW_ADDED_MOST * (double)lit;
}

// Opens a view's holes and adds what is possible.
static int64_t grow(FfpView *view, const FfpImage *holes, const FfpImage *possible) {
    const size_t pixels = (size_t)view->coverage.width * (size_t)view->coverage.height;
    int64_t added = 0;
    for (size_t i = 0; i < pixels; i++) {
        const bool before = view->coverage.data[i] >= 0.5F,
                   after = possible->data[i] > 0 || (before && !(holes->data[i] > 0));
        added += (int)after - (int)before;
        view->coverage.data[i] = after;
    }
    return added + ffp_mask_fill_specks(&view->coverage);
}

static Hull new_hull(const FfpCapture *capture, const FfpImage *holes) {
    Hull h = {capture, holes, ffp_voxels_new(capture, CELLS), NULL};
    h.nearest = ffp_alloc((size_t)capture->n_views, sizeof *h.nearest);
    for (int v = 0; v < capture->n_views; v++)
        h.nearest[v] = ffp_depth_map_new(&capture->views[v].projector, MAP, MAP);
    cast_all(&h);
    return h;
}

static void free_hull(Hull *h) {
    for (int v = 0; v < h->capture->n_views; v++) ffp_depth_map_free(&h->nearest[v]);
    ffp_free(h->nearest);
    ffp_voxels_free(&h->voxels);
}

bool ffp_grow_masks(FfpCapture *capture, const bool *made, const FfpImage *holes, int64_t *added) {
    const int n = capture->n_views;
    const real radius = capture->radius;
    FfpImage *possible = ffp_alloc((size_t)n, sizeof *possible);
    capture->radius *= (real)REACH;
    Hull h = new_hull(capture, holes);
    build_hull(&h);
    for (int v = 0; v < n; v++) {
        ffp_cancel_point();
        if (made[v]) possible[v] = possible_pixels(&h, v);
    }
    free_hull(&h);
    capture->radius = radius;
    const bool sure = !too_dark(capture, made, possible);
    *added = 0;
    for (int v = 0; v < n; v++) {
        if (made[v] && sure) *added += grow(&capture->views[v], &holes[v], &possible[v]);
        ffp_image_free(&possible[v]);
    }
    ffp_free(possible);
    return sure;
}
