// Inside the field's room: some rays of a step, from the pixels that they belong to to the loss and back to
// what the networks were given. The steps of a fit are made of chunks, which threads work on side by side.
#ifndef FFP_FIELD_CHUNK_H
#define FFP_FIELD_CHUNK_H

#include "lab/baselines/light.h"
#include "lab/baselines/march.h"

enum {
    FFP_CHUNK_POINTS = 4096,
    FFP_CHUNK_ROW = FFP_CHUNK_POINTS + 64, // numbers from row to row: no power of two, for the cache's sake
    FFP_CHUNK_RAYS = 1024,
    FFP_CHUNK_LOOKS = 2, // of the visibility network at a ray's surface: to the projector, and anywhere
    FFP_CHUNK_PROBED = 4 // every such ray's normals are held against the density's
};

typedef struct FfpFieldPattern {
    const FfpImage *image;
    FfpSummed summed; // of a pattern that is not flat
    bool flat;
    real colour[3]; // of a flat one
} FfpFieldPattern;

// The scene that all chunks see.
typedef struct FfpFieldScene {
    const FfpCapture *capture;
    const int *chosen; // [n_patterns] indices into the capture's
    int n_patterns;
    FfpFieldPattern *patterns; // [n_patterns]
    int32_t **pixels;          // [n_views] those that rays are drawn from
    int64_t *counts;           // [n_views]
    double share;              // of all pixels of all views that are drawn from; the others are empty
} FfpFieldScene;
FfpFieldScene ffp_field_scene_new(const FfpCapture *capture, const int *chosen, int n_patterns);
void ffp_field_scene_free(FfpFieldScene *scene);

typedef struct FfpChunkRay {
    FfpFieldRay ray;
    int view, pixel;
    int64_t first; // point
    int count;
    // Held for the step, as if they did not depend on the parameters:
    real opacity, depth, visibility; // depth: distance of the surface
    bool probed;
    real normal[3]; // of the density, at the surface
} FfpChunkRay;

typedef struct FfpChunkLoss {
    double pictures, mask, visibility, facing, match; // sums over rays, weighted
    double square;                                    // sum of squared errors of the pictures
    int64_t numbers;                                  // that it is the sum of
} FfpChunkLoss;

typedef struct FfpFieldChunk {
    int n_rays;
    int64_t points, looks;
    FfpChunkRay *rays;
    real *distance;                                 // [POINTS]
    real *held;                                     // [POINTS] weights W, held
    real *position, *encoded, *geometry, *material; // rows: what the networks see and say of the points
    real *hidden[3];                                // geometry's, material's two
    real *d_encoded, *d_geometry, *d_material, *scratch[2];
    real *look_position, *look_encoded, *look, *look_target, *d_look, *d_look_encoded; // rows, visibility
    real *look_hidden[2];
    real *gradient; // of the networks' numbers: [layout.count - layout.grid]
    FfpChunkLoss loss;
} FfpFieldChunk;
FfpFieldChunk ffp_field_chunk_new(const FfpFieldLayout *layout);
void ffp_field_chunk_free(FfpFieldChunk *chunk);

// Draws up to `rays` rays and marches along them.
void ffp_field_chunk_draw(FfpFieldChunk *chunk, const FfpNeuralField *field, const FfpFieldScene *scene,
                          int rays, FfpRng *rng);
void ffp_field_chunk_place(FfpFieldChunk *chunk, const FfpChunkRay *ray); // positions, from the distances
// To draw and not to fit: runs all networks for points that are placed, with a projector at `lamp`: weights
// (held), surfaces, visibilities.
void ffp_field_chunk_see(FfpFieldChunk *chunk, const FfpNeuralField *field, const real lamp[3]);
// Runs geometry and material, and the visibility network where there are looks.
void ffp_field_chunk_forward(FfpFieldChunk *chunk, const FfpNeuralField *field);
// Values held for the step: weights, surfaces, visibilities and what they ought to be, the density's normals.
void ffp_field_chunk_hold(FfpFieldChunk *chunk, const FfpNeuralField *field, const FfpFieldScene *scene,
                          FfpRng *rng);
// The loss, each ray's part times `per_ray`, and its gradient in d_geometry, d_material and d_look. Patterns
// from `n_patterns` on do not count.
void ffp_field_chunk_loss(FfpFieldChunk *chunk, const FfpNeuralField *field, const FfpFieldScene *scene,
                          const FfpFieldSettings *settings, int n_patterns, real per_ray);
// On to the networks' numbers (chunk->gradient) and to the encodings.
void ffp_field_chunk_backward(FfpFieldChunk *chunk, const FfpNeuralField *field);

#endif
