// The studio's folder. Paths are inside it; every function refuses others.
#ifndef FFP_STUDIO_DISK_H
#define FFP_STUDIO_DISK_H

#include "studio.h"

// Words of letters, digits, '-', '_' and '.' that do not begin with '.', with '/' between.
bool ffp_studio_path(const char *path);
// Opens for reading, following no links; -1: there is none.
int ffp_studio_open(const FfpStudio *studio, const char *path);
char *ffp_studio_read_whole(int file, size_t *size); // to be freed; NULL: it cannot be read
bool ffp_studio_exists(const FfpStudio *studio, const char *path);
bool ffp_studio_make(const FfpStudio *studio, const char *folder); // and those above it
// Whole or not at all, and on disk when it returns true; the folder above it is made. False: errno.
bool ffp_studio_write(const FfpStudio *studio, const char *path, const void *bytes, size_t size);
// Moves it to discarded/NAME-N, NAME being its path with dashes. True if there is nothing.
bool ffp_studio_set_aside(const FfpStudio *studio, const char *path);
// Deletes it, with all in it. True if there is nothing.
bool ffp_studio_remove(const FfpStudio *studio, const char *path);
// Names in a folder in the alphabet's order, at most `most`; each to be freed. 0: none, or no folder.
int ffp_studio_list(const FfpStudio *studio, const char *folder, char **names, int most);
void ffp_studio_free_names(char **names, int count);
json_t *ffp_studio_read_json(const FfpStudio *studio,
                             const char *path); // NULL: none, or none that can be read

#endif
