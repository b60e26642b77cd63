// A folder that a camera's program fills, watched by inotify.
#include <errno.h>
#include <stdio.h>
#include <string.h>
#include <sys/inotify.h>
#include <unistd.h>
#include "work.h"

bool ffp_server_watch(FfpStudio *studio, const char *folder, char said[FFP_STUDIO_SAID]) {
    FfpStudioServer *server = (FfpStudioServer *)studio;
    const int watch = inotify_add_watch(server->changes, folder, IN_CLOSE_WRITE | IN_MOVED_TO | IN_ONLYDIR);
    if (watch < 0)
        return ffp_studio_say(said, "the folder %s cannot be watched: %s", folder, strerror(errno));
    if (server->watch >= 0 && server->watch != watch) // the same folder has the same watch
        inotify_rm_watch(server->changes, server->watch);
    server->watch = watch;
    studio->watching = true;
    return true;
}

// It was deleted, or its disk was taken out.
static void lose_watch(FfpStudioServer *server, const char *folder) {
    FfpStudio *studio = &server->studio;
    server->watch = -1;
    studio->watching = false;
    snprintf(studio->notice, sizeof studio->notice,
             "The folder %.300s is gone: make it again, or name another (step 1).", folder);
    ffp_studio_changed(studio);
}

void ffp_server_arrived(FfpStudioServer *server) {
    _Alignas(struct inotify_event) char events[16384];
    const ssize_t got = read(server->changes, events, sizeof events);
    const char *folder = ffp_studio_setting(&server->studio, "watched", NULL);
    const bool watching = strcmp(ffp_studio_setting(&server->studio, "camera", ""), "folder") == 0;
    for (ssize_t at = 0; folder && watching && at < got;) {
        const struct inotify_event *event = (const struct inotify_event *)(events + at);
        if (event->wd == server->watch && (event->mask & IN_IGNORED)) lose_watch(server, folder);
        if (event->len > 0 && !(event->mask & IN_ISDIR))
            ffp_studio_arrived(&server->studio, folder, event->name);
        at += (ssize_t)(sizeof *event + event->len);
    }
}
