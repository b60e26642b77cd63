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
    return ffp_fail(err, ffp_place(path, place).text, "%s", what);
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
    if (!ffp_read_file(path, FFP_DOCUMENT_BYTES_MAX, &text, &size, err)) return false;
    const char *bom = "\xEF\xBB\xBF";
    const size_t skipped = strncmp(text, bom, 3) == 0 ? 3 : 0;
    char *body = text + skipped;
    const char first = body[strspn(body, " \t\r\n")];
    if (first == '{' || first == '[')
        root->value = parse_json(body, size - skipped, path, err);
    else if (first == '<')
        root->value = ffp_xml_parse(body, size - skipped, path, err);
    else
        root->value = ffp_yaml_parse(body, size - skipped, path, err);
    free(text);
    if (root->value == NULL) return false;
    if (json_is_object(root->value) || json_is_array(root->value)) return true;
    json_decref(root->value);
    root->value = NULL;
    return ffp_fail(err, path, "holds no keys: is it a calibration in JSON, YAML or XML?");
}
