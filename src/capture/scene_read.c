// scene.json, our own layout (docs/formats.md): OpenCV axes, every file named.
#include <string.h>

#include "base/file.h"
#include "base/real.h"
#include "capture/manifest.h"

#define RADIUS_MAX 1e9
#define LENS_MAX 1e4    // of a lens's coefficients
#define GAMMA_LEAST 0.1 // of a projector
#define GAMMA_MOST 10

// width, height, fx, fy, cx, cy; every key may be missing when `device` holds it already (an override of a
// view's own).
static bool read_device(const FfpField *field, bool complete, int least_side, FfpCamera *device,
                        FfpError *err) {
    static const char *const keys[4] = {"fx", "fy", "cx", "cy"};
    real *const numbers[4] = {&device->fx, &device->fy, &device->cx, &device->cy};
    FfpField part;
    if (!json_is_object(field->value)) return ffp_field_fail(field, err, "must be an object");
    if ((complete || ffp_field_find(field, "width", &part)) &&
        !ffp_get_whole(field, "width", least_side, FFP_IMAGE_SIDE_MAX, &device->width, err)) {
        return false;
    }
    if ((complete || ffp_field_find(field, "height", &part)) &&
        !ffp_get_whole(field, "height", least_side, FFP_IMAGE_SIDE_MAX, &device->height, err)) {
        return false;
    }
    for (int i = 0; i < 4; i++) {
        if (!complete && !ffp_field_find(field, keys[i], &part)) continue;
        const double low = i < 2 ? 1e-3 : -FFP_PIXELS_MAX;
        if (!ffp_get_number(field, keys[i], low, FFP_PIXELS_MAX, numbers[i], err)) return false;
    }
    return true;
}

// projector.device: the real projector, of which the rest describes the ideal one.
static bool read_panel(const FfpField *projector, FfpPanel *panel, FfpError *err) {
    static const char *const keys[4] = {"fx", "fy", "cx", "cy"};
    real *const numbers[4] = {&panel->fx, &panel->fy, &panel->cx, &panel->cy};
    FfpField field, part;
    if (!ffp_field_find(projector, "device", &field)) return true;
    if (!json_is_object(field.value)) return ffp_field_fail(&field, err, "must be an object");
    if (!ffp_get_whole(&field, "width", FFP_PATTERN_SIDE_MIN, FFP_IMAGE_SIDE_MAX, &panel->width, err) ||
        !ffp_get_whole(&field, "height", FFP_PATTERN_SIDE_MIN, FFP_IMAGE_SIDE_MAX, &panel->height, err))
        return false;
    for (int i = 0; i < 4; i++) {
        const double low = i < 2 ? 1e-3 : -FFP_PIXELS_MAX;
        if (!ffp_get_number(&field, keys[i], low, FFP_PIXELS_MAX, numbers[i], err)) return false;
    }
    if (ffp_field_find(&field, "lens", &part) &&
        !ffp_field_numbers(&part, 5, -LENS_MAX, LENS_MAX, panel->lens, err))
        return false;
    panel->power = ffp_field_find(&field, "gamma", &part);
    if (panel->power && !ffp_field_numbers(&part, 3, GAMMA_LEAST, GAMMA_MOST, panel->gamma, err))
        return false;
    return panel->known = true;
}

static bool read_projector(FfpManifest *manifest, const FfpField *root, FfpCamera *projector, FfpError *err) {
    FfpField field, intensity;
    if (!ffp_field_get(root, "projector", &field, err)) return false;
    if (!read_device(&field, true, FFP_PATTERN_SIDE_MIN, projector, err)) return false;
    manifest->pattern_width = projector->width;
    manifest->pattern_height = projector->height;
    if (!read_panel(&field, &manifest->capture->panel, err)) return false;
    if (!ffp_field_find(&field, "intensity", &intensity)) return true;
    manifest->capture->intensity_known = true;
    return ffp_field_numbers(&intensity, 3, 1e-12, 1e18, manifest->capture->intensity, err);
}

static bool read_bounds(FfpManifest *manifest, const FfpField *root, FfpError *err) {
    FfpField object, field;
    if (!ffp_field_find(root, "object", &object)) return true;
    manifest->has_bounds = true;
    return ffp_field_get(&object, "centre", &field, err) &&
           ffp_field_numbers(&field, 3, -RADIUS_MAX, RADIUS_MAX, manifest->capture->centre, err) &&
           ffp_get_number(&object, "radius", 1e-9, RADIUS_MAX, &manifest->capture->radius, err);
}

// An optional file of a view: named means that it must be there, unless poses alone are read.
static bool read_file(FfpManifest *manifest, const FfpField *view, const char *key, const char **path,
                      FfpError *err) {
    FfpField field;
    const char *name = NULL;
    if (!ffp_field_find(view, key, &field)) return true;
    if (!ffp_field_file(&field, &name, err)) return false;
    *path = ffp_manifest_path(manifest, manifest->folder, name);
    return *path != NULL || manifest->poses || ffp_field_fail(&field, err, "there is no file '%.200s'", name);
}

static bool read_role(FfpManifest *manifest, const FfpField *item, int pattern, FfpError *err) {
    FfpCapture *capture = manifest->capture;
    FfpField field;
    const char *role = "active";
    if (ffp_field_find(item, "role", &field) && !ffp_field_text(&field, &role, err)) return false;
    const bool black = strcmp(role, "black") == 0, white = strcmp(role, "white") == 0;
    capture->patterns[pattern].novel = strcmp(role, "novel") == 0;
    if (!black && !white) {
        if (capture->patterns[pattern].novel || strcmp(role, "active") == 0) return true;
        return ffp_field_fail(&field, err, "role '%.40s' is none of black, white, active, novel", role);
    }
    int *const place = black ? &capture->black : &capture->white;
    if (*place >= 0) return ffp_field_fail(&field, err, "a second pattern with the role %s", role);
    *place = pattern;
    return true;
}

// Patterns that a targets file shares with its reference are known already and only checked to have a good
// name.
static bool read_pattern(FfpManifest *manifest, const FfpField *item, FfpError *err) {
    FfpField field;
    char name[FFP_NAME_MAX];
    if (!ffp_field_get(item, "name", &field, err) || !ffp_field_name(&field, name, err)) return false;
    const int before = manifest->capture->n_patterns,
              pattern = ffp_manifest_pattern(manifest, name, &field, err);
    if (pattern < 0) return false;
    if (pattern < manifest->known_patterns) return true;
    if (pattern < before) return ffp_field_fail(&field, err, "pattern '%s' comes twice", name);
    if (!read_role(manifest, item, pattern, err)) return false;
    if (!read_file(manifest, item, "file", &manifest->patterns[pattern].path, err)) return false;
    const bool plain = pattern == manifest->capture->black || pattern == manifest->capture->white;
    return plain || manifest->poses || manifest->patterns[pattern].path != NULL ||
           ffp_field_get(item, "file", &field, err);
}

static bool read_patterns(FfpManifest *manifest, const FfpField *root, FfpError *err) {
    FfpField list, item;
    int n = 0;
    if (manifest->targets && !ffp_field_find(root, "patterns", &list)) return true;
    if (!ffp_field_get(root, "patterns", &list, err)) return false;
    if (!ffp_field_count(&list, manifest->targets ? 0 : 2, FFP_PATTERNS_MAX, &n, err)) return false;
    for (int i = 0; i < n; i++) {
        if (!ffp_field_item(&list, i, &item, err) || !read_pattern(manifest, &item, err)) return false;
    }
    if (manifest->poses) return true;
    if (manifest->capture->black < 0) return ffp_field_fail(&list, err, "no pattern has the role black");
    if (manifest->capture->white < 0) return ffp_field_fail(&list, err, "no pattern has the role white");
    return true;
}

static bool read_pictures(FfpManifest *manifest, const FfpField *view, FfpViewFiles *files, FfpError *err) {
    FfpField images, field;
    if (manifest->targets && !ffp_field_find(view, "images", &images)) return true;
    if (!ffp_field_get(view, "images", &images, err)) return false;
    if (!json_is_object(images.value)) return ffp_field_fail(&images, err, "must be an object");
    const char *name = NULL;
    json_t *value = NULL;
    json_object_foreach(images.value, name, value) {
        const int pattern = ffp_capture_find_pattern(manifest->capture, name);
        ffp_field_find(&images, name, &field);
        if (pattern < 0) return ffp_field_fail(&field, err, "'%.100s' is not among the patterns", name);
        if (!read_file(manifest, &images, name, &files->images[pattern].path, err)) return false;
    }
    return true;
}

// What of the picture the camera saw, where that is not all of it.
static bool read_frame(const FfpField *view_field, FfpView *view, FfpError *err) {
    FfpField frame, item;
    int *const sides[2] = {&view->frame_width, &view->frame_height};
    const int most[2] = {view->camera.width, view->camera.height};
    int n;
    if (!ffp_field_find(view_field, "frame", &frame)) return true;
    if (!ffp_field_count(&frame, 2, 2, &n, err)) return false;
    for (int i = 0; i < 2; i++)
        if (!ffp_field_item(&frame, i, &item, err) ||
            !ffp_field_whole(&item, FFP_CAMERA_SIDE_MIN, most[i], sides[i], err))
            return false;
    return true;
}

static bool read_view(FfpManifest *manifest, const FfpField *field, int index, const FfpCamera *camera,
                      const FfpCamera *projector, FfpError *err) {
    FfpView *view = &manifest->capture->views[index];
    FfpViewFiles *files = &manifest->views[index];
    FfpField part;
    if (!ffp_field_get(field, "id", &part, err) || !ffp_manifest_view_id(manifest, index, &part, err))
        return false;
    view->camera = *camera;
    view->projector = *projector;
    if (ffp_field_find(field, "camera", &part) &&
        !read_device(&part, false, FFP_CAMERA_SIDE_MIN, &view->camera, err)) {
        return false;
    }
    if (!read_frame(field, view, err)) return false;
    if (ffp_field_find(field, "projector", &part)) {
        if (!read_device(&part, false, FFP_PATTERN_SIDE_MIN, &view->projector, err)) return false;
        if (view->projector.width != projector->width || view->projector.height != projector->height) {
            return ffp_field_fail(&part, err,
                                  "the projector's size is that of the patterns, the same for all views");
        }
    }
    if (!ffp_field_get(field, "c2w", &part, err) || !ffp_field_pose(&part, false, view->camera.pose, err))
        return false;
    if (!ffp_field_get(field, "p2w", &part, err) || !ffp_field_pose(&part, false, view->projector.pose, err))
        return false;
    if (manifest->poses) return true;
    return read_pictures(manifest, field, files, err) &&
           read_file(manifest, field, "coverage", &files->coverage.path, err) &&
           read_file(manifest, field, "correspondence", &files->correspondence.path, err) &&
           read_file(manifest, field, "depth", &files->depth.path, err) &&
           read_file(manifest, field, "normal", &files->normal.path, err) &&
           read_file(manifest, field, "albedo", &files->albedo.path, err) &&
           read_file(manifest, field, "roughness", &files->roughness.path, err) &&
           read_file(manifest, field, "direct_white", &files->direct_white.path, err);
}

static bool check_version(const FfpField *root, FfpError *err) {
    FfpField field;
    const char *format = NULL;
    int version = 0;
    if (!ffp_field_get(root, "format", &field, err) || !ffp_field_text(&field, &format, err)) return false;
    if (strcmp(format, "ffprocams-capture") != 0) {
        return ffp_field_fail(&field, err, "'%.60s' is not ffprocams-capture", format);
    }
    if (!ffp_field_get(root, "version", &field, err) || !ffp_field_whole(&field, 1, 1000000, &version, err))
        return false;
    return version == 1 ||
           ffp_field_fail(&field, err, "version %d is newer than this program; it reads version 1", version);
}

bool ffp_manifest_from_scene(FfpManifest *manifest, const FfpField *root, FfpError *err) {
    FfpField field, views;
    FfpCamera camera = {0}, projector = {0};
    int n = 0;
    if (!check_version(root, err)) return false;
    if (ffp_field_find(root, "name", &field) && !ffp_field_name(&field, manifest->capture->name, err))
        return false;
    if (!read_bounds(manifest, root, err)) return false;
    manifest->depth_scale = 1;
    if (ffp_field_find(root, "depth_scale", &field) &&
        !ffp_field_number(&field, 1e-12, 1e12, &manifest->depth_scale, err)) {
        return false;
    }
    if (!ffp_field_get(root, "camera", &field, err) ||
        !read_device(&field, true, FFP_CAMERA_SIDE_MIN, &camera, err)) {
        return false;
    }
    if (!read_projector(manifest, root, &projector, err) || !read_patterns(manifest, root, err)) return false;
    if (!ffp_field_get(root, "views", &views, err)) return false;
    if (!ffp_field_count(&views, 1, FFP_VIEWS_MAX, &n, err)) return false;
    ffp_manifest_start_views(manifest, n);
    for (int i = 0; i < n; i++) {
        if (!ffp_field_item(&views, i, &field, err)) return false;
        if (!read_view(manifest, &field, i, &camera, &projector, err)) return false;
    }
    manifest->mask_is_given = true;
    return true;
}
