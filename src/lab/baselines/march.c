#include "lab/baselines/march.h"
#include <string.h>
#include <tgmath.h>
#include "core/base/alloc.h"
#include "lab/baselines/kernels/kernels.h"
#include "lab/baselines/light.h"

enum {
    N = FFP_FIELD_CELLS,
    BEHIND = 2, // points of a ray behind where nothing is seen any more
    START = 3,  // cells before a point that throw no shadow on it
    BATCH = 4096,
    ROW = BATCH + FFP_FIELD_BLOCK
};
#define CELL (2.0F / N)
#define LEAST 0.3F  // density of a cell worth looking at: a 200th of the light a step
#define OPAQUE 7.0F // optical depth behind which nothing is seen

FfpFieldRay ffp_field_ray(const FfpCamera *camera, real x, real y) {
    FfpFieldRay ray;
    ray.ahead = ffp_pixel_ray(camera, x, y, ray.direction);
    for (int k = 0; k < 3; k++) ray.origin[k] = camera->pose[4 * k + 3];
    return ray;
}

// Where the line enters and leaves the unit sphere; false when it does not.
static bool cross_sphere(const real origin[3], const real direction[3], real *from, real *to) {
    const real b = ffp_dot3(origin, direction), c = ffp_dot3(origin, origin) - 1, square = b * b - c;
    if (!(square > 0)) return false;
    const real half = sqrt(square);
    *from = -b - half > 0 ? -b - half : 0;
    *to = -b + half;
    return *to > *from;
}

static inline int axis_cell(real x) {
    const int i = (int)((x + 1) * (N / 2));
    return i < 0 ? 0 : i < N ? i : N - 1;
}

static inline real density_at(const FfpNeuralField *field, const real origin[3], const real direction[3],
                              real t) {
    const int x = axis_cell(origin[0] + t * direction[0]), y = axis_cell(origin[1] + t * direction[1]),
              z = axis_cell(origin[2] + t * direction[2]);
    return field->density[((size_t)z * N + (size_t)y) * N + (size_t)x];
}

int ffp_field_march(const FfpNeuralField *field, const FfpFieldRay *ray, real jitter, bool explores,
                    real distance[FFP_FIELD_ON_RAY]) {
    real from, to, depth = 0;
    int count = 0, behind = 0;
    if (!cross_sphere(ray->origin, ray->direction, &from, &to)) return 0;
    const int steps = (int)ceil((to - from) / field->step - jitter);
    for (int i = 0; i < steps && count < FFP_FIELD_ON_RAY; i++) {
        const real t = from + ((real)i + jitter) * field->step;
        const real density = density_at(field, ray->origin, ray->direction, t);
        if (!(density > (explores ? 0 : LEAST))) continue;
        distance[count++] = t;
        depth += density * field->step;
        if (depth > OPAQUE && ++behind > BEHIND) break;
    }
    return count;
}

real ffp_field_transmittance(const FfpNeuralField *field, const real point[3], const real lamp[3]) {
    real direction[3], from, to, depth = 0;
    for (int k = 0; k < 3; k++) direction[k] = lamp[k] - point[k];
    const real away = ffp_normalise3(direction);
    if (!cross_sphere(point, direction, &from, &to)) return 1;
    const int steps = (int)ceil(fmin(to, away) / CELL);
    for (int i = START; i < steps && depth < OPAQUE; i++) {
        const real density = density_at(field, point, direction, (real)i * CELL);
        if (density >= LEAST) depth += density * CELL;
    }
    return exp(-depth);
}

// --- The visual hull. ---

// The largest coverage within `reach` pixels of each pixel, along rows and columns in turn.
static void spread(const FfpView *view, int reach, real *out, real *rows) {
    const int width = view->camera.width, height = view->camera.height;
    for (int y = 0; y < height; y++)
        for (int x = 0; x < width; x++) {
            real most = 0;
            for (int i = x - reach < 0 ? 0 : x - reach; i <= x + reach && i < width; i++)
                most = fmax(most, view->coverage.data[y * width + i]);
            rows[y * width + x] = most;
        }
    for (int y = 0; y < height; y++)
        for (int x = 0; x < width; x++) {
            real most = 0;
            for (int i = y - reach < 0 ? 0 : y - reach; i <= y + reach && i < height; i++)
                most = fmax(most, rows[i * width + x]);
            out[y * width + x] = most;
        }
}

// Pixels that a cell's half diagonal is long in a view, and one for the outline.
static int cell_reach(const FfpCamera *camera) {
    real away = 0;
    for (int k = 0; k < 3; k++) away += camera->pose[4 * k + 3] * camera->pose[4 * k + 3];
    const real nearest = fmax(sqrt(away) - 1, (real)0.1F);
    return 1 + (int)ceil((real)0.87F * CELL * camera->fx / nearest);
}

static void carve_view(FfpNeuralField *field, const FfpView *view, const real *coverage) {
    const FfpCamera *camera = &view->camera;
    const int width = ffp_frame_width(view), height = ffp_frame_height(view);
#pragma omp parallel for schedule(static)
    for (int z = 0; z < N; z++)
        for (int i = 0; i < N * N; i++) {
            real *density = &field->density[(size_t)z * N * N + (size_t)i];
            const real point[3] = {((real)(i % N) + 0.5F) * CELL - 1, ((real)(i / N) + 0.5F) * CELL - 1,
                                   ((real)z + 0.5F) * CELL - 1};
            real x, y;
            if (!(*density > 0) || !(ffp_project(camera, point, &x, &y) > 0)) continue;
            if (!(x >= 0 && y >= 0 && x < (real)width && y < (real)height)) continue;
            if (!(coverage[(int)y * camera->width + (int)x] > 0)) *density = 0;
        }
}

int64_t ffp_field_carve(FfpNeuralField *field, const FfpCapture *capture) {
    int64_t left = 0;
    for (int i = 0; i < N * N * N; i++) {
        const real p[3] = {((real)(i % N) + 0.5F) * CELL - 1, ((real)(i / N % N) + 0.5F) * CELL - 1,
                           ((real)(i / N / N) + 0.5F) * CELL - 1};
        if (ffp_dot3(p, p) > 1) field->density[i] = 0;
    }
    for (int v = 0; v < capture->n_views; v++) {
        const FfpView *view = &capture->views[v];
        const size_t pixels = (size_t)view->camera.width * (size_t)view->camera.height;
        real *coverage = ffp_alloc(2 * pixels, sizeof *coverage);
        spread(view, cell_reach(&view->camera), coverage, coverage + pixels);
        carve_view(field, view, coverage);
        ffp_free(coverage);
    }
    for (int i = 0; i < N * N * N; i++) left += field->density[i] > 0;
    return left;
}

// --- Densities renewed. ---

FfpFieldCells ffp_field_cells_new(const FfpNeuralField *field) {
    FfpFieldCells cells = {0};
    for (int i = 0; i < N * N * N; i++) cells.count += field->density[i] > 0;
    cells.cell = ffp_alloc((size_t)cells.count, sizeof *cells.cell);
    int64_t n = 0;
    for (int i = 0; i < N * N * N; i++)
        if (field->density[i] > 0) cells.cell[n++] = i;
    cells.position = ffp_alloc(3 * (size_t)ROW, sizeof(real));
    cells.encoded = ffp_alloc(FFP_FIELD_ENCODED * (size_t)ROW, sizeof(real));
    cells.raw = ffp_alloc(FFP_GEOMETRY_OUTPUTS * (size_t)ROW, sizeof(real));
    cells.hidden[0] = ffp_alloc(FFP_FIELD_WIDTH * (size_t)ROW, sizeof(real));
    return cells;
}

void ffp_field_cells_free(FfpFieldCells *cells) {
    ffp_free(cells->cell);
    ffp_free(cells->position);
    ffp_free(cells->encoded);
    ffp_free(cells->raw);
    ffp_free(cells->hidden[0]);
    *cells = (FfpFieldCells){0};
}

// The cell `ahead` places behind the one whose turn it is.
static int32_t cell_in_turn(const FfpFieldCells *cells, int64_t ahead) {
    return cells->cell[(cells->next + ahead) % cells->count];
}

static void renew_batch(FfpFieldCells *cells, FfpNeuralField *field, int64_t count, FfpRng *rng) {
    const FfpFieldKernels *k = ffp_field_kernels();
    for (int64_t i = 0; i < count; i++) {
        const int32_t cell = cell_in_turn(cells, i);
        const int at[3] = {cell % N, cell / N % N, cell / N / N};
        for (int a = 0; a < 3; a++)
            cells->position[a * ROW + i] = ((real)at[a] + ffp_rng_uniform(rng)) * CELL - 1;
    }
    const FfpNetRows rows = {.stride = ROW,
                             .columns = ffp_field_padded(count),
                             .in = cells->encoded,
                             .hidden = {cells->hidden[0]},
                             .out = cells->raw};
    k->encode(&field->layout, field->parameters, cells->position, count, ROW, cells->encoded);
    k->forward(&field->layout.geometry, field->parameters, &rows);
    for (int64_t i = 0; i < count; i++) {
        real *density = &field->density[cell_in_turn(cells, i)];
        *density = 0.5F * (*density + ffp_field_density(cells->raw[FFP_GEOMETRY_DENSITY * ROW + i]));
    }
    cells->next = (cells->next + count) % cells->count;
}

void ffp_field_cells_renew(FfpFieldCells *cells, FfpNeuralField *field, int64_t count, FfpRng *rng) {
    while (count > 0) {
        const int64_t now = count < BATCH ? count : BATCH;
        renew_batch(cells, field, now < cells->count ? now : cells->count, rng);
        count -= now;
    }
}
