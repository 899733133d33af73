"""Mitsuba 3: the shape `sdfgrid`, which intersects the trilinear interpolant of samples, cell by cell.

The variant `llvm_ad_rgb` traces all rays of a picture as one compiled kernel. It needs a shared library of LLVM, which
no wheel has (Dr.Jit's environment variable DRJIT_LIBLLVM_PATH names one), and `scalar_rgb` is taken without.
"""

from __future__ import annotations  # names of mitsuba exist only once a variant is chosen

from pathlib import Path
from typing import Any

import drjit as dr
import mitsuba as mi
import numpy as np

import scene
from worker import Peer


def trace(job: dict[str, Any]) -> Peer:
    mi.set_variant(job["variant"])
    dr.set_thread_count(job["threads"])
    peer = Peer(job, f"Mitsuba sdfgrid, {job['variant'].split('_')[0]}", mi.__version__)
    volume = scene.read_volume(Path(job["volume"]))
    made = peer.build(lambda: scene_of(volume, job["isovalue"], peer))
    prepare = jit_frame(made) if job["variant"].startswith("llvm") else scalar_frame(made)
    if job["variant"].startswith("scalar"):
        peer.note("one random ray in each pixel; no LLVM for the faster variant")
    peer.frames(prepare)
    return peer


def scene_of(volume: scene.Volume, isovalue: float, peer: Peer) -> mi.Scene:
    """Samples become negative inside. Other grids than cubes are padded: version 3.9.1 mistakes their axes."""
    dims = volume.samples.shape
    edge = max(dims)
    grid = np.float32(isovalue) - volume.samples.astype("f4")
    if dims != (edge, edge, edge):
        outside = max(float(grid.max()), 1.0)
        grid = np.pad(grid, [(0, edge - n) for n in dims], constant_values=outside)
        peer.note("padded to a cube, since other grids come out wrong: closed where the surface meets the upper borders")
    extent = ((edge - 1) * np.array(volume.spacing)).tolist()
    # A grid without a sign change is refused, and one with NaN is not closed
    tensor = mi.TensorXf(np.nan_to_num(grid, nan=float(np.nanmax(grid)))[..., None])
    to_world = mi.ScalarTransform4f().scale(extent)
    shape = {"type": "sdfgrid", "grid": tensor, "normals": "analytic", "to_world": to_world}
    return mi.load_dict({"type": "scene", "surface": shape})


def jit_frame(made: mi.Scene):
    def prepare(view: dict, size: int):
        forward, right, up = (mi.Vector3f(b) for b in scene.camera_basis(view).tolist())
        eye = mi.Point3f(view["eye"])

        def render() -> mi.Float:
            index = dr.arange(mi.UInt32, size * size)
            u = (mi.Float(index % size) + 0.5) * (2 / size) - 1
            v = 1 - (mi.Float(index // size) + 0.5) * (2 / size)
            ray = mi.Ray3f(eye, dr.normalize(forward + u * right + v * up))
            hit = made.ray_intersect(ray)
            light = dr.select(hit.is_valid(), dr.abs(dr.dot(hit.n, ray.d)), -1.0)
            dr.eval(light)
            dr.sync_thread()
            return light

        def develop(light: mi.Float) -> tuple[np.ndarray, np.ndarray]:
            image = np.array(light).reshape(size, size)
            return np.maximum(image, 0.0), (image >= 0).astype(float)

        return render, develop

    return prepare


def scalar_frame(made: mi.Scene):
    integrator = mi.load_dict({"type": "aov", "aovs": "depth:depth,normal:geo_normal"})

    def prepare(view: dict, size: int):
        film = {"type": "hdrfilm", "width": size, "height": size, "rfilter": {"type": "box"}}
        sensor = mi.load_dict({
            "type": "perspective",
            "fov": view["fov"],
            "fov_axis": "y",
            "to_world": mi.ScalarTransform4f().look_at(view["eye"], view["look_at"], view["up"]),
            "film": film,
            "sampler": {"type": "independent", "sample_count": 1},
        })
        basis = scene.camera_basis(view)
        u = (np.arange(size) + 0.5) * (2 / size) - 1
        rays = basis[0] + u[None, :, None] * basis[1] - u[:, None, None] * basis[2]
        rays /= np.linalg.norm(rays, axis=2, keepdims=True)

        def develop(image: Any) -> tuple[np.ndarray, np.ndarray]:
            depth_and_normal = np.array(image)[:, :, -4:]
            hit = depth_and_normal[:, :, 0] > 0
            return np.where(hit, np.abs((depth_and_normal[:, :, 1:] * rays).sum(axis=2)), 0.0), hit.astype(float)

        return lambda: mi.render(made, sensor=sensor, integrator=integrator, spp=1), develop

    return prepare
