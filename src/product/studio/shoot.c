// Photographs on their way to disk: of the shot that is due and no other, so that a second window, a reload
// or a camera that fires twice changes nothing. A folder's photographs have no numbers: of those, the first
// after a pattern is on the projector is taken.
#define _GNU_SOURCE
#include <errno.h>
#include <fcntl.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>
#include <unistd.h>
#include "rules.h"

// The shot of this number, if it is due now.
const FfpStudioShot *ffp_studio_due(const FfpStudio *studio, const char *name, int number, FfpStudioSet *set,
                                    char *said) {
    const char *active = ffp_studio_setting(studio, "active", "");
    if (strcmp(active, name) != 0 || !ffp_studio_set(studio, name, set)) {
        ffp_studio_say(said, "%s is not being photographed", name);
        return NULL;
    }
    const int next = ffp_studio_next(set);
    if (next >= 0 && set->shots[next].number == number) return &set->shots[next];
    ffp_studio_say(said, "number %d of %s is not due: another window may have gone on", number, name);
    return NULL;
}

// All photographs of a studio have one size: another means that the camera or its settings are others now.
static bool check_size(FfpStudio *studio, int width, int height, char *said) {
    const long long w = ffp_studio_number(studio, "photograph", 0, 0),
                    h = ffp_studio_number(studio, "photograph", 1, 0);
    if (w == width && h == height) return true;
    if (w > 0 && ffp_studio_photographed(studio))
        return ffp_studio_say(said,
                              "the photograph has %d x %d pixels, those before it %lld x %lld: the camera "
                              "must stay as it was",
                              width, height, w, h);
    json_object_set_new(studio->settings, "photograph", json_pack("[ii]", width, height));
    return ffp_studio_save(studio, said);
}

bool ffp_studio_store(FfpStudio *studio, const char *name, int number, const void *bytes, size_t size,
                      char said[FFP_STUDIO_SAID]) {
    FfpStudioSet set;
    char path[FFP_STUDIO_NAME + 16];
    int width, height;
    const char *ending;
    const FfpStudioShot *shot = ffp_studio_due(studio, name, number, &set, said);
    if (!shot) return false;
    if (!ffp_studio_picture(bytes, size, &width, &height, &ending))
        return ffp_studio_say(said, "this is not a whole PNG or JPEG picture");
    if (!check_size(studio, width, height, said)) return false;
    snprintf(path, sizeof path, "%s/%03d.%s", name, shot->number, ending);
    if (!ffp_studio_write(studio, path, bytes, size))
        return ffp_studio_say(said, "%s cannot be written: %s", path, strerror(errno));
    studio->notice[0] = 0;
    studio->shown = -1;
    if (set.done + 1 == set.count) {
        json_object_del(studio->settings, "active");
        if (!ffp_studio_save(studio, said)) return false;
    }
    ffp_studio_changed(studio);
    return true;
}

// --- A folder that a camera fills. ---

bool ffp_studio_show(FfpStudio *studio, const char *name, int number, char said[FFP_STUDIO_SAID]) {
    FfpStudioSet set;
    if (!ffp_studio_due(studio, name, number, &set, said)) return false;
    studio->shown = number;
    ffp_studio_changed(studio);
    return true;
}

// Raw files beside JPEG ones, and what a camera's program writes besides, are left where they are.
static bool is_photograph(const char *file) {
    const char *dot = strrchr(file, '.');
    return file[0] != '.' && dot &&
           (strcasecmp(dot, ".png") == 0 || strcasecmp(dot, ".jpg") == 0 || strcasecmp(dot, ".jpeg") == 0);
}

static void leave_file(FfpStudio *studio, const char *file, const char *why) {
    snprintf(studio->notice, sizeof studio->notice, "%.120s: %.250s", file, why);
    ffp_studio_changed(studio);
}

void ffp_studio_arrived(FfpStudio *studio, const char *folder, const char *file) {
    char path[8192], *bytes;
    size_t size;
    FfpStudioSet set;
    const char *active = ffp_studio_setting(studio, "active", NULL);
    const int next = active && ffp_studio_set(studio, active, &set) ? ffp_studio_next(&set) : -1;
    if (next < 0 || !is_photograph(file)) return;
    if (set.shots[next].number != studio->shown) {
        leave_file(studio, file, "left where it is, since it came before the next pattern was shown");
        return;
    }
    snprintf(path, sizeof path, "%s/%s", folder, file);
    const int from = open(path, O_RDONLY | O_CLOEXEC | O_NONBLOCK);
    if (from < 0) return;
    bytes = ffp_studio_read_whole(from, &size);
    close(from);
    char said[FFP_STUDIO_SAID] = "it cannot be read";
    if (!bytes || !ffp_studio_store(studio, set.name, set.shots[next].number, bytes, size, said))
        leave_file(studio, file, said);
    free(bytes);
}
