#include <zstd.h>
#include "core/gaussians/elsewhere.h"

// zstd's memory is its own, and nothing here jumps while it has some.
bool ffp_unzstd(unsigned char *out, size_t size, const unsigned char *data, size_t data_size) {
    return ZSTD_decompress(out, size, data, data_size) == size;
}
