// Memory, random numbers, files, error text.
#include <math.h>

#include "scratch.h"
#include "base/arena.h"
#include "base/log.h"
#include "base/rng.h"
#include "base/vec.h"

static void arena_gives_aligned_zeroed_memory(void **state) {
    (void)state;
    FfpArena *arena = ffp_arena_new();
    for (int pass = 0; pass < 3; pass++) {
        unsigned char *last = NULL;
        for (size_t i = 0; i < 300; i++) {
            const size_t size = (i * i * 37) % 50000; // 0 too
            unsigned char *block = ffp_arena_alloc(arena, size, 1);
            assert_int_equal((uintptr_t)block % 64, 0);
            assert_ptr_not_equal(block, last);
            for (size_t k = 0; k < size; k++) assert_int_equal(block[k], 0);
            memset(block, 0xff, size); // the next pass must see zeros again
            last = block;
        }
        unsigned char *large = ffp_arena_alloc(arena, 3, 1 << 20); // more than a chunk
        assert_int_equal(large[(3 << 20) - 1], 0);
        large[0] = 1;
        ffp_arena_reset(arena);
    }
    const size_t high = ffp_arena_high_water(arena);
    assert_true(high > (3U << 20) && high < (16U << 20));
    ffp_arena_alloc(arena, 1, 1);
    assert_int_equal(ffp_arena_high_water(arena), high);
    ffp_arena_free(arena);
    ffp_arena_free(NULL);
}

// The first numbers of PCG32's reference demonstration, seed 42 and stream 54.
static void random_numbers_are_pcg32(void **state) {
    (void)state;
    static const uint32_t want[6] = {0xa15c02b7, 0x7b47f409, 0xba1d3330, 0x83d2f293, 0xbfa4784b, 0xcbed606e};
    FfpRng rng = ffp_rng(42, 54);
    for (int i = 0; i < 6; i++) assert_int_equal(ffp_rng_u32(&rng), want[i]);
}

static void random_numbers_have_their_moments(void **state) {
    (void)state;
    enum { N = 200000 };
    FfpRng rng = ffp_rng(1, 2);
    double sum = 0, normal = 0, square = 0, counts[3] = {0};
    for (int i = 0; i < N; i++) {
        const float u = ffp_rng_uniform(&rng), n = ffp_rng_normal(&rng);
        assert_true(u >= 0 && u < 1 && isfinite(n));
        sum += u, normal += n, square += (double)n * n;
        counts[ffp_rng_below(&rng, 3)]++;
    }
    assert_true(fabs(sum / N - 0.5) < 0.003);
    assert_true(fabs(normal / N) < 0.01);
    assert_true(fabs(square / N - 1) < 0.02);
    for (int i = 0; i < 3; i++) assert_true(fabs(counts[i] / N - 1.0 / 3) < 0.005);
    for (int i = 0; i < 100; i++) assert_int_equal(ffp_rng_below(&rng, 1), 0);
    const float low = ffp_rng_range(&rng, 5, 6);
    assert_true(low >= 5 && low < 6);
}

static void errors_say_what_and_where(void **state) {
    (void)state;
    FfpError err = {0};
    assert_false(ffp_fail(&err, "a.json: views[3].c2w", "must be %d", 4));
    assert_string_equal(err.text, "must be 4 (a.json: views[3].c2w)");
    assert_false(ffp_fail(&err, NULL, "%s again", err.text)); // may quote itself
    assert_string_equal(err.text, "must be 4 (a.json: views[3].c2w) again");
    assert_false(ffp_fail(&err, NULL, "bell\a escape\033[31m line\n"));
    assert_string_equal(err.text, "bell? escape?[31m line?");
    assert_false(ffp_fail(NULL, NULL, "nobody listens"));
    char text[5000];
    memset(text, 'x', sizeof text);
    text[sizeof text - 1] = 0;
    assert_false(ffp_fail(&err, text, "%s", text));
    assert_int_equal(strlen(err.text), sizeof err.text - 1);
}

static void files_come_back_whole(void **state) {
    (void)state;
    char path[FFP_PATH_MAX], *data = NULL, bytes[200000];
    size_t size = 0;
    FfpError err = {0};
    for (size_t i = 0; i < sizeof bytes; i++) bytes[i] = (char)(i * 7);
    assert_true(ffp_join_path(path, scratch, "a"));
    assert_true(ffp_write_file(path, bytes, sizeof bytes, &err));
    assert_true(ffp_read_file(path, sizeof bytes, &data, &size, &err));
    assert_int_equal(size, sizeof bytes);
    assert_memory_equal(data, bytes, size);
    assert_int_equal(data[size], 0);
    free(data);
    assert_false(ffp_read_file(path, sizeof bytes - 1, &data, &size, &err));
    assert_non_null(strstr(err.text, "larger than 199999 bytes"));
    assert_null(data);
    assert_false(ffp_read_file(scratch, 100, &data, &size, &err));
    assert_non_null(strstr(err.text, "is a folder"));
    assert_true(ffp_write_file(path, "", 0, &err));
    assert_true(ffp_read_file(path, 0, &data, &size, &err));
    assert_int_equal(size, 0);
    free(data);
}

static int files_there(void) {
    char command[128];
    int count = -1;
    snprintf(command, sizeof command, "ls -A %s | wc -l", scratch);
    FILE *pipe = popen(command, "r");
    assert_non_null(pipe);
    assert_int_equal(fscanf(pipe, "%d", &count), 1);
    pclose(pipe);
    return count;
}

// The old file stays whole until commit, whatever happens to the new one.
static void an_aborted_file_changes_nothing(void **state) {
    (void)state;
    char path[FFP_PATH_MAX], *data = NULL;
    size_t size = 0;
    assert_true(ffp_join_path(path, scratch, "old"));
    assert_true(ffp_write_file(path, "old", 3, NULL));
    const int before = files_there();
    FfpOutput out;
    assert_true(ffp_output_open(&out, path, NULL));
    fputs("half", out.stream);
    fflush(out.stream);
    assert_true(ffp_read_file(path, 100, &data, &size, NULL));
    assert_string_equal(data, "old");
    free(data);
    ffp_output_abort(&out);
    ffp_output_abort(&out); // a second time does nothing
    assert_int_equal(files_there(), before);
    assert_true(ffp_output_open(&out, path, NULL));
    fputs("new", out.stream);
    assert_true(ffp_output_commit(&out, NULL));
    ffp_output_abort(&out);
    assert_true(ffp_read_file(path, 100, &data, &size, NULL));
    assert_string_equal(data, "new");
    free(data);
    assert_int_equal(files_there(), before);
}

static void impossible_files_are_errors(void **state) {
    (void)state;
    char path[FFP_PATH_MAX], deep[FFP_PATH_MAX], long_name[2000];
    FfpError err = {0};
    FfpOutput out;
    assert_true(ffp_join_path(path, scratch, "no/such/place"));
    assert_false(ffp_write_file(path, "x", 1, &err));
    assert_non_null(strstr(err.text, path));
    assert_false(ffp_output_open(&out, scratch, &err));
    ffp_output_abort(&out);
    memset(long_name, 'n', sizeof long_name);
    long_name[sizeof long_name - 1] = 0;
    assert_false(ffp_output_open(&out, long_name, &err));
    assert_false(ffp_join_path(path, scratch, long_name));
    assert_false(ffp_make_folders(long_name, &err));
    assert_false(ffp_make_folders("", &err));
    assert_true(ffp_join_path(deep, scratch, "d1/d2/d3/"));
    assert_true(ffp_make_folders(deep, &err));
    assert_true(ffp_make_folders(deep, &err));
    assert_true(ffp_is_folder(deep));
    assert_true(ffp_join_path(path, scratch, "plain"));
    assert_true(ffp_write_file(path, "x", 1, &err));
    assert_true(ffp_is_file(path) && !ffp_is_file(scratch));
    assert_true(ffp_join_path(deep, path, "below"));
    assert_false(ffp_make_folders(deep, &err)); // a file is in the way
}

static void paths_are_joined_and_split(void **state) {
    (void)state;
    char path[FFP_PATH_MAX];
    assert_true(ffp_join_path(path, "a/", "b"));
    assert_string_equal(path, "a/b");
    assert_true(ffp_join_path(path, "a", "b/c"));
    assert_string_equal(path, "a/b/c");
    assert_string_equal(ffp_basename("a/b/c"), "c");
    assert_string_equal(ffp_basename("c"), "c");
    assert_string_equal(ffp_basename("c/"), "");
}

static void poses_undo_themselves(void **state) {
    (void)state;
    const real pose[16] = {0, 0, 1, 3, 1, 0, 0, -2, 0, 1, 0, 5, 0, 0, 0, 1}, point[3] = {1, 2, 3};
    real world[3], back[3], cross[3];
    ffp_transform_point(pose, point, world);
    assert_true(world[0] == 6 && world[1] == -1 && world[2] == 7);
    ffp_inverse_transform_point(pose, world, back);
    for (int i = 0; i < 3; i++) assert_true(back[i] == point[i]);
    const real x[3] = {1, 0, 0}, y[3] = {0, 1, 0};
    ffp_cross3(x, y, cross);
    assert_true(cross[0] == 0 && cross[1] == 0 && cross[2] == 1);
    real zero[3] = {0, 0, 0};
    assert_true(ffp_normalise3(zero) == 0 && zero[0] == 0);
}

static void progress_counts_and_time_runs(void **state) {
    (void)state;
    const double before = ffp_seconds();
    FfpProgress progress = ffp_progress("testing", 10);
    ffp_progress_step(&progress, 5, NULL);
    assert_int_equal(progress.done, 5);
    ffp_progress_end(&progress);
    assert_int_equal(progress.done, 10);
    assert_true(ffp_seconds() >= before);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(arena_gives_aligned_zeroed_memory),
        cmocka_unit_test(random_numbers_are_pcg32),
        cmocka_unit_test(random_numbers_have_their_moments),
        cmocka_unit_test(errors_say_what_and_where),
        cmocka_unit_test(files_come_back_whole),
        cmocka_unit_test(an_aborted_file_changes_nothing),
        cmocka_unit_test(impossible_files_are_errors),
        cmocka_unit_test(paths_are_joined_and_split),
        cmocka_unit_test(poses_undo_themselves),
        cmocka_unit_test(progress_counts_and_time_runs),
    };
    return cmocka_run_group_tests(tests, scratch_setup, scratch_teardown);
}
