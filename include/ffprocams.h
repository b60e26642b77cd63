// FF-ProCams in C: from eight photographed views of an object to relightable 3D Gaussians, and pictures of them under any
// pattern, camera pose and projector pose. This is the one public header.
//
// Every function that can fail returns false or NULL and leaves "WHAT (WHERE)" in the FfpError it was given. Handles are
// freed with their *_close; NULL is allowed there. Nothing here is shared between threads: one handle, one thread.
#ifndef FFPROCAMS_H
#define FFPROCAMS_H

#include <stdbool.h>
#include <stdint.h>

typedef struct FfpError FfpError;
typedef struct FfpCapture FfpCapture;
typedef struct FfpModel FfpModel;
typedef struct FfpGaussians FfpGaussians;

#endif
