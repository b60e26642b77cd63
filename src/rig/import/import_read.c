// Import: one photograph as linear light without lens distortion.
#include <tgmath.h>
#include "rig/import/import_steps.h"

// Exposure of linear values; what then exceeds 1 is cut off when the capture is written, and counted.
static void expose(FfpImporting *import, FfpImage *image) {
    const real factor = (real)exp2(import->settings->exposure);
    const ptrdiff_t count = (ptrdiff_t)image->width * image->height * 3;
    for (ptrdiff_t i = 0; i < count; i++) {
        image->data[i] *= factor;
        import->too_bright += image->data[i] > 1.002F;
    }
    import->values += count;
}

// An alpha channel that is 1 everywhere tells nothing: programs add such to any picture.
static bool tells_shape(const FfpImage *alpha) {
    const ptrdiff_t pixels = alpha->data ? (ptrdiff_t)alpha->width * alpha->height : 0;
    for (ptrdiff_t i = 0; i < pixels; i++) {
        if (alpha->data[i] < 1) return true;
    }
    return false;
}

bool ffp_importing_read_picture(FfpImporting *import, const char *path, int stop, FfpImage *picture,
                                FfpImage *alpha, FfpError *err) {
    const FfpOptics *optics = &import->calibration.stops[stop].camera;
    const FfpCamera *camera = &import->capture.views[stop].camera;
    FfpImage raw = {0}, raw_alpha = {0};
    if (!ffp_photograph_read(&raw, &raw_alpha, path, import->settings->linear_images, &import->developed,
                             err) ||
        !ffp_importing_has_size(path, raw.width, raw.height, optics, err)) {
        ffp_image_free(&raw);
        ffp_image_free(&raw_alpha);
        return false;
    }
    expose(import, &raw);
    *picture = ffp_optics_rectify(optics, camera, &raw);
    if (alpha && tells_shape(&raw_alpha)) *alpha = ffp_optics_rectify(optics, camera, &raw_alpha);
    ffp_image_free(&raw);
    ffp_image_free(&raw_alpha);
    return true;
}
