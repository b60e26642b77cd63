// Gaussians from PLY files: ours, those of 3DGS, 2DGS and gsplat, and SuperSplat's compressed ones.
#include <math.h>
#include <string.h>
#include "core/base/arena.h"
#include "core/base/file.h"
#include "core/base/kind.h"
#include "core/base/log.h"
#include "core/gaussians/elsewhere.h"
#include "core/gaussians/ply_header.h"

#define FILTER "filter_3D" // Mip-Splatting

// Where an element has what we read, counted in its properties; -1: not at all.
typedef struct Columns {
    int number[FFP_ROW_NUMBERS];
    int colour[3];       // red, green, blue, where there are no f_dc
    double colour_white; // their number for 1
    int rest;            // the first of f_rest_*, which follow one another
    int rests;
    bool relightable;
} Columns;

static bool is_splat_number(int i) {
    return i >= FFP_ROW_AMBIENT && i < FFP_ROW_ALBEDO;
}

static bool check_single(const FfpPly *ply, const FfpPlyElement *element, int column, const char *path,
                         FfpError *err) {
    const FfpPlyProperty *property = column < 0 ? NULL : &ply->properties[element->first + column];
    return !property || property->length == FFP_PLY_NO_TYPE ||
           ffp_fail(err, FFP_ERROR_FILE, path, "property %s is a list, not a single number", property->name);
}

// Colours of point clouds; true if the vertices have them.
static bool find_colours(Columns *columns, const FfpPly *ply, const FfpPlyElement *vertex) {
    static const char *const names[3] = {"red", "green", "blue"};
    for (int k = 0; k < 3; k++) columns->colour[k] = ffp_ply_find(ply, vertex, names[k]);
    if (columns->colour[0] < 0 || columns->colour[1] < 0 || columns->colour[2] < 0) return false;
    const FfpPlyType type = ply->properties[vertex->first + columns->colour[0]].type;
    columns->colour_white = type == FFP_PLY_UINT16 ? 65535 : type < FFP_PLY_FLOAT ? 255 : 1;
    return true;
}

// The error for vertices that lack what a splat has.
static bool refuse(const FfpPly *ply, const Columns *columns, int missing, const char *path, FfpError *err) {
    bool any = false;
    for (int i = 0; i < FFP_ROW_NUMBERS; i++) any |= is_splat_number(i) && columns->number[i] >= 0;
    const FfpPlyElement *face = ffp_ply_element(ply, "face");
    if (any || columns->number[0] < 0)
        return ffp_fail(err, FFP_ERROR_FILE, path, "property %s is missing", ffp_row_names[missing]);
    return ffp_fail(err, FFP_ERROR_FILE, path,
                    "is a %s, not Gaussians: its vertices have no opacity, scale_0 and rot_0",
                    face && face->count > 0 ? "mesh" : "point cloud");
}

static bool find_columns(Columns *columns, const FfpPly *ply, const FfpPlyElement *vertex, const char *path,
                         FfpError *err) {
    *columns = (Columns){.rest = ffp_ply_find(ply, vertex, "f_rest_0")};
    for (int i = 0; i < FFP_ROW_NUMBERS; i++) {
        columns->number[i] = ffp_ply_find(ply, vertex, ffp_row_names[i]);
        columns->relightable |= i >= FFP_ROW_ALBEDO && columns->number[i] >= 0;
    }
    while (columns->rest >= 0 && columns->rest + columns->rests < vertex->properties &&
           strncmp(ply->properties[vertex->first + columns->rest + columns->rests].name, "f_rest_", 7) == 0)
        columns->rests++;
    const bool coloured = columns->number[FFP_ROW_AMBIENT] < 0 && find_colours(columns, ply, vertex);
    for (int i = 0; i < FFP_ROW_NUMBERS; i++) {
        const bool optional = i == FFP_ROW_SCALE + 2 || i >= FFP_ROW_SCATTERED ||
                              (i >= FFP_ROW_ALBEDO && !columns->relightable) ||
                              (i >= FFP_ROW_AMBIENT && i < FFP_ROW_AMBIENT + 3 && coloured);
        if (columns->number[i] < 0 && !optional) return refuse(ply, columns, i, path, err);
        if (!check_single(ply, vertex, columns->number[i], path, err)) return false;
    }
    for (int k = 0; coloured && k < 3; k++)
        if (!check_single(ply, vertex, columns->colour[k], path, err)) return false;
    if (!coloured) columns->colour_white = 0;
    return true;
}

static void get_row(const Columns *columns, const double *values, float row[FFP_ROW_NUMBERS]) {
    for (int i = 0; i < FFP_ROW_NUMBERS; i++)
        row[i] = columns->number[i] < 0 ? 0 : (float)values[columns->number[i]];
    if (columns->number[FFP_ROW_SCALE + 2] < 0) row[FFP_ROW_SCALE + 2] = -INFINITY; // discs (2DGS)
    for (int k = 0; columns->colour_white > 0 && k < 3; k++)
        row[FFP_ROW_AMBIENT + k] =
            (float)((values[columns->colour[k]] / columns->colour_white - 0.5) / FFP_SH_C0);
}

static bool read_vertices(FfpSplatSet *set, const FfpPly *ply, const FfpPlyElement *vertex,
                          const Columns *columns, FILE *stream, FfpError *err) {
    double values[FFP_PLY_PROPERTIES];
    set->relightable = columns->relightable;
    set->filtered = ffp_ply_find(ply, vertex, FILTER) >= 0;
    for (int64_t i = 0; i < vertex->count; i++) {
        float row[FFP_ROW_NUMBERS];
        if (!ffp_ply_row(ply, vertex, stream, values, set->path, err)) return false;
        get_row(columns, values, row);
        for (int c = 0; !set->harmonics && c < columns->rests; c++)
            set->harmonics = values[columns->rest + c] != 0;
        ffp_splats_add(set, row);
    }
    return true;
}

// --- SuperSplat's compressed PLY (github.com/playcanvas, splat-transform): bounds of every 256 splats, and
// four whole numbers a splat that lie between them. ---

enum { CHUNK = 256, BOUNDS = 18, PACKED = 4 };

static const char *const bound_names[BOUNDS] = {
    "min_x",       "min_y",       "min_z",       "max_x",       "max_y",       "max_z",
    "min_scale_x", "min_scale_y", "min_scale_z", "max_scale_x", "max_scale_y", "max_scale_z",
    "min_r",       "min_g",       "min_b",       "max_r",       "max_g",       "max_b"};
static const char *const packed_names[PACKED] = {"packed_position", "packed_rotation", "packed_scale",
                                                 "packed_color"};

// Bounds of colours may be missing (early files): then they are 0 and 1.
static bool read_chunks(double *bounds, const FfpPly *ply, const FfpPlyElement *chunk, FILE *stream,
                        const char *path, FfpError *err) {
    int columns[BOUNDS];
    double values[FFP_PLY_PROPERTIES];
    for (int b = 0; b < BOUNDS; b++) {
        columns[b] = ffp_ply_find(ply, chunk, bound_names[b]);
        if (columns[b] < 0 && b < 12)
            return ffp_fail(err, FFP_ERROR_FILE, path, "element chunk: property %s is missing",
                            bound_names[b]);
    }
    for (int64_t i = 0; i < chunk->count; i++) {
        if (!ffp_ply_row(ply, chunk, stream, values, path, err)) return false;
        for (int b = 0; b < BOUNDS; b++)
            bounds[BOUNDS * i + b] = columns[b] < 0 ? b >= 15 : values[columns[b]];
    }
    return true;
}

static double part(uint32_t packed, int shift, int bits) {
    const uint32_t most = (1U << bits) - 1;
    return (double)(packed >> shift & most) / most;
}

static void unpack_vector(const double bounds[6], uint32_t packed, float out[3]) {
    const double share[3] = {part(packed, 21, 11), part(packed, 11, 10), part(packed, 0, 11)};
    for (int k = 0; k < 3; k++) out[k] = (float)(bounds[k] * (1 - share[k]) + bounds[3 + k] * share[k]);
}

// The three smaller parts of w x y z, 10 bits each, behind the index of the largest.
static void unpack_rotation(uint32_t packed, float wxyz[4]) {
    const int largest = (int)(packed >> 30);
    double square = 0;
    for (int i = 0, shift = 20; i < 4; i++) {
        if (i == largest) continue;
        const double one = (part(packed, shift, 10) - 0.5) * 2 * FFP_SPZ_SHORT;
        wxyz[i] = (float)one;
        square += one * one;
        shift -= 10;
    }
    wxyz[largest] = (float)sqrt(fmax(1 - square, 0));
}

static void unpack(const double bounds[BOUNDS], const uint32_t packed[PACKED], float row[FFP_ROW_NUMBERS]) {
    memset(row, 0, FFP_ROW_NUMBERS * sizeof *row);
    unpack_vector(bounds, packed[0], row + FFP_ROW_POSITION);
    unpack_rotation(packed[1], row + FFP_ROW_ROTATION);
    unpack_vector(bounds + 6, packed[2], row + FFP_ROW_SCALE);
    for (int k = 0; k < 3; k++) {
        const double share = part(packed[3], 24 - 8 * k, 8),
                     colour = bounds[12 + k] * (1 - share) + bounds[15 + k] * share;
        row[FFP_ROW_AMBIENT + k] = (float)((colour - 0.5) / FFP_SH_C0);
    }
    row[FFP_ROW_OPACITY] = (float)ffp_opacity_logit(part(packed[3], 0, 8));
}

static bool find_packed(int columns[PACKED], const FfpPly *ply, const FfpPlyElement *vertex, const char *path,
                        FfpError *err) {
    const FfpPlyElement *chunk = ffp_ply_element(ply, "chunk");
    if (!chunk || chunk > vertex || chunk->count < (vertex->count + CHUNK - 1) / CHUNK)
        return ffp_fail(err, FFP_ERROR_FILE, path, "element chunk: %lld before %lld vertices",
                        chunk ? (long long)chunk->count : 0, (long long)vertex->count);
    for (int c = 0; c < PACKED; c++) {
        columns[c] = ffp_ply_find(ply, vertex, packed_names[c]);
        if (columns[c] < 0)
            return ffp_fail(err, FFP_ERROR_FILE, path, "property %s is missing", packed_names[c]);
        if (ply->properties[vertex->first + columns[c]].type != FFP_PLY_UINT32)
            return ffp_fail(err, FFP_ERROR_FILE, path, "property %s is not uint", packed_names[c]);
        if (!check_single(ply, vertex, columns[c], path, err)) return false;
    }
    return true;
}

static bool read_packed(FfpSplatSet *set, const FfpPly *ply, const FfpPlyElement *vertex,
                        const int columns[PACKED], const double *bounds, FILE *stream, FfpError *err) {
    double values[FFP_PLY_PROPERTIES];
    for (int64_t i = 0; i < vertex->count; i++) {
        float row[FFP_ROW_NUMBERS];
        uint32_t packed[PACKED];
        if (!ffp_ply_row(ply, vertex, stream, values, set->path, err)) return false;
        for (int c = 0; c < PACKED; c++) {
            const double value = values[columns[c]]; // of a text it may be anything
            packed[c] = value >= 0 && value <= UINT32_MAX ? (uint32_t)value : 0;
        }
        unpack(bounds + BOUNDS * (i / CHUNK), packed, row);
        ffp_splats_add(set, row);
    }
    const FfpPlyElement *harmonics = ffp_ply_element(ply, "sh");
    set->harmonics = harmonics && harmonics->count > 0;
    return true;
}

// --- The file. ---

typedef struct Layout {
    const FfpPlyElement *vertex, *chunk; // chunk: NULL if it is not compressed
    Columns columns;
    int packed[PACKED];
} Layout;

static bool find_layout(Layout *layout, const FfpPly *ply, const char *path, FfpError *err) {
    *layout = (Layout){.vertex = ffp_ply_element(ply, "vertex")};
    if (!layout->vertex) return ffp_fail(err, FFP_ERROR_FILE, path, "holds no element vertex");
    if (ffp_ply_find(ply, layout->vertex, packed_names[0]) < 0)
        return find_columns(&layout->columns, ply, layout->vertex, path, err);
    layout->chunk = ffp_ply_element(ply, "chunk");
    return find_packed(layout->packed, ply, layout->vertex, path, err);
}

static bool read_elements(FfpSplatSet *set, const FfpPly *ply, const Layout *layout, FILE *stream,
                          FfpError *err) {
    double *bounds = NULL;
    bool ok = true;
    for (const FfpPlyElement *at = ply->elements; ok && at < layout->vertex; at++) {
        if (at == layout->chunk) {
            bounds = ffp_alloc((size_t)at->count, BOUNDS * sizeof *bounds);
            ok = read_chunks(bounds, ply, at, stream, set->path, err);
        } else {
            ok = ffp_ply_skip(ply, at, stream, set->path, err);
        }
    }
    if (ok && layout->chunk)
        ok = read_packed(set, ply, layout->vertex, layout->packed, bounds, stream, err);
    else if (ok)
        ok = read_vertices(set, ply, layout->vertex, &layout->columns, stream, err);
    ffp_free(bounds);
    return ok;
}

static bool read_all(FfpGaussians *gaussians, FfpPly *ply, FILE *stream, const char *path, FfpError *err) {
    Layout layout;
    FfpSplatSet set;
    if (!ffp_ply_header_read(ply, stream, path, err) || !find_layout(&layout, ply, path, err) ||
        !ffp_ply_check_size(ply, stream, path, err))
        return false;
    ffp_splats_begin(&set, gaussians, layout.vertex->count, path);
    memcpy(gaussians->made_from, ply->made_from, sizeof ply->made_from);
    gaussians->baked = ply->baked;
    if (!ffp_splats_end(&set, read_elements(&set, ply, &layout, stream, err), err)) return false;
    const FfpPlyElement *face = ffp_ply_element(ply, "face");
    if (face && face->count > 0)
        ffp_note("%s: its %lld faces are left out", ffp_basename(path), (long long)face->count);
    return true;
}

bool ffp_gaussians_read_ply(FfpGaussians *gaussians, const char *path, FfpError *err) {
    FILE *stream = ffp_open_to_read(path, err);
    *gaussians = (FfpGaussians){0};
    if (!stream) return false;
    ffp_own_file(stream);
    FfpPly *ply = ffp_alloc(1, sizeof *ply);
    const bool ok = read_all(gaussians, ply, stream, path, err);
    ffp_free(ply);
    ffp_close_file(stream);
    return ok;
}

static FfpPly *read_header(const char *path, FfpError *err) {
    FILE *stream = ffp_open_to_read(path, err);
    if (!stream) return NULL;
    ffp_own_file(stream);
    FfpPly *ply = ffp_alloc(1, sizeof *ply);
    const bool ok = ffp_ply_header_read(ply, stream, path, err);
    ffp_close_file(stream);
    if (ok) return ply;
    ffp_free(ply);
    return NULL;
}

bool ffp_gaussians_read_made_from(char made_from[FFP_MADE_FROM], const char *path, FfpError *err) {
    made_from[0] = 0;
    if (!ffp_check_kind(path, FFP_WANTED_GAUSSIANS, err)) return false;
    if (ffp_file_kind(path) != FFP_KIND_PLY) return true;
    FfpPly *ply = read_header(path, err);
    if (!ply) return false;
    memcpy(made_from, ply->made_from, sizeof ply->made_from);
    ffp_free(ply);
    return true;
}

bool ffp_gaussians_are_relightable(const char *path) {
    FfpPly *ply = read_header(path, NULL);
    const FfpPlyElement *vertex = ply ? ffp_ply_element(ply, "vertex") : NULL;
    const bool relightable = vertex && ffp_ply_find(ply, vertex, ffp_row_names[FFP_ROW_ALBEDO]) >= 0;
    ffp_free(ply);
    return relightable;
}
