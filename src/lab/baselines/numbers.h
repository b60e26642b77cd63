// Inside the field's room: a list of numbers of a file.
#ifndef FFP_FIELD_NUMBERS_H
#define FFP_FIELD_NUMBERS_H

#include "core/base/real.h"
#include "core/tensor/safetensors.h"

// Exactly `count` finite numbers of at least `least`, whatever their shape. Errors name file and tensor.
bool ffp_read_field_numbers(const FfpSafetensors *file, const char *path, const char *name, int64_t count,
                            real least, real *out, FfpError *err);

#endif
