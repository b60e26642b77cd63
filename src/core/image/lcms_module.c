#include "core/image/lcms_module.h"

const FfpLcmsModule ffp_lcms_module = {
    .version = FFP_LCMS_MODULE_VERSION,
    .build_gamma = cmsBuildGamma,
    .build_curve = cmsBuildParametricToneCurve,
    .free_curve = cmsFreeToneCurve,
    .open = cmsOpenProfileFromMem,
    .create_rgb = cmsCreateRGBProfile,
    .create_srgb = cmsCreate_sRGBProfile,
    .close = cmsCloseProfile,
    .colours = cmsGetColorSpace,
    .info = cmsGetProfileInfoASCII,
    .create_transform = cmsCreateTransform,
    .transform = cmsDoTransform,
    .delete_transform = cmsDeleteTransform,
};
