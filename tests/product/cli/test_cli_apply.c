// `compensate` and `map` as a user runs them: results, and errors before anything is written.
#include "core/base/file.h"
#include "core/gaussians/gaussians.h"
#include "product/cli/program.h"
#include "product/cli/tiny.h"
#include "unzip.h"
#include "world/shapes/mesh.h"

#define SIDE 48

static ProgramRun run;

static void must_run(void) {
    if (run.status != 0) printf("exit %d\n%s", run.status, run.err);
    assert_int_equal(run.status, 0);
}

static int group_setup(void **state) {
    if (scratch_setup(state) != 0) return -1;
    tiny_capture(in_scratch("tiny"), SIDE);
    run_format(&run, "reconstruct %s/tiny -o %s/tiny.ply --model none", scratch, scratch);
    must_run();
    run_format(&run, "generate %s/scenes --split test --preset smoke --resolution 64 --count 1 --seed 5",
               scratch);
    must_run();
    return 0;
}

// The number behind a word in the program's output.
static double number_after(const char *word) {
    const char *at = strstr(run.out, word);
    assert_non_null(at);
    return strtod(at + strlen(word), NULL);
}

static void read_encoded(FfpImage *image, const char *name) {
    FfpError err = {0};
    if (!ffp_image_read(image, in_scratch(name), FFP_COLOUR_ENCODED, &err)) fail_msg("%s", err.text);
}

// A wide picture with a transparent left half, as a logo is.
static void write_logo(const char *name) {
    FfpError err = {0};
    FfpImage logo = ffp_image_new(160, 90, 4);
    for (int i = 0; i < 160 * 90; i++)
        for (int c = 0; c < 4; c++) logo.data[4 * i + c] = i % 160 < 80 ? 0 : 1;
    if (!ffp_image_write_png(&logo, in_scratch(name), &err)) fail_msg("%s", err.text);
    ffp_image_free(&logo);
}

// Any shape is taken, with a note; what is transparent is black.
static void targets_of_any_shape_with_transparent_parts(void **state) {
    (void)state;
    FfpImage black, contained;
    write_logo("logo.png");
    run_format(&run,
               "compensate %s/tiny.ply -c %s/tiny -v view_1 -t %s/logo.png --paint -s 0 -o %s/black.png",
               scratch, scratch, scratch, scratch);
    must_run();
    assert_non_null(strstr(run.err, "160 x 90 is cropped to fill"));
    run_format(&run,
               "compensate %s/tiny.ply -c %s/tiny -v view_1 -t %s/logo.png --paint -s 0 --fit contain -o "
               "%s/contain.png",
               scratch, scratch, scratch, scratch);
    must_run();
    assert_non_null(strstr(run.err, "fitted inside"));
    read_encoded(&black, "black.png");
    read_encoded(&contained, "contain.png");
    double cover = 0, contain = 0;
    for (int i = 0; i < TINY_PATTERN * TINY_PATTERN; i++) {
        cover += (double)black.data[4 * i];
        contain += (double)contained.data[4 * i];
    }
    assert_true(contain > 0 && cover > contain); // the logo is smaller
    ffp_image_free(&black);
    ffp_image_free(&contained);

    FfpImage clear = ffp_image_new(SIDE, SIDE, 4);
    assert_true(ffp_image_write_png(&clear, in_scratch("clear.png"), NULL));
    ffp_image_free(&clear);
    run_format(&run, "compensate %s/tiny.ply -c %s/tiny -v view_1 -t %s/clear.png --paint -o %s/dark.png",
               scratch, scratch, scratch, scratch);
    must_run();
    read_encoded(&black, "dark.png");
    for (int i = 0; i < TINY_PATTERN * TINY_PATTERN; i++)
        for (int c = 0; c < 3; c++) assert_true(black.data[4 * i + c] == 0);
    ffp_image_free(&black);
}

// Three slanted strokes with soft edges, as a word is; transparent parts are white, as many programs leave
// them.
static void write_letters(const char *name, int side) {
    FfpError err = {0};
    FfpImage letters = ffp_image_new(side, side, 4);
    for (int p = 0; p < side * side; p++) {
        const double x = (p % side + 0.25 * (p / side)) * 48 / side; // in 48ths
        const double beside = fabs(x - 12 * floor(x / 12) - 6) - 1.5, edge = 24.0 / side;
        for (int c = 0; c < 3; c++) letters.data[4 * p + c] = 1;
        letters.data[4 * p + 3] = (real)fmin(fmax(0.5 - beside / edge, 0), 1);
    }
    if (!ffp_image_write_png(&letters, in_scratch(name), &err)) fail_msg("%s", err.text);
    ffp_image_free(&letters);
}

// The light on the object that nobody asked for: the greatest of what is seen above the target, at pixels
// whose neighbours are all transparent, too.
static double halo(const char *seen_name, const char *target_name) {
    FfpImage seen, target, letters;
    double most = 0;
    read_encoded(&seen, seen_name);
    read_encoded(&target, target_name);
    read_encoded(&letters, "letters.png");
    for (int y = 1; y < SIDE - 1; y++)
        for (int x = 1; x < SIDE - 1; x++) {
            double alpha = 0;
            for (int k = 0; k < 9; k++)
                alpha += (double)letters.data[4 * ((y + k / 3 - 1) * SIDE + x + k % 3 - 1) + 3];
            const int p = 4 * (y * SIDE + x);
            if (alpha == 0) most = fmax(most, (double)(seen.data[p] - target.data[p]));
        }
    ffp_image_free(&seen);
    ffp_image_free(&target);
    ffp_image_free(&letters);
    return most;
}

static void letters_have_no_halos(void **state) {
    (void)state;
    write_letters("letters.png", SIDE);
    run_format(&run, "compensate %s/tiny.ply -c %s/tiny -v view_1 -t %s/letters.png --paint -o %s/word.png",
               scratch, scratch, scratch, scratch);
    must_run();
    const double black = halo("word_seen_view_1.png", "word_target_view_1.png");
    run_format(&run,
               "compensate %s/tiny.ply -c %s/tiny -v view_1 -t %s/letters.png --paint --transparent free -o "
               "%s/free.png",
               scratch, scratch, scratch, scratch);
    must_run();
    const double free = halo("free_seen_view_1.png", "word_target_view_1.png");
    print_message("beside letters at most %.1f steps of 255, free %.1f\n", 255 * black, 255 * free);
    assert_true(255 * black < 8);
    assert_true(255 * free > 12);
}

// Before the descent the closed form takes a target's edges from its own pixels, not from the camera's, which
// are coarser.
static void edges_are_finer_than_the_cameras_pixels(void **state) {
    (void)state;
    write_letters("fine.png", 8 * SIDE);
    run_format(&run,
               "compensate %s/tiny.ply -c %s/tiny -v view_1 -t %s/fine.png --paint -s 1 -o %s/fine_p.png",
               scratch, scratch, scratch, scratch);
    must_run();
    assert_true(number_after("dB dark, ") > 34.5); // 32.9 from the camera's pixels
}

static void compensate_writes_pattern_prediction_and_target(void **state) {
    (void)state;
    run_format(
        &run,
        "compensate %s/tiny.ply -c %s/tiny -v view_1 -t %s/tiny/view_2_stripes.png --paint -s 30 -o %s/p.png",
        scratch, scratch, scratch, scratch);
    must_run();
    FfpImage pattern, seen, target;
    read_encoded(&pattern, "p.png");
    read_encoded(&seen, "p_seen_view_1.png");
    read_encoded(&target, "p_target_view_1.png");
    assert_int_equal(pattern.width, TINY_PATTERN);
    assert_int_equal(seen.width, SIDE);
    assert_int_equal(target.height, SIDE);
    double bright = 0;
    for (int i = 0; i < 4 * TINY_PATTERN * TINY_PATTERN; i++) bright += i % 4 < 3 && pattern.data[i] > 0.1F;
    assert_true(bright > 100);
    assert_true(number_after("dB dark, ") > 20);
    assert_true(number_after("closed form, ") > number_after("dB dark, "));
    ffp_image_free(&pattern);
    ffp_image_free(&seen);
    ffp_image_free(&target);
}

static void several_projectors_get_a_pattern_each(void **state) {
    (void)state;
    run_format(
        &run,
        "compensate %s/tiny.ply -c %s/tiny -v view_0 -v view_1 -t %s/tiny/view_0_all_black.png -g auto -s 2 "
        "-o %s/both.png",
        scratch, scratch, scratch, scratch);
    must_run();
    assert_true(ffp_is_file(in_scratch("both_view_0.png")) && ffp_is_file(in_scratch("both_view_1.png")));
    assert_false(ffp_is_file(in_scratch("both.png")));
    assert_true(ffp_is_file(in_scratch("both_seen_view_0.png")) &&
                ffp_is_file(in_scratch("both_seen_view_1.png")));
    assert_non_null(strstr(run.out, "patterns       2"));
    assert_true(number_after("gain ") > 0);
}

// The camera's picture of the ball under a pattern, encoded.
static FfpImage seen_under(const FfpCamera *camera, const FfpCamera *projector, const FfpImage *pattern) {
    FfpSummed light = ffp_summed_new(pattern);
    FfpImage seen = tiny_photograph(camera, projector, &light);
    ffp_image_to_srgb(&seen);
    ffp_summed_free(&light);
    return seen;
}

// Root mean square difference inside the ball of two encoded pictures of four channels.
static double ball_off(const FfpImage *a, const FfpImage *ball) {
    double square = 0, count = 0;
    assert_int_equal(a->channels, 4);
    assert_int_equal(a->width, ball->width);
    for (int i = 0; i < 4 * a->width * a->height; i++)
        if (i % 4 < 3 && ball->data[i - i % 4 + 3] == 1)
            square += pow((double)(a->data[i] - ball->data[i]), 2), count++;
    assert_true(count > 1000);
    return sqrt(square / count);
}

// The ball, lit by what is written, is to look as asked for, and the program is to have foreseen it.
static void compensation_for_new_poses_uses_the_gaussians(void **state) {
    (void)state;
    FfpCamera camera, projector;
    FfpImage black = ffp_image_new(TINY_PATTERN, TINY_PATTERN, 3), pattern, seen, target;
    tiny_aside(scratch, SIDE, &camera, &projector);
    read_encoded(&target, "aside.png");
    FfpImage dark = seen_under(&camera, &projector, &black);
    run_format(&run,
               "compensate %s/tiny.ply -c %s/tiny --poses %s/aside.json -v aside -t %s/aside.png -s 30 "
               "-o %s/new.png",
               scratch, scratch, scratch, scratch, scratch);
    must_run();
    read_encoded(&pattern, "new.png");
    read_encoded(&seen, "new_seen_aside.png");
    FfpImage light = ffp_image_new(TINY_PATTERN, TINY_PATTERN, 3);
    assert_int_equal(pattern.width, TINY_PATTERN);
    for (int i = 0; i < 3 * TINY_PATTERN * TINY_PATTERN; i++) light.data[i] = pattern.data[i / 3 * 4 + i % 3];
    ffp_image_to_linear(&light);
    FfpImage lit = seen_under(&camera, &projector, &light);
    const double before = ball_off(&dark, &target), foreseen = ball_off(&seen, &target),
                 after = ball_off(&lit, &target);
    printf("off the target by %.3f in the dark, by %.3f as foreseen, by %.3f as lit\n", before, foreseen,
           after);
    FfpImage *all[] = {&black, &pattern, &seen, &light, &target, &dark, &lit};
    for (size_t i = 0; i < sizeof all / sizeof *all; i++) ffp_image_free(all[i]);
    assert_true(before > 0.15 && foreseen < 0.05 && after < 0.03);
}

// The capture with a real projector of a panel of 96 x 64 pixels, as an import keeps it.
static void write_capture_with_device(const char *folder, const char *device) {
    FfpCapture capture;
    FfpError err = {0};
    char *text, *end;
    size_t size;
    if (!ffp_capture_read(&capture, in_scratch("tiny"), &err) ||
        !ffp_capture_write(&capture, in_scratch(folder), &err))
        fail_msg("%s", err.text);
    ffp_capture_free(&capture);
    char name[64];
    snprintf(name, sizeof name, "%s/scene.json", folder);
    assert_true(ffp_read_file(in_scratch(name), 1 << 20, &text, &size, NULL));
    char *at = strstr(text, "\"intensity\"");
    assert_non_null(at);
    end = ffp_alloc(size + strlen(device) + 32, 1);
    sprintf(end, "%.*s\"device\": %s, %s", (int)(at - text), text, device, at);
    assert_true(ffp_write_file(in_scratch(name), end, strlen(end), &err));
    ffp_free(text);
    ffp_free(end);
}

// By a gamma of 3 the values sent make the light that the ideal pattern has where the ray meets it.
static void compensate_writes_what_the_device_is_sent(void **state) {
    (void)state;
    FfpImage ideal, sent;
    write_capture_with_device("real", "{\"width\": 96, \"height\": 64, \"fx\": 90, \"fy\": 70, \"cx\": 48, "
                                      "\"cy\": 32, \"gamma\": [3, 3, 3]}");
    run_format(&run,
               "compensate %s/tiny.ply -c %s/real -v view_1 -t %s/tiny/view_2_stripes.png --paint -s 3 -o "
               "%s/ideal.png",
               scratch, scratch, scratch, scratch);
    must_run();
    run_format(&run,
               "compensate %s/tiny.ply -c %s/real -v view_1 -t %s/tiny/view_2_stripes.png --paint -s 3 -o "
               "%s/sent.png --for-device",
               scratch, scratch, scratch, scratch);
    must_run();
    read_encoded(&ideal, "ideal.png");
    read_encoded(&sent, "sent.png");
    assert_int_equal(sent.width, 96);
    assert_int_equal(sent.height, 64);
    FfpCapture capture;
    FfpError err = {0};
    assert_true(ffp_capture_read(&capture, in_scratch("real"), &err));
    const FfpCamera *pinhole = &capture.views[1].projector;
    double worst = 0;
    int count = 0;
    ffp_image_to_linear(&ideal);
    for (int i = 0; i < 96 * 64; i++) {
        const real u = pinhole->cx + pinhole->fx * (i % 96 + 0.5F - 48) / 90,
                   v = pinhole->cy + pinhole->fy * (i / 96 + 0.5F - 32) / 70;
        if (!(u > 0 && v > 0 && u < pinhole->width && v < pinhole->height)) continue;
        real light[4];
        ffp_image_sample(&ideal, u, v, light);
        for (int c = 0; c < 3; c++) {
            if (light[c] < 0.05F) continue; // an eighth bit is much there
            worst = worse(worst, (double)fabsf(sent.data[4 * i + c] - cbrtf(light[c])));
            count++;
        }
    }
    assert_true(count > 500);
    assert_true(worst < 0.01);
    ffp_capture_free(&capture);
    ffp_image_free(&ideal);
    ffp_image_free(&sent);
}

// One splat a pixel of every view, from the generator's own maps.
static void write_true_gaussians(const FfpCapture *capture, const char *path) {
    const int pixels = capture->views[0].camera.width * capture->views[0].camera.height;
    FfpGaussians g = ffp_gaussians_new((int64_t)pixels * capture->n_views);
    int64_t n = 0;
    for (int i = 0; i < pixels * capture->n_views; i++) {
        const FfpView *view = &capture->views[i / pixels];
        const int p = i % pixels, width = view->camera.width;
        const real z = view->depth.data[p], *normal = view->normal.data + 3 * p;
        if (!(z > 0)) continue;
        real ray[3];
        const real along = ffp_pixel_ray(&view->camera, p % width + 0.5F, p / width + 0.5F, ray);
        const real half = sqrtf(fmaxf((1 + normal[2]) / 2, 1e-6F)); // turns z into the normal
        for (int k = 0; k < 3; k++) {
            g.centre[3 * n + k] = view->camera.pose[4 * k + 3] + z / along * ray[k];
            g.scale[3 * n + k] = (k == 2 ? 0.05F : 0.5F) * z / view->camera.fx;
            g.albedo[3 * n + k] = fminf(fmaxf(view->albedo.data[3 * p + k], 0.01F), 0.99F);
            g.ambient[3 * n + k] = 0.05F;
        }
        g.rotation[4 * n] = half;
        g.rotation[4 * n + 1] = -normal[1] / (2 * half), g.rotation[4 * n + 2] = normal[0] / (2 * half);
        g.opacity[n] = 0.98F, g.roughness[n] = 0.8F;
        n++;
    }
    g.count = n;
    FfpError err = {0};
    if (!ffp_gaussians_write(&g, path, 0, &err)) fail_msg("%s", err.text);
    ffp_gaussians_free(&g);
}

// The map's positions against the true depth, at pixels whose neighbours have about the same depth.
static void check_forward_map(const FfpView *view, const FfpImage *map) {
    const int width = view->camera.width;
    int count = 0, near = 0;
    for (int y = 1; y + 1 < view->camera.height; y++)
        for (int x = 1; x + 1 < width; x++) {
            const int p = y * width + x;
            const real z = view->depth.data[p];
            bool smooth = z > 0 && map->data[4 * p + 2] > 0.5F;
            for (int k = 0; k < 9; k++)
                smooth &= fabsf(view->depth.data[p + (k / 3 - 1) * width + k % 3 - 1] - z) < 0.03F * z;
            if (!smooth) continue;
            real ray[3], point[3], u, v;
            const real along = ffp_pixel_ray(&view->camera, x + 0.5F, y + 0.5F, ray);
            for (int k = 0; k < 3; k++) point[k] = view->camera.pose[4 * k + 3] + z / along * ray[k];
            ffp_project(&view->projector, point, &u, &v);
            count++, near += hypotf(map->data[4 * p] - u, map->data[4 * p + 1] - v) <
                             0.01F * (real)view->projector.width;
        }
    assert_true(count > 50);
    assert_true(near > 0.95 * count);
}

static FfpMesh read_warp(const FfpView *view, const char *ending) {
    char name[256];
    FfpError err = {0};
    FfpMesh mesh = {0};
    snprintf(name, sizeof name, "maps/%s_warp.%s", view->id, ending);
    if (!ffp_mesh_read(&mesh, in_scratch(name), &err)) fail_msg("%s", err.text);
    return mesh;
}

// Assimp reads the same of OBJ and GLB.
static void check_mesh(const FfpView *view, int faces) {
    FfpMesh a = read_warp(view, "obj"), b = read_warp(view, "glb");
    assert_true(a.n_triangles == faces && b.n_triangles == faces && a.uv && b.uv);
    for (int c = 0; c < 3 * faces; c++) {
        const size_t i = a.triangles[c], j = b.triangles[c];
        for (size_t k = 0; k < 3; k++)
            assert_true(fabsf(a.positions[3 * i + k] - b.positions[3 * j + k]) < 1e-4F);
        for (size_t k = 0; k < 2; k++) assert_true(fabsf(a.uv[2 * i + k] - b.uv[2 * j + k]) < 2e-6F);
    }
    ffp_mesh_free(&a), ffp_mesh_free(&b);
}

// The MPCDI archive: the same shares, rows from below, NaN where there is nothing.
static void check_archive(const FfpView *view, const FfpImage *shares) {
    char archive[512], wanted[128];
    const size_t pixels = (size_t)shares->width * (size_t)shares->height, room = 12 * pixels + 65536;
    unsigned char *bytes = test_malloc(room);
    snprintf(archive, sizeof archive, "%s", in_scratch("maps/projectors.mpcdi"));
    size_t size = unpack(archive, "mpcdi.xml", bytes, room - 1);
    bytes[size] = 0;
    snprintf(wanted, sizeof wanted, "<region id=\"%s\" xResolution=\"%d\"", view->id, shares->width);
    assert_non_null(strstr((char *)bytes, wanted));
    size = unpack(archive, "warp0.pfm", bytes, room);
    snprintf(wanted, sizeof wanted, "PF\n%d %d\n-1.0\n", shares->width, shares->height);
    assert_int_equal(size, strlen(wanted) + 12 * pixels);
    assert_memory_equal(bytes, wanted, strlen(wanted));
    const unsigned char *from = bytes + strlen(wanted);
    for (int y = shares->height - 1; y >= 0; y--)
        for (int x = 0; x < shares->width; x++, from += 12) {
            const real *share = shares->data + 4 * (y * shares->width + x);
            float uv[2];
            memcpy(uv, from, sizeof uv);
            if (share[3] == 0)
                assert_true(isnan(uv[0]) && isnan(uv[1]));
            else
                assert_true(fabsf(uv[0] - (float)share[0]) < 1e-6F && fabsf(uv[1] - (float)share[1]) < 1e-6F);
        }
    assert_true(unpack(archive, "alpha0.png", bytes, room) > 100);
    test_free(bytes);
}

// The STMap holds the map of pixels as shares, v from below, and the mesh the same at its corners.
static void check_warp(const FfpView *view) {
    char name[256], line[256];
    FfpImage map, shares;
    FfpError err = {0};
    snprintf(name, sizeof name, "maps/%s_projector_to_camera.exr", view->id);
    assert_true(ffp_image_read(&map, in_scratch(name), FFP_COLOUR_LINEAR, &err));
    snprintf(name, sizeof name, "maps/%s_stmap.exr", view->id);
    assert_true(ffp_image_read(&shares, in_scratch(name), FFP_COLOUR_LINEAR, &err));
    assert_int_equal(shares.width, view->projector.width);
    int seen = 0;
    for (int i = 0; i < map.width * map.height; i++) {
        const real *pixel = map.data + 4 * i, *share = shares.data + 4 * i;
        assert_true((share[3] > 0) == (pixel[0] >= 0));
        if (pixel[0] < 0) continue;
        seen++;
        assert_true(fabs((double)(share[0] * (real)view->camera.width - pixel[0])) < 1e-2);
        assert_true(fabs((double)((1 - share[1]) * (real)view->camera.height - pixel[1])) < 1e-2);
    }
    assert_true(seen > 100);
    snprintf(name, sizeof name, "maps/%s_warp.obj", view->id);
    FILE *file = fopen(in_scratch(name), "r");
    double x = 0, y = 0, u, v;
    int corners = 0, faces = 0;
    while (fgets(line, sizeof line, file)) {
        char *rest = line + 2;
        faces += line[0] == 'f';
        if (strncmp(line, "v ", 2) == 0) x = strtod(rest, &rest), y = strtod(rest, &rest);
        if (strncmp(line, "vt ", 3) != 0) continue;
        u = strtod(rest, &rest), v = strtod(rest, &rest);
        const int column = (int)(x * map.width), row = (int)((1 - y) * map.height);
        const real *share = shares.data + 4 * (row * map.width + column);
        assert_true(fabs(u - (double)share[0]) < 1e-5 && fabs(v - (double)share[1]) < 1e-5);
        corners++;
    }
    fclose(file);
    assert_true(corners > 50 && faces > 50);
    check_mesh(view, faces);
    check_archive(view, &shares);
    ffp_image_free(&map);
    ffp_image_free(&shares);
}

static void maps_of_a_generated_scene_go_there_and_back(void **state) {
    (void)state;
    FfpCapture capture;
    FfpError err = {0};
    FfpImage map;
    if (!ffp_capture_read(&capture, in_scratch("scenes/test_00000"), &err)) fail_msg("%s", err.text);
    const FfpView *view = &capture.views[0];
    write_true_gaussians(&capture, in_scratch("true.ply"));
    run_format(&run, "map %s/true.ply -c %s/scenes/test_00000 -v %s -o %s/maps", scratch, scratch, view->id,
               scratch);
    must_run();
    printf("%s", run.out);
    assert_true(number_after("round trip: ") > 100);
    assert_true(number_after("camera pixels, ") > 98.5);
    assert_true(number_after("median ") < 0.1);
    static const char *const files[] = {"camera_to_projector.exr",
                                        "camera_to_projector.png",
                                        "projector_to_camera.exr",
                                        "projector_to_camera.png",
                                        "stmap.exr",
                                        "warp.obj",
                                        "warp.glb",
                                        "projector_sees.png",
                                        "lit.png",
                                        "density.exr",
                                        "resolution.exr",
                                        "incidence.exr",
                                        "illuminance.exr"};
    for (size_t i = 0; i < sizeof files / sizeof *files; i++) {
        char name[256];
        snprintf(name, sizeof name, "maps/%s_%s", view->id, files[i]);
        assert_true(ffp_is_file(in_scratch(name)));
    }
    char name[256];
    snprintf(name, sizeof name, "maps/%s_camera_to_projector.exr", view->id);
    if (!ffp_image_read(&map, in_scratch(name), FFP_COLOUR_LINEAR, &err)) fail_msg("%s", err.text);
    check_forward_map(view, &map);
    check_warp(view);
    ffp_image_free(&map);
    ffp_capture_free(&capture);
}

// In light without cosine and falloff the projector sees another picture than in the paper's form, of which
// the way of the light is the same.
static void maps_know_even_light(void **state) {
    (void)state;
    static const char *const forms[2] = {"paper", "gs-procams"};
    FfpImage seen[2], way[2];
    for (int k = 0; k < 2; k++) {
        run_format(&run, "map %s/tiny.ply -c %s/tiny -v view_1 --drawing %s -o %s/even_%d", scratch, scratch,
                   forms[k], scratch, k);
        must_run();
        char name[64];
        snprintf(name, sizeof name, "even_%d/view_1_projector_sees.png", k);
        read_encoded(&seen[k], name);
        snprintf(name, sizeof name, "even_%d/view_1_camera_to_projector.png", k);
        read_encoded(&way[k], name);
    }
    double off = 0;
    for (int i = 0; i < 4 * seen[0].width * seen[0].height; i++)
        off = fmax(off, fabs((double)(seen[0].data[i] - seen[1].data[i])));
    assert_true(off > 0.05);
    for (int i = 0; i < 4 * way[0].width * way[0].height; i++) assert_true(way[0].data[i] == way[1].data[i]);
    for (int k = 0; k < 2; k++) ffp_image_free(&seen[k]), ffp_image_free(&way[k]);
}

static void must_fail(int status, const char *what, const char *file) {
    if (run.status != status || !strstr(run.err, what)) printf("exit %d\n%s", run.status, run.err);
    assert_int_equal(run.status, status);
    assert_non_null(strstr(run.err, what));
    if (file) assert_false(ffp_is_file(in_scratch(file)));
}

// Of all that draws them with the capture's devices.
static void gaussians_of_another_place_are_noted(void **state) {
    (void)state;
    FfpError err = {0};
    FfpGaussians moved;
    static const char *const commands[] = {
        "render %s/far.ply -c %s/scenes/test_00000 -v path_0_theta000 -o %s/far",
        "map %s/far.ply -c %s/scenes/test_00000 -v path_0_theta000 -o %s/far_maps",
        "view %s/far.ply -c %s/scenes/test_00000 -o %s/far.html"};
    if (!ffp_gaussians_read(&moved, in_scratch("tiny.ply"), &err)) fail_msg("%s", err.text);
    for (int64_t i = 0; i < moved.count; i++) moved.centre[3 * i + 2] += 30;
    if (!ffp_gaussians_write(&moved, in_scratch("far.ply"), 0, &err)) fail_msg("%s", err.text);
    ffp_gaussians_free(&moved);
    for (size_t i = 0; i < sizeof commands / sizeof *commands; i++) {
        char line[1024];
        snprintf(line, sizeof line, commands[i], scratch, scratch, scratch);
        run_program(&run, line);
        must_run();
        if (!strstr(run.err, "Gaussians lie outside the sphere")) fail_msg("%s: %s", line, run.err);
    }
}

static void wrong_compensations_say_what_is_wrong(void **state) {
    (void)state;
    run_format(&run,
               "compensate %s/tiny.ply -c %s/tiny -v view_1 -t %s/tiny/view_2_stripes.png -o %s/no.png "
               "--for-device",
               scratch, scratch, scratch, scratch);
    must_fail(1, "does not describe the real projector", "no.png");
    const char *start = "compensate";
    char common[512];
    snprintf(common, sizeof common, "%s %s/tiny.ply -c %s/tiny -o %s/never.png", start, scratch, scratch,
             scratch);
    run_format(&run, "%s -t %s/tiny/view_0_stripes.png", common, scratch);
    must_fail(2, "--view ID is missing", "never.png");
    run_format(&run, "%s -v view_0", common);
    must_fail(2, "--target IMAGE|FILM is missing", "never.png");
    run_format(&run, "%s -v view_9 -t %s/tiny/view_0_stripes.png", common, scratch);
    must_fail(1, "no view view_9", "never.png");
    run_format(&run, "%s -v view_0 -v view_0 -t %s/tiny/view_0_stripes.png", common, scratch);
    must_fail(1, "named twice", "never.png");
    run_format(&run, "%s -v view_0 -t %s/tiny/render_poses.json", common, scratch);
    must_fail(1, "render_poses.json", "never.png");
    run_format(&run, "%s -v view_0 -t %s/nowhere.png", common, scratch);
    must_fail(1, "nowhere.png", "never.png");
    run_format(&run, "%s -v view_0 -t %s/tiny/view_0_stripes.png --gain -3", common, scratch);
    must_fail(2, "--gain", "never.png");
    run_format(&run, "%s -v view_0 -v view_1 -v view_2 -t a.png -t b.png", common);
    must_fail(2, "2 targets for 3 views", "never.png");
    FfpImage clear = ffp_image_new(SIDE, SIDE, 4);
    assert_true(ffp_image_write_png(&clear, in_scratch("clear.png"), NULL));
    run_format(&run, "%s -v view_0 -t %s/tiny/view_0_stripes.png --fit some", common, scratch);
    must_fail(2, "--fit takes cover, contain, stretch or pixel, not 'some'", "never.png");
    run_format(&run, "%s -v view_0 -t %s/clear.png --transparent free", common, scratch);
    must_fail(1, "no projector lights anything", "never.png");
    run_format(&run,
               "compensate %s/tiny.ply -c %s/tiny -o %s/no/where.png -v view_0 -t %s/tiny/view_0_stripes.png",
               scratch, scratch, scratch, scratch);
    must_fail(1, "no/where.png", NULL);
    ffp_image_free(&clear);
}

static bool is_link(const char *path) {
    struct stat about;
    return lstat(path, &about) == 0 && S_ISLNK(about.st_mode);
}

static void outputs_go_through_links_and_into_no_device(void **state) {
    (void)state;
    char common[512];
    snprintf(common, sizeof common,
             "compensate %s/tiny.ply -c %s/tiny -v view_0 -s 2 -t %s/tiny/view_0_stripes.png", scratch,
             scratch, scratch);
    assert_int_equal(symlink("there.png", in_scratch("link.png")), 0);
    run_format(&run, "%s -o %s/link.png", common, scratch);
    must_run();
    assert_true(is_link(in_scratch("link.png")) && ffp_is_file(in_scratch("there.png")));
    assert_int_equal(symlink("/dev/null", in_scratch("null.png")), 0);
    run_format(&run, "%s -o %s/null.png", common, scratch);
    must_fail(1, "a device has this name", NULL);
    assert_true(is_link(in_scratch("null.png")));
    assert_int_equal(symlink("real_maps", in_scratch("maps_link")), 0);
    run_format(&run, "map %s/tiny.ply -c %s/tiny -v view_0 -o %s/maps_link", scratch, scratch, scratch);
    must_run();
    assert_true(is_link(in_scratch("maps_link")) && ffp_is_file(in_scratch("real_maps/view_0_lit.png")));
}

// No file may grow past 8 kB: writing fails somewhere among the maps.
static void maps_that_fail_leave_no_folder(void **state) {
    (void)state;
    char command[1024];
    snprintf(command, sizeof command,
             "trap '' XFSZ; ulimit -f 16; '%s' map %s/tiny.ply -c %s/tiny -o %s/part/maps 2>/dev/null >&2",
             FFP_PROGRAM, scratch, scratch, scratch);
    assert_int_not_equal(system(command), 0);
    assert_int_equal(rmdir(in_scratch("part")), 0); // nothing is in it
}

static void wrong_maps_say_what_is_wrong(void **state) {
    (void)state;
    run_format(&run, "map %s/tiny.ply -c %s/tiny", scratch, scratch);
    must_fail(2, "-o, --output DIR is missing", NULL);
    run_format(&run, "map %s/tiny.ply -c %s/tiny -v view_7 -o %s/nomaps", scratch, scratch, scratch);
    must_fail(1, "no view view_7", NULL);
    assert_false(ffp_is_folder(in_scratch("nomaps")));
    run_format(&run, "map %s/missing.ply -c %s/tiny -o %s/nomaps", scratch, scratch, scratch);
    must_fail(1, "missing.ply", NULL);
}

static void help_teaches(void **state) {
    (void)state;
    run_format(&run, "compensate --help");
    must_run();
    assert_non_null(strstr(run.out, "--gain"));
    assert_non_null(strstr(run.out, "\nexample:\n  ffprocams compensate "));
    run_format(&run, "map --help");
    must_run();
    assert_non_null(strstr(run.out, "projector_to_camera.exr"));
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(targets_of_any_shape_with_transparent_parts),
        cmocka_unit_test(letters_have_no_halos),
        cmocka_unit_test(edges_are_finer_than_the_cameras_pixels),
        cmocka_unit_test(compensate_writes_pattern_prediction_and_target),
        cmocka_unit_test(compensate_writes_what_the_device_is_sent),
        cmocka_unit_test(several_projectors_get_a_pattern_each),
        cmocka_unit_test(compensation_for_new_poses_uses_the_gaussians),
        cmocka_unit_test(maps_of_a_generated_scene_go_there_and_back),
        cmocka_unit_test(maps_know_even_light),
        cmocka_unit_test(gaussians_of_another_place_are_noted),
        cmocka_unit_test(wrong_compensations_say_what_is_wrong),
        cmocka_unit_test(outputs_go_through_links_and_into_no_device),
        cmocka_unit_test(maps_that_fail_leave_no_folder),
        cmocka_unit_test(wrong_maps_say_what_is_wrong),
        cmocka_unit_test(help_teaches),
    };
    return cmocka_run_group_tests(tests, group_setup, scratch_teardown);
}
