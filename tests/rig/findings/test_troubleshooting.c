// The rules' table, and docs/guide/troubleshooting.md, which is made from it: FFP_WRITE=1 writes the page.
#include "rig/findings/tell.h"
#include "support.h"

#define PAGE FFP_SOURCE_DIR "/docs/guide/troubleshooting.md"

static char *read_page(void) {
    static char text[1 << 17];
    FILE *in = fopen(PAGE, "r");
    const size_t size = in ? fread(text, 1, sizeof text - 1, in) : 0;
    if (in) fclose(in);
    text[size] = 0;
    return text;
}

static void the_page_is_that_of_the_rules(void **state) {
    (void)state;
    char *text = NULL;
    size_t size = 0;
    FILE *out = open_memstream(&text, &size);
    ffp_write_troubleshooting(out);
    fclose(out);
    if (getenv("FFP_WRITE")) {
        FILE *page = fopen(PAGE, "w");
        assert_non_null(page);
        fputs(text, page);
        fclose(page);
    }
    if (strcmp(text, read_page()) != 0) fail_msg("%s is not that of the rules: FFP_WRITE=1 writes it", PAGE);
    free(text);
}

static void every_rule_has_its_words(void **state) {
    (void)state;
    for (int id = 0; id < FFP_RULES; id++) {
        const FfpRule *rule = ffp_rule((FfpRuleId)id);
        if (!rule->code || !rule->subject || !rule->sentence) fail_msg("rule %d is empty", id);
        if (rule->severity == FFP_FINDING_OK) assert_null(rule->advice);
        if (rule->severity >= FFP_FINDING_DOUBT && !rule->advice) fail_msg("%s has no remedy", rule->code);
        for (int other = 0; other < id; other++)
            if (strcmp(ffp_rule((FfpRuleId)other)->code, rule->code) == 0 &&
                ffp_rule((FfpRuleId)other)->severity == rule->severity)
                fail_msg("%s is the code of two rules", rule->code);
    }
}

static void templates_are_filled(void **state) {
    (void)state;
    FfpFindings found = {0};
    assert_true(ffp_found(&found, FFP_RULE_VIEW_CONTRADICTS,
                          &(FfpFacts){.view = "a\033b", .figure = 0.1234, .x = 0.05}));
    assert_false(ffp_found(&found, FFP_RULE_DEVICE_FAR, &(FfpFacts){.a = "camera", .figure = 250.4}));
    const FfpFinding *doubt = &found.items[0], *fault = ffp_findings_fault(&found);
    assert_ptr_equal(strstr(doubt->text, "12.3 % of"), doubt->text);
    assert_ptr_equal(strstr(doubt->advice, "without view a?b it is 5.0 %:"), doubt->advice);
    assert_string_equal(fault->text, "the camera is 250 times the object's radius away");
    assert_true(fault->figure > 250 && fault->limit == 100);
    ffp_findings_free(&found);
}

// No doubt or note repeats what a fault of its subject explains.
static void what_is_worse_speaks_for_its_subject(void **state) {
    (void)state;
    static const FfpRuleId given[] = {FFP_RULE_VIEWS_CONTRADICT, FFP_RULE_CLIPPED, FFP_RULE_VIEW_TURNED,
                                      FFP_RULE_NOTE_CLIPPED};
    FfpFindings found = {0};
    for (size_t i = 0; i < sizeof given / sizeof *given; i++)
        ffp_found(&found, given[i], &(FfpFacts){.view = i == 2 ? "045" : NULL, .a = "mirrored"});
    ffp_findings_merge(&found);
    assert_int_equal(found.count, 2);
    assert_string_equal(found.items[0].code, "clipped");
    assert_string_equal(found.items[1].code, "view-turned");
    ffp_findings_free(&found);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_page_is_that_of_the_rules),
        cmocka_unit_test(every_rule_has_its_words),
        cmocka_unit_test(templates_are_filled),
        cmocka_unit_test(what_is_worse_speaks_for_its_subject),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
