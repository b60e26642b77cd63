// Files that a calibration is read from and written to: photographs in order, names of any bytes, drawings.
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

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(names_of_any_bytes_can_be_read),
                                       cmocka_unit_test(drawings_have_pixels_at_their_places),
                                       cmocka_unit_test(names_of_one_number_have_an_order)};
    return cmocka_run_group_tests(tests, scratch_setup, scratch_teardown);
}
