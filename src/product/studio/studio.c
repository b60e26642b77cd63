// The studio from its opening to its end.
#define _GNU_SOURCE
#include "studio.h"
#include <errno.h>
#include <fcntl.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/file.h>
#include <sys/inotify.h>
#include <sys/random.h>
#include <sys/stat.h>
#include <unistd.h>
#include "work.h"

// 128 bits that nobody can guess.
static bool make_token(char token[33]) {
    unsigned char bytes[16];
    if (getrandom(bytes, sizeof bytes, 0) != (ssize_t)sizeof bytes) return false;
    for (size_t i = 0; i < sizeof bytes; i++) snprintf(token + 2 * i, 3, "%02x", bytes[i]);
    return true;
}

// One studio for a folder at a time.
static bool open_folder(FfpStudio *studio, const char *folder, char *said) {
    if (mkdir(folder, 0777) != 0 && errno != EEXIST)
        return ffp_studio_say(said, "%.300s: the folder cannot be made: %s", folder, strerror(errno));
    studio->root = open(folder, O_RDONLY | O_DIRECTORY | O_CLOEXEC);
    if (studio->root < 0 || !realpath(folder, studio->folder))
        return ffp_studio_say(said, "%.300s: the folder cannot be opened: %s", folder, strerror(errno));
    studio->lock_file = openat(studio->root, ".studio-lock", O_RDWR | O_CREAT | O_NOFOLLOW | O_CLOEXEC, 0666);
    if (studio->lock_file < 0)
        return ffp_studio_say(said, "%.300s: the folder cannot be written to: %s", folder, strerror(errno));
    return flock(studio->lock_file, LOCK_EX | LOCK_NB) == 0 ||
           ffp_studio_say(said, "%.300s: another studio works in this folder", folder);
}

static bool prepare(FfpStudio *studio, const FfpStudioOptions *options, char *said) {
    if (!make_token(studio->token)) return ffp_studio_say(said, "this system has no random numbers");
    studio->changes = inotify_init1(IN_NONBLOCK | IN_CLOEXEC);
    if (studio->changes < 0) return ffp_studio_say(said, "folders cannot be watched: %s", strerror(errno));
    if (!open_folder(studio, options->folder, said) || !ffp_studio_load(studio, options->virtual_rig, said))
        return false;
    if (options->osc && !ffp_studio_listen(studio, options->osc, said)) return false;
    const char *watched = ffp_studio_setting(studio, "watched", NULL);
    if (watched) ffp_studio_watch(studio, watched, studio->notice); // what is wrong with it the page shows
    return true;
}

bool ffp_studio_run(const FfpStudioOptions *options, char *error, size_t size) {
    char said[FFP_STUDIO_SAID] = "no memory";
    FfpStudio *studio = calloc(1, sizeof *studio);
    bool ok = false;
    if (studio) {
        studio->root = studio->lock_file = studio->changes = studio->watch = studio->shown = studio->osc = -1;
        studio->port = options->port;
        pthread_mutex_init(&studio->lock, NULL);
        ok = prepare(studio, options, said) && ffp_studio_serve(studio, !options->stays_closed, said);
        json_decref(studio->settings), json_decref(studio->listed), json_decref(studio->controls);
        const int open_files[] = {studio->root, studio->lock_file, studio->changes, studio->osc};
        for (int i = 0; i < 4; i++)
            if (open_files[i] >= 0) close(open_files[i]);
        pthread_mutex_destroy(&studio->lock);
        free(studio);
    }
    if (!ok) snprintf(error, size, "%s", said);
    return ok;
}
