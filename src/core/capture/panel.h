// Pictures for the real projector, out of pictures for the ideal one that a capture describes.
#ifndef FFP_CAPTURE_PANEL_H
#define FFP_CAPTURE_PANEL_H

#include "core/capture/capture.h"
#include "core/capture/optics.h"

// The part of a projector's calibration that a capture records. The gamma is not changed.
void ffp_panel_describe(FfpPanel *panel, const FfpOptics *optics);

// A picture as the ideal projector is to show it (linear light, in place) becomes what reaches the camera of
// it: blurred, and a share of it spread. The capture's own patterns are so already.
void ffp_panel_soften(const FfpPanel *panel, FfpImage *picture);

// The picture to send to the projector so that it projects `pattern` (linear light of the pinhole `ideal`):
// lens distortion is reapplied, the picture resampled to the panel's size, and light converted to the values
// that produce it; black outside the ideal frame. Returned as linear numbers whose sRGB encoding is those
// values, so that it is written like any picture. Errors, which name `where`: a lens that folds the picture
// over itself.
bool ffp_panel_picture(FfpImage *out, const FfpPanel *panel, const FfpCamera *ideal, const FfpImage *pattern,
                       const char *where, FfpError *err);

#endif
