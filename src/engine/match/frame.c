#include <tgmath.h>
#include "engine/match/match.h"

void ffp_normal_frame(const real n[3], real quaternion[4]) {
    // Half-way quaternion: (1 + z.n, z x n), normalised. Against z it has no direction; then half a
    // turn about x.
    const real w = 1 + n[2], x = -n[1], y = n[0], square = w * w + x * x + y * y;
    const bool against = square < 1e-10F;
    const real scale = against ? 0 : 1 / sqrt(square);
    quaternion[0] = w * scale;
    quaternion[1] = against ? 1 : x * scale;
    quaternion[2] = y * scale;
    quaternion[3] = 0;
}
