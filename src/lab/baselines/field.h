// A neural reflectance field fitted to one object's photographs, the form of Nepmap (Erel et al. 2023):
// density, normal, albedo, roughness and ambient colour of every point of space by small networks, drawn by
// integrating along the camera's rays (Mildenhall et al. 2020) with the projector as a light whose pixels are
// looked up, and a network that has learned how much of a projector's light reaches a point. The networks see
// points through a multiresolution hash grid (Mueller et al. 2022) instead of Nepmap's sines.
// Everything in the unit sphere of a normalised capture, on the CPU.
#ifndef FFP_FIELD_FIELD_H
#define FFP_FIELD_FIELD_H

#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>
#include "core/base/real.h"
#include "core/capture/capture.h"
#include "core/image/lookup.h"
#include "engine/render/render.h"

enum {
    FFP_FIELD_LEVELS = 6,
    FFP_FIELD_FEATURES = 4, // of a grid point
    FFP_FIELD_ENCODED = FFP_FIELD_LEVELS * FFP_FIELD_FEATURES,
    FFP_FIELD_TABLE = 1 << 16, // grid points that a level stores at the most
    FFP_FIELD_WIDTH = 32,      // of hidden layers
    FFP_FIELD_LAYERS = 3,      // of a network, at the most
    FFP_FIELD_DIRECTION = 15,  // what the visibility network sees of a direction
    FFP_FIELD_CELLS = 128,     // of the density's grid, a side
};

// The networks' outputs, before sigmoid and the like (light.h).
enum { FFP_GEOMETRY_DENSITY, FFP_GEOMETRY_NORMAL, FFP_GEOMETRY_OUTPUTS = 4 };
enum { FFP_MATERIAL_ALBEDO, FFP_MATERIAL_ROUGHNESS = 3, FFP_MATERIAL_AMBIENT = 4, FFP_MATERIAL_OUTPUTS = 7 };

// Numbers of parameters are places in FfpNeuralField.parameters.
typedef struct FfpGridLevel {
    int resolution; // cells a side over [-1,1]
    bool dense;     // every grid point has an entry; otherwise entries are shared by a hash
    int64_t first;  // number of the first entry, of FFP_FIELD_FEATURES each
    int64_t entries;
} FfpGridLevel;

typedef struct FfpFieldLayer {
    int inputs, outputs;
    bool relu;
    int64_t weights, biases; // [outputs,inputs], [outputs]
} FfpFieldLayer;

typedef struct FfpFieldNet {
    int count;
    FfpFieldLayer layers[FFP_FIELD_LAYERS];
} FfpFieldNet;

typedef struct FfpFieldLayout {
    FfpGridLevel levels[FFP_FIELD_LEVELS];
    FfpFieldNet geometry, material, visibility;
    int64_t grid, count; // numbers of the grid, which come first; of all
} FfpFieldLayout;

typedef struct FfpNeuralField FfpNeuralField;
struct FfpNeuralField {
    FfpFieldLayout layout;
    real *parameters;       // [layout.count]
    real *density;          // [CELLS,CELLS,CELLS] mean of each cell, z outermost; 0 outside the visual hull
    real step;              // of a ray
    real centre[3], radius; // of the capture, in world units: x of the field is centre + radius x
};

// Share of the cells of the cube around the unit sphere that hold anything.
double ffp_field_filled(const FfpNeuralField *field);

FfpFieldLayout ffp_field_layout(void);
// Random networks, and density everywhere.
FfpNeuralField ffp_neural_field_new(uint64_t seed);
void ffp_neural_field_free(FfpNeuralField *field);

typedef struct FfpFieldSettings {
    double grid_rate, net_rate; // of Adam, falling to `decay` of it over the budget, exponentially
    double decay;
    double black_share;    // of the budget, at its beginning, in which only the black pictures count
    int64_t samples;       // points of all rays in a step: as many rays are drawn as give about these
    real mask, visibility; // weights of the loss terms beside the pictures' (fit.c)
    real facing, match;
    int64_t steps;  // 0: no limit
    double seconds; // of wall clock; 0: no limit
    uint64_t seed;
    bool may_stop;            // when cancelled, the fit returns what it has so far
    FILE *metrics;            // a line of JSON now and then; NULL: none. Failing to write one ends the fit
    bool quiet;               // reports no progress
    const FfpCapture *source; // what the capture is of, as it was before it was normalised and its noise,
    double noise;             // of this setting, taken away; tells whose a checkpoint is. NULL: the capture
    const char *checkpoint; // file that is written every two minutes and at the end, and from which the same
                            // fit goes on, to the same bits; NULL: none
} FfpFieldSettings;
FfpFieldSettings ffp_field_defaults(void);

typedef struct FfpFieldResult {
    int64_t steps;
    double seconds;
    double psnr; // dB on pictures fitted, mean over up to FFP_FIELD_MEASURED views; without 8-bit rounding
    bool stopped;
} FfpFieldResult;
enum { FFP_FIELD_MEASURED = 16 };

// Fits a field to the given patterns (indices into the capture's; a view lacks none of them) of all views of
// a normalised capture, and puts it where that of the settings' source is. With a limit in steps alone the
// same seed gives the same bits, whatever the number of threads. Errors: a missing picture or limit,
// silhouettes without room for an object, a loss that is not finite, a device.
bool ffp_field_fit(FfpNeuralField *field, const FfpCapture *capture, const int *patterns, int n_patterns,
                   const FfpFieldSettings *settings, FfpFieldResult *result, FfpError *err);

// A view of the field, drawn once for any number of patterns. Camera, projector, intensity and depth are in
// world units.
typedef struct FfpFieldPass FfpFieldPass;
FfpFieldPass *ffp_field_pass_new(void);
void ffp_field_pass_free(FfpFieldPass *pass);
void ffp_field_pass_draw(FfpFieldPass *pass, const FfpNeuralField *field, const FfpCamera *camera,
                         const FfpCamera *projector, const real intensity[3]);
// The picture under a pattern (NULL: black): sRGB-encoded RGB of the camera's size, the caller's to free.
FfpImage ffp_field_pass_shade(const FfpFieldPass *pass, const FfpSummed *pattern);
// Sums along the rays as the rasteriser has them, valid until the next view; distortion is 0.
const FfpGbuffer *ffp_field_pass_gbuffer(const FfpFieldPass *pass);

// A field as a file of safetensors.
bool ffp_neural_field_write(const FfpNeuralField *field, const char *path, FfpError *err);
bool ffp_neural_field_read(FfpNeuralField *field, const char *path, FfpError *err);

#endif
