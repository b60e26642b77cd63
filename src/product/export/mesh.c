#include "product/export/mesh.h"
#include "core/base/alloc.h"
#include "core/base/file.h"
#include "core/capture/node.h"
#include "product/export/gltf.h"
#include "product/export/quaternion.h"
#include "product/export/volume.h"

bool ffp_surface_of_gaussians(FfpSurface *mesh, const FfpGaussians *gaussians, const FfpCapture *capture,
                              const FfpRenderSettings *settings, int resolution, const char *where,
                              FfpError *err) {
    const FfpDepthSource source = {gaussians, capture, settings, ffp_raster_new()};
    FfpVolume volume = ffp_volume_fuse(&source, resolution);
    *mesh = (FfpSurface){0};
    ffp_surface_nets(&volume, mesh);
    ffp_surface_drop_loose(mesh);
    const bool ok = mesh->n_quads > 0;
    if (ok) ffp_surface_paint(mesh, &source, &volume);
    ffp_volume_free(&volume);
    ffp_raster_free(source.raster);
    if (ok) return true;
    ffp_surface_free(mesh);
    return ffp_fail(
        err, FFP_ERROR_FILE, where,
        "the capture's cameras see no surface of these Gaussians: do they belong to this capture?");
}

void ffp_surface_rotate(FfpSurface *mesh, const real turn[4]) {
    for (size_t i = 0; i < mesh->n_vertices; i++) {
        real point[3], normal[3];
        ffp_quaternion_rotate(turn, mesh->position + 3 * i, point);
        ffp_quaternion_rotate(turn, mesh->normal + 3 * i, normal);
        for (size_t k = 0; k < 3; k++) {
            mesh->position[3 * i + k] = point[k];
            mesh->normal[3 * i + k] = normal[k];
        }
    }
}

void ffp_surface_free(FfpSurface *mesh) {
    ffp_free(mesh->position);
    ffp_free(mesh->normal);
    ffp_free(mesh->quads);
    ffp_image_free(&mesh->albedo);
    ffp_image_free(&mesh->roughness);
    *mesh = (FfpSurface){0};
}

// --- glTF. ---

// Every quad has corners of its own, since its tile of the textures is its own.
static json_t *add_corners(FfpGltf *gltf, const FfpSurface *mesh) {
    const size_t n = 4 * (size_t)mesh->n_quads;
    real *position = ffp_alloc(n, 3 * sizeof(real)), *normal = ffp_alloc(n, 3 * sizeof(real)),
         *uv = ffp_alloc(n, 2 * sizeof(real));
    for (size_t i = 0; i < n; i++) {
        const size_t from = mesh->quads[i], quad = i / 4, across = (size_t)mesh->tiles_across;
        const size_t right = (i % 4 == 1 || i % 4 == 2) * (FFP_TILE_TEXELS - 1),
                     below = (i % 4 >= 2) * (FFP_TILE_TEXELS - 1);
        for (size_t k = 0; k < 3; k++) {
            position[3 * i + k] = mesh->position[3 * from + k];
            normal[3 * i + k] = mesh->normal[3 * from + k];
        }
        uv[2 * i] = ((real)(quad % across * FFP_TILE_TEXELS + right) + 0.5F) / (real)mesh->albedo.width;
        uv[2 * i + 1] = ((real)(quad / across * FFP_TILE_TEXELS + below) + 0.5F) / (real)mesh->albedo.height;
    }
    const int places[3] = {ffp_gltf_floats(gltf, position, n, 3, true),
                           ffp_gltf_floats(gltf, normal, n, 3, false),
                           ffp_gltf_floats(gltf, uv, n, 2, false)};
    ffp_free(position);
    ffp_free(normal);
    ffp_free(uv);
    return json_pack("{s:i, s:i, s:i}", "POSITION", places[0], "NORMAL", places[1], "TEXCOORD_0", places[2]);
}

static int add_triangles(FfpGltf *gltf, const FfpSurface *mesh) {
    static const uint32_t corners[6] = {0, 1, 2, 0, 2, 3};
    const size_t n = 6 * (size_t)mesh->n_quads;
    uint32_t *indices = ffp_alloc(n, sizeof *indices);
    for (size_t i = 0; i < n; i++) indices[i] = (uint32_t)(i / 6) * 4 + corners[i % 6];
    const int accessor = ffp_gltf_indices(gltf, indices, n);
    ffp_free(indices);
    return accessor;
}

static int add_texture(FfpGltf *gltf, const FfpImage *image, FfpError *err) {
    unsigned char *png;
    size_t size;
    if (!ffp_image_encode_png(image, &png, &size, err)) return -1;
    const int texture = ffp_gltf_texture(gltf, png, size);
    ffp_free(png);
    return texture;
}

// Roughness in green, metallic 0 in blue.
static int add_roughness(FfpGltf *gltf, const FfpSurface *mesh, FfpError *err) {
    FfpImage rgb = ffp_image_new(mesh->roughness.width, mesh->roughness.height, 3);
    const size_t texels = (size_t)rgb.width * (size_t)rgb.height;
    for (size_t i = 0; i < texels; i++) {
        rgb.data[3 * i] = 1;
        rgb.data[3 * i + 1] = mesh->roughness.data[i];
    }
    const int texture = add_texture(gltf, &rgb, err);
    ffp_image_free(&rgb);
    return texture;
}

static bool add_material(FfpGltf *gltf, const FfpSurface *mesh, FfpError *err) {
    FfpImage encoded = ffp_image_copy(&mesh->albedo);
    ffp_image_to_srgb(&encoded);
    const int colour = add_texture(gltf, &encoded, err);
    ffp_image_free(&encoded);
    const int rough = colour >= 0 ? add_roughness(gltf, mesh, err) : -1;
    if (rough < 0) return false;
    json_array_append_new(ffp_gltf_list(gltf, "materials"),
                          json_pack("{s:{s:{s:i}, s:{s:i}, s:f, s:f}}", "pbrMetallicRoughness",
                                    "baseColorTexture", "index", colour, "metallicRoughnessTexture", "index",
                                    rough, "metallicFactor", 0.0, "roughnessFactor", 1.0));
    return true;
}

bool ffp_surface_write_gltf(const FfpSurface *mesh, const char *path, bool binary, FfpError *err) {
    FfpGltf gltf = ffp_gltf_new();
    bool ok = add_material(&gltf, mesh, err);
    if (ok) {
        const int triangles = add_triangles(&gltf, mesh);
        json_t *attributes = add_corners(&gltf, mesh);
        ok = ffp_gltf_write(&gltf,
                            json_pack("{s:o, s:i, s:i, s:i}", "attributes", attributes, "indices", triangles,
                                      "material", 0, "mode", 4),
                            path, binary, err);
    }
    ffp_gltf_free(&gltf);
    return ok;
}

// --- OBJ. ---

// Colours of the vertices: a corner texel of any quad that has it.
static real *vertex_colours(const FfpSurface *mesh) {
    real *colours = ffp_alloc((size_t)mesh->n_vertices + 1, 3 * sizeof *colours);
    const size_t across = (size_t)mesh->tiles_across, width = (size_t)mesh->albedo.width;
    for (size_t i = 0; i < 4 * (size_t)mesh->n_quads; i++) {
        const size_t quad = i / 4, right = (i % 4 == 1 || i % 4 == 2) * (FFP_TILE_TEXELS - 1),
                     below = (i % 4 >= 2) * (FFP_TILE_TEXELS - 1);
        const size_t texel =
            (quad / across * FFP_TILE_TEXELS + below) * width + quad % across * FFP_TILE_TEXELS + right;
        for (size_t k = 0; k < 3; k++)
            colours[3 * (size_t)mesh->quads[i] + k] = ffp_srgb_encode(mesh->albedo.data[3 * texel + k]);
    }
    return colours;
}

// Vertices that no quad has (of loose pieces) are left out: `number` counts the others from 1.
static uint32_t number_vertices(const FfpSurface *mesh, uint32_t *number) {
    uint32_t count = 0;
    for (size_t i = 0; i < 4 * (size_t)mesh->n_quads; i++) number[mesh->quads[i]] = 1;
    for (size_t i = 0; i < mesh->n_vertices; i++)
        if (number[i]) number[i] = ++count;
    return count;
}

static void print_obj(const FfpSurface *mesh, const real *colours, const uint32_t *number, FILE *out) {
    for (size_t i = 0; i < mesh->n_vertices; i++) {
        const real *p = mesh->position + 3 * i, *c = colours + 3 * i, *n = mesh->normal + 3 * i;
        if (!number[i]) continue;
        fprintf(out, "v %.6g %.6g %.6g %.4f %.4f %.4f\n", (double)p[0], (double)p[1], (double)p[2],
                (double)c[0], (double)c[1], (double)c[2]);
        fprintf(out, "vn %.4f %.4f %.4f\n", (double)n[0], (double)n[1], (double)n[2]);
    }
    for (size_t i = 0; i < 6 * (size_t)mesh->n_quads; i++) {
        static const size_t corners[6] = {0, 1, 2, 0, 2, 3};
        const uint32_t v = number[mesh->quads[4 * (i / 6) + corners[i % 6]]];
        fprintf(out, "%s %u//%u%s", i % 3 == 0 ? "f" : "", v, v, i % 3 == 2 ? "\n" : "");
    }
}

bool ffp_surface_write_obj(const FfpSurface *mesh, const char *path, FfpError *err) {
    FfpOutput out;
    real *colours = vertex_colours(mesh);
    uint32_t *number = ffp_alloc((size_t)mesh->n_vertices + 1, sizeof *number);
    number_vertices(mesh, number);
    bool ok = ffp_output_open(&out, path, err);
    if (ok) {
        print_obj(mesh, colours, number, out.stream);
        ok = ffp_output_commit(&out, err);
    }
    ffp_free(colours);
    ffp_free(number);
    return ok;
}
