// Films by their endings. ffmpeg itself is not tested: a script stands in for it, which keeps what it is
// given.
#include <dirent.h>
#include <sys/stat.h>
#include "product/cli/program.h"
#include "product/cli/tiny.h"

#define SIDE 24
#define FRAMES 3

static ProgramRun run;
static char path_before[4096];

// Writes scratch/bin/ffmpeg and lets nothing but it and the system's own be found.
static void put_ffmpeg(const char *script) {
    char path[4200];
    assert_true(ffp_write_file(in_scratch("bin/ffmpeg"), script, strlen(script), NULL));
    assert_int_equal(chmod(in_scratch("bin/ffmpeg"), 0755), 0);
    snprintf(path, sizeof path, "%s/bin:%s", scratch, path_before);
    setenv("PATH", path, 1);
}

static int group_setup(void **state) {
    if (scratch_setup(state) != 0) return -1;
    snprintf(path_before, sizeof path_before, "%s", getenv("PATH"));
    assert_true(ffp_make_folders(in_scratch("bin"), NULL));
    tiny_capture(in_scratch("tiny"), SIDE);
    return run_format(&run, "reconstruct %s/tiny -o %s/tiny.ply --model none --polish 0", scratch, scratch);
}

static int film(const char *name) {
    return run_format(&run,
                      "render %s/tiny.ply -c %s/tiny --orbit object,%d -o %s/frames --rate 7 --video %s/%s",
                      scratch, scratch, FRAMES, scratch, scratch, name);
}

static void must_refuse(const char *name, const char *why) {
    assert_int_equal(film(name), 1);
    if (!strstr(run.err, why)) printf("%s", run.err);
    assert_non_null(strstr(run.err, why));
    assert_non_null(strstr(run.err, name));
    assert_false(ffp_is_file(in_scratch(name)));
    DIR *folder = opendir(scratch);
    for (const struct dirent *entry; (entry = readdir(folder));) assert_null(strstr(entry->d_name, ".tmp"));
    closedir(folder);
}

static void check_frame(const char *bytes, int number) {
    char name[64];
    FfpImage frame;
    snprintf(name, sizeof name, "frames/frame_%04d.png", number);
    assert_true(ffp_image_read(&frame, in_scratch(name), FFP_COLOUR_ENCODED, NULL));
    for (int i = 0; i < SIDE * SIDE; i++)
        for (int c = 0; c < 3; c++)
            assert_int_equal((unsigned char)bytes[3 * i + c], lrint((double)frame.data[4 * i + c] * 255));
    ffp_image_free(&frame);
}

static void ffmpeg_gets_every_frame_as_it_is(void **state) {
    (void)state;
    static const char *const endings[][2] = {
        {"gif", "gif"}, {"mp4", "mp4"}, {"webm", "webm"}, {"MKV", "matroska"}};
    put_ffmpeg("#!/bin/sh\nfor last; do :; done\necho \"$*\" >\"${0%/*}/told\"\ncat >\"${last#file:}\"\n");
    for (size_t i = 0; i < sizeof endings / sizeof *endings; i++) {
        char name[32], told[4096], expected[128], *bytes;
        size_t size;
        snprintf(name, sizeof name, "film.%s", endings[i][0]);
        assert_int_equal(film(name), 0);
        assert_true(ffp_read_file(in_scratch(name), 1 << 20, &bytes, &size, NULL));
        assert_int_equal(size, FRAMES * SIDE * SIDE * 3);
        for (int f = 0; f < FRAMES; f++) check_frame(bytes + f * SIDE * SIDE * 3, f);
        ffp_free(bytes);
        read_text(in_scratch("bin/told"), told, sizeof told);
        assert_non_null(strstr(told, "-s 24x24 -r 7 -i pipe:0 "));
        snprintf(expected, sizeof expected, " -f %s -y file:%s/", endings[i][1], scratch);
        assert_non_null(strstr(told, expected));
    }
}

static void a_failure_of_ffmpeg_is_told_and_leaves_nothing(void **state) {
    (void)state;
    put_ffmpeg("#!/bin/sh\necho warming up >&2\necho 'unknown codec' >&2\nexit 3\n");
    must_refuse("failed.mp4", "ffmpeg failed: unknown codec");
    assert_true(ffp_is_file(in_scratch("frames/INCOMPLETE")));
    put_ffmpeg("#!/bin/sh\ncat >/dev/null\nkill -9 $$\n");
    must_refuse("killed.mp4", "ffmpeg failed: no reason given");
}

static void what_cannot_be_made_is_told_before_the_work(void **state) {
    (void)state;
    char command[128];
    snprintf(command, sizeof command, "rm -rf -- '%s/frames'", scratch);
    assert_int_equal(system(command), 0);
    setenv("PATH", "/nowhere", 1);
    must_refuse("absent.mp4", "ffmpeg, which makes .mp4 films, is not installed");
    setenv("PATH", path_before, 1);
    must_refuse("film.avi", "must be .png, .apng, .gif, .mp4, .webm or .mkv");
    must_refuse("film", "the extension of a film");
    must_refuse("nowhere/film.png", "cannot write");
    assert_false(ffp_is_folder(in_scratch("frames")));
    assert_int_equal(film("film.apng"), 0); // needs nothing
}

// --- Films that are projected. ---

// A film of a red and a blue frame, twice as wide as high, by a script in place of ffmpeg.
static void put_film(void) {
    static const char bytes[16] = "\0\0\0\x10"
                                  "ftypisom";
    assert_true(ffp_write_file(in_scratch("two.mp4"), bytes, sizeof bytes, NULL));
    put_ffmpeg("#!/bin/sh\necho \"$*\" >\"${0%/*}/told\"\n"
               "printf 'P6\\n2 1\\n255\\n\\377\\000\\000\\377\\000\\000'\n"
               "printf 'P6\\n2 1\\n255\\n\\000\\000\\377\\000\\000\\377'\n");
}

static FfpImage plain(int red, int blue) {
    FfpImage image = ffp_image_new(TINY_PATTERN, TINY_PATTERN, 3);
    for (int i = 0; i < TINY_PATTERN * TINY_PATTERN; i++) {
        image.data[3 * i] = (float)red;
        image.data[3 * i + 2] = (float)blue;
    }
    return image;
}

static void assert_same_file(const char *a, const char *b) {
    char *one, *other;
    size_t n, m;
    assert_true(ffp_read_file(in_scratch(a), 1 << 20, &one, &n, NULL));
    assert_true(ffp_read_file(in_scratch(b), 1 << 20, &other, &m, NULL));
    assert_int_equal(n, m);
    assert_memory_equal(one, other, n);
    ffp_free(one);
    ffp_free(other);
}

static void a_film_is_a_sequence_of_patterns(void **state) {
    (void)state;
    char told[4096];
    put_film();
    FfpImage red = plain(1, 0), blue = plain(0, 1);
    assert_true(ffp_image_write_png(&red, in_scratch("red.png"), NULL));
    assert_true(ffp_image_write_png(&blue, in_scratch("blue.png"), NULL));
    ffp_image_free(&red);
    ffp_image_free(&blue);
    assert_int_equal(
        run_format(&run, "render %s/tiny.ply -c %s/tiny -v view_0 -p %s/red.png -p %s/blue.png -o %s/still",
                   scratch, scratch, scratch, scratch, scratch),
        0);
    assert_int_equal(run_format(&run, "render %s/tiny.ply -c %s/tiny -v view_0 -p %s/two.mp4@1-2 -o %s/lit",
                                scratch, scratch, scratch, scratch),
                     0);
    assert_same_file("lit/view_0_two.mp4@1-2_0000.png", "still/view_0_red.png");
    assert_same_file("lit/view_0_two.mp4@1-2_0001.png", "still/view_0_blue.png");
    read_text(in_scratch("bin/told"), told, sizeof told);
    assert_non_null(strstr(told, "-ss 1.000000 -t 1.000000 -i file:"));
    assert_non_null(strstr(told, "-r 15 "));
}

static void a_film_is_corrected_frame_by_frame(void **state) {
    (void)state;
    put_film();
    const char *const command =
        "compensate %s/tiny.ply -c %s/tiny -v view_0 --paint --steps 0 -o %s/%s.png -t %s/%s";
    assert_int_equal(run_format(&run, command, scratch, scratch, scratch, "one", scratch, "red.png"), 0);
    assert_int_equal(
        run_format(&run,
                   "compensate %s/tiny.ply -c %s/tiny -v view_0 --paint --steps 0 -o %s/first.png -t "
                   "%s/two.mp4 --video %s/corrected.png --rate 5",
                   scratch, scratch, scratch, scratch, scratch),
        0);
    assert_same_file("first.png", "one.png");
    assert_true(ffp_is_file(in_scratch("corrected.png")));
    assert_int_equal(run_format(&run, command, scratch, scratch, scratch, "none", scratch, "two.mp4"), 1);
    assert_non_null(strstr(run.err, "say with video"));
    assert_int_equal(run_format(&run,
                                "compensate %s/tiny.ply -c %s/tiny -v view_0 --steps 0 -o %s/none.png -t "
                                "%s/red.png --video %s/not_it.png",
                                scratch, scratch, scratch, scratch, scratch),
                     1);
    assert_non_null(strstr(run.err, "the target is not a film"));
    assert_non_null(strstr(run.err, "red.png"));
    assert_false(ffp_is_file(in_scratch("none.png")));
    put_ffmpeg("#!/bin/sh\nprintf 'P6\\n2 1\\n255\\n\\377'\necho broken >&2\nexit 1\n");
    assert_int_equal(run_format(&run, "render %s/tiny.ply -c %s/tiny -p %s/two.mp4 -o %s/none", scratch,
                                scratch, scratch, scratch),
                     1);
    assert_non_null(strstr(run.err, "could not read all of the film: broken"));
    assert_false(ffp_is_folder(in_scratch("none")));
}

// With the real program, where there is one.
static void ffmpeg_makes_films(void **state) {
    (void)state;
    setenv("PATH", path_before, 1);
    if (system("command -v ffmpeg >/dev/null && command -v ffprobe >/dev/null") != 0) {
        printf("skipped: real films (ffmpeg is not installed)\n");
        return;
    }
    static const char *const names[] = {"real.gif", "real.mp4", "real.webm", "real.mkv"};
    for (size_t i = 0; i < sizeof names / sizeof *names; i++) {
        char command[512], text[256];
        assert_int_equal(film(names[i]), 0);
        assert_false(ffp_is_file(in_scratch("frames/INCOMPLETE")));
        snprintf(
            command, sizeof command,
            "ffprobe -v error -count_frames -show_entries stream=width,height,nb_read_frames -of csv=p=0 "
            "%s/%s >%s.probe",
            scratch, names[i], scratch);
        assert_int_equal(system(command), 0);
        snprintf(command, sizeof command, "%s.probe", scratch);
        read_text(command, text, sizeof text);
        assert_string_equal(text, "24,24,3\n");
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(ffmpeg_gets_every_frame_as_it_is),
        cmocka_unit_test(a_failure_of_ffmpeg_is_told_and_leaves_nothing),
        cmocka_unit_test(what_cannot_be_made_is_told_before_the_work),
        cmocka_unit_test(a_film_is_a_sequence_of_patterns),
        cmocka_unit_test(a_film_is_corrected_frame_by_frame),
        cmocka_unit_test(ffmpeg_makes_films),
    };
    return cmocka_run_group_tests(tests, group_setup, scratch_teardown);
}
