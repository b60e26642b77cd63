// Where the shipped weights are.
#ifndef FFP_API_WEIGHTS_H
#define FFP_API_WEIGHTS_H

#include "base/error.h"
#include "base/file.h"

// Their path, by the rules of ffp_model_open; else an error that names all places looked at.
bool ffp_find_weights(char path[FFP_PATH_MAX], FfpError *err);

#endif
