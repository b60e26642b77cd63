#include "api/images.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include "base/arena.h"
#include "capture/capture.h"

typedef struct Entry {
    char name[FFP_NAME_MAX + 32];
    FfpImage image;
    struct Entry *next;
} Entry;

struct FfpImages {
    int count;
    Entry *first, *last;
};

FfpImages *ffp_images_new(void) {
    return ffp_alloc(1, sizeof(FfpImages));
}

void ffp_images_add(FfpImages *images, FfpImage image, const char *what, const char *view) {
    Entry *entry = ffp_alloc(1, sizeof *entry);
    snprintf(entry->name, sizeof entry->name, "%s%s%s", what, view ? "_" : "", view ? view : "");
    entry->image = image;
    if (images->last)
        images->last->next = entry;
    else
        images->first = entry;
    images->last = entry;
    images->count++;
}

int ffp_images_count(const FfpImages *images) {
    return images->count;
}

static FfpNamedImage named(const Entry *entry) {
    if (!entry) return (FfpNamedImage){0};
    const FfpImage *image = &entry->image;
    return (FfpNamedImage){entry->name, image->width, image->height, image->channels, image->data};
}

FfpNamedImage ffp_images_at(const FfpImages *images, int index) {
    const Entry *entry = index >= 0 ? images->first : NULL;
    while (entry && index-- > 0) entry = entry->next;
    return named(entry);
}

FfpNamedImage ffp_images_find(const FfpImages *images, const char *name) {
    const Entry *entry = images->first;
    while (entry && strcmp(entry->name, name) != 0) entry = entry->next;
    return named(entry);
}

void ffp_images_close(FfpImages *images) {
    if (!images) return;
    for (Entry *entry = images->first, *next = NULL; entry; entry = next) {
        next = entry->next;
        ffp_image_free(&entry->image);
        ffp_free(entry);
    }
    ffp_free(images);
}
