// The lens that photographs' files tell: of every file, not of a folder's first.
#include "core/base/call.h"
#include "core/capture/capture.h"
#include "rig/selfcal/selfcal.h"
#include "rig/shots/tagged.h"
#include "scratch.h"

enum { PLACES = 3, FILES = 5 };

// A grey JPEG whose EXIF data say a focal length, mm of 35 mm film, and how the camera was held.
static void write_photograph(int place, int file, double focal, int orientation) {
    unsigned char grey[3 * 64 * 64];
    char name[64];
    memset(grey, 100, sizeof grey);
    snprintf(name, sizeof name, "%d", place);
    mkdir(in_scratch(name), 0777);
    snprintf(name, sizeof name, "%d/%03d.jpg", place, file);
    write_tagged(in_scratch(name), grey, 64, 64, &(FfpTakenBy){.focal_35mm = focal}, orientation);
}

static void keep_finding(void *user, const FfpFinding *finding) {
    char *said = user;
    const size_t used = strlen(said);
    snprintf(said + used, 1024 - used, "%s %s %s %.0f %.0f\n", finding->code, finding->view, finding->text,
             finding->figure, finding->limit);
}

static bool read_all(void *argument, FfpError *err) {
    (void)argument;
    const char *const folders[] = {scratch};
    const FfpSelfCalibration options = {.places = folders, .n_places = 1, .width = 64, .height = 64};
    FfpTracks tracks = {0};
    const bool ok = ffp_places_read(&options, &tracks, err);
    assert_float_equal(tracks.focal_35mm, 50, 0);
    ffp_tracks_free(&tracks);
    return ok;
}

static void every_file_says_its_lens(void **state) {
    (void)state;
    char said[1024] = "";
    FfpContext context = {.settings = {.finding = keep_finding, .user = said}};
    FfpError err = {0};
    for (int p = 0; p < PLACES; p++)
        for (int f = 0; f < FILES; f++) write_photograph(p, f, p == 2 ? 28 : p == 1 && f == 3 ? 70 : 50, 1);
    ffp_call_run(&context, read_all, NULL, &err);
    printf("%s", said);
    assert_non_null(strstr(said, "file-lens 1 the photograph '003.jpg' says a focal length of 70 mm"));
    assert_non_null(strstr(said, "place-lens 2 "));
    assert_null(strstr(said, "place-lens 1 "));
}

// The codes of the findings behind what is wrong with three places, the second of which is tagged within, and
// the third as a whole; `angles`: of a turntable.
static void read_tagged(const double *angles, const char *codes[PLACES]) {
    const char *const folders[] = {scratch};
    const FfpSelfCalibration options = {.places = folders,
                                        .n_places = 1,
                                        .width = 64,
                                        .height = 64,
                                        .angles = angles,
                                        .n_angles = angles ? PLACES : 0};
    FfpTracks tracks = {0};
    FfpError err = {0};
    for (int p = 0; p < PLACES; p++)
        for (int f = 0; f < FILES; f++) write_photograph(p, f, 50, p == 2 || (p == 1 && f == 3) ? 3 : 1);
    assert_true(ffp_places_read(&options, &tracks, &err));
    for (int p = 0; p < PLACES; p++) codes[p] = tracks.places[p].finding ? tracks.places[p].finding : "";
    ffp_tracks_free(&tracks);
}

// Within a place nothing turns; from stop to stop of a turntable the camera does not either.
static void orientations_must_be_alike(void **state) {
    (void)state;
    static const double angles[PLACES] = {0, 30, 60};
    for (int turns = 0; turns < 2; turns++) {
        const char *codes[PLACES];
        read_tagged(turns ? angles : NULL, codes);
        assert_string_not_equal(codes[0], "orientation-tags-mixed");
        assert_string_equal(codes[1], "orientation-tags-mixed");
        assert_int_equal(strcmp(codes[2], "orientation-tags-differ") == 0, turns);
    }
}

// True if a folder of one photograph that is called so is refused for its name; otherwise it must be read.
static bool refuses_name(const char *name, const double *angles) {
    char file[512];
    unsigned char grey[3 * 64 * 64] = {0};
    snprintf(file, sizeof file, "named/%s", name);
    mkdir(in_scratch("named"), 0777), mkdir(in_scratch(file), 0777);
    snprintf(file, sizeof file, "named/%s/001.jpg", name);
    write_tagged(in_scratch(file), grey, 64, 64, &(FfpTakenBy){.focal_35mm = 50}, 1);
    snprintf(file, sizeof file, "%s", in_scratch("named"));
    snprintf(file + strlen(file), sizeof file - strlen(file), "/%s", name);
    const char *const folders[] = {file};
    const FfpSelfCalibration options = {.places = folders,
                                        .n_places = 1,
                                        .width = 64,
                                        .height = 64,
                                        .angles = angles,
                                        .n_angles = angles != NULL};
    FfpTracks tracks = {0};
    FfpError err = {0};
    const bool ok = ffp_places_read(&options, &tracks, &err);
    ffp_tracks_free(&tracks);
    assert_true(ok || strstr(err.text, "rename"));
    return !ok;
}

// No place of a walk may be called as the projector's picture, or have a name that no view can have.
static void names_must_do_for_views(void **state) {
    (void)state;
    static const double angle = 0;
    char longest[FFP_NAME_MAX + 1];
    memset(longest, 'a', sizeof longest);
    longest[FFP_NAME_MAX] = 0;
    assert_true(refuses_name("calib", NULL) && refuses_name("calib.old", NULL));
    assert_true(refuses_name(longest, NULL) && refuses_name("mitte\xe4", NULL));
    assert_false(refuses_name("calib", &angle) || refuses_name(longest, &angle));
    assert_false(refuses_name("calibration", NULL) || refuses_name(longest + 1, NULL));
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(every_file_says_its_lens),
                                       cmocka_unit_test(orientations_must_be_alike),
                                       cmocka_unit_test(names_must_do_for_views)};
    return cmocka_run_group_tests(tests, scratch_setup, scratch_teardown);
}
