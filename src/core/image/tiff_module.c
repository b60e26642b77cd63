#include "core/image/tiff_module.h"

const FfpTiffModule ffp_tiff_module = {
    .version = FFP_TIFF_MODULE_VERSION,
    .options_new = TIFFOpenOptionsAlloc,
    .options_free = TIFFOpenOptionsFree,
    .on_error = TIFFOpenOptionsSetErrorHandlerExtR,
    .on_warning = TIFFOpenOptionsSetWarningHandlerExtR,
    .limit_memory = TIFFOpenOptionsSetMaxSingleMemAlloc,
    .open = TIFFClientOpenExt,
    .close = TIFFClose,
    .get = TIFFGetField,
    .get_or_default = TIFFGetFieldDefaulted,
    .set = TIFFSetField,
    .is_tiled = TIFFIsTiled,
    .tile_row_size = TIFFTileRowSize,
    .scanline_size = TIFFScanlineSize,
    .tile_at = TIFFComputeTile,
    .strip_at = TIFFComputeStrip,
    .read_tile = TIFFReadEncodedTile,
    .read_strip = TIFFReadEncodedStrip,
};
