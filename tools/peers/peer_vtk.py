"""VTK: meshes of isosurfaces by flying edges, and the fixed-point ray caster. Both need no graphics card."""

import ctypes
from pathlib import Path
from typing import Any

import numpy as np
import vtkmodules.vtkRenderingOpenGL2  # noqa: F401, makes renderers and lights possible
import vtkmodules.vtkRenderingVolumeOpenGL2  # noqa: F401
from vtkmodules.util.numpy_support import numpy_to_vtk, vtk_to_numpy
from vtkmodules.vtkCommonCore import vtkSMPTools
from vtkmodules.vtkCommonDataModel import vtkImageData, vtkPiecewiseFunction
from vtkmodules.vtkCommonCore import vtkVersion
from vtkmodules.vtkFiltersCore import vtkFlyingEdges3D
from vtkmodules.vtkRenderingCore import (
    vtkColorTransferFunction,
    vtkLight,
    vtkRenderer,
    vtkRenderWindow,
    vtkVolume,
    vtkVolumeProperty,
)
from vtkmodules.vtkRenderingVolume import vtkFixedPointVolumeRayCastMapper

import scene
from worker import Peer

FULL = 32767
"""One, in the fixed-point numbers of the ray caster's pictures."""


def image_data(volume: scene.Volume) -> vtkImageData:
    image = vtkImageData()
    image.SetDimensions(*volume.samples.shape[::-1])
    image.SetSpacing(*volume.spacing)
    image.GetPointData().SetScalars(numpy_to_vtk(volume.samples.reshape(-1), deep=False))
    return image


def triangles(image: vtkImageData, isovalue: float, threads: int) -> tuple[np.ndarray, np.ndarray]:
    """Vertices and corners of triangles of the isosurface."""
    vtkSMPTools.SetBackend("STDThread")
    vtkSMPTools.Initialize(threads)
    edges = vtkFlyingEdges3D()
    edges.SetInputData(image)
    edges.SetValue(0, isovalue)
    edges.ComputeNormalsOff()
    edges.ComputeGradientsOff()
    edges.ComputeScalarsOff()
    edges.Update()
    mesh = edges.GetOutput()
    if mesh.GetNumberOfPolys() == 0:
        raise ValueError(f"no surface at the isovalue {isovalue}")
    corners = vtk_to_numpy(mesh.GetPolys().GetConnectivityArray()).reshape(-1, 3)
    return vtk_to_numpy(mesh.GetPoints().GetData()), corners


def extract(job: dict[str, Any]) -> Peer:
    peer = Peer(job, "VTK flying edges", vtkVersion.GetVTKVersion())
    volume = peer.build(lambda: image_data(scene.read_volume(Path(job["volume"]))))
    peer.result["build_s"] = 0.0  # reading the file is not what is compared
    vertices, corners = peer.build(lambda: triangles(volume, job["isovalue"], job["threads"]))
    peer.note(f"makes the mesh only, once per isovalue: {len(corners):,} triangles, {len(vertices):,} vertices")
    return peer


def ray_cast(job: dict[str, Any]) -> Peer:
    """The volume, or an isosurface as a step of opacity. Only the ray casting is timed, not the way to a window."""
    surface = job["work"] == "isosurface"
    peer = Peer(job, "VTK fixed-point ray caster", vtkVersion.GetVTKVersion())
    volume = scene.read_volume(Path(job["volume"]))
    image = image_data(volume)
    mapper = vtkFixedPointVolumeRayCastMapper()
    mapper.SetInputData(image)
    mapper.SetNumberOfThreads(job["threads"])
    mapper.AutoAdjustSampleDistancesOff()
    mapper.SetImageSampleDistance(1.0)
    mapper.LockSampleDistanceToInputSpacingOff()
    mapper.SetSampleDistance(min(volume.spacing))
    peer.note("one sample for each edge of a voxel along the ray, in fixed point")
    if surface:
        peer.note("no surface but a step of opacity: all that is inside is opaque, also where the border cuts it")
    prop = surface_property(job["isovalue"]) if surface else volume_property(Path(job["transfer"]), volume)
    actor = vtkVolume()
    actor.SetMapper(mapper)
    actor.SetProperty(prop)
    renderer = vtkRenderer()
    renderer.AddVolume(actor)
    headlight = vtkLight()
    headlight.SetLightTypeToHeadlight()
    renderer.AddLight(headlight)
    window = vtkRenderWindow()
    window.SetOffScreenRendering(True)
    window.AddRenderer(renderer)

    def cast() -> None:
        mapper.PerImageInitialization(
            renderer, actor, 0, list(image.GetOrigin()), list(image.GetSpacing()), list(image.GetExtent())
        )
        mapper.PerVolumeInitialization(renderer, actor)
        mapper.PerSubVolumeInitialization(renderer, actor, 0)
        mapper.RenderSubVolume()

    def prepare(view: dict, size: int):
        window.SetSize(size, size)
        camera = renderer.GetActiveCamera()
        camera.SetPosition(view["eye"])
        camera.SetFocalPoint(view["look_at"])
        camera.SetViewUp(view["up"])
        camera.SetViewAngle(view["fov"])
        renderer.ResetCameraClippingRange()
        renderer.UpdateLightsGeometryToFollowCamera()
        return cast, lambda _: picture(mapper, size)

    first = job["frames"][0]
    prepare(first["view"], 16)
    peer.build(cast)  # gradients and tables are made along with the first picture
    peer.frames(prepare)
    return peer


def surface_property(isovalue: float) -> vtkVolumeProperty:
    color, opacity = vtkColorTransferFunction(), vtkPiecewiseFunction()
    color.AddRGBPoint(isovalue, 1.0, 1.0, 1.0)
    opacity.AddPoint(np.nextafter(np.float32(isovalue), -np.inf), 0.0)
    opacity.AddPoint(isovalue, 1.0)
    prop = vtkVolumeProperty()
    prop.SetColor(color)
    prop.SetScalarOpacity(opacity)
    prop.SetInterpolationTypeToLinear()
    prop.ShadeOn()
    prop.SetAmbient(0.0)
    prop.SetDiffuse(1.0)
    prop.SetSpecular(0.0)
    return prop


def volume_property(path: Path, volume: scene.Volume) -> vtkVolumeProperty:
    transfer = scene.read_transfer(path)
    finite = volume.samples[np.isfinite(volume.samples)]
    values = np.linspace(float(finite.min()), float(finite.max()), 1024)
    colors, extinctions = transfer.at(values)
    color, opacity = vtkColorTransferFunction(), vtkPiecewiseFunction()
    for value, rgb, extinction in zip(values, colors, extinctions):
        color.AddRGBPoint(value, *rgb)
        opacity.AddPoint(value, -np.expm1(-extinction))
    prop = vtkVolumeProperty()
    prop.SetColor(color)
    prop.SetScalarOpacity(opacity)
    prop.SetScalarOpacityUnitDistance(1.0)
    prop.SetInterpolationTypeToLinear()
    prop.ShadeOff()
    return prop


def picture(mapper: vtkFixedPointVolumeRayCastMapper, size: int) -> tuple[np.ndarray, np.ndarray]:
    """Copies the part of the picture that the mapper rendered into one of the whole view."""
    image = mapper.GetRayCastImage()
    width, height = image.GetImageInUseSize()
    stride, lines = image.GetImageMemorySize()
    x, y = image.GetImageOrigin()
    pointer = int(image.GetImage().split("_")[1], 16)
    stored = (ctypes.c_uint16 * (stride * lines * 4)).from_address(pointer)
    rgba = np.frombuffer(stored, np.uint16).reshape(lines, stride, 4)[:height, :width] / FULL
    whole = np.zeros((size, size, 4))
    whole[y:y + height, x:x + width] = rgba[:size - y, :size - x]
    whole = whole[::-1]  # VTK's first row is the lowest
    return whole[:, :, :3], whole[:, :, 3]
