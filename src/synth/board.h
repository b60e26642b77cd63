// A printed chessboard: flat, matt, with a white margin around its squares.
#ifndef FFP_SYNTH_BOARD_H
#define FFP_SYNTH_BOARD_H

#include "synth/mesh.h"

typedef struct FfpBoard {
    int columns, rows;       // inner corners
    float square;            // side of a square, world units
    float origin[3];         // the inner corner nearest to the upper left
    float right[3], down[3]; // unit: along its rows and columns of corners
} FfpBoard;

// The point x squares to the right and y down from the first corner, in the world.
void ffp_board_point(const FfpBoard *board, float x, float y, float point[3]);
// The print: fine triangles that face against right x down, where one sees it, with the margin of a square.
FfpMesh ffp_board_mesh(const FfpBoard *board);
// Albedo and roughness at a point of it. The square at the upper left is black.
void ffp_board_look(const FfpBoard *board, const float point[3], float albedo[3], float *roughness);

#endif
