// The smallest capture in both layouts, as text to be damaged, with its files in a folder of its own.
#ifndef FFP_TESTS_TINY_CAPTURE_H
#define FFP_TESTS_TINY_CAPTURE_H

#include "core/base/alloc.h"
#include "core/base/rng.h"
#include "core/capture/capture.h"
#include "scratch.h"

static inline void write_text(const char *name, const char *text) {
    assert_true(ffp_write_file(in_scratch(name), text, strlen(text), NULL));
}

// A grey picture with a disc of alpha 1 around its middle.
static inline void write_disc(const char *name, int width, int height, real value) {
    FfpImage image = ffp_image_new(width, height, 4);
    for (int i = 0; i < width * height; i++) {
        const int x = 2 * (i % width) + 1 - width, y = 2 * (i / width) + 1 - height;
        for (int c = 0; c < 3; c++) image.data[4 * i + c] = value * (real)(c + 1) / 3;
        image.data[4 * i + 3] = x * x + y * y < width * width / 2;
    }
    assert_true(ffp_image_write_png(&image, in_scratch(name), NULL));
    ffp_image_free(&image);
}

static inline void write_pattern(const char *name, int width, int height, uint64_t seed) {
    FfpRng rng = ffp_rng(seed, 0);
    FfpImage image = ffp_image_new(width, height, 3);
    for (int i = 0; i < width * height * 3; i++) image.data[i] = ffp_rng_uniform(&rng);
    assert_true(ffp_image_write_png(&image, in_scratch(name), NULL));
    ffp_image_free(&image);
}

static const char scene_text[] =
    "{\"format\": \"ffprocams-capture\", \"version\": 1, \"name\": \"tiny\",\n"
    "\"object\": {\"centre\": [0, 0, 0], \"radius\": 0.5},\n"
    "\"camera\": {\"width\": 12, \"height\": 10, \"fx\": 20, \"fy\": 21, \"cx\": 6, \"cy\": -5.5},\n"
    "\"projector\": {\"width\": 16, \"height\": 9, \"fx\": 30, \"fy\": 31, \"cx\": 8, \"cy\": 14, "
    "\"intensity\": [7, 8, 9]},\n"
    "\"patterns\": [{\"name\": \"dark\", \"role\": \"black\"}, {\"name\": \"bright\", \"role\": \"white\"},\n"
    "  {\"name\": \"earth\", \"role\": \"novel\", \"file\": \"p/earth.png\"},\n"
    "  {\"name\": \"dots\", \"file\": \"p/dots.png\"}],\n"
    "\"views\": [\n"
    " {\"id\": \"a\", \"c2w\": [[0, 0, -1, 3], [1, 0, 0, 0], [0, -1, 0, 0], [0, 0, 0, 1]],\n"
    "  \"p2w\": [[0, 0, -1, 2], [1, 0, 0, 0], [0, -1, 0, 1], [0, 0, 0, 1]],\n"
    "  \"images\": {\"dark\": \"a0.png\", \"bright\": \"a1.png\", \"dots\": \"a2.png\", \"earth\": "
    "\"a2.png\"}},\n"
    " {\"id\": \"b\", \"c2w\": [[-1, 0, 0, 0], [0, 0, -1, 3], [0, -1, 0, 0], [0, 0, 0, 1]],\n"
    "  \"p2w\": [[-1, 0, 0, 0], [0, 0, -1, 2], [0, -1, 0, 1], [0, 0, 0, 1]], \"camera\": {\"fx\": 25},\n"
    "  \"images\": {\"dark\": \"b0.png\", \"bright\": \"b1.png\", \"dots\": \"b2.png\"}}]}\n";

static const char poses_text[] =
    "{\"scene_name\": \"tiny\", \"camera\": {\"h\": 10, \"w\": 12, \"fx\": 20, \"fy\": 21, \"cx\": 6, "
    "\"cy\": -5.5},\n"
    "\"projector\": {\"projector_energy\": 100},\n"
    "\"views\": [{\"view_id\": \"a\",\n"
    " \"c2w\": [[0, 0, 0.9999995, 3], [1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 0, 1]],\n"
    " \"p2w\": [[0, 0, 1, 2], [1, 0, 0, 0], [0, 1, 0, 1], [0, 0, 0, 1]],\n"
    " \"proj_fx\": 30, \"proj_fy\": 31, \"proj_cx\": 8, \"proj_cy\": 14, \"patterns\": [\n"
    "  {\"file_path\": \"/far/away/a0.png\", \"projector_image\": \"all_black\"},\n"
    "  {\"file_path\": \"a1.png\", \"projector_image\": \"all_white\"},\n"
    "  {\"file_path\": \"../a2.png\", \"projector_image\": \"nature\"},\n"
    "  {\"file_path\": \"a2.png\", \"projector_image\": \"lollipop_0\"}]}]}\n";

static inline int make_capture_files(void **state) {
    if (scratch_setup(state) != 0) return -1;
    write_text("scene.json", scene_text);
    assert_true(ffp_make_folders(in_scratch("p"), NULL));
    assert_true(ffp_make_folders(in_scratch("patterns"), NULL));
    write_pattern("p/earth.png", 16, 9, 1);
    write_pattern("p/dots.png", 16, 9, 2);
    write_pattern("patterns/nature.png", 16, 9, 1);
    write_pattern("lollipop_0.png", 16, 9, 2);
    static const char *const names[6] = {"a0.png", "a1.png", "a2.png", "b0.png", "b1.png", "b2.png"};
    for (int i = 0; i < 6; i++) write_disc(names[i], 12, 10, (real)(i % 3 == 0 ? 0.2 : 1.0 / (i % 3)));
    return 0;
}

// `text` with the first `old` replaced by `fresh`; malloc'd.
static inline char *replaced(const char *text, const char *old, const char *fresh) {
    const char *place = strstr(text, old);
    if (!place) fail_msg("the test's text has no '%s'", old);
    char *out = ffp_alloc(strlen(text) + strlen(fresh) + 1, 1);
    sprintf(out, "%.*s%s%s", (int)(place - text), text, fresh, place + strlen(old));
    return out;
}

#endif
