// Import: one photograph as linear light without lens distortion.
#include <pthread.h>
#include <tgmath.h>
#include "core/base/alloc.h"
#include "core/base/call.h"
#include "rig/graycode/graycode.h"
#include "rig/import/import_steps.h"

#define SAMPLES_LEFT 4 // a side of the capture's pixels, from which on a photograph may be reduced before

static pthread_mutex_t counting = PTHREAD_MUTEX_INITIALIZER; // several photographs are read at a time

// Exposure of linear values; what then exceeds 1 is cut off when the capture is written, and counted.
static void expose(FfpImporting *import, FfpImage *image) {
    const real factor = (real)exp2(import->settings->exposure);
    const ptrdiff_t count = (ptrdiff_t)image->width * image->height * 3;
    int64_t too_bright = 0;
    real brightest = 0;
    for (ptrdiff_t i = 0; i < count; i++) {
        brightest = image->data[i] > brightest ? image->data[i] : brightest;
        image->data[i] *= factor;
        too_bright += image->data[i] > 1.002F;
    }
    pthread_mutex_lock(&counting);
    import->brightest = fmax(import->brightest, (double)brightest);
    import->too_bright += too_bright;
    import->values += count;
    pthread_mutex_unlock(&counting);
}

// Photographs are read by several threads.
static void count_developed(FfpDeveloped *sum, const FfpDeveloped *more) {
#pragma omp atomic
    sum->raws += more->raws;
#pragma omp atomic
    sum->films += more->films;
#pragma omp atomic
    sum->frames += more->frames;
}

// An alpha channel that is 1 everywhere tells nothing: programs add such to any picture.
static bool tells_shape(const FfpImage *alpha) {
    const ptrdiff_t pixels = alpha->data ? (ptrdiff_t)alpha->width * alpha->height : 0;
    for (ptrdiff_t i = 0; i < pixels; i++) {
        if (alpha->data[i] < 1) return true;
    }
    return false;
}

// By what a view's photographs are reduced before, and their optics then.
static int shrink_for(const FfpImporting *import, int stop, FfpOptics *reduced) {
    const FfpOptics *optics = &import->calibration.stops[stop].camera;
    const FfpCamera *camera = &import->capture.views[stop].camera;
    const int shrink = ffp_optics_shrink_by(optics, optics->fx / (double)camera->fx / SAMPLES_LEFT);
    *reduced = ffp_optics_shrunk(optics, shrink);
    return shrink;
}

bool ffp_importing_read_picture(FfpImporting *import, const char *path, int stop, FfpImage *picture,
                                FfpImage *alpha, FfpError *err) {
    const FfpOptics *optics = &import->calibration.stops[stop].camera;
    const FfpCamera *camera = &import->capture.views[stop].camera;
    FfpOptics reduced;
    const int shrink = shrink_for(import, stop, &reduced);
    FfpImage raw = {0}, raw_alpha = {0};
    FfpDeveloped developed = {0};
    int whole[2];
    const bool read = ffp_photograph_read_reduced(
        &raw, &raw_alpha, whole, path, import->settings->linear_images, shrink, false, &developed, err);
    count_developed(&import->developed, &developed);
    if (!read || !ffp_importing_has_size(path, whole[0], whole[1], optics, err)) {
        ffp_image_free(&raw);
        ffp_image_free(&raw_alpha);
        return false;
    }
    expose(import, &raw);
    *picture = ffp_optics_rectify(&reduced, camera, &raw);
    if (alpha && tells_shape(&raw_alpha)) *alpha = ffp_optics_rectify(&reduced, camera, &raw_alpha);
    ffp_image_free(&raw);
    ffp_image_free(&raw_alpha);
    return true;
}

typedef struct Reading {
    FfpImporting *import;
    const char *const *paths;
    int stop;
    FfpImage *pictures, *alphas;
    FfpError *errors;
    bool *ok;
} Reading;

static void read_one(void *argument, int64_t i) {
    const Reading *r = argument;
    r->ok[i] = !r->paths[i] || ffp_importing_read_picture(r->import, r->paths[i], r->stop, &r->pictures[i],
                                                          &r->alphas[i], &r->errors[i]);
    ffp_cancel_point();
}

bool ffp_importing_read_pictures(FfpImporting *import, const char *const *paths, int n, int stop,
                                 FfpImage *pictures, FfpImage *alphas, FfpError *err) {
    FfpError *errors = ffp_alloc((size_t)n + 1, sizeof *errors);
    bool *ok = ffp_alloc((size_t)n + 1, sizeof *ok), all = true;
    ffp_parallel_for(n, FFP_IMPORT_READERS, read_one,
                     &(Reading){import, paths, stop, pictures, alphas, errors, ok});
    for (int i = 0; i < n && all; i++) {
        all = ok[i];
        if (!all && err) *err = errors[i];
    }
    ffp_free(errors), ffp_free(ok);
    return all;
}

bool ffp_importing_make_plain(FfpImporting *import, int stop, FfpImage *black, FfpImage *white,
                              FfpError *err) {
    const FfpShots *shots = &import->shots;
    const FfpCamera *camera = &import->capture.views[stop].camera;
    FfpOptics reduced;
    FfpImage made[2], *const plain[2] = {black, white};
    if ((black->data && white->data) || !shots->codes) return true;
    const FfpGrayPhotographs from = {.width = import->coded.width,
                                     .height = import->coded.height,
                                     .codes = shots->codes + (ptrdiff_t)stop * shots->n_codes,
                                     .shrink = shrink_for(import, stop, &reduced),
                                     .linear = import->settings->linear_images};
    if (!ffp_gray_make_pictures(made, &from, err)) return false;
    const bool ok =
        ffp_importing_has_size(ffp_shots_white(shots, stop), made[0].width, made[0].height, &reduced, err);
    for (int k = 0; k < 2; k++) {
        if (ok && !plain[k]->data) {
            expose(import, &made[k]);
            *plain[k] = ffp_optics_rectify(&reduced, camera, &made[k]);
        }
        ffp_image_free(&made[k]);
    }
    return ok;
}
