// Folders of photographs, one for each attitude of a chessboard, place of a camera or stop of a turntable.
#ifndef FFP_SHOTS_FOLDERS_H
#define FFP_SHOTS_FOLDERS_H

#include <stdbool.h>
#include <sys/types.h>
#include "core/base/arena.h"
#include "core/base/error.h"
#include "core/patterns/shown.h"

enum { FFP_SHOT_FOLDERS_MAX = 512 };

typedef struct FfpShotFolder {
    const char *name;    // the folder's, or of folders of one name the part of the path that tells them apart
    const char *problem; // NULL, or why the folder cannot be used
    const char **files;  // paths of its pictures in natural order; NULL: missing (ffp_shot_folder_select)
    int n_files, others; // of patterns before the codes so many may be among them, too
    dev_t device;        // which folder it is, whatever the path to it
    ino_t inode;
} FfpShotFolder;

typedef struct FfpShotFolders {
    FfpArena *arena; // owns all strings and lists
    FfpShotFolder *folders;
    int n;
} FfpShotFolders;

// The folders that are named, or the folders in them where they hold no pictures themselves; both in natural
// order, unless the caller's is another than that of the names' bytes. If a folder
// holds two pictures, black and white, and a single folder with more, these follow its own. Errors: a folder
// that is named twice, is not there or holds neither pictures nor folders with pictures, more than
// FFP_SHOT_FOLDERS_MAX.
bool ffp_shot_folders_find(FfpShotFolders *out, const char *const *paths, int n_paths, FfpError *err);
// Keeps a folder's pictures under black, white and the Gray codes, in this order, among those of everything
// that was shown: codes that are missing by the numbers of the files are NULL, with a note. A folder of these
// alone, or of so many pictures that they may be codes in another order, stays as it is. NULL, or the problem
// of others.
const char *ffp_shot_folder_select(FfpShotFolder *folder, const FfpShown *shown, FfpArena *arena);
// The same of each folder, by the folder of patterns. *width, *height: of the panel.
// Errors: of ffp_shown_read, and patterns without Gray codes.
bool ffp_shot_folders_select_codes(FfpShotFolders *folders, const char *shown, int *width, int *height,
                                   FfpError *err);
// The size of a folder's photographs: of the middle one, as the first and the last may be strays.
bool ffp_shot_folder_size(const FfpShotFolder *folder, int *width, int *height, FfpError *err);
void ffp_shot_folders_free(FfpShotFolders *out);

#endif
