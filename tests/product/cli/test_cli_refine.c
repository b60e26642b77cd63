// Refining, fits from scratch and films, through the command line only.
#include <signal.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <time.h>
#include "core/gaussians/gaussians.h"
#include "product/cli/program.h"
#include "product/cli/tiny.h"

#define SIDE 48

static ProgramRun run;

static int group_setup(void **state) {
    if (scratch_setup(state) != 0) return -1;
    char folder[128];
    snprintf(folder, sizeof folder, "%s/tiny", scratch);
    tiny_capture(folder, SIDE);
    return run_format(&run, "reconstruct %s/tiny -o %s/tiny.ply --model none", scratch, scratch);
}

// The two figures of the line that tells of the result.
static void read_gain(double *before, double *after) {
    const char *at = strstr(run.out, "Gaussians, ");
    assert_non_null(at);
    assert_int_equal(sscanf(at, "Gaussians, %lf -> %lf dB", before, after), 2);
}

static void test_refining_gains_and_tells_of_each_round(void **state) {
    (void)state;
    double before, after;
    assert_int_equal(
        run_format(&run, "refine %s/tiny.ply -c %s/tiny -o %s/better.ply --steps 96 --metrics %s/m.json",
                   scratch, scratch, scratch, scratch),
        0);
    read_gain(&before, &after);
    assert_true(after > before + 1);
    assert_true(ffp_is_file(in_scratch("better.ply")));
    FILE *file = fopen(in_scratch("m.json"), "r");
    char line[256];
    int lines = 0;
    for (; fgets(line, sizeof line, file); lines++) {
        json_t *row = json_loads(line, 0, NULL);
        assert_int_equal(json_integer_value(json_object_get(row, "step")), TINY_VIEWS * (lines + 1));
        assert_true(json_real_value(json_object_get(row, "psnr")) > 10);
        json_decref(row);
    }
    fclose(file);
    assert_int_equal(lines, 96 / TINY_VIEWS);
    // A fit that fails leaves the file as it is.
    run_format(&run, "refine %s/tiny.ply -c %s/tiny -o %s/better.ply -p none --metrics %s/m.json", scratch,
               scratch, scratch, scratch);
    assert_non_null(strstr(run.err, "none"));
    struct stat kept;
    assert_int_equal(stat(in_scratch("m.json"), &kept), 0);
    assert_true(kept.st_size > 0);
}

static const json_t *row_of(const json_t *root, const char *protocol) {
    size_t i;
    const json_t *row;
    json_array_foreach(json_object_get(root, "rows"), i,
                       row) if (strcmp(json_string_value(json_object_get(row, "protocol")), protocol) ==
                                0) return row;
    fail_msg("no row %s", protocol);
    return NULL;
}

// The lines that a reconstruction ends with: as many Gaussians as the file has, and the PSNR that `evaluate`
// finds on the photographs that were given and on those held out (there rounded to 8 bits).
static void test_a_reconstruction_says_how_good_it_is(void **state) {
    (void)state;
    char least[64];
    long long said, held;
    double psnr, worst, seconds, unseen, lit, own;
    assert_int_equal(run_format(&run, "--events 2 reconstruct %s/tiny -o %s/said.ply --model none --polish 8",
                                scratch, scratch),
                     0);
    assert_int_equal(sscanf(strrchr(run.out, '/'),
                            "/said.ply: %lld Gaussians from lollipop_0: %lf dB on its photographs (least: "
                            "%63[^,], %lf dB), %lf s (",
                            &said, &psnr, least, &worst, &seconds),
                     5);
    assert_int_equal(
        sscanf(strchr(run.out, '\n'),
               "\non patterns that no fit has seen: %lf dB (where lit: %lf dB, and %lf dB on its own "
               "photographs)\n",
               &unseen, &lit, &own),
        3);
    assert_non_null(strstr(run.err, lit < 22 ? "\"unseen-badly-predicted\"" : "\"unseen-predicted\""));
    assert_true(worst < psnr && worst > psnr - 6 && seconds > 0);
    assert_int_equal(run_format(&run, "info %s/said.ply", scratch), 0);
    assert_int_equal(sscanf(run.out, "Gaussians %lld", &held), 1);
    assert_true(held == said);
    assert_int_equal(
        run_format(&run, "evaluate %s/tiny -g %s/said.ply --json %s/said.json", scratch, scratch, scratch),
        0);
    json_t *root = json_load_file(in_scratch("said.json"), 0, NULL);
    const double given = json_number_value(json_object_get(row_of(root, "given"), "psnr")),
                 novel = json_number_value(json_object_get(row_of(root, "novel_pattern"), "psnr"));
    json_decref(root);
    assert_true(fabs(given - psnr) < 0.1 && fabs(novel - unseen) < 0.1 && lit < unseen && own < psnr);
    assert_int_equal(run_format(&run, "info %s/tiny", scratch), 0);
    assert_non_null(strstr(run.out, least));
}

static void test_several_patterns(void **state) {
    (void)state;
    const char *at;
    double unseen;
    assert_int_equal(run_format(&run,
                                "reconstruct %s/tiny -o %s/both.ply --model none --polish 8 -p lollipop_0 "
                                "-p lollipop_1",
                                scratch, scratch),
                     0);
    assert_non_null(strstr(run.out, " Gaussians from lollipop_0, lollipop_1: "));
    assert_int_equal(run_format(&run,
                                "refine %s/both.ply -c %s/tiny -o %s/both_2.ply --steps 8 -p lollipop_0 "
                                "-p lollipop_1",
                                scratch, scratch, scratch),
                     0);
    // The file says what it was made from: nothing is unseen then. Refined with one more, it says that too.
    assert_int_equal(run_format(&run, "info %s/both.ply", scratch), 0);
    assert_non_null(strstr(run.out, "made from    lollipop_0, lollipop_1\n"));
    assert_int_equal(run_format(&run, "refine %s/tiny.ply -c %s/tiny -o %s/more.ply --steps 4 -p lollipop_1",
                                scratch, scratch, scratch),
                     0);
    assert_int_equal(run_format(&run, "info %s/more.ply", scratch), 0);
    assert_non_null(strstr(run.out, "made from    lollipop_0, lollipop_1\n"));
    static const char *const kinds[] = {"both", "tiny"};
    for (int k = 0; k < 2; k++) {
        assert_int_equal(run_format(&run, "evaluate %s/tiny --gaussians %s/%s.ply --json %s/of_file.json",
                                    scratch, scratch, kinds[k], scratch),
                         0);
        json_t *rows = json_load_file(in_scratch("of_file.json"), 0, NULL);
        const json_t *row = row_of(rows, "rendering");
        assert_int_equal(json_is_null(json_object_get(row, "psnr_unseen_lollipops")), k == 0);
        json_decref(rows);
    }
    // The second lollipop is unseen where it is not given.
    assert_int_equal(
        run_format(
            &run,
            "evaluate %s/tiny --model none --polish 0 -p lollipop_0 --json %s/one.json --report %s/one.html",
            scratch, scratch, scratch),
        0);
    assert_int_equal(run_format(&run,
                                "evaluate %s/tiny --model none --polish 0 -p lollipop_0 -p lollipop_1 --json "
                                "%s/two.json --report %s/two.html",
                                scratch, scratch, scratch),
                     0);
    assert_true(ffp_is_file(in_scratch("two.html")));
    json_t *one = json_load_file(in_scratch("one.json"), 0, NULL),
           *two = json_load_file(in_scratch("two.json"), 0, NULL);
    at = "psnr_unseen_lollipops";
    unseen = json_number_value(json_object_get(row_of(one, "rendering"), at));
    assert_true(unseen > 10);
    assert_true(json_is_null(json_object_get(row_of(two, "rendering"), at)));
    json_decref(one), json_decref(two);
    assert_int_equal(
        run_format(&run, "reconstruct %s/tiny -o %s/never.ply --model none -p lollipop_1 -p lollipop_1",
                   scratch, scratch),
        1);
    assert_non_null(strstr(run.err, "'lollipop_1' is named twice"));
    assert_null(strstr(run.err, "repeat -p"));
    assert_int_equal(run_format(&run,
                                "reconstruct %s/tiny -o %s/never.ply --model none -p lollipop_0,lollipop_1",
                                scratch, scratch),
                     1);
    assert_non_null(strstr(run.err, "no pattern 'lollipop_0,lollipop_1'"));
    assert_non_null(strstr(run.err, "repeat -p for several: -p A -p B"));
    assert_false(ffp_is_file(in_scratch("never.ply")));
}

static void test_from_scratch_needs_no_gaussians(void **state) {
    (void)state;
    double before, after, given;
    assert_int_equal(
        run_format(&run,
                   "refine --from-scratch=gaussians -c %s/tiny -o %s/scratch.ply --steps 24 --pattern "
                   "lollipop_0 --pattern lollipop_1",
                   scratch, scratch),
        0);
    read_gain(&before, &after);
    assert_true(after > before + 1);
    assert_true(ffp_is_file(in_scratch("scratch.ply")));
    assert_int_equal(
        run_format(&run, "refine %s/tiny.ply --from-scratch=gaussians -c %s/tiny -o %s/given.ply --steps 24",
                   scratch, scratch, scratch),
        0);
    read_gain(&before, &given);
    assert_true(given > before + 1);
    assert_true(ffp_is_file(in_scratch("given.ply")));
}

static void test_a_field_is_fitted_and_evaluated(void **state) {
    (void)state;
    assert_int_equal(run_format(&run,
                                "refine --from-scratch=field -c %s/tiny -o %s/tiny.field --steps 100 "
                                "--metrics %s/field.jsonl",
                                scratch, scratch, scratch),
                     0);
    double psnr = 0;
    const char *at = strstr(run.out, "neural field, ");
    assert_non_null(at);
    assert_int_equal(sscanf(at, "neural field, %lf dB", &psnr), 1);
    assert_true(psnr > 15);
    assert_true(ffp_is_file(in_scratch("field.jsonl")));
    assert_int_equal(run_format(&run, "info %s/tiny.field", scratch), 0);
    assert_non_null(strstr(run.out, "neural field "));
    assert_non_null(strstr(run.out, "info, evaluate"));
    static const char *const others[] = {"render %s/tiny.field -c %s/tiny -o %s/never",
                                         "reconstruct %s/tiny.field -o %s/never --model none",
                                         "reconstruct %s/tiny -o %s/never --model %s/tiny.field",
                                         "refine %s/tiny.field -c %s/tiny -o %s/never.ply"};
    for (size_t i = 0; i < sizeof others / sizeof *others; i++) {
        run_format(&run, others[i], scratch, scratch, scratch);
        assert_int_equal(run.status, 1);
        assert_non_null(strstr(run.err, "is a neural field, which only `info` and `evaluate` read, not "));
    }
    assert_int_equal(run_format(&run, "evaluate %s/tiny --field %s/tiny.ply", scratch, scratch), 1);
    assert_non_null(strstr(run.err, "is Gaussians (a PLY), not a neural field"));
    assert_int_equal(run_format(&run, "evaluate %s/tiny --field %s/tiny.field", scratch, scratch), 0);
    assert_non_null(strstr(run.out, "rendering"));
    assert_int_equal(run_format(&run, "evaluate %s/tiny --field %s/tiny.ply", scratch, scratch), 1);
    assert_int_equal(run_format(&run, "evaluate %s/tiny --field a --gaussians %s/tiny.ply", scratch, scratch),
                     2);
}

// Of Gaussians in a file, on all photographs.
static double psnr_of_gaussians(const char *name) {
    assert_int_equal(run_format(&run, "evaluate %s/tiny --gaussians %s/%s.ply --json %s/of_file.json",
                                scratch, scratch, name, scratch),
                     0);
    json_t *root = json_load_file(in_scratch("of_file.json"), 0, NULL);
    const json_t *row = row_of(root, "rendering");
    const double psnr = json_number_value(json_object_get(row, "psnr"));
    printf("%s: %.2f dB\n", name, psnr);
    json_decref(root);
    return psnr;
}

static void test_an_interrupt_keeps_the_best_so_far(void **state) {
    (void)state;
    char ply[128], capture[128], out[128], metrics[128];
    snprintf(ply, sizeof ply, "%s/start.ply", scratch);
    snprintf(capture, sizeof capture, "%s/tiny", scratch);
    snprintf(out, sizeof out, "%s/stopped.ply", scratch);
    snprintf(metrics, sizeof metrics, "%s/stopped.json", scratch);
    assert_int_equal(run_format(&run, "reconstruct %s -o %s --model none --polish 0", capture, ply), 0);
    const char *const arguments[] = {FFP_PROGRAM, "refine",    ply,     "-c",        capture, "-o",
                                     out,         "--seconds", "10000", "--metrics", metrics, NULL};
    const pid_t child = fork();
    if (child == 0) {
        if (!freopen("/dev/null", "w", stdout) || !freopen("/dev/null", "w", stderr)) _exit(126);
        execv(FFP_PROGRAM, (char *const *)arguments);
        _exit(127);
    }
    struct stat info = {0};
    for (int i = 0; i < 6000 && (stat(metrics, &info) != 0 || info.st_size == 0); i++) // the first round
        nanosleep(&(struct timespec){0, 10000000}, NULL);
    kill(child, SIGINT);
    int status;
    assert_int_equal(waitpid(child, &status, 0), child);
    assert_true(WIFEXITED(status) && WEXITSTATUS(status) == 0);
    assert_true(psnr_of_gaussians("stopped") > psnr_of_gaussians("start") + 0.5);
}

static void test_wrong_requests_are_told_and_write_nothing(void **state) {
    (void)state;
    assert_int_equal(run_format(&run, "refine %s/tiny.ply -c %s/tiny", scratch, scratch), 2);
    assert_int_equal(run_format(&run, "refine -c %s/tiny -o a.ply", scratch), 2);
    assert_int_equal(
        run_format(&run, "refine %s/tiny.ply --from-scratch=field -c %s/tiny -o a.field", scratch, scratch),
        2);
    static const char *const wrong[][2] = {
        {"refine --from-scratch=field -c %s/tiny -o %s/b.PLY", "a field is not a PLY file: name "},
        {"refine --from-scratch=gaussians -c %s/tiny -o %s/b.field", "Gaussians are not a field: name "},
        {"refine --from-scratch=field -c %s/tiny -o %s/b.field --drawing ours",
         "--drawing applies to Gaussians only"},
        {"refine --from-scratch=field -c %s/tiny -o %s/b.field --samples 2",
         "--samples applies to Gaussians only"}};
    for (size_t i = 0; i < sizeof wrong / sizeof *wrong; i++) {
        assert_int_equal(run_format(&run, wrong[i][0], scratch, scratch), 2);
        assert_non_null(strstr(run.err, wrong[i][1]));
    }
    assert_int_equal(run_format(&run, "refine %s/tiny.ply -c %s/tiny -o a.ply --steps 0", scratch, scratch),
                     2);
    assert_int_equal(run_format(&run, "refine %s/tiny.ply -c %s/tiny -o %s/no.ply --steps 4 --pattern absent",
                                scratch, scratch, scratch),
                     1);
    assert_non_null(strstr(run.err, "absent"));
    assert_false(ffp_is_file(in_scratch("no.ply")));
    static const char *const none[] = {"b.PLY", "b.field"};
    for (size_t i = 0; i < sizeof none / sizeof *none; i++) assert_false(ffp_is_file(in_scratch(none[i])));
    assert_false(ffp_is_file("a.ply"));
    assert_int_equal(
        run_format(&run, "refine %s/absent.ply -c %s/tiny -o %s/no.ply", scratch, scratch, scratch), 1);
    assert_non_null(strstr(run.err, "absent.ply"));
    // A file that cannot be written is reported before the work, and before any other fault.
    assert_int_equal(run_format(&run, "refine %s/absent.ply -c %s/tiny -o %s/nowhere/no.ply --seconds 100",
                                scratch, scratch, scratch),
                     1);
    assert_non_null(strstr(run.err, "nowhere/no.ply"));
}

static uint32_t big_endian(const char *at) {
    const unsigned char *bytes = (const unsigned char *)at;
    return (uint32_t)bytes[0] << 24 | (uint32_t)bytes[1] << 16 | (uint32_t)bytes[2] << 8 | bytes[3];
}

// Walks the file's chunks; sequence numbers must follow each other.
static int count_frames(const char *path) {
    char *data;
    size_t size;
    int frames = 0;
    uint32_t sequence = 0, announced = 0;
    assert_true(ffp_read_file(path, 1 << 26, &data, &size, NULL));
    size_t at = 8;
    for (; at + 12 <= size; at += 12 + big_endian(data + at)) {
        const char *type = data + at + 4, *content = data + at + 8;
        if (memcmp(type, "acTL", 4) == 0) announced = big_endian(content);
        if (memcmp(type, "fcTL", 4) == 0) frames++;
        if (memcmp(type, "fcTL", 4) == 0 || memcmp(type, "fdAT", 4) == 0)
            assert_int_equal(big_endian(content), sequence++);
    }
    assert_int_equal(at, size);
    assert_int_equal(announced, frames);
    ffp_free(data);
    return frames;
}

static FfpImage frame(const char *folder, int number) {
    char name[128];
    FfpImage image;
    snprintf(name, sizeof name, "%s/frame_%04d.png", folder, number);
    assert_true(ffp_image_read(&image, in_scratch(name), FFP_COLOUR_ENCODED, NULL));
    return image;
}

static double mean_difference(const FfpImage *a, const FfpImage *b) {
    double sum = 0;
    const int count = a->width * a->height * 4;
    for (int i = 0; i < count; i++) sum += fabs((double)a->data[i] - (double)b->data[i]) / count;
    return sum;
}

// The ball is the same from all sides; here the half where x is above 0 glows.
static void write_half_moon(const char *name) {
    FfpGaussians g;
    FfpError err = {0};
    if (!ffp_gaussians_read(&g, in_scratch("tiny.ply"), &err)) fail_msg("%s", err.text);
    for (int64_t i = 0; i < 3 * g.count; i++)
        if (g.centre[i - i % 3] > 0) g.ambient[i] += 0.4F;
    if (!ffp_gaussians_write(&g, in_scratch(name), 0, &err)) fail_msg("%s", err.text);
    ffp_gaussians_free(&g);
}

// Half a turn of a rig of four views lands on the third view; a whole turn comes back.
static void test_an_orbit_goes_round(void **state) {
    (void)state;
    write_half_moon("moon.ply");
    assert_int_equal(
        run_format(&run, "render %s/moon.ply -c %s/tiny --orbit object,4 -o %s/turn --video %s/turn.png",
                   scratch, scratch, scratch, scratch),
        0);
    assert_int_equal(count_frames(in_scratch("turn.png")), 4);
    assert_int_equal(run_format(&run, "render %s/moon.ply -c %s/tiny -o %s/still", scratch, scratch, scratch),
                     0);
    FfpImage frames[4], views[4];
    for (int i = 0; i < 4; i++) {
        char name[64];
        snprintf(name, sizeof name, "still/view_%d_all_white.png", i);
        assert_true(ffp_image_read(&views[i], in_scratch(name), FFP_COLOUR_ENCODED, NULL));
        frames[i] = frame("turn", i);
    }
    assert_true(mean_difference(&frames[0], &views[0]) < 1e-3);
    assert_true(mean_difference(&frames[2], &views[2]) < 1e-3);
    assert_true(mean_difference(&views[0], &views[2]) > 0.02);
    const bool same_way = mean_difference(&frames[1], &views[1]) < 1e-3; // it may go round either way
    for (int i = 1; i < 4; i += 2)
        assert_true(mean_difference(&frames[i], &views[same_way ? i : 4 - i]) < 1e-3);
    assert_true(mean_difference(&views[1], &views[3]) > 0.02);
    for (int i = 0; i < 4; i++) ffp_image_free(&frames[i]), ffp_image_free(&views[i]);
}

static void test_patterns_of_a_folder_make_a_film(void **state) {
    (void)state;
    assert_int_equal(run_format(&run,
                                "render %s/tiny.ply -c %s/tiny --view view_1 --pattern %s/tiny/patterns -o "
                                "%s/film --video %s/film.png --rate 5",
                                scratch, scratch, scratch, scratch, scratch),
                     0);
    assert_int_equal(count_frames(in_scratch("film.png")), TINY_PATTERNS);
    FfpImage black = frame("film", 0), white = frame("film", 1); // in the order of their names
    assert_true(mean_difference(&black, &white) > 0.01);
    ffp_image_free(&black);
    ffp_image_free(&white);
    assert_int_equal(
        run_format(&run, "render %s/tiny.ply -c %s/tiny --orbit moon,9 -o %s/x", scratch, scratch, scratch),
        2);
    assert_int_equal(
        run_format(&run, "render %s/tiny.ply -c %s/tiny --orbit camera,0 -o %s/x", scratch, scratch, scratch),
        2);
    assert_int_equal(run_format(&run, "render %s/tiny.ply -c %s/tiny --video %s/x.png --maps -o %s/x",
                                scratch, scratch, scratch, scratch),
                     2);
    assert_true(ffp_make_folders(in_scratch("empty"), NULL));
    assert_int_equal(run_format(&run, "render %s/tiny.ply -c %s/tiny --pattern %s/empty -o %s/x", scratch,
                                scratch, scratch, scratch),
                     1);
    assert_non_null(strstr(run.err, "holds no pictures"));
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_refining_gains_and_tells_of_each_round),
        cmocka_unit_test(test_a_reconstruction_says_how_good_it_is),
        cmocka_unit_test(test_several_patterns),
        cmocka_unit_test(test_from_scratch_needs_no_gaussians),
        cmocka_unit_test(test_a_field_is_fitted_and_evaluated),
        cmocka_unit_test(test_an_interrupt_keeps_the_best_so_far),
        cmocka_unit_test(test_wrong_requests_are_told_and_write_nothing),
        cmocka_unit_test(test_an_orbit_goes_round),
        cmocka_unit_test(test_patterns_of_a_folder_make_a_film),
    };
    return cmocka_run_group_tests(tests, group_setup, scratch_teardown);
}
