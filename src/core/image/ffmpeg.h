// The program ffmpeg, which makes films in formats other than animated PNG from raw frames.
#ifndef FFP_IMAGE_FFMPEG_H
#define FFP_IMAGE_FFMPEG_H

#include "core/image/frames.h"

bool ffp_ffmpeg_makes(const char *path); // true if the extension is one that it makes: .gif .mp4 .webm .mkv

bool ffp_ffmpeg_sounds(const char *path); // true if its films have sound

// Starts it on frames of width x height RGB bytes, with the sound of the film that they were made from, or
// NULL. It writes to `file`, in the format given by the extension of `path`.
bool ffp_ffmpeg_start(FfpProcess **ffmpeg, const char *path, const char *file, int width, int height,
                      FfpRate rate, const FfpFrames *sound, FfpError *err);
// Waits for its end; the error contains ffmpeg's message. *ffmpeg becomes NULL.
bool ffp_ffmpeg_finish(FfpProcess **ffmpeg, const char *path, FfpError *err);

#endif
