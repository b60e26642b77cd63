// Rendering to files: chosen views under chosen patterns, and the G-buffers.
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include "base/arena.h"
#include "base/file.h"
#include "base/log.h"
#include "eval/relight.h"

// What a call works with: views and patterns borrowed from the capture or the poses file, or read for it.
typedef struct Job {
    const FfpPictures *options;
    FfpCapture poses; // only when the options name a file
    bool has_poses;
    int n_views, n_patterns;
    const FfpCapture *source; // of the views: the capture or the poses
    int *views;               // [n_views] which of them
    FfpPattern *patterns;     // images are owned when `owned`
    bool *owned;
    int written;
} Job;

static const FfpView *view_of(const Job *job, int v) {
    return &job->source->views[job->views[v]];
}

static void free_job(Job *job) {
    for (int p = 0; p < job->n_patterns; p++)
        if (job->owned[p]) ffp_image_free(&job->patterns[p].image);
    free(job->patterns);
    free(job->owned);
    free(job->views);
    if (job->has_poses) ffp_capture_free(&job->poses);
}

static bool choose_views(Job *job, const FfpCapture *capture, FfpError *err) {
    const FfpPictures *options = job->options;
    job->source = capture;
    if (options->poses) {
        if (!ffp_capture_read_targets(&job->poses, options->poses, capture, err)) return false;
        job->has_poses = true;
        job->source = &job->poses;
    }
    job->n_views = options->n_views ? options->n_views : job->source->n_views;
    job->views = ffp_alloc(job->n_views, sizeof *job->views);
    for (int v = 0; v < job->n_views; v++) {
        const int found = options->n_views ? ffp_capture_find_view(job->source, options->views[v]) : v;
        if (found < 0)
            return ffp_fail(err, options->poses ? options->poses : capture->folder, "there is no view %s",
                            options->views[v]);
        job->views[v] = found;
    }
    return true;
}

static bool add_pattern(Job *job, const FfpCapture *capture, const char *name, FfpError *err) {
    FfpPattern *pattern = &job->patterns[job->n_patterns];
    const FfpCamera *projector = &view_of(job, 0)->projector;
    const int known = ffp_capture_find_pattern(capture, name);
    const bool from_file = known < 0;
    if (!from_file)
        *pattern = capture->patterns[known];
    else if (!ffp_is_file(name))
        return ffp_fail(err, capture->folder, "%s is neither a pattern of the capture nor an image file",
                        name);
    else if (!ffp_pattern_read(pattern, name, projector->width, projector->height, err))
        return false;
    job->owned[job->n_patterns++] = from_file;
    for (int p = 0; p + 1 < job->n_patterns; p++)
        if (strcmp(job->patterns[p].name, pattern->name) == 0)
            return ffp_fail(err, name, "two patterns are called %s: their pictures would share a file",
                            pattern->name);
    return true;
}

static bool choose_patterns(Job *job, const FfpCapture *capture, FfpError *err) {
    const int wanted = job->options->n_patterns;
    job->patterns = ffp_alloc(wanted ? wanted : 1, sizeof *job->patterns);
    job->owned = ffp_alloc(wanted ? wanted : 1, sizeof *job->owned);
    if (!wanted) return add_pattern(job, capture, capture->patterns[capture->white].name, err);
    for (int p = 0; p < wanted; p++)
        if (!add_pattern(job, capture, job->options->patterns[p], err)) return false;
    return true;
}

// One projector size must serve: patterns are given in its pixels.
static bool check_projectors(const Job *job, FfpError *err) {
    for (int v = 0; v < job->n_views; v++)
        for (int p = 0; p < job->n_patterns; p++) {
            const FfpImage *image = &job->patterns[p].image;
            const FfpCamera *projector = &view_of(job, v)->projector;
            if (image->width != projector->width || image->height != projector->height)
                return ffp_fail(err, job->patterns[p].name,
                                "a pattern of %d x %d does not fit view %s's projector of %d x %d",
                                image->width, image->height, view_of(job, v)->id, projector->width,
                                projector->height);
        }
    return true;
}

static bool write_map(Job *job, const FfpView *view, const FfpImage *picture, const char *rest,
                      FfpError *err) {
    char path[FFP_PATH_MAX];
    if (!ffp_picture_path(path, sizeof path, job->options->folder, view->id, rest, err)) return false;
    job->written++;
    return strstr(rest, ".exr") ? ffp_image_write_exr(picture, path, err)
                                : ffp_image_write_png(picture, path, err);
}

static bool write_maps(Job *job, const FfpView *view, const FfpGbuffer *gbuffer, FfpError *err) {
    FfpImage depth = ffp_map_depth(gbuffer);
    bool ok = write_map(job, view, &depth, "depth.exr", err);
    ffp_image_free(&depth);
    for (int m = 0; ok && m < FFP_MAP_COUNT; m++) {
        char rest[32];
        snprintf(rest, sizeof rest, "%s.png", ffp_map_name((FfpMap)m));
        FfpImage picture = ffp_map_picture(gbuffer, (FfpMap)m);
        ok = write_map(job, view, &picture, rest, err);
        ffp_image_free(&picture);
    }
    return ok;
}

static bool write_view(Job *job, FfpRelight *relight, const FfpGaussians *gaussians,
                       const FfpCapture *capture, const FfpView *view, FfpError *err) {
    ffp_relight_view(relight, gaussians, view);
    bool ok = true;
    for (int p = 0; ok && p < job->n_patterns; p++) {
        char rest[FFP_NAME_MAX + 8];
        snprintf(rest, sizeof rest, "%s.png", job->patterns[p].name);
        FfpSummed summed = ffp_summed_new(&job->patterns[p].image);
        FfpImage picture = ffp_relight_shade(relight, view, capture->intensity, &summed);
        ok = write_map(job, view, &picture, rest, err);
        ffp_image_free(&picture);
        ffp_summed_free(&summed);
    }
    return ok && (!job->options->maps || write_maps(job, view, &relight->gbuffer, err));
}

int ffp_render_pictures(const FfpGaussians *gaussians, const FfpCapture *capture, const FfpPictures *options,
                        FfpError *err) {
    Job job = {.options = options};
    bool ok = choose_views(&job, capture, err) && choose_patterns(&job, capture, err) &&
              check_projectors(&job, err) && ffp_make_folders(options->folder, err);
    if (ok) {
        const FfpRenderSettings settings = ffp_drawing_settings(options->drawing, NULL);
        FfpRelight relight = ffp_relight_new(&settings);
        FfpProgress progress = ffp_progress("rendering", job.n_views);
        for (int v = 0; ok && v < job.n_views; v++) {
            ok = write_view(&job, &relight, gaussians, capture, view_of(&job, v), err);
            ffp_progress_step(&progress, v + 1, NULL);
        }
        ffp_progress_end(&progress);
        ffp_relight_free(&relight);
    }
    free_job(&job);
    return ok ? job.written : -1;
}
