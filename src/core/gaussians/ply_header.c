#include "core/gaussians/ply_header.h"
#include <errno.h>
#include <inttypes.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include "core/gaussians/row.h"

#define PATTERN "comment made from pattern "
#define BAKED "comment shadows baked from "

enum { LINE_BYTES = 512, LINES_MAX = 4096 };

static bool starts_with(const char *line, const char *word) {
    return strncmp(line, word, strlen(word)) == 0;
}

static bool is_comment(const char *line) {
    return starts_with(line, "comment") || starts_with(line, "obj_info");
}

// One line without its end and blanks before it; false at the end of the file, or when it is longer than any
// sound one. Only comments may be longer: some programs keep their settings there, and the rest is left out.
static bool read_line(FILE *stream, char line[LINE_BYTES]) {
    size_t length = 0;
    bool whole = true;
    int c = getc(stream);
    for (; c != EOF && c != '\n'; c = getc(stream)) {
        whole = length + 1 < LINE_BYTES;
        if (whole) line[length++] = (char)c;
    }
    while (length > 0 && strchr(" \t\r", line[length - 1])) length--;
    line[length] = 0;
    return c == '\n' && (whole || is_comment(line));
}

static FfpPlyType type_of(const char *name) {
    static const char *const names[][2] = {
        [FFP_PLY_INT8] = {"char", "int8"},      [FFP_PLY_UINT8] = {"uchar", "uint8"},
        [FFP_PLY_INT16] = {"short", "int16"},   [FFP_PLY_UINT16] = {"ushort", "uint16"},
        [FFP_PLY_INT32] = {"int", "int32"},     [FFP_PLY_UINT32] = {"uint", "uint32"},
        [FFP_PLY_FLOAT] = {"float", "float32"}, [FFP_PLY_DOUBLE] = {"double", "float64"},
    };
    for (int i = 0; i < FFP_PLY_NO_TYPE; i++)
        if (strcmp(name, names[i][0]) == 0 || strcmp(name, names[i][1]) == 0) return (FfpPlyType)i;
    return FFP_PLY_NO_TYPE;
}

static bool known_type(FfpPlyType *type, const char *text, const char *line, const char *path,
                       FfpError *err) {
    *type = type_of(text);
    return *type != FFP_PLY_NO_TYPE ||
           ffp_fail(err, FFP_ERROR_FILE, path, "\"%.60s\": unknown type %s", line, text);
}

static bool read_property(FfpPly *ply, const char *line, const char *path, FfpError *err) {
    char length[32] = "", type[32], name[FFP_PLY_NAME], rest[2];
    FfpPlyElement *element = &ply->elements[ply->n_elements - 1];
    FfpPlyProperty one = {.length = FFP_PLY_NO_TYPE};
    if (sscanf(line, "property list %31s %31s %63s %1s", length, type, name, rest) == 3)
        element->lists = true;
    else if (sscanf(line, "property %31s %63s %1s", type, name, rest) != 2)
        return ffp_fail(err, FFP_ERROR_FILE, path, "PLY header: cannot understand \"%.60s\"", line);
    if (!known_type(&one.type, type, line, path, err) ||
        (length[0] && !known_type(&one.length, length, line, path, err)))
        return false;
    if (length[0] && one.length >= FFP_PLY_FLOAT)
        return ffp_fail(err, FFP_ERROR_FILE, path, "property %s: a list's length is a whole number", name);
    if (ffp_ply_find(ply, element, name) >= 0)
        return ffp_fail(err, FFP_ERROR_FILE, path, "duplicate property %s", name);
    if (ply->n_properties == FFP_PLY_PROPERTIES)
        return ffp_fail(err, FFP_ERROR_FILE, path, "has more than %d properties", FFP_PLY_PROPERTIES);
    snprintf(one.name, sizeof one.name, "%s", name);
    element->stride += ffp_ply_bytes(length[0] ? one.length : one.type);
    element->properties++;
    ply->properties[ply->n_properties++] = one;
    return true;
}

static bool read_element(FfpPly *ply, const char *line, const char *path, FfpError *err) {
    char name[FFP_PLY_NAME], number[32], rest[2];
    if (sscanf(line, "element %63s %31s %1s", name, number, rest) != 2)
        return ffp_fail(err, FFP_ERROR_FILE, path, "cannot understand \"%.60s\"", line);
    if (ffp_ply_element(ply, name))
        return ffp_fail(err, FFP_ERROR_FILE, path, "has an element %s twice", name);
    if (ply->n_elements == FFP_PLY_ELEMENTS)
        return ffp_fail(err, FFP_ERROR_FILE, path, "has more than %d elements", FFP_PLY_ELEMENTS);
    char *end = NULL;
    errno = 0;
    const long long count = strtoll(number, &end, 10);
    if (errno != 0 || *end != 0 || count < 0 || count > FFP_GAUSSIANS_MAX)
        return ffp_fail(err, FFP_ERROR_FILE, path, "element %s: count %s is not in 0..%d", name, number,
                        FFP_GAUSSIANS_MAX);
    FfpPlyElement *element = &ply->elements[ply->n_elements++];
    *element = (FfpPlyElement){.count = count, .first = ply->n_properties};
    snprintf(element->name, sizeof element->name, "%s", name);
    return true;
}

const FfpPlyElement *ffp_ply_element(const FfpPly *ply, const char *name) {
    for (int i = 0; i < ply->n_elements; i++)
        if (strcmp(ply->elements[i].name, name) == 0) return &ply->elements[i];
    return NULL;
}

int ffp_ply_find(const FfpPly *ply, const FfpPlyElement *element, const char *name) {
    for (int i = 0; i < element->properties; i++)
        if (strcmp(ply->properties[element->first + i].name, name) == 0) return i;
    return -1;
}

// X Y Z within R, in world units.
static bool read_baked(FfpBakedShadows *baked, const char *text) {
    static const char within[] = " within ";
    char *end = NULL;
    for (int k = 0; k < 3; k++, text = end) {
        baked->light[k] = (real)strtod(text, &end);
        if (end == text) return false;
    }
    if (strncmp(text, within, strlen(within)) != 0) return false;
    text += strlen(within);
    baked->within = (real)strtod(text, &end);
    if (end == text || *end) return false;
    return isfinite(baked->light[0]) && isfinite(baked->light[1]) && isfinite(baked->light[2]) &&
           isfinite(baked->within) && baked->within > 0;
}

static bool read_encoding(FfpPly *ply, FILE *stream, const char *path, FfpError *err) {
    static const char *const formats[] = {[FFP_PLY_ASCII] = "format ascii 1.0",
                                          [FFP_PLY_LITTLE] = "format binary_little_endian 1.0",
                                          [FFP_PLY_BIG] = "format binary_big_endian 1.0"};
    char line[LINE_BYTES];
    if (!read_line(stream, line) || strcmp(line, "ply") != 0)
        return ffp_fail(err, FFP_ERROR_FILE, path, "is not a PLY file");
    bool more = read_line(stream, line); // comments before the format break the rules, and occur
    while (more && (!*line || is_comment(line))) more = read_line(stream, line);
    for (int i = 0; more && i < 3; i++) {
        ply->encoding = (FfpPlyEncoding)i;
        if (strcmp(line, formats[i]) == 0) return true;
    }
    return ffp_fail(err, FFP_ERROR_FILE, path,
                    "PLY header: no format ascii, binary_little_endian or binary_big_endian 1.0");
}

bool ffp_ply_header_read(FfpPly *ply, FILE *stream, const char *path, FfpError *err) {
    char line[LINE_BYTES];
    *ply = (FfpPly){0};
    if (!read_encoding(ply, stream, path, err)) return false;
    for (int i = 0; i < LINES_MAX && read_line(stream, line); i++) {
        if (strcmp(line, "end_header") == 0) return true;
        if (starts_with(line, BAKED) && !read_baked(&ply->baked, line + strlen(BAKED)))
            return ffp_fail(err, FFP_ERROR_FILE, path, "PLY header: cannot understand \"%.60s\"", line);
        if (starts_with(line, PATTERN)) ffp_made_from_add(ply->made_from, line + strlen(PATTERN));
        if (!*line || is_comment(line)) continue;
        if (starts_with(line, "element ")) {
            if (!read_element(ply, line, path, err)) return false;
        } else if (starts_with(line, "property ") && ply->n_elements > 0) {
            if (!read_property(ply, line, path, err)) return false;
        } else {
            return ffp_fail(err, FFP_ERROR_FILE, path, "PLY header: cannot understand \"%.60s\"", line);
        }
    }
    return ffp_fail(err, FFP_ERROR_FILE, path, "PLY header has no end");
}

void ffp_ply_header_write(FILE *stream, int64_t count, const FfpGaussians *gaussians) {
    const FfpBakedShadows *baked = &gaussians->baked;
    fprintf(stream, "ply\nformat binary_little_endian 1.0\ncomment relightable Gaussians of ffprocams %s\n",
            FFP_VERSION);
    if (baked->within > 0)
        fprintf(stream, "%s%.9g %.9g %.9g within %.9g\n", BAKED, (double)baked->light[0],
                (double)baked->light[1], (double)baked->light[2], (double)baked->within);
    for (const char *at = gaussians->made_from; *at; at = strchr(at, '\n') + 1)
        fprintf(stream, "%s%.*s\n", PATTERN, (int)strcspn(at, "\n"), at);
    fprintf(stream, "element vertex %" PRId64 "\n", count);
    for (int i = 0; i < ffp_row_numbers(gaussians); i++)
        fprintf(stream, "property float %s\n", ffp_row_names[i]);
    fprintf(stream, "end_header\n");
}
