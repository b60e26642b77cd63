// Photographs as they come from cameras: pictures (image.h), and files that other programs convert to
// pictures. Raw photographs are developed by dcraw_emu (LibRaw) to linear light, with the white balance of
// daylight, which is the same for all of a camera's, and without automatic brightening. Films of a still
// scene by a still camera become the mean of their frames in linear light, by ffmpeg: "FILE@FROM-TO" is the
// part from one second to another, "FILE@AT" the frame at that second.
#ifndef FFP_IMAGE_PHOTOGRAPH_H
#define FFP_IMAGE_PHOTOGRAPH_H

#include "core/image/image.h"

typedef struct FfpDeveloped { // how many were read so far
    int raws, films, frames;
} FfpDeveloped;

// As ffp_image_read_over_black, or ffp_image_read_light where files hold `linear` numbers; raw photographs
// are always linear, and neither they nor films have an alpha channel. `developed` counts; it and alpha may
// be NULL. Further errors: the program is not installed, or cannot read the file; frames of several sizes.
bool ffp_photograph_read(FfpImage *rgb, FfpImage *alpha, const char *path, bool linear,
                         FfpDeveloped *developed, FfpError *err);
// The same at 1 / shrink of its size, as ffp_image_read_reduced.
bool ffp_photograph_read_reduced(FfpImage *rgb, FfpImage *alpha, int whole[2], const char *path, bool linear,
                                 int shrink, bool rough, FfpDeveloped *developed, FfpError *err);
// Luma of a photograph (BT.601, of sRGB-encoded values), as for corner detectors: [h,w,1]. The photograph is
// encoded in the process.
FfpImage ffp_photograph_luma(FfpImage *rgb);
// Only the size; for raw photographs it takes a fast development, and for films one frame.
bool ffp_photograph_read_size(int *width, int *height, const char *path, FfpError *err);
// Checks that the file exists, ignoring the part of a film in its name; the error says `what` it would show.
// Further errors: an invalid part.
bool ffp_photograph_check(const char *path, const char *what, FfpError *err);
// True if a name asks for the part of a film, valid or not: an @ after a film's extension.
bool ffp_photograph_names_part(const char *path);
// True if a name has the extension of a raw photograph.
bool ffp_photograph_is_raw(const char *name);
// True if a name has the extension of a photograph: for finding those among a folder's files.
bool ffp_photograph_has_ending(const char *name);

#endif
