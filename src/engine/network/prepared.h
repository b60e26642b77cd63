// All inputs that the network takes from a capture, as arrays: made once by the CPU and copied to a device
// for any number of passes. A pass on the CPU needs none of this: it computes inputs where they are needed.
#ifndef FFP_NETWORK_PREPARED_H
#define FFP_NETWORK_PREPARED_H

#include "engine/network/context.h"
#include "engine/network/table.h"

struct FfpPrepared {
    int tokens, across, down; // of the context; across and down a view
    int64_t count;            // Gaussians
    int64_t *pixel;           // [count] the host's: their pixels in the capture
    size_t inputs_count;      // numbers of inputs
    int channels;             // of own
    int n_used;               // tokens that a Gaussian needs
    bool has_context_inputs;  // `context_inputs` exists
    // The CPU's as it was made, the device's in a copy that was brought there:
    real *inputs;         // [tokens, patch^2, channels]
    FfpPixelBase *base;   // [count]
    int32_t *used;        // [n_used]
    FfpTapTable taps;     // into a map of n_used * patch^2 rows
    real *own;            // [count, channels]; NULL without pixel_skip
    real *context_inputs; // [count, context channels]; NULL where there is nothing to tell
    // With looks:
    FfpLookPhotographs *photographs;
    FfpModelConfig config;
    int64_t *pixel_there; // [count] `pixel` where the arrays above are
};

// For a network that runs elsewhere, on the CPU: out [count, FFP_LOOK_SEEN + numbers], what the Gaussians of
// raw [count, numbers] see at a look. Errors: a number is not finite, or no looks are in the configuration.
bool ffp_prepared_seen(const FfpPrepared *prepared, const real *raw, real *out, FfpError *err);

#endif
