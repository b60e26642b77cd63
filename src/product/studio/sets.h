// Sets of photographs: their kinds, their shots, and what each is for. Here is decided what a folder's name
// means, and nowhere else.
#ifndef FFP_STUDIO_SETS_H
#define FFP_STUDIO_SETS_H

#include "studio.h"

typedef enum FfpShotRole {
    FFP_SHOT_OTHER,
    FFP_SHOT_BLACK,
    FFP_SHOT_WHITE,
    FFP_SHOT_LOLLIPOP,
    FFP_SHOT_CODE,
    FFP_SHOT_OWN // under a picture of the user's
} FfpShotRole;

typedef struct FfpStudioShot {
    int number; // of the file: NNN.png
    FfpShotRole role;
    char pattern[128]; // its picture: patterns/004_gray_x_00.png
    double angle;      // of the table, where has_angle
    bool has_angle;
} FfpStudioShot;

typedef enum FfpSetKind {
    FFP_SET_ATTITUDE, // of the board
    FFP_SET_TABLE,    // the board on the turntable
    FFP_SET_EMPTY,    // the stage without the object
    FFP_SET_STOP,
    FFP_SET_SECOND, // a stop under the second projector
    FFP_SET_TRIAL,  // the object as it stands now
    FFP_SET_KINDS
} FfpSetKind;
extern const char *const ffp_set_kinds[FFP_SET_KINDS]; // as the page is told

typedef struct FfpStudioSet {
    char name[FFP_STUDIO_NAME]; // its folder: calibration/attitude-03
    FfpSetKind kind;
    char object[FFP_STUDIO_NAME]; // that it is of; "": the calibration
    char stage[32];               // what `generate --only` calls it
    FfpStudioShot shots[FFP_STUDIO_SHOTS];
    int count, done;
    int panel[2]; // pixels of a second projector that shows its patterns; 0: the first one does
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
FfpShotRole ffp_studio_pattern_role(const char *file); // of a file that has a number
bool ffp_studio_complete(const FfpStudioSet *set);     // it has shots, and all of their photographs
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

// The second projector to be photographed, the object's "second" in studio.json; false: there is none.
// Its sets are objects/NAME/projector-2/view-DDD.
#define FFP_STUDIO_SECOND "projector-2"
#define FFP_STUDIO_EVERY "every" // in place of a stop: all of them, each after the first projector's own set
typedef struct FfpStudioSecond {
    const char *view; // "view-045", or "every"
    bool every;
    int width, height;            // of its panel
    char folder[FFP_STUDIO_NAME]; // objects/NAME/projector-2; its patterns are in folder/patterns
} FfpStudioSecond;
bool ffp_studio_read_second(const FfpStudio *studio, const char *object, FfpStudioSecond *second);
// {"view", "size", "count" and "done" of its photographs, "found"}; null: there is none.
json_t *ffp_studio_second_state(const FfpStudio *studio, const char *object);

int ffp_studio_next(const FfpStudioSet *set);          // index of the first missing shot; -1: complete
bool ffp_studio_photographed(const FfpStudio *studio); // anything at all
json_t *ffp_studio_object(const FfpStudio *studio, const char *name); // borrowed; NULL: none of that name

#endif
