// Inside the capture room: where the photographs are that a capture has left in their files.
#ifndef FFP_CAPTURE_PHOTOGRAPH_FILES_H
#define FFP_CAPTURE_PHOTOGRAPH_FILES_H

#include "core/capture/manifest.h"

// As the file has the camera's picture.
typedef struct FfpWholePicture {
    int width, height, frame_width, frame_height;
} FfpWholePicture;

typedef struct FfpPhotographFiles {
    FfpArena *arena;
    const char *json;
    FfpViewFiles *views;     // [n_views]
    FfpWholePicture *wholes; // [n_views]
    bool mask_is_given;
} FfpPhotographFiles;

// Leaves the manifest's files, with its arena, to the capture, before views are cut to their frames.
void ffp_photographs_leave(FfpManifest *manifest);
void ffp_photographs_forget(FfpCapture *capture);

#endif
