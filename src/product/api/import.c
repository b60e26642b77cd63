// Photographs and calibrations of other tools into a capture.
#include "rig/import/import.h"
#include <string.h>
#include "core/base/call.h"
#include "product/api/arguments.h"

void ffp_import_defaults_into(FfpImport *options, size_t size) {
    ffp_give_defaults(options, size, &(FfpImport){.kept_codes = 8}, sizeof(FfpImport));
}

// Checks for values that a caller in C may pass though the type says otherwise.
static bool check_choices(const FfpImport *options, FfpError *err) {
    return ffp_check_choice((int)options->masks, FFP_MASKS_FROM_FILES, "masks", err) &&
           ffp_check_choice((int)options->camera.fit, FFP_FIT_CROPPED, "camera.fit", err) &&
           ffp_check_choice((int)options->projector.fit, FFP_FIT_CROPPED, "projector.fit", err);
}

// Only images of all that was shown need no names.
static bool check_images(const FfpImportImages *images, int n, const char *what, bool unnamed,
                         FfpError *err) {
    const char *const fields[2][2] = {{"images.files", "images.patterns"}, {"empty.files", "empty.patterns"}};
    const int k = strcmp(what, "empty") == 0;
    bool ok = n <= 0 || ffp_need(images, what, err);
    for (int i = 0; ok && i < n; i++)
        ok = ffp_need(images[i].files, fields[k][0], err) &&
             (unnamed || images[i].n_patterns > 0 || ffp_need(NULL, fields[k][1], err)) &&
             ffp_need_texts(images[i].patterns, images[i].n_patterns, fields[k][1], err);
    return ok;
}

static bool check_texts(const FfpImport *options, FfpError *err) {
    const FfpImportPattern *const patterns[2] = {options->patterns, options->held_out};
    const int n[2] = {options->n_patterns, options->n_held_out};
    bool ok = ffp_need(options->folder, "folder", err) &&
              ffp_need_texts(options->calibrations, options->n_calibrations, "calibrations", err) &&
              ffp_need_texts(options->views, options->n_views, "views", err) &&
              (options->masks != FFP_MASKS_FROM_FILES || ffp_need(options->mask_files, "mask_files", err)) &&
              check_images(options->images, options->n_images, "images", options->shown != NULL, err) &&
              check_images(options->empty, options->n_empty, "empty", false, err);
    for (int k = 0; ok && k < 2; k++) {
        ok = n[k] <= 0 || ffp_need(patterns[k], k ? "held_out" : "patterns", err);
        for (int i = 0; ok && i < n[k]; i++)
            ok = ffp_need(patterns[k][i].name, k ? "held_out.name" : "patterns.name", err) &&
                 ffp_need(patterns[k][i].file, k ? "held_out.file" : "patterns.file", err);
    }
    return ok;
}

static bool import_capture(void *argument, FfpError *err) {
    const FfpImport *options = *(const FfpImport *const *)argument;
    return check_choices(options, err) && ffp_import(options, err);
}

bool ffp_import_capture(FfpContext *context, const FfpImport *options, FfpError *err) {
    FfpImport own = ffp_import_defaults();
    if (!ffp_take_options(&own, options, "FfpImport", err) || !check_texts(&own, err)) return false;
    options = &own;
    return ffp_call_run(context, import_capture, &options, err);
}
