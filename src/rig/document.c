#include "rig/document.h"

#include <math.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>

#include "base/file.h"

bool ffp_document_fail(const char *path, size_t line, FfpError *err, const char *format, ...) {
    char what[512], place[40];
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(what, sizeof what, format, arguments);
    va_end(arguments);
    snprintf(place, sizeof place, "line %zu", line);
    return ffp_fail(err, FFP_ERROR_FILE, ffp_place(path, place).text, "%s", what);
}

json_t *ffp_document_scalar(const char *text, size_t length) {
    // strtod alone would also take hexadecimal numbers, "inf" and "nan".
    if (length > 0 && length < 64 && strspn(text, "0123456789+-.eE") >= length) {
        char number[64], *end = NULL;
        memcpy(number, text, length);
        number[length] = 0;
        const double value = strtod(number, &end);
        if (end == number + length && isfinite(value)) return json_real(value);
    }
    return memchr(text, 0, length) == NULL ? json_stringn(text, length) : NULL;
}

static json_t *parse_json(const char *text, size_t size, const char *path, FfpError *err) {
    json_error_t why;
    json_t *value = json_loadb(text, size, JSON_REJECT_DUPLICATES, &why);
    if (value == NULL) ffp_document_fail(path, (size_t)why.line, err, "broken JSON: %s", why.text);
    return value;
}

bool ffp_document_open(FfpField *root, const char *path, FfpError *err) {
    *root = (FfpField){.file = path};
    char *text = NULL;
    size_t size = 0;
    if (!ffp_read_text(path, FFP_DOCUMENT_BYTES_MAX, &text, &size, err)) return false;
    const char first = text[strspn(text, " \t\r\n")];
    if (first == '{' || first == '[')
        root->value = parse_json(text, size, path, err);
    else if (first == '<')
        root->value = ffp_xml_parse(text, size, path, err);
    else
        root->value = ffp_yaml_parse(text, size, path, err);
    ffp_free(text);
    if (root->value == NULL) return false;
    if (json_is_object(root->value) || json_is_array(root->value)) {
        ffp_json_own(root->value);
        return true;
    }
    json_decref(root->value);
    root->value = NULL;
    return ffp_fail(err, FFP_ERROR_FILE, path, "holds no keys: is it a calibration in JSON, YAML or XML?");
}
