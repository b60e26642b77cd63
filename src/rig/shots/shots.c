#include "rig/shots/shots.h"
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include "core/base/arena.h"
#include "core/base/call.h"
#include "core/base/file.h"
#include "core/base/log.h"
#include "core/image/photograph.h"
#include "core/patterns/patterns.h"
#include "rig/shots/file_names.h"
#include "rig/shots/sets.h"

// Settings, for errors.
#define IMAGES "images"
#define PATTERNS "patterns"
#define HELD_OUT "held_out"
#define EMPTY "empty"

// --- Photographs under some patterns. ---

typedef struct Group {
    int patterns[FFP_PATTERNS_MAX], count;
    const char *template;
} Group;

static int known_pattern(const FfpShots *shots, const char *name) {
    for (int i = 0; i < shots->n_patterns; i++)
        if (strcmp(shots->patterns[i].name, name) == 0) return i;
    return -1;
}

// The same; a name that is not known is a new pattern's.
static int pattern_index(FfpShots *shots, const char *name, FfpError *err) {
    const int known = known_pattern(shots, name);
    if (known >= 0) return known;
    if (!ffp_is_name(name) || shots->n_patterns == FFP_PATTERNS_MAX) {
        ffp_fail(err, FFP_ERROR_ARGUMENT, IMAGES, "invalid pattern name '%.100s', or too many patterns",
                 name);
        return -1;
    }
    snprintf(shots->patterns[shots->n_patterns].name, FFP_NAME_MAX, "%s", name);
    const bool black = strcmp(name, "black") == 0 || strcmp(name, "all_black") == 0;
    const bool white = strcmp(name, "white") == 0 || strcmp(name, "all_white") == 0;
    if ((black && shots->black >= 0) || (white && shots->white >= 0)) {
        ffp_fail(err, FFP_ERROR_ARGUMENT, IMAGES, "'%s' is a second %s pattern", name,
                 black ? "black" : "white");
        return -1;
    }
    if (black) shots->black = shots->n_patterns;
    if (white) shots->white = shots->n_patterns;
    return shots->n_patterns++;
}

static bool read_group(FfpShots *shots, const FfpImportImages *source, Group *group, FfpError *err) {
    if (!source->files || source->files[0] == 0)
        return ffp_fail(err, FFP_ERROR_ARGUMENT, IMAGES, "no file given");
    if (source->n_patterns < 1 || source->n_patterns > FFP_PATTERNS_MAX)
        return ffp_fail(err, FFP_ERROR_ARGUMENT, IMAGES, "%d patterns for '%.100s': expected 1 to %d",
                        source->n_patterns, source->files, FFP_PATTERNS_MAX);
    group->template = source->files;
    group->count = source->n_patterns;
    for (int i = 0; i < source->n_patterns; i++) {
        group->patterns[i] = pattern_index(shots, source->patterns[i], err);
        if (group->patterns[i] < 0) return false;
    }
    return true;
}

static bool set_picture(FfpShots *shots, const FfpCalibration *calibration, int stop, int pattern,
                        const char *path, FfpError *err) {
    const char **place = &shots->pictures[stop * FFP_PATTERNS_MAX + pattern];
    if (*place)
        return ffp_fail(err, FFP_ERROR_ARGUMENT, IMAGES, "view '%s' has two pictures under '%s'",
                        calibration->stops[stop].id, shots->patterns[pattern].name);
    *place = path;
    return true;
}

static bool find_group(FfpShots *shots, const Group *group, const FfpCalibration *calibration,
                       FfpError *err) {
    const int n = group->count, all = calibration->n_stops * n;
    const char **names = ffp_arena_alloc(shots->arena, (size_t)n, sizeof *names),
               **paths = ffp_arena_alloc(shots->arena, (size_t)all, sizeof *paths);
    for (int i = 0; i < n; i++) names[i] = shots->patterns[group->patterns[i]].name;
    const FfpFileSet set = {group->template, calibration, names, n, "photographs", "pattern", "", false};
    if (!ffp_files_find(paths, shots->arena, &set, err)) return false;
    for (int i = 0; i < all; i++)
        if (!set_picture(shots, calibration, i / n, group->patterns[i % n], paths[i], err)) return false;
    return true;
}

// --- Photographs of everything that was shown. ---

// Black, white and the codes alone, [stops,n], are as many as all of which one is missing, unless the files'
// numbers have no gap, or only that of the `others` between white and the codes.
static bool without_gaps(const char *const *paths, int stops, int n, int others, FfpError *err) {
    for (int stop = 0; stop < stops; stop++) {
        const char *const *files = paths + (ptrdiff_t)stop * n;
        int count;
        const int gap = ffp_find_gap(files, n, &count);
        if (gap >= 0 && (gap != 2 || count != others))
            return ffp_fail(err, FFP_ERROR_FILE, files[gap],
                            "by the numbers of the files a photograph is missing before this one");
    }
    return true;
}

// All that was shown, but for photographs of codes, which the numbers in the names tell.
static bool find_with_gaps(const char **paths, FfpShots *shots, const char *template,
                           const FfpCalibration *calibration, const char **names) {
    const int n = shots->shown.n, others = n - shots->shown.n_codes;
    const FfpFileSet set = {template, calibration, names, n, "photographs", "pattern", "", true};
    FfpError none = {0};
    for (int i = 0; i < n; i++) names[i] = shots->shown.patterns[i].name;
    memset(paths, 0, (size_t)calibration->n_stops * (size_t)n * sizeof *paths);
    if (!ffp_files_find(paths, shots->arena, &set, &none)) return false;
    // Where the last one is missing, the files' numbers may be the camera's own, which tell nothing.
    for (int i = 0; i < calibration->n_stops * n; i++)
        if (!paths[i] && (i % n < others || i % n == n - 1)) return false;
    return true;
}

// The paths [n_stops, *plain + *codes] of all that was shown or, where there are fewer photographs, of those
// before the codes, or of black, white and the codes.
static const char **find_shown(FfpShots *shots, const char *template, const FfpCalibration *calibration,
                               int *plain, int *codes, FfpError *err) {
    const FfpShown *shown = &shots->shown;
    const int others = shown->n - shown->n_codes;
    const char **names = ffp_arena_alloc(shots->arena, (size_t)shown->n, sizeof *names),
               **paths = ffp_arena_alloc(shots->arena, (size_t)calibration->n_stops * (size_t)shown->n,
                                         sizeof *paths);
    char order[160] = "";
    if (shown->n_codes > 0)
        snprintf(order, sizeof order,
                 " for all that was shown, %d without the Gray codes, or %d for black, white and these alone",
                 others, 2 + shown->n_codes);
    for (int kind = FFP_SHOWN_ALL; kind < FFP_SHOWN_KINDS; kind++) {
        if (!ffp_shown_photographed(shown, kind, plain, codes)) continue;
        const int n = *plain + *codes;
        for (int i = 0; i < n; i++) names[i] = shown->patterns[i < *plain ? i : shown->n - n + i].name;
        const FfpFileSet set = {
            template, calibration, names, n, "photographs", "pattern", kind == FFP_SHOWN_ALL ? order : "",
            false};
        FfpError error = {0};
        paths[0] = NULL;
        if (ffp_files_find(paths, shots->arena, &set, &error)) {
            if (kind != FFP_SHOWN_CODES || without_gaps(paths, calibration->n_stops, n, others - 2, err))
                return paths;
            break;
        }
        // The first view has no codes where paths[0] is set: another one is to blame.
        if (err && (kind == FFP_SHOWN_ALL || paths[0])) *err = error;
    }
    if (shown->n_codes == 0 || !find_with_gaps(paths, shots, template, calibration, names)) return NULL;
    *plain = others, *codes = shown->n_codes;
    if (err) *err = (FfpError){0};
    return paths;
}

// Photographs of greys tell the projector's response, and belong to no pattern.
static void take_greys(FfpShots *shots, const char **paths, int stops, int plain, int n) {
    if (shots->greys) return;
    shots->grey = ffp_arena_alloc(shots->arena, (size_t)plain, sizeof *shots->grey);
    for (int p = 0; p < plain; p++) {
        const int value = ffp_grey_named(shots->shown.patterns[p].name);
        if (value > 0) shots->grey[shots->n_greys++] = value;
    }
    shots->greys =
        ffp_arena_alloc(shots->arena, (size_t)stops * (size_t)shots->n_greys + 1, sizeof *shots->greys);
    for (int stop = 0, k = 0; stop < stops; stop++)
        for (int p = 0; p < plain; p++)
            if (ffp_grey_named(shots->shown.patterns[p].name) > 0) shots->greys[k++] = paths[stop * n + p];
}

// Places for the codes of every view.
static bool make_room(FfpShots *shots, int stops, int codes, FfpError *err) {
    if (shots->codes) return ffp_fail(err, FFP_ERROR_ARGUMENT, IMAGES, "the Gray codes come twice");
    shots->n_codes = codes;
    shots->codes = ffp_arena_alloc(shots->arena, (size_t)stops * (size_t)codes, sizeof *shots->codes);
    return true;
}

// Black, white and codes in another order, or fewer of them.
static bool take_set(FfpShots *shots, const char *template, const FfpCalibration *calibration, bool linear,
                     FfpError *err) {
    const FfpShown *shown = &shots->shown;
    const FfpGrayPhotographs panel = {.width = shown->width, .height = shown->height, .linear = linear};
    if (shown->n_codes == 0 || pattern_index(shots, shown->patterns[0].name, NULL) < 0 ||
        pattern_index(shots, shown->patterns[1].name, NULL) < 0 ||
        !make_room(shots, calibration->n_stops, shown->n_codes, NULL) ||
        !ffp_sets_find(shots, template, calibration, shown, &panel))
        return false; // and what was not found is the error
    if (shown->n > shown->n_codes + 2)
        ffp_note("%s: not all that was shown was photographed of every view: black, white and the Gray codes "
                 "alone are taken",
                 template);
    if (err) *err = (FfpError){0};
    return true;
}

static bool take_all_shown(FfpShots *shots, const FfpImport *sources, const char *template,
                           const FfpCalibration *calibration, FfpError *err) {
    const int stops = calibration->n_stops;
    const FfpShown *shown = &shots->shown;
    int plain, codes;
    if (!template || template[0] == 0) return ffp_fail(err, FFP_ERROR_ARGUMENT, IMAGES, "no file is named");
    if (!shown->arena)
        return ffp_fail(err, FFP_ERROR_ARGUMENT, IMAGES, "'%.100s' is without names of patterns", template);
    const char **paths = find_shown(shots, template, calibration, &plain, &codes, err);
    if (!paths) return take_set(shots, template, calibration, sources->linear_images, err);
    const int n = plain + codes;
    take_greys(shots, paths, stops, plain, n);
    for (int p = 0; p < plain; p++) {
        if (ffp_grey_named(shown->patterns[p].name) > 0) continue;
        const int pattern = pattern_index(shots, shown->patterns[p].name, err);
        if (pattern < 0) return false;
        for (int stop = 0; stop < stops; stop++)
            if (!set_picture(shots, calibration, stop, pattern, paths[stop * n + p], err)) return false;
    }
    if (codes == 0) return true;
    if (!make_room(shots, stops, codes, err)) return false;
    for (int i = 0; i < stops * codes; i++) shots->codes[i] = paths[i / codes * n + plain + i % codes];
    if (plain == 2) shots->others = shown->n - codes - plain;
    ffp_sets_sort_found(shots, stops,
                        &(FfpGrayPhotographs){.width = shown->width,
                                              .height = shown->height,
                                              .others = shots->others,
                                              .linear = sources->linear_images});
    return true;
}

// --- Patterns and masks. ---

static bool take_projected(FfpShots *shots, const FfpImportPattern *projected, bool novel, FfpError *err) {
    const char *where = novel ? HELD_OUT : PATTERNS;
    for (int i = 0; i < shots->n_patterns; i++) {
        FfpShotPattern *pattern = &shots->patterns[i];
        if (strcmp(pattern->name, projected->name) != 0) continue;
        if (pattern->file)
            return ffp_fail(err, FFP_ERROR_ARGUMENT, where, "duplicate pattern '%s'", pattern->name);
        if (!ffp_is_file(projected->file))
            return ffp_fail(err, FFP_ERROR_ARGUMENT, projected->file, "no such file: pattern '%s'",
                            pattern->name);
        pattern->file = ffp_arena_text(shots->arena, projected->file);
        pattern->novel = novel;
        return true;
    }
    return ffp_fail(err, FFP_ERROR_ARGUMENT, IMAGES, "no picture under pattern '%.100s'", projected->name);
}

// Pictures that the calibration names itself, where the caller names none.
static bool take_named(FfpShots *shots, const FfpCalibration *calibration, FfpError *err) {
    for (int i = 0; i < calibration->n_pictures; i++) {
        const FfpNamedPicture *picture = &calibration->pictures[i];
        const int pattern = pattern_index(shots, picture->pattern, err);
        char what[2 * FFP_NAME_MAX + 32];
        snprintf(what, sizeof what, "view '%s' under pattern '%s'", calibration->stops[picture->stop].id,
                 picture->pattern);
        if (pattern < 0 || !ffp_photograph_check(picture->path, what, err) ||
            !set_picture(shots, calibration, picture->stop, pattern,
                         ffp_arena_text(shots->arena, picture->path), err))
            return false;
    }
    return true;
}

// Patterns as they were shown.
static void take_shown_patterns(FfpShots *shots) {
    for (int i = 0; i < shots->n_patterns; i++)
        for (int k = 0; k < shots->shown.n; k++)
            if (!shots->patterns[i].file && i != shots->black && i != shots->white &&
                strcmp(shots->patterns[i].name, shots->shown.patterns[k].name) == 0)
                shots->patterns[i].file = ffp_arena_text(shots->arena, shots->shown.patterns[k].file);
}

// Patterns that lie where the calibration keeps them.
static void take_kept_patterns(FfpShots *shots, const char *folder) {
    for (int i = 0; i < shots->n_patterns && folder[0] != 0; i++) {
        char name[FFP_NAME_MAX + 8], path[FFP_PATH_MAX];
        snprintf(name, sizeof name, "%s.png", shots->patterns[i].name);
        const bool plain = i == shots->black || i == shots->white;
        if (!plain && !shots->patterns[i].file && ffp_join_path(path, folder, name) && ffp_is_file(path))
            shots->patterns[i].file = ffp_arena_text(shots->arena, path);
    }
}

static bool find_masks(FfpShots *shots, const char *template, const FfpCalibration *calibration,
                       FfpError *err) {
    if (!template || template[0] == 0)
        return ffp_fail(err, FFP_ERROR_ARGUMENT, "mask_files", "no file given");
    shots->masks = ffp_arena_alloc(shots->arena, (size_t)calibration->n_stops, sizeof *shots->masks);
    const FfpFileSet set = {template, calibration, NULL, 1, "masks", "", "", false};
    return ffp_files_find(shots->masks, shots->arena, &set, err);
}

// --- The empty stage. ---

// Paths [n_stops, n]: of each view, or the same for all of them.
static bool find_empty_files(const char **paths, FfpShots *shots, const FfpImportImages *source,
                             const FfpCalibration *calibration, FfpError *err) {
    const char *files = source->files;
    const bool by_view = ffp_files_by_view(files);
    const int n = source->n_patterns, stops = calibration->n_stops;
    const FfpFileSet set = {
        files, calibration, source->patterns, n, "photographs of the empty stage", "pattern", "", false};
    FfpCalibration first = *calibration; // which stands for all
    FfpFileSet of_all = set;
    FfpError none = {0};
    first.n_stops = 1, of_all.calibration = &first;
    if (by_view) return ffp_files_find(paths, shots->arena, &set, err);
    if (!ffp_files_find(paths, shots->arena, &of_all,
                        strchr(files, '*') ? &none : err)) // * may be all views'
        return strchr(files, '*') && ffp_files_find(paths, shots->arena, &set, err);
    for (int i = n; i < stops * n; i++) paths[i] = paths[i - n];
    return true;
}

// Files of one pattern of the empty stage, or of several.
static bool find_empty(FfpShots *shots, const FfpImportImages *source, const FfpCalibration *calibration,
                       FfpError *err) {
    const int n = source->n_patterns, stops = calibration->n_stops;
    if (!source->files || source->files[0] == 0 || n < 1)
        return ffp_fail(err, FFP_ERROR_ARGUMENT, EMPTY, "no file is named");
    const char **paths = ffp_arena_alloc(shots->arena, (size_t)stops * (size_t)n, sizeof *paths);
    if (!find_empty_files(paths, shots, source, calibration, err)) return false;
    for (int i = 0; i < n; i++) {
        const int pattern = known_pattern(shots, source->patterns[i]);
        if (pattern < 0)
            return ffp_fail(err, FFP_ERROR_ARGUMENT, EMPTY, "no photographs under pattern '%.100s' (images)",
                            source->patterns[i]);
        if (shots->empty[pattern])
            return ffp_fail(err, FFP_ERROR_ARGUMENT, EMPTY, "two pictures of the stage under '%s'",
                            shots->patterns[pattern].name);
        for (int v = 0; v < stops; v++) shots->empty[v * FFP_PATTERNS_MAX + pattern] = paths[v * n + i];
    }
    return true;
}

static bool find_stage(FfpShots *shots, const FfpImport *sources, const FfpCalibration *calibration,
                       FfpError *err) {
    if (sources->n_empty == 0) return true;
    if (sources->masks == FFP_MASKS_FROM_FILES)
        return ffp_fail(err, FFP_ERROR_ARGUMENT, EMPTY,
                        "files of masks are given, too: either these or the empty stage tells the object");
    shots->empty =
        ffp_arena_alloc(shots->arena, (size_t)calibration->n_stops * FFP_PATTERNS_MAX, sizeof *shots->empty);
    for (int i = 0; i < sources->n_empty; i++)
        if (!find_empty(shots, &sources->empty[i], calibration, err)) return false;
    return (shots->empty[shots->black] && shots->empty[shots->white]) ||
           ffp_fail(err, FFP_ERROR_ARGUMENT, EMPTY, "no picture of the stage under %s",
                    shots->empty[shots->black] ? "white" : "black");
}

// --- All of it. ---

// No file of a view is its picture under two patterns.
static bool check_single(const FfpShots *shots, const FfpCalibration *calibration, FfpError *err) {
    for (int stop = 0; stop < calibration->n_stops; stop++) {
        const char *const *pictures = shots->pictures + (ptrdiff_t)stop * FFP_PATTERNS_MAX;
        for (int i = 0; i < shots->n_patterns; i++)
            for (int k = 0; k < i; k++)
                if (pictures[i] && pictures[k] && strcmp(pictures[i], pictures[k]) == 0)
                    return ffp_fail(err, FFP_ERROR_FILE, pictures[i],
                                    "is named twice: view '%s' under '%.64s' and under '%.64s'",
                                    calibration->stops[stop].id, shots->patterns[k].name,
                                    shots->patterns[i].name);
    }
    return true;
}

static bool check_complete(const FfpShots *shots, const FfpImport *sources, const FfpCalibration *calibration,
                           FfpError *err) {
    const bool coded = shots->codes || sources->gray_codes; // black and white are made from the codes
    if (shots->black < 0) return ffp_fail(err, FFP_ERROR_ARGUMENT, IMAGES, "no pictures under black given");
    if (shots->white < 0) return ffp_fail(err, FFP_ERROR_ARGUMENT, IMAGES, "no pictures under white given");
    const int plain[2] = {shots->black, shots->white};
    for (int i = 0; i < 2 * calibration->n_stops; i++) {
        if (coded || shots->pictures[i / 2 * FFP_PATTERNS_MAX + plain[i % 2]] != NULL) continue;
        return ffp_fail(err, FFP_ERROR_ARGUMENT, IMAGES,
                        "view '%s' has no picture under %s: every pose must be photographed under "
                        "black, white and a pattern",
                        calibration->stops[i / 2].id, i % 2 == 0 ? "black" : "white");
    }
    for (int i = 0; i < shots->n_patterns; i++) {
        if (!shots->patterns[i].file && i != shots->black && i != shots->white)
            return ffp_fail(err, FFP_ERROR_ARGUMENT, PATTERNS,
                            "no file given for pattern '%s': name the image that was projected",
                            shots->patterns[i].name);
    }
    return true;
}

static bool find_all(FfpShots *shots, const FfpImport *sources, const FfpCalibration *calibration,
                     FfpError *err) {
    Group *group = ffp_arena_alloc(shots->arena, 1, sizeof *group);
    if (sources->n_images == 0 && !take_named(shots, calibration, err)) return false;
    for (int i = 0; i < sources->n_images; i++) {
        const FfpImportImages *images = &sources->images[i];
        const bool ok =
            images->n_patterns == 0
                ? take_all_shown(shots, sources, images->files, calibration, err)
                : read_group(shots, images, group, err) && find_group(shots, group, calibration, err);
        if (!ok) return false;
    }
    for (int i = 0; i < sources->n_patterns; i++) {
        if (!take_projected(shots, &sources->patterns[i], false, err)) return false;
    }
    for (int i = 0; i < sources->n_held_out; i++) {
        if (!take_projected(shots, &sources->held_out[i], true, err)) return false;
    }
    if (sources->gray_codes && shots->black < 0 && pattern_index(shots, "black", err) < 0) return false;
    if (sources->gray_codes && shots->white < 0 && pattern_index(shots, "white", err) < 0) return false;
    take_shown_patterns(shots);
    take_kept_patterns(shots, calibration->pattern_folder);
    return (sources->masks != FFP_MASKS_FROM_FILES ||
            find_masks(shots, sources->mask_files, calibration, err)) &&
           check_complete(shots, sources, calibration, err) && check_single(shots, calibration, err) &&
           find_stage(shots, sources, calibration, err);
}

bool ffp_shots_find(FfpShots *shots, const FfpImport *sources, const FfpCalibration *calibration,
                    FfpError *err) {
    *shots = (FfpShots){.arena = ffp_arena_new(), .black = -1, .white = -1};
    shots->patterns = ffp_arena_alloc(shots->arena, FFP_PATTERNS_MAX, sizeof *shots->patterns);
    shots->pictures = ffp_arena_alloc(shots->arena, (size_t)calibration->n_stops * FFP_PATTERNS_MAX,
                                      sizeof *shots->pictures);
    return (!sources->shown || ffp_shown_read(&shots->shown, sources->shown, err)) &&
           find_all(shots, sources, calibration, err);
}

void ffp_shots_free(FfpShots *shots) {
    if (shots->arena) ffp_arena_free(shots->arena);
    ffp_shown_free(&shots->shown);
    *shots = (FfpShots){0};
}
