// Inside the field's room: the grid of mean densities that tells where along a ray there is anything.
#ifndef FFP_FIELD_MARCH_H
#define FFP_FIELD_MARCH_H

#include "core/base/rng.h"
#include "core/base/vec.h"
#include "lab/baselines/field.h"

enum { FFP_FIELD_ON_RAY = 256 }; // points at the most

typedef struct FfpFieldRay {
    real origin[3], direction[3]; // unit
    real ahead;                   // camera z of a step of 1 along it
} FfpFieldRay;

FfpFieldRay ffp_field_ray(const FfpCamera *camera, real x, real y);

// The cells of the visual hull, into field->density: where no view that has a cell in its picture sees past
// all of it. Returns how many there are.
int64_t ffp_field_carve(FfpNeuralField *field, const FfpCapture *capture);

// Distances of the ray's points: steps of field->step through the unit sphere, the first `jitter` of one
// behind its rim, where there is something (or, exploring, anywhere in the hull), until nothing more comes
// through. Returns their number.
int ffp_field_march(const FfpNeuralField *field, const FfpFieldRay *ray, real jitter, bool explores,
                    real distance[FFP_FIELD_ON_RAY]);

// Share of the light of `lamp` that comes through to a point, by the grid alone; 3 cells before the point do
// not count.
real ffp_field_transmittance(const FfpNeuralField *field, const real point[3], const real lamp[3]);

// Cells whose density is renewed in turn.
typedef struct FfpFieldCells {
    int64_t count, next;
    int32_t *cell;                  // [count]
    real *position, *encoded, *raw; // of a batch
    real *hidden[FFP_FIELD_LAYERS - 1];
} FfpFieldCells;
FfpFieldCells ffp_field_cells_new(const FfpNeuralField *field);
void ffp_field_cells_free(FfpFieldCells *cells);
// The next cells' densities halfway towards the network's at a random place in each.
void ffp_field_cells_renew(FfpFieldCells *cells, FfpNeuralField *field, int64_t count, FfpRng *rng);

#endif
