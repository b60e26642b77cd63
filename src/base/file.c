#include "base/file.h"

#include <errno.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

// Reads to the end of an open file; pipes have no size beforehand, so the buffer grows.
static bool read_stream(FILE *stream, const char *path, size_t max_bytes, char **data, size_t *size,
                        FfpError *err) {
    size_t capacity = 65536, used = 0;
    char *buffer = malloc(capacity);
    while (buffer != NULL) {
        used += fread(buffer + used, 1, capacity - 1 - used, stream);
        if (used > max_bytes || used < capacity - 1) break;
        char *larger = realloc(buffer, capacity * 2);
        if (larger == NULL) free(buffer);
        buffer = larger;
        capacity *= 2;
    }
    if (buffer == NULL) return ffp_fail(err, path, "out of memory while reading");
    if (ferror(stream) || used > max_bytes) {
        const bool large = used > max_bytes;
        free(buffer);
        if (large) return ffp_fail(err, path, "file is larger than %zu bytes", max_bytes);
        return ffp_fail(err, path, "cannot read: %s", strerror(errno));
    }
    buffer[used] = 0;
    *data = buffer;
    *size = used;
    return true;
}

bool ffp_read_file(const char *path, size_t max_bytes, char **data, size_t *size, FfpError *err) {
    *data = NULL;
    *size = 0;
    if (ffp_is_folder(path)) return ffp_fail(err, path, "is a folder, not a file");
    FILE *stream = fopen(path, "rb");
    if (stream == NULL) return ffp_fail(err, path, "cannot open: %s", strerror(errno));
    const bool ok = read_stream(stream, path, max_bytes, data, size, err);
    fclose(stream);
    return ok;
}

bool ffp_output_open(FfpOutput *out, const char *path, FfpError *err) {
    memset(out, 0, sizeof *out);
    if (strlen(path) >= sizeof out->path) return ffp_fail(err, path, "path is too long");
    memcpy(out->path, path, strlen(path) + 1);
    snprintf(out->temporary, sizeof out->temporary, "%s.%ld.tmp", path, (long)getpid());
    if (ffp_is_folder(path)) return ffp_fail(err, path, "cannot write: a folder has this name");
    out->stream = fopen(out->temporary, "wb");
    if (out->stream == NULL) return ffp_fail(err, path, "cannot write: %s", strerror(errno));
    return true;
}

bool ffp_output_commit(FfpOutput *out, FfpError *err) {
    if (out->stream == NULL) return ffp_fail(err, out->path, "cannot write: not open");
    bool ok = !ferror(out->stream) && fflush(out->stream) == 0 && fsync(fileno(out->stream)) == 0;
    int reason = errno;
    if (fclose(out->stream) != 0 && ok) ok = false, reason = errno;
    out->stream = NULL;
    if (ok && rename(out->temporary, out->path) != 0) ok = false, reason = errno;
    if (ok) return true;
    unlink(out->temporary);
    return ffp_fail(err, out->path, "cannot write: %s", strerror(reason));
}

void ffp_output_abort(FfpOutput *out) {
    if (out->stream == NULL) return;
    fclose(out->stream);
    out->stream = NULL;
    unlink(out->temporary);
}

bool ffp_output_probe(const char *path, FfpError *err) {
    FfpOutput out;
    if (path == NULL) return true;
    const bool ok = ffp_output_open(&out, path, err);
    ffp_output_abort(&out);
    return ok;
}

bool ffp_write_file(const char *path, const void *data, size_t size, FfpError *err) {
    FfpOutput out;
    if (!ffp_output_open(&out, path, err)) return false;
    if (size > 0 && fwrite(data, 1, size, out.stream) != size) {
        ffp_output_abort(&out);
        return ffp_fail(err, path, "cannot write: disk full?");
    }
    return ffp_output_commit(&out, err);
}

bool ffp_make_folders(const char *path, FfpError *err) {
    char part[FFP_PATH_MAX];
    const size_t length = strlen(path);
    if (length == 0 || length >= sizeof part) return ffp_fail(err, path, "not a path for a folder");
    memcpy(part, path, length + 1);
    for (size_t i = 1; i <= length; i++) {
        if (part[i] != '/' && part[i] != 0) continue;
        part[i] = 0;
        if (mkdir(part, 0777) != 0 && !ffp_is_folder(part)) {
            return ffp_fail(err, part, "cannot make the folder: %s", strerror(errno));
        }
        if (i < length) part[i] = '/';
    }
    return true;
}

bool ffp_is_file(const char *path) {
    struct stat about;
    return stat(path, &about) == 0 && S_ISREG(about.st_mode);
}

bool ffp_is_folder(const char *path) {
    struct stat about;
    return stat(path, &about) == 0 && S_ISDIR(about.st_mode);
}

bool ffp_join_path(char out[FFP_PATH_MAX], const char *folder, const char *name) {
    const size_t length = strlen(folder);
    const char *slash = length > 0 && folder[length - 1] == '/' ? "" : "/";
    const int written = snprintf(out, FFP_PATH_MAX, "%s%s%s", folder, slash, name);
    return written >= 0 && written < FFP_PATH_MAX;
}

const char *ffp_basename(const char *path) {
    const char *slash = strrchr(path, '/');
    return slash != NULL ? slash + 1 : path;
}
