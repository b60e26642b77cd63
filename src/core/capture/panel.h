// Pictures for the real projector, out of pictures for the ideal one that a capture describes.
#ifndef FFP_CAPTURE_PANEL_H
#define FFP_CAPTURE_PANEL_H

#include "core/capture/capture.h"
#include "core/capture/optics.h"

// What a capture keeps of a projector's calibration. Its gamma is not touched.
void ffp_panel_describe(FfpPanel *panel, const FfpOptics *optics);

// What to send to the projector so that it throws `pattern` (linear light of the pinhole `ideal`): the lens's
// distortion is put in again, the picture brought to the panel's size, and light turned into the values that
// make it; black where the ideal frame ends. Returned as linear numbers whose sRGB encoding is those values,
// so that it is written as any picture is. Errors: a lens that folds the picture over itself; `where` is what
// they name.
bool ffp_panel_picture(FfpImage *out, const FfpPanel *panel, const FfpCamera *ideal, const FfpImage *pattern,
                       const char *where, FfpError *err);

#endif
