// The result in COLMAP's files.
#include <math.h>
#include <string.h>
#include "core/base/alloc.h"
#include "core/base/file.h"
#include "rig/optics/colmap_write.h"
#include "rig/selfcal/selfcal.h"

enum { NAME = 300 };

typedef struct World { // the first known place's camera
    FfpRigid from;     // the projector's frame to it
    double scale;
} World;

static World world_of(const FfpBundle *b, double scale) {
    int first = 0;
    while (!b->known[first]) first++;
    return (World){b->places[first], scale};
}

// pose: the projector's frame to a device's.
static FfpRigid in_world(const World *world, const FfpRigid *pose) {
    FfpRigid out, back;
    ffp_rigid_inverse(&world->from, &back);
    ffp_rigid_product(pose, &back, &out);
    for (int k = 0; k < 3; k++) out.t[k] *= world->scale;
    return out;
}

static FfpOptics optics_of(const FfpBundleDevice *d, int width, int height) {
    FfpOptics optics = {width, height, d->fx, d->fy, d->x, d->y, {0}};
    memcpy(optics.lens, d->lens, sizeof optics.lens);
    return optics;
}

// Places may have cameras of their own.
static bool has_own(const FfpBundle *b) {
    return b->own_usual[FFP_OWN_X] > 0;
}

// The camera, or that of each known place, and the projector; their number.
static int set_devices(const FfpBundle *b, FfpOptics *devices) {
    const FfpTracks *t = b->tracks;
    const FfpBundleDevice projector = ffp_bundle_projector(t, b->optics);
    int n = 0;
    for (int p = 0; p < t->n_places && (has_own(b) || n == 0); p++) {
        const FfpBundleDevice camera = ffp_bundle_camera_at(t, b->optics, b->own[p]);
        if (b->known[p]) devices[n++] = optics_of(&camera, t->width, t->height);
    }
    devices[n] = optics_of(&projector, t->panel_width, t->panel_height);
    return n + 1;
}

// A picture for each known place, and the projector's; their number.
static int set_images(const FfpBundle *b, const World *world, FfpColmapImage *images, char (*names)[NAME]) {
    const FfpRigid itself = {{1, 0, 0, 0, 1, 0, 0, 0, 1}, {0}};
    int n = 0;
    for (int p = 0; p < b->tracks->n_places; p++) {
        if (!b->known[p]) continue;
        snprintf(names[n], NAME, "%s.jpg", ffp_basename(b->tracks->places[p].name));
        images[n] = (FfpColmapImage){names[n], has_own(b) ? n : 0, in_world(world, &b->places[p])};
        n++;
    }
    images[n] = (FfpColmapImage){FFP_COLMAP_PROJECTOR ".jpg", has_own(b) ? n : 1, in_world(world, &itself)};
    return n + 1;
}

// How far a point's sightings lie from where it puts them, root mean square; their number in *n.
static double error_of(const FfpBundle *b, int track, const double point[3], int *n) {
    double sum = 0, at[2];
    *n = 0;
    for (int k = 0; k < b->tracks->tracks[track].n; k++) {
        const FfpSighting *s = &b->tracks->sightings[b->tracks->tracks[track].first + k];
        if (!s->used || !b->known[s->place] || !ffp_bundle_see(b, s->place, point, at)) continue;
        sum += pow(at[0] - s->at[0], 2) + pow(at[1] - s->at[1], 2);
        ++*n;
    }
    return sqrt(sum / fmax(1, *n));
}

// Those that two places see or more.
static size_t set_points(const FfpBundle *b, const World *world, FfpColmapPoint *points) {
    size_t found = 0;
    for (int i = 0; i < b->tracks->n; i++) {
        FfpColmapPoint *p = &points[found];
        double point[3];
        int n;
        if (!ffp_bundle_point(b, i, point)) continue;
        p->error = error_of(b, i, point, &n);
        if (n < 2) continue;
        for (int k = 0; k < 3; k++) {
            p->at[k] = world->scale * (ffp_dot(world->from.r + 3 * (size_t)k, point) + world->from.t[k]);
            p->colour[k] = (unsigned char)lround(255 * fmax(0, fmin(1, (double)b->tracks->tracks[i].light)));
        }
        found++;
    }
    return found;
}

bool ffp_self_calibration_write(const FfpBundle *b, double scale, const char *folder, FfpError *err) {
    const World world = world_of(b, scale);
    FfpOptics devices[FFP_PLACES_MAX + 1];
    FfpColmapImage images[FFP_PLACES_MAX + 1];
    char(*names)[NAME] = ffp_alloc(FFP_PLACES_MAX, sizeof *names);
    FfpColmapPoint *points = ffp_alloc((size_t)b->tracks->n + 1, sizeof *points);
    const FfpColmapModel model = {.cameras = devices,
                                  .images = images,
                                  .points = points,
                                  .n_cameras = set_devices(b, devices),
                                  .n_images = set_images(b, &world, images, names),
                                  .n_points = set_points(b, &world, points)};
    FfpOutput out;
    bool ok = ffp_output_open_folder(&out, folder, true, err);
    if (ok) {
        ok = ffp_colmap_write(&model, out.temporary, err) && ffp_output_commit(&out, err);
        ffp_output_abort(&out);
    }
    ffp_free(names), ffp_free(points);
    return ok;
}
