#!/usr/bin/env python3
"""Files of each part, read by every part that is to read them, at 64 pixels: the program, the studio, the page of `view`, the page
that reconstructs, the Python package, and formats of other programs.

    test_matrix.py PROGRAM FOLDER [PAGE]     everything stays in FOLDER; PAGE: that of script/test-wasm

Prints a row for each cell. A cell whose part is not installed or built is skipped with its reason; exit status 1 if one fails."""
import functools
import json
import os
import shutil
import subprocess
import sys
import zipfile
from pathlib import Path

HERE = Path(__file__).resolve().parent
sys.path[:0] = [str(HERE / "view"), str(HERE / "studio")]
import browser
import test_engine
from test_server import Studio

STOPS, WIDTH, PANEL, HEIGHT = 8, 64, "128x80", 180
ANGLES = f"{STOPS}x{360 // STOPS}"
LATER = 600  # seconds that a page may take where others work, too


class Lacking(Exception):
    """A part that is not there."""


def needed(condition, why):
    if not condition:
        raise Lacking(why)


class Parts:
    """Files of the parts, each written when a cell asks for it."""

    def __init__(self, program, folder, page):
        self.program, self.folder, self.page = program, folder, page

    def run(self, *words):
        done = subprocess.run([self.program, *map(str, words)], cwd=self.folder, capture_output=True, text=True)
        assert done.returncode == 0, f"ffprocams {words[0]}: {done.stderr.strip()[-600:]}"
        return done.stdout

    @functools.cached_property
    def python(self):
        try:
            import ffprocams
        except ImportError:
            raise Lacking("the Python package is not installed (script/test-python)") from None
        return ffprocams

    # --- The program. ---

    @functools.cached_property
    def rig(self):
        """Photographs with Gray codes, their patterns and the calibration, laid out as the guide says."""
        self.run("patterns", "-o", "rig/patterns", "--projector", PANEL)
        self.run("generate", "rig/shots", "--photographs", "rig/patterns", "--views", STOPS, "--attitudes", 0, "--split", "test", "--first", 15,
                 "--resolution", HEIGHT, "--sensor", "read=0.003")
        return self.folder / "rig"

    def imported(self, name, *options):
        truth = self.rig / "shots/truth.json"
        self.run("import", *(options or ("-c", truth, "-t", truth)), "--angles", ANGLES, "--shown", "rig/patterns", "-i", "rig/shots/view-{view}/*.png",
                 "-w", WIDTH, "-o", name)
        return self.folder / name

    @functools.cached_property
    def capture(self):
        return self.imported("capture")

    def made(self, capture, ply):
        self.run("reconstruct", capture, "--polish", 0, "-o", ply)
        return self.folder / ply

    @functools.cached_property
    def ply(self):
        return self.made(self.capture, "program.ply")

    @functools.cached_property
    def view(self):
        self.run("view", self.ply, "--capture", self.capture, "-o", "program.html")
        return self.folder / "program.html"

    # --- The studio. ---

    @functools.cached_property
    def studio(self):
        """Its folder after a simulated rig was photographed and its object made, by the requests of its page."""
        folder = self.folder / "studio"
        first = Studio(self.program, folder, "--virtual")
        needed("without the studio" not in first.error, "the program was built without the studio")
        first.stop()
        settings = json.loads((folder / "studio.json").read_text())
        settings["simulator"][settings["simulator"].index("--resolution") + 1] = str(HEIGHT)
        settings.update(projector=[int(side) for side in PANEL.split("x")], width=WIDTH, draft=True)
        (folder / "studio.json").write_text(json.dumps(settings))
        studio = Studio(self.program, folder, "--virtual")
        for request in ({"verb": "run", "step": "patterns"}, {"verb": "object", "name": "object", "stops": STOPS, "empty": False}):
            status, state = studio.do(**request)
            assert status == 200 and not state.get("error"), state
            studio.wait()
        for one in studio.state()["objects"][0]["sets"]:
            self.photograph(studio, one["name"])
        status, state = studio.do(verb="run", step="make")
        assert status == 200 and not state.get("error"), state
        studio.wait()
        studio.stop()
        return folder

    @staticmethod
    def photograph(studio, name):
        studio.do(verb="shoot", set=name)
        while active := studio.state()["active"]:
            if not active.get("next"):
                break
            studio.do(verb="take", set=name, number=active["next"]["number"])

    @property
    def of_studio(self):
        return self.studio / "objects/object"

    # --- Python. ---

    @functools.cached_property
    def python_capture(self):
        self.python.Capture.open(self.capture).save(self.folder / "python-capture")
        return self.folder / "python-capture"

    @functools.cached_property
    def python_ply(self):
        self.python.Gaussians.load(self.ply).save(self.folder / "python.ply")
        return self.folder / "python.ply"

    # --- The page that reconstructs. ---

    @functools.cached_property
    def engine(self):
        needed(self.page, "the page that reconstructs is not built (script/test-wasm)")
        needed(browser.find(), "there is no browser")
        page = test_engine.Page(browser.find())
        page.start(self.page)
        page.run("document.getElementById('polish').checked = false")
        return page

    def engine_takes(self, path):
        page = self.engine
        page.run("document.getElementById('result').hidden || document.getElementById('again').click()")
        return page.reconstruct(str(path), LATER)

    @functools.cached_property
    def of_engine(self):
        """The files that it saves of the program's capture."""
        self.engine_takes(self.capture)
        folder = self.folder / "engine"
        folder.mkdir(exist_ok=True)
        return {kind: Path(path) for kind, path in self.engine.save(["ply", "html", "spz", "glb"], str(folder)).items()}


# --- Readers. ---

def program_reads_capture(parts, path):
    assert "correspondence" in json.loads(Path(path, "scene.json").read_text())["views"][0]
    parts.run("info", path)
    parts.made(path, "again.ply")


def program_reads_splats(parts, path, capture=None):
    parts.run("view", path, "--capture", capture or parts.capture, "-o", "again.html")
    assert (parts.folder / "again.html").stat().st_size > 1e5


def python_reads_capture(parts, path):
    assert len(parts.python.Capture.open(path).view_ids) >= STOPS


def python_reads_splats(parts, path):
    assert len(parts.python.Gaussians.load(path)) > 100


def python_imports(parts, calibration):
    turntable = parts.python.Turntable(file=calibration, angles=[360 // STOPS * i for i in range(STOPS)])
    parts.python.import_capture(parts.folder / "python-import", calibration, images=parts.rig / "shots/view-{view}/*.png", shown=parts.rig / "patterns",
                                turntable=turntable, width=WIDTH)


def engine_reads(parts, path):
    assert parts.engine_takes(path)["psnr"] > 20


def engine_reads_zip(parts, path):
    archive = parts.folder / "capture.zip"
    with zipfile.ZipFile(archive, "w", zipfile.ZIP_DEFLATED) as file:
        for name in sorted(Path(path).rglob("*")):
            file.write(name, Path("capture") / name.relative_to(path))
    engine_reads(parts, archive)


def engine_makes(parts, path):
    """Photographs with Gray codes: it makes the capture, and reads it."""
    page = parts.engine
    page.run("document.getElementById('result').hidden || document.getElementById('again').click()")
    page.drop(str(path))
    page.wait("!document.getElementById('photographs').hidden || !document.getElementById('problem').hidden", LATER)
    page.run("for (const name of ['calibration', 'turntable']) document.getElementById(name).value = 'rig/shots/truth.json'")
    page.run(f"document.getElementById('width').value = {WIDTH}")
    page.run("document.querySelector('#photographs button').click()")
    page.wait("!document.getElementById('result').hidden || !document.getElementById('problem').hidden", LATER)
    assert page.run("document.getElementById('problem').hidden"), page.run("document.getElementById('why').textContent")


def browser_shows(parts, path, then=None):
    needed(browser.find(), "there is no browser")
    page = browser.Browser(browser.find(), 320, 240)
    try:
        page.open(str(path))
        page.wait("document.body && document.body.classList.contains('ready')", LATER)
        assert page.run("viewer.scene.views.length") >= STOPS
        if then:
            then(page)
    finally:
        page.close()


def stage_returns(page):
    text = page.run("(async () => { const before = await stageText(viewer); await loadStage(viewer, before); return await stageText(viewer) === before; })()")
    assert text is True, text


def other_programs_read(_, path):
    """The names and the size by which readers of 3DGS know a PLY."""
    head, _, rows = Path(path).read_bytes().partition(b"end_header\n")
    names = [line.split()[-1] for line in head.decode().splitlines() if line.startswith("property float")]
    count = int(head.decode().split("element vertex ")[1].split()[0])
    assert len(rows) == 4 * count * len(names) and {"x", "f_dc_0", "opacity", "scale_0", "rot_3"} <= set(names), names


def calibrated(parts):
    parts.run("calibrate", *[f"rig/shots/view-{360 // STOPS * i:03d}" for i in range(STOPS)], "--without-board", "--angles", ANGLES, "--shown", "rig/patterns",
              "-o", "calibration.xml", "--turntable-output", "axis.json")


def program_imports_calibrated(parts):
    calibrated(parts)
    parts.run("import", "-c", "calibration.xml", "-t", "axis.json", "--shown", "rig/patterns", "-i", "rig/shots/{view}/*.png", "-w", WIDTH, "-o", "calibrated")


def exported(parts, ending):
    parts.run("export", parts.ply, "--capture", parts.capture, "-o", f"program.{ending}")
    program_reads_splats(parts, parts.folder / f"program.{ending}")


CELLS = [
    ("photographs with codes", "program", "program", lambda p: program_reads_capture(p, p.capture)),
    ("photographs with codes", "program", "Python", lambda p: python_imports(p, p.rig / "shots/truth.json")),
    ("photographs with codes", "program", "page that reconstructs", lambda p: engine_makes(p, p.rig)),
    ("calibration and axis", "program", "program", program_imports_calibrated),
    ("capture with codes", "studio", "program", lambda p: program_reads_capture(p, p.of_studio / "capture")),
    ("capture with codes", "Python", "program", lambda p: program_reads_capture(p, p.python_capture)),
    ("capture with codes", "program", "Python", lambda p: python_reads_capture(p, p.capture)),
    ("capture with codes", "studio", "Python", lambda p: python_reads_capture(p, p.of_studio / "capture")),
    ("capture with codes", "program", "page that reconstructs", lambda p: engine_reads(p, p.capture)),
    ("capture with codes", "Python", "page that reconstructs", lambda p: engine_reads(p, p.python_capture)),
    ("the studio's folder", "studio", "page that reconstructs", lambda p: engine_reads(p, p.studio)),
    ("capture in a ZIP", "other programs", "page that reconstructs", lambda p: engine_reads_zip(p, p.capture)),
    ("PLY", "program", "program", lambda p: program_reads_splats(p, p.ply)),
    ("PLY", "program", "Python", lambda p: python_reads_splats(p, p.ply)),
    ("PLY", "program", "other programs", lambda p: other_programs_read(p, p.ply)),
    ("PLY", "studio", "program", lambda p: program_reads_splats(p, p.of_studio / "object.ply", p.of_studio / "capture")),
    ("PLY", "Python", "program", lambda p: program_reads_splats(p, p.python_ply)),
    ("PLY", "page that reconstructs", "program", lambda p: program_reads_splats(p, p.of_engine["ply"])),
    ("PLY", "page that reconstructs", "Python", lambda p: python_reads_splats(p, p.of_engine["ply"])),
    ("SPZ", "program", "program", lambda p: exported(p, "spz")),
    ("SPZ", "page that reconstructs", "program", lambda p: program_reads_splats(p, p.of_engine["spz"])),
    ("glTF", "program", "program", lambda p: exported(p, "glb")),
    ("glTF", "page that reconstructs", "program", lambda p: program_reads_splats(p, p.of_engine["glb"])),
    ("page", "program", "browser", lambda p: browser_shows(p, p.view)),
    ("page", "studio", "browser", lambda p: browser_shows(p, p.of_studio / "view.html")),
    ("page", "page that reconstructs", "browser", lambda p: browser_shows(p, p.of_engine["html"])),
    ("stage", "page", "page", lambda p: browser_shows(p, p.view, stage_returns)),
]


def main():
    program, folder = os.path.abspath(sys.argv[1]), Path(sys.argv[2]).resolve()
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    parts = Parts(program, folder, os.path.abspath(sys.argv[3]) if len(sys.argv) > 3 and os.path.exists(sys.argv[3]) else None)
    failed = 0
    for what, writer, reader, read in CELLS:
        try:
            read(parts)
            said = "ok"
        except Lacking as lacking:
            said = f"skipped: {lacking}"
        except Exception as error:  # a cell that fails is a row as well
            failed += 1
            said = f"FAILED: {type(error).__name__}: {error}"
        print(f"{what:24} {writer:24} {reader:24} {said}", flush=True)
    if "engine" in vars(parts):
        parts.engine.close()
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
