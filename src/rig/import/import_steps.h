// The steps of an import (ffp_import), in their order, and what each of them fills in. Private to import*.c.
#ifndef FFP_RIG_IMPORT_STEPS_H
#define FFP_RIG_IMPORT_STEPS_H

#include "core/capture/capture.h"
#include "core/image/photograph.h"
#include "rig/import/import.h"
#include "rig/masks/masks.h"
#include "rig/optics/lens.h"
#include "rig/response/response.h"
#include "rig/shots/shots.h"
#include "rig/turntable/turntable.h"

#define FFP_IMPORT_READERS 4 // threads: each has a photograph in memory

// capture: name_capture sets its name, and the other steps set the fields described with them.
typedef struct FfpImporting {
    const FfpImport *settings;  // before all steps
    FfpCalibration calibration; // read_rig; settle_views completes the optics' sizes
    FfpOptics coded;            // settle_views: the projector that shows the Gray codes
    FfpShots shots;             // ffp_shots_find: files; settle_views those of Gray codes
    FfpCapture capture;
    double
        code_step; // load_codes: panel pixels between neighbouring pixels of the capture, most of all views
    unsigned unlike[2]; // load_codes: bits of columns and rows that some view saw under other light, or dim
    bool *made;         // load_pixels: [views] masks made by Otsu's method
    FfpImage *holes;    // load_pixels: [views] and what was filled of them
    FfpEmptyStage *stages;  // load_pixels: [views] the empty stage, where it was photographed; NULL: was not
    FfpImage *thumbs;       // load_pixels: [views] small photographs under white, not masked
    int64_t values;         // load_pixels: of the photographs
    double brightest;       // load_pixels: of the photographs' values, before their exposure
    int64_t too_bright;     // load_pixels: those that are cut off
    FfpDeveloped developed; // load_pixels: photographs and films by other programs
    FfpResponse response;   // find_response, where it is asked for
    bool has_response;      // and kept
    const char *limit;      // fit_object: why the pictures are smaller than the photographs; ""
    int pixels[2];          // tell_size: of the object's longer side, in the capture and in the photographs
} FfpImporting;

// 1. The calibration; its stops are the views that are asked for, in their order, with poses wherever the
// axis is known.
bool ffp_importing_read_rig(FfpImporting *import, FfpError *err);
// 2. (ffp_shots_find: which file is which picture.)
// Orientation tags that differ within a rig are refused, and cameras that do are told.
bool ffp_importing_check_tags(FfpImporting *import, FfpError *err);
// 3. The optics' sizes; of the capture: views with ids, cameras and projectors, and the panel. Which files
// are Gray codes.
bool ffp_importing_settle_views(FfpImporting *import, FfpError *err);
// 4. Cameras of a size that fits the object, where the settings have no width. (check_memory)
void ffp_importing_fit_object(FfpImporting *import);
// 5. Of the capture: patterns, black and white; the views' images and coverage.
bool ffp_importing_load_pixels(FfpImporting *import, FfpError *err);
// 6. The views' correspondence, where there are Gray codes. Needs coverage.
bool ffp_importing_load_codes(FfpImporting *import, FfpError *err);
// 7. (ffp_turntable_find: the calibration's and the views' poses, where the axis is to be found. Needs images
// and coverage.)
// 8. (settle_object: centre and radius. Needs poses, coverage and correspondence.)
// 9. Of the capture: Gray codes as further patterns, where photographs of them were decoded, and the views'
// images under them; more than are to be kept, and some held out, as patterns like others.
bool ffp_importing_look_at_codes(FfpImporting *import, FfpError *err);
// 10. Of the capture: the panel's response, the patterns' light, the intensity. Needs all before.
bool ffp_importing_find_response(FfpImporting *import, FfpError *err);
// Part of 10: the response by photographs of greys, and their errors as ffp_fit_greys gives them; *enough is
// false, and there is none, where too few pixels are lit.
bool ffp_importing_has_greys(const FfpImporting *import);
bool ffp_importing_fit_greys(FfpImporting *import, bool *enough, double errors[2], FfpError *err);
// 11. Of the capture: the blur of its projector, if the patterns' edges tell it, and the spread of its light,
// if several patterns do; and the patterns filtered by both. Needs the response.
void ffp_importing_find_softness(FfpImporting *import);
// 12. Drops the Gray codes that are not to be kept.
void ffp_importing_keep_codes(FfpImporting *import);
// 13. While the capture is written (ffp_capture_write_whole), `context` being the import: the response into
// its JSON, the masks' contact sheet, and the masks that were made.
bool ffp_importing_finish(const char *folder, void *context, FfpError *err);
bool ffp_importing_keep_response(const char *folder, const FfpImporting *import, FfpError *err);

// Parts of steps. Says how large the object is in the capture (needs coverage), and keeps it in its JSON
// (13).
void ffp_importing_tell_size(FfpImporting *import);
bool ffp_importing_keep_size(const char *folder, const FfpImporting *import, FfpError *err);
// How many Gray codes are looked at; 0: there are none. And how many of them are held out, in captures that
// hold nothing else out.
int ffp_importing_codes_looked_at(const FfpImporting *import);
int ffp_importing_codes_held_out(const FfpImporting *import);
// The light of the panel's Gray code with this number, [h,w,3] (5, 9).
FfpImage ffp_importing_code_pattern(const FfpOptics *panel, int index);
// Checks that a picture has the size of the optics; check_size: of the picture in a file (5).
bool ffp_importing_has_size(const char *path, int width, int height, const FfpOptics *optics, FfpError *err);
bool ffp_importing_check_size(const char *path, const FfpOptics *optics, FfpError *err);
// The coverage of a view whose images exist, and its images over black by it, unless it was made of light
// (5).
bool ffp_importing_cover(FfpImporting *import, int stop, const FfpImage *alphas, FfpError *err);
// The same for a whole scene (settings->scene), whose settings check_scene has checked:
// everything that the camera saw, less what the correction of its lens has moved in from outside the picture.
bool ffp_importing_check_scene(const FfpImporting *import, FfpError *err);
void ffp_importing_cover_scene(FfpImporting *import, int stop);
// Coverage made of light: completed by what other views see, and applied to the images (5).
bool ffp_importing_complete_masks(FfpImporting *import, FfpError *err);
bool ffp_importing_write_sheet(const char *folder, const FfpImporting *import, FfpError *err);
// Replaces the mask of a view in the dark (dark.h) by means of one with twice as many pixels a side, for
// which its photographs are read once more. False, and the mask stays: they are less than 1.5 times as wide,
// cannot be read or are not dark, or the two masks differ by two fifths.
bool ffp_importing_refine_mask(FfpImporting *import, int v);
// masks/VIEW.png, if masks were made.
bool ffp_importing_write_masks(const char *folder, const FfpImporting *import, FfpError *err);
// A photograph as linear light without lens distortion, as the settings have it (5); *alpha (or NULL) stays
// empty when the file has none or its alpha channel tells nothing.
bool ffp_importing_read_picture(FfpImporting *import, const char *path, int stop, FfpImage *picture,
                                FfpImage *alpha, FfpError *err);
// The same of n photographs side by side; no path: no picture. alphas: [n].
bool ffp_importing_read_pictures(FfpImporting *import, const char *const *paths, int n, int stop,
                                 FfpImage *pictures, FfpImage *alphas, FfpError *err);
// Black and white that nobody photographed, where they are not among the pictures, made from the codes.
bool ffp_importing_make_plain(FfpImporting *import, int stop, FfpImage *black, FfpImage *white,
                              FfpError *err);
// The empty stage, where there are photographs of it; and its memory (5).
bool ffp_importing_load_stage(FfpImporting *import, FfpError *err);
void ffp_importing_free_stage(FfpImporting *import);

#endif
