#!/usr/bin/env python3
"""A second projector in the studio: photographed on the simulated rig by the page's buttons (by requests where there is no
browser), found, and held against the simulator's truth.

    test_second.py PROGRAM FOLDER

Exits with 77 where the program was built without the studio."""
import json
import math
import os
import shutil
import sys
import time
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent.parent / "view"))
import browser  # noqa: E402
import test_server  # noqa: E402
import test_studio  # noqa: E402

STOPS, VIEW, SIZE = 5, "view-072", [480, 300]
TURNED, MOVED, FOCAL, RMS = 1.0, 0.03, 0.03, 0.3  # degrees, shares of distance and focal length, pixels of the projector


def shoot(studio, name):
    """All photographs of a set by the simulated camera."""
    assert studio.do(verb="shoot", set=name)[0] == 200
    while (active := studio.state()["active"]) and active["name"] == name:
        status, answer = studio.do(verb="take", set=name, number=active["next"]["number"])
        assert status == 200, answer
        if answer["active"] and answer["active"]["done"] == active["done"]:
            time.sleep(0.1)  # being simulated


def reconstruct(studio):
    assert studio.do(verb="run", step="patterns")[0] == 200
    studio.wait()
    assert studio.do(verb="set", settings={"draft": True})[0] == 200
    assert studio.do(verb="object", name="object", stops=STOPS, empty=False)[0] == 200
    for at in studio.state()["objects"][0]["sets"]:
        shoot(studio, at["name"])
    assert studio.do(verb="run", step="make")[0] == 200
    studio.wait()


def refusals(studio):
    """Wrong requests change nothing."""
    before = studio.state()["objects"]
    for wrong in ({"view": "view-073", "size": SIZE}, {"size": SIZE}, {"view": VIEW}, {"view": VIEW, "size": [480]},
                  {"view": VIEW, "size": [63, 300]}, {"view": VIEW, "size": [480, 9000]}, {"view": VIEW, "size": [480.5, 300]}):
        status, answer = studio.do(verb="second", **wrong)
        assert status != 200 and answer["error"], wrong
    status, answer = studio.do(verb="run", step="second")
    assert status != 200 and "not photographed" in answer["error"], answer
    assert studio.state()["objects"] == before


def by_requests(studio):
    assert studio.do(verb="second", view=VIEW, size=SIZE)[0] == 200
    studio.wait()
    shoot(studio, f"objects/object/projector-2/{VIEW}")
    assert studio.do(verb="run", step="second")[0] == 200
    studio.wait()


def by_buttons(found, studio, folder):
    """The page photographs it, is closed in the middle, goes on, and the viewer has it."""
    url = f"http://127.0.0.1:{studio.port}/{studio.key}/#look"
    viewer = "document.getElementById('viewer').contentWindow.viewer"
    page = test_studio.Page(found)
    try:
        page.start(url)
        page.wait_for_viewer()
        page.run(f"document.getElementById('second-view').value = '{VIEW}'")
        page.click("#second-go")
        page.wait("studio.state.active && studio.state.active.done > 3")
        page.click("#shooting-stop")
        page.wait("!shooting.running && studio.state.active && studio.state.active.name.includes('/projector-2/')")
        page.start(url)  # after a reload
        page.wait_for_viewer()
        page.click("#shooting-stop")  # goes on
        page.wait(f"objectNow(studio.state).second.found && {viewer}.projectors.length === 2", 60)
        page.wait("/^Known well/.test(document.getElementById('second-says').textContent)")
        print(page.run("document.getElementById('second-says').textContent"))
        told = page.run(f"(() => {{ const p = {viewer}.projectors[1]; return {{device: p.device, panel: [p.panel.width, p.panel.height], "
                        f"first: {viewer}.projectors[0].device.pose}}; }})()")
        page.screenshot(str(folder / "second.png"))
        assert not page.said, page.said
    finally:
        page.close()
    scene = json.loads((studio.folder / "objects/object/projector-2/found/scene.json").read_text())
    assert told["panel"] == SIZE and [told["device"][side] for side in ("width", "height")] == SIZE
    assert told["device"]["pose"] == sum(scene["views"][0]["p2w"], [])
    views = json.loads((studio.folder / "objects/object/capture/scene.json").read_text())["views"]
    first = next(view for view in views if view["id"] == VIEW)
    assert all(abs(a - b) < 1e-4 for a, b in zip(told["first"], sum(first["p2w"], []))), "the first one shines at another stop"


def product(a, b):
    return [[sum(a[i][k] * b[k][j] for k in range(3)) for j in range(3)] for i in range(3)]


def turned(m):
    return [list(row) for row in zip(*m)]


def judge(folder):
    """The device that was found, as the camera sees it, against the simulator's."""
    truth = json.loads((folder / f"virtual/projector-2-{VIEW}/truth.json").read_text())
    first = json.loads((folder / f"virtual/{VIEW}/truth.json").read_text())
    scene = json.loads((folder / "objects/object/projector-2/found/scene.json").read_text())
    log = (folder / "logs/second.txt").read_text()
    told = json.loads(log[log.rindex("\n{"):])
    c2w, p2w = scene["views"][0]["c2w"], scene["views"][0]["p2w"]
    unit = math.hypot(*first["T"])  # millimetres of a world unit: the distance between the first two lenses
    rotation = product(turned([row[:3] for row in p2w[:3]]), [row[:3] for row in c2w[:3]])
    apart = [p2w[i][3] - c2w[i][3] for i in range(3)]  # in the world; in the camera's frame:
    place = [unit * sum(c2w[k][i] * apart[k] for k in range(3)) for i in range(3)]
    right = [-sum(truth["R"][k][i] * truth["T"][k] for k in range(3)) for i in range(3)]
    between = product(turned(rotation), truth["R"])
    angle = math.degrees(math.acos(min(1, (sum(between[i][i] for i in range(3)) - 1) / 2)))
    moved = math.dist(place, right) / (unit * told["distance"])
    focal = scene["projector"]["fx"] / truth["proj_K"][0][0] - 1
    print(f"rotation off by {angle:.3f} degrees, place by {100 * moved:.2f} % of its distance, focal length by {100 * focal:+.2f} %; "
          f"{told['used']} of {told['points']} points within {told['rms']:.3f} pixels; said: {told['deviations']}")
    assert angle < TURNED and moved < MOVED and abs(focal) < FOCAL and told["rms"] < RMS


def main():
    program, folder = os.path.abspath(sys.argv[1]), Path(sys.argv[2]).resolve()
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    studio = test_server.Studio(program, folder / "rig", "--virtual")
    if "without the studio" in studio.error:
        print("built without the studio")
        return 77
    began, found = time.monotonic(), browser.find()
    reconstruct(studio)
    refusals(studio)
    print(f"reconstructed after {time.monotonic() - began:.0f} s")
    if found:
        by_buttons(found, studio, folder)
    else:
        by_requests(studio)
    judge(folder / "rig")
    studio.stop()
    print(f"{time.monotonic() - began:.0f} s")
    return 0


if __name__ == "__main__":
    sys.exit(main())
