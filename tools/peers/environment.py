"""The virtual environment that peers run in, made from published wheels; the versions are those of requirements.txt."""

import hashlib
import json
import re
import subprocess
import sys
from pathlib import Path

NEEDED = {
    "flying edges": ["vtk"],
    "fixed point": ["vtk"],
    "embree": ["vtk", "embreex"],
    "mitsuba": ["mitsuba"],
    "yt": ["yt"],
}
"""Packages without which a peer cannot run."""

COMMON = ["numpy", "pillow"]
"""Packages without which no peer can run."""


class Environment:
    """A virtual environment, and why packages are missing in it."""

    def __init__(self, folder: Path, requirements: Path):
        self.python = folder / ("Scripts/python.exe" if sys.platform == "win32" else "bin/python")
        self.stamp = folder / "installed.json"
        self.requirements = requirements
        pinned = [line for line in requirements.read_text().splitlines() if line and not line.startswith("#")]
        state = hashlib.sha256("\n".join([sys.version, *pinned]).encode()).hexdigest()
        known = json.loads(self.stamp.read_text()) if self.stamp.exists() else {}
        if known.get("state") == state:
            self.missing: dict[str, str] = known["missing"]
            return
        print(f"making the environment {folder} (once; some 1.5 GB)", file=sys.stderr)
        subprocess.run([sys.executable, "-m", "venv", "--clear", str(folder)], check=True)
        self.missing = {}
        for line in pinned:
            reason = self._install(line)
            if reason is not None:
                self.missing[re.split("[=<>~!]", line)[0]] = reason
        lost = [name for name in COMMON if name in self.missing]
        if lost:
            raise RuntimeError(f"{requirements}: {lost[0]} could not be installed: {self.missing[lost[0]]}")
        self.stamp.write_text(json.dumps({"state": state, "missing": self.missing}))

    def _install(self, line: str) -> str | None:
        print(f"  {line}", file=sys.stderr)
        command = [str(self.python), "-m", "pip", "install", "--quiet", "--only-binary", ":all:"]
        ran = subprocess.run([*command, "-c", str(self.requirements), line], capture_output=True, text=True)
        if ran.returncode == 0:
            return None
        errors = [e for e in ran.stderr.splitlines() if e.startswith("ERROR")]
        print("\n".join(f"    {e}" for e in errors), file=sys.stderr)
        return f"pip found no wheel for Python {sys.version_info.major}.{sys.version_info.minor} here, or could not fetch it"

    def lacks(self, peer: str) -> str | None:
        """Why a peer cannot run, if so."""
        for package in NEEDED[peer]:
            if package in self.missing:
                return f"{package} not installed: {self.missing[package]}"
        return None
