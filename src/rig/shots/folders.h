// Folders of photographs: a chessboard in several attitudes, one folder each.
#ifndef FFP_CALIBRATE_SHOTS_H
#define FFP_CALIBRATE_SHOTS_H

#include <stdbool.h>
#include <sys/types.h>
#include "core/base/arena.h"
#include "core/base/error.h"
#include "core/patterns/shown.h"

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
// Of folders with a picture for each pattern that was shown only black, white and the codes stay, in this
// order. Folders with pictures of these alone stay as they are; all others have a problem.
void ffp_shot_folders_take(FfpShotFolders *folders, const FfpShown *shown);
void ffp_shot_folders_free(FfpShotFolders *out);

#endif
