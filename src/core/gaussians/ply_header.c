#include "core/gaussians/ply_header.h"
#include <errno.h>
#include <inttypes.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#define PATTERN "comment made from pattern "
#define BAKED "comment shadows baked from "

enum { LINE_BYTES = 512, LINES_MAX = 4096, STRIDE_MAX = 65536 };

// One line without its end; false at the end of the file, or when it is longer than any sound one.
static bool read_line(FILE *stream, char line[LINE_BYTES]) {
    if (!fgets(line, LINE_BYTES, stream)) return false;
    const size_t length = strlen(line);
    if (length == 0 || line[length - 1] != '\n') return false;
    line[length - 1] = 0;
    if (length > 1 && line[length - 2] == '\r') line[length - 2] = 0;
    return true;
}

// Bytes of a scalar type; 0 when it is none.
static int type_bytes(const char *type) {
    static const struct {
        const char *name;
        int bytes;
    } types[] = {{"char", 1},  {"uchar", 1},   {"int8", 1},   {"uint8", 1},  {"short", 2}, {"ushort", 2},
                 {"int16", 2}, {"uint16", 2},  {"int", 4},    {"uint", 4},   {"int32", 4}, {"uint32", 4},
                 {"float", 4}, {"float32", 4}, {"double", 8}, {"float64", 8}};
    for (size_t i = 0; i < sizeof types / sizeof types[0]; i++)
        if (strcmp(type, types[i].name) == 0) return types[i].bytes;
    return 0;
}

static bool is_float(const char *type) {
    return strcmp(type, "float") == 0 || strcmp(type, "float32") == 0 || strcmp(type, "double") == 0 ||
           strcmp(type, "float64") == 0;
}

static bool read_property(FfpPlyHeader *header, const char *line, const char *path, FfpError *err) {
    char type[32], name[64], rest[2];
    if (sscanf(line, "property %31s %63s %1s", type, name, rest) != 2)
        return ffp_fail(err, FFP_ERROR_FILE, path, "property \"%s\" is not a single number", line);
    const int bytes = type_bytes(type);
    if (bytes == 0)
        return ffp_fail(err, FFP_ERROR_FILE, path, "property %s has the unknown type %s", name, type);
    for (int i = 0; i < FFP_ROW_NUMBERS; i++) {
        if (strcmp(name, ffp_row_names[i]) != 0) continue;
        if (header->offset[i] >= 0) return ffp_fail(err, FFP_ERROR_FILE, path, "duplicate property %s", name);
        if (!is_float(type))
            return ffp_fail(err, FFP_ERROR_FILE, path, "property %s is %s, not float", name, type);
        header->offset[i] = header->stride;
        header->wide |= bytes == 8 ? 1U << i : 0U;
    }
    header->stride += bytes;
    if (header->stride > STRIDE_MAX)
        return ffp_fail(err, FFP_ERROR_FILE, path, "a row has more than %d bytes", STRIDE_MAX);
    return true;
}

static bool read_element(FfpPlyHeader *header, const char *line, const char *path, FfpError *err) {
    char name[64], number[32], rest[2];
    if (sscanf(line, "element %63s %31s %1s", name, number, rest) != 2)
        return ffp_fail(err, FFP_ERROR_FILE, path, "cannot understand \"%s\"", line);
    if (strcmp(name, "vertex") != 0 || header->count >= 0)
        return ffp_fail(err, FFP_ERROR_FILE, path,
                        "has an element %s: Gaussians are a single element, vertex", name);
    char *end = NULL;
    errno = 0;
    const long long count = strtoll(number, &end, 10);
    if (errno != 0 || *end != 0 || count < 0 || count > FFP_GAUSSIANS_MAX)
        return ffp_fail(err, FFP_ERROR_FILE, path, "element vertex: count %s is not in 0..%d", number,
                        FFP_GAUSSIANS_MAX);
    header->count = count;
    return true;
}

static bool check_complete(FfpPlyHeader *header, const char *path, FfpError *err) {
    if (header->count < 0) return ffp_fail(err, FFP_ERROR_FILE, path, "holds no element vertex");
    header->plain = true;
    for (int i = FFP_ROW_ALBEDO; i < FFP_ROW_NUMBERS; i++) header->plain &= header->offset[i] < 0;
    header->flat = header->offset[FFP_ROW_SCALE + 2] < 0;
    for (int i = 0; i < FFP_ROW_NUMBERS; i++) {
        const bool optional =
            (header->plain && i >= FFP_ROW_ALBEDO) || (header->flat && i == FFP_ROW_SCALE + 2);
        if (header->offset[i] < 0 && !optional)
            return ffp_fail(err, FFP_ERROR_FILE, path, "property %s is missing", ffp_row_names[i]);
    }
    return true;
}

static bool starts_with(const char *line, const char *word) {
    return strncmp(line, word, strlen(word)) == 0;
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

bool ffp_ply_header_read(FfpPlyHeader *header, FILE *stream, const char *path, FfpError *err) {
    char line[LINE_BYTES];
    *header = (FfpPlyHeader){.count = -1};
    for (int i = 0; i < FFP_ROW_NUMBERS; i++) header->offset[i] = -1;
    if (!read_line(stream, line) || strcmp(line, "ply") != 0)
        return ffp_fail(err, FFP_ERROR_FILE, path, "is not a PLY file");
    if (!read_line(stream, line) || strcmp(line, "format binary_little_endian 1.0") != 0)
        return ffp_fail(err, FFP_ERROR_FILE, path, "PLY is not binary_little_endian 1.0");
    for (int i = 0; i < LINES_MAX && read_line(stream, line); i++) {
        if (strcmp(line, "end_header") == 0) return check_complete(header, path, err);
        if (starts_with(line, BAKED) && !read_baked(&header->baked, line + strlen(BAKED)))
            return ffp_fail(err, FFP_ERROR_FILE, path, "PLY header: cannot understand \"%.60s\"", line);
        if (starts_with(line, PATTERN)) ffp_made_from_add(header->made_from, line + strlen(PATTERN));
        if (starts_with(line, "comment") || starts_with(line, "obj_info")) continue;
        if (starts_with(line, "element ")) {
            if (!read_element(header, line, path, err)) return false;
        } else if (starts_with(line, "property ") && header->count >= 0) {
            if (!read_property(header, line, path, err)) return false;
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
    for (int i = 0; i < FFP_ROW_NUMBERS; i++) fprintf(stream, "property float %s\n", ffp_row_names[i]);
    fprintf(stream, "end_header\n");
}
