#!/usr/bin/env python3
"""bench/failures.py WORK [--program build/ffprocams]: what the method cannot do, for docs/lab/failures.md and docs/pictures/failures.png.

Blender's head of an ape under the rig of data/sample (eight stops, 128 x 128), by its path tracer Cycles: once as it should be, then of glass,
of metal, a mirror, furred, as a cage full of holes, overexposed, with a projector that scales its picture, and with a lens that was zoomed
at one stop. Each is checked (`info`), reconstructed from black, white and one lollipop, and compared at two new poses under white and under
a picture. Prints a row of the table for each. Existing pictures are not drawn again. Needs bpy (pip) and Pillow.
"""
import argparse
import json
import math
import shutil
import subprocess
import textwrap
from pathlib import Path

import bpy
from mathutils import Matrix, Vector
from PIL import Image, ImageDraw

ROOT = Path(__file__).resolve().parent.parent
SIDE, FOCAL, PANEL, THROW, WATTS, SAMPLES = 128, 175.84, 800, 768.4, 100, 64
GIVEN, NEW = ("all_black", "all_white", "lollipop_0"), ("all_white", "sun")
# name: (what it is, material, exposure in stops, scale of the projector's picture, zoom of the fourth stop)
CASES = {
    "sound": ("as it should be", "matt", 0, 1, 1),
    "glass": ("glass", "glass", 0, 1, 1),
    "metal": ("brushed metal", "metal", 0, 1, 1),
    "mirror": ("a mirror", "mirror", 0, 1, 1),
    "fur": ("fur", "fur", 0, 1, 1),
    "cage": ("holes", "cage", 0, 1, 1),
    "over": ("overexposed", "matt", 2.5, 1, 1),
    "scaled": ("the projector scales its picture to 93 %", "matt", 0, 0.93, 1),
    "zoomed": ("the lens zoomed by 1.1 at one stop", "matt", 0, 1, 1.1),
}


def look_from(place):
    """Blender's matrix of a device at this place that is aimed at the middle, its top towards z."""
    return Matrix.Translation(place) @ (-Vector(place)).to_track_quat("-Z", "Y").to_matrix().to_4x4()


def poses():
    """{name: (camera, projector)}: eight stops and two new poses."""
    def around(degrees, distance, height):
        return Vector((distance * math.cos(math.radians(degrees)), distance * math.sin(math.radians(degrees)), height))

    stops = {f"stop_{45 * i:03d}": (look_from(around(45 * i, 3, 0)), look_from(around(45 * i, 1.732, 1))) for i in range(8)}
    return stops | {"new_0": (look_from(around(20, 2.9, 0.8)), look_from(around(40, 1.9, 0.6))),
                    "new_1": (look_from(around(200, 3, 0.3)), look_from(around(170, 1.8, 0.9)))}


def surface(kind):
    """A material of Blender's principled surface."""
    material = bpy.data.materials.new(kind)
    material.use_nodes = True
    shader = material.node_tree.nodes["Principled BSDF"].inputs
    shader["Base Color"].default_value = {"metal": (0.8, 0.75, 0.7, 1), "mirror": (0.9, 0.9, 0.9, 1), "fur": (0.5, 0.3, 0.15, 1), "glass": (1, 1, 1, 1)}.get(kind, (0.7, 0.4, 0.3, 1))
    shader["Roughness"].default_value = {"metal": 0.25, "mirror": 0.0, "glass": 0.0}.get(kind, 0.7)
    shader["Metallic"].default_value = float(kind in ("metal", "mirror"))
    shader["Transmission Weight"].default_value = float(kind == "glass")
    return material


def build(kind):
    """The scene without its projector: the object of this material, a dim room, a camera."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    scene = bpy.context.scene
    scene.render.engine, scene.cycles.samples, scene.cycles.use_denoising = "CYCLES", SAMPLES, False
    scene.render.resolution_x = scene.render.resolution_y = SIDE
    scene.render.film_transparent, scene.view_settings.view_transform = True, "Standard"
    scene.render.image_settings.file_format, scene.render.image_settings.color_mode = "PNG", "RGBA"
    scene.world = bpy.data.worlds.new("room")
    scene.world.use_nodes = True
    scene.world.node_tree.nodes["Background"].inputs["Strength"].default_value = 0.3
    bpy.ops.mesh.primitive_monkey_add(size=1.2, rotation=(0, 0, math.pi / 2))
    thing = bpy.context.object
    thing.data.materials.append(surface(kind))
    bpy.ops.object.shade_smooth()
    thing.modifiers.new("finer", "SUBSURF").render_levels = 1 if kind == "cage" else 2
    if kind == "cage":
        wires = thing.modifiers.new("wires", "WIREFRAME")
        wires.thickness, wires.use_replace = 0.03, True
    if kind == "fur":
        thing.modifiers.new("fur", "PARTICLE_SYSTEM")
        hair = thing.particle_systems[0].settings
        hair.type, hair.count, hair.hair_length, hair.child_type, hair.rendered_child_count = "HAIR", 3000, 0.12, "INTERPOLATED", 10
    scene.camera = bpy.data.objects.new("camera", bpy.data.cameras.new("camera"))
    scene.collection.objects.link(scene.camera)
    return scene


def add_projector(scene):
    """A spot light that shows a picture: its direction, divided by its depth, is a place on the panel. Returns the light and its picture's node."""
    light = bpy.data.lights.new("projector", "SPOT")
    light.energy, light.spot_size, light.spot_blend, light.shadow_soft_size, light.use_nodes = WATTS, math.pi, 0, 0, True
    nodes, link = light.node_tree.nodes, light.node_tree.links.new
    ray, parts, place, shown = (nodes.new("ShaderNode" + kind) for kind in ("TexCoord", "SeparateXYZ", "CombineXYZ", "TexImage"))
    link(ray.outputs["Normal"], parts.inputs[0])
    for axis in "XY":
        over, shift = nodes.new("ShaderNodeMath"), nodes.new("ShaderNodeMath")
        over.operation, shift.operation = "DIVIDE", "MULTIPLY_ADD"
        link(parts.outputs[axis], over.inputs[0])
        link(parts.outputs["Z"], over.inputs[1])
        link(over.outputs[0], shift.inputs[0])
        shift.inputs[1].default_value, shift.inputs[2].default_value = -THROW / PANEL, 0.5
        link(shift.outputs[0], place.inputs[axis])
    link(place.outputs[0], shown.inputs["Vector"])
    link(shown.outputs["Color"], nodes["Emission"].inputs["Color"])
    shown.extension, shown.interpolation = "CLIP", "Linear"
    projector = bpy.data.objects.new("projector", light)
    scene.collection.objects.link(projector)
    return projector, shown


def pattern(name, folder, scale):
    """The picture that the panel really shows, scaled about its middle."""
    picture = {"all_black": lambda: Image.new("RGB", (PANEL, PANEL)), "all_white": lambda: Image.new("RGB", (PANEL, PANEL), "white"),
               "lollipop_0": lambda: Image.open(ROOT / "data/sample/patterns/lollipop_0.png").convert("RGB").resize((PANEL, PANEL)),
               "sun": lambda: Image.open(ROOT / "data/sun.png").convert("RGB").resize((PANEL, PANEL))}[name]()
    (folder / "patterns").mkdir(parents=True, exist_ok=True)
    picture.save(folder / "patterns" / f"{name}.png")
    side = round(PANEL * scale)
    shown = Image.new("RGB", (PANEL, PANEL))
    shown.paste(picture.resize((side, side), Image.LANCZOS), ((PANEL - side) // 2,) * 2)
    path = folder / "patterns" / f"shown_{name}.png"
    shown.save(path)
    return str(path)


def draw(case, folder):
    """All pictures of a case and the files that describe them, where they are not there."""
    _, kind, exposure, scale, zoom = CASES[case]
    scene = build(kind)
    scene.view_settings.exposure = exposure
    projector, shown = add_projector(scene)
    pictures = {name: bpy.data.images.load(pattern(name, folder, scale)) for name in {*GIVEN, *NEW}}
    described = {"render_poses.json": [], "targets.json": []}
    for name, (camera, light) in poses().items():
        stop = name.startswith("stop")
        scene.camera.matrix_world, projector.matrix_world = camera, light
        scene.camera.data.sensor_width = 36
        scene.camera.data.lens = 36 * FOCAL / SIDE * (zoom if name == "stop_135" else 1)
        for picture in GIVEN if stop else NEW:
            shown.image = pictures[picture]
            scene.render.filepath = str(folder / f"{name}_{picture}.png")
            same = folder.parent / "sound" / Path(scene.render.filepath).name
            if case == "zoomed" and name != "stop_135" and same.exists():
                shutil.copy(same, folder)
            elif not Path(scene.render.filepath).exists():
                bpy.ops.render.render(write_still=True)
        described["render_poses.json" if stop else "targets.json"].append(
            {"view_id": name, "c2w": [list(row) for row in camera], "p2w": [list(row) for row in light], "proj_fx": THROW, "proj_fy": THROW, "proj_cx": PANEL / 2,
             "proj_cy": PANEL / 2, "patterns": [{"file_path": f"{name}_{p}.png", "projector_image": p} for p in (GIVEN if stop else NEW)]})
    for file, views in described.items():
        camera = {"h": SIDE, "w": SIDE, "fx": FOCAL, "fy": FOCAL, "cx": SIDE / 2, "cy": SIDE / 2}
        (folder / file).write_text(json.dumps({"scene_name": case, "camera": camera, "projector": {"projector_energy": WATTS, "pattern_w": PANEL, "pattern_h": PANEL},
                                               "views": views}))


def over_black(path):
    """Straight alpha over black."""
    picture = Image.open(path).convert("RGBA")
    return Image.alpha_composite(Image.new("RGBA", picture.size, (0, 0, 0, 255)), picture).convert("RGB")


def score(program, folder):
    """Prints the case's row: codes of what `info` finds, PSNR of the photographs given and at the new poses. Returns its four pictures."""
    def call(*command, text=None):
        return subprocess.run([program, *map(str, command)], capture_output=True, text=True, check=text is None).stdout

    found = [f["code"] for f in json.loads(call("info", folder, "--json", text=True))["findings"] if f["severity"] in ("fault", "doubt")]
    call("reconstruct", folder, "-o", folder / "o.ply", "--force")
    call("evaluate", folder, "--gaussians", folder / "o.ply", "--targets", "targets.json", "--save", folder / "predicted", "--json", folder / "scores.json")
    rows = {row["protocol"]: row["psnr"] for row in json.loads((folder / "scores.json").read_text(encoding="utf-8"))["rows"]}
    codes = ", ".join(f"`{code}`" for code in dict.fromkeys(found)) or "nothing"
    print(f"| {CASES[folder.name][0]} | {codes} | {rows['given']:.1f} | {rows['novel_pose']:.1f} |", flush=True)
    names = ("stop_045_all_white.png", "new_0_sun.png")
    predicted = {name: next((folder / "predicted").rglob("*" + name)) for name in names}
    return [over_black(path) for name in names for path in (folder / name, predicted[name])]


def save_sheet(path, rows):
    """Rows of four pictures, each beside its case's name."""
    left = 150
    sheet = Image.new("RGB", (left + 4 * SIDE, 18 + SIDE * len(rows)))
    put = ImageDraw.Draw(sheet)
    for i, label in enumerate(("photograph", "drawn", "new pose", "drawn")):
        put.text((left + i * SIDE + 4, 4), label, fill="white")
    for y, (label, pictures) in enumerate(rows):
        put.multiline_text((6, 18 + y * SIDE + SIDE // 2 - 12), "\n".join(textwrap.wrap(label, 22)), fill="white")
        for x, picture in enumerate(pictures):
            sheet.paste(picture, (left + x * SIDE, 18 + y * SIDE))
    sheet.quantize(256).save(path, optimize=True)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("work", type=Path)
    parser.add_argument("--program", default=str(ROOT / "build/ffprocams"))
    parser.add_argument("--case", action="append", choices=CASES)
    options = parser.parse_args()
    rows = []
    for case in options.case or CASES:
        draw(case, options.work / case)
        rows.append((CASES[case][0], score(options.program, options.work / case)))
    save_sheet(options.work / "failures.png", rows)


if __name__ == "__main__":
    main()
