#include "core/base/rng.h"
#include <math.h>

FfpRng ffp_rng(uint64_t seed, uint64_t stream) {
    FfpRng rng = {0, (stream << 1) | 1U};
    ffp_rng_u32(&rng);
    rng.state += seed;
    ffp_rng_u32(&rng);
    return rng;
}

// PCG-XSH-RR 64/32: an LCG step, output from the old state (O'Neill 2014, section 6.3).
uint32_t ffp_rng_u32(FfpRng *rng) {
    const uint64_t old = rng->state;
    rng->state = old * 6364136223846793005ULL + rng->increment;
    const uint32_t shifted = (uint32_t)(((old >> 18) ^ old) >> 27);
    const uint32_t turn = (uint32_t)(old >> 59);
    return (shifted >> turn) | (shifted << ((32 - turn) & 31));
}

uint32_t ffp_rng_below(FfpRng *rng, uint32_t bound) {
    // Draws below 2^32 mod bound are thrown away, so that every remainder is equally likely.
    const uint32_t threshold = (0U - bound) % bound;
    uint32_t draw = ffp_rng_u32(rng);
    while (draw < threshold) draw = ffp_rng_u32(rng);
    return draw % bound;
}

float ffp_rng_uniform(FfpRng *rng) {
    return (float)(ffp_rng_u32(rng) >> 8) * 0x1p-24F;
}

float ffp_rng_range(FfpRng *rng, float low, float high) {
    return low + (high - low) * ffp_rng_uniform(rng);
}

float ffp_rng_normal(FfpRng *rng) {
    // Box-Muller; one of the pair is dropped to keep the generator's state to its two words.
    const double radius = sqrt(-2.0 * log((ffp_rng_u32(rng) + 1.0) * 0x1p-32));
    const double angle = 6.283185307179586 * ffp_rng_u32(rng) * 0x1p-32;
    return (float)(radius * cos(angle));
}
