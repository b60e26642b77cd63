// The contents of a list of images.
#include <string.h>
#include "core/image/named.h"
#include "ffprocams.h"

int ffp_images_count(const FfpImages *images) {
    return images->count;
}

static FfpNamedImage named(const FfpImageEntry *entry) {
    if (!entry) return (FfpNamedImage){0};
    const FfpImage *image = &entry->image;
    return (FfpNamedImage){.name = entry->name,
                           .width = image->width,
                           .height = image->height,
                           .channels = image->channels,
                           .data = image->data};
}

FfpNamedImage ffp_images_at(const FfpImages *images, int index) {
    const FfpImageEntry *entry = index >= 0 ? images->first : NULL;
    while (entry && index-- > 0) entry = entry->next;
    return named(entry);
}

FfpNamedImage ffp_images_find(const FfpImages *images, const char *name) {
    const FfpImageEntry *entry = name ? images->first : NULL;
    while (entry && strcmp(entry->name, name) != 0) entry = entry->next;
    return named(entry);
}

void ffp_images_close(FfpImages *images) {
    ffp_images_free(images);
}
