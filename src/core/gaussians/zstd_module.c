#include "core/gaussians/zstd_module.h"
#include <zstd.h>

const FfpZstdModule ffp_zstd_module = {FFP_ZSTD_MODULE_VERSION, ZSTD_decompress};
