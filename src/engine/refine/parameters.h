// Gaussians as unconstrained parameters for an optimiser, and the inverse mapping: on the CPU, or on the
// device that the thread works on, except the gathering.
#ifndef FFP_REFINE_PARAMETERS_H
#define FFP_REFINE_PARAMETERS_H

#include <stdbool.h>
#include "core/gaussians/gaussians.h"

typedef struct FfpRates {      // of each attribute
    real rate[FFP_ATTRIBUTES]; // Adam's, in the parameters' units
    real pull[FFP_ATTRIBUTES]; // share of the rate by which a step goes back towards the start
    real shared_roughness;     // Adam's of the number that all roughness logits share; 0: there is none
} FfpRates;

// Numbers have the shape of Gaussians: centre = origin + unit * R(frame) number; scale = exp,
// at most `most` units; rotation = number / length; opacity, albedo, ambient = sigmoid; scattered =
// number^2, so that what is 0 stays 0; roughness = 0.05 +
// 0.95 sigmoid. Of a flat set the third deviation is a twentieth of the smaller of the others, and has no
// number of its own.
typedef struct FfpParameters {
    FfpGaussians numbers;
    real *origin, *frame, *unit; // [count,3], [count,4] unit quaternions, [count]
    bool flat;
    real most; // of a deviation, in units
} FfpParameters;

// Local: each centre is measured from where it is, along the splat's own axes, in its larger deviation's
// units, and no deviation grows to more than three times that one: what a single view sees does not say how
// long a splat is along its rays, and from elsewhere it would be a needle. Otherwise in world axes and units
// from zero, without bounds.
FfpParameters ffp_parameters_new(const FfpGaussians *gaussians, bool local, bool flat);
void ffp_parameters_free(FfpParameters *parameters);
void ffp_parameters_decode(const FfpParameters *parameters, FfpGaussians *out); // out has the same count
// The gradient to the Gaussians turned, in place, into the gradient to the numbers. `decoded` is what
// ffp_parameters_decode gave.
void ffp_parameters_pull_back(const FfpParameters *parameters, const FfpGaussians *decoded,
                              FfpGaussians *grad);
// The mean of the numbers over n steps, from that over the n - 1 before: share = 1 / n.
void ffp_parameters_average(const FfpParameters *parameters, real share, FfpGaussians *mean);

// A set with element i taken from from[i] of the given one, which is released.
void ffp_gaussians_gather(FfpGaussians *gaussians, const int64_t *from, int64_t count);
void ffp_parameters_gather(FfpParameters *parameters, const int64_t *from, int64_t count);

#endif
