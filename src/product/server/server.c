// The studio from its opening to its end.
#define _GNU_SOURCE
#include "server.h"
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
static bool open_folder(FfpStudioServer *server, const char *folder, char *said) {
    FfpStudio *studio = &server->studio;
    if (mkdir(folder, 0777) != 0 && errno != EEXIST)
        return ffp_studio_say(said, "%.300s: the folder cannot be made: %s", folder, strerror(errno));
    studio->root = open(folder, O_RDONLY | O_DIRECTORY | O_CLOEXEC);
    if (studio->root < 0 || !realpath(folder, studio->folder))
        return ffp_studio_say(said, "%.300s: the folder cannot be opened: %s", folder, strerror(errno));
    server->lock_file = openat(studio->root, ".studio-lock", O_RDWR | O_CREAT | O_NOFOLLOW | O_CLOEXEC, 0666);
    if (server->lock_file < 0)
        return ffp_studio_say(said, "%.300s: the folder cannot be written to: %s", folder, strerror(errno));
    return flock(server->lock_file, LOCK_EX | LOCK_NB) == 0 ||
           ffp_studio_say(said, "%.300s: another studio works in this folder", folder);
}

static bool prepare(FfpStudioServer *server, const FfpStudioOptions *options, char *said) {
    FfpStudio *studio = &server->studio;
    if (!make_token(server->token)) return ffp_studio_say(said, "this system has no random numbers");
    server->changes = inotify_init1(IN_NONBLOCK | IN_CLOEXEC);
    if (server->changes < 0) return ffp_studio_say(said, "folders cannot be watched: %s", strerror(errno));
    if (!open_folder(server, options->folder, said) || !ffp_studio_load(studio, options->virtual_rig, said))
        return false;
    if (options->osc && !ffp_server_listen(server, options->osc, said)) return false;
    const char *watched = ffp_studio_setting(studio, "watched", NULL);
    if (watched) ffp_server_watch(studio, watched, studio->notice); // what is wrong with it the page shows
    return true;
}

static FfpStudioServer *new_server(int port) {
    static const FfpStudioPlatform platform = {ffp_server_run, ffp_server_stop, ffp_server_watch};
    FfpStudioServer *server = calloc(1, sizeof *server);
    if (!server) return NULL;
    FfpStudio *studio = &server->studio;
    studio->platform = &platform;
    studio->root = studio->shown = server->lock_file = server->changes = server->watch = server->osc = -1;
    studio->run = getpid();
    studio->speed = (double)sysconf(_SC_NPROCESSORS_ONLN);
    const ssize_t length = readlink("/proc/self/exe", studio->program, sizeof studio->program - 1);
    studio->program[length > 0 ? length : 0] = 0;
    server->port = port;
    pthread_mutex_init(&server->lock, NULL);
    return server;
}

static void free_server(FfpStudioServer *server) {
    const int open_files[] = {server->studio.root, server->lock_file, server->changes, server->osc};
    ffp_studio_close(&server->studio);
    json_decref(server->controls);
    for (int i = 0; i < 4; i++)
        if (open_files[i] >= 0) close(open_files[i]);
    pthread_mutex_destroy(&server->lock);
    free(server);
}

bool ffp_server_main(const FfpStudioOptions *options, char *error, size_t size) {
    char said[FFP_STUDIO_SAID] = "no memory";
    FfpStudioServer *server = new_server(options->port);
    const bool ok =
        server && prepare(server, options, said) && ffp_server_serve(server, !options->stays_closed, said);
    if (server) free_server(server);
    if (!ok) snprintf(error, size, "%s", said);
    return ok;
}
