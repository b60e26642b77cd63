#include "core/base/error.h"
#include <stdarg.h>
#include <stdio.h>
#include <string.h>

// Names from files must not steer a terminal.
static void make_plain(char *text) {
    for (char *c = text; *c; c++)
        if ((unsigned char)*c < 32 || *c == 127) *c = '?';
}

bool ffp_fail(FfpError *err, FfpErrorCode code, const char *where, const char *what_format, ...) {
    if (!err) return false;
    // Assembled aside: `where` and the arguments may point into err->text when a caller adds to an older
    // message.
    char text[sizeof err->text], place[sizeof err->where] = "";
    va_list arguments;
    va_start(arguments, what_format);
    int length = vsnprintf(text, sizeof text, what_format, arguments);
    va_end(arguments);
    if (length < 0) {
        length = 0;
        text[0] = 0;
    }
    if (where) snprintf(place, sizeof place, "%s", where);
    make_plain(place);
    if (place[0] && (size_t)length < sizeof text - 1)
        snprintf(text + length, sizeof text - (size_t)length, " (%s)", place);
    make_plain(text);
    memcpy(err->text, text, sizeof text);
    memcpy(err->where, place, sizeof place);
    err->code = code;
    err->finding = NULL;
    return false;
}

bool ffp_check_choice(int value, int last, const char *name, FfpError *err) {
    return (value >= 0 && value <= last) ||
           ffp_fail(err, FFP_ERROR_ARGUMENT, name, "invalid value %d: expected 0 to %d", value, last);
}

FfpPlace ffp_place(const char *file, const char *field) {
    FfpPlace place;
    snprintf(place.text, sizeof place.text, "%.1023s: %.160s", file, field);
    return place;
}
