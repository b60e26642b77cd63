#include "engine/match/fill.h"
#include <stdlib.h>
#include <tgmath.h>
#include "core/base/arena.h"

#define ITERATIONS 80
#define OVER 1.85F // over-relaxation; holes are some tens of pixels wide

typedef struct Sheet { // a function on the picture, known in places
    int width, height;
    real *value;
    unsigned char *known;
} Sheet;

// Mean of the known values among the four neighbours; false when there is none.
static bool neighbours_mean(const Sheet *sheet, size_t i, real *mean) {
    const size_t width = (size_t)sheet->width, x = i % width, y = i / width;
    const size_t around[4] = {i - 1, i + 1, i - width, i + width};
    const bool there[4] = {x > 0, x + 1 < width, y > 0, y + 1 < (size_t)sheet->height};
    int count = 0;
    real sum = 0;
    for (int n = 0; n < 4; n++)
        if (there[n] && sheet->known[around[n]]) {
            sum += sheet->value[around[n]];
            count++;
        }
    *mean = count > 0 ? sum / (real)count : 0;
    return count > 0;
}

// Grows the known region within the mask by a ring at a time; lists the pixels that it gained, in the order
// of their rings.
static size_t grow(Sheet *sheet, const real *mask, size_t *gained) {
    size_t total = 0, start;
    do {
        start = total;
        for (size_t i = 0; i < (size_t)sheet->width * (size_t)sheet->height; i++) {
            real mean;
            if (sheet->known[i] || (mask && mask[i] <= 0) || !neighbours_mean(sheet, i, &mean)) continue;
            sheet->value[i] = mean;
            gained[total++] = i;
        }
        for (size_t k = start; k < total; k++) sheet->known[gained[k]] = 1;
    } while (total > start);
    return total;
}

void ffp_fill_smoothly(real *depth, const real *mask, const real *range, int width, int height) {
    const size_t pixels = (size_t)width * (size_t)height;
    Sheet sheet = {width, height, ffp_alloc(pixels, sizeof(real)), ffp_alloc(pixels, 1)};
    size_t *gained = ffp_alloc(pixels, sizeof *gained);
    for (size_t i = 0; i < pixels; i++) {
        sheet.known[i] = depth[i] > 0;
        sheet.value[i] = depth[i] - (range ? range[2 * i] : 0);
    }
    const size_t total = grow(&sheet, mask, gained);
    for (int round = 0; round < ITERATIONS; round++) {
        for (size_t k = 0; k < total; k++) {
            real mean;
            if (neighbours_mean(&sheet, gained[k], &mean))
                sheet.value[gained[k]] += OVER * (mean - sheet.value[gained[k]]);
        }
    }
    for (size_t k = 0; k < total; k++) {
        const size_t i = gained[k];
        depth[i] = sheet.value[i];
        if (range) depth[i] = fmin(fmax(depth[i], 0) + range[2 * i], range[2 * i + 1]);
    }
    ffp_free(gained);
    ffp_free(sheet.value);
    ffp_free(sheet.known);
}
