// Bytes as text (RFC 4648), without line breaks.
#ifndef FFP_BASE_BASE64_H
#define FFP_BASE_BASE64_H

#include <stddef.h>
#include <stdio.h>

void ffp_write_base64(FILE *out, const unsigned char *bytes, size_t size);

#endif
