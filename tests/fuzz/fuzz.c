#define _GNU_SOURCE // memfd_create, nftw
#include "fuzz.h"
#include <ftw.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <unistd.h>
#include "core/base/file.h"
#include "core/image/image.h"

static void must(bool ok, const char *what) {
    if (ok) return;
    perror(what);
    abort();
}

const char *fuzz_file(const uint8_t *data, size_t size) {
    static int file = -1;
    static char path[64];
    if (file < 0) {
        file = memfd_create("fuzz", 0);
        must(file >= 0, "memfd_create");
        snprintf(path, sizeof path, "/proc/self/fd/%d", file);
    }
    must(ftruncate(file, 0) == 0 && pwrite(file, data, size, 0) == (ssize_t)size, "a file in memory");
    return path;
}

// --- The folder. ---

static char folder[FFP_PATH_MAX];

static const char *in_folder(const char *name) {
    static char path[FFP_PATH_MAX];
    must(ffp_join_path(path, folder, name), "a path");
    return path;
}

static int remove_one(const char *path, const struct stat *about, int kind, struct FTW *place) {
    (void)about, (void)kind, (void)place;
    return remove(path);
}

static void remove_folder(void) {
    nftw(folder, remove_one, 8, FTW_DEPTH | FTW_PHYS);
}

static void write_picture(const char *name, int side, real value) {
    FfpImage image = ffp_image_new(side, side, 1);
    for (int i = 0; i < side * side; i++) image.data[i] = i % 3 == 0 ? 0 : value;
    must(ffp_image_write_png16(&image, in_folder(name), NULL), name);
    ffp_image_free(&image);
}

static void make_folder(void) {
    const char *root = getenv("TMPDIR");
    snprintf(folder, sizeof folder, "%s/fuzz.XXXXXX", root ? root : "/dev/shm");
    must(mkdtemp(folder) != NULL, folder);
    atexit(remove_folder);
    must(ffp_make_folders(in_folder("patterns"), NULL), "patterns");
    write_picture("a.png", 8, 0.1F);
    write_picture("b.png", 8, 0.7F);
    write_picture("c.png", 8, 0.4F);
    write_picture("a_depth.png", 8, 0.05F);
    write_picture("a_mask.png", 8, 1);
    write_picture("patterns/black.png", 4, 0);
    write_picture("patterns/white.png", 4, 1);
    write_picture("patterns/dots.png", 4, 0.8F);
}

const char *fuzz_neighbour(const char *name, const uint8_t *data, size_t size) {
    if (folder[0] == 0) make_folder();
    FILE *file = fopen(in_folder(name), "wb"); // in its own place: what the library writes waits for the disk
    must(file != NULL, name);
    must(fwrite(data, 1, size, file) == size && fclose(file) == 0, name);
    return in_folder(name);
}

void fuzz_verdict(bool ok, const FfpError *err) {
    if (ok || (err->text[0] != 0 && err->code != FFP_OK)) return;
    fprintf(stderr, "failed without a word\n");
    abort();
}
