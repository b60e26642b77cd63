// A module that is not there, cannot be loaded, or is another version's is an error that says so; one that
// is there stays. TIFF's serves as the example.
#include <stdio.h>
#include "core/base/file.h"
#include "core/base/module.h"
#include "scratch.h"

static FfpModule tiff_of(int version) {
    return (FfpModule){"tiff", version, "TIFF files are read by libtiff", "the package of this test", NULL};
}

static void must_fail(FfpModule *module, const char *part) {
    FfpError err = {0};
    assert_null(ffp_module_load(module, &err));
    assert_int_equal(err.code, FFP_ERROR_UNSUPPORTED);
    if (!strstr(err.text, part)) fail_msg("\"%s\" is not in \"%s\"", part, err.text);
    assert_non_null(strstr(err.text, "(libffprocams-tiff.so)"));
}

static void what_is_wrong_is_said(void **state) {
    (void)state;
    FfpModule module = tiff_of(1), other = tiff_of(-1);
    must_fail(&other, "TIFF files are read by libtiff, whose module cannot be loaded: it belongs to another");
    setenv("FFPROCAMS_MODULES", scratch, 1);
    must_fail(&module, "TIFF files are read by libtiff, whose module is not installed: it comes with the "
                       "package of this test");
    assert_true(ffp_write_file(in_scratch("libffprocams-tiff.so"), "no module", 9, NULL));
    must_fail(&module, "whose module cannot be loaded: ");
    unsetenv("FFPROCAMS_MODULES");
    const void *table = ffp_module_load(&module, NULL); // an earlier failure is not kept
    assert_non_null(table);
    setenv("FFPROCAMS_MODULES", scratch, 1);
    assert_ptr_equal(ffp_module_load(&module, NULL), table); // but what was loaded is
    unsetenv("FFPROCAMS_MODULES");
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(what_is_wrong_is_said)};
    return cmocka_run_group_tests(tests, scratch_setup, scratch_teardown);
}
