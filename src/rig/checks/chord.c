#include "rig/checks/chord.h"
#include <tgmath.h>

#define WIDER 1.25 // the sphere of a whole scene, which need not hold all that is lit

bool ffp_chord(const FfpCapture *capture, const FfpCamera *camera, size_t index, FfpChord *chord) {
    const size_t column = index % (size_t)camera->width, row = index / (size_t)camera->width;
    ffp_pixel_ray(camera, (real)column + 0.5F, (real)row + 0.5F, chord->direction);
    double along = 0, square = 0;
    for (int i = 0; i < 3; i++) {
        chord->origin[i] = camera->pose[4 * i + 3];
        const double to = (double)capture->centre[i] - (double)chord->origin[i];
        along += to * (double)chord->direction[i], square += to * to;
    }
    const double radius = (double)capture->radius * (capture->scene ? WIDER : 1);
    const double half = radius * radius - (square - along * along);
    if (!(half > 0)) return false;
    chord->near = (real)(along - sqrt(half)), chord->far = (real)(along + sqrt(half));
    return chord->near > 0;
}

void ffp_chord_point(const FfpChord *chord, int k, int n, real point[3]) {
    const real t = chord->near + (chord->far - chord->near) * ((real)k + 0.5F) / (real)n;
    for (int i = 0; i < 3; i++) point[i] = chord->origin[i] + t * chord->direction[i];
}
