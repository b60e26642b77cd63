// FF-ProCams in C: turns eight photographed views of an object into relightable 3D Gaussians, and renders
// them under any pattern, camera pose and projector pose. This header includes the others, which are one for
// each subject; to be read in this order: context.h, capture.h, reconstruct.h, render.h.
//
// Every function that can fail returns false, NULL or, where it counts something, -1, and writes
// "WHAT (WHERE)" to the FfpError passed to it (which may be NULL). Passing NULL to one for a required
// argument (a handle, the options, an output file) fails with FFP_ERROR_ARGUMENT, and the text names it;
// functions without an FfpError, such as ffp_capture_views, must not be given NULL where they do not say that
// they may. Statistics and other results of a failed call are undefined. Functions that take long, log or
// allocate much take an FfpContext first (NULL: silent, all processors, no GPU). Structs of options begin
// with their size in the program, which their defaults set: options that a later library added have their
// defaults, and a struct without a size or of a later version fails with FFP_ERROR_ARGUMENT. Handles are
// freed by their *_close functions, a context by ffp_context_free; all accept NULL. Handles share no state.
// Captures, models, fields and Gaussians may be used by several threads at a time as long as none of them
// changes or closes the handle: calls that take it as const only read it. A renderer belongs to one thread at
// a time. Files are written under a temporary name and then renamed, so an old file stays intact until the
// new one is complete. Numbers in files and texts use a decimal point regardless of setlocale().
#ifndef FFPROCAMS_H
#define FFPROCAMS_H

#include <stdbool.h>
#include "ffprocams/api.h"
#include "ffprocams/capture.h"
#include "ffprocams/context.h"
#include "ffprocams/error.h"
#include "ffprocams/findings.h"
#include "ffprocams/gradients.h"
#include "ffprocams/lab.h"
#include "ffprocams/reconstruct.h"
#include "ffprocams/render.h"
#include "ffprocams/rig.h"
#include "ffprocams/version.h"

#ifdef __cplusplus
extern "C" {
#endif

// The version of the library, as "0.4.0". That of the headers is in ffprocams/version.h:
// FFPROCAMS_VERSION_MAJOR, _MINOR, _PATCH, and FFPROCAMS_VERSION, a number that grows with it.
FFP_API const char *ffp_version(void);

// Checks that the environment variable FFPROCAMS_CPU (portable, avx2, avx512, avx512bf16 or amx; unset: the
// best supported) names kernels that this processor can run. Without this check an invalid value is ignored
// and the best kernels are used.
FFP_API bool ffp_cpu_check(FfpError *err);

#ifdef __cplusplus
}
#endif

#endif
