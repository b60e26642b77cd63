// Names of files with placeholders and *: one rule for photographs, Gray codes and masks.
#ifndef FFP_SHOTS_FILE_NAMES_H
#define FFP_SHOTS_FILE_NAMES_H

#include "core/base/arena.h"
#include "rig/optics/calibration.h"
#include "rig/shots/folders.h"

// Order of two paths for qsort: runs of digits count as numbers, "img_9" before "img_10"; "1.png" and
// "01.png" have an order, too.
int ffp_compare_paths(const void *a, const void *b);
// True if the template has a placeholder that differs from view to view.
bool ffp_files_by_view(const char *template);

// Files in natural order, [n], of a camera whose numbers began again (9999, 0001): the part before that comes
// first, with a note.
void ffp_unwrap_numbers(const char **paths, int n);
// The last number in a file's name and how many digits it has; -1: none.
long ffp_last_number(const char *path, int *digits);
// Where the first number is missing among those of n files in natural order, which otherwise go up by one; -1
// where none is, or files have no numbers. *count: how many are missing.
int ffp_find_gap(const char *const *paths, int n, int *count);
// Two of the files in natural order, [n], that differ in their ending alone (a raw photograph and its JPEG):
// each photograph exists twice. -1: there are none; otherwise the first of the two. *count: of such pairs.
int ffp_find_twins(const char *const *paths, int n, int *count);

// A file of every view under every name.
typedef struct FfpFileSet {
    const char *template;
    const FfpCalibration *calibration; // its stops are the views
    const char *const *names;          // [n_names] what {pattern} stands for; NULL: nothing, n_names is 1
    int n_names;
    const char *kind;  // for errors: "photographs"
    const char *name;  // and what each name denotes: "pattern"
    const char *order; // and in which order they must be; "": as the names are
    bool gaps;         // files may be missing: their paths are NULL
} FfpFileSet;

// The paths, [n_stops, n_names], which must be NULL before the call; each is known to exist, unless there may
// be gaps. With gaps, the last number in each name that matches * shows which files of a view are missing;
// those after the last number are the last, and if there are half as many as names and no number is left out,
// every second one is missing. Placeholders are filled in first: {view}, {pattern}, {index} (from 0),
// {number} (from 1) and {number:3} (with zeros). Files that they do not tell apart are given by *, whose
// files are taken in natural order: all names of the first view, then of the second. ? and [...] are
// wildcards, too, unless a file has that literal name.
bool ffp_files_find(const char **paths, FfpArena *arena, const FfpFileSet *set, FfpError *err);
// The files of every view, [n_stops], whatever their number, in natural order. A template without
// placeholders must match a folder of each view, or as many files of each. False: it does not, or has no *.
bool ffp_files_list(FfpShotFolder *views, FfpArena *arena, const char *template,
                    const FfpCalibration *calibration);

#endif
