// Films: a sequence of pictures in one file.
#ifndef FFP_IMAGE_FILM_H
#define FFP_IMAGE_FILM_H

#include <stdint.h>
#include "core/base/file.h"
#include "core/base/process.h"
#include "core/image/frames.h"
#include "core/image/image.h"

// Checks before the work that a film can be made: its extension is .png or .apng (an animated PNG), or it is
// .gif, .mp4, .webm or .mkv and ffmpeg is installed.
bool ffp_film_check(const char *path, FfpError *err);

// An animated PNG (PNG third edition, W3C 2025, section 11.3.4 and 12): every frame is a complete 8-bit RGB
// picture, shown as long as the rate says, and played in an endless loop. Programs without support for
// animation show the first. Or a film in another format, made by ffmpeg.
typedef struct FfpFilm {
    FfpOutput out;
    int width, height;
    FfpRate rate;
    const FfpFrames *sound; // of the film whose sound it gets; NULL: none
    uint32_t frames, done;  // frames: 0 where their number is not known before
    long control;           // animated PNG: where its chunk acTL is
    uint32_t sequence;      // animated PNG: number of the next fcTL or fdAT chunk
    bool by_ffmpeg;
    FfpProcess *ffmpeg; // runs from the first frame on, into out's temporary file
} FfpFilm;
bool ffp_film_open(FfpFilm *film, const char *path, int frames, int rate, FfpError *err);
// Gives it the rate of frames that are open, and their film's sound, before the first frame; they stay the
// caller's until the commit. A note says that a format has no sound.
void ffp_film_follow(FfpFilm *film, const FfpFrames *frames);
// All frames must have the same size, and their number must be the one announced, unless that was 0.
bool ffp_film_add(FfpFilm *film, const FfpImage *encoded, FfpError *err);
bool ffp_film_commit(FfpFilm *film, FfpError *err);
void ffp_film_abort(FfpFilm *film); // safe after commit or a failed open

#endif
