// Turntables as the sightings of their stops, without pictures, sound ones and those with a fault.
#ifndef FFP_TESTS_TABLES_H
#define FFP_TESTS_TABLES_H

#include <math.h>
#include <string.h>
#include "core/base/alloc.h"
#include "core/base/lens.h"
#include "core/base/rng.h"
#include "rig/selfcal/selfcal.h"

enum {
    WIDTH = 640,
    HEIGHT = 480,
    PANEL_WIDTH = 800,
    PANEL_HEIGHT = 500,
    STOPS = 8,
    PITCH = 11,
    TABLE_STOPS_MOST = 16
};
enum { MARCH = 120 };
#define NOISE 0.05 // pixels
#define CAMERA 760.0
#define PROJECTOR 900.0
#define STEP 0.02 // of a ray's way to the surface
#define RADIUS 0.45

static const double camera_lens[5] = {-0.08, 0.02, 0, 0, 0}, projector_lens[5] = {-0.04, 0, 0, 0, 0};
static const double axis_point[3] = {0.02, 0.1, 2.2}; // camera's frame; the projector is one unit away

// Differences from a sound turntable.
typedef struct Table {
    bool round;                      // the object is the same from all sides
    bool mirrored;                   // pictures
    bool reversed;                   // it turns the other way
    double apart;                    // degrees between the rays of camera and projector; 0: 25
    double less;                     // share by which it turns less than is said
    double hand;                     // degrees by which angles are off
    int moved;                       // stop before which the object falls over; 0: it stands
    int twin;                        // stop at which it stands as at the one before; 0: none
    double lens;                     // the focal length that the user gives, pixels; 0: none
    int stops;                       // 0: STOPS
    int pitch;                       // of the spots, panel pixels; 0: PITCH
    double camera, projector;        // focal lengths, pixels; 0: CAMERA, PROJECTOR
    double noise;                    // pixels; 0: NOISE
    double relief[4];                // amplitude and phase of its two waves, of the usual; 0: the usual
    double zoomed[TABLE_STOPS_MOST]; // logarithm of the focal length at a stop
    double stretched, leaning;       // of the panel's picture: in x; of its columns
    uint64_t seed;
} Table;

static void axis_direction(double u[3]) {
    const double up[3] = {0.03, -0.95, -0.3};
    memcpy(u, up, sizeof up);
    ffp_unit(u);
}

static int stops_of(const Table *table) {
    return table->stops > 0 ? table->stops : STOPS;
}

static int pitch_of(const Table *table) {
    return table->pitch > 0 ? table->pitch : PITCH;
}

static double camera_of(const Table *table) {
    return table->camera > 0 ? table->camera : CAMERA;
}

static double projector_of(const Table *table) {
    return table->projector > 0 ? table->projector : PROJECTOR;
}

static double angle_of(const Table *table, int stop) { // radians, in truth
    if (table->twin > 0 && stop == table->twin) stop--;
    const double degrees = 360.0 / stops_of(table) * (1 - table->less) * stop + table->hand * sin(7.0 * stop);
    return (table->reversed ? -degrees : degrees) * FFP_PI_DOUBLE / 180;
}

static FfpRigid projector_pose(const Table *table) { // camera's frame to the projector's
    const double apart = (table->apart > 0 ? table->apart : 25) * FFP_PI_DOUBLE / 180;
    const double turn[3] = {0.02, -apart, 0.01}, far = axis_point[2];
    const double from[3] = {-far * sin(apart), -0.3 * apart, far * (1 - cos(apart))};
    FfpRigid pose;
    ffp_rotation_from_vector(turn, pose.r);
    for (int k = 0; k < 3; k++) pose.t[k] = -ffp_dot(pose.r + 3 * (size_t)k, from);
    return pose;
}

// Beyond the surface of the object at a stop, or within it: below 0.
static double outside(const Table *table, int stop, const double x[3]) {
    double vector[3], turn[9], from[3], y[3], u[3];
    axis_direction(u);
    for (int k = 0; k < 3; k++) vector[k] = angle_of(table, stop) * u[k], from[k] = x[k] - axis_point[k];
    if (table->moved > 0 && stop >= table->moved) vector[0] += 0.5;
    ffp_rotation_from_vector(vector, turn);
    for (int k = 0; k < 3; k++) y[k] = turn[k] * from[0] + turn[3 + k] * from[1] + turn[6 + k] * from[2];
    const double r = sqrt(ffp_dot(y, y)), height = ffp_dot(y, u) / r;
    const double around = atan2(y[0], y[2]);
    const double relief =
        table->round ? 0.1 * sin(5 * height)
                     : 0.15 * (1 + table->relief[0]) * sin(3 * around + 2 * height + table->relief[1]) +
                           0.1 * (1 + table->relief[2]) * cos(2 * around - 5 * height + table->relief[3]);
    return r - RADIUS * (1 + relief * sqrt(1 - height * height));
}

// Where a ray first meets it.
static bool meet(const Table *table, int stop, const double from[3], const double ray[3], double x[3]) {
    double before = 0;
    for (int i = 0; i < MARCH; i++) {
        const double s = 1.2 + i * STEP;
        for (int k = 0; k < 3; k++) x[k] = from[k] + s * ray[k];
        if (outside(table, stop, x) > 0) {
            before = s;
            continue;
        }
        double after = s;
        for (int halving = 0; halving < 40; halving++) {
            const double middle = 0.5 * (before + after);
            for (int k = 0; k < 3; k++) x[k] = from[k] + middle * ray[k];
            if (outside(table, stop, x) > 0)
                before = middle;
            else
                after = middle;
        }
        return true;
    }
    return false;
}

static bool see_spot(const Table *table, int stop, const double panel[2], double at[2]) {
    double ray[3] = {0, 0, 1}, turned[3], x[3], back[3], first[3], u, v;
    const FfpRigid pose = projector_pose(table);
    FfpRigid camera;
    ffp_rigid_inverse(&pose, &camera);
    const double lit_y = (panel[1] - 0.5 * PANEL_HEIGHT - 0.05 * PANEL_WIDTH) / projector_of(table),
                 lit_x = (panel[0] - 0.51 * PANEL_WIDTH) / projector_of(table) * (1 + table->stretched) +
                         table->leaning * lit_y;
    if (!ffp_lens_undistort(projector_lens, lit_x, lit_y, ray)) return false;
    for (int k = 0; k < 3; k++) turned[k] = ffp_dot(camera.r + 3 * (size_t)k, ray);
    if (!meet(table, stop, camera.t, turned, x)) return false;
    const double origin[3] = {0};
    for (int k = 0; k < 3; k++) back[k] = x[k] / x[2];
    if (!meet(table, stop, origin, back, first) || fabs(first[2] - x[2]) > 1e-6) return false;
    ffp_lens_distort(camera_lens, x[0] / x[2], x[1] / x[2], &u, &v);
    const double focal = camera_of(table) * exp(table->zoomed[stop]);
    at[0] = 0.503 * WIDTH + focal * u, at[1] = 0.498 * HEIGHT + focal * v;
    if (table->mirrored) at[0] = WIDTH - at[0];
    return at[0] >= 0 && at[1] >= 0 && at[0] < WIDTH && at[1] < HEIGHT;
}

static bool add_sighting(const Table *table, int stop, const FfpTrack *track, FfpSighting *s, FfpRng *rng) {
    *s = (FfpSighting){.place = stop, .used = true};
    if (!see_spot(table, stop, track->panel, s->at)) return false;
    for (int k = 0; k < 2; k++) {
        double beside[2] = {track->panel[0], track->panel[1]}, there[2];
        beside[k] += 0.1;
        if (!see_spot(table, stop, beside, there) || hypot(there[0] - s->at[0], there[1] - s->at[1]) > 0.5)
            return false;
        for (int c = 0; c < 2; c++) s->slope[2 * c + k] = (there[c] - s->at[c]) / 0.1;
    }
    for (int k = 0; k < 2; k++)
        s->at[k] += (table->noise > 0 ? table->noise : NOISE) * (double)ffp_rng_normal(rng);
    return true;
}

static FfpTracks table_tracks(const Table *table) {
    const int pitch = pitch_of(table), columns = PANEL_WIDTH / pitch,
              rows = (PANEL_HEIGHT + pitch - 1) / pitch;
    const size_t spots = (size_t)columns * (size_t)rows, stops = (size_t)stops_of(table);
    FfpTracks t = {.width = WIDTH,
                   .height = HEIGHT,
                   .panel_width = PANEL_WIDTH,
                   .panel_height = PANEL_HEIGHT,
                   .n_places = (int)stops,
                   .places = ffp_alloc(stops, sizeof *t.places),
                   .tracks = ffp_alloc(spots, sizeof *t.tracks),
                   .sightings = ffp_alloc(spots * stops, sizeof *t.sightings),
                   .columns = columns,
                   .rows = rows,
                   .pitch = pitch,
                   .grid = ffp_alloc(spots, sizeof *t.grid)};
    FfpRng rng = ffp_rng(5 + table->seed, 1);
    for (size_t i = 0; i < spots; i++) {
        FfpTrack *track = &t.tracks[t.n];
        *track = (FfpTrack){.panel = {pitch * ((double)(i % (size_t)columns) + 0.5),
                                      pitch * ((double)(i / (size_t)columns) + 0.5)},
                            .first = t.n_sightings};
        for (int p = 0; p < t.n_places; p++)
            if (add_sighting(table, p, track, &t.sightings[t.n_sightings], &rng))
                t.n_sightings++, track->n++, t.places[p].seen++;
        t.grid[i] = track->n > 0 ? t.n++ : -1;
    }
    return t;
}

typedef struct Found {
    FfpTracks tracks;
    FfpTurning turning;
    double given[FFP_PLACES_MAX];
} Found;

static bool find(const Table *table, Found *f, FfpError *err) {
    f->tracks = table_tracks(table);
    for (int p = 0; p < f->tracks.n_places; p++) f->given[p] = 2 * FFP_PI_DOUBLE / stops_of(table) * p;
    f->turning = ffp_turning_new(&f->tracks, f->given);
    if (table->lens > 0) f->turning.usual.focal = (FfpKnownFocal){log(table->lens), 0.03};
    return ffp_self_calibration_turn(&f->turning, err);
}

static void forget(Found *f) {
    ffp_turning_free(&f->turning);
    ffp_tracks_free(&f->tracks);
}

#endif
