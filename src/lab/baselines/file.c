// A field on disk: its numbers, the cells' densities, and "place": step, centre and radius.
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include "core/base/alloc.h"
#include "core/base/kind.h"
#include "core/tensor/safetensors.h"
#include "lab/baselines/field.h"
#include "lab/baselines/numbers.h"

#define FORMAT "ffprocams neural field 1"

enum { PLACES = 5, CELLS = FFP_FIELD_CELLS * FFP_FIELD_CELLS * FFP_FIELD_CELLS };

bool ffp_neural_field_write(const FfpNeuralField *field, const char *path, FfpError *err) {
    const int64_t count = field->layout.count;
    float *numbers = ffp_alloc((size_t)count, sizeof *numbers);
    uint16_t *density = ffp_alloc(CELLS, sizeof *density);
    const float place[PLACES] = {(float)field->step, (float)field->centre[0], (float)field->centre[1],
                                 (float)field->centre[2], (float)field->radius};
    for (int64_t i = 0; i < count; i++) numbers[i] = (float)field->parameters[i];
    for (int i = 0; i < CELLS; i++) density[i] = ffp_bf16_from_float((float)field->density[i]);
    const FfpTensor tensors[] = {
        {"parameters", FFP_F32, 1, {count}, count, numbers},
        {"density", FFP_BF16, 3, {FFP_FIELD_CELLS, FFP_FIELD_CELLS, FFP_FIELD_CELLS}, CELLS, density},
        {"place", FFP_F32, 1, {PLACES}, PLACES, place},
    };
    const char *const metadata[] = {"format", FORMAT};
    const bool ok = ffp_safetensors_write(path, tensors, 3, metadata, 1, err);
    ffp_free(numbers);
    ffp_free(density);
    return ok;
}

static bool read_all(FfpNeuralField *field, const FfpSafetensors *file, const char *path, FfpError *err) {
    const char *format = ffp_safetensors_metadata(file, "format");
    real place[PLACES];
    if (!format || strcmp(format, FORMAT) != 0)
        return ffp_fail(err, FFP_ERROR_FILE, path, "is not a neural field");
    if (!ffp_read_field_numbers(file, path, "parameters", field->layout.count, -INFINITY, field->parameters,
                                err) ||
        !ffp_read_field_numbers(file, path, "density", CELLS, 0, field->density, err) ||
        !ffp_read_field_numbers(file, path, "place", PLACES, -INFINITY, place, err))
        return false;
    if (!(place[0] >= 1e-3F && place[0] <= 1) || !(place[4] > 0))
        return ffp_fail(err, FFP_ERROR_FILE, ffp_place(path, "place").text,
                        "the step is not in 0.001..1, or the radius not positive");
    field->step = place[0];
    field->radius = place[4];
    memcpy(field->centre, place + 1, sizeof field->centre);
    return true;
}

double ffp_field_filled(const FfpNeuralField *field) {
    int filled = 0;
    for (int i = 0; i < CELLS; i++) filled += field->density[i] > 0;
    return (double)filled / CELLS;
}

bool ffp_neural_field_read(FfpNeuralField *field, const char *path, FfpError *err) {
    FfpSafetensors file;
    if (!ffp_check_kind(path, FFP_WANTED_FIELD, err) || !ffp_safetensors_read(&file, path, err)) return false;
    *field = ffp_neural_field_new(0);
    const bool ok = read_all(field, &file, path, err);
    ffp_safetensors_free(&file);
    if (!ok) ffp_neural_field_free(field);
    return ok;
}
