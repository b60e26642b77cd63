#include "import_text.h"
#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

static bool fail(FfpError *err, const char *format, ...) __attribute__((format(printf, 2, 3)));
static bool fail(FfpError *err, const char *format, ...) {
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(err->text, sizeof err->text, format, arguments);
    va_end(arguments);
    err->code = FFP_ERROR_ARGUMENT;
    return false;
}

// Room for one more element.
static void *grown(void *list, int count, size_t size) {
    void *more = realloc(list, ((size_t)count + 1) * size);
    if (!more) abort();
    return more;
}

static char *copy(FfpImportLists *lists, const char *text) {
    lists->texts = grown(lists->texts, lists->n_texts, sizeof *lists->texts);
    char *out = grown(NULL, (int)strlen(text), 1);
    lists->texts[lists->n_texts++] = out;
    return strcpy(out, text);
}

void ffp_cli_import_lists_free(FfpImportLists *lists) {
    for (int i = 0; i < lists->n_images; i++) free((void *)lists->images[i].patterns);
    for (int i = 0; i < lists->n_empty; i++) free((void *)lists->empty[i].patterns);
    for (int i = 0; i < lists->n_texts; i++) free(lists->texts[i]);
    free(lists->images);
    free(lists->empty);
    free(lists->patterns);
    free(lists->held_out);
    free(lists->texts);
    *lists = (FfpImportLists){0};
}

// Cuts "NAMES=FILES" in two; NULL when there is nothing on either side.
static char *cut_at_equals(char *text) {
    char *equals = strchr(text, '=');
    if (!equals || equals == text || !equals[1]) return NULL;
    *equals = 0;
    return equals + 1;
}

// "NAME[,NAME..]=FILES", or with `shown` files alone.
static bool read_images(FfpImportLists *lists, const char *text, bool shown, FfpImportImages *images,
                        const char *option, FfpError *err) {
    char *names = copy(lists, text);
    const bool unnamed = shown && !strchr(text, '=');
    const char *files = unnamed ? names : cut_at_equals(names);
    if (!files) return fail(err, "expected NAME=FILES, not '%.100s' (%s)", text, option);
    const char **patterns = NULL;
    int n = 0;
    for (char *at = unnamed ? NULL : names; at; n++) {
        char *comma = strchr(at, ',');
        if (comma) *comma = 0;
        patterns = grown(patterns, n, sizeof *patterns);
        patterns[n] = at;
        at = comma ? comma + 1 : NULL;
    }
    *images = (FfpImportImages){.patterns = patterns, .n_patterns = n, .files = files};
    return true;
}

bool ffp_cli_add_images(FfpImportLists *lists, const char *text, bool shown, FfpError *err) {
    lists->images = grown(lists->images, lists->n_images, sizeof *lists->images);
    FfpImportImages *images = &lists->images[lists->n_images];
    return read_images(lists, text, shown, images, "--images", err) && ++lists->n_images;
}

bool ffp_cli_add_empty(FfpImportLists *lists, const char *text, FfpError *err) {
    lists->empty = grown(lists->empty, lists->n_empty, sizeof *lists->empty);
    FfpImportImages *images = &lists->empty[lists->n_empty];
    return read_images(lists, text, false, images, "--empty", err) && ++lists->n_empty;
}

bool ffp_cli_add_pattern(FfpImportLists *lists, const char *text, bool held_out, FfpError *err) {
    char *name = copy(lists, text);
    const char *file = cut_at_equals(name);
    if (!file)
        return fail(err, "expected NAME=FILE, not '%.100s' (%s)", text,
                    held_out ? "--held-out" : "--pattern");
    FfpImportPattern **list = held_out ? &lists->held_out : &lists->patterns;
    int *count = held_out ? &lists->n_held_out : &lists->n_patterns;
    *list = grown(*list, *count, sizeof **list);
    (*list)[(*count)++] = (FfpImportPattern){.name = name, .file = file};
    return true;
}

// --- The turntable. ---

// "AX,AY,AZ,PX,PY,PZ", and what follows.
static bool read_axis(const char *text, const char *needed, FfpImportTurntable *turntable, const char **rest,
                      FfpError *err) {
    const char *at = text;
    for (int i = 0; i < 6; i++) {
        const char *end;
        const double value = ffp_cli_decimal(at, &end);
        if (isnan(value) || (*end != ',' && (*end || i < 5)))
            return fail(err, "'%.40s' is not a number: expected %s", at, needed);
        *(i < 3 ? &turntable->axis[i] : &turntable->point[i - 3]) = value;
        at = *end ? end + 1 : end;
    }
    *rest = at;
    return true;
}

bool ffp_cli_turntable(FfpImportLists *lists, const char *text, FfpImportTurntable *turntable,
                       FfpError *err) {
    const char *needed =
        turntable->find_axis
            ? "only angles (--turntable 8x45)"
            : "three numbers for the axis, three for a point on it, and the angles (--turntable)";
    const bool numbers = !text[strspn(text, "0123456789+-.,eEx")] && access(text, F_OK) != 0;
    if (!numbers) {
        turntable->file = text;
        return true;
    }
    const char *rest = text, *where;
    if (!turntable->find_axis && !read_axis(text, needed, turntable, &rest, err)) return false;
    const bool given = turntable->n_angles > 0; // by --angles
    if (!*rest && given) return true;
    if (!*rest) return fail(err, "missing angles: expected %s, or the name of a file", needed);
    if (given) return fail(err, "'%.40s': --angles gives the angles already (--turntable)", rest);
    const char *wrong = ffp_cli_angles(rest, &lists->angles, &where);
    if (wrong) return fail(err, "'%.40s' %s: expected %s", where, wrong, needed);
    turntable->angles = lists->angles.degrees;
    turntable->n_angles = lists->angles.count;
    return true;
}

bool ffp_cli_fit_axis(const char *text, FfpImportTurntable *turntable, FfpError *err) {
    static const char needed[] = "six numbers AX,AY,AZ,PX,PY,PZ";
    int commas = 0;
    for (const char *at = text; *at; at++) commas += *at == ',';
    turntable->find_axis = true;
    turntable->guessed = *text;
    if (!*text) return true;
    const char *rest;
    if (commas != 5) return fail(err, "expected %s, not '%.80s' (--fit-axis)", needed, text);
    return read_axis(text, needed, turntable, &rest, err);
}

// --- Errors. ---

const char *ffp_cli_import_option(const FfpError *err) {
    static const struct {
        const char *setting, *option;
    } table[] = {
        {"camera.width", "--camera-size WxH"},
        {"projector.width", "--projector-size WxH"},
        {"camera.fit", "--camera-fit F"},
        {"projector.fit", "--projector-fit F"},
        {"images", "--images NAMES=FILES"},
        {"shown", "--shown DIR"},
        {"patterns", "--pattern NAME=FILE"},
        {"held_out", "--held-out NAME=FILE"},
        {"gray_codes", "--graycode FILES"},
        {"empty", "--empty NAMES=FILES"},
        {"views", "--view ID"},
        {"width", "--width W"},
        {"object", "--object X,Y,Z,R"},
        {"turntable", "--turntable T"},
        {"turntable.angles", "--turntable T"},
        {"turntable.axis", "--fit-axis"},
        {"fit_response", "--fit-response"},
        {"linear_images", "--linear images"},
        {"projector_image", "--projector-image N"},
    };
    for (size_t i = 0; i < sizeof table / sizeof *table; i++)
        if (strcmp(err->where, table[i].setting) == 0) return table[i].option;
    return NULL;
}
