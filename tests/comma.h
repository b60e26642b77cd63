// A locale that writes numbers with a comma, as hosts have it that call setlocale(LC_ALL, "") in German or
// French surroundings. It is compiled into the test's own folder (scratch.h), so that none need be installed.
#ifndef FFP_TESTS_COMMA_H
#define FFP_TESTS_COMMA_H

#include <locale.h>
#include "scratch.h"

static inline int with_comma(void) {
    char text[32];
    snprintf(text, sizeof text, "%.1f", 0.5);
    return strcmp(text, "0,5") == 0;
}

// The process has it from here on; 0 with a printed line when it cannot be made: the test should skip().
static inline int comma_locale(void) {
    static const char numeric[] = "LC_NUMERIC\ndecimal_point \"<U002C>\"\nthousands_sep \"\"\ngrouping -1\n"
                                  "END LC_NUMERIC\n";
    char command[256];
    // It warns of all the categories that there are not, and exits with 1.
    snprintf(command, sizeof command, "localedef -c -i '%s/comma.src' '%s/comma' >/dev/null 2>&1", scratch,
             scratch);
    uselocale(LC_GLOBAL_LOCALE);
    assert_true(ffp_write_file(in_scratch("comma.src"), numeric, sizeof numeric - 1, NULL));
    if (system(command) != -1 && setenv("LOCPATH", scratch, 1) == 0 && setlocale(LC_NUMERIC, "comma") &&
        with_comma())
        return 1;
    setlocale(LC_NUMERIC, "C");
    printf("skipped: no locale with commas can be compiled here (localedef, package locales)\n");
    return 0;
}

#endif
