// Patterns by inverting the correspondences and the light, without iterating.
#include <stdlib.h>
#include <string.h>
#include <tgmath.h>
#include "core/base/arena.h"
#include "engine/apply/solve.h"

// A camera's request at each of its pixels: level times certainty in three channels, and the certainty.
// Levels are cut at what full feather could show, so that one impossible wish does not spoil its neighbours.
static FfpImage levels(const FfpProCams *procams, int s) {
    const FfpCameraView *camera_view = &procams->camera_views[s];
    const int width = camera_view->weight.width, height = camera_view->weight.height;
    FfpImage out = ffp_image_new(width, height, 4), lit = ffp_procams_lit(procams, s);
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
            const real wanted = camera_view->target.data[3 * p + c] - camera_view->ambient.data[3 * p + c];
            const real level = sum[c] > 0 ? wanted / sum[c] : wanted > 0 ? 1 / greatest : 0;
            out.data[4 * p + c] = certainty * fmin(fmax(level, (real)0), 1 / greatest);
        }
        out.data[4 * p + 3] = certainty;
    }
    ffp_image_free(&lit);
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

void ffp_procams_closed_form(FfpProCams *procams, int margin) {
    FfpImage *wishes = ffp_alloc((size_t)procams->n_camera_views, sizeof *wishes);
    for (int s = 0; s < procams->n_camera_views; s++) wishes[s] = levels(procams, s);
    for (int k = 0; k < procams->n_projections; k++) {
        FfpProjection *projection = &procams->projections[k];
        const int width = projection->pattern.width, height = projection->pattern.height;
        FfpImage sum = ffp_image_new(width, height, 4);
        for (int s = 0; s < procams->n_camera_views; s++) gather(procams, s, k, &wishes[s], &sum);
        for (int pass = margin * ffp_procams_footprint(procams, k); pass > 0; pass--) grow(&sum);
        for (int p = 0; p < width * height; p++)
            for (int c = 0; c < 3; c++) {
                const real level = sum.data[4 * p + 3] > 0 ? sum.data[4 * p + c] / sum.data[4 * p + 3] : 0;
                projection->pattern.data[3 * p + c] = fmin(level * projection->feather.data[p], (real)1);
            }
        ffp_image_free(&sum);
    }
    for (int s = 0; s < procams->n_camera_views; s++) ffp_image_free(&wishes[s]);
    ffp_free(wishes);
}
