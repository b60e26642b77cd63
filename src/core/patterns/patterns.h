// The patterns that a projector shows while a rig is photographed. Pictures have the size of its panel, with
// encoded values in [0,1] as in 8-bit files, [height,width,3] unless stated otherwise.
#ifndef FFP_PATTERNS_PATTERNS_H
#define FFP_PATTERNS_PATTERNS_H

#include <stdbool.h>
#include <stdint.h>
#include "core/image/image.h"

// All of one grey, 0 to 255. [height,width,1]
FfpImage ffp_pattern_plain(int width, int height, int grey);

// Bits that number the panel's columns (axis 0, of its width) or rows (axis 1, of its height).
int ffp_gray_code_bits(int size);
// Bit `bit`, 0 the coarsest of ffp_gray_code_bits, of the reflected binary code i ^ (i >> 1) of each column
// or row i (Gray 1953; Inokuchi et al. 1984); inverse: white where the bit is 0. [height,width,1]
FfpImage ffp_pattern_gray_code(int width, int height, int axis, int bit, bool inverse);
// Of the panel's codes in their order (columns, the coarsest bit first, each pattern followed by its inverse;
// then rows likewise) the axis and bit of number `index`, and its name: "gray_x_03_inverse".
void ffp_gray_code_place(int width, int index, int *axis, int *bit);
void ffp_gray_code_name(int width, int index, char name[32]);
// The column or row whose code's bits these are, the coarsest first.
int ffp_gray_decode(const bool *bits, int count);

// A lollipop as wide as high, in the centre of the panel and black around it: its rings stay circles.
FfpImage ffp_pattern_round_lollipop(int width, int height, uint64_t seed);

// For focusing and for placing the object: a frame and a cross one pixel wide, and nine stars of 36 sectors,
// whose spokes merge where the projector no longer resolves them. [height,width,1]
FfpImage ffp_pattern_focus(int width, int height);

// --- In display order. ---

typedef struct FfpShow {
    int width, height; // of the panel
    int lollipops;
    bool focus, capture, gray_codes; // which parts
    int columns, rows;               // inner corners of the chessboard on paper; 0: none
    double square;                   // side of its squares, mm
    int greys;                       // even pictures between black and white, behind the lollipops
} FfpShow;

typedef enum FfpShowPart { FFP_SHOW_FOCUS, FFP_SHOW_CAPTURE, FFP_SHOW_GRAY_CODES } FfpShowPart;

int ffp_show_count(const FfpShow *show);
// The value of grey `index` of so many, 1 to 254, evenly from dark to light; and its value by the name
// "grey_051", 0 if that is not a grey's.
int ffp_show_grey(int greys, int index);
int ffp_grey_named(const char *name);
// The picture with number `index`, and its name ("lollipop_0").
FfpImage ffp_show_picture(const FfpShow *show, int index, char name[32], FfpShowPart *part);
// Its number in the names of files: that of its photograph, from 1. The focus chart, which nobody
// photographs, has 0.
int ffp_show_number(const FfpShow *show, int index);

// Everything into the folder at `path`, which exists: <number>_<name>.png, README.txt, which says how to
// photograph them, show.html, which shows them one by one, and the
// chessboard on paper. shown.h reads such a folder.
bool ffp_show_write(const FfpShow *show, const char *path, FfpError *err);
// The same into a folder that is new or empty, completely or not at all.
bool ffp_show_write_folder(const FfpShow *show, const char *path, FfpError *err);

// --- On paper. ---

// chessboard.svg and chessboard.pdf at true size, on A4 if it fits, with a ruler below: columns x rows inner
// corners, squares of `square` mm.
bool ffp_board_write(const char *folder, int columns, int rows, double square, FfpError *err);

#endif
