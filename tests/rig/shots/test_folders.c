// Folders of photographs in the order in which they were taken.
#include "core/base/call.h"
#include "core/image/image.h"
#include "rig/shots/folders.h"
#include "scratch.h"

static void keep_finding(void *user, const FfpFinding *finding) {
    snprintf(user, 256, "%s: %s", finding->code, finding->text);
}

static bool find(void *folders, FfpError *err) {
    char paths[3][FFP_PATH_MAX];
    static const char *const names[3] = {"stop135", "stop45", "stop90"}; // as a shell lists them
    const char *given[3];
    for (int i = 0; i < 3; i++) {
        snprintf(paths[i], sizeof paths[i], "%s/%s", scratch, names[i]);
        given[i] = paths[i];
        mkdir(paths[i], 0777);
        FfpImage grey = ffp_image_new(8, 8, 1);
        char file[FFP_PATH_MAX + 8];
        snprintf(file, sizeof file, "%s/1.png", paths[i]);
        assert_true(ffp_image_write_png(&grey, file, err));
        ffp_image_free(&grey);
    }
    return ffp_shot_folders_find(folders, given, 3, err);
}

static void they_are_taken_in_the_order_of_their_numbers(void **state) {
    (void)state;
    char said[256] = "";
    FfpContext context = {.settings = {.finding = keep_finding, .user = said}};
    FfpError err = {0};
    FfpShotFolders folders;
    if (!ffp_call_run(&context, find, &folders, &err)) fail_msg("%s", err.text);
    assert_non_null(strstr(said, "folders-order: "));
    assert_string_equal(folders.folders[0].name, "stop45");
    assert_string_equal(folders.folders[2].name, "stop135");
    ffp_shot_folders_free(&folders);
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(they_are_taken_in_the_order_of_their_numbers)};
    return cmocka_run_group_tests(tests, scratch_setup, scratch_teardown);
}
