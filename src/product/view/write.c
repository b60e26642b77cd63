#include "product/view/write.h"
#include "core/base/log.h"
#include "engine/pipeline/elsewhere.h"
#include "engine/pipeline/relight.h"
#include "product/view/view.h"

bool ffp_page_run(const FfpGaussians *gaussians, const FfpCapture *capture, const FfpPage *options,
                  FfpPageStats *stats, FfpError *err) {
    FfpCapture poses;
    FfpPageCounts counts;
    if (options->poses && !ffp_capture_read_targets(&poses, options->poses, capture, err)) return false;
    ffp_note_elsewhere(gaussians, capture);
    const FfpRenderSettings settings = ffp_showing_settings(options->drawing);
    const FfpPageContent source = {gaussians, capture, options->poses ? &poses : NULL, &settings,
                                   options->photographs};
    const bool ok = ffp_page_build(&source, options->file, &counts, err);
    if (options->poses) ffp_capture_free(&poses);
    if (!ok) return false;
    if (counts.patterns_left || counts.photographs_left)
        ffp_note("the page has room for %d of %d patterns and %d of %d photographs", counts.patterns,
                 counts.patterns + counts.patterns_left, counts.photographs,
                 counts.photographs + counts.photographs_left);
    if (stats)
        *stats = (FfpPageStats){.gaussians = gaussians->count,
                                .bytes = counts.bytes,
                                .patterns = counts.patterns,
                                .photographs = counts.photographs};
    return true;
}
