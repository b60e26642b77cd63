#include <stdint.h>
#include <string.h>
#include "core/base/alloc.h"
#include "product/view/view.h"

void ffp_bytes_append(FfpByteBuffer *packed, const void *bytes, size_t size) {
    if (size > packed->room - packed->size) {
        if (size > SIZE_MAX / 4 || packed->size > SIZE_MAX / 4) ffp_no_memory(size);
        packed->room = 2 * packed->room > packed->size + size ? 2 * packed->room : packed->size + size;
        packed->bytes = ffp_grow(packed->bytes, packed->room, 1);
    }
    if (bytes) memcpy(packed->bytes + packed->size, bytes, size);
    packed->size += size;
}
