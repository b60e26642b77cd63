// Which number means what, and what the numbers are at the start.
#include <tgmath.h>
#include "core/base/alloc.h"
#include "core/base/rng.h"
#include "lab/baselines/field.h"

#define COARSEST 16 // cells a side of the first level
#define GROWTH 1.7  // from level to level: the sixth has 227, two for a pixel of 128 x 128
#define FIRST_STEP (1.0F / 64)
#define FIRST_DENSITY 8.0F // of all space: a sixth of the light stays in it at every step

static FfpFieldNet net_of(const int *widths, int layers, int64_t *next) {
    FfpFieldNet net = {.count = layers};
    for (int i = 0; i < layers; i++) {
        FfpFieldLayer *layer = &net.layers[i];
        *layer = (FfpFieldLayer){.inputs = widths[i], .outputs = widths[i + 1], .relu = i + 1 < layers};
        layer->weights = *next;
        *next += (int64_t)layer->inputs * layer->outputs;
        layer->biases = *next;
        *next += layer->outputs;
    }
    return net;
}

FfpFieldLayout ffp_field_layout(void) {
    FfpFieldLayout layout = {0};
    double resolution = COARSEST;
    for (int l = 0; l < FFP_FIELD_LEVELS; l++) {
        FfpGridLevel *level = &layout.levels[l];
        const int64_t side = (int64_t)(resolution + 0.5) + 1, points = side * side * side;
        level->resolution = (int)side - 1;
        level->dense = points <= FFP_FIELD_TABLE;
        level->entries = level->dense ? points : FFP_FIELD_TABLE;
        level->first = layout.grid;
        layout.grid += level->entries * FFP_FIELD_FEATURES;
        resolution *= GROWTH;
    }
    const int wide = FFP_FIELD_WIDTH;
    int64_t next = layout.grid;
    layout.geometry = net_of((const int[]){FFP_FIELD_ENCODED, wide, FFP_GEOMETRY_OUTPUTS}, 2, &next);
    layout.material = net_of((const int[]){FFP_FIELD_ENCODED, wide, wide, FFP_MATERIAL_OUTPUTS}, 3, &next);
    layout.visibility =
        net_of((const int[]){FFP_FIELD_ENCODED + FFP_FIELD_DIRECTION, wide, wide, 1}, 3, &next);
    layout.count = next;
    return layout;
}

// Evenly within +- sqrt(6 / inputs) in front of a ReLU (He et al. 2015), half of it in the last layer.
static void start_net(real *parameters, const FfpFieldNet *net, FfpRng *rng) {
    for (int i = 0; i < net->count; i++) {
        const FfpFieldLayer *layer = &net->layers[i];
        const float reach = sqrtf(6.0F / (float)layer->inputs) * (layer->relu ? 1 : 0.5F);
        for (int64_t k = 0; k < (int64_t)layer->inputs * layer->outputs; k++)
            parameters[layer->weights + k] = ffp_rng_range(rng, -reach, reach);
    }
}

static real *last_biases(real *parameters, const FfpFieldNet *net) {
    return parameters + net->layers[net->count - 1].biases;
}

FfpNeuralField ffp_neural_field_new(uint64_t seed) {
    FfpNeuralField field = {.layout = ffp_field_layout(), .step = FIRST_STEP, .radius = 1};
    const FfpFieldLayout *layout = &field.layout;
    const size_t cells = (size_t)FFP_FIELD_CELLS * FFP_FIELD_CELLS * FFP_FIELD_CELLS;
    FfpRng rng = ffp_rng(seed, 11);
    real *p = field.parameters = ffp_alloc((size_t)layout->count, sizeof(real));
    field.density = ffp_alloc(cells, sizeof(real));
    for (int64_t i = 0; i < layout->grid; i++) p[i] = ffp_rng_range(&rng, -1e-2F, 1e-2F);
    start_net(p, &layout->geometry, &rng);
    start_net(p, &layout->material, &rng);
    start_net(p, &layout->visibility, &rng);
    last_biases(p, &layout->geometry)[FFP_GEOMETRY_DENSITY] = log(FIRST_DENSITY);
    for (int k = 0; k < 3; k++) last_biases(p, &layout->material)[FFP_MATERIAL_AMBIENT + k] = -1.5F;
    last_biases(p, &layout->visibility)[0] = 2;
    for (size_t i = 0; i < cells; i++) field.density[i] = FIRST_DENSITY;
    return field;
}

void ffp_neural_field_free(FfpNeuralField *field) {
    ffp_free(field->parameters);
    ffp_free(field->density);
    *field = (FfpNeuralField){0};
}
