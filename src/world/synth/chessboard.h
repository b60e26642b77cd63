// A printed chessboard: flat, matt, with a white margin around its squares.
#ifndef FFP_SYNTH_CHESSBOARD_H
#define FFP_SYNTH_CHESSBOARD_H

#include "world/shapes/mesh.h"

typedef struct FfpChessboard {
    int columns, rows;       // inner corners
    float square;            // side of a square, world units
    float origin[3];         // the inner corner nearest to the upper left
    float right[3], down[3]; // unit: along its rows and columns of corners
} FfpChessboard;

// The point x squares to the right and y down from the first corner, in the world.
void ffp_chessboard_point(const FfpChessboard *board, float x, float y, float point[3]);
// The print: fine triangles that face against right x down, where one sees it, with the margin of a square.
FfpMesh ffp_chessboard_mesh(const FfpChessboard *board);
// Albedo and roughness at a point of it. The square at the upper left is black.
void ffp_chessboard_look(const FfpChessboard *board, const float point[3], float albedo[3], float *roughness);

#endif
