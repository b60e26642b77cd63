#!/usr/bin/env python3
"""Makes a folder of pictures for `ffprocams generate --materials` and `--patterns`, and for training (`materials`,
`material_share`, `patterns`, `pattern_share`), out of photographs that Debian's packages ship under free licences.

    script/fetch_materials.py OUT [--packages FOLDER] [--side 768] [--each 6]

Downloads the packages (74 MB in all; they are not installed, and root is not needed), or takes them from a folder of
.deb files, and cuts each photograph into squares, reduced to SIDE pixels. OUT is written completely or not at all.
OUT/licences.txt lists every picture with its package and version, the file that it was cut from, licence and holders;
the packages' own copyright files, with the licences' text, are beside it. Needs apt-get, dpkg-deb and python3-pil.
"""

import argparse
import fnmatch
import pathlib
import subprocess
import sys
import tempfile

# Package, the folder of its photographs, and how its copyright file calls that folder.
PACKAGES = [
    ("lomiri-wallpapers-16.04", "usr/share/backgrounds", "16.04"),
    ("lomiri-wallpapers-20.04", "usr/share/backgrounds", "20.04"),
    ("mate-backgrounds", "usr/share/backgrounds/mate/nature", "nature"),
]
FREE = ("CC0-1.0", "CC-BY-4.0", "CC-BY-SA-3.0", "CC-BY-SA-4.0", "GPL-2+", "GPL-3+", "Expat")


def fail(what, where):
    sys.exit(f"fetch_materials.py: error: {where}: {what}")


def run(*command, cwd=None):
    done = subprocess.run(command, cwd=cwd, capture_output=True, text=True, check=False)
    if done.returncode:
        fail((done.stderr.strip().splitlines() or ["failed"])[-1], " ".join(command[:3]))
    return done.stdout


def package_file(name, folder, work):
    """The package's .deb, from the folder or downloaded."""
    if folder is None:
        run("apt-get", "download", name, cwd=work)
    found = sorted((work if folder is None else folder).glob(f"{name}_*.deb"))
    if not found:
        fail("the package is not among the files", name)
    return found[-1]


def paragraphs(text):
    """Those of a Debian copyright file: fields by name, with their lines joined."""
    for block in text.split("\n\n"):
        fields, last = {}, None
        for line in block.splitlines():
            if line[:1].isspace() and last:
                fields[last] += "\n" + line.strip()
            elif ":" in line:
                last, _, value = line.partition(":")
                fields[last] = value.strip()
        if "Files" in fields:
            yield fields


def licence_of(text, name, where):
    """Licence and holders of a file: the last paragraph whose patterns match it, as the format says."""
    found = None
    for fields in paragraphs(text):
        if any(fnmatch.fnmatchcase(name, pattern) for pattern in fields["Files"].split()):
            found = fields
    if found is None:
        fail("the copyright file says nothing about it", where)
    licence = found.get("License", "").splitlines()[0]
    if licence not in FREE:
        fail(f"its licence, {licence!r}, is not among those that were looked at", where)
    return licence, "; ".join(found.get("Copyright", "").splitlines())


def squares(image, each):
    """Up to `each` squares side by side, as large as fit."""
    width, height = image.size
    columns = max(1, round((each * width / height) ** 0.5))
    rows = max(1, each // columns)
    side = min(width // columns, height // rows)
    for i in range(columns * rows):
        x = (i % columns) * (width - side) // max(1, columns - 1) if columns > 1 else (width - side) // 2
        y = (i // columns) * (height - side) // max(1, rows - 1) if rows > 1 else (height - side) // 2
        yield image.crop((x, y, x + side, y + side))


def fetch(out, options, work):
    try:
        from PIL import Image
    except ImportError:
        fail("is needed (Debian: python3-pil)", "PIL")
    lines = []
    for name, folder, called in PACKAGES:
        deb = package_file(name, options.packages, work)
        root = work / name
        run("dpkg-deb", "-x", str(deb), str(root))
        version = run("dpkg-deb", "-f", str(deb), "Version").strip()
        copyright_file = root / "usr/share/doc" / name / "copyright"
        text = copyright_file.read_text(encoding="utf-8")
        (out / f"copyright_{name}.txt").write_text(text, encoding="utf-8")
        for file in sorted((root / folder).glob("*.jpg")):
            if file.is_symlink():
                continue
            licence, holders = licence_of(text, f"{called}/{file.name}", f"{name}: {file.name}")
            with Image.open(file) as image:
                for i, square in enumerate(squares(image.convert("RGB"), options.each)):
                    made = f"{file.stem.lower()}_{i}.jpg"
                    square.resize((options.side, options.side), Image.LANCZOS).save(out / made, quality=95)
                    lines.append(f"{made}\t{name} {version}\t{file.name}\t{licence}\t{holders}\n")
    (out / "licences.txt").write_text("".join(lines), encoding="utf-8")
    return len(lines)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("out", type=pathlib.Path, help="new folder")
    parser.add_argument("--packages", type=pathlib.Path, help="folder of .deb files; default: they are downloaded")
    parser.add_argument("--side", type=int, default=768, help="of the pictures, pixels (768)")
    parser.add_argument("--each", type=int, default=6, help="squares of a photograph, at most (6)")
    options = parser.parse_args()
    if options.out.exists():
        fail("already exists", options.out)
    if not 64 <= options.side <= 4096 or not 1 <= options.each <= 64:
        fail("--side must be in 64..4096, --each in 1..64", "arguments")
    options.out.parent.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory(dir=options.out.parent, prefix=".materials-") as scratch:
        work, ready = pathlib.Path(scratch), pathlib.Path(scratch) / "ready"
        ready.mkdir()
        count = fetch(ready, options, work)
        ready.rename(options.out)
    print(f"{options.out}: {count} pictures; licences.txt says whose they are")


if __name__ == "__main__":
    main()
