// A capture's folder appears under its name only when it is whole.
#define _XOPEN_SOURCE 700 // nftw
#include <dirent.h>
#include <errno.h>
#include <ftw.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>

#include "base/file.h"
#include "capture/capture.h"

#define NOT_FREE "is there already and not empty: choose another, or remove it"

static int remove_entry(const char *path, const struct stat *about, int kind, struct FTW *where) {
    (void)about, (void)kind, (void)where;
    return remove(path);
}

// Reads what was written as every command will: a capture that could not be used must not appear.
static bool verify(const char *folder, FfpError *err) {
    FfpCapture capture;
    FfpError why = {0};
    if (!ffp_capture_read(&capture, folder, &why))
        return ffp_fail(err, NULL, "the capture made cannot be used: %s", why.text);
    ffp_capture_free(&capture);
    return true;
}

// "FOLDER.<process>.tmp", without the slashes at the end of FOLDER.
static bool part_of(const char *folder, char part[FFP_PATH_MAX], FfpError *err) {
    size_t length = strlen(folder);
    while (length > 1 && folder[length - 1] == '/') length--;
    const int needed = snprintf(part, FFP_PATH_MAX, "%.*s.%ld.tmp", (int)length, folder, (long)getpid());
    return (needed > 0 && needed < FFP_PATH_MAX) || ffp_fail(err, folder, "the path is too long");
}

// Names the folder; one that is there and empty gives way.
static bool publish(const char *part, const char *folder, FfpError *err) {
    if (rename(part, folder) == 0) return true;
    const bool there = errno == ENOTEMPTY || errno == EEXIST || errno == ENOTDIR;
    return there ? ffp_fail(err, folder, NOT_FREE)
                 : ffp_fail(err, folder, "cannot name the folder: %s", strerror(errno));
}

bool ffp_capture_probe(const char *folder, FfpError *err) {
    DIR *there = opendir(folder);
    int entries = 0; // "." and ".." are always there
    while (there != NULL && entries < 3 && readdir(there) != NULL) entries++;
    if (there != NULL) closedir(there);
    return (entries < 3 && !ffp_is_file(folder)) || ffp_fail(err, folder, NOT_FREE);
}

bool ffp_capture_write_whole(const FfpCapture *capture, const char *folder,
                             bool (*finish)(const char *part, void *context, FfpError *err), void *context,
                             FfpError *err) {
    char part[FFP_PATH_MAX];
    if (!part_of(folder, part, err)) return false;
    const bool ok = ffp_capture_write(capture, part, err) && (!finish || finish(part, context, err)) &&
                    verify(part, err) && publish(part, folder, err);
    if (!ok) nftw(part, remove_entry, 16, FTW_DEPTH | FTW_PHYS);
    return ok;
}
