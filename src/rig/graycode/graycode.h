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
    } files[6];
    int n;
    const char **codes; // the list of files that ffp_gray_find_plain has put in order; NULL: as they came
    const char **other; // the order that ffp_gray_decode_view has found instead of that of `codes`, or NULL
} FfpGrayCache;
void ffp_gray_cache_free(FfpGrayCache *cache);

// The photographs of one view, in the order in which `ffprocams patterns` shows the codes: columns, the
// coarsest bit first, each pattern followed by its inverse; then rows likewise.
typedef struct FfpGrayPhotographs {
    int width, height; // of the panel that showed them
    const char *const
        *codes; // [ffp_gray_photographs(width, height)] files; NULL: missing. One of a pair is made of
                // the other, black and white; without both this code and finer ones are not used
    const char *black, *white; // NULL: missing, and made from the codes' photographs
    int shrink; // they are read at 1 / shrink of their size, which the map and `region` have; 0: as they are
    int others; // patterns between black and white and the codes that may have been photographed, too
    double noise;        // deviation of what white adds to black, where they were made; 0: they tell it
    bool linear;         // the files' numbers are linear light, and not sRGB
    FfpGrayCache *cache; // where ffp_gray_find_plain leaves what it has read, for ffp_gray_decode_view; NULL:
                         // nowhere
    const FfpImage
        *region; // [h,w,1] not 0 where it is looked at whether they belong together; NULL: anywhere
} FfpGrayPhotographs;
int ffp_gray_photographs(int width, int height);

// Takes black and white, by their light, from the two first or the two last of `n` files of which the others
// are the codes (NULL: missing); white is brighter wherever the projector's light falls. Sets `codes`,
// `black` and `white` of what has the other members set. Where there is a cache, other numbers and orders of
// files are understood, too (orders.h). Errors: another number of files; neither pair is black and white.
bool ffp_gray_find_plain(FfpGrayPhotographs *photographs, const char *const *files, int n, FfpError *err);

typedef struct FfpGrayScaling {
    double wave, period; // by which sums of pairs differ along the panel, in white, and every how many pixels
} FfpGrayScaling;

enum { FFP_GRAY_FAR = 12, FFP_GRAY_PAIRS = 30 };

// Figures of a view's photographs that depend on the settings of projector and camera (doctor.c). Pairs of
// codes are those whose stripes are wide; brightness is in white's light.
typedef struct FfpGrayFigures {
    int pairs;
    double sum[FFP_GRAY_PAIRS];       // what each adds up to far from edges
    double colour[FFP_GRAY_PAIRS][3]; // and its channels' means over the photographs; 0: unknown
    double bright[FFP_GRAY_FAR + 1], dark[FFP_GRAY_FAR + 1]; // lit and dark stripes by distance from an edge,
                                                             // in the lit ones far from it: sums
    double count[FFP_GRAY_FAR + 1];                          // over so many pixels; the last: and farther
    double step;                                             // panel pixels from one pixel to the next
    double bands;               // deviation between neighbouring strips of a photograph
    double black;               // light under black, in that under white
    FfpGrayScaling scaling[2];  // of columns and rows
    double ends[2][2], size[2]; // where the picture begins and ends within the panel, pixels; 0: as the panel
} FfpGrayFigures;

// Black and white (0, 1) that nobody photographed, made from the codes: [h,w,3], linear light.
bool ffp_gray_make_pictures(FfpImage plain[2], const FfpGrayPhotographs *from, FfpError *err);
// Says that black or white, those that are missing, are made from the codes, of which one is there at least.
void ffp_gray_tell_made(const bool missing[2], const char *const *codes);

typedef struct FfpGrayReport {
    int lit, decoded; // pixels that white brightens enough; of these, with a position
    int dropped[2];   // finest bits of columns and rows that the photographs do not resolve
    bool linear;      // the photographs' numbers were read as linear light
    double fine_sum; // what the finest codes and their inverses add up to, in white: 1 where values are light
    double step;     // median distance of neighbouring pixels' positions, panel pixels
    double clipped;  // share of the pixels that are looked at which are saturated under white
    int dim[2];     // of `dropped`, those left out because their pairs add up to much less than coarser ones:
    double dim_sum; // so much of white
    unsigned
        unlike[2]; // bits of columns and rows whose pairs add up to another light than white, as a whole:
    double other_light; // the one that is farthest off, in white; 0: all add up to it
    FfpGrayFigures figures;
} FfpGrayReport;

// Reports dim codes, other light and wrong settings as findings of a view or place.
void ffp_gray_tell_light(const FfpGrayReport *report, const char *view);
// Notes how much of it is overexposed, if that is much.
void ffp_gray_note_clipped(const FfpGrayReport *report, const char *view);

// map [h,w,3] of the photographs' size: position on the panel, pixels, centres at integer + 0.5, and trust: 1
// where it is known, otherwise all are 0. Between the edges of the codes, which are found where a pattern and
// its inverse are equally bright, positions are those of local planes. Errors name the photographs: another
// size; too little light; a pair that does not add up to white (one of it exposed differently, or no pair);
// stripes of a finer code that are broader, codes that jump or lie beyond the panel (numbers exchanged: which
// ones, where one exchange explains it).
bool ffp_gray_decode_view(FfpImage *map, FfpGrayReport *report, const FfpGrayPhotographs *photographs,
                          FfpError *err);

// Sets the error of a white photograph that lights nothing: it and black have changed places, are overexposed
// or dark. `black`, `added`: means of the linear light under black, and of what white adds. Returns false.
bool ffp_gray_fail_dark(double black, double added, const char *white, FfpError *err);

#endif
