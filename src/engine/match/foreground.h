// The pixels of a view that show the object: matching keeps numbers for these alone.
#ifndef FFP_MATCH_FOREGROUND_H
#define FFP_MATCH_FOREGROUND_H

#include "core/capture/capture.h"

#define FFP_OFF ((size_t)-1) // the slot of a pixel off the object

typedef struct FfpForeground {
    int width, height;
    size_t count;  // pixels of coverage above zero
    size_t *pixel; // [count] y * width + x, ascending
    size_t *slot;  // [h,w] index into pixel, or FFP_OFF
} FfpForeground;

FfpForeground ffp_foreground_new(const FfpImage *coverage);
void ffp_foreground_free(FfpForeground *foreground);

#endif
