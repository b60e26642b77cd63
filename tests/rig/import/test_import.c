// Whole imports of a simulated rig: a ball, seen through lenses, by a projector that has one too. The capture
// must hold the true poses, and drawing the ball again with the capture's ideal devices and patterns must
// give the capture's pictures.
#include <dirent.h>
#include <math.h>
#include <stdio.h>
#include <tgmath.h>
#include <jpeglib.h>
#include "core/base/alloc.h"
#include "core/base/call.h"
#include "core/base/rng.h"
#include "core/base/vec.h"
#include "core/image/lookup.h"
#include "named.h"
#include "rig/import/import.h"
#include "rig/optics/lens.h"
#include "rig/optics/matrix.h"
#include "short_of_memory.h"

#define VIEWS 4
#define WIDTH 96
#define HEIGHT 72

typedef struct Rig {
    int n_views;
    FfpStop stops[VIEWS];
    FfpOptics projector;
    real centre[3], radius, strength; // of the ball; radiance = strength / d^2 * cosine
} Rig;

static const char *const names[3] = {"black", "white", "dots"};
static FfpError err;

// --- The rig. ---

static void look_at(const double from[3], double pose[16]) {
    double z[3], n = 0;
    for (int i = 0; i < 3; i++) z[i] = -from[i], n += z[i] * z[i];
    for (int i = 0; i < 3; i++) z[i] /= sqrt(n);
    const double flat = sqrt(z[0] * z[0] + z[1] * z[1]), x[3] = {z[1] / flat, -z[0] / flat, 0};
    const double y[3] = {z[1] * x[2] - z[2] * x[1], z[2] * x[0] - z[0] * x[2], z[0] * x[1] - z[1] * x[0]};
    for (int i = 0; i < 3; i++)
        pose[4 * i] = x[i], pose[4 * i + 1] = y[i], pose[4 * i + 2] = z[i], pose[4 * i + 3] = from[i];
    for (int i = 0; i < 4; i++) pose[12 + i] = i == 3;
}

// Cameras around a ball of radius 0.8, the projector standing still above them; its axis leaves its image.
static Rig orbit(bool lenses) {
    static const double lens[5] = {-0.15, 0.08, 0.002, -0.003, 0},
                        lamp[5] = {0.06, -0.1, -0.004, 0.003, 0.02};
    Rig rig = {.n_views = VIEWS, .radius = 0.8, .strength = 3};
    rig.projector = (FfpOptics){.width = 80, .height = 60, .fx = 85, .fy = 83, .cx = 38, .cy = 64};
    if (lenses) memcpy(rig.projector.lens, lamp, sizeof lamp);
    for (int v = 0; v < VIEWS; v++) {
        FfpStop *stop = &rig.stops[v];
        const double azimuth = 0.4 * v - 0.6, at[3] = {2.9 * cos(azimuth), 2.9 * sin(azimuth), 0.3};
        const double light[3] = {1.9, 0.3, 1.1};
        snprintf(stop->id, sizeof stop->id, "%02d", v + 1);
        stop->camera = (FfpOptics){.width = WIDTH, .height = HEIGHT, .fx = 101, .fy = 99, .cx = 47, .cy = 37};
        if (lenses) memcpy(stop->camera.lens, lens, sizeof lens);
        look_at(at, stop->c2w);
        look_at(light, stop->p2w);
        // Its principal point lies below its image, as when a projector throws upwards: tilt it to hit the
        // ball.
        const double tilt = 0.36, c = cos(tilt), s = sin(tilt);
        for (int i = 0; i < 3; i++) {
            const double y = stop->p2w[4 * i + 1], z = stop->p2w[4 * i + 2];
            stop->p2w[4 * i + 1] = c * y - s * z, stop->p2w[4 * i + 2] = s * y + c * z;
        }
    }
    return rig;
}

// --- Its photographs. ---

// Coloured squares; or waves, which survive resampling.
static bool waves;
static FfpImage make_pattern(int width, int height, int index) {
    FfpImage image = ffp_image_new(width, height, 3);
    const int cell = 6, across = width / cell + 1;
    for (int i = 0; i < width * height * 3; i++) {
        const int x = i / 3 % width, y = i / 3 / width, c = i % 3;
        FfpRng rng = ffp_rng(5, (uint64_t)(3 * (y / cell * across + x / cell) + c));
        const double phase = 12.0 * x / width * (c != 1) + 10.0 * y / width * (c != 0) + c;
        image.data[i] = waves ? (real)(0.5 + 0.45 * sin(phase)) : ffp_rng_uniform(&rng);
        if (index < 2) image.data[i] = (real)index;
    }
    return image;
}

// The ray of a pixel: the lens undone by fixed-point iteration.
static void pixel_ray(const FfpStop *stop, double u, double v, real direction[3]) {
    const FfpOptics *o = &stop->camera;
    const double x = (u - o->cx) / o->fx, y = (v - o->cy) / o->fy;
    double ideal[2] = {x, y};
    for (int i = 0; i < 12 && !ffp_lens_is_ideal(o->lens); i++) {
        double dx, dy;
        ffp_lens_distort(o->lens, ideal[0], ideal[1], &dx, &dy);
        ideal[0] += x - dx, ideal[1] += y - dy;
    }
    for (int i = 0; i < 3; i++)
        direction[i] =
            (real)(stop->c2w[4 * i] * ideal[0] + stop->c2w[4 * i + 1] * ideal[1] + stop->c2w[4 * i + 2]);
    ffp_normalise3(direction);
}

// The projector's light at a point, lens and all; black off its picture.
static void light_at(const Rig *rig, const FfpStop *stop, const FfpSummed *pattern, const real point[3],
                     real out[3]) {
    const FfpOptics *o = &rig->projector;
    double local[3] = {0}, x, y;
    for (int i = 0; i < 3; i++)
        for (int k = 0; k < 3; k++)
            local[i] += stop->p2w[4 * k + i] * ((double)point[k] - stop->p2w[4 * k + 3]);
    ffp_lens_distort(o->lens, local[0] / local[2], local[1] / local[2], &x, &y);
    out[0] = out[1] = out[2] = 0;
    if (local[2] > 0) ffp_lookup(pattern, (real)(o->cx + o->fx * x), (real)(o->cy + o->fy * y), 1, 1, out);
}

// Radiance along a ray; false when it misses the ball.
static bool shade(const Rig *rig, const FfpStop *stop, const FfpSummed *pattern, const real direction[3],
                  real colour[3]) {
    real origin[3], b = 0, c = -rig->radius * rig->radius;
    for (int i = 0; i < 3; i++) {
        origin[i] = (real)stop->c2w[4 * i + 3] - rig->centre[i];
        b += origin[i] * direction[i], c += origin[i] * origin[i];
    }
    if (b * b < c) return false;
    const real t = -b - sqrt(b * b - c);
    real point[3], lambert = 0, squared = 0;
    for (int i = 0; i < 3; i++) {
        const real normal = (origin[i] + t * direction[i]) / rig->radius;
        point[i] = origin[i] + t * direction[i] + rig->centre[i];
        const real to = (real)stop->p2w[4 * i + 3] - point[i];
        lambert += to * normal, squared += to * to;
    }
    light_at(rig, stop, pattern, point, colour);
    const real strength = fmax(lambert, (real)0) / sqrt(squared) * rig->strength / squared;
    for (int i = 0; i < 3; i++) colour[i] = 0.05F + strength * colour[i];
    return true;
}

// Linear RGB, 2 x 2 samples a pixel; the background is grey and gets none of the projector's light.
static FfpImage photograph(const Rig *rig, const FfpStop *stop, const FfpImage *pattern, real background) {
    FfpImage out = ffp_image_new(stop->camera.width, stop->camera.height, 3);
    FfpSummed summed = ffp_summed_new(pattern);
#pragma omp parallel for schedule(static)
    for (int i = 0; i < out.width * out.height; i++) {
        for (int k = 0; k < 4; k++) {
            real direction[3], colour[3];
            pixel_ray(stop, i % out.width + (k % 2 + 0.5) / 2, i / out.width + (k / 2 + 0.5) / 2, direction);
            const bool hit = shade(rig, stop, &summed, direction, colour);
            for (int c = 0; c < 3; c++) out.data[3 * i + c] += (hit ? colour[c] : background) / 4;
        }
    }
    ffp_summed_free(&summed);
    return out;
}

typedef enum Kind { PNG8, PNG16, EXR, JPEG } Kind;

static void write_jpeg(const FfpImage *encoded, const char *path) {
    struct jpeg_compress_struct jpeg = {0};
    struct jpeg_error_mgr errors;
    FILE *stream = fopen(path, "wb");
    JSAMPLE *row = ffp_alloc((size_t)encoded->width * 3, 1);
    assert_non_null(stream);
    jpeg.err = jpeg_std_error(&errors);
    jpeg_create_compress(&jpeg);
    jpeg_stdio_dest(&jpeg, stream);
    jpeg.image_width = (JDIMENSION)encoded->width, jpeg.image_height = (JDIMENSION)encoded->height;
    jpeg.input_components = 3, jpeg.in_color_space = JCS_RGB;
    jpeg_set_defaults(&jpeg);
    jpeg_set_quality(&jpeg, 98, TRUE);
    jpeg_start_compress(&jpeg, TRUE);
    while (jpeg.next_scanline < jpeg.image_height) {
        const real *from = encoded->data + (size_t)jpeg.next_scanline * (size_t)encoded->width * 3;
        for (int i = 0; i < 3 * encoded->width; i++) row[i] = (JSAMPLE)(from[i] * 255 + 0.5F);
        jpeg_write_scanlines(&jpeg, &row, 1);
    }
    jpeg_finish_compress(&jpeg);
    jpeg_destroy_compress(&jpeg);
    ffp_free(row);
    fclose(stream);
}

static void save(FfpImage *linear, const char *path, Kind kind) {
    if (kind != EXR) ffp_image_to_srgb(linear);
    if (kind == JPEG) {
        write_jpeg(linear, path);
        return;
    }
    assert_true(kind == EXR     ? ffp_image_write_exr(linear, path, NULL)
                : kind == PNG16 ? ffp_image_write_png16(linear, path, NULL)
                                : ffp_image_write_png(linear, path, NULL));
}

// photos/<view>_<pattern>.png and dots.png
static void take_photographs(const Rig *rig, Kind kind) {
    assert_true(ffp_make_folders(in_scratch("photos"), NULL));
    for (int p = 0; p < 3; p++) {
        FfpImage pattern = make_pattern(rig->projector.width, rig->projector.height, p);
        for (int v = 0; v < rig->n_views; v++) {
            char name[64];
            snprintf(name, sizeof name, "photos/%s_%s.png", rig->stops[v].id, names[p]);
            FfpImage picture = photograph(rig, &rig->stops[v], &pattern, 0.02F);
            save(&picture, in_scratch(name), kind);
            ffp_image_free(&picture);
        }
        save(&pattern, in_scratch(p == 2 ? "dots.png" : "plain.png"), PNG8);
        ffp_image_free(&pattern);
    }
}

// --- Importing. ---

typedef struct Call {
    FfpImport options;
    char images[200], pattern[200], folder[100];
    FfpImportImages image_list[1];
    FfpImportPattern pattern_list[1];
    char files[2][100];
    const char *file_list[2];
} Call;

// The options that every import of photographs here has; `files` in the scratch folder.
static Call *call_of(const char *folder, const char *file, const char *second) {
    static Call call;
    call = (Call){0};
    snprintf(call.images, sizeof call.images, "%s/photos/{view}_{pattern}.png", scratch);
    snprintf(call.pattern, sizeof call.pattern, "%s/dots.png", scratch);
    snprintf(call.folder, sizeof call.folder, "%s/%s", scratch, folder);
    snprintf(call.files[0], sizeof call.files[0], "%s/%s", scratch, file);
    snprintf(call.files[1], sizeof call.files[1], "%s/%s", scratch, second ? second : "");
    call.image_list[0] = (FfpImportImages){.patterns = names, .n_patterns = 3, .files = call.images};
    call.pattern_list[0] = (FfpImportPattern){.name = "dots", .file = call.pattern};
    call.file_list[0] = call.files[0], call.file_list[1] = call.files[1];
    call.options = (FfpImport){.size = sizeof(FfpImport),
                               .calibrations = call.file_list,
                               .n_calibrations = second ? 2 : 1,
                               .images = call.image_list,
                               .n_images = 1,
                               .patterns = call.pattern_list,
                               .n_patterns = 1,
                               .folder = call.folder};
    return &call;
}

static void import(FfpCapture *capture, Call *call) {
    if (!ffp_import(&call->options, &err)) fail_msg("%s", err.text);
    if (!ffp_capture_read(capture, call->folder, &err)) fail_msg("%s", err.text);
}

static int count_entries(const char *folder) {
    DIR *dir = opendir(folder);
    int n = 0;
    while (dir && readdir(dir)) n++;
    if (dir) closedir(dir);
    return n;
}

static void must_fail(Call *call, const char *what) {
    const int before = count_entries(scratch);
    const bool ok = ffp_import(&call->options, &err);
    if (ok || !strstr(err.text, what)) printf("expected \"%s\", got: %s\n", what, ok ? "no error" : err.text);
    assert_false(ok);
    assert_non_null(strstr(err.text, what));
    assert_int_equal(count_entries(scratch), before); // neither the folder nor a part of it
}

// The stop with the capture's ideal devices.
static void ideal_stop(const FfpView *view, Rig *rig, FfpStop *stop) {
    const FfpCamera *const devices[2] = {&view->camera, &view->projector};
    FfpOptics *const optics[2] = {&stop->camera, &rig->projector};
    for (int k = 0; k < 2; k++) {
        *optics[k] = (FfpOptics){.width = devices[k]->width,
                                 .height = devices[k]->height,
                                 .fx = (double)devices[k]->fx,
                                 .fy = (double)devices[k]->fy,
                                 .cx = (double)devices[k]->cx,
                                 .cy = (double)devices[k]->cy};
    }
    for (int i = 0; i < 16; i++)
        stop->c2w[i] = (double)view->camera.pose[i], stop->p2w[i] = (double)view->projector.pose[i];
}

// True if the ball fills the pixel and all its neighbours: resampled, others hold some background.
static bool is_inside(const FfpImage *drawn, int i) {
    const int x = i % drawn->width, y = i / drawn->width;
    if (x == 0 || y == 0 || x + 1 == drawn->width || y + 1 == drawn->height) return false;
    for (int k = 0; k < 9; k++) {
        if (isnan(drawn->data[3 * (i + (k / 3 - 1) * drawn->width + k % 3 - 1)])) return false;
    }
    return true;
}

// PSNR over the ball's inside, in encoded values, of the capture's pictures against the ball drawn again with
// its ideal devices and its own patterns; the worst of all.
static double explained(const FfpCapture *capture, Rig rig) {
    double worst = 100;
    for (int v = 0; v < capture->n_views; v++) {
        const FfpView *view = &capture->views[v];
        FfpStop stop;
        ideal_stop(view, &rig, &stop);
        for (int p = 0; p < capture->n_patterns; p++) {
            FfpImage drawn = photograph(&rig, &stop, &capture->patterns[p].image, NAN);
            double sum = 0;
            int count = 0;
            for (int i = 0; i < drawn.width * drawn.height; i++) {
                if (view->coverage.data[i] < 1 || !is_inside(&drawn, i)) continue;
                for (int c = 0; c < 3; c++) {
                    const double d = (double)(ffp_srgb_encode(drawn.data[3 * i + c]) -
                                              ffp_srgb_encode(view->images[p].data[3 * i + c]));
                    sum += d * d, count++;
                }
            }
            assert_true(count > 300);
            worst = fmin(worst, -10 * log10(sum / count));
            ffp_image_free(&drawn);
        }
    }
    return worst;
}

static void check_poses(const FfpCapture *capture, const Rig *rig) {
    assert_int_equal(capture->n_views, rig->n_views);
    for (int v = 0; v < capture->n_views; v++) {
        assert_string_equal(capture->views[v].id, rig->stops[v].id);
        for (int i = 0; i < 16; i++) {
            assert_true(fabs((double)capture->views[v].camera.pose[i] - rig->stops[v].c2w[i]) < 1e-5);
            assert_true(fabs((double)capture->views[v].projector.pose[i] - rig->stops[v].p2w[i]) < 1e-5);
        }
    }
}

static void check(Call *call, const Rig *rig, double least_db) {
    FfpCapture capture;
    import(&capture, call);
    check_poses(&capture, rig);
    const double psnr = explained(&capture, *rig);
    printf("%s: %.1f dB\n", call->folder, psnr);
    assert_true(psnr > least_db);
    ffp_capture_free(&capture);
}

// --- Calibrations as text. ---

static FILE *create(const char *name) {
    FILE *out = fopen(in_scratch(name), "w");
    assert_non_null(out);
    return out;
}

// The quaternion of a rotation whose angle is not near half a turn, w first (Shepperd 1978 has all cases).
static void quaternion(const double r[16], double q[4]) {
    const double diagonal[4] = {1 + r[0] + r[5] + r[10], 1 + r[0] - r[5] - r[10], 1 - r[0] + r[5] - r[10],
                                1 - r[0] - r[5] + r[10]};
    int k = 0;
    for (int i = 1; i < 4; i++) k = diagonal[i] > diagonal[k] ? i : k;
    const double s = 2 * sqrt(diagonal[k]);
    const double products[4][4] = {{s * s / 4, r[9] - r[6], r[2] - r[8], r[4] - r[1]},
                                   {r[9] - r[6], s * s / 4, r[4] + r[1], r[2] + r[8]},
                                   {r[2] - r[8], r[4] + r[1], s * s / 4, r[9] + r[6]},
                                   {r[4] - r[1], r[2] + r[8], r[9] + r[6], s * s / 4}};
    for (int i = 0; i < 4; i++) q[i] = products[k][i] / s;
}

static void put_colmap_image(FILE *out, int id, const double pose[16], int camera, const char *name) {
    double w2c[16], q[4];
    ffp_pose_inverse(pose, w2c);
    quaternion(w2c, q);
    fprintf(out, "%d %.12g %.12g %.12g %.12g %.12g %.12g %.12g %d %s\n", id, q[0], q[1], q[2], q[3], w2c[3],
            w2c[7], w2c[11], camera, name);
    fputs(id % 2 ? "\n" : "12.5 3.25 -1 40 41 7\n", out); // points, or none
}

static void write_colmap(const Rig *rig, const char *folder) {
    char name[64];
    assert_true(ffp_make_folders(in_scratch(folder), NULL));
    snprintf(name, sizeof name, "%s/cameras.txt", folder);
    FILE *out = create(name);
    const FfpOptics *c = &rig->stops[0].camera, *p = &rig->projector;
    fputs("# Camera list with one line of data per camera:\n#   CAMERA_ID, MODEL, WIDTH, HEIGHT, PARAMS[]\n",
          out);
    const bool ideal = ffp_lens_is_ideal(c->lens);
    fprintf(out, "1 %s %d %d %.9g %.9g %.9g %.9g", ideal ? "PINHOLE" : "OPENCV", c->width, c->height, c->fx,
            c->fy, c->cx, c->cy);
    for (int i = 0; i < 4 && !ideal; i++) fprintf(out, " %.9g", c->lens[i]);
    fprintf(out, "\n2 PINHOLE %d %d %.9g %.9g %.9g %.9g\n", p->width, p->height, p->fx, p->fy, p->cx, p->cy);
    fclose(out);
    snprintf(name, sizeof name, "%s/images.txt", folder);
    out = create(name);
    fputs("# Image list with two lines of data per image:\n", out);
    for (int v = 0; v < rig->n_views; v++) {
        snprintf(name, sizeof name, "Camera/%s.png", rig->stops[v].id);
        put_colmap_image(out, v + 1, rig->stops[v].c2w, 1, name);
    }
    put_colmap_image(out, 9, rig->stops[0].p2w, 2, "Projector/calib.png");
    fclose(out);
}

// The orbit's photographs, and its model of COLMAP's.
static Rig photographed(Kind kind) {
    const Rig rig = orbit(false);
    take_photographs(&rig, kind);
    write_colmap(&rig, "model");
    return rig;
}

static void put_rotation(FILE *out, const double pose[16]) {
    for (int i = 0; i < 3; i++)
        fprintf(out, "%s[%.12g, %.12g, %.12g]", i ? ", " : "[", pose[4 * i], pose[4 * i + 1],
                pose[4 * i + 2]);
    fputs("]", out);
}

static void put_k(FILE *out, const FfpOptics *o) {
    fprintf(out, "[[%.12g, 0, %.12g], [0, %.12g, %.12g], [0, 0, 1]]", o->fx, o->cx, o->fy, o->cy);
}

static void write_procams(const Rig *rig) {
    FILE *out = create("cameras.json");
    for (int v = 0; v < rig->n_views; v++) {
        const FfpStop *stop = &rig->stops[v];
        fprintf(out,
                "%s{\"id\": %d, \"view_id\": %d, \"img_name\": \"img_%s\", \"width\": %d, \"height\": %d, ",
                v ? ",\n" : "[", v, v + 1, stop->id, stop->camera.width, stop->camera.height);
        fprintf(out, "\"position\": [%.12g, %.12g, %.12g], \"rotation\": ", stop->c2w[3], stop->c2w[7],
                stop->c2w[11]);
        put_rotation(out, stop->c2w);
        fputs(", \"K\": ", out);
        put_k(out, &stop->camera);
        fputs("}", out);
    }
    fputs("]\n", out);
    fclose(out);
    double w2p[16];
    ffp_pose_inverse(rig->stops[0].p2w, w2p);
    out = create("projector.json");
    fprintf(out, "[{\"width\": %d, \"height\": %d, \"R\": ", rig->projector.width, rig->projector.height);
    put_rotation(out, rig->stops[0].p2w); // the transpose of the rotation from the world
    fprintf(out, ", \"T\": [%.12g, %.12g, %.12g], \"K\": ", w2p[3], w2p[7], w2p[11]);
    put_k(out, &rig->projector);
    fputs(", \"FoVx\": 0.9, \"FoVy\": 0.7}]\n", out);
    fclose(out);
}

// Blender's axes: y and z turned round.
static void put_blender(FILE *out, const double pose[16]) {
    for (int i = 0; i < 4; i++)
        fprintf(out, "%s[%.12g, %.12g, %.12g, %.12g]", i ? ", " : "[", pose[4 * i], -pose[4 * i + 1],
                -pose[4 * i + 2], pose[4 * i + 3]);
    fputs("]", out);
}

static void write_nepmap(const Rig *rig) {
    FILE *out = create("transforms.json");
    fputs("{\"camera_angle_x\": 0.8, \"K_cam\": ", out);
    put_k(out, &rig->stops[0].camera);
    fputs(", \"K_proj\": ", out);
    put_k(out, &rig->projector);
    fputs(", \"blender_matrix_world_proj\": ", out);
    put_blender(out, rig->stops[0].p2w);
    fputs(", \"frames\": [", out);
    for (int i = 0; i < 3 * rig->n_views; i++) {
        const FfpStop *stop = &rig->stops[i / 3];
        fprintf(out, "%s{\"file_path\": \"photos/%s_%s\", \"view_id\": \"%s\", \"patterns\": [\"%s\"], ",
                i ? ",\n" : "", stop->id, names[i % 3], stop->id, names[i % 3]);
        fputs("\"blender_matrix_world\": ", out);
        put_blender(out, stop->c2w);
        fputs("}", out);
    }
    fputs("]}\n", out);
    fclose(out);
    assert_true(ffp_make_folders(in_scratch("projector"), NULL));
    FfpImage pattern = make_pattern(rig->projector.width, rig->projector.height, 2);
    save(&pattern, in_scratch("projector/dots.png"), PNG8);
    ffp_image_free(&pattern);
}

static void put_matrix(FILE *out, const char *name, int rows, int cols, const double *values) {
    fprintf(out, "%s: !!opencv-matrix\n   rows: %d\n   cols: %d\n   dt: d\n   data: [ ", name, rows, cols);
    for (int i = 0; i < rows * cols; i++) fprintf(out, "%s%.16e", i ? ", " : "", values[i]);
    fputs(" ]\n", out);
}

// The rig of one view as OpenCV's tools write it.
static void write_opencv(const Rig *rig, int view, const char *name) {
    const FfpStop *stop = &rig->stops[view];
    const FfpOptics *o[2] = {&stop->camera, &rig->projector};
    double w2p[16], c2p[16], r[9], t[3];
    ffp_pose_inverse(stop->p2w, w2p);
    ffp_pose_product(w2p, stop->c2w, c2p);
    for (int i = 0; i < 9; i++) r[i] = c2p[4 * (i / 3) + i % 3];
    for (int i = 0; i < 3; i++) t[i] = c2p[4 * i + 3];
    FILE *out = create(name);
    fputs("%YAML:1.0\n---\n", out);
    for (int k = 0; k < 2; k++) {
        const double matrix[9] = {o[k]->fx, 0, o[k]->cx - 0.5, 0, o[k]->fy, o[k]->cy - 0.5, 0, 0, 1};
        put_matrix(out, k ? "prjK" : "camK", 3, 3, matrix);
        put_matrix(out, k ? "prjKc" : "camKc", 1, 5, o[k]->lens);
    }
    put_matrix(out, "R", 3, 3, r);
    put_matrix(out, "T", 3, 1, t);
    fprintf(out, "camW: %d\ncamH: %d\nprjW: %d\nprjH: %d\n", o[0]->width, o[0]->height, o[1]->width,
            o[1]->height);
    fclose(out);
}

// --- The tests. ---

static void test_poses_of_all_views(void **state) {
    (void)state;
    const Rig rig = orbit(false);
    take_photographs(&rig, PNG8);
    write_colmap(&rig, "model/sparse/0");
    check(call_of("from_colmap", "model", NULL), &rig, 30);
    write_procams(&rig);
    check(call_of("from_procams", "cameras.json", "projector.json"), &rig, 30);
    write_nepmap(&rig);
    Call *call = call_of("from_nepmap", "transforms.json", NULL);
    call->options.n_images = call->options.n_patterns = 0; // it names them itself
    check(call, &rig, 30);
}

// Both lenses are taken out; and if the camera's were not, it would show.
static void test_lenses(void **state) {
    (void)state;
    Rig rig = orbit(true);
    waves = true;
    take_photographs(&rig, PNG16);
    write_opencv(&rig, 1, "both.yml");
    Call *call = call_of("both", "both.yml", NULL);
    snprintf(call->images, sizeof call->images, "%s/photos/02_{pattern}.png", scratch);
    FfpCapture capture;
    import(&capture, call);
    assert_int_equal(capture.n_views, 1);
    Rig seen = rig; // in the camera's frame
    double w2c[16];
    ffp_pose_inverse(rig.stops[1].c2w, w2c);
    for (int i = 0; i < 3; i++) seen.centre[i] = (real)w2c[4 * i + 3];
    const double with = explained(&capture, seen);
    const FfpPanel *panel = &capture.panel; // the projector as it is
    assert_true(panel->known && panel->width == rig.projector.width && panel->height == rig.projector.height);
    assert_true(fabs((double)panel->cy - rig.projector.cy) < 1e-4 && !panel->power);
    for (int i = 0; i < 5; i++) assert_true(fabs((double)panel->lens[i] - rig.projector.lens[i]) < 1e-6);
    ffp_capture_free(&capture);
    memset(rig.stops[1].camera.lens, 0, sizeof rig.stops[1].camera.lens);
    write_opencv(&rig, 1, "one.yml");
    Call *ignorant = call_of("ignorant", "one.yml", NULL);
    snprintf(ignorant->images, sizeof ignorant->images, "%s/photos/02_{pattern}.png", scratch);
    import(&capture, ignorant);
    const double without = explained(&capture, seen);
    ffp_capture_free(&capture);
    printf("lenses removed: %.1f dB; the camera's left in: %.1f dB\n", with, without);
    assert_true(with > 44 && without < with - 5);
    waves = false;
}

static void test_colmap_lens(void **state) {
    (void)state;
    Rig rig = orbit(true);
    waves = true;
    memset(rig.projector.lens, 0, sizeof rig.projector.lens);
    take_photographs(&rig, EXR);
    write_colmap(&rig, "distorted");
    check(call_of("from_opencv_model", "distorted", NULL), &rig, 44);
    waves = false;
}

// Photographs taken at twice the calibrated size, and cut out of a larger sensor; patterns likewise.
static void test_other_sizes(void **state) {
    (void)state;
    const Rig rig = orbit(false);
    take_photographs(&rig, PNG8);
    Rig told = rig;
    FfpOptics *p = &told.projector;
    for (int v = 0; v < VIEWS; v++) {
        FfpOptics *c = &told.stops[v].camera;
        c->width /= 2, c->height /= 2, c->fx /= 2, c->fy /= 2, c->cx /= 2, c->cy /= 2;
    }
    p->width += 40, p->height += 9, p->cx += 31, p->cy += 4;
    write_colmap(&told, "elsewhere");
    Call *call = call_of("resized", "elsewhere", NULL);
    must_fail(call, "projector.fit");
    call->options.projector = (FfpCalibratedAt){.fit = FFP_FIT_CROPPED, .left = 31, .top = 4};
    must_fail(call, "camera.fit");
    call->options.camera.fit = FFP_FIT_SCALED;
    check(call, &rig, 50);
    FfpCapture capture; // the panel is what was calibrated
    if (!ffp_capture_read(&capture, call->folder, &err)) fail_msg("%s", err.text);
    assert_true(capture.panel.width == p->width && capture.panel.height == p->height);
    assert_true(fabs((double)capture.panel.cx - p->cx) < 1e-4 &&
                fabs((double)capture.panel.cx - (double)capture.views[0].projector.cx - 31) < 1e-4);
    ffp_capture_free(&capture);
}

// Half as wide: the pinhole keeps its field, and a pixel is the mean of four.
static void test_narrower(void **state) {
    (void)state;
    waves = true;
    const Rig rig = photographed(PNG8);
    Call *call = call_of("narrow", "model", NULL);
    call->options.width = WIDTH / 2;
    FfpCapture capture;
    import(&capture, call);
    assert_int_equal(capture.views[2].camera.height, HEIGHT / 2);
    int width = 0, height = 0; // of the file: whole patches
    assert_true(ffp_image_read_size(&width, &height, in_scratch("narrow/03_white.png"), &err));
    assert_int_equal(width, WIDTH / 2);
    assert_int_equal(height, 40);
    assert_true(fabs((double)capture.views[2].camera.cy - 18.5) < 1e-5);
    check_poses(&capture, &rig);
    const double psnr = explained(&capture, rig);
    printf("half as wide: %.1f dB\n", psnr);
    assert_true(psnr > 48);
    ffp_capture_free(&capture);
    waves = false;
}

// The mask that is made against the ball's true silhouette: all that is lit, and no background.
static void test_masks(void **state) {
    (void)state;
    const Rig rig = photographed(PNG8);
    Call *call = call_of("made", "model", NULL);
    FfpCapture capture;
    import(&capture, call);
    assert_true(ffp_make_folders(in_scratch("masks"), NULL));
    for (int v = 0; v < VIEWS; v++) {
        FfpImage white = make_pattern(rig.projector.width, rig.projector.height, 1), mask;
        mask = photograph(&rig, &rig.stops[v], &white, 0);
        int lit = 0, found = 0, both = 0, within = 0;
        for (int i = 0; i < WIDTH * HEIGHT; i++) {
            const bool is_lit = mask.data[3 * i] > 0.1F, is_found = capture.views[v].coverage.data[i] > 0.5F;
            lit += is_lit, found += is_found, both += is_lit && is_found;
            within += is_found && mask.data[3 * i] > 0;
            const real inside = mask.data[3 * i] > 0.03F;
            for (int c = 0; c < 3; c++) mask.data[3 * i + c] = inside;
            // Pictures are black where the mask is 0.
            assert_true(capture.views[v].coverage.data[i] > 0 ||
                        capture.views[v].images[capture.white].data[3 * i] == 0);
        }
        printf("view %d: %d pixels lit, %d found, %d of them both, %d on the ball\n", v, lit, found, both,
               within);
        assert_true(both > 0.97 * lit && within > 0.99 * found);
        char name[64];
        snprintf(name, sizeof name, "masks/%d.png", v);
        assert_true(ffp_image_write_png(&mask, in_scratch(name), NULL));
        ffp_image_free(&mask);
        ffp_image_free(&white);
    }
    ffp_capture_free(&capture);
    // The same from files; these know the ball's dark side too.
    char masks[128];
    snprintf(masks, sizeof masks, "%s/masks/{index}.png", scratch);
    call = call_of("given", "model", NULL);
    call->options.masks = FFP_MASKS_FROM_FILES, call->options.mask_files = masks;
    check(call, &rig, 50);
    // A later one that is damaged, or finer than the photographs, is refused by name.
    call = call_of("never", "model", NULL);
    call->options.masks = FFP_MASKS_FROM_FILES, call->options.mask_files = masks;
    assert_true(ffp_write_file(in_scratch("masks/1.png"), "\x89PNG\r\n\x1a\n", 8, NULL));
    must_fail(call, "masks/1.png");
    FfpImage finer = ffp_image_new(2 * WIDTH, 2 * HEIGHT, 1);
    assert_true(ffp_image_write_png(&finer, in_scratch("masks/1.png"), NULL));
    ffp_image_free(&finer);
    must_fail(call, "image is 192 x 144, but the others are 96 x 72");
}

// JPEG; and EXR pictures four times as bright as the range allows, brought back by two stops.
static void test_kinds_of_files(void **state) {
    (void)state;
    Rig rig = orbit(false);
    waves = true;
    write_colmap(&rig, "model");
    take_photographs(&rig, JPEG);
    check(call_of("from_jpeg", "model", NULL), &rig, 35);
    take_photographs(&rig, EXR);
    for (int v = 0; v < VIEWS; v++)
        for (int p = 0; p < 3; p++) {
            char name[64];
            snprintf(name, sizeof name, "photos/%s_%s.png", rig.stops[v].id, names[p]);
            FfpImage picture = {0};
            assert_true(ffp_image_read_over_black(&picture, NULL, in_scratch(name), NULL));
            for (int i = 0; i < 3 * WIDTH * HEIGHT; i++) picture.data[i] *= 4;
            assert_true(ffp_image_write_exr(&picture, in_scratch(name), NULL));
            ffp_image_free(&picture);
        }
    Call *call = call_of("from_bright_exr", "model", NULL);
    call->options.exposure = -2;
    check(call, &rig, 55);
    waves = false;
}

// Files that hold linear values, as raw converters write them.
static void test_linear_files(void **state) {
    (void)state;
    const Rig rig = photographed(EXR);
    for (int v = 0; v < VIEWS; v++)
        for (int p = 0; p < 3; p++) {
            char name[64];
            snprintf(name, sizeof name, "photos/%s_%s.png", rig.stops[v].id, names[p]);
            FfpImage picture = {0};
            assert_true(ffp_image_read_over_black(&picture, NULL, in_scratch(name), NULL));
            assert_true(ffp_image_write_png16(&picture, in_scratch(name), NULL));
            ffp_image_free(&picture);
        }
    FfpImage pattern = make_pattern(rig.projector.width, rig.projector.height, 2);
    assert_true(ffp_image_write_png16(&pattern, in_scratch("dots.png"), NULL));
    ffp_image_free(&pattern);
    Call *call = call_of("linear", "model", NULL);
    call->options.linear_images = call->options.linear_patterns = true;
    check(call, &rig, 50);
    FfpCapture capture;
    if (!ffp_capture_read(&capture, call->folder, &err)) fail_msg("%s", err.text);
    assert_true(capture.panel.power && capture.panel.gamma[0] == 1 && capture.panel.gamma[2] == 1);
    ffp_capture_free(&capture);
}

// The white picture's alpha channel masks the others, unless it is 1 everywhere.
static void test_alpha(void **state) {
    (void)state;
    const Rig rig = photographed(PNG8);
    for (int opaque = 0; opaque < 2; opaque++) {
        for (int v = 0; v < VIEWS; v++) {
            char name[64];
            snprintf(name, sizeof name, "photos/%s_white.png", rig.stops[v].id);
            FfpImage picture = {0}, rgba = ffp_image_new(WIDTH, HEIGHT, 4);
            assert_true(ffp_image_read(&picture, in_scratch(name), FFP_COLOUR_ENCODED, NULL));
            for (int i = 0; i < 4 * WIDTH * HEIGHT; i++)
                rgba.data[i] = i % 4 < 3 ? picture.data[i] : opaque || i / 4 % WIDTH > 20;
            assert_true(ffp_image_write_png(&rgba, in_scratch(name), NULL));
            ffp_image_free(&picture);
            ffp_image_free(&rgba);
        }
        FfpCapture capture;
        import(&capture, call_of(opaque ? "opaque" : "alpha", "model", NULL));
        int right = 0;
        for (int i = 0; i < WIDTH * HEIGHT; i++) {
            right += capture.views[1].coverage.data[i] == (real)(i % WIDTH > 20);
            if (!opaque && i % WIDTH <= 20)
                assert_true(capture.views[1].images[capture.black].data[3 * i] == 0);
        }
        printf("%.2f of the pixels are as the alpha channel's\n", (double)right / (WIDTH * HEIGHT));
        assert_true(opaque ? right < WIDTH * HEIGHT * 3 / 4 : right == WIDTH * HEIGHT);
        ffp_capture_free(&capture);
    }
}

static void test_some_views(void **state) {
    (void)state;
    const Rig rig = photographed(PNG8);
    Call *call = call_of("some", "model", NULL);
    const char *const views[3] = {"04", "02", "04"};
    call->options.views = views, call->options.n_views = 3;
    must_fail(call, "named twice");
    call->options.n_views = 2;
    FfpCapture capture;
    import(&capture, call);
    assert_int_equal(capture.n_views, 2);
    assert_string_equal(capture.views[0].id, "04");
    assert_true(explained(&capture, rig) > 50);
    ffp_capture_free(&capture);
}

// --- What goes wrong. ---

static void test_bad_pictures(void **state) {
    (void)state;
    Rig rig = photographed(PNG8);
    Call *call = call_of("never", "model", NULL);
    char *data = NULL;
    size_t size = 0;
    const char *path = in_scratch("photos/03_dots.png");
    leave_memory("1000"); // of the 2 MB that four views take
    must_fail(call,
              "the pictures need 0.0 GB of memory; this machine has 0.0 left: make them narrower (width)");
    meminfo = NULL;
    assert_true(ffp_read_file(path, 1 << 20, &data, &size, NULL));
    assert_true(ffp_write_file(path, data, size / 2, NULL));
    must_fail(call, "03_dots.png");
    assert_true(ffp_write_file(path, "GIF89a", 6, NULL));
    must_fail(call, "03_dots.png");
    FfpImage small = ffp_image_new(WIDTH / 2, HEIGHT, 3);
    assert_true(ffp_image_write_png(&small, path, NULL));
    ffp_image_free(&small);
    must_fail(call, "but the others are 96 x 72");
    assert_int_equal(remove(path), 0);
    must_fail(call, "no such file");
    assert_true(ffp_write_file(path, data, size, NULL));
    ffp_free(data);
    // At one stop white was shown first, which noise must not hide.
    FfpImage swapped[2];
    FfpRng rng = ffp_rng(5, 1);
    for (int p = 0; p < 2; p++)
        assert_true(ffp_image_read(&swapped[p], in_scratch(p ? "photos/02_black.png" : "photos/02_white.png"),
                                   FFP_COLOUR_ENCODED, NULL));
    for (int p = 0; p < 2; p++) {
        for (int i = 0; i < swapped[p].width * swapped[p].height * swapped[p].channels; i++)
            swapped[p].data[i] += 0.01F * ffp_rng_normal(&rng);
        assert_true(ffp_image_write_png(&swapped[p],
                                        in_scratch(p ? "photos/02_white.png" : "photos/02_black.png"), NULL));
        ffp_image_free(&swapped[p]);
    }
    must_fail(call, "02_white.png");
    must_be(&err, FFP_RULE_PLAIN_SWAPPED);
    // White and black of the same light: nothing to see.
    snprintf(call->images, sizeof call->images, "%s/photos/{view}_dots.png", scratch);
    must_fail(call, "names one file for 3 patterns");
    rig.stops[0].camera.lens[0] = -3;
    rig.projector.lens[0] = 0;
    write_opencv(&rig, 0, "fold.yml");
    call = call_of("never", "fold.yml", NULL);
    snprintf(call->images, sizeof call->images, "%s/photos/01_{pattern}.png", scratch);
    must_fail(call, "folds the picture over itself");
}

// A real file, and photographs as its rig would take them: millimetres, two lenses, an off-centre projector.
static void test_real_calibration(void **state) {
    (void)state;
    char path[1024];
    if (!shared_path(path, "real/single-shot/calibration.yml")) skip();
    const char *files[1] = {path};
    FfpCalibration calibration;
    assert_true(ffp_calibration_read(&calibration, files, 1, "calib", &err));
    Rig rig = {.n_views = 1, .radius = 90, .strength = 1.5e6F, .projector = calibration.projector};
    FfpStop *stop = &rig.stops[0];
    stop->camera = calibration.camera;
    snprintf(stop->id, sizeof stop->id, "000");
    for (int i = 0; i < 16; i++) stop->c2w[i] = i % 5 == 0;
    memcpy(stop->p2w, calibration.p2c, sizeof stop->p2w);
    ffp_calibration_free(&calibration);
    // A ball 1.2 m before the camera; where exactly the projector's beam is, is found by looking.
    const double *p = stop->p2w;
    const double beam[3] = {(400 - rig.projector.cx) / rig.projector.fx,
                            (300 - rig.projector.cy) / rig.projector.fy, 1};
    for (int i = 0; i < 3; i++) {
        rig.centre[i] = (real)(p[4 * i + 3] +
                               1300 * (p[4 * i] * beam[0] + p[4 * i + 1] * beam[1] + p[4 * i + 2] * beam[2]));
        printf("%.0f ", (double)rig.centre[i]);
    }
    waves = true;
    take_photographs(&rig, PNG8);
    Call *call = call_of("real", "unused", NULL);
    call->file_list[0] = path;
    check(call, &rig, 50);
    waves = false;
}

static char told[256];

static void keep_code(void *user, const FfpFinding *finding) {
    (void)user;
    snprintf(told, sizeof told, "%s %s", finding->code, finding->setting ? finding->setting : "");
}

static bool run_import(void *argument, FfpError *error) {
    return ffp_import(argument, error);
}

// Twelve bits in files of 16 are told with the stops that they lack, and with these they are not; and where
// they were read as sRGB.
static void test_twelve_bits(void **state) {
    (void)state;
    const Rig rig = orbit(false);
    FfpContext context = {.settings = {.finding = keep_code}};
    take_photographs(&rig, EXR);
    write_colmap(&rig, "model");
    for (int v = 0; v < VIEWS; v++)
        for (int p = 0; p < 3; p++) {
            char name[64];
            snprintf(name, sizeof name, "photos/%s_%s.png", rig.stops[v].id, names[p]);
            FfpImage picture = {0};
            assert_true(ffp_image_read_over_black(&picture, NULL, in_scratch(name), NULL));
            for (int i = 0; i < 3 * WIDTH * HEIGHT; i++)
                picture.data[i] = fminf(picture.data[i], 1) * 4095 / 65535;
            assert_true(ffp_image_write_png16(&picture, in_scratch(name), NULL));
            ffp_image_free(&picture);
        }
    Call *call = call_of("twelve", "model", NULL);
    call->options.linear_images = call->options.linear_patterns = true;
    if (!ffp_call_run(&context, run_import, &call->options, &err)) fail_msg("%s", err.text);
    assert_string_equal(told, "twelve-bits exposure=4");
    told[0] = 0;
    call = call_of("sixteen", "model", NULL);
    call->options.linear_images = call->options.linear_patterns = true;
    call->options.exposure = 4;
    if (!ffp_call_run(&context, run_import, &call->options, &err)) fail_msg("%s", err.text);
    assert_null(strstr(told, "twelve-bits"));
    call = call_of("twelve_as_srgb", "model", NULL);
    assert_false(ffp_call_run(&context, run_import, &call->options, &err)); // in nearly black pictures
    assert_string_equal(told, "twelve-bits-as-srgb linear=images");
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_poses_of_all_views),
        cmocka_unit_test(test_lenses),
        cmocka_unit_test(test_colmap_lens),
        cmocka_unit_test(test_other_sizes),
        cmocka_unit_test(test_narrower),
        cmocka_unit_test(test_masks),
        cmocka_unit_test(test_bad_pictures),
        cmocka_unit_test(test_kinds_of_files),
        cmocka_unit_test(test_alpha),
        cmocka_unit_test(test_linear_files),
        cmocka_unit_test(test_twelve_bits),
        cmocka_unit_test(test_some_views),
        cmocka_unit_test(test_real_calibration),
    };
    return cmocka_run_group_tests(tests, scratch_setup, scratch_teardown);
}
