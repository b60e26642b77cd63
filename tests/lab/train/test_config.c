// The training configuration: what is refused, and that writing and reading agree.
#include "core/base/alloc.h"
#include "lab/train/train.h"
#include "scratch.h"

static void refused(const char *text, const char *place, const char *reason) {
    FfpTrainConfig config;
    FfpError err = {0};
    assert_false(ffp_train_config_parse(&config, text, "c.json", &err));
    if (!strstr(err.text, place) || !strstr(err.text, reason))
        fail_msg("'%s' lacks '%s' or '%s'", err.text, place, reason);
}

static void test_bad_fields(void **state) {
    (void)state;
    refused("{", "c.json", "broken JSON");
    refused("[]", "c.json", "expected an object");
    refused("{\"stepz\": 3}", "c.json: stepz", "unknown field");
    refused("{\"steps\": \"3\"}", "c.json: steps", "whole number");
    refused("{\"steps\": 1.5}", "c.json: steps", "whole number");
    refused("{\"steps\": 0}", "c.json: steps", "not in");
    refused("{\"steps\": 1, \"steps\": 2}", "c.json", "broken JSON");
    refused("{\"learning_rate\": -1}", "c.json: learning_rate", "not in");
    refused("{\"learning_rate\": 1e999}", "c.json", "broken JSON");
    refused("{\"learning_rate\": NaN}", "c.json", "broken JSON");
    refused("{\"recompute\": 1}", "c.json: recompute", "true or false");
    refused("{\"white_from\": -1}", "c.json: white_from", "not in");
    refused("{\"active_from\": 0.1}", "c.json: active_from", "whole number");
    refused("{\"low_steps\": 9}", "c.json: low_steps", "unknown field"); // a former field
    refused("{\"model\": \"huge\"}", "c.json: model", "no preset");
    refused("{\"model\": {\"dims\": 3}}", "c.json: model.dims", "unknown field");
    refused("{\"model\": {\"modules\": \"MXT\"}}", "c.json", "modules");
    refused("{\"supervised_inputs\": 0, \"supervised_targets\": 0}", "c.json", "both 0");
    refused("{\"supervised_targets\": 5, \"targets\": 4}", "c.json", "above targets");
    refused("{\"generators\": -1}", "c.json: generators", "not in");
    refused("{\"queue\": 0}", "c.json: queue", "not in");
    refused("{\"scenes\": 3}", "c.json: scenes", "a string");
    refused("{\"resolution\": 100}", "c.json", "multiple");
    refused("{\"views\": 4, \"views_least\": 5}", "c.json: views_least", "above views");
    refused("{\"free_share\": 1.5}", "c.json: free_share", "not in");
    refused("{\"large_share\": 0.1, \"large_resolution\": 100}", "c.json: large_resolution", "multiple");
    refused("{\"views_least\": 2, \"scenes\": \"made\"}", "c.json: views_least", "of a folder");
    refused("{\"free_share\": 0.2, \"scenes\": \"made\"}", "c.json: free_share", "of a folder");
    refused("{\"large_share\": 0.2, \"scenes\": \"made\"}", "c.json: large_share", "of a folder");
    refused("{\"sensor_share\": 0.2, \"scenes\": \"made\"}", "c.json: sensor_share", "of a folder");
    refused("{\"material_share\": 0.2}", "c.json: materials", "names no folder");
    refused("{\"materials\": \"stock\"}", "c.json: materials", "material_share is 0");
    refused("{\"room_share\": 0.2}", "c.json: rooms", "names no folder");
    refused("{\"rooms\": \"made\"}", "c.json: rooms", "room_share is 0");
    refused("{\"room_share\": 0.2, \"rooms\": \"made\", \"captures\": \"mine\"}", "c.json: room_share",
            "of a folder");
    refused("{\"pattern_share\": 0.2}", "c.json: patterns", "names no folder");
    refused("{\"pattern_share\": 0.2, \"patterns\": \"stock\", \"lollipops\": 1}", "c.json: pattern_share",
            "no other");
    refused("{\"pattern_share\": 0.2, \"patterns\": \"stock\", \"scenes\": \"made\"}",
            "c.json: pattern_share", "of a folder");
    refused("{\"material_share\": 0.2, \"materials\": \"stock\", \"scenes\": \"made\"}",
            "c.json: material_share", "of a folder");
    refused("{\"sensor_share\": 0.2, \"captures\": \"mine\"}", "c.json: sensor_share", "of a folder");
    refused("{\"captures\": \"mine\", \"validate_every\": 0}", "c.json: validate_every", "is 0");
    refused("{\"captures\": \"mine\", \"validate_every\": 50, \"patience\": 49}", "c.json: patience",
            "below validate_every");
}

// Defaults that nobody has set are in nobody's way.
static void test_defaults_learn_from_captures(void **state) {
    (void)state;
    FfpTrainConfig config;
    FfpError err = {0};
    if (!ffp_train_config_parse(&config, "{\"captures\": \"mine\"}", "c.json", &err))
        fail_msg("%s", err.text);
    config = ffp_fine_tuning_defaults();
    snprintf(config.captures, sizeof config.captures, "mine");
    char *text = ffp_train_config_print(&config, &err);
    if (!ffp_train_config_parse(&config, text, "c.json", &err)) fail_msg("%s", err.text);
    ffp_free(text);
}

static void test_round_trip(void **state) {
    (void)state;
    FfpTrainConfig config, again;
    FfpError err = {0};
    assert_true(ffp_train_config_parse(
        &config,
        "{\"steps\": 77, \"white_from\": 3, \"active_from\": 7, \"scenes\": "
        "\"a/b\", \"generators\": 2, \"ema\": 0.5, \"model\": {\"preset\": \"tiny\", \"modules\": \"TM\"}}",
        "c.json", &err));
    assert_int_equal(config.steps, 77);
    assert_int_equal(config.white_from, 3);
    assert_int_equal(config.active_from, 7);
    assert_string_equal(config.model.modules, "TM");
    assert_string_equal(config.scenes, "a/b");
    assert_int_equal(config.generators, 2);
    assert_int_equal(config.model.dim, 128);
    char *text = ffp_train_config_print(&config, &err);
    assert_true(ffp_train_config_parse(&again, text, "again", &err));
    char *text_again = ffp_train_config_print(&again, &err);
    assert_string_equal(text, text_again);
    ffp_free(text);
    ffp_free(text_again);
}

// As a path may be, and JSON may not: it would be missing from what is written.
static void test_a_path_that_is_not_utf8_is_not_lost(void **state) {
    (void)state;
    FfpTrainConfig config = ffp_train_defaults();
    FfpError err = {0};
    snprintf(config.captures, sizeof config.captures, "f\xfcr/mich");
    assert_null(ffp_train_config_print(&config, &err));
    if (!strstr(err.text, "UTF-8") || !strstr(err.text, "captures")) fail_msg("%s", err.text);
    FfpModel *model = ffp_model_new(&config.model, 1, &err);
    FfpAdam adam = ffp_adam_new(model);
    assert_false(ffp_checkpoint_write(in_scratch("lost"), model, &adam, &config, "test", &err));
    assert_false(ffp_is_file(in_scratch("lost")));
    ffp_adam_free(&adam);
    ffp_model_free(model);
}

static void test_byte_order_mark(void **state) {
    (void)state;
    FfpTrainConfig config;
    FfpError err = {0};
    config = ffp_train_defaults();
    assert_true(ffp_write_file(in_scratch("marked.json"), "\xEF\xBB\xBF{\"steps\": 7}", 15, NULL));
    if (!ffp_train_config_overlay(&config, in_scratch("marked.json"), &err)) fail_msg("%s", err.text);
    assert_int_equal(config.steps, 7);
}

static void test_schedule(void **state) {
    (void)state;
    FfpTrainConfig config = ffp_train_defaults();
    config.steps = 1000, config.warmup_steps = 100, config.learning_rate = 1e-3,
    config.final_learning_rate = 1e-6;
    assert_float_equal(ffp_learning_rate(&config, 0), 1e-5, 1e-12);
    assert_float_equal(ffp_learning_rate(&config, 99), 1e-3, 1e-12);
    assert_float_equal(ffp_learning_rate(&config, 550), (1e-3 + 1e-6) / 2, 1e-9);
    assert_float_equal(ffp_learning_rate(&config, 1000), 1e-6, 1e-12);
    assert_float_equal(ffp_learning_rate(&config, 5000), 1e-6, 1e-12);
}

#define PAGE FFP_SOURCE_DIR "/docs/reference/training.md"
#define BEGIN "<!-- fields: FFP_WRITE=1 build/test_config writes them -->\n\n"
#define END "\n<!-- end of fields -->\n"

// docs/reference/training.md has the tables of config.c between its two comments; FFP_WRITE=1 writes them.
static void the_page_has_the_fields(void **state) {
    (void)state;
    char *page = NULL, *text = NULL;
    size_t size = 0;
    FfpError err = {0};
    assert_true(ffp_read_text(PAGE, 1 << 20, &page, &size, &err));
    char *begin = strstr(page, BEGIN), *end = begin ? strstr(begin, END) : NULL;
    assert_non_null(end);
    begin += strlen(BEGIN);
    FILE *out = open_memstream(&text, &size);
    ffp_train_write_fields(out);
    fclose(out);
    if (getenv("FFP_WRITE")) {
        out = fopen(PAGE, "w");
        assert_non_null(out);
        fprintf(out, "%.*s%s%s", (int)(begin - page), page, text, end);
        fclose(out);
    } else if ((size_t)(end - begin) != size || memcmp(begin, text, size) != 0) {
        fail_msg("the fields of %s are not those of config.c: FFP_WRITE=1 writes them", PAGE);
    }
    free(text);
    ffp_free(page);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_bad_fields),
        cmocka_unit_test(the_page_has_the_fields),
        cmocka_unit_test(test_defaults_learn_from_captures),
        cmocka_unit_test(test_round_trip),
        cmocka_unit_test(test_a_path_that_is_not_utf8_is_not_lost),
        cmocka_unit_test(test_byte_order_mark),
        cmocka_unit_test(test_schedule),
    };
    return cmocka_run_group_tests(tests, scratch_setup, scratch_teardown);
}
