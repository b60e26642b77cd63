"""The documents' tables of figures, by the names of their blocks (script/measure): functions from docs/lab/measured.json to Markdown."""

PAGES = ["README.md", "docs/lab/results.md", "docs/design/performance.md", "docs/reference/python.md", "docs/lab/applications.md"]
SPARED = {"docs/lab/applications.md"}  # has tables of PSNR outside of blocks too
NUMBERS = {1: "one", 2: "two", 4: "four", 8: "eight", 16: "sixteen"}
PAPER = [[35.76, 0.9829, 0.0174], [32.36, 0.9611, 0.0349], [32.49, 0.9575, 0.0308]]  # FF-ProCams, its tables: PSNR, SSIM, LPIPS
TABLES = {}


def block(function):
    TABLES[function.__name__.replace("_", "-")] = function
    return function


def cell(value, digits=2):
    """A figure, or several as "a / b / c"; what has not been measured is empty."""
    if value is None or value == []:
        return ""
    if isinstance(value, list):
        return " / ".join(cell(v, digits) or "–" for v in value)
    return f"{value:,}" if isinstance(value, int) else f"{value:,.{digits}f}"


def mean(values):
    return sum(values) / len(values)


def table(head, rows):
    """Columns in which nothing has been measured are left out."""
    kept = [i for i in range(len(head)) if i == 0 or any(str(row[i]) for row in rows)]
    lines = [[line[i] for i in kept] for line in (head, ["---"] * len(head), *rows)]
    return "\n".join("|" + "|".join(f" {c} " if c != "---" else c for c in map(str, line)).replace("|  |", "| |") + "|" for line in lines).replace("|  |", "| |")


def program(figures, parts, timed=False, level=True):
    """The program of parts {name: what the table calls them}, once if they are of one; with the machine where seconds count."""
    by = {}
    for part, label in parts.items():
        of = figures[part]
        name = of["program"] + (f", {of['commit']}" if of["commit"] else "")
        if timed:
            name += f", {NUMBERS.get(of['threads'], of['threads'])} {of['machine']} core{'s' * (of['threads'] > 1)}" + f", `{of['level']}`" * level
        by.setdefault(name, []).append(label)
    if len(by) == 1:
        return next(iter(by))
    return "; ".join(f"{' and '.join(labels)}: {name}" for name, labels in by.items())


# --- README and results: quality. ---

PREDICTORS = {"start": "classical start", "fit": "classical start and fit", "before": "network, before its looks", "network": "network",
              "shipped": "**as shipped**"}


def of_both(f):
    return f"{f['scenes']['count']} scenes of our generator's test split and four objects rendered by Blender's Cycles"


@block
def readme(f):
    labels = PREDICTORS | {"start": "classical start, without a network", "network": "network alone: 8 blocks of width 256", "shipped": "**network and fit, as shipped**"}
    rows = [["FF-ProCams paper: 24 blocks, RTX 3090", cell([p[0] for p in PAPER]), ""]]
    rows += [[labels[who], cell(f["scenes"][who]), cell(f["captures"][who])] for who in labels if who != "before"]
    return (f"PSNR in dB over the full frame, {of_both(f)}.\n"
            f"Program {program(f, {'scenes': 'test scenes', 'captures': 'Cycles'})}; the paper's data is not public, so its row is of other pictures:\n\n"
            + table(["rendering / novel pattern / novel pose", "test scenes", "Cycles"], rows))


@block
def readme_seconds(f):
    best = f["times"]["level"]
    whole, alone = (f["times"]["rows"][f"{best} {steps}"]["wall"] for steps in ("auto", "0"))
    return f"`reconstruct` takes {cell(whole, 1)} s, {cell(alone, 1)} s without the fit (program {program(f, {'times': ''}, timed=True)})."


@block
def readme_real(f):
    return f"{cell(f['real']['rows']['hasselt 240'][3], 1)} and {cell(f['real']['rows']['skull 422'][3], 1)} dB"


REAL = {"shell 256": "shell, 256 wide", "hasselt 240": "ceramics, 240 wide", "hasselt 480": "ceramics, 480 wide", "skull 422": "skull, 422 wide"}


@block
def readme_photographs(f):
    rows = [[REAL[name], *(cell(f["real"]["rows"][name][i]) for i in (0, 2, 3, 4))] for name in ("shell 256", "hasselt 240", "skull 422")]
    return (f"PSNR in dB, as shipped, program {program(f, {'real': ''})}; no fit saw the held-back stripes:\n\n"
            + table(["", "white", "given stripes", "held-back stripes", "the worst of these"], rows))


@block
def in_short(f):
    return (f"PSNR over the full frame, {of_both(f)}; program {program(f, {'scenes': 'test scenes', 'captures': 'Cycles'})}:\n\n"
            + table(["", "test scenes", "Cycles"], [[label, cell(f["scenes"][who]), cell(f["captures"][who])] for who, label in PREDICTORS.items()]))


@block
def quality(f):
    q = f["quality"]

    def of(who):
        return [f"{cell(q[who]['psnr'][i])} / {cell(q[who]['ssim'][i], 4)} / {cell(q[who]['lpips'][i], 4) or '–'}" for i in range(3)]

    rows = [["FF-ProCams paper: 24 blocks", *(f"{cell(p)} / {cell(s, 4)} / {cell(lpips, 4)}" for p, s, lpips in PAPER)],
            ["network: 8 blocks of width 256", *of("network")], ["**as shipped**", *of("shipped")],
            *([label, *map(cell, q[who]["psnr_foreground"])] for who, label in (("network", "network, object's pixels"), ("shipped", "as shipped, object's pixels")))]
    return (f"{q['count']} scenes, {q['pictures']:,} pictures, PSNR / SSIM / LPIPS, program {program(f, {'quality': ''})}.\n"
            "The paper's data is not public, so its row is of other pictures:\n\n" + table(["", "rendering", "novel pattern", "novel pose"], rows)
            + f"\n\nAt new poses the best scene has {cell(q['best'], 1)} dB, the median {cell(q['median'], 1)} and the worst {cell(q['worst'], 1)}.")


@block
def highlights(f):
    gloss = f["quality"]["shipped"]["psnr_gloss"]
    return (f"Pixels with a marked specular part reach {cell(gloss[0], 1)} dB at the input poses and {cell(gloss[2], 1)} at new ones "
            f"({f['quality']['count']} scenes, {program(f, {'quality': ''})}).")


@block
def truth(f):
    keys = ("depth_lit_median", "depth_lit_p90", "depth_unlit_median", "depth_unlit_p90")
    rows = [[label, *(cell(f["quality"][who][key]) for key in keys), cell(f["quality"][who]["albedo_mse"], 5)]
            for who, label in (("network", "network"), ("shipped", "as shipped"))]
    return (f"Depth as drawn at the input poses, in per cent of the object's radius, and mean squared error of linear albedo over the object's pixels, "
            f"{f['quality']['count']} scenes, program {program(f, {'quality': ''})}:\n\n"
            + table(["", "lit: median", "90th percentile", "unlit: median", "90th percentile", "albedo"], rows))


@block
def each(f):
    rows = [[{"suzanne_free": "Suzanne, 12 hand-held views"}.get(name, name.capitalize()), cell(psnr, 1)] for name, psnr in f["each"]["rows"].items()]
    return f"The Cycles captures one by one, as shipped, program {program(f, {'each': ''})}:\n\n" + table(["", "as shipped"], rows)


@block
def photographs(f):
    rows = [[REAL[name], *map(cell, figures)] for name, figures in f["real"]["rows"].items()]
    return f"Full frame, program {program(f, {'real': ''})}:\n\n" + table(["", "white", "black", "given stripes", "held-back stripes", "the worst of these", "these, where lit"], rows)


@block
def walks(f):
    return f"{f['walks']['count']} scenes of a walking camera, eight places, 128 x 96 pixels, full frame, have {cell(f['walks']['psnr'])} dB, program {program(f, {'walks': ''})}."


@block
def rooms(f):
    kinds = ("white", "held", "turns")
    rows = [[f"{f['rooms']['count']} generated rooms (362 x 272)", *(cell(f["rooms"][k]) for k in kinds)], ["the path-traced room", *(cell(f["room"][k]) for k in kinds)]]
    return (f"Objects on a turntable in a room, masked by photographs of the empty stage, object's pixels / full frame, "
            f"program {program(f, {'rooms': 'generated', 'room': 'path-traced'})}:\n\n" + table(["", "white, at the stops", "held-out pictures", "new turns"], rows))


@block
def without_board(f):
    kinds = [f["board"][kind] for kind in ("walks", "turntables")]

    def of(figure, key, digits, unit=""):
        return [cell(figure([v for v in kind[key] if v is not None]), digits) + unit for kind in kinds]

    lost = [max(a - b for a, b in zip(kind["true"], kind["found"]) if b is not None) for kind in kinds]
    rows = [["refused", *(kind["found"].count(None) for kind in kinds)], ["focal length of the camera, largest error", *of(max, "camera", 2, " %")], ["of the projector", *of(max, "projector", 2, " %")],
            ["PSNR with the calibration found", *of(mean, "found", 2)], ["with the true one", *of(mean, "true", 2)], ["the most that a rig loses", *map(cell, lost)]]
    return f"Program {program(f, {'board': ''})}:\n\n" + table(["", "walks", "turntables"], rows)


@block
def sizes(f):
    rows = [[size, cell(of["psnr"]), cell(of["gaussians"], 0), cell(of["ply_mb"], 1 if of["ply_mb"] < 10 else 0)] for size, of in f["sizes"]["rows"].items()]
    return (f"Eight views, means over {f['sizes']['count']} scenes of the test split (0, 25, ..), each made at its size, "
            f"program {program(f, {'sizes': ''})}:\n\n" + table(["size", "as shipped", "Gaussians", "PLY, MB"], rows))


@block
def views(f):
    v = f["views"]
    rows = [[count, cell(of["psnr"]), cell(v["free"][count]["psnr"]), cell(of["peak_gb"])] for count, of in v["turntable"].items()]
    return (f"Numbers of views at 128 x 128, {v['count']} scenes, on a turntable and on free rigs, program {program(f, {'views': ''})}; "
            "peak memory is of the turntable:\n\n" + table(["views", "turntable", "free", "peak GB"], rows))


@block
def steps(f):
    rows = [[f"**{steps}**" if steps == "72" else steps, cell(of["seconds"]), cell(of["psnr"])] for steps, of in f["steps"]["rows"].items()]
    return (f"Means of the four Cycles captures, program {program(f, {'steps': ''}, timed=True)}"
            + ("; seconds of one reconstruction" if any(of["seconds"] for of in f["steps"]["rows"].values()) else "") + ":\n\n"
            + table(["steps", "seconds", "as shipped"], rows))


@block
def faults(f):
    rows = [[name, *(cell(v, 1) for v in figures)] for name, figures in f["faults"]["rows"]]
    return (f"The first {f['faults']['count']} test scenes, generated again with a fault of the devices, reconstructed from these pictures and poses, and scored against "
            f"faultless pictures at faultless poses (`bench/faults`), program {program(f, {'faults': ''})}:\n\n"
            + table(["", "network: input poses", "new poses", "as shipped: input poses", "new poses"], rows))


@block
def rig(f):
    r = f["rig"]
    return (f"`bench/rig_faults` puts {r['faults']} faults into the sample, one at a time: devices turned, moved, exchanged or in wrong units, wrong calibrations and angles, "
            "views and pictures turned, mirrored or exchanged, lamps, exposure, masks, patterns.\n"
            f"The checks name {r['named']} of them, with the view where there is one: {r['refused']} are refused, and {r['noted']}, which people must judge, are noted "
            f"(program {program(f, {'rig': ''})}).\n"
            f"They take up to {r['ms']} ms of processor time on eight views, and at most {r['sound_ms']} ms without fault: both samples, {r['captures']} captures by Cycles and "
            f"{r['scenes']} test scenes.")


@block
def compensation(f):
    c = f["compensation"]
    return (f"Program {program(f, {'compensation': ''})}:\n\n"
            + table(["capture", "unwarped", "closed form", "30 steps of descent"], [[name, *(cell(v, 1) for v in figures)] for name, figures in c["rows"].items()])
            + f"\n\nThe least gain over unwarped in any of the {c['cases']} cases is {cell(c['least'], 1)} dB.")


# --- Performance. ---


@block
def seconds(f):
    rows = f["times"]["rows"]
    levels = dict.fromkeys(way.split()[0] for way in rows)
    return (f"`reconstruct data/sample`, the whole command, medians of {f['times']['runs']} runs in turns, program {program(f, {'times': ''}, timed=True, level=False)}:\n\n"
            + table(["level", "wall s", "processor s", "wall s without the fit"],
                    [[f"`{level}`", cell(rows[f"{level} auto"]["wall"]), cell(rows[f"{level} auto"]["processor"]), cell(rows.get(f"{level} 0", {}).get("wall"))] for level in levels]))


@block
def large(f):
    rows = [[name, *(cell(of.get(key), digits) for key, digits in (("seconds", 1), ("polish", 1), ("peak_gb", 2)))] for name, of in f["large"]["rows"].items()]
    return f"Larger captures, medians of {f['large']['runs']} runs, program {program(f, {'large': ''}, timed=True)}:\n\n" + table(["capture", "seconds", "of these the polish", "peak GB"], rows)


def ms(value):
    return cell(value, 0 if value >= 100 else 1 if value >= 10 else 2)


def by_level(f, kind, cells):
    """A column (or more) for each level."""
    levels = f["kernels"]["levels"].values()
    names = dict.fromkeys(name for of in levels for name in of[kind])
    return [[name, *(cells(of[kind][name]) if name in of[kind] else "" for of in levels)] for name in names]


@block
def kernels(f):
    levels = f["kernels"]["levels"]
    fma = ", ".join(f"{of['peaks']['fp32_fma_gflops']:.0f} at `{level}`" for level, of in levels.items() if of["peaks"]["fp32_fma_gflops"])
    copied = ", ".join(f"{of['peaks']['copy_gbs']:.0f} at `{level}`" for level, of in levels.items())
    pairs = ", ".join(f"{of['peaks']['bf16_tile_gflops']:.0f} at `{level}`" for level, of in levels.items() if "bf16" in level)
    return (f"`ffprocams bench`, the faster of two runs, program {program(f, {'kernels': ''}, timed=True, level=False)}.\n"
            f"Peaks in GFLOP/s: multiply-adds in fp32 from registers {fma}; products in pairs of bf16 {pairs}; GB/s copied: {copied}.\n"
            "Products, attention and the scan are shares of the arithmetic peak; the others are shares of their run's copy rate, which arrays in cache exceed.\n\n"
            + table(["kernel: ms, share of the peak", *(f"`{level}`" for level in levels)], by_level(f, "kernels", lambda v: f"{ms(v[0])}, {v[1] * 100:.0f} %"))
            + "\n\n" + table(["step: ms", *(f"`{level}`" for level in levels)], by_level(f, "steps", ms)))


@block
def splats(f):
    return (f"131,072 splats, one per pixel of eight views of 128 x 128, drawn into a ninth under one pattern with the settings of `ffp_render_defaults`; "
            f"ms forward and backward, program {program(f, {'kernels': ''}, timed=True, level=False)}:\n\n"
            + table(["deviation, opacity", *(f"`{level}`" for level in f["kernels"]["levels"])], by_level(f, "splats", lambda v: f"{ms(v[0])}; {ms(v[1])}")))


@block
def cores(f):
    c = f["cores"]
    return (f"`bench/cores.py` predicts them from a run in which every parallel region is recorded ({c['regions']:,} of them), with what lies between regions and a wait for each "
            f"call.\n`reconstruct data/sample`, program {program(f, {'cores': ''}, timed=True)}:\n\n"
            + table(["threads", "seconds", "times as fast as one"], [[name, cell(s), cell(fast, 1)] for name, (s, fast) in c["rows"].items()]))


@block
def memory(f):
    return (f"Peak on `data/sample`, program {program(f, {'memory': ''})}:\n\n"
            + table(["command", "MB"], [[f"`{name}`", cell(mb, 0)] for name, mb in f["memory"]["rows"].items()]))
