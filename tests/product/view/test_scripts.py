#!/usr/bin/env python3
"""The pages' scripts as TypeScript's compiler reads them (Debian: node-typescript), all scripts of a page together, since they share
one scope: names that nothing declares or two scripts do, calls with too many or too few arguments, assignments to constants, code
that is never reached, switches that fall through.

    test_scripts.py [TSC]

Exits with 77 and a line where there is no tsc."""
import re
import shutil
import subprocess
import sys
from pathlib import Path

HERE = Path(__file__).resolve().parent
VIEW = HERE.parents[2] / "view"
PAGES = ("page", "engine", "studio", "studio_projector")
# Members of objects and elements, whose types plain scripts do not say.
UNTYPED = {"TS2339", "TS2345", "TS2349", "TS2538", "TS2551", "TS2322", "TS2740", "TS2769", "TS2367", "TS2365", "TS2362", "TS2363"}


def scripts(page):
    return re.findall(r'<script src="([a-z_.]+)"></script>', (VIEW / f"{page}.html").read_text(encoding="utf-8"))


def faults(tsc, names):
    """Of scripts that share a scope."""
    command = [tsc, "--noEmit", "--allowJs", "--checkJs", "--target", "es2022", "--lib", "es2022,dom,dom.iterable", "--skipLibCheck",
               "--allowUnreachableCode", "false", "--allowUnusedLabels", "false", "--noFallthroughCasesInSwitch",
               str(HERE / "browser.d.ts"), *(str(VIEW / name) for name in names)]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    output = done.stdout or (done.stderr or "tsc failed") * bool(done.returncode)
    found = re.findall(r"^(\S+): error (TS\d+): (.*)$", output, re.MULTILINE)
    if not found and output.strip():
        return [output.strip()]
    return [f"{Path(where.split('(')[0]).name}({where.split('(')[1]}: {text}" for where, code, text in found if code not in UNTYPED]


def hidden(names):
    """Functions that two scripts declare, of which the later one hides the other: the compiler allows it."""
    declared = {}
    for name in names:
        for function in re.findall(r"^(?:async )?function (\w+)", (VIEW / name).read_text(encoding="utf-8"), re.MULTILINE):
            declared.setdefault(function, []).append(name)
    return [f"{function}: declared by {' and '.join(places)}" for function, places in declared.items() if len(places) > 1]


def main():
    tsc = sys.argv[1] if len(sys.argv) > 1 else shutil.which("tsc")
    if not tsc:
        print("skipped: tsc is not installed (Debian: node-typescript)")
        return 77
    failed = False
    for page in PAGES:
        names = scripts(page)
        found = faults(tsc, names) + hidden(names)
        print(f"{page}: {len(names)} scripts, {len(found)} faults", *found, sep="\n  ")
        failed |= bool(found) or not names
    return int(failed)


if __name__ == "__main__":
    sys.exit(main())
