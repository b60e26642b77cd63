// Files that a calibration is read from and written to: photographs in order, names of any bytes, drawings.
#include "core/patterns/patterns.h"
#include "core/patterns/shown.h"
#include "rig/calibrate/calibrate.h"
#include "rig/chessboard/attitudes.h"
#include "rig/optics/document.h"
#include "scratch.h"

// A rig that is calibrated as it is in truth, whose first two attitudes have this name.
static FfpRigFit known_rig(const char *name) {
    FfpRng rng = ffp_rng(4, 1);
    FfpRigFit fit = new_rig_fit(3);
    for (int i = 0; i < 3; i++) fit.attitudes[i] = new_attitude(i < 2 ? name : "last", 0.1, &rng);
    memcpy(fit.devices, true_devices, sizeof fit.devices);
    ffp_rotation_from_vector(true_turn, fit.r), memcpy(fit.t, true_shift, sizeof fit.t);
    snprintf(fit.attitudes[1].problem, sizeof fit.attitudes[1].problem, "%s is not a name", name);
    return fit;
}

typedef struct Name {
    const char *given, *kept;
} Name;

static void names_of_any_bytes_can_be_read(void **state) {
    (void)state;
    static const Name names[] = {
        {"pose_1", "name: \"pose_1\""},
        {"K\xc3\xb6ln \xe2\x82\xac \xf0\x9f\x8e\xa5", "K\xc3\xb6ln \xe2\x82\xac \xf0\x9f\x8e\xa5\""},
        {"K\xf6ln", "\"K?ln\""},                           // Latin-1
        {"a\xc3", "\"a?\""},                               // cut short
        {"\xe2\x82z\xc0\xaf\xed\xa0\x80", "\"??z?????\""}, // no characters: cut, too long, a surrogate
        {"\xf8\x88\x80\x80\x80\xff", "\"??????\""},        // never in UTF-8
        {"a\tb\x7f\xc2\x85g", "\"a?b???g\""},              // control characters
        {"\xef\xbf\xbf\xef\xbb\xbf.", "\"??????.\""},      // what XML or YAML refuses
    };
    static const char *const files[2] = {"names.yml", "names.xml"};
    for (size_t i = 0; i < sizeof names / sizeof *names; i++) {
        FfpRigFit fit = known_rig(names[i].given);
        for (int form = 0; form < 2; form++) {
            const char *path = in_scratch(files[form]), *keyed = strchr(names[i].kept, '"');
            FfpError err = {0};
            char *text;
            size_t size;
            if (!ffp_write_calibration(&fit, path, &err)) fail_msg("%s", err.text);
            FfpNode root;
            if (!ffp_document_open(&root, path, &err)) fail_msg("%s", err.text);
            ffp_node_close(&root);
            assert_true(ffp_read_text(path, 1 << 20, &text, &size, &err));
            assert_non_null(strstr(text, form == 0 ? names[i].kept : keyed));
            ffp_free(text);
        }
        ffp_rig_fit_free(&fit);
    }
}

// Pixel centres lie at integers in the calibration and at halves in drawings.
static void drawings_have_pixels_at_their_places(void **state) {
    (void)state;
    FfpRigFit fit = known_rig("pose");
    FfpError err = {0};
    char *text;
    size_t size;
    fit.attitudes[0].picture = ffp_image_new(CAMERA_W, CAMERA_H, 1);
    fit.attitudes[0].camera[0] = 100, fit.attitudes[0].camera[1] = 59.75;
    fit.attitudes[0].projector[0] = 20, fit.attitudes[0].projector[1] = 30;
    assert_true(ffp_write_calibration_report(&fit, NULL, in_scratch("report.html"), &err));
    assert_true(ffp_read_text(in_scratch("report.html"), 1 << 24, &text, &size, &err));
    const char *field = strstr(text, "<circle cx=100.5 cy=60.2 "), *arrow = strstr(text, "M100.5 60.2l");
    assert_true(field && arrow);
    assert_non_null(strstr(field + 1, "<circle cx=100.5 cy=60.2 ")); // the board's drawing
    assert_non_null(strstr(text, "<circle cx=20.5 cy=30.5 "));
    ffp_free(text);
    ffp_rig_fit_free(&fit);
}

// Names that are one number in natural order, whatever order the folder lists them in.
static void names_of_one_number_have_an_order(void **state) {
    (void)state;
    enum { NAMES = 8 };
    for (int turn = 0; turn < 2; turn++) {
        char folder[FFP_PATH_MAX], name[32];
        snprintf(folder, sizeof folder, "%s", in_scratch(turn ? "up" : "down"));
        assert_int_equal(mkdir(folder, 0777), 0);
        for (int i = 0; i < NAMES; i++) {
            char path[FFP_PATH_MAX + 32];
            snprintf(path, sizeof path, "%s/%0*d.png", folder, turn ? i + 1 : NAMES - i, 7);
            assert_true(ffp_write_file(path, "", 0, NULL));
        }
        const char *paths[1] = {folder};
        FfpShotFolders found;
        FfpError err = {0};
        if (!ffp_shot_folders_find(&found, paths, 1, &err)) fail_msg("%s", err.text);
        assert_true(found.n == 1 && found.folders[0].n_files == NAMES);
        for (int i = 0; i < NAMES; i++) {
            snprintf(name, sizeof name, "%0*d.png", NAMES - i, 7);
            assert_string_equal(ffp_basename(found.folders[0].files[i]), name);
        }
        ffp_shot_folders_free(&found);
    }
}

// A folder of files whose numbers go from 1 to `last`, but for some.
static void put_numbered(const char *folder, int last, int without, int without_too) {
    assert_true(ffp_make_folders(in_scratch(folder), NULL));
    for (int i = 1; i <= last; i++) {
        char path[FFP_PATH_MAX];
        snprintf(path, sizeof path, "%s/%03d.png", in_scratch(folder), i);
        if (i != without && i != without_too) assert_true(ffp_write_file(path, "", 0, NULL));
    }
}

// Which photograph is missing, the files' numbers tell; what calibration does not need may be.
static void missing_photographs_are_named(void **state) {
    (void)state;
    const FfpShow show = {.width = 64, .height = 64, .lollipops = 1, .capture = true, .gray_codes = true};
    static const char *const names[] = {"p-10", "p-11", "p-12", "p-2", "p-9"};
    char paths[5][FFP_PATH_MAX];
    const char *given[5];
    FfpShotFolders found;
    FfpError err = {0};
    FfpShown shown;
    int width, height;
    assert_true(ffp_show_write_folder(&show, in_scratch("shown"), &err));
    assert_true(ffp_shown_read(&shown, in_scratch("shown"), &err));
    const int others = shown.n - shown.n_codes;
    put_numbered("p-2", shown.n, 0, 0);
    put_numbered("p-9", shown.n, others, others > 3 ? others - 1 : 0); // without its lollipops
    put_numbered("p-10", shown.n, others + 3, others + 6);             // codes of two pairs
    put_numbered("p-11", shown.n, others + 3, 0);                      // one may be missing
    put_numbered("p-12", shown.n, 1, 0);                               // also black
    for (int i = 0; i < 5; i++) {
        snprintf(paths[i], sizeof paths[i], "%s", in_scratch(names[i]));
        given[i] = paths[i];
    }
    if (!ffp_shot_folders_find(&found, given, 5, &err)) fail_msg("%s", err.text);
    assert_string_equal(found.folders[0].name, "p-2"); // not as bytes have it
    assert_string_equal(found.folders[2].name, "p-10");
    assert_true(ffp_shot_folders_select_codes(&found, in_scratch("shown"), &width, &height, &err));
    assert_null(found.folders[0].problem);
    assert_null(found.folders[1].problem);
    const char **codes = found.folders[2].files + 2;
    assert_true(!found.folders[2].problem && !codes[2] && codes[3] && codes[4] && !codes[5]);
    assert_null(found.folders[3].problem);
    assert_null(found.folders[3].files[4]);
    assert_null(found.folders[4].problem);
    assert_int_equal(found.folders[4].n_files, 1 + shown.n_codes);
    assert_string_equal(ffp_basename(found.folders[4].files[0]), "002.png");
    ffp_shown_free(&shown);
    ffp_shot_folders_free(&found);
}

// Folders of one name are told apart by the rest of their paths.
static void folders_of_one_name_are_told_apart(void **state) {
    (void)state;
    static const char *const days[2] = {"mon", "tue"};
    char paths[2][FFP_PATH_MAX];
    const char *given[2];
    FfpShotFolders found;
    FfpError err = {0};
    for (int i = 0; i < 2; i++) {
        char name[32];
        snprintf(name, sizeof name, "%s/left/shots", days[i]);
        snprintf(paths[i], sizeof paths[i], "%s", in_scratch(name));
        assert_true(ffp_make_folders(paths[i], &err));
        put_numbered(name, 3, 0, 0);
        given[i] = paths[i];
    }
    if (!ffp_shot_folders_find(&found, given, 2, &err)) fail_msg("%s", err.text);
    for (int i = 0; i < 2; i++) assert_string_equal(found.folders[i].name, days[i]);
    ffp_shot_folders_free(&found);
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(names_of_any_bytes_can_be_read),
                                       cmocka_unit_test(drawings_have_pixels_at_their_places),
                                       cmocka_unit_test(names_of_one_number_have_an_order),
                                       cmocka_unit_test(missing_photographs_are_named),
                                       cmocka_unit_test(folders_of_one_name_are_told_apart)};
    return cmocka_run_group_tests(tests, scratch_setup, scratch_teardown);
}
