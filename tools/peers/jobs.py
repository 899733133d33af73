"""What is to be rendered, and the processes that do it: isoray, and one process for each peer and volume."""

import json
import os
import re
import subprocess
import sys
import threading
import time
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from environment import Environment

HERE = Path(__file__).resolve().parent

DIRECTIONS = {"far": (1.1, 0.9, 1.3), "close": (0.25, 0.2, 0.3)}
"""Where the eye is, seen from the centre of the volume, in lengths of its longest edge."""

BUDGET_S = 2.0
"""Seconds in which the pictures of a row should be made: of slow ones, fewer are."""
LEAST_REPEAT = 3

UNSTEADY = 1.2
"""How many times as long as the shortest frames may take before a row says that the machine had other things to do."""


@dataclass
class Subject:
    """A volume or an adaptive mesh, with what is asked of it."""

    name: str
    path: Path
    views: list[dict[str, Any]]
    isovalue: float | None = None
    transfer: Path | None = None
    field: str | None = None

    @property
    def slug(self) -> str:
        return re.sub(r"[^A-Za-z0-9]+", "-", self.name).strip("-").lower()


@dataclass
class Runner:
    """Runs programs and gathers rows of the table."""

    isoray: Path
    environment: Environment
    folder: Path
    threads: int
    repeat: int
    sizes: list[int]
    timeout: float
    rows: list[dict[str, Any]] = field(default_factory=list)

    def prepare(self, source: dict[str, Any], name: str) -> tuple[Path, dict[str, Any]]:
        """Makes the one file of a volume that all programs read. Returns it and its measures."""
        path = self.folder / f"{name}.nrrd"
        result, _peak, problem = self._work({"peer": "prepare", "source": source, "volume": str(path)}, f"{name}-prepare")
        if result is None:
            raise RuntimeError(problem)
        return path, result

    def proposed(self, path: Path) -> float:
        """The isovalue that isoray proposes."""
        stats = self.folder / "stats.json"
        picture = self.folder / "proposed.png"
        self._isoray(["render", str(path), "-o", str(picture), "--size", "16x16", "--stats", str(stats)])
        picture.unlink()
        return json.loads(stats.read_text())["isovalues"][0]

    def measure(self, subject: Subject, kind: str) -> None:
        """Renders a subject as 'isosurface', 'volume' or 'AMR volume' with all programs that can."""
        ours = self._isoray_rows(subject, kind)
        self.rows += ours
        if kind == "AMR volume":
            self._peer_rows(subject, kind, "yt", "yt")
        elif kind == "isosurface":
            self._peer_rows(subject, kind, "flying edges", "VTK flying edges")
            self._peer_rows(subject, kind, "embree", "Embree on a mesh")
            self._mitsuba_rows(subject, kind)
        if kind != "AMR volume":
            self._peer_rows(subject, kind, "fixed point", "VTK fixed-point ray caster")
        # Once more when all others are done: what the machine does beside this must not favour one of them
        for row, other in zip(ours, self._isoray_rows(subject, kind)):
            times = sorted([row["frame_ms"], other["frame_ms"]])
            row["frame_ms"] = sum(times) / 2
            if times[1] > UNSTEADY * times[0]:
                row["notes"].append(unsteady(times))

    def _mitsuba_rows(self, subject: Subject, kind: str) -> None:
        """Through the compiled variant, or where that fails (it needs a recent LLVM), the scalar one."""
        llvm = "Mitsuba sdfgrid, llvm"
        problem = self._peer_rows(subject, kind, "mitsuba", llvm, {"variant": "llvm_ad_rgb"}, tell=False)
        if problem is not None:
            scalar = "Mitsuba sdfgrid, scalar"
            note = "the faster variant failed here, which needs a shared library of LLVM 17 or later"
            self._peer_rows(subject, kind, "mitsuba", scalar, {"variant": "scalar_rgb"}, extra=note)

    def _names(self, subject: Subject, kind: str, view: dict, size: int) -> tuple[str, str]:
        where = f"{subject.slug}-{kind.replace(' ', '-').lower()}-{view['name']}-{size}"
        at = f" at {subject.isovalue:g}" if kind == "isosurface" else ""
        return where, f"{subject.name}, {kind}{at}, {view['name']}, {size}²"

    def _isoray_rows(self, subject: Subject, kind: str) -> list[dict[str, Any]]:
        self._say(subject, kind, "isoray")
        return [self._isoray_row(subject, kind, view, size) for view in subject.views for size in self.sizes]

    def _isoray_row(self, subject: Subject, kind: str, view: dict, size: int) -> dict[str, Any]:
        slug, work = self._names(subject, kind, view, size)
        stats = self.folder / "stats.json"
        camera = {f"--{k.replace('_', '-')}": ",".join(map(repr, view[k])) for k in ("eye", "look_at", "up")}
        flags = [f"{k}={v}" for k, v in camera.items()] + [f"--fov={view['fov']}", f"--size={size}x{size}"]
        if kind == "isosurface":
            flags.append(f"--isovalue={subject.isovalue!r}")
        else:
            flags += ["--volume", f"--tf={subject.transfer}", "--shading=none"]
        if subject.field is not None:
            flags.append(f"--field={subject.field}")
        picture = self.folder / f"{slug}-isoray.png"
        flags = ["-o", str(picture), *flags, "--transparent", f"--threads={self.threads}"]
        command = ["render", str(subject.path), *flags, "--stats", str(stats)]
        self._isoray(command)
        once = json.loads(stats.read_text())["render_s"]
        repeat = min(self.repeat, max(LEAST_REPEAT, int(BUDGET_S / once)))
        # The first picture warms up, and is among those that the median is of
        peak = self._isoray([*command, f"--repeat={repeat + 1}"])
        told = json.loads(stats.read_text())
        row = {"work": work, "kind": kind, "peer": "isoray", "program": "isoray", "version": self.version()}
        row |= {"view": view, "size": size, "build_s": told["open_s"] + told["build_s"], "frame_ms": 1000 * told["render_s"]}
        return row | {"peak_mib": peak, "picture": str(picture), "notes": []}

    def _peer_rows(
        self,
        subject: Subject,
        kind: str,
        peer: str,
        program: str,
        more: dict[str, Any] | None = None,
        extra: str | None = None,
        tell: bool = True,
    ) -> str | None:
        """Adds the rows of a peer, or with `tell`, one that says why there are none. Returns that reason, too."""
        frames = []
        if peer != "flying edges":
            for view in subject.views:
                for size in self.sizes:
                    slug, work = self._names(subject, kind, view, size)
                    picture = self.folder / f"{slug}-{peer.replace(' ', '-')}.png"
                    reference = self.folder / f"{slug}-isoray.png"
                    frames.append({"view": view, "size": size, "picture": str(picture), "reference": str(reference), "row": work})
        job = {"peer": peer, "work": kind, "volume": str(subject.path), "isovalue": subject.isovalue}
        job |= {"transfer": str(subject.transfer), "field": subject.field, "frames": frames, **(more or {})}
        self._say(subject, kind, program)
        problem = self.environment.lacks(peer)
        result, peak = None, None
        if problem is None:
            result, peak, problem = self._work(job, f"{subject.slug}-{kind.replace(' ', '-').lower()}-{peer.replace(' ', '-')}")
        at = f" at {subject.isovalue:g}" if kind == "isosurface" else ""
        shared = {"work": f"{subject.name}, {kind}{at}", "kind": kind, "peer": peer, "program": program, "version": "–"}
        if result is None:
            if tell:
                self.rows.append(shared | {"notes": [f"left out: {problem}"]})
            return problem
        notes = [*([extra] if extra else []), *result["notes"]]
        shared |= {"program": result["program"], "version": result["version"], "peak_mib": peak, "notes": notes}
        shared |= {"before_mib": result["before_mib"], "build_s": result["build_s"]}
        if not frames:
            self.rows.append(shared)
        for wanted, frame in zip(frames, result["frames"]):
            times = sorted(frame["all_ms"])
            spread = [unsteady(times)] if times[len(times) * 3 // 4] > UNSTEADY * times[0] else []
            self.rows.append({**shared, **frame, "work": wanted["row"], "notes": [*notes, *spread]})
        return None

    def version(self) -> str:
        ran = subprocess.run([str(self.isoray), "--version"], capture_output=True, text=True, check=True)
        return ran.stdout.split()[-1]

    def _work(self, job: dict[str, Any], name: str) -> tuple[dict[str, Any] | None, float | None, str | None]:
        """Runs a job in a process of its own. Returns its result and peak memory, or what went wrong."""
        file, out = self.folder / f"{name}.job.json", self.folder / f"{name}.out.json"
        shared = {"threads": self.threads, "repeat": self.repeat, "least_repeat": LEAST_REPEAT, "budget_s": BUDGET_S}
        file.write_text(json.dumps({**job, **shared, "out": str(out)}))
        out.unlink(missing_ok=True)
        code, peak, errors = run([str(self.environment.python), str(HERE / "worker.py"), str(file)], self.timeout)
        file.unlink()
        if code == 0 and out.exists():
            result = json.loads(out.read_text())
            out.unlink()
            return result, peak, None
        if code is None:
            return None, None, f"took more than {self.timeout:g} s (--timeout)"
        lines = [line for line in errors.splitlines() if line and not line.startswith(" ")]
        (self.folder / f"{name}.log").write_text(errors)
        return None, None, f"{(lines or ['no message'])[-1][:200]} (exit code {code}; all of it in {name}.log)"

    def _isoray(self, arguments: list[str]) -> float | None:
        code, peak, errors = run([str(self.isoray), *arguments], self.timeout)
        if code != 0:
            raise RuntimeError(f"{self.isoray} {' '.join(arguments)}\nexit code {code}: {errors.strip()}")
        return peak

    @staticmethod
    def _say(subject: Subject, kind: str, program: str) -> None:
        print(f"{subject.name}, {kind}: {program}", file=sys.stderr)


def unsteady(times: list[float]) -> str:
    return f"unsteady: {times[0]:.3g} to {times[-1]:.3g} ms"


def run(command: list[str], timeout: float) -> tuple[int | None, float | None, str]:
    """Runs a program. Returns its exit code (none if it was stopped), peak resident memory in MiB, and errors."""
    environment = {**os.environ, "PYTHONDONTWRITEBYTECODE": "1"}
    with subprocess.Popen(
        command, stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True, env=environment
    ) as process:
        code, peak, errors = None, None, ""
        try:
            if not hasattr(os, "wait4"):  # Windows
                errors = process.communicate(timeout=timeout)[1]
                return process.returncode, None, errors
            code, peak, errors = _wait(process, time.monotonic() + timeout)
        except subprocess.TimeoutExpired:
            process.kill()
        return code, peak, errors


def _wait(process: subprocess.Popen, deadline: float) -> tuple[int | None, float | None, str]:
    """Waits for a process, and finds its own peak of memory, which `subprocess` does not tell."""
    read: list[str] = []
    reader = threading.Thread(target=lambda: read.append(process.stderr.read()))
    reader.start()
    status, seen = None, 0.0
    while status is None:
        seen = max(seen, _resident_peak(process.pid))
        child, ended, usage = os.wait4(process.pid, os.WNOHANG)
        if child != 0:
            status = ended
        elif time.monotonic() > deadline:
            raise subprocess.TimeoutExpired(process.args, 0)
        else:
            time.sleep(0.01)
    process.returncode = os.waitstatus_to_exitcode(status)
    reader.join()
    peak = usage.ru_maxrss / (1 << 20 if sys.platform == "darwin" else 1 << 10)
    # A child begins with the peak of this script, so that less than that is known from looking now and then only
    if seen > 0 and peak <= _resident_peak(os.getpid()):
        peak = seen
    return process.returncode, peak, "".join(read)


def _resident_peak(pid: int) -> float:
    """Peak resident memory of a process in MiB, where Linux tells it, else 0."""
    try:
        status = Path(f"/proc/{pid}/status").read_text()
    except OSError:
        return 0.0
    return next((int(line.split()[1]) / 1024 for line in status.splitlines() if line.startswith("VmHWM")), 0.0)
