// Photographs of Gray codes to the projector position that each camera pixel sees (Inokuchi et al. 1984),
// with the pattern and its inverse compared pixel by pixel, which no albedo or exposure can mislead.
#ifndef FFP_GRAYCODE_GRAYCODE_H
#define FFP_GRAYCODE_GRAYCODE_H

#include "core/base/error.h"
#include "core/image/image.h"

// Photographs that were read already, so that nobody reads them again.
typedef struct FfpGrayCache {
    struct {
        const char *path;
        float *grey;   // [h,w] mean of the channels as linear light; NULL: given away
        FfpImage luma; // of the white one (ffp_photograph_luma)
        int width, height;
    } files[4];
    int n;
} FfpGrayCache;
void ffp_gray_cache_free(FfpGrayCache *cache);

// The photographs of one view, in the order in which `ffprocams patterns` shows the codes: columns, the
// coarsest bit first, each pattern followed by its inverse; then rows likewise.
typedef struct FfpGrayPhotographs {
    int width, height; // of the panel that showed them
    const char *const
        *codes; // [ffp_gray_photographs(width, height)] files; NULL: missing. One of a pair is made of
                // the other, black and white; without both this code and finer ones are not used
    const char *black, *white;
    int shrink;  // they are read at 1 / shrink of their size, which the map and `region` have; 0: as they are
    bool linear; // the files' numbers are linear light, and not sRGB
    FfpGrayCache *cache; // where ffp_gray_find_plain leaves what it has read, for ffp_gray_decode_view; NULL:
                         // nowhere
    const FfpImage
        *region; // [h,w,1] not 0 where it is looked at whether they belong together; NULL: anywhere
} FfpGrayPhotographs;
int ffp_gray_photographs(int width, int height);

// Takes black and white, by their light, from the two first or the two last of `n` files of which the others
// are the codes; white is brighter wherever the projector's light falls. Sets `codes`, `black` and `white` of
// what has the other members set. Errors: another number of files; neither pair is black and white.
bool ffp_gray_find_plain(FfpGrayPhotographs *photographs, const char *const *files, int n, FfpError *err);

typedef struct FfpGrayReport {
    int lit, decoded; // pixels that white brightens enough; of these, with a position
    int dropped[2];   // finest bits of columns and rows that the photographs do not resolve
    double fine_sum; // what the finest codes and their inverses add up to, in white: 1 where values are light
    double step;     // median distance of neighbouring pixels' positions, panel pixels
    double clipped;  // share of the pixels that are looked at which are saturated under white
} FfpGrayReport;

// map [h,w,3] of the photographs' size: position on the panel, pixels, centres at integer + 0.5, and trust: 1
// where it is known, otherwise all are 0. Between the edges of the codes, which are found where a pattern and
// its inverse are equally bright, positions are those of local planes. Errors name the photographs: another
// size; too little light; a pair that does not add up to white (another exposure, or no pair); stripes of a
// finer code that are broader, codes that jump or lie beyond the panel (numbers exchanged: which ones, where
// one exchange explains it).
bool ffp_gray_decode_view(FfpImage *map, FfpGrayReport *report, const FfpGrayPhotographs *photographs,
                          FfpError *err);

// Sets the error of a white photograph that lights nothing: it and black have changed places, are overexposed
// or dark. `black`, `added`: means of the linear light under black, and of what white adds. Returns false.
bool ffp_gray_fail_dark(double black, double added, const char *white, FfpError *err);

#endif
