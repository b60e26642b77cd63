// Photographs as cameras leave them: pictures (image.h), and what other programs make pictures of. Raw
// photographs are developed by dcraw_emu (LibRaw) to linear light, with the white balance of daylight, which
// is the same for all of a camera's, and nothing brightened. Films, which a camera that stands still took of
// one thing, become the mean of their frames in linear light, by ffmpeg: "FILE@FROM-TO" is the part from one
// second to another, "FILE@AT" the frame at that second.
#ifndef FFP_IMAGE_PHOTOGRAPH_H
#define FFP_IMAGE_PHOTOGRAPH_H

#include "core/image/image.h"

typedef struct FfpDeveloped { // how many were read so far
    int raws, films, frames;
} FfpDeveloped;

// As ffp_image_read_over_black, or ffp_image_read_light where files hold `linear` numbers; raw photographs
// are linear anyhow, and neither they nor films have an alpha channel. `developed` counts; it and alpha may
// be NULL. Errors also: the program is not there, or makes nothing of the file; frames of several sizes.
bool ffp_photograph_read(FfpImage *rgb, FfpImage *alpha, const char *path, bool linear,
                         FfpDeveloped *developed, FfpError *err);
// Luma of a photograph (BT.601, of sRGB-encoded values), as corner detectors have it: [h,w,1]. The photograph
// is encoded meanwhile.
FfpImage ffp_photograph_luma(FfpImage *rgb);
// Only the size; of what has to be developed it costs a fast development, or one frame.
bool ffp_photograph_read_size(int *width, int *height, const char *path, FfpError *err);
// Whether there is such a file, the part of a film taken off its name; the error says `what` it would show.
// Errors also: a part that is none.
bool ffp_photograph_check(const char *path, const char *what, FfpError *err);
// Whether a name asks for the part of a film, right or wrong: something with an @ behind a film's ending.
bool ffp_photograph_names_part(const char *path);
// Whether a name ends as those of photographs do: for those among a folder's files.
bool ffp_photograph_has_ending(const char *name);

#endif
