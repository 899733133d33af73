"""One table of all that was measured, as text, Markdown and JSON."""

import json
import os
import platform
import textwrap
from pathlib import Path
from typing import Any

HEAD = ["work", "program", "version", "build s", "frame ms", "Mrays/s", "× isoray", "peak MiB", "note"]

UNLIKE = 0.01
"""Share of pixels in which a surface may be hit by one program only, before the row is marked."""
COLOUR = 0.02
"""Mean difference of linear colour, from 0 to 1, of pixels that show anything of a volume, likewise."""

EXPLANATION = """\
*build*: all that is done once for a volume, or for an isovalue of it. isoray's includes reading the file, and serves all
isovalues; that of the others begins with the samples in memory (yt's, with the file). *frame*: median time of a picture, without build, reading or writing (isoray's: of two
medians, one before and one after the others). *Mrays/s*: pixels, hit or not, by that
time. *× isoray*: times as long as isoray's frame. *peak*: most memory that the process had resident, over all pictures
that it made; in brackets, what it had before it read any data: the interpreter and the program's modules. A row with ⚠
did not show the same as isoray."""


def processor() -> str:
    """Name of the machine's processor."""
    try:
        for line in Path("/proc/cpuinfo").read_text().splitlines():
            if line.startswith("model name"):
                return line.split(":", 1)[1].strip()
    except OSError:
        pass
    return platform.processor() or platform.machine()


def machine() -> dict[str, Any]:
    flags = Path("/proc/cpuinfo").read_text().split() if Path("/proc/cpuinfo").exists() else []
    simd = next((s for s, f in [("AVX-512", "avx512f"), ("AVX2", "avx2"), ("NEON", "asimd")] if f in flags), "unknown")
    return {"processor": processor(), "simd": simd, "cores": os.cpu_count(), "system": platform.platform()}


def compare(row: dict[str, Any]) -> tuple[bool, str | None]:
    """Whether a row shows what isoray shows, and what is to be said of it."""
    compared = row.get("compared")
    if compared is None:
        return True, None
    if row["kind"] == "isosurface":
        shares = f"{100 * compared['hit']:.2f} % hit, isoray {100 * compared['isoray_hit']:.2f} %"
        return compared["unlike"] <= UNLIKE, f"{shares}, unlike {100 * compared['unlike']:.3f} %"
    return compared["colour"] <= COLOUR, f"colour off by {compared['colour']:.4f}"


def finish(rows: list[dict[str, Any]]) -> None:
    """Adds to each row what follows from the others."""
    ours = {(r["work"], r["kind"]): r for r in rows if r["peer"] == "isoray" and "frame_ms" in r}
    for row in rows:
        reference = ours.get((row["work"], row["kind"]))
        if "frame_ms" in row:
            row["mrays_per_s"] = row["size"] ** 2 / row["frame_ms"] / 1000
            if reference is not None:
                row["ratio"] = row["frame_ms"] / reference["frame_ms"]
        row["agrees"], told = compare(row)
        row["agreement"] = "" if told is None else ("" if row["agrees"] else "⚠ ") + told


def cells(row: dict[str, Any], numbers: dict[str, int]) -> list[str]:
    """A line of the table. What many rows have to be said of gets a number."""

    def number(key: str, form: str) -> str:
        return format(row[key], form) if key in row else "–"

    peak = number("peak_mib", ".0f") if row.get("peak_mib") else "–"
    peak += f" ({row['before_mib']:.0f})" if "before_mib" in row else ""
    speed = [number("build_s", ".3f"), number("frame_ms", ".2f"), number("mrays_per_s", ".2f"), number("ratio", ".2f")]
    refer = "".join(f"[{numbers.setdefault(note, len(numbers) + 1)}]" for note in row["notes"])
    return [row["work"], row["program"], row["version"], *speed, peak, f"{row['agreement']} {refer}".strip()]


def markdown(rows: list[dict[str, Any]], settings: dict[str, Any]) -> str:
    numbers: dict[str, int] = {}
    lines = [
        "# isoray and its peers",
        "",
        title(settings),
        "",
        EXPLANATION.replace("\n", " "),
        "",
        "| " + " | ".join(HEAD) + " |",
        "|---|---|---|---:|---:|---:|---:|---:|---|",
    ]
    lines += ["| " + " | ".join(cell.replace("|", "\\|") for cell in cells(row, numbers)) + " |" for row in rows]
    lines += ["", *(f"- [{n}] {note}" for note, n in numbers.items())]
    return "\n".join(lines) + "\n"


def title(settings: dict[str, Any]) -> str:
    where = settings["machine"]
    machine = f"{where['processor']} ({where['simd']}, {where['cores']} cores), {where['system']}"
    busy = "" if settings["load"] is None else f", load {settings['load']:.2f} before"
    return f"{machine}{busy}; {settings['threads']} threads; medians of up to {settings['repeat']} pictures; {settings['date']}."


def text(rows: list[dict[str, Any]], settings: dict[str, Any]) -> str:
    """The table for a terminal."""
    numbers: dict[str, int] = {}
    shown = [HEAD, *(cells(row, numbers) for row in rows)]
    widths = [max(len(line[c]) for line in shown) for c in range(len(HEAD))]
    right = range(3, 8)
    body = [
        "  ".join(f"{c:>{w}}" if k in right else f"{c:<{w}}" for k, (c, w) in enumerate(zip(line, widths))).rstrip()
        for line in shown
    ]
    notes = [textwrap.fill(f"[{n}] {note}", 160, subsequent_indent="    ") for note, n in numbers.items()]
    return "\n".join([title(settings), "", *body, "", *notes])


def write(folder: Path, rows: list[dict[str, Any]], settings: dict[str, Any]) -> None:
    (folder / "peers.md").write_text(markdown(rows, settings), encoding="utf-8")
    (folder / "peers.json").write_text(json.dumps({**settings, "rows": rows}, indent=1) + "\n", encoding="utf-8")
