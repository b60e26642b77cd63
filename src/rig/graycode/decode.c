// From signals to positions.
#include <math.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>
#include "core/base/alloc.h"
#include "core/base/file.h"
#include "core/numerics/rank.h"
#include "core/patterns/patterns.h"
#include "rig/findings/tell.h"
#include "rig/graycode/decoder.h"
#include "rig/graycode/edges.h"

#define SPREAD 4     // pixels around that a lens spreads light to,
#define SWAMPED 0.25 // and the share of theirs below which a pixel shows little else
#define ALIKE 2      // neighbours, of eight, that a position must be near to

// --- Codes. ---

static int code_of(const FfpGrayDecoder *d, int axis, size_t pixel) {
    const int used = d->bits[axis] - d->dropped[axis];
    bool bits[FFP_GRAY_BITS_MAX];
    int weak = 0;
    for (int bit = 0; bit < used; bit++) {
        const int s = ffp_gray_signal(d->signal[axis][bit][pixel]);
        bits[bit] = s > 0;
        weak += abs(s) <= FFP_GRAY_WEAK;
    }
    // An edge of the code is one of one bit alone; the finest bit's and the others' alternate.
    return weak <= 2 ? ffp_gray_decode(bits, used) : -1;
}

static void find_codes(FfpGrayDecoder *d, int axis) {
    d->code[axis] = ffp_alloc(d->pixels, sizeof(int));
    for (size_t i = 0; i < d->pixels; i++) d->code[axis][i] = d->light[i] > 0 ? code_of(d, axis, i) : -1;
}

// Those that both axes have, on the panel.
static void drop_half_codes(FfpGrayDecoder *d) {
    const int size[2] = {d->from->width, d->from->height};
    for (size_t i = 0; i < d->pixels; i++) {
        bool known = true;
        for (int axis = 0; axis < 2; axis++) {
            const int code = d->code[axis][i];
            known = known && code >= 0 && code << d->dropped[axis] < size[axis];
        }
        if (!known) d->code[0][i] = d->code[1][i] = -1;
    }
}

// --- Positions. ---

static double distance(const real *p, const real *q) {
    return fmax(fabs((double)(p[0] - q[0])), fabs((double)(p[1] - q[1])));
}

// Middle distance of the positions of neighbours in a row.
static double median_step(const FfpGrayDecoder *d, const FfpImage *map) {
    float *steps = ffp_alloc(d->pixels, sizeof(float));
    size_t count = 0;
    for (size_t i = 0; i + 1 < d->pixels; i++) {
        const real *p = map->data + 3 * i;
        if (p[2] > 0 && p[5] > 0 && (i + 1) % (size_t)d->width != 0)
            steps[count++] = (float)distance(p, p + 3);
    }
    const double middle = (double)ffp_median(steps, count);
    ffp_free(steps);
    return middle;
}

static int near_neighbours(const FfpGrayDecoder *d, const FfpImage *map, int x, int y, double near) {
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
static void drop_strays(FfpGrayDecoder *d, FfpImage *map) {
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
static void drop_swamped(FfpGrayDecoder *d) {
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

static void find_positions(FfpGrayDecoder *d, FfpImage *map) {
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

static bool decode(FfpGrayDecoder *d, FfpImage *map, FfpError *err) {
    if (d->bits[0] > FFP_GRAY_BITS_MAX || d->bits[1] > FFP_GRAY_BITS_MAX)
        return ffp_fail(err, FFP_ERROR_ARGUMENT, "gray_codes", "a panel of %d x %d pixels is too large",
                        d->from->width, d->from->height);
    if (!ffp_gray_find_light(d, err) || !ffp_gray_read_signals(d, err)) return false;
    for (int axis = 0; axis < 2; axis++) {
        ffp_gray_drop_fine_bits(d, axis);
        find_codes(d, axis);
    }
    for (int axis = 0; axis < 2; axis++)
        if (!ffp_gray_check_order(d, axis, err)) return false;
    drop_half_codes(d);
    find_positions(d, map);
    return true;
}

bool ffp_gray_decode_view(FfpImage *map, FfpGrayReport *report, const FfpGrayPhotographs *photographs,
                          FfpError *err) {
    FfpGrayDecoder *d = ffp_alloc(1, sizeof *d);
    *report = (FfpGrayReport){0};
    *map = (FfpImage){0};
    *d = (FfpGrayDecoder){
        .from = photographs,
        .bits = {ffp_gray_code_bits(photographs->width), ffp_gray_code_bits(photographs->height)},
        .report = report};
    FfpError why = {0};
    const bool ok = decode(d, map, &why);
    // Codes at the camera's limit cannot be told from their inverses, whatever else seems to be wrong.
    if (!ok && why.code == FFP_ERROR_FILE && report->clipped > ffp_rule(FFP_RULE_CODES_CLIPPED)->limit)
        ffp_fail_by(FFP_RULE_CODES_CLIPPED,
                    &(FfpFacts){.a = ffp_basename(photographs->white), .figure = report->clipped},
                    photographs->white, &why);
    if (!ok && err) *err = why;
    for (int axis = 0; axis < 2; axis++) {
        for (int bit = 0; bit < FFP_GRAY_BITS_MAX; bit++) ffp_free(d->signal[axis][bit]);
        ffp_free(d->code[axis]);
    }
    ffp_free(d->black), ffp_free(d->light), ffp_free(d->checked), ffp_free(d);
    return ok;
}
