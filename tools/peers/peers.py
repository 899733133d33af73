#!/usr/bin/env python3
"""Measures isoray beside other programs that render scalar volumes on CPUs, in one run, on the same volumes and views.

README.md beside this file tells what is compared and what is not. Needs Python 3.11 or later, and nothing but it: the
other programs are installed into an environment of their own.
"""

import argparse
import datetime
import os
import subprocess
import sys
from pathlib import Path

if sys.version_info < (3, 11):
    sys.exit("peers.py needs Python 3.11 or later")

sys.dont_write_bytecode = True

import report
from environment import Environment
from jobs import DIRECTIONS, HERE, Runner, Subject

ROOT = HERE.parents[1]

ISOVALUES = {
    "tooth": 600.0,
    "csafe_heptane": 42.0,
    "visible_human_head": 25.0,
    "lidc_0314": -400.0,
    "cranium_256x256x108_i16le": -300.0,
    "stent": 0.15,
    "nucleon_41x41x41_u8": 90.0,
}
"""Isovalues of well-known volumes, by the name of the file; of others, isoray proposes one."""

MARSCHNER_LOBB = 127.5
"""Isovalue of the generated volume: the middle of its range."""


def arguments() -> argparse.Namespace:
    parser = argparse.ArgumentParser(description=__doc__.split("\n\n")[0])
    parser.add_argument("volumes", nargs="*", metavar="FILE[@ISOVALUE]", help="more volumes: .nrrd, .nhdr, NAME_XxYxZ_u8.raw")
    parser.add_argument("--isoray", type=Path, metavar="PROGRAM", help="default: target/release/isoray, built if missing")
    parser.add_argument("--data", type=Path, metavar="DIR", help="more volumes, from here (default: ../shared/data, if there)")
    parser.add_argument("--no-data", action="store_true", help="only the volumes that are named, and the two that always are")
    parser.add_argument("--amr", type=Path, action="append", default=[], metavar="PLOTFILE", help="AMReX plotfile; may be repeated (default: a generated one)")
    parser.add_argument("--amr-field", default="density", metavar="NAME", help="its field (default: density)")
    layers = ROOT / "fixtures/transfer/clumps.toml"
    parser.add_argument("--amr-tf", type=Path, default=layers, metavar="FILE", help="its transfer function")
    parser.add_argument("--amr-eye", type=vector, default=[1.6, 1.4, 1.8], metavar="X,Y,Z", help="its view (default: 1.6,1.4,1.8)")
    parser.add_argument("--amr-look-at", type=vector, default=[0.5, 0.5, 0.5], metavar="X,Y,Z", help="(default: 0.5,0.5,0.5)")
    parser.add_argument("--sizes", type=numbers, default=[512, 1024], metavar="N,N", help="edges of the pictures (default: 512,1024)")
    parser.add_argument("--work", default="isosurface,volume,amr", help="what is compared (default: all three)")
    parser.add_argument("--views", default="far,close", help="of the volumes: far, close, or both (the default)")
    parser.add_argument("--marschner-lobb", type=int, default=256, metavar="N", help="size of the generated volume (default: 256)")
    parser.add_argument("--threads", type=int, default=len(processors()), metavar="N", help="default: all cores")
    parser.add_argument("--repeat", type=int, default=7, metavar="N", help="pictures that a median is of, at least 3 of slow ones (default: 7)")
    parser.add_argument("--timeout", type=float, default=900, metavar="S", help="seconds after which a program is given up (default: 900)")
    args = parser.parse_args()
    args.views, args.work = args.views.split(","), args.work.split(",")
    works = ["isosurface", "volume", "amr"]
    for flag, given, known in [("--views", args.views, [*DIRECTIONS]), ("--work", args.work, works)]:
        if unknown := [g for g in given if g not in known]:
            parser.error(f"{flag} {unknown[0]}: there are {', '.join(known)}")
    if not 1 <= args.threads <= len(processors()):
        parser.error(f"--threads {args.threads}: from 1 to {len(processors())} here")
    if args.repeat < 1:
        parser.error(f"--repeat {args.repeat}: at least 1")
    for plotfile in args.amr:
        if not (plotfile / "Header").is_file():
            parser.error(f"--amr {plotfile}: not the folder of a plotfile")
    if args.data is not None and not args.data.is_dir():
        parser.error(f"--data {args.data}: not a folder")
    if args.isoray is not None and not args.isoray.is_file():
        parser.error(f"--isoray {args.isoray}: not a file")
    return args


def vector(text: str) -> list[float]:
    parts = [float(p) for p in text.split(",")]
    if len(parts) != 3:
        raise argparse.ArgumentTypeError("three numbers, like 1.6,1.4,1.8")
    return parts


def numbers(text: str) -> list[int]:
    return [int(p) for p in text.split(",")]


def processors() -> list[int]:
    """Numbers of the cores that this process may use."""
    if hasattr(os, "sched_getaffinity"):
        return sorted(os.sched_getaffinity(0))
    return list(range(os.cpu_count() or 1))


def program(given: Path | None) -> Path:
    if given is not None:
        return given.resolve()
    name = "isoray.exe" if sys.platform == "win32" else "isoray"
    built = Path(os.environ.get("CARGO_TARGET_DIR", ROOT / "target")) / "release" / name
    subprocess.run(["cargo", "build", "--release", "--locked", "-p", "isoray", "--bin", "isoray"], cwd=ROOT, check=True)
    return built


def clumps(folder: Path) -> Path:
    """The adaptive mesh of the benchmarks as a plotfile, made once."""
    plotfile = folder / "clumps 4"
    if not plotfile.exists():
        writer = ["cargo", "run", "--quiet", "--release", "--locked", "-p", "isoray-benches", "--example", "clumps"]
        subprocess.run([*writer, "--", str(plotfile)], cwd=ROOT, check=True)
    return plotfile


def sources(args: argparse.Namespace) -> list[tuple[str, dict, float | None]]:
    """Name, origin and isovalue of each volume."""
    found: list[tuple[str, dict, float | None]] = [
        ("tooth", {"file": str(ROOT / "fixtures/tooth/tooth.nrrd")}, ISOVALUES["tooth"]),
        (f"Marschner-Lobb {args.marschner_lobb}", {"marschner_lobb": args.marschner_lobb}, MARSCHNER_LOBB),
    ]
    names = {"tooth"}
    files = [Path(v.rpartition("@")[0] or v) for v in args.volumes]
    given = [float(v.rpartition("@")[2]) if "@" in v else None for v in args.volumes]
    data = args.data or ROOT.parent / "shared/data"
    if data.is_dir() and not args.no_data:
        layouts = [p for s in ("*.nrrd", "*.nhdr", "*_*x*x*_*.raw") for p in sorted((data / "volumes").glob(f"**/{s}"))]
        files += layouts
        given += [None] * len(layouts)
    for path, isovalue in zip(files, given):
        if path.stem not in names:
            names.add(path.stem)
            found.append((path.stem, {"file": str(path)}, ISOVALUES.get(path.stem) if isovalue is None else isovalue))
    return found


def subject(runner: Runner, views: list[str], name: str, source: dict, isovalue: float | None) -> Subject:
    path, told = runner.prepare(source, name.lower().replace(" ", "-"))
    isovalue = runner.proposed(path) if isovalue is None else isovalue
    edge, center = max(told["extent"]), [x / 2 for x in told["extent"]]
    placed = []
    for view in views:
        eye = [c + edge * d for c, d in zip(center, DIRECTIONS[view])]
        placed.append({"name": view, "eye": eye, "look_at": center, "up": [0.0, 1.0, 0.0], "fov": 45.0})
    transfer = ROOT / "fixtures/transfer/tooth.toml"
    if name != "tooth":
        transfer = runner.folder / f"{path.stem}.toml"
        transfer.write_text(transfer_around(isovalue, told["least"], told["greatest"], edge))
    return Subject(name, path, placed, isovalue, transfer)


def transfer_around(isovalue: float, least: float, greatest: float, length: float) -> str:
    """A transfer function: clear up to 15 % of the range below the isovalue, and dense at the greatest value.

    Along `length`, the isovalue alone would let a fiftieth of the light through.
    """
    foot = isovalue - 0.15 * (greatest - least)
    points = [(foot, "#2a4d8f", 0.0), (isovalue, "#58b5a0", 4.0 / length), (greatest, "#f08a3c", 30.0 / length)]
    return "\n".join(f'[[points]]\nvalue = {v!r}\ncolor = "{c}"\nextinction = {e!r}\n' for v, c, e in points)


def main() -> None:
    args = arguments()
    isoray = program(args.isoray)
    folder = ROOT / "target/peers"
    folder.mkdir(parents=True, exist_ok=True)
    environment = Environment(folder / "venv", HERE / "requirements.txt")
    meshes = [] if "amr" not in args.work else args.amr or [clumps(folder)]
    if hasattr(os, "sched_setaffinity"):  # inherited by all programs, so that none has more threads than the others
        os.sched_setaffinity(0, processors()[:args.threads])
    load = os.getloadavg()[0] if hasattr(os, "getloadavg") else None
    if load is not None and load > 0.3:
        print(f"the machine is busy (load {load:.2f}): times will be worth little", file=sys.stderr)
    runner = Runner(isoray, environment, folder, args.threads, args.repeat, args.sizes, args.timeout)
    kinds = [kind for kind in ("isosurface", "volume") if kind in args.work]
    for name, source, isovalue in sources(args) if kinds else []:
        try:
            made = subject(runner, args.views, name, source, isovalue)
        except RuntimeError as problem:
            print(f"{source.get('file', name)}: left out: {problem}", file=sys.stderr)
            continue
        for kind in kinds:
            runner.measure(made, kind)
    view = {"name": "given", "eye": args.amr_eye, "look_at": args.amr_look_at, "up": [0.0, 1.0, 0.0], "fov": 45.0}
    for plotfile in meshes:
        made = Subject(plotfile.resolve().name, plotfile.resolve(), [view], None, args.amr_tf.resolve(), args.amr_field)
        runner.measure(made, "AMR volume")
    report.finish(runner.rows)
    settings = {"machine": report.machine(), "threads": args.threads, "repeat": args.repeat, "load": load}
    settings["date"] = datetime.date.today().isoformat()
    report.write(folder, runner.rows, settings)
    print(report.text(runner.rows, settings))
    print(f"\n{folder / 'peers.md'}, peers.json, and a picture of each row, *.png", file=sys.stderr)


if __name__ == "__main__":
    try:
        main()
    except (RuntimeError, subprocess.CalledProcessError) as problem:
        sys.exit(f"peers.py: {problem}")
