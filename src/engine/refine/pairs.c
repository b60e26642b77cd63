// Which views go together where steps come in pairs.
#include <tgmath.h>
#include "engine/refine/fit.h"

// Cosine of the angle between the cameras' directions from the middle.
static real alike(const FfpCapture *capture, int a, int b) {
    const real *from_a = capture->views[a].camera.pose, *from_b = capture->views[b].camera.pose;
    real dot = 0, square_a = 0, square_b = 0;
    for (int k = 3; k < 12; k += 4) {
        dot += from_a[k] * from_b[k];
        square_a += from_a[k] * from_a[k];
        square_b += from_b[k] * from_b[k];
    }
    return dot / sqrt(square_a * square_b);
}

void ffp_pair_opposites(const FfpCapture *capture, int *order) {
    for (int i = 0; i + 1 < capture->n_views; i += 2) {
        int farthest = i + 1;
        for (int j = i + 2; j < capture->n_views; j++)
            if (alike(capture, order[i], order[j]) < alike(capture, order[i], order[farthest])) farthest = j;
        const int swap = order[i + 1];
        order[i + 1] = order[farthest];
        order[farthest] = swap;
    }
}
