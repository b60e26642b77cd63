#include "core/capture/coarse_depth.h"
#include <stdint.h>
#include <tgmath.h>
#include "core/base/arena.h"
#include "core/image/lookup.h"
#include "core/numerics/rank.h"

#define VIEWS 8     // that are looked at, evenly chosen
#define SAMPLES 300 // pixels of each
#define PATTERNS 12 // evenly chosen
#define WINDOW 9    // pixels that a sample compares, all at one depth
#define DEPTHS_MAX 512
#define NEAREST 0.5 // depths searched, in distances between camera and projector
#define FARTHEST 100
#define LIT 0.02F // linear radiance that white must add
#define CLIPPED 0.98F
#define COST_MAX 0.25F // mean square: highlights and shadow edges must not decide
#define COST_DARK 0.3F // of what lies outside the pattern
#define THICK 1.1F     // an object's depth may range by this factor about the middle
#define WIDE 1.3F      // and single pixels are searched within this one
#define CLEARLY 0.75F  // of the median over depths: at most, for depths to be told apart
#define REACHED 0.9F   // of the samples that the projector reaches at the best depth: no fewer
#define TRUSTED 2      // times the mean cost: more, and a pixel has found nothing
#define LEAST 20       // samples
#define ALONE 0.15F // of the median of a sample's costs: at most, for it to tell its depth without the others

typedef struct Sample {
    real ray[WINDOW][3]; // camera's frame, z = 1
    real ratio[WINDOW][PATTERNS][3];
    bool valid[WINDOW];
} Sample;

typedef struct Sweep {
    const FfpView *view;
    int n_patterns, n_depths, n_samples;
    const FfpSummed *patterns; // [n_patterns]
    int indices[PATTERNS];     // of the capture's patterns
    real near, far;            // camera depths
    Sample *samples;           // [n_samples]
    real *costs;               // [n_samples, n_depths]
} Sweep;

// --- Samples. ---

// The share of white that the projector sent to the pixel, under each pattern.
static bool read_pixel(const Sweep *sweep, const FfpCapture *capture, int x, int y, Sample *sample, int k) {
    const FfpView *view = sweep->view;
    if (x < 0 || y < 0 || x >= view->camera.width || y >= view->camera.height) return false;
    const ptrdiff_t i = (ptrdiff_t)y * view->camera.width + x;
    const real *black = view->images[capture->black].data + 3 * i,
               *white = view->images[capture->white].data + 3 * i;
    if (view->coverage.data[i] < 1) return false;
    for (int c = 0; c < 3; c++)
        if (!(white[c] - black[c] > LIT) || white[c] > CLIPPED) return false;
    for (int p = 0; p < sweep->n_patterns; p++)
        for (int c = 0; c < 3; c++) {
            const real seen = view->images[sweep->indices[p]].data[3 * i + c];
            sample->ratio[k][p][c] = fmin(fmax((seen - black[c]) / (white[c] - black[c]), (real)0), (real)1);
        }
    sample->ray[k][0] = ((real)x + 0.5F - view->camera.cx) / view->camera.fx;
    sample->ray[k][1] = ((real)y + 0.5F - view->camera.cy) / view->camera.fy;
    sample->ray[k][2] = 1;
    return true;
}

// Pixels of a grid as coarse as it takes; windows are a hundredth of the picture wide.
static void collect(Sweep *sweep, const FfpCapture *capture) {
    static const int offsets[WINDOW][2] = {{0, 0}, {-1, -1}, {0, -1}, {1, -1}, {-1, 0},
                                           {1, 0}, {-1, 1},  {0, 1},  {1, 1}};
    const int width = sweep->view->camera.width, height = sweep->view->camera.height;
    const int step = (int)fmax(1, floor(sqrt((double)width * height / (4.0 * SAMPLES)))),
              apart = width > 200 ? width / 200 : 1;
    Sample *all = ffp_alloc((size_t)(width / step + 1) * (size_t)(height / step + 1), sizeof *all);
    int n = 0;
    for (int y = step / 2; y < height; y += step)
        for (int x = step / 2; x < width; x += step) {
            Sample *sample = &all[n];
            if (!read_pixel(sweep, capture, x, y, sample, 0)) continue;
            for (int k = 0; k < WINDOW; k++)
                sample->valid[k] = read_pixel(sweep, capture, x + apart * offsets[k][0],
                                              y + apart * offsets[k][1], sample, k);
            n++;
        }
    const int every = n / SAMPLES + 1;
    sweep->samples = ffp_alloc((size_t)(n / every) + 1, sizeof *sweep->samples);
    for (int i = 0; i < n; i += every) sweep->samples[sweep->n_samples++] = all[i];
    ffp_free(all);
}

// --- Costs. ---

static real depth_of(const Sweep *sweep, int d) {
    const real share = (real)d / (real)(sweep->n_depths - 1); // uniform in the inverse
    return 1 / ((1 - share) / sweep->near + share / sweep->far);
}

static bool is_lit(const FfpCamera *projector, real z, real x, real y) {
    return z > 0 && x >= -1 && y >= -1 && x <= (real)projector->width + 1 && y <= (real)projector->height + 1;
}

// Mean square between what the pattern shows there and what was seen; COST_DARK where no light is.
static real cost_of(const Sweep *sweep, const Sample *sample, real depth) {
    const FfpCamera *camera = &sweep->view->camera, *projector = &sweep->view->projector;
    real sum = 0;
    int count = 0;
    for (int k = 0; k < WINDOW; k++) {
        if (!sample->valid[k]) continue;
        real point[3], x, y;
        for (int i = 0; i < 3; i++) {
            point[i] = camera->pose[4 * i + 3];
            for (int j = 0; j < 3; j++) point[i] += camera->pose[4 * i + j] * sample->ray[k][j] * depth;
        }
        const real z = ffp_project(projector, point, &x, &y);
        count++;
        if (!is_lit(projector, z, x, y)) {
            sum += COST_DARK;
            continue;
        }
        const real side = fmax(depth / camera->fx * projector->fx / z, (real)1);
        real square = 0;
        for (int p = 0; p < sweep->n_patterns; p++) {
            real colour[3];
            ffp_lookup(&sweep->patterns[p], x, y, side, side, colour);
            for (int c = 0; c < 3; c++)
                square += (colour[c] - sample->ratio[k][p][c]) * (colour[c] - sample->ratio[k][p][c]);
        }
        sum += fmin(square / (real)(3 * sweep->n_patterns), COST_MAX);
    }
    return sum / (real)count;
}

// Depths between which the projection moves by about a pattern's pixel.
static void settle_depths(Sweep *sweep) {
    const FfpCamera *camera = &sweep->view->camera, *projector = &sweep->view->projector;
    real square = 0;
    for (int i = 0; i < 3; i++) square += pow(camera->pose[4 * i + 3] - projector->pose[4 * i + 3], (real)2);
    sweep->near = (real)NEAREST * sqrt(square);
    sweep->far = FARTHEST * sqrt(square);
    const real travel = projector->fx / (real)NEAREST;
    sweep->n_depths = (int)fmin(fmax(travel / 1.5F, (real)64), (real)DEPTHS_MAX);
}

static void fill_costs(Sweep *sweep) {
    sweep->costs = ffp_alloc((size_t)sweep->n_samples * (size_t)sweep->n_depths, sizeof *sweep->costs);
#pragma omp parallel for schedule(static)
    for (int s = 0; s < sweep->n_samples; s++)
        for (int d = 0; d < sweep->n_depths; d++)
            sweep->costs[(size_t)s * (size_t)sweep->n_depths + (size_t)d] =
                cost_of(sweep, &sweep->samples[s], depth_of(sweep, d));
}

// --- What they say. ---

// The least cost of a sample among depths within a factor of depth d; *best is where.
static real least_near(const Sweep *sweep, int s, int d, real factor, int *best) {
    const real *costs = sweep->costs + (size_t)s * (size_t)sweep->n_depths, middle = depth_of(sweep, d);
    *best = d;
    for (int k = d; k >= 0 && depth_of(sweep, k) * factor > middle; k--)
        if (costs[k] < costs[*best]) *best = k;
    for (int k = d; k < sweep->n_depths && depth_of(sweep, k) < middle * factor; k++)
        if (costs[k] < costs[*best]) *best = k;
    return costs[*best];
}

static real camera_depth(const FfpCamera *camera, const double point[3]) {
    real depth = 0;
    for (int i = 0; i < 3; i++) depth += camera->pose[4 * i + 2] * ((real)point[i] - camera->pose[4 * i + 3]);
    return depth;
}

// Share of the samples that the projector can reach at depth d.
static real share_lit(const Sweep *sweep, int d) {
    int lit = 0;
    for (int s = 0; s < sweep->n_samples; s++)
        lit += sweep->costs[(size_t)s * (size_t)sweep->n_depths + (size_t)d] <= COST_MAX;
    return (real)lit / (real)sweep->n_samples;
}

// The depth that all samples fit best; *cost is the mean there. -1 when it is not clearly better than others
// at which the projector reaches about as many samples, and `guess` is one of these.
static int common_depth(const Sweep *sweep, const double guess[3], real *cost) {
    real *means = ffp_alloc(2 * (size_t)sweep->n_depths, sizeof *means), *possible = means + sweep->n_depths;
    int best = 0, n = 0;
    for (int d = 0; d < sweep->n_depths; d++) {
        // The least nearby is kind to deep objects, what is there tells repeating patterns apart.
        for (int s = 0; s < sweep->n_samples; s++) {
            int at;
            const real here = sweep->costs[(size_t)s * (size_t)sweep->n_depths + (size_t)d];
            means[d] += (least_near(sweep, s, d, THICK, &at) + here) / (real)(2 * sweep->n_samples);
        }
        if (means[d] < means[best]) best = d;
    }
    *cost = means[best];
    const real lit = REACHED * share_lit(sweep, best);
    real nearest = INFINITY, farthest = 0;
    for (int d = 0; d < sweep->n_depths; d++) {
        if (share_lit(sweep, d) < lit) continue;
        nearest = fmin(nearest, depth_of(sweep, d));
        farthest = fmax(farthest, depth_of(sweep, d));
        possible[n++] = means[d];
    }
    const bool clear = *cost < CLEARLY * ffp_median(possible, (size_t)n);
    ffp_free(means);
    const real guessed = guess ? camera_depth(&sweep->view->camera, guess) : 0;
    return clear || guessed < nearest || guessed > farthest ? best : -1;
}

static void add_point(const Sweep *sweep, int s, real depth, real point[3]) {
    const FfpCamera *camera = &sweep->view->camera;
    for (int i = 0; i < 3; i++) {
        point[i] = camera->pose[4 * i + 3];
        for (int j = 0; j < 3; j++) point[i] += camera->pose[4 * i + j] * sweep->samples[s].ray[0][j] * depth;
    }
}

static int add_points(const Sweep *sweep, const double guess[3], real points[][3]) {
    real mean;
    const int common = common_depth(sweep, guess, &mean);
    int n = 0;
    for (int s = 0; common >= 0 && s < sweep->n_samples; s++) {
        int at;
        if (least_near(sweep, s, common, WIDE, &at) > TRUSTED * mean) continue;
        add_point(sweep, s, depth_of(sweep, at), points[n++]);
    }
    return n;
}

// Of each sample alone, the depth that fits it best, if it does so clearly better than most.
static int add_clear_points(const Sweep *sweep, const double guess[3], real points[][3]) {
    (void)guess;
    real *sorted = ffp_alloc((size_t)sweep->n_depths, sizeof *sorted);
    int n = 0;
    for (int s = 0; s < sweep->n_samples; s++) {
        const real *costs = sweep->costs + (size_t)s * (size_t)sweep->n_depths;
        int best = 0, possible = 0;
        for (int d = 0; d < sweep->n_depths; d++) {
            if (costs[d] < costs[best]) best = d;
            if (costs[d] <= COST_MAX) sorted[possible++] = costs[d];
        }
        if (possible < 2 || costs[best] > ALONE * ffp_median(sorted, (size_t)possible)) continue;
        add_point(sweep, s, depth_of(sweep, best), points[n++]);
    }
    ffp_free(sorted);
    return n;
}

// Of `count`, at most `most`, evenly chosen: the k-th.
static int choice(int k, int count, int most) {
    return count <= most ? k : (int)((int64_t)k * count / most);
}

// Points that the samples of a view give; returns their number.
typedef int Say(const Sweep *sweep, const double guess[3], real points[][3]);

static int sweep_view(const FfpCapture *capture, const FfpView *view, const int *usable, int n_usable,
                      const FfpSummed *summed, Say *say, const double guess[3], real points[][3]) {
    Sweep sweep = {.view = view, .patterns = summed, .n_patterns = n_usable};
    for (int p = 0; p < n_usable; p++) sweep.indices[p] = usable[p];
    collect(&sweep, capture);
    settle_depths(&sweep);
    int n = 0;
    if (sweep.n_samples >= LEAST && sweep.near > 0) {
        fill_costs(&sweep);
        n = say(&sweep, guess, points);
    }
    ffp_free(sweep.samples);
    ffp_free(sweep.costs);
    return n;
}

static bool has_picture(const FfpView *view, int pattern) {
    return view->images && view->images[pattern].data;
}

// Patterns besides black and white that all views have.
static int usable_patterns(const FfpCapture *capture, int usable[PATTERNS]) {
    int all[FFP_PATTERNS_MAX], n = 0;
    for (int p = 0; p < ffp_patterns_shown(capture); p++) {
        bool ok = p != capture->black && p != capture->white && capture->patterns[p].image.data;
        for (int v = 0; v < capture->n_views && ok; v++) ok = has_picture(&capture->views[v], p);
        if (ok) all[n++] = p;
    }
    const int count = n < PATTERNS ? n : PATTERNS;
    for (int k = 0; k < count; k++) usable[k] = all[choice(k, n, PATTERNS)];
    return count;
}

static int points_of(const FfpCapture *capture, Say *say, const double guess[3],
                     real points[FFP_COARSE_POINTS_MAX][3]) {
    int usable[PATTERNS], n = 0;
    const int n_usable = usable_patterns(capture, usable),
              n_views = capture->n_views < VIEWS ? capture->n_views : VIEWS;
    FfpSummed summed[PATTERNS];
    if (n_usable == 0) return 0;
    for (int p = 0; p < n_usable; p++) summed[p] = ffp_summed_new(&capture->patterns[usable[p]].image);
    for (int k = 0; k < n_views; k++) {
        const FfpView *view = &capture->views[choice(k, capture->n_views, VIEWS)];
        const bool complete = has_picture(view, capture->black) && has_picture(view, capture->white) &&
                              view->coverage.data != NULL;
        if (complete) n += sweep_view(capture, view, usable, n_usable, summed, say, guess, points + n);
    }
    for (int p = 0; p < n_usable; p++) ffp_summed_free(&summed[p]);
    return n;
}

int ffp_coarse_points(const FfpCapture *capture, const double guess[3],
                      real points[FFP_COARSE_POINTS_MAX][3]) {
    return points_of(capture, add_points, guess, points);
}

int ffp_clear_points(const FfpCapture *capture, real points[FFP_COARSE_POINTS_MAX][3]) {
    return points_of(capture, add_clear_points, NULL, points);
}
