// A glTF 2.0 file under construction: its JSON, and one buffer with the data of all its accessors.
#ifndef FFP_EXPORT_GLTF_H
#define FFP_EXPORT_GLTF_H

#include <jansson.h>
#include <stdint.h>
#include "core/base/error.h"
#include "core/base/real.h"

typedef struct FfpGltf {
    json_t *root;         // the call's until the file is written (ffp_json_own)
    unsigned char *bytes; // of the buffer
    size_t size, room;
} FfpGltf;

enum { FFP_GLTF_ARRAY = 34962, FFP_GLTF_INDICES = 34963 };

FfpGltf ffp_gltf_new(void);
void ffp_gltf_free(FfpGltf *gltf);

// Accessors, by index. `values` [count,width] as floats; `bounds`: with min and max, as positions must have.
int ffp_gltf_floats(FfpGltf *gltf, const real *values, size_t count, int width, bool bounds);
int ffp_gltf_indices(FfpGltf *gltf, const uint32_t *values, size_t count);
// A texture of a PNG file's bytes, filtered without mip maps and not repeated.
int ffp_gltf_texture(FfpGltf *gltf, const unsigned char *png, size_t size);
json_t *ffp_gltf_list(FfpGltf *gltf, const char *name); // root[name], an array, created if missing

// The file: GLB, or JSON with the buffer inside as base64. One mesh, whose primitive is given (taken over),
// and one node and scene that show it. Errors: more than the 4 GB that a GLB can hold.
bool ffp_gltf_write(FfpGltf *gltf, json_t *primitive, const char *path, bool binary, FfpError *err);

#endif
