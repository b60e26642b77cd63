// Safetensors files (an 8-byte length, a JSON header, raw little-endian data), with a metadata block of
// strings.
#ifndef FFP_TENSOR_SAFETENSORS_H
#define FFP_TENSOR_SAFETENSORS_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include "core/base/error.h"
#include "core/base/real.h"

#define FFP_TENSOR_NAME_MAX 128

typedef enum FfpDtype { FFP_F32, FFP_BF16, FFP_F16, FFP_F64, FFP_I64, FFP_U8 } FfpDtype;

typedef struct FfpTensor {
    char name[FFP_TENSOR_NAME_MAX];
    FfpDtype dtype;
    int rank; // at most 8
    int64_t shape[8];
    int64_t count;    // product of the shape
    const void *data; // count elements of dtype, unaligned in a file: use memcpy or ffp_tensor_to_real
} FfpTensor;

// A file read whole. Every offset, size, shape and name is checked against the file before use; overlapping
// or out-of-range data, overflowing products and duplicate names are errors that name file and tensor.
typedef struct FfpSafetensors {
    int count;
    FfpTensor *tensors;
    int metadata_count; // pairs
    char **metadata;    // key, value, key, value, ...
    char *bytes;        // owned
} FfpSafetensors;

bool ffp_safetensors_read(FfpSafetensors *file, const char *path, FfpError *err);
void ffp_safetensors_free(FfpSafetensors *file);
const FfpTensor *ffp_safetensors_find(const FfpSafetensors *file, const char *name); // NULL when absent
const char *ffp_safetensors_metadata(const FfpSafetensors *file, const char *key);   // NULL when absent
// Converts F32, BF16, F16 or F64 data to real; false when the dtype is an integer.
bool ffp_tensor_to_real(const FfpTensor *tensor, real *out);

// Writing, metadata_count pairs of metadata (NULL when 0): tensors with F32, F64, I64, U8 or BF16 data as
// given (BF16 data are uint16_t); atomic.
bool ffp_safetensors_write(const char *path, const FfpTensor *tensors, int count, const char *const *metadata,
                           int metadata_count, FfpError *err);
uint16_t ffp_bf16_from_float(float value); // round to nearest even; NaN stays NaN
float ffp_bf16_to_float(uint16_t value);

#endif
