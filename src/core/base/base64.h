// Bytes as text (RFC 4648), without line breaks.
#ifndef FFP_BASE_BASE64_H
#define FFP_BASE_BASE64_H

#include <stddef.h>
#include <stdio.h>

// The bytes of base64 text of this length, into `out` (room for 3 bytes for every 4 begun): their number, or
// -1 if it is not base64. Padding may be missing; nothing may follow it.
ptrdiff_t ffp_read_base64(unsigned char *out, const char *text, size_t length);
void ffp_write_base64(FILE *out, const unsigned char *bytes, size_t size);

#endif
