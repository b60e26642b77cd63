// Users' meshes and materials: every format, what is made of it, and files that are none.
#include <errno.h>
#include <fcntl.h>
#include <math.h>
#include <pthread.h>
#include <stdbool.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>
#include "core/base/alloc.h"
#include "core/base/call.h"
#include "core/base/file.h"
#include "core/image/image.h"
#include "support.h"
#include "world/shapes/mesh.h"
#include "world/synth/picture_folder.h"
#include "world/synth/synth.h"
#include "world/synth/texture.h"

enum { RINGS = 12, SECTORS = 24, BALL_TRIANGLES = 2 * SECTORS * (RINGS - 1) };
static char root[64];

static int make_root(void **state) {
    (void)state;
    snprintf(root, sizeof root, "ffp_assets_XXXXXX");
    return mkdtemp(root) ? 0 : -1;
}
static int remove_root(void **state) {
    (void)state;
    char command[128];
    snprintf(command, sizeof command, "rm -r %s", root);
    return system(command);
}

static const char *path_of(const char *name) {
    static char path[FFP_PATH_MAX];
    snprintf(path, sizeof path, "%s/%s", root, name);
    return path;
}
static FILE *create(const char *name) {
    FILE *file = fopen(path_of(name), "wb");
    assert_non_null(file);
    return file;
}
static void write_bytes(const char *name, const void *bytes, size_t size) {
    FILE *file = create(name);
    assert_int_equal(fwrite(bytes, 1, size, file), size);
    fclose(file);
}
static void write_words(const char *name, const char *text) {
    write_bytes(name, text, strlen(text));
}

// --- A ball of radius 7 around (10, 20, 30), two and a half times as long along its third axis. ---

static void ball_vertex(int ring, int sector, float p[3]) {
    const float a = 3.14159265F * (float)ring / RINGS, b = 6.2831853F * (float)sector / SECTORS;
    p[0] = 10 + 7 * sinf(a) * cosf(b), p[1] = 20 + 7 * sinf(a) * sinf(b), p[2] = 30 + 17.5F * cosf(a);
}
static int ball_number(int ring, int sector) {
    return ring == 0       ? 0
           : ring == RINGS ? 1 + (RINGS - 1) * SECTORS
                           : 1 + (ring - 1) * SECTORS + sector % SECTORS;
}
enum { BALL_VERTICES = 2 + (RINGS - 1) * SECTORS };

static int ball_triangles(int (*out)[3]) {
    int n = 0;
    for (int r = 0; r < RINGS; r++)
        for (int s = 0; s < SECTORS; s++) {
            const int a = ball_number(r, s), b = ball_number(r + 1, s), c = ball_number(r + 1, s + 1),
                      d = ball_number(r, s + 1);
            if (r < RINGS - 1) out[n][0] = a, out[n][1] = b, out[n++][2] = c;
            if (r > 0) out[n][0] = a, out[n][1] = c, out[n++][2] = d;
        }
    return n;
}
static void ball_positions(float (*out)[3]) {
    for (int r = 0; r <= RINGS; r++)
        for (int s = 0; s < SECTORS; s++) ball_vertex(r, s, out[ball_number(r, s)]);
}

static void write_ball(const char *name) {
    float p[BALL_VERTICES][3];
    int t[BALL_TRIANGLES][3];
    ball_positions(p);
    assert_int_equal(ball_triangles(t), BALL_TRIANGLES);
    FILE *file = create(name);
    if (strstr(name, ".obj")) {
        for (int i = 0; i < BALL_VERTICES; i++) fprintf(file, "v %g %g %g\n", p[i][0], p[i][1], p[i][2]);
        for (int i = 0; i < BALL_TRIANGLES; i++)
            fprintf(file, "f %d %d %d\n", t[i][0] + 1, t[i][1] + 1, t[i][2] + 1);
    } else if (strstr(name, ".ply")) {
        fprintf(
            file,
            "ply\nformat ascii 1.0\nelement vertex %d\nproperty float x\nproperty float y\nproperty float "
            "z\nelement face %d\nproperty list uchar int vertex_indices\nend_header\n",
            BALL_VERTICES, BALL_TRIANGLES);
        for (int i = 0; i < BALL_VERTICES; i++) fprintf(file, "%g %g %g\n", p[i][0], p[i][1], p[i][2]);
        for (int i = 0; i < BALL_TRIANGLES; i++) fprintf(file, "3 %d %d %d\n", t[i][0], t[i][1], t[i][2]);
    } else if (strstr(name, ".stl")) {
        const char header[80] = "a ball";
        const uint32_t count = BALL_TRIANGLES;
        const uint16_t attributes = 0;
        fwrite(header, 1, 80, file);
        fwrite(&count, 4, 1, file);
        for (int i = 0; i < BALL_TRIANGLES; i++) {
            const float normal[3] = {0, 0, 0};
            fwrite(normal, 4, 3, file);
            for (int k = 0; k < 3; k++) fwrite(p[t[i][k]], 4, 3, file);
            fwrite(&attributes, 2, 1, file);
        }
    } else {
        fprintf(
            file,
            "{\"asset\":{\"version\":\"2.0\"},\"scene\":0,\"scenes\":[{\"nodes\":[0]}],\"nodes\":[{\"mesh\":"
            "0,\"translation\":[5,6,7]}],\"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":0},"
            "\"indices\":1}]}],\"buffers\":[{\"uri\":\"ball.bin\",\"byteLength\":%zu}],\"bufferViews\":[{"
            "\"buffer\":0,\"byteOffset\":0,\"byteLength\":%zu},{\"buffer\":0,\"byteOffset\":%zu,"
            "\"byteLength\":%zu}],\"accessors\":[{\"bufferView\":0,\"componentType\":5126,\"count\":%d,"
            "\"type\":\"VEC3\",\"min\":[3,13,12.5],\"max\":[17,27,47.5]},{\"bufferView\":1,"
            "\"componentType\":5125,\"count\":%d,\"type\":\"SCALAR\"}]}",
            sizeof p + sizeof t, sizeof p, sizeof p, sizeof t, BALL_VERTICES, 3 * BALL_TRIANGLES);
        FILE *binary = create("ball.bin");
        fwrite(p, sizeof p, 1, binary);
        fwrite(t, sizeof t, 1, binary);
        fclose(binary);
    }
    fclose(file);
}

// The long axis is the file's z: up in PLY and STL, and -y of ours where y is up in the file.
static void check_ball(const char *name, int long_axis) {
    FfpMesh mesh;
    FfpError err = {0};
    write_ball(name);
    if (!ffp_mesh_read(&mesh, path_of(name), &err)) fail_msg("%s", err.text);
    assert_int_equal(mesh.n_triangles, BALL_TRIANGLES);
    assert_int_equal(mesh.n_vertices, BALL_VERTICES); // shared, hence smooth
    assert_null(mesh.uv);
    float reach[3] = {0, 0, 0}, worst = 1;
    for (int i = 0; i < mesh.n_vertices; i++) {
        const float *p = mesh.positions + 3 * i, *n = mesh.normals + 3 * i;
        float slope[3], length = 0, cosine = 0; // of the ellipsoid
        assert_true(sqrtf(p[0] * p[0] + p[1] * p[1] + p[2] * p[2]) <= FFP_MESH_RADIUS);
        for (int k = 0; k < 3; k++) {
            reach[k] = fmaxf(reach[k], fabsf(p[k]));
            slope[k] = p[k] / (k == long_axis ? 6.25F : 1);
            length += slope[k] * slope[k];
        }
        for (int k = 0; k < 3; k++) cosine += n[k] * slope[k] / sqrtf(length);
        worst = fminf(worst, cosine);
    }
    assert_true(worst > 0.9F); // the tips are coarse
    for (int k = 0; k < 3; k++)
        assert_float_equal(reach[k], (k == long_axis ? FFP_MESH_RADIUS : FFP_MESH_RADIUS / 2.5F), 0.01);
    ffp_mesh_free(&mesh);
}

static void every_format_is_read_and_placed(void **state) {
    (void)state;
    check_ball("ball.obj", 1);
    check_ball("ball.ply", 2);
    check_ball("ball.stl", 2);
    check_ball("ball.gltf", 1);
}

static const char cube[] =
    "v 0 0 0\nv 2 0 0\nv 2 2 0\nv 0 2 0\nv 0 0 2\nv 2 0 2\nv 2 2 2\nv 0 2 2\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\n"
    "f 1/1 4/2 3/3 2/4\nf 5/1 6/2 7/3 8/4\nf 1/1 2/2 6/3 5/4\nf 2/1 3/2 7/3 6/4\nf 3/1 4/2 8/3 7/4\n"
    "f 4/1 1/2 5/3 8/4\n";

static void sharp_edges_and_coordinates_stay(void **state) {
    (void)state;
    FfpMesh mesh;
    FfpError err = {0};
    write_words("cube.obj", cube);
    if (!ffp_mesh_read(&mesh, path_of("cube.obj"), &err)) fail_msg("%s", err.text);
    assert_int_equal(mesh.n_triangles, 12);
    assert_non_null(mesh.uv);
    for (int i = 0; i < mesh.n_vertices; i++) {
        const float *n = mesh.normals + 3 * i;
        assert_float_equal(fmaxf(fabsf(n[0]), fmaxf(fabsf(n[1]), fabsf(n[2]))), 1, 1e-5);
    }
    ffp_mesh_free(&mesh);
}

static void files_that_are_no_mesh_are_refused(void **state) {
    (void)state;
    static const char *const texts[][2] = {
        {"empty.obj", ""},
        {"words.obj", "hello\n"},
        {"words.ply", "hello\n"},
        {"words.stl", "hello\n"},
        {"words.gltf", "hello\n"},
        {"words.glb", "hello\n"},
        {"points.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\n"},
        {"line.obj", "v 0 0 0\nv 1 0 0\nl 1 2\n"},
        {"beyond.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 9\n"},
        {"zero.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 0 1 2\n"},
        {"nan.obj", "v nan 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n"},
        {"far.obj", "v 1e30 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n"},
        {"dot.obj", "v 1 1 1\nv 1 1 1\nv 1 1 1\nf 1 2 3\n"},
        {"many.ply", "ply\nformat binary_little_endian 1.0\nelement vertex 4000000000\nproperty float x\n"
                     "property float y\nproperty float z\nelement face 1\nproperty list uchar int "
                     "vertex_indices\nend_header\n"},
        {"wrong.ply", "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty "
                      "float z\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n"
                      "0 0 0\n1 0 0\n0 1 0\n3 0 1 70000\n"},
        {"nothing.gltf", "{\"asset\":{\"version\":\"2.0\"}}"},
        {"lost.gltf",
         "{\"asset\":{\"version\":\"2.0\"},\"buffers\":[{\"uri\":\"gone.bin\",\"byteLength\":12}]}"},
        {"mesh.xyz", "v 0 0 0\n"},
    };
    FfpMesh mesh;
    for (size_t i = 0; i < sizeof texts / sizeof texts[0]; i++) {
        FfpError err = {0};
        write_words(texts[i][0], texts[i][1]);
        if (ffp_mesh_read(&mesh, path_of(texts[i][0]), &err)) fail_msg("%s was taken", texts[i][0]);
        assert_non_null(strstr(err.text, texts[i][0]));
    }
    FfpError err = {0};
    assert_false(ffp_mesh_read(&mesh, path_of("not_there.obj"), &err));
    assert_non_null(strstr(err.text, "no such file"));
    assert_int_equal(mkdir(path_of("folder.obj"), 0777), 0);
    assert_false(ffp_mesh_read(&mesh, path_of("folder.obj"), &err));
}

// Every beginning of a file, and every file with one byte changed, is read or refused, but does no harm.
static void damaged_files_do_no_harm(void **state) {
    (void)state;
    static const char *const names[] = {"ball.stl", "ball.ply", "ball.gltf", "cube.obj"};
    write_words("cube.obj", cube);
    for (int i = 0; i < 4; i++) {
        char *bytes;
        size_t size;
        FfpError err = {0};
        if (i < 3) write_ball(names[i]);
        assert_true(ffp_read_file(path_of(names[i]), 1 << 24, &bytes, &size, &err));
        const char *damaged = i == 0   ? "damaged.stl"
                              : i == 1 ? "damaged.ply"
                              : i == 2 ? "damaged.gltf"
                                       : "damaged.obj";
        for (size_t step = 0; step < 40; step++) {
            FfpMesh mesh;
            const size_t at = size < 400 ? step * size / 40 : step < 30 ? step * 11 : step * size / 40;
            const char was = bytes[at % size];
            bytes[at % size] ^= 0x55;
            write_bytes(damaged, bytes, size);
            if (ffp_mesh_read(&mesh, path_of(damaged), &err)) ffp_mesh_free(&mesh);
            bytes[at % size] = was;
            write_bytes(damaged, bytes, at);
            if (ffp_mesh_read(&mesh, path_of(damaged), &err)) ffp_mesh_free(&mesh);
        }
        ffp_free(bytes);
    }
}

// --- The process that reads. ---

static void *waits_for_input(void *nothing) {
    getchar();
    return nothing;
}

// In a process of its own: 0 when the mesh was read while a thread waits on stdin and a word waits in stdout.
static int read_while_waiting(const char *path, const char *words) {
    int ends[2];
    pthread_t thread;
    FfpMesh mesh;
    if (pipe(ends) != 0 || dup2(ends[0], 0) < 0 || !freopen(words, "w", stdout)) return 2;
    printf("once\n");
    if (pthread_create(&thread, NULL, waits_for_input, NULL) != 0) return 3;
    nanosleep(&(struct timespec){.tv_nsec = 100000000}, NULL); // it has the stream's lock by now
    alarm(60);
    if (!ffp_mesh_read(&mesh, path, NULL)) return 4;
    return fflush(stdout) == 0 ? 0 : 5;
}

static void the_hosts_streams_are_left_alone(void **state) {
    (void)state;
    char path[FFP_PATH_MAX], words[FFP_PATH_MAX], text[32] = "";
    int status = 0;
    write_words("cube.obj", cube);
    snprintf(path, sizeof path, "%s/cube.obj", root);
    snprintf(words, sizeof words, "%s/words", root);
    const pid_t child = fork();
    if (child == 0) _exit(read_while_waiting(path, words));
    assert_true(child > 0);
    assert_int_equal(waitpid(child, &status, 0), child);
    if (!WIFEXITED(status) || WEXITSTATUS(status) != 0) fail_msg("ended with status %x", (unsigned)status);
    FILE *file = fopen(words, "r");
    assert_non_null(file);
    assert_int_equal(fread(text, 1, sizeof text - 1, file), 5); // by one of the two processes alone
    assert_string_equal(text, "once\n");
    fclose(file);
}

static int open_files(void) {
    int count = 0;
    for (int fd = 0; fd < 256; fd++) count += fcntl(fd, F_GETFD) >= 0;
    return count;
}

static bool read_cube(void *argument, FfpError *err) {
    return ffp_mesh_read(argument, path_of("cube.obj"), err);
}

// Whichever allocation fails: no process is left, nor an end of its pipe.
static void no_reader_is_left_when_memory_is_out(void **state) {
    (void)state;
    const int before = open_files();
    bool ok = false;
    write_words("cube.obj", cube);
    for (int n = 1; !ok; n++) {
        FfpMesh mesh;
        FfpError err = {0};
        FfpContext context = {0};
        assert_true(n < 100);
        ffp_context_fail_at(&context, n);
        ok = ffp_call_run(&context, read_cube, &mesh, &err);
        assert_true(waitpid(-1, NULL, WNOHANG) == -1 && errno == ECHILD);
        assert_int_equal(open_files(), before);
        if (ok) ffp_mesh_free(&mesh);
        assert_true(ok || err.code == FFP_ERROR_MEMORY);
        assert_true(!ok || n > 5); // what failed were the reader, and the arrays it sends
    }
}

// --- Materials. ---

static void write_map(const char *name, float r, float g, float b) {
    FfpError err = {0};
    FfpImage image = ffp_image_new(8, 8, 3);
    for (int i = 0; i < 64; i++) image.data[3 * i] = r, image.data[3 * i + 1] = g, image.data[3 * i + 2] = b;
    if (!ffp_image_write_png(&image, path_of(name), &err)) fail_msg("%s", err.text);
    ffp_image_free(&image);
}

static const float hit_point[3] = {0.31F, -0.2F, 0.4F};

static FfpHit hit_at(float x, float y, float z) {
    FfpHit hit = {.t = 3, .normal = {x, y, z}, .facet = {x, y, z}, .u = 0.25F, .v = 0.25F};
    memcpy(hit.point, hit_point, sizeof hit_point);
    return hit;
}

static void maps_are_found_and_understood(void **state) {
    (void)state;
    assert_int_equal(mkdir(path_of("clay"), 0777), 0);
    write_map("clay/rusty_metal_diff_1k.png", 1, 0.5F, 0);
    write_map("clay/rusty_metal_Roughness.png", 0.4F, 0.4F, 0.4F);
    write_map("clay/rusty_metal_metallic.png", 1, 1, 1); // refused with a warning
    write_map("clay/rusty_metal_nor_gl_1k.png", 0.5F + 0.3F, 0.5F, 0.9F);
    write_map("clay/rusty_metal_nor_dx_1k.png", 0, 0, 0); // not this one
    write_words("clay/readme.txt", "albedo");
    FfpError err = {0};
    FfpTextures *textures = ffp_textures_read(path_of("clay"), &err);
    if (!textures) fail_msg("%s", err.text);
    const FfpMesh mesh = {0};
    const float s = sqrtf(0.5F);
    const FfpHit hits[3] = {hit_at(0, 0, 1), hit_at(0, -1, 0), hit_at(s, 0, s)};
    for (int i = 0; i < 3; i++) {
        float albedo[3], roughness, n[3];
        ffp_textures_look(textures, &mesh, &hits[i], 0.01F, albedo, &roughness);
        assert_float_equal(albedo[0], 1, 1e-3);
        assert_float_equal(albedo[1], 0.2140, 3e-3); // encoded 0.5
        assert_float_equal(albedo[2], 0, 1e-3);
        assert_float_equal(roughness, 0.4, 3e-3);
        memcpy(n, hits[i].normal, sizeof n);
        ffp_textures_bump(textures, &mesh, &hits[i], 0.01F, n);
        assert_float_equal(n[0] * n[0] + n[1] * n[1] + n[2] * n[2], 1, 1e-4);
        if (i == 2) continue;
        assert_float_equal(n[0], 0.6, 6e-3); // (0.6, 0, 0.8) in the map; u grows with x on both sides
        assert_float_equal((i == 0 ? n[2] : -n[1]), 0.8, 6e-3);
    }
    ffp_textures_free(textures);
}

static void coordinates_lay_the_map(void **state) {
    (void)state;
    assert_int_equal(mkdir(path_of("halves"), 0777), 0);
    FfpError err = {0};
    FfpImage image = ffp_image_new(64, 64, 3); // red left, green right; the upper half brighter by blue
    for (int i = 0; i < 64 * 64; i++)
        image.data[3 * i + (i % 64 < 32 ? 0 : 1)] = 1, image.data[3 * i + 2] = i < 32 * 64 ? 1 : 0;
    assert_true(ffp_image_write_png(&image, path_of("halves/basecolor.png"), &err));
    ffp_image_free(&image);
    write_map("halves/normal_dx.png", 0.5F, 0.5F + 0.3F, 0.9F);
    FfpTextures *textures = ffp_textures_read(path_of("halves"), &err);
    if (!textures) fail_msg("%s", err.text);
    float positions[9] = {0, 0, 0, 1, 0, 0, 0, 1, 0}, normals[9] = {0, 0, 1, 0, 0, 1, 0, 0, 1};
    float uv[6] = {0, 0, 1, 0, 0, 1};
    uint32_t triangle[3] = {0, 1, 2};
    const FfpMesh mesh = {.n_vertices = 3,
                          .n_triangles = 1,
                          .positions = positions,
                          .normals = normals,
                          .triangles = triangle,
                          .uv = uv};
    FfpHit hit = hit_at(0, 0, 1);
    for (int k = 0; k < 4; k++) {
        float albedo[3], roughness, n[3] = {0, 0, 1};
        hit.u = k & 1 ? 0.7F : 0.2F, hit.v = k & 2 ? 0.7F : 0.2F;
        ffp_textures_look(textures, &mesh, &hit, 0.001F, albedo, &roughness);
        assert_float_equal(albedo[0], (k & 1 ? 0 : 1), 1e-3);
        assert_float_equal(albedo[1], (k & 1 ? 1 : 0), 1e-3);
        assert_float_equal(albedo[2], (k & 2 ? 1 : 0), 1e-3);
        ffp_textures_bump(textures, &mesh, &hit, 0.001F, n);
        assert_float_equal(n[1], -0.6, 6e-3); // DirectX's green points down
    }
    float albedo[3], roughness;
    ffp_textures_look(textures, &mesh, &hit, 4, albedo, &roughness); // wide: the mean of all
    for (int c = 0; c < 3; c++) assert_float_equal(albedo[c], 0.5, 1e-2);
    ffp_textures_free(textures);
}

static void folders_that_are_no_material_are_refused(void **state) {
    (void)state;
    FfpError err = {0};
    assert_null(ffp_textures_read(path_of("not_there"), &err));
    assert_int_equal(mkdir(path_of("bare"), 0777), 0);
    write_map("bare/roughness.png", 1, 1, 1);
    assert_null(ffp_textures_read(path_of("bare"), &err));
    assert_non_null(strstr(err.text, "basecolor"));
    write_words("bare/albedo.png", "\x89PNG\r\n\x1a\n and no more");
    assert_null(ffp_textures_read(path_of("bare"), &err));
    assert_non_null(strstr(err.text, "albedo.png"));
}

// Albedo and roughness of the material that a seed draws, at one place; its name.
static const char *drawn_look(const FfpPictureFolder *folder, uint64_t seed, float albedo[3],
                              float *roughness) {
    FfpError err = {0};
    const char *name = NULL;
    FfpTextures *textures = ffp_picture_folder_material(folder, seed, &name, &err);
    if (!textures) fail_msg("%s", err.text);
    const FfpMesh mesh = {0};
    const FfpHit hit = hit_at(0, 0, 1);
    ffp_textures_look(textures, &mesh, &hit, 0.01F, albedo, roughness);
    ffp_textures_free(textures);
    return name;
}

// Pictures and folders of maps are all drawn, each as its files say; the seed alone decides.
static void seeds_draw_materials_from_pictures(void **state) {
    (void)state;
    assert_int_equal(mkdir(path_of("stock"), 0777), 0);
    assert_int_equal(mkdir(path_of("stock/tin"), 0777), 0);
    write_map("stock/bark.png", 1, 0.5F, 0);
    write_map("stock/moss.png", 0, 1, 0);
    write_map("stock/tin/basecolor.png", 0, 0, 1);
    write_map("stock/tin/roughness.png", 0.4F, 0.4F, 0.4F);
    write_words("stock/licences.txt", "free");
    write_words("stock/.hidden.png", "no picture");
    FfpError err = {0};
    FfpPictureFolder folder;
    if (!ffp_picture_folder_open(&folder, path_of("stock"), true, &err)) fail_msg("%s", err.text);
    int seen[3] = {0};
    float least = 1, most = 0;
    for (uint64_t seed = 0; seed < 60; seed++) {
        float albedo[3], again[3], roughness, repeated;
        const char *name = drawn_look(&folder, seed, albedo, &roughness);
        assert_string_equal(drawn_look(&folder, seed, again, &repeated), name);
        assert_memory_equal(albedo, again, sizeof albedo);
        assert_true(roughness == repeated);
        const int which = name[0] == 'b' ? 0 : name[0] == 'm' ? 1 : 2;
        const float encoded[3] = {which == 0, which == 0 ? 0.2140F : (float)(which == 1), which == 2};
        for (int c = 0; c < 3; c++) assert_float_equal(albedo[c], 0.02 + 0.9 * (double)encoded[c], 3e-3);
        seen[which]++;
        if (which == 2) {
            assert_float_equal(roughness, 0.4, 3e-3);
        } else {
            least = fminf(least, roughness), most = fmaxf(most, roughness);
        }
    }
    assert_true(seen[0] > 8 && seen[1] > 8 && seen[2] > 8);
    assert_true(least >= 0.25F && least < 0.4F && most <= 0.9F && most > 0.75F);
    ffp_picture_folder_close(&folder);
}

// Half as high as it is wide, left half white: a seed's picture repeats at its own width in both directions
// of the world that it is turned to, so the share of white along any line is a half, and it has its
// proportions.
static void pictures_keep_their_shape(void **state) {
    (void)state;
    FfpError err = {0};
    FfpImage image = ffp_image_new(64, 32, 3);
    for (int i = 0; i < 64 * 32; i++)
        for (int c = 0; c < 3; c++)
            image.data[3 * i + c] = c == 0 ? (real)(i % 64 < 32) : (real)(i < 16 * 64);
    assert_true(ffp_image_write_png(&image, path_of("wide.png"), &err));
    ffp_image_free(&image);
    FfpTextures *textures = ffp_textures_read_picture(path_of("wide.png"), &err);
    if (!textures) fail_msg("%s", err.text);
    const FfpLaying laying = {.axes = {0, 1, 0, -1, 0, 0, 0, 0, 1}, .tile = 2, .roughness = 0.3F, .span = 1};
    ffp_textures_lay(textures, &laying);
    const FfpMesh mesh = {0};
    enum { STEPS = 400 };
    int changes[2][2] = {{0}}; // of red and of green, along y (the pictures' u) and along x
    for (int along = 0; along < 2; along++) {
        float last[2] = {-1, -1};
        for (int i = 0; i < STEPS; i++) { // four world units
            FfpHit hit = hit_at(0, 0, 1);
            hit.point[along == 0 ? 1 : 0] = 0.013F + 4 * (float)i / STEPS;
            float albedo[3], roughness;
            ffp_textures_look(textures, &mesh, &hit, 0.001F, albedo, &roughness);
            assert_float_equal(roughness, 0.3, 1e-6);
            for (int c = 0; c < 2; c++) {
                const float side = albedo[c] > 0.5F ? 1 : 0;
                changes[along][c] += last[c] >= 0 && side != last[c];
                last[c] = side;
            }
        }
    }
    assert_int_equal(changes[0][0], 4); // two widths of 2 units
    assert_int_equal(changes[0][1], 0);
    assert_int_equal(changes[1][0], 0);
    assert_int_equal(changes[1][1], 8); // four heights of 1 unit
    ffp_textures_free(textures);
}

static void folders_of_no_pictures_are_refused(void **state) {
    (void)state;
    FfpError err = {0};
    FfpPictureFolder folder;
    assert_false(ffp_picture_folder_open(&folder, path_of("not_there"), true, &err));
    assert_int_equal(mkdir(path_of("empty"), 0777), 0);
    write_words("empty/notes.txt", "nothing");
    assert_false(ffp_picture_folder_open(&folder, path_of("empty"), true, &err));
    assert_non_null(strstr(err.text, "pictures"));
    write_map("empty/good.png", 1, 1, 1);
    write_words("empty/torn.png", "\x89PNG\r\n\x1a\n and no more");
    assert_false(ffp_picture_folder_open(&folder, path_of("empty"), true, &err));
    assert_non_null(strstr(err.text, "torn.png"));
    assert_int_equal(unlink(path_of("empty/torn.png")), 0);
    assert_int_equal(mkdir(path_of("empty/maps"), 0777), 0);
    assert_false(ffp_picture_folder_open(&folder, path_of("empty"), true, &err));
    assert_non_null(strstr(err.text, "maps"));
    assert_int_equal(rmdir(path_of("empty/maps")), 0);
    if (!ffp_picture_folder_open(&folder, path_of("empty"), true, &err)) fail_msg("%s", err.text);
    write_words("empty/good.png", "gone bad since");
    assert_null(ffp_picture_folder_material(&folder, 1, NULL, &err));
    assert_non_null(strstr(err.text, "good.png"));
    ffp_picture_folder_close(&folder);
}

// Red grows to the right and green downwards, so a pattern says which square of the picture it shows: its
// sides are as long in both directions, half to all of the shorter one, and lie inside. A folder of maps
// is not a picture. The seed alone decides.
static void seeds_draw_patterns_from_pictures(void **state) {
    (void)state;
    enum { WIDTH = 96, HEIGHT = 64, SIDE = 32, COUNT = 3 };
    FfpError err = {0};
    FfpImage image = ffp_image_new(WIDTH, HEIGHT, 3);
    for (int i = 0; i < WIDTH * HEIGHT; i++) {
        image.data[3 * i] = ((real)(i % WIDTH) + 0.5F) / WIDTH;
        image.data[3 * i + 1] = ((real)(i / WIDTH) + 0.5F) / HEIGHT;
    }
    assert_int_equal(mkdir(path_of("shows"), 0777), 0);
    FfpPictureFolder folder;
    assert_int_equal(mkdir(path_of("shows/maps"), 0777), 0);
    assert_false(ffp_picture_folder_open(&folder, path_of("shows"), false, &err));
    assert_non_null(strstr(err.text, "patterns"));
    assert_true(ffp_image_write_png(&image, path_of("shows/a b.png"), &err));
    ffp_image_free(&image);
    if (!ffp_picture_folder_open(&folder, path_of("shows"), false, &err)) fail_msg("%s", err.text);
    double least = 1, most = 0, left = 1, right = 0;
    for (uint64_t seed = 0; seed < 20; seed++) {
        FfpPattern *drawn = ffp_picture_folder_patterns(&folder, seed, COUNT, SIDE, &err);
        FfpPattern *again = ffp_picture_folder_patterns(&folder, seed, COUNT, SIDE, &err);
        assert_true(drawn && again);
        for (int p = 0; p < COUNT; p++) {
            char name[32];
            snprintf(name, sizeof name, "picture_%d_a_b", p + 1);
            assert_string_equal(drawn[p].name, name);
            assert_false(drawn[p].novel);
            assert_memory_equal(drawn[p].image.data, again[p].image.data, SIDE * SIDE * 3 * sizeof(real));
            ffp_image_to_srgb(&drawn[p].image);
            const real *first = drawn[p].image.data, *last = first + 3 * (SIDE * SIDE - 1);
            const double part = (double)SIDE / (SIDE - 1); // from pixel centres to edges
            const double wide = ((double)last[0] - (double)first[0]) * part * WIDTH / HEIGHT,
                         high = ((double)last[1] - (double)first[1]) * part;
            assert_float_equal(wide, high, 0.04);
            assert_float_equal(255 * first[0], round(255 * (double)first[0]), 1e-3);
            least = fmin(least, high), most = fmax(most, high);
            left = fmin(left, (double)first[0]), right = fmax(right, (double)last[0]);
        }
        ffp_picture_patterns_free(drawn, COUNT);
        ffp_picture_patterns_free(again, COUNT);
    }
    assert_true(least > 0.48 && least < 0.6 && most > 0.9 && most < 1.03);
    assert_true(left < 0.1 && right > 0.9);
    write_words("shows/a b.png", "gone bad since");
    assert_null(ffp_picture_folder_patterns(&folder, 1, COUNT, SIDE, &err));
    assert_non_null(strstr(err.text, "a b.png"));
    ffp_picture_folder_close(&folder);
}

// A whole scene of a user's mesh and material: seen, lit and with the albedo of the map.
static void a_scene_of_users_assets(void **state) {
    (void)state;
    FfpError err = {0};
    FfpMesh mesh;
    write_words("cube.obj", cube);
    assert_int_equal(mkdir(path_of("grey"), 0777), 0);
    write_map("grey/basecolor.png", 0.5F, 0.5F, 0.5F);
    assert_true(ffp_mesh_read(&mesh, path_of("cube.obj"), &err));
    FfpTextures *textures = ffp_textures_read(path_of("grey"), &err);
    assert_non_null(textures);
    FfpSceneSpec spec = ffp_scene_defaults();
    spec.own_mesh = &mesh, spec.own_textures = textures, spec.own_name = "cube";
    spec.resolution = 32, spec.views = 2, spec.targets = 0, spec.lollipops = 0, spec.pattern_side = 100;
    FfpCapture capture;
    if (!ffp_scene_make(&capture, &spec, &err)) fail_msg("%s", err.text);
    int seen = 0, lit = 0;
    for (int i = 0; i < 32 * 32; i++) {
        const FfpView *view = &capture.views[0];
        if (view->coverage.data[i] <= 0) continue;
        seen++;
        lit += view->direct_white.data[3 * i] > 0;
        assert_float_equal(view->albedo.data[3 * i], 0.2140, 3e-3);
    }
    assert_true(seen > 150 && lit > 50);
    ffp_capture_free(&capture);
    ffp_textures_free(textures);
    ffp_mesh_free(&mesh);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_format_is_read_and_placed),
        cmocka_unit_test(sharp_edges_and_coordinates_stay),
        cmocka_unit_test(files_that_are_no_mesh_are_refused),
        cmocka_unit_test(damaged_files_do_no_harm),
        cmocka_unit_test(the_hosts_streams_are_left_alone),
        cmocka_unit_test(no_reader_is_left_when_memory_is_out),
        cmocka_unit_test(maps_are_found_and_understood),
        cmocka_unit_test(coordinates_lay_the_map),
        cmocka_unit_test(folders_that_are_no_material_are_refused),
        cmocka_unit_test(seeds_draw_materials_from_pictures),
        cmocka_unit_test(pictures_keep_their_shape),
        cmocka_unit_test(folders_of_no_pictures_are_refused),
        cmocka_unit_test(seeds_draw_patterns_from_pictures),
        cmocka_unit_test(a_scene_of_users_assets),
    };
    return cmocka_run_group_tests(tests, make_root, remove_root);
}
