// A capture from the caller's memory, and what a capture holds. The manifest that the readers of JSON fill in
// is filled in here from numbers and pointers; everything after it is the same.
#include <stdlib.h>
#include <string.h>
#include "core/base/arena.h"
#include "core/base/call.h"
#include "core/base/real.h"
#include "core/capture/manifest.h"
#include "product/api/arguments.h"
#include "product/api/memory.h"

// The texts that the manifest points to as long as it lives.
typedef struct Sources {
    FfpManifest manifest;
    FfpArena *arena;
} Sources;

static FfpSource source_of(Sources *s, const FfpPicture *picture, const char *format, const char *id,
                           const char *name) {
    if (!picture->data) return (FfpSource){0};
    char text[3 * FFP_NAME_MAX];
    snprintf(text, sizeof text, format, id, name);
    FfpRaw *raw = ffp_arena_alloc(s->arena, 1, sizeof *raw);
    *raw = ffp_raw_of(picture);
    return (FfpSource){.path = ffp_arena_text(s->arena, text), .raw = raw};
}

static bool take_name(char out[FFP_NAME_MAX], const char *name, const char *what, int index, FfpError *err) {
    char where[64];
    snprintf(where, sizeof where, "%s[%d]", what, index);
    if (!name || !ffp_is_name(name))
        return ffp_fail(err, FFP_ERROR_ARGUMENT, where,
                        "invalid name '%.100s': expected 1 to %d bytes of UTF-8 without '/' and '\\'",
                        name ? name : "", FFP_NAME_MAX - 1);
    memcpy(out, name, strlen(name) + 1);
    return true;
}

static bool take_patterns(Sources *s, const FfpCaptureData *data, FfpError *err) {
    FfpCapture *capture = s->manifest.capture;
    if (data->n_patterns < 2 || data->n_patterns > FFP_PATTERNS_MAX)
        return ffp_fail(err, FFP_ERROR_ARGUMENT, "patterns", "%d patterns are not in 2 to %d",
                        data->n_patterns, FFP_PATTERNS_MAX);
    if (data->black < 0 || data->white < 0 || data->black >= data->n_patterns ||
        data->white >= data->n_patterns || data->black == data->white)
        return ffp_fail(err, FFP_ERROR_ARGUMENT, "patterns",
                        "black %d and white %d are not two different patterns of %d", data->black,
                        data->white, data->n_patterns);
    capture->black = data->black;
    capture->white = data->white;
    for (int i = 0; i < data->n_patterns; i++) {
        FfpPattern *pattern = &capture->patterns[i];
        if (!take_name(pattern->name, data->patterns[i].name, "patterns", i, err)) return false;
        if (ffp_capture_find_pattern(capture, pattern->name) >= 0)
            return ffp_fail(err, FFP_ERROR_ARGUMENT, "patterns", "duplicate pattern '%s'", pattern->name);
        capture->n_patterns++;
        const bool plain = i == data->black || i == data->white;
        pattern->novel = data->patterns[i].held_out && !plain;
        s->manifest.patterns[i] = source_of(s, &data->patterns[i].picture, "pattern %s%s", pattern->name, "");
        if (!plain && !s->manifest.patterns[i].path)
            return ffp_fail(err, FFP_ERROR_ARGUMENT, pattern->name, "the pattern has no picture");
    }
    return true;
}

static bool take_view(Sources *s, const FfpCaptureData *data, int index, FfpError *err) {
    const FfpViewData *from = &data->views[index];
    FfpCapture *capture = s->manifest.capture;
    FfpView *view = &capture->views[index];
    FfpViewFiles *files = &s->manifest.views[index];
    char where[FFP_NAME_MAX + 32];
    if (!take_name(view->id, from->id, "views", index, err)) return false;
    snprintf(where, sizeof where, "view %s: photographs", view->id);
    if (!ffp_need(from->photographs, where, err)) return false;
    for (int i = 0; i < index; i++)
        if (strcmp(capture->views[i].id, view->id) == 0)
            return ffp_fail(err, FFP_ERROR_ARGUMENT, "views", "duplicate view '%s'", view->id);
    snprintf(where, sizeof where, "view %s: camera", view->id);
    if (!ffp_camera_of(&view->camera, &from->camera, FFP_CAMERA_SIDE_MIN, where, err)) return false;
    snprintf(where, sizeof where, "view %s: projector", view->id);
    if (!ffp_camera_of(&view->projector, &from->projector, FFP_PATTERN_SIDE_MIN, where, err)) return false;
    if (view->projector.width != capture->views[0].projector.width ||
        view->projector.height != capture->views[0].projector.height)
        return ffp_fail(err, FFP_ERROR_ARGUMENT, where, "all projectors must have the same size");
    for (int i = 0; i < data->n_patterns; i++)
        files->images[i] = source_of(s, &from->photographs[i], "view %s: photograph under %s", view->id,
                                     capture->patterns[i].name);
    files->coverage = source_of(s, &from->mask, "view %s: %s", view->id, "mask");
    files->coverage.applied = from->masked;
    snprintf(where, sizeof where, "view %s: correspondence", view->id);
    if (from->correspondence.data &&
        (from->correspondence.type != FFP_PIXELS_F32 || from->correspondence.channels != 3))
        return ffp_fail(err, FFP_ERROR_ARGUMENT, where, "expected three channels of FFP_PIXELS_F32");
    files->correspondence = source_of(s, &from->correspondence, "view %s: %s", view->id, "correspondence");
    files->depth = source_of(s, &from->depth, "view %s: %s", view->id, "depth");
    return true;
}

static bool take_numbers(FfpCapture *capture, FfpManifest *manifest, const FfpCaptureData *data,
                         FfpError *err) {
    capture->intensity_known = data->intensity[0] != 0 || data->intensity[1] != 0 || data->intensity[2] != 0;
    manifest->has_bounds = data->radius != 0;
    for (int i = 0; i < 3; i++) {
        if (capture->intensity_known && !(data->intensity[i] >= 1e-12 && data->intensity[i] <= 1e18))
            return ffp_fail(err, FFP_ERROR_ARGUMENT, "intensity", "%g is out of range", data->intensity[i]);
        if (!(data->centre[i] >= -FFP_LENGTH_MAX && data->centre[i] <= FFP_LENGTH_MAX))
            return ffp_fail(err, FFP_ERROR_ARGUMENT, "centre", "%g is out of range", data->centre[i]);
        capture->intensity[i] = (real)data->intensity[i];
        capture->centre[i] = (real)data->centre[i];
    }
    if (manifest->has_bounds && !(data->radius >= 1e-9 && data->radius <= FFP_LENGTH_MAX))
        return ffp_fail(err, FFP_ERROR_ARGUMENT, "radius", "%g is out of range", data->radius);
    capture->radius = (real)data->radius;
    return true;
}

static bool take_all(Sources *s, const FfpCaptureData *data, FfpError *err) {
    FfpCapture *capture = s->manifest.capture;
    if (!take_numbers(capture, &s->manifest, data, err) || !take_patterns(s, data, err)) return false;
    if (data->n_views < 1 || data->n_views > FFP_VIEWS_MAX)
        return ffp_fail(err, FFP_ERROR_ARGUMENT, "views", "%d views are not in 1 to %d", data->n_views,
                        FFP_VIEWS_MAX);
    ffp_manifest_new_views(&s->manifest, data->n_views);
    for (int v = 0; v < data->n_views; v++)
        if (!take_view(s, data, v, err)) return false;
    s->manifest.pattern_width = capture->views[0].projector.width;
    s->manifest.pattern_height = capture->views[0].projector.height;
    return ffp_manifest_load(&s->manifest, err);
}

static FfpCapture *copy_capture(const FfpCaptureData *data, FfpError *err) {
    FfpCapture *capture = ffp_alloc(1, sizeof *capture);
    Sources s = {.arena = ffp_arena_new()};
    capture->patterns = ffp_alloc(FFP_PATTERNS_MAX, sizeof *capture->patterns);
    s.manifest = (FfpManifest){.capture = capture, .arena = s.arena, .mask_is_given = true, .depth_scale = 1};
    s.manifest.patterns = ffp_arena_alloc(s.arena, FFP_PATTERNS_MAX, sizeof *s.manifest.patterns);
    bool ok = take_name(capture->name, data->name ? data->name : "capture", "name", 0, err);
    s.manifest.file = ffp_arena_text(s.arena, capture->name);
    ok = ok && take_all(&s, data, err);
    ffp_arena_free(s.arena);
    if (ok) return capture;
    ffp_capture_free(capture);
    ffp_free(capture);
    return NULL;
}

typedef struct Call {
    const FfpCaptureData *data;
    FfpCapture *capture;
} Call;

static bool work(void *argument, FfpError *err) {
    Call *call = argument;
    call->capture = copy_capture(call->data, err);
    return call->capture != NULL;
}

FfpCapture *ffp_capture_from_memory(FfpContext *context, const FfpCaptureData *data, FfpError *err) {
    Call call = {data, NULL};
    if (!ffp_need(data, "data", err) || !ffp_need(data->patterns, "patterns", err) ||
        !ffp_need(data->views, "views", err))
        return NULL;
    return ffp_call_run(context, work, &call, err) ? call.capture : NULL;
}

// --- What a capture holds. ---

int ffp_capture_views(const FfpCapture *capture) {
    return capture->n_views;
}

int ffp_capture_patterns(const FfpCapture *capture) {
    return capture->n_patterns;
}

const char *ffp_capture_view_id(const FfpCapture *capture, int view) {
    return view >= 0 && view < capture->n_views ? capture->views[view].id : NULL;
}

const char *ffp_capture_pattern_name(const FfpCapture *capture, int pattern) {
    return pattern >= 0 && pattern < capture->n_patterns ? capture->patterns[pattern].name : NULL;
}

FfpPatternRole ffp_capture_pattern_role(const FfpCapture *capture, int pattern) {
    if (pattern < 0 || pattern >= capture->n_patterns) return FFP_PATTERN_ACTIVE;
    if (pattern == capture->black) return FFP_PATTERN_BLACK;
    if (pattern == capture->white) return FFP_PATTERN_WHITE;
    return capture->patterns[pattern].novel ? FFP_PATTERN_HELD_OUT : FFP_PATTERN_ACTIVE;
}

bool ffp_capture_view_devices(const FfpCapture *capture, int view, FfpPinhole *camera,
                              FfpPinhole *projector) {
    if (view < 0 || view >= capture->n_views) return false;
    if (camera) *camera = ffp_pinhole_of(&capture->views[view].camera);
    if (projector) *projector = ffp_pinhole_of(&capture->views[view].projector);
    return true;
}

static FfpPicture picture_of(const FfpImage *image) {
    return (FfpPicture){.data = image->data,
                        .width = image->width,
                        .height = image->height,
                        .channels = image->channels,
                        .type = FFP_PIXELS_F32};
}

FfpPicture ffp_capture_coverage(const FfpCapture *capture, int view) {
    if (view < 0 || view >= capture->n_views) return (FfpPicture){0};
    return picture_of(&capture->views[view].coverage);
}

FfpPicture ffp_capture_picture(const FfpCapture *capture, int view, int pattern) {
    if (pattern < 0 || pattern >= capture->n_patterns || view < -1 || view >= capture->n_views)
        return (FfpPicture){0};
    return picture_of(view < 0 ? &capture->patterns[pattern].image : &capture->views[view].images[pattern]);
}

void ffp_capture_intensity(const FfpCapture *capture, double intensity[3]) {
    for (int i = 0; i < 3; i++) intensity[i] = (double)capture->intensity[i];
}

void ffp_capture_bounds(const FfpCapture *capture, double centre[3], double *radius) {
    for (int i = 0; centre && i < 3; i++) centre[i] = (double)capture->centre[i];
    if (radius) *radius = (double)capture->radius;
}
