#include "core/base/base64.h"

void ffp_write_base64(FILE *out, const unsigned char *bytes, size_t size) {
    static const char digits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    char line[4 * 1024];
    size_t filled = 0;
    for (size_t i = 0; i < size; i += 3) {
        const size_t left = size - i;
        const unsigned a = bytes[i], b = left > 1 ? bytes[i + 1] : 0, c = left > 2 ? bytes[i + 2] : 0;
        line[filled++] = digits[a >> 2];
        line[filled++] = digits[(a & 3) << 4 | b >> 4];
        line[filled++] = left > 1 ? digits[(b & 15) << 2 | c >> 6] : '=';
        line[filled++] = left > 2 ? digits[c & 63] : '=';
        if (filled == sizeof line || left <= 3) {
            fwrite(line, 1, filled, out);
            filled = 0;
        }
    }
}

static int value_of(char digit) {
    if (digit >= 'A' && digit <= 'Z') return digit - 'A';
    if (digit >= 'a' && digit <= 'z') return digit - 'a' + 26;
    if (digit >= '0' && digit <= '9') return digit - '0' + 52;
    return digit == '+' ? 62 : digit == '/' ? 63 : -1;
}

ptrdiff_t ffp_read_base64(unsigned char *out, const char *text, size_t length) {
    unsigned bits = 0;
    ptrdiff_t size = 0;
    size_t digits = length;
    while (digits > 0 && length - digits < 2 && text[digits - 1] == '=') digits--;
    if (digits % 4 == 1 || (digits < length && length % 4 != 0)) return -1;
    for (size_t i = 0; i < digits; i++) {
        const int value = value_of(text[i]);
        if (value < 0) return -1;
        bits = bits << 6 | (unsigned)value;
        if (i % 4 > 0) out[size++] = (unsigned char)(bits >> (6 - 2 * (i % 4)));
    }
    return size;
}
