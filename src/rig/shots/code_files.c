// Which photograph shows which Gray code.
#include <stdio.h>
#include "core/base/arena.h"
#include "core/patterns/patterns.h"
#include "rig/graycode/graycode.h"
#include "rig/shots/file_names.h"
#include "rig/shots/shots.h"

#define WHERE "gray_codes"
#define PATTERN_BIT 5 // of the code that serves as the pattern: 32 stripes

static bool all_have(const FfpShots *shots, int stops, int code) {
    for (int stop = 0; stop < stops; stop++)
        if (!shots->codes[stop * shots->n_codes + code]) return false;
    return true;
}

// One code as the pattern that the network sees.
static void add_pattern(FfpShots *shots, int stops, int width, int height, int axis) {
    const int bits[2] = {ffp_gray_code_bits(width), ffp_gray_code_bits(height)};
    int index = -1;
    for (int bit = bits[axis] > PATTERN_BIT ? PATTERN_BIT : bits[axis] - 1; bit >= 0 && index < 0; bit--)
        for (int inverse = 0; inverse < 2 && index < 0; inverse++) {
            const int code = 2 * ((axis ? bits[0] : 0) + bit) + inverse;
            if (all_have(shots, stops, code)) index = code;
        }
    if (index < 0) return; // and an error says that there is no pattern
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
    if (shots->n_patterns == 2) add_pattern(shots, stops, width, height, axis);
    return true;
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
    const FfpFileSet set = {template,    calibration, names, shots->n_codes, "photographs of Gray codes",
                            "Gray code", order,       true};
    if (!ffp_files_find(shots->codes, shots->arena, &set, err)) return false;
    if (shots->n_patterns == 2) add_pattern(shots, stops, width, height, axis);
    return true;
}
