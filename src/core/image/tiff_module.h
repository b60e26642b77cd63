// libtiff's functions: a module (core/base/module.h), loaded by tiff.c. Debian's libtiff brings eight other
// libraries for compressions that are not read here.
#ifndef FFP_IMAGE_TIFF_MODULE_H
#define FFP_IMAGE_TIFF_MODULE_H

#include <tiffio.h>
#include "core/base/module.h"

enum { FFP_TIFF_MODULE_VERSION = 1 }; // of the table below

typedef struct FfpTiffModule {
    int version;
    __typeof__(TIFFOpenOptionsAlloc) *options_new;
    __typeof__(TIFFOpenOptionsFree) *options_free;
    __typeof__(TIFFOpenOptionsSetErrorHandlerExtR) *on_error;
    __typeof__(TIFFOpenOptionsSetWarningHandlerExtR) *on_warning;
    __typeof__(TIFFOpenOptionsSetMaxSingleMemAlloc) *limit_memory;
    __typeof__(TIFFClientOpenExt) *open;
    __typeof__(TIFFClose) *close;
    __typeof__(TIFFGetField) *get;
    __typeof__(TIFFGetFieldDefaulted) *get_or_default;
    __typeof__(TIFFSetField) *set;
    __typeof__(TIFFIsTiled) *is_tiled;
    __typeof__(TIFFTileRowSize) *tile_row_size;
    __typeof__(TIFFScanlineSize) *scanline_size;
    __typeof__(TIFFComputeTile) *tile_at;
    __typeof__(TIFFComputeStrip) *strip_at;
    __typeof__(TIFFReadEncodedTile) *read_tile;
    __typeof__(TIFFReadEncodedStrip) *read_strip;
} FfpTiffModule;

extern FFP_MODULE_EXPORT const FfpTiffModule ffp_tiff_module;

#endif
