// Common declarations of this room's files.
#ifndef FFP_SERVER_WORK_H
#define FFP_SERVER_WORK_H

#include <pthread.h>
#include <sys/types.h>
#include "product/studio/studio.h"

enum { FFP_STUDIO_JOBS = 3 };

typedef struct FfpStudioProcess {
    FfpStudioJob *job;
    pid_t process; // 0: none
    bool joinable;
    pthread_t thread;
} FfpStudioProcess;

// The studio on this machine. Its lock is held by whoever calls a rule, or changes what a rule reads.
typedef struct FfpStudioServer {
    FfpStudio studio; // the first: a rule's studio is its server
    pthread_mutex_t lock;
    int lock_file;
    int changes, watch; // inotify, and the folder that it looks at; -1: none
    char token[33];
    int port;
    FfpStudioProcess processes[FFP_STUDIO_JOBS];
    int osc;               // the socket of control from outside; -1: none
    char heard[80];        // its address and port
    json_t *controls;      // the last messages
    uint64_t controlled;   // number of all that came
    uint64_t passed_over;  // messages that could not be read
    char passed_last[128]; // the address of the last of them
} FfpStudioServer;

// --- Processes (process.c). ---

bool ffp_server_run(FfpStudio *studio, FfpStudioJob *job);
void ffp_server_stop(FfpStudio *studio, FfpStudioJob *job);
void ffp_server_end_jobs(FfpStudioServer *server); // and waits for them; without the lock

// --- A folder that a camera fills (arrivals.c), with the lock. ---

bool ffp_server_watch(FfpStudio *studio, const char *folder, char said[FFP_STUDIO_SAID]);
void ffp_server_arrived(FfpStudioServer *server); // when `changes` can be read

// --- Control from outside (control.c), with the lock. ---

enum { FFP_STUDIO_CONTROLS = 1024 }; // messages that are kept

// Listens for OSC messages over UDP at "[ADDRESS:]PORT"; without an address on this machine's loopback one.
bool ffp_server_listen(FfpStudioServer *server, const char *where, char said[FFP_STUDIO_SAID]);
// Takes the packets that have come. A message that cannot be read is counted and passed over alone.
void ffp_server_controlled(FfpStudioServer *server);
// {"osc": "127.0.0.1:9000" or null, "number": of all that came, "events": [{"address", "values", "number"}]
// after `known`, "passed_over": messages that could not be read, "passed_last": the last one's address}.
json_t *ffp_server_controls(const FfpStudioServer *server, uint64_t known);

// --- Requests (serve.c). ---

bool ffp_server_serve(FfpStudioServer *server, bool opens, char said[FFP_STUDIO_SAID]);

// The pages, made of view/ (cmake/page.cmake), each ended by a 0.
extern const unsigned char ffp_page_studio[], ffp_page_projector[];
extern const size_t ffp_page_studio_size, ffp_page_projector_size;

#endif
