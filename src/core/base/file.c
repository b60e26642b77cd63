#define _XOPEN_SOURCE 700 // nftw
#include "core/base/file.h"
#include <errno.h>
#include <fcntl.h>
#include <ftw.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>
#include "core/base/call.h"
#include "core/base/memory_file.h"

#define LINKS_MAX 40     // as in Linux's own path lookup
#define TEMPORARIES 1000 // names that are tried for one

// The kind of file at a path, for messages; NULL: a regular file.
static const char *not_regular(const struct stat *about) {
    if (S_ISREG(about->st_mode)) return NULL;
    if (S_ISDIR(about->st_mode)) return "a folder";
    if (S_ISFIFO(about->st_mode)) return "a FIFO or pipe";
    if (S_ISSOCK(about->st_mode)) return "a socket";
    return "a device";
}

// --- Reading. ---

static FILE *open_contents(const FfpMemoryFile *file, FfpError *err) {
    FILE *stream = file->size > 0 ? fmemopen((void *)file->bytes, file->size, "rb") : NULL;
    if (!stream) ffp_fail(err, FFP_ERROR_FILE, file->path, file->size > 0 ? "cannot open" : "is empty");
    return stream;
}

FILE *ffp_open_to_read(const char *path, FfpError *err) {
    const FfpMemoryFile *file = ffp_memory_file(path);
    if (file) return open_contents(file, err);
    const int fd = open(path, O_RDONLY | O_NONBLOCK | O_NOCTTY | O_CLOEXEC);
    struct stat about;
    if (fd < 0 || fstat(fd, &about) != 0) {
        ffp_fail(err, FFP_ERROR_IO, path, "cannot open: %s", strerror(errno));
        if (fd >= 0) close(fd);
        return NULL;
    }
    FILE *stream = NULL;
    if (not_regular(&about))
        ffp_fail(err, FFP_ERROR_FILE, path, "is %s, not a file", not_regular(&about));
    else if (!(stream = fdopen(fd, "rb")))
        ffp_fail(err, FFP_ERROR_IO, path, "cannot open: %s", strerror(errno));
    if (!stream) close(fd);
    return stream;
}

int64_t ffp_file_size(FILE *stream) {
    const off_t at = ftello(stream);
    if (at < 0 || fseeko(stream, 0, SEEK_END) != 0) return -1;
    const off_t size = ftello(stream);
    return fseeko(stream, at, SEEK_SET) == 0 ? (int64_t)size : -1;
}

FILE *ffp_open_to_grow(const char *path, bool append, FfpError *err) {
    const int kind = append ? O_APPEND : O_TRUNC;
    struct stat about;
    if (stat(path, &about) == 0 && not_regular(&about)) {
        ffp_fail(err, FFP_ERROR_IO, path, "cannot write: %s has this name", not_regular(&about));
        return NULL;
    }
    const int fd = open(path, O_WRONLY | O_CREAT | O_NONBLOCK | O_NOCTTY | O_CLOEXEC | kind, 0666);
    FILE *stream = fd >= 0 ? fdopen(fd, append ? "ab" : "wb") : NULL;
    if (stream) return stream;
    ffp_fail(err, FFP_ERROR_IO, path, "cannot write: %s", strerror(errno));
    if (fd >= 0) close(fd);
    return NULL;
}

// Reads to the end of an open file, which may have grown since its size was asked.
static bool read_stream(FILE *stream, const char *path, size_t max_bytes, char **data, size_t *size,
                        FfpError *err) {
    const int64_t known = ffp_file_size(stream);
    if (known > 0 && (uint64_t)known > max_bytes)
        return ffp_fail(err, FFP_ERROR_FILE, path, "file is larger than %zu bytes", max_bytes);
    size_t capacity = (known > 0 ? (size_t)known : 0) + 4096, used = 0;
    char *buffer = ffp_try_take(capacity, 1);
    while (buffer) {
        used += fread(buffer + used, 1, capacity - 1 - used, stream);
        if (used > max_bytes || used < capacity - 1) break;
        char *larger = ffp_try_grow(buffer, capacity * 2, 1);
        if (!larger) ffp_free(buffer);
        buffer = larger;
        capacity *= 2;
    }
    if (!buffer) return ffp_fail(err, FFP_ERROR_MEMORY, path, "out of memory while reading");
    if (ferror(stream) || used > max_bytes) {
        const bool large = used > max_bytes;
        ffp_free(buffer);
        if (large) return ffp_fail(err, FFP_ERROR_FILE, path, "file is larger than %zu bytes", max_bytes);
        return ffp_fail(err, FFP_ERROR_IO, path, "cannot read: %s", strerror(errno));
    }
    buffer[used] = 0;
    *data = buffer;
    *size = used;
    return true;
}

bool ffp_read_file(const char *path, size_t max_bytes, char **data, size_t *size, FfpError *err) {
    *data = NULL;
    *size = 0;
    FILE *stream = ffp_open_to_read(path, err);
    if (!stream) return false;
    const bool ok = read_stream(stream, path, max_bytes, data, size, err);
    fclose(stream);
    return ok;
}

bool ffp_read_text(const char *path, size_t max_bytes, char **text, size_t *size, FfpError *err) {
    if (!ffp_read_file(path, max_bytes, text, size, err)) return false;
    char *bytes = *text;
    if (*size >= 2 && (memcmp(bytes, "\xFF\xFE", 2) == 0 || memcmp(bytes, "\xFE\xFF", 2) == 0)) {
        ffp_free(bytes);
        *text = NULL;
        return ffp_fail(err, FFP_ERROR_FILE, path, "is text in UTF-16: save it as UTF-8");
    }
    if (*size >= 3 && memcmp(bytes, "\xEF\xBB\xBF", 3) == 0) {
        *size -= 3;
        memmove(bytes, bytes + 3, *size + 1);
    }
    return true;
}

static void close_file(void *file) {
    fclose(file);
}

void ffp_own_file(FILE *file) {
    ffp_own(file, close_file);
}

int ffp_close_file(FILE *file) {
    ffp_disown(file);
    return fclose(file);
}

// --- Names. ---

// The path that a path's last part leads to through any symbolic links; it need not exist. Slashes at its end
// are left out.
static bool follow_links(char out[FFP_PATH_MAX], const char *path, FfpError *err) {
    size_t length = strlen(path);
    while (length > 1 && path[length - 1] == '/') length--;
    if (length == 0) return ffp_fail(err, FFP_ERROR_ARGUMENT, path, "the path is empty");
    if (length >= FFP_PATH_MAX) return ffp_fail(err, FFP_ERROR_ARGUMENT, path, "path is too long");
    memcpy(out, path, length);
    out[length] = 0;
    for (int i = 0; i < LINKS_MAX; i++) {
        char link[FFP_PATH_MAX];
        const ssize_t got = readlink(out, link, sizeof link - 1);
        if (got < 0) return true; // no link, or nothing at all
        link[got] = 0;
        const char *slash = strrchr(out, '/');
        const size_t folder = *link == '/' || !slash ? 0 : (size_t)(slash - out) + 1;
        if (got == 0 || folder + (size_t)got >= FFP_PATH_MAX)
            return ffp_fail(err, FFP_ERROR_ARGUMENT, path, "the link's path is too long");
        memcpy(out + folder, link, (size_t)got + 1);
    }
    return ffp_fail(err, FFP_ERROR_IO, path, "symbolic links form a circle");
}

// The name that an output gets in the end into out->temporary, and what is there now (st_mode 0: nothing).
static bool find_target(FfpOutput *out, const char *path, struct stat *there, FfpError *err) {
    struct stat target;
    char found[FFP_PATH_MAX];
    *out = (FfpOutput){0};
    memset(there, 0, sizeof *there);
    if (!follow_links(found, path, err)) return false;
    snprintf(out->path, sizeof out->path, "%s", path);
    if (stat(path, there) != 0) {
        memset(there, 0, sizeof *there);
    } else if (stat(found, &target) != 0 || target.st_dev != there->st_dev ||
               target.st_ino != there->st_ino) {
        // what /proc/self/fd holds looks like links, but leads to no name
        return ffp_fail(err, FFP_ERROR_IO, path, "cannot write: this is an open file, pipe or terminal");
    }
    memcpy(out->temporary, found, strlen(found) + 1);
    out->target = strlen(found);
    return true;
}

static void target_of(const FfpOutput *out, char target[FFP_PATH_MAX]) {
    memcpy(target, out->temporary, out->target);
    target[out->target] = 0;
}

// Takes a free name beside the target: a file, whose descriptor is returned, or a folder. -1 with errno.
static int take_temporary(FfpOutput *out, bool folder) {
    for (int i = 0; i < TEMPORARIES; i++) {
        char number[16] = "";
        if (i > 0) snprintf(number, sizeof number, "-%d", i);
        snprintf(out->temporary + out->target, sizeof out->temporary - out->target, ".%ld%s.tmp",
                 (long)getpid(), number);
        const int got =
            folder ? mkdir(out->temporary, 0777)
                   : open(out->temporary, O_WRONLY | O_CREAT | O_EXCL | O_NOFOLLOW | O_CLOEXEC, 0666);
        if (got >= 0 || errno != EEXIST) return got;
    }
    return -1;
}

// --- Outputs. ---

typedef struct FfpTemporary {
    FILE *stream; // NULL: a folder
    char name[FFP_PATH_MAX + 32];
    FfpMemoryFile *file; // in memory: it has no name, but
    char *bytes;         // what the stream holds, by malloc
    size_t size;
} FfpTemporary;

static void remove_temporary(void *thing) {
    FfpTemporary *temporary = thing;
    if (temporary->stream) fclose(temporary->stream);
    if (temporary->file)
        free(temporary->bytes);
    else if (unlink(temporary->name) != 0)
        ffp_remove_tree(temporary->name);
    ffp_free(temporary);
}

// False, and nothing is left, when there is no memory for it.
static bool own_temporary(FfpOutput *out, FfpError *err) {
    FfpTemporary *owned = ffp_try_alloc(1, sizeof *owned);
    if (owned) {
        owned->stream = out->stream;
        memcpy(owned->name, out->temporary, sizeof owned->name);
    }
    if (owned && ffp_try_own(owned, remove_temporary)) {
        out->owned = owned;
        return true;
    }
    ffp_free(owned);
    ffp_output_abort(out);
    return ffp_fail(err, FFP_ERROR_MEMORY, out->path, "out of memory");
}

static void disown_temporary(FfpOutput *out) {
    ffp_disown(out->owned);
    ffp_free(out->owned);
    out->owned = NULL;
}

static bool cannot_write(FfpOutput *out, int reason, FfpError *err) {
    out->temporary[0] = 0;
    return ffp_fail(err, FFP_ERROR_IO, out->path, "cannot write: %s", strerror(reason));
}

static bool open_in_memory(FfpOutput *out, FfpMemoryFile *file, FfpError *err) {
    FfpTemporary *owned = ffp_try_alloc(1, sizeof *owned);
    *out = (FfpOutput){.owned = owned};
    if (owned && (owned->stream = open_memstream(&owned->bytes, &owned->size))) {
        owned->file = file;
        out->stream = owned->stream;
        snprintf(out->path, sizeof out->path, "%s", file->path);
        memcpy(out->temporary, out->path, sizeof out->path);
        out->target = strlen(out->path);
        if (ffp_try_own(owned, remove_temporary)) return true;
        remove_temporary(owned);
    } else {
        ffp_free(owned);
    }
    *out = (FfpOutput){0};
    return ffp_fail(err, FFP_ERROR_MEMORY, file->path, "out of memory");
}

static bool commit_in_memory(FfpOutput *out, FfpError *err) {
    FfpTemporary *owned = out->owned;
    FfpMemoryFile *file = owned->file;
    const bool ok = !ferror(owned->stream) && fflush(owned->stream) == 0;
    file->written = ok ? ffp_try_take(owned->size, 1) : NULL;
    if (file->written) {
        memcpy(file->written, owned->bytes, owned->size);
        file->size = owned->size;
    }
    ffp_output_abort(out);
    return file->written || ffp_fail(err, FFP_ERROR_MEMORY, file->path, "out of memory");
}

bool ffp_output_open(FfpOutput *out, const char *path, FfpError *err) {
    struct stat there;
    FfpMemoryFile *file = ffp_memory_file(path);
    if (file) return open_in_memory(out, file, err);
    if (!find_target(out, path, &there, err)) return false;
    if (path[strlen(path) - 1] == '/') return cannot_write(out, EISDIR, err);
    if (there.st_mode != 0 && not_regular(&there)) {
        out->temporary[0] = 0;
        return ffp_fail(err, FFP_ERROR_IO, path, "cannot write: %s has this name", not_regular(&there));
    }
    const int fd = take_temporary(out, false);
    if (fd < 0) return cannot_write(out, errno, err);
    if (there.st_mode != 0) fchmod(fd, there.st_mode & 0777); // file systems without permissions refuse
    out->stream = fdopen(fd, "wb");
    if (out->stream) return own_temporary(out, err);
    const int reason = errno;
    close(fd);
    unlink(out->temporary);
    return cannot_write(out, reason, err);
}

static bool make_parents(const FfpOutput *out, FfpError *err) {
    char parent[FFP_PATH_MAX];
    target_of(out, parent);
    char *slash = strrchr(parent, '/');
    if (!slash || slash == parent) return true;
    *slash = 0;
    return ffp_make_folders(parent, err);
}

bool ffp_output_open_folder(FfpOutput *out, const char *path, bool fresh, FfpError *err) {
    struct stat there;
    if (!find_target(out, path, &there, err)) return false;
    if (there.st_mode != 0 && !S_ISDIR(there.st_mode)) return cannot_write(out, ENOTDIR, err);
    if (there.st_mode != 0 && !fresh) return true;
    if (!make_parents(out, err)) {
        out->temporary[0] = 0;
        return false;
    }
    return take_temporary(out, true) == 0 ? own_temporary(out, err) : cannot_write(out, errno, err);
}

// Closes the file so that it is on the disk; false with errno.
static bool finish_stream(FfpOutput *out) {
    if (!out->stream) return true;
    const bool ok = !ferror(out->stream) && fflush(out->stream) == 0 && fsync(fileno(out->stream)) == 0;
    const int reason = errno;
    const bool closed = fclose(out->stream) == 0;
    out->stream = NULL;
    if (!ok) errno = reason;
    return ok && closed;
}

bool ffp_output_commit(FfpOutput *out, FfpError *err) {
    char target[FFP_PATH_MAX];
    if (out->temporary[0] == 0) return ffp_fail(err, FFP_ERROR_IO, out->path, "cannot write: not open");
    if (out->owned && out->owned->file) return commit_in_memory(out, err);
    const bool folder = !out->stream;
    disown_temporary(out);
    target_of(out, target);
    bool ok = finish_stream(out);
    if (ok && out->temporary[out->target] != 0) ok = rename(out->temporary, target) == 0;
    const int reason = errno;
    if (!ok) ffp_output_abort(out);
    out->temporary[0] = 0;
    if (ok) return true;
    if (folder && (reason == ENOTEMPTY || reason == EEXIST || reason == ENOTDIR))
        return ffp_fail(err, FFP_ERROR_FILE, out->path,
                        "already exists and is not empty: choose another, or remove it");
    return cannot_write(out, reason, err);
}

void ffp_output_abort(FfpOutput *out) {
    if (out->temporary[0] == 0) return;
    if (out->owned && out->owned->file) {
        ffp_disown(out->owned);
        remove_temporary(out->owned);
        *out = (FfpOutput){0};
        return;
    }
    disown_temporary(out);
    if (out->stream) fclose(out->stream);
    out->stream = NULL;
    if (out->temporary[out->target] != 0 && unlink(out->temporary) != 0) ffp_remove_tree(out->temporary);
    out->temporary[0] = 0;
}

bool ffp_output_probe(const char *path, FfpError *err) {
    FfpOutput out;
    if (!path) return true;
    const bool ok = ffp_output_open(&out, path, err);
    ffp_output_abort(&out);
    return ok;
}

bool ffp_output_prepare(const char *path, FfpError *err) {
    FfpOutput out;
    struct stat there;
    if (!path) return true;
    if (!find_target(&out, path, &there, err) || !make_parents(&out, err)) return false;
    return ffp_output_probe(path, err);
}

// The folder itself, or the first above it that exists, must be one that can be written to.
bool ffp_output_probe_folder(const char *path, FfpError *err) {
    FfpOutput out;
    struct stat there;
    if (!path) return true;
    if (!find_target(&out, path, &there, err)) return false;
    char *name = out.temporary, *slash;
    while (stat(name, &there) != 0) {
        if (errno != ENOENT) return cannot_write(&out, errno, err);
        if (!(slash = strrchr(name, '/')))
            strcpy(name, ".");
        else if (slash == name)
            strcpy(name, "/");
        else
            *slash = 0;
    }
    if (!S_ISDIR(there.st_mode)) return cannot_write(&out, ENOTDIR, err);
    return access(name, W_OK | X_OK) == 0 || cannot_write(&out, errno, err);
}

bool ffp_write_file(const char *path, const void *data, size_t size, FfpError *err) {
    FfpOutput out;
    if (!ffp_output_open(&out, path, err)) return false;
    if (size > 0 && fwrite(data, 1, size, out.stream) != size) {
        ffp_output_abort(&out);
        return ffp_fail(err, FFP_ERROR_IO, path, "cannot write: disk full?");
    }
    return ffp_output_commit(&out, err);
}

// One folder, whose parent exists; if it is a link that leads nowhere yet, the folder it means.
static bool make_folder(const char *path, FfpError *err) {
    char target[FFP_PATH_MAX];
    struct stat about;
    if (mkdir(path, 0777) == 0) return true;
    const int reason = errno;
    if (ffp_is_folder(path)) return true;
    if (reason == EEXIST && stat(path, &about) != 0 && errno == ENOENT)
        return follow_links(target, path, err) && ffp_make_folders(target, err);
    return ffp_fail(err, FFP_ERROR_IO, path, "cannot make the folder: %s", strerror(reason));
}

bool ffp_make_folders(const char *path, FfpError *err) {
    char part[FFP_PATH_MAX];
    const size_t length = strlen(path);
    if (length == 0 || length >= sizeof part)
        return ffp_fail(err, FFP_ERROR_ARGUMENT, path, "not a path for a folder");
    memcpy(part, path, length + 1);
    for (size_t i = 1; i <= length; i++) {
        if (part[i] != '/' && part[i] != 0) continue;
        part[i] = 0;
        if (!make_folder(part, err)) return false;
        if (i < length) part[i] = '/';
    }
    return true;
}

static int remove_entry(const char *path, const struct stat *about, int kind, struct FTW *where) {
    (void)about, (void)kind, (void)where;
    return remove(path);
}

void ffp_remove_tree(const char *folder) {
    nftw(folder, remove_entry, 16, FTW_DEPTH | FTW_PHYS);
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
    return slash ? slash + 1 : path;
}
