// A file given in another's place is named as what it is; names that are not there, with those that are.
#include <sys/stat.h>
#include "core/gaussians/gaussians.h"
#include "product/cli/program.h"
#include "product/cli/tiny.h"

#define SIDE 24

static ProgramRun run;

static int group_setup(void **state) {
    if (scratch_setup(state) != 0) return -1;
    static const char weights[] = "\x02\0\0\0\0\0\0\0{}";
    FfpGaussians none = ffp_gaussians_new(0);
    tiny_capture(in_scratch("tiny"), SIDE);
    assert_true(ffp_write_file(in_scratch("w.safetensors"), weights, sizeof weights - 1, NULL));
    assert_true(ffp_gaussians_write(&none, in_scratch("empty.ply"), 0, NULL));
    assert_int_equal(mkfifo(in_scratch("pipe"), 0600), 0);
    ffp_gaussians_free(&none);
    return run_format(&run, "reconstruct %s/tiny -o %s/tiny.ply --model none --polish 0", scratch, scratch);
}

// `@` in the arguments stands for the scratch folder.
static void must_say(const char *arguments, const char *message) {
    char text[1024] = "";
    for (const char *at = arguments; *at; at++)
        snprintf(text + strlen(text), sizeof text - strlen(text), *at == '@' ? "%s" : "%.1s",
                 *at == '@' ? scratch : at);
    run_program(&run, text);
    if (run.status != 1 || !strstr(run.err, message)) printf("%s: exit %d\n%s", text, run.status, run.err);
    assert_int_equal(run.status, 1);
    assert_non_null(strstr(run.err, message));
}

static void a_file_in_anothers_place_is_named(void **state) {
    (void)state;
    static const char *const said[][2] = {
        {"reconstruct @/tiny.ply -o @/x.ply", "is Gaussians (a PLY), not a capture: "},
        {"render @/tiny.ply -c @/tiny.ply -o @/x", "is Gaussians (a PLY), not a capture: "},
        {"evaluate @/tiny.ply --model none", "is Gaussians (a PLY), not a capture: "},
        {"align @/tiny/view_0_stripes.png -o @/x", "is a picture, not a capture: "},
        {"reconstruct @/w.safetensors -o @/x.ply", "is weights (safetensors), not a capture: "},
        {"render @/tiny -c @/tiny -o @/x", "is a folder, as captures are, not Gaussians: "},
        {"refine @/tiny/render_poses.json -c @/tiny -o @/x.ply", "is JSON, as in captures, not Gaussians: "},
        {"map @/tiny/view_0_stripes.png -c @/tiny -o @/x", "is a picture, not Gaussians: "},
        {"map @/w.safetensors -c @/tiny -o @/x", "is weights (safetensors), not Gaussians: "},
        {"reconstruct @/tiny -o @/x.ply --model @/tiny.ply", "is Gaussians (a PLY), not weights: "},
        {"reconstruct @/tiny -o @/x.ply --model @/tiny", "is a folder, as captures are, not weights: "},
        {"render @/tiny.ply -c @/tiny --poses @/tiny.ply -o @/x", "is Gaussians (a PLY), not a capture: "},
        {"render @/tiny.ply -c @/tiny -p @/tiny.ply -o @/x", "is Gaussians (a PLY), not a picture"},
        {"compensate @/tiny.ply -c @/tiny -v view_0 -t @/tiny.ply -o @/x.png",
         "is Gaussians (a PLY), not a picture"},
        {"info @/tiny/view_0_stripes.png", "is a picture: not a capture"},
        {"info @/pipe", "is a FIFO or pipe, not a file"},
        {"render @/pipe -c @/tiny -o @/x", "is a FIFO or pipe, not a file"},
    };
    for (size_t i = 0; i < sizeof said / sizeof *said; i++) must_say(said[i][0], said[i][1]);
}

static void no_gaussians_are_an_error(void **state) {
    (void)state;
    static const char *const said[] = {
        "render @/empty.ply -c @/tiny -o @/x",
        "refine @/empty.ply -c @/tiny -o @/x.ply",
        "compensate @/empty.ply -c @/tiny -v view_0 -t @/tiny/view_0_stripes.png -o @/x.png",
        "map @/empty.ply -c @/tiny -o @/x",
        "evaluate @/tiny --gaussians @/empty.ply",
    };
    for (size_t i = 0; i < sizeof said / sizeof *said; i++) must_say(said[i], "holds no Gaussians");
    assert_int_equal(run_format(&run, "info %s/empty.ply", scratch), 0);
    assert_non_null(strstr(run.out, "Gaussians    0: nothing to draw"));
}

static void names_that_are_not_there_come_with_those_that_are(void **state) {
    (void)state;
    static const char views[] = "no view v9; the views are view_0, view_1, view_2, view_3 (";
    static const char patterns[] = "all_black, all_white, lollipop_0, lollipop_1, stripes (";
    must_say("render @/tiny.ply -c @/tiny -v v9 -o @/x", views);
    must_say("map @/tiny.ply -c @/tiny -v v9 -o @/x", views);
    must_say("compensate @/tiny.ply -c @/tiny -v v9 -t a.png -o @/x.png", views);
    must_say("render @/tiny.ply -c @/tiny --poses @/tiny/targets.json -v v9 -o @/x",
             "; the views are novel_0, novel_1 (");
    must_say("render @/tiny.ply -c @/tiny -p tartan -o @/x", patterns);
    must_say("reconstruct @/tiny -p tartan -o @/x.ply --model none", patterns);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_file_in_anothers_place_is_named),
        cmocka_unit_test(no_gaussians_are_an_error),
        cmocka_unit_test(names_that_are_not_there_come_with_those_that_are),
    };
    return cmocka_run_group_tests(tests, group_setup, scratch_teardown);
}
