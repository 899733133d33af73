"""yt: volume rendering of adaptive meshes."""

from pathlib import Path
from typing import Any

import numpy as np
import yt
from yt.visualization.volume_rendering.api import ColorTransferFunction, Scene, create_volume_source

import scene
from worker import Peer

BINS = 1024
"""Entries of the table of the transfer function."""


def render(job: dict[str, Any]) -> Peer:
    yt.set_log_level("error")
    peer = Peer(job, "yt", yt.__version__)
    ds = peer.build(lambda: yt.load(job["volume"]))
    field = next((f for f in ds.field_list if f[1] == job["field"]), None)
    if field is None:
        raise ValueError(f"{job['volume']} has no field {job['field']}")
    source = create_volume_source(ds.all_data(), field)
    source.set_log(False)
    source.num_threads = job["threads"]
    low, high = (float(x) for x in ds.all_data().quantities.extrema(field))
    # The perspective lens makes lengths a share of the longest ray there may be; `length` is the lens's own choice
    eye = np.array(job["frames"][0]["view"]["eye"])
    center, width = (np.asarray(x, float) for x in (ds.domain_center, ds.domain_width))
    length = float(np.linalg.norm(eye - center) + 0.5 * np.linalg.norm(width))
    source.set_transfer_function(table(Path(job["transfer"]), low, high, length))
    peer.build(lambda: source.volume.initialize_source([field], [False], not source.use_ghost_zones))
    peer.note("a fixed number of steps in each cell; without ghost zones, its default, so with seams between boxes")
    peer.note("within a box, what is farther from the eye is blended over what is nearer")
    world = Scene()
    world.add_source(source)

    def prepare(view: dict, size: int):
        camera = world.add_camera(ds, lens_type="perspective")
        camera.resolution = (size, size)
        camera.position = ds.arr(view["eye"], "code_length")
        camera.focus = ds.arr(view["look_at"], "code_length")
        camera.switch_orientation(
            normal_vector=np.subtract(view["look_at"], view["eye"]), north_vector=np.array(view["up"], float)
        )
        # The picture's plane lies as far behind what is looked at as the eye is before it
        far = 2 * float(np.linalg.norm(np.subtract(view["look_at"], view["eye"])))
        across = 2 * far * np.tan(np.radians(view["fov"]) / 2)
        camera.width = ds.arr([across, across, far], "code_length")
        camera.lens.setup_box_properties(camera)
        camera.lens.viewpoint = camera.position  # boxes are met in the order of their distance from it
        return lambda: source.render(camera), develop

    peer.frames(prepare)
    return peer


def develop(image: Any) -> tuple[np.ndarray, np.ndarray]:
    """yt's first axis is x, from right to left, and its second one goes up."""
    rgba = np.asarray(image)[:, :, :4].transpose(1, 0, 2)[::-1, ::-1]
    return rgba[:, :, :3], rgba[:, :, 3]


def table(path: Path, low: float, high: float, length: float) -> ColorTransferFunction:
    """Colours, which yt multiplies by the fourth channel, and absorption along `length`."""
    made = ColorTransferFunction((low, high), BINS, grey_opacity=True)
    colors, extinctions = scene.read_transfer(path).at(np.linspace(low, high, BINS))
    for k, channel in enumerate((made.red, made.green, made.blue)):
        channel.y = np.ascontiguousarray(colors[:, k])  # yt reads without regard to strides
    made.alpha.y = np.ascontiguousarray(extinctions * length)
    return made
