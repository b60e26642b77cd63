#include "rig/graycode.h"

#include <math.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include "base/alloc.h"
#include "base/call.h"
#include "patterns/patterns.h"
#include "rig/gray_edges.h"

enum { BITS_MAX = 15, LEVELS = 1024 };

#define LIGHT_LEAST 0.003 // linear, that white adds to black where a code can be read
#define LIGHT_SHARE 0.02  // and of what it adds typically
#define LIT_LEAST 64      // pixels
#define BRIGHT 0.25       // of the typical light: pixels that checks are made on
#define WEAK 15           // of 127: the code's bit is not told from its inverse
#define RESOLVED 0.5      // of the pixels must tell a bit, or it counts as too fine
#define PAIR_LOW 0.7      // what a pattern and its inverse add up to, in white
#define PAIR_HIGH 1.4     // and against white
#define LINES_CHECKED 3   // edges across what is lit, by which one bit may have more than the next
#define EDGES_CHECKED 50  // of a bit, from which its edges say something
#define SPREAD 4          // pixels around that a lens spreads light to,
#define SWAMPED 0.25      // and the share of theirs below which a pixel shows little else
#define ALIKE 2           // neighbours, of eight, that a position must be near to

typedef struct Decoder {
    const FfpGrayPhotographs *from;
    int width, height, bits[2];
    size_t pixels;
    float *black, *light;         // [h,w] grey; light: white - black, 0 where a pixel is not lit
    double typical;               // of the light
    uint8_t *signal[2][BITS_MAX]; // [h,w]
    int *code[2];                 // [h,w] blocks; -1: not decoded
    int dropped[2];
    FfpGrayReport *report;
} Decoder;

int ffp_gray_photographs(int width, int height) {
    return 2 * (ffp_gray_code_bits(width) + ffp_gray_code_bits(height));
}

void ffp_gray_name(int width, int height, int index, char name[32]) {
    const int columns = ffp_gray_code_bits(width), pair = index / 2;
    (void)height;
    snprintf(name, 32, "gray_%c_%02d%s", pair < columns ? 'x' : 'y', pair < columns ? pair : pair - columns,
             index % 2 ? "_inverse" : "");
}

static const char *photograph(const Decoder *d, int axis, int bit, int inverse) {
    return d->from->codes[2 * ((axis ? d->bits[0] : 0) + bit) + inverse];
}

// --- Light. ---

static bool read_grey(float **out, Decoder *d, const char *path, FfpError *err) {
    FfpImage rgb = {0};
    const bool ok = d->from->linear ? ffp_image_read_light(&rgb, NULL, path, err)
                                    : ffp_image_read_over_black(&rgb, NULL, path, err);
    if (!ok) return false;
    if (d->pixels == 0)
        d->width = rgb.width, d->height = rgb.height, d->pixels = (size_t)rgb.width * (size_t)rgb.height;
    if (rgb.width != d->width || rgb.height != d->height) {
        ffp_fail(err, FFP_ERROR_FILE, path, "image is %d x %d, the others have %d x %d", rgb.width,
                 rgb.height, d->width, d->height);
        ffp_image_free(&rgb);
        return false;
    }
    *out = ffp_alloc(d->pixels, sizeof(float));
    for (size_t i = 0; i < d->pixels; i++)
        (*out)[i] = (float)(rgb.data[3 * i] + rgb.data[3 * i + 1] + rgb.data[3 * i + 2]) / 3;
    ffp_image_free(&rgb);
    return true;
}

// What white adds to black.
static bool find_light(Decoder *d, FfpError *err) {
    if (!read_grey(&d->black, d, d->from->black, err) || !read_grey(&d->light, d, d->from->white, err))
        return false;
    double sum = 0, count = 0;
    for (size_t i = 0; i < d->pixels; i++) {
        d->light[i] -= d->black[i];
        if (d->light[i] >= LIGHT_LEAST) sum += (double)d->light[i], count++;
    }
    d->typical = sum / fmax(count, 1);
    const double least = fmax(LIGHT_LEAST, LIGHT_SHARE * d->typical);
    for (size_t i = 0; i < d->pixels; i++) {
        if ((double)d->light[i] >= least)
            d->report->lit++;
        else
            d->light[i] = 0;
    }
    return d->report->lit >= LIT_LEAST || ffp_fail(err, FFP_ERROR_FILE, d->from->white,
                                                   "white is hardly brighter than black: nothing is lit");
}

// --- Signals. ---

// The middle of what a pair adds up to, in white, over the bright pixels where `brighter` is the brighter
// one; 0 where there are few.
static double pair_sum(const Decoder *d, const float *brighter, const float *other) {
    size_t histogram[LEVELS] = {0}, count = 0, below = 0;
    for (size_t i = 0; i < d->pixels; i++) {
        if ((double)d->light[i] < BRIGHT * d->typical || brighter[i] <= other[i]) continue;
        const double sum = (double)((brighter[i] + other[i] - 2 * d->black[i]) / d->light[i]);
        histogram[(int)fmax(0, fmin(sum * LEVELS / 4, LEVELS - 1))]++, count++;
    }
    if (count < LIT_LEAST) return 0;
    int level = 0;
    for (; level < LEVELS - 1 && 2 * (below + histogram[level]) < count; level++) below += histogram[level];
    return (level + 0.5) * 4 / LEVELS;
}

// Where both were exposed as white and black were, a pattern and its inverse add up to white; less and less
// so from bit to bit where stripes blur and values are not linear in light. `before`: of the coarser bit.
static bool check_pair(const Decoder *d, int axis, int bit, const float *const pair[2], double *before,
                       FfpError *err) {
    double sum = 0;
    for (int k = 0; k < 2; k++) {
        const double here = pair_sum(d, pair[k], pair[1 - k]);
        if (here > PAIR_HIGH || (here > 0 && here < PAIR_LOW * *before))
            return ffp_fail(err, FFP_ERROR_FILE, photograph(d, axis, bit, k),
                            "it and its inverse add up to %.2f of white: another exposure, or no pair", here);
        sum = fmax(sum, here);
    }
    if (sum > 0) *before = sum;
    return true;
}

static void take_signal(Decoder *d, int axis, int bit, const float *const pair[2]) {
    uint8_t *signal = d->signal[axis][bit] = ffp_alloc(d->pixels, 1);
    for (size_t i = 0; i < d->pixels; i++) {
        if (!(d->light[i] > 0)) continue;
        const float s = (pair[0][i] - pair[1][i]) / d->light[i];
        signal[i] = (uint8_t)(FFP_GRAY_NONE + lrintf(127 * fmaxf(-1, fminf(s, 1))));
    }
}

static bool read_bit(Decoder *d, int axis, int bit, double *sum, FfpError *err) {
    float *pair[2] = {NULL, NULL};
    const bool ok = read_grey(&pair[0], d, photograph(d, axis, bit, 0), err) &&
                    read_grey(&pair[1], d, photograph(d, axis, bit, 1), err) &&
                    check_pair(d, axis, bit, (const float *const *)pair, sum, err);
    if (ok) take_signal(d, axis, bit, (const float *const *)pair);
    ffp_free(pair[0]), ffp_free(pair[1]);
    ffp_cancel_point();
    return ok;
}

static bool read_signals(Decoder *d, FfpError *err) {
    for (int axis = 0; axis < 2; axis++) {
        double sum = 1;
        for (int bit = 0; bit < d->bits[axis]; bit++)
            if (!read_bit(d, axis, bit, &sum, err)) return false;
        d->report->fine_sum += sum / 2;
    }
    return true;
}

// --- Checks. ---

// The finest bits that most pixels cannot tell.
static void drop_fine_bits(Decoder *d, int axis) {
    int bit = d->bits[axis] - 1;
    for (; bit > 0; bit--) {
        size_t told = 0;
        for (size_t i = 0; i < d->pixels; i++)
            told += d->light[i] > 0 && abs(ffp_gray_signal(d->signal[axis][bit][i])) > WEAK;
        if ((double)told >= RESOLVED * d->report->lit) break;
    }
    d->dropped[axis] = d->report->dropped[axis] = d->bits[axis] - 1 - bit;
}

// Between how many neighbouring bright pixels a bit changes.
static size_t changes(const Decoder *d, const uint8_t *signal) {
    const double least = BRIGHT * d->typical;
    const size_t width = (size_t)d->width;
    size_t count = 0;
    for (size_t i = 0; i + width < d->pixels; i++) {
        if ((double)d->light[i] < least || (i + 1) % width == 0) continue;
        count += (double)d->light[i + 1] >= least &&
                 (signal[i] > FFP_GRAY_NONE) != (signal[i + 1] > FFP_GRAY_NONE);
        count += (double)d->light[i + width] >= least &&
                 (signal[i] > FFP_GRAY_NONE) != (signal[i + width] > FFP_GRAY_NONE);
    }
    return count;
}

// Each bit has twice the edges of the one before, give or take those at the rim of what is lit.
static bool check_order(const Decoder *d, int axis, FfpError *err) {
    const double line = sqrt(d->report->lit); // pixels of an edge
    double before = 0;
    for (int bit = 0; bit < d->bits[axis] - d->dropped[axis]; bit++) {
        const double here = (double)changes(d, d->signal[axis][bit]);
        if (before > 1.5 * here + LINES_CHECKED * line)
            return ffp_fail(
                err, FFP_ERROR_FILE, photograph(d, axis, bit, 0),
                "its stripes are broader than those of '%.200s', which comes before it: codes are "
                "needed coarsest first, columns before rows",
                photograph(d, axis, bit - 1, 0));
        before = here;
    }
    return true;
}

// --- Codes. ---

static int code_of(const Decoder *d, int axis, size_t pixel) {
    const int used = d->bits[axis] - d->dropped[axis], size = axis ? d->from->height : d->from->width;
    bool bits[BITS_MAX];
    int weak = 0;
    for (int bit = 0; bit < used; bit++) {
        const int s = ffp_gray_signal(d->signal[axis][bit][pixel]);
        bits[bit] = s > 0;
        weak += abs(s) <= WEAK;
    }
    // An edge of the code is one of one bit alone; the finest bit's and the others' alternate.
    const int code = ffp_gray_decode(bits, used);
    return weak <= 2 && code << d->dropped[axis] < size ? code : -1;
}

static void find_codes(Decoder *d) {
    for (int axis = 0; axis < 2; axis++) d->code[axis] = ffp_alloc(d->pixels, sizeof(int));
    for (size_t i = 0; i < d->pixels; i++) {
        int codes[2] = {-1, -1};
        for (int axis = 0; axis < 2 && d->light[i] > 0; axis++) codes[axis] = code_of(d, axis, i);
        for (int axis = 0; axis < 2; axis++)
            d->code[axis][i] = codes[0] >= 0 && codes[1] >= 0 ? codes[axis] : -1;
    }
}

// The bit in which alone two codes' bits differ, -1: in none, or in several.
static int single_difference(int a, int b, int bits) {
    const unsigned difference = ((unsigned)a ^ (unsigned)a >> 1) ^ ((unsigned)b ^ (unsigned)b >> 1);
    if (difference == 0 || (difference & (difference - 1)) != 0) return -1;
    int bit = bits - 1;
    for (unsigned rest = difference; !(rest & 1U); rest >>= 1) bit--;
    return bit;
}

// Where one bit alone changes, a number must go on to the next. Where a pattern and its inverse have changed
// places, it jumps at the edges of all coarser bits.
static bool check_pairs(const Decoder *d, int axis, FfpError *err) {
    const int used = d->bits[axis] - d->dropped[axis];
    size_t jumps[BITS_MAX] = {0}, edges[BITS_MAX] = {0};
    const int *code = d->code[axis];
    const size_t width = (size_t)d->width;
    for (size_t i = 0; i + width < d->pixels; i++)
        for (int k = 0; k < 2; k++) {
            const size_t next = k ? i + width : i + 1;
            if (code[i] < 0 || code[next] < 0) continue;
            const int bit = single_difference(code[i], code[next], used);
            if (bit >= 0) edges[bit]++, jumps[bit] += abs(code[i] - code[next]) != 1;
        }
    for (int bit = used - 1; bit >= 0; bit--) {
        if (edges[bit] < EDGES_CHECKED || 2 * jumps[bit] < edges[bit]) continue;
        return ffp_fail(err, FFP_ERROR_FILE, photograph(d, axis, bit + 1 < used ? bit + 1 : bit, 0),
                        "the codes jump at its neighbour's edges: it and its inverse have changed places, or "
                        "photographs are in another order");
    }
    return true;
}

// --- Positions. ---

static int compare_floats(const void *a, const void *b) {
    const float x = *(const float *)a, y = *(const float *)b;
    return (x > y) - (x < y);
}

static double distance(const real *p, const real *q) {
    return fmax(fabs((double)(p[0] - q[0])), fabs((double)(p[1] - q[1])));
}

// Middle distance of the positions of neighbours in a row.
static double median_step(const Decoder *d, const FfpImage *map) {
    float *steps = ffp_alloc(d->pixels, sizeof(float));
    size_t count = 0;
    for (size_t i = 0; i + 1 < d->pixels; i++) {
        const real *p = map->data + 3 * i;
        if (p[2] > 0 && p[5] > 0 && (i + 1) % (size_t)d->width != 0)
            steps[count++] = (float)distance(p, p + 3);
    }
    qsort(steps, count, sizeof *steps, compare_floats);
    const double middle = count > 0 ? (double)steps[count / 2] : 0;
    ffp_free(steps);
    return middle;
}

static int near_neighbours(const Decoder *d, const FfpImage *map, int x, int y, double near) {
    const real *p = map->data + 3 * ((size_t)y * (size_t)d->width + (size_t)x);
    int count = 0;
    for (int n = 0; n < 9; n++) {
        const int i = x + n % 3 - 1, j = y + n / 3 - 1;
        if (n == 4 || i < 0 || j < 0 || i >= d->width || j >= d->height) continue;
        const real *q = map->data + 3 * ((size_t)j * (size_t)d->width + (size_t)i);
        count += q[2] > 0 && distance(p, q) <= near;
    }
    return count;
}

// Takes the trust from positions that no neighbours are near to: bits read wrongly.
static void drop_strays(Decoder *d, FfpImage *map) {
    const double near = 4 * d->report->step + 2 * fmax(1 << d->dropped[0], 1 << d->dropped[1]);
    unsigned char *stray = ffp_alloc(d->pixels, 1);
    for (size_t i = 0; i < d->pixels; i++)
        stray[i] = map->data[3 * i + 2] > 0 && near_neighbours(d, map, (int)(i % (size_t)d->width),
                                                               (int)(i / (size_t)d->width), near) < ALIKE;
    for (size_t i = 0; i < d->pixels; i++) {
        if (stray[i]) memset(map->data + 3 * i, 0, 3 * sizeof(real));
        d->report->decoded += map->data[3 * i + 2] > 0;
    }
    ffp_free(stray);
}

// Takes the light from pixels that are much darker than others near them: what they show is those' light,
// which a lens spreads, and their codes are those' codes.
static void drop_swamped(Decoder *d) {
    const int width = d->width, height = d->height;
    float *row = ffp_alloc(d->pixels, sizeof(float)), *most = ffp_alloc(d->pixels, sizeof(float));
    for (int y = 0; y < height; y++)
        for (int x = 0; x < width; x++)
            for (int i = x > SPREAD ? x - SPREAD : 0; i <= x + SPREAD && i < width; i++)
                row[(size_t)y * (size_t)width + (size_t)x] =
                    fmaxf(row[(size_t)y * (size_t)width + (size_t)x],
                          d->light[(size_t)y * (size_t)width + (size_t)i]);
    for (int y = 0; y < height; y++)
        for (int j = y > SPREAD ? y - SPREAD : 0; j <= y + SPREAD && j < height; j++)
            for (int x = 0; x < width; x++)
                most[(size_t)y * (size_t)width + (size_t)x] = fmaxf(
                    most[(size_t)y * (size_t)width + (size_t)x], row[(size_t)j * (size_t)width + (size_t)x]);
    for (size_t i = 0; i < d->pixels; i++)
        if ((double)d->light[i] < SWAMPED * (double)most[i]) d->light[i] = 0;
    ffp_free(row), ffp_free(most);
}

static void find_positions(Decoder *d, FfpImage *map) {
    float *position = ffp_alloc(d->pixels, sizeof(float));
    *map = ffp_image_new(d->width, d->height, 3);
    drop_swamped(d);
    for (int axis = 0; axis < 2; axis++) {
        const FfpGrayAxis of = {d->width,
                                d->height,
                                d->bits[axis] - d->dropped[axis],
                                1 << d->dropped[axis],
                                (const uint8_t *const *)d->signal[axis],
                                d->code[axis],
                                d->light};
        ffp_gray_positions(position, &of);
        for (size_t i = 0; i < d->pixels; i++)
            if (of.code[i] >= 0 && d->light[i] > 0) map->data[3 * i + (size_t)axis] = (real)position[i];
    }
    for (size_t i = 0; i < d->pixels; i++) map->data[3 * i + 2] = d->code[0][i] >= 0 && d->light[i] > 0;
    ffp_free(position);
    d->report->step = median_step(d, map);
    drop_strays(d, map);
}

static bool decode(Decoder *d, FfpImage *map, FfpError *err) {
    if (d->bits[0] > BITS_MAX || d->bits[1] > BITS_MAX)
        return ffp_fail(err, FFP_ERROR_ARGUMENT, "gray_codes", "a panel of %d x %d pixels is too large",
                        d->from->width, d->from->height);
    if (!find_light(d, err) || !read_signals(d, err)) return false;
    for (int axis = 0; axis < 2; axis++) {
        drop_fine_bits(d, axis);
        if (!check_order(d, axis, err)) return false;
    }
    find_codes(d);
    for (int axis = 0; axis < 2; axis++)
        if (!check_pairs(d, axis, err)) return false;
    find_positions(d, map);
    return true;
}

bool ffp_gray_decode_view(FfpImage *map, FfpGrayReport *report, const FfpGrayPhotographs *photographs,
                          FfpError *err) {
    Decoder *d = ffp_alloc(1, sizeof *d);
    *report = (FfpGrayReport){0};
    *map = (FfpImage){0};
    *d = (Decoder){.from = photographs,
                   .bits = {ffp_gray_code_bits(photographs->width), ffp_gray_code_bits(photographs->height)},
                   .report = report};
    const bool ok = decode(d, map, err);
    for (int axis = 0; axis < 2; axis++) {
        for (int bit = 0; bit < BITS_MAX; bit++) ffp_free(d->signal[axis][bit]);
        ffp_free(d->code[axis]);
    }
    ffp_free(d->black), ffp_free(d->light), ffp_free(d);
    return ok;
}
