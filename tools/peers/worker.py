"""Runs one peer on one volume in a process of its own: `python worker.py JOB.json`, which names the file for the result.

Runs inside the virtual environment. What a job holds is made by `jobs.py`.
"""

import importlib
import json
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

import scene

PEERS = {
    "flying edges": ("peer_vtk", "extract"),
    "fixed point": ("peer_vtk", "ray_cast"),
    "embree": ("peer_embree", "trace"),
    "mitsuba": ("peer_mitsuba", "trace"),
    "yt": ("peer_yt", "render"),
}
"""Module and function of each peer. The function takes a job, with the volume, and returns a `Result`."""

Frame = Callable[[], tuple[np.ndarray, np.ndarray]]


class Peer:
    """What a peer tells, and how it is timed."""

    def __init__(self, job: dict[str, Any], program: str, version: str):
        self.job = job
        self.result: dict[str, Any] = {"program": program, "version": version, "notes": [], "frames": []}
        # Memory of the interpreter and the peer's modules, before any data
        self.result["before_mib"] = peak_mib()

    def note(self, text: str) -> None:
        self.result["notes"].append(text)

    def build(self, step: Callable[[], Any]) -> Any:
        """Does a step of the preparation, whose time adds to that of the build."""
        start = time.perf_counter()
        made = step()
        self.result["build_s"] = self.result.get("build_s", 0.0) + time.perf_counter() - start
        return made

    def frames(self, prepare: Callable[[dict, int], tuple[Callable[[], Any], Callable[[Any], Any]]]) -> None:
        """Times the frames of all views and sizes.

        `prepare` gets a view and a size, and returns what renders (timed) and what makes linear premultiplied colour
        and alpha, top row first, of the last that was rendered (not timed).
        """
        for wanted in self.job["frames"]:
            render, develop = prepare(wanted["view"], wanted["size"])
            render()  # warm-up: compilers, caches, pages
            times: list[float] = []
            enough = min(self.job["repeat"], self.job["least_repeat"])
            while len(times) < enough or (len(times) < self.job["repeat"] and sum(times) < 1000 * self.job["budget_s"]):
                start = time.perf_counter()
                image = render()
                times.append(1000 * (time.perf_counter() - start))
            scene.save_picture(wanted["picture"], *develop(image))
            frame = {"view": wanted["view"]["name"], "size": wanted["size"], "frame_ms": float(np.median(times))}
            frame["all_ms"] = [round(t, 3) for t in times]
            frame["picture"] = wanted["picture"]
            if Path(wanted["reference"]).exists():
                frame["compared"] = scene.compare(wanted["picture"], wanted["reference"])
            self.result["frames"].append(frame)


def peak_mib() -> float:
    """Peak resident memory of this process so far, MiB."""
    try:
        import resource
    except ImportError:  # not on Windows
        return 0.0
    unit = 1 << 20 if sys.platform == "darwin" else 1 << 10
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * unit / (1 << 20)


def main() -> None:
    job = json.loads(Path(sys.argv[1]).read_text())
    if job["peer"] == "prepare":
        result = prepare(job)
    else:
        module, function = PEERS[job["peer"]]
        result = getattr(importlib.import_module(module), function)(job).result
    Path(job["out"]).write_text(json.dumps(result))


def prepare(job: dict[str, Any]) -> dict[str, Any]:
    """Writes the volume of a job as all programs read it, and tells its measures."""
    source = job["source"]
    volume = scene.marschner_lobb(source["marschner_lobb"]) if "marschner_lobb" in source else None
    volume = volume or scene.read_volume(Path(source["file"]))
    scene.write_nrrd(Path(job["volume"]), volume)
    finite = volume.samples[np.isfinite(volume.samples)]
    return {
        "dims": volume.samples.shape[::-1],
        "type": str(volume.samples.dtype),
        "extent": volume.extent().tolist(),
        "least": float(finite.min()),
        "greatest": float(finite.max()),
    }


if __name__ == "__main__":
    main()
