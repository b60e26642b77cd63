// Memory, random numbers, files, error text.
#include <math.h>
#include "core/base/arena.h"
#include "core/base/exp2.h"
#include "core/base/listing.h"
#include "core/base/log.h"
#include "core/base/rng.h"
#include "core/base/text.h"
#include "core/base/vec.h"
#include "scratch.h"

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
static void texts_are_copied_and_escaped(void **state) {
    (void)state;
    FfpArena *arena = ffp_arena_new();
    char name[] = "a \"b\" <c> & d";
    const char *copy = ffp_arena_text(arena, name), *none = ffp_arena_text(arena, "");
    name[0] = 'x';
    assert_string_equal(copy, "a \"b\" <c> & d");
    assert_string_equal(none, "");
    FfpText *page = ffp_text_new();
    ffp_put_html(ffp_text_stream(page), copy);
    char *text = ffp_text_end(page);
    assert_string_equal(text, "a &quot;b&quot; &lt;c&gt; &amp; d");
    ffp_free(text);
    ffp_arena_free(arena);
}

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
    assert_false(ffp_fail(&err, FFP_ERROR_FILE, "a.json: views[3].c2w", "must be %d", 4));
    assert_string_equal(err.text, "must be 4 (a.json: views[3].c2w)");
    assert_string_equal(err.where, "a.json: views[3].c2w");
    assert_int_equal(err.code, FFP_ERROR_FILE);
    assert_false(ffp_fail(&err, FFP_ERROR_FILE, err.where, "%s again", err.text)); // may quote itself
    assert_string_equal(err.text, "must be 4 (a.json: views[3].c2w) again (a.json: views[3].c2w)");
    assert_string_equal(err.where, "a.json: views[3].c2w");
    assert_false(ffp_fail(&err, FFP_ERROR_ARGUMENT, "(\n)", "no"));
    assert_string_equal(err.where, "(?)");
    assert_false(ffp_fail(&err, FFP_ERROR_ARGUMENT, NULL, "bell\a escape\033[31m line\n"));
    assert_string_equal(err.text, "bell? escape?[31m line?");
    assert_string_equal(err.where, "");
    assert_false(ffp_fail(NULL, FFP_ERROR_ARGUMENT, NULL, "nobody listens"));
    char text[5000];
    memset(text, 'x', sizeof text);
    text[sizeof text - 1] = 0;
    assert_false(ffp_fail(&err, FFP_ERROR_ARGUMENT, text, "%s", text));
    assert_int_equal(strlen(err.text), sizeof err.text - 1);
    assert_int_equal(strlen(err.where), sizeof err.where - 1);
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
    ffp_free(data);
    assert_false(ffp_read_file(path, sizeof bytes - 1, &data, &size, &err));
    assert_non_null(strstr(err.text, "larger than 199999 bytes"));
    assert_null(data);
    assert_false(ffp_read_file(scratch, 100, &data, &size, &err));
    assert_non_null(strstr(err.text, "is a folder"));
    assert_true(ffp_write_file(path, "", 0, &err));
    assert_true(ffp_read_file(path, 0, &data, &size, &err));
    assert_int_equal(size, 0);
    ffp_free(data);
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
    ffp_free(data);
    ffp_output_abort(&out);
    ffp_output_abort(&out); // a second time does nothing
    assert_int_equal(files_there(), before);
    assert_true(ffp_output_open(&out, path, NULL));
    fputs("new", out.stream);
    assert_true(ffp_output_commit(&out, NULL));
    ffp_output_abort(&out);
    assert_true(ffp_read_file(path, 100, &data, &size, NULL));
    assert_string_equal(data, "new");
    ffp_free(data);
    assert_int_equal(files_there(), before);
}

static mode_t mode_of(const char *path) {
    struct stat about;
    assert_int_equal(lstat(path, &about), 0);
    return about.st_mode;
}

static void expect_text(const char *path, const char *want) {
    char *data;
    size_t size;
    assert_true(ffp_read_file(path, 100, &data, &size, NULL));
    assert_string_equal(data, want);
    ffp_free(data);
}

// A link stays a link; what it leads to is replaced, or made.
static void links_are_written_through(void **state) {
    (void)state;
    FfpError err = {0};
    assert_true(ffp_make_folders(in_scratch("real"), NULL));
    assert_true(ffp_write_file(in_scratch("real/file"), "old", 3, NULL));
    assert_int_equal(symlink("real/file", in_scratch("link")), 0);
    assert_int_equal(symlink("link", in_scratch("second")), 0);
    assert_int_equal(symlink("real/new", in_scratch("dangling")), 0);
    assert_int_equal(symlink("circle", in_scratch("circle")), 0);
    const int before = files_there();
    assert_true(ffp_output_probe(in_scratch("second"), &err));
    assert_true(ffp_write_file(in_scratch("second"), "new", 3, &err));
    expect_text(in_scratch("real/file"), "new");
    assert_true(S_ISLNK(mode_of(in_scratch("second"))) && S_ISLNK(mode_of(in_scratch("link"))));
    assert_true(ffp_write_file(in_scratch("dangling"), "made", 4, &err));
    expect_text(in_scratch("real/new"), "made");
    assert_true(S_ISLNK(mode_of(in_scratch("dangling"))));
    assert_false(ffp_write_file(in_scratch("circle"), "x", 1, &err));
    assert_non_null(strstr(err.text, "circle"));
    assert_int_equal(files_there(), before);
}

// Neither opened (which would wait for a reader) nor replaced.
static void what_is_no_regular_file_is_refused(void **state) {
    (void)state;
    char *data;
    size_t size;
    FfpError err = {0};
    assert_int_equal(mkfifo(in_scratch("fifo"), 0600), 0);
    assert_int_equal(symlink("/dev/null", in_scratch("nowhere")), 0);
    const struct {
        const char *path, *words;
    } cases[4] = {{in_scratch("fifo"), "a FIFO or pipe has this name"},
                  {"/dev/null", "a device has this name"},
                  {in_scratch("nowhere"), "a device has this name"},
                  {scratch, "a folder has this name"}};
    for (int k = 0; k < 4; k++) {
        assert_false(ffp_output_probe(cases[k].path, &err));
        if (!strstr(err.text, cases[k].words)) fail_msg("%s", err.text);
        assert_false(ffp_write_file(cases[k].path, "x", 1, &err));
        assert_null(ffp_open_to_grow(cases[k].path, false, &err));
        assert_non_null(strstr(err.text, cases[k].words));
    }
    assert_true(S_ISFIFO(mode_of(in_scratch("fifo"))));
    assert_true(S_ISCHR(mode_of("/dev/null")));
    assert_false(ffp_read_file(in_scratch("fifo"), 100, &data, &size, &err));
    assert_non_null(strstr(err.text, "is a FIFO or pipe, not a file"));
    assert_false(ffp_read_file("/dev/null", 100, &data, &size, &err));
    assert_non_null(strstr(err.text, "is a device, not a file"));
}

// /dev/stdout and its like lead to open files, which have no name of their own: a pipe's "pipe:[123]" is
// none.
static void open_files_are_no_targets(void **state) {
    (void)state;
    int ends[2];
    char path[64];
    FfpError err = {0};
    assert_int_equal(pipe(ends), 0);
    snprintf(path, sizeof path, "/proc/self/fd/%d", ends[1]);
    assert_false(ffp_output_probe(path, &err));
    assert_non_null(strstr(err.text, "open file, pipe or terminal"));
    close(ends[0]);
    close(ends[1]);
}

static void permissions_stay(void **state) {
    (void)state;
    const mode_t mask = umask(027);
    assert_true(ffp_write_file(in_scratch("fresh"), "a", 1, NULL));
    umask(mask);
    assert_int_equal(mode_of(in_scratch("fresh")) & 0777, 0640);
    assert_int_equal(chmod(in_scratch("fresh"), 0604), 0);
    assert_true(ffp_write_file(in_scratch("fresh"), "b", 1, NULL));
    assert_int_equal(mode_of(in_scratch("fresh")) & 0777, 0604);
}

// Who can guess the temporary name must not be able to lead the writer elsewhere by a link of that name.
static void a_planted_temporary_is_not_followed(void **state) {
    (void)state;
    char planted[FFP_PATH_MAX], name[64];
    assert_true(ffp_write_file(in_scratch("victim"), "whole", 5, NULL));
    snprintf(name, sizeof name, "guess.%ld.tmp", (long)getpid());
    snprintf(planted, sizeof planted, "%s", in_scratch(name));
    assert_int_equal(symlink("victim", planted), 0);
    assert_true(ffp_write_file(in_scratch("guess"), "mine", 4, NULL));
    expect_text(in_scratch("victim"), "whole");
    expect_text(in_scratch("guess"), "mine");
    assert_int_equal(unlink(planted), 0);
}

static void put(const FfpOutput *folder, const char *name) {
    char path[FFP_PATH_MAX];
    assert_true(ffp_join_path(path, folder->temporary, name));
    assert_true(ffp_write_file(path, "x", 1, NULL));
}

static void folders_appear_whole_or_not_at_all(void **state) {
    (void)state;
    FfpOutput out;
    FfpError err = {0};
    const char *path = in_scratch("deep/maps");
    assert_true(ffp_output_probe_folder(path, &err));
    assert_true(ffp_output_open_folder(&out, path, false, &err));
    put(&out, "a");
    assert_false(ffp_is_folder(path));
    ffp_output_abort(&out);
    assert_int_equal(rmdir(in_scratch("deep")), 0); // nothing is left in it
    assert_true(ffp_output_open_folder(&out, path, false, &err));
    put(&out, "a");
    assert_true(ffp_output_commit(&out, &err));
    assert_true(ffp_is_file(in_scratch("deep/maps/a")));
    // an existing folder is filled in place, and kept
    assert_true(ffp_output_open_folder(&out, in_scratch("deep/maps/"), false, &err));
    put(&out, "b");
    ffp_output_abort(&out);
    assert_true(ffp_is_file(in_scratch("deep/maps/a")) && ffp_is_file(in_scratch("deep/maps/b")));
    // unless it has to be fresh
    assert_true(ffp_output_open_folder(&out, in_scratch("deep/maps"), true, &err));
    put(&out, "c");
    assert_false(ffp_output_commit(&out, &err));
    assert_non_null(strstr(err.text, "not empty"));
    assert_false(ffp_is_file(in_scratch("deep/maps/c")));
}

static void folders_are_made_through_links(void **state) {
    (void)state;
    FfpOutput out;
    FfpError err = {0};
    assert_int_equal(symlink("elsewhere/inner", in_scratch("folder")), 0);
    assert_true(ffp_output_open_folder(&out, in_scratch("folder"), true, &err));
    put(&out, "a");
    assert_true(ffp_output_commit(&out, &err));
    assert_true(S_ISLNK(mode_of(in_scratch("folder"))));
    assert_true(ffp_is_file(in_scratch("elsewhere/inner/a")));
    assert_int_equal(symlink("made/inner", in_scratch("second_folder")), 0);
    if (!ffp_make_folders(in_scratch("second_folder/x"), &err)) fail_msg("%s", err.text);
    assert_true(ffp_is_folder(in_scratch("made/inner/x")));
    assert_int_equal(symlink("round", in_scratch("round")), 0);
    assert_false(ffp_make_folders(in_scratch("round/x"), &err));
    assert_false(ffp_output_probe_folder("/dev/null", &err));
    assert_false(ffp_output_probe_folder("/dev/null/x", &err));
}

static void text_is_read_without_its_byte_order_mark(void **state) {
    (void)state;
    char *text;
    size_t size;
    FfpError err = {0};
    assert_true(ffp_write_file(in_scratch("bom"), "\xEF\xBB\xBF{}", 5, NULL));
    assert_true(ffp_read_text(in_scratch("bom"), 100, &text, &size, &err));
    assert_string_equal(text, "{}");
    assert_int_equal(size, 2);
    ffp_free(text);
    assert_true(ffp_write_file(in_scratch("bom"), "\xFF\xFE{\0}\0", 6, NULL));
    assert_false(ffp_read_text(in_scratch("bom"), 100, &text, &size, &err));
    assert_non_null(strstr(err.text, "UTF-16"));
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

static void close_to(double value, double want, double relative) {
    if (!(fabs(value - want) <= relative * fabs(want))) fail_msg("%.9g is not %.9g", value, want);
}

static void powers_and_logarithms_are_libms(void **state) {
    (void)state;
    for (float x = -100; x < 87; x += 0.0137F) {
        close_to((double)ffp_exp2(x), exp2((double)x), 2.5e-7);
        if (x > -87) close_to((double)ffp_exp(x), exp((double)x), 2e-7);
    }
    for (float x = 1e-37F; x < 1e37F; x *= 1.00371F) {
        const double want = log2((double)x);
        assert_true(fabs((double)ffp_log2(x) - want) <= 1e-7 * fmax(fabs(want), 1));
    }
    assert_true(ffp_log2(1) == 0 && ffp_exp2(0) == ffp_exp2(-0.0F) && isnan(ffp_exp2(NAN)));
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

static void time_runs(void **state) {
    (void)state;
    const double before = ffp_seconds();
    assert_true(ffp_seconds() >= before);
}

static void names_in_a_folder_are_listed_in_order(void **state) {
    (void)state;
    static const char *const names[] = {"b", "a_1", "B", ".hidden", "a_10"};
    static const char *const sorted[] = {".hidden", "B", "a_1", "a_10", "b"};
    FfpListing listing;
    char folder[FFP_PATH_MAX], path[FFP_PATH_MAX];
    snprintf(folder, sizeof folder, "%s", in_scratch("listed"));
    assert_true(ffp_make_folders(folder, NULL));
    assert_true(ffp_list_folder(&listing, folder));
    assert_int_equal(listing.count, 0);
    ffp_free(listing.names);
    for (int i = 0; i < 5; i++) {
        assert_true(ffp_join_path(path, folder, names[i]));
        assert_true(ffp_write_file(path, "", 0, NULL));
    }
    assert_true(ffp_list_folder(&listing, folder));
    assert_int_equal(listing.count, 5);
    for (int i = 0; i < 5; i++) assert_string_equal(listing.names[i], sorted[i]);
    ffp_free(listing.names);
    assert_false(ffp_list_folder(&listing, in_scratch("nowhere")));
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(arena_gives_aligned_zeroed_memory),
        cmocka_unit_test(texts_are_copied_and_escaped),
        cmocka_unit_test(random_numbers_are_pcg32),
        cmocka_unit_test(random_numbers_have_their_moments),
        cmocka_unit_test(errors_say_what_and_where),
        cmocka_unit_test(files_come_back_whole),
        cmocka_unit_test(an_aborted_file_changes_nothing),
        cmocka_unit_test(links_are_written_through),
        cmocka_unit_test(what_is_no_regular_file_is_refused),
        cmocka_unit_test(open_files_are_no_targets),
        cmocka_unit_test(permissions_stay),
        cmocka_unit_test(a_planted_temporary_is_not_followed),
        cmocka_unit_test(folders_appear_whole_or_not_at_all),
        cmocka_unit_test(folders_are_made_through_links),
        cmocka_unit_test(text_is_read_without_its_byte_order_mark),
        cmocka_unit_test(impossible_files_are_errors),
        cmocka_unit_test(paths_are_joined_and_split),
        cmocka_unit_test(names_in_a_folder_are_listed_in_order),
        cmocka_unit_test(poses_undo_themselves),
        cmocka_unit_test(powers_and_logarithms_are_libms),
        cmocka_unit_test(time_runs),
    };
    return cmocka_run_group_tests(tests, scratch_setup, scratch_teardown);
}
