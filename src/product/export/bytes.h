// Little-endian numbers into bytes, whatever the machine is.
#ifndef FFP_EXPORT_BYTES_H
#define FFP_EXPORT_BYTES_H

#include <stdint.h>
#include <string.h>

static inline void ffp_put_u32(unsigned char *bytes, uint32_t value) {
    for (int i = 0; i < 4; i++) bytes[i] = (unsigned char)(value >> (8 * i));
}

static inline void ffp_put_float(unsigned char *bytes, float value) {
    uint32_t bits;
    memcpy(&bits, &value, 4);
    ffp_put_u32(bytes, bits);
}

#endif
