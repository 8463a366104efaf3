"""Pictures of parts and assemblies without a display: VTK off-screen (EGL, or OSMesa where there is no EGL), labels by Pillow."""

from __future__ import annotations

import os
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from PIL import Image, ImageDraw, ImageFont

Colour = tuple[float, float, float]


@dataclass(frozen=True)
class Body:
    """One thing to draw: a build123d shape, its colour (0 to 1), a shift in mm, and how solid it looks."""

    shape: Any
    colour: Colour
    shift: tuple[float, float, float] = (0.0, 0.0, 0.0)
    opacity: float = 1.0


@dataclass(frozen=True)
class Label:
    """Text beside a point in the scene (mm, before any shift is applied by the caller)."""

    text: str
    point: tuple[float, float, float]


def draw(
    bodies: Sequence[Body],
    path: Path,
    *,
    size: tuple[int, int] = (800, 600),
    direction: tuple[float, float, float] = (1.0, -1.2, 0.9),
    labels: Sequence[Label] = (),
    margin: float = 1.0,
    colours: int = 64,
) -> None:
    """Draw the bodies in parallel projection and write a small PNG.

    Args:
        bodies: What to draw.
        path: The PNG to write.
        size: Width and height in pixels.
        direction: From the scene to the viewer.
        labels: Texts at the picture's sides with a line to their points.
        margin: Zoom out by this factor.
        colours: Colours kept in the PNG's palette.
    """
    meshes = [(mesh(body.shape), body) for body in bodies]
    window, renderer = _scene(meshes, (2 * size[0], 2 * size[1]), direction, margin)
    picture = _grab(window).resize(size, Image.Resampling.LANCZOS)
    if labels:
        _annotate(picture, labels, _projector(renderer, size))
    path.parent.mkdir(parents=True, exist_ok=True)
    picture.quantize(colours, method=Image.Quantize.MEDIANCUT, dither=Image.Dither.NONE).save(path, optimize=True)


def mesh(shape: Any, tolerance: float = 0.08, angle: float = 0.18) -> Any:
    """Return a shape's triangles as VTK polygon data, points merged so that smooth faces share them."""
    import vtk
    from vtk.util.numpy_support import numpy_to_vtk, numpy_to_vtkIdTypeArray

    vertices, triangles = shape.tessellate(tolerance, angle)
    points = vtk.vtkPoints()
    points.SetData(numpy_to_vtk(np.array([tuple(v) for v in vertices], dtype=np.float64), deep=True))
    cells = np.hstack([np.full((len(triangles), 1), 3), np.array(triangles)]).astype(np.int64)
    polygons = vtk.vtkCellArray()
    polygons.SetCells(len(triangles), numpy_to_vtkIdTypeArray(cells.ravel(), deep=True))
    data = vtk.vtkPolyData()
    data.SetPoints(points)
    data.SetPolys(polygons)
    clean = vtk.vtkCleanPolyData()
    clean.SetInputData(data)
    clean.SetToleranceIsAbsolute(True)
    clean.SetAbsoluteTolerance(1e-5)
    clean.Update()
    return clean.GetOutput()


def _scene(meshes: Sequence[tuple[Any, Body]], size: tuple[int, int], direction: tuple[float, float, float], margin: float) -> Any:
    os.environ.pop("DISPLAY", None)
    import vtk

    vtk.vtkObject.GlobalWarningDisplayOff()
    vtk.vtkLogger.SetStderrVerbosity(vtk.vtkLogger.VERBOSITY_OFF)
    renderer = vtk.vtkRenderer()
    renderer.SetBackground(1, 1, 1)
    for data, body in meshes:
        for actor in (_surface(data, body), _edges(data, body)):
            actor.SetPosition(*body.shift)
            renderer.AddActor(actor)
    window = vtk.vtkRenderWindow()
    window.SetOffScreenRendering(1)
    window.SetSize(*size)
    window.AddRenderer(renderer)
    camera = renderer.GetActiveCamera()
    camera.ParallelProjectionOn()
    toward = np.asarray(direction) / np.linalg.norm(direction)
    camera.SetFocalPoint(0, 0, 0)
    camera.SetPosition(*toward)
    camera.SetViewUp(*((0, 0, 1) if abs(toward[2]) < 0.99 else (1, 0, 0)))
    renderer.ResetCamera()
    _fit(meshes, camera, size, margin)
    kit = vtk.vtkLightKit()
    kit.SetKeyLightAngle(55, -25)
    kit.SetKeyLightIntensity(0.95)
    kit.AddLightsToRenderer(renderer)
    window.Render()
    return window, renderer


def _fit(meshes: Sequence[tuple[Any, Body]], camera: Any, size: tuple[int, int], margin: float) -> None:
    """Centre and scale the parallel camera on what it sees of the bodies."""
    from vtk.util.numpy_support import vtk_to_numpy

    points = np.vstack([vtk_to_numpy(data.GetPoints().GetData()) + np.array(body.shift) for data, body in meshes])
    up = np.array(camera.GetViewUp())
    toward = np.array(camera.GetDirectionOfProjection()) * -1
    right = np.cross(up, toward) / np.linalg.norm(np.cross(up, toward))
    up = np.cross(toward, right)
    seen = np.c_[points @ right, points @ up, points @ toward]
    low, high = seen.min(axis=0), seen.max(axis=0)
    middle = (low + high) / 2
    focus = middle[0] * right + middle[1] * up + middle[2] * toward
    reach = high[2] - low[2] + 100.0
    camera.SetFocalPoint(*focus)
    camera.SetPosition(*(focus + reach * toward))
    camera.SetClippingRange(1.0, 2 * reach)
    extent = high - low
    camera.SetParallelScale(margin * 1.05 * max(extent[1] / 2, extent[0] / 2 * size[1] / size[0]))


def _surface(data: Any, body: Body) -> Any:
    import vtk

    normals = vtk.vtkPolyDataNormals()
    normals.SetInputData(data)
    normals.SetFeatureAngle(30)
    mapper = vtk.vtkPolyDataMapper()
    mapper.SetInputConnection(normals.GetOutputPort())
    mapper.ScalarVisibilityOff()
    actor = vtk.vtkActor()
    actor.SetMapper(mapper)
    look = actor.GetProperty()
    look.SetColor(*body.colour)
    look.SetOpacity(body.opacity)
    look.SetAmbient(0.18)
    look.SetDiffuse(0.85)
    look.SetSpecular(0.08)
    return actor


def _edges(data: Any, body: Body) -> Any:
    import vtk

    features = vtk.vtkFeatureEdges()
    features.SetInputData(data)
    features.SetFeatureAngle(28)
    features.ColoringOff()
    features.NonManifoldEdgesOff()
    mapper = vtk.vtkPolyDataMapper()
    mapper.SetInputConnection(features.GetOutputPort())
    mapper.SetResolveCoincidentTopologyToPolygonOffset()
    actor = vtk.vtkActor()
    actor.SetMapper(mapper)
    look = actor.GetProperty()
    look.SetColor(0.08, 0.08, 0.08)
    look.SetLineWidth(1.8)
    look.SetOpacity(0.25 if body.opacity < 1 else 1.0)
    look.LightingOff()
    return actor


def _grab(window: Any) -> Image.Image:
    import vtk
    from vtk.util.numpy_support import vtk_to_numpy

    grabber = vtk.vtkWindowToImageFilter()
    grabber.SetInput(window)
    grabber.ReadFrontBufferOff()
    grabber.Update()
    image = grabber.GetOutput()
    width, height, _ = image.GetDimensions()
    pixels = vtk_to_numpy(image.GetPointData().GetScalars()).reshape(height, width, -1)
    if np.ptp(pixels) == 0:
        raise RuntimeError("the off-screen picture is empty: no working EGL or OSMesa; install Mesa (Debian: libegl1 libgl1-mesa-dri)")
    return Image.fromarray(pixels[::-1, :, :3].copy())


def _projector(renderer: Any, size: tuple[int, int]) -> Any:
    def project(point: tuple[float, float, float]) -> tuple[float, float]:
        renderer.SetWorldPoint(*point, 1.0)
        renderer.WorldToDisplay()
        x, y, _ = renderer.GetDisplayPoint()
        return x / 2, size[1] - y / 2

    return project


def _annotate(picture: Image.Image, labels: Sequence[Label], project: Any) -> None:
    """Write each label at the nearer side, evenly spread, with a line to its point."""
    pen = ImageDraw.Draw(picture)
    width, height = picture.size
    font = ImageFont.load_default(size=15)
    sides: dict[str, list[tuple[float, float, str]]] = {"left": [], "right": []}
    for label in labels:
        x, y = project(label.point)
        sides["left" if x < width / 2 else "right"].append((y, x, label.text))
    for side, entries in sides.items():
        entries.sort()
        heights = _spread([y for y, _, _ in entries], 22.0, 14.0, height - 14.0)
        for (y, x, text), row in zip(entries, heights, strict=True):
            length = pen.textlength(text, font=font)
            anchor = 8 + length if side == "left" else width - 8 - length
            start = (8, row - 9) if side == "left" else (anchor, row - 9)
            end = anchor + 4 if side == "left" else anchor - 4
            pen.line([(end, row), (x, y)], fill=(90, 90, 90), width=1)
            pen.ellipse([x - 2.5, y - 2.5, x + 2.5, y + 2.5], fill=(200, 30, 30))
            pen.rectangle([start[0] - 3, row - 10, start[0] + length + 3, row + 11], fill=(255, 255, 255))
            pen.text(start, text, fill=(0, 0, 0), font=font)


def _spread(wanted: list[float], gap: float, low: float, high: float) -> list[float]:
    """Move sorted positions apart until they keep their gap, inside the picture."""
    placed: list[float] = []
    for value in wanted:
        placed.append(max(value, placed[-1] + gap if placed else low))
    limit = high
    for index in range(len(placed) - 1, -1, -1):
        placed[index] = min(placed[index], limit)
        limit = placed[index] - gap
    return placed
