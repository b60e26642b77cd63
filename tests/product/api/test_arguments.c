// Arguments that a caller in C leaves out, or sets to values that do not exist, are named: no call falls over
// them.
#include "ffprocams/lab.h"
#include "initialised.h"

static FfpError err;

// The call before this one was refused, and said what for.
static void refused(bool right, const char *name) {
    char where[128];
    snprintf(where, sizeof where, "(%s)", name);
    if (!right || err.code != FFP_ERROR_ARGUMENT || !strstr(err.text, where))
        fail_msg("not refused for %s: %s", name, err.text);
    err = (FfpError){0};
}

static void handles_are_asked_for(void **state) {
    (void)state;
    refused(!ffp_context_new(NULL, &err), "settings");
    refused(!ffp_capture_open(NULL, NULL, NULL, &err), "path");
    refused(!ffp_capture_from_memory(NULL, NULL, &err), "data");
    refused(!ffp_capture_from_memory(NULL, &(FfpCaptureData){.n_patterns = 2, .n_views = 1}, &err),
            "patterns");
    refused(!ffp_capture_save(NULL, NULL, "folder", &err), "capture");
    refused(!ffp_capture_save(NULL, capture, NULL, &err), "folder");
    refused(!ffp_can_save_capture(NULL, &err), "folder");
    refused(!ffp_can_write(NULL, &err), "path");
    refused(!ffp_gaussians_open(NULL, NULL, NULL, &err), "path");
    refused(!ffp_gaussians_save(NULL, NULL, "file", &err), "gaussians");
    refused(!ffp_gaussians_save(NULL, gaussians, NULL, &err), "path");
    refused(!ffp_gaussians_from_arrays(NULL, NULL, &err), "arrays");
    refused(!ffp_neural_field_open(NULL, NULL, &err), "path");
    refused(!ffp_neural_field_save(NULL, NULL, "file", &err), "field");
    refused(!ffp_info(NULL, NULL, &err), "path");
    refused(!ffp_info_report(NULL, NULL, "file.html", &err), "path");
    refused(!ffp_info_report(NULL, "capture", NULL, &err), "html");
}

static void fits_are_told_what_to_fit(void **state) {
    (void)state;
    static const char *const one[1] = {NULL};
    const FfpReconstruction how = {.size = sizeof how, .patterns = one, .n_patterns = 1};
    const FfpRefinement fine = {.size = sizeof fine, .steps = 1},
                        further = {.size = sizeof further, .patterns = one, .n_patterns = 1};
    const FfpAlignment aligning = ffp_alignment_defaults();
    FfpReconstruction drawn = {.size = sizeof drawn, .drawing.samples = 5};
    refused(!ffp_reconstruct(NULL, NULL, &how, NULL, &err), "capture");
    refused(!ffp_reconstruct(NULL, capture, NULL, NULL, &err), "options");
    refused(!ffp_reconstruct(NULL, capture, &how, NULL, &err), "patterns[0]");
    refused(!ffp_reconstruct(NULL, capture, &drawn, NULL, &err), "drawing.samples");
    refused(!ffp_refine_gaussians(NULL, NULL, capture, &fine, NULL, &err), "gaussians");
    refused(!ffp_refine_gaussians(NULL, gaussians, NULL, &fine, NULL, &err), "capture");
    refused(!ffp_refine_gaussians(NULL, gaussians, capture, &further, NULL, &err), "patterns[0]");
    refused(!ffp_fit_from_scratch(NULL, NULL, NULL, &fine, NULL, &err), "capture");
    refused(!ffp_fit_from_scratch(NULL, capture, NULL, NULL, NULL, &err), "options");
    refused(!ffp_fit_neural_field(NULL, NULL, &fine, NULL, NULL, &err), "capture");
    refused(!ffp_fit_neural_field(NULL, capture, &further, NULL, NULL, &err), "patterns[0]");
    refused(!ffp_align_poses(NULL, NULL, &aligning, NULL, &err), "capture");
    refused(!ffp_align_poses(NULL, capture, NULL, NULL, &err), "options");
    refused(!ffp_find_projector(NULL, NULL, gaussians, NULL, &err), "capture");
    refused(!ffp_find_projector(NULL, capture, NULL, NULL, &err), "gaussians");
    refused(!ffp_find_projector(NULL, capture, gaussians, NULL, &err), "capture"); // without Gray codes
    // A capture whose photographs were left in their files.
    FfpOpening opening = ffp_opening_defaults();
    opening.photographs = FFP_READ_NONE;
    FfpCapture *devices = ffp_capture_open(NULL, FFP_SOURCE_DIR "/data/sample", &opening, &err);
    const FfpReconstruction plain = ffp_reconstruction_defaults();
    assert_non_null(devices);
    refused(!ffp_reconstruct(NULL, devices, &plain, NULL, &err), "FFP_READ_NONE");
    refused(!ffp_refine_gaussians(NULL, gaussians, devices, &fine, NULL, &err), "FFP_READ_NONE");
    refused(!ffp_fit_from_scratch(NULL, devices, NULL, &fine, NULL, &err), "FFP_READ_NONE");
    refused(!ffp_align_poses(NULL, devices, &aligning, NULL, &err), "FFP_READ_NONE");
    refused(!ffp_capture_save(NULL, devices, "folder", &err), "FFP_READ_NONE");
    ffp_capture_close(devices);
    opening.photographs = 7;
    refused(!ffp_capture_open(NULL, FFP_SOURCE_DIR "/data/sample", &opening, &err), "photographs");
    opening.size = sizeof opening.size + 1; // ends within a field
    refused(!ffp_capture_open(NULL, FFP_SOURCE_DIR "/data/sample", &opening, &err), "FfpOpening");
    opening.size = 0;
    refused(!ffp_capture_open(NULL, FFP_SOURCE_DIR "/data/sample", &opening, &err), "FfpOpening");
}

static void numbers_of_fits_are_in_range(void **state) {
    (void)state;
    static const double no_noise[3] = {NAN, 5, -2};
    for (int i = 0; i < 3; i++) {
        FfpReconstruction how = ffp_reconstruction_defaults();
        FfpRefinement fine = ffp_refinement_defaults();
        how.noise = fine.noise = no_noise[i], fine.steps = 1;
        refused(!ffp_reconstruct(NULL, capture, &how, NULL, &err), "noise");
        refused(!ffp_refine_gaussians(NULL, gaussians, capture, &fine, NULL, &err), "noise");
    }
    FfpReconstruction how = ffp_reconstruction_defaults();
    how.polish = -2;
    refused(!ffp_reconstruct(NULL, capture, &how, NULL, &err), "polish");
    how.polish = 0, how.layers = NAN;
    refused(!ffp_reconstruct(NULL, capture, &how, NULL, &err), "layers");
    how.layers = 0, how.n_patterns = -1;
    refused(!ffp_reconstruct(NULL, capture, &how, NULL, &err), "patterns");
    FfpEvaluation evaluation = ffp_evaluation_defaults();
    int n;
    evaluation.polish = -2;
    refused(!ffp_evaluate(NULL, &evaluation, &n, &err), "polish");
    FfpRefinement fine = ffp_refinement_defaults();
    fine.steps = -1;
    refused(!ffp_refine_gaussians(NULL, gaussians, capture, &fine, NULL, &err), "steps");
    refused(!ffp_fit_from_scratch(NULL, capture, NULL, &fine, NULL, &err), "steps");
    fine.steps = 0, fine.limit_s = NAN;
    refused(!ffp_refine_gaussians(NULL, gaussians, capture, &fine, NULL, &err), "limit_s");
}

static void contexts_are_checked(void **state) {
    (void)state;
    FfpContextSettings settings = ffp_context_defaults();
    settings.threads = 100000;
    refused(!ffp_context_new(&settings, &err), "threads");
    settings.threads = 0, settings.interval_s = NAN;
    refused(!ffp_context_new(&settings, &err), "interval_s");
    settings.interval_s = 0, settings.device = (FfpDeviceKind)9;
    refused(!ffp_context_new(&settings, &err), "device");
    settings.device = FFP_DEVICE_CPU, settings.ranks = &(FfpRanks){.rank = 0, .count = 0};
    refused(!ffp_context_new(&settings, &err), "ranks");
    settings.ranks = &(FfpRanks){.rank = 0, .count = 1};
    refused(!ffp_context_new(&settings, &err), "ranks");
}

static void pictures_are_told_where_to_go(void **state) {
    (void)state;
    static const char *const one[1] = {NULL};
    FfpPictures pictures = ffp_pictures_defaults();
    FfpPage page = ffp_page_defaults();
    FfpCompensation compensation = ffp_compensation_defaults();
    FfpWarps maps = ffp_warps_defaults();
    FfpExport export = ffp_export_defaults();
    FfpPinhole device;
    assert_true(ffp_capture_view_devices(capture, 0, &device, NULL));
    refused(ffp_render_pictures(NULL, gaussians, capture, &pictures, &err) < 0, "folder");
    pictures.folder = "pictures";
    refused(ffp_render_pictures(NULL, NULL, capture, &pictures, &err) < 0, "gaussians");
    refused(ffp_render_pictures(NULL, gaussians, capture, NULL, &err) < 0, "options");
    pictures.orbit = (FfpOrbit)9;
    refused(ffp_render_pictures(NULL, gaussians, capture, &pictures, &err) < 0, "orbit");
    pictures.orbit = FFP_ORBIT_NONE, pictures.views = one, pictures.n_views = 1;
    refused(ffp_render_pictures(NULL, gaussians, capture, &pictures, &err) < 0, "views[0]");
    refused(!ffp_write_page(NULL, gaussians, capture, &page, NULL, &err), "file");
    page.file = "page.html";
    refused(!ffp_write_page(NULL, gaussians, NULL, &page, NULL, &err), "capture");
    compensation.targets = one, compensation.n_targets = 1;
    refused(!ffp_compensate_images(NULL, gaussians, capture, &compensation, NULL, &err), "targets[0]");
    refused(!ffp_compensate_images(NULL, gaussians, NULL, &compensation, NULL, &err), "capture");
    compensation.pictures = &(FfpPicture){0};
    refused(!ffp_compensate_images(NULL, gaussians, capture, &compensation, NULL, &err), "targets");
    compensation.pictures = NULL, compensation.n_targets = 0;
    refused(!ffp_compensate(NULL, gaussians, capture, &compensation, NULL, &err), "pattern");
    refused(ffp_write_warps(NULL, gaussians, capture, &maps, NULL, 0, &err) < 0, "folder");
    refused(!ffp_warp_images(NULL, gaussians, capture, NULL, &device, (FfpDrawing){0}, NULL, &err), "camera");
    refused(!ffp_export(NULL, gaussians, capture, &export, NULL, &err), "file");
    export.file = "a.ply", export.up = (FfpUp)7;
    refused(!ffp_export(NULL, gaussians, capture, &export, NULL, &err), "up");
}

static void sources_are_named(void **state) {
    (void)state;
    static const char *const one[1] = {NULL};
    FfpEvaluation evaluation = ffp_evaluation_defaults();
    FfpTraining training = ffp_training_defaults();
    FfpGeneration generation = ffp_generation_defaults();
    FfpPatterns patterns = ffp_patterns_defaults();
    FfpRigCalibration calibration = ffp_rig_calibration_defaults();
    FfpImport import = ffp_import_defaults();
    int n = 5;
    evaluation.captures = one, evaluation.n_captures = 1;
    refused(!ffp_evaluate(NULL, &evaluation, &n, &err), "captures[0]");
    assert_int_equal(n, 0);
    refused(!ffp_evaluate(NULL, NULL, &n, &err), "options");
    refused(!ffp_lpips(NULL, NULL, NULL, NULL, 0, NULL, &err), "weights");
    refused(!ffp_lpips(NULL, "weights", NULL, NULL, 1, NULL, &err), "a");
    refused(!ffp_lpips(NULL, "weights", NULL, NULL, -1, NULL, &err), "n");
    refused(!ffp_train_model(NULL, &training, &err), "out");
    refused(!ffp_generate(NULL, &generation, &err), "folder");
    generation = (FfpGeneration){.size = sizeof(FfpGeneration), .folder = "scenes", .seed = UINT64_MAX};
    refused(!ffp_generate(NULL, &generation, &err), "seed");
    refused(ffp_write_patterns(NULL, &patterns, &err) < 0, "folder");
    calibration.n_attitudes = 3;
    refused(!ffp_calibrate_rig(NULL, &calibration, NULL, &err), "attitudes");
    refused(!ffp_import_capture(NULL, &import, &err), "folder");
    import.folder = "capture", import.calibrations = one, import.n_calibrations = 1;
    refused(!ffp_import_capture(NULL, &import, &err), "calibrations[0]");
    import.n_calibrations = 0, import.n_patterns = 1;
    import.patterns = &(FfpImportPattern){.name = "stripes"};
    refused(!ffp_import_capture(NULL, &import, &err), "patterns.file");
}

// Samples beyond what a pixel can have, and forms that there are not, in every call that draws.
static void drawings_are_checked(void **state) {
    (void)state;
    static const FfpDrawing bad[4] = {
        {.samples = 5}, {.samples = -1}, {.samples = 33554432}, {.form = (FfpForm)3}};
    FfpPictures pictures = ffp_pictures_defaults();
    FfpPage page = ffp_page_defaults();
    FfpCompensation compensation = ffp_compensation_defaults();
    FfpWarps maps = ffp_warps_defaults();
    FfpExport export = ffp_export_defaults();
    FfpEvaluation evaluation = ffp_evaluation_defaults();
    FfpPinhole camera, projector;
    int n;
    pictures.folder = maps.folder = "folder", page.file = compensation.pattern = "file";
    export.file = "a.ply", export.form = (FfpForm)3;
    assert_true(ffp_capture_view_devices(capture, 0, &camera, &projector));
    for (int i = 0; i < 4; i++) {
        const char *field = i < 3 ? "drawing.samples" : "drawing.form";
        const FfpRefinement how = {.size = sizeof how, .steps = 1, .drawing = bad[i]};
        pictures.drawing = page.drawing = compensation.drawing = maps.drawing = evaluation.drawing = bad[i];
        refused(!ffp_renderer_new(NULL, bad[i], &err), field);
        refused(ffp_render_pictures(NULL, gaussians, capture, &pictures, &err) < 0, field);
        refused(!ffp_write_page(NULL, gaussians, capture, &page, NULL, &err), field);
        refused(!ffp_compensate(NULL, gaussians, capture, &compensation, NULL, &err), field);
        refused(!ffp_compensate_images(NULL, gaussians, capture, &compensation, NULL, &err), field);
        refused(ffp_write_warps(NULL, gaussians, capture, &maps, NULL, 0, &err) < 0, field);
        refused(!ffp_warp_images(NULL, gaussians, capture, &camera, &projector, bad[i], NULL, &err), field);
        refused(!ffp_refine_gaussians(NULL, gaussians, capture, &how, NULL, &err), field);
        refused(!ffp_fit_from_scratch(NULL, capture, NULL, &how, NULL, &err), field);
        refused(!ffp_evaluate(NULL, &evaluation, &n, &err), field);
    }
    refused(!ffp_export(NULL, gaussians, capture, &export, NULL, &err), "drawing.form");
    FfpWarpStats two[2]; // for three views
    maps.drawing = (FfpDrawing){0}, maps.folder = in_scratch("maps");
    refused(ffp_write_warps(NULL, gaussians, capture, &maps, two, 2, &err) < 0, "stats");
    assert_false(ffp_is_folder(in_scratch("maps")));
    FfpRenderer *renderer = ffp_renderer_new(NULL, (FfpDrawing){.samples = 4}, &err);
    assert_non_null(renderer);
    refused(!ffp_renderer_aim(NULL, NULL, gaussians, &camera, &projector, &err), "renderer");
    refused(!ffp_renderer_aim(NULL, renderer, gaussians, NULL, &projector, &err), "camera");
    assert_true(ffp_renderer_aim(NULL, renderer, gaussians, &camera, &projector, &err));
    refused(!ffp_renderer_shade(NULL, renderer, NULL, NULL, &n, sizeof n, FFP_PIXELS_U8, 0, &err),
            "intensity");
    const double light[3] = {1, 1, 1};
    float *out = ffp_alloc((size_t)camera.width * (size_t)camera.height * 4, sizeof *out);
    const size_t bytes = (size_t)camera.width * (size_t)camera.height * 4 * sizeof *out,
                 row = 3 * sizeof *out * (size_t)camera.width;
    refused(!ffp_renderer_shade(NULL, renderer, NULL, light, out, bytes, FFP_PIXELS_F32, row + 1, &err),
            "row_bytes");
    assert_true(ffp_renderer_shade(NULL, renderer, NULL, light, out, bytes, FFP_PIXELS_F32, row + 4, &err));
    ffp_free(out);
    refused(!ffp_renderer_map(NULL, renderer, FFP_MAP_DEPTH, NULL, 0, &err), "out");
    refused(!ffp_renderer_map(NULL, renderer, FFP_MAP_COUNT, (float[1]){0}, 1, &err), "map");
    ffp_renderer_close(renderer);
}

// --- Gaussians too faint to be drawn. ---

static FfpGaussians *with_opacity(const float opacity[3]) {
    FfpGaussianArrays arrays = ffp_gaussians_arrays(gaussians);
    assert_true(arrays.count >= 3);
    arrays.count = 3, arrays.opacity = (float *)opacity;
    FfpGaussians *made = ffp_gaussians_from_arrays(NULL, &arrays, &err);
    assert_non_null(made);
    return made;
}

static void faint_gaussians_are_not_saved(void **state) {
    (void)state;
    static const float some[3] = {0.5F, 0.003F, 1.0F / 255}, none[3] = {0, 0.003F, 0.0039F};
    const char *path = in_scratch("some.ply");
    FfpGaussians *made = with_opacity(some);
    assert_true(ffp_gaussians_save(NULL, made, path, &err));
    ffp_gaussians_close(made);
    made = ffp_gaussians_open(NULL, path, NULL, &err);
    assert_int_equal(ffp_gaussians_count(made), 2);
    ffp_gaussians_close(made);
    made = with_opacity(none);
    path = in_scratch("none.ply");
    assert_false(ffp_gaussians_save(NULL, made, path, &err));
    assert_int_equal(err.code, FFP_ERROR_ARGUMENT);
    assert_non_null(strstr(err.text, "no Gaussian is opaque enough"));
    assert_false(ffp_is_file(path));
    ffp_gaussians_close(made);
}

// --- Numbers written through the arrays. ---

static void numbers_from_outside_are_checked_at_use(void **state) {
    (void)state;
    FfpGaussianArrays arrays = ffp_gaussians_arrays(gaussians);
    float *const places[] = {arrays.centre + 7,    arrays.rotation + 9, arrays.albedo + 8, arrays.ambient + 6,
                             arrays.roughness + 2, arrays.opacity + 2,  arrays.scale + 6};
    const char *const names[] = {"centre", "rotation", "albedo", "ambient", "roughness", "opacity", "scale"};
    FfpPinhole camera, projector;
    assert_true(ffp_capture_view_devices(capture, 0, &camera, &projector));
    FfpRenderer *renderer = ffp_renderer_new(NULL, (FfpDrawing){0}, &err);
    for (int i = 0; i < 7; i++) {
        const float kept = *places[i];
        FfpPictures how = ffp_pictures_defaults();
        how.folder = in_scratch("pictures");
        *places[i] = NAN;
        assert_false(ffp_renderer_aim(NULL, renderer, gaussians, &camera, &projector, &err));
        assert_int_equal(err.code, FFP_ERROR_ARGUMENT);
        if (!strstr(err.text, names[i]) || !strstr(err.text, "row 2")) fail_msg("%s: %s", names[i], err.text);
        assert_int_equal(ffp_render_pictures(NULL, gaussians, capture, &how, &err), -1);
        assert_false(ffp_is_folder(in_scratch("pictures")));
        assert_false(ffp_gaussians_save(NULL, gaussians, in_scratch("nan.ply"), &err));
        *places[i] = kept;
    }
    assert_true(ffp_renderer_aim(NULL, renderer, gaussians, &camera, &projector, &err));
    ffp_renderer_close(renderer);
}

// --- Pictures' names. ---

static int render(const char *const *views, int n_views, const char *const *patterns, int n_patterns,
                  bool maps, const char *video) {
    FfpPictures how = ffp_pictures_defaults();
    how.views = views, how.n_views = n_views, how.patterns = patterns, how.n_patterns = n_patterns;
    how.maps = maps, how.video = video, how.folder = in_scratch("pictures");
    err = (FfpError){0};
    return ffp_render_pictures(NULL, gaussians, capture, &how, &err);
}

static void nothing_but(const char *words) {
    if (err.code != FFP_ERROR_ARGUMENT || !strstr(err.text, words)) fail_msg("not %s: %s", words, err.text);
    assert_false(ffp_is_folder(in_scratch("pictures")));
}

static void pictures_have_names_of_their_own(void **state) {
    (void)state;
    char albedo[FFP_PATH_MAX], film[FFP_PATH_MAX], id[FFP_NAME_MAX];
    FfpImage grey = ffp_image_new(SMALL_PATTERN, SMALL_PATTERN, 3);
    assert_true(ffp_join_path(albedo, scratch, "albedo.png") && ffp_join_path(film, scratch, "film.png"));
    assert_true(ffp_image_write_png(&grey, albedo, NULL));
    snprintf(id, sizeof id, "%s", capture->views[1].id);
    const char *const views[2] = {capture->views[0].id, capture->views[0].id};
    const char *const both[2] = {capture->views[0].id, capture->views[1].id}, *const pattern[1] = {albedo};
    assert_int_equal(render(views, 1, pattern, 1, true, NULL), -1);
    nothing_but("_albedo.png");
    assert_int_equal(render(views, 2, NULL, 0, false, NULL), -1);
    nothing_but("is named twice");
    // Of `a` and `a_b` under `b_c` and `c` two would be a_b_c.png.
    char b_c[FFP_PATH_MAX], c[FFP_PATH_MAX];
    assert_true(ffp_join_path(b_c, scratch, "b_c.png") && ffp_join_path(c, scratch, "c.png"));
    assert_true(ffp_image_write_png(&grey, b_c, NULL) && ffp_image_write_png(&grey, c, NULL));
    const char *const crossed[2] = {b_c, c};
    snprintf(capture->views[1].id, sizeof id, "%.80s_b", capture->views[0].id);
    assert_int_equal(render(both, 2, crossed, 2, false, NULL), -1);
    nothing_but("_b_c.png");
    snprintf(capture->views[1].id, sizeof id, "%s", id);
    assert_int_equal(render(both, 2, crossed, 2, true, NULL), 18); // each under two, with seven maps
    assert_int_equal(render(views, 2, NULL, 0, false, film), 2);   // frames have numbers
    ffp_image_free(&grey);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(handles_are_asked_for),
        cmocka_unit_test(fits_are_told_what_to_fit),
        cmocka_unit_test(numbers_of_fits_are_in_range),
        cmocka_unit_test(contexts_are_checked),
        cmocka_unit_test(pictures_are_told_where_to_go),
        cmocka_unit_test(sources_are_named),
        cmocka_unit_test(drawings_are_checked),
        cmocka_unit_test(numbers_from_outside_are_checked_at_use),
        cmocka_unit_test(faint_gaussians_are_not_saved),
        cmocka_unit_test(pictures_have_names_of_their_own),
    };
    return cmocka_run_group_tests(tests, setup, teardown);
}
