// From calibration files and photographs to a capture folder.
#ifndef FFP_RIG_IMPORT_H
#define FFP_RIG_IMPORT_H

#include "rig/optics/lens.h"
#include "rig/shots/shots.h"
#include "rig/turntable/turntable.h"

#define FFP_CODES_MOST 32 // that are kept for fits

typedef enum FfpAxisKnown {
    FFP_AXIS_KNOWN,   // axis and point of the turntable
    FFP_AXIS_UNKNOWN, // found from the pictures
    FFP_AXIS_GUESSED  // likewise, near axis and point
} FfpAxisKnown;

typedef struct FfpImportSettings {
    const char *const *calibrations; // files (and folders) of one calibration
    int n_calibrations;
    const char *projector_image; // COLMAP: the image that is the projector; NULL: "calib"
    const char *turntable_file;  // axis and point unless they are to be found, and angles unless `turntable`
                                 // has some; NULL: as below
    const FfpTurntable *turntable; // NULL: neither angles nor a guess are given
    FfpAxisKnown axis;
    FfpShotSources sources;
    const char *const *views; // ids to import; none: all
    int n_views;
    FfpPictureSize camera, projector;
    int width;                           // of the imported pictures; 0: as they are
    bool fit_response;                   // patterns become the light that the projector made of them
    bool linear_images, linear_patterns; // PNG and JPEG files hold linear light
    int codes;        // at most so many photographs of Gray codes are kept for fits; 0: none
    double exposure;  // stops
    double object[4]; // centre and radius of a sphere around the object; radius 0: estimated
    bool scene;       // a whole scene: no masks, and depth without a sphere
    const char *name; // of the capture; NULL: the folder's
    const char *folder;
} FfpImportSettings;

// Writes a capture folder, whole or not at all. Errors name the setting, or file and field.
bool ffp_import(const FfpImportSettings *settings, FfpError *err);

#endif
