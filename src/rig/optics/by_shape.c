// Calibrations whose keys no tool of ours is known for: what a key holds can be seen by its numbers, and
// whose it is by a part of its name.
#include "rig/optics/by_shape.h"
#include <ctype.h>
#include <math.h>
#include <string.h>
#include "rig/optics/matrix.h"

#define FOCAL_LEAST 16.0 // pixels: no identity is a camera matrix
#define RIGID 1e-3

static bool is_zero(double value) {
    return fabs(value) <= 1e-9;
}

static bool is_camera_matrix(const double *k) {
    return k[0] >= FOCAL_LEAST && k[4] >= FOCAL_LEAST && k[2] > 0 && k[5] > 0 && is_zero(k[3]) &&
           is_zero(k[6]) && is_zero(k[7]) && is_zero(k[8] - 1);
}

static bool is_rotation(const double *r) {
    for (int i = 0; i < 3; i++)
        for (int j = 0; j <= i; j++) {
            double dot = 0;
            for (int k = 0; k < 3; k++) dot += r[3 * i + k] * r[3 * j + k];
            if (fabs(dot - (i == j)) > RIGID) return false;
        }
    return true;
}

static bool is_size(const FfpMatrix *m) {
    for (int i = 0; i < 2; i++)
        if (!(m->values[i] >= FOCAL_LEAST && m->values[i] == floor(m->values[i]))) return false;
    return true;
}

static FfpKeyShape shape_of(const FfpNode *field) {
    FfpMatrix m;
    if (json_is_string(field->value) || !ffp_node_matrix(field, &m, NULL)) return FFP_SHAPE_NONE;
    const int n = m.rows * m.cols;
    if (n == 9 && (m.rows == 3 || m.cols == 1)) // or a flat list of its rows
        return is_camera_matrix(m.values) ? FFP_SHAPE_MATRIX
               : is_rotation(m.values)    ? FFP_SHAPE_ROTATION
                                          : FFP_SHAPE_NONE;
    if (m.rows != 1 && m.cols != 1) return FFP_SHAPE_NONE;
    if (n == 3) return FFP_SHAPE_TRANSLATION;
    if (n == 2) return is_size(&m) ? FFP_SHAPE_SIZE : FFP_SHAPE_NONE;
    return n == 4 || n == 5 || n == 8 || n == 12 || n == 14 ? FFP_SHAPE_LENS : FFP_SHAPE_NONE;
}

// 0: the camera, 1: the projector, -1: the name does not say. Of a stereo pair the second is the projector.
static int device_of(const char *key) {
    static const char *const parts[] = {"proj",    "prj",   "pro_", "_pro", "cam2",
                                        "camera2", "right", "cam",  "left"};
    enum { PROJECTORS = 7 };
    char small[64] = "";
    size_t n = 0;
    for (; key[n] && n + 1 < sizeof small; n++) small[n] = (char)tolower((unsigned char)key[n]);
    for (int i = 0; i < (int)(sizeof parts / sizeof *parts); i++)
        if (strstr(small, parts[i])) return i < PROJECTORS;
    return n > 0 && small[n - 1] == '2' ? 1 : n > 0 && small[n - 1] == '1' ? 0 : -1;
}

// R1 and R2 of OpenCV's stereoRectify turn each device into a rectified pair: they are not the motion.
static bool is_rectification(const char *key) {
    return strcmp(key, "R1") == 0 || strcmp(key, "R2") == 0;
}

// Where a key of this shape belongs; NULL: nowhere.
static const char **place_of(FfpShapedKeys *keys, FfpKeyShape shape, int device) {
    if (shape == FFP_SHAPE_ROTATION) return &keys->rotation;
    if (shape == FFP_SHAPE_TRANSLATION) return &keys->translation;
    if (shape == FFP_SHAPE_NONE || device < 0) return NULL;
    return &keys->device[device][shape];
}

bool ffp_keys_by_shape(const FfpNode *root, FfpShapedKeys *keys) {
    const char *key;
    json_t *value;
    *keys = (FfpShapedKeys){0};
    json_object_foreach(root->value, key, value) {
        FfpNode field;
        if (is_rectification(key) || !ffp_node_find(root, key, &field)) continue;
        const char **place = place_of(keys, shape_of(&field), device_of(key));
        if (!place) continue;
        if (*place) return false; // two of them: which is meant?
        *place = key;
    }
    return keys->device[0][FFP_SHAPE_MATRIX] && keys->device[1][FFP_SHAPE_MATRIX];
}
