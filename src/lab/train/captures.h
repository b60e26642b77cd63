// Captures to learn from: the user's own, photographs and calibrations without ground truth; and rooms, of
// whose photographs clean ones are known.
#ifndef FFP_TRAIN_CAPTURES_H
#define FFP_TRAIN_CAPTURES_H

#include "lab/train/train.h"

typedef struct FfpCaptureSet FfpCaptureSet;

// All captures in the folder at config->captures (each a folder with scene.json or render_poses.json), sorted
// by name and kept in memory: as for a reconstruction, in their bounding spheres, with noise filtered from
// the pictures, and with no side longer than config->resolution. Every fourth is held out, or the last if
// there are fewer than four. Of the patterns that every view has, black, white and up to config->lollipops
// others are kept, the one to reconstruct from first. Maps of depth and material that a capture may have are
// ignored. Errors name the capture: fewer than two of them; only one view and one pattern, which leave
// nothing to predict; not enough memory.
FfpCaptureSet *ffp_captures_open(const FfpTrainConfig *config, FfpError *err);
void ffp_captures_close(FfpCaptureSet *set); // NULL is allowed
int ffp_captures_count(const FfpCaptureSet *set, bool held_out);

// Scene `number` to learn from: the captures in turn, in an order of the seed. A random quarter of the views
// (up to config->targets) are the new poses, to be predicted, and of the rest up to config->views are the
// input; every fourth scene has all of them as input. The scene borrows from the set. A pure function of its
// arguments, for any number of threads.
bool ffp_captures_scene(FfpScene *scene, const FfpTrainConfig *config, const FfpCaptureSet *set,
                        int64_t number, FfpError *err);
// A held-out capture: every fourth view is a new pose.
bool ffp_captures_held_scene(FfpScene *scene, const FfpTrainConfig *config, const FfpCaptureSet *set,
                             int index, FfpError *err);

// The rooms in the folder at config->rooms: captures as above, at least one, none held out. Each has clean
// pictures in targets/scene.json, in the capture's frame, under black, white and the pattern to reconstruct
// from at least, from any poses, those of the capture's views among them; patterns that one of them lacks are
// left out. Errors name the room or its targets.
FfpCaptureSet *ffp_rooms_open(const FfpTrainConfig *config, FfpError *err);
// True if scene `number` is a room: config->room_share of them are.
bool ffp_is_room(const FfpTrainConfig *config, int64_t number);
// The room of scene `number`: in turn, in an order of the seed. Up to config->views of its views, at random
// if it has more, are the input; the new poses are all its clean pictures, and alone supervised. It borrows
// from the set, and is a pure function of its arguments, for any number of threads.
bool ffp_rooms_scene(FfpScene *scene, const FfpTrainConfig *config, const FfpCaptureSet *set, int64_t number,
                     FfpError *err);

// Mean PSNR on the held-out captures' photographs, each reconstructed without every fourth of its views: of
// these views under all patterns, and of the others under patterns that were not given.
typedef struct FfpHeldOut {
    double alone, polished; // dB, full frame, the prediction and after a fit of config->polish_steps
    int photographs;
} FfpHeldOut;
bool ffp_captures_score(const FfpModel *model, const FfpTrainConfig *config, const FfpCaptureSet *set,
                        FfpHeldOut *result, FfpError *err);

#endif
