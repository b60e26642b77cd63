#include "lab/baselines/numbers.h"
#include <math.h>

static bool check_numbers(const real *numbers, int64_t count, real least, const char *path, const char *name,
                          FfpError *err) {
    for (int64_t i = 0; i < count; i++)
        if (!isfinite(numbers[i]) || !(numbers[i] >= least))
            return ffp_fail(err, FFP_ERROR_FILE, ffp_place(path, name).text, "number %lld is out of range",
                            (long long)i);
    return true;
}

bool ffp_read_field_numbers(const FfpSafetensors *file, const char *path, const char *name, int64_t count,
                            real least, real *out, FfpError *err) {
    const FfpTensor *tensor = ffp_safetensors_find(file, name);
    if (!tensor) return ffp_fail(err, FFP_ERROR_FILE, ffp_place(path, name).text, "is missing");
    if (tensor->count != count)
        return ffp_fail(err, FFP_ERROR_FILE, ffp_place(path, name).text, "has %lld numbers instead of %lld",
                        (long long)tensor->count, (long long)count);
    if (!ffp_tensor_to_real(tensor, out))
        return ffp_fail(err, FFP_ERROR_FILE, ffp_place(path, name).text, "does not hold real numbers");
    return check_numbers(out, count, least, path, name, err);
}
