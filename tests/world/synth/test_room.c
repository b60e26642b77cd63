// Labels: threads
// A room's light against closed forms; rooms in which nothing is in the way; folders of photographs.
#include <math.h>
#include <omp.h>
#include <unistd.h>
#include "core/base/file.h"
#include "core/base/listing.h"
#include "core/patterns/patterns.h"
#include "support.h"
#include "world/shapes/solids.h"
#include "world/synth/photographs.h"
#include "world/synth/room.h"
#include "world/synth/simulate.h"

enum { SIDE = 24, HEIGHT = 64, PANEL_WIDTH = 96, PANEL_HEIGHT = 64 };

static char root[64];

static int make_root(void **state) {
    (void)state;
    snprintf(root, sizeof root, "ffp_room_XXXXXX");
    return mkdtemp(root) ? 0 : -1;
}

static int remove_root(void **state) {
    (void)state;
    ffp_remove_tree(root);
    return 0;
}

static void path_of(char path[FFP_PATH_MAX], const char *name) {
    assert_true(ffp_join_path(path, root, name));
}

// --- Light. ---

static FfpCamera device_at(const float at[3], const float x[3], const float y[3], const float z[3], real f) {
    FfpCamera c = {.width = SIDE, .height = SIDE, .fx = f, .fy = f, .cx = SIDE / 2.0F, .cy = SIDE / 2.0F};
    for (int k = 0; k < 3; k++)
        c.pose[4 * k] = x[k], c.pose[4 * k + 1] = y[k], c.pose[4 * k + 2] = z[k], c.pose[4 * k + 3] = at[k];
    c.pose[15] = 1;
    return c;
}

// The light under white that a camera sees in a room of plain parts.
static FfpImage see(const FfpRoom *room, const FfpCamera *camera, const FfpCamera *projector,
                    float intensity) {
    FfpImage white = ffp_image_new(SIDE, SIDE, 3);
    for (int i = 0; i < SIDE * SIDE * 3; i++) white.data[i] = 1;
    const FfpImage *patterns[1] = {&white};
    FfpLight light = ffp_light_new(patterns, 1);
    FfpSurroundings around = ffp_around_new(room, NULL, 0);
    FfpError err = {0};
    FfpTracer *tracer = ffp_tracer_new(&around.mesh, &err);
    if (!tracer) fail_msg("%s", err.text);
    const FfpSimulation simulation = {.tracer = tracer,
                                      .mesh = &around.mesh,
                                      .around = &around,
                                      .light = &light,
                                      .intensity = {intensity, intensity, intensity},
                                      .samples = 8,
                                      .ambient_rays = 16,
                                      .photograph = true,
                                      .light_only = true};
    FfpView view = {.camera = *camera, .projector = *projector};
    ffp_simulate_view(&simulation, &view, 0, NULL);
    FfpImage seen = ffp_image_copy(&view.images[0]);
    ffp_view_free(&view, 1);
    ffp_tracer_free(tracer);
    ffp_around_free(&around);
    ffp_light_free(&light);
    ffp_image_free(&white);
    return seen;
}

static FfpRoomPart plain(FfpMesh mesh, float albedo) {
    return (FfpRoomPart){
        .mesh = mesh, .plain = true, .albedo = {albedo, albedo / 2, albedo / 4}, .roughness = 0.9F};
}

static const float X[3] = {1, 0, 0}, Y[3] = {0, 1, 0}, BACK[3] = {-1, 0, 0}, LEFT[3] = {0, -1, 0},
                   DOWN[3] = {0, 0, -1};

// A floor in the dark before a wall that a projector far away lights evenly: by the factor from an element to
// a rectangle at right angles to it, whose one side lies in the element's plane (Howell, Catalog of Radiation
// Heat Transfer Configuration Factors, B-4), twice, for the wall's two halves.
static void a_wall_lights_the_floor_before_it(void **state) {
    (void)state;
    const float far = 500, half = 1, high = 1.5F, away = 0.8F, irradiance = 2;
    FfpRoom room = {.n_parts = 2};
    room.parts[0] = plain(ffp_solid_box((float[3]){2, 0, -0.5F}, (float[3]){2, 3, 0.5F}, 0), 0.6F);
    room.parts[1] =
        plain(ffp_solid_box((float[3]){-0.5F, 0, high / 2}, (float[3]){0.5F, half, high / 2}, 0), 0.8F);
    const FfpCamera projector = device_at((float[3]){far, 0, -0.01F}, Y, DOWN, BACK, 12 * far / 4),
                    camera = device_at((float[3]){away, 0, 2}, Y, X, DOWN, 24 * SIDE); // 0.08 across
    FfpImage seen = see(&room, &camera, &projector, irradiance * far * far);
    double mean[3] = {0};
    for (int i = 0; i < SIDE * SIDE * 3; i++) mean[i % 3] += (double)seen.data[i] / (SIDE * SIDE);
    const double slant = sqrt((double)(away * away + high * high));
    const double factor =
        (atan((double)(half / away)) - (double)away / slant * atan((double)half / slant)) / FFP_PI_DOUBLE;
    const double want = 0.6 * 0.8 * (double)irradiance / FFP_PI_DOUBLE * factor;
    print_message("floor: %.5f, %.5f expected\n", mean[0], want);
    assert_true(fabs(mean[0] / want - 1) < 0.02);
    assert_true(fabs(mean[1] / want * 4 - 1) < 0.02 && fabs(mean[2] / want * 16 - 1) < 0.02);
    ffp_image_free(&seen);
    ffp_room_free(&room);
}

// The inside of a sphere, seen from its middle.
static FfpMesh cavity(void) {
    enum { RINGS = 48, SECTORS = 96 };
    FfpMesh mesh = {.n_vertices = (RINGS + 1) * SECTORS, .n_triangles = 2 * RINGS * SECTORS};
    mesh.positions = ffp_alloc((size_t)mesh.n_vertices * 3 + 1, sizeof(float));
    mesh.normals = ffp_alloc((size_t)mesh.n_vertices * 3, sizeof(float));
    mesh.triangles = ffp_alloc((size_t)mesh.n_triangles * 3, sizeof(uint32_t));
    for (int i = 0; i < mesh.n_vertices; i++) {
        const float polar = 3.1415927F * (float)(i / SECTORS) / RINGS,
                    azimuth = 6.2831853F * (float)(i % SECTORS) / SECTORS;
        const float p[3] = {sinf(polar) * cosf(azimuth), sinf(polar) * sinf(azimuth), cosf(polar)};
        for (int k = 0; k < 3; k++) mesh.positions[3 * i + k] = 2 * p[k], mesh.normals[3 * i + k] = -p[k];
    }
    for (int r = 0; r < RINGS; r++)
        for (int s = 0; s < SECTORS; s++) {
            const uint32_t a = (uint32_t)(r * SECTORS + s), b = (uint32_t)(r * SECTORS + (s + 1) % SECTORS),
                           quad[6] = {a, b, a + SECTORS, b, b + SECTORS, a + SECTORS};
            memcpy(mesh.triangles + 6 * (size_t)(r * SECTORS + s), quad, sizeof quad);
        }
    return mesh;
}

// An integrating sphere: light that has bounced k times arrives evenly, albedo^k of what the lamp sends.
static void a_sphere_keeps_what_it_does_not_swallow(void **state) {
    (void)state;
    FfpRoom room = {.n_parts = 1, .lamp = {.radius = 0.2F, .radiance = 10}};
    room.parts[0] = plain(cavity(), 0.8F);
    const FfpCamera camera = device_at((float[3]){0, 0, 0}, Y, DOWN, BACK, SIDE),
                    projector = device_at((float[3]){0, 0, 0}, LEFT, DOWN, X, SIDE);
    FfpImage seen = see(&room, &camera, &projector, 0);
    double mean[3] = {0}, square = 0;
    for (int i = 0; i < SIDE * SIDE * 3; i++) mean[i % 3] += (double)seen.data[i] / (SIDE * SIDE);
    for (int c = 0; c < 3; c++) {
        const double albedo = 0.8 / (1 << c), sent = 10 * 0.01, // radiance (r / R)^2
            want = albedo * sent * (1 + albedo + albedo * albedo);
        print_message("sphere: %.5f, %.5f expected\n", mean[c], want);
        assert_true(fabs(mean[c] / want - 1) < 0.01);
    }
    for (int i = 0; i < SIDE * SIDE; i++)
        square += ((double)seen.data[3 * i] - mean[0]) * ((double)seen.data[3 * i] - mean[0]);
    assert_true(sqrt(square / (SIDE * SIDE)) < 0.03 * mean[0]);
    ffp_image_free(&seen);
    ffp_room_free(&room);
}

// --- Rooms. ---

// The volume within a mesh, by the divergence theorem; every triangle looks where its corners' normals do.
static double volume_of(const FfpMesh *mesh) {
    double volume = 0;
    for (int t = 0; t < mesh->n_triangles; t++) {
        const uint32_t *corner = mesh->triangles + 3 * (size_t)t;
        const float *p[3];
        float n[3];
        for (int i = 0; i < 3; i++) p[i] = mesh->positions + 3 * (size_t)corner[i];
        for (int k = 0; k < 3; k++) {
            const int i = (k + 1) % 3, j = (k + 2) % 3;
            n[k] = (p[1][i] - p[0][i]) * (p[2][j] - p[0][j]) - (p[1][j] - p[0][j]) * (p[2][i] - p[0][i]);
        }
        for (int i = 0; i < 3; i++) {
            const float *normal = mesh->normals + 3 * (size_t)corner[i];
            assert_true(n[0] * normal[0] + n[1] * normal[1] + n[2] * normal[2] > 0);
        }
        volume += (double)(n[0] * p[0][0] + n[1] * p[0][1] + n[2] * p[0][2]) / 6;
    }
    return volume;
}

static void solids_are_closed_and_face_outwards(void **state) {
    (void)state;
    FfpMesh box = ffp_solid_box((float[3]){3, -2, 1}, (float[3]){0.5F, 1, 0.25F}, 0.7F),
            cylinder = ffp_solid_cylinder(1.2F, -1, -0.7F);
    assert_float_equal(volume_of(&box), 1, 1e-4);
    assert_float_equal(volume_of(&cylinder), 0.3 * 1.44 * 3.1415927, 2e-3); // 128 sides
    ffp_mesh_free(&box), ffp_mesh_free(&cylinder);
}

static bool is_free(const FfpTracer *tracer, const float from[3], const FfpCamera *device) {
    float way[3];
    FfpRays rays = {.count = 0};
    for (int k = 0; k < 3; k++) way[k] = (float)device->pose[4 * k + 3] - from[k];
    ffp_rays_add(&rays, from, way);
    return ffp_trace_blocked(tracer, &rays) == 0;
}

// From every point where an object may have its surface both devices are seen, and in their pictures.
static void check_room(const FfpRoom *room, float floor) {
    FfpSurroundings around = ffp_around_new(room, NULL, 0);
    FfpError err = {0};
    FfpTracer *tracer = ffp_tracer_new(&around.mesh, &err);
    assert_non_null(tracer);
    for (int i = 0; i < 200; i++) { // a Fibonacci sphere
        const float z = 1 - ((float)i + 0.5F) / 100, r = FFP_MESH_RADIUS * sqrtf(1 - z * z);
        const float point[3] = {r * cosf(2.3999632F * (float)i), r * sinf(2.3999632F * (float)i),
                                FFP_MESH_RADIUS * z};
        double pixel[2];
        if (point[2] < floor + 0.01F) continue;
        assert_true(is_free(tracer, point, &room->rig.camera));
        assert_true(is_free(tracer, point, &room->rig.projector));
        assert_true(ffp_bare_rig_pixel(&room->rig.camera, room->rig.camera_lens, point, pixel));
        assert_true(ffp_bare_rig_pixel(&room->rig.projector, room->rig.projector_lens, point, pixel));
    }
    ffp_tracer_free(tracer);
    ffp_around_free(&around);
}

static void nothing_is_in_the_way(void **state) {
    (void)state;
    int boxes[FFP_ROOM_BOXES + 1] = {0};
    for (uint64_t seed = 0; seed < TIMES(100, 10); seed++) {
        const float floor = -0.4F - 0.005F * (float)seed;
        FfpRoom room = ffp_room_draw(seed, floor, 480, 640, 400);
        assert_true(room.n_parts >= 4 && room.n_parts <= FFP_ROOM_PARTS);
        boxes[room.n_parts - 3]++;
        check_room(&room, floor);
        ffp_room_free(&room);
    }
    for (int i = 2; i <= FFP_ROOM_BOXES; i++) assert_true(boxes[i] > 0);
}

static void a_seed_is_a_room(void **state) {
    (void)state;
    FfpRoom a = ffp_room_draw(3, -0.9F, 480, 640, 400), same = ffp_room_draw(3, -0.9F, 240, 320, 200),
            other = ffp_room_draw(4, -0.9F, 480, 640, 400);
    assert_int_equal(a.n_parts, same.n_parts);
    assert_memory_equal(&a.lamp, &same.lamp, sizeof a.lamp);
    for (int p = 0; p < a.n_parts; p++)
        assert_memory_equal(a.parts[p].mesh.positions, same.parts[p].mesh.positions,
                            (size_t)a.parts[p].mesh.n_vertices * 3 * sizeof(float));
    assert_memory_equal(a.rig.camera.pose, same.rig.camera.pose, sizeof a.rig.camera.pose);
    assert_true(a.camera_defocus == 2 * same.camera_defocus);
    assert_memory_not_equal(a.rig.camera.pose, other.rig.camera.pose, sizeof a.rig.camera.pose);
    assert_memory_not_equal(&a.lamp, &other.lamp, sizeof a.lamp);
    ffp_room_free(&a), ffp_room_free(&same), ffp_room_free(&other);
}

// Things that turn with the table keep their place in the object's frame, and the rest turns the other way.
static void the_room_stands_still(void **state) {
    (void)state;
    FfpRoom room = ffp_room_draw(1, -0.9F, 480, 640, 400);
    FfpSurroundings start = ffp_around_new(&room, NULL, 0), turned = ffp_around_new(&room, NULL, 90);
    const int platter = room.parts[0].mesh.n_vertices;
    assert_memory_equal(start.mesh.positions, turned.mesh.positions, (size_t)platter * 3 * sizeof(float));
    for (int i = platter; i < start.mesh.n_vertices; i++) {
        const float *was = start.mesh.positions + 3 * (size_t)i, *is = turned.mesh.positions + 3 * (size_t)i;
        assert_float_equal(is[0], was[1], 1e-5);
        assert_float_equal(is[1], -was[0], 1e-5);
        assert_float_equal(is[2], was[2], 0);
    }
    ffp_around_free(&start), ffp_around_free(&turned);
    ffp_room_free(&room);
}

// --- Photographs. ---

static FfpSceneSpec small_spec(void) {
    FfpSceneSpec spec = ffp_scene_defaults();
    spec.mesh = 2, spec.material = 4, spec.seed = 5, spec.resolution = HEIGHT, spec.views = 1;
    spec.samples = 2, spec.ambient_rays = 1;
    return spec;
}

static void draw_patterns(const char *name, bool codes) {
    char path[FFP_PATH_MAX];
    FfpError err = {0};
    const FfpShow show = {.width = PANEL_WIDTH,
                          .height = PANEL_HEIGHT,
                          .lollipops = 1,
                          .focus = true,
                          .capture = true,
                          .gray_codes = codes};
    path_of(path, name);
    assert_true(ffp_make_folders(path, &err));
    if (!ffp_show_write(&show, path, &err)) fail_msg("%s", err.text);
}

static bool photograph(const char *to, const char *patterns, const FfpSceneSpec *spec, FfpError *err) {
    char folder[FFP_PATH_MAX], from[FFP_PATH_MAX];
    path_of(folder, to), path_of(from, patterns);
    const FfpPhotographs options = {
        .folder = folder, .patterns = from, .attitudes = 1, .room = true, .seed = 6, .quality = 92};
    return ffp_photographs_write(&options, spec, err);
}

static void read_bytes(const char *folder, const char *name, char **data, size_t *size) {
    char part[FFP_PATH_MAX], path[FFP_PATH_MAX];
    FfpError err = {0};
    snprintf(part, sizeof part, "%.200s/%.500s", folder, name);
    path_of(path, part);
    if (!ffp_read_file(path, 1 << 24, data, size, &err)) fail_msg("%s", err.text);
}

static int count_files(const char *name) {
    char path[FFP_PATH_MAX];
    FfpListing listing;
    path_of(path, name);
    assert_true(ffp_list_folder(&listing, path));
    const int count = listing.count;
    ffp_free(listing.names);
    return count;
}

static void everything_is_written_once(void **state) {
    (void)state;
    static const char *const names[] = {"view-000/002.JPG",       "view-157/001.JPG",
                                        "held-out/map.png",       "held-out/view-022/map.JPG",
                                        "truth/view-000/003.png", "truth/held-out/view-022/photograph.png",
                                        "empty/002.JPG",          "masks/view-000.png",
                                        "masks/view-157.png",     "attitude-00/002.JPG",
                                        "turntable/04.JPG",       "truth.json"};
    FfpError err = {0};
    const FfpSceneSpec spec = small_spec();
    draw_patterns("coded", true);
    if (!photograph("whole", "coded", &spec, &err)) fail_msg("%s", err.text);
    for (size_t i = 0; i < sizeof names / sizeof *names; i++) {
        char *data;
        size_t size;
        read_bytes("whole", names[i], &data, &size);
        assert_true(size > 50);
        ffp_free(data);
    }
    const int codes = 2 * (ffp_gray_code_bits(PANEL_WIDTH) + ffp_gray_code_bits(PANEL_HEIGHT));
    assert_int_equal(count_files("whole/view-000"), 3 + codes);
    assert_int_equal(count_files("whole/held-out/view-000"), 2);
    assert_int_equal(count_files("whole/view-022"), 3);
    assert_int_equal(count_files("whole/truth/view-000"), 3);
    assert_int_equal(count_files("whole/empty"), 3);
    assert_int_equal(count_files("whole/attitude-00"), 2 + codes);
    assert_int_equal(count_files("whole/masks"), 3);
}

static void any_number_of_threads_gives_the_same_bits(void **state) {
    (void)state;
    static const char *const names[] = {"view-000/003.JPG", "view-022/002.JPG", "empty/001.JPG",
                                        "truth/held-out/view-000/map.png", "masks/view-000.png"};
    static const char *const folders[] = {"one", "three"};
    FfpError err = {0};
    const FfpSceneSpec spec = small_spec();
    const int threads = omp_get_max_threads();
    draw_patterns("few", false);
    for (int i = 0; i < 2; i++) {
        omp_set_num_threads(1 + 2 * i);
        if (!photograph(folders[i], "few", &spec, &err)) fail_msg("%s", err.text);
    }
    omp_set_num_threads(threads);
    for (size_t i = 0; i < sizeof names / sizeof *names; i++) {
        char *a, *b;
        size_t size_a, size_b;
        read_bytes(folders[0], names[i], &a, &size_a);
        read_bytes(folders[1], names[i], &b, &size_b);
        assert_int_equal(size_a, size_b);
        assert_memory_equal(a, b, size_a);
        ffp_free(a), ffp_free(b);
    }
}

static FfpImage picture(const char *name) {
    char path[FFP_PATH_MAX];
    FfpError err = {0};
    FfpImage image;
    path_of(path, name);
    if (!ffp_image_read(&image, path, FFP_COLOUR_LINEAR, &err)) fail_msg("%s", err.text);
    return image;
}

// The stage is the same with and without the object, but for the object itself and the shadow it throws.
static void the_empty_stage_is_the_same_room(void **state) {
    (void)state;
    FfpImage full = picture("one/view-000/002.JPG"), empty = picture("one/empty/002.JPG"),
             mask = picture("one/masks/view-000.png");
    int same = 0, shadow = 0, brighter = 0, stage = 0, object = 0;
    for (int i = 0; i < full.width * full.height; i++) {
        const real with = full.data[4 * i + 1], without = empty.data[4 * i + 1];
        object += mask.data[4 * i] > 0.99F;
        if (mask.data[4 * i] > 0) continue;
        stage++;
        same += fabsf((float)(with - without)) < 0.03F;
        shadow += with < 0.5F * without - 0.03F;
        brighter += with > 1.5F * without + 0.05F;
    }
    print_message("of %d pixels of the stage %d are the same, %d in shadow, %d brighter\n", stage, same,
                  shadow, brighter);
    assert_true(object > 100 && stage > 10 * object / 2);
    assert_true(same > 0.85 * stage && shadow > 0.01 * stage && brighter < 0.01 * stage);
    ffp_image_free(&full), ffp_image_free(&empty), ffp_image_free(&mask);
}

static void refused(const char *patterns, const FfpSceneSpec *spec, int quality, const char *text) {
    FfpError err = {0};
    char folder[FFP_PATH_MAX], from[FFP_PATH_MAX];
    path_of(folder, "refused"), path_of(from, patterns);
    const FfpPhotographs options = {
        .folder = folder, .patterns = from, .room = true, .seed = 6, .quality = quality};
    assert_false(ffp_photographs_write(&options, spec, &err));
    if (!strstr(err.text, text)) fail_msg("'%s' does not say '%s'", err.text, text);
    assert_false(ffp_is_folder(folder));
}

static void what_gives_no_room_is_refused(void **state) {
    (void)state;
    FfpSceneSpec spec = small_spec();
    refused("nowhere", &spec, 92, "cannot read the patterns' folder");
    refused("few", &spec, 0, "quality");
    spec.sensor.shift_error = 0.01F;
    refused("few", &spec, 92, "shift_error");
    spec = small_spec(), spec.resolution = 20;
    refused("few", &spec, 92, "resolution");
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_wall_lights_the_floor_before_it),
        cmocka_unit_test(a_sphere_keeps_what_it_does_not_swallow),
        cmocka_unit_test(solids_are_closed_and_face_outwards),
        cmocka_unit_test(nothing_is_in_the_way),
        cmocka_unit_test(a_seed_is_a_room),
        cmocka_unit_test(the_room_stands_still),
        cmocka_unit_test(everything_is_written_once),
        cmocka_unit_test(any_number_of_threads_gives_the_same_bits),
        cmocka_unit_test(the_empty_stage_is_the_same_room),
        cmocka_unit_test(what_gives_no_room_is_refused),
    };
    return cmocka_run_group_tests(tests, make_root, remove_root);
}
