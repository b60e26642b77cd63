// Hostile and broken files: exit 1, one line "ffprocams: error: WHAT (WHERE)", nothing written.
#include <dirent.h>
#include <zlib.h>
#include "engine/network/network.h"
#include "product/cli/program.h"
#include "product/cli/tiny.h"

#define SIDE 16

static char capture[80], output[80];
static ProgramRun run;

// --- What every failure must look like. ---

static const char *last_line(const char *text) {
    const char *line = text;
    for (const char *at = text; *at; at++)
        if (*at == '\n' && at[1]) line = at + 1;
    return line;
}

static bool holds_anything(const char *folder) {
    DIR *dir = opendir(folder);
    if (!dir) return false;
    int entries = 0;
    while (readdir(dir)) entries++;
    closedir(dir);
    return entries > 2;
}

static void must_fail(const char *what, const char *where, const char *arguments) {
    run_program(&run, arguments);
    const char *line = last_line(run.err);
    const size_t length = strlen(line);
    const bool ok = run.status == 1 && strncmp(line, "ffprocams: error: ", 18) == 0 && length > 20 &&
                    strcmp(line + length - 2, ")\n") == 0 && strstr(line, where) && !holds_anything(output);
    if (!ok)
        printf("%s: exit %d, expected an error that names \"%s\":\n%s", what, run.status, where, run.err);
    assert_true(ok);
}

// The output folder exists and is empty, so that anything left behind shows, including temporary files.
static void reconstruct_must_fail(const char *what, const char *where) {
    char arguments[1024];
    snprintf(arguments, sizeof arguments, "reconstruct %s -o %s/out.ply --model none", capture, output);
    must_fail(what, where, arguments);
}

// --- JSON. ---

static json_t *load_poses(void) {
    char path[256];
    snprintf(path, sizeof path, "%s/render_poses.json", capture);
    json_t *root = json_load_file(path, 0, NULL);
    assert_non_null(root);
    return root;
}

static void save_poses(const json_t *root) {
    char path[256];
    snprintf(path, sizeof path, "%s/render_poses.json", capture);
    assert_int_equal(json_dump_file(root, path, 0), 0);
}

static void save_text(const char *name, const void *text, size_t size) {
    char path[256];
    snprintf(path, sizeof path, "%s/%s", capture, name);
    assert_true(ffp_write_file(path, text, size, NULL));
}

// Replaces the value at "a/0/b" by JSON text, or removes it.
static void edit(json_t *at, const char *path, const char *text) {
    char parts[256], *save = NULL;
    snprintf(parts, sizeof parts, "%s", path);
    char *part = strtok_r(parts, "/", &save);
    for (char *next; (next = strtok_r(NULL, "/", &save)); part = next)
        at = json_is_array(at) ? json_array_get(at, (size_t)atoi(part)) : json_object_get(at, part);
    assert_non_null(at);
    json_t *value = text ? json_loads(text, JSON_DECODE_ANY, NULL) : NULL;
    assert_true(value || !text);
    if (json_is_array(at) && value)
        assert_int_equal(json_array_set_new(at, (size_t)atoi(part), value), 0);
    else if (json_is_array(at))
        assert_int_equal(json_array_remove(at, (size_t)atoi(part)), 0);
    else if (value)
        assert_int_equal(json_object_set_new(at, part, value), 0);
    else
        assert_int_equal(json_object_del(at, part), 0);
}

// Every refusal below is of this capture with one thing changed.
static void test_the_sound_capture_is_taken(void **state) {
    (void)state;
    char arguments[256];
    snprintf(arguments, sizeof arguments, "info %s", capture);
    run_program(&run, arguments);
    assert_int_equal(run.status, 0);
}

typedef struct Edit {
    const char *path, *text, *where;
} Edit;

static void test_fields_that_are_missing_or_wrong(void **state) {
    (void)state;
    static const Edit edits[] = {
        {"camera", NULL, "camera"},
        {"camera/w", NULL, "w"},
        {"camera/w", "\"16\"", "w"},
        {"camera/w", "0", "w"},
        {"camera/w", "-16", "w"},
        {"camera/w", "20000", "w"},
        {"camera/w", "1e30", "w"},
        {"camera/fx", NULL, "fx"},
        {"camera/fx", "\"20\"", "fx"},
        {"camera/fx", "0", "fx"},
        {"camera/fx", "-20", "fx"},
        {"camera/fy", "null", "fy"},
        {"camera/cx", "[]", "cx"},
        {"views", NULL, "views"},
        {"views", "[]", "views"},
        {"views", "{}", "views"},
        {"views", "17", "views"},
        {"views/0", "3", "views"},
        {"views/1/view_id", NULL, "view_id"},
        {"views/1/view_id", "12", "view_id"},
        {"views/1/view_id", "\"view_0\"", "view_"},
        {"views/1/c2w", NULL, "c2w"},
        {"views/1/c2w", "[]", "c2w"},
        {"views/1/c2w/0", "[1, 2, 3]", "c2w"},
        {"views/1/c2w/0/0", "\"1\"", "c2w"},
        {"views/1/c2w/0/0", "7", "c2w"},
        {"views/1/c2w/0", "[0, 0, 0, 0]", "c2w"},
        {"views/1/c2w", "[[2, 0, 0, 3], [0, 2, 0, 0], [0, 0, 2, 0], [0, 0, 0, 1]]", "c2w"},
        {"views/1/c2w", "[[1, 0, 0, 3], [0, 1, 0, 0], [0, 0, -1, 0], [0, 0, 0, 1]]", "c2w"},
        {"views/1/c2w", "[[0, 0, 0, 0], [0, 0, 0, 0], [0, 0, 0, 0], [0, 0, 0, 0]]", "c2w"},
        {"views/1/c2w/3", "[0, 0, 1, 1]", "c2w"},
        {"views/1/p2w", NULL, "p2w"},
        {"views/1/p2w/1/1", "0.99", "p2w"},
        {"views/1/proj_fx", NULL, "proj_fx"},
        {"views/1/proj_fx", "\"a\"", "proj_fx"},
        {"views/1/proj_fx", "0", "proj_fx"},
        {"views/1/patterns", NULL, "patterns"},
        {"views/1/patterns", "[]", "patterns"},
        {"views/1/patterns/0", NULL, "black"},
        {"views/1/patterns/1", NULL, "white"},
        {"views/1/patterns/2/file_path", NULL, "file_path"},
        {"views/1/patterns/2/file_path", "5", "file_path"},
        {"views/1/patterns/2/file_path", "\"not_there.png\"", "not_there.png"},
        {"views/1/patterns/2/projector_image", NULL, "projector_image"},
        {"views/1/patterns/2/projector_image", "\"not_there\"", "not_there"},
        {"projector/pattern_w", "\"64\"", "pattern_w"},
        {"projector/pattern_w", "63", "pattern"},
    };
    for (size_t i = 0; i < sizeof edits / sizeof *edits; i++) {
        char what[256];
        snprintf(what, sizeof what, "%s = %s", edits[i].path, edits[i].text ? edits[i].text : "(removed)");
        json_t *root = load_poses(), *changed = json_deep_copy(root);
        edit(changed, edits[i].path, edits[i].text);
        save_poses(changed);
        reconstruct_must_fail(what, edits[i].where);
        save_poses(root);
        json_decref(changed);
        json_decref(root);
    }
}

static void test_json_that_is_no_capture(void **state) {
    (void)state;
    json_t *root = load_poses();
    char *whole = json_dumps(root, 0);
    save_text("render_poses.json", whole, strlen(whole) / 2);
    reconstruct_must_fail("truncated JSON", "render_poses.json");
    static const char *const texts[] = {
        "", "[]", "null", "{", "{\"views\": NaN}", "{\"views\": [1e999]}", "\xff\xfe\x00"};
    for (size_t i = 0; i < sizeof texts / sizeof *texts; i++) {
        save_text("render_poses.json", texts[i], strlen(texts[i]));
        reconstruct_must_fail(texts[i], "render_poses.json");
    }
    char *deep = malloc(200001);
    assert_non_null(deep);
    memset(deep, '[', 200000);
    deep[200000] = 0;
    save_text("render_poses.json", deep, 200000);
    reconstruct_must_fail("200,000 brackets", "render_poses.json");
    free(deep);
    free(whole);
    save_poses(root);
    json_decref(root);
}

static void test_a_number_that_is_no_number(void **state) {
    (void)state;
    json_t *root = load_poses();
    json_t *changed = json_deep_copy(root);
    edit(changed, "camera/fx", "123456789");
    char *text = json_dumps(changed, 0);
    memcpy(strstr(text, "123456789"), "NaN      ", 9);
    save_text("render_poses.json", text, strlen(text));
    reconstruct_must_fail("fx = NaN", "render_poses.json");
    free(text);
    save_poses(root);
    json_decref(changed);
    json_decref(root);
}

static void test_a_million_views(void **state) {
    (void)state;
    json_t *root = load_poses(), *changed = json_deep_copy(root), *views = json_array();
    json_t *first = json_array_get(json_object_get(root, "views"), 0);
    for (int i = 0; i < 1000000; i++) json_array_append_new(views, json_object());
    json_object_set_new(changed, "views", views);
    save_poses(changed);
    reconstruct_must_fail("a million empty views", "views");
    json_array_clear(views);
    for (int i = 0; i < 1000; i++) json_array_append(views, first);
    save_poses(changed);
    reconstruct_must_fail("a thousand views", "views");
    save_poses(root);
    json_decref(changed);
    json_decref(root);
}

// --- Pictures. ---

// The photograph of view 1 under lollipop_0 while `test` runs with another in its place.
static void with_photograph(const char *what, const void *bytes, size_t size) {
    char path[256];
    snprintf(path, sizeof path, "%s/view_1_lollipop_0.png", capture);
    char *kept;
    size_t kept_size;
    assert_true(ffp_read_file(path, 1 << 24, &kept, &kept_size, NULL));
    if (bytes)
        assert_true(ffp_write_file(path, bytes, size, NULL));
    else
        assert_int_equal(remove(path), 0);
    reconstruct_must_fail(what, "view_1_lollipop_0.png");
    assert_true(ffp_write_file(path, kept, kept_size, NULL));
    ffp_free(kept);
}

// A PNG that consists of its header only: enough to claim any size.
static size_t png_head(unsigned char out[64], uint32_t width, uint32_t height) {
    static const unsigned char start[] = {137, 80, 78, 71, 13, 10, 26, 10, 0, 0, 0, 13, 'I', 'H', 'D', 'R'};
    memcpy(out, start, sizeof start);
    for (int i = 0; i < 4; i++) {
        out[16 + i] = (unsigned char)(width >> (24 - 8 * i));
        out[20 + i] = (unsigned char)(height >> (24 - 8 * i));
    }
    memcpy(out + 24, (unsigned char[]){8, 6, 0, 0, 0}, 5);
    const uint32_t crc = (uint32_t)crc32(0, out + 12, 17);
    for (int i = 0; i < 4; i++) out[29 + i] = (unsigned char)(crc >> (24 - 8 * i));
    return 33;
}

static void test_photographs_that_are_none(void **state) {
    (void)state;
    unsigned char head[64];
    char path[256];
    with_photograph("missing picture", NULL, 0);
    with_photograph("empty picture", "", 0);
    with_photograph("text for a picture", "hello, world\n", 13);
    snprintf(path, sizeof path, "%s/view_0_lollipop_0.png", capture);
    char *whole;
    size_t size;
    assert_true(ffp_read_file(path, 1 << 24, &whole, &size, NULL));
    with_photograph("truncated picture", whole, size / 2);
    with_photograph("picture cut in its header", whole, 20);
    ffp_free(whole);
    with_photograph("20000 x 20000", head, png_head(head, 20000, 20000));
    with_photograph("2^31 x 2^31", head, png_head(head, 0x7fffffff, 0x7fffffff));
    with_photograph("0 x 0", head, png_head(head, 0, 0));
}

static void test_a_photograph_of_another_size(void **state) {
    (void)state;
    char path[256];
    snprintf(path, sizeof path, "%s/one.png", scratch);
    FfpImage one = ffp_image_new(1, 1, 4);
    assert_true(ffp_image_write_png(&one, path, NULL));
    ffp_image_free(&one);
    char *bytes;
    size_t size;
    assert_true(ffp_read_file(path, 1 << 20, &bytes, &size, NULL));
    with_photograph("1 x 1", bytes, size);
    ffp_free(bytes);
}

// A capture whose JSON agrees that its pictures are a single pixel: there is no object in it.
static void test_a_capture_of_single_pixels(void **state) {
    (void)state;
    char folder[128], arguments[1024];
    snprintf(folder, sizeof folder, "%s/pixel", scratch);
    assert_true(ffp_make_folders(folder, NULL));
    tiny_capture(folder, 1);
    snprintf(arguments, sizeof arguments, "reconstruct %s -o %s/out.ply --model none", folder, output);
    must_fail("pictures of one pixel", "pixel", arguments);
}

// --- Gaussians and weights. ---

static void test_files_that_are_not_there(void **state) {
    (void)state;
    char arguments[1024];
    snprintf(arguments, sizeof arguments, "reconstruct %s/none -o %s/out.ply --model none", scratch, output);
    must_fail("no capture", "none", arguments);
    snprintf(arguments, sizeof arguments, "reconstruct %s -o %s/out.ply --model %s/none.safetensors", capture,
             output, scratch);
    must_fail("no model", "none.safetensors", arguments);
    snprintf(arguments, sizeof arguments, "reconstruct %s -o %s/out.ply --model none --pattern tartan",
             capture, output);
    must_fail("no such pattern", "tartan", arguments);
    snprintf(arguments, sizeof arguments, "render %s/none.ply --capture %s -o %s/out", scratch, capture,
             output);
    must_fail("no Gaussians", "none.ply", arguments);
    snprintf(arguments, sizeof arguments,
             "evaluate %s --model none --targets %s/none.json --json %s/out.json --save %s/out", capture,
             scratch, output, output);
    must_fail("no targets", "none.json", arguments);
    snprintf(arguments, sizeof arguments, "evaluate %s --predictor depth --json %s/out.json", capture,
             output);
    must_fail("no true depth", "depth", arguments);
    snprintf(arguments, sizeof arguments,
             "evaluate %s --model none --perceptual %s/none.safetensors --json %s/out.json", capture, scratch,
             output);
    must_fail("no LPIPS weights", "none.safetensors", arguments);
    snprintf(arguments, sizeof arguments, "reconstruct %s -o %s/no/folder/out.ply --model none", capture,
             output);
    must_fail("no folder to write to", "out.ply", arguments);
    // Told before anything is read, let alone computed.
    snprintf(arguments, sizeof arguments, "reconstruct %s/none -o %s/no/folder/out.ply", scratch, output);
    must_fail("no folder to write to, before the work", "out.ply", arguments);
    snprintf(arguments, sizeof arguments, "info %s/none", scratch);
    must_fail("nothing to tell of", "none", arguments);
    assert_int_equal(mkfifo(in_scratch("fifo"), 0600), 0);
    snprintf(arguments, sizeof arguments, "info %s/fifo", scratch); // must not wait for a writer
    must_fail("a FIFO", "is a FIFO or pipe", arguments);
    snprintf(arguments, sizeof arguments, "train --out %s/run --config %s/none.json", output, scratch);
    must_fail("no configuration", "none.json", arguments);
}

typedef struct Blob {
    const char *what;
    const char *text;
} Blob;

#define PLY_PROPERTIES                                                                                       \
    "property float x\nproperty float y\nproperty float z\nproperty float f_dc_0\nproperty float "           \
    "f_dc_1\nproperty float f_dc_2\n"                                                                        \
    "property float opacity\nproperty float scale_0\nproperty float scale_1\nproperty float "                \
    "scale_2\nproperty float rot_0\n"                                                                        \
    "property float rot_1\nproperty float rot_2\nproperty float rot_3\nproperty float "                      \
    "base_color_0\nproperty float base_color_1\n"                                                            \
    "property float base_color_2\nproperty float roughness\n"

static void test_gaussians_that_are_broken(void **state) {
    (void)state;
    static const Blob blobs[] = {
        {"empty", ""},
        {"only the magic", "ply\n"},
        {"ascii", "ply\nformat ascii 1.0\nelement vertex 1\n" PLY_PROPERTIES "end_header\n0 0 0\n"},
        {"no properties", "ply\nformat binary_little_endian 1.0\nelement vertex 1\nend_header\n"},
        {"more splats than bytes",
         "ply\nformat binary_little_endian 1.0\nelement vertex 1000\n" PLY_PROPERTIES "end_header\nabcdefgh"},
        {"negative count",
         "ply\nformat binary_little_endian 1.0\nelement vertex -5\n" PLY_PROPERTIES "end_header\n"},
        {"a count that overflows",
         "ply\nformat binary_little_endian 1.0\nelement vertex 4611686018427387904\n" PLY_PROPERTIES
         "end_header\n"},
        {"a count beyond 64 bits",
         "ply\nformat binary_little_endian 1.0\nelement vertex 99999999999999999999999\n" PLY_PROPERTIES
         "end_header\n"},
        {"a header without end", "ply\nformat binary_little_endian 1.0\nelement vertex 1\n" PLY_PROPERTIES},
    };
    char path[256], arguments[1024];
    snprintf(path, sizeof path, "%s/bad.ply", scratch);
    for (size_t i = 0; i < sizeof blobs / sizeof *blobs; i++) {
        assert_true(ffp_write_file(path, blobs[i].text, strlen(blobs[i].text), NULL));
        snprintf(arguments, sizeof arguments, "render %s --capture %s -o %s/out", path, capture, output);
        must_fail(blobs[i].what, "bad.ply", arguments);
        snprintf(arguments, sizeof arguments, "evaluate %s --gaussians %s --json %s/out.json", capture, path,
                 output);
        must_fail(blobs[i].what, "bad.ply", arguments);
        snprintf(arguments, sizeof arguments, "info %s", path);
        must_fail(blobs[i].what, "bad.ply", arguments);
    }
}

static void write_safetensors(const char *path, uint64_t length, const char *header, size_t extra) {
    char bytes[1024] = {0};
    for (int i = 0; i < 8; i++) bytes[i] = (char)(length >> (8 * i));
    const size_t size = strlen(header);
    memcpy(bytes + 8, header, size);
    assert_true(ffp_write_file(path, bytes, 8 + size + extra, NULL));
}

static void test_weights_that_are_broken(void **state) {
    (void)state;
    static const struct {
        const char *what, *header;
        uint64_t length; // 0: the header's own
        size_t extra;
    } files[] = {
        {"no model inside", "{\"a\":{\"dtype\":\"F32\",\"shape\":[2],\"data_offsets\":[0,8]}}", 0, 8},
        {"a header longer than the file", "{}", 1000, 0},
        {"a header of 2^63 bytes", "{}", (uint64_t)1 << 63, 0},
        {"offsets past the end", "{\"a\":{\"dtype\":\"F32\",\"shape\":[2],\"data_offsets\":[0,8]}}", 0, 4},
        {"offsets in the wrong order", "{\"a\":{\"dtype\":\"F32\",\"shape\":[2],\"data_offsets\":[8,0]}}", 0,
         8},
        {"negative offsets", "{\"a\":{\"dtype\":\"F32\",\"shape\":[2],\"data_offsets\":[-8,0]}}", 0, 8},
        {"a shape that overflows",
         "{\"a\":{\"dtype\":\"F32\",\"shape\":[4294967296,4294967296,4],\"data_offsets\":[0,0]}}", 0, 0},
        {"a shape that is not its data's", "{\"a\":{\"dtype\":\"F32\",\"shape\":[3],\"data_offsets\":[0,8]}}",
         0, 8},
        {"an unknown type", "{\"a\":{\"dtype\":\"F7\",\"shape\":[2],\"data_offsets\":[0,8]}}", 0, 8},
        {"no JSON", "{\"a\":", 0, 0},
    };
    char path[256], arguments[1024];
    snprintf(path, sizeof path, "%s/bad.safetensors", scratch);
    for (size_t i = 0; i < sizeof files / sizeof *files; i++) {
        write_safetensors(path, files[i].length ? files[i].length : strlen(files[i].header), files[i].header,
                          files[i].extra);
        snprintf(arguments, sizeof arguments, "reconstruct %s -o %s/out.ply --model %s", capture, output,
                 path);
        must_fail(files[i].what, "bad.safetensors", arguments);
        snprintf(arguments, sizeof arguments, "info %s", path);
        must_fail(files[i].what, "bad.safetensors", arguments);
    }
    assert_true(ffp_write_file(path, "abc", 3, NULL));
    snprintf(arguments, sizeof arguments, "reconstruct %s -o %s/out.ply --model %s", capture, output, path);
    must_fail("three bytes", "bad.safetensors", arguments);
}

// A sound model cuts pictures into patches of 8: it cannot take 20 x 20.
static void test_targets_of_another_capture(void **state) {
    (void)state;
    char path[256], arguments[1024];
    snprintf(path, sizeof path, "%s/targets.json", capture);
    json_t *root = json_load_file(path, 0, NULL);
    assert_non_null(root);
    edit(root, "scene_name", "\"another\"");
    snprintf(path, sizeof path, "%s/other.json", capture);
    assert_int_equal(json_dump_file(root, path, 0), 0);
    json_decref(root);
    snprintf(arguments, sizeof arguments, "evaluate %s --model none --targets other.json --json %s/out.json",
             capture, output);
    must_fail("targets of another capture", "other.json", arguments);
}

// --- Evaluation: whatever is wrong, and wherever, shows before the first picture is saved. ---

static void test_nothing_is_saved_when_a_later_file_is_bad(void **state) {
    (void)state;
    char arguments[1024];
    snprintf(arguments, sizeof arguments, "evaluate %s %s/none --model none --save %s/saved", capture,
             scratch, output);
    must_fail("the second capture is missing", "none", arguments);
    snprintf(arguments, sizeof arguments, "evaluate %s %s --model none --save %s/saved", capture, capture,
             output);
    must_fail("two captures of one name", "saved", arguments);
    assert_true(ffp_write_file(in_scratch("cut.png"), "\x89PNG\r\n\x1a\n", 8, NULL));
    snprintf(arguments, sizeof arguments,
             "evaluate %s --model none --save %s/saved --report %s/out.html --show-pattern %s", capture,
             output, output, in_scratch("cut.png"));
    must_fail("a truncated pattern to show", "cut.png", arguments);
    static const char *const texts[] = {"", "{", "{\"views\": NaN}", "{\"views\": []}"};
    for (size_t i = 0; i < sizeof texts / sizeof *texts; i++) {
        save_text("bad_targets.json", texts[i], strlen(texts[i]));
        snprintf(arguments, sizeof arguments,
                 "evaluate %s --model none --targets bad_targets.json --save %s/saved", capture, output);
        must_fail("broken targets", "bad_targets.json", arguments);
    }
}

// --- Training. ---

static void test_training_files_that_are_broken(void **state) {
    (void)state;
    static const struct {
        const char *text, *where;
    } configs[] = {
        {"", "bad.json"},
        {"{\"steps\": \"3\"}", "bad.json: steps"},
        {"{\"steps\": NaN}", "bad.json"},
        {"{\"views\": 0}", "bad.json: views"},
        {"{\"views\": 1000000}", "bad.json: views"},
        {"{\"resolution\": 20000}", "bad.json: resolution"},
        {"{\"model\": {\"dim\": 1e9}}", "bad.json: model.dim"},
        {"{\"model\": {\"modules\": \"MXT\"}}", "bad.json: model.modules"},
        {"{\"resolution\": 100}", "bad.json: resolution"},
    };
    char path[256], arguments[1024];
    snprintf(path, sizeof path, "%s/bad.json", scratch);
    for (size_t i = 0; i < sizeof configs / sizeof *configs; i++) {
        assert_true(ffp_write_file(path, configs[i].text, strlen(configs[i].text), NULL));
        snprintf(arguments, sizeof arguments, "train --out %s/run --config %s", output, path);
        must_fail(configs[i].text, configs[i].where, arguments);
    }
    snprintf(arguments, sizeof arguments, "train --out %s/run --initial %s", output, path);
    must_fail("initial weights that are none", "bad.json", arguments);
    snprintf(arguments, sizeof arguments, "train --out %s --steps 1", path);
    must_fail("a file where the run's folder belongs", "bad.json", arguments);
    snprintf(arguments, sizeof arguments, "generate %s --preset smoke --count 1", path);
    must_fail("a file where the scenes' folder belongs", "bad.json", arguments);
}

// A folder of pictures is looked through before a scene is made; a name may have any bytes.
static void test_pictures_that_are_no_materials(void **state) {
    (void)state;
    static const char torn[] = "\x89PNG\r\n\x1a\n and no more";
    char stock[128], path[256], arguments[1024];
    snprintf(stock, sizeof stock, "%s/stock", scratch);
    snprintf(arguments, sizeof arguments, "generate %s/scenes --preset smoke -r 16 --count 1 --materials %s",
             output, stock);
    must_fail("no folder of pictures", "stock", arguments);
    assert_true(ffp_make_folders(stock, NULL));
    must_fail("a folder without pictures", "stock", arguments);
    snprintf(path, sizeof path, "%s/r\xff \"k\n.png", stock);
    FfpImage image = ffp_image_new(4, 4, 3);
    assert_true(ffp_image_write_png(&image, path, NULL));
    ffp_image_free(&image);
    snprintf(path, sizeof path, "%s/torn.png", stock);
    assert_true(ffp_write_file(path, torn, sizeof torn - 1, NULL));
    must_fail("a broken picture", "torn.png", arguments);
    assert_int_equal(remove(path), 0);
    snprintf(arguments, sizeof arguments, "generate %s/scenes --preset smoke -r 16 --count 1 --materials %s",
             scratch, stock);
    assert_int_equal(run_format(&run, "%s", arguments), 0);
    FfpCapture made;
    FfpError err = {0};
    if (!ffp_capture_read(&made, in_scratch("scenes/all_00000"), &err)) fail_msg("%s", err.text);
    const char *name = strrchr(made.name, 'r');
    assert_non_null(name);
    assert_string_equal(name, "r___k_");
    ffp_capture_free(&made);
    snprintf(arguments, sizeof arguments, "generate %s/shown --preset smoke -r 16 --count 1 --patterns %s",
             scratch, stock);
    assert_int_equal(run_format(&run, "%s", arguments), 0);
    if (!ffp_capture_read(&made, in_scratch("shown/all_00000"), &err)) fail_msg("%s", err.text);
    assert_int_equal(ffp_capture_find_pattern(&made, "lollipop_0"), 2);
    assert_int_equal(ffp_capture_find_pattern(&made, "picture_1_r___k_"), 3);
    assert_int_equal(made.n_patterns, 4);
    ffp_capture_free(&made);
    assert_int_equal(remove(in_scratch("stock/r\xff \"k\n.png")), 0);
    must_fail("a folder without patterns", "stock", arguments);
}

static void test_checkpoints_that_are_broken(void **state) {
    (void)state;
    static const struct {
        const char *what, *header, *where;
    } files[] = {
        {"no metadata", "{}", "checkpoint.safetensors: format"},
        {"another format", "{\"__metadata__\":{\"format\":\"x\"}}", "checkpoint.safetensors: format"},
        {"no step", "{\"__metadata__\":{\"format\":\"ffprocams-checkpoint-1\"}}",
         "checkpoint.safetensors: step"},
        {"an invalid step", "{\"__metadata__\":{\"format\":\"ffprocams-checkpoint-1\",\"step\":\"-4\"}}",
         "checkpoint.safetensors: step"},
        {"no configuration", "{\"__metadata__\":{\"format\":\"ffprocams-checkpoint-1\",\"step\":\"4\"}}",
         "checkpoint.safetensors: config"},
        {"a large model without any tensors",
         "{\"__metadata__\":{\"format\":\"ffprocams-checkpoint-1\",\"step\":\"4\",\"config\":\"{"
         "\\\"model\\\": "
         "\\\"paper\\\"}\"}}",
         "checkpoint.safetensors: values"},
    };
    char folder[128], path[256], arguments[1024];
    snprintf(folder, sizeof folder, "%s/run", scratch);
    snprintf(path, sizeof path, "%s/checkpoint.safetensors", folder);
    snprintf(arguments, sizeof arguments, "train --out %s --resume", folder);
    assert_true(ffp_make_folders(folder, NULL));
    must_fail("not a checkpoint", "checkpoint.safetensors", arguments);
    for (size_t i = 0; i < sizeof files / sizeof *files; i++) {
        write_safetensors(path, strlen(files[i].header), files[i].header, 0);
        must_fail(files[i].what, files[i].where, arguments);
    }
    write_safetensors(path, 1000, "{}", 0);
    must_fail("a truncated checkpoint", "checkpoint.safetensors", arguments);
}

static int group_setup(void **state) {
    if (scratch_setup(state) != 0) return -1;
    snprintf(capture, sizeof capture, "%s/tiny", scratch);
    snprintf(output, sizeof output, "%s/out", scratch);
    assert_true(ffp_make_folders(output, NULL));
    tiny_capture(capture, SIDE);
    return 0;
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_the_sound_capture_is_taken),
        cmocka_unit_test(test_fields_that_are_missing_or_wrong),
        cmocka_unit_test(test_json_that_is_no_capture),
        cmocka_unit_test(test_a_number_that_is_no_number),
        cmocka_unit_test(test_a_million_views),
        cmocka_unit_test(test_photographs_that_are_none),
        cmocka_unit_test(test_a_photograph_of_another_size),
        cmocka_unit_test(test_a_capture_of_single_pixels),
        cmocka_unit_test(test_files_that_are_not_there),
        cmocka_unit_test(test_gaussians_that_are_broken),
        cmocka_unit_test(test_weights_that_are_broken),
        cmocka_unit_test(test_targets_of_another_capture),
        cmocka_unit_test(test_nothing_is_saved_when_a_later_file_is_bad),
        cmocka_unit_test(test_training_files_that_are_broken),
        cmocka_unit_test(test_pictures_that_are_no_materials),
        cmocka_unit_test(test_checkpoints_that_are_broken),
    };
    return cmocka_run_group_tests(tests, group_setup, scratch_teardown);
}
