// A capture's folder appears under its name only when it is whole.
#include <dirent.h>
#include "core/base/file.h"
#include "core/capture/capture.h"

#define NOT_FREE "already exists and is not empty: choose another, or remove it"

// Reads what was written as every command will: a capture that could not be used must not appear.
static bool verify(const char *folder, FfpError *err) {
    FfpCapture capture;
    FfpError why = {0};
    if (!ffp_capture_read(&capture, folder, &why))
        return ffp_fail(err, why.code, NULL, "the resulting capture cannot be used: %s", why.text);
    ffp_capture_free(&capture);
    return true;
}

bool ffp_capture_probe(const char *folder, FfpError *err) {
    DIR *there = opendir(folder);
    int entries = 0; // "." and ".." are always there
    while (there && entries < 3 && readdir(there)) entries++;
    if (there) closedir(there);
    if (entries >= 3 || ffp_is_file(folder)) return ffp_fail(err, FFP_ERROR_FILE, folder, NOT_FREE);
    return ffp_output_probe_folder(folder, err);
}

bool ffp_capture_write_whole(const FfpCapture *capture, const char *folder,
                             bool (*finish)(const char *part, void *context, FfpError *err), void *context,
                             FfpError *err) {
    FfpOutput out;
    const bool ok = ffp_output_open_folder(&out, folder, true, err) &&
                    ffp_capture_write(capture, out.temporary, err) &&
                    (!finish || finish(out.temporary, context, err)) && verify(out.temporary, err) &&
                    ffp_output_commit(&out, err);
    ffp_output_abort(&out);
    return ok;
}
