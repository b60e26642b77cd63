#include "rig/optics/colmap_write.h"
#include <stdio.h>
#include "core/base/file.h"

static void print_cameras(FILE *f, const FfpColmapModel *m) {
    for (int i = 0; i < m->n_cameras; i++) {
        const FfpOptics *o = &m->cameras[i];
        if (o->fx == o->fy && o->lens[2] == 0 && o->lens[3] == 0 && o->lens[4] == 0)
            fprintf(f, "%d RADIAL %d %d %.12g %.12g %.12g %.12g %.12g\n", i + 1, o->width, o->height, o->fx,
                    o->cx, o->cy, o->lens[0], o->lens[1]);
        else
            fprintf(f, "%d FULL_OPENCV %d %d %.12g %.12g %.12g %.12g %.12g %.12g %.12g %.12g %.12g 0 0 0\n",
                    i + 1, o->width, o->height, o->fx, o->fy, o->cx, o->cy, o->lens[0], o->lens[1],
                    o->lens[2], o->lens[3], o->lens[4]);
    }
}

static void print_images(FILE *f, const FfpColmapModel *m) {
    for (int i = 0; i < m->n_images; i++) {
        const FfpColmapImage *image = &m->images[i];
        const double *t = image->pose.t;
        double q[4];
        ffp_rotation_to_quaternion(image->pose.r, q);
        fprintf(f, "%d %.15g %.15g %.15g %.15g %.15g %.15g %.15g %d %s\n\n", i + 1, q[0], q[1], q[2], q[3],
                t[0], t[1], t[2], image->camera + 1, image->name);
    }
}

static void print_points(FILE *f, const FfpColmapModel *m) {
    for (size_t i = 0; i < m->n_points; i++) {
        const FfpColmapPoint *p = &m->points[i];
        fprintf(f, "%zu %.9g %.9g %.9g %d %d %d %.4g\n", i + 1, p->at[0], p->at[1], p->at[2], p->colour[0],
                p->colour[1], p->colour[2], p->error);
    }
}

static bool write_one(const FfpColmapModel *model, void (*print)(FILE *, const FfpColmapModel *),
                      const char *folder, const char *name, FfpError *err) {
    char path[FFP_PATH_MAX];
    FfpOutput out;
    if (!ffp_join_path(path, folder, name))
        return ffp_fail(err, FFP_ERROR_ARGUMENT, folder, "the path is too long");
    if (!ffp_output_open(&out, path, err)) return false;
    print(out.stream, model);
    const bool ok = ffp_output_commit(&out, err);
    ffp_output_abort(&out);
    return ok;
}

bool ffp_colmap_write(const FfpColmapModel *model, const char *folder, FfpError *err) {
    return write_one(model, print_cameras, folder, "cameras.txt", err) &&
           write_one(model, print_images, folder, "images.txt", err) &&
           write_one(model, print_points, folder, "points3D.txt", err);
}
