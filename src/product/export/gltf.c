#include "product/export/gltf.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include "core/base/alloc.h"
#include "core/base/base64.h"
#include "core/base/file.h"
#include "core/base/text.h"
#include "core/capture/node.h"
#include "product/export/bytes.h"

#define GLB_MAGIC 0x46546c67U
#define CHUNK_JSON 0x4e4f534aU
#define CHUNK_BINARY 0x004e4942U
#define SIZE_MAX_GLB 0xffff0000ULL

FfpGltf ffp_gltf_new(void) {
    FfpGltf gltf = {.root = json_object()};
    ffp_json_own(gltf.root);
    json_object_set_new(gltf.root, "asset",
                        json_pack("{s:s, s:s}", "version", "2.0", "generator", "ffprocams " FFP_VERSION));
    return gltf;
}

void ffp_gltf_free(FfpGltf *gltf) {
    ffp_json_release(gltf->root);
    ffp_free(gltf->bytes);
    *gltf = (FfpGltf){0};
}

json_t *ffp_gltf_list(FfpGltf *gltf, const char *name) {
    json_t *list = json_object_get(gltf->root, name);
    if (list) return list;
    list = json_array();
    json_object_set_new(gltf->root, name, list);
    return list;
}

static int append(json_t *list, json_t *value) {
    json_array_append_new(list, value);
    return (int)json_array_size(list) - 1;
}

// Room for `size` bytes at a multiple of four; the new buffer view.
static int add_view(FfpGltf *gltf, size_t size, int target, unsigned char **at) {
    const size_t begin = (gltf->size + 3) / 4 * 4, end = begin + size;
    if (end > gltf->room) {
        gltf->room = 2 * end + 1024;
        gltf->bytes = ffp_grow(gltf->bytes, gltf->room, 1);
    }
    memset(gltf->bytes + gltf->size, 0, begin - gltf->size);
    gltf->size = end;
    *at = gltf->bytes + begin;
    json_t *view = json_pack("{s:i, s:I, s:I}", "buffer", 0, "byteOffset", (json_int_t)begin, "byteLength",
                             (json_int_t)size);
    if (target) json_object_set_new(view, "target", json_integer(target));
    return append(ffp_gltf_list(gltf, "bufferViews"), view);
}

static void add_bounds(json_t *accessor, const real *values, size_t count, int width) {
    json_t *least = json_array(), *most = json_array();
    for (int c = 0; c < width; c++) {
        float low = INFINITY, high = -INFINITY;
        for (size_t i = 0; i < count; i++) {
            const float value = (float)values[i * (size_t)width + (size_t)c];
            low = fminf(low, value);
            high = fmaxf(high, value);
        }
        json_array_append_new(least, json_real((double)low));
        json_array_append_new(most, json_real((double)high));
    }
    json_object_set_new(accessor, "min", least);
    json_object_set_new(accessor, "max", most);
}

int ffp_gltf_floats(FfpGltf *gltf, const real *values, size_t count, int width, bool bounds) {
    static const char *const types[5] = {NULL, "SCALAR", "VEC2", "VEC3", "VEC4"};
    const size_t numbers = count * (size_t)width;
    unsigned char *at;
    const int view = add_view(gltf, 4 * numbers, FFP_GLTF_ARRAY, &at);
    for (size_t i = 0; i < numbers; i++) ffp_put_float(at + 4 * i, (float)values[i]);
    json_t *accessor = json_pack("{s:i, s:i, s:I, s:s}", "bufferView", view, "componentType", 5126, "count",
                                 (json_int_t)count, "type", types[width]);
    if (bounds) add_bounds(accessor, values, count, width);
    return append(ffp_gltf_list(gltf, "accessors"), accessor);
}

int ffp_gltf_indices(FfpGltf *gltf, const uint32_t *values, size_t count) {
    unsigned char *at;
    const int view = add_view(gltf, 4 * count, FFP_GLTF_INDICES, &at);
    for (size_t i = 0; i < count; i++) ffp_put_u32(at + 4 * i, values[i]);
    return append(ffp_gltf_list(gltf, "accessors"),
                  json_pack("{s:i, s:i, s:I, s:s}", "bufferView", view, "componentType", 5125, "count",
                            (json_int_t)count, "type", "SCALAR"));
}

int ffp_gltf_texture(FfpGltf *gltf, const unsigned char *png, size_t size) {
    unsigned char *at;
    const int view = add_view(gltf, size, 0, &at);
    memcpy(at, png, size);
    json_t *samplers = ffp_gltf_list(gltf, "samplers");
    if (json_array_size(samplers) == 0)
        append(samplers, json_pack("{s:i, s:i, s:i, s:i}", "magFilter", 9729, "minFilter", 9729, "wrapS",
                                   33071, "wrapT", 33071));
    const int image = append(ffp_gltf_list(gltf, "images"),
                             json_pack("{s:i, s:s}", "bufferView", view, "mimeType", "image/png"));
    return append(ffp_gltf_list(gltf, "textures"), json_pack("{s:i, s:i}", "source", image, "sampler", 0));
}

// --- The file. ---

static bool write_json(const FfpGltf *gltf, const char *path, FfpError *err) {
    char *text = json_dumps(gltf->root, JSON_COMPACT | JSON_REAL_PRECISION(9));
    if (!text) return ffp_fail(err, FFP_ERROR_IO, path, "cannot write the JSON");
    const bool ok = ffp_write_file(path, text, strlen(text), err);
    free(text);
    return ok;
}

static bool put_chunk(FILE *stream, const void *data, size_t size, uint32_t kind, char fill) {
    const size_t padded = (size + 3) / 4 * 4;
    const char rest[4] = {fill, fill, fill, fill};
    unsigned char head[8];
    ffp_put_u32(head, (uint32_t)padded);
    ffp_put_u32(head + 4, kind);
    return fwrite(head, sizeof head, 1, stream) == 1 && fwrite(data, 1, size, stream) == size &&
           fwrite(rest, 1, padded - size, stream) == padded - size;
}

static bool write_binary(const FfpGltf *gltf, const char *path, FfpError *err) {
    FfpOutput out;
    if (!ffp_output_open(&out, path, err)) return false;
    char *text = json_dumps(gltf->root, JSON_COMPACT | JSON_REAL_PRECISION(9));
    const size_t length = text ? strlen(text) : 0;
    unsigned char head[12];
    ffp_put_u32(head, GLB_MAGIC);
    ffp_put_u32(head + 4, 2);
    ffp_put_u32(head + 8, (uint32_t)(12 + 8 + (length + 3) / 4 * 4 + 8 + (gltf->size + 3) / 4 * 4));
    const bool ok = text && fwrite(head, sizeof head, 1, out.stream) == 1 &&
                    put_chunk(out.stream, text, length, CHUNK_JSON, ' ') &&
                    put_chunk(out.stream, gltf->bytes, gltf->size, CHUNK_BINARY, 0);
    free(text);
    if (ok) return ffp_output_commit(&out, err);
    ffp_output_abort(&out);
    return ffp_fail(err, FFP_ERROR_IO, path, "cannot write");
}

bool ffp_gltf_write(FfpGltf *gltf, json_t *primitive, const char *path, bool binary, FfpError *err) {
    json_t *buffer = json_pack("{s:I}", "byteLength", (json_int_t)gltf->size);
    append(ffp_gltf_list(gltf, "buffers"), buffer);
    append(ffp_gltf_list(gltf, "meshes"), json_pack("{s:[o]}", "primitives", primitive));
    append(ffp_gltf_list(gltf, "nodes"), json_pack("{s:i}", "mesh", 0));
    append(ffp_gltf_list(gltf, "scenes"), json_pack("{s:[i]}", "nodes", 0));
    json_object_set_new(gltf->root, "scene", json_integer(0));
    if (gltf->size > SIZE_MAX_GLB)
        return ffp_fail(err, FFP_ERROR_UNSUPPORTED, path, "%.1f GB exceed what a glTF file can hold",
                        (double)gltf->size / 1e9);
    if (binary) return write_binary(gltf, path, err);
    FfpText *uri = ffp_text_new();
    fputs("data:application/octet-stream;base64,", ffp_text_stream(uri));
    ffp_write_base64(ffp_text_stream(uri), gltf->bytes, gltf->size);
    json_object_set_new(buffer, "uri", json_string(ffp_text_so_far(uri, NULL)));
    ffp_text_free(uri);
    return write_json(gltf, path, err);
}
