// A splat's inputs from the pictures drawn with all splats: errors at its own pixel, around it and in the
// other views that see it. One text for the CPU and the GPU.
#ifndef FFP_NETWORK_LOOK_FORMULA_H
#define FFP_NETWORK_LOOK_FORMULA_H

#include <stdint.h>
#include <tgmath.h>
#include "core/base/real.h"
#include "core/capture/capture.h"
#include "engine/network/splat_formula.h"

enum {
    FFP_LOOK_COLOURS = 9,  // under black, white and the active pattern
    FFP_LOOK_ERRORS = 10,  // photographed less drawn: these, sRGB-encoded, and the coverage
    FFP_LOOK_DEPTH = 10,   // in a pixel's numbers: camera z as drawn, 0 where there is no surface;
    FFP_LOOK_WHITE = 11,   // the photograph's brightness under white,
    FFP_LOOK_ACTIVE = 12,  // and under the active pattern
    FFP_LOOK_NUMBERS = 13, // of a pixel
    FFP_LOOK_SLOPES = 8,
    FFP_LOOK_NEIGHBOURS = 24, // eight pixels around: errors of brightness under white and active, of coverage
    // Of a splat, in this order: errors of its pixel, their means over 3 x 3 and 7 x 7 pixels; neighbours;
    // how far its centre lies behind what is drawn, and whether anything is; slopes of the photographs (white
    // x, y, active x, y) and these times the error; errors in other views, share of the views that see it,
    // how far it lies behind what they draw; and its raw numbers, FFP_PLAIN_NUMBERS or FFP_RESIDUAL_NUMBERS.
    FFP_LOOK_SEEN = 3 * FFP_LOOK_ERRORS + FFP_LOOK_NEIGHBOURS + 2 + FFP_LOOK_SLOPES + FFP_LOOK_ERRORS + 2
};
#define FFP_LOOK_REACH 4.0F   // footprints: differences of depth beyond count as this
#define FFP_LOOK_HIDDEN 3.0F  // footprints behind what a view draws: that view does not see it
#define FFP_LOOK_SURFACE 0.5F // least opacity of what counts as drawn
#define FFP_LOOK_GAIN 16.0F   // errors of a few hundredths to the size of the other inputs
#define FFP_LOOK_SLOPE_GAIN 4.0F

typedef struct FfpLookMaps { // of all views
    int views, width, height;
    const FfpCamera *camera; // [views]
    const int32_t *frame;    // [views,2] columns and rows that the camera saw
    const real *numbers;     // [views,height,width,FFP_LOOK_NUMBERS]
} FfpLookMaps;

typedef struct FfpLookPictures { // of one view, as drawn
    const real *colour[3];       // [height,width,3] black, white, active; sRGB-encoded
    const real *opacity, *depth; // [height,width] sums over the splats (FfpGbuffer)
} FfpLookPictures;

FFP_FORMULA real ffp_look_brightness(const real rgb[3]) {
    return (rgb[0] + rgb[1] + rgb[2]) / 3;
}

// numbers [FFP_LOOK_NUMBERS] of one pixel; photograph [FFP_LOOK_COLOURS].
FFP_FORMULA void ffp_look_pixel(real *numbers, const FfpLookPictures *drawn, size_t pixel,
                                const real *photograph, real coverage) {
    for (int k = 0; k < FFP_LOOK_COLOURS; k++)
        numbers[k] = FFP_LOOK_GAIN * (photograph[k] - drawn->colour[k / 3][3 * pixel + k % 3]);
    const real opacity = drawn->opacity[pixel];
    numbers[FFP_LOOK_COLOURS] = FFP_LOOK_GAIN * (coverage - opacity);
    numbers[FFP_LOOK_DEPTH] = opacity >= FFP_LOOK_SURFACE ? drawn->depth[pixel] / opacity : 0;
    numbers[FFP_LOOK_WHITE] = ffp_look_brightness(photograph + 3);
    numbers[FFP_LOOK_ACTIVE] = ffp_look_brightness(photograph + 6);
}

// Of the pixel of a view, held inside what its camera saw.
FFP_FORMULA const real *ffp_look_at(const FfpLookMaps *m, int view, int x, int y) {
    const int right = m->frame[2 * view] - 1, bottom = m->frame[2 * view + 1] - 1;
    x = x < 0 ? 0 : x > right ? right : x;
    y = y < 0 ? 0 : y > bottom ? bottom : y;
    return m->numbers + (((size_t)view * m->height + y) * m->width + x) * FFP_LOOK_NUMBERS;
}

FFP_FORMULA void ffp_look_mean(real *out, const FfpLookMaps *m, int view, int x, int y, int reach) {
    for (int k = 0; k < FFP_LOOK_ERRORS; k++) out[k] = 0;
    for (int v = y - reach; v <= y + reach; v++)
        for (int u = x - reach; u <= x + reach; u++) {
            const real *at = ffp_look_at(m, view, u, v);
            for (int k = 0; k < FFP_LOOK_ERRORS; k++) out[k] += at[k];
        }
    const int side = 2 * reach + 1;
    for (int k = 0; k < FFP_LOOK_ERRORS; k++) out[k] /= side * side;
}

FFP_FORMULA void ffp_look_neighbours(real *out, const FfpLookMaps *m, int view, int x, int y) {
    for (int i = 0; i < 9; i++) {
        if (i == 4) continue;
        const real *at = ffp_look_at(m, view, x + i % 3 - 1, y + i / 3 - 1);
        *out++ = ffp_look_brightness(at + 3);
        *out++ = ffp_look_brightness(at + 6);
        *out++ = at[FFP_LOOK_COLOURS];
    }
}

// How far z lies behind what is drawn, in [-1,1]; 0 where nothing is.
FFP_FORMULA real ffp_look_behind(real z, real drawn, real footprint) {
    const real behind = (z - drawn) / (FFP_LOOK_REACH * footprint);
    return drawn > 0 ? fmin(fmax(behind, (real)-1), (real)1) : 0;
}

FFP_FORMULA void ffp_look_slopes(real *out, const FfpLookMaps *m, int view, int x, int y) {
    const real *own = ffp_look_at(m, view, x, y);
    const real *beside[2][2] = {{ffp_look_at(m, view, x - 1, y), ffp_look_at(m, view, x + 1, y)},
                                {ffp_look_at(m, view, x, y - 1), ffp_look_at(m, view, x, y + 1)}};
    for (int i = 0; i < 2; i++) { // white, active
        const real error = ffp_look_brightness(own + 3 + 3 * i);
        for (int k = 0; k < 2; k++) {
            const int number = FFP_LOOK_WHITE + i;
            const real slope = FFP_LOOK_SLOPE_GAIN * (beside[k][1][number] - beside[k][0][number]) / 2;
            out[2 * i + k] = slope;
            out[FFP_LOOK_SLOPES / 2 + 2 * i + k] = slope * error;
        }
    }
}

// The view's camera: z of a point; into *x, *y the pixel that it falls into, -1 outside.
FFP_FORMULA real ffp_look_project(const FfpLookMaps *m, int view, const real point[3], int *x, int *y) {
    const FfpCamera *c = &m->camera[view];
    real at[3];
    for (int k = 0; k < 3; k++) {
        at[k] = 0;
        for (int i = 0; i < 3; i++) at[k] += c->pose[4 * i + k] * (point[i] - c->pose[4 * i + 3]);
    }
    *x = *y = -1;
    if (at[2] <= 0) return at[2];
    const real u = c->fx * at[0] / at[2] + c->cx, v = c->fy * at[1] / at[2] + c->cy;
    if (u < 0 || v < 0 || u >= (real)m->frame[2 * view] || v >= (real)m->frame[2 * view + 1]) return at[2];
    *x = (int)u;
    *y = (int)v;
    return at[2];
}

// out [FFP_LOOK_ERRORS + 2]
FFP_FORMULA void ffp_look_elsewhere(real *out, const FfpLookMaps *m, int own, const real centre[3]) {
    int seen = 0;
    for (int k = 0; k < FFP_LOOK_ERRORS + 2; k++) out[k] = 0;
    for (int view = 0; view < m->views; view++) {
        int x, y;
        const real z = ffp_look_project(m, view, centre, &x, &y);
        if (view == own || x < 0) continue;
        const real *at = ffp_look_at(m, view, x, y), footprint = z / m->camera[view].fx;
        if (at[FFP_LOOK_DEPTH] > 0 && z - at[FFP_LOOK_DEPTH] > FFP_LOOK_HIDDEN * footprint) continue;
        for (int k = 0; k < FFP_LOOK_ERRORS; k++) out[k] += at[k];
        out[FFP_LOOK_ERRORS + 1] += ffp_look_behind(z, at[FFP_LOOK_DEPTH], footprint);
        seen++;
    }
    for (int k = 0; k < FFP_LOOK_ERRORS + 2; k++) out[k] /= seen > 1 ? seen : 1;
    out[FFP_LOOK_ERRORS] = (real)seen / m->views;
}

// out [FFP_LOOK_SEEN + numbers] of the splat of `pixel`, (view * height + y) * width + x.
FFP_FORMULA void ffp_look_inputs(real *out, const FfpLookMaps *m, int64_t pixel, const real centre[3],
                                 const real *raw, int numbers) {
    const int x = (int)(pixel % m->width), y = (int)(pixel / m->width % m->height);
    const int view = (int)(pixel / m->width / m->height);
    const real *own = ffp_look_at(m, view, x, y);
    for (int k = 0; k < FFP_LOOK_ERRORS; k++) out[k] = own[k];
    ffp_look_mean(out + FFP_LOOK_ERRORS, m, view, x, y, 1);
    ffp_look_mean(out + 2 * FFP_LOOK_ERRORS, m, view, x, y, 3);
    out += 3 * FFP_LOOK_ERRORS;
    ffp_look_neighbours(out, m, view, x, y);
    out += FFP_LOOK_NEIGHBOURS;
    int ignored[2];
    const real z = ffp_look_project(m, view, centre, ignored, ignored + 1);
    out[0] = ffp_look_behind(z, own[FFP_LOOK_DEPTH], fmax(z, (real)0.01F) / m->camera[view].fx);
    out[1] = own[FFP_LOOK_DEPTH] > 0 ? 1 : 0;
    ffp_look_slopes(out + 2, m, view, x, y);
    out += 2 + FFP_LOOK_SLOPES;
    ffp_look_elsewhere(out, m, view, centre);
    out += FFP_LOOK_ERRORS + 2;
    for (int k = 0; k < numbers; k++) out[k] = raw[k];
}

#endif
