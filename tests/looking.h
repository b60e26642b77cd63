// Cameras for tests.
#ifndef FFP_TESTS_LOOKING_H
#define FFP_TESTS_LOOKING_H

#include "core/base/vec.h"
#include "core/capture/capture.h"

// At `eye`, looking at the origin, z up, the principal point in the middle; focal length in pixels.
static inline FfpCamera looking_at_origin(const real eye[3], int width, int height, real focal) {
    FfpCamera c = {.width = width,
                   .height = height,
                   .fx = focal,
                   .fy = focal,
                   .cx = (real)width / 2,
                   .cy = (real)height / 2};
    const real up[3] = {0, 0, 1};
    real forward[3] = {-eye[0], -eye[1], -eye[2]}, right[3], down[3];
    ffp_normalise3(forward);
    ffp_cross3(forward, up, right);
    ffp_normalise3(right);
    ffp_cross3(forward, right, down);
    for (int i = 0; i < 3; i++) {
        real *row = c.pose + 4 * i;
        row[0] = right[i], row[1] = down[i], row[2] = forward[i], row[3] = eye[i];
    }
    c.pose[15] = 1;
    return c;
}

#endif
