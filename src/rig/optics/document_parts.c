// Common parts of the documents' formats.
#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include "core/base/error.h"
#include "rig/optics/document.h"

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
    return !memchr(text, 0, length) ? json_stringn(text, length) : NULL;
}
