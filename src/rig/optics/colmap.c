// COLMAP's text model: cameras.txt and images.txt. Pixel centres lie at integer + 0.5, as ours; poses are
// world to camera.
#include <errno.h>
#include <limits.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include "core/base/arena.h"
#include "core/base/file.h"
#include "core/base/real.h"
#include "core/capture/manifest.h"
#include "rig/optics/calibration.h"
#include "rig/optics/colmap_write.h"
#include "rig/optics/document.h"
#include "rig/optics/matrix.h"

#define CAMERAS_MAX 4096
#define PARAMETERS_MAX 12

typedef struct Lines { // a text file, line by line
    char *text, *next;
    const char *path;
    size_t number;
} Lines;

typedef struct ColmapCamera {
    long id;
    FfpOptics optics;
    FfpError problem; // of a model that is not read: an error where an image has it
} ColmapCamera;

typedef struct ColmapImage {
    const char *name; // in the text of images.txt
    long camera;
    double c2w[16];
    size_t line;
} ColmapImage;

typedef struct Colmap {
    ColmapCamera *cameras;
    ColmapImage *images;
    int n_cameras, n_images;
} Colmap;

static bool fail_here(const Lines *lines, FfpError *err, const char *what) {
    return ffp_document_fail(lines->path, lines->number, err, "%s", what);
}

static bool open_lines(Lines *lines, const char *path, FfpError *err) {
    size_t size = 0;
    *lines = (Lines){.path = path};
    if (!ffp_read_text(path, FFP_DOCUMENT_BYTES_MAX, &lines->text, &size, err)) return false;
    lines->next = lines->text;
    return true;
}

// The next line without its end, or NULL.
static char *next_line(Lines *lines) {
    if (!lines->next || *lines->next == 0) return NULL;
    char *line = lines->next, *end = strchr(line, '\n');
    lines->next = end ? end + 1 : NULL;
    if (end) *end = 0;
    const size_t length = strlen(line);
    if (length > 0 && line[length - 1] == '\r') line[length - 1] = 0;
    lines->number++;
    return line;
}

// Likewise, passing over comments and empty lines.
static char *next_entry(Lines *lines) {
    for (char *line; (line = next_line(lines)) != NULL;) {
        line += strspn(line, " \t");
        if (*line != 0 && *line != '#') return line;
    }
    return NULL;
}

static bool take_number(char **at, double *value) {
    char *end = NULL;
    *value = strtod(*at, &end);
    const bool ok = end != *at && isfinite(*value) && (*end == ' ' || *end == '\t' || *end == 0);
    *at = end + strspn(end, " \t");
    return ok;
}

static bool take_whole(char **at, long low, long high, long *value) {
    char *end = NULL;
    errno = 0;
    *value = strtol(*at, &end, 10);
    const bool ok = errno == 0 && end != *at && *value >= low && *value <= high &&
                    (*end == ' ' || *end == '\t' || *end == 0);
    *at = end + strspn(end, " \t");
    return ok;
}

static char *take_word(char **at) {
    char *word = *at;
    *at += strcspn(*at, " \t");
    if (**at != 0) *(*at)++ = 0;
    *at += strspn(*at, " \t");
    return word;
}

#define RATIONAL                                                                                             \
    "FULL_OPENCV with k4, k5 or k6 other than 0 is not removed: calibrate with OPENCV, or undistort with "   \
    "colmap image_undistorter"

// --- cameras.txt: CAMERA_ID MODEL WIDTH HEIGHT PARAMS... ---

// Where each model keeps its parameters: focal lengths (one or two), the principal point, then k1 k2 p1 p2.
static bool camera_from(const Lines *lines, const char *model, const double *p, int n, FfpOptics *optics,
                        FfpError *err) {
    static const struct {
        const char *name;
        int focals, lens;
    } models[] = {{"SIMPLE_PINHOLE", 1, 0}, {"PINHOLE", 2, 0}, {"SIMPLE_RADIAL", 1, 1},
                  {"RADIAL", 1, 2},         {"OPENCV", 2, 4},  {"FULL_OPENCV", 2, 8}};
    for (size_t i = 0; i < sizeof models / sizeof *models; i++) {
        if (strcmp(model, models[i].name) != 0) continue;
        const int focals = models[i].focals;
        if (n != focals + 2 + models[i].lens)
            return fail_here(lines, err, "wrong number of camera parameters");
        optics->fx = p[0], optics->fy = p[focals - 1];
        optics->cx = p[focals], optics->cy = p[focals + 1];
        for (int k = 0; k < models[i].lens && k < 5; k++) optics->lens[k] = p[focals + 2 + k];
        for (int k = 5; k < models[i].lens; k++)
            if (p[focals + 2 + k] != 0) return fail_here(lines, err, RATIONAL);
        for (int k = 0; k < n; k++) {
            if (fabs(p[k]) > FFP_PIXELS_MAX) return fail_here(lines, err, "a camera parameter is too large");
        }
        return (optics->fx >= 1e-3 && optics->fy >= 1e-3) ||
               fail_here(lines, err, "a focal length is not positive");
    }
    return ffp_document_fail(
        lines->path, lines->number, err,
        "camera model %.40s is not among SIMPLE_PINHOLE, PINHOLE, SIMPLE_RADIAL, RADIAL, "
        "OPENCV and FULL_OPENCV without rational terms: undistort with colmap image_undistorter, or "
        "calibrate with one of them",
        model);
}

static bool read_camera(const Lines *lines, char *at, ColmapCamera *camera, FfpError *err) {
    double parameters[PARAMETERS_MAX];
    long width = 0, height = 0;
    int n = 0;
    if (!take_whole(&at, 0, LONG_MAX, &camera->id)) return fail_here(lines, err, "no camera id");
    const char *model = take_word(&at);
    if (!take_whole(&at, 1, FFP_IMAGE_SIDE_MAX, &width) || !take_whole(&at, 1, FFP_IMAGE_SIDE_MAX, &height))
        return fail_here(lines, err, "invalid width or height");
    for (; *at != 0; n++) {
        // The models that are read have at most twelve; longer ones are told by their name.
        double value = 0;
        if (!take_number(&at, &value)) return fail_here(lines, err, "a camera parameter is not a number");
        if (n < PARAMETERS_MAX) parameters[n] = value;
    }
    camera->optics = (FfpOptics){.width = (int)width, .height = (int)height};
    camera_from(lines, model, parameters, n, &camera->optics, &camera->problem);
    return true;
}

static bool read_cameras(Colmap *colmap, Lines *lines, FfpError *err) {
    for (char *line; (line = next_entry(lines)) != NULL; colmap->n_cameras++) {
        if (colmap->n_cameras == CAMERAS_MAX) return fail_here(lines, err, "too many cameras");
        if (!read_camera(lines, line, &colmap->cameras[colmap->n_cameras], err)) return false;
    }
    return colmap->n_cameras > 0 || fail_here(lines, err, "no camera in the file");
}

// --- images.txt: IMAGE_ID QW QX QY QZ TX TY TZ CAMERA_ID NAME, then a line of points. ---

static bool pose_from(const Lines *lines, const double q[4], const double t[3], double c2w[16],
                      FfpError *err) {
    const double n = sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
    if (!(fabs(n - 1) < 0.01)) return fail_here(lines, err, "the quaternion's length is not 1");
    const double w = q[0] / n, x = q[1] / n, y = q[2] / n, z = q[3] / n;
    const double w2c[16] = {1 - 2 * (y * y + z * z),
                            2 * (x * y - w * z),
                            2 * (x * z + w * y),
                            t[0],
                            2 * (x * y + w * z),
                            1 - 2 * (x * x + z * z),
                            2 * (y * z - w * x),
                            t[1],
                            2 * (x * z - w * y),
                            2 * (y * z + w * x),
                            1 - 2 * (x * x + y * y),
                            t[2],
                            0,
                            0,
                            0,
                            1};
    ffp_pose_inverse(w2c, c2w);
    return true;
}

static bool read_image(const Lines *lines, char *at, ColmapImage *image, FfpError *err) {
    double numbers[7];
    long id = 0;
    if (!take_whole(&at, 0, LONG_MAX, &id)) return fail_here(lines, err, "no image id");
    for (int i = 0; i < 7; i++) {
        if (!take_number(&at, &numbers[i]) || fabs(numbers[i]) > 1e9)
            return fail_here(lines, err, "a pose needs seven numbers: QW QX QY QZ TX TY TZ");
    }
    if (!take_whole(&at, 0, LONG_MAX, &image->camera)) return fail_here(lines, err, "no camera id");
    if (*at == 0) return fail_here(lines, err, "the image has no name");
    image->name = at;
    image->line = lines->number;
    return pose_from(lines, numbers, numbers + 4, image->c2w, err);
}

// True for an image's points, X Y POINT3D_ID each, of which there may be none.
static bool are_points(const char *line) {
    size_t n = 0;
    while (*(line += strspn(line, " \t")) != 0) {
        line += strcspn(line, " \t");
        n++;
    }
    return n % 3 == 0;
}

static bool read_images(Colmap *colmap, Lines *lines, FfpError *err) {
    for (char *line; (line = next_entry(lines)) != NULL; colmap->n_images++) {
        if (colmap->n_images == FFP_VIEWS_MAX + 1) return fail_here(lines, err, "too many images");
        if (!read_image(lines, line, &colmap->images[colmap->n_images], err)) return false;
        const char *points = next_line(lines); // often empty
        if (points && !are_points(points))
            return fail_here(lines, err, "expected the points of the image before, or an empty line");
    }
    return colmap->n_images > 0 || fail_here(lines, err, "no image in the file");
}

// --- Into the calibration. ---

static bool optics_of(const Colmap *colmap, const ColmapImage *image, const char *path, FfpOptics *optics,
                      FfpError *err) {
    for (int i = 0; i < colmap->n_cameras; i++) {
        if (colmap->cameras[i].id != image->camera) continue;
        *optics = colmap->cameras[i].optics;
        if (err && colmap->cameras[i].problem.code != FFP_OK) *err = colmap->cameras[i].problem;
        return colmap->cameras[i].problem.code == FFP_OK;
    }
    return ffp_document_fail(path, image->line, err, "camera %ld is not in cameras.txt", image->camera);
}

bool ffp_colmap_is_called(const char *name, const char *stem) {
    const char *base = ffp_basename(name);
    const size_t length = strlen(stem);
    return strncmp(base, stem, length) == 0 && (base[length] == 0 || base[length] == '.');
}

// Pictures called the same in a folder for each view ("000/white.png") are named by these folders.
static bool name_stop(FfpCalibration *calibration, int stop, const FfpNode *file, const Colmap *colmap,
                      const char *name, const char *projector_image, FfpError *err) {
    const char *base = ffp_basename(name);
    bool alike = base != name;
    for (int i = 0; alike && i < colmap->n_images; i++) {
        const char *other = colmap->images[i].name;
        alike = ffp_colmap_is_called(other, projector_image) || strcmp(ffp_basename(other), base) == 0;
    }
    if (!alike || colmap->n_images < 3) return ffp_name_stop_by_file(calibration, stop, file, name, err);
    char folder[FFP_NAME_MAX];
    const char *end = base - 1, *start = end;
    while (start > name && start[-1] != '/') start--;
    snprintf(folder, sizeof folder, "%.*s", (int)(end - start), start);
    return ffp_name_stop(calibration, stop, file, folder, err);
}

static bool distribute(FfpCalibration *calibration, const Colmap *colmap, const char *path,
                       const char *projector_image, FfpError *err) {
    const FfpNode file = {.file = path};
    int projectors = 0, stop = 0;
    for (int i = 0; i < colmap->n_images; i++)
        projectors += ffp_colmap_is_called(colmap->images[i].name, projector_image);
    if (projectors != 1) {
        return ffp_fail(err, FFP_ERROR_FILE, "projector_image",
                        "%s: %d images are called '%.60s': the projector must be one of COLMAP's images",
                        path, projectors, projector_image);
    }
    if (!ffp_calibration_new_stops(calibration, &file, colmap->n_images - 1, err)) return false;
    for (int i = 0; i < colmap->n_images; i++) {
        const ColmapImage *image = &colmap->images[i];
        if (ffp_colmap_is_called(image->name, projector_image)) {
            if (!optics_of(colmap, image, path, &calibration->projector, err)) return false;
            ffp_place_projector(calibration, image->c2w);
            continue;
        }
        FfpStop *to = &calibration->stops[stop];
        if (!optics_of(colmap, image, path, &to->camera, err) ||
            !name_stop(calibration, stop, &file, colmap, image->name, projector_image, err)) {
            return false;
        }
        memcpy(to->c2w, image->c2w, sizeof to->c2w);
        stop++;
    }
    calibration->has_projector = true;
    return true;
}

bool ffp_read_colmap(FfpCalibration *calibration, const char *folder, const char *projector_image,
                     FfpError *err) {
    char cameras[FFP_PATH_MAX], images[FFP_PATH_MAX];
    if (!ffp_join_path(cameras, folder, "cameras.txt") || !ffp_join_path(images, folder, "images.txt"))
        return ffp_fail(err, FFP_ERROR_FILE, folder, "the path is too long");
    if (calibration->has_projector)
        return ffp_fail(err, FFP_ERROR_FILE, cameras, "the projector was already given by another file");
    Lines camera_lines = {0}, image_lines = {0};
    Colmap colmap = {.cameras = ffp_alloc(CAMERAS_MAX, sizeof(ColmapCamera)),
                     .images = ffp_alloc(FFP_VIEWS_MAX + 1, sizeof(ColmapImage))};
    const bool ok = open_lines(&camera_lines, cameras, err) && read_cameras(&colmap, &camera_lines, err) &&
                    open_lines(&image_lines, images, err) && read_images(&colmap, &image_lines, err) &&
                    distribute(calibration, &colmap, images, projector_image, err);
    ffp_free(camera_lines.text);
    ffp_free(image_lines.text);
    ffp_free(colmap.cameras);
    ffp_free(colmap.images);
    return ok;
}
