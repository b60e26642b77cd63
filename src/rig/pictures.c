#include "rig/pictures.h"

#include <ctype.h>
#include <glob.h>
#include <stdlib.h>
#include <string.h>

#include "base/call.h"
#include "base/file.h"
#include "image/photograph.h"

// Settings, for errors.
#define IMAGES "images"
#define PATTERNS "patterns"
#define HELD_OUT "held_out"

// --- Names in order. ---

int ffp_natural_order(const char *a, const char *b) {
    while (*a != 0 && *b != 0) {
        if (isdigit((unsigned char)*a) && isdigit((unsigned char)*b)) {
            a += strspn(a, "0"), b += strspn(b, "0");
            const size_t m = strspn(a, "0123456789"), n = strspn(b, "0123456789");
            if (m != n) return m < n ? -1 : 1;
            const int order = strncmp(a, b, m);
            if (order != 0) return order;
            a += m, b += n;
        } else {
            if (*a != *b) return (unsigned char)*a < (unsigned char)*b ? -1 : 1;
            a++, b++;
        }
    }
    return (*a != 0) - (*b != 0);
}

static int compare_paths(const void *a, const void *b) {
    const char *x = *(char *const *)a, *y = *(char *const *)b;
    const int order = ffp_natural_order(x, y);
    return order != 0 ? order : strcmp(x, y); // "1.png" and "01.png"
}

static const char *keep(FfpArena *arena, const char *text) {
    const size_t size = strlen(text) + 1;
    return memcpy(ffp_arena_alloc(arena, size, 1), text, size);
}

// --- Templates: {view}, {pattern}, {index}, {number}, the last two also as {number:3}. ---

// The text of one placeholder, "view" or "number:3"; false when there is no such.
static bool fill_blank(const FfpBlanks *blanks, const char *blank, size_t length,
                       char out[FFP_NAME_MAX + 16]) {
    static const char *const words[2] = {"view", "pattern"}, *const counters[2] = {"index", "number"};
    const char *const texts[2] = {blanks->view, blanks->pattern};
    for (size_t i = 0; i < 2; i++) {
        const size_t n = strlen(words[i]);
        if (length != n || strncmp(blank, words[i], n) != 0 || texts[i] == NULL) continue;
        snprintf(out, FFP_NAME_MAX + 16, "%s", texts[i]);
        return true;
    }
    for (int i = 0; i < 2; i++) {
        const size_t n = strlen(counters[i]);
        if (length < n || strncmp(blank, counters[i], n) != 0) continue;
        const bool wide = length == n + 2 && blank[n] == ':' && blank[n + 1] >= '1' && blank[n + 1] <= '9';
        if (length != n && !wide) continue;
        snprintf(out, FFP_NAME_MAX + 16, "%0*d", wide ? blank[n + 1] - '0' : 1, blanks->index + i);
        return true;
    }
    return false;
}

bool ffp_template_fill(const char *template, const FfpBlanks *blanks, char path[FFP_PATH_MAX],
                       FfpError *err) {
    size_t length = 0;
    for (const char *at = template; *at != 0;) {
        char text[FFP_NAME_MAX + 16] = {*at, 0};
        const char *end = *at == '{' ? strchr(at, '}') : NULL;
        if (*at == '{' && (end == NULL || !fill_blank(blanks, at + 1, (size_t)(end - at - 1), text))) {
            return ffp_fail(err, FFP_ERROR_FILE, template,
                            "%.20s: the placeholders are {view}, {pattern}, {index}, {number}, {number:3}",
                            at);
        }
        const size_t n = strlen(text);
        if (length + n >= FFP_PATH_MAX)
            return ffp_fail(err, FFP_ERROR_FILE, template, "the path is too long");
        memcpy(path + length, text, n);
        length += n;
        at = end != NULL ? end + 1 : at + 1;
    }
    path[length] = 0;
    return true;
}

bool ffp_template_is_glob(const char *text) {
    return strpbrk(text, "*?[") != NULL;
}

// --- Photographs under some patterns. ---

typedef struct Group {
    int patterns[FFP_PATTERNS_MAX], count;
    const char *template;
} Group;

static int pattern_index(FfpShots *shots, const char *name, FfpError *err) {
    for (int i = 0; i < shots->n_patterns; i++) {
        if (strcmp(shots->patterns[i].name, name) == 0) return i;
    }
    if (!ffp_is_name(name) || shots->n_patterns == FFP_PATTERNS_MAX) {
        ffp_fail(err, FFP_ERROR_ARGUMENT, IMAGES, "'%.100s' is no name for a pattern, or there are too many",
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

static bool read_group(FfpShots *shots, const FfpShotFiles *source, Group *group, FfpError *err) {
    if (source->files == NULL || source->files[0] == 0)
        return ffp_fail(err, FFP_ERROR_ARGUMENT, IMAGES, "no file is named");
    if (source->n_patterns < 1 || source->n_patterns > FFP_PATTERNS_MAX)
        return ffp_fail(err, FFP_ERROR_ARGUMENT, IMAGES, "%d patterns for '%.100s': 1 to %d are possible",
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
    if (*place != NULL)
        return ffp_fail(err, FFP_ERROR_ARGUMENT, IMAGES, "view '%s' has two pictures under '%s'",
                        calibration->stops[stop].id, shots->patterns[pattern].name);
    if (!ffp_photograph_is_there(path))
        return ffp_fail(err, FFP_ERROR_FILE, path, "there is no such file: view '%s' under pattern '%s'",
                        calibration->stops[stop].id, shots->patterns[pattern].name);
    *place = keep(shots->arena, path);
    return true;
}

static void free_glob(void *found) {
    globfree(found);
    ffp_free(found);
}

// Files in natural order: all of the first view, all of the second, and so on.
static bool match_files(FfpShots *shots, const Group *group, const FfpCalibration *calibration,
                        FfpError *err) {
    glob_t *found = ffp_alloc(1, sizeof *found);
    if (glob(group->template, GLOB_NOSORT, NULL, found) != 0) {
        ffp_free(found);
        return ffp_fail(err, FFP_ERROR_FILE, group->template,
                        "no file matches, or the folder cannot be read");
    }
    ffp_own(found, free_glob);
    qsort(found->gl_pathv, found->gl_pathc, sizeof *found->gl_pathv, compare_paths);
    const int n = calibration->n_stops * group->count;
    bool ok = found->gl_pathc == (size_t)n;
    if (!ok) {
        ffp_fail(err, FFP_ERROR_FILE, group->template,
                 "%zu files match, but %d views under %d pattern%s need %d", found->gl_pathc,
                 calibration->n_stops, group->count, group->count > 1 ? "s each" : "", n);
    }
    for (int i = 0; i < n && ok; i++) {
        ok = set_picture(shots, calibration, i / group->count, group->patterns[i % group->count],
                         found->gl_pathv[i], err);
    }
    ffp_disown(found);
    free_glob(found);
    return ok;
}

static bool fill_in_files(FfpShots *shots, const Group *group, const FfpCalibration *calibration,
                          FfpError *err) {
    const char *text = group->template;
    const bool tells_view =
        strstr(text, "{view}") != NULL || strstr(text, "{index") != NULL || strstr(text, "{number") != NULL;
    const FfpBlanks first = {calibration->stops[0].id, shots->patterns[group->patterns[0]].name, 0};
    char path[FFP_PATH_MAX];
    if (!ffp_template_fill(text, &first, path, err))
        return false; // an unknown placeholder is told before a missing one
    if (calibration->n_stops > 1 && !tells_view)
        return ffp_fail(err, FFP_ERROR_FILE, text,
                        "names one file for %d views: use {view}, {index}, {number} or *",
                        calibration->n_stops);
    if (group->count > 1 && strstr(text, "{pattern}") == NULL)
        return ffp_fail(err, FFP_ERROR_FILE, text, "names one file for %d patterns: use {pattern} or *",
                        group->count);
    for (int i = 0; i < calibration->n_stops * group->count; i++) {
        const int stop = i / group->count, pattern = group->patterns[i % group->count];
        const FfpBlanks blanks = {calibration->stops[stop].id, shots->patterns[pattern].name,
                                  calibration->stops[stop].index};
        if (!ffp_template_fill(text, &blanks, path, err) ||
            !set_picture(shots, calibration, stop, pattern, path, err))
            return false;
    }
    return true;
}

// --- Patterns and masks. ---

static bool take_projected(FfpShots *shots, const FfpProjected *projected, bool novel, FfpError *err) {
    const char *where = novel ? HELD_OUT : PATTERNS;
    for (int i = 0; i < shots->n_patterns; i++) {
        FfpShotPattern *pattern = &shots->patterns[i];
        if (strcmp(pattern->name, projected->name) != 0) continue;
        if (pattern->file != NULL)
            return ffp_fail(err, FFP_ERROR_ARGUMENT, where, "pattern '%s' comes twice", pattern->name);
        if (!ffp_is_file(projected->file))
            return ffp_fail(err, FFP_ERROR_ARGUMENT, projected->file, "there is no such file: pattern '%s'",
                            pattern->name);
        pattern->file = keep(shots->arena, projected->file);
        pattern->novel = novel;
        return true;
    }
    return ffp_fail(err, FFP_ERROR_ARGUMENT, IMAGES, "no picture was taken under pattern '%.100s'",
                    projected->name);
}

// Pictures that the calibration names itself, where the caller names none.
static bool take_named(FfpShots *shots, const FfpCalibration *calibration, FfpError *err) {
    for (int i = 0; i < calibration->n_pictures; i++) {
        const FfpNamedPicture *picture = &calibration->pictures[i];
        const int pattern = pattern_index(shots, picture->pattern, err);
        if (pattern < 0 || !set_picture(shots, calibration, picture->stop, pattern, picture->path, err))
            return false;
    }
    return true;
}

// Patterns that lie where the calibration keeps them.
static void take_kept_patterns(FfpShots *shots, const char *folder) {
    for (int i = 0; i < shots->n_patterns && folder[0] != 0; i++) {
        char name[FFP_NAME_MAX + 8], path[FFP_PATH_MAX];
        snprintf(name, sizeof name, "%s.png", shots->patterns[i].name);
        const bool plain = i == shots->black || i == shots->white;
        if (!plain && shots->patterns[i].file == NULL && ffp_join_path(path, folder, name) &&
            ffp_is_file(path))
            shots->patterns[i].file = keep(shots->arena, path);
    }
}

static bool find_masks(FfpShots *shots, const char *template, const FfpCalibration *calibration,
                       FfpError *err) {
    if (template == NULL || template[0] == 0)
        return ffp_fail(err, FFP_ERROR_ARGUMENT, "mask_files", "no file is named");
    shots->masks = ffp_arena_alloc(shots->arena, (size_t)calibration->n_stops, sizeof *shots->masks);
    for (int i = 0; i < calibration->n_stops; i++) {
        const FfpBlanks blanks = {calibration->stops[i].id, NULL, calibration->stops[i].index};
        char path[FFP_PATH_MAX];
        if (!ffp_template_fill(template, &blanks, path, err)) return false;
        if (!ffp_is_file(path))
            return ffp_fail(err, FFP_ERROR_FILE, path, "there is no such file: mask of view '%s'",
                            calibration->stops[i].id);
        shots->masks[i] = keep(shots->arena, path);
    }
    return true;
}

// --- All of it. ---

// No file of a view is its picture under two patterns.
static bool check_single(const FfpShots *shots, const FfpCalibration *calibration, FfpError *err) {
    for (int stop = 0; stop < calibration->n_stops; stop++) {
        const char *const *pictures = shots->pictures + (ptrdiff_t)stop * FFP_PATTERNS_MAX;
        for (int i = 0; i < shots->n_patterns; i++)
            for (int k = 0; k < i; k++)
                if (pictures[i] != NULL && pictures[k] != NULL && strcmp(pictures[i], pictures[k]) == 0)
                    return ffp_fail(err, FFP_ERROR_FILE, pictures[i],
                                    "is named twice: view '%s' under '%.64s' and under '%.64s'",
                                    calibration->stops[stop].id, shots->patterns[k].name,
                                    shots->patterns[i].name);
    }
    return true;
}

static bool check_complete(const FfpShots *shots, const FfpCalibration *calibration, FfpError *err) {
    if (shots->black < 0)
        return ffp_fail(err, FFP_ERROR_ARGUMENT, IMAGES, "no pictures under black are named");
    if (shots->white < 0)
        return ffp_fail(err, FFP_ERROR_ARGUMENT, IMAGES, "no pictures under white are named");
    const int plain[2] = {shots->black, shots->white};
    for (int i = 0; i < 2 * calibration->n_stops; i++) {
        if (shots->pictures[i / 2 * FFP_PATTERNS_MAX + plain[i % 2]] != NULL) continue;
        return ffp_fail(err, FFP_ERROR_ARGUMENT, IMAGES,
                        "view '%s' has no picture under %s: every pose must be photographed under "
                        "black, white and a pattern",
                        calibration->stops[i / 2].id, i % 2 == 0 ? "black" : "white");
    }
    for (int i = 0; i < shots->n_patterns; i++) {
        if (shots->patterns[i].file == NULL && i != shots->black && i != shots->white)
            return ffp_fail(err, FFP_ERROR_ARGUMENT, PATTERNS,
                            "what was projected as '%s'? name the pattern's file", shots->patterns[i].name);
    }
    return true;
}

static bool find_all(FfpShots *shots, const FfpShotSources *sources, const FfpCalibration *calibration,
                     FfpError *err) {
    Group *group = ffp_arena_alloc(shots->arena, 1, sizeof *group);
    if (sources->n_images == 0 && !take_named(shots, calibration, err)) return false;
    for (int i = 0; i < sources->n_images; i++) {
        if (!read_group(shots, &sources->images[i], group, err)) return false;
        const bool ok = ffp_template_is_glob(group->template) ? match_files(shots, group, calibration, err)
                                                              : fill_in_files(shots, group, calibration, err);
        if (!ok) return false;
    }
    for (int i = 0; i < sources->n_patterns; i++) {
        if (!take_projected(shots, &sources->patterns[i], false, err)) return false;
    }
    for (int i = 0; i < sources->n_held_out; i++) {
        if (!take_projected(shots, &sources->held_out[i], true, err)) return false;
    }
    take_kept_patterns(shots, calibration->pattern_folder);
    return (sources->mask != FFP_MASKS_FILES || find_masks(shots, sources->mask_files, calibration, err)) &&
           check_complete(shots, calibration, err) && check_single(shots, calibration, err);
}

bool ffp_shots_find(FfpShots *shots, const FfpShotSources *sources, const FfpCalibration *calibration,
                    FfpError *err) {
    *shots = (FfpShots){.arena = ffp_arena_new(), .black = -1, .white = -1};
    shots->patterns = ffp_arena_alloc(shots->arena, FFP_PATTERNS_MAX, sizeof *shots->patterns);
    shots->pictures = ffp_arena_alloc(shots->arena, (size_t)calibration->n_stops * FFP_PATTERNS_MAX,
                                      sizeof *shots->pictures);
    return find_all(shots, sources, calibration, err);
}

void ffp_shots_free(FfpShots *shots) {
    if (shots->arena != NULL) ffp_arena_free(shots->arena);
    *shots = (FfpShots){0};
}
