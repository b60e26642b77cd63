// Inside the field's room: a fit on disk, from which it goes on to the bit.
#ifndef FFP_FIELD_CHECKPOINT_H
#define FFP_FIELD_CHECKPOINT_H

#include "lab/baselines/field.h"

typedef struct FfpFieldState {
    FfpNeuralField *field;
    real *mean, *square; // Adam's, [layout.count]
    int64_t step, next_cell;
    int rays;
    double seconds; // spent so far
} FfpFieldState;

// `fit` says what is fitted to what and how long: one that goes on has to say the same. Reading fills in what
// the state points to, and the field's step.
bool ffp_field_state_write(const FfpFieldState *state, const char *fit, const char *path, FfpError *err);
bool ffp_field_state_read(FfpFieldState *state, const char *fit, const char *path, FfpError *err);

#endif
