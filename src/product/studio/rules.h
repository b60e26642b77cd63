// Common declarations of this room's files; all with the platform's lock.
#ifndef FFP_STUDIO_RULES_H
#define FFP_STUDIO_RULES_H

#include "disk.h"
#include "jobs.h"
#include "sets.h"
#include "studio.h"

// Size and format of a PNG or JPEG; false: neither, or not whole. ending: "png" or "jpg".
bool ffp_studio_picture(const unsigned char *bytes, size_t size, int *width, int *height,
                        const char **ending);

// `import` with all that holds for every capture of an object, but for its photographs and its folder.
FfpStudioCommand *ffp_studio_import(const FfpStudio *studio, FfpStudioJob *job, const char *object);
// The option of its pictures' width for what has to be quick; without it they are as fine as photographs.
void ffp_studio_add_width(const FfpStudio *studio, FfpStudioCommand *c);
// {"draft", "fine"}: seconds that a reconstruction of the object will take, roughly; 0: not known yet.
json_t *ffp_studio_expected(const FfpStudio *studio, const char *object);
// The commands of a step ("patterns", "calibrate", "make", "evaluate") into the job;
// false: what it lacks.
bool ffp_studio_step(FfpStudio *studio, const char *step, FfpStudioJob *job, char said[FFP_STUDIO_SAID]);
// {"verb": ...}; false: why not.
bool ffp_studio_do(FfpStudio *studio, const json_t *request, char said[FFP_STUDIO_SAID]);
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

// The sphere around the object that its capture was made with, for `import`; false: there is none.
bool ffp_studio_add_sphere(const FfpStudio *studio, const char *object, FfpStudioCommand *c);

// --- A second projector (second.c): objects/NAME/projector-2. ---

// {"verb": "second", "view": "view-045" or "every", "size": [1280, 800]}: a second projector of so many
// pixels is to be photographed at that stop, of an object that is reconstructed, or at every stop, under
// patterns that a job "draw" begins to draw; what was photographed of one before is set aside.
bool ffp_studio_begin_second(FfpStudio *studio, const json_t *request, char said[FFP_STUDIO_SAID]);
// The step "second", which finds it, as ffp_studio_step.
bool ffp_studio_find_second(FfpStudio *studio, FfpStudioJob *job, char said[FFP_STUDIO_SAID]);

#endif
