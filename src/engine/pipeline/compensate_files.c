// A compensation's patterns and predicted pictures in files.
#include <math.h>
#include <stdio.h>
#include <string.h>
#include "core/base/alloc.h"
#include "core/base/file.h"
#include "core/base/log.h"
#include "core/image/film.h"
#include "core/image/frames.h"
#include "engine/pipeline/compensate.h"

// "<pattern without .png><between><id>.png"
static bool name_beside(char out[FFP_PATH_MAX], const char *pattern, const char *between, const char *id,
                        FfpError *err) {
    const char *base = ffp_basename(pattern), *dot = strrchr(base, '.');
    const int stem = (int)(dot && dot != base ? dot - pattern : (ptrdiff_t)strlen(pattern));
    if (strchr(id, '/'))
        return ffp_fail(err, FFP_ERROR_ARGUMENT, pattern, "view %s is not a valid file name", id);
    if (snprintf(out, FFP_PATH_MAX, "%.*s%s%s.png", stem, pattern, between, id) >= FFP_PATH_MAX)
        return ffp_fail(err, FFP_ERROR_ARGUMENT, pattern, "the path is too long");
    return true;
}

// A single pattern takes the file's name; everything else stands beside it.
static bool write_image(const FfpImageEntry *entry, const char *file, int patterns, FfpError *err) {
    static const char *const kinds[3][2] = {{"pattern_", "_"}, {"seen_", "_seen_"}, {"target_", "_target_"}};
    char path[FFP_PATH_MAX];
    for (int k = 0; k < 3; k++) {
        const size_t length = strlen(kinds[k][0]);
        if (strncmp(entry->name, kinds[k][0], length) != 0) continue;
        if (k == 0 && patterns == 1) return ffp_image_write_png_encoded(&entry->image, file, err);
        return name_beside(path, file, kinds[k][1], entry->name + length, err) &&
               ffp_image_write_png_encoded(&entry->image, path, err);
    }
    return true;
}

static bool write_images(const FfpImages *images, const FfpCompensation *options, int patterns,
                         FfpError *err) {
    for (const FfpImageEntry *entry = images->first; entry; entry = entry->next)
        if (!write_image(entry, options->pattern, patterns, err)) return false;
    return true;
}

// --- Films. ---

typedef struct FilmJob {
    const FfpGaussians *gaussians;
    const FfpCapture *capture;
    const FfpCompensation *options;
    FfpFilm film;
    FfpCompensationStats sum;
} FilmJob;

static bool check_film(const FfpCompensation *options, FfpError *err) {
    if (!options->video)
        return ffp_fail(err, FFP_ERROR_ARGUMENT, options->targets[0],
                        "is read as a film: say with video where the corrected film goes, or save a still "
                        "picture as PNG");
    if (options->n_views != 1)
        return ffp_fail(err, FFP_ERROR_ARGUMENT, options->video,
                        "a film is corrected for one view at a time");
    if (options->rate < 0 || options->rate > 1000)
        return ffp_fail(err, FFP_ERROR_ARGUMENT, options->video, "%d frames per second: expected 1 to 1000",
                        options->rate);
    return ffp_film_check(options->video, err) && ffp_output_probe(options->video, err);
}

static void add_stats(FfpCompensationStats *sum, const FfpCompensationStats *one) {
    sum->patterns = one->patterns;
    sum->gain += one->gain;
    sum->unlit += one->unlit;
    sum->too_dark += one->too_dark;
    sum->too_bright += one->too_bright;
    sum->psnr_dark += one->psnr_dark;
    sum->psnr_closed += one->psnr_closed;
    sum->psnr += one->psnr;
    sum->elapsed_s += one->elapsed_s;
}

static bool add_corrected(FilmJob *job, const FfpRaw *frame, bool first, FfpError *err) {
    FfpCompensationStats found = {0};
    FfpImages *images = ffp_compensation_run(job->gaussians, job->capture, job->options, frame, &found, err);
    if (!images) return false;
    FfpImage pattern = ffp_image_copy(&images->first->image);
    const ptrdiff_t values = (ptrdiff_t)3 * pattern.width * pattern.height;
    ffp_image_to_srgb(&pattern);
    for (ptrdiff_t i = 0; i < values; i++) pattern.data[i] = floorf(pattern.data[i] * 255 + 0.5F) / 255;
    const bool ok = (!first || write_images(images, job->options, found.patterns, err)) &&
                    ffp_film_add(&job->film, &pattern, err);
    ffp_image_free(&pattern);
    ffp_images_free(images);
    add_stats(&job->sum, &found);
    return ok;
}

// The figures are means over the frames.
static void take_means(FfpCompensationStats *sum, int frames) {
    double *const means[] = {&sum->gain,      &sum->unlit,       &sum->too_dark, &sum->too_bright,
                             &sum->psnr_dark, &sum->psnr_closed, &sum->psnr};
    for (size_t i = 0; i < sizeof means / sizeof *means; i++) *means[i] /= frames;
}

static bool write_film(FilmJob *job, FfpError *err) {
    const FfpCompensation *options = job->options;
    FfpFrames frames;
    FfpRaw frame;
    if (!ffp_film_open(&job->film, options->video, 0, options->rate, err)) return false;
    int status = ffp_frames_open(&frames, options->targets[0], options->rate, err) ? 1 : -1, done = 0;
    if (status > 0) ffp_film_follow(&job->film, &frames);
    const FfpTask task = ffp_task("correcting frames", frames.expected);
    while (status > 0 && (status = ffp_frames_next(&frames, &frame, err)) > 0) {
        if (!add_corrected(job, &frame, done == 0, err)) status = -1;
        ffp_task_step(&task, ++done, NULL);
    }
    ffp_frames_close(&frames);
    ffp_task_end(&task);
    if (status < 0) {
        ffp_film_abort(&job->film);
        return false;
    }
    take_means(&job->sum, done);
    return ffp_film_commit(&job->film, err);
}

bool ffp_compensation_write(const FfpGaussians *gaussians, const FfpCapture *capture,
                            const FfpCompensation *options, const FfpRaw *pictures,
                            FfpCompensationStats *stats, FfpError *err) {
    FfpCompensationStats found = {0};
    if (!ffp_output_probe(options->pattern, err)) return false;
    if (!pictures && options->n_targets == 1 && ffp_frames_are_in(options->targets[0])) {
        FfpCapture held;
        FilmJob job = {.gaussians = gaussians, .capture = &held, .options = options};
        if (!check_film(options, err) || !ffp_compensation_hold(&held, capture, options, err)) return false;
        const bool written = write_film(&job, err);
        ffp_compensation_release(&held, capture);
        if (written && stats) *stats = job.sum;
        return written;
    }
    if (options->video)
        return ffp_fail(err, FFP_ERROR_ARGUMENT, pictures ? options->video : options->targets[0],
                        "the target is not a film");
    FfpImages *images = ffp_compensation_run(gaussians, capture, options, pictures, &found, err);
    if (!images) return false;
    const bool ok = write_images(images, options, found.patterns, err);
    ffp_images_free(images);
    if (ok && stats) *stats = found;
    return ok;
}
