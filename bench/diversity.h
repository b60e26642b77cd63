#ifndef FFP_BENCH_DIVERSITY_H
#define FFP_BENCH_DIVERSITY_H

#include <stdbool.h>
#include "core/base/error.h"

// Prints how different the meshes and the materials are, as Markdown tables, to the standard output.
bool ffp_print_diversity(FfpError *err);

#endif
