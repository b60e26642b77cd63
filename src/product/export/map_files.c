#include "product/export/map_files.h"
#include <stdio.h>
#include <string.h>
#include "core/base/file.h"
#include "core/base/log.h"
#include "engine/apply/choose.h"
#include "engine/pipeline/correspondence.h"
#include "engine/pipeline/elsewhere.h"
#include "product/export/mpcdi.h"
#include "product/export/warp.h"

typedef struct Writer {
    FfpOutput folder;
    const char *view;
    FfpMpcdi *archive; // NULL: none
    int written;
} Writer;

static bool name_map(char path[FFP_PATH_MAX], Writer *writer, const char *name, const char *ending,
                     FfpError *err) {
    writer->written++;
    if (snprintf(path, FFP_PATH_MAX, "%s/%s_%s%s", writer->folder.temporary, writer->view, name, ending) >=
        FFP_PATH_MAX)
        return ffp_fail(err, FFP_ERROR_ARGUMENT, writer->folder.path, "the path of %s_%s is too long",
                        writer->view, name);
    return true;
}

static bool write_map(Writer *writer, const FfpImage *image, const char *name, const char *ending,
                      FfpError *err) {
    char path[FFP_PATH_MAX];
    if (!name_map(path, writer, name, ending, err)) return false;
    return strcmp(ending, ".exr") == 0 ? ffp_image_write_exr(image, path, err)
                                       : ffp_image_write_png(image, path, err);
}

// A correspondence map, to a device.
typedef struct Shares {
    const FfpImage *map;
    const FfpCamera *to;
} Shares;

static void row_of_shares(void *context, int y, real *row) {
    const Shares *shares = context;
    const FfpImage *map = shares->map;
    const real *from = map->data + 3 * (size_t)y * (size_t)map->width;
    memset(row, 0, 4 * (size_t)map->width * sizeof *row);
    for (int x = 0; x < map->width; x++, from += 3) {
        if (from[0] < 0) continue;
        const real pixel[4] = {from[0] / (real)shares->to->width, from[1] / (real)shares->to->height, from[2],
                               1};
        memcpy(row + 4 * (size_t)x, pixel, sizeof pixel);
    }
}

// A correspondence map [.,3] (x, y, third; x < 0: none) as a 16-bit PNG: x and y as shares of the other
// device's size, the third as it stands, alpha 0 where there is nothing.
static bool write_shares(Writer *writer, const FfpImage *map, const FfpCamera *to, const char *name,
                         FfpError *err) {
    char path[FFP_PATH_MAX];
    Shares shares = {map, to};
    const FfpRows rows = {map->width, map->height, 4, row_of_shares, &shares};
    return name_map(path, writer, name, ".png", err) && ffp_image_write_png_rows(&rows, 16, path, err);
}

static bool write_warp(Writer *writer, const FfpImage *map, const FfpView *view, FfpError *err) {
    char path[FFP_PATH_MAX];
    FfpWarp warp = ffp_warp_of_map(map, &view->camera);
    bool ok = name_map(path, writer, "warp", ".obj", err) && ffp_warp_write_obj(&warp, path, err);
    if (ok && warp.n_triangles > 0) // glTF has no empty meshes
        ok = name_map(path, writer, "warp", ".glb", err) && ffp_warp_write_gltf(&warp, path, err);
    ffp_warp_free(&warp);
    return ok;
}

// Numbers go into EXR files; what people look at, into PNG files.
static bool write_image(Writer *writer, const FfpImageEntry *entry, const FfpView *view, FfpError *err) {
    const FfpImage *image = &entry->image;
    const char *name = entry->name;
    char path[FFP_PATH_MAX];
    if (strcmp(name, "projector_sees") == 0)
        return name_map(path, writer, name, ".png", err) && ffp_image_write_png_encoded(image, path, err);
    if (strcmp(name, "lit") == 0) return write_map(writer, image, name, ".png", err);
    if (!write_map(writer, image, name, ".exr", err)) return false;
    if (strcmp(name, "illuminance") == 0) return write_map(writer, image, name, ".png", err);
    if (strcmp(name, "camera_to_projector") == 0)
        return write_shares(writer, image, &view->projector, name, err);
    if (strcmp(name, "projector_to_camera") == 0)
        return write_shares(writer, image, &view->camera, name, err) &&
               name_map(path, writer, "stmap", ".exr", err) &&
               ffp_write_stmap(image, &view->camera, path, err) && write_warp(writer, image, view, err) &&
               (!writer->archive || ffp_mpcdi_add(writer->archive, view, image, err));
    return true;
}

static bool check_names(const FfpChosen *chosen, const char *folder, FfpError *err) {
    for (int v = 0; v < chosen->n_views; v++) {
        const char *id = chosen->views[v]->id;
        if (!*id || *id == '.' || strchr(id, '/'))
            return ffp_fail(err, FFP_ERROR_ARGUMENT, folder, "view %s is not a valid file name", id);
    }
    return true;
}

// The archive of all views, unless they are more than it can hold.
static bool open_archive(Writer *writer, FfpMpcdi *archive, const FfpChosen *chosen, FfpError *err) {
    char path[FFP_PATH_MAX];
    if (!ffp_mpcdi_holds(chosen->views, chosen->n_views)) {
        ffp_note("%s: no projectors.mpcdi, which cannot hold so many pixels: choose fewer views",
                 writer->folder.path);
        return true;
    }
    if (!ffp_join_path(path, writer->folder.temporary, "projectors.mpcdi"))
        return ffp_fail(err, FFP_ERROR_ARGUMENT, writer->folder.path,
                        "the path of projectors.mpcdi is too long");
    writer->archive = archive;
    writer->written += 2;
    return ffp_mpcdi_open(archive, path, err);
}

int ffp_warps_run(const FfpGaussians *gaussians, const FfpCapture *capture, const FfpWarps *options,
                  FfpWarpStats *stats, int n_stats, FfpError *err) {
    FfpChosen chosen;
    FfpMpcdi archive = {0};
    Writer writer = {.written = 0};
    bool ok = ffp_choose_views(&chosen, capture, options->poses, options->views, options->n_views, err) &&
              (!stats || n_stats >= chosen.n_views ||
               ffp_fail(err, FFP_ERROR_ARGUMENT, "stats", "has room for %d of %d views", n_stats,
                        chosen.n_views)) &&
              check_names(&chosen, options->folder, err) &&
              ffp_output_open_folder(&writer.folder, options->folder, false, err);
    if (ok) ffp_note_elsewhere(gaussians, capture);
    for (int v = 0; ok && v < chosen.n_views; v++)
        ok = ffp_warps_fit(gaussians, chosen.views[v], options->drawing, err);
    ok = ok && open_archive(&writer, &archive, &chosen, err);
    for (int v = 0; ok && v < chosen.n_views; v++) {
        FfpWarpStats found = {0};
        FfpImages *images = ffp_warps_draw(gaussians, capture, chosen.views[v], options->drawing, &found);
        writer.view = chosen.views[v]->id;
        for (const FfpImageEntry *entry = images->first; ok && entry; entry = entry->next)
            ok = write_image(&writer, entry, chosen.views[v], err);
        ffp_images_free(images);
        if (ok && stats) stats[v] = found;
    }
    ok = ok && (!writer.archive || ffp_mpcdi_commit(&archive, err));
    ffp_mpcdi_abort(&archive);
    ok = ok && ffp_output_commit(&writer.folder, err);
    ffp_output_abort(&writer.folder);
    ffp_chosen_free(&chosen);
    return ok ? writer.written : -1;
}
