#!/usr/bin/env python3
"""Bumped devices found again by the picture of a show, as the studio's watch does it: bumps.py PROGRAM FOLDER PICTURE.png...
The object 15 of the test split, photographed by the simulator at 256 pixels under a projector with the pictures' size, is
reconstructed from eight stops; then poses are falsified, and `import` and `align --gaussians` look at one photograph of a
picture. For each: shift that is reported (share of the width; the watch tells more than 0.0015), what is left of it, pixels,
and processor seconds. Not part of the tests."""
import json
import math
import os
import resource
import shutil
import subprocess
import sys

BUMPS = [(device, degrees) for degrees in (0.1, 0.5, 1.5, 3) for device in ("camera", "projector")] + [("both", 0.3), ("both", 1), ("object", 2.5)]
SHIFT = 0.004  # of the distance, for each bump but the object's
TOLD = 0.0015  # SHIFTED of view/studio_watch.js


def run(program, *words):
    """Its output and its processor seconds."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    done = subprocess.run([program, *words], check=True, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return done.stdout.decode(), after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


def turn(axis, degrees):
    (x, y, z), c, s = axis, math.cos(math.radians(degrees)), math.sin(math.radians(degrees))
    t = 1 - c
    return [[t * x * x + c, t * x * y - s * z, t * x * z + s * y],
            [t * x * y + s * z, t * y * y + c, t * y * z - s * x],
            [t * x * z - s * y, t * y * z + s * x, t * z * z + c]]


def product(a, b):
    return [[sum(a[i][n] * b[n][k] for n in range(3)) for k in range(3)] for i in range(3)]


def bumped(pose, degrees, about, distance, axis):
    """About its own place and along its axes; with `about`, a point of the world, around that."""
    rotation, place = [row[:3] for row in pose[:3]], [row[3] for row in pose[:3]]
    if about:
        by = turn(axis, degrees)
        rotation = product(by, rotation)
        place = [about[i] + sum(by[i][k] * (place[k] - about[k]) for k in range(3)) for i in range(3)]
    else:
        rotation = product(rotation, turn(axis, degrees))
        place = [p + SHIFT * distance * rotation[i][0] for i, p in enumerate(place)]
    return [[*row, p] for row, p in zip(rotation, place)] + [[0, 0, 0, 1]]


def seen(device, pose, point):
    d = [p - row[3] for p, row in zip(point, pose)]
    q = [sum(pose[i][k] * d[i] for i in range(3)) for k in range(3)]
    return device["cx"] + device["fx"] * q[0] / q[2], device["cy"] + device["fy"] * q[1] / q[2]


def apart(device, a, b, points):
    """Mean distance of the object's points in the device's picture."""
    return sum(math.dist(seen(device, a, p), seen(device, b, p)) for p in points) / len(points)


def look(program, folder, now, view, ply):
    """Poses that `align` finds from believed ones, and seconds."""
    here = os.path.join(folder, "believed")
    shutil.rmtree(here, ignore_errors=True)
    shutil.rmtree(here + "-aligned", ignore_errors=True)
    shutil.copytree(now, here)
    path = os.path.join(here, "scene.json")
    scene = json.load(open(path))
    scene["views"][0].update(view)
    json.dump(scene, open(path, "w"))
    told, seconds = run(program, "align", here, "-g", ply, "-p", "own", "--json", "-o", here + "-aligned")
    found = json.load(open(os.path.join(here + "-aligned", "scene.json")))["views"][0]
    return {name: found[name] for name in ("c2w", "p2w")}, json.loads(told)["after"], seconds


def prepare(program, folder, pictures):
    """Photographs, capture and Gaussians; the names of the photographs of each picture."""
    at = lambda name: os.path.join(folder, name)
    width, height = (int.from_bytes(open(pictures[0], "rb").read(24)[i:i + 4], "big") for i in (16, 20))
    run(program, "patterns", "-o", at("patterns"), "--projector", f"{width}x{height}", "--lollipops", "1")
    plain = sorted(name for name in os.listdir(at("patterns")) if name.endswith(".png") and "gray" not in name and "focus" not in name)
    for name in os.listdir(at("patterns")):
        if "gray" in name or "focus" in name:
            os.remove(at("patterns/" + name))
    numbers = {name.split("_", 1)[1][:-4]: int(name.split("_")[0]) for name in plain}
    for i, picture in enumerate(pictures):
        numbers[f"own{i}"] = 900 + i
        shutil.copy(picture, at(f"patterns/{900 + i}_own{i}.png"))
    shots = ["generate", at("shots"), "--photographs", at("patterns"), "--views", "8", "--attitudes", "0", "--split", "test", "--first", "15",
             "--resolution", "256", "--sensor", "read=0.003", "--sensor", "shot=0.0003"]
    run(program, *shots)
    shutil.rmtree(at("patterns-one"), ignore_errors=True)
    os.mkdir(at("patterns-one"))
    shutil.copy(pictures[0], at("patterns-one/900_own0.png"))
    again = [at("one") if word == at("shots") else at("patterns-one") if word == at("patterns") else word for word in shots]
    print(f"a simulated photograph: {run(program, *again, '--only', 'view-000')[1]:.1f} processor seconds")
    names = [name for name in numbers if not name.startswith("own")]
    image = lambda name, number: f"{name}={at('shots')}/view-{{view}}/{number:03}.png"
    calibration = ["-c", at("shots/truth.json"), "-t", at("shots/truth.json"), "--angles", "8x45", "-w", "256", "-m", at("shots") + "/masks/view-{view}.png"]
    given = [word for name in names for word in ("-i", image(name, numbers[name]))]
    given += [word for name in names if name not in ("black", "white") for word in ("-p", f"{name}={at('patterns')}/{numbers[name]:03}_{name}.png")]
    run(program, "import", *calibration, *given, "-o", at("capture"))
    run(program, "reconstruct", at("capture"), "-o", at("object.ply"))
    looks = []
    for i in range(len(pictures)):
        own = [word for name in ("black", "white") for word in ("-i", image(name, numbers[name]))] + ["-i", image("own", 900 + i), "-p", f"own={pictures[i]}"]
        seconds = run(program, "import", *calibration, *own, "-v", "000", "-o", at(f"now{i}"))[1]
        looks.append((at(f"now{i}"), seconds))
    return at("object.ply"), looks


def main():
    program, folder, pictures = sys.argv[1], sys.argv[2], sys.argv[3:]
    os.makedirs(folder)
    ply, looks = prepare(program, folder, pictures)
    for picture, (now, importing) in zip(pictures, looks):
        scene = json.load(open(os.path.join(now, "scene.json")))
        centre, radius, truth = scene["object"]["centre"], scene["object"]["radius"], scene["views"][0]
        points = [[centre[k] + (0.8 * radius * side if k == axis else 0) for k in range(3)] for axis in range(3) for side in (1, -1)]
        devices = {"c2w": scene["camera"], "p2w": scene["projector"]}
        far = {name: math.dist(centre, [row[3] for row in truth[name][:3]]) for name in devices}
        pixels = lambda a, b: {name: apart(device, a[name], b[name], points) for name, device in devices.items()}
        still, least, _ = look(program, folder, now, {}, ply)
        print(f"{picture}: without a bump off by " + ", ".join(f"{name} {value:.2f}" for name, value in pixels(still, truth).items()), flush=True)
        for what, degrees in BUMPS:
            moved = {"camera": ["c2w"], "projector": ["p2w"]}.get(what, list(devices))
            axis = [0.48, 0.6, 0.64] if what != "object" else [row[1] for row in truth["c2w"][:3]]
            believed = {name: bumped(truth[name], degrees, centre if what == "object" else None, far[name], axis) for name in moved}
            start = {**{name: still[name] for name in devices}, **believed}
            found, after, seconds = look(program, folder, now, start, ply)
            told, left = pixels(start, found), pixels(found, truth)
            noticed = any(told[name] > TOLD * device["width"] for name, device in devices.items())
            print(f"  {what:9} {degrees:3} degrees: was off by {max(pixels(start, truth).values()):5.1f}, {'noticed' if noticed else 'NOT NOTICED'}, "
                  f"{'found' if after <= 2 * least else 'LOST'}, left camera {left['c2w']:.2f} projector {left['p2w']:.2f} pixels; "
                  f"{importing:.1f} + {seconds:.1f} processor seconds", flush=True)


if __name__ == "__main__":
    main()
