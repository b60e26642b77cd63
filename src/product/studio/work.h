// Common declarations of this room's files.
#ifndef FFP_STUDIO_WORK_H
#define FFP_STUDIO_WORK_H

#include <jansson.h>
#include <pthread.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <sys/types.h>

enum {
    FFP_STUDIO_NAME = 160,    // of a path inside the folder, with its 0
    FFP_STUDIO_SAID = 400,    // of a message
    FFP_STUDIO_SHOTS = 256,   // of a set
    FFP_STUDIO_SETS = 256,    // of an object or the calibration
    FFP_STUDIO_WORDS = 128,   // of a command
    FFP_STUDIO_LINES = 6,     // commands of a job
    FFP_STUDIO_LOG = 1 << 15, // what a job wrote last
    FFP_STUDIO_FINDINGS = 500 // of a job
};

// --- Commands and jobs (job.c). ---

typedef struct FfpStudioCommand {
    char *words[FFP_STUDIO_WORDS + 1]; // owned; NULL ends them. The first is "ffprocams"
    int count;
    bool failed; // no room
} FfpStudioCommand;

void ffp_studio_word(FfpStudioCommand *command, const char *format, ...)
    __attribute__((format(printf, 2, 3)));
// As one would type it in the folder; to be freed.
char *ffp_studio_typed(const FfpStudioCommand *command);

typedef enum FfpJobEnd {
    FFP_JOB_NONE,
    FFP_JOB_RUNNING,
    FFP_JOB_DONE,
    FFP_JOB_FAILED,
    FFP_JOB_STOPPED
} FfpJobEnd;

typedef struct FfpStudioJob {
    char name[32]; // "calibrate"; its log is logs/NAME.txt
    FfpStudioCommand commands[FFP_STUDIO_LINES];
    int n_commands, current;
    FfpJobEnd end;
    pid_t process;  // 0: none
    bool stop;      // asked for
    char stage[80]; // of the progress; "" without any
    long long done, total;
    char error[1024]; // why it failed; ""
    json_t *findings; // what its commands found, as ffp_finding_json; they end in logs/NAME.json
    char log[FFP_STUDIO_LOG];
    size_t logged;
    double began, seconds;
    bool joinable;
    pthread_t thread;
} FfpStudioJob;

// --- The studio. ---

typedef struct FfpStudio {
    char folder[4096]; // absolute
    int root;          // the open folder
    int lock_file;
    int changes, watch; // inotify, and the folder that it looks at; -1: none
    char token[33];
    int port;
    pthread_mutex_t lock; // of all that follows
    json_t *settings;     // studio.json
    uint64_t version;     // of what the page is told; grows with every change
    json_t *listed;       // the folder's sets and objects as they are told; NULL: to be looked up again
    char notice[FFP_STUDIO_SAID];
    int shown; // number of the shot whose pattern is on the projector, where a camera fills a folder; -1:
               // none
    FfpStudioJob job, camera, eye; // what the user began; the virtual camera; what looks for the board
    bool closing;
    int osc;             // the socket of control from outside; -1: none
    char heard[80];      // its address and port
    json_t *controls;    // the last messages
    uint64_t controlled; // number of all that came
} FfpStudio;

// A new command of a job, which has its name already; its words follow.
FfpStudioCommand *ffp_studio_command(FfpStudioJob *job, const char *name);
// Begins a job of the commands that it holds already; false if one runs. To be called with the lock.
bool ffp_studio_start(FfpStudio *studio, FfpStudioJob *job, const char *name);
void ffp_studio_stop(FfpStudioJob *job);                    // with the lock; it ends as soon as it can
void ffp_studio_join(FfpStudio *studio, FfpStudioJob *job); // without the lock
void ffp_studio_clear(FfpStudioJob *job);                   // its commands; not while it runs

// --- The folder (disk.c). Paths are inside it; every function refuses others. ---

// Words of letters, digits, '-', '_' and '.' that do not begin with '.', with '/' between.
bool ffp_studio_path(const char *path);
// Opens for reading, following no links; -1: there is none.
int ffp_studio_open(const FfpStudio *studio, const char *path);
char *ffp_studio_read_whole(int file, size_t *size); // to be freed; NULL: it cannot be read
bool ffp_studio_exists(const FfpStudio *studio, const char *path);
bool ffp_studio_make(const FfpStudio *studio, const char *folder); // and those above it
// Whole or not at all, and on disk when it returns true; the folder above it is made. False: errno.
bool ffp_studio_write(const FfpStudio *studio, const char *path, const void *bytes, size_t size);
// Moves it to discarded/NAME-N, NAME being its path with dashes. True if there is nothing.
bool ffp_studio_set_aside(const FfpStudio *studio, const char *path);
// Deletes it, with all in it. True if there is nothing.
bool ffp_studio_remove(const FfpStudio *studio, const char *path);
// Names in a folder in the alphabet's order, at most `most`; each to be freed. 0: none, or no folder.
int ffp_studio_list(const FfpStudio *studio, const char *folder, char **names, int most);
void ffp_studio_free_names(char **names, int count);
json_t *ffp_studio_read_json(const FfpStudio *studio,
                             const char *path); // NULL: none, or none that can be read

// Something beside a job's progress has changed: the page is told, and what is in the folder is looked up
// again. With the lock.
void ffp_studio_changed(FfpStudio *studio);

// --- Sets of photographs (sets.c). ---

typedef struct FfpStudioShot {
    int number;       // of the file: NNN.png
    char pattern[80]; // its picture: patterns/004_gray_x_00.png
    double angle;     // of the table, where has_angle
    bool has_angle;
} FfpStudioShot;

typedef struct FfpStudioSet {
    char name[FFP_STUDIO_NAME]; // its folder: calibration/attitude-03
    char stage[32];             // what `generate --only` calls it
    FfpStudioShot shots[FFP_STUDIO_SHOTS];
    int count, done;
    bool there[FFP_STUDIO_SHOTS];
    char ending[8]; // of its photographs; "" without any
} FfpStudioSet;

// The set of that name as it is on disk; false: there can be none.
bool ffp_studio_set(const FfpStudio *studio, const char *name, FfpStudioSet *set);
// All sets that there are or are to be: of the calibration (object NULL) or of an object.
int ffp_studio_set_names(const FfpStudio *studio, const char *object, char names[][FFP_STUDIO_NAME],
                         int most);
// "004_gray_x_00.png": its number; 0: of the chart to focus by and of any other file.
int ffp_studio_pattern_number(const char *file);
// The pattern that a file is named for, "lollipop_0" of "patterns/003_lollipop_0.png", in `size` bytes; the
// user's own picture: "own".
void ffp_studio_pattern_name(const char *file, char *name, size_t size);
// The rig is calibrated from the codes on each object; its views are called as the folders of its stops.
bool ffp_studio_without_board(const FfpStudio *studio);
// The angle of the stop that a folder of an object is called for, "view-045"; -1: none.
double ffp_studio_stop_angle(const json_t *object, const char *folder);

// The entry of objects/NAME/now in studio.json; false: none, or none of this object.
#define FFP_STUDIO_VIEW "view-" // before the angle in the name of a stop's folder, as `generate` calls it
enum { FFP_STUDIO_OWN = 999 };  // number of the photograph under a picture of the user's
#define FFP_STUDIO_OWNED "objects/%.60s/own.png"    // that picture
#define FFP_STUDIO_WATCHED "objects/%.60s/show.png" // in its place while a show is watched: the show's
typedef struct FfpStudioTrial {
    const char *object, *view, *pattern; // "view-045"; a file of patterns/, or "own"
    int turned;                          // degrees by which the simulated turntable is off
    bool is_own, watch; // watch: photographed while a show goes on, under its own picture alone
    char name[80], file[FFP_STUDIO_NAME]; // of the pattern: what `import` calls it, and its picture
} FfpStudioTrial;
bool ffp_studio_read_trial(const FfpStudio *studio, const char *object, FfpStudioTrial *t);

int ffp_studio_next(const FfpStudioSet *set);          // index of the first missing shot; -1: complete
bool ffp_studio_photographed(const FfpStudio *studio); // anything at all
const char *ffp_studio_setting(const FfpStudio *studio, const char *name, const char *otherwise);
long long ffp_studio_number(const FfpStudio *studio, const char *name, int index, long long otherwise);
json_t *ffp_studio_object(const FfpStudio *studio, const char *name); // borrowed; NULL: none of that name

// --- Pictures that come from outside (picture.c). ---

// Size and format of a PNG or JPEG; false: neither, or not whole. ending: "png" or "jpg".
bool ffp_studio_picture(const unsigned char *bytes, size_t size, int *width, int *height,
                        const char **ending);

// --- What the page is told, and what it asks for (state.c, verbs.c, shoot.c, steps.c); all with the lock.
// ---

bool ffp_studio_load(FfpStudio *studio, bool virtual_rig, char said[FFP_STUDIO_SAID]);
bool ffp_studio_save(FfpStudio *studio, char said[FFP_STUDIO_SAID]);
json_t *ffp_studio_state(FfpStudio *studio);
// {"verb": ...}; false: why not.
bool ffp_studio_do(FfpStudio *studio, const json_t *request, char said[FFP_STUDIO_SAID]);
// `import` with all that holds for every capture of an object, but for its photographs and its folder.
FfpStudioCommand *ffp_studio_import(const FfpStudio *studio, FfpStudioJob *job, const char *object);
// The commands of a step ("patterns", "calibrate", "make", "evaluate") into the job;
// false: what it lacks.
bool ffp_studio_step(FfpStudio *studio, const char *step, FfpStudioJob *job, char said[FFP_STUDIO_SAID]);
// A photograph for the shot that is due; it is on disk when this is true.
bool ffp_studio_store(FfpStudio *studio, const char *set, int number, const void *bytes, size_t size,
                      char said[FFP_STUDIO_SAID]);
// The shot of this number, if it is due now; NULL: why not.
const FfpStudioShot *ffp_studio_due(const FfpStudio *studio, const char *name, int number, FfpStudioSet *set,
                                    char *said);
// The virtual camera takes the shot that is due, or begins to.
bool ffp_studio_take(FfpStudio *studio, const char *set, int number, char said[FFP_STUDIO_SAID]);
// Looks for the board in the photograph under white of a set, which then has SET/board.json (`calibrate
// --seen`). Without a board, for a stop of the object that is chosen: how well those that are complete, three
// or more, determine the rig; objects/NAME/known then has the calibration.
bool ffp_studio_look(FfpStudio *studio, const char *set, char said[FFP_STUDIO_SAID]);
// The pattern of the shot that is due is on the projector: the next new picture in the folder is its
// photograph.
bool ffp_studio_show(FfpStudio *studio, const char *set, int number, char said[FFP_STUDIO_SAID]);
// A folder that a camera fills, in place of the one before, which stays if this one cannot be watched.
bool ffp_studio_watch(FfpStudio *studio, const char *folder, char said[FFP_STUDIO_SAID]);
void ffp_studio_arrived(FfpStudio *studio); // when `changes` can be read

// --- Prediction against reality, now (trial.c): objects/NAME/now. ---

// {"verb": "try", "view": "view-045", "pattern": "004_lollipop_1.png" or "own", "turned": degrees}: what is
// to be photographed as objects/NAME/now; what was photographed there before is set aside. With "watch": true
// it is the show's picture alone, "own", and what watching has photographed before is deleted.
bool ffp_studio_try(FfpStudio *studio, const json_t *request, char said[FFP_STUDIO_SAID]);
// A picture of the user's, a PNG of the panel's size, as objects/NAME/own.png; watch: the show's, as
// show.png.
bool ffp_studio_store_own(FfpStudio *studio, bool watch, const void *bytes, size_t size,
                          char said[FFP_STUDIO_SAID]);
// The steps "now", which compares, "register", which finds the devices again, and "watch", which finds them
// by the show's picture (black and white are the stop's own), as ffp_studio_step.
bool ffp_studio_is_trial_step(const char *step);
bool ffp_studio_trial_step(FfpStudio *studio, const char *step, FfpStudioJob *job,
                           char said[FFP_STUDIO_SAID]);

bool ffp_studio_say(char said[FFP_STUDIO_SAID], const char *format, ...)
    __attribute__((format(printf, 2, 3)));

// --- Control from outside (control.c), with the lock. ---

enum { FFP_STUDIO_CONTROLS = 256 }; // messages that are kept

// Listens for OSC messages over UDP at "[ADDRESS:]PORT"; without an address on this machine's loopback one.
bool ffp_studio_listen(FfpStudio *studio, const char *where, char said[FFP_STUDIO_SAID]);
// Takes the packets that have come; what is not OSC is dropped.
void ffp_studio_controlled(FfpStudio *studio);
// {"osc": "127.0.0.1:9000" or null, "number": of all that came, "events": [{"address", "values"}] after
// `known`}.
json_t *ffp_studio_controls(const FfpStudio *studio, uint64_t known);
// The messages of a packet, [{"address", "values"}]; NULL: one of them cannot be read, or there is no memory.
json_t *ffp_studio_osc(const void *bytes, size_t size);

// --- The server (serve.c). ---

bool ffp_studio_serve(FfpStudio *studio, bool opens, char said[FFP_STUDIO_SAID]);

// The pages, made of view/ (cmake/page.cmake), each ended by a 0.
extern const unsigned char ffp_page_studio[], ffp_page_projector[];
extern const size_t ffp_page_studio_size, ffp_page_projector_size;

#endif
