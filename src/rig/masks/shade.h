// The object's shadow on the stage.
#ifndef FFP_RIG_SHADE_H
#define FFP_RIG_SHADE_H

#include "rig/masks/steps.h"

// Marks those pixels of a view's mask [height*width] that are the stage in the object's shadow, though a hull
// allows the object there, and returns the marks (the caller frees them). They are as dark, as a share of the
// lit stage, as the shadow is elsewhere (`around` [height*width]: pixels that are not the mask's, near it),
// and under black they have the stage's colour rather than that of the object nearby: the room's light
// reaches shadows, too, and the pattern itself does not. Pixels that are sure (compared->kinds) stay as they
// are.
unsigned char *ffp_shade_find(const FfpCapture *capture, int view, const FfpEmptyStage *stage,
                              const FfpCompared *compared, const unsigned char *mask,
                              const unsigned char *around);

#endif
