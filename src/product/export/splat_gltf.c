// KHR_gaussian_splatting (github.com/KhronosGroup/glTF, extensions/2.0/Khronos/KHR_gaussian_splatting,
// ratified): points with rotation, scale, opacity and spherical harmonics; a program that does not know it
// shows points of COLOR_0.
#include "core/base/alloc.h"
#include "core/capture/node.h"
#include "core/gaussians/elsewhere.h"
#include "core/image/image.h"
#include "product/export/gltf.h"
#include "product/export/splats.h"

// x y z w
static int add_rotations(FfpGltf *gltf, const FfpSplats *splats) {
    real *numbers = ffp_alloc(4 * (size_t)splats->count + 1, sizeof *numbers);
    for (int64_t i = 0; i < 4 * splats->count; i++) numbers[i] = splats->rotation[i % 4 == 3 ? i - 3 : i + 1];
    const int accessor = ffp_gltf_floats(gltf, numbers, (size_t)splats->count, 4, false);
    ffp_free(numbers);
    return accessor;
}

static int add_harmonics(FfpGltf *gltf, const FfpSplats *splats) {
    real *numbers = ffp_alloc(3 * (size_t)splats->count + 1, sizeof *numbers);
    for (int64_t i = 0; i < 3 * splats->count; i++) numbers[i] = (splats->colour[i] - 0.5F) / (real)FFP_SH_C0;
    const int accessor = ffp_gltf_floats(gltf, numbers, (size_t)splats->count, 3, false);
    ffp_free(numbers);
    return accessor;
}

// The look without the extension: linear colour in [0,1], and the opacity.
static int add_fallback(FfpGltf *gltf, const FfpSplats *splats) {
    real *numbers = ffp_alloc(4 * (size_t)splats->count + 1, sizeof *numbers);
    for (int64_t i = 0; i < splats->count; i++) {
        for (int64_t k = 0; k < 3; k++) {
            const real colour = splats->colour[3 * i + k];
            numbers[4 * i + k] = ffp_srgb_decode(colour < 1 ? colour : 1);
        }
        numbers[4 * i + 3] = splats->opacity[i];
    }
    const int accessor = ffp_gltf_floats(gltf, numbers, (size_t)splats->count, 4, false);
    ffp_free(numbers);
    return accessor;
}

bool ffp_splats_write_gltf(const FfpSplats *splats, const char *path, bool binary, FfpError *err) {
    FfpGltf gltf = ffp_gltf_new();
    const size_t n = (size_t)splats->count;
    json_t *attributes = json_object();
    json_t *primitive =
        json_pack("{s:i, s:i, s:o, s:{s:{s:s, s:s, s:s, s:s}}}", "mode", 0, "material", 0, "attributes",
                  attributes, "extensions", FFP_SPLAT_EXTENSION, "kernel", "ellipse", "colorSpace",
                  "srgb_rec709_display", "projection", "perspective", "sortingMethod", "cameraDistance");
    ffp_json_own(primitive);
    json_object_set_new(attributes, "POSITION",
                        json_integer(ffp_gltf_floats(&gltf, splats->centre, n, 3, true)));
    json_object_set_new(attributes, FFP_SPLAT_EXTENSION ":ROTATION",
                        json_integer(add_rotations(&gltf, splats)));
    json_object_set_new(attributes, FFP_SPLAT_EXTENSION ":SCALE",
                        json_integer(ffp_gltf_floats(&gltf, splats->scale, n, 3, false)));
    json_object_set_new(attributes, FFP_SPLAT_EXTENSION ":OPACITY",
                        json_integer(ffp_gltf_floats(&gltf, splats->opacity, n, 1, false)));
    json_object_set_new(attributes, FFP_SPLAT_EXTENSION ":SH_DEGREE_0_COEF_0",
                        json_integer(add_harmonics(&gltf, splats)));
    json_object_set_new(attributes, "COLOR_0", json_integer(add_fallback(&gltf, splats)));
    json_object_set_new(gltf.root, "extensionsUsed",
                        json_pack("[s, s]", FFP_SPLAT_EXTENSION, "KHR_materials_unlit"));
    json_array_append_new(ffp_gltf_list(&gltf, "materials"),
                          json_pack("{s:{s:{}}}", "extensions", "KHR_materials_unlit"));
    const bool ok = ffp_gltf_write(&gltf, json_incref(primitive), path, binary, err);
    ffp_json_release(primitive);
    ffp_gltf_free(&gltf);
    return ok;
}
