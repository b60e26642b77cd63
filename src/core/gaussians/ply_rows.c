// The rows of a PLY file, one at a time.
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include "core/base/file.h"
#include "core/gaussians/elsewhere.h"
#include "core/gaussians/ply_header.h"

enum { WORD_BYTES = 64 };

int ffp_ply_bytes(FfpPlyType type) {
    static const int bytes[] = {1, 1, 2, 2, 4, 4, 4, 8, 0};
    return bytes[type];
}

static bool has_lists(const FfpPly *ply) {
    bool lists = false;
    for (int i = 0; i < ply->n_elements; i++) lists |= ply->elements[i].lists;
    return lists;
}

bool ffp_ply_check_size(const FfpPly *ply, FILE *stream, const char *path, FfpError *err) {
    const int64_t size = ffp_file_size(stream);
    if (size < 0) return ffp_fail(err, FFP_ERROR_FILE, path, "its size is unknown");
    const bool text = ply->encoding == FFP_PLY_ASCII;
    const int64_t rest = size - (int64_t)ftello(stream);
    int64_t want = text ? -1 : 0; // every number of a text has a character after it, but perhaps the last
    for (int i = 0; i < ply->n_elements; i++) {
        const FfpPlyElement *element = &ply->elements[i];
        if (element->count > 0 && element->properties == 0)
            return ffp_fail(err, FFP_ERROR_FILE, path, "element %s has no property", element->name);
        want += element->count * (text ? 2 * element->properties : element->stride);
    }
    if (rest > want && !text && !has_lists(ply)) ffp_splats_note_rest(path, rest - want);
    if (rest >= want) return true;
    return ffp_fail(err, FFP_ERROR_FILE, path,
                    "its header asks for %lld bytes after it, but the file has %lld", (long long)want,
                    (long long)rest);
}

static double decode(const unsigned char *bytes, FfpPlyType type, FfpPlyEncoding encoding) {
    const int n = ffp_ply_bytes(type);
    uint64_t bits = 0;
    for (int i = 0; i < n; i++) bits |= (uint64_t)bytes[encoding == FFP_PLY_BIG ? n - 1 - i : i] << (8 * i);
    const uint32_t low = (uint32_t)bits;
    float single;
    double value;
    switch (type) {
    case FFP_PLY_INT8:
        return (int8_t)low;
    case FFP_PLY_INT16:
        return (int16_t)low;
    case FFP_PLY_INT32:
        return (int32_t)low;
    case FFP_PLY_FLOAT:
        memcpy(&single, &low, sizeof single);
        return (double)single;
    case FFP_PLY_DOUBLE:
        memcpy(&value, &bits, sizeof value);
        return value;
    default:
        return low;
    }
}

// The words of older Microsoft libraries for nan and inf, behind the 1 that strtod takes: "1.#QNAN",
// "-1.#IND00", "1.#INF", "1.#J" (inf with few digits).
static bool read_old_nan(const char *rest, double *value) {
    static const char *const words[] = {"#INF", "#J", "#QNAN", "#SNAN", "#IND"};
    if (fabs(*value) != 1) return false;
    for (size_t i = 0; i < sizeof words / sizeof *words; i++) {
        const size_t length = strlen(words[i]);
        if (strncmp(rest, words[i], length) != 0 || rest[length + strspn(rest + length, "0")]) continue;
        *value = i < 2 ? copysign(INFINITY, *value) : NAN;
        return true;
    }
    return false;
}

// One number of a text; nan and inf are what other programs write for them.
static bool read_word(FILE *stream, double *value) {
    char word[WORD_BYTES], *end;
    int c = getc(stream), n = 0;
    while (c == ' ' || c == '\t' || c == '\n' || c == '\r') c = getc(stream);
    for (; c != EOF && c > ' ' && n < WORD_BYTES - 1; c = getc(stream)) word[n++] = (char)c;
    word[n] = 0;
    *value = strtod(word, &end);
    return n > 0 && (*end == 0 || read_old_nan(end, value)) && (c == EOF || c <= ' ');
}

static bool read_number(const FfpPly *ply, FfpPlyType type, FILE *stream, double *value) {
    unsigned char bytes[8];
    if (ply->encoding == FFP_PLY_ASCII) return read_word(stream, value);
    if (fread(bytes, (size_t)ffp_ply_bytes(type), 1, stream) != 1) return false;
    *value = decode(bytes, type, ply->encoding);
    return true;
}

static bool read_list(const FfpPly *ply, const FfpPlyProperty *property, FILE *stream, double *length) {
    double skipped;
    if (!read_number(ply, property->length, stream, length) || !(*length >= 0 && *length <= UINT32_MAX))
        return false;
    for (int64_t i = 0; i < (int64_t)*length; i++)
        if (!read_number(ply, property->type, stream, &skipped)) return false;
    return true;
}

bool ffp_ply_row(const FfpPly *ply, const FfpPlyElement *element, FILE *stream, double *values,
                 const char *path, FfpError *err) {
    const FfpPlyProperty *properties = ply->properties + element->first;
    const bool packed = ply->encoding != FFP_PLY_ASCII && !element->lists;
    unsigned char row[8 * FFP_PLY_PROPERTIES];
    if (packed && fread(row, (size_t)element->stride, 1, stream) != 1)
        return ffp_fail(err, FFP_ERROR_IO, path, "element %s: cannot read all rows", element->name);
    const unsigned char *at = row;
    for (int i = 0; i < element->properties; i++) {
        const FfpPlyProperty *one = &properties[i];
        bool ok = true;
        if (packed) {
            values[i] = decode(at, one->type, ply->encoding);
            at += ffp_ply_bytes(one->type);
        } else {
            ok = one->length != FFP_PLY_NO_TYPE ? read_list(ply, one, stream, &values[i])
                                                : read_number(ply, one->type, stream, &values[i]);
        }
        if (!ok)
            return ffp_fail(err, FFP_ERROR_FILE, path, "element %s, property %s: %s", element->name,
                            one->name, feof(stream) ? "the file ends" : "cannot understand a row");
    }
    return true;
}

bool ffp_ply_skip(const FfpPly *ply, const FfpPlyElement *element, FILE *stream, const char *path,
                  FfpError *err) {
    double values[FFP_PLY_PROPERTIES];
    for (int64_t i = 0; i < element->count; i++)
        if (!ffp_ply_row(ply, element, stream, values, path, err)) return false;
    return true;
}
