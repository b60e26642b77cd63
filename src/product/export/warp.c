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
    double reach;     // camera pixels that the side of a cell of one pixel may have
    uint32_t *number; // of the pixels' corners, from 1; 0: none yet
    FfpWarp *warp;
    size_t room[2]; // for corners and triangles
} Net;

static double side(const real *a, const real *b) {
    return a[0] < 0 || b[0] < 0 ? INFINITY : hypot((double)(a[0] - b[0]), (double)(a[1] - b[1]));
}

static double mean_side(const FfpImage *map) {
    double sum = 0;
    int64_t count = 0;
    for (int y = 0; y < map->height; y++)
        for (int x = 0; x + 1 < map->width; x++) {
            const double length = side(at(map, x, y), at(map, x + 1, y));
            if (length < INFINITY) sum += length, count++;
        }
    return count ? sum / (double)count : 0;
}

static bool is_whole(const Net *net, int x, int y, int size) {
    const FfpImage *map = net->map;
    if (x + size >= map->width || y + size >= map->height) return false;
    const real *a = at(map, x, y), *b = at(map, x + size, y), *c = at(map, x, y + size),
               *d = at(map, x + size, y + size);
    return side(a, b) <= net->reach * size && side(c, d) <= net->reach * size &&
           side(a, c) <= net->reach * size && side(b, d) <= net->reach * size;
}

static uint32_t corner(Net *net, int x, int y) {
    FfpWarp *warp = net->warp;
    const FfpImage *map = net->map;
    uint32_t *number = &net->number[(size_t)y * (size_t)map->width + (size_t)x];
    if (*number) return *number - 1;
    if (warp->n_corners == net->room[0]) {
        net->room[0] = 2 * net->room[0] + 1024;
        warp->position = ffp_grow(warp->position, 3 * net->room[0], sizeof(real));
        warp->texture = ffp_grow(warp->texture, 2 * net->room[0], sizeof(real));
    }
    const real *seen = at(map, x, y);
    real *place = warp->position + 3 * (size_t)warp->n_corners,
         *from = warp->texture + 2 * (size_t)warp->n_corners;
    place[0] = ((real)x + 0.5F) / (real)map->width;
    place[1] = 1 - ((real)y + 0.5F) / (real)map->height;
    place[2] = 0;
    from[0] = seen[0] / (real)net->camera->width;
    from[1] = 1 - seen[1] / (real)net->camera->height;
    *number = ++warp->n_corners;
    return *number - 1;
}

// A cell of `size` pixels, or its quarters where it is not whole.
static void add_cell(Net *net, int x, int y, int size) {
    FfpWarp *warp = net->warp;
    if (!is_whole(net, x, y, size)) {
        const int half = size / 2;
        for (int k = 0; half > 0 && k < 4; k++) add_cell(net, x + k % 2 * half, y + k / 2 * half, half);
        return;
    }
    if (warp->n_triangles + 2 > net->room[1]) {
        net->room[1] = 2 * net->room[1] + 2048;
        warp->corners = ffp_grow(warp->corners, 3 * net->room[1], sizeof *warp->corners);
    }
    const uint32_t a = corner(net, x, y), b = corner(net, x + size, y), c = corner(net, x, y + size),
                   d = corner(net, x + size, y + size),
                   cell[6] = {a, c, d, a, d, b}; // counter-clockwise, y up
    memcpy(warp->corners + 3 * warp->n_triangles, cell, sizeof cell);
    warp->n_triangles += 2;
}

FfpWarp ffp_warp_of_map(const FfpImage *map, const FfpCamera *camera) {
    const int longest = map->width > map->height ? map->width : map->height;
    int step = 1;
    while (step * CELLS < longest) step *= 2;
    FfpWarp warp = {0};
    Net net = {.map = map, .camera = camera, .reach = STEP * mean_side(map), .warp = &warp};
    net.number = ffp_alloc((size_t)map->width * (size_t)map->height, sizeof *net.number);
    for (int y = 0; y < map->height; y += step)
        for (int x = 0; x < map->width; x += step) add_cell(&net, x, y, step);
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
