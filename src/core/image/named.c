#include "core/image/named.h"
#include <stdio.h>
#include "core/base/alloc.h"

FfpImages *ffp_images_new(void) {
    return ffp_alloc(1, sizeof(FfpImages));
}

void ffp_images_add(FfpImages *images, FfpImage image, const char *what, const char *view) {
    FfpImageEntry *entry = ffp_alloc(1, sizeof *entry);
    snprintf(entry->name, sizeof entry->name, "%s%s%s", what, view ? "_" : "", view ? view : "");
    entry->image = image;
    if (images->last)
        images->last->next = entry;
    else
        images->first = entry;
    images->last = entry;
    images->count++;
}

void ffp_images_free(FfpImages *images) {
    if (!images) return;
    for (FfpImageEntry *entry = images->first, *next = NULL; entry; entry = next) {
        next = entry->next;
        ffp_image_free(&entry->image);
        ffp_free(entry);
    }
    ffp_free(images);
}
