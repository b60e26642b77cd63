// Photographs as light, and pairs of them as signals.
#include <math.h>
#include <stdio.h>
#include <string.h>
#include "core/base/alloc.h"
#include "core/base/call.h"
#include "core/base/file.h"
#include "core/image/photograph.h"
#include "core/numerics/rank.h"
#include "rig/findings/tell.h"
#include "rig/graycode/decoder.h"
#include "rig/graycode/edges.h"

enum { LEVELS = 1024 };

#define LIGHT_SHARE 0.02 // and of what it adds typically
#define DIM 2.0          // times the least light that is typical where codes can be read
#define LIT_LEAST 64     // pixels
#define NOISE_SHARE 0.1  // of the pixels, by which white must be the darker one where noise counts
#define NOISES 4.0       // deviations of the noise that are light
#define BRIGHT 0.25      // of the typical light: pixels that checks are made on
#define OVEREXPOSED 0.5  // under black, typically: nothing can be told
#define BOTH_LIGHT 0.6   // of white: the darker of a pair where both are light
#define BOTH_DARK 0.25   // what they add up to where both are dark
#define ALIKE_SHARE 0.25 // of the pixels: that is not a pair
#define RIGHT 0.25       // of white: by as much the sum of a pair may be off
#define PAIR_SHARE 0.8   // of the pixels that must be right where two are each other's inverse
#define PAIR_LOW 0.7     // what a pattern and its inverse add up to, in white
#define PAIR_HIGH 1.4    // and against white
#define PAIR_APART 1.25  // where one of a pair is the brighter, and where the other is: exposed differently
#define FINE 3           // finest bits, whose stripes a projector that scales its picture dims

void ffp_gray_cache_free(FfpGrayCache *cache) {
    for (int i = 0; i < cache->n; i++) {
        ffp_free(cache->files[i].grey);
        ffp_image_free(&cache->files[i].luma);
    }
    ffp_free(cache->codes), ffp_free(cache->other);
    *cache = (FfpGrayCache){.n = 0};
}

// The cache's copy of a file; NULL: none.
static float *take_from_cache(FfpGrayCache *cache, const char *path, int *width, int *height) {
    for (int i = 0; cache && i < cache->n; i++) {
        float *grey = cache->files[i].grey;
        if (!grey || strcmp(cache->files[i].path, path) != 0) continue;
        cache->files[i].grey = NULL;
        *width = cache->files[i].width, *height = cache->files[i].height;
        return grey;
    }
    return NULL;
}

static bool read_light(float **grey, double colour[3], int *width, int *height, const FfpGrayDecoder *d,
                       const char *path, FfpError *err) {
    *grey = take_from_cache(d->from->cache, path, width, height);
    return *grey ||
           ffp_gray_read(grey, NULL, colour, width, height, path, d->from->linear, d->from->shrink, err);
}

bool ffp_gray_read(float **grey, FfpImage *luma, double colour[3], int *width, int *height, const char *path,
                   bool linear, int shrink, FfpError *err) {
    FfpImage rgb = {0};
    int whole[2];
    if (!ffp_photograph_read_reduced(&rgb, NULL, whole, path, linear, shrink > 0 ? shrink : 1, true, NULL,
                                     err))
        return false;
    const size_t pixels = (size_t)rgb.width * (size_t)rgb.height;
    *width = rgb.width, *height = rgb.height;
    *grey = ffp_take(pixels, sizeof(float));
    double sums[3] = {0};
    for (size_t i = 0; i < pixels; i++) {
        const real *p = rgb.data + 3 * i;
        (*grey)[i] = (float)(p[0] + p[1] + p[2]) / 3;
        for (int c = 0; c < 3; c++) sums[c] += (double)p[c];
    }
    for (int c = 0; colour && c < 3; c++) colour[c] = sums[c] / (double)pixels;
    if (luma) *luma = ffp_photograph_luma(&rgb);
    ffp_image_free(&rgb);
    return true;
}

// One that must be of the others' size.
static bool read_next(float **grey, double colour[3], const FfpGrayDecoder *d, const char *path,
                      FfpError *err) {
    int width, height;
    if (!read_light(grey, colour, &width, &height, d, path, err)) return false;
    return (width == d->width && height == d->height) ||
           ffp_fail(err, FFP_ERROR_FILE, path, "image is %d x %d, but the others are %d x %d", width, height,
                    d->width, d->height);
}

// --- What white adds to black. ---

static bool looked_at(const FfpGrayDecoder *d, size_t pixel) {
    const FfpImage *region = d->from->region;
    return !region || region->data[pixel] > 0;
}

bool ffp_gray_fail_dark(double black, double added, const char *white, FfpError *err) {
    if (added < -FFP_GRAY_LIT) return ffp_fail_by(FFP_RULE_PLAIN_SWAPPED, &(FfpFacts){0}, white, err);
    return ffp_fail_by(black > OVEREXPOSED ? FFP_RULE_BOTH_CLIPPED : FFP_RULE_NOTHING_LIT, &(FfpFacts){0},
                       white, err);
}

static bool tell_dark(const FfpGrayDecoder *d, FfpError *err) {
    double black = 0, added = 0;
    for (size_t i = 0; i < d->pixels; i++)
        black += (double)d->black[i] / (double)d->pixels, added += (double)d->light[i] / (double)d->pixels;
    return ffp_gray_fail_dark(black, added, d->from->white, err);
}

// The least light that is more than noise: only noise makes white darker than black (the median of a normal
// distribution's side lies at 0.67 deviations).
static double least_light(const FfpGrayDecoder *d) {
    if (d->from->noise > 0) return fmax(FFP_GRAY_LIT, NOISES * d->from->noise);
    real *darker = ffp_alloc(d->pixels + 1, sizeof *darker);
    size_t n = 0;
    for (size_t i = 0; i < d->pixels; i++)
        if (d->light[i] < 0) darker[n++] = (real)-d->light[i];
    const double noise =
        (double)n >= NOISE_SHARE * (double)d->pixels ? (double)ffp_median(darker, n) / 0.67 : 0;
    ffp_free(darker);
    return fmax(FFP_GRAY_LIT, NOISES * noise);
}

// The light by which pixels are typical, over those that have as much as `least` and are looked at.
static double typical_light(const FfpGrayDecoder *d, double least) {
    double sum = 0, count = 0;
    for (size_t i = 0; i < d->pixels; i++)
        if (looked_at(d, i) && (double)d->light[i] >= least) sum += (double)d->light[i], count++;
    return sum / fmax(count, 1);
}

bool ffp_gray_find_light(FfpGrayDecoder *d, FfpError *err) {
    const FfpImage *region = d->from->region;
    if (!read_light(&d->light, NULL, &d->width, &d->height, d, d->from->white, err)) return false;
    if (region && (region->width != d->width || region->height != d->height))
        return ffp_fail(err, FFP_ERROR_FILE, d->from->white, "image is %d x %d, but was %d x %d before",
                        d->width, d->height, region->width, region->height);
    d->pixels = (size_t)d->width * (size_t)d->height;
    if (!read_next(&d->black, NULL, d, d->from->black, err)) return false;
    d->checked = ffp_alloc(d->pixels, 1);
    size_t clipped = 0, checked = 0;
    for (size_t i = 0; i < d->pixels; i++) {
        d->checked[i] = (double)d->light[i] >= FFP_GRAY_CLIPPED;
        d->light[i] -= d->black[i];
    }
    double least = least_light(d);
    const double typical = typical_light(d, least);
    if (!(typical > DIM * least)) return tell_dark(d, err);
    least = fmax(least, LIGHT_SHARE * typical);
    for (size_t i = 0; i < d->pixels; i++) {
        const bool full = d->checked[i];
        d->checked[i] = looked_at(d, i) && (double)d->light[i] >= fmax(least, BRIGHT * typical);
        checked += d->checked[i], clipped += d->checked[i] && full;
        if (looked_at(d, i) && (double)d->light[i] >= least)
            d->report->lit++;
        else
            d->light[i] = 0;
    }
    d->report->clipped = (double)clipped / fmax(1, (double)checked);
    return (d->report->lit >= LIT_LEAST && checked >= LIT_LEAST) || tell_dark(d, err);
}

// --- Pairs. ---

typedef struct Pair {
    int axis, bit;
    float *grey[2];       // [h,w] of the pattern and of its inverse
    double colours[2][3]; // means of their channels
} Pair;

typedef struct PairReading {
    const FfpGrayDecoder *d;
    Pair *pair;
    FfpError errors[2];
    bool ok[2];
} PairReading;

static void read_half(void *argument, int64_t k) {
    PairReading *r = argument;
    r->ok[k] = true;
    if (!ffp_gray_has_photograph(r->d, r->pair->axis, r->pair->bit, (int)k)) return;
    r->ok[k] = read_next(&r->pair->grey[k], r->pair->colours[k], r->d,
                         ffp_gray_photograph(r->d, r->pair->axis, r->pair->bit, (int)k), &r->errors[k]);
}

// Makes the pair's missing photograph: both add up to black and white.
static void complete_pair(const FfpGrayDecoder *d, Pair *pair) {
    const int missing = pair->grey[0] ? 1 : 0;
    const float *other = pair->grey[1 - missing];
    float *grey = pair->grey[missing] = ffp_alloc(d->pixels, sizeof *grey);
    for (size_t i = 0; i < d->pixels; i++) grey[i] = d->light[i] + 2 * d->black[i] - other[i];
}

// Both photographs side by side.
static bool read_pair(const FfpGrayDecoder *d, Pair *pair, FfpError *err) {
    PairReading r = {.d = d, .pair = pair};
    ffp_parallel_for(2, 0, read_half, &r);
    const int failed = !r.ok[0] ? 0 : 1;
    if (!r.ok[failed] && err) *err = r.errors[failed];
    if (!r.ok[0] || !r.ok[1] || !ffp_gray_photograph(d, pair->axis, pair->bit, 0)) return false;
    if (!pair->grey[0] || !pair->grey[1]) complete_pair(d, pair);
    return true;
}

static double sum_of(const FfpGrayDecoder *d, const Pair *pair, size_t pixel) {
    return (double)((pair->grey[0][pixel] + pair->grey[1][pixel] - 2 * d->black[pixel]) / d->light[pixel]);
}

static double contrast_of(const FfpGrayDecoder *d, const Pair *pair, size_t pixel) {
    return (double)(fabsf(pair->grey[0][pixel] - pair->grey[1][pixel]) / d->light[pixel]);
}

static int level_of(double value) {
    const double level = value * LEVELS / 4;
    if (!(level < LEVELS - 1)) return LEVELS - 1;
    return level > 0 ? (int)level : 0;
}

// The middle of what a pair adds up to or differs by (`of`), in white, over the pixels where picture k is the
// brighter one; 0 where there are few.
static double middle(const FfpGrayDecoder *d, const Pair *pair, int k,
                     double (*of)(const FfpGrayDecoder *, const Pair *, size_t)) {
    size_t histogram[LEVELS] = {0}, count = 0, below = 0;
    for (size_t i = 0; i < d->pixels; i++) {
        if (!d->checked[i] || pair->grey[k][i] <= pair->grey[1 - k][i]) continue;
        histogram[level_of(of(d, pair, i))]++, count++;
    }
    if (count < LIT_LEAST) return 0;
    int level = 0;
    for (; level < LEVELS - 1 && 2 * (below + histogram[level]) < count; level++) below += histogram[level];
    return (level + 0.5) * 4 / LEVELS;
}

// Where the two are another view's, another code's or another exposure's, both are light in one place or both
// dark; where it is the exposure, all is one way.
static bool check_inverse(const FfpGrayDecoder *d, const Pair *pair, FfpError *err) {
    size_t count = 0, light = 0, dark = 0, right = 0;
    for (size_t i = 0; i < d->pixels; i++) {
        if (!d->checked[i]) continue;
        const double sum = sum_of(d, pair, i),
                     inverse = (double)(pair->grey[1][i] - d->black[i]) / (double)d->light[i];
        count++, right += fabs(sum - 1) < RIGHT;
        light += fmin(inverse, sum - inverse) > BOTH_LIGHT, dark += sum < BOTH_DARK;
    }
    const double least = ALIKE_SHARE * (double)count, wrong = (double)(light + dark);
    const bool one_way = fmin((double)light, (double)dark) < 0.15 * wrong && (double)right < least;
    return wrong <= least || one_way ||
           ffp_fail_by(FFP_RULE_CODES_NO_PAIR,
                       &(FfpFacts){.a = ffp_basename(ffp_gray_photograph(d, pair->axis, pair->bit, 1))},
                       ffp_gray_photograph(d, pair->axis, pair->bit, 0), err);
}

// Where both were exposed as white and black were, a pattern and its inverse add up to white; less and less
// so from bit to bit where stripes blur and values are not linear in light. `before`: of the coarser bit.
// Each pixel is decided by its pair alone, so that a pair may differ from white as a whole: fine stripes that
// are dim are left out, and other light is reported. Only two of a pair that differ cannot be compared.
static bool check_exposure(FfpGrayDecoder *d, const Pair *pair, double *before, FfpError *err) {
    const double here[2] = {middle(d, pair, 0, sum_of), middle(d, pair, 1, sum_of)},
                 contrast[2] = {middle(d, pair, 0, contrast_of), middle(d, pair, 1, contrast_of)},
                 most = fmax(here[0], here[1]), least = fmin(here[0], here[1]),
                 low = PAIR_LOW * fmin(1, *before);
    const int finer = d->bits[pair->axis] - pair->bit;
    const bool apart =
        least > 0 && fmax(contrast[0], contrast[1]) > PAIR_APART * fmin(contrast[0], contrast[1]);
    // Where a projector scales its picture, the two of the finest stripes may differ.
    const bool scaled = apart && finer == 1 && most <= 1;
    if (apart && !scaled && (most > PAIR_APART || least < fmin(1, *before) / PAIR_APART)) {
        const int k = most > PAIR_APART ? here[1] > here[0] : here[1] < here[0];
        return ffp_fail_by(
            FFP_RULE_CODES_EXPOSURE,
            &(FfpFacts){.a = ffp_basename(ffp_gray_photograph(d, pair->axis, pair->bit, 1 - k)),
                        .b = here[k] > 1 ? "brighter" : "darker",
                        .x = here[k]},
            ffp_gray_photograph(d, pair->axis, pair->bit, k), err);
    }
    if (!(most > 0)) return true;
    unsigned *const unlike = &d->report->unlike[pair->axis];
    const bool coarser = pair->bit > 0 && (*unlike >> (pair->bit - 1) & 1U) && fabs(most - 1) > RIGHT;
    if ((most < low || (scaled && least < low)) && finer <= FINE) {
        d->report->dim[pair->axis] = finer;
        d->report->dim_sum = (most + least) / 2;
    } else if (most < low || most > PAIR_HIGH || coarser) {
        *unlike |= 1U << pair->bit;
        if (fabs(most - 1) > fabs(d->report->other_light - 1) || d->report->other_light == 0)
            d->report->other_light = most;
    }
    *before = most;
    return true;
}

// --- Which have changed places. ---

// One exchange of two photographs after which both pairs that it touches are pairs.
typedef struct Exchange {
    const char *first, *second;
} Exchange;

typedef struct Search {
    const FfpGrayDecoder *d;
    const Pair *broken;
    Exchange found[2];
    int count;
} Search;

// True if two photographs are each other's inverse; *edges: neighbouring pixels between which the brighter
// one changes.
static bool are_inverse(const FfpGrayDecoder *d, float *a, float *b, size_t *edges) {
    const Pair pair = {.grey = {a, b}};
    size_t count = 0, right = 0;
    *edges = 0;
    for (size_t i = 0; i < d->pixels; i++) {
        if (!d->checked[i]) continue;
        count++, right += fabs(sum_of(d, &pair, i) - 1) < RIGHT;
        for (int n = 0; n < 2; n++) {
            const size_t back = n ? (size_t)d->width : 1;
            if (i >= back && d->checked[i - back]) *edges += (a[i] > b[i]) != (a[i - back] > b[i - back]);
        }
    }
    return (double)right > PAIR_SHARE * (double)count;
}

// The broken pair with one of its photographs (k) exchanged for one (m) of another pair. Within an axis the
// coarser code must have fewer edges.
static void try_exchange(Search *s, const Pair *other, int k, int m) {
    const FfpGrayDecoder *d = s->d;
    float *here[2] = {s->broken->grey[0], s->broken->grey[1]}, *there[2] = {other->grey[0], other->grey[1]};
    size_t edges[2];
    here[k] = other->grey[m], there[m] = s->broken->grey[k];
    if (!are_inverse(d, here[0], here[1], &edges[0]) || !are_inverse(d, there[0], there[1], &edges[1]))
        return;
    const bool same = other->axis == s->broken->axis, coarser = other->bit < s->broken->bit;
    if (same && edges[0] != edges[1] && (edges[1] < edges[0]) != coarser) return;
    if (s->count < 2)
        s->found[s->count] = (Exchange){ffp_gray_photograph(d, s->broken->axis, s->broken->bit, k),
                                        ffp_gray_photograph(d, other->axis, other->bit, m)};
    s->count++;
}

// The pair k places after another, rows after columns; false: there is none that can be read.
static bool read_pair_beside(const FfpGrayDecoder *d, const Pair *pair, int k, Pair *beside) {
    const int at = (pair->axis ? d->bits[0] : 0) + pair->bit + k, axis = at >= d->bits[0];
    *beside = (Pair){axis, axis ? at - d->bits[0] : at, {NULL, NULL}, {{0}}};
    return at >= 0 && at < d->bits[0] + d->bits[1] && read_pair(d, beside, NULL);
}

static void free_pair(Pair *pair) {
    ffp_free(pair->grey[0]), ffp_free(pair->grey[1]);
}

static bool are_alike(const FfpGrayDecoder *d, const Pair *pair) {
    size_t count = 0, alike = 0;
    for (size_t i = 0; i < d->pixels; i++) {
        const float apart = fabsf(pair->grey[0][i] - pair->grey[1][i]);
        count += d->checked[i], alike += d->checked[i] && (double)apart < RIGHT * (double)d->light[i];
    }
    return (double)alike > PAIR_SHARE * (double)count;
}

// True if from this pair on every photograph shows the pattern before its own: its second one and the first
// of the next pair are the pair, and its first one is as its second, or the inverse of the first before.
static bool is_late(const FfpGrayDecoder *d, const Pair *broken, FfpError *err) {
    Pair before, next;
    size_t edges;
    const bool alike = are_alike(d, broken), has_before = read_pair_beside(d, broken, -1, &before);
    const bool late = read_pair_beside(d, broken, 1, &next) &&
                      are_inverse(d, broken->grey[1], next.grey[0], &edges) &&
                      (alike || (has_before && are_inverse(d, before.grey[0], broken->grey[0], &edges)));
    const char *from = ffp_gray_photograph(d, broken->axis, broken->bit, alike);
    free_pair(&before), free_pair(&next);
    if (late) ffp_fail_by(FFP_RULE_LATE_FROM, &(FfpFacts){.a = ffp_basename(from)}, from, err);
    return late;
}

static void try_pair(Search *s, int axis, int bit) {
    const FfpGrayDecoder *d = s->d;
    Pair other = {.axis = axis, .bit = bit};
    const bool ok = read_pair(d, &other, NULL);
    for (int n = 0; ok && n < 4; n++) try_exchange(s, &other, n / 2, n % 2);
    free_pair(&other);
    ffp_cancel_point();
}

// Where an exchange with another photograph (or either of two) mends a broken pair, that is the error.
static void explain(const FfpGrayDecoder *d, const Pair *broken, FfpError *err) {
    Search s = {.d = d, .broken = broken};
    char swapped[600];
    int used = 0;
    if (is_late(d, broken, err)) return;
    for (int axis = 0; axis < 2; axis++)
        for (int bit = 0; bit < d->bits[axis]; bit++)
            if (axis != broken->axis || bit != broken->bit) try_pair(&s, axis, bit);
    if (s.count < 1 || s.count > 2) return;
    for (int i = 0; i < s.count; i++)
        used +=
            snprintf(swapped + used, sizeof swapped - (size_t)used, "%s%.120s and %.120s",
                     i > 0 ? ", or " : "", ffp_basename(s.found[i].first), ffp_basename(s.found[i].second));
    ffp_fail_by(FFP_RULE_CODES_SWAPPED, &(FfpFacts){.a = swapped},
                ffp_gray_photograph(d, broken->axis, broken->bit, 0), err);
}

static void take_signal(FfpGrayDecoder *d, const Pair *pair) {
    uint8_t *signal = d->signal[pair->axis][pair->bit] = ffp_alloc(d->pixels, 1);
    for (size_t i = 0; i < d->pixels; i++) {
        if (!(d->light[i] > 0)) continue;
        const float share = (pair->grey[0][i] - pair->grey[1][i]) / d->light[i], s = share < 1 ? share : 1;
        signal[i] = (uint8_t)(FFP_GRAY_NONE + lrintf(127 * (s > -1 ? s : -1)));
    }
}

typedef struct PairLooking {
    FfpGrayDecoder *d;
    const Pair *pair;
    double *sum;
    bool ok;
    FfpError error;
} PairLooking;

// The pair's figures, and side by side with them its checks and its signal.
static void look_at_pair(void *argument, int64_t k) {
    PairLooking *l = argument;
    const Pair *pair = l->pair;
    if (k == 1) {
        l->ok = check_inverse(l->d, pair, &l->error) && check_exposure(l->d, pair, l->sum, &l->error);
        if (l->ok) take_signal(l->d, pair);
    } else if (ffp_gray_has_photograph(l->d, pair->axis, pair->bit, 0) &&
               ffp_gray_has_photograph(l->d, pair->axis, pair->bit, 1)) {
        ffp_gray_see_pair(l->d, pair->axis, pair->bit, pair->grey, (const double(*)[3])pair->colours);
    }
}

static bool read_bit(FfpGrayDecoder *d, int axis, int bit, double *sum, FfpError *err) {
    Pair pair = {.axis = axis, .bit = bit};
    bool ok = read_pair(d, &pair, err);
    if (ok) {
        PairLooking look = {.d = d, .pair = &pair, .sum = sum};
        ffp_parallel_for(2, 0, look_at_pair, &look);
        ok = look.ok;
        if (!ok && err) *err = look.error;
        if (!ok) explain(d, &pair, err);
    }
    free_pair(&pair);
    ffp_cancel_point();
    return ok;
}

bool ffp_gray_read_signals(FfpGrayDecoder *d, FfpError *err) {
    for (int axis = 0; axis < 2; axis++) {
        double sum = 1;
        for (int bit = 0; bit < d->bits[axis]; bit++) {
            if (!ffp_gray_photograph(d, axis, bit, 0)) {
                d->missing[axis] = d->bits[axis] - bit;
                break;
            }
            if (!read_bit(d, axis, bit, &sum, err)) return false;
            if (d->report->dim[axis] > 0) {
                d->missing[axis] = d->report->dim[axis];
                break;
            }
        }
        if (d->missing[axis] == d->bits[axis])
            return ffp_fail(err, FFP_ERROR_FILE, d->from->white,
                            "no photograph of the coarsest code of %s, nor of its inverse, is beside it",
                            axis ? "rows" : "columns");
        d->report->fine_sum += sum / 2;
    }
    return true;
}
