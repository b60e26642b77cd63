// The kind of a file, by its first bytes, for errors about a file of the wrong kind.
#ifndef FFP_BASE_KIND_H
#define FFP_BASE_KIND_H

#include "core/base/error.h"

typedef enum FfpKind {
    FFP_KIND_UNKNOWN, // nothing of these, not there, or no regular file
    FFP_KIND_FOLDER,
    FFP_KIND_JSON,
    FFP_KIND_PLY,
    FFP_KIND_SPZ,     // gzip, as SPZ is up to version 3, or SPZ
    FFP_KIND_GLTF,    // GLB, or JSON called .gltf
    FFP_KIND_SPLAT,   // called .splat, and nothing of these
    FFP_KIND_WEIGHTS, // safetensors
    FFP_KIND_FIELD,   // likewise, of a neural field
    FFP_KIND_IMAGE,
} FfpKind;

FfpKind ffp_file_kind(const char *path);

// The kind that a reader expects.
typedef enum FfpExpectedKind {
    FFP_WANTED_CAPTURE,
    FFP_WANTED_GAUSSIANS,
    FFP_WANTED_WEIGHTS,
    FFP_WANTED_FIELD,
    FFP_WANTED_TENSORS, // any safetensors
    FFP_WANTED_IMAGE
} FfpExpectedKind;

// False with "is Gaussians (a PLY), not a capture: ..." if the file is clearly of another kind. True
// guarantees nothing: the file may be broken, unknown or missing.
bool ffp_check_kind(const char *path, FfpExpectedKind wanted, FfpError *err);

#endif
