#include "core/base/kind.h"
#include <stdio.h>
#include <string.h>
#include <strings.h>
#include "core/base/file.h"
#include "core/base/memory_file.h"

enum { HEAD = 256 };

static bool begins(const unsigned char *head, size_t size, const char *magic, size_t length) {
    return size >= length && memcmp(head, magic, length) == 0;
}

static bool is_json(const unsigned char *head, size_t size) {
    size_t at = begins(head, size, "\xef\xbb\xbf", 3) ? 3 : 0; // a byte order mark
    while (at < size && head[at] != 0 && strchr(" \t\r\n", head[at])) at++;
    return at < size && head[at] == '{';
}

static bool is_image(const unsigned char *head, size_t size) {
    return begins(head, size, "\x89PNG", 4) || begins(head, size, "\xff\xd8\xff", 3) ||
           begins(head, size, "\x76\x2f\x31\x01", 4) || begins(head, size, "II*\0", 4) ||
           begins(head, size, "MM\0*", 4);
}

static bool holds(const unsigned char *head, size_t size, const char *mark) {
    const size_t length = strlen(mark);
    for (size_t i = 0; i + length <= size; i++)
        if (memcmp(head + i, mark, length) == 0) return true;
    return false;
}

// Safetensors whose metadata, which come first, say so (lab/baselines/file.c).
static bool is_field(const unsigned char *head, size_t size) {
    return holds(head, size, "\"ffprocams neural field 1\"");
}

// A .splat has no mark, and its first number may begin like JSON, which is text.
static bool is_text(const unsigned char *head, size_t size) {
    for (size_t i = 0; i < size; i++)
        if (head[i] == 0 || (head[i] < ' ' && !strchr("\t\r\n", head[i]))) return false;
    return true;
}

static bool ends_with(const char *path, const char *ending) {
    const size_t length = strlen(path), end = strlen(ending);
    return length >= end && strcasecmp(path + length - end, ending) == 0;
}

// Splats of other programs that are JSON files with data beside them: LCC, SOG that is not zipped.
static bool is_foreign_json(const unsigned char *head, size_t size, const char *path) {
    return ends_with(path, ".lcc") || (ends_with(path, "meta.json") && holds(head, size, "\"means\""));
}

FfpKind ffp_file_kind(const char *path) {
    unsigned char head[HEAD];
    if (!ffp_memory_file(path) && ffp_is_folder(path)) return FFP_KIND_FOLDER;
    FILE *stream = ffp_open_to_read(path, NULL);
    if (!stream) return FFP_KIND_UNKNOWN;
    const size_t size = fread(head, 1, sizeof head, stream);
    fclose(stream);
    const bool bare = ends_with(path, ".splat") && !is_text(head, size);
    if (!bare && size > 8 && head[7] == 0 && head[8] == '{') // the header's length before it
        return is_field(head, size) ? FFP_KIND_FIELD : FFP_KIND_WEIGHTS;
    if (begins(head, size, "ply", 3) && size > 3 && head[3] != 0 && strchr(" \t\r\n", head[3]))
        return FFP_KIND_PLY;
    if (begins(head, size, "\x1f\x8b\x08", 3) || begins(head, size, "NGSP", 4)) return FFP_KIND_SPZ;
    if (begins(head, size, "glTF", 4) || (is_json(head, size) && ends_with(path, ".gltf")))
        return FFP_KIND_GLTF;
    if (is_image(head, size)) return FFP_KIND_IMAGE;
    if (!bare && is_json(head, size))
        return is_foreign_json(head, size, path) ? FFP_KIND_UNKNOWN : FFP_KIND_JSON;
    return ends_with(path, ".splat") ? FFP_KIND_SPLAT : FFP_KIND_UNKNOWN;
}

bool ffp_check_kind(const char *path, FfpExpectedKind wanted, FfpError *err) {
    static const char *const found[] = {
        [FFP_KIND_FOLDER] = "a folder, as captures are",
        [FFP_KIND_JSON] = "JSON, as in captures",
        [FFP_KIND_PLY] = "Gaussians (a PLY)",
        [FFP_KIND_SPZ] = "gzipped or SPZ, as splats are",
        [FFP_KIND_GLTF] = "glTF",
        [FFP_KIND_SPLAT] = "splats (.splat)",
        [FFP_KIND_WEIGHTS] = "weights (safetensors)",
        [FFP_KIND_FIELD] = "a neural field, which only `info` and `evaluate` read",
        [FFP_KIND_IMAGE] = "a picture",
    };
    static const char *const wants[] = {
        [FFP_WANTED_CAPTURE] = "a capture: expected its folder or its JSON file",
        [FFP_WANTED_GAUSSIANS] = "Gaussians: expected a PLY, an SPZ, a .splat or glTF with splats",
        [FFP_WANTED_WEIGHTS] = "weights: expected a safetensors file",
        [FFP_WANTED_FIELD] = "a neural field",
        [FFP_WANTED_TENSORS] = "weights: expected a safetensors file",
        [FFP_WANTED_IMAGE] = "a picture",
    };
    const FfpKind kind = ffp_file_kind(path);
    const bool capture = kind == FFP_KIND_FOLDER || kind == FFP_KIND_JSON;
    if (kind == FFP_KIND_UNKNOWN || (wanted == FFP_WANTED_CAPTURE && capture) ||
        (wanted == FFP_WANTED_GAUSSIANS &&
         (kind == FFP_KIND_PLY || kind == FFP_KIND_SPZ || kind == FFP_KIND_GLTF || kind == FFP_KIND_SPLAT)) ||
        (wanted == FFP_WANTED_WEIGHTS && kind == FFP_KIND_WEIGHTS) ||
        ((wanted == FFP_WANTED_FIELD || wanted == FFP_WANTED_TENSORS) &&
         (kind == FFP_KIND_FIELD || kind == FFP_KIND_WEIGHTS)) || // whose reader says what else it is
        (wanted == FFP_WANTED_IMAGE && kind == FFP_KIND_IMAGE))
        return true;
    return ffp_fail(err, FFP_ERROR_FILE, path, "is %s, not %s", found[kind], wants[wanted]);
}
