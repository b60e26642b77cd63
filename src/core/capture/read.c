// The way in: finds the JSON, sees which kind it is, and turns it into a capture.
#define _XOPEN_SOURCE 700 // realpath
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include "core/base/file.h"
#include "core/base/kind.h"
#include "core/capture/manifest.h"

// `path` itself if it is a JSON file; in a folder, the first of the names that exists.
static bool find_json(char json[FFP_PATH_MAX], const char *path, const char *const *names, int n,
                      FfpError *err) {
    if (strlen(path) >= FFP_PATH_MAX) return ffp_fail(err, FFP_ERROR_FILE, NULL, "path is too long");
    if (!ffp_is_folder(path)) {
        memcpy(json, path, strlen(path) + 1);
        if (!ffp_check_kind(path, FFP_WANTED_CAPTURE, err)) return false;
        return ffp_is_file(path) || ffp_fail(err, FFP_ERROR_IO, path, "no such file or folder");
    }
    for (int i = 0; i < n; i++) {
        if (ffp_join_path(json, path, names[i]) && ffp_is_file(json)) return true;
    }
    if (n == 1) return ffp_fail(err, FFP_ERROR_FILE, path, "the folder has no %s", names[0]);
    return ffp_fail(err, FFP_ERROR_FILE, path,
                    "the folder has neither %s nor %s; photographs become a capture with `ffprocams import`",
                    names[0], names[n - 1]);
}

static void folder_of(char folder[FFP_PATH_MAX], const char *file) {
    memcpy(folder, file, strlen(file) + 1);
    char *slash = strrchr(folder, '/');
    if (!slash)
        memcpy(folder, ".", 2);
    else if (slash == folder)
        folder[1] = 0;
    else
        *slash = 0;
}

// A capture without a name is called as its folder is.
static void name_after_folder(FfpCapture *capture) {
    char *full = realpath(capture->folder, NULL);
    const char *name = full ? ffp_basename(full) : "";
    snprintf(capture->name, FFP_NAME_MAX, "%s", ffp_is_name(name) ? name : "capture");
    free(full);
}

static bool read_manifest(FfpManifest *manifest, FfpError *err) {
    FfpNode root, format;
    if (!ffp_node_open(&root, manifest->file, err)) return false;
    const bool ours = ffp_node_find(&root, "format", &format);
    const bool ok = ours ? ffp_manifest_from_scene(manifest, &root, err)
                         : ffp_manifest_from_render_poses(manifest, &root, err);
    ffp_node_close(&root);
    if (ok && manifest->capture->name[0] == 0) name_after_folder(manifest->capture);
    return ok && ffp_manifest_load(manifest, err);
}

// Reads `json` into the manifest's capture, which is freed when that fails.
static bool read_file(FfpManifest *manifest, const char *json, FfpError *err) {
    FfpCapture *capture = manifest->capture;
    folder_of(capture->folder, json);
    manifest->file = json;
    manifest->folder = capture->folder;
    manifest->arena = ffp_arena_new();
    manifest->patterns = ffp_arena_alloc(manifest->arena, FFP_PATTERNS_MAX, sizeof(FfpSource));
    const bool ok = read_manifest(manifest, err);
    if (!capture->files) ffp_arena_free(manifest->arena);
    if (!ok) ffp_capture_free(capture);
    return ok;
}

static const char *const capture_names[2] = {"scene.json", "render_poses.json"};

static bool read_most(FfpCapture *capture, const char *path, double values, const FfpWanted *wanted,
                      FfpError *err) {
    char json[FFP_PATH_MAX];
    FfpManifest manifest = {.capture = capture, .values_most = values, .wanted = wanted};
    *capture = (FfpCapture){.black = -1, .white = -1};
    if (!find_json(json, path, capture_names, 2, err)) return false;
    capture->patterns = ffp_alloc(FFP_PATTERNS_MAX, sizeof(FfpPattern));
    return read_file(&manifest, json, err);
}

bool ffp_capture_read(FfpCapture *capture, const char *path, FfpError *err) {
    return read_most(capture, path, 0, NULL, err);
}

FfpCapture *ffp_capture_load(const char *path, FfpError *err) {
    return ffp_capture_load_most(path, 0, err);
}

FfpCapture *ffp_capture_load_most(const char *path, double values, FfpError *err) {
    FfpCapture *capture = ffp_alloc(1, sizeof *capture);
    if (read_most(capture, path, values, NULL, err)) return capture;
    ffp_free(capture);
    return NULL;
}

bool ffp_capture_read_targets(FfpCapture *targets, const char *path, const FfpCapture *reference,
                              FfpError *err) {
    static const char *const names[1] = {"targets.json"};
    char json[FFP_PATH_MAX];
    *targets = (FfpCapture){
        .black = reference->black, .white = reference->white, .n_patterns = reference->n_patterns};
    if (!find_json(json, path, names, 1, err)) return false;
    targets->patterns = ffp_alloc(FFP_PATTERNS_MAX, sizeof(FfpPattern));
    for (int i = 0; i < reference->n_patterns; i++) {
        targets->patterns[i] = reference->patterns[i];
        targets->patterns[i].image = ffp_image_copy(&reference->patterns[i].image);
    }
    FfpManifest manifest = {.capture = targets, .targets = true, .known_patterns = targets->n_patterns};
    if (!read_file(&manifest, json, err)) return false;
    memcpy(targets->centre, reference->centre, sizeof targets->centre);
    memcpy(targets->intensity, reference->intensity, sizeof targets->intensity);
    targets->radius = reference->radius;
    targets->intensity_known = reference->intensity_known;
    targets->panel = reference->panel;
    return true;
}

// True if the file says all that the photographs would be looked at for.
static bool says_enough(const FfpCapture *devices, bool sphere) {
    bool enough = devices->intensity_known && (!sphere || devices->radius > 0);
    for (int p = 0; p < devices->n_patterns; p++) enough &= devices->patterns[p].image.data != NULL;
    return enough;
}

FfpCapture *ffp_capture_load_devices(const char *path, bool sphere, FfpError *err) {
    char json[FFP_PATH_MAX];
    FfpCapture *devices = ffp_alloc(1, sizeof *devices);
    FfpManifest manifest = {.capture = devices, .targets = true, .poses = true, .keep = true};
    *devices = (FfpCapture){.black = -1, .white = -1};
    devices->patterns = ffp_alloc(FFP_PATTERNS_MAX, sizeof(FfpPattern));
    FfpError why = {0}; // what is wrong is found again, and told, by reading all of it
    const bool found = find_json(json, path, capture_names, 2, &why);
    const bool read = found && read_file(&manifest, json, &why);
    if (read && says_enough(devices, sphere)) return devices;
    if (read) ffp_capture_free(devices);
    if (!found) ffp_free(devices->patterns);
    ffp_free(devices);
    return ffp_capture_load(path, err);
}

FfpCapture *ffp_capture_load_wanted(const char *path, const char *const *patterns, int n, FfpError *err) {
    const FfpWanted wanted = {patterns, n};
    FfpCapture *capture = ffp_alloc(1, sizeof *capture);
    FfpError why = {0}; // as above
    if (read_most(capture, path, 0, &wanted, &why)) return capture;
    ffp_free(capture);
    return ffp_capture_load(path, err);
}

bool ffp_capture_read_poses(FfpCapture *poses, const char *path, int width, int height, FfpError *err) {
    static const char *const names[3] = {"targets.json", "scene.json", "render_poses.json"};
    char json[FFP_PATH_MAX];
    *poses = (FfpCapture){.black = -1, .white = -1};
    if (!find_json(json, path, names, 3, err)) return false;
    poses->patterns = ffp_alloc(FFP_PATTERNS_MAX, sizeof(FfpPattern));
    FfpManifest manifest = {
        .capture = poses, .targets = true, .poses = true, .other_width = width, .other_height = height};
    return read_file(&manifest, json, err);
}
