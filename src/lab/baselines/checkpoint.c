#include "lab/baselines/checkpoint.h"
#include <math.h>
#include <string.h>
#include "core/tensor/safetensors.h"
#include "lab/baselines/numbers.h"

#define FORMAT "ffprocams neural field checkpoint 2"

enum { NUMBERS = 5, CELLS = FFP_FIELD_CELLS * FFP_FIELD_CELLS * FFP_FIELD_CELLS };
#define STEP_LEAST 1e-3 // of a ray through the unit sphere
static const FfpDtype OWN = sizeof(real) == sizeof(double) ? FFP_F64 : FFP_F32;

bool ffp_field_state_write(const FfpFieldState *s, const char *fit, const char *path, FfpError *err) {
    const int64_t count = s->field->layout.count;
    const double numbers[NUMBERS] = {(double)s->step, (double)s->next_cell, s->rays, s->seconds,
                                     s->field->step};
    const FfpTensor tensors[] = {
        {"parameters", OWN, 1, {count}, count, s->field->parameters},
        {"mean", OWN, 1, {count}, count, s->mean},
        {"square", OWN, 1, {count}, count, s->square},
        {"density", OWN, 1, {CELLS}, CELLS, s->field->density},
        {"numbers", FFP_F64, 1, {NUMBERS}, NUMBERS, numbers},
    };
    const char *const metadata[] = {"format", FORMAT, "fit", fit};
    return ffp_safetensors_write(path, tensors, 5, metadata, 2, err);
}

static bool read_counts(FfpFieldState *s, const FfpSafetensors *file, const char *path, FfpError *err) {
    const FfpTensor *tensor = ffp_safetensors_find(file, "numbers");
    double numbers[NUMBERS];
    if (!tensor || tensor->dtype != FFP_F64 || tensor->count != NUMBERS)
        return ffp_fail(err, FFP_ERROR_FILE, ffp_place(path, "numbers").text, "is not a list of %d numbers",
                        NUMBERS);
    memcpy(numbers, tensor->data, sizeof numbers);
    for (int i = 0; i < NUMBERS; i++)
        if (!(numbers[i] >= 0 && numbers[i] <= 1e12))
            return ffp_fail(err, FFP_ERROR_FILE, ffp_place(path, "numbers").text, "number %d is out of range",
                            i);
    s->step = (int64_t)numbers[0];
    s->next_cell = (int64_t)numbers[1];
    s->rays = (int)fmin(fmax(numbers[2], 1), 1e6);
    s->seconds = numbers[3];
    s->field->step = (real)numbers[4];
    return (numbers[4] >= STEP_LEAST && numbers[4] <= 1) ||
           ffp_fail(err, FFP_ERROR_FILE, ffp_place(path, "numbers").text, "the step is out of range");
}

static bool read_all(FfpFieldState *s, const char *fit, const FfpSafetensors *file, const char *path,
                     FfpError *err) {
    const int64_t count = s->field->layout.count;
    const char *format = ffp_safetensors_metadata(file, "format"),
               *theirs = ffp_safetensors_metadata(file, "fit");
    if (!format || strcmp(format, FORMAT) != 0)
        return ffp_fail(err, FFP_ERROR_FILE, path,
                        "is not a checkpoint of a neural field, or comes from an older version");
    if (!theirs || strcmp(theirs, fit) != 0)
        return ffp_fail(err, FFP_ERROR_ARGUMENT, path, "belongs to another fit (%s) than this one (%s)",
                        theirs ? theirs : "it does not say which", fit);
    return ffp_read_field_numbers(file, path, "parameters", count, -INFINITY, s->field->parameters, err) &&
           ffp_read_field_numbers(file, path, "mean", count, -INFINITY, s->mean, err) &&
           ffp_read_field_numbers(file, path, "square", count, 0, s->square, err) &&
           ffp_read_field_numbers(file, path, "density", CELLS, 0, s->field->density, err) &&
           read_counts(s, file, path, err);
}

bool ffp_field_state_read(FfpFieldState *state, const char *fit, const char *path, FfpError *err) {
    FfpSafetensors file;
    if (!ffp_safetensors_read(&file, path, err)) return false;
    const bool ok = read_all(state, fit, &file, path, err);
    ffp_safetensors_free(&file);
    return ok;
}
