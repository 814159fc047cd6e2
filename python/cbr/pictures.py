# SPDX-License-Identifier: GPL-3.0-or-later
"""Pictures of instances, drawn without a display: of fields, or of the faces that superelements keep."""
from __future__ import annotations

import io
import os
import pathlib
import warnings
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Any

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import PolyCollection
from matplotlib.figure import Figure

from cbr.results import Results
from cbr.superelement import Array, FileError, Indices, attributes, child, open_file, read

COLOURS = ["#1f3b73", "#b3202c", "#2a9d4a", "#e07b00", "#7b2d8e", "#555555"]
# Corners of the sides of an element; a triangle repeats its last
SIDES = {
    "Triangle": ((0, 1, 2, 2),), "Quadrilateral": ((0, 1, 2, 3),),
    "Tetrahedron": ((0, 1, 2, 2), (0, 1, 3, 3), (1, 2, 3, 3), (0, 2, 3, 3)),
    "Pyramid": ((0, 1, 2, 3), (0, 1, 4, 4), (1, 2, 4, 4), (2, 3, 4, 4), (3, 0, 4, 4)),
    "Wedge": ((0, 1, 2, 2), (3, 4, 5, 5), (0, 1, 4, 3), (1, 2, 5, 4), (2, 0, 3, 5)),
    "Hexahedron": ((0, 1, 2, 3), (4, 5, 6, 7), (0, 1, 5, 4), (1, 2, 6, 5), (2, 3, 7, 6), (3, 0, 4, 7)),
}
VIEWER = np.array([0.48, -0.75, 0.45]) / np.linalg.norm([0.48, -0.75, 0.45])  # the direction to it
RIGHT = np.cross([0, 0, 1], VIEWER) / np.linalg.norm(np.cross([0, 0, 1], VIEWER))
PLANE = np.column_stack([RIGHT, np.cross(VIEWER, RIGHT)])  # 3 x 2: to the right, up


def printable(name: str) -> str:
    """A name without control characters, which neither HTML nor a font has.

    >>> printable("a\\x07b")
    'a\\\\x07b'
    """
    return "".join(c if c.isprintable() else repr(c)[1:-1] for c in name)


def label(name: str) -> str:
    """As matplotlib draws it: a dollar begins no formula, an underscore hides no label.

    >>> label("_cost in $")
    '\\u200a_cost in \\\\$'
    """
    text = printable(name).replace("$", r"\$")
    return "\u200a" + text if text.startswith("_") else text


@dataclass
class Part:
    """Faces of one instance that can be looked at."""

    instance: str
    points: Array      # p x 3, undeformed, scene axes
    node_ids: Indices  # p
    faces: Indices     # f x 4, rows of points; a triangle repeats its last
    cell: Indices      # f, the element that each is a side of
    grid: int = -1     # number of its grid in the fields


def outer(cells: Indices, topology: str) -> tuple[Indices, Indices]:
    """Sides that no other element of the grid has (f x 4), and the element of each.

    >>> faces, cell = outer(np.array([[0, 1, 2, 3], [1, 2, 3, 4]]), "Tetrahedron")
    >>> len(faces), cell.tolist()
    (6, [0, 0, 0, 1, 1, 1])
    """
    sides = np.array(SIDES[topology.split("_")[0]])
    faces = cells[:, sides].reshape(-1, 4)
    keys = np.sort(np.where(faces == np.roll(faces, 1, axis=1), -1, faces), axis=1)
    _, first, count = np.unique(keys, axis=0, return_index=True, return_counts=True)
    alone = np.sort(first[count == 1])
    return faces[alone], alone // len(sides)


class Fields:
    """The fields of a run, NAME.fields.h5 beside its results. FileError: there are none, they are damaged, or of another run."""

    def __init__(self, results: str | os.PathLike[str]):
        self.path = os.fspath(pathlib.Path(results).with_suffix(".fields.h5"))
        self.parts: list[Part] = []
        with open_file(results, "cbr-results", "cbr-modes") as f:
            run = f.attrs.get("run_hash")
        with open_file(self.path, "cbr-fields") as f:
            if run and f.attrs.get("run_hash") != run:
                raise FileError(f"{self.path}: is not of the run of {os.fspath(results)} (attribute 'run_hash')")
            self.times: Array = read(f["times"])
            grids = {int(number): grid for number, grid in f["grids"].items()}
            of = {number: attributes(grid) for number, grid in grids.items()}
            inner = {str(a["instance"]) for a in of.values() if not str(a["name"]).endswith(".interface")}
            for number, grid in sorted(grids.items()):
                instance = str(of[number]["instance"])
                if instance in inner and str(of[number]["name"]).endswith(".interface"):
                    continue
                faces, cell = outer(read(grid["cells"]), str(of[number]["topology"]))
                self.parts.append(Part(instance, read(grid["points"]), read(grid["node_ids"]), faces, cell, number))

    def displacements(self, step: int) -> list[Array] | None:
        """Of the points of each part. None: they are not among the fields."""
        with open_file(self.path, "cbr-fields") as f:
            names = [f"steps/{step}/{part.grid}/displacement" for part in self.parts]
            return [read(f[name]) for name in names] if all(name in f for name in names) else None

    def stresses(self, step: int) -> list[Array] | None:
        """Von Mises stress at each face of each part, 0 without one. None: it is not among the fields."""
        with open_file(self.path, "cbr-fields") as f:
            names = [f"steps/{step}/{part.grid}/stress_von_mises" for part in self.parts]
            if not any(name in f for name in names):
                return None
            return [read(f[name])[part.cell, 0] if name in f else np.zeros(len(part.faces)) for name, part in zip(names, self.parts)]


def kept_faces(file: str, content_hash: str) -> tuple[Indices, Array, dict[str, Indices]]:
    """Of a superelement or a group of them: node ids, coordinates and the corners of the faces of each surface. FileError: another
    content_hash."""
    ids, coordinates, n = [], [], 0
    faces: dict[str, Indices] = {}
    with open_file(file, "cbr-superelement", "cbr-superelement-group") as f:
        if f.attrs.get("content_hash") != content_hash:
            raise FileError(f"{file}: was made again after the run")
        for part in f["domains"].values() if "domains" in f else [f]:
            ids.append(read(part["nodes/id"]))
            coordinates.append(read(part["nodes/coordinates"]))
            for name, group in child(part, "interface").items():
                nodes, kind = read(group["faces"]), str(attributes(group["faces"])["kind"])
                corners = n + nodes[:, [0, 1, 2, 2] if kind.startswith("tri") else [0, 1, 2, 3]]
                faces[name] = np.vstack([faces[name], corners]) if name in faces else corners
            n += len(ids[-1])
    return np.concatenate(ids), np.vstack(coordinates), faces


def placed(points: Array, instance: dict[str, Any]) -> Array:
    """Points of a component (n x 3) as an instance of the scene has them.

    >>> print(placed(np.array([[1.0, 2.0, 3.0]]), {"rotation": ["0", "0", "90"], "mirror": "x", "position": [10, 0, 0]}).round(9))
    [[ 8. -1.  3.]]
    """
    x = points.copy()
    if "mirror" in instance:
        x[:, "xyz".index(instance["mirror"])] *= -1
    for axis, angle in enumerate(np.radians(np.asarray(instance.get("rotation", [0, 0, 0]), float))):
        a, b = (axis + 1) % 3, (axis + 2) % 3
        x[:, a], x[:, b] = np.cos(angle) * x[:, a] - np.sin(angle) * x[:, b], np.sin(angle) * x[:, a] + np.cos(angle) * x[:, b]
    x += np.asarray(instance.get("position", [0, 0, 0]), float)
    return x


def at_start(run: Results) -> list[Part]:
    """Of the fields of a run; without them, of the superelements that its scene places. FileError: neither can be read."""
    if os.path.exists(os.path.splitext(run.path)[0] + ".fields.h5"):
        return Fields(run.path).parts
    parts = []
    placed_as = run.scene.get("instances", {})
    for name, (file, content_hash) in run.superelements.items() if placed_as else ():
        ids, points, faces = kept_faces(file, content_hash)
        if faces:
            corners = np.unique(np.vstack(list(faces.values())), axis=0)
            parts.append(Part(name, placed(points, placed_as[name]), ids, corners, np.arange(len(corners))))
    if not parts:
        raise FileError(f"{run.path}: has no shapes to draw: give output.fields: [displacement] in the scene")
    return parts


def surface_points(run: Results, parts: list[Part]) -> dict[str, Array]:
    """Where surfaces are at the start: those with a history, and those of pairs that a superelement keeps."""
    at = {name: run[f"surfaces/{name}/mean_position"][0] for name in run.surfaces}
    for side in dict.fromkeys(side for pair in run.pairs for side in pair.split(" - ")):
        instance, _, surface = side.partition(".")
        if side in at or instance not in run.superelements:
            continue
        try:
            ids, _, faces = kept_faces(*run.superelements[instance])
        except FileError:
            continue
        corners = [of for name, of in faces.items() if surface in (name, "all")]
        for part in parts if corners else []:
            is_on = np.isin(part.node_ids, ids[np.unique(np.vstack(corners))])
            if part.instance == instance and is_on.any():
                at[side] = part.points[is_on].mean(axis=0)
    return at


def _colours(parts: list[Part]) -> list[Array]:
    names = list(dict.fromkeys(part.instance for part in parts))
    return [np.tile(matplotlib.colors.to_rgb(COLOURS[names.index(part.instance) % len(COLOURS)]), (len(part.faces), 1)) for part in parts]


def extent(positions: Iterable[list[Array]]) -> Array:
    """The corners, 2 x 2, of what positions cover in the picture."""
    flat = [points @ PLANE for of_parts in positions for points in of_parts]
    return np.array([np.min([x.min(axis=0) for x in flat], axis=0), np.max([x.max(axis=0) for x in flat], axis=0)])


def draw(axis: Axes, parts: list[Part], positions: list[Array], corners: Array, values: list[Array] | None = None,
         largest: float = 0) -> None:
    """Parts at positions (p x 3 of each), the farthest face first, in the colour of the instance or of values at the faces."""
    polygons, depths, colours = [], [], []
    for i, (part, of_instance) in enumerate(zip(parts, _colours(parts))):
        x = positions[i][part.faces]
        normal = np.cross(x[:, 2] - x[:, 0], x[:, 3] - x[:, 1])
        facing = np.abs(normal @ VIEWER) / np.maximum(np.linalg.norm(normal, axis=1), 1e-300)
        colour = 0.4 + 0.6 * of_instance if values is None else matplotlib.cm.viridis(values[i] / (largest or 1))[:, :3]
        colours.append((0.55 + 0.45 * facing[:, None]) * colour)
        polygons.append(x @ PLANE)
        depths.append(x.mean(axis=1) @ VIEWER)
    order = np.argsort(np.concatenate(depths), kind="stable")
    edge = "#00000040" if len(order) < 20000 else "face"
    axis.add_collection(PolyCollection(np.concatenate(polygons)[order], facecolors=np.concatenate(colours)[order],
                                       edgecolors=edge, linewidths=0.3))
    margin = 0.06 * (corners[1] - corners[0]).max()
    axis.set_xlim(corners[0, 0] - margin, corners[1, 0] + margin)
    axis.set_ylim(corners[0, 1] - margin, corners[1, 1] + margin)
    axis.set_aspect("equal")
    axis.axis("off")


def sheet(corners: Array, width: float = 8) -> tuple[Figure, Axes]:
    """A figure of the proportions of a picture."""
    across, up = np.maximum(corners[1] - corners[0], 1e-300)
    fig = plt.figure(figsize=(width, float(np.clip(width * up / across, 2, 6))))
    return fig, fig.add_axes([0, 0, 1, 0.94])


def png(fig: Figure) -> bytes:
    out = io.BytesIO()
    with warnings.catch_warnings():
        warnings.filterwarnings("ignore", "Glyph .* missing")
        fig.savefig(out, format="png", dpi=110, metadata={"Software": None})
    plt.close(fig)
    return out.getvalue()


def start_picture(run: Results, parts: list[Part], most_names: int) -> bytes:
    """Instances by their names, surfaces as dots, pairs by their numbers from 1."""
    positions = [part.points for part in parts]
    corners = extent([positions])
    fig, axis = sheet(corners)
    draw(axis, parts, positions, corners)
    box = {"boxstyle": "round,pad=0.2", "facecolor": "white", "alpha": 0.8, "linewidth": 0}
    for name in list(dict.fromkeys(part.instance for part in parts))[:most_names]:
        middle = np.vstack([part.points for part in parts if part.instance == name]).mean(axis=0) @ PLANE
        axis.annotate(label(name), middle, ha="center", fontsize=11, fontweight="bold", bbox=box)
    at = surface_points(run, parts)
    for i, (name, point) in enumerate(list(at.items())[:most_names]):
        axis.plot(*(point @ PLANE), "o", color="black", markersize=3)
        axis.annotate(label(name), point @ PLANE, xytext=(8, 12 + 14 * (i % 3)), textcoords="offset points", fontsize=8, bbox=box,
                      arrowprops={"arrowstyle": "-", "linewidth": 0.6})
    for i, pair in enumerate(run.pairs[:most_names]):
        sides = [at[side] for side in pair.split(" - ") if side in at]
        if sides:
            axis.annotate(str(i + 1), np.mean(sides, axis=0) @ PLANE, xytext=(-12, -14), textcoords="offset points", fontsize=9,
                          bbox={"boxstyle": "circle", "facecolor": "#ffd94a", "linewidth": 0.6})
    return png(fig)


def gif(parts: list[Part], frames: Sequence[tuple[str, list[Array], list[Array] | None]], largest: float) -> bytes:
    """Frames of a title, positions and values of each part, as an animation that repeats."""
    from PIL import Image  # matplotlib's own dependency

    corners = extent(positions for _, positions, _ in frames)
    images, (fig, axis) = [], sheet(corners, 7)
    for title, positions, values in frames:
        axis.clear()
        draw(axis, parts, positions, corners, values, largest)
        axis.set_title(title, loc="left", fontsize=9)
        fig.canvas.draw()
        images.append(Image.fromarray(np.asarray(fig.canvas.buffer_rgba())[..., :3]).convert("P", palette=Image.Palette.ADAPTIVE))
    plt.close(fig)
    out = io.BytesIO()
    images[0].save(out, format="GIF", save_all=True, append_images=images[1:], duration=100, loop=0)
    return out.getvalue()
