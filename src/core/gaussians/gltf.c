// glTF 2.0 with KHR_gaussian_splatting.
#include <jansson.h>
#include <math.h>
#include <stdio.h>
#include <string.h>
#include "core/base/base64.h"
#include "core/base/call.h"
#include "core/base/file.h"
#include "core/gaussians/elsewhere.h"

#define GLB_HEAD 12
#define CHUNK_HEAD 8
#define CHUNK_JSON 0x4e4f534aU
#define CHUNK_BINARY 0x004e4942U
enum { BUFFERS_MAX = 16, DEPTH_MAX = 16, KIND_FLOAT = 5126 };

typedef struct Buffer {
    const unsigned char *bytes;
    size_t size;
    void *own; // to be freed
} Buffer;

typedef struct Gltf {
    const char *path;
    json_t *root;
    Buffer buffers[BUFFERS_MAX];
    int n_buffers;
    Buffer chunk; // of a GLB
} Gltf;

// An attribute of all splats: numbers at bytes + i * stride.
typedef struct Numbers {
    const unsigned char *bytes;
    size_t stride;
    int kind, width;
    int64_t count;
} Numbers;

static uint32_t get_u32(const unsigned char *bytes) {
    return bytes[0] | (uint32_t)bytes[1] << 8 | (uint32_t)bytes[2] << 16 | (uint32_t)bytes[3] << 24;
}

static void release(void *value) {
    json_decref(value);
}

static bool fail(const Gltf *gltf, FfpError *err, const char *what) {
    ffp_fail(err, FFP_ERROR_FILE, gltf->path, "%s", what);
    return false;
}

// --- The file: JSON and buffers. ---

static bool parse(Gltf *gltf, const char *text, size_t size, FfpError *err) {
    json_error_t why;
    gltf->root = json_loadb(text, size, JSON_REJECT_DUPLICATES, &why);
    if (!gltf->root) return ffp_fail(err, FFP_ERROR_FILE, gltf->path, "line %d: %s", why.line, why.text);
    ffp_own(gltf->root, release);
    return json_is_object(gltf->root) || fail(gltf, err, "JSON is not an object");
}

static bool open_binary(Gltf *gltf, const unsigned char *bytes, size_t size, FfpError *err) {
    size_t at = GLB_HEAD;
    const char *json = NULL;
    size_t json_size = 0;
    if (size < GLB_HEAD || get_u32(bytes + 4) != 2) return fail(gltf, err, "is not glTF of version 2");
    while (size - at >= CHUNK_HEAD) {
        const size_t length = get_u32(bytes + at);
        const uint32_t kind = get_u32(bytes + at + 4);
        at += CHUNK_HEAD;
        if (length > size - at) return fail(gltf, err, "ends inside a chunk");
        if (kind == CHUNK_JSON && !json) {
            json = (const char *)bytes + at;
            json_size = length;
        }
        if (kind == CHUNK_BINARY && !gltf->chunk.bytes) gltf->chunk = (Buffer){bytes + at, length, NULL};
        at += length;
    }
    return json ? parse(gltf, json, json_size, err) : fail(gltf, err, "holds no JSON");
}

static bool decode_uri(const Gltf *gltf, Buffer *buffer, const char *uri, FfpError *err) {
    const char *text = strstr(uri, ";base64,");
    if (!text) return fail(gltf, err, "buffers: a data URI that is not base64");
    text += strlen(";base64,");
    const size_t length = strlen(text);
    unsigned char *bytes = ffp_alloc(length / 4 * 3 + 3, 1);
    const ptrdiff_t size = ffp_read_base64(bytes, text, length);
    *buffer = (Buffer){bytes, size > 0 ? (size_t)size : 0, bytes};
    return size >= 0 || fail(gltf, err, "buffers: a data URI that is not base64");
}

// A file beside the JSON: its name must not lead elsewhere.
static bool read_beside(const Gltf *gltf, Buffer *buffer, const char *uri, FfpError *err) {
    char path[FFP_PATH_MAX];
    char *data;
    const char *base = ffp_basename(gltf->path);
    if (strchr(uri, '/') || strchr(uri, '\\') || strchr(uri, ':') || uri[0] == '.' ||
        snprintf(path, sizeof path, "%.*s%s", (int)(base - gltf->path), gltf->path, uri) >= FFP_PATH_MAX)
        return ffp_fail(err, FFP_ERROR_FILE, gltf->path, "buffers: '%.100s' is not a file beside it", uri);
    if (!ffp_read_file(path, FFP_SPLAT_FILE_MAX, &data, &buffer->size, err)) return false;
    buffer->bytes = buffer->own = data;
    return true;
}

static bool open_buffers(Gltf *gltf, FfpError *err) {
    const json_t *list = json_object_get(gltf->root, "buffers");
    if (json_array_size(list) > BUFFERS_MAX) return fail(gltf, err, "has too many buffers");
    for (size_t i = 0; i < json_array_size(list); i++) {
        const char *uri = json_string_value(json_object_get(json_array_get(list, i), "uri"));
        Buffer *buffer = &gltf->buffers[gltf->n_buffers++];
        if (!uri)
            *buffer = gltf->chunk;
        else if (!(strncmp(uri, "data:", 5) == 0 ? decode_uri : read_beside)(gltf, buffer, uri, err))
            return false;
    }
    return true;
}

// --- Accessors. ---

static size_t bytes_of(int kind) {
    return kind == 5120 || kind == 5121 ? 1 : kind == 5122 || kind == 5123 ? 2 : kind == KIND_FLOAT ? 4 : 0;
}

// A whole number in 0..2^52; -1: there is none.
static int64_t whole(const json_t *object, const char *key, int64_t missing) {
    const json_t *value = json_object_get(object, key);
    if (!value) return missing;
    const json_int_t number = json_is_integer(value) ? json_integer_value(value) : -1;
    return number >= 0 && number <= (json_int_t)1 << 52 ? number : -1;
}

static int width_of(const char *type) {
    static const char *const types[] = {"SCALAR", "VEC2", "VEC3", "VEC4"};
    for (int i = 0; type && i < 4; i++)
        if (strcmp(type, types[i]) == 0) return i + 1;
    return 0;
}

static bool lies_inside(const Gltf *gltf, const json_t *view, int64_t offset, Numbers *out) {
    const int64_t buffer = whole(view, "buffer", -1), begin = whole(view, "byteOffset", 0),
                  length = whole(view, "byteLength", -1);
    const int64_t element = (int64_t)bytes_of(out->kind) * out->width,
                  stride = whole(view, "byteStride", element);
    if (buffer < 0 || buffer >= gltf->n_buffers || begin < 0 || length < 0 || stride < element ||
        stride > 65536 || offset < 0)
        return false;
    const Buffer *from = &gltf->buffers[buffer];
    const int64_t size = (int64_t)from->size;
    if (begin > size || length > size - begin || offset > length) return false;
    if (out->count > 0 && !from->bytes) return false;
    if (out->count > 0 && (out->count - 1) * stride + element > length - offset) return false;
    out->bytes = from->bytes ? from->bytes + begin + offset : NULL;
    out->stride = (size_t)stride;
    return true;
}

static bool find_numbers(const Gltf *gltf, const json_t *attributes, const char *name, int width,
                         Numbers *out, FfpError *err) {
    const json_t *index = json_object_get(attributes, name);
    if (!json_is_integer(index)) {
        ffp_fail(err, FFP_ERROR_FILE, gltf->path, "attribute %s is missing", name);
        return false;
    }
    const json_int_t at = json_integer_value(index);
    const json_t *accessor =
        at < 0 ? NULL : json_array_get(json_object_get(gltf->root, "accessors"), (size_t)at);
    const int64_t kind = whole(accessor, "componentType", -1), view = whole(accessor, "bufferView", -1);
    *out = (Numbers){.kind = (int)(kind < 65536 ? kind : 0),
                     .width = width_of(json_string_value(json_object_get(accessor, "type"))),
                     .count = whole(accessor, "count", -1)};
    const bool sound = bytes_of(out->kind) > 0 && out->width == width && out->count >= 0 &&
                       out->count <= FFP_GAUSSIANS_MAX && view >= 0 && !json_object_get(accessor, "sparse") &&
                       (out->kind == KIND_FLOAT || json_is_true(json_object_get(accessor, "normalized")));
    const json_t *of =
        view < 0 ? NULL : json_array_get(json_object_get(gltf->root, "bufferViews"), (size_t)view);
    if (sound && lies_inside(gltf, of, whole(accessor, "byteOffset", 0), out)) return true;
    ffp_fail(err, FFP_ERROR_FILE, gltf->path,
             "attribute %s: its accessor does not give %d numbers a splat inside a buffer", name, width);
    return false;
}

static double number_at(const Numbers *numbers, int64_t i, int c) {
    const size_t each = bytes_of(numbers->kind);
    const unsigned char *at = numbers->bytes + (size_t)i * numbers->stride + (size_t)c * each;
    const uint32_t small = each == 1 ? at[0] : at[0] | (uint32_t)at[1] << 8,
                   bits = each == 4 ? get_u32(at) : 0;
    float value;
    switch (numbers->kind) {
    case 5120:
        return fmax((double)(int8_t)small / 127, -1);
    case 5121:
        return small / 255.0;
    case 5122:
        return fmax((double)(int16_t)small / 32767, -1);
    case 5123:
        return small / 65535.0;
    default:
        memcpy(&value, &bits, sizeof value);
        return (double)value;
    }
}

// --- Splats. ---

// Its mesh comes back too; NULL: there is none, or more than one.
static const json_t *find_primitive(const Gltf *gltf, json_int_t *mesh, FfpError *err) {
    const json_t *meshes = json_object_get(gltf->root, "meshes"), *found = NULL;
    for (size_t m = 0; m < json_array_size(meshes); m++) {
        const json_t *list = json_object_get(json_array_get(meshes, m), "primitives");
        for (size_t p = 0; p < json_array_size(list); p++) {
            const json_t *one = json_array_get(list, p);
            if (!json_object_get(json_object_get(one, "extensions"), FFP_SPLAT_EXTENSION)) continue;
            if (found) {
                fail(gltf, err, "holds several sets of splats: export them as one");
                return NULL;
            }
            found = one;
            *mesh = (json_int_t)m;
        }
    }
    if (!found) fail(gltf, err, "holds no splats (" FFP_SPLAT_EXTENSION ")");
    return found;
}

static bool holds(const json_t *node, json_int_t mesh, const bool *on_way, size_t n) {
    const json_t *own = json_object_get(node, "mesh"), *children = json_object_get(node, "children");
    bool yes = json_is_integer(own) && json_integer_value(own) == mesh;
    for (size_t c = 0; c < json_array_size(children); c++) {
        const json_int_t child = json_integer_value(json_array_get(children, c));
        yes = yes || (child >= 0 && (size_t)child < n && on_way[child]);
    }
    return yes;
}

// Nodes on the way to the mesh whose transform would need to be applied to centres, sizes and rotations.
static bool check_nodes(const Gltf *gltf, json_int_t mesh, FfpError *err) {
    static const char *const moves[] = {"matrix", "translation", "rotation", "scale"};
    const json_t *nodes = json_object_get(gltf->root, "nodes");
    const size_t n = json_array_size(nodes);
    bool *on_way = ffp_alloc(n, sizeof *on_way), ok = true;
    for (int depth = 0; depth < DEPTH_MAX; depth++)
        for (size_t i = 0; i < n; i++) on_way[i] |= holds(json_array_get(nodes, i), mesh, on_way, n);
    for (size_t i = 0; i < n && ok; i++)
        for (int k = 0; k < 4 && ok; k++)
            if (on_way[i] && json_object_get(json_array_get(nodes, i), moves[k]))
                ok =
                    ffp_fail(err, FFP_ERROR_UNSUPPORTED, gltf->path,
                             "nodes[%zu] has a %s: apply it in the program that wrote the file", i, moves[k]);
    ffp_free(on_way);
    return ok;
}

typedef struct Splats {
    Numbers position, rotation, scale, opacity, colour;
    bool linear; // the colour is linear light
} Splats;

static bool find_splats(const Gltf *gltf, Splats *splats, FfpError *err) {
    json_int_t mesh = 0;
    const json_t *primitive = find_primitive(gltf, &mesh, err);
    if (!primitive || !check_nodes(gltf, mesh, err)) return false;
    const json_t *how = json_object_get(json_object_get(primitive, "extensions"), FFP_SPLAT_EXTENSION);
    if (json_object_get(how, "extensions")) {
        ffp_fail(err, FFP_ERROR_UNSUPPORTED, gltf->path,
                 "its splats are compressed: export them uncompressed, or as SPZ");
        return false;
    }
    const char *space = json_string_value(json_object_get(how, "colorSpace"));
    const json_t *of = json_object_get(primitive, "attributes");
    splats->linear = space && strncmp(space, "lin_", 4) == 0;
    if (!find_numbers(gltf, of, "POSITION", 3, &splats->position, err) ||
        !find_numbers(gltf, of, FFP_SPLAT_EXTENSION ":ROTATION", 4, &splats->rotation, err) ||
        !find_numbers(gltf, of, FFP_SPLAT_EXTENSION ":SCALE", 3, &splats->scale, err) ||
        !find_numbers(gltf, of, FFP_SPLAT_EXTENSION ":OPACITY", 1, &splats->opacity, err) ||
        !find_numbers(gltf, of, FFP_SPLAT_EXTENSION ":SH_DEGREE_0_COEF_0", 3, &splats->colour, err))
        return false;
    const int64_t n = splats->position.count;
    return (splats->rotation.count == n && splats->scale.count == n && splats->opacity.count == n &&
            splats->colour.count == n) ||
           fail(gltf, err, "its attributes have different counts");
}

static void get_row(const Splats *splats, int64_t i, float row[FFP_ROW_NUMBERS]) {
    // NaN, which fmax would hide, stays one, and ffp_splat_put names it; so does the logarithm of a scale
    // below 0
    const double given = number_at(&splats->opacity, i, 0),
                 opacity = isnan(given) ? given : fmin(fmax(given, 1e-6), 1 - 1e-6);
    memset(row, 0, FFP_ROW_NUMBERS * sizeof *row);
    for (int k = 0; k < 3; k++) {
        row[FFP_ROW_POSITION + k] = (float)number_at(&splats->position, i, k);
        row[FFP_ROW_SCALE + k] = (float)log(number_at(&splats->scale, i, k));
        row[FFP_ROW_AMBIENT + k] = (float)number_at(&splats->colour, i, k);
    }
    row[FFP_ROW_OPACITY] = (float)log(opacity / (1 - opacity));
    for (int k = 0; k < 4; k++) // x y z w in the file
        row[FFP_ROW_ROTATION + k] = (float)number_at(&splats->rotation, i, (k + 3) % 4);
}

// Colours in linear light were decoded as if they were encoded.
static void take_linear(FfpGaussians *gaussians, int64_t i, const float row[FFP_ROW_NUMBERS]) {
    for (int k = 0; k < 3; k++)
        gaussians->ambient[3 * i + k] = (real)(0.5 + FFP_SH_C0 * (double)row[FFP_ROW_AMBIENT + k]);
    ffp_splat_complete(gaussians, i);
}

static bool read_splats(FfpGaussians *gaussians, const Gltf *gltf, FfpError *err) {
    Splats splats = {0};
    if (!find_splats(gltf, &splats, err)) return false;
    *gaussians = ffp_gaussians_new(splats.position.count);
    for (int64_t i = 0; i < gaussians->count; i++) {
        float row[FFP_ROW_NUMBERS];
        get_row(&splats, i, row);
        if (!ffp_splat_put(gaussians, i, row, gltf->path, err)) {
            ffp_gaussians_free(gaussians);
            return false;
        }
        if (splats.linear) take_linear(gaussians, i, row);
    }
    return true;
}

bool ffp_gaussians_read_gltf(FfpGaussians *gaussians, const char *path, FfpError *err) {
    Gltf gltf = {.path = path};
    char *data;
    size_t size;
    *gaussians = (FfpGaussians){0};
    if (!ffp_read_file(path, FFP_SPLAT_FILE_MAX, &data, &size, err)) return false;
    const bool binary = size >= 4 && memcmp(data, "glTF", 4) == 0;
    const bool ok = (binary ? open_binary(&gltf, (const unsigned char *)data, size, err)
                            : parse(&gltf, data, size, err)) &&
                    open_buffers(&gltf, err) && read_splats(gaussians, &gltf, err);
    for (int i = 0; i < gltf.n_buffers; i++) ffp_free(gltf.buffers[i].own);
    if (gltf.root) {
        ffp_disown(gltf.root);
        json_decref(gltf.root);
    }
    ffp_free(data);
    if (ok) ffp_splats_note(path);
    return ok;
}
