#include "core/patterns/shown.h"
#include <ctype.h>
#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include "core/base/file.h"
#include "core/base/listing.h"
#include "core/image/image.h"
#include "core/patterns/patterns.h"

enum { SHOWN_MAX = 512, NUMBER_MAX = 999, DIGITS_MAX = 6 };

// "002_white.png": its number, and the length of it; -1 for what is called otherwise.
static int number_of(const char *file, size_t *digits) {
    const size_t length = strlen(file);
    int number = 0;
    *digits = 0;
    for (; *digits < DIGITS_MAX && isdigit((unsigned char)file[*digits]); ++*digits)
        number = 10 * number + file[*digits] - '0';
    const bool named =
        *digits > 0 && file[*digits] == '_' && length > *digits + 5 && strcmp(file + length - 4, ".png") == 0;
    return named ? number : -1;
}

// The name alone, without number and ending.
static const char *name_of(FfpArena *arena, const char *file, size_t digits) {
    const size_t length = strlen(file) - digits - 5;
    char *name = ffp_arena_alloc(arena, length + 1, 1);
    snprintf(name, length + 1, "%s", file + digits + 1); // cut before the ending
    return name;
}

static bool add(FfpShown *shown, const char *file, FfpError *err) {
    size_t digits;
    char path[FFP_PATH_MAX];
    const int number = number_of(file, &digits);
    if (number < 0 || strcmp(file + digits, "_focus.png") == 0) return true;
    if (number < 1 || number > NUMBER_MAX || shown->n == SHOWN_MAX)
        return ffp_fail(err, FFP_ERROR_FILE, shown->folder,
                        "%.100s: there are at most %d pictures, and their numbers are 1 to %d", file,
                        SHOWN_MAX, NUMBER_MAX);
    if (!ffp_join_path(path, shown->folder, file))
        return ffp_fail(err, FFP_ERROR_ARGUMENT, shown->folder, "the path is too long");
    shown->patterns[shown->n++] = (FfpShownPattern){.number = number,
                                                    .name = name_of(shown->arena, file, digits),
                                                    .file = ffp_arena_text(shown->arena, path)};
    return true;
}

static int by_number(const void *a, const void *b) {
    return ((const FfpShownPattern *)a)->number - ((const FfpShownPattern *)b)->number;
}

static bool list(FfpShown *shown, FfpError *err) {
    FfpListing listing;
    bool ok = true;
    if (!ffp_list_folder(&listing, shown->folder))
        return ffp_fail(err, FFP_ERROR_IO, shown->folder, "cannot read the patterns' folder: %s",
                        strerror(errno));
    for (int i = 0; ok && i < listing.count; i++) ok = add(shown, listing.names[i], err);
    ffp_free(listing.names);
    if (ok && shown->n == 0)
        return ffp_fail(err, FFP_ERROR_FILE, shown->folder,
                        "no picture is called <number>_<name>.png, as those of `patterns` are");
    qsort(shown->patterns, (size_t)shown->n, sizeof *shown->patterns, by_number);
    const FfpShownPattern *p = shown->patterns;
    for (int i = 1; ok && i < shown->n; i++)
        if (p[i].number == p[i - 1].number)
            return ffp_fail(err, FFP_ERROR_FILE, shown->folder, "%.100s has the same number as %.100s",
                            ffp_basename(p[i].file), ffp_basename(p[i - 1].file));
    return ok;
}

static bool check_numbers(FfpShown *shown, FfpError *err) {
    for (int i = 0; i < shown->n; i++)
        if (shown->patterns[i].number != i + 1)
            return ffp_fail(err, FFP_ERROR_FILE, shown->folder, "number %03d is missing", i + 1);
    return true;
}

static bool check_sizes(FfpShown *shown, FfpError *err) {
    for (int i = 0; i < shown->n; i++) {
        const char *file = shown->patterns[i].file;
        int width, height;
        if (!ffp_image_read_size(&width, &height, file, err)) return false;
        if (i == 0) {
            shown->width = width;
            shown->height = height;
        }
        if (width != shown->width || height != shown->height)
            return ffp_fail(err, FFP_ERROR_FILE, file, "%d x %d pixels, but the first pattern has %d x %d",
                            width, height, shown->width, shown->height);
    }
    return true;
}

static bool check_names(FfpShown *shown, FfpError *err) {
    static const char *const plain[2] = {"black", "white"};
    for (int i = 0; i < 2; i++)
        if (i >= shown->n || strcmp(shown->patterns[i].name, plain[i]) != 0)
            return ffp_fail(err, FFP_ERROR_FILE, shown->folder,
                            "number %03d is not %s: `patterns` begins "
                            "with black and white",
                            i + 1, plain[i]);
    const int first = shown->n - shown->n_codes;
    if (shown->n_codes == 0) return true;
    const int count = 2 * (ffp_gray_code_bits(shown->width) + ffp_gray_code_bits(shown->height));
    for (int i = 0; i < count || i < shown->n_codes; i++) {
        char name[32];
        ffp_gray_code_name(shown->width, i, name);
        const bool there = i < shown->n_codes && i < count;
        if (!there || strcmp(shown->patterns[first + i].name, name) != 0)
            return ffp_fail(err, FFP_ERROR_FILE, shown->folder,
                            "number %03d is not %s: a panel of %d x %d pixels has %d Gray codes",
                            first + i + 1, i < count ? name : "there", shown->width, shown->height, count);
    }
    return true;
}

bool ffp_shown_list(FfpShown *shown, const char *folder, FfpError *err) {
    *shown = (FfpShown){.arena = ffp_arena_new()};
    shown->folder = ffp_arena_text(shown->arena, folder);
    shown->patterns = ffp_arena_alloc(shown->arena, SHOWN_MAX, sizeof *shown->patterns);
    if (!list(shown, err) || !check_sizes(shown, err)) return false;
    int first = 0;
    while (first < shown->n && !ffp_shown_is_code(shown, first)) first++;
    shown->n_codes = shown->n - first;
    return true;
}

bool ffp_shown_read(FfpShown *shown, const char *folder, FfpError *err) {
    return ffp_shown_list(shown, folder, err) && check_numbers(shown, err) && check_names(shown, err);
}

bool ffp_shown_photographed(const FfpShown *shown, FfpShownKind kind, int *plain, int *codes) {
    const int others = shown->n - shown->n_codes;
    *plain = kind == FFP_SHOWN_CODES ? 2 : others;
    *codes = kind == FFP_SHOWN_PLAIN ? 0 : shown->n_codes;
    return kind == FFP_SHOWN_ALL || (shown->n_codes > 0 && (kind == FFP_SHOWN_PLAIN || others > 2));
}

void ffp_shown_free(FfpShown *shown) {
    if (shown->arena) ffp_arena_free(shown->arena);
    *shown = (FfpShown){0};
}
