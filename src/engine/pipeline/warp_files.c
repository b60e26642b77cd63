#include "engine/pipeline/warp_files.h"
#include <math.h>
#include <stdint.h>
#include "core/base/file.h"

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
    uint32_t *number;       // of the corners, from 1; 0: none
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

static void print_corners(const Net *net, FILE *out) {
    uint32_t count = 0;
    for (int j = 0; j < net->down; j++)
        for (int i = 0; i < net->across; i++) {
            const real *seen = corner(net, i, j);
            if (seen[0] < 0) continue;
            net->number[j * net->across + i] = ++count;
            fprintf(out, "v %.6f %.6f 0\nvt %.6f %.6f\n", (i * net->step + 0.5) / net->map->width,
                    1 - (j * net->step + 0.5) / net->map->height, (double)seen[0] / net->camera->width,
                    1 - (double)seen[1] / net->camera->height);
        }
}

static void print_triangles(const Net *net, FILE *out) {
    for (int j = 0; j + 1 < net->down; j++)
        for (int i = 0; i + 1 < net->across; i++) {
            const uint32_t *n = net->number + j * net->across + i;
            const uint32_t a = n[0], b = n[1], c = n[net->across], d = n[net->across + 1];
            if (!is_whole(net, i, j)) continue; // counter-clockwise, with y up
            fprintf(out, "f %u/%u %u/%u %u/%u\nf %u/%u %u/%u %u/%u\n", a, a, c, c, d, d, a, a, d, d, b, b);
        }
}

bool ffp_write_warp(const FfpImage *map, const FfpCamera *camera, const char *path, FfpError *err) {
    const int longest = map->width > map->height ? map->width : map->height;
    Net net = {.map = map, .camera = camera, .step = (longest + CELLS - 1) / CELLS};
    FfpOutput out;
    net.across = (map->width - 1) / net.step + 1;
    net.down = (map->height - 1) / net.step + 1;
    net.reach = STEP * mean_side(&net);
    if (!ffp_output_open(&out, path, err)) return false;
    net.number = ffp_alloc((size_t)net.across * (size_t)net.down, sizeof *net.number);
    fprintf(out.stream, "# x, y: the projector's picture, 0 to 1; texture: the camera's\n");
    print_corners(&net, out.stream);
    print_triangles(&net, out.stream);
    ffp_free(net.number);
    return ffp_output_commit(&out, err);
}
