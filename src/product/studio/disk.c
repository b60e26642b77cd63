// The studio's folder: nothing outside it is read or written, no link is followed, and what is written is on
// disk, whole, before anybody is told so.
#define _GNU_SOURCE
#include <dirent.h>
#include <errno.h>
#include <fcntl.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>
#include "rules.h"

#define FILE_MOST ((size_t)1 << 28) // bytes of a photograph
enum { JSON_MOST = 1 << 20, SET_ASIDE_MOST = 10000 };

bool ffp_studio_path(const char *path) {
    const size_t length = strlen(path);
    if (length == 0 || length >= FFP_STUDIO_NAME || path[length - 1] == '/') return false;
    bool begins = true;
    for (const char *c = path; *c; c++) {
        const bool letter = (*c >= 'a' && *c <= 'z') || (*c >= 'A' && *c <= 'Z') || (*c >= '0' && *c <= '9');
        if (*c == '/' ? begins : !letter && *c != '-' && *c != '_' && *c != '.') return false;
        if (begins && *c == '.') return false;
        begins = *c == '/';
    }
    return true;
}

// The folder that holds the last word of a path, and that word; its parents are made if that is asked for.
static int open_parent(const FfpStudio *studio, const char *path, bool make, const char **last) {
    if (!ffp_studio_path(path)) return errno = EINVAL, -1;
    int at = dup(studio->root);
    const char *word = path;
    for (const char *slash; at >= 0 && (slash = strchr(word, '/')); word = slash + 1) {
        char name[FFP_STUDIO_NAME];
        snprintf(name, sizeof name, "%.*s", (int)(slash - word), word);
        if (make && mkdirat(at, name, 0777) == 0) fsync(at);
        const int next = openat(at, name, O_RDONLY | O_DIRECTORY | O_NOFOLLOW | O_CLOEXEC);
        close(at);
        at = next;
    }
    *last = word;
    return at;
}

int ffp_studio_open(const FfpStudio *studio, const char *path) {
    const char *name;
    const int at = open_parent(studio, path, false, &name);
    if (at < 0) return -1;
    const int file = openat(at, name, O_RDONLY | O_NOFOLLOW | O_NONBLOCK | O_CLOEXEC);
    close(at);
    return file;
}

char *ffp_studio_read_whole(int file, size_t *size) {
    struct stat about;
    if (fstat(file, &about) != 0 || !S_ISREG(about.st_mode) || (size_t)about.st_size > FILE_MOST) return NULL;
    char *bytes = malloc((size_t)about.st_size + 1);
    *size = 0;
    for (ssize_t got; bytes && *size < (size_t)about.st_size; *size += (size_t)got)
        if ((got = read(file, bytes + *size, (size_t)about.st_size - *size)) <= 0) return free(bytes), NULL;
    return bytes;
}

bool ffp_studio_exists(const FfpStudio *studio, const char *path) {
    const int file = ffp_studio_open(studio, path);
    if (file >= 0) close(file);
    return file >= 0;
}

bool ffp_studio_make(const FfpStudio *studio, const char *folder) {
    const char *name;
    const int at = open_parent(studio, folder, true, &name);
    if (at < 0) return false;
    const bool made = mkdirat(at, name, 0777) == 0;
    const bool ok = made ? fsync(at) == 0 : errno == EEXIST;
    close(at);
    return ok;
}

static bool write_all(int file, const char *bytes, size_t size) {
    while (size > 0) {
        const ssize_t wrote = write(file, bytes, size);
        if (wrote < 0 && errno == EINTR) continue;
        if (wrote <= 0) return false;
        bytes += wrote, size -= (size_t)wrote;
    }
    return true;
}

bool ffp_studio_write(const FfpStudio *studio, const char *path, const void *bytes, size_t size) {
    const char *name;
    char temporary[FFP_STUDIO_NAME + 16];
    const int at = open_parent(studio, path, true, &name);
    if (at < 0) return false;
    snprintf(temporary, sizeof temporary, ".%s.part", name); // one writer: the studio holds the folder's lock
    const int file = openat(at, temporary, O_WRONLY | O_CREAT | O_TRUNC | O_NOFOLLOW | O_CLOEXEC, 0666);
    bool ok = file >= 0 && write_all(file, bytes, size) && fsync(file) == 0;
    const int why = errno;
    if (file >= 0) ok = close(file) == 0 && ok;
    ok = ok && renameat(at, temporary, at, name) == 0 && fsync(at) == 0;
    const int then = ok || why == 0 ? errno : why;
    if (!ok && file >= 0) unlinkat(at, temporary, 0);
    close(at);
    errno = then;
    return ok;
}

// A name of a folder, and all below it.
static bool remove_at(int folder, const char *name) {
    if (unlinkat(folder, name, 0) == 0 || errno == ENOENT) return true;
    if (errno != EISDIR && errno != EPERM) return false;
    const int file = openat(folder, name, O_RDONLY | O_DIRECTORY | O_NOFOLLOW | O_CLOEXEC);
    DIR *listed = file >= 0 ? fdopendir(file) : NULL;
    if (!listed) {
        if (file >= 0) close(file);
        return false;
    }
    bool ok = true;
    for (const struct dirent *entry; ok && (entry = readdir(listed));)
        ok = strcmp(entry->d_name, ".") == 0 || strcmp(entry->d_name, "..") == 0 ||
             remove_at(file, entry->d_name);
    closedir(listed);
    return ok && unlinkat(folder, name, AT_REMOVEDIR) == 0;
}

bool ffp_studio_remove(const FfpStudio *studio, const char *path) {
    const char *last;
    const int folder = open_parent(studio, path, false, &last);
    if (folder < 0) return errno == ENOENT;
    const bool ok = remove_at(folder, last);
    close(folder);
    return ok;
}

bool ffp_studio_set_aside(const FfpStudio *studio, const char *path) {
    char flat[FFP_STUDIO_NAME], to[FFP_STUDIO_NAME + 24];
    if (!ffp_studio_exists(studio, path)) return true;
    snprintf(flat, sizeof flat, "%s", path);
    for (char *c = flat; *c; c++)
        if (*c == '/') *c = '-';
    if (!ffp_studio_make(studio, "discarded")) return false;
    for (int n = 1; n < SET_ASIDE_MOST; n++) {
        struct stat there;
        snprintf(to, sizeof to, "discarded/%s-%d", flat, n);
        if (fstatat(studio->root, to, &there, AT_SYMLINK_NOFOLLOW) == 0) continue;
        return renameat(studio->root, path, studio->root, to) == 0;
    }
    return false;
}

static int compare_names(const void *a, const void *b) {
    return strcmp(*(char *const *)a, *(char *const *)b);
}

int ffp_studio_list(const FfpStudio *studio, const char *folder, char **names, int most) {
    const int at = ffp_studio_open(studio, folder);
    DIR *stream = at >= 0 ? fdopendir(at) : NULL;
    int count = 0;
    if (!stream) {
        if (at >= 0) close(at);
        return 0;
    }
    for (struct dirent *entry; count < most && (entry = readdir(stream));)
        if (entry->d_name[0] != '.' && ffp_studio_path(entry->d_name)) {
            char *name = strdup(entry->d_name);
            if (name) names[count++] = name;
        }
    closedir(stream);
    qsort(names, (size_t)count, sizeof *names, compare_names);
    return count;
}

void ffp_studio_free_names(char **names, int count) {
    for (int i = 0; i < count; i++) free(names[i]);
}

json_t *ffp_studio_read_json(const FfpStudio *studio, const char *path) {
    const int file = ffp_studio_open(studio, path);
    size_t size;
    if (file < 0) return NULL;
    char *text = ffp_studio_read_whole(file, &size);
    close(file);
    json_t *value = text && size <= JSON_MOST ? json_loadb(text, size, JSON_REJECT_DUPLICATES, NULL) : NULL;
    free(text);
    return value;
}

void ffp_studio_changed(FfpStudio *studio) {
    studio->version++;
    json_decref(studio->listed);
    studio->listed = NULL;
}
