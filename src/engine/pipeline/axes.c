#include "engine/pipeline/axes.h"
#include <math.h>
#include <string.h>
#include "core/base/alloc.h"
#include "core/base/file.h"
#include "core/base/log.h"
#include "core/capture/photographs.h"
#include "core/capture/project.h"
#include "core/capture/reduce.h"

enum { TURNS = 24, VIEWS = 6, CELLS = 64, SPLATS = 20000, REACH = 6 };

#define SEEN 0.3     // opacity
#define COLOUR 0.25  // weight of the correlation of colours beside the overlap of silhouettes
#define CLEARLY 0.05 // of the score
#define POOR 0.5     // overlap

#define HALF 0.70710678F

static void product(const real a[4], const real b[4], real out[4]) {
    out[0] = a[0] * b[0] - a[1] * b[1] - a[2] * b[2] - a[3] * b[3];
    out[1] = a[0] * b[1] + a[1] * b[0] + a[2] * b[3] - a[3] * b[2];
    out[2] = a[0] * b[2] - a[1] * b[3] + a[2] * b[0] + a[3] * b[1];
    out[3] = a[0] * b[3] + a[1] * b[2] - a[2] * b[1] + a[3] * b[0];
}

static void turn_point(const real q[4], const real p[3], real out[3]) {
    const real v[4] = {0, p[0], p[1], p[2]}, back[4] = {q[0], -q[1], -q[2], -q[3]};
    real half[4], all[4];
    product(q, v, half);
    product(half, back, all);
    memcpy(out, all + 1, 3 * sizeof *out);
}

void ffp_gaussians_rotate(FfpGaussians *gaussians, const real turn[4]) {
    for (int64_t i = 0; i < gaussians->count; i++) {
        real at[3], q[4];
        turn_point(turn, gaussians->centre + 3 * i, at);
        product(turn, gaussians->rotation + 4 * i, q);
        memcpy(gaussians->centre + 3 * i, at, sizeof at);
        memcpy(gaussians->rotation + 4 * i, q, sizeof q);
    }
}

void ffp_gaussians_stand(FfpGaussians *gaussians, bool y, bool minus_y) {
    const real turn[4] = {HALF, y ? HALF : -HALF, 0, 0};
    if (y || minus_y) ffp_gaussians_rotate(gaussians, turn);
}

// --- The photographs, as few cells. ---

typedef struct Cells {
    FfpCamera camera;
    int width, height;
    bool *object;
    real *luma; // of the photograph under black, encoded
} Cells;

static real luma_of(const real *rgb) {
    const real light = (real)0.2126 * rgb[0] + (real)0.7152 * rgb[1] + (real)0.0722 * rgb[2];
    return (real)pow(light > 0 ? (double)light : 0, 1 / 2.2);
}

static bool read_cells(Cells *cells, const FfpCapture *capture, int index, FfpError *err) {
    const FfpCamera *camera = &capture->views[index].camera;
    const int longest = camera->width > camera->height ? camera->width : camera->height,
              least = longest < CELLS ? longest : CELLS;
    cells->width = (int)((int64_t)camera->width * least / longest);
    cells->height = (int)((int64_t)camera->height * least / longest);
    FfpView view;
    if (cells->width < 1) cells->width = 1;
    if (cells->height < 1) cells->height = 1;
    if (!ffp_photographs_read(&view, capture, index, &capture->black, 1, cells->width, cells->height, err))
        return false;
    const size_t n = (size_t)cells->width * (size_t)cells->height;
    cells->camera = view.camera;
    cells->object = ffp_alloc(n, sizeof *cells->object);
    cells->luma = ffp_alloc(n, sizeof *cells->luma);
    for (size_t i = 0; i < n; i++) {
        cells->object[i] = view.coverage.data[i] > (real)0.5;
        if (view.images[capture->black].data)
            cells->luma[i] = luma_of(view.images[capture->black].data + 3 * i);
    }
    ffp_view_reduced_free(&view, capture->n_patterns);
    return true;
}

// --- How splats fit. ---

typedef struct Drawn {
    real *depth, *luma; // of the nearest splat in each cell; depth 0: none
} Drawn;

static void draw_splat(const Cells *cells, Drawn *drawn, const real at[3], real size, real luma) {
    real x, y;
    const real depth = ffp_projected(&cells->camera, at, &x, &y);
    if (!(depth > 0) || !(fabs((double)x) < 1e6) || !(fabs((double)y) < 1e6)) return;
    const double wide = (double)(size * cells->camera.fx / depth), reach = wide < REACH ? wide : REACH;
    const int left = (int)floor((double)x - reach), right = (int)floor((double)x + reach),
              top = (int)floor((double)y - reach), bottom = (int)floor((double)y + reach);
    for (int v = top < 0 ? 0 : top; v <= bottom && v < cells->height; v++)
        for (int u = left < 0 ? 0 : left; u <= right && u < cells->width; u++) {
            const int i = v * cells->width + u;
            if (drawn->depth[i] > 0 && drawn->depth[i] <= depth) continue;
            drawn->depth[i] = depth;
            drawn->luma[i] = luma;
        }
}

typedef struct Fit {
    double overlap, score;
} Fit;

// Share of cells that both have, of those that either has; and how their colours go together.
static void compare(const Cells *cells, const Drawn *drawn, Fit *fit) {
    double both = 0, either = 0, a = 0, b = 0, aa = 0, bb = 0, ab = 0;
    for (int i = 0; i < cells->width * cells->height; i++) {
        const bool seen = drawn->depth[i] > 0;
        either += seen || cells->object[i];
        if (!seen || !cells->object[i]) continue;
        const double p = (double)drawn->luma[i], q = (double)cells->luma[i];
        both++;
        a += p, b += q, aa += p * p, bb += q * q, ab += p * q;
    }
    const double spread = (aa * both - a * a) * (bb * both - b * b);
    fit->overlap += either > 0 ? both / either : 0;
    fit->score +=
        (either > 0 ? both / either : 0) + (spread > 1e-12 ? COLOUR * (ab * both - a * b) / sqrt(spread) : 0);
}

static Fit fit_of(const FfpGaussians *g, const Cells *cells, int n, const real turn[4]) {
    Fit fit = {0};
    const int64_t step = g->count > SPLATS ? g->count / SPLATS : 1;
    for (int v = 0; v < n; v++) {
        const size_t count = (size_t)cells[v].width * (size_t)cells[v].height;
        Drawn drawn = {ffp_alloc(count, sizeof(real)), ffp_alloc(count, sizeof(real))};
        for (int64_t i = 0; i < g->count; i += step) {
            const real *s = g->scale + 3 * i;
            const real size = fmaxf((float)s[0], fmaxf((float)s[1], (float)s[2]));
            real at[3];
            if (g->opacity[i] < (real)SEEN) continue;
            turn_point(turn, g->centre + 3 * i, at);
            draw_splat(&cells[v], &drawn, at, size, luma_of(g->ambient + 3 * i));
        }
        compare(&cells[v], &drawn, &fit);
        ffp_free(drawn.depth);
        ffp_free(drawn.luma);
    }
    return (Fit){fit.overlap / n, fit.score / n};
}

// The rotations of a cube: about nothing, faces, edges and corners.
static void turns_of_cube(real turns[TURNS][4]) {
    int n = 0;
    memset(turns, 0, TURNS * sizeof *turns);
    for (int k = 0; k < 4; k++) turns[n++][k] = 1;
    for (int i = 0; i < 4; i++)
        for (int j = i + 1; j < 4; j++)
            for (int sign = 1; sign >= -1; sign -= 2) {
                turns[n][i] = HALF;
                turns[n++][j] = (real)sign * HALF;
            }
    for (int bits = 0; bits < 8; bits++, n++)
        for (int k = 0; k < 4; k++) turns[n][k] = k > 0 && bits >> (k - 1) & 1 ? (real)-0.5 : (real)0.5;
}

// "x -z y": the file's axes that become x, y and z.
static void name_axes(const real turn[4], char name[16]) {
    int length = 0;
    for (int row = 0; row < 3; row++)
        for (int k = 0; k < 3; k++) {
            real axis[3] = {0, 0, 0}, to[3];
            axis[k] = 1;
            turn_point(turn, axis, to);
            if (fabs((double)to[row]) < 0.5) continue;
            length += snprintf(name + length, (size_t)(16 - length), "%s%s%c", row ? " " : "",
                               to[row] < 0 ? "-" : "", "xyz"[k]);
        }
}

static void choose(FfpGaussians *gaussians, const Cells *cells, int n, const char *path) {
    real turns[TURNS][4];
    Fit own = {0}, best = {0}, second = {0};
    int chosen = 0;
    char axes[16] = "";
    turns_of_cube(turns);
    for (int t = 0; t < TURNS; t++) {
        const Fit fit = fit_of(gaussians, cells, n, turns[t]);
        if (t == 0) own = fit;
        if (t == 0 || fit.score > best.score) {
            second = best;
            best = fit;
            chosen = t;
        } else if (fit.score > second.score)
            second = fit;
    }
    name_axes(turns[chosen], axes);
    const char *name = ffp_basename(path);
    const bool turned = chosen > 0 && best.score > own.score + CLEARLY;
    if (turned) ffp_gaussians_rotate(gaussians, turns[chosen]);
    if (turned)
        ffp_note(
            "%s: turned, its axes %s become x y z: %.0f %% of the silhouettes agree, %.0f %% as they were",
            name, axes, 100 * best.overlap, 100 * own.overlap);
    if (best.overlap < POOR)
        ffp_note("%s: in no order of its axes do more than %.0f %% of the silhouettes agree: is it of this "
                 "capture, and of its size?",
                 name, 100 * best.overlap);
    else if (turned && best.score < second.score + CLEARLY / 5)
        ffp_note("%s: another order of its axes fits as well: --up says which direction is up", name);
}

bool ffp_gaussians_find_axes(FfpGaussians *gaussians, const FfpCapture *capture, const char *path,
                             FfpError *err) {
    Cells cells[VIEWS] = {0};
    const int n = capture->n_views < VIEWS ? capture->n_views : VIEWS;
    bool ok = true;
    if (capture->scene) return true;
    for (int v = 0; ok && v < n; v++)
        ok = read_cells(&cells[v], capture, (int)((int64_t)v * capture->n_views / n), err);
    if (ok) choose(gaussians, cells, n, path);
    for (int v = 0; v < n; v++) {
        ffp_free(cells[v].object);
        ffp_free(cells[v].luma);
    }
    return ok;
}
