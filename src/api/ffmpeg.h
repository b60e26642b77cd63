// The program ffmpeg, which makes the films that we do not write ourselves out of raw frames.
#ifndef FFP_API_FFMPEG_H
#define FFP_API_FFMPEG_H

#include <stdbool.h>
#include <stdio.h>
#include <sys/types.h>
#include "base/error.h"

typedef struct FfpFfmpeg {
    pid_t pid;  // 0: not running
    int frames; // socket that takes them
    FILE *said; // what it says on stderr
} FfpFfmpeg;

bool ffp_ffmpeg_makes(const char *path); // whether the file has an ending that it makes: .gif .mp4 .webm .mkv
bool ffp_ffmpeg_is_there(void);          // on PATH

// Starts it (*ffmpeg, which a call that is left kills) on frames of width x height RGB bytes. It writes into
// `file`, as what the ending of `path` says.
bool ffp_ffmpeg_start(FfpFfmpeg **ffmpeg, const char *path, const char *file, int width, int height, int rate,
                      FfpError *err);
bool ffp_ffmpeg_write(FfpFfmpeg *ffmpeg, const unsigned char *bytes, size_t size); // false: it takes no more
// Waits for its end; the error says what ffmpeg said. *ffmpeg becomes NULL.
bool ffp_ffmpeg_finish(FfpFfmpeg **ffmpeg, const char *path, FfpError *err);
void ffp_ffmpeg_kill(FfpFfmpeg **ffmpeg); // safe after finish, and when it was never started

#endif
