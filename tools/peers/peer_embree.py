"""Embree: the mesh of the isosurface (by flying edges), ray traced.

The published wheel of Embree, `embreex`, has an interface for single rays. What is fast is packets of 16 rays: with
Numba, the library in the wheel is called directly for them, from compiled code without the interpreter's lock, which
makes the rays and shades the hits, too. Without Numba, single rays go through embreex, on one thread.
"""

import ctypes
import importlib.metadata
import re
import threading
import time
from pathlib import Path
from typing import Any

import embreex
import embreex.rtcore_scene  # loads the library
import numpy as np

import scene
from peer_vtk import image_data, triangles
from worker import Peer

try:
    import numba
except ImportError:
    numba = None

INDEX, VERTEX = 0, 1  # RTCBufferType
UINT3, FLOAT3 = 0x5003, 0x9003  # RTCFormat
TRIANGLES = 0  # RTCGeometryType
COHERENT = 1 << 16  # RTCRayQueryFlags
NATIVE_16 = 34  # RTCDeviceProperty: whether packets of 16 are traversed as such
NOTHING = 0xFFFFFFFF  # RTC_INVALID_GEOMETRY_ID
PACKET = 4
"""Pixels along the edge of a packet."""
WORDS = 24
"""Words of 16 lanes that are kept for an RTCRayHit16, which has 20 or 21 of them."""


class Library:
    """The part of Embree's interface, version 4, that is needed here."""

    def __init__(self, threads: int):
        folder = Path(embreex.__file__).parent
        files = [f for g in ("../embreex.libs/*embree4*", ".dylibs/*embree4*", "*embree4*") for f in folder.glob(g)]
        if not files:
            raise FileNotFoundError("the wheel of embreex has no library of Embree 4 beside it")
        self.c = ctypes.CDLL(str(files[0]))
        pointer, size, unsigned = ctypes.c_void_p, ctypes.c_size_t, ctypes.c_uint
        for name, result, *arguments in [
            ("rtcNewDevice", pointer, ctypes.c_char_p),
            ("rtcGetDeviceProperty", ctypes.c_ssize_t, pointer, ctypes.c_int),
            ("rtcNewScene", pointer, pointer),
            ("rtcNewGeometry", pointer, pointer, ctypes.c_int),
            ("rtcSetSharedGeometryBuffer", None, pointer, ctypes.c_int, unsigned, ctypes.c_int, pointer, size, size, size),
            ("rtcCommitGeometry", None, pointer),
            ("rtcAttachGeometry", unsigned, pointer, pointer),
            ("rtcCommitScene", None, pointer),
            ("rtcIntersect16", None, size, size, size, size),
        ]:
            function = getattr(self.c, name)
            function.restype, function.argtypes = result, arguments
        self.device = self.c.rtcNewDevice(f"threads={threads}".encode())
        number = self.c.rtcGetDeviceProperty(self.device, 0)
        self.version = f"{number // 10000}.{number // 100 % 100}.{number % 100}"
        self.native = bool(self.c.rtcGetDeviceProperty(self.device, NATIVE_16))

    def scene(self, vertices: np.ndarray, corners: np.ndarray) -> int:
        """Builds the hierarchy. The arrays are used where they lie and must stay."""
        made = self.c.rtcNewScene(self.device)
        mesh = self.c.rtcNewGeometry(self.device, TRIANGLES)
        self.c.rtcSetSharedGeometryBuffer(mesh, VERTEX, 0, FLOAT3, vertices.ctypes.data, 0, 12, len(vertices) - 1)
        self.c.rtcSetSharedGeometryBuffer(mesh, INDEX, 0, UINT3, corners.ctypes.data, 0, 12, len(corners))
        self.c.rtcCommitGeometry(mesh)
        self.c.rtcAttachGeometry(made, mesh)
        self.c.rtcCommitScene(made)
        return made


def trace(job: dict[str, Any]) -> Peer:
    library = Library(job["threads"])
    packets = compiled(library.c.rtcIntersect16) if numba else None
    wheel = importlib.metadata.version("embreex")
    peer = Peer(job, "Embree on a mesh", f"{library.version} (embreex {re.sub('[.]post.*', '', wheel)})")
    volume = image_data(scene.read_volume(Path(job["volume"])))
    start = time.perf_counter()
    points, indices = peer.build(lambda: triangles(volume, job["isovalue"], job["threads"]))
    # A vertex more than are used: Embree reads 16 bytes of the last one
    vertices = peer.build(lambda: np.vstack([points, np.zeros((1, 3))]).astype("f4"))
    corners = peer.build(lambda: indices.astype("u4"))
    mesh_s = time.perf_counter() - start
    if packets is None:
        return trace_single(peer, vertices, corners)
    built = peer.build(lambda: library.scene(vertices, corners))
    bvh_s = peer.result["build_s"] - mesh_s
    peer.note(f"{len(corners):,} triangles; {mesh_s:.2f} s mesh + {bvh_s:.2f} s hierarchy, for each isovalue anew")
    peer.note(f"packets of 16 rays, {'native' if library.native else 'split by Embree'}")
    threads = job["threads"]
    scratch = [aligned(16 * WORDS) for _ in range(threads)]
    masks = [aligned(16) for _ in range(threads)]
    for mask in masks:
        mask[:] = NOTHING
    arguments = aligned(16)
    arguments[:2] = COHERENT, NOTHING  # flags, and all features; the rest is zero

    def prepare(view: dict, size: int):
        basis = scene.camera_basis(view).astype("f4")
        eye = np.array(view["eye"], "f4")
        image = np.empty((size, size), "f4")

        def render() -> np.ndarray:
            def share(k: int) -> None:
                packets(built, arguments.ctypes.data, masks[k], scratch[k], eye, basis, image, k, threads)

            others = [threading.Thread(target=share, args=(k,)) for k in range(1, threads)]
            for other in others:
                other.start()
            share(0)
            for other in others:
                other.join()
            return image

        return render, develop

    peer.frames(prepare)
    return peer


def develop(image: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Of brightness, which is negative at a miss."""
    hit = image >= 0
    return np.where(hit, image, 0.0), hit.astype(float)


def aligned(words: int) -> np.ndarray:
    """Zeroed 32-bit words at a multiple of 64 bytes."""
    room = np.zeros(words + 16, "u4")
    return room[-(room.ctypes.data // 4) % 16:][:words]


def compiled(intersect16):
    """Compiles the loop over packets: rays, intersection, light from the eye. Done before anything is timed."""

    def packets(built, arguments, mask, words, eye, basis, image, first, step):
        size = image.shape[0]
        floats = words.view(np.float32)
        scale = np.float32(2.0 / size)
        for row in range(first * PACKET, size, step * PACKET):
            for column in range(0, size, PACKET):
                for lane in range(16):
                    u = scale * (column + lane % PACKET + np.float32(0.5)) - np.float32(1)
                    v = np.float32(1) - scale * (row + lane // PACKET + np.float32(0.5))
                    dx = basis[0, 0] + u * basis[1, 0] + v * basis[2, 0]
                    dy = basis[0, 1] + u * basis[1, 1] + v * basis[2, 1]
                    dz = basis[0, 2] + u * basis[1, 2] + v * basis[2, 2]
                    norm = np.float32(1) / np.sqrt(dx * dx + dy * dy + dz * dz)
                    floats[lane] = eye[0]
                    floats[16 + lane] = eye[1]
                    floats[32 + lane] = eye[2]
                    floats[48 + lane] = 0
                    floats[64 + lane] = dx * norm
                    floats[80 + lane] = dy * norm
                    floats[96 + lane] = dz * norm
                    floats[112 + lane] = 0
                    floats[128 + lane] = np.inf
                    words[144 + lane] = NOTHING  # mask of geometries
                    words[160 + lane] = 0
                    words[176 + lane] = 0
                    words[288 + lane] = NOTHING  # geometry that is hit
                    words[304 + lane] = NOTHING
                intersect16(mask.ctypes.data, built, words.ctypes.data, arguments)
                for lane in range(16):
                    y, x = row + lane // PACKET, column + lane % PACKET
                    light = np.float32(-1)
                    if words[288 + lane] != NOTHING:
                        nx, ny, nz = floats[192 + lane], floats[208 + lane], floats[224 + lane]
                        dot = nx * floats[64 + lane] + ny * floats[80 + lane] + nz * floats[96 + lane]
                        light = abs(dot) / np.sqrt(nx * nx + ny * ny + nz * nz)
                    if y < size and x < size:
                        image[y, x] = light

    signature = "void(uint64, uint64, uint32[::1], uint32[::1], float32[::1], float32[:, ::1], float32[:, ::1], int64, int64)"
    return numba.njit(signature, nogil=True, fastmath=True)(packets)


def trace_single(peer: Peer, vertices: np.ndarray, corners: np.ndarray) -> Peer:
    from embreex.mesh_construction import TriangleMesh

    def build():
        made = embreex.rtcore_scene.EmbreeScene()
        return made, TriangleMesh(made, vertices, corners.astype("i4"))

    built, _mesh = peer.build(build)
    peer.note(f"{len(corners):,} triangles; single rays on one thread: install numba for packets")

    def prepare(view: dict, size: int):
        u = (np.arange(size) + 0.5) * (2 / size) - 1
        basis = scene.camera_basis(view)
        rays = (basis[0] + u[None, :, None] * basis[1] - u[:, None, None] * basis[2]).reshape(-1, 3).astype("f4")
        rays /= np.linalg.norm(rays, axis=1, keepdims=True)
        eyes = np.tile(np.array(view["eye"], "f4"), (len(rays), 1))

        def shade(hits: dict[str, np.ndarray]) -> tuple[np.ndarray, np.ndarray]:
            normals = hits["Ng"] / np.maximum(np.linalg.norm(hits["Ng"], axis=1, keepdims=True), 1e-30)
            light = np.where(hits["geomID"] == 0, np.abs((normals * rays).sum(axis=1)), -1.0)
            return develop(light.reshape(size, size))

        return lambda: built.run(eyes, rays, output=True), shade

    peer.frames(prepare)
    return peer
