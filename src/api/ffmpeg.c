#include "api/ffmpeg.h"

#include <errno.h>
#include <fcntl.h>
#include <signal.h>
#include <spawn.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>
#include "base/call.h"
#include "base/file.h"

enum { OPTIONS_MAX = 20 };

extern char **environ;

// Even sides, colours as players expect them of untagged files too.
#define YUV                                                                                                  \
    "pad=ceil(iw/2)*2:ceil(ih/2)*2,scale=out_color_matrix=bt709:out_range=tv,format=yuv420p", "-colorspace", \
        "bt709", "-color_primaries", "bt709", "-color_trc", "bt709", "-color_range", "tv"

static const struct Format {
    const char *ending;
    const char *options[OPTIONS_MAX];
} formats[] = {
    {".gif", {"-vf", "split[a][b];[a]palettegen[p];[b][p]paletteuse", "-loop", "0", "-f", "gif"}},
    {".mp4", {"-vf", YUV, "-crf", "18", "-movflags", "+faststart", "-f", "mp4"}},
    {".webm", {"-vf", YUV, "-b:v", "0", "-crf", "24", "-f", "webm"}},
    {".mkv", {"-vf", YUV, "-crf", "18", "-f", "matroska"}},
};

static const struct Format *find_format(const char *path) {
    const char *dot = strrchr(path, '.');
    for (size_t i = 0; dot && i < sizeof formats / sizeof *formats; i++)
        if (strcasecmp(dot, formats[i].ending) == 0) return &formats[i];
    return NULL;
}

bool ffp_ffmpeg_makes(const char *path) {
    return find_format(path) != NULL;
}

bool ffp_ffmpeg_is_there(void) {
    const char *folders = getenv("PATH");
    char path[FFP_PATH_MAX];
    for (const char *at = folders; at && *at;) {
        const int length = (int)strcspn(at, ":");
        const int written = snprintf(path, sizeof path, "%.*s/ffmpeg", length, length ? at : ".");
        if (written > 0 && written < (int)sizeof path && ffp_is_file(path) && access(path, X_OK) == 0)
            return true;
        at += length + (at[length] == ':');
    }
    return false;
}

// Runs it with the socket as its input. A group of its own: Ctrl-C is for us, who then end it.
static int spawn(FfpFfmpeg *ffmpeg, int input, char *const arguments[]) {
    posix_spawn_file_actions_t files;
    posix_spawnattr_t attributes;
    int failed = posix_spawn_file_actions_init(&files);
    if (failed) return failed;
    failed = posix_spawnattr_init(&attributes);
    if (failed) {
        posix_spawn_file_actions_destroy(&files);
        return failed;
    }
    posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETPGROUP);
    failed = posix_spawn_file_actions_adddup2(&files, input, 0);
    if (!failed) failed = posix_spawn_file_actions_addopen(&files, 1, "/dev/null", O_WRONLY, 0);
    if (!failed) failed = posix_spawn_file_actions_adddup2(&files, fileno(ffmpeg->said), 2);
    if (!failed) failed = posix_spawnp(&ffmpeg->pid, arguments[0], &files, &attributes, arguments, environ);
    posix_spawnattr_destroy(&attributes);
    posix_spawn_file_actions_destroy(&files);
    if (failed) ffmpeg->pid = 0;
    return failed;
}

// A socket in place of a pipe: writing to one whose reader is gone can be told not to raise a signal.
static bool start(FfpFfmpeg *ffmpeg, char *const arguments[], const char *path, FfpError *err) {
    int ends[2];
    ffmpeg->said = tmpfile();
    if (!ffmpeg->said || socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, ends) != 0) {
        ffp_fail(err, FFP_ERROR_IO, path, "cannot start ffmpeg: %s", strerror(errno));
        if (ffmpeg->said) fclose(ffmpeg->said);
        return false;
    }
    const int failed = spawn(ffmpeg, ends[1], arguments);
    close(ends[1]);
    ffmpeg->frames = ends[0];
    if (!failed) return true;
    close(ends[0]);
    fclose(ffmpeg->said);
    return ffp_fail(err, FFP_ERROR_IO, path, "cannot start ffmpeg: %s", strerror(failed));
}

// Its exit status as waitpid gives it, -1 when nobody knows.
static int end(FfpFfmpeg *ffmpeg) {
    int status = -1;
    close(ffmpeg->frames);
    while (waitpid(ffmpeg->pid, &status, 0) < 0)
        if (errno != EINTR) break;
    ffmpeg->pid = 0;
    return status;
}

static void stop(void *thing) {
    FfpFfmpeg *ffmpeg = thing;
    kill(ffmpeg->pid, SIGKILL);
    end(ffmpeg);
    fclose(ffmpeg->said);
    ffp_free(ffmpeg);
}

bool ffp_ffmpeg_start(FfpFfmpeg **ffmpeg, const char *path, const char *file, int width, int height, int rate,
                      FfpError *err) {
    const struct Format *format = find_format(path);
    char size[32], speed[16], output[2 * FFP_PATH_MAX];
    const char *arguments[OPTIONS_MAX + 24] = {"ffmpeg", "-hide_banner", "-loglevel", "error", "-nostdin",
                                               "-f",     "rawvideo",     "-pix_fmt",  "rgb24", "-s",
                                               size,     "-r",           speed,       "-i",    "pipe:0"};
    int n = 15;
    *ffmpeg = ffp_alloc(1, sizeof **ffmpeg);
    snprintf(size, sizeof size, "%dx%d", width, height);
    snprintf(speed, sizeof speed, "%d", rate);
    snprintf(output, sizeof output, "file:%s", file);
    for (int i = 0; format->options[i]; i++) arguments[n++] = format->options[i];
    arguments[n++] = "-y", arguments[n++] = output;
    if (start(*ffmpeg, (char *const *)arguments, path, err)) {
        ffp_own(*ffmpeg, stop);
        return true;
    }
    ffp_free(*ffmpeg);
    *ffmpeg = NULL;
    return false;
}

bool ffp_ffmpeg_write(FfpFfmpeg *ffmpeg, const unsigned char *bytes, size_t size) {
    for (size_t done = 0; done < size;) {
        const ssize_t sent = send(ffmpeg->frames, bytes + done, size - done, MSG_NOSIGNAL);
        if (sent < 0 && errno != EINTR) return false;
        if (sent > 0) done += (size_t)sent;
    }
    return true;
}

bool ffp_ffmpeg_finish(FfpFfmpeg **running, const char *path, FfpError *err) {
    char line[256], last[256] = "it does not say why";
    FfpFfmpeg *ffmpeg = *running;
    ffp_disown(ffmpeg);
    *running = NULL;
    const int status = end(ffmpeg);
    rewind(ffmpeg->said);
    while (fgets(line, sizeof line, ffmpeg->said)) {
        line[strcspn(line, "\r\n")] = 0;
        if (*line) memcpy(last, line, sizeof last);
    }
    fclose(ffmpeg->said);
    ffp_free(ffmpeg);
    if (WIFEXITED(status) && WEXITSTATUS(status) == 0) return true;
    return ffp_fail(err, FFP_ERROR_IO, path, "ffmpeg failed: %s", last);
}

void ffp_ffmpeg_kill(FfpFfmpeg **ffmpeg) {
    ffp_disown(*ffmpeg);
    if (*ffmpeg) stop(*ffmpeg);
    *ffmpeg = NULL;
}
