# SPDX-License-Identifier: GPL-3.0-or-later
"""Superelements: what cbr-reduce writes."""
from __future__ import annotations

import contextlib
import os
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import h5py
import numpy as np
import numpy.typing as npt
import xxhash

from cbr.soundness import is_sound

Array = npt.NDArray[np.float64]
Indices = npt.NDArray[np.int64]


class FileError(Exception):
    """A file that is not what it should be: its name and what is wrong."""


_DOFS = ("x", "y", "z", "rx", "ry", "rz")


@dataclass(frozen=True)
class Faces:
    """Faces of a surface that the superelement keeps; nodes are rows of Superelement.coordinates."""

    kind: str         # tri3, quad4, tri6, quad8 or quad9
    nodes: Indices    # f x 3, 4, 6, 8 or 9, outward by the right-hand rule
    element: Indices  # f, id of the element in the mesh
    side: Indices     # f, numbered as in Exodus II


@dataclass(frozen=True)
class Superelement:
    """A reduced component: k coordinates q_k of its modes, and c interface dofs u_c.

    basis craig-bampton: the coordinates of K and M are [q_k; u_c], modes first.
    basis massless, characteristic: those of K and M are q_k alone; u_c = V q_k + F f_c for forces f_c
    on the interface (docs/formats.md).

    Two masses of 2 on a spring of 3, along x; no modes. superelement(path) makes it of a file.

    >>> import numpy as np
    >>> K, M = np.array([[3.0, -3.0], [-3.0, 3.0]]), 2 * np.eye(2)
    >>> part = Superelement(
    ...     path="two.cbr.h5", basis="craig-bampton", K=K, M=M, V=np.eye(2), F=np.zeros((2, 2)),
    ...     node=np.array([0, 1]), component=np.array([0, 0]), node_id=np.array([7, 9]),
    ...     coordinates=np.zeros((2, 3)), faces={}, nodesets={"end": np.array([1])}, mass=4.0,
    ...     center=np.zeros(3), inertia=np.zeros((3, 3)), n_modes=0, accuracy={}, provenance={})
    >>> (2 * np.pi * part.frequencies())**2
    array([0., 3.])
    >>> part.dof(9, "x"), part.point("end")
    (1, 9)
    >>> part.response([0.1], out=1, at=0).real.round(4)
    array([-0.7292])
    >>> part.shape(np.array([1.0, -1.0]))[:, 0]
    array([ 1., -1.])
    """

    path: str
    basis: str
    K: Array                      # stiffness, n x n; n = k + c, or k
    M: Array                      # mass, n x n
    V: Array                      # c x n: u_c = V q, without forces
    F: Array                      # c x c, static compliance beside V; zero with craig-bampton
    node: Indices                 # c, row of `coordinates` of each interface dof
    component: Indices            # c, 0 1 2 for x y z; of points also 3 4 5, rotations about them
    node_id: Indices              # n_nodes, ids in the mesh
    coordinates: Array            # n_nodes x 3
    faces: dict[str, Faces]
    nodesets: dict[str, Indices]  # rows of `coordinates`
    mass: float
    center: Array                 # 3, centre of mass
    inertia: Array                # 3 x 3, about the centre of mass
    n_modes: int                  # k
    accuracy: dict[str, Any]      # errors of the reduction: /accuracy of the file
    provenance: dict[str, str]    # what it was made of
    content_hash: str = ""        # of all that the file depends on

    def modes(self) -> tuple[Array, Array]:
        """Frequencies (n, Hz, ascending; rigid motions 0) and shapes of the interface (c x n).

        Shapes have modal mass 1. Rigid motions are those below a millionth of the highest frequency.
        """
        if self.basis != "craig-bampton":
            lam, phi = np.diag(self.K).copy(), np.eye(len(self.K))
        else:
            L = np.linalg.cholesky(self.M)
            lam, y = np.linalg.eigh(np.linalg.solve(L, np.linalg.solve(L, self.K).T))
            phi = np.linalg.solve(L.T, y)
        lam[np.abs(lam) < 1e-12 * lam.max(initial=0)] = 0
        order = np.argsort(lam, kind="stable")
        return np.sqrt(np.maximum(lam[order], 0)) / (2 * np.pi), self.V @ phi[:, order]

    def frequencies(self) -> Array:
        """Of the free superelement, Hz, ascending."""
        return self.modes()[0]

    def dof(self, node_id: int, component: str | int) -> int:
        """Number of an interface dof: the id of a node, and x, y, z, of a point also rx, ry, rz, or 0 to 5."""
        if component not in (*_DOFS, *range(6)):
            raise ValueError(f"no component {component!r}: give x, y, z, rx, ry, rz, or 0 to 5")
        c = _DOFS.index(component) if isinstance(component, str) else component
        found = np.flatnonzero((self.node_id[self.node] == node_id) & (self.component == c))
        if len(found) == 0:
            raise KeyError(f"{self.path}: node {node_id} has no dof {_DOFS[c]} on the interface")
        return int(found[0])

    def point(self, name: str) -> int:
        """The node id of a point of the interface, as dof() takes it."""
        if name not in self.nodesets or len(self.nodesets[name]) != 1:
            raise KeyError(f"{self.path}: no point '{name}' on the interface")
        return int(self.node_id[self.nodesets[name][0]])

    def shape(self, u_c: Array) -> Array:
        """Interface displacements as n_nodes x 3, from c of them; rotations of points are left out."""
        u = np.zeros((len(self.coordinates), 3))
        moves = self.component < 3
        u[self.node[moves], self.component[moves]] = np.asarray(u_c)[moves]
        return u

    def response(self, hz: npt.ArrayLike, out: int, at: int, ratio: float = 0.0) -> npt.NDArray[np.complex128]:
        """Displacement of dof `out` per unit harmonic force on dof `at` (numbers from dof()), at each of
        the frequencies `hz`. `ratio`: of critical damping, of every mode.
        """
        frequency, shapes = self.modes()
        w, w_r = 2 * np.pi * np.asarray(hz, float)[:, None], 2 * np.pi * frequency[None, :]
        modal = shapes[out] * shapes[at] / (w_r**2 - w**2 + 2j * ratio * w_r * w)
        return np.asarray(modal.sum(axis=1) + self.F[out, at])


def _compliance(f: h5py.File, node: Indices, component: Indices) -> Array:
    """B F B^T of /characteristic/statics (c x c)."""
    c = len(node)
    statics = child(f["characteristic"], "statics")
    if not statics:
        return np.zeros((c, c))
    at, direction = read(statics["node"]), read(statics["direction"])
    B = np.where(node[:, None] == at[None, :], direction[:, component].T, 0.0)
    return np.asarray(B @ read(statics["F"]) @ B.T)


def _matrices(f: h5py.File, node: Indices, component: Indices) -> tuple[Array, Array, Array, Array]:
    """K, M, V and F."""
    lam, c = read(f["matrices/eigenvalues"]), len(node)
    k = len(lam)
    if (basis := f.attrs["basis"]) != "craig-bampton":
        F = read(f["massless/F"]) if basis == "massless" else _compliance(f, node, component)
        return np.diag(lam), np.eye(k), read(f[f"{basis}/V"]), F
    K, M = np.diag(np.concatenate([lam, np.zeros(c)])), np.eye(k + c)
    K[k:, k:], M[k:, k:] = read(f["matrices/K_cc"]), read(f["matrices/M_cc"])
    M[:k, k:] = read(f["matrices/M_kc"])
    M[k:, :k] = M[:k, k:].T
    return K, M, np.hstack([np.zeros((c, k)), np.eye(c)]), np.zeros((c, c))


def _tree(group: h5py.Group) -> dict[str, Any]:
    """A group as nested dictionaries; datasets of one entry as numbers."""
    return {name: _tree(item) if isinstance(item, h5py.Group)
            else (read(item)[0].item() if item.shape == (1,) else read(item)) for name, item in group.items()}


def _faces(group: h5py.Group) -> Faces:
    kind = str(attributes(group["faces"])["kind"])
    if kind not in ("tri3", "quad4", "tri6", "quad8", "quad9"):
        raise ValueError(f"{group.name}: faces of kind '{kind}'")
    return Faces(kind, read(group["faces"]), read(group["element"]), read(group["side"]))


def child(group: Any, name: str) -> Any:
    """A group in a group, empty where there is none. KeyError: it cannot be read, which h5py's get() takes for none."""
    return group[name] if group and group.id.links.exists(name.encode()) else {}


def read(item: h5py.Dataset) -> Any:
    """The numbers of a dataset. FileError: they do not match its attribute `checksum`, if it has one."""
    values = item[()]
    if "checksum" in item.attrs:
        stored = np.ascontiguousarray(values, values.dtype.newbyteorder("<")).tobytes()
        if xxhash.xxh3_64_intdigest(stored) != int(item.attrs["checksum"]) % 2**64:
            raise FileError(f"{item.file.filename}: {item.name}: its numbers are not those that were written (attribute 'checksum'): "
                            "the file was damaged")
    return values


def attributes(item: h5py.Group | h5py.Dataset) -> dict[str, Any]:
    """Of an object. FileError: its texts do not match its attribute `checksums_of_texts`, if it has one."""
    found = dict(item.attrs)
    wanted = {int(checksum) % 2**64 for checksum in found.pop("checksums_of_texts", [])}
    texts = {name.encode() + (text.encode("utf-8", "surrogateescape") if isinstance(text, str) else text)
             for name, text in found.items() if isinstance(text, (str, bytes))}
    if not wanted <= {xxhash.xxh3_64_intdigest(text) for text in texts}:
        raise FileError(f"{item.file.filename}: {item.name}: its texts are not those that were written "
                        "(attribute 'checksums_of_texts'): the file was damaged")
    return found


@contextlib.contextmanager
def open_file(path: str | os.PathLike[str], *wanted: str) -> Iterator[h5py.File]:
    """A file of the cbr programs, to read, of one of the wanted formats. FileError: there is none, it has another
    format, or something in it cannot be read.

    >>> with open_file("none.h5", "cbr-results") as file:
    ...     pass
    Traceback (most recent call last):
    cbr.superelement.FileError: none.h5: no such file
    """
    name, expected = os.fspath(path), " or ".join(wanted)
    if not os.path.isfile(name):
        raise FileError(f"{name}: no such file")
    if not os.access(name, os.R_OK):
        raise FileError(f"{name}: cannot be opened: Permission denied")
    if not h5py.is_hdf5(name):
        raise FileError(f"{name}: is not an HDF5 file, expected {expected}")
    try:
        if not is_sound(name):
            raise OSError
        with h5py.File(name, "r") as f:
            found = attributes(f).get("format", "an HDF5 file of another program")
            if found not in wanted:
                raise FileError(f"{name}: is {found}, expected {expected}")
            yield f
    except KeyError as error:  # h5py's words, in quotes
        raise FileError(f"{name}: is incomplete or damaged: {error.args[0] if error.args else error}") from error
    except OSError as error:  # HDF5's own words name no file and speak of its blocks
        raise FileError(f"{name}: cannot be read: the HDF5 file is truncated or damaged") from error
    except (ArithmeticError, AttributeError, IndexError, MemoryError, RuntimeError, TypeError, ValueError) as error:
        raise FileError(f"{name}: is damaged, or no {expected}: {error}") from error


def superelement(path: str | os.PathLike[str]) -> Superelement:
    """Reads a superelement. FileError: it is none, or a group of several (`domains` above 1)."""
    with open_file(path, "cbr-superelement") as f:
        if f.attrs["basis"] not in ("craig-bampton", "massless", "characteristic"):
            raise ValueError(f"basis '{f.attrs['basis']}'")
        node, component = read(f["dofs/node"]), read(f["dofs/component"])
        K, M, V, F = _matrices(f, node, component)
        return Superelement(
            path=os.fspath(path), basis=str(f.attrs["basis"]), K=K, M=M, V=V, F=F, node=node,
            component=component, node_id=read(f["nodes/id"]), coordinates=read(f["nodes/coordinates"]),
            faces={name: _faces(group) for name, group in child(f, "interface").items()},
            nodesets={name: read(item) for name, item in child(f, "nodesets").items()},
            content_hash=str(f.attrs.get("content_hash", "")), mass=float(read(f["rigid_body/mass"])[0]), center=read(f["rigid_body/center"]),
            inertia=read(f["rigid_body/inertia"]), n_modes=int(f.attrs["n_modes"]),
            accuracy=_tree(child(f, "accuracy")),
            provenance={k: str(v) for k, v in attributes(f["provenance"]).items()} if "provenance" in f else {})
