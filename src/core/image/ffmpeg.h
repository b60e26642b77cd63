// The program ffmpeg, which makes the films that we do not write ourselves out of raw frames.
#ifndef FFP_IMAGE_FFMPEG_H
#define FFP_IMAGE_FFMPEG_H

#include "core/base/process.h"

bool ffp_ffmpeg_makes(const char *path); // whether the file has an ending that it makes: .gif .mp4 .webm .mkv

// Starts it on frames of width x height RGB bytes. It writes into `file`, as what the ending of `path` says.
bool ffp_ffmpeg_start(FfpProcess **ffmpeg, const char *path, const char *file, int width, int height,
                      int rate, FfpError *err);
// Waits for its end; the error says what ffmpeg said. *ffmpeg becomes NULL.
bool ffp_ffmpeg_finish(FfpProcess **ffmpeg, const char *path, FfpError *err);

#endif
