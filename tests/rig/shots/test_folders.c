// Folders of photographs in the order in which they were taken.
#include "core/base/call.h"
#include "core/base/file.h"
#include "core/image/image.h"
#include "rig/shots/folders.h"
#include "scratch.h"

static void keep_finding(void *user, const FfpFinding *finding) {
    snprintf(user, 256, "%s: %s", finding->code, finding->text);
}

static void write_photograph(const char *folder) {
    char file[FFP_PATH_MAX];
    FfpImage grey = ffp_image_new(8, 8, 1);
    snprintf(file, sizeof file, "%s/1.png", folder);
    assert_true(ffp_make_folders(folder, NULL));
    assert_true(ffp_image_write_png(&grey, file, NULL));
    ffp_image_free(&grey);
}

static bool find(FfpShotFolders *folders, const char *const names[3], FfpError *err) {
    char paths[3][FFP_PATH_MAX];
    const char *given[3];
    for (int i = 0; i < 3; i++) {
        snprintf(paths[i], sizeof paths[i], "%s/%s", scratch, names[i]);
        given[i] = paths[i];
        write_photograph(paths[i]);
    }
    return ffp_shot_folders_find(folders, given, 3, err);
}

static bool find_stops(void *folders, FfpError *err) {
    return find(folders, (const char *[]){"stop135", "stop45", "stop90"}, err); // as a shell lists them
}

static void they_are_taken_in_the_order_of_their_numbers(void **state) {
    (void)state;
    char said[256] = "";
    FfpContext context = {.settings = {.finding = keep_finding, .user = said}};
    FfpError err = {0};
    FfpShotFolders folders;
    if (!ffp_call_run(&context, find_stops, &folders, &err)) fail_msg("%s", err.text);
    assert_non_null(strstr(said, "folders-order: "));
    assert_string_equal(folders.folders[0].name, "stop45");
    assert_string_equal(folders.folders[2].name, "stop135");
    ffp_shot_folders_free(&folders);
}

// By one part of their paths, or by several.
static void those_of_one_name_are_told_apart(void **state) {
    (void)state;
    static const char *const given[2][3] = {{"mon/a/shots", "tue/a/shots", "wed/a/shots"},
                                            {"a/x/shots", "a/y/shots", "b/x/shots"}},
                             *const names[2][3] = {{"mon", "tue", "wed"},
                                                   {"a-x-shots", "a-y-shots", "b-x-shots"}};
    for (int k = 0; k < 2; k++) {
        FfpShotFolders folders;
        FfpError err = {0};
        if (!find(&folders, given[k], &err)) fail_msg("%s", err.text);
        for (int i = 0; i < 3; i++) assert_string_equal(folders.folders[i].name, names[k][i]);
        ffp_shot_folders_free(&folders);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(they_are_taken_in_the_order_of_their_numbers),
                                       cmocka_unit_test(those_of_one_name_are_told_apart)};
    return cmocka_run_group_tests(tests, scratch_setup, scratch_teardown);
}
