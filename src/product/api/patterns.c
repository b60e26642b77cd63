// Patterns that a projector shows while it is photographed.
#include "core/patterns/patterns.h"
#include "core/base/call.h"
#include "core/base/log.h"
#include "ffprocams.h"
#include "product/api/arguments.h"
#include "rig/optics/calibration.h"

enum { SIDE_MIN = 64, SIDE_MAX = 16384, LOLLIPOPS_MAX = 100, GREYS_MAX = 64 };

void ffp_patterns_defaults_into(FfpPatterns *options, size_t size) {
    ffp_give_defaults(options, size,
                      &(FfpPatterns){.width = 1920,
                                     .height = 1080,
                                     .lollipops = 1,
                                     .focus = true,
                                     .capture = true,
                                     .gray_codes = true,
                                     .columns = 9,
                                     .rows = 6,
                                     .square = 25},
                      sizeof(FfpPatterns));
}

static bool check_panel(const FfpPatterns *o, FfpError *err) {
    const int least = o->width < o->height ? o->width : o->height,
              most = o->width > o->height ? o->width : o->height;
    return (least >= SIDE_MIN && most <= SIDE_MAX) ||
           ffp_fail(err, FFP_ERROR_ARGUMENT, "projector", "a side of %d x %d is not in %d to %d pixels",
                    o->width, o->height, SIDE_MIN, SIDE_MAX);
}

static bool check(const FfpPatterns *o, FfpError *err) {
    if (o->n_calibrations == 0 && !check_panel(o, err)) return false;
    if (o->lollipops < 0 || o->lollipops > LOLLIPOPS_MAX)
        return ffp_fail(err, FFP_ERROR_ARGUMENT, "lollipops", "%d are not in 0 to %d", o->lollipops,
                        LOLLIPOPS_MAX);
    if (o->greys < 0 || o->greys > GREYS_MAX)
        return ffp_fail(err, FFP_ERROR_ARGUMENT, "greys", "%d are not in 0 to %d", o->greys, GREYS_MAX);
    if (o->columns != 0 && (o->columns < 3 || o->columns > 64 || o->rows < 3 || o->rows > 64))
        return ffp_fail(err, FFP_ERROR_ARGUMENT, "board", "%d x %d corners are not in 3 to 64", o->columns,
                        o->rows);
    if (o->columns != 0 && !(o->square >= 1 && o->square <= 500))
        return ffp_fail(err, FFP_ERROR_ARGUMENT, "square", "%g is not in 1 to 500 mm", o->square);
    return o->focus || o->capture || o->gray_codes ||
           ffp_fail(err, FFP_ERROR_ARGUMENT, "patterns", "none requested");
}

typedef struct Call {
    FfpPatterns *options;
    int count;
} Call;

static bool take_panel(FfpPatterns *o, FfpError *err) {
    FfpCalibration calibration;
    if (!ffp_calibration_read(&calibration, o->calibrations, o->n_calibrations, NULL, err)) return false;
    o->width = calibration.projector.width, o->height = calibration.projector.height;
    ffp_calibration_free(&calibration);
    if (o->width == 0)
        return ffp_fail(err, FFP_ERROR_FILE, o->calibrations[0],
                        "does not tell the size of the projector's panel: give it");
    ffp_note("%s: its projector has %d x %d pixels", o->calibrations[0], o->width, o->height);
    return check_panel(o, err);
}

static bool work(void *argument, FfpError *err) {
    Call *call = argument;
    FfpPatterns *o = call->options;
    if (o->n_calibrations > 0 && !take_panel(o, err)) return false;
    const FfpShow show = {.width = o->width,
                          .height = o->height,
                          .lollipops = o->lollipops,
                          .focus = o->focus,
                          .capture = o->capture,
                          .gray_codes = o->gray_codes,
                          .columns = o->gray_codes ? o->columns : 0,
                          .rows = o->rows,
                          .square = o->square,
                          .greys = o->capture ? o->greys : 0};
    call->count = ffp_show_count(&show);
    return ffp_show_write_folder(&show, o->folder, err);
}

int ffp_write_patterns(FfpContext *context, const FfpPatterns *options, FfpError *err) {
    FfpPatterns own = ffp_patterns_defaults();
    Call call = {&own, 0};
    if (!ffp_take_options(&own, options, "FfpPatterns", err) || !ffp_need(own.folder, "folder", err) ||
        !check(&own, err))
        return -1;
    return ffp_call_run(context, work, &call, err) ? call.count : -1;
}
