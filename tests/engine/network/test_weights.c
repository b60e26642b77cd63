// Configurations, first values, and the weights file: what is written reads back; what does not fit is
// refused with file and tensor (or field) named.
#include <unistd.h>
#include "core/base/alloc.h"
#include "core/tensor/safetensors.h"
#include "scene.h"

#define FILE_NAME "test_weights.safetensors"

static void expect(const FfpError *err, const char *part) {
    if (strstr(err->text, part)) return;
    print_error("expected '%s' in '%s'\n", part, err->text);
    fail();
}

static FfpModelConfig tiny(void) {
    FfpModelConfig config;
    assert_true(ffp_model_preset(&config, "tiny"));
    strcpy(config.modules, "MT");
    config.dim = 64;
    config.state = 5;
    return config;
}

static FfpModel *new_tiny(void) {
    const FfpModelConfig config = tiny();
    FfpError err;
    FfpModel *model = ffp_model_new(&config, 3, &err);
    assert_non_null(model);
    return model;
}

static const FfpParameter *find(const FfpModel *model, const char *name) {
    for (int i = 0; i < model->n_parameters; i++)
        if (strcmp(model->parameters[i].name, name) == 0) return &model->parameters[i];
    print_error("no parameter %s\n", name);
    fail();
    return NULL;
}

static void test_presets(void **state) {
    (void)state;
    const char *names[] = {"tiny", "small", "paper-small", "paper"};
    FfpModelConfig config;
    FfpError err;
    for (int i = 0; i < 4; i++) {
        assert_true(ffp_model_preset(&config, names[i]));
        assert_string_equal(config.name, names[i]);
        assert_true(ffp_model_config_check(&config, NULL, &err));
        assert_int_equal(config.residual, i < 2);
    }
    assert_false(ffp_model_preset(&config, "huge"));
}

static void test_config_check(void **state) {
    (void)state;
    FfpError err;
    FfpModelConfig config = tiny();
    strcpy(config.modules, "MXT");
    assert_false(ffp_model_config_check(&config, "f.json", &err));
    expect(&err, "f.json: model.modules");
    config = tiny();
    config.modules[0] = 0;
    assert_false(ffp_model_config_check(&config, NULL, &err));
    expect(&err, "model.modules");
    memset(config.modules, 'M', sizeof config.modules); // no end
    assert_false(ffp_model_config_check(&config, NULL, &err));
    int *const numbers[] = {&config.dim,   &config.patch,          &config.state,
                            &config.chunk, &config.pixel_features, &config.pixel_hidden};
    const char *names[] = {"model.dim",   "model.patch",          "model.state",
                           "model.chunk", "model.pixel_features", "model.pixel_hidden"};
    const int bad[] = {-64, 0, 1000000};
    for (int i = 0; i < 6; i++)
        for (int k = 0; k < 3; k++) {
            config = tiny();
            *numbers[i] = bad[k];
            assert_false(ffp_model_config_check(&config, NULL, &err));
            expect(&err, names[i]);
        }
    config = tiny();
    config.dim = 65;
    assert_null(ffp_model_new(&config, 1, &err));
    config = tiny();
    strcpy(config.render, "theirs");
    assert_false(ffp_model_config_check(&config, NULL, &err));
    expect(&err, "model.render");
}

static double deviation(const FfpModel *model, const FfpParameter *p) {
    double sum = 0, square = 0;
    for (int64_t i = 0; i < p->count; i++) {
        const double x = (double)model->values[p->offset + i];
        sum += x;
        square += x * x;
    }
    assert_true(fabs(sum / (double)p->count) < 0.1 * sqrt(square / (double)p->count));
    return sqrt(square / (double)p->count);
}

// First values, number by number: deviations of the linear layers, ranges of the scan's parameters.
static void test_first_values(void **state) {
    (void)state;
    FfpModel *model = new_tiny(), *again = new_tiny();
    assert_memory_equal(model->values, again->values, (size_t)model->count * sizeof(real));
    assert_true(fabs(deviation(model, find(model, "tokeniser.weight")) - 0.02) < 0.0005);
    assert_true(fabs(deviation(model, find(model, "blocks.0.in_proj")) - 0.02) < 0.0005);
    assert_true(fabs(deviation(model, find(model, "blocks.0.out_proj")) - 0.01) <
                0.0005); // 0.02 / sqrt(2 * 2)
    assert_true(fabs(deviation(model, find(model, "blocks.1.fc2")) - 0.01) < 0.0005);
    assert_true(fabs(deviation(model, find(model, "blocks.1.qkv")) - 0.02) < 0.0005);
    int64_t end = 0;
    for (int i = 0; i < model->n_parameters; i++) {
        const FfpParameter *p = &model->parameters[i];
        assert_int_equal(p->offset, end);
        assert_int_equal(p->decay, p->rank == 2);
        end += p->count;
        for (int64_t k = 0; k < p->count; k++) {
            const double x = (double)model->values[p->offset + k];
            if (strstr(p->name, "dt_bias")) assert_in_range((int)(1e6 * log1p(exp(x))), 990, 101000);
            if (strstr(p->name, "a_log")) assert_true(x >= 0 && x <= log(16.0) + 1e-6);
            if (strstr(p->name, ".conv")) assert_true(fabs(x) <= 0.5);
            if (strstr(p->name, "norm") || strstr(p->name, "gain")) assert_true(x == 1);
            if (strstr(p->name, ".last.")) assert_true(x == 0);
        }
    }
    assert_int_equal(end, model->count);
    ffp_model_free(model);
    ffp_model_free(again);
}

static void test_round_trip(void **state) {
    (void)state;
    FfpModel *model = new_tiny();
    shake(model, 5);
    const char *metadata[] = {"steps", "1200", "commit", "abc"};
    FfpError err;
    for (int exact = 0; exact < 2; exact++) {
        assert_true(ffp_model_write(model, FILE_NAME, exact, metadata, 2, &err));
        FfpModel *read = ffp_model_read(FILE_NAME, &err);
        if (!read) print_error("%s\n", err.text);
        assert_non_null(read);
        assert_string_equal(read->config.modules, "MT");
        assert_string_equal(read->config.name, "tiny");
        assert_string_equal(read->config.render, "ours");
        assert_int_equal(read->config.dim, 64);
        assert_int_equal(read->config.pixel_hidden, model->config.pixel_hidden);
        assert_true(read->config.residual && read->config.match_input && read->config.pixel_skip);
        assert_int_equal(read->count, model->count);
        assert_int_equal(read->metadata_count, 2);
        for (int i = 0; i < 4; i++) assert_string_equal(read->metadata[i], metadata[i]);
        for (int i = 0; i < model->n_parameters; i++) {
            const FfpParameter *p = &model->parameters[i];
            for (int64_t k = p->offset; k < p->offset + p->count; k++) {
                const real slack = exact || p->rank == 1 ? 0 : fabs(model->values[k]) / 256;
                assert_true(fabs(read->values[k] - model->values[k]) <= slack);
            }
        }
        ffp_model_free(read);
    }
    const char *taken[] = {"model.dim", "128"};
    assert_false(ffp_model_write(model, FILE_NAME, false, taken, 1, &err));
    expect(&err, "model.dim");
    ffp_model_free(model);
    unlink(FILE_NAME);
}

// A good file, changed by `spoil`, must be refused with `part` in the error.
typedef void Spoil(FfpSafetensors *file);

// A model's file, changed, and read again.
static FfpModel *read_changed(Spoil *change, FfpError *err) {
    FfpModel *model = new_tiny();
    FfpSafetensors file;
    assert_true(ffp_model_write(model, FILE_NAME, true, NULL, 0, err));
    ffp_model_free(model);
    assert_true(ffp_safetensors_read(&file, FILE_NAME, err));
    change(&file);
    assert_true(ffp_safetensors_write(FILE_NAME, file.tensors, file.count, (const char *const *)file.metadata,
                                      file.metadata_count, err));
    ffp_safetensors_free(&file);
    err->text[0] = 0;
    return ffp_model_read(FILE_NAME, err);
}

static void check_spoilt(Spoil *spoil, const char *part) {
    FfpError err;
    assert_null(read_changed(spoil, &err));
    expect(&err, part);
    expect(&err, FILE_NAME);
    unlink(FILE_NAME);
}

static void set_metadata(FfpSafetensors *file, const char *key, const char *value) {
    for (int i = 0; i < file->metadata_count; i++)
        if (strcmp(file->metadata[2 * i], key) == 0) {
            ffp_free(file->metadata[2 * i + 1]);
            file->metadata[2 * i + 1] = ffp_copy_text(value);
            return;
        }
    fail();
}

static void drop_last_tensor(FfpSafetensors *file) {
    file->count--;
}
static void rename_tensor(FfpSafetensors *file) {
    strcpy(file->tensors[3].name, "stranger");
}
static void turn_matrix(FfpSafetensors *file) {
    FfpTensor *t = (FfpTensor *)ffp_safetensors_find(file, "blocks.1.fc1");
    const int64_t rows = t->shape[0];
    t->shape[0] = t->shape[1];
    t->shape[1] = rows;
}
static void flatten_matrix(FfpSafetensors *file) {
    FfpTensor *t = (FfpTensor *)ffp_safetensors_find(file, "blocks.1.fc1");
    t->shape[0] *= t->shape[1];
    t->rank = 1;
}
static void put_nan(FfpSafetensors *file) {
    FfpTensor *t = (FfpTensor *)ffp_safetensors_find(file, "blocks.0.forward.a_log");
    const float nan = NAN;
    memcpy((char *)t->data + 4, &nan, sizeof nan);
}
static void put_integers(FfpSafetensors *file) {
    FfpTensor *t = (FfpTensor *)ffp_safetensors_find(file, "blocks.1.norm2");
    static const int64_t whole[64];
    t->dtype = FFP_I64;
    t->data = whole;
}
static void add_tensor(FfpSafetensors *file) {
    file->tensors = ffp_grow(file->tensors, (size_t)file->count + 1, sizeof *file->tensors);
    file->tensors[file->count] = file->tensors[0];
    strcpy(file->tensors[file->count++].name, "stranger");
}
static void claim_more_blocks(FfpSafetensors *file) {
    set_metadata(file, "model.modules", "MTMT");
}
static void claim_width(FfpSafetensors *file) {
    set_metadata(file, "model.dim", "4096");
}
static void claim_vast_width(FfpSafetensors *file) {
    set_metadata(file, "model.dim", "99999999999999999999");
}
static void claim_odd_width(FfpSafetensors *file) {
    set_metadata(file, "model.dim", "96");
}
static void claim_text(FfpSafetensors *file) {
    set_metadata(file, "model.state", "5x");
}
static void claim_switch(FfpSafetensors *file) {
    set_metadata(file, "model.residual", "maybe");
}
static void claim_letters(FfpSafetensors *file) {
    set_metadata(file, "model.modules", "MZ");
}
static void claim_long_text(FfpSafetensors *file) {
    set_metadata(file, "model.render", "oursoursoursoursoursoursours");
}
static void claim_format(FfpSafetensors *file) {
    set_metadata(file, "format", "pt");
}
static void claim_version(FfpSafetensors *file) {
    set_metadata(file, "format_version", "2");
}
static void drop_metadata(FfpSafetensors *file) {
    for (int i = 0; i < 2 * file->metadata_count; i++) ffp_free(file->metadata[i]);
    file->metadata_count = 0;
}

static void drop_key(FfpSafetensors *file, const char *key) {
    for (int i = 0; i < file->metadata_count; i++) {
        if (strcmp(file->metadata[2 * i], key) != 0) continue;
        char **pair = file->metadata + 2 * i, **last = file->metadata + 2 * --file->metadata_count;
        ffp_free(pair[0]);
        ffp_free(pair[1]);
        pair[0] = last[0], pair[1] = last[1];
        return;
    }
    fail();
}
static void drop_tensor(FfpSafetensors *file, const char *name) {
    int i = 0;
    while (i < file->count && strcmp(file->tensors[i].name, name) != 0) i++;
    assert_true(i < file->count);
    memmove(file->tensors + i, file->tensors + i + 1, (size_t)(file->count - i - 1) * sizeof *file->tensors);
    file->count--;
}
static void be_of_version_0_1(FfpSafetensors *file) {
    drop_key(file, "model.samples");
    drop_key(file, "model.appearance_cnn");
    drop_key(file, "model.tokens");
    drop_key(file, "model.context_inputs");
    drop_tensor(file, "pixel.context");
}
static void keep(FfpSafetensors *file) {
    (void)file;
}
static void claim_samples(FfpSafetensors *file) {
    set_metadata(file, "model.samples", "5");
}

// Files from before a field was there mean what the program did then: one sample a pixel.
static void test_older_files(void **state) {
    (void)state;
    FfpError err;
    FfpModel *new = read_changed(keep, &err), *old = read_changed(be_of_version_0_1, &err);
    if (!old) fail_msg("%s", err.text);
    assert_int_equal(new->config.samples, 2);
    assert_int_equal(old->config.samples, 1);
    assert_int_equal(old->config.samples, 1);
    assert_false(old->config.appearance_cnn);
    assert_int_equal(old->config.tokens, 4096);
    assert_true(new->config.context_inputs);
    assert_false(old->config.context_inputs);
    // A training that wants them takes the rest over:
    FfpModel *wider = ffp_model_new(&new->config, 99, &err);
    ffp_model_take_over(wider, old);
    for (int i = 0; i < wider->n_parameters; i++) {
        const FfpParameter *p = &wider->parameters[i];
        for (int64_t k = p->offset; k < p->offset + p->count; k++)
            assert_float_equal(wider->values[k], strcmp(p->name, "pixel.context") == 0 ? 0 : new->values[k],
                               0);
    }
    ffp_model_free(wider);
    ffp_model_free(new);
    ffp_model_free(old);
    unlink(FILE_NAME);
}

static void test_hostile_files(void **state) {
    (void)state;
    check_spoilt(drop_last_tensor, "pixel.last.bias");
    check_spoilt(rename_tensor, "missing");
    check_spoilt(turn_matrix, "blocks.1.fc1");
    check_spoilt(flatten_matrix, "blocks.1.fc1");
    check_spoilt(put_nan, "blocks.0.forward.a_log");
    check_spoilt(put_integers, "blocks.1.norm2");
    check_spoilt(add_tensor, "stranger");
    check_spoilt(claim_more_blocks, "blocks.2.norm");
    check_spoilt(claim_width, "tokeniser.weight");
    check_spoilt(claim_vast_width, "model.dim");
    check_spoilt(claim_odd_width, "model.dim");
    check_spoilt(claim_text, "model.state");
    check_spoilt(claim_switch, "model.residual");
    check_spoilt(claim_samples, "model.samples");
    check_spoilt(claim_letters, "model.modules");
    check_spoilt(claim_long_text, "model.render");
    check_spoilt(claim_format, "format");
    check_spoilt(claim_version, "format_version");
    check_spoilt(drop_metadata, "not a model file");
}

// Whatever a bit flip or a cut makes of a file: refused, or read as finite numbers; never more than that.
static void test_damaged_bytes(void **state) {
    (void)state;
    FfpModel *model = new_tiny();
    FfpError err;
    assert_true(ffp_model_write(model, FILE_NAME, false, NULL, 0, &err));
    ffp_model_free(model);
    FILE *f = fopen(FILE_NAME, "rb");
    assert_non_null(f);
    fseek(f, 0, SEEK_END);
    const long size = ftell(f);
    char *bytes = ffp_alloc((size_t)size, 1);
    rewind(f);
    assert_int_equal(fread(bytes, 1, (size_t)size, f), size);
    fclose(f);
    const uint32_t header = 8 + (unsigned char)bytes[0] + 256U * (unsigned char)bytes[1];
    FfpRng rng = ffp_rng(1, 1);
    int refused = 0;
    for (int i = 0; i < 60; i++) {
        const uint32_t at = ffp_rng_below(&rng, header);
        const size_t kept = i % 3 ? (size_t)size : ffp_rng_below(&rng, (uint32_t)size);
        const char old = bytes[at];
        bytes[at] = (char)(old ^ 1 << ffp_rng_below(&rng, 8));
        assert_non_null(f = fopen(FILE_NAME, "wb"));
        fwrite(bytes, 1, kept, f);
        fclose(f);
        bytes[at] = old;
        FfpModel *read = ffp_model_read(FILE_NAME, &err);
        refused += !read;
        if (!read) expect(&err, FILE_NAME);
        ffp_model_free(read);
    }
    assert_true(refused >= 50); // a model's name may change unseen
    ffp_free(bytes);
    unlink(FILE_NAME);
    assert_null(ffp_model_read(FILE_NAME, &err));
    expect(&err, FILE_NAME);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_presets),       cmocka_unit_test(test_config_check),
        cmocka_unit_test(test_first_values),  cmocka_unit_test(test_round_trip),
        cmocka_unit_test(test_older_files),   cmocka_unit_test(test_hostile_files),
        cmocka_unit_test(test_damaged_bytes),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
