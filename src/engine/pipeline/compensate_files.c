// A compensation's patterns and predicted pictures in files.
#include <stdio.h>
#include <string.h>
#include "core/base/file.h"
#include "engine/pipeline/compensate.h"

// "<pattern without .png><between><id>.png"
static bool name_beside(char out[FFP_PATH_MAX], const char *pattern, const char *between, const char *id,
                        FfpError *err) {
    const char *base = ffp_basename(pattern), *dot = strrchr(base, '.');
    const int stem = (int)(dot && dot != base ? dot - pattern : (ptrdiff_t)strlen(pattern));
    if (strchr(id, '/'))
        return ffp_fail(err, FFP_ERROR_ARGUMENT, pattern, "view %s is not a valid file name", id);
    if (snprintf(out, FFP_PATH_MAX, "%.*s%s%s.png", stem, pattern, between, id) >= FFP_PATH_MAX)
        return ffp_fail(err, FFP_ERROR_ARGUMENT, pattern, "the path is too long");
    return true;
}

static bool write_encoded(const FfpImage *linear, const char *path, FfpError *err) {
    FfpImage picture = ffp_image_copy(linear);
    ffp_image_to_srgb(&picture);
    const bool ok = ffp_image_write_png(&picture, path, err);
    ffp_image_free(&picture);
    return ok;
}

// A single pattern takes the file's name; everything else stands beside it.
static bool write_image(const FfpImageEntry *entry, const char *file, int patterns, FfpError *err) {
    static const char *const kinds[3][2] = {{"pattern_", "_"}, {"seen_", "_seen_"}, {"target_", "_target_"}};
    char path[FFP_PATH_MAX];
    for (int k = 0; k < 3; k++) {
        const size_t length = strlen(kinds[k][0]);
        if (strncmp(entry->name, kinds[k][0], length) != 0) continue;
        if (k == 0 && patterns == 1) return write_encoded(&entry->image, file, err);
        return name_beside(path, file, kinds[k][1], entry->name + length, err) &&
               write_encoded(&entry->image, path, err);
    }
    return true;
}

bool ffp_compensation_write(const FfpGaussians *gaussians, const FfpCapture *capture,
                            const FfpCompensation *options, const FfpRaw *pictures,
                            FfpCompensationStats *stats, FfpError *err) {
    FfpCompensationStats found = {0};
    if (!ffp_output_probe(options->pattern, err)) return false;
    FfpImages *images = ffp_compensation_run(gaussians, capture, options, pictures, &found, err);
    if (!images) return false;
    bool ok = true;
    for (const FfpImageEntry *entry = images->first; ok && entry; entry = entry->next)
        ok = write_image(entry, options->pattern, found.patterns, err);
    ffp_images_free(images);
    if (ok && stats) *stats = found;
    return ok;
}
