#include "engine/pipeline/relight.h"
#include <tgmath.h>

FfpImage ffp_relight(FfpViewPass *pass, const real intensity[3], const FfpSummed *pattern) {
    FfpImage picture = ffp_view_pass_picture_new(pass);
    ffp_view_pass_shade(pass, intensity, pattern, &picture);
    ffp_quantise(&picture);
    return picture;
}

void ffp_quantise(FfpImage *encoded) {
    const size_t count = (size_t)encoded->width * encoded->height * encoded->channels;
    for (size_t i = 0; i < count; i++)
        encoded->data[i] = floor(fmin(fmax(encoded->data[i], 0), 1) * 255 + 0.5F) / 255;
}

FfpRenderSettings ffp_drawing_settings(FfpDrawing drawing, const FfpModel *model) {
    if (!model && drawing.form == FFP_FORM_GS_PROCAMS) {
        FfpRenderSettings settings = ffp_render_gs_procams();
        if (drawing.samples > 0) settings.samples = drawing.samples;
        return settings;
    }
    const bool paper = model ? ffp_model_is_paper_form(&model->config) : drawing.form == FFP_FORM_PAPER;
    const int meant = model ? model->config.samples : 0;
    return ffp_render_settings(paper, drawing.samples ? drawing.samples : meant);
}

FfpRenderSettings ffp_showing_settings(FfpDrawing drawing) {
    FfpRenderSettings settings = ffp_drawing_settings(drawing, NULL);
    settings.smooth = drawing.form == FFP_FORM_OURS;
    return settings;
}
