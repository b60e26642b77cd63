#include "rig/shots/folders.h"
#include <dirent.h>
#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include "core/base/arena.h"
#include "core/base/call.h"
#include "core/base/file.h"
#include "core/image/photograph.h"
#include "core/patterns/shown.h"
#include "rig/findings/tell.h"
#include "rig/shots/file_names.h"

enum { FILES_MAX = 4096 };

static void close_folder(void *folder) {
    closedir(folder);
}

static bool check_names(const char *folder, const char **files, int n, FfpError *err) {
    int twins;
    const int twin = ffp_find_twins(files, n, &twins);
    if (twin >= 0 && 2 * twins >= n)
        return ffp_fail_by(
            FFP_RULE_RAW_AND_JPEG,
            &(FfpFacts){.x = twins, .a = ffp_basename(files[twin]), .b = ffp_basename(files[twin + 1])},
            folder, err);
    ffp_unwrap_numbers(files, n);
    return true;
}

// Lists the pictures of a folder, or its folders. Paths in natural order, [*n].
static bool list(FfpArena *arena, const char *folder, bool folders, const char ***paths, int *n,
                 FfpError *err) {
    DIR *directory = opendir(folder);
    if (!directory) return ffp_fail(err, FFP_ERROR_IO, folder, "cannot open: %s", strerror(errno));
    ffp_own(directory, close_folder);
    const char **found = ffp_arena_alloc(arena, FILES_MAX, sizeof *found);
    bool ok = true;
    *n = 0;
    while (ok) {
        char path[FFP_PATH_MAX];
        errno = 0;
        const struct dirent *entry = readdir(directory);
        if (!entry) {
            ok = !errno || ffp_fail(err, FFP_ERROR_IO, folder, "cannot read: %s", strerror(errno));
            break;
        }
        if (entry->d_name[0] == '.' || (!folders && !ffp_photograph_has_ending(entry->d_name))) continue;
        ok = ffp_join_path(path, folder, entry->d_name) ||
             ffp_fail(err, FFP_ERROR_ARGUMENT, folder, "the path is too long");
        if (!ok || (folders ? !ffp_is_folder(path) : !ffp_is_file(path))) continue;
        ok = *n < FILES_MAX || ffp_fail(err, FFP_ERROR_FILE, folder, "more than %d %s", FILES_MAX,
                                        folders ? "folders" : "pictures");
        if (ok) found[(*n)++] = ffp_arena_text(arena, path);
    }
    ffp_disown(directory), closedir(directory);
    qsort(found, (size_t)*n, sizeof *found, ffp_compare_paths);
    if (ok && !folders) ok = check_names(folder, found, *n, err);
    *paths = found;
    return ok;
}

static bool add(FfpShotFolders *out, const char *path, const char **files, int n_files, FfpError *err) {
    struct stat status;
    if (stat(path, &status) != 0)
        return ffp_fail(err, FFP_ERROR_IO, path, "cannot open: %s", strerror(errno));
    for (int i = 0; i < out->n; i++)
        if (out->folders[i].device == status.st_dev && out->folders[i].inode == status.st_ino)
            return ffp_fail(err, FFP_ERROR_FILE, path, "the folder is named twice");
    if (out->n == FFP_SHOT_FOLDERS_MAX)
        return ffp_fail(err, FFP_ERROR_FILE, path, "more than %d folders of photographs",
                        FFP_SHOT_FOLDERS_MAX);
    char name[FFP_PATH_MAX];
    snprintf(name, sizeof name, "%s", path);
    for (size_t end = strlen(name); end > 1 && name[end - 1] == '/';) name[--end] = 0;
    out->folders[out->n++] = (FfpShotFolder){.name = ffp_arena_text(out->arena, ffp_basename(name)),
                                             .files = files,
                                             .n_files = n_files,
                                             .device = status.st_dev,
                                             .inode = status.st_ino};
    return true;
}

static bool find(FfpShotFolders *out, const char *path, FfpError *err) {
    const char **files = NULL, **folders = NULL;
    int n_files = 0, n_folders = 0;
    const int before = out->n;
    if (!list(out->arena, path, false, &files, &n_files, err)) return false;
    if (n_files > 0) return add(out, path, files, n_files, err);
    if (!list(out->arena, path, true, &folders, &n_folders, err)) return false;
    for (int i = 0; i < n_folders; i++) {
        if (!list(out->arena, folders[i], false, &files, &n_files, err)) return false;
        if (n_files > 0 && !add(out, folders[i], files, n_files, err)) return false;
    }
    return out->n > before ||
           ffp_fail(err, FFP_ERROR_FILE, path, "no photographs in this folder or its subfolders");
}

bool ffp_shot_folders_find(FfpShotFolders *out, const char *const *paths, int n_paths, FfpError *err) {
    *out = (FfpShotFolders){.arena = ffp_arena_new()};
    out->folders = ffp_arena_alloc(out->arena, FFP_SHOT_FOLDERS_MAX, sizeof *out->folders);
    for (int i = 0; i < n_paths; i++)
        if (!find(out, paths[i], err)) return false;
    return true;
}

// Its pictures of black, white and the codes; false: it has others.
static bool take_codes(FfpShotFolder *folder, const FfpShown *shown) {
    int plain, codes;
    for (int kind = 0; kind < FFP_SHOWN_KINDS; kind++) {
        if (!ffp_shown_photographed(shown, kind, &plain, &codes) || codes == 0 ||
            folder->n_files != plain + codes)
            continue;
        for (int k = 0; k < codes; k++) folder->files[2 + k] = folder->files[plain + k];
        folder->n_files = 2 + codes;
        return true;
    }
    return false;
}

bool ffp_shot_folders_select_codes(FfpShotFolders *folders, const char *shown_folder, int *width, int *height,
                                   FfpError *err) {
    FfpShown shown;
    bool ok = ffp_shown_read(&shown, shown_folder, err);
    if (ok && shown.n_codes == 0)
        ok = ffp_fail(err, FFP_ERROR_FILE, shown_folder,
                      "has no Gray codes, which a calibration is made from");
    for (int i = 0; ok && i < folders->n; i++) {
        FfpShotFolder *folder = &folders->folders[i];
        char problem[FFP_PATH_MAX + 160];
        if (take_codes(folder, &shown)) continue;
        snprintf(problem, sizeof problem,
                 "%d photographs, but %s has %d patterns: one photograph of each is needed, or of black, "
                 "white and the %d Gray codes alone",
                 folder->n_files, shown_folder, shown.n, shown.n_codes);
        folder->problem = ffp_arena_text(folders->arena, problem);
    }
    if (ok) *width = shown.width, *height = shown.height;
    ffp_shown_free(&shown);
    return ok;
}

void ffp_shot_folders_free(FfpShotFolders *out) {
    ffp_arena_free(out->arena);
    *out = (FfpShotFolders){0};
}
