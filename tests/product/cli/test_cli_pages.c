// Manual pages and the completion of bash, as `ffprocams --pages` writes them.
#include <dirent.h>
#include "product/cli/program.h"

#define BEGIN "bash -c 'source %s/pages/ffprocams-completion.bash; COMP_WORDS=("
#define END "); COMP_CWORD=$((${#COMP_WORDS[@]} - 1)); _ffprocams; echo \"${COMPREPLY[*]}\"' >%s.out"

static ProgramRun run;

static int group_setup(void **state) {
    if (scratch_setup(state) != 0) return -1;
    return run_format(&run, "--pages %s/pages", scratch);
}

static char *read_page(const char *name) {
    char path[512], *text;
    size_t size;
    snprintf(path, sizeof path, "%s/pages/%s", scratch, name);
    assert_true(ffp_read_file(path, 1 << 20, &text, &size, NULL));
    return text;
}

// The parts of a page, each of them there and in this order.
static void check_parts(const char *name) {
    static const char *const parts[] = {
        ".TH ",        ".SH NAME\n",        ".SH SYNOPSIS\n", ".SH DESCRIPTION\n",
        ".SH OPTIONS", ".SH EXIT STATUS\n", ".SH EXAMPLES\n", ".SH SEE ALSO\n"};
    char *text = read_page(name);
    const char *at = text;
    for (size_t i = 0; i < sizeof parts / sizeof *parts; i++) {
        at = strstr(at, parts[i]);
        if (!at) printf("%s: no %s", name, parts[i]);
        assert_non_null(at);
    }
    ffp_free(text);
}

static void every_command_has_a_page_that_renders(void **state) {
    (void)state;
    char command[512], path[256];
    snprintf(path, sizeof path, "%s/pages", scratch);
    DIR *folder = opendir(path);
    assert_non_null(folder);
    const bool groff = system("command -v groff >/dev/null") == 0;
    if (!groff) printf("skipped: pages through groff (it is not installed)\n");
    int pages = 0;
    for (const struct dirent *entry; (entry = readdir(folder));) {
        if (!strstr(entry->d_name, ".1")) continue;
        check_parts(entry->d_name);
        pages++;
        // every warning but that of lines that cannot be broken
        snprintf(command, sizeof command,
                 "test -z \"$(groff -man -ww -Wbreak -Tutf8 -z %.100s/%.100s 2>&1)\"", path, entry->d_name);
        if (groff && system(command) != 0) fail_msg("%s does not render", entry->d_name);
    }
    closedir(folder);
    char *text = read_page("ffprocams.1");
    for (const char *at = text; (at = strstr(at, ".BR ffprocams\\-")); at++) pages--;
    assert_int_equal(pages, 1); // the program's own beside those it points to
    ffp_free(text);
}

static void a_page_says_what_help_says(void **state) {
    (void)state;
    char *text = read_page("ffprocams-compensate.1");
    assert_non_null(strstr(text, "\\fB\\-g, \\-\\-gain G|auto\\fR\n"));
    assert_non_null(strstr(text, "A projector can only add light."));
    assert_non_null(strstr(text, "\\-\\-capture\\~CAPTURE\n"));
    ffp_free(text);
}

#define REFERENCE FFP_SOURCE_DIR "/docs/reference/options.md"

// docs/reference/options.md is what the program writes: FFP_WRITE=1 writes it.
static void the_reference_is_that_of_the_tables(void **state) {
    (void)state;
    char *text = read_page("ffprocams-options.md"), *page = NULL;
    size_t size = 0;
    if (getenv("FFP_WRITE")) {
        FILE *out = fopen(REFERENCE, "w");
        assert_non_null(out);
        fputs(text, out);
        fclose(out);
    }
    assert_true(ffp_read_file(REFERENCE, 1 << 20, &page, &size, NULL));
    if (strcmp(text, page) != 0) fail_msg("%s is not that of the tables: FFP_WRITE=1 writes it", REFERENCE);
    ffp_free(text);
    ffp_free(page);
}

// The completions that bash would offer after these words.
static void completes(const char *words, const char *offered) {
    char command[1024], path[128], text[4096];
    snprintf(command, sizeof command, BEGIN "%s" END, scratch, words, scratch);
    assert_int_equal(system(command), 0);
    snprintf(path, sizeof path, "%s.out", scratch);
    read_text(path, text, sizeof text);
    text[strcspn(text, "\n")] = 0;
    if (strcmp(text, offered) != 0) printf("%s: offered \"%s\"\n", words, text);
    assert_string_equal(text, offered);
}

static void bash_completes_commands_options_and_values(void **state) {
    (void)state;
    if (system("command -v bash >/dev/null") != 0) {
        printf("skipped: completion (bash is not installed)\n");
        return;
    }
    completes("ffprocams re", "reconstruct refine render");
    completes("ffprocams --v", "--version");
    completes("ffprocams render --po", "--poses");
    completes("ffprocams map --", "--capture --output --poses --view --up --drawing --samples --help");
    completes("ffprocams render a.ply --drawing \"\"", "ours paper gs-procams");
    completes("ffprocams render a.ply --drawing = p", "paper");
    completes("ffprocams generate a --split =", "train validation test");
    completes("ffprocams evaluate -m no", "none");
    completes("ffprocams reconstruct a --layers \"\"", "auto all");
    completes("ffprocams reconstruct a --pattern \"\"", ""); // names are the capture's
    char words[256], path[256];
    snprintf(words, sizeof words, "ffprocams info %s/pages/ffprocams-comple", scratch);
    snprintf(path, sizeof path, "%s/pages/ffprocams-completion.bash", scratch);
    completes(words, path);
    snprintf(words, sizeof words, "ffprocams align %s -o %s/pa", scratch, scratch);
    snprintf(path, sizeof path, "%s/pages", scratch);
    completes(words, path);
}

static void pages_that_cannot_be_written_are_an_error(void **state) {
    (void)state;
    run_program(&run, "--pages /nowhere/pages");
    assert_int_equal(run.status, 1);
    assert_non_null(strstr(run.err, "/nowhere/pages"));
    run_program(&run, "--pages");
    assert_int_equal(run.status, 2);
    char path[128], command[1024], *before = read_page("ffprocams.1");
    snprintf(path, sizeof path, "--pages %s/pages/ffprocams.1", scratch);
    run_program(&run, path);
    assert_int_equal(run.status, 1);
    assert_non_null(strstr(run.err, "Not a directory (")); // of the file itself, not of what was to be in it
    assert_non_null(strstr(run.err, "/pages/ffprocams.1)"));
    // A disk that fills up half-way: files may hold 4 KiB. The old file stays, with nothing beside it.
    snprintf(command, sizeof command, "bash -c \"trap '' XFSZ; ulimit -f 4; '%s' --pages %s/pages\" 2>%s.err",
             FFP_PROGRAM, scratch, scratch);
    if (system("command -v bash >/dev/null") == 0) {
        assert_int_not_equal(system(command), 0);
        snprintf(path, sizeof path, "%s.err", scratch);
        read_text(path, run.err, sizeof run.err);
        assert_non_null(strstr(run.err, "cannot write: File too large"));
    }
    char *after = read_page("ffprocams.1"), *completion = read_page("ffprocams-completion.bash");
    assert_string_equal(after, before);
    assert_true(strlen(completion) > 4096);
    snprintf(command, sizeof command, "ls %s/pages | grep -q tmp", scratch);
    assert_int_not_equal(system(command), 0);
    ffp_free(before), ffp_free(after), ffp_free(completion);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_command_has_a_page_that_renders),
        cmocka_unit_test(a_page_says_what_help_says),
        cmocka_unit_test(the_reference_is_that_of_the_tables),
        cmocka_unit_test(bash_completes_commands_options_and_values),
        cmocka_unit_test(pages_that_cannot_be_written_are_an_error),
    };
    return cmocka_run_group_tests(tests, group_setup, scratch_teardown);
}
