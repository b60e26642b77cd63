// Little CMS takes memory of its own, and nothing here leaves while it has some.
#include "core/image/profile.h"
#include <math.h>
#include <string.h>
#include "core/base/log.h"
#include "core/image/lcms_module.h"

#define FLOATS(colours, channels, extra)                                                                     \
    (FLOAT_SH(1) | COLORSPACE_SH(colours) | CHANNELS_SH(channels) | EXTRA_SH(extra) |                        \
     BYTES_SH(sizeof(real) % 8)) // 8 bytes are 0

#define IGNORED "%s: its colour profile cannot be used, and is ignored"

enum { GRID = 5, NAME = 64 };

static const FfpLcmsModule *load(void) {
    static FfpModule module = {.name = "lcms",
                               .version = FFP_LCMS_MODULE_VERSION,
                               .purpose = "colour profiles are read by Little CMS",
                               .origin = "the library itself: install ffprocams again"};
    FfpError none = {0};
    return ffp_module_load(&module, &none);
}

static cmsToneCurve *curve_of(const FfpLcmsModule *lcms, double gamma) {
    const cmsFloat64Number srgb[5] = {2.4, 1 / 1.055, 0.055 / 1.055, 1 / 12.92, 0.04045};
    return gamma > 0 ? lcms->build_gamma(NULL, gamma) : lcms->build_curve(NULL, 4, srgb);
}

static cmsHPROFILE open_profile(const FfpLcmsModule *lcms, const FfpColourProfile *profile) {
    if (profile->kind == FFP_PROFILE_ICC) return lcms->open(profile->icc, (cmsUInt32Number)profile->size);
    const cmsCIExyY white = {profile->white[0], profile->white[1], 1};
    const double *p = profile->primaries;
    const cmsCIExyYTRIPLE primaries = {{p[0], p[1], 1}, {p[2], p[3], 1}, {p[4], p[5], 1}};
    cmsToneCurve *curve = curve_of(lcms, profile->gamma);
    cmsToneCurve *const curves[3] = {curve, curve, curve};
    cmsHPROFILE opened = curve ? lcms->create_rgb(&white, &primaries, curves) : NULL;
    if (curve) lcms->free_curve(curve);
    return opened;
}

// A transform from the profile to sRGB, if it is of these colours; NULL otherwise.
static cmsHTRANSFORM transform_from(const FfpLcmsModule *lcms, cmsHPROFILE opened,
                                    cmsColorSpaceSignature colours, cmsUInt32Number in, cmsUInt32Number out) {
    if (!opened || lcms->colours(opened) != colours) return NULL;
    cmsHPROFILE srgb = lcms->create_srgb();
    cmsHTRANSFORM transform = lcms->create_transform(opened, in, srgb, out, INTENT_RELATIVE_COLORIMETRIC,
                                                     cmsFLAGS_NOCACHE | cmsFLAGS_COPY_ALPHA);
    lcms->close(srgb);
    return transform;
}

static bool keeps_colours(const FfpLcmsModule *lcms, cmsHTRANSFORM transform) {
    real worst = 0;
    for (int i = 0; i < GRID * GRID * GRID; i++) {
        real colour[4] = {(real)(i % GRID) / (GRID - 1), (real)(i / GRID % GRID) / (GRID - 1),
                          (real)(i / GRID / GRID) / (GRID - 1), 1},
             out[4];
        lcms->transform(transform, colour, out, 1);
        for (int c = 0; c < 3; c++) {
            const real off = out[c] - colour[c];
            worst = off > worst ? off : -off > worst ? -off : worst;
        }
    }
    return worst < (real)1 / 255;
}

bool ffp_profile_is_srgb(const FfpColourProfile *profile) {
    if (profile->kind == FFP_PROFILE_NONE) return true;
    const FfpLcmsModule *lcms = load();
    if (!lcms) return false;
    cmsHPROFILE opened = open_profile(lcms, profile);
    cmsHTRANSFORM transform =
        transform_from(lcms, opened, cmsSigRgbData, FLOATS(PT_RGB, 3, 1), FLOATS(PT_RGB, 3, 1));
    const bool same = transform && keeps_colours(lcms, transform);
    if (transform) lcms->delete_transform(transform);
    if (opened) lcms->close(opened);
    return same;
}

static void describe(const FfpLcmsModule *lcms, cmsHPROFILE opened, const FfpColourProfile *profile,
                     char name[NAME]) {
    snprintf(name, NAME, "%s",
             profile->kind == FFP_PROFILE_ICC ? "its colour profile"
             : profile->name                  ? profile->name
                                              : "its tags of colour");
    char said[NAME] = "";
    if (profile->kind != FFP_PROFILE_ICC) return;
    lcms->info(opened, cmsInfoDescription, "en", "US", said, sizeof said);
    for (char *at = said; *at; at++)
        if (*at < ' ' || *at > '~') *at = '?';
    if (*said) snprintf(name, NAME, "%s", said);
}

static void clip(real *values, size_t count) {
    for (size_t i = 0; i < count; i++) values[i] = values[i] > 0 ? (values[i] < 1 ? values[i] : 1) : 0;
}

static void convert_rows(const FfpLcmsModule *lcms, cmsHTRANSFORM transform, FfpImage *rgba) {
    const size_t row = 4 * (size_t)rgba->width;
#pragma omp parallel for schedule(static)
    for (int y = 0; y < rgba->height; y++) {
        real *values = rgba->data + row * (size_t)y;
        lcms->transform(transform, values, values, (cmsUInt32Number)rgba->width);
        clip(values, row);
    }
}

// Greys came as three equal values.
static void convert_greys(const FfpLcmsModule *lcms, cmsHTRANSFORM transform, FfpImage *rgba) {
    const size_t pixels = (size_t)rgba->width * (size_t)rgba->height;
    for (size_t i = 0; i < pixels; i++) {
        real *at = rgba->data + 4 * i, grey = at[0];
        lcms->transform(transform, &grey, at, 1);
        clip(at, 3);
    }
}

void ffp_profile_apply(const FfpColourProfile *profile, FfpImage *rgba, const char *path) {
    char name[NAME] = "";
    if (profile->kind == FFP_PROFILE_NONE) return;
    if (profile->hdr) {
        ffp_note("%s: is HDR (PQ or HLG), and is read as if it were not: save it as sRGB or EXR", path);
        return;
    }
    const FfpLcmsModule *lcms = load();
    if (!lcms) {
        ffp_note(IGNORED, path);
        return;
    }
    cmsHPROFILE opened = open_profile(lcms, profile);
    const bool grey = opened && lcms->colours(opened) == cmsSigGrayData;
    cmsHTRANSFORM transform =
        grey ? transform_from(lcms, opened, cmsSigGrayData, FLOATS(PT_GRAY, 1, 0), FLOATS(PT_RGB, 3, 0))
             : transform_from(lcms, opened, cmsSigRgbData, FLOATS(PT_RGB, 3, 1), FLOATS(PT_RGB, 3, 1));
    const bool same = transform && !grey && keeps_colours(lcms, transform);
    if (opened) describe(lcms, opened, profile, name);
    if (transform && grey)
        convert_greys(lcms, transform, rgba);
    else if (transform && !same)
        convert_rows(lcms, transform, rgba);
    if (transform) lcms->delete_transform(transform);
    if (opened) lcms->close(opened);
    if (!transform)
        ffp_note(IGNORED, path);
    else if (!same && !grey)
        ffp_note("%s: converted from %s to sRGB", path, name);
}

bool ffp_profile_inks(const FfpColourProfile *profile, const unsigned char *inks, bool inverted,
                      FfpImage *rgba, const char *path) {
    char name[NAME] = "";
    if (profile->kind != FFP_PROFILE_ICC) return false;
    const FfpLcmsModule *lcms = load();
    if (!lcms) {
        ffp_note(IGNORED, path);
        return false;
    }
    cmsHPROFILE opened = open_profile(lcms, profile);
    cmsHTRANSFORM transform =
        transform_from(lcms, opened, cmsSigCmykData, FLOATS(PT_CMYK, 4, 0), FLOATS(PT_RGB, 3, 0));
    const size_t pixels = (size_t)rgba->width * (size_t)rgba->height;
    if (transform) describe(lcms, opened, profile, name);
    for (size_t i = 0; transform && i < pixels; i++) {
        real *at = rgba->data + 4 * i, ink[4];
        for (int c = 0; c < 4; c++) // per cent
            ink[c] =
                (real)100 / 255 * (real)(inverted ? 255 - inks[4 * i + (size_t)c] : inks[4 * i + (size_t)c]);
        lcms->transform(transform, ink, at, 1);
        clip(at, 3);
        at[3] = 1;
    }
    if (transform) lcms->delete_transform(transform);
    if (opened) lcms->close(opened);
    if (transform)
        ffp_note("%s: converted from %s to sRGB", path, name);
    else
        ffp_note(IGNORED, path);
    return transform != NULL;
}
