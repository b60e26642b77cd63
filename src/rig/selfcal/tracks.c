#include <math.h>
#include <string.h>
#include "core/base/alloc.h"
#include "core/base/call.h"
#include "rig/selfcal/places.h"

#define SPOTS_A_SIDE 130.0 // of the panel's longer one, at most
#define RADIUS 2.5         // of a spot, in distances of neighbouring pixels on the panel
#define RADIUS_LEAST 2.0   // panel pixels
#define OFF_CENTRE 0.35    // of the radius: the mean of its pixels
#define UNEVEN 0.7         // pixels of the map: root mean square about the plane
enum { PIXELS_LEAST = 8 };

typedef struct Spot { // sums over its pixels; u, v on the panel from the spot, x, y in the map
    double n, u, v, uu, uv, vv, x, y, ux, vx, uy, vy, xx, yy, light;
} Spot;

typedef struct Grid {
    int columns, rows;
    double pitch, radius; // panel pixels
    Spot *spots;          // [rows,columns]
} Grid;

static void add_pixel(const Grid *grid, const real *position, double x, double y, double light) {
    const double pu = (double)position[0], pv = (double)position[1];
    const int column = (int)floor(pu / grid->pitch), row = (int)floor(pv / grid->pitch);
    if (column < 0 || row < 0 || column >= grid->columns || row >= grid->rows) return;
    const double u = pu - (column + 0.5) * grid->pitch, v = pv - (row + 0.5) * grid->pitch;
    if (hypot(u, v) > grid->radius) return;
    Spot *s = &grid->spots[(size_t)row * (size_t)grid->columns + (size_t)column];
    s->n++, s->u += u, s->v += v, s->uu += u * u, s->uv += u * v, s->vv += v * v;
    s->x += x, s->y += y, s->ux += u * x, s->vx += v * x, s->uy += u * y, s->vy += v * y;
    s->xx += x * x, s->yy += y * y, s->light += light;
}

// One coordinate over (u, v): its value at the spot, its slopes, and the mean square about the plane.
static double plane_at(const Spot *s, double mean, double ux, double vx, double square, double slope[2],
                       double *left) {
    const double uu = s->uu / s->n - s->u * s->u / (s->n * s->n),
                 uv = s->uv / s->n - s->u * s->v / (s->n * s->n),
                 vv = s->vv / s->n - s->v * s->v / (s->n * s->n);
    const double a = ux / s->n - s->u / s->n * mean, b = vx / s->n - s->v / s->n * mean;
    const double determinant = uu * vv - uv * uv;
    const double du = (a * vv - b * uv) / determinant, dv = (b * uu - a * uv) / determinant;
    *left = square / s->n - mean * mean - du * a - dv * b;
    slope[0] = du, slope[1] = dv;
    return mean - du * s->u / s->n - dv * s->v / s->n;
}

// Where the spot is in the map; false where its pixels do not lie around it on one surface.
static bool place_spot(const Grid *grid, const Spot *s, double at[2], double slope[4]) {
    double left[2];
    if (s->n < PIXELS_LEAST || hypot(s->u, s->v) > OFF_CENTRE * grid->radius * s->n) return false;
    const double uu = s->uu - s->u * s->u / s->n, uv = s->uv - s->u * s->v / s->n,
                 vv = s->vv - s->v * s->v / s->n;
    if (!(uu * vv - uv * uv > 0.1 * uu * vv)) return false; // all on a line
    at[0] = plane_at(s, s->x / s->n, s->ux, s->vx, s->xx, slope, &left[0]);
    at[1] = plane_at(s, s->y / s->n, s->uy, s->vy, s->yy, slope + 2, &left[1]);
    return left[0] + left[1] < UNEVEN * UNEVEN;
}

static Grid grid_new(const FfpTracks *tracks, double step) {
    const double longer = fmax(tracks->panel_width, tracks->panel_height);
    Grid grid = {.radius = fmax(RADIUS_LEAST, RADIUS * step)};
    grid.pitch = fmax(2 * grid.radius, longer / SPOTS_A_SIDE);
    grid.columns = (int)ceil(tracks->panel_width / grid.pitch);
    grid.rows = (int)ceil(tracks->panel_height / grid.pitch);
    grid.spots = ffp_alloc((size_t)grid.columns * (size_t)grid.rows, sizeof *grid.spots);
    return grid;
}

static void add_map(const Grid *grid, const FfpImage *map, const FfpImage *white) {
    const size_t spots = (size_t)grid->columns * (size_t)grid->rows;
    for (size_t i = 0; i < spots; i++) grid->spots[i] = (Spot){0};
    for (int y = 0; y < map->height; y++)
        for (int x = 0; x < map->width; x++) {
            const size_t i = (size_t)y * (size_t)map->width + (size_t)x;
            const real *p = map->data + 3 * i;
            // Sums about the picture's middle: they are of pixels, and are squared.
            if (p[2] > 0)
                add_pixel(grid, p, x + 0.5 - 0.5 * map->width, y + 0.5 - 0.5 * map->height,
                          white->data ? (double)white->data[i] : 0);
        }
}

typedef struct Seen { // of a spot, by one place
    double at[2], slope[4], light;
    bool there;
} Seen;

// One place's view of the grid: [rows * columns].
static void look(const Grid *grid, const FfpImage *map, const FfpImage *white, int shrink, Seen *seen) {
    const size_t spots = (size_t)grid->columns * (size_t)grid->rows;
    if (!map->data) return;
    add_map(grid, map, white);
    for (size_t i = 0; i < spots; i++) {
        const Spot *s = &grid->spots[i];
        Seen *to = &seen[i];
        to->there = place_spot(grid, s, to->at, to->slope);
        if (!to->there) continue;
        to->at[0] = (to->at[0] + 0.5 * map->width) * shrink;
        to->at[1] = (to->at[1] + 0.5 * map->height) * shrink;
        for (int k = 0; k < 4; k++) to->slope[k] *= shrink;
        to->light = s->light / s->n;
    }
}

static void add_track(FfpTracks *out, const Grid *grid, Seen *const *seen, size_t spot) {
    FfpTrack *track = &out->tracks[out->n];
    double light = 0;
    out->grid[spot] = -1;
    *track = (FfpTrack){.panel = {((double)(spot % (size_t)grid->columns) + 0.5) * grid->pitch,
                                  ((double)(spot / (size_t)grid->columns) + 0.5) * grid->pitch},
                        .first = out->n_sightings};
    for (int p = 0; p < out->n_places; p++) {
        const Seen *s = &seen[p][spot];
        if (!s->there) continue;
        FfpSighting *sighting = &out->sightings[out->n_sightings++];
        *sighting = (FfpSighting){.place = p, .used = true, .light = (float)s->light};
        memcpy(sighting->at, s->at, sizeof s->at), memcpy(sighting->slope, s->slope, sizeof s->slope);
        out->places[p].seen++;
        light += s->light;
        track->n++;
    }
    if (track->n == 0) return;
    track->light = (float)(light / track->n);
    out->grid[spot] = out->n++;
}

void ffp_tracks_find(FfpTracks *tracks, const FfpImage *maps, const FfpImage *whites, int shrink,
                     double step) {
    const Grid grid = grid_new(tracks, step);
    const size_t spots = (size_t)grid.columns * (size_t)grid.rows;
    Seen **seen = ffp_alloc((size_t)tracks->n_places, sizeof *seen);
    for (int p = 0; p < tracks->n_places; p++) {
        seen[p] = ffp_alloc(spots, sizeof **seen);
        look(&grid, &maps[p], &whites[p], shrink, seen[p]);
        ffp_cancel_point();
    }
    tracks->columns = grid.columns, tracks->rows = grid.rows, tracks->pitch = grid.pitch;
    tracks->grid = ffp_alloc(spots, sizeof *tracks->grid);
    tracks->tracks = ffp_alloc(spots, sizeof *tracks->tracks);
    tracks->sightings = ffp_alloc(spots * (size_t)tracks->n_places, sizeof *tracks->sightings);
    for (size_t i = 0; i < spots; i++) add_track(tracks, &grid, seen, i);
    for (int p = 0; p < tracks->n_places; p++) ffp_free(seen[p]);
    ffp_free(seen);
    ffp_free(grid.spots);
}

double ffp_tracks_noise(const FfpTracks *t, const void *fit,
                        bool (*miss)(const void *fit, int track, int place, double off[2])) {
    double sum = 0;
    int n = 0;
    for (int cell = 0; cell + 1 < t->columns * t->rows; cell++) {
        const int first = t->grid[cell], second = t->grid[cell + 1];
        if (first < 0 || second < 0 || (cell + 1) % t->columns == 0) continue;
        for (int p = 0; p < t->n_places; p++) {
            double a[2], b[2];
            if (!miss(fit, first, p, a) || !miss(fit, second, p, b)) continue;
            sum += 0.5 * (pow(a[0] - b[0], 2) + pow(a[1] - b[1], 2));
            n++;
        }
    }
    return n > 0 ? sqrt(sum / n) : 0;
}

void ffp_tracks_free(FfpTracks *tracks) {
    ffp_free(tracks->places), ffp_free(tracks->tracks), ffp_free(tracks->sightings);
    ffp_free(tracks->grid);
    *tracks = (FfpTracks){0};
}
