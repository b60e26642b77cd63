// Calls by which the readers of both kinds of JSON fill the manifest.
#include "core/capture/manifest.h"
#include <stdio.h>
#include <string.h>
#include "core/base/file.h"

const char *ffp_manifest_join(FfpManifest *manifest, const char *folder, const char *name) {
    char path[FFP_PATH_MAX];
    return ffp_join_path(path, folder, name) ? ffp_arena_text(manifest->arena, path) : NULL;
}

const char *ffp_manifest_path(FfpManifest *manifest, const char *folder, const char *name) {
    char path[FFP_PATH_MAX];
    if (!ffp_join_path(path, folder, name) || !ffp_is_file(path)) return NULL;
    return ffp_arena_text(manifest->arena, path);
}

int ffp_manifest_pattern(FfpManifest *manifest, const char *name, const FfpNode *field, FfpError *err) {
    FfpCapture *capture = manifest->capture;
    const int found = ffp_capture_find_pattern(capture, name);
    if (found >= 0) return found;
    if (capture->n_patterns == FFP_PATTERNS_MAX) {
        ffp_node_fail(field, err, "more than %d patterns", FFP_PATTERNS_MAX);
        return -1;
    }
    snprintf(capture->patterns[capture->n_patterns].name, FFP_NAME_MAX, "%s", name);
    return capture->n_patterns++;
}

void ffp_manifest_new_views(FfpManifest *manifest, int n) {
    manifest->capture->n_views = n;
    manifest->capture->views = ffp_alloc((size_t)n, sizeof(FfpView));
    manifest->views = ffp_arena_alloc(manifest->arena, (size_t)n, sizeof *manifest->views);
    for (int i = 0; i < n; i++) {
        manifest->views[i].images = ffp_arena_alloc(manifest->arena, FFP_PATTERNS_MAX, sizeof(FfpSource));
    }
}

bool ffp_manifest_view_id(FfpManifest *manifest, int view, const FfpNode *field, FfpError *err) {
    FfpView *views = manifest->capture->views;
    if (!ffp_node_name(field, views[view].id, err)) return false;
    for (int i = 0; i < view; i++) {
        if (strcmp(views[i].id, views[view].id) == 0) {
            return ffp_node_fail(field, err, "duplicate view '%s'", views[view].id);
        }
    }
    return true;
}
