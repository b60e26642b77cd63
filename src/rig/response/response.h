// How much light the projector makes of a pattern's values.
#ifndef FFP_RIG_RESPONSE_H
#define FFP_RIG_RESPONSE_H

#include "core/capture/capture.h"

typedef struct FfpResponse { // per channel: light = white's * (black + (1 - black) value^gamma)
    double gamma[3], gamma_deviation[3];
    double black[3];  // share of white's light under black ...
    bool black_known; // ... because the room was dark; otherwise at most this share: the rest is the room's
                      // light
    double intensity; // W/sr in world units, as a reader of captures would guess it (bright pixels have an
                      // albedo of 0.8), but with the distances and slants that were matched
    int samples;      // lit pixels that were used
} FfpResponse;

// Pattern values as they are in the file, in [0,1], to light beside black's: value^gamma. In place;
// `linear`: the image's values are the file's own, otherwise these are what sRGB encodes.
void ffp_response_apply(const FfpResponse *response, bool linear, FfpImage *pattern);

// From the pictures under black, white and `active`, with the depth that matching finds; matching and fitting
// take turns, since each needs the other. Errors (where: `fit_response`): views of different sizes, too few
// lit pixels, and a pattern without middling values, which says nothing about gamma.
bool ffp_fit_response(FfpResponse *response, const FfpCapture *capture, int active, bool linear,
                      FfpError *err);
// The black level of a channel from n pixels' shares black / white, which are reordered: false where the room
// was not dark, and it is the most that it may be.
bool ffp_response_black(double *shares, size_t n, double *black);

// --- greys.c ---

typedef struct FfpGrey { // an even picture
    double value;        // of the file, in (0,1)
    double light[3];     // median share of white's light above black's
} FfpGrey;

// Gamma and its deviation from at least two greys, by least squares. errors: root mean square differences of
// light of every other grey by the plain response (sRGB or `linear`) and by the gamma of the rest.
void ffp_fit_greys(FfpResponse *response, const FfpGrey *greys, int n, bool linear, double errors[2]);

#endif
