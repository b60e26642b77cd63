// The pictures of an animated WebP, which the ffmpeg of Debian 12 does not read.
#ifndef FFP_IMAGE_WEBP_H
#define FFP_IMAGE_WEBP_H

#include "core/image/raw.h"

typedef struct FfpWebp FfpWebp;

bool ffp_webp_moves(const char *path); // true if the file is an animated WebP
// The pictures of `file` between two times in seconds, `rate` a second. Errors,
// which name `path`: damaged; the module is not there.
FfpWebp *ffp_webp_open(const char *file, const char *path, int rate, double from, double to, FfpError *err);
// 1: *out is the next picture, U8 RGBA, until the next call; 0: there are no more; -1: an error.
int ffp_webp_next(FfpWebp *webp, FfpRaw *out, FfpError *err);
void ffp_webp_close(FfpWebp *webp); // NULL is allowed

#endif
