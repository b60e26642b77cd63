// What a program meets that was compiled with other headers than the library.
#include <stdio.h>
#include "ffprocams.h"
#include "support.h"

static void versions_agree(void **state) {
    (void)state;
    char text[64];
    snprintf(text, sizeof text, "%d.%d.%d", FFPROCAMS_VERSION_MAJOR, FFPROCAMS_VERSION_MINOR,
             FFPROCAMS_VERSION_PATCH);
    assert_string_equal(ffp_version(), text);
    int major, minor, patch;
    assert_int_equal(sscanf(ffp_version(), "%d.%d.%d", &major, &minor, &patch), 3);
    assert_int_equal(FFPROCAMS_VERSION, FFPROCAMS_VERSION_NUMBER(major, minor, patch));
    assert_true(FFPROCAMS_VERSION_NUMBER(0, 4, 0) > FFPROCAMS_VERSION_NUMBER(0, 3, 12));
    assert_true(FFPROCAMS_VERSION_NUMBER(1, 0, 0) > FFPROCAMS_VERSION_NUMBER(0, 40, 40));
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(versions_agree),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
