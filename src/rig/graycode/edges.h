// Positions between the edges of Gray codes.
#ifndef FFP_GRAYCODE_EDGES_H
#define FFP_GRAYCODE_EDGES_H

#include <stdint.h>

// How much brighter the pattern is than its inverse, in 1/127 of white: -127 to 127, kept as a byte.
#define FFP_GRAY_NONE 128
static inline int ffp_gray_signal(uint8_t byte) {
    return (int)byte - FFP_GRAY_NONE;
}

// One axis of a decoded view.
typedef struct FfpGrayAxis {
    int width, height;            // of the photographs
    int bits, block;              // that are used; panel pixels that share a code
    const uint8_t *const *signal; // [bits][h,w] pattern against inverse, ffp_gray_signal
    const int *code;              // [h,w] number of the block; -1: not decoded
    const float *light;           // [h,w] that white adds to black: how well a signal is known; 0: not at all
} FfpGrayAxis;

// Bit in which the codes of two neighbouring blocks differ; -1 where they are not neighbours.
int ffp_gray_edge_bit(const FfpGrayAxis *axis, int a, int b);

// position [h,w]: panel pixels, of the centre of each decoded pixel with light. Where the code changes from
// one block to the next between two pixels, the edge lies where pattern and inverse are equally bright, and
// its position on the panel is exact; a plane through the edges around a pixel, by least squares weighted
// with the light, says where the pixel lies. Where there are too few edges it is the block's middle, or -1
// where the pixel has no light.
void ffp_gray_positions(float *position, const FfpGrayAxis *axis);

#endif
