// Sequences of pictures: devices that go round an object, and films.
#ifndef FFP_API_VIDEO_H
#define FFP_API_VIDEO_H

#include "ffprocams.h"
#include "api/ffmpeg.h"
#include "base/file.h"
#include "capture/capture.h"

// `count` views [count] (release with ffp_free): those of one full turn from `base`. The turn is about the
// capture's centre and the direction that is up in its pictures, the mean over the views. Views have no
// pictures.
FfpView *ffp_orbit_views(const FfpCapture *capture, const FfpView *base, FfpOrbit orbit, int count);

// Whether a film can be made, told before the work: its ending is .png or .apng (an animated PNG), or .gif,
// .mp4, .webm or .mkv, and then ffmpeg is there.
bool ffp_animation_check(const char *path, FfpError *err);

// An animated PNG (PNG third edition, W3C 2025, section 11.3.4 and 12): every frame a whole 8-bit RGB
// picture, shown for 1 / rate seconds, played without end. Programs that know no animation show the first.
// Or a film of another kind, by ffmpeg.
typedef struct FfpAnimation {
    FfpOutput out;
    int width, height, rate; // frames a second
    uint32_t frames, done;
    uint32_t sequence; // animated PNG: number of the next fcTL or fdAT chunk
    bool by_ffmpeg;
    FfpProcess *ffmpeg; // runs from the first frame on, into out's temporary file
} FfpAnimation;
bool ffp_animation_open(FfpAnimation *animation, const char *path, int frames, int rate, FfpError *err);
// Frames must be of one size, and as many as were announced.
bool ffp_animation_add(FfpAnimation *animation, const FfpImage *encoded, FfpError *err);
bool ffp_animation_commit(FfpAnimation *animation, FfpError *err);
void ffp_animation_abort(FfpAnimation *animation); // safe after commit or a failed open

#endif
