#include "core/gaussians/gaussians.h"
#include <stdio.h>
#include <string.h>
#include "core/base/arena.h"
#include "core/base/device.h"

const FfpAttributeForm ffp_attributes[FFP_ATTRIBUTES] = {
    [FFP_CENTRE] = {"centre", 3, offsetof(FfpGaussians, centre)},
    [FFP_SCALE] = {"scale", 3, offsetof(FfpGaussians, scale)},
    [FFP_ROTATION] = {"rotation", 4, offsetof(FfpGaussians, rotation)},
    [FFP_OPACITY] = {"opacity", 1, offsetof(FfpGaussians, opacity)},
    [FFP_ALBEDO] = {"albedo", 3, offsetof(FfpGaussians, albedo)},
    [FFP_ROUGHNESS] = {"roughness", 1, offsetof(FfpGaussians, roughness)},
    [FFP_AMBIENT] = {"ambient", 3, offsetof(FfpGaussians, ambient)},
    [FFP_SCATTERED] = {"scattered", 3, offsetof(FfpGaussians, scattered)},
};

static real **array_of(FfpGaussians *gaussians, int attribute) {
    return (real **)((char *)gaussians + ffp_attributes[attribute].member);
}

FfpAttribute ffp_attribute(const FfpGaussians *gaussians, int attribute) {
    const FfpAttributeForm *form = &ffp_attributes[attribute];
    return (FfpAttribute){*(real *const *)((const char *)gaussians + form->member), form->width};
}

static size_t bytes_of(const FfpGaussians *gaussians, int attribute) {
    return (size_t)gaussians->count * (size_t)ffp_attributes[attribute].width * sizeof(real);
}

FfpGaussians ffp_gaussians_new(int64_t count) {
    FfpGaussians new = {.count = count};
    for (int a = 0; a < FFP_ATTRIBUTES; a++)
        *array_of(&new, a) = ffp_memory_new((size_t)count, (size_t)ffp_attributes[a].width * sizeof(real));
    return new;
}

void ffp_gaussians_take_notes(FfpGaussians *to, const FfpGaussians *from) {
    to->baked = from->baked;
    to->scatters = from->scatters;
}

FfpGaussians ffp_gaussians_copy(const FfpGaussians *from) {
    FfpGaussians to = ffp_gaussians_new(from->count);
    for (int a = 0; a < FFP_ATTRIBUTES; a++)
        if (ffp_attribute(from, a).data)
            ffp_memory_copy(ffp_attribute(&to, a).data, ffp_attribute(from, a).data, bytes_of(from, a));
    memcpy(to.made_from, from->made_from, sizeof to.made_from);
    ffp_gaussians_take_notes(&to, from);
    return to;
}

void ffp_made_from_add(char made_from[FFP_MADE_FROM], const char *name) {
    const size_t length = strlen(name), used = strlen(made_from);
    for (const char *at = made_from; *at; at = strchr(at, '\n') + 1)
        if (strncmp(at, name, length) == 0 && at[length] == '\n') return;
    if (length > 0 && !strchr(name, '\n') && used + length + 2 <= FFP_MADE_FROM)
        snprintf(made_from + used, FFP_MADE_FROM - used, "%s\n", name);
}

void ffp_gaussians_free(FfpGaussians *gaussians) {
    if (!gaussians) return;
    for (int a = 0; a < FFP_ATTRIBUTES; a++) ffp_memory_free(ffp_attribute(gaussians, a).data);
    *gaussians = (FfpGaussians){0};
}

void ffp_gaussians_clear(FfpGaussians *gaussians) {
    for (int a = 0; a < FFP_ATTRIBUTES; a++)
        ffp_memory_zero(ffp_attribute(gaussians, a).data, bytes_of(gaussians, a));
}

FfpGaussians ffp_gaussians_uploaded(const FfpGaussians *host) {
    FfpGaussians there = {.count = host->count};
    ffp_gaussians_take_notes(&there, host);
    for (int a = 0; a < FFP_ATTRIBUTES; a++) {
        const FfpAttribute from = ffp_attribute(host, a);
        if (from.data)
            *array_of(&there, a) =
                ffp_memory_uploaded(from.data, (size_t)host->count, (size_t)from.width * sizeof(real));
    }
    return there;
}

void ffp_gaussians_download(FfpGaussians *host, const FfpGaussians *gaussians) {
    for (int a = 0; a < FFP_ATTRIBUTES; a++)
        if (ffp_attribute(gaussians, a).data)
            ffp_memory_download(ffp_attribute(host, a).data, ffp_attribute(gaussians, a).data,
                                bytes_of(host, a));
}

FfpGaussians ffp_gaussians_downloaded(const FfpGaussians *gaussians) {
    FfpGaussians host = {.count = gaussians->count};
    ffp_gaussians_take_notes(&host, gaussians);
    for (int a = 0; a < FFP_ATTRIBUTES; a++)
        *array_of(&host, a) =
            ffp_alloc((size_t)gaussians->count, (size_t)ffp_attributes[a].width * sizeof(real));
    ffp_gaussians_download(&host, gaussians);
    return host;
}

void ffp_gaussians_transform(FfpGaussians *gaussians, const real offset[3], real radius) {
    for (int64_t i = 0; i < gaussians->count; i++) {
        for (int c = 0; c < 3; c++) {
            gaussians->centre[3 * i + c] = gaussians->centre[3 * i + c] * radius + offset[c];
            gaussians->scale[3 * i + c] *= radius;
        }
    }
    FfpBakedShadows *baked = &gaussians->baked;
    for (int c = 0; c < 3; c++) baked->light[c] = baked->light[c] * radius + offset[c];
    baked->within *= radius;
}

bool ffp_shadows_are_baked(const FfpGaussians *gaussians, const real pose[16]) {
    const FfpBakedShadows *baked = &gaussians->baked;
    real squared = 0;
    for (int c = 0; c < 3; c++) {
        const real off = pose[4 * c + 3] - baked->light[c];
        squared += off * off;
    }
    return baked->within > 0 && squared <= baked->within * baked->within;
}

void ffp_gaussians_keep_drawn(FfpGaussians *gaussians) {
    int64_t kept = 0;
    for (int64_t i = 0; i < gaussians->count; i++) {
        if (gaussians->opacity[i] < FFP_OPACITY_LEAST) continue;
        for (int a = 0; kept < i && a < FFP_ATTRIBUTES; a++) {
            const FfpAttribute attribute = ffp_attribute(gaussians, a);
            const size_t width = (size_t)attribute.width;
            memcpy(attribute.data + (size_t)kept * width, attribute.data + (size_t)i * width,
                   width * sizeof(real));
        }
        kept++;
    }
    if (kept > 0) gaussians->count = kept;
}
