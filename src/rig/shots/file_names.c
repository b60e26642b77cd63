#include "rig/shots/file_names.h"
#include <ctype.h>
#include <glob.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>
#include <unistd.h>
#include "core/base/arena.h"
#include "core/base/call.h"
#include "core/base/file.h"
#include "core/capture/node.h"
#include "core/image/photograph.h"
#include "rig/findings/tell.h"

// --- Names in order. ---

static int natural_order(const char *a, const char *b) {
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

int ffp_compare_paths(const void *a, const void *b) {
    const char *x = *(char *const *)a, *y = *(char *const *)b;
    const int order = natural_order(x, y);
    return order != 0 ? order : strcmp(x, y); // "1.png" and "01.png"
}

// --- What cameras do to names. ---

long ffp_last_number(const char *path, int *digits) {
    const char *base = ffp_basename(path), *dot = strrchr(base, '.');
    const char *end = dot ? dot : base + strlen(base);
    while (end > base && !isdigit((unsigned char)end[-1])) end--;
    const char *start = end;
    while (start > base && isdigit((unsigned char)start[-1])) start--;
    *digits = (int)(end - start);
    return *digits > 0 && *digits < 10 ? strtol(start, NULL, 10) : -1;
}

void ffp_unwrap_numbers(const char **paths, int n) {
    int gaps = 0, gap = 0, digits;
    long before = -1, after = 1000;
    if (n < 3 || ffp_last_number(paths[0], &digits) > 1) return;
    for (int i = 0; i < n; i++) {
        const long number = ffp_last_number(paths[i], &digits);
        if (number < 0) return;
        if (i > 0 && number != before + 1) gaps++, gap = i;
        before = number;
    }
    while (after < before + 1) after *= 10; // cameras count to 9999 in five digits, too
    if (gaps != 1 || before != after - 1 || digits < 3) return;
    const char **held = ffp_alloc((size_t)n, sizeof *held);
    for (int i = 0; i < n; i++) held[i] = paths[(i + gap) % n];
    memcpy(paths, held, (size_t)n * sizeof *held);
    ffp_free(held);
    ffp_tell(FFP_RULE_NUMBERS_WRAP,
             &(FfpFacts){.a = ffp_basename(paths[n - gap - 1]), .b = ffp_basename(paths[n - gap])});
}

int ffp_find_gap(const char *const *paths, int n, int *count) {
    int first = -1, digits;
    long before = -1;
    *count = 0;
    for (int i = 0; i < n; i++) {
        const long number = ffp_last_number(paths[i], &digits);
        if (number < 0 || (i > 0 && number <= before)) return -1;
        if (i > 0 && number > before + 1) {
            if (first < 0) first = i;
            *count += (int)(number - before - 1);
        }
        before = number;
    }
    return first;
}

int ffp_find_twins(const char *const *paths, int n, int *count) {
    int first = -1;
    *count = 0;
    for (int i = 0; i + 1 < n; i++) {
        const char *dot = strrchr(paths[i], '.'), *other = strrchr(paths[i + 1], '.');
        if (!dot || !other || dot - paths[i] != other - paths[i + 1] ||
            strncmp(paths[i], paths[i + 1], (size_t)(dot - paths[i])) != 0 || strcasecmp(dot, other) == 0)
            continue;
        if ((*count)++ == 0) first = i;
    }
    return first;
}

// --- Templates: {view}, {pattern}, {index}, {number}, the last two also as {number:3}. ---

typedef struct Blanks {
    const char *view, *pattern; // NULL: not to be filled in
    int index;
} Blanks;

// The text of one placeholder, "view" or "number:3"; false when there is no such.
static bool fill_blank(const Blanks *blanks, const char *blank, size_t length, char out[FFP_NAME_MAX + 16]) {
    static const char *const words[2] = {"view", "pattern"}, *const counters[2] = {"index", "number"};
    const char *const texts[2] = {blanks->view, blanks->pattern};
    for (size_t i = 0; i < 2; i++) {
        const size_t n = strlen(words[i]);
        if (length != n || strncmp(blank, words[i], n) != 0 || !texts[i]) continue;
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

// `text` behind `length` bytes of a path of FFP_PATH_MAX, with a \\ before characters in `special`.
static bool append(char *path, size_t *length, const char *text, const char *special) {
    for (; *text != 0; text++) {
        const bool escaped = strchr(special, *text) != NULL;
        if (*length + escaped + 1 >= FFP_PATH_MAX) return false;
        if (escaped) path[(*length)++] = '\\';
        path[(*length)++] = *text;
    }
    path[*length] = 0;
    return true;
}

// Characters of a name that would be wildcards: in the placeholders' values, in the template itself.
typedef struct Specials {
    const char *filled, *written;
} Specials;
static const Specials as_written = {"", ""}, only_stars = {"*?[\\", "?[\\"}, all_wildcards = {"*?[\\", ""};

static bool fill(const char *template, const Blanks *blanks, Specials specials, char path[FFP_PATH_MAX],
                 FfpError *err) {
    size_t length = 0;
    path[0] = 0;
    for (const char *at = template; *at != 0;) {
        char text[FFP_NAME_MAX + 16] = {*at, 0};
        const char *end = *at == '{' ? strchr(at, '}') : NULL;
        if (*at == '{' && (!end || !fill_blank(blanks, at + 1, (size_t)(end - at - 1), text))) {
            return ffp_fail(err, FFP_ERROR_FILE, template,
                            "%.20s: the placeholders are {view}, {pattern}, {index}, {number} and {number:3}",
                            at);
        }
        if (!append(path, &length, text, end ? specials.filled : specials.written))
            return ffp_fail(err, FFP_ERROR_FILE, template, "the path is too long");
        at = end ? end + 1 : at + 1;
    }
    return true;
}

// --- Files. ---

bool ffp_files_by_view(const char *text) {
    return strstr(text, "{view}") || strstr(text, "{index") || strstr(text, "{number") != NULL;
}

// One of the paths that a template stands for, and which files it must match: `count` of them, from paths[at]
// on, every `stride`.
typedef struct Part {
    char path[FFP_PATH_MAX];
    int at, stride, count;
    bool by_view, by_name; // placeholders tell views, names
} Part;

static bool wrong_number(const FfpFileSet *set, const Part *part, size_t found, FfpError *err) {
    char whose[64] = "a view has", each[96] = "";
    const int views = set->calibration->n_stops;
    if (!part->by_view && views > 1) snprintf(whose, sizeof whose, "%d views have", views);
    if (part->by_name)
        snprintf(each, sizeof each, " under a %s", set->name);
    else if (set->n_names > 1 && !set->order[0])
        snprintf(each, sizeof each, " (%d %ss each)", set->n_names, set->name);
    return ffp_fail(err, FFP_ERROR_FILE, part->path, "%zu files match, but %s %d %s%s%s", found, whose,
                    part->count, set->kind, each, set->order);
}

static void free_glob(void *found) {
    globfree(found);
    ffp_free(found);
}

// The paths that match, with only * as a wildcard or, if that finds none, ? and [...] as well.
static bool find_files(glob_t *found, const FfpFileSet *set, const Blanks *blanks, const char *filled,
                       FfpError *err) {
    char path[FFP_PATH_MAX];
    if (!fill(set->template, blanks, only_stars, path, err)) return false;
    int status = glob(path, GLOB_NOSORT, NULL, found);
    if (status == GLOB_NOMATCH) {
        if (!fill(set->template, blanks, all_wildcards, path, err)) return false;
        status = glob(path, GLOB_NOSORT, NULL, found);
    }
    if (status == GLOB_NOSPACE) {
        globfree(found);
        return ffp_fail(err, FFP_ERROR_MEMORY, filled, "no memory for the list of files");
    }
    return status == 0 || ffp_fail(err, FFP_ERROR_FILE, filled,
                                   "no file matches (.JPG is not .jpg), or the folder cannot be read");
}

// Not a link that leads nowhere, nor one of the files that other programs leave beside pictures (Thumbs.db,
// 001.xmp).
static bool is_photograph(const char *path) {
    return ffp_photograph_has_ending(path) && access(path, F_OK) == 0;
}

// Puts others behind the photographs. Returns how many photographs there are; of none, how many files,
// whatever they are.
static size_t photographs_first(const glob_t *found) {
    size_t n = 0;
    for (size_t i = 0; i < found->gl_pathc; i++) {
        char *path = found->gl_pathv[i];
        if (!is_photograph(path)) continue;
        found->gl_pathv[i] = found->gl_pathv[n];
        found->gl_pathv[n++] = path;
    }
    return n > 0 ? n : found->gl_pathc;
}

// A view's files, fewer than its names, in their places; false: their numbers do not tell these.
static bool place_some(const char **paths, FfpArena *arena, const FfpFileSet *set, const Part *part,
                       char *const *found, size_t n) {
    const bool whole_view = set->gaps && part->count == set->n_names && part->stride == 1;
    int digits;
    const long first = n > 0 ? ffp_last_number(found[0], &digits) : -1,
               last = n > 0 ? ffp_last_number(found[n - 1], &digits) : -1;
    if (!whole_view || first < 0 || last - first + 1 > part->count || (int)n > part->count) return false;
    const int apart = 2 * (int)n == part->count && last - first + 1 == (int)n ? 2 : 1;
    for (size_t i = 0; i < n; i++) {
        const long at = apart * (ffp_last_number(found[i], &digits) - first);
        if (at < 0 || at >= part->count || paths[part->at + at]) return false;
        paths[part->at + at] = ffp_arena_text(arena, found[i]);
    }
    return true;
}

static bool match(const char **paths, FfpArena *arena, const FfpFileSet *set, const Blanks *blanks,
                  const Part *part, FfpError *err) {
    glob_t *found = ffp_alloc(1, sizeof *found);
    if (ffp_photograph_names_part(part->path)) {
        ffp_free(found);
        return ffp_fail(err, FFP_ERROR_FILE, part->path,
                        "* cannot be combined with parts of films (@): name the films with {view}, {index} "
                        "or {number}");
    }
    if (!find_files(found, set, blanks, part->path, err)) {
        ffp_free(found);
        return false;
    }
    ffp_own(found, free_glob);
    const size_t n = photographs_first(found);
    qsort(found->gl_pathv, n, sizeof *found->gl_pathv, ffp_compare_paths);
    const char **names = (const char **)found->gl_pathv;
    int twins = 0;
    const int twin = ffp_find_twins(names, (int)n, &twins);
    const bool all = n == (size_t)part->count;
    if (part->by_view) ffp_unwrap_numbers(names, (int)n);
    bool ok = all;
    if (!all && twin >= 0)
        ffp_fail_by(
            FFP_RULE_RAW_AND_JPEG,
            &(FfpFacts){.x = twins, .a = ffp_basename(names[twin]), .b = ffp_basename(names[twin + 1])},
            part->path, err);
    else if (!all)
        ok = place_some(paths, arena, set, part, found->gl_pathv, n) || wrong_number(set, part, n, err);
    for (int i = 0; all && i < part->count; i++)
        paths[part->at + i * part->stride] = ffp_arena_text(arena, found->gl_pathv[i]);
    ffp_disown(found);
    free_glob(found);
    return ok;
}

static bool take(const char **paths, FfpArena *arena, const FfpFileSet *set, const Part *part,
                 FfpError *err) {
    const char *view = set->calibration->stops[part->at / set->n_names].id;
    char what[2 * FFP_NAME_MAX + 64];
    if (!part->by_view && set->calibration->n_stops > 1)
        return ffp_fail(err, FFP_ERROR_FILE, set->template,
                        "names one file for %d views: use {view}, {index}, {number} or *",
                        set->calibration->n_stops);
    if (!part->by_name && set->n_names > 1)
        return ffp_fail(err, FFP_ERROR_FILE, set->template, "names one file for %d %ss: use {pattern} or *",
                        set->n_names, set->name);
    if (set->names)
        snprintf(what, sizeof what, "view '%s' under %s '%s'", view, set->name,
                 set->names[part->at % set->n_names]);
    else
        snprintf(what, sizeof what, "%s of view '%s'", set->kind, view);
    FfpError missing = {0};
    if (set->gaps && !ffp_photograph_check(part->path, what, &missing)) return true;
    if (!ffp_photograph_check(part->path, what, err)) return false;
    paths[part->at] = ffp_arena_text(arena, part->path);
    return true;
}

// A name in which ? or [ stand, and no *, is that of a file that is so called, or else has wildcards.
static bool has_wildcards(const char *template, const char *path) {
    FfpError none = {0};
    return strchr(template, '*') || (strpbrk(template, "?[") && !ffp_photograph_check(path, "", &none));
}

static bool find_all(const char **paths, FfpArena *arena, const FfpFileSet *set, FfpError *err) {
    const int stops = set->calibration->n_stops, n = set->n_names;
    Part part = {.by_view = ffp_files_by_view(set->template),
                 .by_name = set->names && strstr(set->template, "{pattern}")};
    const int views = part.by_view ? stops : 1, names = part.by_name ? n : 1;
    part.count = stops / views * (n / names);
    part.stride = part.by_name ? n : 1;
    for (int i = 0; i < views * names; i++) {
        const int stop = i / names, name = i % names;
        const FfpStop *of = &set->calibration->stops[stop];
        const Blanks blanks = {of->id, set->names ? set->names[name] : NULL, of->index};
        part.at = stop * n + name;
        if (!fill(set->template, &blanks, as_written, part.path, err)) return false;
        if (!(has_wildcards(set->template, part.path) ? match(paths, arena, set, &blanks, &part, err)
                                                      : take(paths, arena, set, &part, err)))
            return false;
    }
    return true;
}

bool ffp_files_find(const char **paths, FfpArena *arena, const FfpFileSet *set, FfpError *err) {
    if (!find_all(paths, arena, set, err)) return false;
    for (int stop = 0; set->gaps && stop < set->calibration->n_stops; stop++) {
        int there = 0;
        for (int i = 0; i < set->n_names; i++) there += paths[stop * set->n_names + i] != NULL;
        if (2 * there >= set->n_names) continue;
        FfpFileSet whole = *set; // more than gaps: the error that names a file
        whole.gaps = false;
        return find_all(paths, arena, &whole, err);
    }
    return true;
}

// --- Of views, whatever their number. ---

// The files that match, in natural order; n: how many.
static const char **list_files(FfpArena *arena, const FfpFileSet *set, const Blanks *blanks, int *n) {
    glob_t *found = ffp_alloc(1, sizeof *found);
    FfpError none = {0};
    *n = 0;
    if (!find_files(found, set, blanks, "", &none)) {
        ffp_free(found);
        return NULL;
    }
    ffp_own(found, free_glob);
    const char **files = ffp_arena_alloc(arena, found->gl_pathc + 1, sizeof *files);
    for (size_t i = 0; i < found->gl_pathc; i++)
        if (is_photograph(found->gl_pathv[i])) files[(*n)++] = ffp_arena_text(arena, found->gl_pathv[i]);
    ffp_disown(found);
    free_glob(found);
    qsort(files, (size_t)*n, sizeof *files, ffp_compare_paths);
    return files;
}

static bool in_one_folder(const char *a, const char *b) {
    const ptrdiff_t length = ffp_basename(a) - a;
    return length == ffp_basename(b) - b && strncmp(a, b, (size_t)length) == 0;
}

// Files of all views by their folders, or in equal shares.
static bool share_out(FfpShotFolder *views, int stops, const char **files, int n) {
    int folders = n > 0;
    for (int i = 1; i < n; i++) folders += !in_one_folder(files[i - 1], files[i]);
    if (n == 0 || (folders != stops && n % stops != 0)) return false;
    for (int i = 0, stop = -1; i < n; i++) {
        const bool next =
            folders == stops ? i == 0 || !in_one_folder(files[i - 1], files[i]) : i % (n / stops) == 0;
        if (next) views[++stop].files = files + i;
        views[stop].n_files++;
    }
    return true;
}

bool ffp_files_list(FfpShotFolder *views, FfpArena *arena, const char *template,
                    const FfpCalibration *calibration) {
    const FfpFileSet set = {.template = template, .calibration = calibration, .n_names = 1};
    const bool by_view = ffp_files_by_view(template);
    int n, twins;
    if (!strchr(template, '*') || ffp_photograph_names_part(template)) return false;
    for (int stop = 0; stop < (by_view ? calibration->n_stops : 1); stop++) {
        const Blanks blanks = {calibration->stops[stop].id, NULL, calibration->stops[stop].index};
        const char **files = list_files(arena, &set, &blanks, &n);
        if (!files || n == 0 || ffp_find_twins(files, n, &twins) >= 0) return false;
        if (!by_view) return share_out(views, calibration->n_stops, files, n);
        ffp_unwrap_numbers(files, n);
        views[stop].files = files, views[stop].n_files = n;
    }
    return true;
}
