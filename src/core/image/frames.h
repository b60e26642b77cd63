// The frames of a film one after another, by ffmpeg.
#ifndef FFP_IMAGE_FRAMES_H
#define FFP_IMAGE_FRAMES_H

#include "core/base/file.h"
#include "core/base/process.h"
#include "core/image/raw.h"
#include "core/image/stream.h"

typedef struct FfpFrames {
    FfpProcess *process;
    struct FfpWebp *webp; // an animated WebP, which no process reads
    const char *path;
    int width, height; // of all frames, once there is one
    int channels;      // 3, or 4 with straight alpha
    unsigned char *bytes;
    int count;               // that came so far
    int expected;            // by what the file says of its length; 0: it does not
    FfpRate rate;            // of the frames that come
    char file[FFP_PATH_MAX]; // where they come from:
    double from, length;     // seconds; length 0: to its end
    bool sound;              // it has some
} FfpFrames;

// True if a path names a film, or a part of one ("FILM@FROM-TO"), by what the file holds: GIF, WebP and
// animated PNG too.
bool ffp_frames_are_in(const char *path);
// Starts reading, `rate` frames a second (0: the film's own, or 15 if it does not say), with square pixels,
// in sRGB (stream.h); a note says what was assumed. Errors: no film; ffmpeg is not installed.
bool ffp_frames_open(FfpFrames *frames, const char *path, int rate, FfpError *err);
// 1: *out is the next frame, U8 RGB or RGBA, until the next call; 0: there are no more; -1: an error, as when
// frames have several sizes, or none came at all.
int ffp_frames_next(FfpFrames *frames, FfpRaw *out, FfpError *err);
void ffp_frames_close(FfpFrames *frames); // safe after a failed open

#endif
