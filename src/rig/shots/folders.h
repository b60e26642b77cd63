// Folders of photographs, one for each attitude of a chessboard, place of a camera or stop of a turntable.
#ifndef FFP_SHOTS_FOLDERS_H
#define FFP_SHOTS_FOLDERS_H

#include <stdbool.h>
#include <sys/types.h>
#include "core/base/arena.h"
#include "core/base/error.h"

enum { FFP_SHOT_FOLDERS_MAX = 512 };

typedef struct FfpShotFolder {
    const char *name;    // the folder's, for people
    const char *problem; // NULL, or why the folder cannot be used
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
// pictures, more than FFP_SHOT_FOLDERS_MAX.
bool ffp_shot_folders_find(FfpShotFolders *out, const char *const *paths, int n_paths, FfpError *err);
// Of each folder, keeps the pictures under black, white and the Gray codes, in this order, among those of
// everything that was shown (the folder of patterns); a folder of these alone stays as it is, and all others
// get a problem. *width, *height: of the panel. Errors: of ffp_shown_read, and patterns without Gray codes.
bool ffp_shot_folders_select_codes(FfpShotFolders *folders, const char *shown, int *width, int *height,
                                   FfpError *err);
void ffp_shot_folders_free(FfpShotFolders *out);

#endif
