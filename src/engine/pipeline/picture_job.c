#include "engine/pipeline/picture_job.h"
#include <math.h>
#include <string.h>
#include "core/base/alloc.h"
#include "core/base/file.h"
#include "core/base/listing.h"
#include "core/base/memory.h"
#include "core/capture/panel.h"
#include "core/image/film.h"
#include "core/image/frames.h"
#include "core/image/framing.h"
#include "engine/apply/choose.h"
#include "engine/pipeline/elsewhere.h"
#include "engine/pipeline/orbit.h"

#define ORBIT_FRAMES_MAX 9999 // as many as a name's four digits count

void ffp_picture_job_free(FfpPictureJob *job) {
    for (int p = 0; p < job->n_patterns; p++)
        if (job->owned[p]) ffp_image_free(&job->patterns[p].image);
    ffp_free(job->patterns);
    ffp_free(job->owned);
    ffp_free(job->views);
    ffp_free(job->own);
    if (job->has_poses) ffp_capture_free(&job->poses);
}

static bool check_sequence(const FfpPictures *options, FfpError *err) {
    if (!ffp_framing_check(options->framing, err) ||
        !ffp_check_choice((int)options->orbit, FFP_ORBIT_OBJECT, "orbit", err))
        return false;
    if (!ffp_is_sequence(options)) return true;
    if (options->maps)
        return ffp_fail(err, FFP_ERROR_ARGUMENT, options->folder,
                        "maps cannot be written for an orbit or a video");
    if (options->video && !(ffp_film_check(options->video, err) && ffp_output_probe(options->video, err)))
        return false;
    if (options->video && (options->rate < 1 || options->rate > 1000))
        return ffp_fail(err, FFP_ERROR_ARGUMENT, options->video, "%d frames per second: expected 1 to 1000",
                        options->rate);
    if (options->orbit == FFP_ORBIT_NONE) return true;
    if (options->n_views > 1)
        return ffp_fail(err, FFP_ERROR_ARGUMENT, options->folder, "an orbit starts from one view");
    if (options->frames < 1 || options->frames > ORBIT_FRAMES_MAX)
        return ffp_fail(err, FFP_ERROR_ARGUMENT, options->folder, "an orbit of %d frames: expected 1 to %d",
                        options->frames, ORBIT_FRAMES_MAX);
    return true;
}

// The size of the first pattern that is an image file; 0 when none is.
static bool size_of_patterns(const FfpPictures *options, int *width, int *height, FfpError *err) {
    *width = *height = 0;
    for (int p = 0; p < options->n_patterns; p++)
        if (ffp_is_file(options->patterns[p]) && !ffp_frames_are_in(options->patterns[p]))
            return ffp_image_read_size(width, height, options->patterns[p], err);
    return true;
}

// Where devices and patterns come from.
static bool open_sources(FfpPictureJob *job, const FfpCapture *capture, FfpError *err) {
    const FfpPictures *options = job->options;
    int width, height;
    job->capture = job->source = capture;
    if (!options->poses)
        return capture || ffp_fail(err, FFP_ERROR_ARGUMENT, "poses", "neither a capture nor poses given");
    job->source = &job->poses;
    if (capture) {
        job->has_poses = ffp_capture_read_targets(&job->poses, options->poses, capture, err);
    } else {
        job->has_poses = size_of_patterns(options, &width, &height, err) &&
                         ffp_capture_read_poses(&job->poses, options->poses, width, height, err);
        job->capture = &job->poses;
    }
    return job->has_poses;
}

static bool settle_intensity(FfpPictureJob *job, FfpError *err) {
    const double *given = job->options->intensity;
    const bool none = given[0] == 0 && given[1] == 0 && given[2] == 0;
    for (int c = 0; c < 3; c++) {
        job->intensity[c] = none ? job->capture->intensity[c] : (real)given[c];
        if (!none && !(given[c] >= 0 && given[c] < 1e18))
            return ffp_fail(err, FFP_ERROR_ARGUMENT, "intensity", "invalid radiant intensity %g", given[c]);
    }
    if (none && job->capture == &job->poses && !job->poses.intensity_known)
        return ffp_fail(err, FFP_ERROR_ARGUMENT, job->options->poses,
                        "lacks the projector's intensity: give it, or the capture");
    return true;
}

static bool choose_views(FfpPictureJob *job, FfpError *err) {
    const FfpPictures *options = job->options;
    job->n_views = options->n_views ? options->n_views : job->source->n_views;
    job->views = ffp_alloc((size_t)job->n_views, sizeof *job->views);
    return ffp_choose_among(job->views, job->source, options->views, options->n_views,
                            ffp_is_sequence(options), options->poses ? options->poses : job->capture->folder,
                            err);
}

// Poses without a sphere go round where the Gaussians are.
static void find_centre(FfpCapture *poses, const FfpGaussians *gaussians) {
    double sum[3] = {0}, weight = 0;
    if (poses->radius > 0) return;
    for (int64_t i = 0; i < gaussians->count; i++) {
        weight += (double)gaussians->opacity[i];
        for (int c = 0; c < 3; c++)
            sum[c] += (double)gaussians->opacity[i] * (double)gaussians->centre[3 * i + c];
    }
    for (int c = 0; c < 3; c++) poses->centre[c] = weight > 0 ? (real)(sum[c] / weight) : 0;
}

// After the patterns: all of them are to be seen.
static void make_orbit(FfpPictureJob *job, const FfpGaussians *gaussians) {
    if (job->options->orbit == FFP_ORBIT_NONE) return;
    const FfpView base = *ffp_picture_view(job, 0);
    if (job->capture == &job->poses) find_centre(&job->poses, gaussians);
    job->n_views = job->options->frames > job->n_patterns ? job->options->frames : job->n_patterns;
    job->own = ffp_orbit_views(job->capture, &base, job->options->orbit, job->n_views);
}

static bool resize_camera(FfpCamera *camera, int width, int height, FfpError *err) {
    const double scale = (double)width / camera->width, natural = camera->height * scale;
    const double rows = height > 0 ? height : fmax(1, round(natural));
    if (!(rows <= FFP_IMAGE_SIDE_MAX))
        return ffp_fail(err, FFP_ERROR_ARGUMENT, "height", "%.0f is more than %d", rows, FFP_IMAGE_SIDE_MAX);
    camera->fx *= (real)scale;
    camera->fy *= (real)scale;
    camera->cx *= (real)scale;
    camera->cy *= (real)(height > 0 ? rows / camera->height : scale);
    camera->width = width;
    camera->height = (int)rows;
    return true;
}

static bool resize_views(FfpPictureJob *job, FfpError *err) {
    const int width = job->options->width, height = job->options->height;
    if (width == 0 && height == 0) return true;
    if (width < 1 || width > FFP_IMAGE_SIDE_MAX || height < 0 || height > FFP_IMAGE_SIDE_MAX)
        return ffp_fail(err, FFP_ERROR_ARGUMENT, "width",
                        "pictures of %d x %d pixels: expected 1 to %d per side", width, height,
                        FFP_IMAGE_SIDE_MAX);
    if (!job->own) {
        FfpView *own = ffp_alloc((size_t)job->n_views, sizeof *own);
        for (int v = 0; v < job->n_views; v++) own[v] = *ffp_picture_view(job, v);
        job->own = own;
    }
    for (int v = 0; v < job->n_views; v++)
        if (!resize_camera(&job->own[v].camera, width, height, err)) return false;
    return true;
}

static FfpPattern *next_pattern(FfpPictureJob *job) {
    const size_t count = (size_t)job->n_patterns + 1;
    job->patterns = ffp_grow(job->patterns, count, sizeof *job->patterns);
    job->owned = ffp_grow(job->owned, count, sizeof *job->owned);
    return &job->patterns[job->n_patterns];
}

static bool add_pattern(FfpPictureJob *job, const char *name, FfpError *err) {
    const FfpCapture *capture = job->capture;
    FfpPattern *pattern = next_pattern(job);
    const FfpCamera *projector = &ffp_picture_view(job, 0)->projector;
    const int known = ffp_capture_find_pattern(capture, name);
    const bool from_file = known < 0;
    if (job->n_patterns == FFP_PATTERNS_MAX)
        return ffp_fail(err, FFP_ERROR_ARGUMENT, name, "more than %d patterns", FFP_PATTERNS_MAX);
    if (!from_file && !capture->patterns[known].image.data)
        return ffp_fail(err, FFP_ERROR_FILE, job->options->poses, "the file of pattern %.96s does not exist",
                        name);
    if (!from_file)
        *pattern = capture->patterns[known];
    else if (!ffp_is_file(name))
        return ffp_fail(
            err, FFP_ERROR_ARGUMENT, capture->folder,
            "%.256s is not an image file, a folder or a pattern of the capture; its patterns are %s", name,
            ffp_list_patterns(capture).text);
    else if (!ffp_pattern_read(pattern, name, projector, job->options->framing, err))
        return false;
    job->owned[job->n_patterns++] = from_file;
    for (int p = 0; !ffp_is_sequence(job->options) && p + 1 < job->n_patterns; p++)
        if (strcmp(job->patterns[p].name, pattern->name) == 0)
            return ffp_fail(err, FFP_ERROR_ARGUMENT, name,
                            "two patterns are called %s: their pictures would share a file", pattern->name);
    return true;
}

#define RATE 15 // frames a second of a film, where no rate is given

// Frame `number` of a film as a pattern.
static bool add_frame(FfpPictureJob *job, const char *film, const FfpRaw *raw, int number, FfpError *err) {
    const FfpFraming framing = job->options->framing;
    const FfpCamera *projector = &ffp_picture_view(job, 0)->projector;
    const int width = projector->width, height = projector->height;
    FfpImage image;
    FfpPattern *pattern = next_pattern(job);
    if (job->n_patterns == FFP_PATTERNS_MAX)
        return ffp_fail(
            err, FFP_ERROR_ARGUMENT, film,
            "has more than %d frames: give a part of it, FILM@FROM-TO in seconds, or a lower rate",
            FFP_PATTERNS_MAX);
    if (!ffp_raw_over_black(&image, NULL, raw, film, err)) return false;
    if (number == 0) ffp_framing_note(film, &image, width, height, framing);
    *pattern = (FfpPattern){.novel = true, .image = ffp_image_framed(&image, width, height, framing)};
    ffp_image_free(&image);
    snprintf(pattern->name, sizeof pattern->name, "%.*s_%04u", FFP_NAME_MAX - 8, ffp_basename(film),
             (unsigned)number % 10000U);
    job->owned[job->n_patterns++] = true;
    return true;
}

static bool add_film(FfpPictureJob *job, const char *film, FfpError *err) {
    const int rate = job->options->rate > 0 ? job->options->rate : RATE;
    const FfpCamera *projector = &ffp_picture_view(job, 0)->projector;
    const double bytes = 3.0 * sizeof(real) * projector->width * projector->height;
    FfpFrames frames;
    FfpRaw raw;
    int status =
        ffp_frames_open(&frames, film, rate, err) &&
                ffp_memory_suffices(frames.expected * bytes, "the film's frames",
                                    "give a part of it, FILM@FROM-TO in seconds, or a lower rate", film, err)
            ? 1
            : -1;
    for (int i = 0; status > 0 && (status = ffp_frames_next(&frames, &raw, err)) > 0; i++)
        if (!add_frame(job, film, &raw, i, err)) status = -1;
    ffp_frames_close(&frames);
    return status == 0;
}

// A folder's pictures in the order of their names.
static bool add_pattern_folder(FfpPictureJob *job, const char *folder, FfpError *err) {
    FfpListing listing;
    int pictures = 0;
    bool ok = true;
    ffp_list_folder(&listing, folder);
    for (int i = 0; ok && i < listing.count; i++) {
        char path[FFP_PATH_MAX];
        if (!ffp_image_has_ending(listing.names[i])) continue;
        pictures++;
        ok = ffp_join_path(path, folder, listing.names[i])
                 ? add_pattern(job, path, err)
                 : ffp_fail(err, FFP_ERROR_ARGUMENT, folder, "path is too long");
    }
    ffp_free(listing.names);
    return ok && (pictures > 0 || ffp_fail(err, FFP_ERROR_ARGUMENT, folder, "holds no pictures"));
}

static bool choose_patterns(FfpPictureJob *job, FfpError *err) {
    const FfpCapture *capture = job->capture;
    const int wanted = job->options->n_patterns;
    if (!wanted) return add_pattern(job, capture->patterns[capture->white].name, err);
    for (int p = 0; p < wanted; p++) {
        const char *name = job->options->patterns[p];
        const bool known = ffp_capture_find_pattern(capture, name) >= 0;
        const bool folder = !known && ffp_is_folder(name),
                   film = !known && !folder && ffp_frames_are_in(name);
        if (!(folder ? add_pattern_folder : film ? add_film : add_pattern)(job, name, err)) return false;
    }
    return true;
}

// One projector size must serve: patterns are given in its pixels.
static bool check_projectors(const FfpPictureJob *job, FfpError *err) {
    for (int v = 0; v < job->n_views; v++)
        for (int p = 0; p < job->n_patterns; p++) {
            const FfpImage *image = &job->patterns[p].image;
            const FfpCamera *projector = &ffp_picture_view(job, v)->projector;
            if (image->width != projector->width || image->height != projector->height)
                return ffp_fail(err, FFP_ERROR_ARGUMENT, job->patterns[p].name,
                                "a pattern of %d x %d does not fit view %s's projector of %d x %d",
                                image->width, image->height, ffp_picture_view(job, v)->id, projector->width,
                                projector->height);
        }
    return true;
}

// Pictures from files are sharp; a capture's own patterns are as soft as its projector shows them.
static void soften(FfpPictureJob *job) {
    for (int p = 0; p < job->n_patterns; p++)
        if (job->owned[p]) ffp_panel_soften(&job->capture->panel, &job->patterns[p].image);
}

bool ffp_picture_job_new(FfpPictureJob *job, const FfpGaussians *gaussians, const FfpCapture *capture,
                         const FfpPictures *options, FfpError *err) {
    *job = (FfpPictureJob){.options = options};
    if (!check_sequence(options, err) || !open_sources(job, capture, err) || !settle_intensity(job, err) ||
        !choose_views(job, err) || !choose_patterns(job, err))
        return false;
    soften(job);
    ffp_note_elsewhere(gaussians, job->capture);
    make_orbit(job, gaussians);
    return resize_views(job, err) && check_projectors(job, err);
}
