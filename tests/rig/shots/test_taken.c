// The cameras of photographs as they write it into them: the odd photograph or folder is named.
#include "core/base/call.h"
#include "core/image/codec.h"
#include "rig/shots/tagged.h"
#include "rig/shots/taken.h"
#include "scratch.h"

enum { FOLDERS = 3, FILES = 5 };
#define BODY .model = "DC-S5", .serial = "A17", .lens = "50 mm F1.8"

static const FfpTakenBy usual = {BODY, .focal = 50, .focal_35mm = 50, .zoom = 0};

typedef struct Odd {
    FfpTakenBy taken;
    const char *said; // of a file, or of a folder
} Odd;

static const Odd odd[] = {
    {{.model = "DC-S1", .serial = "A17", .focal_35mm = 50}, "the camera 'DC-S1', %s the camera 'DC-S5'"},
    {{.model = "DC-S5", .serial = "B2", .focal_35mm = 50},
     "a camera with the serial number 'B2', %s a camera with the serial number 'A17'"},
    {{.model = "DC-S5", .lens = "35 mm F1.8", .focal_35mm = 35}, "the lens '35 mm F1.8', %s the lens"},
    {{.model = "DC-S5", .focal_35mm = 70}, "a focal length of 70 mm, %s 50 mm"},
    {{.focal = 35}, "a focal length of 35 mm, %s a focal length of 50 mm"},
    {{BODY, .focal_35mm = 50, .zoom = 1.5}, "a digital zoom of 1.5, %s a digital zoom of 1"},
    {{.focal = 50.4}, NULL}, // files round
    {{.model = ""}, NULL},   // and some say nothing
};
enum { ODD = sizeof odd / sizeof *odd };

static void keep_text(void *user, const FfpFinding *finding) {
    char *said = user;
    const size_t used = strlen(said);
    snprintf(said + used, 1024 - used, "%s %s: %s\n", finding->code, finding->view, finding->text);
}

static FfpShotFolders folders;

// Writes all photographs: of one folder those from `file` on are odd, up to the next or to the last.
static void write_folders(const FfpTakenBy *by, int file, bool all) {
    static unsigned char grey[3 * 64 * 64];
    char name[64];
    for (int d = 0; d < FOLDERS; d++)
        for (int f = 0; f < FILES; f++) {
            snprintf(name, sizeof name, "%d", d);
            mkdir(in_scratch(name), 0777);
            snprintf(name, sizeof name, "%d/%03d.jpg", d, f);
            const bool is_odd = d == 1 && (all ? f >= file : f == file);
            write_tagged(in_scratch(name), grey, 64, 64, is_odd ? by : &usual, 1);
        }
}

typedef struct Comparing {
    bool one;
    double focal, each[FOLDERS];
} Comparing;

static bool compare(void *argument, FfpError *err) {
    Comparing *c = argument;
    const char *const paths[] = {scratch};
    const bool ok = ffp_shot_folders_find(&folders, paths, 1, err);
    if (ok) c->focal = ffp_taken_compare(folders.folders, folders.n, c->one, c->each);
    ffp_shot_folders_free(&folders);
    return ok;
}

static void said_of(Comparing *c, char said[1024]) {
    FfpContext context = {.settings = {.finding = keep_text, .user = said}};
    FfpError err = {0};
    said[0] = 0;
    if (!ffp_call_run(&context, compare, c, &err)) fail_msg("%s", err.text);
    printf("%s", said);
}

// One finding at most: the first thing that differs.
static void must_say(const char *said, const char *template, const char *beside, const char *where) {
    char expected[256];
    const char *end = strchr(said, '\n');
    if (!template) {
        assert_string_equal(said, "");
        return;
    }
    snprintf(expected, sizeof expected, template, beside);
    if (!strstr(said, expected) || !strstr(said, where) || (end && end[1]))
        fail_msg("not %s, %s, but %s", where, expected, said);
}

static void the_odd_one_is_named(void **state) {
    (void)state;
    char said[1024];
    for (int i = 0; i < ODD; i++) {
        Comparing c = {.one = true};
        write_folders(&odd[i].taken, 3, false);
        said_of(&c, said);
        must_say(said, odd[i].said, "those beside it",
                 i == 3 ? "file-lens 1: the photograph '003.jpg'"
                        : "file-camera 1: the photograph '003.jpg'");
        assert_float_equal(c.focal, 50, 0);
        write_folders(&odd[i].taken, 0, true);
        said_of(&c, said);
        must_say(said, odd[i].said, "those of the others",
                 i == 3 ? "place-lens 1: the photographs of '1'" : "place-camera 1: the photographs of '1'");
        assert_float_equal(c.each[1], odd[i].taken.focal_35mm, 0);
        c.one = false;
        said_of(&c, said);
        assert_string_equal(said, "");
    }
}

// Wherever the data end, nothing beyond them is read; and texts longer than there is room for are cut.
static void data_that_are_cut_say_less(void **state) {
    (void)state;
    unsigned char exif[TAGGED_SIZE];
    FfpTakenBy by = usual;
    memset(by.lens, 'x', FFP_TAKEN_TEXT - 1);
    const size_t size = make_tags(exif, &by, 1);
    for (size_t n = 0; n <= size - 6; n++) {
        unsigned char *cut = ffp_alloc(n + 1, 1);
        memcpy(cut, exif + 6, n);
        const FfpTakenBy found = ffp_exif_taken_by(cut, n);
        assert_true(strlen(found.model) <= strlen(by.model) && strlen(found.lens) < FFP_TAKEN_TEXT);
        assert_int_equal(found.focal_35mm > 0, n >= 50 + 2 + 3 * 12 - 2);
        ffp_free(cut);
    }
    const FfpTakenBy all = ffp_exif_taken_by(exif + 6, size - 6);
    assert_string_equal(all.model, by.model);
    assert_string_equal(all.serial, by.serial);
    assert_string_equal(all.lens, by.lens);
    assert_true(all.focal > 49.99 && all.focal < 50.01 && all.focal_35mm > 49 && all.zoom > 0.99);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_odd_one_is_named),
        cmocka_unit_test(data_that_are_cut_say_less),
    };
    return cmocka_run_group_tests(tests, scratch_setup, scratch_teardown);
}
