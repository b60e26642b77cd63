// Splats as the page reads them: centres as they are, everything else in 16 bits between its own limits.
#include <math.h>
#include <string.h>
#include "engine/render/formula.h"
#include "product/view/view.h"

#define SCALE_MIN 1e-30F // below it a logarithm would spoil the steps of all others

static bool is_drawn(const FfpGaussians *g, int64_t i) {
    return g->opacity[i] >= FFP_ALPHA_MIN;
}

int ffp_page_columns(const FfpGaussians *gaussians) {
    return gaussians->scatters ? FFP_PAGE_COLUMNS : FFP_PAGE_COLUMNS - 3;
}

// The numbers of splat i in the order of the columns.
static void values_of(const FfpGaussians *g, int64_t i, float out[FFP_PAGE_COLUMNS]) {
    const float *q = g->rotation + 4 * i;
    const float length = sqrtf(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
    for (int k = 0; k < 3; k++) out[k] = logf(fmaxf(g->scale[3 * i + k], SCALE_MIN));
    for (int k = 0; k < 4; k++) out[3 + k] = length > 0 ? q[k] / length : k == 0;
    out[7] = fminf(g->opacity[i], 1);
    memcpy(out + 8, g->albedo + 3 * i, 3 * sizeof *out);
    out[11] = g->roughness[i];
    memcpy(out + 12, g->ambient + 3 * i, 3 * sizeof *out);
    for (int k = 0; k < 3; k++) out[15 + k] = g->scatters ? g->scattered[3 * i + k] : 0;
}

static int64_t find_limits(const FfpGaussians *g, float low[FFP_PAGE_COLUMNS], float high[FFP_PAGE_COLUMNS]) {
    int64_t count = 0;
    for (int k = 0; k < FFP_PAGE_COLUMNS; k++) {
        low[k] = INFINITY;
        high[k] = -INFINITY;
    }
    for (int64_t i = 0; i < g->count; i++) {
        float value[FFP_PAGE_COLUMNS];
        if (!is_drawn(g, i)) continue;
        values_of(g, i, value);
        count++;
        for (int k = 0; k < FFP_PAGE_COLUMNS; k++) {
            low[k] = fminf(low[k], value[k]);
            high[k] = fmaxf(high[k], value[k]);
        }
    }
    for (int k = 0; count == 0 && k < FFP_PAGE_COLUMNS; k++) low[k] = high[k] = 0;
    return count;
}

// Little-endian whatever the machine.
static void put16(unsigned char *at, unsigned value) {
    at[0] = (unsigned char)(value & 255), at[1] = (unsigned char)(value >> 8);
}

static void put_float(unsigned char *at, float value) {
    uint32_t bits;
    memcpy(&bits, &value, sizeof bits);
    put16(at, bits & 0xFFFF);
    put16(at + 2, bits >> 16);
}

int64_t ffp_pack_splats(FfpByteBuffer *packed, const FfpGaussians *g, float low[FFP_PAGE_COLUMNS],
                        float high[FFP_PAGE_COLUMNS]) {
    const int64_t count = find_limits(g, low, high);
    const int used = ffp_page_columns(g);
    const size_t begin = packed->size, n = (size_t)count; // at most FFP_GAUSSIANS_MAX: the product fits
    ffp_bytes_append(packed, NULL, n * (12 + 2 * (size_t)used));
    unsigned char *centres = packed->bytes + begin, *columns = centres + 12 * n;
    size_t at = 0;
    for (int64_t i = 0; i < g->count; i++) {
        float value[FFP_PAGE_COLUMNS];
        if (!is_drawn(g, i)) continue;
        values_of(g, i, value);
        for (int k = 0; k < 3; k++) put_float(centres + 12 * at + 4 * k, g->centre[3 * i + k]);
        for (int k = 0; k < used; k++) {
            const float range = high[k] - low[k], share = range > 0 ? (value[k] - low[k]) / range : 0;
            put16(columns + 2 * (n * (size_t)k + at), (unsigned)(share * 65535 + 0.5F));
        }
        at++;
    }
    return count;
}
