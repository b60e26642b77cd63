// Scenes on disk: resumed, shared between runs, made by any number of threads; and a disk that is full.
// Labels: threads
#include <omp.h>
#include <signal.h>
#include <stdbool.h>
#include <sys/resource.h>
#include <unistd.h>
#include "core/base/file.h"
#include "support.h"
#include "world/synth/dataset.h"

static char root[64];

static int make_root(void **state) {
    (void)state;
    const char *above = getenv("FFP_SCRATCH"); // as in scratch.h
    snprintf(root, sizeof root, "%s%sffp_generate_XXXXXX", above ? above : "", above ? "/" : "");
    return mkdtemp(root) ? 0 : -1;
}

static int shell(const char *format, ...) __attribute__((format(printf, 1, 2)));
static int shell(const char *format, ...) {
    char command[2048];
    va_list args;
    va_start(args, format);
    vsnprintf(command, sizeof command, format, args);
    va_end(args);
    return system(command);
}

static int remove_root(void **state) {
    (void)state;
    return shell("rm -r %s", root);
}

static bool generate(const char *name, int64_t first, int64_t count, FfpError *err) {
    char folder[FFP_PATH_MAX];
    snprintf(folder, sizeof folder, "%s/%s", root, name);
    const FfpDatasetSettings options = {.folder = folder,
                                        .split = "test",
                                        .preset = FFP_DATASET_SMOKE,
                                        .first = first,
                                        .count = count,
                                        .resolution = 24};
    return ffp_dataset_write(&options, err);
}

static void must_generate(const char *name, int64_t first, int64_t count) {
    FfpError err = {0};
    if (!generate(name, first, count, &err)) fail_msg("%s", err.text);
}

static void threads_and_ranges_do_not_matter(void **state) {
    (void)state;
    const int threads = omp_get_max_threads();
    omp_set_num_threads(1);
    must_generate("whole", 3, 3);
    omp_set_num_threads(3);
    must_generate("shared", 4, 2);
    must_generate("shared", 3, 1);
    omp_set_num_threads(threads);
    assert_int_equal(shell("diff -r %s/whole %s/shared", root, root), 0);
    assert_int_equal(shell("test $(ls -A %s/shared | wc -l) = 3", root), 0);
}

static void a_stopped_run_goes_on(void **state) {
    (void)state;
    must_generate("resumed", 3, 2);
    // one scene is as a killed process leaves it, the other is whole and must not be touched
    assert_int_equal(
        shell("cd %s/resumed && mv test_00004 .test_00004.part && rm .test_00004.part/scene.json "
              "&& echo kept > test_00003/mark",
              root),
        0);
    must_generate("resumed", 3, 3);
    assert_int_equal(shell("cd %s/resumed && rm test_00003/mark", root), 0);
    assert_int_equal(shell("diff -r %s/resumed %s/whole", root, root), 0); // made without a stop, above
}

static void something_else_of_that_name_is_left_alone(void **state) {
    (void)state;
    FfpError err = {0};
    assert_int_equal(
        shell("mkdir -p %s/taken/test_00003 && echo mine > %s/taken/test_00003/notes", root, root), 0);
    assert_false(generate("taken", 3, 1, &err));
    assert_non_null(strstr(err.text, "test_00003"));
    assert_int_equal(shell("test \"$(cat %s/taken/test_00003/notes)\" = mine", root), 0);
    assert_int_equal(shell("test $(ls -A %s/taken | wc -l) = 1", root), 0);
}

// A limit on the size of files fails a write in the middle, as a full disk does.
static void a_full_disk_leaves_nothing_half_written(void **state) {
    (void)state;
    FfpError err = {0};
    struct rlimit before, small;
    assert_int_equal(getrlimit(RLIMIT_FSIZE, &before), 0);
    signal(SIGXFSZ, SIG_IGN);
    small = before;
    small.rlim_cur = 1500;
    assert_int_equal(setrlimit(RLIMIT_FSIZE, &small), 0);
    const bool ok = generate("full", 3, 2, &err);
    assert_int_equal(setrlimit(RLIMIT_FSIZE, &before), 0);
    assert_false(ok);
    assert_non_null(strstr(err.text, "cannot write"));
    assert_int_equal(shell("test $(ls -A %s/full | wc -l) = 0", root), 0);
    must_generate("full", 3, 1); // and with room again it works
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(threads_and_ranges_do_not_matter),
        cmocka_unit_test(a_stopped_run_goes_on),
        cmocka_unit_test(something_else_of_that_name_is_left_alone),
        cmocka_unit_test(a_full_disk_leaves_nothing_half_written),
    };
    return cmocka_run_group_tests(tests, make_root, remove_root);
}
