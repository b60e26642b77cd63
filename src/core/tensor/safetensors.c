#include "core/tensor/safetensors.h"
#include <jansson.h>
#include <math.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include "core/base/file.h"
#include "core/base/kind.h"

#define FILE_BYTES_MAX (SIZE_MAX >> (sizeof(size_t) == 8 ? 30 : 1)) // 16 GiB: `paper` while trained takes 3
#define HEADER_BYTES_MAX ((size_t)100 << 20)                        // the format's own limit
#define METADATA_KEY "__metadata__"

static const struct {
    const char *name;
    size_t size;
} dtypes[] = {
    [FFP_F32] = {"F32", 4}, [FFP_BF16] = {"BF16", 2}, [FFP_F16] = {"F16", 2},
    [FFP_F64] = {"F64", 8}, [FFP_I64] = {"I64", 8},   [FFP_U8] = {"U8", 1},
};
enum { DTYPES = sizeof dtypes / sizeof *dtypes };

static bool read_dtype(FfpTensor *tensor, const json_t *entry, const char *where, FfpError *err) {
    const char *name = json_string_value(json_object_get(entry, "dtype"));
    if (!name) return ffp_fail(err, FFP_ERROR_FILE, where, "a tensor without dtype");
    for (int i = 0; i < DTYPES; i++)
        if (strcmp(name, dtypes[i].name) == 0) {
            tensor->dtype = (FfpDtype)i;
            return true;
        }
    return ffp_fail(err, FFP_ERROR_UNSUPPORTED, where, "dtype %.16s is not supported", name);
}

static bool read_shape(FfpTensor *tensor, const json_t *entry, const char *where, FfpError *err) {
    const json_t *shape = json_object_get(entry, "shape");
    if (!json_is_array(shape) || json_array_size(shape) > 8)
        return ffp_fail(err, FFP_ERROR_FILE, where, "shape must be a list of at most 8 sizes");
    tensor->rank = (int)json_array_size(shape);
    tensor->count = 1;
    for (int i = 0; i < tensor->rank; i++) {
        const json_t *side = json_array_get(shape, (size_t)i);
        const int64_t n = json_integer_value(side);
        if (!json_is_integer(side) || n < 0)
            return ffp_fail(err, FFP_ERROR_FILE, where, "invalid size in shape");
        if (n > 0 && tensor->count > INT64_MAX / 8 / n)
            return ffp_fail(err, FFP_ERROR_FILE, where, "shape overflows");
        tensor->shape[i] = n;
        tensor->count *= n;
    }
    return true;
}

static bool read_offsets(FfpTensor *tensor, const json_t *entry, const char *data, size_t data_size,
                         const char *where, FfpError *err) {
    const json_t *offsets = json_object_get(entry, "data_offsets");
    const json_t *first = json_array_get(offsets, 0), *last = json_array_get(offsets, 1);
    if (json_array_size(offsets) != 2 || !json_is_integer(first) || !json_is_integer(last))
        return ffp_fail(err, FFP_ERROR_FILE, where, "data_offsets must be two integers");
    const int64_t begin = json_integer_value(first), end = json_integer_value(last);
    if (begin < 0 || end < begin || (uint64_t)end > data_size)
        return ffp_fail(err, FFP_ERROR_FILE, where,
                        "data_offsets [%lld, %lld] lie outside the file's %zu bytes of data",
                        (long long)begin, (long long)end, data_size);
    if ((uint64_t)(end - begin) != (uint64_t)tensor->count * dtypes[tensor->dtype].size)
        return ffp_fail(
            err, FFP_ERROR_FILE, where, "shape and dtype ask for %llu bytes, data_offsets give %lld",
            (unsigned long long)tensor->count * dtypes[tensor->dtype].size, (long long)(end - begin));
    tensor->data = data + begin;
    return true;
}

static char *copy_of(const char *text) {
    const size_t size = strlen(text) + 1;
    char *copy = ffp_try_alloc(size, 1);
    return copy ? memcpy(copy, text, size) : NULL;
}

static bool read_metadata(FfpSafetensors *file, const json_t *object, const char *path, FfpError *err) {
    if (!json_is_object(object))
        return ffp_fail(err, FFP_ERROR_FILE, path, "%s is not an object", METADATA_KEY);
    file->metadata = ffp_try_alloc(2 * json_object_size(object) + 1, sizeof *file->metadata);
    if (!file->metadata) return ffp_fail(err, FFP_ERROR_MEMORY, path, "out of memory");
    const char *key;
    json_t *value;
    json_object_foreach((json_t *)object, key, value) {
        if (!json_is_string(value))
            return ffp_fail(err, FFP_ERROR_FILE, ffp_place(path, key).text,
                            "a metadata value is not a string");
        char *k = copy_of(key), *v = copy_of(json_string_value(value));
        file->metadata[2 * file->metadata_count] = k;
        file->metadata[2 * file->metadata_count++ + 1] = v;
        if (!k || !v) return ffp_fail(err, FFP_ERROR_MEMORY, path, "out of memory");
    }
    return true;
}

static int compare_begin(const void *a, const void *b) {
    const FfpTensor *x = *(const FfpTensor *const *)a, *y = *(const FfpTensor *const *)b;
    if (x->data != y->data) return (const char *)x->data < (const char *)y->data ? -1 : 1;
    return (x->count > y->count) - (x->count < y->count); // empty tensors before the one that starts there
}

// The format wants the data covered exactly once: no overlap, no gap, nothing after the last tensor.
static bool check_cover(const FfpSafetensors *file, const char *data, size_t data_size, const char *path,
                        FfpError *err) {
    const FfpTensor **order = ffp_try_alloc((size_t)file->count + 1, sizeof(const FfpTensor *));
    if (!order) return ffp_fail(err, FFP_ERROR_MEMORY, path, "out of memory");
    for (int i = 0; i < file->count; i++) order[i] = &file->tensors[i];
    qsort(order, (size_t)file->count, sizeof(const FfpTensor *), compare_begin);
    const char *end = data;
    bool ok = true;
    for (int i = 0; i < file->count && ok; i++) {
        const char *begin = order[i]->data;
        if (begin != end)
            ok = ffp_fail(err, FFP_ERROR_FILE, ffp_place(path, order[i]->name).text,
                          begin < end ? "its data overlap another tensor's" : "a gap lies before its data");
        end = begin + (size_t)order[i]->count * dtypes[order[i]->dtype].size;
    }
    if (ok && end != data + data_size) ok = ffp_fail(err, FFP_ERROR_FILE, path, "data after the last tensor");
    ffp_free(order);
    return ok;
}

static bool read_entries(FfpSafetensors *file, json_t *header, const char *data, size_t data_size,
                         const char *path, FfpError *err) {
    file->tensors = ffp_try_alloc(json_object_size(header) + 1, sizeof *file->tensors);
    if (!file->tensors) return ffp_fail(err, FFP_ERROR_MEMORY, path, "out of memory");
    const char *name;
    json_t *entry;
    json_object_foreach(header, name, entry) {
        if (strcmp(name, METADATA_KEY) == 0) {
            if (!read_metadata(file, entry, path, err)) return false;
            continue;
        }
        const FfpPlace where = ffp_place(path, name);
        FfpTensor *tensor = &file->tensors[file->count];
        if (!*name || strlen(name) >= FFP_TENSOR_NAME_MAX)
            return ffp_fail(err, FFP_ERROR_FILE, where.text, "a tensor's name must have 1 to %d bytes",
                            FFP_TENSOR_NAME_MAX - 1);
        snprintf(tensor->name, sizeof tensor->name, "%s", name);
        if (!json_is_object(entry))
            return ffp_fail(err, FFP_ERROR_FILE, where.text, "a tensor's entry is not an object");
        if (!read_dtype(tensor, entry, where.text, err) || !read_shape(tensor, entry, where.text, err) ||
            !read_offsets(tensor, entry, data, data_size, where.text, err))
            return false;
        file->count++;
    }
    return check_cover(file, data, data_size, path, err);
}

static bool parse(FfpSafetensors *file, size_t size, const char *path, FfpError *err) {
    if (size < 8) return ffp_fail(err, FFP_ERROR_FILE, path, "not a safetensors file: shorter than 8 bytes");
    uint64_t header_size = 0;
    for (int i = 7; i >= 0; i--) header_size = header_size << 8 | (unsigned char)file->bytes[i];
    if (header_size > HEADER_BYTES_MAX || header_size > size - 8)
        return ffp_fail(err, FFP_ERROR_FILE, path,
                        "not a safetensors file, or truncated: its header would have %llu bytes",
                        (unsigned long long)header_size);
    json_error_t at;
    json_t *header = json_loadb(file->bytes + 8, (size_t)header_size, JSON_REJECT_DUPLICATES, &at);
    if (!header)
        return ffp_fail(err, FFP_ERROR_FILE, path, "broken header: %s at byte %d", at.text, at.position);
    const size_t data_size = size - 8 - (size_t)header_size;
    const bool ok = json_is_object(header)
                        ? read_entries(file, header, file->bytes + 8 + header_size, data_size, path, err)
                        : ffp_fail(err, FFP_ERROR_FILE, path, "the header is not an object");
    json_decref(header);
    return ok;
}

bool ffp_safetensors_read(FfpSafetensors *file, const char *path, FfpError *err) {
    *file = (FfpSafetensors){0};
    size_t size;
    if (!ffp_check_kind(path, FFP_WANTED_TENSORS, err)) return false;
    if (!ffp_read_file(path, FILE_BYTES_MAX, &file->bytes, &size, err)) {
        file->bytes = NULL;
        return false;
    }
    if (parse(file, size, path, err)) return true;
    ffp_safetensors_free(file);
    return false;
}

void ffp_safetensors_free(FfpSafetensors *file) {
    for (int i = 0; i < 2 * file->metadata_count; i++) ffp_free(file->metadata[i]);
    ffp_free(file->metadata);
    ffp_free(file->tensors);
    ffp_free(file->bytes);
    *file = (FfpSafetensors){0};
}

const FfpTensor *ffp_safetensors_find(const FfpSafetensors *file, const char *name) {
    for (int i = 0; i < file->count; i++)
        if (strcmp(file->tensors[i].name, name) == 0) return &file->tensors[i];
    return NULL;
}

const char *ffp_safetensors_metadata(const FfpSafetensors *file, const char *key) {
    for (int i = 0; i < file->metadata_count; i++)
        if (strcmp(file->metadata[2 * i], key) == 0) return file->metadata[2 * i + 1];
    return NULL;
}

uint16_t ffp_bf16_from_float(float value) {
    uint32_t bits;
    memcpy(&bits, &value, sizeof bits);
    if ((bits & 0x7fffffffU) > 0x7f800000U) return (uint16_t)(bits >> 16 | 0x40U); // NaN, made quiet
    return (uint16_t)((bits + 0x7fffU + (bits >> 16 & 1U)) >> 16);
}

float ffp_bf16_to_float(uint16_t value) {
    const uint32_t bits = (uint32_t)value << 16;
    float out;
    memcpy(&out, &bits, sizeof out);
    return out;
}

// IEEE 754 binary16.
static float half_to_float(uint16_t bits) {
    const int exponent = bits >> 10 & 31, mantissa = bits & 1023;
    float value;
    if (exponent == 31)
        value = mantissa ? NAN : INFINITY;
    else if (exponent == 0)
        value = ldexpf((float)mantissa, -24);
    else
        value = ldexpf((float)(mantissa + 1024), exponent - 25);
    return bits & 0x8000 ? -value : value;
}

bool ffp_tensor_to_real(const FfpTensor *tensor, real *out) {
    if (tensor->dtype == FFP_I64 || tensor->dtype == FFP_U8) return false;
    const char *data = tensor->data; // memcpy, since nothing aligns a tensor inside the file
    for (int64_t i = 0; i < tensor->count; i++) {
        uint16_t bits;
        float single;
        double twice;
        switch (tensor->dtype) {
        case FFP_F32:
            memcpy(&single, data + 4 * i, sizeof single);
            out[i] = (real)single;
            break;
        case FFP_F64:
            memcpy(&twice, data + 8 * i, sizeof twice);
            out[i] = (real)twice;
            break;
        default:
            memcpy(&bits, data + 2 * i, sizeof bits);
            out[i] = (real)(tensor->dtype == FFP_BF16 ? ffp_bf16_to_float(bits) : half_to_float(bits));
        }
    }
    return true;
}

// {"__metadata__": {...}, name: {"dtype", "shape", "data_offsets"}, ...} as text, or NULL with an error.
static char *print_header(const FfpTensor *tensors, int count, const char *const *metadata,
                          int metadata_count, const char *path, FfpError *err) {
    json_t *header = json_object(), *strings = json_object();
    bool ok = header && strings ? true : ffp_fail(err, FFP_ERROR_MEMORY, path, "out of memory");
    for (int i = 0; ok && i < 2 * metadata_count; i += 2)
        if (json_object_set_new(strings, metadata[i], json_string(metadata[i + 1])) != 0)
            ok = ffp_fail(err, FFP_ERROR_FILE, ffp_place(path, metadata[i]).text,
                          "metadata that is not UTF-8");
    if (ok) json_object_set(header, METADATA_KEY, strings);
    json_decref(strings);
    int64_t begin = 0;
    for (int i = 0; ok && i < count; i++) {
        const FfpTensor *t = &tensors[i];
        const int64_t end = begin + t->count * (int64_t)dtypes[t->dtype].size;
        json_t *shape = json_array();
        for (int k = 0; k < t->rank; k++) json_array_append_new(shape, json_integer(t->shape[k]));
        json_t *entry = json_pack("{s:s, s:o, s:[I,I]}", "dtype", dtypes[t->dtype].name, "shape", shape,
                                  "data_offsets", (json_int_t)begin, (json_int_t)end);
        if (json_object_get(header, t->name) || json_object_set(header, t->name, entry) != 0)
            ok = ffp_fail(err, FFP_ERROR_FILE, ffp_place(path, t->name).text,
                          "a tensor's name is duplicate or not UTF-8");
        json_decref(entry);
        begin = end;
    }
    char *text = ok ? json_dumps(header, JSON_COMPACT) : NULL;
    json_decref(header);
    if (ok && !text) ffp_fail(err, FFP_ERROR_MEMORY, path, "out of memory");
    return text;
}

bool ffp_safetensors_write(const char *path, const FfpTensor *tensors, int count, const char *const *metadata,
                           int metadata_count, FfpError *err) {
    char *header = print_header(tensors, count, metadata, metadata_count, path, err);
    if (!header) return false;
    FfpOutput out;
    if (!ffp_output_open(&out, path, err)) {
        free(header);
        return false;
    }
    const size_t length = strlen(header), padded = (length + 7) / 8 * 8; // data start on 8 bytes
    unsigned char prefix[8];
    for (int i = 0; i < 8; i++) prefix[i] = (unsigned char)((uint64_t)padded >> 8 * i);
    bool ok = fwrite(prefix, 1, 8, out.stream) == 8 &&
              fprintf(out.stream, "%-*s", (int)padded, header) == (int)padded;
    for (int i = 0; i < count && ok; i++) {
        const size_t bytes = (size_t)tensors[i].count * dtypes[tensors[i].dtype].size;
        ok = fwrite(tensors[i].data, 1, bytes, out.stream) == bytes;
    }
    free(header);
    if (ok) return ffp_output_commit(&out, err);
    ffp_output_abort(&out);
    return ffp_fail(err, FFP_ERROR_IO, path, "cannot be written");
}
