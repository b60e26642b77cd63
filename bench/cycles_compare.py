"""Run by bench/cycles_compare inside Blender, in a scratch folder.

make SHAPE      writes SHAPE.ply, of radius 0.95, and white/ (the material's maps)
compare SHAPE   renders the views of ours/SHAPE_00000 with Cycles and prints how far the two lie apart
"""
import json
import os
import sys
import time

import bpy
import numpy as np
from mathutils import Matrix

ALBEDO = 0.8
INTENSITY, AMBIENT = 7.96, 0.3
SAMPLES = 64


def make_shape(shape):
    if shape == 'ball':
        bpy.ops.mesh.primitive_uv_sphere_add(segments=128, ring_count=64, radius=0.95)
    else:
        bpy.ops.mesh.primitive_torus_add(
            major_segments=160, minor_segments=64, major_radius=0.6, minor_radius=0.35, rotation=(1.2, 0, 0.5))
        bpy.ops.object.transform_apply(rotation=True)
    thing = bpy.context.object
    bpy.ops.object.shade_smooth()
    return thing


def clear():
    bpy.ops.object.select_all(action='SELECT')
    bpy.ops.object.delete()


def save_map(name, value, colour_space):
    image = bpy.data.images.new(name, 4, 4)
    image.colorspace_settings.name = colour_space
    image.pixels = [value, value, value, 1] * 16
    image.filepath_raw = f'white/{name}.png'
    image.file_format = 'PNG'
    image.save()


def encode(linear):
    return 1.055 * linear ** (1 / 2.4) - 0.055


def make(shape):
    clear()
    mesh = make_shape(shape).data
    mesh.calc_loop_triangles()
    with open(f'{shape}.ply', 'w') as file:
        file.write(f'ply\nformat ascii 1.0\nelement vertex {len(mesh.vertices)}\n'
                   + ''.join(f'property float {k}\n' for k in ('x', 'y', 'z', 'nx', 'ny', 'nz'))
                   + f'element face {len(mesh.loop_triangles)}\nproperty list uchar int vertex_indices\nend_header\n')
        for v in mesh.vertices:
            file.write(' '.join(f'{x:.7g}' for x in (*v.co, *v.normal)) + '\n')
        for t in mesh.loop_triangles:
            file.write('3 ' + ' '.join(map(str, t.vertices)) + '\n')
    os.makedirs('white', exist_ok=True)
    save_map('basecolor', round(255 * encode(ALBEDO)) / 255, 'sRGB')
    save_map('roughness', 1.0, 'Non-Color')


def true_albedo():
    v = round(255 * encode(ALBEDO)) / 255
    return ((v + 0.055) / 1.055) ** 2.4


def read(path):
    """Pixels of a linear picture, first row on top, [height, width, 4]."""
    image = bpy.data.images.load(path, check_existing=False)
    pixels = np.array(image.pixels[:], dtype=np.float64).reshape(image.size[1], image.size[0], 4)[::-1]
    bpy.data.images.remove(image)
    return pixels


def set_up(shape):
    clear()
    thing = make_shape(shape)
    matt = bpy.data.materials.new('matt')
    matt.use_nodes = True
    nodes = matt.node_tree.nodes
    nodes.clear()
    diffuse, end = nodes.new('ShaderNodeBsdfDiffuse'), nodes.new('ShaderNodeOutputMaterial')
    diffuse.inputs['Color'].default_value = (true_albedo(),) * 3 + (1,)
    matt.node_tree.links.new(diffuse.outputs[0], end.inputs[0])
    thing.data.materials.clear()
    thing.data.materials.append(matt)
    lamp = bpy.data.objects.new('lamp', bpy.data.lights.new('lamp', 'POINT'))
    lamp.data.shadow_soft_size = 0
    camera = bpy.data.objects.new('camera', bpy.data.cameras.new('camera'))
    scene = bpy.context.scene
    for thing in (lamp, camera):
        scene.collection.objects.link(thing)
    scene.camera = camera
    scene.world.use_nodes = True
    scene.render.engine = 'CYCLES'
    scene.cycles.samples, scene.cycles.use_denoising, scene.cycles.use_adaptive_sampling = SAMPLES, False, False
    scene.cycles.pixel_filter_type = 'BOX'
    scene.render.film_transparent = True
    scene.render.image_settings.file_format = 'OPEN_EXR'
    scene.render.image_settings.color_depth = '32'
    scene.render.threads_mode, scene.render.threads = 'FIXED', 2
    return scene, camera, lamp


def blender_pose(rows):
    return Matrix(rows) @ Matrix.Diagonal((1, -1, -1, 1))


def render(scene, lamp, power, ambient, bounces, path):
    lamp.data.energy = power
    world = scene.world.node_tree.nodes['Background'].inputs
    world[0].default_value, world[1].default_value = (ambient,) * 3 + (1,), 1
    scene.cycles.max_bounces = scene.cycles.diffuse_bounces = bounces
    scene.render.filepath = f'./{path}'
    begin = time.time()
    bpy.ops.render.render(write_still=True)
    return read(f'{path}'), time.time() - begin


def inside(mask):
    """Pixels whose eight neighbours are in the mask too."""
    out = mask.copy()
    for dy in (-1, 0, 1):
        for dx in (-1, 0, 1):
            out &= np.roll(mask, (dy, dx), (0, 1))
    return out


def specular_share(view, capture, normal, depth):
    """The gloss that our light model adds to its Lambert term, and that Cycles' matt surface lacks (docs/design/architecture.md)."""
    camera, c2w, p2w = capture['camera'], np.array(view['c2w']), np.array(view['p2w'])
    y, x = np.mgrid[0:camera['height'], 0:camera['width']] + 0.5
    ray = np.stack([(x - camera['cx']) / camera['fx'], (y - camera['cy']) / camera['fy'], np.ones_like(x)], -1) @ c2w[:3, :3].T
    point = c2w[:3, 3] + depth[..., None] * ray

    def unit(a):
        return a / np.maximum(np.linalg.norm(a, axis=-1, keepdims=True), 1e-9)

    v, l = unit(-ray), unit(p2w[:3, 3] - point)
    h = unit(v + l)
    nl, nv, nh, vh = [np.clip((a * b).sum(-1), 1e-6, 1) for a, b in ((normal, l), (normal, v), (normal, h), (v, h))]
    k = 0.5  # roughness 1: a = 1, (rho + 1)^2 / 8
    gloss = 1 / np.pi * (0.04 + 0.96 * 2 ** ((-5.55473 * vh - 6.98316) * vh)) / (4 * (nv * (1 - k) + k) * (nl * (1 - k) + k))
    return gloss / (true_albedo() / np.pi)


def depths(scene, view, camera):
    """Camera z of the surface at the pixels' centres, 0 where there is none: Blender cannot read our depth files."""
    c2w = np.array(view['c2w'])
    graph, out = bpy.context.evaluated_depsgraph_get(), np.zeros((camera['height'], camera['width']))
    for y in range(camera['height']):
        for x in range(camera['width']):
            ray = c2w[:3, :3] @ ((x + 0.5 - camera['cx']) / camera['fx'], (y + 0.5 - camera['cy']) / camera['fy'], 1)
            hit, place, *_ = scene.ray_cast(graph, c2w[:3, 3], ray)
            if hit:
                out[y, x] = (np.array(place) - c2w[:3, 3]) @ c2w[:3, 2]
    return out


def compare(shape):
    folder = f'ours/{shape}_00000'
    capture = json.load(open(f'{folder}/scene.json'))
    scene, camera, lamp = set_up(shape)
    size = capture['camera']
    scene.render.resolution_x, scene.render.resolution_y, scene.render.resolution_percentage = size['width'], size['height'], 100
    camera.data.sensor_width = 36
    camera.data.lens = size['fx'] / size['width'] * 36
    direct, ambient, seconds = [], [], 0
    for view in capture['views']:
        camera.matrix_world, lamp.matrix_world = blender_pose(view['c2w']), blender_pose(view['p2w'])
        lit, _ = render(scene, lamp, 4 * np.pi * INTENSITY, 0, 0, 'direct.exr')
        glow, _ = render(scene, lamp, 0, AMBIENT, 4, 'ambient.exr')
        ours = {key: read(f"{folder}/{view[key]}") for key in ('direct_white', 'normal')}
        black = bpy.data.images.load(f"{folder}/{view['images']['all_black']}")
        pixels = np.array(black.pixels[:]).reshape(size['height'], size['width'], 4)[::-1]
        encoded = pixels[..., 1]
        black_linear = np.where(encoded <= 0.04045, encoded / 12.92, ((encoded + 0.055) / 1.055) ** 2.4)
        depth = depths(scene, view, size)
        share = specular_share(view, capture, ours['normal'][..., :3], depth)
        whole = inside((lit[..., 3] > 0.999) & (pixels[..., 3] > 0.999) & (depth > 0))
        lambert = ours['direct_white'][..., 1] / (1 + share)
        both = whole & inside((lit[..., 1] > 0.02) & (lambert > 0.02))
        direct.append((lambert / np.maximum(lit[..., 1], 1e-6))[both])
        ambient.append((black_linear / np.maximum(glow[..., 1], 1e-6))[whole])
    for pattern in range(8):  # the time of one picture, as often as a view has patterns
        seconds += render(scene, lamp, 4 * np.pi * INTENSITY, AMBIENT, 1, 'timed.exr')[1]
    for name, values in (('direct', direct), ('ambient', ambient)):
        ratio = np.concatenate(values)
        print(f'== {shape}: {name} ours / Cycles: mean {ratio.mean():.4f}, median {np.median(ratio):.4f}, '
              f'5 % to 95 %: {np.percentile(ratio, 5):.4f} to {np.percentile(ratio, 95):.4f}, {ratio.size} pixels')
    print(f'== {shape}: Cycles, {SAMPLES} samples, two threads: {8 * seconds:.1f} s for 8 views x 8 patterns')


{'make': make, 'compare': compare}[sys.argv[-2]](sys.argv[-1])
