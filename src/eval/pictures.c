// Rendering to files: chosen views under chosen patterns, and the G-buffers.
#include <dirent.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>
#include "base/arena.h"
#include "base/file.h"
#include "base/log.h"
#include "eval/relight.h"
#include "eval/video.h"

#define ORBIT_FRAMES_MAX 9999 // as many as a name's four digits count

// What a call works with: views and patterns borrowed from the capture or the poses file, or read for it.
typedef struct Job {
    const FfpPictures *options;
    FfpCapture poses; // only when the options name a file
    bool has_poses;
    FfpView *orbit; // [n_views], or NULL
    int n_views, n_patterns;
    const FfpCapture *source; // of the views: the capture or the poses
    int *views;               // [n_views] which of them
    FfpPattern *patterns;     // images are owned when `owned`
    bool *owned;
    int written;
} Job;

static const FfpView *view_of(const Job *job, int v) {
    return job->orbit ? &job->orbit[v] : &job->source->views[job->views[v]];
}

// Whether pictures are frames with numbers, in place of names.
static bool is_sequence(const FfpPictures *options) {
    return options->orbit != FFP_ORBIT_NONE || options->video;
}

static void free_job(Job *job) {
    for (int p = 0; p < job->n_patterns; p++)
        if (job->owned[p]) ffp_image_free(&job->patterns[p].image);
    free(job->patterns);
    free(job->owned);
    free(job->views);
    free(job->orbit);
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

static bool check_sequence(const FfpPictures *options, FfpError *err) {
    if (!is_sequence(options)) return true;
    if (options->maps) return ffp_fail(err, options->folder, "frames of a sequence come without maps");
    if (options->video && (options->rate < 1 || options->rate > 1000))
        return ffp_fail(err, options->video, "%d frames a second: 1 to 1000 are possible", options->rate);
    if (options->orbit == FFP_ORBIT_NONE) return true;
    if (options->n_views > 1) return ffp_fail(err, options->folder, "an orbit starts from one view");
    if (options->frames < 1 || options->frames > ORBIT_FRAMES_MAX)
        return ffp_fail(err, options->folder, "an orbit of %d frames: 1 to %d are possible", options->frames,
                        ORBIT_FRAMES_MAX);
    return true;
}

// After the patterns: all of them are to be seen.
static void make_orbit(Job *job, const FfpCapture *capture) {
    if (job->options->orbit == FFP_ORBIT_NONE) return;
    const FfpView base = *view_of(job, 0);
    job->n_views = job->options->frames > job->n_patterns ? job->options->frames : job->n_patterns;
    job->orbit = ffp_orbit_views(capture, &base, job->options->orbit, job->n_views);
}

static FfpPattern *next_pattern(Job *job) {
    const size_t count = (size_t)job->n_patterns + 1;
    FfpPattern *patterns = realloc(job->patterns, count * sizeof *patterns);
    if (!patterns) abort();
    job->patterns = patterns;
    bool *owned = realloc(job->owned, count * sizeof *owned);
    if (!owned) abort();
    job->owned = owned;
    return &job->patterns[job->n_patterns];
}

static bool add_pattern(Job *job, const FfpCapture *capture, const char *name, FfpError *err) {
    FfpPattern *pattern = next_pattern(job);
    const FfpCamera *projector = &view_of(job, 0)->projector;
    const int known = ffp_capture_find_pattern(capture, name);
    const bool from_file = known < 0;
    if (job->n_patterns == FFP_PATTERNS_MAX)
        return ffp_fail(err, name, "more than %d patterns", FFP_PATTERNS_MAX);
    if (!from_file)
        *pattern = capture->patterns[known];
    else if (!ffp_is_file(name))
        return ffp_fail(err, capture->folder,
                        "%s is neither a pattern of the capture nor an image file or a folder", name);
    else if (!ffp_pattern_read(pattern, name, projector->width, projector->height, err))
        return false;
    job->owned[job->n_patterns++] = from_file;
    for (int p = 0; !is_sequence(job->options) && p + 1 < job->n_patterns; p++)
        if (strcmp(job->patterns[p].name, pattern->name) == 0)
            return ffp_fail(err, name, "two patterns are called %s: their pictures would share a file",
                            pattern->name);
    return true;
}

static int is_picture(const struct dirent *entry) {
    static const char *const endings[] = {".png", ".jpg", ".jpeg", ".exr"};
    const char *dot = strrchr(entry->d_name, '.');
    if (!dot || dot == entry->d_name) return 0;
    for (size_t i = 0; i < sizeof endings / sizeof *endings; i++)
        if (strcasecmp(dot, endings[i]) == 0) return 1;
    return 0;
}

// A folder's pictures in the order of their names.
static bool add_pattern_folder(Job *job, const FfpCapture *capture, const char *folder, FfpError *err) {
    struct dirent **entries;
    const int count = scandir(folder, &entries, is_picture, alphasort);
    bool ok = count > 0 || ffp_fail(err, folder, "holds no pictures");
    for (int i = 0; i < count; i++) {
        char path[FFP_PATH_MAX];
        if (ok && !ffp_join_path(path, folder, entries[i]->d_name))
            ok = ffp_fail(err, folder, "path is too long");
        ok = ok && add_pattern(job, capture, path, err);
        free(entries[i]);
    }
    if (count >= 0) free(entries);
    return ok;
}

static bool choose_patterns(Job *job, const FfpCapture *capture, FfpError *err) {
    const int wanted = job->options->n_patterns;
    if (!wanted) return add_pattern(job, capture, capture->patterns[capture->white].name, err);
    for (int p = 0; p < wanted; p++) {
        const char *name = job->options->patterns[p];
        const bool folder = ffp_capture_find_pattern(capture, name) < 0 && ffp_is_folder(name);
        if (!(folder ? add_pattern_folder : add_pattern)(job, capture, name, err)) return false;
    }
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

static bool write_view(Job *job, FfpViewPass *pass, const FfpGaussians *gaussians, const FfpCapture *capture,
                       const FfpView *view, FfpError *err) {
    ffp_view_pass_draw(pass, gaussians, &view->camera, &view->projector);
    bool ok = true;
    for (int p = 0; ok && p < job->n_patterns; p++) {
        char rest[FFP_NAME_MAX + 8];
        snprintf(rest, sizeof rest, "%s.png", job->patterns[p].name);
        FfpSummed summed = ffp_summed_new(&job->patterns[p].image);
        FfpImage picture = ffp_relight(pass, capture->intensity, &summed);
        ok = write_map(job, view, &picture, rest, err);
        ffp_image_free(&picture);
        ffp_summed_free(&summed);
    }
    return ok && (!job->options->maps || write_maps(job, view, ffp_view_pass_gbuffer(pass), err));
}

// One frame under one pattern, numbered.
static bool write_frame(Job *job, FfpViewPass *pass, const FfpCapture *capture, int pattern,
                        FfpAnimation *animation, FfpError *err) {
    char name[32], path[FFP_PATH_MAX];
    snprintf(name, sizeof name, "%04d.png", job->written);
    FfpSummed summed = ffp_summed_new(&job->patterns[pattern].image);
    FfpImage picture = ffp_relight(pass, capture->intensity, &summed);
    const bool ok = ffp_picture_path(path, sizeof path, job->options->folder, "frame", name, err) &&
                    ffp_image_write_png(&picture, path, err) &&
                    (!job->options->video || ffp_animation_add(animation, &picture, err));
    job->written++;
    ffp_image_free(&picture);
    ffp_summed_free(&summed);
    return ok;
}

// An orbit's frames share the patterns out; else each view is seen under each.
static bool write_sequence(Job *job, FfpViewPass *pass, const FfpGaussians *gaussians,
                           const FfpCapture *capture, FfpError *err) {
    const int each = job->orbit ? 1 : job->n_patterns, frames = job->n_views * each;
    const char *video = job->options->video;
    FfpAnimation animation = {0};
    bool ok = !video || ffp_animation_open(&animation, video, frames, job->options->rate, err);
    FfpProgress progress = ffp_progress("rendering", frames);
    for (int f = 0; ok && f < frames; f++) {
        const FfpView *view = view_of(job, f / each);
        const int pattern = job->orbit ? (int)((int64_t)f * job->n_patterns / frames) : f % job->n_patterns;
        if (f % each == 0) ffp_view_pass_draw(pass, gaussians, &view->camera, &view->projector);
        ok = write_frame(job, pass, capture, pattern, &animation, err);
        ffp_progress_step(&progress, f + 1, NULL);
    }
    ffp_progress_end(&progress);
    if (ok && video) ok = ffp_animation_commit(&animation, err);
    if (video) ffp_animation_abort(&animation);
    return ok;
}

static bool write_views(Job *job, FfpViewPass *pass, const FfpGaussians *gaussians, const FfpCapture *capture,
                        FfpError *err) {
    bool ok = true;
    FfpProgress progress = ffp_progress("rendering", job->n_views);
    for (int v = 0; ok && v < job->n_views; v++) {
        ok = write_view(job, pass, gaussians, capture, view_of(job, v), err);
        ffp_progress_step(&progress, v + 1, NULL);
    }
    ffp_progress_end(&progress);
    return ok;
}

int ffp_render_pictures(const FfpGaussians *gaussians, const FfpCapture *capture, const FfpPictures *options,
                        FfpError *err) {
    Job job = {.options = options};
    bool ok = check_sequence(options, err) && choose_views(&job, capture, err) &&
              choose_patterns(&job, capture, err);
    if (ok) make_orbit(&job, capture);
    ok = ok && check_projectors(&job, err) && ffp_make_folders(options->folder, err);
    if (ok) {
        const FfpRenderSettings settings = ffp_drawing_settings(options->drawing, NULL);
        FfpViewPass *pass = ffp_view_pass_new(&settings);
        ok = (is_sequence(options) ? write_sequence : write_views)(&job, pass, gaussians, capture, err);
        ffp_view_pass_free(pass);
    }
    free_job(&job);
    return ok ? job.written : -1;
}
