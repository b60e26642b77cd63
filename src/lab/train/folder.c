// Training scenes from a folder made by `ffprocams generate`.
#include <dirent.h>
#include <errno.h>
#include <stdlib.h>
#include <string.h>
#include "core/base/arena.h"
#include "core/base/call.h"
#include "core/base/file.h"
#include "core/base/rng.h"
#include "lab/train/prepare.h"

// --- The list of scenes. ---

// Only the training split: whoever generates all splits into one folder still trains on this one alone.
static bool is_scene_name(const char *name) {
    static const char prefix[] = "train_";
    const size_t length = sizeof prefix - 1;
    if (strncmp(name, prefix, length) != 0) return false;
    const size_t digits = strspn(name + length, "0123456789");
    return digits >= 1 && name[length + digits] == 0 && length + digits < FFP_SCENE_NAME_MAX;
}

static int by_name(const void *a, const void *b) {
    return strcmp(a, b);
}

static void add_name(FfpSceneFolder *folder, const char *name) {
    const size_t count = (size_t)folder->count, size = sizeof *folder->names;
    if ((count & (count - 1)) == 0) { // 0 and the powers of two: full
        void *larger = ffp_alloc(count ? 2 * count : 1, size);
        if (count) memcpy(larger, folder->names, count * size);
        ffp_free(folder->names);
        folder->names = larger;
    }
    memcpy(folder->names[count], name, strlen(name) + 1); // is_scene_name knows that it fits
    folder->count++;
}

static void close_folder(void *entries) {
    closedir(entries);
}

bool ffp_scene_folder_open(FfpSceneFolder *folder, const char *path, FfpError *err) {
    *folder = (FfpSceneFolder){0};
    if (strlen(path) >= sizeof folder->path)
        return ffp_fail(err, FFP_ERROR_ARGUMENT, path, "path is too long");
    memcpy(folder->path, path, strlen(path) + 1);
    DIR *entries = opendir(path);
    if (!entries)
        return ffp_fail(err, FFP_ERROR_IO, path, "cannot read the folder of scenes: %s", strerror(errno));
    ffp_own(entries, close_folder);
    for (struct dirent *entry; (entry = readdir(entries)) != NULL;)
        if (is_scene_name(entry->d_name)) add_name(folder, entry->d_name);
    ffp_disown(entries);
    closedir(entries);
    if (folder->count == 0)
        return ffp_fail(err, FFP_ERROR_FILE, path,
                        "holds no scene of the training split (train_00000 and so on)");
    qsort(folder->names, (size_t)folder->count, sizeof *folder->names, by_name);
    return true;
}

void ffp_scene_folder_close(FfpSceneFolder *folder) {
    ffp_free(folder->names);
    *folder = (FfpSceneFolder){0};
}

const char *ffp_scene_folder_name(const FfpSceneFolder *folder, int64_t seed, int64_t number) {
    const int64_t round = number / folder->count, wanted = number % folder->count;
    int64_t *order = ffp_alloc((size_t)folder->count, sizeof *order);
    FfpRng rng = ffp_rng((uint64_t)seed, (uint64_t)round);
    for (int64_t i = 0; i < folder->count; i++) order[i] = i;
    for (int64_t i = 0; i <= wanted; i++) { // Fisher and Yates, as far as it is needed
        const int64_t k = i + (int64_t)ffp_rng_below(&rng, (uint32_t)(folder->count - i)), swap = order[k];
        order[k] = order[i];
        order[i] = swap;
    }
    const char *name = folder->names[order[wanted]];
    ffp_free(order);
    return name;
}

// --- One scene. ---

void ffp_scene_append_views(FfpCapture *capture, FfpCapture *more) {
    const size_t n = (size_t)capture->n_views, m = (size_t)more->n_views;
    FfpView *views = ffp_alloc(n + m, sizeof *views);
    memcpy(views, capture->views, n * sizeof *views);
    memcpy(views + n, more->views, m * sizeof *views);
    for (size_t v = n; v < n + m; v++)
        for (int p = capture->n_patterns; p < more->n_patterns; p++) ffp_image_free(&views[v].images[p]);
    ffp_free(capture->views);
    capture->views = views;
    capture->n_views += more->n_views;
    more->n_views = 0;
}

// Black, white and the first lollipops, by number, into chosen [2 + lollipops].
static bool choose_patterns(const FfpCapture *capture, int lollipops, int *chosen, const char *json,
                            FfpError *err) {
    int count = 0;
    for (int p = 0; p < capture->n_patterns && count < lollipops; p++) {
        const bool plain = p == capture->black || p == capture->white;
        if (!plain && !capture->patterns[p].novel) chosen[2 + count++] = p;
    }
    chosen[0] = capture->black;
    chosen[1] = capture->white;
    return count == lollipops ||
           ffp_fail(err, FFP_ERROR_FILE, ffp_place(json, "patterns").text,
                    "%d patterns besides black and white; the configuration's lollipops asks for %d", count,
                    lollipops);
}

void ffp_scene_keep_patterns(FfpCapture *capture, const int *chosen, int count) {
    FfpPattern *patterns = ffp_alloc((size_t)count, sizeof *patterns);
    for (int k = 0; k < count; k++) {
        patterns[k] = capture->patterns[chosen[k]];
        capture->patterns[chosen[k]].image = (FfpImage){0};
    }
    for (int p = 0; p < capture->n_patterns; p++) ffp_image_free(&capture->patterns[p].image);
    ffp_free(capture->patterns);
    for (int v = 0; v < capture->n_views; v++) {
        FfpImage *before = capture->views[v].images, *images = ffp_alloc((size_t)count, sizeof *images);
        for (int k = 0; k < count; k++) {
            images[k] = before[chosen[k]];
            before[chosen[k]] = (FfpImage){0};
        }
        for (int p = 0; p < capture->n_patterns; p++) ffp_image_free(&before[p]);
        ffp_free(before);
        capture->views[v].images = images;
    }
    capture->patterns = patterns;
    capture->n_patterns = count;
    capture->n_codes = 0;
    capture->black = 0;
    capture->white = 1;
}

// That the view has the size and all the pictures and maps that the configuration gives weight to.
static bool check_view(const FfpView *view, const FfpTrainConfig *c, const int *chosen, const char *json,
                       FfpError *err) {
    char field[FFP_NAME_MAX + 64];
    snprintf(field, sizeof field, "view '%.95s', camera", view->id);
    if (view->camera.width != c->resolution || view->camera.height != c->resolution)
        return ffp_fail(err, FFP_ERROR_FILE, ffp_place(json, field).text,
                        "pictures of %d x %d; the configuration's resolution asks for %d", view->camera.width,
                        view->camera.height, c->resolution);
    snprintf(field, sizeof field, "view '%.95s', images", view->id);
    for (int k = 0; k < 2 + c->lollipops; k++)
        if (!view->images[chosen[k]].data)
            return ffp_fail(err, FFP_ERROR_FILE, ffp_place(json, field).text,
                            "a picture under a pattern is missing");
    const struct {
        const char *name;
        const FfpImage *map;
        bool wanted;
    } maps[] = {{"depth", &view->depth, true},
                {"normal", &view->normal, c->truth_normal > 0},
                {"albedo", &view->albedo, c->truth_albedo > 0},
                {"roughness", &view->roughness, c->truth_roughness > 0}};
    for (size_t i = 0; i < sizeof maps / sizeof *maps; i++) {
        snprintf(field, sizeof field, "view '%.95s', %s", view->id, maps[i].name);
        if (maps[i].wanted && !maps[i].map->data)
            return ffp_fail(err, FFP_ERROR_FILE, ffp_place(json, field).text,
                            "a true map that the configuration uses is missing");
    }
    return true;
}

// Drops the views from `count` on.
static void keep_views(FfpCapture *capture, int count) {
    FfpCapture rest = {.n_patterns = capture->n_patterns, .n_views = capture->n_views - count};
    rest.views = ffp_alloc((size_t)rest.n_views, sizeof *rest.views);
    memcpy(rest.views, capture->views + count, (size_t)rest.n_views * sizeof *rest.views);
    capture->n_views = count;
    ffp_capture_free(&rest);
}

typedef struct Part { // input views or new poses: what is asked of their file
    const char *json, *field;
    int views;
} Part;

static bool check_part(const FfpCapture *capture, const Part *part, const FfpTrainConfig *config,
                       const int *chosen, FfpError *err) {
    if (capture->n_views < part->views)
        return ffp_fail(err, FFP_ERROR_FILE, ffp_place(part->json, "views").text,
                        "holds %d views; the configuration's %s asks for %d", capture->n_views, part->field,
                        part->views);
    for (int v = 0; v < part->views; v++)
        if (!check_view(&capture->views[v], config, chosen, part->json, err)) return false;
    return true;
}

// The new poses of a scene, behind its input views.
static bool read_targets(FfpCapture *capture, const FfpTrainConfig *config, const char *folder,
                         const int *chosen, FfpError *err) {
    char json[FFP_PATH_MAX];
    if (!ffp_join_path(json, folder, "targets/scene.json"))
        return ffp_fail(err, FFP_ERROR_ARGUMENT, folder, "path is too long");
    if (!ffp_is_file(json))
        return ffp_fail(err, FFP_ERROR_FILE, json,
                        "the scene has no new poses; the configuration's targets asks for %d",
                        config->targets);
    const Part part = {json, "targets", config->targets};
    FfpCapture targets = {0};
    if (!ffp_capture_read_targets(&targets, json, capture, err)) return false;
    const bool ok = check_part(&targets, &part, config, chosen, err);
    if (ok) {
        keep_views(&targets, config->targets);
        ffp_scene_append_views(capture, &targets);
    }
    ffp_capture_free(&targets);
    return ok;
}

bool ffp_scene_folder_read(FfpCapture *capture, const FfpSceneFolder *folder, const char *name,
                           const FfpTrainConfig *config, FfpError *err) {
    char path[FFP_PATH_MAX], json[FFP_PATH_MAX];
    if (!ffp_join_path(path, folder->path, name) || !ffp_join_path(json, path, "scene.json"))
        return ffp_fail(err, FFP_ERROR_ARGUMENT, folder->path, "path is too long");
    const Part part = {json, "views", config->views};
    int *chosen = ffp_alloc((size_t)config->lollipops + 2, sizeof *chosen);
    bool ok = ffp_capture_read(capture, json, err) &&
              choose_patterns(capture, config->lollipops, chosen, json, err) &&
              check_part(capture, &part, config, chosen, err);
    if (ok) keep_views(capture, config->views);
    if (ok && config->targets > 0) ok = read_targets(capture, config, path, chosen, err);
    if (ok)
        ffp_scene_keep_patterns(capture, chosen, config->lollipops + 2);
    else
        ffp_capture_free(capture);
    ffp_free(chosen);
    return ok;
}
