// Photographs of Gray codes to the projector position that each camera pixel sees (Inokuchi et al. 1984),
// with the pattern and its inverse compared pixel by pixel, which no albedo or exposure can mislead.
#ifndef FFP_RIG_GRAYCODE_H
#define FFP_RIG_GRAYCODE_H

#include "base/error.h"
#include "image/image.h"

// The photographs of one view, in the order in which `ffprocams patterns` shows the codes: columns, the
// coarsest bit first, each pattern followed by its inverse; then rows likewise.
typedef struct FfpGrayPhotographs {
    int width, height;        // of the panel that showed them
    const char *const *codes; // [ffp_gray_photographs(width, height)] files
    const char *black, *white;
    bool linear; // the files' numbers are linear light, and not sRGB
} FfpGrayPhotographs;
int ffp_gray_photographs(int width, int height);
// "gray_x_03_inverse"; also the axis (0: columns) and the bit of photograph `index`.
void ffp_gray_name(int width, int height, int index, char name[32]);

typedef struct FfpGrayReport {
    int lit, decoded; // pixels that white brightens enough; of these, with a position
    int dropped[2];   // finest bits of columns and rows that the photographs do not resolve
    double fine_sum; // what the finest codes and their inverses add up to, in white: 1 where values are light
    double step;     // median distance of neighbouring pixels' positions, panel pixels
} FfpGrayReport;

// map [h,w,3] of the photographs' size: position on the panel, pixels, centres at integer + 0.5, and trust: 1
// where it is known, else all are 0. Between the edges of the codes, which are found where a pattern and its
// inverse are equally bright, positions are those of local planes. Errors name the photographs: another size;
// too little light; stripes of a finer code that are broader (numbers exchanged); pairs that do not add up to
// white (another exposure, or no pair).
bool ffp_gray_decode_view(FfpImage *map, FfpGrayReport *report, const FfpGrayPhotographs *photographs,
                          FfpError *err);

#endif
