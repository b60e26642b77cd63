// Patterns by inverting the correspondences and the light, without iterating.
#include <stdlib.h>
#include <string.h>
#include <tgmath.h>
#include "core/base/arena.h"
#include "engine/apply/solve.h"
#include "engine/apply/unseen.h"

#define ROUNDS 2 // more, where light is spread, blurred or scattered: each takes off what the last one does

// A level asked of direct light, drawn towards the share of all that white adds where more of that is
// scattered than direct, as in shadows: there little direct light would have to make up for much.
static real steadied(const FfpCameraView *camera_view, size_t i, real direct, real level) {
    const real scattered = camera_view->scattered.data ? camera_view->scattered.data[i] : 0;
    if (!(scattered > 0)) return level;
    const real share = (camera_view->target.data[i] - camera_view->ambient.data[i]) / (direct + scattered);
    return share + direct * direct / (direct * direct + scattered * scattered) * (level - share);
}

// A camera's request at each of its pixels: level times certainty in three channels, and the certainty.
// Levels are cut at what full feather could show, so that one impossible wish does not spoil its neighbours.
static FfpImage levels(const FfpProCams *procams, int s) {
    const FfpCameraView *camera_view = &procams->camera_views[s];
    const int width = camera_view->weight.width, height = camera_view->weight.height;
    FfpImage out = ffp_image_new(width, height, 4), lit = ffp_procams_lit(procams, s),
             floor = ffp_procams_floor(procams, s);
    for (int p = 0; p < width * height; p++) {
        real sum[3] = {0, 0, 0}, greatest = 0;
        const real certainty = lit.data[p] * camera_view->weight.data[p] * camera_view->facing.data[p];
        if (!(certainty > 0)) continue;
        for (int k = 0; k < procams->n_projections; k++) {
            const FfpLink *link = ffp_procams_link(procams, s, k);
            real feather;
            ffp_image_sample(&procams->projections[k].feather, link->mapping.uv[2 * p],
                             link->mapping.uv[2 * p + 1], &feather);
            for (int c = 0; c < 3; c++) sum[c] += feather * link->response.data[3 * p + c];
            if (link->mapping.visibility[p] > 0) greatest = fmax(greatest, feather);
        }
        if (!(greatest > 0)) continue;
        for (int c = 0; c < 3; c++) {
            const real wanted = camera_view->target.data[3 * p + c] - floor.data[3 * p + c];
            const real level = sum[c] > 0 ? wanted / sum[c] : wanted > 0 ? 1 / greatest : 0;
            const real steady = steadied(camera_view, 3 * (size_t)p + (size_t)c, sum[c], level);
            out.data[4 * p + c] = certainty * fmin(fmax(steady, (real)0), 1 / greatest);
        }
        out.data[4 * p + 3] = certainty;
    }
    ffp_image_free(&lit);
    ffp_image_free(&floor);
    return out;
}

// Adds a camera's wishes to a projector's: [projector's size, 4], as levels() has them.
static void gather(const FfpProCams *procams, int s, int k, const FfpImage *wishes, FfpImage *out) {
    FfpImage inverse = ffp_procams_inverse(procams, s, k);
    const int pixels = inverse.width * inverse.height;
#pragma omp parallel for schedule(static)
    for (int p = 0; p < pixels; p++) {
        real wish[4];
        if (!(inverse.data[3 * p + 2] > 0)) continue;
        ffp_image_sample(wishes, inverse.data[3 * p], inverse.data[3 * p + 1], wish);
        for (int c = 0; c < 4; c++) out->data[4 * p + c] += wish[c];
    }
    ffp_image_free(&inverse);
}

// The mean of the known among the eight neighbours; false when there is none.
static bool from_neighbours(const FfpImage *known, int x, int y, real out[4]) {
    real count = 0;
    memset(out, 0, 4 * sizeof *out);
    for (int j = y > 0 ? y - 1 : 0; j <= y + 1 && j < known->height; j++)
        for (int i = x > 0 ? x - 1 : 0; i <= x + 1 && i < known->width; i++) {
            const real *pixel = known->data + 4 * ((size_t)j * (size_t)known->width + (size_t)i);
            if (!(pixel[3] > 0)) continue;
            count++;
            for (int c = 0; c < 3; c++) out[c] += pixel[c] / pixel[3];
        }
    for (int c = 0; c < 3; c++) out[c] /= fmax(count, (real)1);
    out[3] = 1;
    return count > 0;
}

// Grows what is known by one pixel.
static void grow(FfpImage *image) {
    FfpImage before = ffp_image_copy(image);
#pragma omp parallel for schedule(static)
    for (int y = 0; y < image->height; y++)
        for (int x = 0; x < image->width; x++) {
            real *pixel = image->data + 4 * ((size_t)y * (size_t)image->width + (size_t)x), filled[4];
            if (!(pixel[3] > 0) && from_neighbours(&before, x, y, filled))
                memcpy(pixel, filled, sizeof filled);
        }
    ffp_image_free(&before);
}

int ffp_procams_footprint(const FfpProCams *procams, int projection) {
    double sum = 0, count = 0;
    for (int s = 0; s < procams->n_camera_views; s++) {
        const FfpMapping *mapping = &ffp_procams_link(procams, s, projection)->mapping;
        for (int p = 0; p < mapping->width * mapping->height; p++)
            if (mapping->visibility[p] > 0) {
                sum += (double)fmax(mapping->extent[2 * p], mapping->extent[2 * p + 1]);
                count++;
            }
    }
    return count > 0 ? (int)ceil(sum / count) : 1;
}

// The pattern whose light is `wanted`, as far as it can be: what the pattern so far spreads and blurs is
// taken off.
static void unspread(const FfpProCams *procams, int k, FfpImage *wanted) {
    if (!(procams->spread_reach > 0 || procams->blur > 0)) return;
    FfpImage spread = ffp_procams_light(procams, k);
    const FfpImage *before = &procams->projections[k].pattern;
    const ptrdiff_t values = (ptrdiff_t)wanted->width * wanted->height * 3;
    for (ptrdiff_t i = 0; i < values; i++) {
        const real direct = (1 - procams->spread[i % 3]) * before->data[i];
        wanted->data[i] = (wanted->data[i] - (spread.data[i] - direct)) / (1 - procams->spread[i % 3]);
    }
    ffp_image_free(&spread);
}

// One round: the patterns for what of the targets those so far leave to direct light.
static void solve_round(FfpProCams *procams, int margin) {
    FfpImage *wishes = ffp_alloc((size_t)procams->n_camera_views, sizeof *wishes);
    for (int s = 0; s < procams->n_camera_views; s++) wishes[s] = levels(procams, s);
    for (int k = 0; k < procams->n_projections; k++) {
        FfpProjection *projection = &procams->projections[k];
        const int width = projection->pattern.width, height = projection->pattern.height;
        FfpImage sum = ffp_image_new(width, height, 4), wanted = ffp_image_new(width, height, 3);
        for (int s = 0; s < procams->n_camera_views; s++) gather(procams, s, k, &wishes[s], &sum);
        for (int pass = margin * ffp_procams_footprint(procams, k); pass > 0; pass--) grow(&sum);
        ffp_fill_unseen(&sum, &projection->lit);
        for (int p = 0; p < width * height; p++)
            for (int c = 0; c < 3; c++) {
                const real level = sum.data[4 * p + 3] > 0 ? sum.data[4 * p + c] / sum.data[4 * p + 3] : 0;
                wanted.data[3 * p + c] = level * projection->feather.data[p];
            }
        unspread(procams, k, &wanted);
        for (int i = 0; i < 3 * width * height; i++) {
            const bool asked = sum.data[i / 3 * 4 + 3] > 0;
            projection->pattern.data[i] = asked ? fmin(fmax(wanted.data[i], (real)0), (real)1) : 0;
        }
        ffp_image_free(&sum);
        ffp_image_free(&wanted);
    }
    for (int s = 0; s < procams->n_camera_views; s++) ffp_image_free(&wishes[s]);
    ffp_free(wishes);
}

void ffp_procams_closed_form(FfpProCams *procams, int margin) {
    bool softens = procams->spread_reach > 0 || procams->blur > 0;
    for (int s = 0; s < procams->n_camera_views; s++)
        softens = softens || procams->camera_views[s].scattered.data;
    solve_round(procams, margin);
    for (int round = 0; softens && round < ROUNDS; round++) solve_round(procams, margin);
}
