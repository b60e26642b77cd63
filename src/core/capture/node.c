#include "core/capture/node.h"
#include <math.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>
#include "core/base/call.h"
#include "core/base/file.h"

#define JSON_BYTES_MAX ((size_t)64 << 20)

static void release(void *value) {
    json_decref(value);
}

void ffp_json_own(json_t *value) {
    ffp_own(value, release);
}

void ffp_json_release(json_t *value) {
    ffp_disown(value);
    json_decref(value);
}

void ffp_node_close(FfpNode *root) {
    ffp_json_release(root->value);
    root->value = NULL;
}

bool ffp_node_open(FfpNode *root, const char *path, FfpError *err) {
    *root = (FfpNode){.file = path};
    char *text = NULL;
    size_t size = 0;
    if (!ffp_read_text(path, JSON_BYTES_MAX, &text, &size, err)) return false;
    json_error_t why;
    json_t *value = json_loadb(text, size, JSON_REJECT_DUPLICATES, &why);
    ffp_free(text);
    if (!value) {
        snprintf(root->place, sizeof root->place, "line %d", why.line);
        return ffp_node_fail(root, err, "broken JSON: %s", why.text);
    }
    if (json_is_object(value)) {
        root->value = value;
        ffp_json_own(value);
        return true;
    }
    json_decref(value);
    return ffp_fail(err, FFP_ERROR_FILE, path, "JSON is not an object");
}

bool ffp_node_fail(const FfpNode *field, FfpError *err, const char *format, ...) {
    char what[512], where[FFP_PATH_MAX + 256];
    va_list arguments;
    va_start(arguments, format);
    // NOLINTNEXTLINE(clang-analyzer-valist.Uninitialized): va_start stands above it
    vsnprintf(what, sizeof what, format, arguments);
    va_end(arguments);
    snprintf(where, sizeof where, "%s%s%s", field->file, field->place[0] != 0 ? ": " : "", field->place);
    return ffp_fail(err, FFP_ERROR_FILE, where, "%s", what);
}

static FfpNode child(const FfpNode *parent, const char *key, json_t *value) {
    FfpNode out = {.file = parent->file, .value = value};
    const char *dot = parent->place[0] != 0 ? "." : "";
    const int length = snprintf(out.place, sizeof out.place, "%s%s%s", parent->place, dot, key);
    if (length >= (int)sizeof out.place) memcpy(out.place + sizeof out.place - 4, "...", 4);
    return out;
}

bool ffp_node_find(const FfpNode *parent, const char *key, FfpNode *out) {
    json_t *value = json_object_get(parent->value, key);
    *out = child(parent, key, value);
    return value && !json_is_null(value);
}

bool ffp_node_get(const FfpNode *parent, const char *key, FfpNode *out, FfpError *err) {
    *out = child(parent, key, NULL);
    if (!json_is_object(parent->value)) return ffp_node_fail(parent, err, "must be an object");
    return ffp_node_find(parent, key, out) || ffp_node_fail(out, err, "missing field");
}

bool ffp_node_item(const FfpNode *array, int index, FfpNode *out, FfpError *err) {
    json_t *value = json_array_get(array->value, (size_t)index);
    *out = (FfpNode){.file = array->file, .value = value};
    const int length = snprintf(out->place, sizeof out->place, "%s[%d]", array->place, index);
    if (length >= (int)sizeof out->place) memcpy(out->place + sizeof out->place - 4, "...", 4);
    return value || ffp_node_fail(out, err, "missing item");
}

bool ffp_node_count(const FfpNode *array, int least, int most, int *count, FfpError *err) {
    if (!json_is_array(array->value)) return ffp_node_fail(array, err, "must be an array");
    const size_t n = json_array_size(array->value);
    if (n < (size_t)least || n > (size_t)most) {
        return ffp_node_fail(array, err, "has %zu entries; %d to %d are allowed", n, least, most);
    }
    *count = (int)n;
    return true;
}

bool ffp_node_number(const FfpNode *field, double low, double high, real *out, FfpError *err) {
    if (!json_is_number(field->value)) return ffp_node_fail(field, err, "must be a number");
    const double value = json_number_value(field->value);
    if (!(value >= low && value <= high))
        return ffp_node_fail(field, err, "%g is outside %g to %g", value, low, high);
    *out = (real)value;
    return true;
}

bool ffp_node_integer(const FfpNode *field, int low, int high, int *out, FfpError *err) {
    if (!json_is_number(field->value)) return ffp_node_fail(field, err, "must be a number");
    const double value = json_number_value(field->value);
    if (!(value >= low && value <= high) || value != floor(value)) {
        return ffp_node_fail(field, err, "%.10g is not a whole number from %d to %d", value, low, high);
    }
    *out = (int)value;
    return true;
}

bool ffp_node_numbers(const FfpNode *field, int n, double low, double high, real *out, FfpError *err) {
    int count = 0;
    if (!ffp_node_count(field, n, n, &count, err)) return false;
    for (int i = 0; i < n; i++) {
        FfpNode item;
        if (!ffp_node_item(field, i, &item, err) || !ffp_node_number(&item, low, high, &out[i], err))
            return false;
    }
    return true;
}

bool ffp_node_text(const FfpNode *field, const char **out, FfpError *err) {
    *out = "";
    if (!json_is_string(field->value)) return ffp_node_fail(field, err, "must be a string");
    *out = json_string_value(field->value);
    // jansson refuses \u0000 by default, so the text ends where C says it does.
    return **out != 0 || ffp_node_fail(field, err, "must not be empty");
}

bool ffp_is_utf8(const char *text) {
    json_t *copy = json_string(text);
    json_decref(copy);
    return copy != NULL;
}

bool ffp_is_name(const char *text) {
    const size_t length = strlen(text);
    if (length == 0 || length >= FFP_NAME_MAX || strcmp(text, ".") == 0 || strcmp(text, "..") == 0)
        return false;
    for (const char *c = text; *c != 0; c++) {
        if ((unsigned char)*c < 32 || *c == 127 || *c == '/' || *c == '\\') return false;
    }
    return ffp_is_utf8(text);
}

bool ffp_node_name(const FfpNode *field, char out[FFP_NAME_MAX], FfpError *err) {
    const char *text = NULL;
    if (!ffp_node_text(field, &text, err)) return false;
    if (!ffp_is_name(text)) {
        return ffp_node_fail(
            field, err,
            "invalid name '%.100s': expected 1 to %d bytes without '/', '\\' or control characters", text,
            FFP_NAME_MAX - 1);
    }
    memcpy(out, text, strlen(text) + 1);
    return true;
}

bool ffp_is_inner_path(const char *text) {
    if (text[0] == 0 || text[0] == '/' || strchr(text, '\\')) return false;
    for (const char *part = text; part != NULL; part = strchr(part, '/')) {
        if (*part == '/') part++;
        if (strncmp(part, "..", 2) == 0 && (part[2] == '/' || part[2] == 0)) return false;
    }
    return true;
}

bool ffp_node_file(const FfpNode *field, const char **out, FfpError *err) {
    if (!ffp_node_text(field, out, err)) return false;
    if (ffp_is_inner_path(*out)) return true;
    return ffp_node_fail(field, err, "file name '%.200s' leaves the capture's folder", *out);
}

bool ffp_get_number(const FfpNode *parent, const char *key, double low, double high, real *out,
                    FfpError *err) {
    FfpNode field;
    return ffp_node_get(parent, key, &field, err) && ffp_node_number(&field, low, high, out, err);
}

bool ffp_get_whole(const FfpNode *parent, const char *key, int low, int high, int *out, FfpError *err) {
    FfpNode field;
    return ffp_node_get(parent, key, &field, err) && ffp_node_integer(&field, low, high, out, err);
}
