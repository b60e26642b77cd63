#include "core/base/listing.h"
#include <dirent.h>
#include <stdlib.h>
#include <string.h>
#include "core/base/alloc.h"

static int is_entry(const struct dirent *entry) {
    return strcmp(entry->d_name, ".") != 0 && strcmp(entry->d_name, "..") != 0;
}

static size_t bytes_of(struct dirent *const *entries, int count) {
    size_t bytes = 0;
    for (int i = 0; i < count; i++) bytes += sizeof(char *) + strlen(entries[i]->d_name) + 1;
    return bytes;
}

static void fill(char **names, struct dirent *const *entries, int count) {
    char *text = (char *)(names + count);
    for (int i = 0; i < count; i++) {
        names[i] = strcpy(text, entries[i]->d_name);
        text += strlen(text) + 1;
    }
}

bool ffp_list_folder(FfpListing *listing, const char *folder) {
    struct dirent **entries;
    *listing = (FfpListing){.count = 0};
    const int count = scandir(folder, &entries, is_entry, alphasort);
    if (count < 0) return false;
    const size_t bytes = bytes_of(entries, count);
    listing->names = ffp_try_alloc(bytes, 1); // scandir's own memory goes back before the call is left
    if (listing->names) fill(listing->names, entries, count);
    for (int i = 0; i < count; i++) free(entries[i]);
    free((void *)entries);
    if (!listing->names) ffp_no_memory(bytes);
    listing->count = count;
    return true;
}
