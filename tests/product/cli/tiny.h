// A small capture made for the tests: a ball under a projector, in the layout of render_poses.json (Blender
// axes).
#ifndef FFP_TESTS_TINY_H
#define FFP_TESTS_TINY_H

#include <jansson.h>
#include <math.h>
#include "core/base/file.h"
#include "core/capture/capture.h"
#include "core/image/image.h"
#include "core/image/lookup.h"
#include "support.h"

#define TINY_VIEWS 4
#define TINY_PATTERN 64
#define TINY_BALL 0.8F
#define TINY_SAMPLES 3

static const char *const tiny_patterns[] = {"all_black", "all_white", "lollipop_0", "lollipop_1", "stripes"};
enum { TINY_PATTERNS = sizeof tiny_patterns / sizeof *tiny_patterns };

// A device at `position` that looks at the origin, z up, OpenCV axes.
static inline FfpCamera tiny_device(const float position[3], int side, float focal) {
    FfpCamera device = {side, side, focal, focal, side * 0.5F, side * 0.5F, {0}};
    float forward[3], right[3], down[3];
    const float length =
        sqrtf(position[0] * position[0] + position[1] * position[1] + position[2] * position[2]);
    for (int i = 0; i < 3; i++) forward[i] = -position[i] / length;
    const float flat = sqrtf(forward[0] * forward[0] + forward[1] * forward[1]);
    right[0] = forward[1] / flat, right[1] = -forward[0] / flat, right[2] = 0;
    down[0] = forward[1] * right[2] - forward[2] * right[1];
    down[1] = forward[2] * right[0] - forward[0] * right[2];
    down[2] = forward[0] * right[1] - forward[1] * right[0];
    for (int i = 0; i < 3; i++) {
        device.pose[4 * i] = right[i], device.pose[4 * i + 1] = down[i], device.pose[4 * i + 2] = forward[i];
        device.pose[4 * i + 3] = position[i];
    }
    device.pose[15] = 1;
    return device;
}

static inline void tiny_rig(int view, float turn, int side, FfpCamera *camera, FfpCamera *projector) {
    const float azimuth = (float)view * 6.2831853F / TINY_VIEWS + turn;
    const float at[3] = {3 * cosf(azimuth), 3 * sinf(azimuth), 0.3F};
    const float light[3] = {1.8F * cosf(azimuth), 1.8F * sinf(azimuth), 1};
    *camera = tiny_device(at, side, side * 1.37F);
    *projector = tiny_device(light, TINY_PATTERN, TINY_PATTERN * 0.96F);
}

// The patterns' linear colours: two of random patches, which matching can tell apart, and stripes.
static inline FfpImage tiny_pattern(int pattern) {
    FfpImage image = ffp_image_new(TINY_PATTERN, TINY_PATTERN, 3);
    for (int y = 0; y < TINY_PATTERN; y++)
        for (int x = 0; x < TINY_PATTERN; x++)
            for (int c = 0; c < 3; c++) {
                uint32_t hash = (uint32_t)(x / 4) * 73856093U ^ (uint32_t)(y / 4) * 19349663U ^
                                (uint32_t)(3 * pattern + c + 1) * 83492791U;
                hash = (hash ^ hash >> 13) * 1274126177U;
                const float random = (float)(hash >> 16 & 255) / 255;
                const float value[] = {0, 1, random, random, x / 8 % 2 ? 0.9F : 0.1F};
                image.data[(y * TINY_PATTERN + x) * 3 + c] = value[pattern];
            }
    return image;
}

// Linear colour of the ball at picture position (x, y), false beside it: ambient 0.06, albedo 0.6, light of
// 4 W/sr through the pattern.
static inline bool tiny_colour(const FfpCamera *camera, const FfpCamera *projector, const FfpSummed *pattern,
                               real x, real y, real out[3]) {
    real direction[3], origin[3], point[3], light[3], colour[3];
    ffp_pixel_ray(camera, x, y, direction);
    for (int i = 0; i < 3; i++) origin[i] = camera->pose[4 * i + 3];
    const real b = origin[0] * direction[0] + origin[1] * direction[1] + origin[2] * direction[2];
    const real c =
        origin[0] * origin[0] + origin[1] * origin[1] + origin[2] * origin[2] - TINY_BALL * TINY_BALL;
    if (b * b < c) return false;
    const real t = -b - sqrtf(b * b - c);
    real squared = 0, lambert = 0, u, v;
    for (int i = 0; i < 3; i++) {
        point[i] = origin[i] + t * direction[i];
        light[i] = projector->pose[4 * i + 3] - point[i];
        squared += light[i] * light[i];
        lambert += light[i] * point[i] / TINY_BALL;
    }
    ffp_project(projector, point, &u, &v);
    ffp_lookup(pattern, u, v, 2, 2, colour);
    const real shade = fmaxf(lambert, 0) / sqrtf(squared) * 4 / squared * 0.6F / 3.14159265F;
    for (int i = 0; i < 3; i++) out[i] = 0.06F + shade * colour[i];
    return true;
}

// Linear RGB and straight alpha, means over TINY_SAMPLES^2 places of each pixel, as a camera's outlines are.
static inline FfpImage tiny_photograph(const FfpCamera *camera, const FfpCamera *projector,
                                       const FfpSummed *pattern) {
    FfpImage image = ffp_image_new(camera->width, camera->height, 4);
    for (int p = 0; p < camera->width * camera->height; p++) {
        real *pixel = image.data + 4 * (size_t)p, colour[3];
        int covered = 0;
        for (int s = 0; s < TINY_SAMPLES * TINY_SAMPLES; s++) {
            const real x = p % camera->width + (s % TINY_SAMPLES + 0.5F) / TINY_SAMPLES;
            const real y = p / camera->width + (s / TINY_SAMPLES + 0.5F) / TINY_SAMPLES;
            if (!tiny_colour(camera, projector, pattern, x, y, colour)) continue;
            covered++;
            for (int i = 0; i < 3; i++) pixel[i] += colour[i];
        }
        for (int i = 0; covered && i < 3; i++) pixel[i] /= covered;
        pixel[3] = (real)covered / (TINY_SAMPLES * TINY_SAMPLES);
    }
    return image;
}

// OpenCV axes to Blender's: y and z turn round.
static inline json_t *tiny_matrix(const FfpCamera *device) {
    json_t *rows = json_array();
    for (int i = 0; i < 4; i++) {
        json_t *row = json_array();
        for (int j = 0; j < 4; j++)
            json_array_append_new(row, json_real(device->pose[4 * i + j] * (j == 1 || j == 2 ? -1.0 : 1.0)));
        json_array_append_new(rows, row);
    }
    return rows;
}

// A view without photographs.
static inline json_t *tiny_view_at(const char *id, const FfpCamera *camera, const FfpCamera *projector) {
    json_t *view =
        json_pack("{s:s,s:o,s:o,s:f,s:f,s:f,s:f}", "view_id", id, "c2w", tiny_matrix(camera), "p2w",
                  tiny_matrix(projector), "proj_fx", (double)projector->fx, "proj_fy", (double)projector->fy,
                  "proj_cx", (double)projector->cx, "proj_cy", (double)projector->cy);
    assert_non_null(view);
    return view;
}

// A capture or targets, of views with that camera.
static inline json_t *tiny_root(const FfpCamera *camera, json_t *views) {
    json_t *root =
        json_pack("{s:s,s:{s:i,s:i,s:f,s:f,s:f,s:f},s:{s:f,s:i,s:i},s:o}", "scene_name", "tiny", "camera",
                  "h", camera->height, "w", camera->width, "fx", (double)camera->fx, "fy", (double)camera->fy,
                  "cx", (double)camera->cx, "cy", (double)camera->cy, "projector", "projector_energy", 50.0,
                  "pattern_w", TINY_PATTERN, "pattern_h", TINY_PATTERN, "views", views);
    assert_non_null(root);
    return root;
}

static inline json_t *tiny_view(const char *folder, const char *id, const FfpCamera *camera,
                                const FfpCamera *projector) {
    json_t *patterns = json_array();
    for (int p = 0; p < TINY_PATTERNS; p++) {
        char name[128], path[FFP_PATH_MAX];
        snprintf(name, sizeof name, "%s_%s.png", id, tiny_patterns[p]);
        assert_true(ffp_join_path(path, folder, name));
        FfpImage pattern = tiny_pattern(p);
        FfpSummed summed = ffp_summed_new(&pattern);
        FfpImage image = tiny_photograph(camera, projector, &summed);
        ffp_image_to_srgb(&image);
        assert_true(ffp_image_write_png(&image, path, NULL));
        ffp_image_free(&image);
        ffp_image_free(&pattern);
        ffp_summed_free(&summed);
        json_array_append_new(patterns,
                              json_pack("{s:s,s:s}", "file_path", name, "projector_image", tiny_patterns[p]));
    }
    json_t *view = tiny_view_at(id, camera, projector);
    json_object_set_new(view, "patterns", patterns);
    return view;
}

static inline void tiny_json(const char *folder, const char *file, const char *prefix, int views, float turn,
                             int side) {
    char path[FFP_PATH_MAX];
    FfpCamera camera, projector;
    json_t *list = json_array();
    for (int v = 0; v < views; v++) {
        char id[32];
        snprintf(id, sizeof id, "%s_%d", prefix, v);
        tiny_rig(v, turn, side, &camera, &projector);
        json_array_append_new(list, tiny_view(folder, id, &camera, &projector));
    }
    json_t *root = tiny_root(&camera, list);
    assert_true(ffp_join_path(path, folder, file));
    assert_int_equal(json_dump_file(root, path, JSON_INDENT(1)), 0);
    json_decref(root);
}

// folder/render_poses.json (TINY_VIEWS views), folder/targets.json (2 new poses), folder/patterns/*.png
static inline void tiny_capture(const char *folder, int side) {
    char path[FFP_PATH_MAX];
    assert_true(ffp_join_path(path, folder, "patterns"));
    assert_true(ffp_make_folders(path, NULL));
    for (int p = 0; p < TINY_PATTERNS; p++) {
        snprintf(path, sizeof path, "%s/patterns/%s.png", folder, tiny_patterns[p]);
        FfpImage image = tiny_pattern(p);
        ffp_image_to_srgb(&image);
        assert_true(ffp_image_write_png(&image, path, NULL));
        ffp_image_free(&image);
    }
    tiny_json(folder, "render_poses.json", "view", TINY_VIEWS, 0, side);
    tiny_json(folder, "targets.json", "novel", 2, 0.4F, side);
}

// folder/aside.json: a view without photographs, its camera and its projector farther apart than in any view
// of the capture, all of which look alike; folder/aside.png: what the camera would see there under the
// stripes.
static inline void tiny_aside(const char *folder, int side, FfpCamera *camera, FfpCamera *projector) {
    char path[FFP_PATH_MAX];
    FfpCamera other;
    tiny_rig(0, 0.4F, side, camera, &other);
    tiny_rig(0, 0.9F, side, &other, projector);
    json_t *root = tiny_root(camera, json_pack("[o]", tiny_view_at("aside", camera, projector)));
    assert_true(ffp_join_path(path, folder, "aside.json"));
    assert_int_equal(json_dump_file(root, path, 0), 0);
    json_decref(root);
    FfpImage stripes = tiny_pattern(TINY_PATTERNS - 1);
    FfpSummed light = ffp_summed_new(&stripes);
    FfpImage seen = tiny_photograph(camera, projector, &light);
    ffp_image_to_srgb(&seen);
    assert_true(ffp_join_path(path, folder, "aside.png"));
    assert_true(ffp_image_write_png(&seen, path, NULL));
    ffp_image_free(&seen);
    ffp_summed_free(&light);
    ffp_image_free(&stripes);
}

#endif
