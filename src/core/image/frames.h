// The frames of a film one after another, by ffmpeg.
#ifndef FFP_IMAGE_FRAMES_H
#define FFP_IMAGE_FRAMES_H

#include "core/base/process.h"
#include "core/image/raw.h"

typedef struct FfpFrames {
    FfpProcess *process;
    const char *path;
    int width, height; // of all frames, once there is one
    unsigned char *rgb;
    int count; // that came so far
} FfpFrames;

// Whether a path names a film, or a part of one ("FILM@FROM-TO"), by what the file holds.
bool ffp_frames_are_in(const char *path);
// Starts reading, `rate` frames a second (0: the film's own). Errors: no film; ffmpeg is not installed.
bool ffp_frames_open(FfpFrames *frames, const char *path, int rate, FfpError *err);
// 1: *out is the next frame, U8 RGB, until the next call; 0: there are no more; -1: an error, as when frames
// have several sizes, or none came at all.
int ffp_frames_next(FfpFrames *frames, FfpRaw *out, FfpError *err);
void ffp_frames_close(FfpFrames *frames); // safe after a failed open
// How many there are; -1: an error.
int ffp_frames_count(const char *path, int rate, FfpError *err);

#endif
