// Little CMS's functions: a module (core/base/module.h), loaded by profile.c for pictures that have a
// profile.
#ifndef FFP_IMAGE_LCMS_MODULE_H
#define FFP_IMAGE_LCMS_MODULE_H

#include <lcms2.h>
#include "core/base/module.h"

enum { FFP_LCMS_MODULE_VERSION = 1 }; // of the table below

typedef struct FfpLcmsModule {
    int version;
    __typeof__(cmsBuildGamma) *build_gamma;
    __typeof__(cmsBuildParametricToneCurve) *build_curve;
    __typeof__(cmsFreeToneCurve) *free_curve;
    __typeof__(cmsOpenProfileFromMem) *open;
    __typeof__(cmsCreateRGBProfile) *create_rgb;
    __typeof__(cmsCreate_sRGBProfile) *create_srgb;
    __typeof__(cmsCloseProfile) *close;
    __typeof__(cmsGetColorSpace) *colours;
    __typeof__(cmsGetProfileInfoASCII) *info;
    __typeof__(cmsCreateTransform) *create_transform;
    __typeof__(cmsDoTransform) *transform;
    __typeof__(cmsDeleteTransform) *delete_transform;
} FfpLcmsModule;

extern FFP_MODULE_EXPORT const FfpLcmsModule ffp_lcms_module;

#endif
