// glTF 2.0 with KHR_gaussian_splatting.
#include <jansson.h>
#include <limits.h>
#include <math.h>
#include <stdio.h>
#include <string.h>
#include "core/base/base64.h"
#include "core/base/call.h"
#include "core/base/file.h"
#include "core/base/log.h"
#include "core/base/memory_file.h"
#include "core/gaussians/affine.h"
#include "core/gaussians/elsewhere.h"

#define GLB_HEAD 12
#define CHUNK_HEAD 8
#define CHUNK_JSON 0x4e4f534aU
#define CHUNK_BINARY 0x004e4942U
#define PACKED "KHR_gaussian_splatting_compression_spz_2"
enum { BUFFERS_MAX = 16, DEPTH_MAX = 64, SETS_MAX = 65536, KIND_FLOAT = 5126 };

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
    bool normalised;
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
    const size_t told = get_u32(bytes + 8);
    if (told >= GLB_HEAD && told < size) {
        ffp_splats_note_rest(gltf->path, (int64_t)(size - told));
        size = told;
    }
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

static int digit(char c) {
    return c >= '0' && c <= '9' ? c - '0' : (c | 32) >= 'a' && (c | 32) <= 'f' ? (c | 32) - 'a' + 10 : -1;
}

// "%20" and the like (RFC 3986); false if what they stand for does not fit, or is a control character.
static bool decode_percent(char out[FFP_PATH_MAX], const char *uri) {
    size_t n = 0;
    for (; *uri && n + 1 < FFP_PATH_MAX; uri++) {
        const bool coded = *uri == '%' && digit(uri[1]) >= 0 && digit(uri[2]) >= 0;
        const char c = coded ? (char)(digit(uri[1]) << 4 | digit(uri[2])) : *uri;
        if ((unsigned char)c < ' ') return false;
        out[n++] = c;
        uri += coded ? 2 : 0;
    }
    out[n] = 0;
    return *uri == 0;
}

// True if it leads nowhere but to the folder that it begins in, or below.
static bool leads_below(const char *name) {
    if (name[0] == '/' || name[0] == 0 || strchr(name, '\\') || strchr(name, ':')) return false;
    for (const char *at = name; at; at = strchr(at, '/')) {
        at += *at == '/';
        if (strncmp(at, "..", 2) == 0 && (at[2] == '/' || at[2] == 0)) return false;
    }
    return true;
}

// A file beside the JSON or below it: its name must not lead elsewhere.
static bool read_beside(const Gltf *gltf, Buffer *buffer, const char *uri, FfpError *err) {
    char path[FFP_PATH_MAX], name[FFP_PATH_MAX] = "";
    char *data;
    const char *base = ffp_basename(gltf->path);
    if (ffp_memory_file(gltf->path))
        return ffp_fail(err, FFP_ERROR_FILE, gltf->path,
                        "buffers: contents in memory cannot name a file ('%.100s')", uri);
    if (!decode_percent(name, uri) || !leads_below(name) ||
        snprintf(path, sizeof path, "%.*s%s", (int)(base - gltf->path), gltf->path, name) >= FFP_PATH_MAX)
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
            *buffer =
                i == 0 ? gltf->chunk : (Buffer){0}; // others without one stand for what an extension unpacks
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

// A part of a buffer; false if it does not lie inside one.
static bool find_view(const Gltf *gltf, const json_t *view, Buffer *out) {
    const int64_t buffer = whole(view, "buffer", -1), begin = whole(view, "byteOffset", 0),
                  length = whole(view, "byteLength", -1);
    if (buffer < 0 || buffer >= gltf->n_buffers || begin < 0 || length < 0) return false;
    const Buffer *from = &gltf->buffers[buffer];
    const int64_t size = (int64_t)from->size;
    if (begin > size || length > size - begin) return false;
    *out = (Buffer){from->bytes ? from->bytes + begin : NULL, (size_t)length, NULL};
    return true;
}

static const json_t *view_at(const Gltf *gltf, int64_t index) {
    return index < 0 ? NULL : json_array_get(json_object_get(gltf->root, "bufferViews"), (size_t)index);
}

static bool lies_inside(const Gltf *gltf, const json_t *view, int64_t offset, Numbers *out) {
    Buffer from;
    const int64_t element = (int64_t)bytes_of(out->kind) * out->width,
                  stride = whole(view, "byteStride", element);
    if (!find_view(gltf, view, &from) || stride < element || stride > 65536 || offset < 0) return false;
    const int64_t length = (int64_t)from.size;
    if (offset > length || (out->count > 0 && !from.bytes)) return false;
    if (out->count > 0 && (out->count - 1) * stride + element > length - offset) return false;
    out->bytes = from.bytes ? from.bytes + offset : NULL;
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
    if (json_object_get(accessor, "sparse"))
        return ffp_fail(err, FFP_ERROR_UNSUPPORTED, gltf->path,
                        "attribute %s: its accessor is sparse, which is not supported: export it as PLY",
                        name);
    *out = (Numbers){.kind = (int)(kind < 65536 ? kind : 0),
                     .width = width_of(json_string_value(json_object_get(accessor, "type"))),
                     .normalised = json_is_true(json_object_get(accessor, "normalized")),
                     .count = whole(accessor, "count", -1)};
    const bool sound = bytes_of(out->kind) > 0 && out->width == width && out->count >= 0 &&
                       out->count <= FFP_GAUSSIANS_MAX && view >= 0;
    if (sound && lies_inside(gltf, view_at(gltf, view), whole(accessor, "byteOffset", 0), out)) return true;
    ffp_fail(err, FFP_ERROR_FILE, gltf->path,
             "attribute %s: its accessor does not give %d numbers a splat inside a buffer", name, width);
    return false;
}

static double number_at(const Numbers *numbers, int64_t i, int c) {
    const size_t each = bytes_of(numbers->kind);
    const unsigned char *at = numbers->bytes + (size_t)i * numbers->stride + (size_t)c * each;
    const uint32_t small = each == 1 ? at[0] : at[0] | (uint32_t)at[1] << 8,
                   bits = each == 4 ? get_u32(at) : 0;
    const bool normalised = numbers->normalised;
    float value;
    switch (numbers->kind) {
    case 5120:
        return normalised ? fmax((double)(int8_t)small / 127, -1) : (int8_t)small;
    case 5121:
        return normalised ? small / 255.0 : small;
    case 5122:
        return normalised ? fmax((double)(int16_t)small / 32767, -1) : (int16_t)small;
    case 5123:
        return normalised ? small / 65535.0 : small;
    default:
        memcpy(&value, &bits, sizeof value);
        return (double)value;
    }
}

// --- Splats. ---

typedef struct Splats {
    Numbers position, rotation, scale, opacity, colour;
    FfpSpz *packed; // holds them all; otherwise NULL
    int64_t count;
    bool linear;    // the colour is linear light
    bool harmonics; // beyond the constant
} Splats;

// Checks the extension for settings that cannot be read, or that are drawn otherwise than the primitive asks
// for.
static bool check_extension(const Gltf *gltf, const json_t *how, FfpError *err) {
    const char *kernel = json_string_value(json_object_get(how, "kernel")), *name;
    json_t *of = json_object_get(how, "extensions"), *value;
    const char *other = kernel && strcmp(kernel, "ellipse") != 0 ? kernel : NULL;
    json_object_foreach(of, name, value) {
        if (strcmp(name, PACKED) == 0) continue;
        if (strstr(name, "compression")) {
            ffp_fail(err, FFP_ERROR_UNSUPPORTED, gltf->path,
                     "its splats are compressed (%.60s): export them uncompressed, or as SPZ", name);
            return false;
        }
        other = other ? other : name;
    }
    if (other)
        ffp_note("%s: splats of %.60s are drawn as ellipses, without what it adds", ffp_basename(gltf->path),
                 other);
    return true;
}

// Whoever does not know an extension that a file requires shall not read the file (glTF 2.0, 3.12).
static bool check_required(const Gltf *gltf, FfpError *err) {
    static const char *const known[] = {FFP_SPLAT_EXTENSION, PACKED, "KHR_materials_unlit",
                                        "KHR_mesh_quantization"};
    const json_t *list = json_object_get(gltf->root, "extensionsRequired");
    for (size_t i = 0; i < json_array_size(list); i++) {
        const char *name = json_string_value(json_array_get(list, i));
        bool found = !name;
        for (size_t k = 0; k < sizeof known / sizeof *known; k++)
            found = found || strcmp(name, known[k]) == 0;
        if (!found)
            return ffp_fail(
                err, FFP_ERROR_UNSUPPORTED, gltf->path,
                "requires the extension %.60s, which is not supported: export it without, or as PLY", name);
    }
    return true;
}

// Splats in an SPZ file, which a view of a buffer holds; what the accessors say of them is not looked at.
static bool open_packed(const Gltf *gltf, const json_t *packed, Splats *splats, FfpError *err) {
    Buffer bytes;
    if (!find_view(gltf, view_at(gltf, whole(packed, "bufferView", -1)), &bytes) || !bytes.bytes)
        return fail(gltf, err, PACKED ": its bufferView is not inside a buffer");
    splats->packed = ffp_spz_open(bytes.bytes, bytes.size, gltf->path, err);
    if (!splats->packed) return false;
    splats->count = ffp_spz_count(splats->packed);
    splats->harmonics = ffp_spz_has_harmonics(splats->packed);
    return true;
}

static bool find_splats(const Gltf *gltf, const json_t *primitive, Splats *splats, FfpError *err) {
    const json_t *how = json_object_get(json_object_get(primitive, "extensions"), FFP_SPLAT_EXTENSION);
    const char *space = json_string_value(json_object_get(how, "colorSpace"));
    const json_t *of = json_object_get(primitive, "attributes"),
                 *packed = json_object_get(json_object_get(how, "extensions"), PACKED);
    splats->linear = space && strncmp(space, "lin_", 4) == 0;
    splats->harmonics = json_object_get(of, FFP_SPLAT_EXTENSION ":SH_DEGREE_1_COEF_0") != NULL;
    if (!check_extension(gltf, how, err)) return false;
    if (packed) return open_packed(gltf, packed, splats, err);
    if (!find_numbers(gltf, of, "POSITION", 3, &splats->position, err) ||
        !find_numbers(gltf, of, FFP_SPLAT_EXTENSION ":ROTATION", 4, &splats->rotation, err) ||
        !find_numbers(gltf, of, FFP_SPLAT_EXTENSION ":SCALE", 3, &splats->scale, err) ||
        !find_numbers(gltf, of, FFP_SPLAT_EXTENSION ":OPACITY", 1, &splats->opacity, err) ||
        !find_numbers(gltf, of, FFP_SPLAT_EXTENSION ":SH_DEGREE_0_COEF_0", 3, &splats->colour, err))
        return false;
    const int64_t n = splats->count = splats->position.count;
    return (splats->rotation.count == n && splats->scale.count == n && splats->opacity.count == n &&
            splats->colour.count == n) ||
           fail(gltf, err, "its attributes have different counts");
}

static void get_row(const Splats *splats, int64_t i, float row[FFP_ROW_NUMBERS]) {
    if (splats->packed) {
        ffp_spz_row(splats->packed, i, row);
        return;
    }
    memset(row, 0, FFP_ROW_NUMBERS * sizeof *row);
    for (int k = 0; k < 3; k++) {
        row[FFP_ROW_POSITION + k] = (float)number_at(&splats->position, i, k);
        row[FFP_ROW_SCALE + k] = (float)log(number_at(&splats->scale, i, k)); // below 0: NaN
        row[FFP_ROW_AMBIENT + k] = (float)number_at(&splats->colour, i, k);
    }
    row[FFP_ROW_OPACITY] = (float)ffp_opacity_logit(number_at(&splats->opacity, i, 0));
    for (int k = 0; k < 4; k++) // x y z w in the file
        row[FFP_ROW_ROTATION + k] = (float)number_at(&splats->rotation, i, (k + 3) % 4);
}

// --- Where the nodes put them. ---

typedef struct Placed {
    Splats splats;
    FfpAffine to_world;
    bool moved; // it is not the identity
} Placed;

typedef struct Scene {
    Placed *placed;
    int count;
    int64_t splats;
    int others; // primitives that are not splats
} Scene;

static const json_t *extension_of(const json_t *primitive) {
    return json_object_get(json_object_get(primitive, "extensions"), FFP_SPLAT_EXTENSION);
}

// `parents` of the nodes; -1: none.
static bool find_parents(const Gltf *gltf, const json_t *nodes, int *parents, FfpError *err) {
    const size_t n = json_array_size(nodes);
    for (size_t i = 0; i < n; i++) parents[i] = -1;
    for (size_t i = 0; i < n; i++) {
        const json_t *children = json_object_get(json_array_get(nodes, i), "children");
        for (size_t c = 0; c < json_array_size(children); c++) {
            const json_t *child = json_array_get(children, c);
            const json_int_t at = json_is_integer(child) ? json_integer_value(child) : -1;
            if (at < 0 || (size_t)at >= n || parents[at] >= 0) {
                ffp_fail(err, FFP_ERROR_FILE, gltf->path, "nodes[%zu]: invalid children", i);
                return false;
            }
            parents[at] = (int)i;
        }
    }
    return true;
}

static bool get_list(const json_t *node, const char *key, int n, double *out) {
    const json_t *list = json_object_get(node, key);
    if (!list) return false;
    for (int i = 0; i < n; i++) out[i] = json_number_value(json_array_get(list, (size_t)i));
    return json_array_size(list) == (size_t)n;
}

// The node's own transform; `moved` becomes true if it has one.
static FfpAffine transform_of(const json_t *node, bool *moved) {
    FfpAffine own = {{1, 0, 0, 0, 1, 0, 0, 0, 1}, {0}};
    double matrix[16], turn[4] = {0, 0, 0, 1}, size[3] = {1, 1, 1};
    if (get_list(node, "matrix", 16, matrix)) { // by columns
        *moved = true;
        for (int i = 0; i < 9; i++) own.a[i] = matrix[4 * (i % 3) + i / 3];
        for (int i = 0; i < 3; i++) own.t[i] = matrix[12 + i];
        return own;
    }
    const bool turned = get_list(node, "rotation", 4, turn), sized = get_list(node, "scale", 3, size);
    *moved |= get_list(node, "translation", 3, own.t) || turned || sized;
    const double xyzw[4] = {turn[3], turn[0], turn[1], turn[2]};
    if (turned) ffp_affine_rotation(xyzw, own.a);
    for (int i = 0; i < 9; i++) own.a[i] *= size[i % 3];
    return own;
}

// Applies the node's transform and those of all above it, of which the topmost becomes `root`. Error: they go
// around in a circle.
static bool place(const Gltf *gltf, const json_t *nodes, const int *parents, size_t node, Placed *placed,
                  int *root, FfpError *err) {
    placed->moved = false;
    placed->to_world = transform_of(json_array_get(nodes, node), &placed->moved);
    int depth = 0;
    for (int at = parents[node]; at >= 0; at = parents[at]) {
        const FfpAffine above = transform_of(json_array_get(nodes, (size_t)at), &placed->moved);
        placed->to_world = ffp_affine_product(&above, &placed->to_world);
        *root = at;
        if (++depth == DEPTH_MAX) {
            ffp_fail(err, FFP_ERROR_FILE, gltf->path, "nodes[%zu] has %d others above it", node, depth);
            return false;
        }
    }
    return true;
}

static bool lists(const json_t *numbers, int number) {
    bool found = false;
    for (size_t i = 0; i < json_array_size(numbers); i++)
        found |= json_integer_value(json_array_get(numbers, i)) == number;
    return found;
}

// The splats of a mesh, placed as `where` says.
static bool add_mesh(const Gltf *gltf, Scene *scene, json_int_t mesh, const Placed *where, FfpError *err) {
    const json_t *list =
        json_object_get(json_array_get(json_object_get(gltf->root, "meshes"), (size_t)mesh), "primitives");
    for (size_t p = 0; p < json_array_size(list); p++) {
        const json_t *primitive = json_array_get(list, p);
        if (!extension_of(primitive)) {
            if (scene->others < INT_MAX) scene->others++;
            continue;
        }
        if (scene->count == SETS_MAX) return fail(gltf, err, "holds too many sets of splats");
        scene->placed = ffp_grow(scene->placed, (size_t)scene->count + 1, sizeof *scene->placed);
        Placed *placed = &scene->placed[scene->count++];
        *placed = *where;
        if (!find_splats(gltf, primitive, &placed->splats, err)) return false;
        scene->splats += placed->splats.count;
        if (scene->splats > FFP_GAUSSIANS_MAX) return fail(gltf, err, "holds too many splats");
    }
    return true;
}

// Every mesh as often as nodes of `roots` and below show it (NULL: all nodes), and, for all nodes, once where
// none does.
static bool add_meshes(const Gltf *gltf, Scene *scene, const int *parents, const json_t *roots,
                       FfpError *err) {
    const json_t *nodes = json_object_get(gltf->root, "nodes"),
                 *meshes = json_object_get(gltf->root, "meshes");
    for (size_t m = 0; m < json_array_size(meshes); m++) {
        bool shown = roots != NULL;
        for (size_t i = 0; i < json_array_size(nodes); i++) {
            const json_t *mesh = json_object_get(json_array_get(nodes, i), "mesh");
            Placed placed = {0};
            int root = (int)i;
            if (!json_is_integer(mesh) || json_integer_value(mesh) != (json_int_t)m) continue;
            if (!place(gltf, nodes, parents, i, &placed, &root, err)) return false;
            if (roots && !lists(roots, root)) continue;
            shown = true;
            if (!add_mesh(gltf, scene, (json_int_t)m, &placed, err)) return false;
        }
        if (!shown && !add_mesh(gltf, scene, (json_int_t)m, &(Placed){0}, err)) return false;
    }
    return true;
}

// The splats of the scene that the file shows, its first unless it says so; of all nodes where that has none.
static bool find_scene(const Gltf *gltf, Scene *scene, int *parents, FfpError *err) {
    const int64_t first = whole(gltf->root, "scene", 0);
    const json_t *shown =
                     json_array_get(json_object_get(gltf->root, "scenes"), first < 0 ? 0 : (size_t)first),
                 *roots = json_object_get(shown, "nodes");
    if (!find_parents(gltf, json_object_get(gltf->root, "nodes"), parents, err)) return false;
    if (roots && !add_meshes(gltf, scene, parents, roots, err)) return false;
    if (scene->count == 0) scene->others = 0;
    if (scene->count == 0 && !add_meshes(gltf, scene, parents, NULL, err)) return false;
    return scene->count > 0 || fail(gltf, err, "holds no splats (" FFP_SPLAT_EXTENSION ")");
}

static bool read_splats(FfpGaussians *gaussians, const Gltf *gltf, FfpError *err) {
    Scene scene = {0};
    FfpSplatSet set;
    int *parents = ffp_alloc(json_array_size(json_object_get(gltf->root, "nodes")), sizeof *parents);
    bool ok = find_scene(gltf, &scene, parents, err);
    if (ok) ffp_splats_begin(&set, gaussians, scene.splats, gltf->path);
    for (int p = 0; ok && p < scene.count; p++) {
        const Placed *placed = &scene.placed[p];
        set.linear = placed->splats.linear;
        set.harmonics |= placed->splats.harmonics;
        for (int64_t i = 0; i < placed->splats.count; i++) {
            float row[FFP_ROW_NUMBERS];
            get_row(&placed->splats, i, row);
            if (placed->moved) ffp_affine_move(&placed->to_world, row);
            ffp_splats_add(&set, row);
        }
    }
    ok = ok && ffp_splats_end(&set, true, err);
    if (ok && scene.others > 0)
        ffp_note("%s: what is not splats is left out: %d primitives of its meshes", ffp_basename(gltf->path),
                 scene.others);
    for (int p = 0; p < scene.count; p++) ffp_spz_close(scene.placed[p].splats.packed);
    ffp_free(scene.placed);
    ffp_free(parents);
    return ok;
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
                    check_required(&gltf, err) && open_buffers(&gltf, err) &&
                    read_splats(gaussians, &gltf, err);
    for (int i = 0; i < gltf.n_buffers; i++) ffp_free(gltf.buffers[i].own);
    if (gltf.root) {
        ffp_disown(gltf.root);
        json_decref(gltf.root);
    }
    ffp_free(data);
    return ok;
}
