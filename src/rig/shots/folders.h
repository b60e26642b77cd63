// Folders of photographs: a chessboard in several attitudes, one folder each.
#ifndef FFP_CALIBRATE_SHOTS_H
#define FFP_CALIBRATE_SHOTS_H

#include <stdbool.h>
#include <sys/types.h>
#include "core/base/arena.h"
#include "core/base/error.h"

enum { FFP_ATTITUDES_MAX = 512 };

typedef struct FfpShotFolder {
    const char *name;    // the folder's, for people
    const char *problem; // NULL, or why its pictures are not those that were shown
    const char **files;  // paths of its pictures in natural order
    int n_files;
    dev_t device; // which folder it is, whatever the path to it
    ino_t inode;
} FfpShotFolder;

typedef struct FfpShotFolders {
    FfpArena *arena; // owns all strings and lists
    FfpShotFolder *folders;
    int n;
} FfpShotFolders;

// The folders that are named, or the folders in them where they hold no pictures themselves; both in natural
// order. Errors: a folder that is named twice, is not there or holds neither pictures nor folders with
// pictures, more than FFP_ATTITUDES_MAX.
bool ffp_shot_folders_find(FfpShotFolders *out, const char *const *paths, int n_paths, FfpError *err);
// Of folders with pictures of all that was shown (the folder of patterns) only those under black, white and
// the Gray codes stay, in this order; folders with pictures of these alone stay as they are, and all others
// have a problem. *width, *height: of the panel. Errors: of ffp_shown_read, and patterns without Gray codes.
bool ffp_shot_folders_take(FfpShotFolders *folders, const char *shown, int *width, int *height,
                           FfpError *err);
void ffp_shot_folders_free(FfpShotFolders *out);

#endif
