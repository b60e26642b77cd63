// Counter-seeded random numbers: the same (seed, stream) gives the same numbers on every machine.
#ifndef FFP_BASE_RNG_H
#define FFP_BASE_RNG_H

#include <stdint.h>

typedef struct FfpRng {
    uint64_t state, increment; // PCG32 (O'Neill 2014)
} FfpRng;

FfpRng ffp_rng(uint64_t seed, uint64_t stream);
uint32_t ffp_rng_u32(FfpRng *rng);
uint32_t ffp_rng_below(FfpRng *rng, uint32_t bound); // uniform in [0, bound), bound > 0, no modulo bias
float ffp_rng_uniform(FfpRng *rng);                  // [0, 1)
float ffp_rng_range(FfpRng *rng, float low, float high);
float ffp_rng_normal(FfpRng *rng); // mean 0, deviation 1

#endif
