// Limits that a shell or a file sets: small stacks, small files, pictures that unpack to gigabytes.
#include <dirent.h>
#include "product/cli/program.h"
#include "product/cli/tiny.h"

#define SIDE 48
#ifdef FFP_SANITIZED
#define SMALL_STACK "-s 1024" // frames are several times as large
#else
#define SMALL_STACK "-s 128"
#endif

static ProgramRun run;

static int group_setup(void **state) {
    if (scratch_setup(state) != 0) return -1;
    char folder[128];
    snprintf(folder, sizeof folder, "%s/tiny", scratch);
    tiny_capture(folder, SIDE);
    return run_format(&run, "reconstruct %s/tiny -o %s/tiny.ply --model none --polish 0", scratch, scratch);
}

// The program under a limit of the shell's; returns its exit code, or 128 and the signal that ended it.
static int run_under(const char *limit, const char *arguments) {
    char command[2048], err[128];
    snprintf(err, sizeof err, "%s.err", scratch);
    assert_true((size_t)snprintf(command, sizeof command,
                                 "sh -c 'ulimit %s; \"%s\" %s; exit $?' >/dev/null 2>%s", limit, FFP_PROGRAM,
                                 arguments, err) < sizeof command);
    const int status = system(command);
    read_text(err, run.err, sizeof run.err);
    return status >> 8 & 0xff;
}

static int entries(const char *folder) {
    int count = 0;
    DIR *open = opendir(folder);
    assert_non_null(open);
    for (const struct dirent *entry; (entry = readdir(open));) count += entry->d_name[0] != '.';
    closedir(open);
    return count;
}

static void a_small_stack_is_enough(void **state) {
    (void)state;
    char arguments[512];
    snprintf(arguments, sizeof arguments, "reconstruct %s/tiny -o %s/stack.ply --model none --polish 2",
             scratch, scratch);
    assert_int_equal(run_under(SMALL_STACK, arguments), 0);
    snprintf(arguments, sizeof arguments, "render %s/stack.ply -c %s/tiny -p lollipop_0 -o %s/stack", scratch,
             scratch, scratch);
    assert_int_equal(run_under(SMALL_STACK, arguments), 0);
}

static void a_file_that_may_not_grow_is_an_error_and_leaves_nothing(void **state) {
    (void)state;
    char arguments[512], folder[FFP_PATH_MAX];
    snprintf(folder, sizeof folder, "%s", in_scratch("small"));
    assert_true(ffp_make_folders(folder, NULL));
    snprintf(arguments, sizeof arguments, "reconstruct %s/tiny -o %s/small/a.ply --model none --polish 0",
             scratch, scratch);
    assert_int_equal(run_under("-f 2", arguments), 1);
    assert_non_null(strstr(run.err, "cannot write"));
    assert_non_null(strstr(run.err, "a.ply"));
    assert_int_equal(entries(folder), 0);
}

// 16000 x 16000 pixels by its header, of which little follows.
static void a_picture_that_unpacks_to_gigabytes_is_refused_by_its_header(void **state) {
    (void)state;
    static const unsigned char bomb[] = {
        0x89, 0x50, 0x4e, 0x47, 0x0d, 0x0a, 0x1a, 0x0a, 0x00, 0x00, 0x00, 0x0d, 0x49, 0x48,
        0x44, 0x52, 0x00, 0x00, 0x3e, 0x80, 0x00, 0x00, 0x3e, 0x80, 0x08, 0x00, 0x00, 0x00,
        0x00, 0x64, 0x15, 0x80, 0x02, 0x00, 0x00, 0x00, 0x0c, 0x49, 0x44, 0x41, 0x54, 0x78,
        0x9c, 0x63, 0x60, 0xa0, 0x3d, 0x00, 0x00, 0x00, 0x64, 0x00, 0x01, 0x86, 0x64, 0x3c,
        0x35, 0x00, 0x00, 0x00, 0x00, 0x49, 0x45, 0x4e, 0x44, 0xae, 0x42, 0x60, 0x82};
    assert_true(ffp_write_file(in_scratch("bomb.png"), bomb, sizeof bomb, NULL));
    assert_int_equal(run_format(&run, "render %s/tiny.ply -c %s/tiny -p %s/bomb.png -o %s/never", scratch,
                                scratch, scratch, scratch),
                     1);
    assert_non_null(strstr(run.err, "16000 x 16000 pixels are too many"));
    assert_non_null(strstr(run.err, "at most 8192 x 8192"));
    assert_int_equal(run_format(&run,
                                "compensate %s/tiny.ply -c %s/tiny --view view_0 --target %s/bomb.png "
                                "-o %s/never.png",
                                scratch, scratch, scratch, scratch),
                     1);
    assert_non_null(strstr(run.err, "16000 x 16000 pixels are too many"));
    assert_false(ffp_is_folder(in_scratch("never")));
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_small_stack_is_enough),
        cmocka_unit_test(a_file_that_may_not_grow_is_an_error_and_leaves_nothing),
        cmocka_unit_test(a_picture_that_unpacks_to_gigabytes_is_refused_by_its_header),
    };
    return cmocka_run_group_tests(tests, group_setup, scratch_teardown);
}
