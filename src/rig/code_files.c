// Which photograph shows which Gray code.
#include <glob.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/call.h"
#include "base/file.h"
#include "image/photograph.h"
#include "patterns/patterns.h"
#include "graycode/graycode.h"
#include "rig/pictures.h"

#define WHERE "gray_codes"
#define PATTERN_BIT 5 // of the code that serves as the pattern: 32 stripes

static const char *keep(FfpArena *arena, const char *text) {
    const size_t size = strlen(text) + 1;
    return memcpy(ffp_arena_alloc(arena, size, 1), text, size);
}

static int compare_paths(const void *a, const void *b) {
    return ffp_natural_order(*(char *const *)a, *(char *const *)b);
}

static void free_glob(void *found) {
    globfree(found);
    ffp_free(found);
}

// `n` files in natural order into `out`. `whose`: for errors.
static bool take_matches(FfpShots *shots, const char *pattern, int n, const char *whose, const char **out,
                         FfpError *err) {
    glob_t *found = ffp_alloc(1, sizeof *found);
    if (glob(pattern, GLOB_NOSORT, NULL, found) != 0) {
        ffp_free(found);
        return ffp_fail(err, FFP_ERROR_FILE, pattern, "no file matches, or the folder cannot be read");
    }
    ffp_own(found, free_glob);
    qsort(found->gl_pathv, found->gl_pathc, sizeof *found->gl_pathv, compare_paths);
    const bool ok = found->gl_pathc == (size_t)n;
    if (!ok)
        ffp_fail(err, FFP_ERROR_FILE, pattern,
                 "%zu files match, but %s %d photographs of Gray codes: each of %d, coarsest first, columns "
                 "before "
                 "rows, every one followed by its inverse",
                 found->gl_pathc, whose, n, shots->n_codes / 2);
    for (int i = 0; ok && i < n; i++) out[i] = keep(shots->arena, found->gl_pathv[i]);
    ffp_disown(found);
    free_glob(found);
    return ok;
}

static bool tells_view(const char *text) {
    return strstr(text, "{view}") != NULL || strstr(text, "{index") != NULL ||
           strstr(text, "{number") != NULL;
}

// The files of one view whose names a template makes.
static bool take_named(FfpShots *shots, const char *template, const FfpCalibration *calibration, int stop,
                       int width, int height, FfpError *err) {
    for (int i = 0; i < shots->n_codes; i++) {
        char name[32], path[FFP_PATH_MAX];
        ffp_gray_name(width, height, i, name);
        const FfpBlanks blanks = {calibration->stops[stop].id, name, calibration->stops[stop].index};
        if (!ffp_template_fill(template, &blanks, path, err)) return false;
        if (!ffp_photograph_is_there(path))
            return ffp_fail(err, FFP_ERROR_FILE, path,
                            "there is no such file: view '%s' under Gray code '%s'",
                            calibration->stops[stop].id, name);
        shots->codes[stop * shots->n_codes + i] = keep(shots->arena, path);
    }
    return true;
}

static bool take_view(FfpShots *shots, const char *template, const FfpCalibration *calibration, int stop,
                      int width, int height, FfpError *err) {
    char path[FFP_PATH_MAX];
    if (!ffp_template_is_glob(template))
        return take_named(shots, template, calibration, stop, width, height, err);
    const FfpBlanks blanks = {calibration->stops[stop].id, NULL, calibration->stops[stop].index};
    return ffp_template_fill(template, &blanks, path, err) &&
           take_matches(shots, path, shots->n_codes, "a view has", shots->codes + stop * shots->n_codes, err);
}

// One code as the pattern that the network sees.
static void add_pattern(FfpShots *shots, int stops, int width, int height, int axis) {
    const int bits[2] = {ffp_gray_code_bits(width), ffp_gray_code_bits(height)};
    const int bit = bits[axis] > PATTERN_BIT ? PATTERN_BIT : bits[axis] - 1;
    const int index = 2 * ((axis ? bits[0] : 0) + bit), pattern = shots->n_patterns++;
    ffp_gray_name(width, height, index, shots->patterns[pattern].name);
    shots->patterns[pattern].code = index + 1;
    for (int stop = 0; stop < stops; stop++)
        shots->pictures[stop * FFP_PATTERNS_MAX + pattern] = shots->codes[stop * shots->n_codes + index];
}

bool ffp_shots_find_codes(FfpShots *shots, const FfpShotSources *sources, const FfpCalibration *calibration,
                          int width, int height, int axis, FfpError *err) {
    const char *template = sources->codes;
    const int stops = calibration->n_stops;
    if (template == NULL) return true;
    if (template[0] == 0) return ffp_fail(err, FFP_ERROR_ARGUMENT, WHERE, "no file is named");
    shots->n_codes = ffp_gray_photographs(width, height);
    shots->codes =
        ffp_arena_alloc(shots->arena, (size_t)stops * (size_t)shots->n_codes, sizeof *shots->codes);
    const bool glob = ffp_template_is_glob(template);
    if (!glob && strstr(template, "{pattern}") == NULL)
        return ffp_fail(err, FFP_ERROR_FILE, template, "names one file for %d codes: use {pattern} or *",
                        shots->n_codes);
    if (glob && !tells_view(template)) {
        char whose[64];
        snprintf(whose, sizeof whose, stops > 1 ? "%d views have" : "a view has", stops);
        if (!take_matches(shots, template, stops * shots->n_codes, whose, shots->codes, err)) return false;
    } else {
        if (stops > 1 && !tells_view(template))
            return ffp_fail(err, FFP_ERROR_FILE, template,
                            "names one file for %d views: use {view}, {index}, {number} or *", stops);
        for (int stop = 0; stop < stops; stop++)
            if (!take_view(shots, template, calibration, stop, width, height, err)) return false;
    }
    if (shots->n_patterns == 2) add_pattern(shots, stops, width, height, axis);
    return true;
}
