// Who took photographs that belong together, and with which lens, by what cameras write into them (EXIF).
#ifndef FFP_SHOTS_TAKEN_H
#define FFP_SHOTS_TAKEN_H

#include "rig/shots/folders.h"

// Asks every file (NULL: passed over) of n folders: a doubt names the first of a folder that says otherwise
// than most beside it, and, if all were taken by `one` camera, each folder that says otherwise than most. The
// result is the focal length of most, as that of a 35 mm camera, mm; 0: they do not say. each: NULL, or
// likewise of each folder, [n].
double ffp_taken_compare(const FfpShotFolder *folders, int n, bool one, double *each);

#endif
