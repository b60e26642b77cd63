// Which photograph of a set shows what, found from the pictures: orders of other programs, and a set of which
// one is missing or too many.
#ifndef FFP_GRAYCODE_ORDERS_H
#define FFP_GRAYCODE_ORDERS_H

#include "rig/graycode/graycode.h"

enum { FFP_GRAY_GAPS = 2 }; // photographs that may be missing or too many, together

// A code without a photograph.
typedef struct FfpGrayLost {
    char name[32];
    const char *beside; // file: a neighbour
    bool after, made;   // it comes after that neighbour; it is made from the other one of its pair
} FfpGrayLost;

// An order in words, for ffp_gray_tell_order.
typedef struct FfpGrayOrder {
    char text[200];                           // "rows first"; "": that of `patterns`
    const char *first, *extra[FFP_GRAY_GAPS]; // files: the first; those too many, or NULL
    FfpGrayLost lost[FFP_GRAY_GAPS];
    int n_lost;
} FfpGrayOrder;

// Fills in `codes` (an array of ffp_gray_photographs(width, height), which the caller releases with
// ffp_free), `black` and `white` (NULL: none that fits) of what has a panel's size, from files in the order
// in which they were shown; white lies somewhere among them. False: no order of the table explains them.
// Codes whose stripes the camera does not resolve are where the others' order has them.
bool ffp_gray_find_order(FfpGrayPhotographs *photographs, FfpGrayOrder *order, const char *const *files,
                         int n, const char **codes);
// Notes which order it is if it is not that of `patterns`, and which photograph is missing or left out.
void ffp_gray_tell_order(const FfpGrayOrder *order);
void ffp_gray_tell_lost(const FfpGrayLost *lost);

#endif
