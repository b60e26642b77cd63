// Tensors, and the model that they may be.
#include <stdlib.h>
#include "core/tensor/safetensors.h"
#include "engine/network/network.h"
#include "fuzz.h"

static void convert(const FfpSafetensors *file) {
    for (int i = 0; i < file->count; i++) {
        real *values = malloc(((size_t)file->tensors[i].count + 1) * sizeof *values);
        if (values) ffp_tensor_to_real(&file->tensors[i], values);
        free(values);
    }
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
    const char *path = fuzz_file(data, size);
    FfpSafetensors file;
    FfpError err = {0};
    const bool ok = ffp_safetensors_read(&file, path, &err);
    fuzz_verdict(ok, &err);
    if (!ok) return 0;
    convert(&file);
    ffp_safetensors_free(&file);
    FfpModel *model = ffp_model_read(path, &err);
    fuzz_verdict(model != NULL, &err);
    ffp_model_free(model);
    return 0;
}
