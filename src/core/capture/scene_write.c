// Writes a capture as scene.json and its files. The JSON goes last, and an older one is taken away first: a
// folder with half of the files is not a capture.
#include <jansson.h>
#include <stdlib.h>
#include <string.h>
#include <tgmath.h>
#include <unistd.h>
#include "core/base/call.h"
#include "core/base/file.h"
#include "core/capture/capture.h"
#include "core/capture/node.h"
#include "core/capture/pad.h"
#include "core/capture/positions.h"

typedef struct Writer {
    const FfpCapture *capture;
    const char *folder;
    json_t *names; // an object whose keys are the files written so far: two must not share a name
} Writer;

// The path of a new file of this capture; an error when another has the name.
static bool claim(Writer *writer, const char *name, char path[FFP_PATH_MAX], FfpError *err) {
    if (!ffp_join_path(path, writer->folder, name))
        return ffp_fail(err, FFP_ERROR_FILE, name, "path is too long");
    if (json_object_get(writer->names, name))
        return ffp_fail(err, FFP_ERROR_FILE, path, "two images would have this name");
    json_object_set_new(writer->names, name, json_true());
    return true;
}

static json_t *numbers(const real *values, int n) {
    json_t *array = json_array();
    for (int i = 0; i < n; i++) json_array_append_new(array, json_real((double)values[i]));
    return array;
}

static json_t *matrix(const real pose[16]) {
    json_t *rows = json_array();
    for (int i = 0; i < 4; i++) json_array_append_new(rows, numbers(pose + 4 * i, 4));
    return rows;
}

static json_t *device(const FfpCamera *camera) {
    return json_pack("{s:i, s:i, s:f, s:f, s:f, s:f}", "width", camera->width, "height", camera->height, "fx",
                     (double)camera->fx, "fy", (double)camera->fy, "cx", (double)camera->cx, "cy",
                     (double)camera->cy);
}

static json_t *describe_panel(const FfpPanel *panel) {
    json_t *json = json_pack("{s:i, s:i, s:f, s:f, s:f, s:f}", "width", panel->width, "height", panel->height,
                             "fx", (double)panel->fx, "fy", (double)panel->fy, "cx", (double)panel->cx, "cy",
                             (double)panel->cy);
    json_object_set_new(json, "lens", numbers(panel->lens, 5));
    if (panel->power) json_object_set_new(json, "gamma", numbers(panel->gamma, 3));
    if (panel->blur > 0) json_object_set_new(json, "blur", json_real((double)panel->blur));
    if (panel->spread_reach > 0)
        json_object_set_new(json, "spread",
                            json_pack("{s:o, s:f}", "share", numbers(panel->spread, 3), "deviation",
                                      (double)panel->spread_reach));
    return json;
}

static bool is_identical(const FfpCamera *a, const FfpCamera *b) {
    return a->width == b->width && a->height == b->height && a->fx == b->fx && a->fy == b->fy &&
           a->cx == b->cx && a->cy == b->cy;
}

// --- Pictures. ---

// True if the picture has light where the object has none: then alpha could not carry it.
static bool shows_background(const FfpImage *rgb, const FfpImage *coverage) {
    const ptrdiff_t pixels = (ptrdiff_t)rgb->width * rgb->height;
    for (ptrdiff_t i = 0; i < pixels; i++) {
        const real *p = rgb->data + 3 * i;
        if (coverage->data[i] <= 0 && fmax(fmax(p[0], p[1]), p[2]) > ffp_srgb_decode(1.0F / 255)) return true;
    }
    return false;
}

// The straight-alpha picture which, put over black in encoded values, gives the linear `rgb`.
static FfpImage straight_alpha(const FfpImage *rgb, const FfpImage *coverage) {
    FfpImage out = ffp_image_new(rgb->width, rgb->height, 4);
    const ptrdiff_t pixels = (ptrdiff_t)rgb->width * rgb->height;
    for (ptrdiff_t i = 0; i < pixels; i++) {
        // The file holds alpha in 255 steps: divide by what will be read.
        const real alpha = round(fmin(fmax(coverage->data[i], (real)0), (real)1) * 255) / 255;
        out.data[4 * i + 3] = alpha;
        for (int c = 0; c < 3 && alpha > 0; c++) {
            out.data[4 * i + c] = fmin(ffp_srgb_encode(rgb->data[3 * i + c]) / alpha, (real)1);
        }
    }
    return out;
}

static bool write_picture(const FfpImage *rgb, const FfpImage *coverage, const char *path, FfpError *err) {
    FfpImage image;
    if (coverage && !shows_background(rgb, coverage)) {
        image = straight_alpha(rgb, coverage);
    } else {
        image = ffp_image_copy(rgb);
        ffp_image_to_srgb(&image);
    }
    const bool ok = ffp_image_write_png(&image, path, err);
    ffp_image_free(&image);
    return ok;
}

// Positions in a form that every program reads.
static bool write_positions(Writer *writer, const FfpView *view, json_t *json, FfpError *err) {
    char name[FFP_NAME_MAX + 32], path[FFP_PATH_MAX];
    if (!view->correspondence.data) return true;
    snprintf(name, sizeof name, "%s_correspondence.png", view->id);
    if (!claim(writer, name, path, err)) return false;
    FfpImage encoded =
        ffp_positions_encoded(&view->correspondence, view->projector.width, view->projector.height);
    const bool ok = ffp_image_write_png16(&encoded, path, err);
    ffp_image_free(&encoded);
    json_object_set_new(json, "correspondence", json_string(name));
    return ok;
}

// Maps of true values.
static bool write_truth(Writer *writer, const FfpView *view, json_t *json, FfpError *err) {
    static const char *const keys[5] = {"depth", "normal", "albedo", "roughness", "direct_white"};
    const FfpImage *const images[5] = {&view->depth, &view->normal, &view->albedo, &view->roughness,
                                       &view->direct_white};
    for (int i = 0; i < 5; i++) {
        if (!images[i]->data) continue;
        char name[FFP_NAME_MAX + 32], path[FFP_PATH_MAX];
        snprintf(name, sizeof name, "%s_%s.exr", view->id, keys[i]);
        if (!claim(writer, name, path, err) || !ffp_image_write_exr(images[i], path, err)) return false;
        json_object_set_new(json, keys[i], json_string(name));
    }
    return true;
}

typedef struct Pictures { // of a view
    const FfpView *view;
    char (*paths)[FFP_PATH_MAX]; // "": none
    FfpError *errors;
    bool *ok;
} Pictures;

static void write_one(void *argument, int64_t i) {
    const Pictures *p = argument;
    const FfpImage *coverage = p->view->coverage.data ? &p->view->coverage : NULL;
    p->ok[i] = !*p->paths[i] || write_picture(&p->view->images[i], coverage, p->paths[i], &p->errors[i]);
}

static bool write_pictures(Writer *writer, const FfpView *view, json_t *images, FfpError *err) {
    const FfpCapture *capture = writer->capture;
    const size_t n = (size_t)capture->n_patterns;
    const Pictures p = {view, ffp_alloc(n, sizeof *p.paths), ffp_alloc(n, sizeof *p.errors),
                        ffp_alloc(n, sizeof *p.ok)};
    bool ok = true;
    for (size_t i = 0; i < n && ok; i++) {
        char name[2 * FFP_NAME_MAX + 8];
        if (!view->images[i].data) continue;
        snprintf(name, sizeof name, "%s_%s.png", view->id, capture->patterns[i].name);
        ok = claim(writer, name, p.paths[i], err);
        json_object_set_new(images, capture->patterns[i].name, json_string(name));
    }
    if (ok) ffp_parallel_for((int64_t)n, 0, write_one, (void *)&p);
    for (size_t i = 0; i < n && ok; i++) {
        ok = p.ok[i];
        if (!ok && err) *err = p.errors[i];
    }
    ffp_free(p.paths), ffp_free(p.errors), ffp_free(p.ok);
    return ok;
}

static bool write_whole_view(Writer *writer, const FfpView *view, json_t *views, FfpError *err) {
    const FfpCapture *capture = writer->capture;
    const FfpCamera first = ffp_whole_camera(&capture->views[0].camera);
    json_t *json = json_object(), *images = json_object();
    json_array_append_new(views, json);
    json_object_set_new(json, "id", json_string(view->id));
    if (!is_identical(&view->camera, &first)) json_object_set_new(json, "camera", device(&view->camera));
    if (!is_identical(&view->projector, &capture->views[0].projector)) {
        json_object_set_new(json, "projector", device(&view->projector));
    }
    if (ffp_frame_width(view) != view->camera.width || ffp_frame_height(view) != view->camera.height)
        json_object_set_new(json, "frame", json_pack("[i,i]", ffp_frame_width(view), ffp_frame_height(view)));
    if (view->near > 0)
        json_object_set_new(json, "range", json_pack("[f,f]", (double)view->near, (double)view->far));
    json_object_set_new(json, "c2w", matrix(view->camera.pose));
    json_object_set_new(json, "p2w", matrix(view->projector.pose));
    json_object_set_new(json, "images", images);
    return write_pictures(writer, view, images, err) && write_positions(writer, view, json, err) &&
           write_truth(writer, view, json, err);
}

static bool write_view(Writer *writer, const FfpView *view, json_t *views, FfpError *err) {
    const FfpCamera whole = ffp_whole_camera(&view->camera);
    if (whole.width == view->camera.width && whole.height == view->camera.height)
        return write_whole_view(writer, view, views, err);
    FfpView filled = ffp_whole_view(view, writer->capture->n_patterns);
    const bool ok = write_whole_view(writer, &filled, views, err);
    ffp_view_free(&filled, writer->capture->n_patterns);
    return ok;
}

static bool write_pattern(Writer *writer, int index, json_t *patterns, FfpError *err) {
    const FfpPattern *pattern = &writer->capture->patterns[index];
    const char *role = pattern->novel ? "novel" : "active";
    if (index == writer->capture->black) role = "black";
    if (index == writer->capture->white) role = "white";
    char name[FFP_NAME_MAX + 32], path[FFP_PATH_MAX];
    snprintf(name, sizeof name, "patterns/%s.png", pattern->name);
    json_array_append_new(patterns,
                          json_pack("{s:s, s:s, s:s}", "name", pattern->name, "file", name, "role", role));
    return claim(writer, name, path, err) && write_picture(&pattern->image, NULL, path, err);
}

// --- The JSON. ---

static void describe_rig(const FfpCapture *capture, json_t *root) {
    const FfpCamera camera = ffp_whole_camera(&capture->views[0].camera);
    json_t *projector = device(&capture->views[0].projector);
    json_object_set_new(projector, "intensity",
                        capture->intensity_known ? numbers(capture->intensity, 3) : json_null());
    if (capture->panel.known) json_object_set_new(projector, "device", describe_panel(&capture->panel));
    json_object_set_new(root, "format", json_string("ffprocams-capture"));
    json_object_set_new(root, "version", json_integer(1));
    json_object_set_new(root, "name", json_string(capture->name));
    json_t *object = json_object();
    json_object_set_new(object, "centre", numbers(capture->centre, 3));
    json_object_set_new(object, "radius", json_real((double)capture->radius));
    json_object_set_new(root, "object", object);
    if (capture->scene) json_object_set_new(root, "scene", json_true());
    json_object_set_new(root, "camera", device(&camera));
    json_object_set_new(root, "projector", projector);
}

static bool write_json(const json_t *root, const char *path, FfpError *err) {
    // Nine digits bring every float back as it was.
    char *text = json_dumps(root, JSON_INDENT(1) | JSON_REAL_PRECISION(9));
    if (!text) return ffp_fail(err, FFP_ERROR_IO, path, "cannot write the JSON");
    const bool ok = ffp_write_file(path, text, strlen(text), err);
    free(text);
    return ok;
}

static bool all_finite(const FfpCapture *capture) {
    real sum = capture->radius + capture->centre[0] + capture->centre[1] + capture->centre[2];
    for (int c = 0; c < 3; c++) sum += capture->intensity[c];
    for (int v = 0; v < capture->n_views; v++) {
        const FfpCamera *const devices[2] = {&capture->views[v].camera, &capture->views[v].projector};
        for (int k = 0; k < 2; k++) {
            sum += devices[k]->fx + devices[k]->fy + devices[k]->cx + devices[k]->cy;
            for (int i = 0; i < 16; i++) sum += devices[k]->pose[i];
        }
    }
    return isfinite(sum);
}

static json_t *names_of_codes(const FfpCapture *capture) {
    json_t *names = json_array();
    for (int i = ffp_patterns_shown(capture); i < capture->n_patterns; i++)
        json_array_append_new(names, json_string(capture->patterns[i].name));
    return names;
}

static bool write_all(Writer *writer, json_t *root, FfpError *err) {
    const FfpCapture *capture = writer->capture;
    json_t *patterns = json_array(), *views = json_array();
    describe_rig(capture, root);
    json_object_set_new(root, "patterns", patterns);
    if (writer->capture->n_codes > 0) json_object_set_new(root, "codes", names_of_codes(writer->capture));
    json_object_set_new(root, "views", views);
    for (int i = 0; i < capture->n_patterns; i++) {
        if (!write_pattern(writer, i, patterns, err)) return false;
    }
    for (int v = 0; v < capture->n_views; v++) {
        if (!write_view(writer, &capture->views[v], views, err)) return false;
    }
    return true;
}

bool ffp_capture_write(const FfpCapture *capture, const char *folder, FfpError *err) {
    char path[FFP_PATH_MAX];
    if (capture->n_views < 1)
        return ffp_fail(err, FFP_ERROR_ARGUMENT, folder, "a capture without views cannot be written");
    if (!all_finite(capture))
        return ffp_fail(err, FFP_ERROR_FILE, folder, "the capture holds numbers that are not finite");
    if (!ffp_join_path(path, folder, "patterns") || !ffp_make_folders(path, err)) {
        return ffp_fail(err, FFP_ERROR_IO, folder, "cannot make the folder");
    }
    if (!ffp_join_path(path, folder, "scene.json"))
        return ffp_fail(err, FFP_ERROR_FILE, folder, "path is too long");
    unlink(path);
    Writer writer = {capture, folder, json_object()};
    json_t *root = json_object();
    ffp_json_own(root);
    ffp_json_own(writer.names);
    const bool ok = write_all(&writer, root, err) && write_json(root, path, err);
    ffp_json_release(root);
    ffp_json_release(writer.names);
    return ok;
}

bool ffp_scene_json_add(const char *folder, const char *section, const char *key, json_t *value,
                        FfpError *err) {
    char path[FFP_PATH_MAX];
    FfpNode root = {0};
    if (!value) return ffp_fail(err, FFP_ERROR_MEMORY, key, "out of memory");
    ffp_json_own(value);
    bool ok = ffp_join_path(path, folder, "scene.json") ||
              ffp_fail(err, FFP_ERROR_FILE, folder, "the path is too long");
    ok = ok && ffp_node_open(&root, path, err);
    if (ok) {
        json_object_set(section ? json_object_get(root.value, section) : root.value, key, value);
        ok = write_json(root.value, path, err);
        ffp_node_close(&root);
    }
    ffp_json_release(value);
    return ok;
}
