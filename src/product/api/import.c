// Photographs and calibrations of other tools into a capture: the public settings as the rig's.
#include "rig/import/import.h"
#include <stdlib.h>
#include <string.h>
#include "core/base/arena.h"
#include "core/base/call.h"
#include "core/base/real.h"
#include "ffprocams.h"
#include "product/api/arguments.h"

FfpImport ffp_import_defaults(void) {
    return (FfpImport){.kept_codes = 8};
}

static FfpPictureSize picture_size(const FfpCalibratedAt *at) {
    static const FfpPictureFit fits[] = {[FFP_FIT_EXACT] = FFP_PICTURES_SAME,
                                         [FFP_FIT_SCALED] = FFP_PICTURES_SCALED,
                                         [FFP_FIT_CROPPED] = FFP_PICTURES_CROPPED};
    return (FfpPictureSize){at->width, at->height, fits[at->fit], at->left, at->top};
}

// The numbers of a turntable; false when there are more angles than it holds.
static bool take_turntable(const FfpImportTurntable *from, FfpTurntable *to, FfpError *err) {
    if (from->n_angles < 0 || from->n_angles > FFP_VIEWS_MAX)
        return ffp_fail(err, FFP_ERROR_ARGUMENT, "turntable.angles", "%d angles: expected at most %d",
                        from->n_angles, FFP_VIEWS_MAX);
    memcpy(to->axis, from->axis, sizeof to->axis);
    memcpy(to->point, from->point, sizeof to->point);
    to->count = from->n_angles;
    for (int i = 0; i < from->n_angles; i++) to->angles[i] = from->angles[i];
    return true;
}

static FfpAxisKnown axis_known(const FfpImportTurntable *turntable) {
    if (!turntable->find_axis) return FFP_AXIS_KNOWN;
    return turntable->guessed ? FFP_AXIS_GUESSED : FFP_AXIS_UNKNOWN;
}

static FfpMaskKind mask_kind(FfpMasks masks) {
    static const FfpMaskKind kinds[] = {[FFP_MASKS_FROM_ALPHA] = FFP_MASKS_ALPHA,
                                        [FFP_MASKS_FROM_LIGHT] = FFP_MASKS_OTSU,
                                        [FFP_MASKS_FROM_FILES] = FFP_MASKS_FILES};
    return kinds[masks];
}

static FfpProjected *take_patterns(const FfpImportPattern *from, int n) {
    FfpProjected *to = ffp_alloc((size_t)n + 1, sizeof *to);
    for (int i = 0; i < n; i++) to[i] = (FfpProjected){from[i].name, from[i].file};
    return to;
}

static FfpShotFiles *take_images(const FfpImportImages *from, int n) {
    FfpShotFiles *to = ffp_alloc((size_t)n + 1, sizeof *to);
    for (int i = 0; i < n; i++) to[i] = (FfpShotFiles){from[i].patterns, from[i].n_patterns, from[i].files};
    return to;
}

// What a caller in C may pass though the type says otherwise.
static bool check_choices(const FfpImport *options, FfpError *err) {
    if ((unsigned)options->masks > FFP_MASKS_FROM_FILES)
        return ffp_fail(err, FFP_ERROR_ARGUMENT, "masks", "invalid value %d", (int)options->masks);
    if ((unsigned)options->camera.fit > FFP_FIT_CROPPED)
        return ffp_fail(err, FFP_ERROR_ARGUMENT, "camera.fit", "invalid value %d", (int)options->camera.fit);
    return (unsigned)options->projector.fit <= FFP_FIT_CROPPED ||
           ffp_fail(err, FFP_ERROR_ARGUMENT, "projector.fit", "invalid value %d",
                    (int)options->projector.fit);
}

// Only images of all that was shown need no names.
static bool check_images(const FfpImportImages *images, int n, const char *what, bool unnamed,
                         FfpError *err) {
    const char *const fields[2][2] = {{"images.files", "images.patterns"}, {"empty.files", "empty.patterns"}};
    const int k = strcmp(what, "empty") == 0;
    bool ok = n <= 0 || ffp_need(images, what, err);
    for (int i = 0; ok && i < n; i++)
        ok = ffp_need(images[i].files, fields[k][0], err) &&
             (unnamed || images[i].n_patterns > 0 || ffp_need(NULL, fields[k][1], err)) &&
             ffp_need_texts(images[i].patterns, images[i].n_patterns, fields[k][1], err);
    return ok;
}

static bool check_texts(const FfpImport *options, FfpError *err) {
    const FfpImportPattern *const patterns[2] = {options->patterns, options->held_out};
    const int n[2] = {options->n_patterns, options->n_held_out};
    bool ok = ffp_need(options->folder, "folder", err) &&
              ffp_need_texts(options->calibrations, options->n_calibrations, "calibrations", err) &&
              ffp_need_texts(options->views, options->n_views, "views", err) &&
              (options->masks != FFP_MASKS_FROM_FILES || ffp_need(options->mask_files, "mask_files", err)) &&
              check_images(options->images, options->n_images, "images", options->shown != NULL, err) &&
              check_images(options->empty, options->n_empty, "empty", false, err);
    for (int k = 0; ok && k < 2; k++) {
        ok = n[k] <= 0 || ffp_need(patterns[k], k ? "held_out" : "patterns", err);
        for (int i = 0; ok && i < n[k]; i++)
            ok = ffp_need(patterns[k][i].name, k ? "held_out.name" : "patterns.name", err) &&
                 ffp_need(patterns[k][i].file, k ? "held_out.file" : "patterns.file", err);
    }
    return ok;
}

static bool import_capture(void *argument, FfpError *err) {
    const FfpImport *options = *(const FfpImport *const *)argument;
    const FfpImportTurntable *turns = &options->turntable;
    if (!check_choices(options, err)) return false;
    FfpImportSettings settings = {.calibrations = options->calibrations,
                                  .n_calibrations = options->n_calibrations,
                                  .projector_image = options->projector_image,
                                  .turntable_file = turns->file,
                                  .axis = axis_known(turns),
                                  .views = options->views,
                                  .n_views = options->n_views,
                                  .camera = picture_size(&options->camera),
                                  .projector = picture_size(&options->projector),
                                  .width = options->width,
                                  .fit_response = options->fit_response,
                                  .linear_images = options->linear_images,
                                  .linear_patterns = options->linear_patterns,
                                  .codes = options->kept_codes,
                                  .exposure = options->exposure,
                                  .scene = options->scene,
                                  .name = options->name,
                                  .folder = options->folder};
    FfpTurntable *turntable = ffp_alloc(1, sizeof *turntable);
    FfpShotFiles *images = take_images(options->images, options->n_images);
    FfpProjected *patterns = take_patterns(options->patterns, options->n_patterns);
    FfpProjected *held_out = take_patterns(options->held_out, options->n_held_out);
    FfpShotFiles *empty = take_images(options->empty, options->n_empty);
    memcpy(settings.object, options->object, sizeof settings.object);
    settings.sources = (FfpShotSources){images,
                                        options->n_images,
                                        patterns,
                                        held_out,
                                        options->n_patterns,
                                        options->n_held_out,
                                        mask_kind(options->masks),
                                        options->mask_files,
                                        options->gray_codes,
                                        options->shown,
                                        empty,
                                        options->n_empty};
    if (turns->n_angles != 0 || turns->find_axis) settings.turntable = turntable; // beside a file: its angles
    const bool ok = take_turntable(turns, turntable, err) && ffp_import(&settings, err);
    ffp_free(turntable);
    ffp_free(images);
    ffp_free(empty);
    ffp_free(patterns);
    ffp_free(held_out);
    return ok;
}

bool ffp_import_capture(FfpContext *context, const FfpImport *options, FfpError *err) {
    if (!ffp_need(options, "options", err) || !check_texts(options, err)) return false;
    return ffp_call_run(context, import_capture, &options, err);
}
