// The rules' table, and docs/guide/troubleshooting.md, which is made from it: FFP_WRITE=1 writes the page.
#include <ctype.h>
#include "rig/findings/tell.h"
#include "support.h"

#define PAGE FFP_SOURCE_DIR "/docs/guide/troubleshooting.md"

// --- The page. ---

static const struct {
    const char *subject, *meaning;
} subjects[] = {
    {"devices",
     "Where camera and projector stand around the object, from the calibration and the turntable's axis."},
    {"frusta", "What the devices see of the object's sphere: the camera should see all of it, and the "
               "pattern cover it."},
    {"lit pixels", "Pixels that white brightens must lie where the projector's light can reach."},
    {"silhouettes", "A pixel that shows the object needs a point on its ray that no other view shows as "
                    "background: with right poses and masks every pixel has one."},
    {"masks", "Which pixels show the object."},
    {"photographs", "The photographs of a view, one under each pattern."},
    {"clipping", "Pixels at the camera's limit have lost their colour."},
    {"exposure", "How bright the object is under white."},
    {"black level", "Nothing can be darker under more light."},
    {"lit share", "How much of the object the projector's light reaches."},
    {"guesses", "A pattern tells a pixel's depth where it reaches the pixel; where Gray codes were "
                "photographed, they must give a position, too, which they do not on mirrors."},
    {"ambient", "The room's light, which remains when the projector shows black."},
    {"camera", "Distances, angles and fields of view, beside those of the rigs that the shipped model was "
               "trained on. Others work, but less well; `--model none` does not depend on them."},
    {"views", "How the views are spread around the object."},
    {"size", "The size of the photographs as they were imported."},
    {"pattern", "Along the right ray through the projector's picture there is a point of the colour that the "
                "camera saw; along a wrong one only by chance."},
    {"surfaces", "Each view's own light gives the surface that it sees; those of neighbouring views are one "
                 "surface, unless something moved in between."},
    {"parallax",
     "In a whole scene, depth where no projector reaches comes from views that are near each other."},
};

// Placeholders as words in capitals.
static void put_word(FILE *out, const char *name, size_t length, const char *digits, const void *with) {
    static const char *const words[][2] = {
        {"view", "VIEW"}, {"other", "OTHER"}, {"figure", "N"}, {"limit", "N"}, {"x", "N"},
        {"y", "N"},       {"z", "N"},         {"a", "A"},      {"b", "B"},     {"c", "C"}};
    const FfpRule *rule = with;
    const char *word = NULL;
    for (size_t i = 0; i < sizeof words / sizeof *words; i++)
        if (strlen(words[i][0]) == length && strncmp(words[i][0], name, length) == 0) word = words[i][1];
    if (!word) fail_msg("%s: no value is called {%.*s}", rule->code, (int)length, name);
    if (digits[0] != 0 && (strcmp(word, "N") != 0 || digits[0] != '.' || !isdigit(digits[1]) ||
                           !strchr("fg%", digits[2]) || digits[3] != '}'))
        fail_msg("%s: {%s is not a number", rule->code, name);
    fputs(word, out);
    if (digits[0] == '.' && digits[2] == '%') fputs(" %", out);
}

static const char *meaning_of(const char *subject) {
    for (size_t i = 0; i < sizeof subjects / sizeof *subjects; i++)
        if (strcmp(subjects[i].subject, subject) == 0) return subjects[i].meaning;
    return NULL;
}

static void put_rule(FILE *out, const FfpRule *rule) {
    static const char *const severities[] = {"", "a note", "a doubt", "a fault"};
    fprintf(out, "\n**`%s`** (%s): ", rule->code, severities[rule->severity]);
    ffp_put_template(out, rule->sentence, put_word, rule);
    fputs(".\n", out);
    if (rule->advice) {
        fputs("What to do: ", out);
        ffp_put_template(out, rule->advice, put_word, rule);
        fputs(strchr("?!.", rule->advice[strlen(rule->advice) - 1]) ? "\n" : ".\n", out);
    }
    if (rule->measure && rule->limit > 0) fprintf(out, "Limit: %g, %s.\n", rule->limit, rule->measure);
}

static void write_page(FILE *out) {
    const char *subject = "";
    fputs("# Troubleshooting\n\n"
          "This page is made from `src/rig/findings/rules.c` (`FFP_WRITE=1 build/test_troubleshooting`), and "
          "holds every message "
          "about photographs, poses and calibrations by its code, which `ffprocams info --json` "
          "and "
          "`ffp_capture_check` give, too.\n"
          "A fault makes the result wrong: `reconstruct`, `refine` and `evaluate` refuse such a capture "
          "unless they are "
          "told `--force`; `calibrate` and `import` always refuse. A doubt makes the result worse, or may "
          "not be what you intended; notes are worth "
          "knowing.\n"
          "Capitals stand for names and numbers.\n",
          out);
    for (int id = 0; id < FFP_RULES; id++) {
        const FfpRule *rule = ffp_rule((FfpRuleId)id);
        if (rule->severity == FFP_FINDING_OK) continue;
        if (strcmp(subject, rule->subject) != 0) {
            const char *meaning = meaning_of(rule->subject);
            fprintf(out, "\n## %c%s\n", rule->subject[0] - 'a' + 'A', rule->subject + 1);
            if (meaning) fprintf(out, "\n%s\n", meaning);
        }
        subject = rule->subject;
        put_rule(out, rule);
    }
}

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
    write_page(out);
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

// --- The rules. ---

static void must_fill(const FfpRule *rule, const char *template) {
    char *text = NULL;
    size_t size = 0;
    FILE *out = open_memstream(&text, &size);
    if (template) ffp_put_template(out, template, put_word, rule);
    fclose(out);
    if (strpbrk(text, "{}")) fail_msg("%s has a brace too many: %s", rule->code, text);
    free(text);
}

static void every_rule_has_its_words(void **state) {
    (void)state;
    for (int id = 0; id < FFP_RULES; id++) {
        const FfpRule *rule = ffp_rule((FfpRuleId)id);
        if (!rule->code || !rule->subject || !rule->sentence) fail_msg("rule %d is empty", id);
        must_fill(rule, rule->sentence), must_fill(rule, rule->advice), must_fill(rule, rule->setting);
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
