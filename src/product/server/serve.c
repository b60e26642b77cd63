// The server: who may speak to it, and what is answered. Everything is refused that does not come from this
// machine, from the page itself and with the key that its address holds.
#define _GNU_SOURCE
#include <arpa/inet.h>
#include <errno.h>
#include <fcntl.h>
#include <microhttpd.h>
#include <poll.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>
#include <sys/signalfd.h>
#include <sys/stat.h>
#include <time.h>
#include <unistd.h>
#include "product/studio/disk.h"
#include "work.h"

#define BODY_MOST ((size_t)1 << 26)              // bytes of a photograph
#define REQUEST_MOST ((size_t)1 << 16)           // of any other body
#define UPLOADS_MOST ((size_t)1 << 27)           // of all bodies that are on their way
enum { CONNECTIONS_MOST = 2000, PATIENCE = 15 }; // seconds
enum {
    WAITING_MOST = 32,
    WAIT = 10000
}; // ms after which pages that wait for control are told that there is none

// Permissions of the page to load and run things; the viewer, a page of its own, sits in a frame.
static const char policy[] = "default-src 'none'; script-src 'unsafe-inline'; style-src 'unsafe-inline'; "
                             "img-src 'self' blob: data:; media-src blob: mediastream:; connect-src 'self'; "
                             "frame-src 'self'; frame-ancestors 'none'; base-uri 'none'; form-action 'none'";

typedef struct Request {
    char *body;
    size_t size, room, most;
    bool refused, waited;
} Request;

typedef struct Service {
    FfpStudioServer *server;
    size_t uploading;                             // bytes; the server's one thread alone counts them
    struct MHD_Connection *waiting[WAITING_MOST]; // for control from outside; with the lock
    int n_waiting;
} Service;

// --- Answers. ---

static enum MHD_Result answer(struct MHD_Connection *connection, unsigned status,
                              struct MHD_Response *response, const char *type) {
    if (!response) return MHD_NO;
    MHD_add_response_header(response, "Content-Type", type);
    MHD_add_response_header(response, "Cache-Control", "no-store");
    MHD_add_response_header(response, "X-Content-Type-Options", "nosniff");
    MHD_add_response_header(response, "Referrer-Policy", "no-referrer");
    MHD_add_response_header(response, "Cross-Origin-Resource-Policy", "same-origin");
    MHD_add_response_header(response, "Cross-Origin-Opener-Policy", "same-origin");
    const enum MHD_Result result = MHD_queue_response(connection, status, response);
    MHD_destroy_response(response);
    return result;
}

static enum MHD_Result answer_text(struct MHD_Connection *connection, unsigned status, const char *text) {
    return answer(connection, status,
                  MHD_create_response_from_buffer(strlen(text), (void *)text, MHD_RESPMEM_MUST_COPY),
                  "text/plain; charset=utf-8");
}

static enum MHD_Result answer_json(struct MHD_Connection *connection, unsigned status, json_t *value) {
    char *text = value ? json_dumps(value, JSON_COMPACT) : NULL;
    json_decref(value);
    if (!text) return answer_text(connection, MHD_HTTP_INTERNAL_SERVER_ERROR, "no memory");
    return answer(connection, status,
                  MHD_create_response_from_buffer(strlen(text), text, MHD_RESPMEM_MUST_FREE),
                  "application/json");
}

static enum MHD_Result answer_page(struct MHD_Connection *connection, const unsigned char *page,
                                   size_t size) {
    struct MHD_Response *response =
        MHD_create_response_from_buffer(size, (void *)page, MHD_RESPMEM_PERSISTENT);
    if (response) MHD_add_response_header(response, "Content-Security-Policy", policy);
    return answer(connection, MHD_HTTP_OK, response, "text/html; charset=utf-8");
}

// --- Who may speak. ---

static const char *header(struct MHD_Connection *connection, const char *name) {
    return MHD_lookup_connection_value(connection, MHD_HEADER_KIND, name);
}

// "127.0.0.1:PORT" or "localhost:PORT"; `before` stands before it.
static bool is_here(const FfpStudioServer *server, const char *text, const char *before) {
    char here[64];
    const char *const names[] = {"127.0.0.1", "localhost"};
    for (int i = 0; text && i < 2; i++) {
        snprintf(here, sizeof here, "%s%s:%d", before, names[i], server->port);
        if (strcasecmp(text, here) == 0) return true;
    }
    return false;
}

// The rest of a path behind the key, in a time that does not tell how much of it was right; NULL: another.
static const char *behind_key(const FfpStudioServer *server, const char *url) {
    const size_t length = sizeof server->token - 1;
    unsigned differs = 0;
    if (strlen(url) < length + 2) return NULL;
    for (size_t i = 0; i < length; i++)
        differs |= (unsigned char)url[i + 1] ^ (unsigned char)server->token[i];
    return differs == 0 && url[0] == '/' && url[length + 1] == '/' ? url + length + 2 : NULL;
}

// The fault of a request; NULL: none.
static const char *refusal(const FfpStudioServer *server, struct MHD_Connection *connection, const char *url,
                           bool changes) {
    const char *origin = header(connection, "Origin"), *site = header(connection, "Sec-Fetch-Site");
    if (!is_here(server, header(connection, "Host"), "")) return "this is not the address of the studio";
    if (origin && !is_here(server, origin, "http://")) return "another page may not ask the studio";
    if (changes && !origin) return "a request that changes something must say where it comes from";
    if (site && strcmp(site, "same-origin") != 0 && strcmp(site, "none") != 0)
        return "another site may not ask the studio";
    return behind_key(server, url) ? NULL : "the address lacks its key: open the one that the studio printed";
}

// --- Files of the folder. ---

static const char *type_of(const char *path) {
    static const char *const types[][2] = {{".png", "image/png"},
                                           {".jpg", "image/jpeg"},
                                           {".json", "application/json"},
                                           {".txt", "text/plain; charset=utf-8"},
                                           {".ply", "application/octet-stream"},
                                           {".xml", "text/plain; charset=utf-8"},
                                           {".svg", "image/svg+xml"},
                                           {".pdf", "application/pdf"},
                                           {".html", "text/html; charset=utf-8"}};
    const char *dot = strrchr(path, '.');
    for (size_t i = 0; dot && i < sizeof types / sizeof *types; i++)
        if (strcmp(dot, types[i][0]) == 0) return types[i][1];
    return NULL;
}

// Pages run scripts: those that the program wrote, and no others.
static bool is_own_page(const char *path) {
    const char *last = strrchr(path, '/');
    return strcmp(path, "calibration/report.html") == 0 ||
           (strncmp(path, "objects/", 8) == 0 && last &&
            (strcmp(last, "/view.html") == 0 || strcmp(last, "/report.html") == 0));
}

static enum MHD_Result answer_file(FfpStudioServer *server, struct MHD_Connection *connection,
                                   const char *path) {
    struct stat about;
    const char *type = ffp_studio_path(path) ? type_of(path) : NULL;
    if (!type || (strcmp(type_of(path), "text/html; charset=utf-8") == 0 && !is_own_page(path)))
        return answer_text(connection, MHD_HTTP_NOT_FOUND, "there is no such file");
    const int file = ffp_studio_open(&server->studio, path);
    if (file < 0 || fstat(file, &about) != 0 || !S_ISREG(about.st_mode)) {
        if (file >= 0) close(file);
        return answer_text(connection, MHD_HTTP_NOT_FOUND, "there is no such file");
    }
    struct MHD_Response *response = MHD_create_response_from_fd((uint64_t)about.st_size, file);
    if (!response) close(file);
    // a picture that is a page (SVG) may run nothing; our own pages name what they may do themselves
    if (response && strncmp(type, "text/html", 9) != 0)
        MHD_add_response_header(response, "Content-Security-Policy",
                                "default-src 'none'; style-src 'unsafe-inline'");
    return answer(connection, MHD_HTTP_OK, response, type);
}

// --- Control from outside. ---

// Answers as soon as there are messages; until then the connection sleeps.
static enum MHD_Result answer_control(Service *service, struct MHD_Connection *connection, Request *request) {
    FfpStudioServer *server = service->server;
    const char *known = MHD_lookup_connection_value(connection, MHD_GET_ARGUMENT_KIND, "known");
    const uint64_t number = known ? strtoull(known, NULL, 10) : UINT64_MAX;
    pthread_mutex_lock(&server->lock);
    const bool sleeps = known && number == server->controlled && server->osc >= 0 && !request->waited &&
                        !server->studio.closing && service->n_waiting < WAITING_MOST;
    json_t *events = sleeps ? NULL : ffp_server_controls(server, number);
    if (sleeps) {
        request->waited = true;
        MHD_suspend_connection(connection);
        service->waiting[service->n_waiting++] = connection;
    }
    pthread_mutex_unlock(&server->lock);
    return sleeps ? MHD_YES : answer_json(connection, MHD_HTTP_OK, events);
}

// With the lock.
static void wake(Service *service) {
    for (int i = 0; i < service->n_waiting; i++) MHD_resume_connection(service->waiting[i]);
    service->n_waiting = 0;
}

// --- Requests. ---

static enum MHD_Result answer_get(Service *service, struct MHD_Connection *connection, const char *path,
                                  Request *request) {
    FfpStudioServer *server = service->server;
    if (!*path) return answer_page(connection, ffp_page_studio, ffp_page_studio_size);
    if (strcmp(path, "projector") == 0)
        return answer_page(connection, ffp_page_projector, ffp_page_projector_size);
    if (strncmp(path, "file/", 5) == 0) return answer_file(server, connection, path + 5);
    if (strcmp(path, "control") == 0) return answer_control(service, connection, request);
    if (strcmp(path, "state") != 0)
        return answer_text(connection, MHD_HTTP_NOT_FOUND, "there is no such page");
    const char *known = MHD_lookup_connection_value(connection, MHD_GET_ARGUMENT_KIND, "known");
    pthread_mutex_lock(&server->lock);
    if (!known) ffp_studio_changed(&server->studio); // a page that begins
    const bool same = known && strtoull(known, NULL, 10) == server->studio.version;
    json_t *state = same ? json_object() : ffp_studio_state(&server->studio);
    pthread_mutex_unlock(&server->lock);
    return answer_json(connection, MHD_HTTP_OK, state);
}

static enum MHD_Result answer_post(FfpStudioServer *server, struct MHD_Connection *connection,
                                   const char *path, const Request *request) {
    const enum MHD_ValueKind where = MHD_GET_ARGUMENT_KIND;
    const FfpStudioRequest asked = {.path = path,
                                    .set = MHD_lookup_connection_value(connection, where, "set"),
                                    .number = MHD_lookup_connection_value(connection, where, "number"),
                                    .watch = MHD_lookup_connection_value(connection, where, "watch"),
                                    .body = request->body ? request->body : "",
                                    .size = request->size};
    bool ok;
    pthread_mutex_lock(&server->lock);
    json_t *state = ffp_studio_answer(&server->studio, &asked, &ok);
    pthread_mutex_unlock(&server->lock);
    return answer_json(connection, ok ? MHD_HTTP_OK : MHD_HTTP_CONFLICT, state);
}

// More of a body; false: it is too long, or too much is on its way.
static bool take_in(Service *service, Request *request, const char *bytes, size_t size) {
    if (size > request->most - request->size) return false;
    if (request->size + size > request->room) {
        size_t room = request->room > 0 ? 2 * request->room : 1 << 16;
        while (room < request->size + size) room *= 2;
        if (service->uploading - request->room + room > UPLOADS_MOST) return false;
        char *body = realloc(request->body, room);
        if (!body) return false;
        service->uploading += room - request->room;
        request->body = body, request->room = room;
    }
    memcpy(request->body + request->size, bytes, size);
    request->size += size;
    return true;
}

// The head of a request: what can be refused is refused before its body comes.
static enum MHD_Result begin(Service *service, struct MHD_Connection *connection, const char *url,
                             const char *method, void **mine) {
    const bool get = strcmp(method, "GET") == 0, post = strcmp(method, "POST") == 0;
    if (!get && !post) return answer_text(connection, MHD_HTTP_METHOD_NOT_ALLOWED, "GET or POST");
    const char *wrong = refusal(service->server, connection, url, post);
    if (wrong) return answer_text(connection, MHD_HTTP_FORBIDDEN, wrong);
    const char *path = behind_key(service->server, url), *length = header(connection, "Content-Length");
    const bool picture = strcmp(path, "photograph") == 0 || strcmp(path, "own") == 0;
    if (post && !picture && strcmp(path, "do") != 0)
        return answer_text(connection, MHD_HTTP_NOT_FOUND, "there is no such page");
    const size_t most = get ? 0 : picture ? BODY_MOST : REQUEST_MOST;
    if (length && strtoull(length, NULL, 10) > most)
        return answer_text(connection, MHD_HTTP_CONTENT_TOO_LARGE, "the body is too long");
    Request *request = calloc(1, sizeof *request);
    if (!request) return MHD_NO;
    request->most = most;
    *mine = request;
    return MHD_YES;
}

static enum MHD_Result handle(void *argument, struct MHD_Connection *connection, const char *url,
                              const char *method, const char *version, const char *bytes, size_t *size,
                              void **mine) {
    Service *service = argument;
    Request *request = *mine;
    (void)version;
    if (!request) return begin(service, connection, url, method, mine);
    if (*size > 0) {
        if (!request->refused && !take_in(service, request, bytes, *size)) request->refused = true;
        *size = 0;
        return request->refused ? MHD_NO : MHD_YES; // closes the connection
    }
    const char *path = behind_key(service->server, url);
    return strcmp(method, "GET") == 0 ? answer_get(service, connection, path, request)
                                      : answer_post(service->server, connection, path, request);
}

static void completed(void *argument, struct MHD_Connection *connection, void **mine,
                      enum MHD_RequestTerminationCode code) {
    Service *service = argument;
    Request *request = *mine;
    (void)connection, (void)code;
    if (!request) return;
    service->uploading -= request->room;
    free(request->body);
    free(request);
    *mine = NULL;
}

// --- The server at work. ---

// Names in the folder need no escapes, so none is read: %2e stays what it is, and is refused.
static size_t keep_escapes(void *argument, struct MHD_Connection *connection, char *text) {
    (void)argument, (void)connection;
    return strlen(text);
}

// One descriptor for each connection, and one for the file that it is sent.
static void raise_limit(void) {
    struct rlimit limit;
    if (getrlimit(RLIMIT_NOFILE, &limit) != 0) return;
    const rlim_t wanted = 2 * CONNECTIONS_MOST + 100;
    if (limit.rlim_cur >= wanted) return;
    limit.rlim_cur = limit.rlim_max == RLIM_INFINITY || limit.rlim_max > wanted ? wanted : limit.rlim_max;
    setrlimit(RLIMIT_NOFILE, &limit);
}

// A socket on the loopback address alone; port 0 becomes one that is free. -1: errno.
static int listen_here(int *port) {
    struct sockaddr_in here = {.sin_family = AF_INET, .sin_port = htons((uint16_t)*port)};
    socklen_t size = sizeof here;
    const int on = 1, file = socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
    here.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    if (file < 0) return -1;
    setsockopt(file, SOL_SOCKET, SO_REUSEADDR, &on, sizeof on);
    if (bind(file, (struct sockaddr *)&here, size) != 0 || listen(file, SOMAXCONN) != 0 ||
        getsockname(file, (struct sockaddr *)&here, &size) != 0) {
        const int why = errno;
        close(file);
        errno = why;
        return -1;
    }
    *port = ntohs(here.sin_port);
    return file;
}

// On the port that was asked for, or that of last time, if it is free: browsers keep a show by the page's
// address.
static int listen_again(FfpStudioServer *server) {
    char said[FFP_STUDIO_SAID];
    const long long kept = ffp_studio_number(&server->studio, "port", -1, 0);
    const bool any = server->port == 0;
    if (any && kept > 0 && kept <= UINT16_MAX) server->port = (int)kept;
    int listening = listen_here(&server->port);
    if (listening < 0 && any) server->port = 0, listening = listen_here(&server->port);
    if (listening >= 0 && server->port != kept) {
        json_object_set_new(server->studio.settings, "port", json_integer(server->port));
        ffp_studio_save(&server->studio, said); // or next time has another
    }
    return listening;
}

static struct MHD_Daemon *start(Service *service, int listening) {
    return MHD_start_daemon(MHD_USE_INTERNAL_POLLING_THREAD | MHD_USE_EPOLL | MHD_ALLOW_SUSPEND_RESUME, 0,
                            NULL, NULL, handle, service, MHD_OPTION_LISTEN_SOCKET, listening,
                            MHD_OPTION_CONNECTION_LIMIT, (unsigned)CONNECTIONS_MOST,
                            MHD_OPTION_CONNECTION_TIMEOUT, (unsigned)PATIENCE, MHD_OPTION_NOTIFY_COMPLETED,
                            completed, service, MHD_OPTION_UNESCAPE_CALLBACK, keep_escapes, NULL,
                            MHD_OPTION_CONNECTION_MEMORY_LIMIT, (size_t)1 << 15, MHD_OPTION_END);
}

// Without a browser to be found nothing is opened: the address is printed anyway.
static void open_browser(const char *address) {
    const pid_t child = fork();
    if (child != 0) return;
    sigset_t none;
    sigemptyset(&none);
    sigprocmask(SIG_SETMASK, &none, NULL);
    const int nothing = open("/dev/null", O_RDWR);
    if (nothing >= 0) dup2(nothing, 0), dup2(nothing, 1), dup2(nothing, 2);
    execlp("xdg-open", "xdg-open", address, (char *)NULL);
    _exit(127);
}

static int64_t milliseconds(void) {
    struct timespec time = {0};
    clock_gettime(CLOCK_MONOTONIC, &time);
    return (int64_t)time.tv_sec * 1000 + time.tv_nsec / 1000000;
}

// Until SIGINT or SIGTERM comes.
static void wait_for_the_end(Service *service, int signals) {
    FfpStudioServer *server = service->server;
    struct pollfd from[3] = {{.fd = signals, .events = POLLIN},
                             {.fd = server->changes, .events = POLLIN},
                             {.fd = server->osc, .events = POLLIN}};
    for (int64_t over = milliseconds() + WAIT;;) {
        const int64_t left = over - milliseconds();
        if (poll(from, 3, server->osc < 0 ? -1 : left > 0 ? (int)left : 0) < 0 && errno != EINTR) return;
        struct signalfd_siginfo which; // read, or it would come again at the end
        if (from[0].revents) return (void)!read(signals, &which, sizeof which);
        pthread_mutex_lock(&server->lock);
        if (from[1].revents) ffp_server_arrived(server);
        if (from[2].revents) ffp_server_controlled(server);
        if (from[2].revents || milliseconds() >= over) // messages have come, or the wait is over
            wake(service), over = milliseconds() + WAIT;
        pthread_mutex_unlock(&server->lock);
    }
}

bool ffp_server_serve(FfpStudioServer *server, bool opens, char said[FFP_STUDIO_SAID]) {
    sigset_t ends, before;
    Service service = {.server = server};
    char address[128];
    sigemptyset(&ends), sigaddset(&ends, SIGINT), sigaddset(&ends, SIGTERM);
    pthread_sigmask(SIG_BLOCK, &ends, &before);         // the server's threads inherit it
    signal(SIGPIPE, SIG_IGN), signal(SIGXFSZ, SIG_IGN); // they are errors where they happen
    raise_limit();
    const int signals = signalfd(-1, &ends, SFD_CLOEXEC);
    const int listening = listen_again(server); // the port is known before the first request comes
    struct MHD_Daemon *daemon = signals >= 0 && listening >= 0 ? start(&service, listening) : NULL;
    if (daemon) {
        snprintf(address, sizeof address, "http://127.0.0.1:%d/%s/", server->port, server->token);
        printf("%s: open %s (Ctrl-C ends the studio)\n", server->studio.folder, address);
        if (server->osc >= 0) printf("OSC messages over UDP: %s\n", server->heard);
        fflush(stdout);
        if (opens) open_browser(address);
        wait_for_the_end(&service, signals);
    } else {
        ffp_studio_say(said, "port %d of this machine cannot be served: %s", server->port, strerror(errno));
    }
    pthread_mutex_lock(&server->lock);
    server->studio.closing = true;
    wake(&service);
    pthread_mutex_unlock(&server->lock);
    if (daemon)
        MHD_stop_daemon(daemon); // closes the socket, too
    else if (listening >= 0)
        close(listening);
    ffp_server_end_jobs(server);
    if (signals >= 0) close(signals);
    pthread_sigmask(SIG_SETMASK, &before, NULL);
    return daemon != NULL;
}
