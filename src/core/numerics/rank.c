#include "core/numerics/rank.h"
#include <stdbool.h>

// By partition (Hoare 1961). NaNs do not lead it out of the array.
// NOLINTBEGIN(bugprone-macro-parentheses): a type cannot be in parentheses
#define RANKS_OF(type, types)                                                                                \
    type ffp_rank_of_##types(type *values, size_t n, size_t rank) {                                          \
        size_t low = 0, high = n - 1;                                                                        \
        while (low < high) {                                                                                 \
            const type pivot = values[low + (high - low) / 2];                                               \
            size_t i = low, j = high;                                                                        \
            while (true) {                                                                                   \
                while (values[i] < pivot) i++;                                                               \
                while (pivot < values[j]) j--;                                                               \
                if (i >= j) break;                                                                           \
                const type swapped = values[i];                                                              \
                values[i++] = values[j];                                                                     \
                values[j--] = swapped;                                                                       \
            }                                                                                                \
            if (rank <= j)                                                                                   \
                high = j;                                                                                    \
            else                                                                                             \
                low = j + 1;                                                                                 \
        }                                                                                                    \
        return values[rank];                                                                                 \
    }                                                                                                        \
    type ffp_median_of_##types(type *values, size_t n) {                                                     \
        return n > 0 ? ffp_rank_of_##types(values, n, n / 2) : 0;                                            \
    }                                                                                                        \
    type ffp_quantile_of_##types(type *values, size_t n, double share) {                                     \
        return n > 0 ? ffp_rank_of_##types(values, n, (size_t)(share * (double)(n - 1))) : 0;                \
    }
// NOLINTEND(bugprone-macro-parentheses)

RANKS_OF(float, floats)
RANKS_OF(double, doubles)
