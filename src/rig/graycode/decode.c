// From signals to positions.
#include <math.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include "core/base/alloc.h"
#include "core/base/call.h"
#include "core/base/file.h"
#include "core/base/log.h"
#include "core/numerics/rank.h"
#include "core/patterns/patterns.h"
#include "rig/findings/tell.h"
#include "rig/graycode/decoder.h"
#include "rig/graycode/edges.h"
#include "rig/graycode/orders.h"

#define SPREAD 4     // pixels around that a lens spreads light to,
#define SWAMPED 0.25 // and the share of theirs below which a pixel shows little else
#define MIRRORED 0.9 // share of neighbours that lie round the other way
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

static void keep_greater(float *to, const float *from, int n) {
    for (int i = 0; i < n; i++)
        if (from[i] > to[i]) to[i] = from[i];
}

// Takes the light from pixels that are much darker than others near them: what they show is those' light,
// which a lens spreads, and their codes are those' codes.
static void drop_swamped(FfpGrayDecoder *d) {
    const int width = d->width, height = d->height;
    float *row = ffp_alloc(d->pixels, sizeof(float)), *most = ffp_alloc(d->pixels, sizeof(float));
    for (int y = 0; y < height; y++)
        for (int apart = 0; apart <= SPREAD && apart < width; apart++) {
            const size_t first = (size_t)y * (size_t)width, other = first + (size_t)apart;
            keep_greater(row + first, d->light + other, width - apart);
            keep_greater(row + other, d->light + first, width - apart);
        }
    for (int y = 0; y < height; y++)
        for (int j = y > SPREAD ? y - SPREAD : 0; j <= y + SPREAD && j < height; j++)
            keep_greater(most + (size_t)y * (size_t)width, row + (size_t)j * (size_t)width, width);
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

// True if the panel is seen as in a mirror: its rows and columns are exchanged, or a mirror is in the way.
static bool is_mirrored(const FfpGrayDecoder *d, const FfpImage *map) {
    size_t right = 0, mirrored = 0;
    const size_t below = 3 * (size_t)d->width;
    for (size_t i = 0; i + (size_t)d->width + 1 < d->pixels; i++) {
        const real *p = map->data + 3 * i;
        if (!(p[2] > 0 && p[5] > 0 && p[below + 2] > 0)) continue;
        const real area = (p[3] - p[0]) * (p[below + 1] - p[1]) - (p[4] - p[1]) * (p[below] - p[0]);
        right += area > 0, mirrored += area < 0;
    }
    return (double)mirrored > MIRRORED * (double)(right + mirrored);
}

// Both axes are read side by side, and then checked, each against the other.
static void read_axis(void *argument, int64_t axis) {
    ffp_gray_drop_fine_bits(argument, (int)axis);
    find_codes(argument, (int)axis);
}

typedef struct AxisOrder {
    const FfpGrayDecoder *d;
    FfpError errors[2];
    bool ok[2];
} AxisOrder;

static void check_axis(void *argument, int64_t axis) {
    AxisOrder *order = argument;
    order->ok[axis] = ffp_gray_check_order(order->d, (int)axis, &order->errors[axis]);
}

static bool decode(FfpGrayDecoder *d, FfpImage *map, FfpError *err) {
    if (d->bits[0] > FFP_GRAY_BITS_MAX || d->bits[1] > FFP_GRAY_BITS_MAX)
        return ffp_fail(err, FFP_ERROR_ARGUMENT, "gray_codes", "a panel of %d x %d pixels is too large",
                        d->from->width, d->from->height);
    if (!ffp_gray_find_light(d, err) || !ffp_gray_read_signals(d, err)) return false;
    AxisOrder order = {.d = d};
    ffp_parallel_for(2, 0, read_axis, d);
    ffp_parallel_for(2, 0, check_axis, &order);
    for (int axis = 0; axis < 2; axis++) {
        if (order.ok[axis]) continue;
        if (err) *err = order.errors[axis];
        return false;
    }
    drop_half_codes(d);
    find_positions(d, map);
    ffp_gray_see_panel(d, map);
    return true;
}

static FfpGrayDecoder *new_decoder(const FfpGrayPhotographs *photographs, FfpGrayReport *report) {
    FfpGrayDecoder *d = ffp_alloc(1, sizeof *d);
    *report = (FfpGrayReport){.linear = photographs->linear};
    *d = (FfpGrayDecoder){
        .from = photographs,
        .bits = {ffp_gray_code_bits(photographs->width), ffp_gray_code_bits(photographs->height)},
        .report = report};
    return d;
}

static void free_decoder(FfpGrayDecoder *d) {
    for (int axis = 0; axis < 2; axis++) {
        for (int bit = 0; bit < FFP_GRAY_BITS_MAX; bit++) ffp_free(d->signal[axis][bit]);
        ffp_free(d->code[axis]), ffp_free(d->weakest[axis]);
    }
    ffp_free(d->black), ffp_free(d->light), ffp_free(d->checked), ffp_free(d);
}

// As ffp_gray_decode_view, of photographs in their order. *mirrored: is_mirrored.
static bool decode_in_order(FfpImage *map, FfpGrayReport *report, const FfpGrayPhotographs *photographs,
                            bool *mirrored, FfpError *err) {
    FfpGrayDecoder *d = new_decoder(photographs, report);
    *map = (FfpImage){0};
    FfpError why = {0};
    const bool ok = decode(d, map, &why);
    // Codes at the camera's limit cannot be told from their inverses, whatever else seems to be wrong.
    if (!ok && why.code == FFP_ERROR_FILE && report->clipped > ffp_rule(FFP_RULE_CODES_CLIPPED)->limit)
        ffp_fail_by(FFP_RULE_CODES_CLIPPED,
                    &(FfpFacts){.a = ffp_basename(photographs->white), .figure = report->clipped},
                    photographs->white, &why);
    if (!ok && err) *err = why;
    *mirrored = ok && is_mirrored(d, map);
    free_decoder(d);
    return ok;
}

// True if the photographs explain themselves better in another order, which `codes` then holds.
static bool find_other_order(FfpGrayPhotographs *other, const FfpGrayPhotographs *from, const char **codes,
                             FfpGrayOrder *order) {
    const int count = ffp_gray_photographs(from->width, from->height);
    const char **files = ffp_alloc((size_t)count + 2, sizeof *files);
    int n = 0;
    *other = *from;
    files[n++] = from->black, files[n++] = from->white;
    for (int i = 0; i < count; i++)
        if (from->codes[i]) files[n++] = from->codes[i];
    const bool differs = ffp_gray_find_order(other, order, files, n, codes) && other->black && other->white &&
                         memcmp(codes, from->codes, (size_t)count * sizeof *codes) != 0;
    ffp_free(files);
    return differs;
}

// The same in another order, if the photographs explain themselves so; otherwise nothing changes. Two that
// are swapped could be left out as well: that is for the error to say.
static bool decode_otherwise(FfpImage *map, FfpGrayReport *report, const FfpGrayPhotographs *from,
                             bool swapped) {
    const char **codes =
        ffp_alloc((size_t)ffp_gray_photographs(from->width, from->height) + 1, sizeof *codes);
    FfpGrayPhotographs other;
    FfpGrayOrder order;
    FfpGrayReport seen;
    FfpImage second = {0};
    FfpError none = {0};
    bool mirrored;
    const bool ok = find_other_order(&other, from, codes, &order) && !(swapped && order.extra[0]) &&
                    decode_in_order(&second, &seen, &other, &mirrored, &none);
    if (ok) {
        ffp_gray_tell_order(&order);
        ffp_image_free(map);
        *map = second, *report = seen;
        from->cache->other = codes;
    } else {
        ffp_image_free(&second);
        ffp_free(codes);
    }
    return ok;
}

bool ffp_gray_decode_view(FfpImage *map, FfpGrayReport *report, const FfpGrayPhotographs *photographs,
                          FfpError *err) {
    FfpGrayPhotographs whole = *photographs;
    FfpGrayCache own = {.n = 0};
    bool mirrored = false;
    *map = (FfpImage){0};
    *report = (FfpGrayReport){0};
    if (!whole.cache) whole.cache = &own;
    bool ok = ffp_gray_make_plain(&whole, err);
    if (ok) {
        FfpError why = {0};
        ok = decode_in_order(map, report, &whole, &mirrored, &why);
        const bool swapped =
            !ok && why.finding && strcmp(why.finding, ffp_rule(FFP_RULE_CODES_SWAPPED)->code) == 0;
        if ((!ok || mirrored) && photographs->cache && decode_otherwise(map, report, &whole, swapped))
            ok = true;
        else if (!ok && err)
            *err = why;
    }
    ffp_gray_cache_free(&own);
    return ok;
}

void ffp_gray_tell_light(const FfpGrayReport *report, const char *view) {
    const bool dim = report->dim[0] > 0 || report->dim[1] > 0;
    if (dim)
        ffp_tell(
            FFP_RULE_CODES_DIM,
            &(FfpFacts){.view = view, .figure = report->dim_sum, .x = report->dim[0], .y = report->dim[1]});
    if (report->other_light > 0)
        ffp_tell(FFP_RULE_CODES_LIGHT, &(FfpFacts){.view = view, .figure = report->other_light});
    if (report->fine_sum < ffp_rule(FFP_RULE_CODES_LINEAR)->limit && !dim && !report->linear)
        ffp_tell(FFP_RULE_CODES_LINEAR, &(FfpFacts){.view = view, .figure = report->fine_sum});
    else
        ffp_gray_tell_figures(&report->figures, view);
}

void ffp_gray_note_clipped(const FfpGrayReport *report, const char *view) {
    if (report->clipped > ffp_rule(FFP_RULE_CODES_CLIPPED)->limit)
        ffp_note("%s: under white %.0f %% of the light pixels are overexposed: shorten the exposure", view,
                 100 * report->clipped);
}

// The name of a file's folder.
static void folder_of(const char *file, char name[FFP_PATH_MAX]) {
    snprintf(name, FFP_PATH_MAX, "%s", file);
    char *slash = strrchr(name, '/');
    if (slash) *slash = 0;
    memmove(name, ffp_basename(name), strlen(ffp_basename(name)) + 1);
}

bool ffp_gray_fail_few(const FfpGrayPhotographs *photographs, int n, FfpError *err) {
    const int count = ffp_gray_photographs(photographs->width, photographs->height);
    const char **codes = ffp_alloc((size_t)count, sizeof *codes);
    FfpGrayPhotographs few = *photographs;
    FfpGrayReport report;
    char panel[32], folder[FFP_PATH_MAX];
    few.codes = codes;
    for (int i = 0; i < n; i++) codes[i] = photographs->codes[i];
    FfpGrayDecoder *d = new_decoder(&few, &report);
    snprintf(panel, sizeof panel, "%d x %d", few.width, few.height);
    // Codes of rows may be missing.
    if (ffp_gray_find_light(d, err) && (ffp_gray_read_signals(d, err) || d->missing[1] == d->bits[1])) {
        if (err) *err = (FfpError){0};
        folder_of(few.white, folder);
        ffp_gray_tell_figures(&report.figures, folder);
        ffp_fail_by(FFP_RULE_COUNT, &(FfpFacts){.x = n + 2, .y = count + 2, .a = panel}, NULL, err);
    }
    free_decoder(d);
    ffp_free(codes);
    return false;
}
