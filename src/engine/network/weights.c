// The weights file: safetensors, the configuration as strings in its metadata
// (docs/reference/formats/weights.md).
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <tgmath.h>
#include "core/base/file.h"
#include "core/base/kind.h"
#include "core/tensor/safetensors.h"
#include "engine/network/layout.h"

#define FORMAT "ffprocams-model"
#define VERSION "1"
#define RESERVED "model." // of the configuration's keys

enum { TEXT, WHOLE, SWITCH };
typedef struct Field {
    const char *key;
    int kind;
    size_t offset, size;
    const char *absent; // what older files mean, which lack it; NULL: none does
} Field;

#define FIELD(name, kind, absent)                                                                            \
    { RESERVED #name, kind, offsetof(FfpModelConfig, name), sizeof(((FfpModelConfig *)0)->name), absent }
static const Field fields[] = {
    FIELD(name, TEXT, NULL),
    FIELD(modules, TEXT, NULL),
    FIELD(dim, WHOLE, NULL),
    FIELD(patch, WHOLE, NULL),
    FIELD(state, WHOLE, NULL),
    FIELD(chunk, WHOLE, NULL),
    FIELD(residual, SWITCH, NULL),
    FIELD(match_input, SWITCH, NULL),
    FIELD(pixel_skip, SWITCH, NULL),
    FIELD(pixel_features, WHOLE, NULL),
    FIELD(pixel_hidden, WHOLE, NULL),
    FIELD(render, TEXT, NULL),
    FIELD(tokens, WHOLE, "4096"),
    FIELD(samples, WHOLE, "1"),
    FIELD(context_inputs, SWITCH, "false"),
    FIELD(appearance_cnn, SWITCH, "false"),
    FIELD(looks, WHOLE, "0"),
    FIELD(look_hidden, WHOLE, "0"),
};
enum { FIELDS = sizeof fields / sizeof *fields, OWN_KEYS = FIELDS + 2 };

static bool is_reserved(const char *key) {
    return strcmp(key, "format") == 0 || strcmp(key, "format_version") == 0 ||
           strncmp(key, RESERVED, strlen(RESERVED)) == 0;
}

static void print_field(char out[FFP_MODULES_MAX], const FfpModelConfig *config, const Field *field) {
    const char *at = (const char *)config + field->offset;
    if (field->kind == TEXT)
        snprintf(out, FFP_MODULES_MAX, "%s", at);
    else if (field->kind == WHOLE)
        snprintf(out, FFP_MODULES_MAX, "%d", *(const int *)at);
    else
        snprintf(out, FFP_MODULES_MAX, "%s", *(const bool *)at ? "true" : "false");
}

static bool read_field(FfpModelConfig *config, const Field *field, const char *text, const char *where,
                       FfpError *err) {
    char *at = (char *)config + field->offset;
    if (!text) text = field->absent;
    if (!text) return ffp_fail(err, FFP_ERROR_FILE, where, "the model file's metadata lacks this key");
    if (field->kind == TEXT) {
        if (strlen(text) >= field->size)
            return ffp_fail(err, FFP_ERROR_FILE, where, "longer than %zu bytes", field->size - 1);
        snprintf(at, field->size, "%s", text);
        return true;
    }
    if (field->kind == SWITCH) {
        *(bool *)at = strcmp(text, "true") == 0;
        return *(bool *)at || strcmp(text, "false") == 0 ||
               ffp_fail(err, FFP_ERROR_FILE, where, "neither true nor false");
    }
    char *end;
    const long value = strtol(text, &end, 10);
    if (end == text || *end || value < 0 || value > 1000000)
        return ffp_fail(err, FFP_ERROR_FILE, where, "not a whole number in range");
    *(int *)at = (int)value;
    return true;
}

// Matrices as bf16 unless exact; vectors (gains, biases, Mamba2's rates) are few and sensitive: always F32.
static void fill_tensors(FfpTensor *tensors, char *bytes, const FfpModel *model, bool exact) {
    for (int i = 0; i < model->n_parameters; i++) {
        const FfpParameter *p = &model->parameters[i];
        const real *values = model->values + p->offset;
        FfpTensor *t = &tensors[i];
        snprintf(t->name, sizeof t->name, "%s", p->name);
        t->dtype = exact || p->rank == 1 ? FFP_F32 : FFP_BF16;
        t->rank = p->rank;
        memcpy(t->shape, p->shape, sizeof p->shape);
        t->count = p->count;
        t->data = bytes + p->offset * 4;
        for (int64_t k = 0; k < p->count; k++) {
            if (t->dtype == FFP_F32)
                ((float *)t->data)[k] = (float)values[k];
            else
                ((uint16_t *)t->data)[k] = ffp_bf16_from_float((float)values[k]);
        }
    }
}

bool ffp_model_write(const FfpModel *model, const char *path, bool exact, const char *const *metadata,
                     int metadata_count, FfpError *err) {
    for (int i = 0; i < 2 * metadata_count; i += 2)
        if (is_reserved(metadata[i]))
            return ffp_fail(err, FFP_ERROR_FILE, ffp_place(path, metadata[i]).text,
                            "this metadata key is reserved");
    char text[FIELDS][FFP_MODULES_MAX];
    const char **strings = ffp_alloc(2 * (OWN_KEYS + (size_t)metadata_count), sizeof *strings);
    int count = 0;
    strings[count++] = "format";
    strings[count++] = FORMAT;
    strings[count++] = "format_version";
    strings[count++] = VERSION;
    for (int i = 0; i < FIELDS; i++) {
        print_field(text[i], &model->config, &fields[i]);
        strings[count++] = fields[i].key;
        strings[count++] = text[i];
    }
    for (int i = 0; i < 2 * metadata_count; i++) strings[count++] = metadata[i];
    FfpTensor *tensors = ffp_alloc((size_t)model->n_parameters, sizeof *tensors);
    char *bytes = ffp_alloc((size_t)model->count, 4);
    fill_tensors(tensors, bytes, model, exact);
    const bool ok = ffp_safetensors_write(path, tensors, model->n_parameters, strings, count / 2, err);
    ffp_free(bytes);
    ffp_free(tensors);
    ffp_free(strings);
    return ok;
}

static bool read_config(FfpModelConfig *config, const FfpSafetensors *file, const char *path, FfpError *err) {
    const char *format = ffp_safetensors_metadata(file, "format");
    const char *version = ffp_safetensors_metadata(file, "format_version");
    if (!format || strcmp(format, FORMAT) != 0)
        return ffp_fail(err, FFP_ERROR_FILE, ffp_place(path, "format").text, "not a model file");
    if (!version || strcmp(version, VERSION) != 0)
        return ffp_fail(err, FFP_ERROR_FILE, ffp_place(path, "format_version").text,
                        "this program reads version " VERSION ", not %.16s", version ? version : "none");
    *config = (FfpModelConfig){0};
    for (int i = 0; i < FIELDS; i++)
        if (!read_field(config, &fields[i], ffp_safetensors_metadata(file, fields[i].key),
                        ffp_place(path, fields[i].key).text, err))
            return false;
    return true;
}

// Names and shapes, before memory is taken for what a configuration merely claims.
static bool check_parameter(const FfpParameter *p, const FfpSafetensors *file, const char *path,
                            FfpError *err) {
    const FfpPlace where = ffp_place(path, p->name);
    const FfpTensor *t = ffp_safetensors_find(file, p->name);
    if (!t)
        return ffp_fail(err, FFP_ERROR_FILE, where.text,
                        "a tensor that the configuration requires is missing");
    if (t->rank != p->rank || memcmp(t->shape, p->shape, (size_t)p->rank * sizeof *p->shape) != 0)
        return ffp_fail(err, FFP_ERROR_FILE, where.text, "the configuration requires shape %lld x %lld",
                        (long long)p->shape[0], (long long)(p->rank == 2 ? p->shape[1] : 1));
    return true;
}

static bool check_known(const FfpModel *model, const char *name, const char *path, FfpError *err) {
    for (int k = 0; k < model->n_parameters; k++)
        if (strcmp(model->parameters[k].name, name) == 0) return true;
    return ffp_fail(err, FFP_ERROR_FILE, ffp_place(path, name).text,
                    "a tensor that the configuration does not have");
}

enum { FINITE = -1, WHOLE_NUMBERS = -2 };

// Fills in a parameter; returns the index of its first value that is not finite, or one of the above.
static int64_t fill_parameter(const FfpModel *model, const FfpParameter *p, const FfpSafetensors *file) {
    real *values = model->values + p->offset;
    if (!ffp_tensor_to_real(ffp_safetensors_find(file, p->name), values)) return WHOLE_NUMBERS;
    for (int64_t i = 0; i < p->count; i++)
        if (!isfinite(values[i])) return i;
    return FINITE;
}

static bool read_parameters(FfpModel *model, const FfpSafetensors *file, const char *path, FfpError *err) {
    const int n = model->n_parameters;
    int64_t *bad = ffp_take((size_t)n, sizeof *bad);
    bool ok = true;
    model->values = ffp_take((size_t)model->count, sizeof *model->values);
#pragma omp parallel for schedule(dynamic)
    for (int i = 0; i < n; i++) bad[i] = fill_parameter(model, &model->parameters[i], file);
    for (int i = 0; ok && i < n; i++) {
        const FfpPlace where = ffp_place(path, model->parameters[i].name);
        if (bad[i] == WHOLE_NUMBERS)
            ok = ffp_fail(err, FFP_ERROR_FILE, where.text, "integers instead of real numbers");
        else if (bad[i] != FINITE)
            ok = ffp_fail(err, FFP_ERROR_FILE, where.text, "value %lld is not finite", (long long)bad[i]);
    }
    ffp_free(bad);
    return ok;
}

static void keep_metadata(FfpModel *model, const FfpSafetensors *file) {
    model->metadata = ffp_alloc(2 * (size_t)file->metadata_count + 1, sizeof *model->metadata);
    for (int i = 0; i < file->metadata_count; i++) {
        if (is_reserved(file->metadata[2 * i])) continue;
        char **pair = model->metadata + 2 * model->metadata_count++;
        for (int k = 0; k < 2; k++) pair[k] = ffp_copy_text(file->metadata[2 * i + k]);
    }
}

static FfpModel *read_model(const FfpSafetensors *file, const char *path, FfpError *err) {
    FfpModelConfig config;
    if (!read_config(&config, file, path, err)) return NULL;
    FfpModel *model = ffp_model_table(&config, path, err);
    if (!model) return NULL;
    bool ok = true;
    for (int i = 0; ok && i < model->n_parameters; i++)
        ok = check_parameter(&model->parameters[i], file, path, err);
    for (int i = 0; ok && i < file->count; i++) ok = check_known(model, file->tensors[i].name, path, err);
    ok = ok && read_parameters(model, file, path, err);
    if (ok) keep_metadata(model, file);
    if (ok) return model;
    ffp_model_free(model);
    return NULL;
}

FfpModel *ffp_model_read(const char *path, FfpError *err) {
    FfpSafetensors file;
    if (!ffp_check_kind(path, FFP_WANTED_WEIGHTS, err) || !ffp_safetensors_read(&file, path, err))
        return NULL;
    FfpModel *model = read_model(&file, path, err);
    ffp_safetensors_free(&file);
    return model;
}
