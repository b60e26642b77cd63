// A look for a network that runs elsewhere.
#include "core/base/arena.h"
#include "engine/network/look.h"
#include "engine/network/pixels.h"
#include "engine/network/prepared.h"

bool ffp_prepared_seen(const FfpPrepared *p, const real *raw, real *out, FfpError *err) {
    const FfpModelConfig *config = &p->config;
    const FfpLookPhotographs *photographs = p->photographs;
    if (!photographs) return ffp_fail(err, FFP_ERROR_ARGUMENT, "prepared", "the model has no looks");
    FfpRun *run = ffp_run_new(false);
    const FfpPixels pixels = {p->count, p->base, (real *)raw}; // only read
    const bool ok = ffp_pixels_splat(&pixels, run, config) ||
                    ffp_fail(err, FFP_ERROR_ARGUMENT, "raw", "holds a number that is not finite");
    if (ok) {
        const FfpRenderSettings render =
            ffp_render_settings(ffp_model_is_paper_form(config), config->samples);
        FfpViewPass *pass = ffp_view_pass_new(&render);
        real *maps =
            ffp_alloc((size_t)photographs->views * (size_t)photographs->width * (size_t)photographs->height,
                      FFP_LOOK_NUMBERS * sizeof *maps);
        ffp_look(maps, pass, &run->gaussians, photographs);
        const FfpLookInputs looked = {ffp_look_maps(photographs, maps), p->pixel, run->gaussians.centre, raw,
                                      ffp_head_numbers(config)};
        ffp_look_gather(out, &looked, 0, (int)p->count);
        ffp_free(maps);
        ffp_view_pass_free(pass);
    }
    ffp_run_free(run);
    return ok;
}
