#include <stdlib.h>
#include <string.h>
#include <tgmath.h>
#include "core/base/arena.h"
#include "rig/graycode/graycode.h"
#include "rig/masks/limits.h"
#include "rig/masks/steps.h"

#define BINS 256

static const real luminance[3] = {0.2126F, 0.7152F, 0.0722F};

static FfpImage added_light(const FfpImage *black, const FfpImage *white) {
    FfpImage out = ffp_image_new(black->width, black->height, 1);
    const ptrdiff_t pixels = (ptrdiff_t)out.width * out.height;
    for (ptrdiff_t i = 0; i < pixels; i++) {
        real sum = 0;
        for (int c = 0; c < 3; c++) sum += luminance[c] * (white->data[3 * i + c] - black->data[3 * i + c]);
        out.data[i] = ffp_srgb_encode(sum);
    }
    return out;
}

// (1 2 1) / 4 along both axes, edges repeated.
static FfpImage smooth(const FfpImage *image) {
    FfpImage out = ffp_image_new(image->width, image->height, 1);
    for (int y = 0; y < image->height; y++) {
        for (int x = 0; x < image->width; x++) {
            real sum = 0;
            for (int k = 0; k < 9; k++) {
                const int dx = k % 3 - 1, dy = k / 3 - 1;
                const int px = x + dx < 0 || x + dx >= image->width ? x : x + dx;
                const int py = y + dy < 0 || y + dy >= image->height ? y : y + dy;
                sum += (real)((2 - abs(dx)) * (2 - abs(dy))) * image->data[(ptrdiff_t)py * image->width + px];
            }
            out.data[(ptrdiff_t)y * image->width + x] = sum / 16;
        }
    }
    return out;
}

// Weight and moment of the bins before each, for sums over any range.
typedef struct Sums {
    double weight[BINS + 1], moment[BINS + 1];
} Sums;

// w m^2 of bins [from, to): the between-class variance is the sum of this over classes, less a constant.
static double class_term(const Sums *sums, int from, int to) {
    const double w = sums->weight[to] - sums->weight[from], m = sums->moment[to] - sums->moment[from];
    return w > 0 ? m * m / w : 0;
}

// The first bin that is not background, of three classes: nothing, dim, bright. With two, the dim side of a
// curved object falls to the background. 0 when all values share a bin.
static int otsu(const FfpImage *image) {
    Sums sums = {{0}, {0}};
    const ptrdiff_t pixels = (ptrdiff_t)image->width * image->height;
    for (ptrdiff_t i = 0; i < pixels; i++) sums.weight[(int)(image->data[i] * (BINS - 1) + 0.5F) + 1]++;
    for (int b = 0; b < BINS; b++) {
        sums.moment[b + 1] = sums.moment[b] + b * sums.weight[b + 1];
        sums.weight[b + 1] += sums.weight[b];
    }
    double most = class_term(&sums, 0, BINS) * (1 + 1e-9);
    int best = 0;
    for (int low = 1; low < BINS; low++) {
        for (int high = low; high < BINS; high++) {
            const double sum =
                class_term(&sums, 0, low) + class_term(&sums, low, high) + class_term(&sums, high, BINS);
            if (sum > most) most = sum, best = low;
        }
    }
    return best;
}

// Marks the 4-connected region of equal values around `start` with `label`; returns its size.
static ptrdiff_t flood(const FfpImage *mask, int *labels, ptrdiff_t *stack, ptrdiff_t start, int label) {
    ptrdiff_t count = 0, depth = 0;
    stack[depth++] = start, labels[start] = label;
    while (depth > 0) {
        const ptrdiff_t at = stack[--depth];
        const int x = (int)(at % mask->width), y = (int)(at / mask->width);
        const ptrdiff_t near[4] = {x > 0 ? at - 1 : -1, x + 1 < mask->width ? at + 1 : -1,
                                   y > 0 ? at - mask->width : -1,
                                   y + 1 < mask->height ? at + mask->width : -1};
        count++;
        for (int k = 0; k < 4; k++) {
            if (near[k] < 0 || labels[near[k]] != 0 || mask->data[near[k]] != mask->data[at]) continue;
            labels[near[k]] = label;
            stack[depth++] = near[k];
        }
    }
    return count;
}

// Labels all regions of one value from 1 on; sizes[label]. Returns the number of labels.
static int label_regions(const FfpImage *mask, real value, int *labels, ptrdiff_t *stack, ptrdiff_t *sizes) {
    const ptrdiff_t pixels = (ptrdiff_t)mask->width * mask->height;
    int n = 0;
    memset(labels, 0, (size_t)pixels * sizeof *labels);
    for (ptrdiff_t i = 0; i < pixels; i++) {
        if (mask->data[i] != value || labels[i] != 0) continue;
        n++;
        sizes[n] = flood(mask, labels, stack, i, n);
    }
    return n;
}

static bool on_border(const FfpImage *mask, ptrdiff_t i) {
    const int x = (int)(i % mask->width), y = (int)(i / mask->width);
    return x == 0 || y == 0 || x + 1 == mask->width || y + 1 == mask->height;
}

// Background that does not reach the border becomes object, marked in *holes; small pieces of object become
// background.
static void tidy(FfpImage *mask, FfpImage *holes) {
    const ptrdiff_t pixels = (ptrdiff_t)mask->width * mask->height;
    int *labels = ffp_alloc((size_t)pixels, sizeof *labels);
    ptrdiff_t *stack = ffp_alloc((size_t)pixels, sizeof *stack);
    ptrdiff_t *sizes = ffp_alloc((size_t)pixels + 1, sizeof *sizes);
    bool *open = ffp_alloc((size_t)pixels + 1, sizeof *open);
    label_regions(mask, 0, labels, stack, sizes);
    for (ptrdiff_t i = 0; i < pixels; i++) open[labels[i]] = open[labels[i]] || on_border(mask, i);
    for (ptrdiff_t i = 0; i < pixels; i++) {
        if (labels[i] > 0 && !open[labels[i]]) mask->data[i] = holes->data[i] = 1;
    }
    const int n = label_regions(mask, 1, labels, stack, sizes);
    ptrdiff_t largest = 0;
    for (int k = 1; k <= n; k++) largest = sizes[k] > largest ? sizes[k] : largest;
    for (ptrdiff_t i = 0; i < pixels; i++) {
        if (labels[i] > 0 && sizes[labels[i]] * MASK_PIECE_LEAST < largest)
            mask->data[i] = holes->data[i] = 0;
    }
    ffp_free(labels);
    ffp_free(stack);
    ffp_free(sizes);
    ffp_free(open);
}

void ffp_mask_fill_holes(FfpImage *mask) {
    FfpImage holes = ffp_image_new(mask->width, mask->height, 1);
    tidy(mask, &holes);
    ffp_image_free(&holes);
}

// Turns pieces that are smaller than `least` pixels, or than the largest's `share`, into background.
static void drop(FfpImage *mask, ptrdiff_t least, double share) {
    const ptrdiff_t pixels = (ptrdiff_t)mask->width * mask->height;
    int *labels = ffp_alloc((size_t)pixels, sizeof *labels);
    ptrdiff_t *stack = ffp_alloc((size_t)pixels, sizeof *stack);
    ptrdiff_t *sizes = ffp_alloc((size_t)pixels + 1, sizeof *sizes), largest = 0;
    const int n = label_regions(mask, 1, labels, stack, sizes);
    for (int k = 1; k <= n; k++) largest = sizes[k] > largest ? sizes[k] : largest;
    for (ptrdiff_t i = 0; i < pixels; i++) {
        const ptrdiff_t size = labels[i] > 0 ? sizes[labels[i]] : pixels;
        if (size < least || (double)size < share * (double)largest) mask->data[i] = 0;
    }
    ffp_free(labels), ffp_free(stack), ffp_free(sizes);
}

void ffp_mask_drop_pieces(FfpImage *mask) {
    drop(mask, 0, 1.0 / MASK_PIECE_LEAST);
}

void ffp_mask_drop_specks(FfpImage *mask, int64_t least) {
    drop(mask, (ptrdiff_t)least, 0);
}

int64_t ffp_mask_fill_specks(FfpImage *mask) {
    const ptrdiff_t pixels = (ptrdiff_t)mask->width * mask->height;
    int *labels = ffp_alloc((size_t)pixels, sizeof *labels);
    ptrdiff_t *stack = ffp_alloc((size_t)pixels, sizeof *stack);
    ptrdiff_t *sizes = ffp_alloc((size_t)pixels + 1, sizeof *sizes), largest = 0;
    int64_t filled = 0;
    const int n = label_regions(mask, 1, labels, stack, sizes);
    for (int k = 1; k <= n; k++) largest = sizes[k] > largest ? sizes[k] : largest;
    label_regions(mask, 0, labels, stack, sizes);
    for (ptrdiff_t i = 0; i < pixels; i++)
        if (labels[i] > 0 && on_border(mask, i)) sizes[labels[i]] = pixels;
    for (ptrdiff_t i = 0; i < pixels; i++) {
        if (labels[i] == 0 || sizes[labels[i]] * MASK_SPECK_LEAST >= largest) continue;
        mask->data[i] = 1;
        filled++;
    }
    ffp_free(labels), ffp_free(stack), ffp_free(sizes);
    return filled;
}

bool ffp_mask_otsu(FfpImage *mask, FfpImage *holes, const FfpImage *black, const FfpImage *white,
                   const char *where, FfpError *err) {
    FfpImage added = added_light(black, white), even = smooth(&added);
    const int first = otsu(&even);
    ffp_image_free(&added);
    if (first == 0) {
        const double dark = ffp_image_mean(black);
        ffp_image_free(&even);
        return ffp_gray_fail_dark(dark, ffp_image_mean(white) - dark, where, err);
    }
    const ptrdiff_t pixels = (ptrdiff_t)even.width * even.height;
    for (ptrdiff_t i = 0; i < pixels; i++) even.data[i] = (int)(even.data[i] * (BINS - 1) + 0.5F) >= first;
    *holes = ffp_image_new(even.width, even.height, 1);
    tidy(&even, holes);
    *mask = even;
    return true;
}
