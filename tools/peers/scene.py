"""What all peers share: the volume, the transfer function, the rays of a camera, pictures and what they are compared by.

Runs inside the virtual environment (needs numpy and Pillow).
"""

import gzip
import math
import re
import tomllib
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from PIL import Image

NRRD_TYPES = {
    "u1": ("uchar", "unsigned char", "uint8", "uint8_t"),
    "i1": ("signed char", "int8", "int8_t"),
    "u2": ("ushort", "unsigned short", "unsigned short int", "uint16", "uint16_t"),
    "i2": ("short", "short int", "signed short", "signed short int", "int16", "int16_t"),
    "f4": ("float",),
    "f8": ("double",),
}
"""Types of samples that are read, as NumPy and as NRRD call them."""

RAW_NAME = re.compile(r"_(\d+)x(\d+)x(\d+)_([uif])(8|16|32)(le|be)?$")
"""What the name of a headerless file must end with, like `_41x41x41_u8` or `_256x256x108_i16le`."""


@dataclass
class Volume:
    """Samples with axes z, y, x; sample (i, j, k) lies at (i, j, k) times the spacing in world space."""

    samples: np.ndarray
    spacing: tuple[float, float, float]

    def extent(self) -> np.ndarray:
        """World coordinates of the last sample."""
        return (np.array(self.samples.shape[::-1]) - 1) * np.array(self.spacing)


def read_volume(path: Path) -> Volume:
    """Reads an NRRD (raw or gzip, attached or detached) or a headerless file whose name tells its layout."""
    if path.suffix in (".nrrd", ".nhdr"):
        return _read_nrrd(path)
    layout = RAW_NAME.search(path.stem)
    if path.suffix != ".raw" or layout is None:
        raise ValueError(f"{path}: neither NRRD nor a name like volume_256x256x108_i16le.raw")
    x, y, z, kind, bits, endian = layout.groups()
    dtype = np.dtype(f"{'>' if endian == 'be' else '<'}{kind}{int(bits) // 8}")
    return _shaped(path, path.read_bytes(), dtype, (int(x), int(y), int(z)), (1.0, 1.0, 1.0))


def _read_nrrd(path: Path) -> Volume:
    content = path.read_bytes()
    head = re.match(rb"NRRD\d{4}\r?\n(.*?)(?:\r?\n\r?\n|\Z)", content, re.DOTALL)
    if head is None:
        raise ValueError(f"{path}: does not begin as an NRRD does")
    fields: dict[str, str] = {}
    for line in head[1].decode("utf-8", "replace").splitlines():
        if ": " in line and not line.startswith("#"):
            key, value = line.split(": ", 1)
            fields[key.strip().lower()] = value.strip()
    code = next((c for c, names in NRRD_TYPES.items() if fields.get("type") in names), None)
    if code is None or fields.get("dimension") != "3":
        raise ValueError(f"{path}: only 3 dimensions of {', '.join(NRRD_TYPES)} are read")
    detached = fields.get("data file", fields.get("datafile"))
    body = content[head.end():] if detached is None else (path.parent / detached).read_bytes()
    encoding = fields.get("encoding", "raw")
    if encoding in ("gzip", "gz"):
        body = gzip.decompress(body)
    elif encoding != "raw":
        raise ValueError(f"{path}: encoding {encoding} is not read")
    if "spacings" in fields:
        spacing = [float(s) for s in fields["spacings"].split()]
    else:
        rows = re.findall(r"\(([^)]*)\)", fields.get("space directions", ""))
        spacing = [math.hypot(*(float(c) for c in row.split(","))) for row in rows] or [1.0, 1.0, 1.0]
    spacing = [s if math.isfinite(s) and s > 0 else 1.0 for s in spacing]
    dtype = np.dtype(code).newbyteorder(">" if fields.get("endian") == "big" else "<")
    return _shaped(path, body, dtype, tuple(int(n) for n in fields["sizes"].split()), tuple(spacing))


def _shaped(path: Path, body: bytes, dtype: np.dtype, dims: tuple[int, ...], spacing: tuple[float, ...]) -> Volume:
    if len(body) < math.prod(dims) * dtype.itemsize:
        raise ValueError(f"{path}: {len(body)} bytes are too few for {dims} samples of {dtype}")
    samples = np.frombuffer(body, dtype, math.prod(dims)).reshape(dims[::-1])
    samples = samples.astype("f4" if dtype.kind == "f" else dtype.newbyteorder("="))
    return Volume(samples, spacing)


def write_nrrd(path: Path, volume: Volume) -> None:
    """Writes what all programs read: uncompressed, little-endian, with the spacing and no other placement."""
    name = NRRD_TYPES[volume.samples.dtype.str[1:]][0]
    header = (
        f"NRRD0004\ntype: {name}\ndimension: 3\nsizes: {' '.join(map(str, volume.samples.shape[::-1]))}\n"
        f"spacings: {' '.join(map(repr, volume.spacing))}\nendian: little\nencoding: raw\n\n"
    )
    little = np.ascontiguousarray(volume.samples, volume.samples.dtype.newbyteorder("<"))
    path.write_bytes(header.encode() + little.tobytes())


def marschner_lobb(n: int) -> Volume:
    """The test signal of Marschner and Lobb (1994) on n³ samples, from 0 to 255; f_M = 6, alpha = 0.25."""
    axis = np.linspace(-1.0, 1.0, n)
    z, y, x = axis[:, None, None], axis[None, :, None], axis[None, None, :]
    rho = np.cos(2 * np.pi * 6 * np.cos(0.5 * np.pi * np.sqrt(x * x + y * y)))
    value = (1 - np.sin(0.5 * np.pi * z) + 0.25 * (1 + rho)) / (2 * (1 + 0.25))
    return Volume(np.rint(255 * value).astype("u1"), (1.0, 1.0, 1.0))


def srgb_to_linear(c: np.ndarray) -> np.ndarray:
    return np.where(c <= 0.04045, c / 12.92, ((c + 0.055) / 1.055) ** 2.4)


def linear_to_srgb(c: np.ndarray) -> np.ndarray:
    c = np.clip(c, 0.0, 1.0)
    return np.where(c <= 0.0031308, c * 12.92, 1.055 * c ** (1 / 2.4) - 0.055)


@dataclass
class Transfer:
    """Control points: values (ascending; two alike are a step), linear colours, extinctions per unit of length."""

    values: np.ndarray
    colors: np.ndarray
    extinctions: np.ndarray

    def at(self, value: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Colours (last axis) and extinctions at values."""
        color = np.stack([np.interp(value, self.values, self.colors[:, c]) for c in range(3)], axis=-1)
        return color, np.interp(value, self.values, self.extinctions)


def read_transfer(path: Path) -> Transfer:
    """Reads isoray's transfer functions, as far as they are points in the data's own units."""
    file = tomllib.loads(path.read_text())
    if file.get("normalized") or "colormap" in file:
        raise ValueError(f"{path}: normalized values and colour maps are not read")
    colors, extinctions = [], []
    for point in file["points"]:
        color = point["color"]
        if isinstance(color, str):
            rgb = np.array([int(color[i:i + 2], 16) / 255 for i in (1, 3, 5)])
        else:
            rgb = np.array(color, float)
        linear = file.get("color_space") == "linear" and not isinstance(color, str)
        colors.append(rgb if linear else srgb_to_linear(rgb))
        if "extinction" in point:
            extinctions.append(point["extinction"])
        else:
            extinctions.append(-math.log1p(-point["opacity"]) / file["unit_distance"])
    values = np.array([p["value"] for p in file["points"]], float)
    return Transfer(values, np.array(colors), np.array(extinctions, float))


def camera_axes(view: dict) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Unit vectors forward, right and up of a view."""
    forward = np.array(view["look_at"], float) - np.array(view["eye"], float)
    forward /= np.linalg.norm(forward)
    right = np.cross(forward, np.array(view["up"], float))
    right /= np.linalg.norm(right)
    return forward, right, np.cross(right, forward)


def camera_basis(view: dict) -> np.ndarray:
    """Rows such that a pixel at (u, v), from -1 to 1, v upwards, of a square picture has direction b0 + u b1 + v b2."""
    forward, right, up = camera_axes(view)
    slope = math.tan(math.radians(view["fov"]) / 2)
    return np.array([forward, right * slope, up * slope])


def save_picture(path: str, premultiplied: np.ndarray, alpha: np.ndarray) -> None:
    """Writes linear premultiplied colour (grey or RGB, top row first) as an sRGB PNG with transparency."""
    if premultiplied.ndim == 2:
        premultiplied = np.repeat(premultiplied[:, :, None], 3, axis=2)
    straight = premultiplied / np.maximum(alpha, 1e-6)[:, :, None]
    rgba = np.dstack([linear_to_srgb(straight), np.clip(alpha, 0.0, 1.0)])
    Image.fromarray(np.rint(rgba * 255).astype("u1"), "RGBA").save(path)


def compare(path: str, reference: str) -> dict[str, float]:
    """How a picture differs from isoray's.

    `hit` and `isoray_hit`: shares of pixels with alpha of at least one half; `unlike`: share in which just one has;
    `colour`: mean difference of linear premultiplied colour over the pixels that either shows anything at.
    """
    a, b = (np.asarray(Image.open(p).convert("RGBA"), float) / 255 for p in (path, reference))
    hit_a, hit_b = a[:, :, 3] >= 0.5, b[:, :, 3] >= 0.5
    lit = (a[:, :, 3] > 0) | (b[:, :, 3] > 0)
    light_a, light_b = (srgb_to_linear(p[:, :, :3]) * p[:, :, 3:] for p in (a, b))
    colour = np.abs(light_a - light_b)[lit].mean() if lit.any() else 0.0
    return {"hit": hit_a.mean(), "isoray_hit": hit_b.mean(), "unlike": (hit_a != hit_b).mean(), "colour": float(colour)}
