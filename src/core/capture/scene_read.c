// scene.json, our own layout (docs/reference/formats/capture.md): OpenCV axes, every file named.
#include <string.h>
#include "core/base/file.h"
#include "core/base/real.h"
#include "core/capture/manifest.h"

#define RADIUS_MAX 1e9
#define LENS_MAX 1e4    // of a lens's coefficients
#define GAMMA_LEAST 0.1 // of a projector
#define GAMMA_MOST 10
#define BLUR_MAX 64    // pixels
#define SPREAD_MAX 0.5 // of a projector's light
#define REACH_MAX 4096 // pixels

// width, height, fx, fy, cx, cy; every key may be missing when `device` holds it already (an override of a
// view's own).
static bool read_device(const FfpNode *field, bool complete, int least_side, FfpCamera *device,
                        FfpError *err) {
    static const char *const keys[4] = {"fx", "fy", "cx", "cy"};
    real *const numbers[4] = {&device->fx, &device->fy, &device->cx, &device->cy};
    FfpNode part;
    if (!json_is_object(field->value)) return ffp_node_fail(field, err, "must be an object");
    if ((complete || ffp_node_find(field, "width", &part)) &&
        !ffp_get_whole(field, "width", least_side, FFP_IMAGE_SIDE_MAX, &device->width, err)) {
        return false;
    }
    if ((complete || ffp_node_find(field, "height", &part)) &&
        !ffp_get_whole(field, "height", least_side, FFP_IMAGE_SIDE_MAX, &device->height, err)) {
        return false;
    }
    for (int i = 0; i < 4; i++) {
        if (!complete && !ffp_node_find(field, keys[i], &part)) continue;
        const double low = i < 2 ? 1e-3 : -FFP_PIXELS_MAX;
        if (!ffp_get_number(field, keys[i], low, FFP_PIXELS_MAX, numbers[i], err)) return false;
    }
    return true;
}

static bool read_spread(const FfpNode *device, FfpPanel *panel, FfpError *err) {
    FfpNode spread, share;
    if (!ffp_node_find(device, "spread", &spread)) return true;
    if (!json_is_object(spread.value)) return ffp_node_fail(&spread, err, "must be an object");
    return ffp_node_get(&spread, "share", &share, err) &&
           ffp_node_numbers(&share, 3, 0, SPREAD_MAX, panel->spread, err) &&
           ffp_get_number(&spread, "deviation", 0, REACH_MAX, &panel->spread_reach, err);
}

// projector.device: the real projector, of which the rest describes the ideal one.
static bool read_panel(const FfpNode *projector, FfpPanel *panel, FfpError *err) {
    static const char *const keys[4] = {"fx", "fy", "cx", "cy"};
    real *const numbers[4] = {&panel->fx, &panel->fy, &panel->cx, &panel->cy};
    FfpNode field, part;
    if (!ffp_node_find(projector, "device", &field)) return true;
    if (!json_is_object(field.value)) return ffp_node_fail(&field, err, "must be an object");
    if (!ffp_get_whole(&field, "width", FFP_PATTERN_SIDE_MIN, FFP_IMAGE_SIDE_MAX, &panel->width, err) ||
        !ffp_get_whole(&field, "height", FFP_PATTERN_SIDE_MIN, FFP_IMAGE_SIDE_MAX, &panel->height, err))
        return false;
    for (int i = 0; i < 4; i++) {
        const double low = i < 2 ? 1e-3 : -FFP_PIXELS_MAX;
        if (!ffp_get_number(&field, keys[i], low, FFP_PIXELS_MAX, numbers[i], err)) return false;
    }
    if (ffp_node_find(&field, "lens", &part) &&
        !ffp_node_numbers(&part, 5, -LENS_MAX, LENS_MAX, panel->lens, err))
        return false;
    if (ffp_node_find(&field, "blur", &part) &&
        !ffp_get_number(&field, "blur", 0, BLUR_MAX, &panel->blur, err))
        return false;
    if (!read_spread(&field, panel, err)) return false;
    panel->power = ffp_node_find(&field, "gamma", &part);
    if (panel->power && !ffp_node_numbers(&part, 3, GAMMA_LEAST, GAMMA_MOST, panel->gamma, err)) return false;
    return panel->known = true;
}

static bool read_projector(FfpManifest *manifest, const FfpNode *root, FfpCamera *projector, FfpError *err) {
    FfpNode field, intensity;
    if (!ffp_node_get(root, "projector", &field, err)) return false;
    if (!read_device(&field, true, FFP_PATTERN_SIDE_MIN, projector, err)) return false;
    manifest->pattern_width = projector->width;
    manifest->pattern_height = projector->height;
    if (!read_panel(&field, &manifest->capture->panel, err)) return false;
    if (!ffp_node_find(&field, "intensity", &intensity)) return true;
    manifest->capture->intensity_known = true;
    return ffp_node_numbers(&intensity, 3, 1e-12, 1e18, manifest->capture->intensity, err);
}

static bool read_bounds(FfpManifest *manifest, const FfpNode *root, FfpError *err) {
    FfpNode object, field;
    if (!ffp_node_find(root, "object", &object)) return true;
    manifest->has_bounds = true;
    return ffp_node_get(&object, "centre", &field, err) &&
           ffp_node_numbers(&field, 3, -RADIUS_MAX, RADIUS_MAX, manifest->capture->centre, err) &&
           ffp_get_number(&object, "radius", 1e-9, RADIUS_MAX, &manifest->capture->radius, err);
}

// Reads whether it is a whole scene.
static bool read_kind(FfpManifest *manifest, const FfpNode *root, FfpError *err) {
    FfpNode field;
    if (!ffp_node_find(root, "scene", &field)) return true;
    if (!json_is_boolean(field.value)) return ffp_node_fail(&field, err, "not true or false");
    manifest->capture->scene = json_is_true(field.value);
    return true;
}

// An optional file: named means that it must be there, unless poses alone are read.
static bool read_file(FfpManifest *manifest, const FfpNode *view, const char *key, const char **path,
                      FfpError *err) {
    FfpNode field;
    const char *name = NULL;
    if (!ffp_node_find(view, key, &field)) return true;
    if (!ffp_node_file(&field, &name, err)) return false;
    *path = ffp_manifest_path(manifest, manifest->folder, name);
    return *path || manifest->poses || ffp_node_fail(&field, err, "no such file '%.200s'", name);
}

static bool read_role(FfpManifest *manifest, const FfpNode *item, int pattern, FfpError *err) {
    FfpCapture *capture = manifest->capture;
    FfpNode field;
    const char *role = "active";
    if (ffp_node_find(item, "role", &field) && !ffp_node_text(&field, &role, err)) return false;
    const bool black = strcmp(role, "black") == 0, white = strcmp(role, "white") == 0;
    capture->patterns[pattern].novel = strcmp(role, "novel") == 0;
    if (!black && !white) {
        if (capture->patterns[pattern].novel || strcmp(role, "active") == 0) return true;
        return ffp_node_fail(&field, err, "invalid role '%.40s': expected black, white, active or novel",
                             role);
    }
    int *const place = black ? &capture->black : &capture->white;
    if (*place >= 0) return ffp_node_fail(&field, err, "a second pattern with the role %s", role);
    *place = pattern;
    return true;
}

// Patterns that a targets file shares with its reference are known already and only checked to have a good
// name.
static bool read_pattern(FfpManifest *manifest, const FfpNode *item, FfpError *err) {
    FfpNode field;
    char name[FFP_NAME_MAX];
    if (!ffp_node_get(item, "name", &field, err) || !ffp_node_name(&field, name, err)) return false;
    const int before = manifest->capture->n_patterns,
              pattern = ffp_manifest_pattern(manifest, name, &field, err);
    if (pattern < 0) return false;
    if (pattern < manifest->known_patterns) return true;
    if (pattern < before) return ffp_node_fail(&field, err, "duplicate pattern '%s'", name);
    if (!read_role(manifest, item, pattern, err)) return false;
    if (!read_file(manifest, item, "file", &manifest->patterns[pattern].path, err)) return false;
    const bool plain = pattern == manifest->capture->black || pattern == manifest->capture->white;
    return plain || manifest->poses || manifest->patterns[pattern].path ||
           ffp_node_get(item, "file", &field, err);
}

// The names of the last patterns, which are Gray codes. Those of a targets file are patterns like others.
static bool read_codes(FfpManifest *manifest, const FfpNode *root, FfpError *err) {
    FfpCapture *capture = manifest->capture;
    FfpNode list, item;
    int n = 0;
    if (manifest->targets || !ffp_node_find(root, "codes", &list)) return true;
    if (!ffp_node_count(&list, 0, capture->n_patterns, &n, err)) return false;
    for (int i = 0; i < n; i++) {
        char name[FFP_NAME_MAX];
        const FfpPattern *pattern = &capture->patterns[capture->n_patterns - n + i];
        if (!ffp_node_item(&list, i, &item, err) || !ffp_node_name(&item, name, err)) return false;
        if (strcmp(name, pattern->name) != 0 || !pattern->novel)
            return ffp_node_fail(&item, err,
                                 "'%.100s' is not in its place among the last %d patterns, with the role "
                                 "novel",
                                 name, n);
    }
    capture->n_codes = n;
    return true;
}

static bool read_patterns(FfpManifest *manifest, const FfpNode *root, FfpError *err) {
    FfpNode list, item;
    int n = 0;
    if (manifest->targets && !ffp_node_find(root, "patterns", &list)) return true;
    if (!ffp_node_get(root, "patterns", &list, err)) return false;
    if (!ffp_node_count(&list, manifest->targets ? 0 : 2, FFP_PATTERNS_MAX, &n, err)) return false;
    for (int i = 0; i < n; i++) {
        if (!ffp_node_item(&list, i, &item, err) || !read_pattern(manifest, &item, err)) return false;
    }
    if (!read_codes(manifest, root, err)) return false;
    if (manifest->poses) return true;
    if (manifest->capture->black < 0) return ffp_node_fail(&list, err, "no pattern has the role black");
    if (manifest->capture->white < 0) return ffp_node_fail(&list, err, "no pattern has the role white");
    return true;
}

// Of a view. One that is left for later and is not there keeps its name: reading it will say so.
static bool read_view_file(FfpManifest *manifest, const FfpNode *view, const char *key, FfpSource *source,
                           FfpError *err) {
    FfpNode field;
    const char *name = NULL;
    if (!read_file(manifest, view, key, &source->path, err)) return false;
    if (source->path || !manifest->keep || !ffp_node_find(view, key, &field)) return true;
    if (!ffp_node_file(&field, &name, err)) return false;
    source->path = ffp_manifest_join(manifest, manifest->folder, name);
    return true;
}

static bool read_pictures(FfpManifest *manifest, const FfpNode *view, FfpViewFiles *files, FfpError *err) {
    FfpNode images, field;
    if (manifest->targets && !ffp_node_find(view, "images", &images)) return true;
    if (!ffp_node_get(view, "images", &images, err)) return false;
    if (!json_is_object(images.value)) return ffp_node_fail(&images, err, "must be an object");
    const char *name = NULL;
    json_t *value = NULL;
    json_object_foreach(images.value, name, value) {
        const int pattern = ffp_capture_find_pattern(manifest->capture, name);
        ffp_node_find(&images, name, &field);
        if (pattern < 0) return ffp_node_fail(&field, err, "'%.100s' is not among the patterns", name);
        if (!read_view_file(manifest, &images, name, &files->images[pattern], err)) return false;
    }
    return true;
}

// The part of the picture that the camera saw, if not all of it.
static bool read_frame(const FfpNode *view_field, FfpView *view, FfpError *err) {
    FfpNode frame, item;
    int *const sides[2] = {&view->frame_width, &view->frame_height};
    const int most[2] = {view->camera.width, view->camera.height};
    int n;
    if (!ffp_node_find(view_field, "frame", &frame)) return true;
    if (!ffp_node_count(&frame, 2, 2, &n, err)) return false;
    for (int i = 0; i < 2; i++)
        if (!ffp_node_item(&frame, i, &item, err) ||
            !ffp_node_integer(&item, FFP_CAMERA_SIDE_MIN, most[i], sides[i], err))
            return false;
    return true;
}

// Camera depths between which a scene's surfaces are looked for.
static bool read_range(const FfpNode *view_field, FfpView *view, FfpError *err) {
    FfpNode field;
    real range[2];
    if (!ffp_node_find(view_field, "range", &field)) return true;
    if (!ffp_node_numbers(&field, 2, 1e-9, RADIUS_MAX, range, err)) return false;
    if (!(range[1] > range[0])) return ffp_node_fail(&field, err, "the far end is not beyond the near one");
    view->near = range[0];
    view->far = range[1];
    return true;
}

static bool read_view(FfpManifest *manifest, const FfpNode *field, int index, const FfpCamera *camera,
                      const FfpCamera *projector, FfpError *err) {
    FfpView *view = &manifest->capture->views[index];
    FfpViewFiles *files = &manifest->views[index];
    FfpNode part;
    if (!ffp_node_get(field, "id", &part, err) || !ffp_manifest_view_id(manifest, index, &part, err))
        return false;
    view->camera = *camera;
    view->projector = *projector;
    if (ffp_node_find(field, "camera", &part) &&
        !read_device(&part, false, FFP_CAMERA_SIDE_MIN, &view->camera, err)) {
        return false;
    }
    if (!read_frame(field, view, err) || !read_range(field, view, err)) return false;
    if (ffp_node_find(field, "projector", &part)) {
        if (!read_device(&part, false, FFP_PATTERN_SIDE_MIN, &view->projector, err)) return false;
        if (view->projector.width != projector->width || view->projector.height != projector->height) {
            return ffp_node_fail(&part, err,
                                 "the projector's size is that of the patterns, the same for all views");
        }
    }
    if (!ffp_node_get(field, "c2w", &part, err) || !ffp_node_pose(&part, false, view->camera.pose, err))
        return false;
    if (!ffp_node_get(field, "p2w", &part, err) || !ffp_node_pose(&part, false, view->projector.pose, err))
        return false;
    if (manifest->poses && !manifest->keep) return true;
    return read_pictures(manifest, field, files, err) &&
           read_view_file(manifest, field, "coverage", &files->coverage, err) &&
           read_view_file(manifest, field, "correspondence", &files->correspondence, err) &&
           read_view_file(manifest, field, "depth", &files->depth, err) &&
           read_view_file(manifest, field, "normal", &files->normal, err) &&
           read_view_file(manifest, field, "albedo", &files->albedo, err) &&
           read_view_file(manifest, field, "roughness", &files->roughness, err) &&
           read_view_file(manifest, field, "direct_white", &files->direct_white, err);
}

static bool check_version(const FfpNode *root, FfpError *err) {
    FfpNode field;
    const char *format = NULL;
    int version = 0;
    if (!ffp_node_get(root, "format", &field, err) || !ffp_node_text(&field, &format, err)) return false;
    if (strcmp(format, "ffprocams-capture") != 0) {
        return ffp_node_fail(&field, err, "'%.60s' is not ffprocams-capture", format);
    }
    if (!ffp_node_get(root, "version", &field, err) || !ffp_node_integer(&field, 1, 1000000, &version, err))
        return false;
    return version == 1 ||
           ffp_node_fail(&field, err, "version %d is newer than this program; it reads version 1", version);
}

bool ffp_manifest_from_scene(FfpManifest *manifest, const FfpNode *root, FfpError *err) {
    FfpNode field, views;
    FfpCamera camera = {0}, projector = {0};
    int n = 0;
    if (!check_version(root, err)) return false;
    if (ffp_node_find(root, "name", &field) && !ffp_node_name(&field, manifest->capture->name, err))
        return false;
    if (!read_bounds(manifest, root, err) || !read_kind(manifest, root, err)) return false;
    manifest->depth_scale = 1;
    if (ffp_node_find(root, "depth_scale", &field) &&
        !ffp_node_number(&field, 1e-12, 1e12, &manifest->depth_scale, err)) {
        return false;
    }
    if (!ffp_node_get(root, "camera", &field, err) ||
        !read_device(&field, true, FFP_CAMERA_SIDE_MIN, &camera, err)) {
        return false;
    }
    if (!read_projector(manifest, root, &projector, err) || !read_patterns(manifest, root, err)) return false;
    if (!ffp_node_get(root, "views", &views, err)) return false;
    if (!ffp_node_count(&views, 1, FFP_VIEWS_MAX, &n, err)) return false;
    ffp_manifest_new_views(manifest, n);
    for (int i = 0; i < n; i++) {
        if (!ffp_node_item(&views, i, &field, err)) return false;
        if (!read_view(manifest, &field, i, &camera, &projector, err)) return false;
    }
    manifest->mask_is_given = true;
    return true;
}
