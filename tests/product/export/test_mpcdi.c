// Several projectors in one archive: which share a content, and names that XML must not take for its own.
#include <unistd.h>
#include "product/export/mpcdi.h"
#include "unzip.h"

#define PATH "test_mpcdi.mpcdi"
#define OLD "test_mpcdi-1.0.mpcdi"

static FfpView view_of(const char *id, real right) {
    FfpView view = {.id = "",
                    .camera = {.width = 64, .height = 48, .fx = 50, .fy = 50, .cx = 32, .cy = 24},
                    .projector = {.width = 20, .height = 10}};
    for (int k = 0; k < 4; k++) view.camera.pose[5 * k] = 1;
    view.camera.pose[3] = right;
    snprintf(view.id, sizeof view.id, "%s", id);
    return view;
}

static int count_of(const char *text, const char *part) {
    int count = 0;
    for (const char *at = strstr(text, part); at; at = strstr(at + 1, part)) count++;
    return count;
}

// Version 1.0 has the same files under other words, which its readers insist on.
static void check_old(unsigned char *bytes, size_t room) {
    static const char *const words[] = {
        "<MPCDI profile=\"2d\" level=\"1\" date=\"",
        " version=\"1.0\">",
        "<buffer id=\"left &lt;a&gt;\" Xresolution=\"64\" Yresolution=\"48\">",
        "<region id=\"other\" Xresolution=\"20\" Yresolution=\"10\" x=\"0.0\"",
        "<geometricUnit>unknown</geometricUnit>",
        "<originof3DData>centerOfMass</originof3DData>"};
    bytes[unpack(OLD, "mpcdi.xml", bytes, room - 1)] = 0;
    for (size_t i = 0; i < sizeof words / sizeof *words; i++)
        if (!strstr((const char *)bytes, words[i])) fail_msg("no %s", words[i]);
    assert_null(strstr((const char *)bytes, "xResolution"));
    assert_int_equal(unpack(OLD, "warp2.pfm", bytes, room), strlen("PF\n20 10\n-1.0\n") + 20 * 10 * 12);
}

static void projectors_of_one_camera_share_its_picture(void **state) {
    (void)state;
    const FfpView views[3] = {view_of("left <a>", 0), view_of("other", 1), view_of("right \"b\"", 0)};
    FfpImage map = ffp_image_new(20, 10, 3);
    FfpMpcdi mpcdi;
    FfpError err = {0};
    static unsigned char bytes[65536];
    if (!ffp_mpcdi_open(&mpcdi, PATH, &err)) fail_msg("%s", err.text);
    for (int v = 0; v < 3; v++) assert_true(ffp_mpcdi_add(&mpcdi, &views[v], &map, &err));
    assert_true(ffp_mpcdi_commit(&mpcdi, &err));
    ffp_mpcdi_abort(&mpcdi);
    bytes[unpack(PATH, "mpcdi.xml", bytes, sizeof bytes - 1)] = 0;
    const char *xml = (const char *)bytes,
               *first = strstr(xml, "<buffer id=\"left &lt;a&gt;\" xResolution=\"64\""),
               *end = first ? strstr(first, "</buffer>") : NULL,
               *right = strstr(xml, "<region id=\"right &quot;b&quot;\"");
    assert_true(end && right && right > first && right < end);
    assert_true(strstr(xml, "<region id=\"other\"") > end);
    assert_int_equal(count_of(xml, "<buffer "), 2);
    assert_int_equal(count_of(xml, "<region "), 3);
    assert_int_equal(count_of(xml, "<fileset "), 3);
    assert_non_null(strstr(xml, "<path>warp2.pfm</path>"));
    assert_int_equal(unpack(PATH, "warp2.pfm", bytes, sizeof bytes),
                     strlen("PF\n20 10\n-1.0\n") + 20 * 10 * 12);
    ffp_image_free(&map);
    check_old(bytes, sizeof bytes);
    unlink(PATH);
    unlink(OLD);
}

static void an_archive_ends_at_four_gigabytes(void **state) {
    (void)state;
    FfpView view = view_of("large", 0);
    const FfpView *views[40];
    for (int v = 0; v < 40; v++) views[v] = &view;
    view.projector.width = 3840, view.projector.height = 2160;
    assert_true(ffp_mpcdi_holds(views, 36));
    assert_false(ffp_mpcdi_holds(views, 37));
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(projectors_of_one_camera_share_its_picture),
                                       cmocka_unit_test(an_archive_ends_at_four_gigabytes)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
