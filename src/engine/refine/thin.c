#include "engine/refine/thin.h"
#include <stdlib.h>
#include "core/base/arena.h"
#include "core/base/vec.h"
#include "engine/refine/parameters.h"

enum { AT_ONCE = 2048 };
#define SLACK 1.5F  // footprints off another splat's plane within which a centre lies on the same surface
#define FACING 0.5F // least cosine between normals of one surface
#define STEEP 0.1F  // least cosine of incidence that counts
#define WIDER 1.15F // a splat that stands alone, for a surface seen head-on;
#define WIDEST_TILT 4.0F // largest 1 / cosine of incidence that widens it further

typedef struct Piece { // of surface, that a splat's pixel shows
    real normal[3];    // unit, towards the camera
    real centre[3];
    real width; // of a pixel there, the footprint
    real area;  // footprint^2 / cosine of incidence
} Piece;

typedef struct Candidate {
    real area;
    int64_t splat;
} Candidate;

typedef struct Thinning {
    const FfpGaussians *gaussians;
    const int64_t *pixel;
    const FfpCapture *capture;
    int width, height;
    int64_t area;  // pixels of a view
    int32_t *at;   // [views,height,width] the pixel's splat, NONE, or OPEN
    Piece *pieces; // [count]
} Thinning;

enum { NONE = -1, OPEN = -2 }; // OPEN: its splat is decided in this batch

static const FfpCamera *camera_of(const Thinning *t, int64_t splat) {
    return &t->capture->views[t->pixel[splat] / t->area].camera;
}

// The thinnest, along which a splat's surface is seen.
static int axis_of(const real scale[3]) {
    return scale[0] < scale[1] ? (scale[0] < scale[2] ? 0 : 2) : scale[1] < scale[2] ? 1 : 2;
}

static Piece piece_of(const Thinning *t, int64_t splat) {
    const FfpCamera *camera = camera_of(t, splat);
    const real *centre = t->gaussians->centre + 3 * splat;
    const int axis = axis_of(t->gaussians->scale + 3 * splat);
    real turn[9], x, y, back[3];
    Piece out = {0};
    ffp_quaternion_matrix(t->gaussians->rotation + 4 * splat, turn);
    for (int c = 0; c < 3; c++) {
        back[c] = camera->pose[4 * c + 3] - centre[c];
        out.normal[c] = turn[3 * c + axis];
        out.centre[c] = centre[c];
    }
    ffp_normalise3(back);
    const real cosine = ffp_dot3(out.normal, back);
    if (cosine < 0)
        for (int c = 0; c < 3; c++) out.normal[c] = -out.normal[c];
    out.width = ffp_project(camera, centre, &x, &y) / camera->fx;
    out.area = out.width * out.width / fmax(fabs(cosine), STEEP);
    return out;
}

static Thinning thinning_new(const FfpGaussians *gaussians, const int64_t *pixel, const FfpCapture *capture) {
    const FfpCamera *camera = &capture->views[0].camera;
    const int64_t area = (int64_t)camera->width * camera->height, pixels = area * capture->n_views;
    Thinning t = {gaussians,
                  pixel,
                  capture,
                  camera->width,
                  camera->height,
                  area,
                  ffp_alloc((size_t)pixels, sizeof *t.at),
                  ffp_alloc((size_t)gaussians->count + 1, sizeof *t.pieces)};
    for (int64_t p = 0; p < pixels; p++) t.at[p] = NONE;
#pragma omp parallel for schedule(static)
    for (int64_t i = 0; i < gaussians->count; i++) {
        t.pieces[i] = piece_of(&t, i);
        if (gaussians->opacity[i] > 0) t.at[pixel[i]] = (int32_t)i;
    }
    return t;
}

static void thinning_free(Thinning *t) {
    ffp_free(t->at);
    ffp_free(t->pieces);
}

// True if `a` lies on the surface that `b` is a piece of.
static bool same_surface(const Piece *a, const Piece *b) {
    const real *p = a->centre, *q = b->centre, apart[3] = {p[0] - q[0], p[1] - q[1], p[2] - q[2]};
    return fabs(ffp_dot3(b->normal, apart)) <= SLACK * b->width && ffp_dot3(b->normal, a->normal) >= FACING;
}

// --- Views with one camera. ---

// Drops one of two splats of the same pixel in two views.
static void drop_repeated(Thinning *t, const real *trust, int first, int second) {
#pragma omp parallel for schedule(static)
    for (int64_t p = 0; p < t->area; p++) {
        const int64_t a = first * t->area + p, b = second * t->area + p;
        if (t->at[a] < 0 || t->at[b] < 0) continue;
        if (!same_surface(&t->pieces[t->at[b]], &t->pieces[t->at[a]])) continue;
        t->at[trust[b] > trust[a] ? a : b] = NONE;
    }
}

// --- Layers. ---

// How many times the splats that stay in view `view` describe the place of a piece: those of the four pixels
// around it that lie on its surface, each by its share and by how much finer it is. `open` becomes true if
// one around it is decided in this batch.
static real described_in(const Thinning *t, const Piece *piece, int view, bool *open) {
    real x, y, sum = 0;
    const real z = ffp_project(&t->capture->views[view].camera, piece->centre, &x, &y);
    x -= 0.5F;
    y -= 0.5F;
    if (!(z > 0 && x >= 0 && y >= 0 && x < (real)(t->width - 1) && y < (real)(t->height - 1))) return 0;
    const int left = (int)x, top = (int)y;
    const real a = x - (real)left, b = y - (real)top;
    const int32_t *at = t->at + view * t->area + (int64_t)top * t->width + left;
    for (int n = 0; n < 4; n++) {
        const int32_t other = at[(n / 2) * t->width + n % 2];
        *open |= other == OPEN;
        if (other < 0 || !same_surface(piece, &t->pieces[other])) continue;
        const real share = (n % 2 ? a : 1 - a) * (n / 2 ? b : 1 - b);
        sum += share * piece->area / t->pieces[other].area;
    }
    return sum;
}

// In all other views, or as soon as it is `enough`.
static real described(const Thinning *t, int64_t splat, real enough, bool *open) {
    const int own = (int)(t->pixel[splat] / t->area);
    real sum = 0;
    *open = false;
    for (int v = 0; v < t->capture->n_views && sum < enough; v++)
        if (v != own) sum += described_in(t, &t->pieces[splat], v, open);
    return sum;
}

static int finer_first(const void *a, const void *b) {
    const Candidate *x = a, *y = b;
    if (x->area != y->area) return x->area < y->area ? -1 : 1;
    return x->splat < y->splat ? -1 : x->splat > y->splat;
}

// Which of up to AT_ONCE candidates stay: one after the other, because that depends on which finer ones do,
// but only those that batches before do not leave out, and that have one of their own batch around them,
// need to take turns.
static void choose_some(Thinning *t, const Candidate *candidates, size_t count, real layers) {
    bool out[AT_ONCE], open[AT_ONCE];
    for (size_t i = 0; i < count; i++) t->at[t->pixel[candidates[i].splat]] = OPEN;
#pragma omp parallel for schedule(static)
    for (size_t i = 0; i < count; i++) out[i] = described(t, candidates[i].splat, layers, &open[i]) >= layers;
    for (size_t i = 0; i < count; i++) {
        const int64_t splat = candidates[i].splat;
        if (!out[i] && open[i]) out[i] = described(t, splat, layers, &open[i]) >= layers;
        t->at[t->pixel[splat]] = out[i] ? NONE : (int32_t)splat;
    }
}

static void choose(Thinning *t, real layers) {
    const int64_t pixels = t->area * t->capture->n_views;
    Candidate *candidates = ffp_alloc((size_t)t->gaussians->count + 1, sizeof *candidates);
    size_t count = 0;
    for (int64_t p = 0; p < pixels; p++) {
        if (t->at[p] >= 0) candidates[count++] = (Candidate){t->pieces[t->at[p]].area, t->at[p]};
        t->at[p] = NONE;
    }
    qsort(candidates, count, sizeof *candidates, finer_first);
    for (size_t i = 0; i < count; i += AT_ONCE)
        choose_some(t, candidates + i, count - i < AT_ONCE ? count - i : AT_ONCE, layers);
    ffp_free(candidates);
}

static bool stays(const Thinning *t, int64_t splat) {
    return t->at[t->pixel[splat]] == splat;
}

// A start's splats are as wide as a pixel that looks at them head-on, and leave gaps in a surface that no
// other view's splats close.
static void widen(const Thinning *t, real *scale) {
#pragma omp parallel for schedule(static)
    for (int64_t i = 0; i < t->gaussians->count; i++) {
        bool open;
        if (!stays(t, i)) continue;
        const real alone = 1 - fmin(described(t, i, 1, &open), 1), width = t->pieces[i].width;
        const real tilt = fmin(t->pieces[i].area / (width * width), WIDEST_TILT);
        const real wider = pow(WIDER * sqrt(tilt), alone);
        const int axis = axis_of(scale + 3 * i);
        for (int c = 0; c < 3; c++) scale[3 * i + c] *= c == axis ? 1 : wider;
    }
}

static int64_t gather(const Thinning *t, FfpGaussians *gaussians, int64_t *pixel) {
    const int64_t before = gaussians->count;
    int64_t *from = ffp_alloc((size_t)before + 1, sizeof *from), count = 0;
    for (int64_t i = 0; i < before; i++)
        if (stays(t, i)) from[count++] = i;
    for (int64_t i = 0; i < count; i++) pixel[i] = pixel[from[i]];
    ffp_gaussians_gather(gaussians, from, count);
    ffp_free(from);
    return before - count;
}

int64_t ffp_thin(FfpGaussians *gaussians, int64_t *pixel, const FfpCapture *capture, const real *trust,
                 double layers) {
    Thinning t = thinning_new(gaussians, pixel, capture);
    for (int v = 1; v < capture->n_views; v++)
        for (int u = 0; u < v; u++)
            if (ffp_same_device(&capture->views[u].camera, &capture->views[v].camera))
                drop_repeated(&t, trust, u, v);
    if (layers > 0) {
        choose(&t, (real)layers);
        widen(&t, gaussians->scale);
    }
    const int64_t left_out = gather(&t, gaussians, pixel);
    thinning_free(&t);
    return left_out;
}
