// What a projector shows while it is photographed.
#include "api/arguments.h"
#include "base/call.h"
#include "base/file.h"
#include "ffprocams.h"
#include "patterns/patterns.h"

enum { SIDE_MIN = 64, SIDE_MAX = 16384, LOLLIPOPS_MAX = 100 };

FfpPatterns ffp_patterns_defaults(void) {
    return (FfpPatterns){.width = 1920,
                         .height = 1080,
                         .lollipops = 3,
                         .focus = true,
                         .capture = true,
                         .gamma = true,
                         .gray_codes = true};
}

static bool check(const FfpPatterns *o, FfpError *err) {
    if (o->width < SIDE_MIN || o->width > SIDE_MAX || o->height < SIDE_MIN || o->height > SIDE_MAX)
        return ffp_fail(err, FFP_ERROR_ARGUMENT, "projector", "a side of %d x %d is not in %d to %d pixels",
                        o->width, o->height, SIDE_MIN, SIDE_MAX);
    if (o->lollipops < 0 || o->lollipops > LOLLIPOPS_MAX)
        return ffp_fail(err, FFP_ERROR_ARGUMENT, "lollipops", "%d are not in 0 to %d", o->lollipops,
                        LOLLIPOPS_MAX);
    return o->focus || o->capture || o->gamma || o->gray_codes ||
           ffp_fail(err, FFP_ERROR_ARGUMENT, "patterns", "none of them is wanted");
}

static bool work(void *argument, FfpError *err) {
    const FfpPatterns *o = argument;
    FfpOutput folder;
    if (!check(o, err) || !ffp_output_open_folder(&folder, o->folder, true, err)) return false;
    const FfpShow show = {o->width, o->height, o->lollipops, o->focus, o->capture, o->gamma, o->gray_codes};
    const bool ok = ffp_show_write(&show, folder.temporary, err) && ffp_output_commit(&folder, err);
    ffp_output_abort(&folder);
    return ok;
}

int ffp_write_patterns(FfpContext *context, const FfpPatterns *options, FfpError *err) {
    if (!ffp_need(options, "options", err) || !ffp_need(options->folder, "folder", err)) return -1;
    FfpPatterns o = *options;
    if (!ffp_call_run(context, work, &o, err)) return -1;
    const FfpShow show = {o.width, o.height, o.lollipops, o.focus, o.capture, o.gamma, o.gray_codes};
    return ffp_show_count(&show);
}
