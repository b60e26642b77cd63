// Captures that are wrong: each is refused with WHAT (FILE: FIELD), and nothing is returned.
#include <fcntl.h>
#include <math.h>
#include <stdarg.h>
#include <stdatomic.h>
#include "core/base/alloc.h"
#include "short_of_memory.h"
#include "tiny_capture.h"

// One change to a good file, and what must be said about it.
typedef struct Damage {
    const char *old, *fresh, *words, *field; // field: the end of the message's "(FILE: FIELD)"
} Damage;

static void expect_refusal(const char *path, const char *words, const char *field) {
    FfpCapture capture;
    FfpError err = {0};
    if (ffp_capture_read(&capture, path, &err)) fail_msg("accepted, where '%s' should be said", words);
    assert_null(capture.views);
    assert_null(capture.patterns);
    if (!strstr(err.text, words)) fail_msg("'%s' does not say '%s'", err.text, words);
    if (!strstr(err.text, field)) fail_msg("'%s' does not name '%s'", err.text, field);
}

static void expect_damage_refused(const char *text, const Damage *damage, const char *name) {
    char *broken = replaced(text, damage->old, damage->fresh);
    char field[256];
    snprintf(field, sizeof field, "%s%s%s)", name, damage->field[0] != 0 ? ": " : "", damage->field);
    write_text(name, broken);
    expect_refusal(in_scratch(name), damage->words, field);
    ffp_free(broken);
}

#define DEVICE(rest)                                                                                         \
    "\"device\": {\"width\": 40, \"height\": 30, \"fx\": 50, \"fy\": 50, \"cx\": 20, " rest "}, "
#define C2W_A "[[0, 0, -1, 3], [1, 0, 0, 0], [0, -1, 0, 0], [0, 0, 0, 1]]"

static void broken_scenes_are_refused(void **state) {
    (void)state;
    static const Damage damages[] = {
        {"\"name\": \"tiny\"", "\"scene\": 1", "not true or false", "scene"},
        {"{\"id\": \"a\"", "{\"range\": [2, 1], \"id\": \"a\"", "not beyond the near", "views[0].range"},
        {"{\"id\": \"a\"", "{\"range\": [0, 1], \"id\": \"a\"", "is outside", "views[0].range[0]"},
        {"\"format\": \"ffprocams-capture\"", "\"format\": \"gltf\"", "is not ffprocams-capture", "format"},
        {"\"version\": 1", "\"version\": 2", "version 2 is newer", "version"},
        {"\"version\": 1", "\"version\": \"1\"", "must be a number", "version"},
        {"\"version\": 1,", "", "missing field", "version"},
        {"\"fx\": 20", "\"fx\": \"20\"", "must be a number", "camera.fx"},
        {"\"fx\": 20", "\"fx\": -20", "-20 is outside", "camera.fx"},
        {"\"fx\": 20", "\"fx\": 0", "0 is outside", "camera.fx"},
        {"\"fx\": 20,", "", "missing field", "camera.fx"},
        {"\"fx\": 20", "\"fx\": null", "missing field", "camera.fx"},
        {"\"fx\": 20", "\"fx\": NaN", "broken JSON", "line 3"},
        {"\"fx\": 20", "\"fx\": Infinity", "broken JSON", "line 3"},
        {"\"fx\": 20", "\"fx\": 1e999", "broken JSON", "line 3"},
        {"\"fx\": 20", "\"fx\": 1e300", "is outside", "camera.fx"},
        {"\"fx\": 20", "\"fx\": 20, \"fx\": 21", "broken JSON: duplicate", "line 3"},
        {"\"id\": \"b\"", "\"frame\": [12], \"id\": \"b\"", "has 1 entries; 2 to 2", "views[1].frame"},
        {"\"id\": \"b\"", "\"frame\": [13, 10], \"id\": \"b\"", "13 is not a whole number from 8 to 12",
         "views[1].frame[0]"},
        {"\"id\": \"b\"", "\"frame\": \"all\", \"id\": \"b\"", "must be an array", "views[1].frame"},
        {"\"fx\": 25", "\"fx\": \"wide\"", "must be a number", "views[1].camera.fx"},
        {"\"width\": 12", "\"width\": 12.5", "12.5 is not a whole number", "camera.width"},
        {"\"width\": 12", "\"width\": 1", "1 is not a whole number from 8", "camera.width"},
        {"\"width\": 12", "\"width\": 20000", "20000 is not a whole number from 8 to 16384", "camera.width"},
        {"\"width\": 12", "\"width\": 99999999999999999999999", "", "line 3"},
        {"\"camera\": {\"width\": 12, ", "\"camera\": [1, 2], \"x\": {", "must be an object", "camera"},
        {"\"radius\": 0.5", "\"radius\": 0", "0 is outside", "object.radius"},
        {"\"centre\": [0, 0, 0]", "\"centre\": [0, 0]", "has 2 entries; 3 to 3", "object.centre"},
        {"\"intensity\": [7, 8, 9]", "\"intensity\": [7, 8, -9]", "-9 is outside", "projector.intensity[2]"},
        {"\"intensity\": [7, 8, 9]", "\"intensity\": 7", "must be an array", "projector.intensity"},
        {"\"intensity\"", DEVICE("\"cy\": 5, \"lens\": [0, 0, 0, 0]") "\"intensity\"", "has 4 entries",
         "projector.device.lens"},
        {"\"intensity\"", DEVICE("\"cy\": 5, \"gamma\": [2, 0, 2]") "\"intensity\"", "0 is outside",
         "projector.device.gamma[1]"},
        {"\"intensity\"", DEVICE("\"lens\": [0, 0, 0, 0, 0]") "\"intensity\"", "missing field",
         "projector.device.cy"},
        {"\"intensity\"", "\"device\": {\"width\": 1e9}, \"intensity\"", "whole number",
         "projector.device.width"},
        {"\"intensity\"", "\"device\": 3, \"intensity\"", "must be an object", "projector.device"},
        {"\"role\": \"black\"", "\"role\": \"dark\"", "invalid role 'dark'", "patterns[0].role"},
        {"\"role\": \"black\"", "\"role\": \"white\"", "a second pattern with the role white",
         "patterns[1].role"},
        {"\"role\": \"black\"", "\"role\": \"active\"", "missing field", "patterns[0].file"},
        {"\"role\": \"white\"", "\"role\": \"novel\", \"file\": \"p/dots.png\"",
         "no pattern has the role white", "patterns"},
        {"\"name\": \"dots\"", "\"name\": \"earth\"", "duplicate pattern 'earth'", "patterns[3].name"},
        {"\"name\": \"dots\"", "\"name\": \"../dots\"", "invalid name", "patterns[3].name"},
        {"\"name\": \"dots\"", "\"name\": \"do\\nts\"", "invalid name", "patterns[3].name"},
        {"\"name\": \"dots\"", "\"name\": \"\"", "must not be empty", "patterns[3].name"},
        {"\"file\": \"p/dots.png\"", "\"file\": \"../dots.png\"", "leaves the capture's folder",
         "patterns[3].file"},
        {"\"file\": \"p/dots.png\"", "\"file\": \"p/../../dots.png\"", "leaves the capture's folder",
         "patterns[3].file"},
        {"\"file\": \"p/dots.png\"", "\"file\": \"/etc/passwd\"", "leaves the capture's folder",
         "patterns[3].file"},
        {"\"file\": \"p/dots.png\"", "\"file\": \"p/none.png\"", "no such file 'p/none.png'",
         "patterns[3].file"},
        {"\"views\": [", "\"codes\": [\"dots\"], \"views\": [", "'dots' is not in its place", "codes[0]"},
        {"\"views\": [", "\"codes\": 5, \"views\": [", "must be an array", "codes"},
        {"\"views\": [", "\"codes\": [\"../dots\"], \"views\": [", "invalid name", "codes[0]"},
        {"\"views\": [", "\"views\": [], \"x\": [", "has 0 entries; 1 to 512", "views"},
        {"\"views\": [", "\"views\": 8, \"x\": [", "must be an array", "views"},
        {"\"id\": \"b\"", "\"id\": \"a\"", "duplicate view 'a'", "views[1].id"},
        {"\"id\": \"b\"", "\"id\": \"..\"", "invalid name", "views[1].id"},
        {"\"id\": \"b\"", "\"id\": 7", "must be a string", "views[1].id"},
        {C2W_A, "[[0, 0, -2, 3], [2, 0, 0, 0], [0, -2, 0, 0], [0, 0, 0, 1]]", "is not rigid", "views[0].c2w"},
        {C2W_A, "[[0, 0, 0, 3], [1, 0, 0, 0], [0, -1, 0, 0], [0, 0, 0, 1]]", "is singular", "views[0].c2w"},
        {C2W_A, "[[0, 0, 0, 0], [0, 0, 0, 0], [0, 0, 0, 0], [0, 0, 0, 0]]", "last row", "views[0].c2w"},
        {C2W_A, "[[0, 0, 1, 3], [1, 0, 0, 0], [0, -1, 0, 0], [0, 0, 0, 1]]", "mirrors", "views[0].c2w"},
        {C2W_A, "[[0, 0, -1, 3], [1, 0.1, 0, 0], [0, -1, 0, 0], [0, 0, 0, 1]]", "is not rigid",
         "views[0].c2w"},
        {C2W_A, "[[0, 0, -1, 3], [1, 0, 0, 0], [0, -1, 0, 0], [0, 0, 1, 1]]", "last row", "views[0].c2w"},
        {C2W_A, "[[0, 0, -1, 3], [1, 0, 0, 0], [0, -1, 0, 0]]", "has 3 entries; 4 to 4", "views[0].c2w"},
        {C2W_A, "[[0, 0, -1, 3], [1, 0, 0], [0, -1, 0, 0], [0, 0, 0, 1]]", "has 3 entries",
         "views[0].c2w[1]"},
        {C2W_A, "[[0, 0, -1, \"3\"], [1, 0, 0, 0], [0, -1, 0, 0], [0, 0, 0, 1]]", "number",
         "views[0].c2w[0][3]"},
        {C2W_A, "[[0, 0, -1, 1e30], [1, 0, 0, 0], [0, -1, 0, 0], [0, 0, 0, 1]]", "outside",
         "views[0].c2w[0][3]"},
        {C2W_A, "\"identity\"", "must be an array", "views[0].c2w"},
        {"\"dark\": \"a0.png\", ", "", "no picture under the black pattern 'dark'", "views[0]"},
        {"\"bright\": \"b1.png\", ", "", "no picture under the white pattern 'bright'", "views[1]"},
        {"\"dark\": \"a0.png\"", "\"dark\": \"gone.png\"", "no such file 'gone.png'", "views[0].images.dark"},
        {"\"earth\": \"a2.png\"", "\"earth\": \"gone.png\"", "no such file 'gone.png'",
         "views[0].images.earth"},
        {"\"dark\": \"a0.png\"", "\"dark\": \"../a0.png\"", "leaves the capture's folder",
         "views[0].images.dark"},
        {"\"dark\": \"a0.png\"", "\"night\": \"a0.png\"", "'night' is not among the patterns",
         "views[0].images.night"},
        {"\"dark\": \"a0.png\"", "\"dark\": 0", "must be a string", "views[0].images.dark"},
        {"\"images\": {\"dark\": \"b0", "\"images\": 5, \"x\": {\"dark\": \"b0", "must be an object",
         "views[1].images"},
    };
    for (size_t i = 0; i < sizeof damages / sizeof damages[0]; i++) {
        expect_damage_refused(scene_text, &damages[i], "broken.json");
    }
}

static void broken_render_poses_are_refused(void **state) {
    (void)state;
    static const Damage damages[] = {
        {"\"h\": 10", "\"h\": \"10\"", "must be a number", "camera.h"},
        {"\"h\": 10, ", "", "missing field", "camera.h"},
        {"\"projector\": {", "\"projector\": 5, \"x\": {", "must be an object", "projector"},
        {"\"projector_energy\": 100", "\"projector_energy\": -1", "-1 is outside",
         "projector.projector_energy"},
        {"\"projector_energy\": 100", "\"pattern_w\": 16", "missing field", "projector.pattern_h"},
        {"\"scene_name\": \"tiny\"", "\"scene_name\": \"a/../../b\"", "invalid name", "scene_name"},
        {"\"view_id\": \"a\"", "\"view_id\": \"../a\"", "invalid name", "views[0].view_id"},
        {"0.9999995", "0.9", "is not rigid", "views[0].c2w"},
        {"\"proj_fx\": 30", "\"proj_fx\": 0", "0 is outside", "views[0].proj_fx"},
        {"\"all_black\"", "\"gone\"", "no pattern is called all_black or black", "views"},
        {"\"all_white\"", "\"gone\"", "no pattern is called all_white or white", "views"},
        {"\"nature\"", "\"stripes\"", "no pattern image stripes.png", "views"},
        {"\"nature\"", "\"lollipop_0\"", "duplicate pattern 'lollipop_0'",
         "views[0].patterns[3].projector_image"},
        {"\"nature\"", "\"../nature\"", "invalid name", "views[0].patterns[2].projector_image"},
        {"/far/away/a0.png", "/etc/gone.png", "nor 'gone.png' beside the JSON",
         "views[0].patterns[0].file_path"},
        {"/far/away/a0.png", "..", "no file '..', nor", "views[0].patterns[0].file_path"},
        {"\"patterns\": [", "\"patterns\": [], \"x\": [", "has 0 entries", "views[0].patterns"},
        {"\"views\": [", "\"views\": [3, ", "must be an object", "views[0]"},
    };
    for (size_t i = 0; i < sizeof damages / sizeof damages[0]; i++) {
        expect_damage_refused(poses_text, &damages[i], "broken.json");
    }
}

static void json_itself_is_checked(void **state) {
    (void)state;
    for (size_t cut = 0; cut < strlen(scene_text) - 2; cut += 61) {
        char *text = strndup(scene_text, cut);
        write_text("cut.json", text);
        expect_refusal(in_scratch("cut.json"), "broken JSON", "cut.json: line");
        free(text);
    }
    write_text("cut.json", "[1, 2]");
    expect_refusal(in_scratch("cut.json"), "JSON is not an object", "cut.json)");
    write_text("cut.json", "{}");
    expect_refusal(in_scratch("cut.json"), "missing field", "cut.json: camera)");
    expect_refusal(in_scratch("absent.json"), "no such file", "absent.json)");
    expect_refusal(in_scratch("p"), "neither scene.json nor render_poses.json; photographs become", "/p)");
    char *deep = ffp_alloc(1, 200001);
    memset(deep, '[', 200000);
    write_text("cut.json", deep);
    expect_refusal(in_scratch("cut.json"), "broken JSON", "cut.json");
    ffp_free(deep);
}

static void a_million_views_are_refused(void **state) {
    (void)state;
    const int n = 1000000;
    char *list = ffp_alloc((size_t)n * 3 + 64, 1), *end = list + sprintf(list, "\"views\": [{}");
    for (int i = 1; i < n; i++) end = stpcpy(end, ",{}");
    strcpy(end, "], \"x\": [");
    char *text = replaced(scene_text, "\"views\": [", list);
    write_text("many.json", text);
    expect_refusal(in_scratch("many.json"), "has 1000000 entries; 1 to 512", "many.json: views)");
    ffp_free(text);
    ffp_free(list);
}

// One file replaced by something else, read, and put back.
static void with_file(const char *name, const void *bytes, size_t size, const char *words) {
    char *good;
    size_t good_size;
    assert_true(ffp_read_file(in_scratch(name), 1 << 20, &good, &good_size, NULL));
    assert_true(ffp_write_file(in_scratch(name), bytes, size, NULL));
    expect_refusal(scratch, words, ffp_basename(name));
    assert_true(ffp_write_file(in_scratch(name), good, good_size, NULL));
    ffp_free(good);
}

static void bad_image_files_are_refused(void **state) {
    (void)state;
    static const char *const names[3] = {"a0.png", "b2.png", "p/dots.png"};
    for (int i = 0; i < 3; i++) {
        char *bytes;
        size_t size;
        assert_true(ffp_read_file(in_scratch(names[i]), 1 << 20, &bytes, &size, NULL));
        with_file(names[i], bytes, size / 2, "PNG");
        with_file(names[i], bytes, 20, "truncated PNG");
        with_file(names[i], "", 0, "file is empty");
        with_file(names[i], "not an image at all", 19, "is not a PNG, JPEG, TIFF or EXR image");
        // The header claims 20000 x 20000; the checksum is wrong then, but the size is looked at first.
        memcpy(bytes + 16, "\0\0\x4e\x20\0\0\x4e\x20", 8);
        with_file(names[i], bytes, size, "image size 20000 x 20000 is outside");
        ffp_free(bytes);
        FfpImage small = ffp_image_new(1, 1, 3);
        unsigned char *encoded;
        assert_true(ffp_image_encode_png(&small, &encoded, &size, NULL));
        with_file(names[i], encoded, size, "image is 1 x 1, but the");
        ffp_free(encoded);
        ffp_image_free(&small);
    }
}

// A truth file named in the JSON: wrong size, wrong kind, wrong values.
static void bad_truth_is_refused(void **state) {
    (void)state;
    FfpImage map = ffp_image_new(12, 10, 3), small = ffp_image_new(9, 10, 1);
    for (int i = 0; i < 360; i++) map.data[i] = 2;
    assert_true(ffp_image_write_exr(&map, in_scratch("two.exr"), NULL));
    assert_true(ffp_image_write_exr(&small, in_scratch("small.exr"), NULL));
    static const char *const keys[6] = {"coverage", "depth", "normal", "albedo", "roughness", "direct_white"};
    for (int i = 0; i < 6; i++) {
        char entry[100];
        snprintf(entry, sizeof entry, "\"id\": \"b\", \"%s\": \"small.exr\"", keys[i]);
        char *text = replaced(scene_text, "\"id\": \"b\"", entry);
        write_text("truth.json", text);
        expect_refusal(in_scratch("truth.json"), "image is 9 x 10, but the camera in truth.json has 12 x 10",
                       "small.exr)");
        ffp_free(text);
    }
    static const Damage damages[] = {
        {"\"id\": \"b\"", "\"id\": \"b\", \"normal\": \"two.exr\"", "normals are not unit vectors",
         "two.exr)"},
        {"\"id\": \"b\"", "\"id\": \"b\", \"roughness\": \"two.exr\"", "roughness is outside 0 to 1",
         "two.exr)"},
        {"\"id\": \"b\"", "\"id\": \"b\", \"depth\": \"b0.png\"", "is not a grey image", "b0.png)"},
        {"\"id\": \"b\"", "\"id\": \"b\", \"depth\": \"gone.exr\"", "no such file 'gone.exr'",
         "views[1].depth)"},
    };
    for (int i = 0; i < 4; i++) {
        char *text = replaced(scene_text, damages[i].old, damages[i].fresh);
        write_text("truth.json", text);
        expect_refusal(in_scratch("truth.json"), damages[i].words, damages[i].field);
        ffp_free(text);
    }
    ffp_image_free(&map);
    ffp_image_free(&small);
}

// --- Files that change while they are read. ---

// From the first or a later opening of `name` onwards, another file is in its place.
static struct {
    const char *name, *other;
    int at; // the opening from which on
    atomic_int openings;
} swap;

// In place of the C library's, which every file is opened by.
int open(const char *file, int oflag, ...) {
    va_list arguments;
    va_start(arguments, oflag);
    const mode_t mode = oflag & O_CREAT ? va_arg(arguments, mode_t) : 0;
    va_end(arguments);
    if (swap.name && strcmp(ffp_basename(file), swap.name) == 0 && swap.openings++ >= swap.at)
        file = swap.other;
    return openat(AT_FDCWD, file, oflag, mode);
}

// Pixels are those of the bytes whose size was checked: no file is opened a second time.
static void files_that_change_are_refused(void **state) {
    (void)state;
    static const char *const keys[6] = {"coverage", "depth", "normal", "albedo", "roughness", "direct_white"};
    FfpImage small = ffp_image_new(2, 2, 3), map = ffp_image_new(12, 10, 3), grey = ffp_image_new(12, 10, 1);
    char other[FFP_PATH_MAX];
    assert_true(ffp_join_path(other, scratch, "other.exr"));
    assert_true(ffp_image_write_exr(&small, other, NULL));
    char *text = replaced(scene_text, "\"id\": \"b\"",
                          "\"id\": \"b\", \"coverage\": \"coverage.exr\", \"depth\": \"depth.exr\", "
                          "\"normal\": \"normal.exr\", \"albedo\": \"albedo.exr\", \"roughness\": "
                          "\"roughness.exr\", \"direct_white\": \"direct_white.exr\", \"correspondence\": "
                          "\"correspondence.exr\"");
    write_text("changing.json", text);
    char names[10][32] = {"b0.png", "p/dots.png", "correspondence.exr"};
    assert_true(ffp_image_write_exr(&map, in_scratch("correspondence.exr"), NULL));
    for (int i = 0; i < 6; i++) {
        snprintf(names[3 + i], sizeof names[0], "%s.exr", keys[i]);
        assert_true(ffp_image_write_exr(i == 1 || i == 4 ? &grey : &map, in_scratch(names[3 + i]), NULL));
    }
    for (int i = 0; i < 9; i++)
        for (swap.at = 0; swap.at < 2; swap.at++) {
            FfpCapture capture;
            FfpError err = {0};
            swap.openings = 0;
            swap.other = other, swap.name = ffp_basename(names[i]);
            const bool ok = ffp_capture_read(&capture, in_scratch("changing.json"), &err);
            swap.name = NULL;
            if (ok) ffp_capture_free(&capture);
            assert_int_equal(swap.openings, 1);
            assert_int_equal(ok, swap.at > 0);
            if (!ok) assert_non_null(strstr(err.text, "image is 2 x 2, but the"));
        }
    ffp_free(text);
    ffp_image_free(&small), ffp_image_free(&map), ffp_image_free(&grey);
}

// An image as large as this program reads, many times over, must be refused before memory is taken for it.
static void images_beyond_memory_are_refused(void **state) {
    (void)state;
    char *text = replaced(scene_text, "\"width\": 12, \"height\": 10", "\"width\": 16384, \"height\": 16384");
    const size_t room = strlen(text) + 512 * 700;
    char *many = ffp_alloc(room, 1), *end = many;
    const char *view = strstr(text, " {\"id\": \"a\""), *next = strstr(text, " {\"id\": \"b\"");
    end += sprintf(end, "%.*s", (int)(view - text), text);
    for (int i = 0; i < 500; i++) {
        end += sprintf(end, " {\"id\": \"v%d\"%.*s", i, (int)(next - view - 11), view + 11);
    }
    strcpy(end, next);
    write_text("huge.json", many);
    expect_refusal(in_scratch("huge.json"), "GB of memory; this machine has", "huge.json)");
    ffp_free(many);
    ffp_free(text);
}

// The limit is the memory that is left, not all that the machine has.
static void images_beyond_what_is_left_are_refused(void **state) {
    (void)state;
    FfpCapture capture;
    leave_memory("20"); // of the 28 kB that seven pictures of 12 x 10 and four patterns take
    expect_refusal(scratch, "GB of memory; this machine has", "scene.json)");
    leave_memory("40");
    const bool ok = ffp_capture_read(&capture, scratch, NULL);
    meminfo = NULL;
    assert_true(ok);
    ffp_capture_free(&capture);
}

static void equal_black_and_white_are_refused(void **state) {
    (void)state;
    char *text = replaced(scene_text, "\"intensity\": [7, 8, 9]", "\"intensity\": null");
    char *first = replaced(text, "\"bright\": \"a1.png\"", "\"bright\": \"a0.png\"");
    char *second = replaced(first, "\"bright\": \"b1.png\"", "\"bright\": \"b0.png\"");
    write_text("dark.json", second);
    expect_refusal(in_scratch("dark.json"), "no pixel is brighter under the white pattern", "dark.json)");
    ffp_free(second);
    ffp_free(first);
    ffp_free(text);
}

static void bad_targets_are_refused(void **state) {
    (void)state;
    FfpCapture capture, targets;
    FfpError err = {0};
    assert_true(ffp_capture_read(&capture, scratch, &err));
    assert_false(ffp_capture_read_targets(&targets, in_scratch("gone.json"), &capture, &err));
    assert_null(targets.patterns);
    write_text("targets.json", poses_text); // its all_black is unknown to this capture, and has no file
    assert_false(ffp_capture_read_targets(&targets, scratch, &capture, &err));
    assert_non_null(strstr(err.text, "no pattern image all_black.png"));
    char *text = replaced(poses_text, "\"projector_energy\": 100", "\"pattern_w\": 17, \"pattern_h\": 9");
    char *dark = replaced(text, "all_black", "dark"), *bright = replaced(dark, "all_white", "bright");
    write_text("targets.json", bright);
    assert_false(ffp_capture_read_targets(&targets, scratch, &capture, &err));
    assert_non_null(strstr(err.text, "projector of 17 x 9, but the capture's has 16 x 9"));
    assert_null(targets.patterns);
    ffp_free(bright);
    ffp_free(dark);
    ffp_free(text);
    write_text("targets.json", "{\"views\": ");
    assert_false(ffp_capture_read_targets(&targets, scratch, &capture, &err));
    assert_non_null(strstr(err.text, "broken JSON"));
    ffp_capture_free(&capture);
}

static void unwritable_captures_are_refused(void **state) {
    (void)state;
    FfpCapture capture;
    FfpError err = {0};
    assert_true(ffp_capture_read(&capture, scratch, &err));
    assert_false(ffp_capture_write(&capture, in_scratch("a0.png"), &err)); // a file, not a folder
    capture.views[1].camera.pose[3] = (real)NAN;
    assert_false(ffp_capture_write(&capture, in_scratch("nan"), &err));
    assert_non_null(strstr(err.text, "not finite"));
    assert_false(ffp_is_folder(in_scratch("nan")));
    ffp_capture_free(&capture);
    assert_false(ffp_capture_write(&capture, in_scratch("none"), &err));
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(broken_scenes_are_refused),
        cmocka_unit_test(broken_render_poses_are_refused),
        cmocka_unit_test(json_itself_is_checked),
        cmocka_unit_test(a_million_views_are_refused),
        cmocka_unit_test(bad_image_files_are_refused),
        cmocka_unit_test(bad_truth_is_refused),
        cmocka_unit_test(files_that_change_are_refused),
        cmocka_unit_test(images_beyond_memory_are_refused),
        cmocka_unit_test(images_beyond_what_is_left_are_refused),
        cmocka_unit_test(equal_black_and_white_are_refused),
        cmocka_unit_test(bad_targets_are_refused),
        cmocka_unit_test(unwritable_captures_are_refused),
    };
    return cmocka_run_group_tests(tests, make_capture_files, scratch_teardown);
}
