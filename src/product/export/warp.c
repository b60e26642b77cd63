#include "product/export/warp.h"
#include <math.h>
#include <string.h>
#include "core/base/alloc.h"
#include "core/base/file.h"
#include "core/capture/node.h"
#include "product/export/gltf.h"

enum { CELLS = 128 };

#define STEP 4.0 // times as far as the mean: across a step in depth

static const real *at(const FfpImage *map, int x, int y) {
    return map->data + 3 * ((size_t)y * (size_t)map->width + (size_t)x);
}

bool ffp_write_stmap(const FfpImage *map, const FfpCamera *camera, const char *path, FfpError *err) {
    FfpImage image = ffp_image_new(map->width, map->height, 4);
    for (int y = 0; y < map->height; y++)
        for (int x = 0; x < map->width; x++) {
            const real *from = at(map, x, y);
            real *to = image.data + 4 * ((size_t)y * (size_t)map->width + (size_t)x);
            if (from[0] < 0) continue;
            to[0] = from[0] / (real)camera->width;
            to[1] = 1 - from[1] / (real)camera->height;
            to[3] = 1;
        }
    const bool ok = ffp_image_write_exr(&image, path, err);
    ffp_image_free(&image);
    return ok;
}

// --- The mesh. ---

typedef struct Net {
    const FfpImage *map;
    const FfpCamera *camera;
    int step, across, down; // pixels between corners; corners
    double reach;           // camera pixels that a side may have
    uint32_t *number;       // of the corners, from 0
} Net;

static const real *corner(const Net *net, int i, int j) {
    return at(net->map, i * net->step, j * net->step);
}

static double side(const Net *net, int i, int j, int k, int l) {
    const real *a = corner(net, i, j), *b = corner(net, k, l);
    return a[0] < 0 || b[0] < 0 ? INFINITY : hypot((double)(a[0] - b[0]), (double)(a[1] - b[1]));
}

static double mean_side(const Net *net) {
    double sum = 0;
    int64_t count = 0;
    for (int j = 0; j < net->down; j++)
        for (int i = 0; i + 1 < net->across; i++) {
            const double length = side(net, i, j, i + 1, j);
            if (length < INFINITY) sum += length, count++;
        }
    return count ? sum / (double)count : 0;
}

static bool is_whole(const Net *net, int i, int j) {
    return side(net, i, j, i + 1, j) <= net->reach && side(net, i, j + 1, i + 1, j + 1) <= net->reach &&
           side(net, i, j, i, j + 1) <= net->reach && side(net, i + 1, j, i + 1, j + 1) <= net->reach;
}

static void take_corners(FfpWarp *warp, const Net *net) {
    for (int j = 0; j < net->down; j++)
        for (int i = 0; i < net->across; i++) {
            const real *seen = corner(net, i, j);
            if (seen[0] < 0) continue;
            real *at = warp->position + 3 * (size_t)warp->n_corners,
                 *from = warp->texture + 2 * (size_t)warp->n_corners;
            at[0] = ((real)(i * net->step) + 0.5F) / (real)net->map->width;
            at[1] = 1 - ((real)(j * net->step) + 0.5F) / (real)net->map->height;
            at[2] = 0;
            from[0] = seen[0] / (real)net->camera->width;
            from[1] = 1 - seen[1] / (real)net->camera->height;
            net->number[j * net->across + i] = warp->n_corners++;
        }
}

static void take_triangles(FfpWarp *warp, const Net *net) {
    for (int j = 0; j + 1 < net->down; j++)
        for (int i = 0; i + 1 < net->across; i++) {
            const uint32_t *n = net->number + j * net->across + i;
            if (!is_whole(net, i, j)) continue;
            const uint32_t below = n[net->across], beyond = n[net->across + 1],
                           cell[6] = {n[0], below, beyond, n[0], beyond, n[1]}; // counter-clockwise, y up
            memcpy(warp->corners + 3 * (size_t)warp->n_triangles, cell, sizeof cell);
            warp->n_triangles += 2;
        }
}

FfpWarp ffp_warp_of_map(const FfpImage *map, const FfpCamera *camera) {
    const int longest = map->width > map->height ? map->width : map->height;
    Net net = {.map = map, .camera = camera, .step = (longest + CELLS - 1) / CELLS};
    net.across = (map->width - 1) / net.step + 1;
    net.down = (map->height - 1) / net.step + 1;
    net.reach = STEP * mean_side(&net);
    const size_t count = (size_t)net.across * (size_t)net.down;
    FfpWarp warp = {.position = ffp_alloc(3 * count, sizeof(real)),
                    .texture = ffp_alloc(2 * count, sizeof(real)),
                    .corners = ffp_alloc(6 * count, sizeof(uint32_t))};
    net.number = ffp_alloc(count, sizeof *net.number);
    take_corners(&warp, &net);
    take_triangles(&warp, &net);
    ffp_free(net.number);
    return warp;
}

void ffp_warp_free(FfpWarp *warp) {
    ffp_free(warp->position);
    ffp_free(warp->texture);
    ffp_free(warp->corners);
}

bool ffp_warp_write_obj(const FfpWarp *warp, const char *path, FfpError *err) {
    FfpOutput out;
    if (!ffp_output_open(&out, path, err)) return false;
    fprintf(out.stream, "# x, y: the projector's picture, 0 to 1; texture: the camera's\n");
    for (size_t i = 0; i < warp->n_corners; i++)
        fprintf(out.stream, "v %.6f %.6f 0\nvt %.6f %.6f\n", (double)warp->position[3 * i],
                (double)warp->position[3 * i + 1], (double)warp->texture[2 * i],
                (double)warp->texture[2 * i + 1]);
    for (size_t t = 0; t < warp->n_triangles; t++) {
        const uint32_t *c = warp->corners + 3 * t;
        fprintf(out.stream, "f %u/%u %u/%u %u/%u\n", c[0] + 1, c[0] + 1, c[1] + 1, c[1] + 1, c[2] + 1,
                c[2] + 1);
    }
    return ffp_output_commit(&out, err);
}

bool ffp_warp_write_gltf(const FfpWarp *warp, const char *path, FfpError *err) {
    const size_t n = warp->n_corners;
    FfpGltf gltf = ffp_gltf_new();
    real *texture = ffp_alloc(2 * n, sizeof *texture);
    for (size_t i = 0; i < 2 * n; i++) texture[i] = i % 2 ? 1 - warp->texture[i] : warp->texture[i];
    const int position = ffp_gltf_floats(&gltf, warp->position, n, 3, true),
              place = ffp_gltf_floats(&gltf, texture, n, 2, false),
              corners = ffp_gltf_indices(&gltf, warp->corners, 3 * warp->n_triangles);
    ffp_free(texture);
    json_t *primitive = json_pack("{s:i, s:i, s:{s:i, s:i}, s:i}", "mode", 4, "material", 0, "attributes",
                                  "POSITION", position, "TEXCOORD_0", place, "indices", corners);
    json_object_set_new(gltf.root, "extensionsUsed", json_pack("[s]", "KHR_materials_unlit"));
    json_array_append_new(ffp_gltf_list(&gltf, "materials"), json_pack("{s:s, s:{s:{}}}", "name", "content",
                                                                       "extensions", "KHR_materials_unlit"));
    const bool ok = ffp_gltf_write(&gltf, primitive, path, true, err);
    ffp_gltf_free(&gltf);
    return ok;
}
