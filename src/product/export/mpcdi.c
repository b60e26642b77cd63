#include "product/export/mpcdi.h"
#include <math.h>
#include <stdio.h>
#include <string.h>
#include <time.h>
#include <zlib.h>
#include "core/base/alloc.h"
#include "core/base/text.h"
#include "product/export/bytes.h"

enum { LOCAL = 30, CENTRAL = 46, END = 22, DEFLATED = 8, ZIP_2_0 = 20, DAY_1980 = 33, HEADER_MOST = 64 };
enum { OLD, NEW, BOTH }; // versions

#define PIXEL_BYTES 14.0 // in the worst case, packed: a warp's three floats and a mask

bool ffp_mpcdi_holds(const FfpView *const *views, int n_views) {
    double bytes = 0;
    for (int v = 0; v < n_views; v++)
        bytes += PIXEL_BYTES * views[v]->projector.width * views[v]->projector.height + 65536;
    return bytes < UINT32_MAX;
}

bool ffp_mpcdi_open(FfpMpcdi *mpcdi, const char *path, FfpError *err) {
    char old[FFP_PATH_MAX];
    *mpcdi = (FfpMpcdi){0};
    const int stem = (int)(strlen(path) - strlen(".mpcdi"));
    if (snprintf(old, sizeof old, "%.*s-1.0.mpcdi", stem, path) >= FFP_PATH_MAX)
        return ffp_fail(err, FFP_ERROR_ARGUMENT, path, "the path is too long");
    return ffp_output_open(&mpcdi->out[OLD], old, err) && ffp_output_open(&mpcdi->out[NEW], path, err);
}

// --- The archive (PKWARE's APPNOTE, 4.3). ---

static void put_u16(unsigned char *bytes, int value) {
    bytes[0] = (unsigned char)value;
    bytes[1] = (unsigned char)(value >> 8);
}

// The common part of a file's header at its data and that in the list at the end, from the version on.
static void put_common(unsigned char bytes[26], const FfpArchived *file) {
    memset(bytes, 0, 26);
    put_u16(bytes, ZIP_2_0);
    put_u16(bytes + 4, DEFLATED);
    put_u16(bytes + 8, DAY_1980); // mpcdi.xml has the date
    ffp_put_u32(bytes + 10, file->crc);
    ffp_put_u32(bytes + 14, file->packed);
    ffp_put_u32(bytes + 18, file->size);
    put_u16(bytes + 22, (int)strlen(file->name));
}

static void put_file(FILE *out, const FfpArchived *file, const unsigned char *packed) {
    unsigned char head[LOCAL] = {'P', 'K', 3, 4};
    put_common(head + 4, file);
    fwrite(head, 1, LOCAL, out);
    fputs(file->name, out);
    fwrite(packed, 1, file->packed, out);
}

// To the archive of a version, or to both. Write errors show at the commit.
static bool add_file(FfpMpcdi *mpcdi, int version, const char *name, const void *data, size_t size,
                     FfpError *err) {
    FfpArchived file = {.size = (uint32_t)size, .crc = (uint32_t)crc32_z(0, data, size)};
    uLongf packed = compressBound((uLong)size);
    unsigned char *bytes = ffp_alloc(packed, 1);
    const bool ok = compress2(bytes, &packed, data, (uLong)size, Z_BEST_SPEED) == Z_OK ||
                    ffp_fail(err, FFP_ERROR_IO, mpcdi->out[NEW].path, "cannot compress %s", name);
    if (ok) {
        snprintf(file.name, sizeof file.name, "%s", name);
        file.packed = (uint32_t)packed - 6; // without zlib's own head and end
        file.at = (uint32_t)ftell(mpcdi->out[version == BOTH ? OLD : version].stream);
        for (int v = OLD; v <= NEW; v++)
            if (version == v || version == BOTH) put_file(mpcdi->out[v].stream, &file, bytes + 2);
        mpcdi->files = ffp_grow(mpcdi->files, (size_t)mpcdi->n_files + 1, sizeof *mpcdi->files);
        mpcdi->files[mpcdi->n_files++] = file;
    }
    ffp_free(bytes);
    return ok;
}

static void put_list(const FfpMpcdi *mpcdi, FILE *out) {
    const uint32_t begin = (uint32_t)ftell(out);
    for (int i = 0; i < mpcdi->n_files; i++) {
        unsigned char head[CENTRAL] = {'P', 'K', 1, 2};
        put_u16(head + 4, ZIP_2_0);
        put_common(head + 6, &mpcdi->files[i]);
        ffp_put_u32(head + 42, mpcdi->files[i].at);
        fwrite(head, 1, CENTRAL, out);
        fputs(mpcdi->files[i].name, out);
    }
    unsigned char end[END] = {'P', 'K', 5, 6};
    put_u16(end + 8, mpcdi->n_files);
    put_u16(end + 10, mpcdi->n_files);
    ffp_put_u32(end + 12, (uint32_t)ftell(out) - begin);
    ffp_put_u32(end + 16, begin);
    fwrite(end, 1, END, out);
}

// --- A region's files. ---

static bool add_warp(FfpMpcdi *mpcdi, const FfpImage *map, const FfpCamera *camera, FfpError *err) {
    char name[32], header[HEADER_MOST];
    const int length = snprintf(header, sizeof header, "PF\n%d %d\n-1.0\n", map->width, map->height);
    const size_t row = (size_t)map->width, size = (size_t)length + 12 * row * (size_t)map->height;
    unsigned char *bytes = ffp_alloc(size, 1), *to = bytes + length;
    memcpy(bytes, header, (size_t)length);
    for (int y = map->height - 1; y >= 0; y--)
        for (size_t x = 0; x < row; x++, to += 12) {
            const real *from = map->data + 3 * ((size_t)y * row + x);
            const bool seen = from[0] >= 0;
            ffp_put_float(to, seen ? (float)(from[0] / (real)camera->width) : NAN);
            ffp_put_float(to + 4, seen ? (float)(1 - from[1] / (real)camera->height) : NAN);
            ffp_put_float(to + 8, seen ? 0 : NAN);
        }
    snprintf(name, sizeof name, "warp%d.pfm", mpcdi->n_views);
    const bool ok = add_file(mpcdi, BOTH, name, bytes, size, err);
    ffp_free(bytes);
    return ok;
}

static bool add_mask(FfpMpcdi *mpcdi, const FfpImage *map, FfpError *err) {
    char name[32];
    unsigned char *png;
    size_t size;
    FfpImage mask = ffp_image_new(map->width, map->height, 1);
    for (size_t i = 0; i < (size_t)map->width * (size_t)map->height; i++)
        mask.data[i] = map->data[3 * i] >= 0;
    bool ok = ffp_image_encode_png(&mask, &png, &size, err);
    ffp_image_free(&mask);
    if (!ok) return false;
    snprintf(name, sizeof name, "alpha%d.png", mpcdi->n_views);
    ok = add_file(mpcdi, BOTH, name, png, size, err);
    ffp_free(png);
    return ok;
}

bool ffp_mpcdi_add(FfpMpcdi *mpcdi, const FfpView *view, const FfpImage *map, FfpError *err) {
    if (!add_warp(mpcdi, map, &view->camera, err) || !add_mask(mpcdi, map, err)) return false;
    mpcdi->views = ffp_grow(mpcdi->views, (size_t)mpcdi->n_views + 1, sizeof *mpcdi->views);
    mpcdi->views[mpcdi->n_views++] = view;
    return true;
}

// --- mpcdi.xml. ---

static void print_size(int width, int height, int version, FILE *out) {
    static const char *const forms[] = {"\" Xresolution=\"%d\" Yresolution=\"%d\"",
                                        "\" xResolution=\"%d\" yResolution=\"%d\""};
    fprintf(out, forms[version], width, height);
}

static void print_buffer(const FfpMpcdi *mpcdi, int first, int version, FILE *out) {
    const FfpCamera *camera = &mpcdi->views[first]->camera;
    fputs("    <buffer id=\"", out);
    ffp_put_html(out, mpcdi->views[first]->id);
    print_size(camera->width, camera->height, version, out);
    fputs(">\n", out);
    for (int v = first; v < mpcdi->n_views; v++) {
        const FfpView *view = mpcdi->views[v];
        if (!ffp_same_device(&view->camera, camera)) continue;
        fputs("      <region id=\"", out);
        ffp_put_html(out, view->id);
        print_size(view->projector.width, view->projector.height, version, out);
        fputs(" x=\"0.0\" y=\"0.0\" xsize=\"1.0\" ysize=\"1.0\"/>\n", out);
    }
    fputs("    </buffer>\n", out);
}

// Version 1.0 asks for units and origin of a surface, though profile 2d has none.
static void print_fileset(const FfpView *view, int number, int version, FILE *out) {
    fputs("    <fileset region=\"", out);
    ffp_put_html(out, view->id);
    fprintf(out,
            "\">\n      <geometryWarpFile>\n        <path>warp%d.pfm</path>\n%s"
            "        <interpolation>linear</interpolation>\n%s      </geometryWarpFile>\n"
            "      <alphaMap>\n        <path>alpha%d.png</path>\n        <componentDepth>1</componentDepth>\n"
            "        <bitDepth>8</bitDepth>\n        <gammaEmbedded>1.0</gammaEmbedded>\n      </alphaMap>\n"
            "    </fileset>\n",
            number, version == OLD ? "        <geometricUnit>unknown</geometricUnit>\n" : "",
            version == OLD ? "        <originof3DData>centerOfMass</originof3DData>\n" : "", number);
}

static void print_xml(const FfpMpcdi *mpcdi, int version, FILE *out) {
    static const char *const heads[] = {"level=\"1\" date=\"%s\" version=\"1.0\"",
                                        "geometry=\"2\" color=\"1\" date=\"%s\" version=\"2.0\""};
    char date[32];
    const time_t now = time(NULL);
    struct tm utc;
    strftime(date, sizeof date, "%Y-%m-%d %H:%M:%S", gmtime_r(&now, &utc));
    fputs("<?xml version=\"1.0\" encoding=\"utf-8\"?>\n<MPCDI profile=\"2d\" ", out);
    fprintf(out, heads[version], date);
    fputs(">\n  <display>\n", out);
    for (int v = 0; v < mpcdi->n_views; v++) {
        int first = 0;
        while (!ffp_same_device(&mpcdi->views[first]->camera, &mpcdi->views[v]->camera)) first++;
        if (first == v) print_buffer(mpcdi, v, version, out);
    }
    fputs("  </display>\n  <files>\n", out);
    for (int v = 0; v < mpcdi->n_views; v++) print_fileset(mpcdi->views[v], v, version, out);
    fputs("  </files>\n</MPCDI>\n", out);
}

static bool commit(FfpMpcdi *mpcdi, int version, FfpError *err) {
    size_t size;
    FfpText *text = ffp_text_new();
    print_xml(mpcdi, version, ffp_text_stream(text));
    const char *xml = ffp_text_so_far(text, &size);
    const bool ok = add_file(mpcdi, version, "mpcdi.xml", xml, size, err);
    ffp_text_free(text);
    if (!ok) return false;
    put_list(mpcdi, mpcdi->out[version].stream);
    mpcdi->n_files--; // the other has one of its own
    return ffp_output_commit(&mpcdi->out[version], err);
}

bool ffp_mpcdi_commit(FfpMpcdi *mpcdi, FfpError *err) {
    return commit(mpcdi, OLD, err) && commit(mpcdi, NEW, err);
}

void ffp_mpcdi_abort(FfpMpcdi *mpcdi) {
    for (int v = OLD; v <= NEW; v++) ffp_output_abort(&mpcdi->out[v]);
    ffp_free(mpcdi->views);
    ffp_free(mpcdi->files);
    *mpcdi = (FfpMpcdi){0};
}
