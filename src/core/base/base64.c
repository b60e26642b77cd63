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
