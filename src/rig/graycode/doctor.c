// Wrong settings of projector and camera, from photographs of codes.
#include <math.h>
#include <string.h>
#include "core/base/alloc.h"
#include "core/numerics/rank.h"
#include "rig/findings/tell.h"
#include "rig/graycode/decoder.h"

#define TAU 6.283185307179586
#define WIDE 2           // times FAR, pixels: stripes that are wide enough to be looked at
#define SUM_MOST 2.0     // of white, that a pixel counts with
#define RESOLVED 0.8     // of the contrast far from an edge, which a Gaussian's edge has
#define DEVIATIONS 1.28  // from its middle
#define CAMERA_SOFT 1.6  // pixels of the camera: what its pixels alone spread an edge over is less
#define FEW 200          // pixels that say nothing
#define FEW_HERE 20      // at one place of the panel
#define PERIOD_MOST 40   // pixels of the panel
#define PERIODS_LEAST 6  // of a wave in what is seen: of fewer, the surface has its own
#define ABOVE_NOISE 6    // times the median wave
#define KINDS_APART 0.03 // of white
#define FLICKERS 4       // times the light changes from pair to pair: kinds of edges are in different ones
#define CUT_LEAST 0.012  // of the panel
#define CUT_MOST 0.12
#define CUT_LINES 0.4 // share of the photograph's lines that end at one place of the panel

enum {
    FAR = FFP_GRAY_FAR,
    STRIPS = 16,
    WIDTHS = 6,
    KINDS = 2 * WIDTHS,
    WAVES = 400,
    SEEN_LEAST = 48,
    BORDER = 3
};

// The places between the panel's columns, or rows.
typedef struct Places {
    int size;
    double *sum, *count;      // [size + 1] what pairs add up to there, over so many pixels
    double mean[KINDS], seen; // of each kind of edge; how many places are seen
} Places;

// --- Each pair. ---

// Marks the pixels at both sides of edges between the line from `first` on and the one `back` pixels before.
static double mark_edges(const FfpGrayDecoder *d, const float *a, const float *b, size_t first, size_t back,
                         size_t count, uint8_t *far) {
    double edges = 0;
    for (size_t i = first; i < first + count; i++) {
        if (!d->checked[i] || !d->checked[i - back] || (a[i] > b[i]) == (a[i - back] > b[i - back])) continue;
        far[i] = far[i - back] = 0, edges++;
    }
    return edges;
}

static void go_on(uint8_t *far, const uint8_t *from, size_t count) {
    for (size_t i = 0; i < count; i++)
        if (from[i] < far[i]) far[i] = (uint8_t)(from[i] + 1);
}

// City-block distance of each pixel from the next edge, up to FAR; *edges: how many there are. NULL: more
// than wide stripes have.
static uint8_t *edge_distances(const FfpGrayDecoder *d, const float *a, const float *b, double checked,
                               double *edges) {
    const size_t width = (size_t)d->width, height = (size_t)d->height;
    uint8_t *far = ffp_alloc(d->pixels, 1);
    memset(far, FAR, d->pixels);
    for (size_t y = 0; y < height; y++) {
        *edges += mark_edges(d, a, b, y * width + 1, 1, width - 1, far);
        if (y > 0) *edges += mark_edges(d, a, b, y * width, width, width, far);
    }
    if (!(checked > WIDE * FAR * *edges)) return ffp_free(far), NULL;
    for (size_t y = 0; y < height; y++) {
        uint8_t *row = far + y * width;
        if (y > 0) go_on(row, row - width, width);
        for (size_t x = 1; x < width; x++) go_on(row + x, row + x - 1, 1);
    }
    for (size_t y = height; y-- > 0;) {
        uint8_t *row = far + y * width;
        if (y + 1 < height) go_on(row, row + width, width);
        for (size_t x = width - 1; x-- > 0;) go_on(row + x, row + x + 1, 1);
    }
    return far;
}

// For each pixel the pair with the least contrast, whose edge is the nearest, and its sum. Where white is at
// the camera's limit, none: sums are too large there.
static void see_weakest(FfpGrayDecoder *d, int axis, const float *a, const float *b) {
    if (!d->weakest[axis]) {
        d->weakest[axis] = ffp_alloc(d->pixels, 2);
        memset(d->weakest[axis], UINT8_MAX, 2 * d->pixels);
    }
    for (size_t i = 0; i < d->pixels; i++) {
        if (!d->checked[i] || (double)(d->black[i] + d->light[i]) >= FFP_GRAY_CLIPPED) continue;
        uint8_t *here = d->weakest[axis] + 2 * i;
        const float contrast = fminf(254 * fabsf(a[i] - b[i]) / d->light[i], 254);
        if (contrast >= (float)here[0]) continue;
        const float sum = (a[i] + b[i] - 2 * d->black[i]) / d->light[i];
        here[0] = (uint8_t)contrast, here[1] = (uint8_t)lrintf(127 * fmaxf(0, fminf(sum, 2)));
    }
}

// Root mean square of what strips of the photograph differ by from those beside them.
static double strips_of(const double sums[STRIPS], const double counts[STRIPS]) {
    double square = 0, n = 0;
    for (int i = 1; i + 1 < STRIPS; i++) {
        if (fmin(counts[i], fmin(counts[i - 1], counts[i + 1])) < FEW) continue;
        const double off =
            sums[i] / counts[i] - (sums[i - 1] / counts[i - 1] + sums[i + 1] / counts[i + 1]) / 2;
        square += off * off, n++;
    }
    return n > 0 ? sqrt(square / n) : 0;
}

static double share_of(float grey, double black, double light) {
    const double share = ((double)grey - black) / light;
    return share < SUM_MOST ? share : SUM_MOST;
}

void ffp_gray_see_pair(FfpGrayDecoder *d, int axis, int bit, float *const grey[2],
                       const double colours[2][3]) {
    FfpGrayFigures *f = &d->report->figures;
    const float *a = grey[0], *b = grey[1];
    see_weakest(d, axis, a, b);
    double edges = 0, sum = 0, count = 0, checked = 0, blacks = 0, strips[STRIPS] = {0}, counts[STRIPS] = {0};
    double profile[3][FAR + 1] = {{0}}; // as the figures' bright, dark and count
    for (size_t i = 0; i < d->pixels; i++) checked += d->checked[i] != 0;
    uint8_t *far = f->pairs < FFP_GRAY_PAIRS ? edge_distances(d, a, b, checked, &edges) : NULL;
    for (size_t i = 0; far && i < d->pixels; i++) {
        if (!d->checked[i]) continue;
        const double light = (double)d->light[i], black = (double)d->black[i],
                     bright = share_of(a[i] > b[i] ? a[i] : b[i], black, light),
                     dark = share_of(a[i] > b[i] ? b[i] : a[i], black, light);
        profile[0][far[i]] += bright, profile[1][far[i]] += dark, profile[2][far[i]]++;
        blacks += black / (black + light);
        if (2 * far[i] < FAR) continue;
        const size_t strip = i / (size_t)d->width * STRIPS / (size_t)d->height;
        sum += bright + dark, count++;
        strips[strip] += bright + dark, counts[strip]++;
    }
    ffp_free(far);
    if (profile[2][FAR] < FEW) return;
    for (int k = 0; k <= FAR; k++) {
        const double lit = profile[0][FAR] / profile[2][FAR];
        f->bright[k] += profile[0][k] / lit, f->dark[k] += profile[1][k] / lit, f->count[k] += profile[2][k];
    }
    // The coarsest code's only edge may lie in an object's shadow.
    if (bit > 0) f->step = (double)(1 << (d->bits[axis] - bit)) * edges / checked;
    f->black = blacks / checked;
    f->sum[f->pairs] = sum / count;
    for (int c = 0; c < 3; c++)
        f->colour[f->pairs][c] = colours[0][c] * colours[1][c] > 0 ? colours[0][c] + colours[1][c] : 0;
    // A white that was made takes each strip's light from other photographs.
    if (axis == 0 && d->from->noise == 0) f->bands += (strips_of(strips, counts) - f->bands) / (f->pairs + 1);
    f->pairs++;
}

// Deviation of numbers from their mean, as a share of it; those that are 0 are unknown.
static double deviation_of(const double *values, int n) {
    double sum = 0, squares = 0, count = 0;
    for (int i = 0; i < n; i++)
        if (values[i] > 0) sum += values[i], squares += values[i] * values[i], count++;
    const double mean = sum / fmax(count, 1);
    return mean > 0 ? sqrt(fmax(squares / count - mean * mean, 0)) / mean : 0;
}

// How much the light changes from pair to pair, or its colour.
static double flicker_of(const FfpGrayFigures *f) {
    double most = deviation_of(f->sum, f->pairs);
    for (int c = 0; c < 3; c += 2) {
        double ratios[FFP_GRAY_PAIRS] = {0};
        for (int i = 0; i < f->pairs; i++)
            if (f->colour[i][1] > 0) ratios[i] = f->colour[i][c] / f->colour[i][1];
        most = fmax(most, deviation_of(ratios, f->pairs));
    }
    return most;
}

// --- All of them, once positions are known. ---

// Which code has its edge there, by its stripes' width, and whether it rises or falls.
static int kind_of(int n) {
    int width = 0;
    while (width < WIDTHS - 1 && !(n >> width & 1)) width++;
    return 2 * width + (n >> (width + 1) & 1);
}

// The largest wave of what pairs add up to along the panel, beside the means of each kind of edge.
static void find_wave(const Places *p, FfpGrayScaling *s) {
    const double least = fmax(1.0 / PERIOD_MOST, PERIODS_LEAST / p->seen);
    real waves[WAVES];
    for (int k = 0; k < WAVES; k++) {
        const double frequency = least + (0.5 - least) * k / WAVES;
        double even = 0, odd = 0;
        for (int n = 1; n < p->size; n++) {
            if (!(p->count[n] > 0)) continue;
            const double off = p->sum[n] - p->mean[kind_of(n)];
            even += off * cos(TAU * frequency * n), odd += off * sin(TAU * frequency * n);
        }
        const double wave = 2 * hypot(even, odd) / p->seen;
        waves[k] = (real)wave;
        if (wave > s->wave) s->wave = wave, s->period = 1 / frequency;
    }
    if (s->wave < ABOVE_NOISE * (double)ffp_median(waves, WAVES)) *s = (FfpGrayScaling){0};
}

// Each place between two columns (or rows) of the panel is the edge of one code. A projector that scales its
// picture draws some of them sharp and others through a grey in between, by turns.
static void find_scaling(const FfpGrayDecoder *d, const FfpImage *map, int axis, double flicker,
                         FfpGrayScaling *s) {
    Places p = {.size = axis ? d->from->height : d->from->width};
    double number[KINDS] = {0};
    p.sum = ffp_alloc((size_t)p.size + 1, sizeof *p.sum);
    p.count = ffp_alloc((size_t)p.size + 1, sizeof *p.count);
    for (size_t i = 0; i < d->pixels; i++) {
        const real *at = map->data + 3 * i;
        const uint8_t *weakest = d->weakest[axis] + 2 * i;
        if (!(at[2] > 0) || weakest[0] == UINT8_MAX) continue;
        const int n = (int)fmin(fmax(lrint((double)at[axis]), 0), p.size);
        p.sum[n] += weakest[1] / 127.0, p.count[n]++;
    }
    for (int n = 1; n < p.size; n++) {
        if (p.count[n] < FEW_HERE) p.count[n] = 0;
        if (!(p.count[n] > 0)) continue;
        p.sum[n] /= p.count[n], p.mean[kind_of(n)] += p.sum[n], number[kind_of(n)]++, p.seen++;
    }
    for (int k = 0; k < KINDS; k++) p.mean[k] /= fmax(number[k], 1);
    if (p.seen >= SEEN_LEAST) {
        const double finest = (p.mean[0] + p.mean[1]) / 2, finer = (p.mean[2] + p.mean[3]) / 2,
                     coarse = (p.mean[4] + p.mean[5]) / 2, off = coarse - fmin(finest, finer);
        find_wave(&p, s);
        // Of half and of quarter pixels: waves of two and four.
        if (off > KINDS_APART + FLICKERS * flicker && off > s->wave)
            *s = (FfpGrayScaling){.wave = off, .period = coarse - finer > off / 2 ? 4 : 2};
    }
    ffp_free(p.sum), ffp_free(p.count);
}

// Where a line of the photograph (a row, or a column: `down`) first and last sees the panel; false: nowhere,
// or beyond the photograph.
static bool ends_of(const FfpGrayDecoder *d, const FfpImage *map, int axis, bool down, int line,
                    double ends[2]) {
    const int length = down ? d->height : d->width;
    const size_t from = down ? (size_t)line : (size_t)line * (size_t)d->width,
                 step = down ? (size_t)d->width : 1;
    int first = -1, last = -1, n = 0;
    for (int k = 0; k < length; k++) {
        if (!(map->data[3 * (from + (size_t)k * step) + 2] > 0)) continue;
        if (first < 0) first = k;
        last = k, n++;
    }
    if (n < SEEN_LEAST / 4 || first < BORDER || last >= length - BORDER) return false;
    const double a = (double)map->data[3 * (from + (size_t)first * step) + (size_t)axis],
                 b = (double)map->data[3 * (from + (size_t)last * step) + (size_t)axis];
    ends[0] = fmin(a, b), ends[1] = fmax(a, b);
    return true;
}

// Where the light ends along a straight line of the panel at both sides, it is the picture's border: ends of
// it if one is farther from the panel's than it may be.
static void find_ends(const FfpGrayDecoder *d, const FfpImage *map, int axis, bool down, double ends[2]) {
    const int size = axis ? d->from->height : d->from->width, lines = down ? d->width : d->height;
    int *counts[2] = {ffp_alloc((size_t)size + 2, sizeof(int)), ffp_alloc((size_t)size + 2, sizeof(int))};
    int at[2] = {0}, most[2] = {0};
    const double least = fmax(CUT_LEAST * size, 3 + 2 * (1 << d->dropped[axis]));
    for (int line = 0; line < lines; line++) {
        double u[2];
        if (!ends_of(d, map, axis, down, line, u)) continue;
        for (int e = 0; e < 2; e++) counts[e][(int)fmin(fmax(u[e], 0), size)]++;
    }
    for (int e = 0; e < 2; e++)
        for (int n = 1; n <= size; n++) {
            const int here = counts[e][n - 1] + counts[e][n] + counts[e][n + 1];
            if (here > most[e]) most[e] = here, at[e] = n;
        }
    for (int e = 0; e < 2; e++) {
        const double off = e ? size - at[e] : at[e];
        if (most[e] >= CUT_LINES * lines && most[1 - e] >= CUT_LINES / 2 * lines && off > least &&
            off < CUT_MOST * size)
            ends[0] = at[0], ends[1] = at[1];
    }
    ffp_free(counts[0]), ffp_free(counts[1]);
}

void ffp_gray_see_panel(FfpGrayDecoder *d, const FfpImage *map) {
    FfpGrayFigures *f = &d->report->figures;
    const bool clipped = d->report->clipped > ffp_rule(FFP_RULE_CODES_CLIPPED)->limit;
    for (int axis = 0; axis < 2; axis++) {
        if (d->weakest[axis] && !clipped) find_scaling(d, map, axis, flicker_of(f), &f->scaling[axis]);
        for (int down = 0; down < 2; down++) find_ends(d, map, axis, down, f->ends[axis]);
        f->size[axis] = axis ? d->from->height : d->from->width;
    }
}

// --- As findings. ---

static bool tell_above(FfpRuleId rule, double figure, const char *view) {
    const bool above = figure > ffp_rule(rule)->limit;
    if (above) ffp_tell(rule, &(FfpFacts){.view = view, .figure = figure});
    return above;
}

// Edges of stripes: whether they are sharpened, or soft.
static bool tell_edges(const FfpGrayFigures *f, const double bright[FAR + 1], const double dark[FAR + 1],
                       const char *view) {
    double most = 0, x = 0;
    for (int k = 1; k < FAR; k++) most = fmax(most, bright[k]);
    const bool sharpened = tell_above(FFP_RULE_CODES_SHARPENED, most / bright[FAR] - 1, view);
    const double target = RESOLVED * (bright[FAR - 1] - dark[FAR - 1]); // a veil lies farther
    while (x < FAR && bright[(int)x] - dark[(int)x] < target) x++;
    if (x > 0 && x < FAR) {
        const double here = bright[(int)x] - dark[(int)x], before = bright[(int)x - 1] - dark[(int)x - 1];
        x -= (here - target) / (here - before);
    }
    const double camera = (x + 0.5) / DEVIATIONS, panel = camera * f->step;
    if (camera > CAMERA_SOFT && panel > ffp_rule(FFP_RULE_CODES_SOFT)->limit)
        ffp_tell(FFP_RULE_CODES_SOFT, &(FfpFacts){.view = view, .figure = panel, .x = camera});
    return sharpened;
}

static bool tell_ends(const FfpGrayFigures *f, int axis, const char *view) {
    const double *ends = f->ends[axis];
    if (!(ends[1] > 0)) return false;
    ffp_tell(
        FFP_RULE_CODES_CUT,
        &(FfpFacts){
            .view = view, .a = axis ? "rows" : "columns", .x = ends[0], .y = ends[1], .z = f->size[axis]});
    return true;
}

static bool tell_scaling(const FfpGrayFigures *f, int axis, const char *view) {
    const FfpGrayScaling *s = &f->scaling[axis];
    if (!(s->wave > ffp_rule(FFP_RULE_CODES_SCALED)->limit)) return false;
    ffp_tell(FFP_RULE_CODES_SCALED, &(FfpFacts){.view = view,
                                                .figure = s->wave,
                                                .a = axis ? "rows" : "columns",
                                                .z = s->period,
                                                .x = f->size[axis] * (1 + 1 / s->period),
                                                .y = f->size[axis] * (1 - 1 / s->period)});
    return true;
}

void ffp_gray_tell_figures(const FfpGrayFigures *f, const char *view) {
    double bright[FAR + 1], dark[FAR + 1];
    if (f->pairs == 0 || f->count[FAR] < FEW) return;
    for (int k = 0; k <= FAR; k++)
        bright[k] = f->bright[k] / fmax(f->count[k], 1), dark[k] = f->dark[k] / fmax(f->count[k], 1);
    tell_above(FFP_RULE_CODES_VEIL, dark[FAR] / bright[FAR], view);
    tell_above(FFP_RULE_CODES_BLACK, f->black, view);
    const double straight = (bright[1] + dark[1]) / (bright[FAR] + dark[FAR]);
    if (straight < ffp_rule(FFP_RULE_CODES_RESPONSE)->limit) {
        ffp_tell(FFP_RULE_CODES_RESPONSE, &(FfpFacts){.view = view, .figure = straight});
        return; // what follows takes values for light
    }
    const bool flicker = tell_above(FFP_RULE_CODES_FLICKER, flicker_of(f), view),
               bands = tell_above(FFP_RULE_CODES_BANDS, f->bands, view),
               sharpened = tell_edges(f, bright, dark, view);
    // Overscan scales, too, one axis is enough, and other faults make edges differ, too.
    const bool columns = tell_ends(f, 0, view), rows = tell_ends(f, 1, view);
    if (!columns && !rows && !flicker && !bands && !sharpened && !tell_scaling(f, 0, view))
        tell_scaling(f, 1, view);
}
