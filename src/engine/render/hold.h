// Pixels held to the places on the pattern that Gray codes found for them.
#ifndef FFP_RENDER_HOLD_H
#define FFP_RENDER_HOLD_H

#include "engine/render/render.h"

// The mean, over all pixels whose place is known, of Huber's cost of the distance between that place and the
// mean of the pixel's samples, in units of `scale` pixels of the projector, times `weight`. A pixel that is
// not lit in all its samples, or is farther off than any surface that codes and depth could disagree about,
// costs nothing. transport: of side x side samples a pixel. positions: [height,width,3] as
// FfpView.correspondence. ADDS its gradient to the transport's places.
real ffp_hold_places(const FfpTransport *transport, int side, const FfpImage *positions, real scale,
                     real weight, FfpTransport *grad_transport);

#endif
