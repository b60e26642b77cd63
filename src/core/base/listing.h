// The contents of a folder.
#ifndef FFP_BASE_LISTING_H
#define FFP_BASE_LISTING_H

#include <stdbool.h>

// The names in it except "." and "..", in alphabetical order. One block: ffp_free(names).
typedef struct FfpListing {
    char **names; // [count]
    int count;
} FfpListing;

// False, with errno, when the folder cannot be read.
bool ffp_list_folder(FfpListing *listing, const char *folder);

#endif
