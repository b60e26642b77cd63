// render_poses.json: the layout of the paper's released generator. Blender axes, one camera for all views,
// patterns found by name, depth as 16-bit millimetres.
#include <math.h>
#include <string.h>
#include "core/base/file.h"
#include "core/base/real.h"
#include "core/capture/manifest.h"

static bool read_camera(const FfpNode *root, FfpCamera *camera, FfpError *err) {
    FfpNode field;
    return ffp_node_get(root, "camera", &field, err) &&
           ffp_get_whole(&field, "w", FFP_CAMERA_SIDE_MIN, FFP_IMAGE_SIDE_MAX, &camera->width, err) &&
           ffp_get_whole(&field, "h", FFP_CAMERA_SIDE_MIN, FFP_IMAGE_SIDE_MAX, &camera->height, err) &&
           ffp_get_number(&field, "fx", 1e-3, FFP_PIXELS_MAX, &camera->fx, err) &&
           ffp_get_number(&field, "fy", 1e-3, FFP_PIXELS_MAX, &camera->fy, err) &&
           ffp_get_number(&field, "cx", -FFP_PIXELS_MAX, FFP_PIXELS_MAX, &camera->cx, err) &&
           ffp_get_number(&field, "cy", -FFP_PIXELS_MAX, FFP_PIXELS_MAX, &camera->cy, err);
}

// The projector's size and power, each of which may be missing. A spot light of E watts has I = E / (4 pi)
// W/sr.
static bool read_projector(FfpManifest *manifest, const FfpNode *root, FfpError *err) {
    FfpNode projector, field;
    if (!ffp_node_find(root, "projector", &projector)) return true;
    if (!json_is_object(projector.value)) return ffp_node_fail(&projector, err, "must be an object");
    const int least = FFP_PATTERN_SIDE_MIN, most = FFP_IMAGE_SIDE_MAX;
    if (ffp_node_find(&projector, "pattern_w", &field) || ffp_node_find(&projector, "pattern_h", &field)) {
        if (!ffp_get_whole(&projector, "pattern_w", least, most, &manifest->pattern_width, err)) return false;
        if (!ffp_get_whole(&projector, "pattern_h", least, most, &manifest->pattern_height, err))
            return false;
    }
    if (!ffp_node_find(&projector, "projector_energy", &field)) return true;
    real energy = 0;
    if (!ffp_node_number(&field, 1e-9, 1e12, &energy, err)) return false;
    for (int c = 0; c < 3; c++) manifest->capture->intensity[c] = (real)((double)energy / (16 * atan(1.0)));
    manifest->capture->intensity_known = true;
    return true;
}

// The picture as the file says, otherwise a file of that base name beside the JSON: releases carry paths of
// another machine.
static const char *find_picture(FfpManifest *manifest, const char *file_path) {
    const char *found = NULL;
    if (ffp_is_inner_path(file_path)) found = ffp_manifest_path(manifest, manifest->folder, file_path);
    if (!found && ffp_is_name(ffp_basename(file_path))) {
        found = ffp_manifest_path(manifest, manifest->folder, ffp_basename(file_path));
    }
    return found;
}

static bool read_pictures(FfpManifest *manifest, const FfpNode *view, FfpViewFiles *files, FfpError *err) {
    FfpNode list;
    int n = 0;
    if (manifest->targets && !ffp_node_find(view, "patterns", &list)) return true;
    if (!ffp_node_get(view, "patterns", &list, err)) return false;
    if (!ffp_node_count(&list, manifest->targets ? 0 : 1, FFP_PATTERNS_MAX, &n, err)) return false;
    for (int i = 0; i < n; i++) {
        FfpNode item, name_field, file_field;
        char name[FFP_NAME_MAX];
        const char *file = NULL;
        if (!ffp_node_item(&list, i, &item, err) ||
            !ffp_node_get(&item, "projector_image", &name_field, err) ||
            !ffp_node_name(&name_field, name, err) || !ffp_node_get(&item, "file_path", &file_field, err) ||
            !ffp_node_text(&file_field, &file, err)) {
            return false;
        }
        const int pattern = ffp_manifest_pattern(manifest, name, &name_field, err);
        if (pattern < 0) return false;
        if (files->images[pattern].path)
            return ffp_node_fail(&name_field, err, "duplicate pattern '%s'", name);
        files->images[pattern].path = find_picture(manifest, file);
        if (!files->images[pattern].path && manifest->keep)
            files->images[pattern].path =
                ffp_manifest_join(manifest, manifest->folder, ffp_basename(file)); // reading it will say so
        if (!files->images[pattern].path && !manifest->poses) {
            return ffp_node_fail(&file_field, err, "no file '%.200s', nor '%.200s' beside the JSON", file,
                                 ffp_basename(file));
        }
    }
    return true;
}

static bool read_view(FfpManifest *manifest, const FfpNode *field, int index, const FfpCamera *camera,
                      FfpError *err) {
    FfpView *view = &manifest->capture->views[index];
    FfpViewFiles *files = &manifest->views[index];
    FfpNode part;
    if (!ffp_node_get(field, "view_id", &part, err) || !ffp_manifest_view_id(manifest, index, &part, err))
        return false;
    view->camera = *camera;
    if (!ffp_node_get(field, "c2w", &part, err) || !ffp_node_pose(&part, true, view->camera.pose, err))
        return false;
    if (!ffp_node_get(field, "p2w", &part, err) || !ffp_node_pose(&part, true, view->projector.pose, err))
        return false;
    FfpCamera *projector = &view->projector;
    if (!ffp_get_number(field, "proj_fx", 1e-3, FFP_PIXELS_MAX, &projector->fx, err) ||
        !ffp_get_number(field, "proj_fy", 1e-3, FFP_PIXELS_MAX, &projector->fy, err) ||
        !ffp_get_number(field, "proj_cx", -FFP_PIXELS_MAX, FFP_PIXELS_MAX, &projector->cx, err) ||
        !ffp_get_number(field, "proj_cy", -FFP_PIXELS_MAX, FFP_PIXELS_MAX, &projector->cy, err)) {
        return false;
    }
    char name[FFP_NAME_MAX + 16];
    snprintf(name, sizeof name, "%s_depth.png", view->id);
    files->depth.path = ffp_manifest_path(manifest, manifest->folder, name);
    snprintf(name, sizeof name, "%s_mask.png", view->id);
    files->coverage.path = ffp_manifest_path(manifest, manifest->folder, name);
    return read_pictures(manifest, field, files, err);
}

static bool is_lollipop(const FfpPattern *pattern) {
    return strncmp(pattern->name, "lollipop", 8) == 0;
}

static int find_either(const FfpCapture *capture, const char *name, const char *other) {
    const int found = ffp_capture_find_pattern(capture, name);
    return found >= 0 ? found : ffp_capture_find_pattern(capture, other);
}

// Roles go by name, as the generator gave them: all_black, all_white, lollipop_* to reconstruct from, others
// held back. A capture without lollipops brought patterns of its own, any of which may be used.
static bool assign_roles(FfpManifest *manifest, const FfpNode *views, FfpError *err) {
    FfpCapture *capture = manifest->capture;
    bool lollipops = false;
    for (int i = 0; i < capture->n_patterns; i++) lollipops = lollipops || is_lollipop(&capture->patterns[i]);
    for (int i = manifest->known_patterns; i < capture->n_patterns; i++) {
        capture->patterns[i].novel = lollipops && !is_lollipop(&capture->patterns[i]);
    }
    if (manifest->targets) return true;
    capture->black = find_either(capture, "all_black", "black");
    capture->white = find_either(capture, "all_white", "white");
    if (capture->black < 0) return ffp_node_fail(views, err, "no pattern is called all_black or black");
    if (capture->white < 0) return ffp_node_fail(views, err, "no pattern is called all_white or white");
    capture->patterns[capture->black].novel = capture->patterns[capture->white].novel = false;
    return true;
}

// <name>.png in the capture's folder, in its patterns/, in the patterns/ beside it. Black and white need no
// file.
static bool find_patterns(FfpManifest *manifest, const FfpNode *views, FfpError *err) {
    static const char *const places[3] = {"", "patterns/", "../patterns/"};
    const FfpCapture *capture = manifest->capture;
    for (int i = manifest->known_patterns; i < capture->n_patterns; i++) {
        for (int k = 0; k < 3 && !manifest->patterns[i].path; k++) {
            char name[FFP_NAME_MAX + 32];
            snprintf(name, sizeof name, "%s%s.png", places[k], capture->patterns[i].name);
            manifest->patterns[i].path = ffp_manifest_path(manifest, manifest->folder, name);
        }
        if (!manifest->patterns[i].path && i != capture->black && i != capture->white && !manifest->poses) {
            return ffp_node_fail(views, err, "no pattern image %s.png here, in patterns/ or in ../patterns/",
                                 capture->patterns[i].name);
        }
    }
    return true;
}

bool ffp_manifest_from_render_poses(FfpManifest *manifest, const FfpNode *root, FfpError *err) {
    FfpNode name, views;
    FfpCamera camera = {0};
    int n = 0;
    if (ffp_node_find(root, "scene_name", &name) && !ffp_node_name(&name, manifest->capture->name, err))
        return false;
    if (!read_camera(root, &camera, err) || !read_projector(manifest, root, err)) return false;
    if (!ffp_node_get(root, "views", &views, err)) return false;
    if (!ffp_node_count(&views, 1, FFP_VIEWS_MAX, &n, err)) return false;
    ffp_manifest_new_views(manifest, n);
    for (int i = 0; i < n; i++) {
        FfpNode view;
        if (!ffp_node_item(&views, i, &view, err) || !read_view(manifest, &view, i, &camera, err))
            return false;
    }
    manifest->depth_scale = 0.001F;
    return assign_roles(manifest, &views, err) && find_patterns(manifest, &views, err);
}
