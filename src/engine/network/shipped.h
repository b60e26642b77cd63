// Where the shipped weights are.
#ifndef FFP_NETWORK_SHIPPED_H
#define FFP_NETWORK_SHIPPED_H

#include "core/base/file.h"
#include "engine/network/network.h"

// Finds the shipped weights by the rules of ffp_model_open (ffprocams.h). Errors name all places searched.
bool ffp_find_weights(char path[FFP_PATH_MAX], FfpError *err);
// Weights from a file, which the model names; `path` NULL: the shipped ones.
FfpModel *ffp_model_load(const char *path, FfpError *err);

#endif
