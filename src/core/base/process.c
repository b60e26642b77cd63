#include "core/base/process.h"
#include <errno.h>
#include <fcntl.h>
#include <signal.h>
#include <spawn.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>
#include "core/base/call.h"
#include "core/base/file.h"

extern char **environ;

struct FfpProcess {
    pid_t pid;
    int data;   // our end
    FILE *said; // what it says on stderr
};

bool ffp_program_exists(const char *name) {
    char path[FFP_PATH_MAX];
    for (const char *at = getenv("PATH"); at && *at;) {
        const int length = (int)strcspn(at, ":");
        const int written =
            snprintf(path, sizeof path, "%.*s/%s", length ? length : 1, length ? at : ".", name);
        if (written > 0 && written < (int)sizeof path && ffp_is_file(path) && access(path, X_OK) == 0)
            return true;
        at += length + (at[length] == ':');
    }
    return false;
}

static int set_files(posix_spawn_file_actions_t *files, int data, FfpProcessEnd end, int said) {
    const int other = end == FFP_PROCESS_STDIN ? 1 : 0;
    int failed = posix_spawn_file_actions_adddup2(files, data, 1 - other);
    if (!failed)
        failed = posix_spawn_file_actions_addopen(files, other, "/dev/null", other ? O_WRONLY : O_RDONLY, 0);
    return failed ? failed : posix_spawn_file_actions_adddup2(files, said, 2);
}

// Runs it with `data` as its end.
static int spawn(FfpProcess *process, int data, FfpProcessEnd end, char *const arguments[]) {
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
    failed = set_files(&files, data, end, fileno(process->said));
    if (!failed) failed = posix_spawnp(&process->pid, arguments[0], &files, &attributes, arguments, environ);
    posix_spawnattr_destroy(&attributes);
    posix_spawn_file_actions_destroy(&files);
    return failed;
}

// A socket in place of a pipe: writing to one whose reader is gone can be told not to raise a signal.
static int start(FfpProcess *process, FfpProcessEnd end, char *const arguments[]) {
    int ends[2];
    process->said = tmpfile();
    if (!process->said) return errno;
    int failed = socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, ends) != 0 ? errno : 0;
    if (!failed) {
        failed = spawn(process, ends[1], end, arguments);
        close(ends[1]);
        process->data = ends[0];
        if (failed) close(ends[0]);
    }
    if (failed) fclose(process->said);
    return failed;
}

// Its exit status as waitpid gives it, -1 when nobody knows.
static int wait_for_end(FfpProcess *process) {
    int status = -1;
    close(process->data);
    while (waitpid(process->pid, &status, 0) < 0)
        if (errno != EINTR) break;
    return status;
}

static void stop(void *thing) {
    FfpProcess *process = thing;
    kill(process->pid, SIGKILL);
    wait_for_end(process);
    fclose(process->said);
    ffp_free(process);
}

bool ffp_process_start(FfpProcess **process, const char *const arguments[], FfpProcessEnd end,
                       const char *where, FfpError *err) {
    *process = ffp_alloc(1, sizeof **process);
    const int failed = start(*process, end, (char *const *)arguments);
    if (!failed) {
        ffp_own(*process, stop);
        return true;
    }
    ffp_free(*process);
    *process = NULL;
    return ffp_fail(err, FFP_ERROR_IO, where, "cannot start %s: %s", arguments[0], strerror(failed));
}

bool ffp_process_write(FfpProcess *process, const void *bytes, size_t size) {
    for (size_t done = 0; done < size;) {
        const ssize_t sent = send(process->data, (const char *)bytes + done, size - done, MSG_NOSIGNAL);
        if (sent < 0 && errno != EINTR) return false;
        if (sent > 0) done += (size_t)sent;
    }
    return true;
}

size_t ffp_process_read(FfpProcess *process, void *bytes, size_t size) {
    size_t done = 0;
    while (done < size) {
        const ssize_t got = recv(process->data, (char *)bytes + done, size - done, 0);
        if (got == 0 || (got < 0 && errno != EINTR)) break;
        if (got > 0) done += (size_t)got;
    }
    return done;
}

bool ffp_process_finish(FfpProcess **running, char said[FFP_PROCESS_SAID]) {
    char line[FFP_PROCESS_SAID];
    FfpProcess *process = *running;
    ffp_disown(process);
    *running = NULL;
    const int status = wait_for_end(process);
    said[0] = 0;
    rewind(process->said);
    while (fgets(line, sizeof line, process->said)) {
        line[strcspn(line, "\r\n")] = 0;
        if (*line) memcpy(said, line, sizeof line);
    }
    fclose(process->said);
    ffp_free(process);
    return WIFEXITED(status) && WEXITSTATUS(status) == 0;
}

void ffp_process_kill(FfpProcess **process) {
    ffp_disown(*process);
    if (*process) stop(*process);
    *process = NULL;
}
