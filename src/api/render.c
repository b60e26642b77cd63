// Rendering to files: chosen views under chosen patterns, and the G-buffers.
#include <dirent.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include "api/arguments.h"
#include "base/arena.h"
#include "base/call.h"
#include "base/file.h"
#include "base/log.h"
#include "api/relight.h"
#include "api/video.h"
#include "apply/choose.h"

#define ORBIT_FRAMES_MAX 9999 // as many as a name's four digits count

FfpPictures ffp_pictures_defaults(void) {
    return (FfpPictures){.rate = 15};
}

// What a call works with: views and patterns borrowed from the capture or the poses file, or read for it.
typedef struct Job {
    const FfpPictures *options;
    FfpCapture poses; // only when the options name a file
    bool has_poses;
    const FfpCapture *capture; // the caller's, or the poses where there is none
    FfpView *own;              // [n_views] of an orbit or of another size; NULL: the source's
    int n_views, n_patterns;
    real intensity[3];
    const FfpCapture *source; // of the views: the capture or the poses
    const FfpView **views;    // [n_views] those chosen
    FfpPattern *patterns;     // images are owned when `owned`
    bool *owned;
    int written;
} Job;

static const FfpView *view_of(const Job *job, int v) {
    return job->own ? &job->own[v] : job->views[v];
}

// Whether pictures are frames with numbers, in place of names.
static bool is_sequence(const FfpPictures *options) {
    return options->orbit != FFP_ORBIT_NONE || options->video;
}

static void free_job(Job *job) {
    for (int p = 0; p < job->n_patterns; p++)
        if (job->owned[p]) ffp_image_free(&job->patterns[p].image);
    ffp_free(job->patterns);
    ffp_free(job->owned);
    ffp_free(job->views);
    ffp_free(job->own);
    if (job->has_poses) ffp_capture_free(&job->poses);
}

// The size of the first pattern that is an image file; 0 when none is.
static bool size_of_patterns(const FfpPictures *options, int *width, int *height, FfpError *err) {
    *width = *height = 0;
    for (int p = 0; p < options->n_patterns; p++)
        if (ffp_is_file(options->patterns[p]))
            return ffp_image_read_size(width, height, options->patterns[p], err);
    return true;
}

// Where devices and patterns come from.
static bool open_sources(Job *job, const FfpCapture *capture, FfpError *err) {
    const FfpPictures *options = job->options;
    int width, height;
    job->capture = job->source = capture;
    if (!options->poses)
        return capture || ffp_fail(err, FFP_ERROR_ARGUMENT, "poses", "there are neither a capture nor poses");
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

static bool settle_intensity(Job *job, FfpError *err) {
    const double *given = job->options->intensity;
    const bool none = given[0] == 0 && given[1] == 0 && given[2] == 0;
    for (int c = 0; c < 3; c++) {
        job->intensity[c] = none ? job->capture->intensity[c] : (real)given[c];
        if (!none && !(given[c] >= 0 && given[c] < 1e18))
            return ffp_fail(err, FFP_ERROR_ARGUMENT, "intensity", "%g is no radiant intensity", given[c]);
    }
    if (none && job->capture == &job->poses && !job->poses.intensity_known)
        return ffp_fail(err, FFP_ERROR_ARGUMENT, job->options->poses,
                        "says no intensity of the projector: give it, or the capture");
    return true;
}

static bool choose_views(Job *job, FfpError *err) {
    const FfpPictures *options = job->options;
    job->n_views = options->n_views ? options->n_views : job->source->n_views;
    job->views = ffp_alloc((size_t)job->n_views, sizeof *job->views);
    return ffp_choose_among(job->views, job->source, options->views, options->n_views, is_sequence(options),
                            options->poses ? options->poses : job->capture->folder, err);
}

static bool check_sequence(const FfpPictures *options, FfpError *err) {
    if (!is_sequence(options)) return true;
    if (options->maps)
        return ffp_fail(err, FFP_ERROR_ARGUMENT, options->folder, "frames of a sequence come without maps");
    if (options->video &&
        !(ffp_animation_check(options->video, err) && ffp_output_probe(options->video, err)))
        return false;
    if (options->video && (options->rate < 1 || options->rate > 1000))
        return ffp_fail(err, FFP_ERROR_ARGUMENT, options->video, "%d frames a second: 1 to 1000 are possible",
                        options->rate);
    if (options->orbit == FFP_ORBIT_NONE) return true;
    if (options->n_views > 1)
        return ffp_fail(err, FFP_ERROR_ARGUMENT, options->folder, "an orbit starts from one view");
    if (options->frames < 1 || options->frames > ORBIT_FRAMES_MAX)
        return ffp_fail(err, FFP_ERROR_ARGUMENT, options->folder,
                        "an orbit of %d frames: 1 to %d are possible", options->frames, ORBIT_FRAMES_MAX);
    return true;
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
static void make_orbit(Job *job, const FfpGaussians *gaussians) {
    if (job->options->orbit == FFP_ORBIT_NONE) return;
    const FfpView base = *view_of(job, 0);
    if (job->capture == &job->poses) find_centre(&job->poses, gaussians);
    job->n_views = job->options->frames > job->n_patterns ? job->options->frames : job->n_patterns;
    job->own = ffp_orbit_views(job->capture, &base, job->options->orbit, job->n_views);
}

static bool resize_camera(FfpCamera *camera, int width, int height, FfpError *err) {
    const double scale = (double)width / camera->width, natural = camera->height * scale;
    const double rows = height > 0 ? height : fmax(1, round(natural));
    if (!(rows <= FFP_IMAGE_SIDE_MAX))
        return ffp_fail(err, FFP_ERROR_ARGUMENT, "height", "%.0f is more than %d", rows, FFP_IMAGE_SIDE_MAX);
    camera->fx *= (real)scale, camera->fy *= (real)scale, camera->cx *= (real)scale;
    camera->cy *= (real)(height > 0 ? rows / camera->height : scale);
    camera->width = width, camera->height = (int)rows;
    return true;
}

static bool resize_views(Job *job, FfpError *err) {
    const int width = job->options->width, height = job->options->height;
    if (width == 0 && height == 0) return true;
    if (width < 1 || width > FFP_IMAGE_SIDE_MAX || height < 0 || height > FFP_IMAGE_SIDE_MAX)
        return ffp_fail(err, FFP_ERROR_ARGUMENT, "width", "pictures of %d x %d pixels: 1 to %d a side", width,
                        height, FFP_IMAGE_SIDE_MAX);
    if (!job->own) {
        FfpView *own = ffp_alloc((size_t)job->n_views, sizeof *own);
        for (int v = 0; v < job->n_views; v++) own[v] = *view_of(job, v);
        job->own = own;
    }
    for (int v = 0; v < job->n_views; v++)
        if (!resize_camera(&job->own[v].camera, width, height, err)) return false;
    return true;
}

static FfpPattern *next_pattern(Job *job) {
    const size_t count = (size_t)job->n_patterns + 1;
    job->patterns = ffp_grow(job->patterns, count, sizeof *job->patterns);
    job->owned = ffp_grow(job->owned, count, sizeof *job->owned);
    return &job->patterns[job->n_patterns];
}

static bool add_pattern(Job *job, const char *name, FfpError *err) {
    const FfpCapture *capture = job->capture;
    FfpPattern *pattern = next_pattern(job);
    const FfpCamera *projector = &view_of(job, 0)->projector;
    const int known = ffp_capture_find_pattern(capture, name);
    const bool from_file = known < 0;
    if (job->n_patterns == FFP_PATTERNS_MAX)
        return ffp_fail(err, FFP_ERROR_ARGUMENT, name, "more than %d patterns", FFP_PATTERNS_MAX);
    if (!from_file && !capture->patterns[known].image.data)
        return ffp_fail(err, FFP_ERROR_FILE, job->options->poses, "the file of pattern %.96s is not there",
                        name);
    if (!from_file)
        *pattern = capture->patterns[known];
    else if (!ffp_is_file(name))
        return ffp_fail(
            err, FFP_ERROR_ARGUMENT, capture->folder,
            "%.256s is neither an image file, nor a folder, nor a pattern of the capture, which are %s", name,
            ffp_list_patterns(capture).text);
    else if (!ffp_pattern_read(pattern, name, projector->width, projector->height, err))
        return false;
    job->owned[job->n_patterns++] = from_file;
    for (int p = 0; !is_sequence(job->options) && p + 1 < job->n_patterns; p++)
        if (strcmp(job->patterns[p].name, pattern->name) == 0)
            return ffp_fail(err, FFP_ERROR_ARGUMENT, name,
                            "two patterns are called %s: their pictures would share a file", pattern->name);
    return true;
}

static int is_picture(const struct dirent *entry) {
    return ffp_image_has_ending(entry->d_name);
}

typedef struct Listing {
    struct dirent **entries; // of scandir
    int count;
} Listing;

static void free_listing(void *thing) {
    Listing *listing = thing;
    for (int i = 0; i < listing->count; i++) free(listing->entries[i]);
    free(listing->entries);
    ffp_free(listing);
}

// A folder's pictures in the order of their names.
static bool add_pattern_folder(Job *job, const char *folder, FfpError *err) {
    Listing *listing = ffp_alloc(1, sizeof *listing);
    ffp_own(listing, free_listing);
    listing->count = scandir(folder, &listing->entries, is_picture, alphasort);
    bool ok = listing->count > 0 || ffp_fail(err, FFP_ERROR_ARGUMENT, folder, "holds no pictures");
    for (int i = 0; ok && i < listing->count; i++) {
        char path[FFP_PATH_MAX];
        if (!ffp_join_path(path, folder, listing->entries[i]->d_name))
            ok = ffp_fail(err, FFP_ERROR_ARGUMENT, folder, "path is too long");
        ok = ok && add_pattern(job, path, err);
    }
    ffp_disown(listing);
    free_listing(listing);
    return ok;
}

static bool choose_patterns(Job *job, FfpError *err) {
    const FfpCapture *capture = job->capture;
    const int wanted = job->options->n_patterns;
    if (!wanted) return add_pattern(job, capture->patterns[capture->white].name, err);
    for (int p = 0; p < wanted; p++) {
        const char *name = job->options->patterns[p];
        const bool folder = ffp_capture_find_pattern(capture, name) < 0 && ffp_is_folder(name);
        if (!(folder ? add_pattern_folder : add_pattern)(job, name, err)) return false;
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
                return ffp_fail(err, FFP_ERROR_ARGUMENT, job->patterns[p].name,
                                "a pattern of %d x %d does not fit view %s's projector of %d x %d",
                                image->width, image->height, view_of(job, v)->id, projector->width,
                                projector->height);
        }
    return true;
}

// --- Files. ---

typedef struct FileName {
    char text[2 * FFP_NAME_MAX + 16];
} FileName;

static bool name_file(FileName *name, const Job *job, const FfpView *view, const char *rest,
                      const char *ending, FfpError *err) {
    char path[FFP_PATH_MAX], whole[FFP_NAME_MAX + 16];
    snprintf(whole, sizeof whole, "%s%s", rest, ending);
    snprintf(name->text, sizeof name->text, "%s_%s", view->id, whole);
    return ffp_picture_path(path, sizeof path, job->options->folder, view->id, whole, err);
}

static int by_name(const void *a, const void *b) {
    return strcmp(((const FileName *)a)->text, ((const FileName *)b)->text);
}

// Before the work: that every file has a name, and one of its own. Views and patterns may be called what they
// like.
static bool check_names(const Job *job, FfpError *err) {
    if (is_sequence(job->options)) return true;
    const int each = job->n_patterns + (job->options->maps ? FFP_MAP_COUNT + 1 : 0);
    FileName *names = ffp_alloc((size_t)job->n_views * (size_t)each, sizeof *names), *next = names;
    bool ok = true;
    for (int v = 0; ok && v < job->n_views; v++) {
        const FfpView *view = view_of(job, v);
        for (int p = 0; ok && p < job->n_patterns; p++)
            ok = name_file(next++, job, view, job->patterns[p].name, ".png", err);
        if (!job->options->maps) continue;
        for (int m = 0; ok && m < FFP_MAP_COUNT; m++)
            ok = name_file(next++, job, view, ffp_map_name((FfpMap)m), ".png", err);
        ok = ok && name_file(next++, job, view, "depth", ".exr", err);
    }
    const size_t count = (size_t)(next - names);
    if (ok) qsort(names, count, sizeof *names, by_name);
    for (size_t i = 1; ok && i < count; i++)
        if (by_name(&names[i - 1], &names[i]) == 0)
            ok = ffp_fail(err, FFP_ERROR_ARGUMENT, job->options->folder, "two pictures would be called %s",
                          names[i].text);
    ffp_free(names);
    return ok;
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

static bool write_view(Job *job, FfpViewPass *pass, const FfpGaussians *gaussians, const FfpView *view,
                       FfpError *err) {
    ffp_view_pass_draw(pass, gaussians, &view->camera, &view->projector);
    bool ok = true;
    for (int p = 0; ok && p < job->n_patterns; p++) {
        char rest[FFP_NAME_MAX + 8];
        snprintf(rest, sizeof rest, "%s.png", job->patterns[p].name);
        FfpSummed summed = ffp_summed_new(&job->patterns[p].image);
        FfpImage picture = ffp_relight(pass, job->intensity, &summed);
        ok = write_map(job, view, &picture, rest, err);
        ffp_image_free(&picture);
        ffp_summed_free(&summed);
    }
    return ok && (!job->options->maps || write_maps(job, view, ffp_view_pass_gbuffer(pass), err));
}

// One frame under one pattern, numbered.
static bool write_frame(Job *job, FfpViewPass *pass, int pattern, FfpAnimation *animation, FfpError *err) {
    char name[32], path[FFP_PATH_MAX];
    snprintf(name, sizeof name, "%04d.png", job->written);
    FfpSummed summed = ffp_summed_new(&job->patterns[pattern].image);
    FfpImage picture = ffp_relight(pass, job->intensity, &summed);
    const bool ok = ffp_picture_path(path, sizeof path, job->options->folder, "frame", name, err) &&
                    ffp_image_write_png(&picture, path, err) &&
                    (!job->options->video || ffp_animation_add(animation, &picture, err));
    job->written++;
    ffp_image_free(&picture);
    ffp_summed_free(&summed);
    return ok;
}

// An orbit's frames share the patterns out; else each view is seen under each.
static bool write_sequence(Job *job, FfpViewPass *pass, const FfpGaussians *gaussians, FfpError *err) {
    const bool orbit = job->options->orbit != FFP_ORBIT_NONE;
    const int each = orbit ? 1 : job->n_patterns, frames = job->n_views * each;
    const char *video = job->options->video;
    FfpAnimation animation = {0};
    bool ok = !video || ffp_animation_open(&animation, video, frames, job->options->rate, err);
    FfpTask progress = ffp_task("rendering", frames);
    for (int f = 0; ok && f < frames; f++) {
        const FfpView *view = view_of(job, f / each);
        const int pattern = orbit ? (int)((int64_t)f * job->n_patterns / frames) : f % job->n_patterns;
        if (f % each == 0) ffp_view_pass_draw(pass, gaussians, &view->camera, &view->projector);
        ok = write_frame(job, pass, pattern, &animation, err);
        ffp_task_step(&progress, f + 1, NULL);
    }
    ffp_task_end(&progress);
    if (ok && video) ok = ffp_animation_commit(&animation, err);
    if (video) ffp_animation_abort(&animation);
    return ok;
}

static bool write_views(Job *job, FfpViewPass *pass, const FfpGaussians *gaussians, FfpError *err) {
    bool ok = true;
    FfpTask progress = ffp_task("rendering", job->n_views);
    for (int v = 0; ok && v < job->n_views; v++) {
        ok = write_view(job, pass, gaussians, view_of(job, v), err);
        ffp_task_step(&progress, v + 1, NULL);
    }
    ffp_task_end(&progress);
    return ok;
}

static int render(const FfpGaussians *gaussians, const FfpCapture *capture, const FfpPictures *options,
                  FfpError *err) {
    Job job = {.options = options};
    bool ok = check_sequence(options, err) && open_sources(&job, capture, err) &&
              settle_intensity(&job, err) && choose_views(&job, err) && choose_patterns(&job, err);
    if (ok) make_orbit(&job, gaussians);
    ok = ok && resize_views(&job, err) && check_projectors(&job, err) && check_names(&job, err) &&
         ffp_make_folders(options->folder, err);
    if (ok) {
        const FfpRenderSettings settings = ffp_drawing_settings(options->drawing, NULL);
        FfpViewPass *pass = ffp_view_pass_new(&settings);
        ok = (is_sequence(options) ? write_sequence : write_views)(&job, pass, gaussians, err);
        ffp_view_pass_free(pass);
    }
    free_job(&job);
    return ok ? job.written : -1;
}

typedef struct Call {
    const FfpGaussians *gaussians;
    const FfpCapture *capture;
    const FfpPictures *options;
    int written;
} Call;

static bool work(void *argument, FfpError *err) {
    Call *call = argument;
    call->written = render(call->gaussians, call->capture, call->options, err);
    return call->written >= 0;
}

int ffp_render_pictures(FfpContext *context, const FfpGaussians *gaussians, const FfpCapture *capture,
                        const FfpPictures *options, FfpError *err) {
    Call call = {gaussians, capture, options, 0};
    if (!ffp_need(gaussians, "gaussians", err) || !ffp_need(options, "options", err) ||
        !ffp_need(options->folder, "folder", err) ||
        !ffp_need_texts(options->views, options->n_views, "views", err) ||
        !ffp_need_texts(options->patterns, options->n_patterns, "patterns", err) ||
        !ffp_check_drawing(options->drawing, err))
        return -1;
    return ffp_call_run(context, work, &call, err) ? call.written : -1;
}
