#include "world/synth/pattern_folder.h"
#include <ctype.h>
#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include "core/base/file.h"
#include "core/base/listing.h"
#include "world/synth/sensor.h"

enum { SIDE_MIN = 64 };

// "002_black.png"; a focus chart is to be looked at, not photographed.
static bool parse_pattern(const char *file, FfpNumbered *pattern) {
    int digits = 0, number = 0;
    for (; digits < 6 && isdigit((unsigned char)file[digits]); digits++)
        number = 10 * number + file[digits] - '0';
    const size_t length = strlen(file);
    if (digits == 0 || file[digits] != '_' || length < 5 || length >= sizeof pattern->file ||
        strcmp(file + length - 4, ".png") != 0 || strncmp(file + digits, "_focus", 6) == 0)
        return false;
    pattern->number = number;
    snprintf(pattern->file, sizeof pattern->file, "%s", file);
    snprintf(pattern->name, sizeof pattern->name, "%.*s", (int)length - digits - 5, file + digits + 1);
    return true;
}

static int by_number(const void *a, const void *b) {
    return ((const FfpNumbered *)a)->number - ((const FfpNumbered *)b)->number;
}

static bool list_patterns(FfpPatternFolder *p, FfpError *err) {
    FfpListing listing;
    if (!ffp_list_folder(&listing, p->folder))
        return ffp_fail(err, FFP_ERROR_IO, p->folder, "cannot read the patterns' folder: %s",
                        strerror(errno));
    for (int i = 0; i < listing.count; i++)
        if (p->count < FFP_PATTERNS_MAX && parse_pattern(listing.names[i], &p->list[p->count])) p->count++;
    ffp_free(listing.names);
    if (p->count == 0)
        return ffp_fail(err, FFP_ERROR_FILE, p->folder,
                        "no pattern is called <number>_<name>.png, as those of `patterns` are");
    qsort(p->list, (size_t)p->count, sizeof *p->list, by_number);
    for (int i = 1; i < p->count; i++)
        if (p->list[i].number == p->list[i - 1].number)
            return ffp_fail(err, FFP_ERROR_FILE, p->folder, "%s and %s have the same number",
                            p->list[i - 1].file, p->list[i].file);
    return true;
}

bool ffp_pattern_folder_path(const FfpPatternFolder *p, int index, char path[FFP_PATH_MAX], FfpError *err) {
    return ffp_join_path(path, p->folder, p->list[index].file) ||
           ffp_fail(err, FFP_ERROR_ARGUMENT, p->folder, "the path is too long");
}

// All sizes alike, told before the work.
static bool read_sizes(FfpPatternFolder *p, FfpError *err) {
    for (int i = 0; i < p->count; i++) {
        char path[FFP_PATH_MAX];
        int w, h;
        if (!ffp_pattern_folder_path(p, i, path, err) || !ffp_image_read_size(&w, &h, path, err))
            return false;
        if (i == 0) p->width = w, p->height = h;
        if (w != p->width || h != p->height)
            return ffp_fail(err, FFP_ERROR_FILE, path, "%d x %d pixels, but %s has %d x %d", w, h,
                            p->list[0].file, p->width, p->height);
        if (w < SIDE_MIN || h < SIDE_MIN)
            return ffp_fail(err, FFP_ERROR_FILE, path, "%d x %d pixels: a panel has at least %d a side", w, h,
                            SIDE_MIN);
    }
    return true;
}

bool ffp_pattern_folder_open(FfpPatternFolder *patterns, const char *folder, FfpError *err) {
    *patterns =
        (FfpPatternFolder){.folder = folder, .list = ffp_alloc(FFP_PATTERNS_MAX, sizeof *patterns->list)};
    if (list_patterns(patterns, err) && read_sizes(patterns, err)) return true;
    ffp_pattern_folder_close(patterns);
    return false;
}

void ffp_pattern_folder_close(FfpPatternFolder *patterns) {
    ffp_free(patterns->list);
    *patterns = (FfpPatternFolder){0};
}

bool ffp_pattern_emit(const char *path, const FfpSensor *sensor, FfpImage *emitted, FfpError *err) {
    if (!ffp_image_read_over_black(emitted, NULL, path, err)) return false;
    if (!ffp_sensor_changes_light(sensor)) return true;
    FfpImage sent = *emitted;
    *emitted = ffp_sensor_emit(&sent, sensor);
    ffp_image_free(&sent);
    return true;
}

bool ffp_pattern_folder_emit(const FfpPatternFolder *patterns, int index, const FfpSensor *sensor,
                             FfpImage *emitted, FfpError *err) {
    char path[FFP_PATH_MAX];
    return ffp_pattern_folder_path(patterns, index, path, err) &&
           ffp_pattern_emit(path, sensor, emitted, err);
}
