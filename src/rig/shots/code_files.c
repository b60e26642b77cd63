// Which photograph shows which Gray code.
#include <stdio.h>
#include "core/base/arena.h"
#include "core/patterns/patterns.h"
#include "rig/shots/file_names.h"
#include "rig/shots/sets.h"

#define WHERE "gray_codes"
#define PATTERN_BIT 5 // of the code that serves as the pattern: 32 stripes

static bool all_have(const FfpShots *shots, int stops, int code) {
    for (int stop = 0; stop < stops; stop++)
        if (!shots->codes[stop * shots->n_codes + code]) return false;
    return true;
}

// One code as the pattern that the network sees, where all others are held out.
static void add_pattern(FfpShots *shots, int stops, int width, int height, int axis) {
    for (int p = 0; p < shots->n_patterns; p++)
        if (p != shots->black && p != shots->white && !shots->patterns[p].novel) return;
    const int bits[2] = {ffp_gray_code_bits(width), ffp_gray_code_bits(height)};
    int index = -1;
    for (int bit = bits[axis] > PATTERN_BIT ? PATTERN_BIT : bits[axis] - 1; bit >= 0 && index < 0; bit--)
        for (int inverse = 0; inverse < 2 && index < 0; inverse++) {
            const int code = 2 * ((axis ? bits[0] : 0) + bit) + inverse;
            if (all_have(shots, stops, code)) index = code;
        }
    if (index < 0 || shots->n_patterns == FFP_PATTERNS_MAX) return; // an error says that there is no pattern
    const int pattern = shots->n_patterns++;
    ffp_gray_code_name(width, index, shots->patterns[pattern].name);
    shots->patterns[pattern].code = index + 1;
    for (int stop = 0; stop < stops; stop++)
        shots->pictures[stop * FFP_PATTERNS_MAX + pattern] = shots->codes[stop * shots->n_codes + index];
}

// The codes were found with the other photographs (shots.c).
static bool take_shown(FfpShots *shots, const char *template, int stops, int width, int height, int axis,
                       FfpError *err) {
    if (template) return ffp_fail(err, FFP_ERROR_ARGUMENT, WHERE, "the photographs include the Gray codes");
    if (width != shots->shown.width || height != shots->shown.height)
        return ffp_fail(err, FFP_ERROR_FILE, shots->shown.folder,
                        "the patterns are of %d x %d pixels, the panel is of %d x %d", shots->shown.width,
                        shots->shown.height, width, height);
    add_pattern(shots, stops, width, height, axis);
    return true;
}

// True if a view's photographs under black or white are missing, or all inverses.
static bool is_partial(const FfpShots *shots, int stop) {
    const char *const *pictures = shots->pictures + (ptrdiff_t)stop * FFP_PATTERNS_MAX;
    int there = 0;
    for (int i = 0; i < shots->n_codes; i++) there += shots->codes[stop * shots->n_codes + i] != NULL;
    return !pictures[shots->black] || !pictures[shots->white] || 2 * there == shots->n_codes;
}

static bool find_files(FfpShots *shots, const FfpImport *sources, const FfpCalibration *calibration,
                       int width, int height, FfpError *err) {
    const FfpGrayPhotographs panel = {.width = width, .height = height, .linear = sources->linear_images};
    const char **names = ffp_arena_alloc(shots->arena, (size_t)shots->n_codes, sizeof *names);
    char order[160];
    for (int i = 0; i < shots->n_codes; i++) {
        char name[32];
        ffp_gray_code_name(width, i, name);
        names[i] = ffp_arena_text(shots->arena, name);
    }
    snprintf(order, sizeof order,
             ": each of %d, coarsest first, columns before rows, every one followed by its inverse",
             shots->n_codes / 2);
    const FfpFileSet set = {sources->gray_codes,         calibration, names, shots->n_codes,
                            "photographs of Gray codes", "Gray code", order, true};
    FfpError error = {0};
    if (ffp_files_find(shots->codes, shots->arena, &set, &error)) {
        bool partial = false;
        for (int stop = 0; stop < calibration->n_stops; stop++) partial = partial || is_partial(shots, stop);
        if (partial) ffp_sets_sort_found(shots, calibration->n_stops, &panel);
        return true;
    }
    if (ffp_sets_find(shots, sources->gray_codes, calibration, NULL, &panel)) return true;
    if (err) *err = error;
    return false;
}

bool ffp_shots_find_codes(FfpShots *shots, const FfpImport *sources, const FfpCalibration *calibration,
                          int width, int height, int axis, FfpError *err) {
    const char *template = sources->gray_codes;
    const int stops = calibration->n_stops;
    if (shots->codes) return take_shown(shots, template, stops, width, height, axis, err);
    if (!template) return true;
    if (template[0] == 0) return ffp_fail(err, FFP_ERROR_ARGUMENT, WHERE, "no file given");
    shots->n_codes = ffp_gray_photographs(width, height);
    shots->codes =
        ffp_arena_alloc(shots->arena, (size_t)stops * (size_t)shots->n_codes, sizeof *shots->codes);
    if (!find_files(shots, sources, calibration, width, height, err)) return false;
    add_pattern(shots, stops, width, height, axis);
    return true;
}

const char *ffp_shots_white(const FfpShots *shots, int stop) {
    const char *white = shots->pictures[(ptrdiff_t)stop * FFP_PATTERNS_MAX + shots->white];
    for (int i = 0; !white && i < shots->n_codes; i++) white = shots->codes[stop * shots->n_codes + i];
    return white;
}
