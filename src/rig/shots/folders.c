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
#include "core/patterns/patterns.h"
#include "rig/findings/tell.h"
#include "rig/graycode/orders.h"
#include "rig/shots/file_names.h"

enum { FILES_MAX = 4096, DEPTH_MAX = 8, PLAIN = 2 };

static void close_folder(void *folder) {
    closedir(folder);
}

static bool fail_twins(const char *const *files, int twin, int twins, const char *folder, FfpError *err) {
    return ffp_fail_by(
        FFP_RULE_RAW_AND_JPEG,
        &(FfpFacts){.x = twins, .a = ffp_basename(files[twin]), .b = ffp_basename(files[twin + 1])}, folder,
        err);
}

static bool check_names(const char *folder, const char **files, int n, FfpError *err) {
    int twins;
    const int twin = ffp_find_twins(files, n, &twins);
    if (twin >= 0 && 2 * twins >= n) return fail_twins(files, twin, twins, folder, err);
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

// A folder's pictures: of two, black and white, and a single folder with more, both.
static bool list_pictures(FfpArena *arena, const char *folder, const char ***files, int *n, FfpError *err) {
    const char **codes, **folders;
    int n_codes, n_folders;
    if (!list(arena, folder, false, files, n, err)) return false;
    if (*n != PLAIN) return true;
    if (!list(arena, folder, true, &folders, &n_folders, err)) return false;
    if (n_folders != 1) return true;
    if (!list(arena, folders[0], false, &codes, &n_codes, err)) return false;
    if (n_codes <= PLAIN) return true;
    const char **all = ffp_arena_alloc(arena, (size_t)*n + (size_t)n_codes, sizeof *all);
    memcpy(all, *files, (size_t)*n * sizeof *all);
    memcpy(all + *n, codes, (size_t)n_codes * sizeof *all);
    *files = all, *n += n_codes;
    return true;
}

static bool find(FfpShotFolders *out, const char *path, FfpError *err) {
    const char **files = NULL, **folders = NULL;
    int n_files = 0, n_folders = 0;
    const int before = out->n;
    if (!list_pictures(out->arena, path, &files, &n_files, err)) return false;
    if (n_files > 0) return add(out, path, files, n_files, err);
    if (!list(out->arena, path, true, &folders, &n_folders, err)) return false;
    for (int i = 0; i < n_folders; i++) {
        if (!list_pictures(out->arena, folders[i], &files, &n_files, err)) return false;
        if (n_files > 0 && !add(out, folders[i], files, n_files, err)) return false;
    }
    return out->n > before ||
           ffp_fail(err, FFP_ERROR_FILE, path, "no photographs in this folder or its subfolders");
}

// Paths in the order that a shell puts them in, by their bytes, are taken in natural order: stop45 comes
// before stop135. Any other order is the caller's.
static const char **in_natural_order(FfpArena *arena, const char *const *paths, int n) {
    const char **sorted = ffp_arena_alloc(arena, (size_t)n + 1, sizeof *sorted);
    bool by_bytes = true, same = true;
    for (int i = 0; i < n; i++) {
        sorted[i] = paths[i];
        by_bytes = by_bytes && (i == 0 || strcmp(paths[i - 1], paths[i]) < 0);
    }
    if (!by_bytes) return sorted;
    qsort(sorted, (size_t)n, sizeof *sorted, ffp_compare_paths);
    int first = 0;
    for (int i = n - 1; i >= 0; i--)
        if (sorted[i] != paths[i]) same = false, first = i;
    if (!same) ffp_tell(FFP_RULE_FOLDERS_ORDER, &(FfpFacts){.a = sorted[first], .b = paths[first]});
    return sorted;
}

// The k-th part from the end of the path to a folder's files, 0 being the folder; NULL: there is none.
static const char *part_of(FfpArena *arena, const FfpShotFolder *folder, int k) {
    const char *start = folder->files[0], *end = NULL;
    const char *at = start + strlen(start);
    for (int i = 0; i <= k + 1; i++) {
        end = at;
        while (at > start && at[-1] != '/') at--;
        if (i <= k && at == start) return NULL;
        const char *first = at;
        while (at > start && at[-1] == '/') at--;
        if (i <= k) continue;
        char name[FFP_PATH_MAX];
        snprintf(name, sizeof name, "%.*s", (int)(end - first), first);
        return name[0] && name[0] != '.' ? ffp_arena_text(arena, name) : NULL;
    }
    return NULL;
}

static bool are_unique(const char *const *names, int n) {
    for (int i = 0; i < n; i++)
        for (int k = 0; k <= i; k++)
            if (!names[i] || (k < i && strcmp(names[i], names[k]) == 0)) return false;
    return true;
}

// The last parts of the path to a folder's files, depth + 1 of them: "monday-left-shots"; NULL: there are
// fewer.
static const char *parts_of(FfpArena *arena, const FfpShotFolder *folder, int depth) {
    char name[FFP_PATH_MAX] = "";
    for (int k = depth; k >= 0; k--) {
        const char *part = part_of(arena, folder, k);
        const size_t length = strlen(name);
        if (!part) return NULL;
        snprintf(name + length, sizeof name - length, "%s%s", length ? "-" : "", part);
    }
    return ffp_arena_text(arena, name);
}

// Folders of one name in several places are called by the first part of their paths that tells them apart, or
// by several.
static void name_apart(FfpShotFolders *out) {
    const char *names[FFP_SHOT_FOLDERS_MAX];
    for (int try = 0; try < 2 * DEPTH_MAX; try++) {
        const int depth = try % DEPTH_MAX;
        for (int i = 0; i < out->n; i++)
            names[i] = try == 0 ? out->folders[i].name
                                : (try < DEPTH_MAX ? part_of : parts_of)(out->arena, &out->folders[i], depth);
        if (!are_unique(names, out->n)) continue;
        for (int i = 0; i < out->n; i++) out->folders[i].name = names[i];
        return;
    }
}

bool ffp_shot_folders_find(FfpShotFolders *out, const char *const *paths, int n_paths, FfpError *err) {
    *out = (FfpShotFolders){.arena = ffp_arena_new()};
    out->folders = ffp_arena_alloc(out->arena, FFP_SHOT_FOLDERS_MAX, sizeof *out->folders);
    const char **ordered = in_natural_order(out->arena, paths, n_paths);
    for (int i = 0; i < n_paths; i++)
        if (!find(out, ordered[i], err)) return false;
    name_apart(out);
    return true;
}

// The first of *lost patterns, black or a code, whose number none of the files has; NULL: the files have
// numbers of their own, as a camera gives, or no needed pattern is missing.
static const FfpShownPattern *find_missing(const FfpShotFolder *folder, const FfpShown *shown, int *lost) {
    int digits;
    const int at = ffp_find_gap(folder->files, folder->n_files, lost), first = shown->patterns[0].number;
    const long from = ffp_last_number(folder->files[0], &digits),
               to = ffp_last_number(folder->files[folder->n_files - 1], &digits);
    if (folder->n_files == shown->n - 1 && from == first + 1 && to == shown->patterns[shown->n - 1].number &&
        *lost == 0 && at < 0) {
        *lost = 1;
        return &shown->patterns[0];
    }
    if (at < 0 || from != first) return NULL;
    const bool missing = at > 0 && folder->n_files + *lost == shown->n && ffp_shown_is_code(shown, at);
    return missing ? &shown->patterns[at] : NULL;
}

// True if the files are the first of all that was shown, by their numbers: ffp_gray_find_plain looks at them.
static bool are_first(const FfpShotFolder *folder, const FfpShown *shown) {
    int digits, lost;
    return folder->n_files <= shown->n / 2 && ffp_find_gap(folder->files, folder->n_files, &lost) < 0 &&
           ffp_last_number(folder->files[0], &digits) == shown->patterns[0].number;
}

// Notes which codes are missing, NULL among a folder's files.
static void tell_missing(const FfpShotFolder *folder, const FfpShown *shown) {
    const char *const *codes = folder->files + 2;
    for (int i = 0; i < folder->n_files - 2; i++) {
        FfpGrayLost lost = {.after = true, .made = codes[i ^ 1] != NULL};
        if (codes[i]) continue;
        for (int before = i - 1; !lost.beside; before--) lost.beside = codes[before];
        ffp_gray_code_name(shown->width, i, lost.name);
        ffp_gray_tell_lost(&lost);
    }
}

// Its pictures of black, white and the codes, by the numbers of the files.
static void take_codes_by_number(FfpShotFolder *folder, const FfpShown *shown, FfpArena *arena) {
    const char **files = ffp_arena_alloc(arena, (size_t)shown->n_codes + 2, sizeof *files);
    int n = 0, digits;
    for (int i = 0; i < folder->n_files; i++) {
        int at = (int)ffp_last_number(folder->files[i], &digits) - shown->patterns[0].number;
        if (at >= 2) at = at < shown->n && ffp_shown_is_code(shown, at) ? at - folder->others : -1;
        if (at < 0) continue;
        files[at] = folder->files[i];
        if (n <= at) n = at + 1;
    }
    const int first = files[0] ? 0 : 1; // ffp_gray_find_plain finds that black is missing
    folder->files = files + first, folder->n_files = n - first, folder->others = 0;
    if (first == 0) tell_missing(folder, shown);
}

// Its pictures of black, white and the codes; false: it has others.
static bool take_codes(FfpShotFolder *folder, const FfpShown *shown) {
    int plain, codes;
    for (int kind = 0; kind < FFP_SHOWN_KINDS; kind++) {
        if (!ffp_shown_photographed(shown, kind, &plain, &codes) || codes == 0 ||
            folder->n_files != plain + codes)
            continue;
        for (int k = 0; k < codes; k++) folder->files[2 + k] = folder->files[plain + k];
        if (plain > 2) folder->others = 0;
        folder->n_files = 2 + codes;
        return true;
    }
    return false;
}

// True if as many pictures may be codes in an order of other programs, as ffp_gray_find_plain finds them:
// positives alone, or as many of rows as of columns, with some missing or too many.
static bool may_be_set(const FfpShotFolder *folder, const FfpShown *shown) {
    const int bits = ffp_gray_code_bits(shown->width > shown->height ? shown->width : shown->height);
    const int codes[] = {shown->n_codes / 2, shown->n_codes, 2 * bits, 4 * bits};
    for (size_t i = 0; i < sizeof codes / sizeof *codes; i++)
        if (folder->n_files >= codes[i] - FFP_GRAY_GAPS &&
            folder->n_files <= codes[i] + 2 + folder->others + FFP_GRAY_GAPS)
            return true;
    return false;
}

const char *ffp_shot_folder_select(FfpShotFolder *folder, const FfpShown *shown, FfpArena *arena) {
    char problem[FFP_PATH_MAX + 160];
    int lost, twins;
    folder->others = shown->n - shown->n_codes - 2;
    const FfpShownPattern *missing = find_missing(folder, shown, &lost);
    const bool whole = !missing && (take_codes(folder, shown) || may_be_set(folder, shown));
    const bool by_number = !whole && (missing || are_first(folder, shown));
    if (by_number) take_codes_by_number(folder, shown, arena);
    if (whole || by_number) return NULL;
    FfpError twice = {0};
    const int twin = ffp_find_twins(folder->files, folder->n_files, &twins);
    if (twin >= 0) {
        fail_twins(folder->files, twin, twins, NULL, &twice);
        return ffp_arena_text(arena, twice.text);
    }
    snprintf(problem, sizeof problem,
             "%d photographs, but %s has %d patterns: one photograph of each is needed, or of black, "
             "white and the %d Gray codes alone",
             folder->n_files, shown->folder, shown->n, shown->n_codes);
    return ffp_arena_text(arena, problem);
}

bool ffp_shot_folders_select_codes(FfpShotFolders *folders, const char *shown_folder, int *width, int *height,
                                   FfpError *err) {
    FfpShown shown;
    bool ok = ffp_shown_read(&shown, shown_folder, err);
    if (ok && shown.n_codes == 0)
        ok = ffp_fail(err, FFP_ERROR_FILE, shown_folder,
                      "has no Gray codes, which a calibration is made from");
    for (int i = 0; ok && i < folders->n; i++)
        folders->folders[i].problem = ffp_shot_folder_select(&folders->folders[i], &shown, folders->arena);
    if (ok) *width = shown.width, *height = shown.height;
    ffp_shown_free(&shown);
    return ok;
}

bool ffp_shot_folder_size(const FfpShotFolder *folder, int *width, int *height, FfpError *err) {
    int middle = folder->n_files / 2;
    while (!folder->files[middle]) middle--; // the first exists
    return ffp_photograph_read_size(width, height, folder->files[middle], err);
}

void ffp_shot_folders_free(FfpShotFolders *out) {
    ffp_arena_free(out->arena);
    *out = (FfpShotFolders){0};
}
