// Photographs of Gray codes in other orders than that of `patterns`, without black and white, and sets of
// which one is missing or too many: what each photograph shows is found from the pictures (graycode.h).
#ifndef FFP_SHOTS_SETS_H
#define FFP_SHOTS_SETS_H

#include "rig/graycode/graycode.h"
#include "rig/shots/folders.h"
#include "rig/shots/shots.h"

// A view's black, white and codes (which have their places) by what n files show: black and white that nobody
// photographed are NULL. False, and nothing changes: no order explains them. panel: width, height, linear.
bool ffp_set_sort(FfpShots *shots, int stop, const FfpGrayPhotographs *panel, const char *const *files,
                  int n);
// The same of every view, whose black, white and codes were found.
void ffp_sets_sort_found(FfpShots *shots, int stops, const FfpGrayPhotographs *panel);
// The same of every view's files that match a template, whatever their number; `shown`: NULL, or what the set
// was chosen from (ffp_shot_folder_select).
bool ffp_sets_find(FfpShots *shots, const char *template, const FfpCalibration *calibration,
                   const FfpShown *shown, const FfpGrayPhotographs *panel);

#endif
