// Rendering to files: chosen views under chosen patterns, and the G-buffers.
#include "engine/pipeline/pictures.h"
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include "core/base/alloc.h"
#include "core/base/file.h"
#include "core/base/integer.h"
#include "core/base/log.h"
#include "core/base/memory.h"
#include "core/image/film.h"
#include "engine/pipeline/maps.h"
#include "engine/pipeline/need.h"
#include "engine/pipeline/picture_job.h"
#include "engine/pipeline/relight.h"
#include "engine/render/outline.h"
#include "engine/render/strip.h"

// --- What the files are called. ---

typedef struct FileName {
    char text[2 * FFP_NAME_MAX + 16];
} FileName;

static bool name_file(FileName *name, const FfpPictureJob *job, const FfpView *view, const char *rest,
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
static bool check_names(const FfpPictureJob *job, FfpError *err) {
    if (ffp_is_sequence(job->options)) return true;
    const int each = job->n_patterns + (job->options->maps ? FFP_MAP_PICTURES + 1 : 0);
    FileName *names = ffp_alloc((size_t)job->n_views * (size_t)each, sizeof *names), *next = names;
    bool ok = true;
    for (int v = 0; ok && v < job->n_views; v++) {
        const FfpView *view = ffp_picture_view(job, v);
        for (int p = 0; ok && p < job->n_patterns; p++)
            ok = name_file(next++, job, view, job->patterns[p].name, ".png", err);
        if (!job->options->maps) continue;
        for (int m = 0; ok && m < FFP_MAP_PICTURES; m++)
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

// --- Writing them. ---

enum { TOGETHER = 8 }; // patterns at most, under which a large view is drawn at once
#define FILMED 15.0    // bytes of a pixel that becomes a film's: in floats, and encoded

typedef struct Writer {
    const FfpPictureJob *job;
    const FfpGaussians *gaussians;
    FfpViewPass *pass;
    int written;
    const FfpView *drawn; // last; and of a large one
    int first;            // the pictures under the patterns from here on, [height, width, 3]:
    unsigned char *pictures[TOGETHER];
} Writer;

static bool write_picture(Writer *writer, const FfpView *view, const FfpImage *picture, const char *rest,
                          FfpError *err) {
    char path[FFP_PATH_MAX];
    if (!ffp_picture_path(path, sizeof path, writer->job->options->folder, view->id, rest, err)) return false;
    writer->written++;
    return strstr(rest, ".exr") ? ffp_image_write_exr(picture, path, err)
                                : ffp_image_write_png(picture, path, err);
}

static bool write_maps(Writer *writer, const FfpView *view, FfpError *err) {
    const FfpGbuffer *gbuffer = ffp_view_pass_gbuffer(writer->pass);
    FfpImage depth = ffp_map_depth(gbuffer);
    bool ok = write_picture(writer, view, &depth, "depth.exr", err);
    ffp_image_free(&depth);
    for (int m = 0; ok && m < FFP_MAP_PICTURES; m++) {
        char rest[32];
        snprintf(rest, sizeof rest, "%s.png", ffp_map_name((FfpMap)m));
        FfpImage picture = ffp_map_picture(gbuffer, (FfpMap)m);
        ok = write_picture(writer, view, &picture, rest, err);
        ffp_image_free(&picture);
    }
    return ok;
}

// The view drawn last, under a pattern.
static FfpImage relit(const Writer *writer, int pattern) {
    FfpSummed summed = ffp_summed_new(&writer->job->patterns[pattern].image);
    FfpImage picture = ffp_relight(writer->pass, writer->job->intensity, &summed);
    ffp_summed_free(&summed);
    return picture;
}

// --- In strips. ---

static bool is_in_strips(const FfpPictureJob *job, const FfpView *view) {
    return ffp_strip_rows(&view->camera) < view->camera.height && !job->options->maps;
}

// Rows that a view's outlines need above and below a strip.
static int margin_of(const Writer *writer, const FfpView *view) {
    const FfpRenderSettings settings = ffp_showing_settings(writer->job->options->drawing);
    const bool smooth = settings.smooth && settings.samples > 1 &&
                        ffp_outline_deviation(writer->gaussians, &view->camera) > 0;
    return smooth ? FFP_STRIP_MARGIN : 0;
}

static double picture_bytes(const Writer *writer, const FfpView *view, int samples, int pictures) {
    const int rows = is_in_strips(writer->job, view) ? ffp_strip_rows(&view->camera) : view->camera.height;
    const double film = writer->job->options->video ? FILMED * view->camera.width * view->camera.height : 0;
    return film + ffp_pictures_bytes((double)writer->gaussians->count, &view->camera, samples, rows,
                                     margin_of(writer, view), pictures);
}

// How many patterns from `first` on a large view is drawn under together: in an orbit it has one of them.
static int count_together(const Writer *writer, const FfpView *view, int first) {
    const FfpPictureJob *job = writer->job;
    const int samples = ffp_drawing_settings(job->options->drawing, NULL).samples;
    FfpError none;
    int count = job->options->orbit != FFP_ORBIT_NONE ? 1 : ffp_smaller(TOGETHER, job->n_patterns - first);
    while (count > 1 && !ffp_memory_suffices(picture_bytes(writer, view, samples, count), "", "", "", &none))
        count--;
    return count;
}

// All rows of a view under `count` patterns, in bytes: the picture of relit.
static void draw_strips(Writer *writer, const FfpView *view, int first) {
    const FfpCamera *whole = &view->camera;
    const int rows = ffp_strip_rows(whole), count = count_together(writer, view, first);
    const int margin = margin_of(writer, view);
    const size_t row = 3 * (size_t)whole->width;
    FfpGbuffer shadow = {0};
    for (int p = 0; p < count; p++) {
        ffp_free(writer->pictures[p]);
        writer->pictures[p] = ffp_alloc(row * (size_t)whole->height, 1);
    }
    ffp_view_pass_keep_shadow(writer->pass, &shadow);
    for (int top = 0; top < whole->height; top += rows) {
        const int above = ffp_smaller(top, margin), kept = ffp_smaller(rows, whole->height - top);
        const FfpCamera strip = ffp_strip_of(whole, top - above, above + kept + margin);
        ffp_view_pass_draw(writer->pass, writer->gaussians, &strip, &view->projector);
        for (int p = 0; p < count; p++) {
            FfpImage part = relit(writer, first + p);
            const real *from = part.data + (size_t)above * row;
            unsigned char *to = writer->pictures[p] + (size_t)top * row;
            for (size_t i = 0; i < (size_t)kept * row; i++) to[i] = (unsigned char)(from[i] * 255 + 0.5F);
            ffp_image_free(&part);
        }
    }
    ffp_view_pass_keep_shadow(writer->pass, NULL);
    ffp_gbuffer_free(&shadow);
    writer->first = first;
}

typedef struct Bytes {
    const unsigned char *data;
    size_t row;
} Bytes;

static void row_of_bytes(void *context, int y, real *row) {
    const Bytes *bytes = context;
    for (size_t i = 0; i < bytes->row; i++) row[i] = bytes->data[(size_t)y * bytes->row + i] / (real)255;
}

static bool write_bytes(const FfpCamera *camera, const unsigned char *data, const char *path, FfpFilm *film,
                        FfpError *err) {
    Bytes bytes = {data, 3 * (size_t)camera->width};
    const FfpRows rows = {camera->width, camera->height, 3, row_of_bytes, &bytes};
    if (!ffp_image_write_png_rows(&rows, 8, path, err)) return false;
    if (!film) return true;
    FfpImage picture = ffp_image_new(camera->width, camera->height, 3);
    for (int y = 0; y < camera->height; y++) row_of_bytes(&bytes, y, picture.data + (size_t)y * bytes.row);
    const bool ok = ffp_film_add(film, &picture, err);
    ffp_image_free(&picture);
    return ok;
}

// A view under a pattern, drawn if the last one was another; into a film, too, unless that is NULL.
static bool write_drawn(Writer *writer, const FfpView *view, int pattern, const char *path, FfpFilm *film,
                        FfpError *err) {
    const bool strips = is_in_strips(writer->job, view), other = writer->drawn != view;
    writer->drawn = view;
    writer->written++;
    if (!strips) {
        if (other) ffp_view_pass_draw(writer->pass, writer->gaussians, &view->camera, &view->projector);
        FfpImage picture = relit(writer, pattern);
        const bool ok =
            ffp_image_write_png(&picture, path, err) && (!film || ffp_film_add(film, &picture, err));
        ffp_image_free(&picture);
        return ok;
    }
    if (other || pattern < writer->first || pattern >= writer->first + TOGETHER ||
        !writer->pictures[pattern - writer->first])
        draw_strips(writer, view, pattern);
    unsigned char **held = &writer->pictures[pattern - writer->first];
    const bool ok = write_bytes(&view->camera, *held, path, film, err);
    ffp_free(*held);
    *held = NULL;
    return ok;
}

// Before the work: that the largest picture fits into memory.
static bool check_memory(const Writer *writer, int samples, FfpError *err) {
    double most = 0;
    for (int v = 0; v < writer->job->n_views; v++)
        most = fmax(most, picture_bytes(writer, ffp_picture_view(writer->job, v), samples, 1));
    return ffp_memory_suffices(most, "pictures of this size", "make them smaller", "width", err);
}

static bool write_view(Writer *writer, const FfpView *view, FfpError *err) {
    const FfpPictureJob *job = writer->job;
    bool ok = true;
    for (int p = 0; ok && p < job->n_patterns; p++) {
        char rest[FFP_NAME_MAX + 8], path[FFP_PATH_MAX];
        snprintf(rest, sizeof rest, "%s.png", job->patterns[p].name);
        ok = ffp_picture_path(path, sizeof path, job->options->folder, view->id, rest, err) &&
             write_drawn(writer, view, p, path, NULL, err);
    }
    return ok && (!job->options->maps || write_maps(writer, view, err));
}

// One frame under one pattern, numbered.
static bool write_frame(Writer *writer, const FfpView *view, int pattern, FfpFilm *film, FfpError *err) {
    const FfpPictures *options = writer->job->options;
    char name[32], path[FFP_PATH_MAX];
    snprintf(name, sizeof name, "%04d.png", writer->written);
    return ffp_picture_path(path, sizeof path, options->folder, "frame", name, err) &&
           write_drawn(writer, view, pattern, path, options->video ? film : NULL, err);
}

// The frames of an orbit are divided among the patterns; without an orbit, each view is drawn under each.
static bool write_sequence(Writer *writer, FfpError *err) {
    const FfpPictureJob *job = writer->job;
    const bool orbit = job->options->orbit != FFP_ORBIT_NONE;
    const int each = orbit ? 1 : job->n_patterns, frames = job->n_views * each;
    const char *video = job->options->video;
    FfpFilm film = {0};
    bool ok = !video || ffp_film_open(&film, video, frames, job->options->rate, err);
    FfpTask progress = ffp_task("rendering", frames);
    for (int f = 0; ok && f < frames; f++) {
        const int pattern = orbit ? (int)((int64_t)f * job->n_patterns / frames) : f % job->n_patterns;
        ok = write_frame(writer, ffp_picture_view(job, f / each), pattern, &film, err);
        ffp_task_step(&progress, f + 1, NULL);
    }
    ffp_task_end(&progress);
    if (ok && video) ok = ffp_film_commit(&film, err);
    if (video) ffp_film_abort(&film);
    return ok;
}

static bool write_views(Writer *writer, FfpError *err) {
    const FfpPictureJob *job = writer->job;
    bool ok = true;
    FfpTask progress = ffp_task("rendering", job->n_views);
    for (int v = 0; ok && v < job->n_views; v++) {
        ok = write_view(writer, ffp_picture_view(job, v), err);
        ffp_task_step(&progress, v + 1, NULL);
    }
    ffp_task_end(&progress);
    return ok;
}

// A folder whose pictures are being written says so until the last one is written, whatever ends the work.
#define MARK "INCOMPLETE"

static bool mark_folder(char path[FFP_PATH_MAX], const char *folder, FfpError *err) {
    static const char text[] = "The pictures in this folder are being written, or the work was stopped.\n";
    return ffp_make_folders(folder, err) &&
           (ffp_join_path(path, folder, MARK) ||
            ffp_fail(err, FFP_ERROR_ARGUMENT, folder, "the path is too long")) &&
           ffp_write_file(path, text, sizeof text - 1, err);
}

int ffp_pictures_run(const FfpGaussians *gaussians, const FfpCapture *capture, const FfpPictures *options,
                     FfpError *err) {
    FfpPictureJob job;
    Writer writer = {.job = &job, .gaussians = gaussians};
    char mark[FFP_PATH_MAX];
    const FfpRenderSettings settings = ffp_showing_settings(options->drawing);
    bool ok = ffp_picture_job_new(&job, gaussians, capture, options, err) && check_names(&job, err) &&
              check_memory(&writer, settings.samples, err) && mark_folder(mark, options->folder, err);
    if (ok) {
        writer.pass = ffp_view_pass_new(&settings);
        ok = (ffp_is_sequence(options) ? write_sequence : write_views)(&writer, err);
        ffp_view_pass_free(writer.pass);
        for (int p = 0; p < TOGETHER; p++) ffp_free(writer.pictures[p]);
        if (ok) remove(mark);
    }
    ffp_picture_job_free(&job);
    return ok ? writer.written : -1;
}
