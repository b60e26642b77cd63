// Safetensors: what is written reads back, and hostile files are refused with file and tensor named.
#include <math.h>
#include <unistd.h>
#include "core/base/file.h"
#include "core/tensor/safetensors.h"
#include "support.h"

#define FILE_NAME "test_safetensors.safetensors"

static void write_bytes(const char *header, size_t claimed, const void *data, size_t size) {
    FILE *f = fopen(FILE_NAME, "wb");
    assert_non_null(f);
    for (int i = 0; i < 8; i++) fputc((int)(claimed >> 8 * i & 255), f);
    fputs(header, f);
    fwrite(data, 1, size, f);
    fclose(f);
}

static void expect_refused(const char *part) {
    FfpSafetensors file;
    FfpError err = {0};
    assert_false(ffp_safetensors_read(&file, FILE_NAME, &err));
    if (!strstr(err.text, part) || !strstr(err.text, FILE_NAME)) {
        print_error("expected '%s' and the file's name in '%s'\n", part, err.text);
        fail();
    }
    assert_null(file.tensors);
    assert_null(file.bytes);
}

static void test_round_trip(void **state) {
    (void)state;
    const float single[6] = {1, -2, 3.5F, 1e-30F, -0.0F, 7};
    const double twice[2] = {3.14159265358979, -1e300};
    const uint16_t brain[3] = {ffp_bf16_from_float(1.5F), ffp_bf16_from_float(-3),
                               ffp_bf16_from_float(1e10F)};
    const int64_t whole[1] = {-1234567890123};
    const uint8_t bytes[3] = {1, 2, 255};
    const FfpTensor tensors[] = {
        {.name = "bytes", .dtype = FFP_U8, .rank = 1, .shape = {3}, .count = 3, .data = bytes},
        {.name = "single", .dtype = FFP_F32, .rank = 2, .shape = {2, 3}, .count = 6, .data = single},
        {.name = "twice", .dtype = FFP_F64, .rank = 1, .shape = {2}, .count = 2, .data = twice},
        {.name = "brain", .dtype = FFP_BF16, .rank = 3, .shape = {1, 3, 1}, .count = 3, .data = brain},
        {.name = "empty", .dtype = FFP_F32, .rank = 2, .shape = {0, 5}, .count = 0, .data = single},
        {.name = "whole", .dtype = FFP_I64, .rank = 0, .count = 1, .data = whole},
    };
    const char *metadata[] = {"step", "12", "quoted", "a \"b\" \\ \n c"};
    FfpError err;
    assert_true(ffp_safetensors_write(FILE_NAME, tensors, 6, metadata, 2, &err));
    FfpSafetensors file;
    assert_true(ffp_safetensors_read(&file, FILE_NAME, &err));
    assert_int_equal(file.count, 6);
    for (int i = 0; i < 6; i++) {
        const FfpTensor *t = ffp_safetensors_find(&file, tensors[i].name);
        assert_non_null(t);
        assert_int_equal(t->dtype, tensors[i].dtype);
        assert_int_equal(t->rank, tensors[i].rank);
        assert_int_equal(t->count, tensors[i].count);
        for (int k = 0; k < t->rank; k++) assert_int_equal(t->shape[k], tensors[i].shape[k]);
        const size_t size[] = {4, 2, 2, 8, 8, 1};
        assert_memory_equal(t->data, tensors[i].data, (size_t)t->count * size[t->dtype]);
    }
    assert_null(ffp_safetensors_find(&file, "absent"));
    assert_int_equal(file.metadata_count, 2);
    assert_string_equal(ffp_safetensors_metadata(&file, "quoted"), metadata[3]);
    assert_null(ffp_safetensors_metadata(&file, "absent"));
    real values[6];
    assert_true(ffp_tensor_to_real(ffp_safetensors_find(&file, "single"), values));
    for (int i = 0; i < 6; i++) assert_true(values[i] == single[i]);
    assert_true(ffp_tensor_to_real(ffp_safetensors_find(&file, "brain"), values));
    assert_true(values[0] == 1.5F && values[1] == -3);
    assert_false(ffp_tensor_to_real(ffp_safetensors_find(&file, "whole"), values));
    ffp_safetensors_free(&file);
    unlink(FILE_NAME);
}

static void test_bf16_rounds_to_even(void **state) {
    (void)state;
    assert_int_equal(ffp_bf16_from_float(1.0F), 0x3f80);
    assert_int_equal(ffp_bf16_from_float(1.0F + 0x1p-8F), 0x3f80);           // halfway: to the even neighbour
    assert_int_equal(ffp_bf16_from_float(1.0F + 0x1p-7F + 0x1p-8F), 0x3f82); // halfway: up to the even one
    assert_int_equal(ffp_bf16_from_float(1.0F + 0x1p-8F + 0x1p-20F), 0x3f81); // above half
    assert_true(isnan(ffp_bf16_to_float(ffp_bf16_from_float(NAN))));
    assert_true(isinf(ffp_bf16_to_float(ffp_bf16_from_float(INFINITY))));
    for (uint32_t i = 0; i < 0x7f80; i++)
        assert_int_equal(ffp_bf16_from_float(ffp_bf16_to_float((uint16_t)i)), i);
}

static void test_f16_values(void **state) {
    (void)state;
    const uint16_t half[6] = {0x3c00, 0xc000, 0x0001, 0x7bff, 0x7c00, 0x3555};
    const double expected[6] = {1, -2, 0x1p-24, 65504, INFINITY, 0.333251953125};
    const FfpTensor tensor = {.dtype = FFP_F16, .rank = 1, .shape = {6}, .count = 6, .data = half};
    real out[6];
    assert_true(ffp_tensor_to_real(&tensor, out));
    for (int i = 0; i < 6; i++) assert_true((double)out[i] == expected[i]);
}

static void test_hostile_files(void **state) {
    (void)state;
    static const struct {
        const char *header, *part;
    } cases[] = {
        {"{", "broken header"},
        {"[1]", "not an object"},
        {"{\"a\":3}", "a)"},
        {"{\"a\":{\"shape\":[2],\"data_offsets\":[0,8]}}", "dtype"},
        {"{\"a\":{\"dtype\":\"C64\",\"shape\":[1],\"data_offsets\":[0,8]}}", "C64"},
        {"{\"a\":{\"dtype\":\"F32\",\"shape\":[-2],\"data_offsets\":[0,8]}}", "shape"},
        {"{\"a\":{\"dtype\":\"F32\",\"shape\":[2.0],\"data_offsets\":[0,8]}}", "shape"},
        {"{\"a\":{\"dtype\":\"F32\",\"shape\":\"2\",\"data_offsets\":[0,8]}}", "shape"},
        {"{\"a\":{\"dtype\":\"F32\",\"shape\":[1,1,1,1,1,1,1,1,2],\"data_offsets\":[0,8]}}", "shape"},
        {"{\"a\":{\"dtype\":\"F32\",\"shape\":[4294967296,4294967298],\"data_offsets\":[0,8]}}", "overflows"},
        {"{\"a\":{\"dtype\":\"F32\",\"shape\":[99999999999999999999],\"data_offsets\":[0,8]}}",
         "broken header"},
        {"{\"a\":{\"dtype\":\"F32\",\"shape\":[3],\"data_offsets\":[0,8]}}", "12 bytes"},
        {"{\"a\":{\"dtype\":\"F32\",\"shape\":[4],\"data_offsets\":[0,16]}}", "outside"},
        {"{\"a\":{\"dtype\":\"F32\",\"shape\":[2],\"data_offsets\":[-8,0]}}", "outside"},
        {"{\"a\":{\"dtype\":\"F32\",\"shape\":[0],\"data_offsets\":[9223372036854775807,9223372036854775807]}"
         "}",
         "outside"},
        {"{\"a\":{\"dtype\":\"F32\",\"shape\":[2],\"data_offsets\":[8,0]}}", "outside"},
        {"{\"a\":{\"dtype\":\"F32\",\"shape\":[2],\"data_offsets\":[0]}}", "data_offsets"},
        {"{\"a\":{\"dtype\":\"F32\",\"shape\":[1],\"data_offsets\":[0,4]}}", "after the last"},
        {"{\"a\":{\"dtype\":\"F32\",\"shape\":[1],\"data_offsets\":[4,8]}}", "gap"},
        {"{\"a\":{\"dtype\":\"F32\",\"shape\":[2],\"data_offsets\":[0,8]},"
         "\"b\":{\"dtype\":\"F32\",\"shape\":[1],\"data_offsets\":[4,8]}}",
         "overlap"},
        {"{\"a\":{\"dtype\":\"F32\",\"shape\":[1],\"data_offsets\":[0,4]},"
         "\"a\":{\"dtype\":\"F32\",\"shape\":[1],\"data_offsets\":[4,8]}}",
         "broken header"},
        {"{\"__metadata__\":{\"k\":1},\"a\":{\"dtype\":\"F32\",\"shape\":[2],\"data_offsets\":[0,8]}}", "k)"},
        {"{\"__metadata__\":[],\"a\":{\"dtype\":\"F32\",\"shape\":[2],\"data_offsets\":[0,8]}}",
         "__metadata__"},
        {"{\"\":{\"dtype\":\"F32\",\"shape\":[2],\"data_offsets\":[0,8]}}", "name"},
    };
    const float data[2] = {1, 2};
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        write_bytes(cases[i].header, strlen(cases[i].header), data, sizeof data);
        expect_refused(cases[i].part);
    }
    unlink(FILE_NAME);
}

static void test_bad_lengths(void **state) {
    (void)state;
    const char *header = "{\"a\":{\"dtype\":\"F32\",\"shape\":[2],\"data_offsets\":[0,8]}}";
    const float data[2] = {1, 2};
    write_bytes(header, SIZE_MAX, data, sizeof data);
    expect_refused("header");
    write_bytes(header, strlen(header) + sizeof data + 1, data, sizeof data);
    expect_refused("header");
    write_bytes(header, strlen(header), data, sizeof data - 1); // truncated
    expect_refused("outside");
    FILE *f = fopen(FILE_NAME, "wb");
    fputs("abc", f);
    fclose(f);
    expect_refused("8 bytes");
    unlink(FILE_NAME);
    FfpSafetensors file;
    FfpError err;
    assert_false(ffp_safetensors_read(&file, FILE_NAME, &err)); // absent
    assert_non_null(strstr(err.text, FILE_NAME));
}

static void test_writer_refuses(void **state) {
    (void)state;
    const float data[1] = {1};
    const FfpTensor twins[] = {
        {.name = "a", .dtype = FFP_F32, .rank = 1, .shape = {1}, .count = 1, .data = data},
        {.name = "a", .dtype = FFP_F32, .rank = 1, .shape = {1}, .count = 1, .data = data}};
    const char *metadata[] = {"key", "\xff\xfe"};
    FfpError err;
    assert_false(ffp_safetensors_write(FILE_NAME, twins, 2, NULL, 0, &err));
    assert_non_null(strstr(err.text, "a)"));
    assert_false(ffp_safetensors_write(FILE_NAME, twins, 1, metadata, 1, &err));
    assert_non_null(strstr(err.text, "key"));
    assert_false(ffp_safetensors_write("no/such/folder/x", twins, 1, NULL, 0, &err));
    assert_int_not_equal(access(FILE_NAME, F_OK), 0);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_round_trip),  cmocka_unit_test(test_bf16_rounds_to_even),
        cmocka_unit_test(test_f16_values),  cmocka_unit_test(test_hostile_files),
        cmocka_unit_test(test_bad_lengths), cmocka_unit_test(test_writer_refuses),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
