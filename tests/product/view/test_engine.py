#!/usr/bin/env python3
"""The page that reconstructs (script/test-wasm) in a headless browser, with the network off: a capture dropped in,
reconstructed, shown and saved; photographs with a calibration; what the program makes of the same capture; what is refused.
Then the same page from a server that isolates it, with threads.

    test_engine.py PAGE CAPTURE CAPTURE-WITH-EXR-TRUTH FOLDER [PROGRAM]     screenshots and files stay in FOLDER

Exits with 77 and a line where there is no browser."""
import functools
import glob
import gzip
import http.server
import json
import os
import re
import shutil
import subprocess
import sys
import threading
import time
import zipfile

import browser

# dB on the photographs it was fitted to, between the page and the program. Moving the camera's centre by 1e-5 of a pixel changes the
# result by as much as 0.14 at any level (docs/design/portability.md), and their means over eight such moves by 0.02.
PSNR_MOST = 0.2

# Processor seconds of the page with all that the browser does, in those of the program on one thread at avx2. Measured: 2.6 to 3.4
# (docs/design/portability.md); a browser that draws all the time while the engine works had 6.
SECONDS_MOST = 5

# Of a function of the module with threads: wasm/openmp.c hands 18 (ARGUMENTS_MAX) of a region's variables on, behind two of its own.
PARAMETERS_MOST = 20


class Isolating(http.server.SimpleHTTPRequestHandler):
    """Serves a folder with what lets pages share memory among threads."""

    def end_headers(self):
        self.send_header("Cross-Origin-Opener-Policy", "same-origin")
        self.send_header("Cross-Origin-Embedder-Policy", "require-corp")
        super().end_headers()

    def log_message(self, *_):
        pass


def serve(folder):
    server = http.server.ThreadingHTTPServer(("127.0.0.1", 0), functools.partial(Isolating, directory=folder))
    threading.Thread(target=server.serve_forever, daemon=True).start()
    return server


def stat_of(folder):
    """Name, parent and processor seconds of a process or thread, from /proc; None: it has ended."""
    try:
        with open(f"{folder}/stat") as file:
            before, _, behind = file.read().rpartition(")")
    except OSError:
        return None
    fields = behind.split()
    return before.partition("(")[2], int(fields[1]), (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


def family_of(pid):
    """A process and all below it: processor seconds of each."""
    all_of_them = {int(name): stat for name in filter(str.isdigit, os.listdir("/proc")) if (stat := stat_of(f"/proc/{name}"))}
    family, more = {pid}, True
    while more:
        below = {child for child, (_, parent, _) in all_of_them.items() if parent in family} - family
        family, more = family | below, bool(below)
    return {one: all_of_them[one][2] for one in family if one in all_of_them}


def seconds_of(pid):
    return sum(family_of(pid).values())


def worker_seconds(pid):
    """Processor seconds of each worker of the browser's pages, most first: threads of that name."""
    stats = [stat_of(task) for one in family_of(pid) for task in glob.glob(f"/proc/{one}/task/*")]
    return sorted((seconds for name, _, seconds in filter(None, stats) if name.startswith("DedicatedWorker")), reverse=True)


class Page(browser.Browser):
    def start(self, page):
        self.open(page)
        self.wait("document.readyState == 'complete' && !!document.getElementById('small.safetensors')", 120)
        self.call("Network.emulateNetworkConditions", {"offline": True, "latency": 0, "downloadThroughput": 0, "uploadThroughput": 0})

    def drop(self, path):
        data = {"items": [], "files": [os.path.abspath(path)], "dragOperationsMask": 1}
        for kind in ("dragEnter", "dragOver", "drop"):
            self.call("Input.dispatchDragEvent", {"type": kind, "x": 400, "y": 300, "data": data})

    def reconstruct(self, path, seconds):
        self.drop(path)
        # Each look costs the browser some, and its seconds are measured.
        self.wait("!document.getElementById('result').hidden || !document.getElementById('problem').hidden", seconds, every=0.5)
        assert self.run("document.getElementById('problem').hidden"), self.run("document.getElementById('why').textContent")
        return json.loads(self.run("document.body.dataset.stats"))

    def refuses(self, path, why):
        self.run("document.getElementById('problem').hidden = true")
        self.drop(path)
        self.wait("!document.getElementById('problem').hidden", 300)
        said = self.run("document.getElementById('why').textContent")
        assert why in said, f"{path}: {said}"

    def save(self, kinds, folder):
        """The files that the buttons write, pressed without waiting for each other."""
        self.call("Browser.setDownloadBehavior", {"behavior": "allow", "downloadPath": folder}, session=None)
        before = set(os.listdir(folder))
        for kind in kinds:
            self.run(f"document.querySelector('[data-save={kind}]').click()")
        for _ in range(600):
            new = {name.rsplit(".", 1)[-1]: os.path.join(folder, name) for name in set(os.listdir(folder)) - before}
            if set(kinds) <= set(new):
                return new
            time.sleep(0.1)
        raise AssertionError(f"of {kinds} only {list(new)} were saved")


def native(program, capture, folder, threads):
    """The program's messages, processor seconds and MB; on x86-64 at avx2."""
    level = {"FFPROCAMS_CPU": "avx2"} if os.uname().machine == "x86_64" else {}
    child = subprocess.Popen([program, "reconstruct", capture, "-o", os.path.join(folder, "native.ply")],
                             env={**os.environ, "OMP_NUM_THREADS": str(threads), **level}, stdout=subprocess.PIPE,
                             stderr=subprocess.STDOUT, text=True)
    said = child.stdout.read()
    _, status, used = os.wait4(child.pid, 0)
    assert status == 0, said
    return said, used.ru_utime + used.ru_stime, used.ru_maxrss / 1e3


def zipped(capture, path):
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
        for folder, _, names in os.walk(capture):
            for name in names:
                whole = os.path.join(folder, name)
                archive.write(whole, os.path.relpath(whole, os.path.dirname(capture)))
    return path


def check_files(page, folder):
    # SPZ 2 is packed by gzip and begins with NGSP.
    magics = {"ply": b"ply\n", "html": b"<!doctype html>", "spz": b"NGSP", "glb": b"glTF\2\0\0\0"}
    saved = page.save(list(magics), folder)
    for kind, magic in magics.items():
        path = saved[kind]
        with (gzip.open if kind == "spz" else open)(path, "rb") as file:
            assert file.read(len(magic)) == magic, path
        print(f"saved {kind}: {os.path.getsize(path) / 1e6:.2f} MB")
    return os.path.join(folder, "sample.ply")


def check_refusals(page, folder):
    empty = os.path.join(folder, "no-scene")
    os.makedirs(empty, exist_ok=True)
    with open(os.path.join(empty, "a.txt"), "w") as file:
        file.write("nothing")
    page.refuses(empty, "\"no-scene\" is not a capture: there is no scene.json")
    page.refuses(os.path.join(empty, "a.txt"), "\"a.txt\" is one file")
    with open(os.path.join(folder, "bad.zip"), "wb") as file:
        file.write(b"PK\3\4" + bytes(100))
    page.refuses(os.path.join(folder, "bad.zip"), "not a ZIP file")
    broken = os.path.join(folder, "broken")
    os.makedirs(broken, exist_ok=True)
    with open(os.path.join(broken, "scene.json"), "w") as file:
        file.write("{\"views\": 3}")
    page.refuses(broken, "scene.json")


def check_fault(page, capture, folder):
    """Black and white exchanged in one view: the page shows it with its remedy, and whoever knows better goes on."""
    wrong = os.path.join(folder, "exchanged")
    shutil.copytree(capture, wrong)
    black, white = (os.path.join(wrong, f"path_0_theta135_all_{name}.png") for name in ("black", "white"))
    shutil.copy(os.path.join(capture, os.path.basename(white)), black)
    shutil.copy(os.path.join(capture, os.path.basename(black)), white)
    page.run("document.getElementById('again').click()")
    page.run("document.getElementById('polish').checked = false")
    page.refuses(wrong, "are exchanged")
    assert page.run("document.querySelector('#why .remedy').textContent") == "exchange their files"
    page.screenshot(os.path.join(folder, "fault.png"))
    page.run("document.getElementById('force').scrollIntoView()")
    assert not page.run("document.getElementById('force').hidden")
    page.run("document.getElementById('force').click()")
    page.wait("!document.getElementById('result').hidden", 900)
    page.screenshot(os.path.join(folder, "forced.png"))


def measured(page, capture):
    before = seconds_of(page.process.pid)
    stats = page.reconstruct(capture, 1800)
    stats["processor"] = round(seconds_of(page.process.pid) - before, 2)  # with the browser's
    print(f"page, threads: {page.run('document.body.dataset.threads')};", json.dumps(stats))
    return stats


def capture_made(page, picture):
    """The result's figures, of photographs whose form is filled in."""
    page.screenshot(picture)
    page.run("document.querySelector('#photographs button').click()")
    page.wait("!document.getElementById('result').hidden || !document.getElementById('problem').hidden", 900)
    assert page.run("document.getElementById('problem').hidden"), page.run("document.getElementById('why').textContent")
    return json.loads(page.run("document.body.dataset.stats"))


def check_patterns(page, folder):
    """Patterns of the size that is asked for, in a window of their own."""
    page.run("document.getElementById('own').open = true")
    page.screenshot(os.path.join(folder, "own.png"))
    page.run("window.open = () => (window.opened = {close() {}}); document.getElementById('projector').value = '320x200'; document.getElementById('draw').click()")
    page.wait("!!window.opened.location && document.getElementById('work').hidden", 120)
    assert page.run("window.opened.location.startsWith('blob:') && document.getElementById('panel').value") == "320x200"
    page.run("document.getElementById('projector').value = '320'; document.getElementById('draw').click()")
    page.wait("!document.getElementById('problem').hidden", 60)
    assert page.run("document.getElementById('why').textContent.startsWith('--projector takes width x height')"), page.run("document.getElementById('why').textContent")
    page.run("document.getElementById('own').open = false")


def from_disk(page, program, capture, with_truth, folder):
    page.screenshot(os.path.join(folder, "start.png"))
    check_patterns(page, folder)
    check_refusals(page, folder)
    stats = measured(page, capture)
    assert page.run("document.body.dataset.threads") == "1"
    assert page.run("!!document.querySelector('#notes [data-code=clipped]')")
    page.wait("document.getElementById('viewer').contentDocument?.body?.classList.contains('ready')", 600)
    time.sleep(5)  # until it has drawn
    page.screenshot(os.path.join(folder, "result.png"))
    page.run("document.getElementById('checks').click()")
    page.screenshot(os.path.join(folder, "checks.png"))
    assert "explains the pictures" in page.run("document.getElementById('checks-text').textContent")
    page.run("document.getElementById('checks-dialog').close()")
    check_files(page, folder)
    check_fault(page, capture, folder)
    page.run("document.getElementById('again').click()")
    page.run("document.getElementById('polish').checked = false")
    again = page.reconstruct(zipped(with_truth, os.path.join(folder, "with_truth.zip")), 900)
    print("page, a ZIP file, without polish:", json.dumps(again))
    assert "no EXR or TIFF: depth (" in page.run("document.getElementById('notes').textContent")
    if program:
        check_photographs(page, program, folder)
        check_codes_alone(page, program, folder)
    return stats


def check_codes_alone(page, program, folder):
    """Photographs under Gray codes and nothing else: no board, no calibration, no patterns beside them; the program gets the same."""
    rig = os.path.join(folder, "codes")
    patterns, shots = os.path.join(folder, "drawn"), os.path.join(rig, "shots")
    for command in (["patterns", "-o", patterns, "--projector", "320x200"],
                    ["generate", shots, "--photographs", patterns, "--split", "test", "--first", "3", "--views", "8", "--attitudes", "0",
                     "--resolution", "240", "--sensor", "read=0.003"]):
        subprocess.run([program, *command], check=True, capture_output=True)
    for name in os.listdir(shots):
        if not name.startswith("view-"):
            path = os.path.join(shots, name)
            shutil.rmtree(path) if os.path.isdir(path) else os.remove(path)
    page.run("document.getElementById('again').click()")
    page.drop(rig)
    page.wait("!document.getElementById('photographs').hidden || !document.getElementById('problem').hidden", 300)
    assert page.run("[document.getElementById('calibration').value, document.getElementById('shown').value].join()") == ","
    assert page.run("document.getElementById('angles').value") == "0,45,90,135,180,225,270,315"
    page.run("document.getElementById('panel').value = '320x200'")
    stats = capture_made(page, os.path.join(folder, "codes.png"))
    print("page, codes alone:", json.dumps(stats))
    subprocess.run([program, "scan", *(os.path.join(shots, f"view-{45 * i:03d}") for i in range(8)), "--angles", "8x45", "--projector", "320x200", "-w", "128",
                    "-o", os.path.join(folder, "scanned"), "--to", "import"], check=True, capture_output=True)
    done = subprocess.run([program, "reconstruct", os.path.join(folder, "scanned", "capture"), "-o", os.path.join(folder, "scanned.ply"), "--polish", "0"],
                          check=True, capture_output=True, text=True)
    found = float(re.search(r"([\d.]+) dB on its photographs", done.stdout)[1])
    print(f"program, codes alone: {found} dB")
    assert abs(stats["psnr"] - found) < PSNR_MOST, stats


def check_photographs(page, program, folder):
    """Photographs of a simulated rig with its calibration, laid out as docs/guide/own-rig.md says."""
    rig = os.path.join(folder, "rig")
    patterns, shots = os.path.join(rig, "patterns"), os.path.join(rig, "shots")
    for command in (["patterns", "-o", patterns, "--projector", "256x160", "--only", "capture"],
                    ["generate", shots, "--photographs", patterns, "--split", "test", "--first", "15", "--views", "8", "--attitudes", "0",
                     "--resolution", "160", "--sensor", "read=0.003"]):
        subprocess.run([program, *command], check=True, capture_output=True)
    page.run("document.getElementById('again').click()")
    page.drop(rig)
    page.wait("!document.getElementById('photographs').hidden || !document.getElementById('problem').hidden", 300)
    assert page.run("document.getElementById('images').value") == "rig/shots/view-{view}/*.png"
    assert page.run("document.getElementById('angles').value") == "0,45,90,135,180,225,270,315"
    page.run("for (const name of ['calibration', 'turntable']) document.getElementById(name).value = 'rig/shots/truth.json'")
    stats = capture_made(page, os.path.join(folder, "photographs.png"))
    print("page, photographs:", json.dumps(stats))
    assert stats["psnr"] > 25, stats


def with_page(source, checks):
    page = Page(browser.find(), arguments=["--js-flags=--max-old-space-size=4096"])
    try:
        page.start(source)
        stats = checks(page)
        asked = [url for url in page.requests if not url.startswith(("file:", "blob:", "data:", source))]
        assert not asked, asked
        assert not [line for line in page.console if "exception" in line or line.startswith("error")], page.console
    finally:
        page.close()
    return stats


class Reader:
    """Numbers and names of a WebAssembly file (core specification, 5)."""

    def __init__(self, data, at=0):
        self.data, self.at = data, at

    def number(self):
        value = shift = 0
        while True:
            byte = self.data[self.at]
            value, shift, self.at = value | (byte & 127) << shift, shift + 7, self.at + 1
            if byte < 128:
                return value

    def name(self):
        size = self.number()
        self.at += size
        return self.data[self.at - size:self.at].decode(errors="replace")

    def skip(self, numbers):
        for _ in range(numbers):
            self.number()


def sections(data):
    """{number, or name of a custom one: its Reader}"""
    found, reader = {}, Reader(data, 8)
    while reader.at < len(data):
        kind, size = reader.number(), reader.number()
        part = Reader(data, reader.at)
        found[part.name() if kind == 0 else kind] = part
        reader.at += size
    return found


def functions(found):
    """How many parameters each function of an object file has, those that it imports first."""
    types, imports, own = found[1], found.get(2), found[3]
    parameters, numbers = [], []
    for _ in range(types.number()):
        types.at += 1  # 0x60
        parameters.append(types.number())
        types.at += parameters[-1]
        results = types.number()
        types.at += results
    for _ in range(imports.number() if imports else 0):
        imports.name(), imports.name()
        kind = imports.number()
        if kind == 0:
            numbers.append(imports.number())
        elif kind in (1, 2):  # a table (with its type) or a memory, with limits
            imports.at += kind == 1
            imports.skip(1 + (imports.number() & 1))
        else:
            imports.skip(2)
    return [parameters[number] for number in numbers + [own.number() for _ in range(own.number())]]


def regions(data):
    """The parameters of the functions that are an object's parallel regions (conventions for linking: the table of symbols)."""
    found = sections(data)
    if 3 not in found or "linking" not in found:
        return []
    counts, reader = functions(found), found["linking"]
    reader.skip(1)
    while reader.number() != 8:
        size = reader.number()
        reader.at += size
    reader.skip(1)
    most = []
    for _ in range(reader.number()):
        kind, flags = reader.number(), reader.number()
        if kind == 1:  # data
            reader.name()
            reader.skip(0 if flags & 0x10 else 3)
            continue
        index = reader.number()
        name = reader.name() if kind != 3 and (not flags & 0x10 or flags & 0x40) else ""
        if kind == 0 and "omp_outlined" in name:
            most.append(counts[index])
    return most


def check_regions(source):
    """Every region of the engine fits into what wasm/openmp.c hands on; a larger one would end the page."""
    objects = glob.glob(os.path.join(os.path.dirname(source), "threads", "**", "*.o"), recursive=True)
    found = []
    for name in objects:
        with open(name, "rb") as file:
            data = file.read()
        found += regions(data) if data.startswith(b"\0asm") else []
    print(f"{len(found)} regions of at most {max(found, default=0)} parameters")
    assert not objects or len(found) > 50 and max(found) <= PARAMETERS_MOST


def isolated(source, capture):
    server = serve(os.path.dirname(source))

    def checks(page):
        assert page.run("crossOriginIsolated")
        stats = measured(page, capture)
        assert page.run("Number(document.body.dataset.threads)") == os.cpu_count()
        busy = worker_seconds(page.process.pid)
        print("processor seconds of its workers:", busy)
        assert len(busy) > 1 and busy[1] > busy[0] / 4, busy
        return stats

    return with_page(f"http://127.0.0.1:{server.server_port}/{os.path.basename(source)}", checks)


def main():
    source, capture, with_truth, folder = (os.path.abspath(path) for path in sys.argv[1:5])
    program = os.path.abspath(sys.argv[5]) if len(sys.argv) > 5 else None
    if not browser.find():
        print("skipped: there is no Chromium")
        return 77
    shutil.rmtree(folder, ignore_errors=True)
    os.makedirs(folder)
    size = os.path.getsize(source)
    print(f"the page has {size / 1e6:.1f} MB")
    assert size < 25e6
    check_regions(source)
    stats = with_page(source, lambda page: from_disk(page, program, capture, with_truth, folder))
    figures = [("one thread", 1, stats)]
    if os.cpu_count() > 1:
        figures.append(("threads", os.cpu_count(), isolated(source, capture)))
    single = 0
    for name, threads, stats in figures if program else ():
        said, seconds, megabytes = native(program, capture, folder, threads)
        single = single or seconds
        psnr = float(re.search(r"([0-9.]+) dB", said).group(1))
        print(f"program, {name}: {psnr} dB, {seconds:.2f} s of processor, {megabytes:.0f} MB")
        assert abs(psnr - stats["psnr"]) < PSNR_MOST, (psnr, stats["psnr"])
        assert stats["processor"] < SECONDS_MOST * single, (stats["processor"], single)
    print("passed")
    return 0


if __name__ == "__main__":
    sys.exit(main())
