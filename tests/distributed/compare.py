# SPDX-License-Identifier: GPL-3.0-or-later
"""Superelements of one component that differ by round-off and by the signs of modes."""
import h5py
import numpy as np

TOLERANCE = 1e-9
ESTIMATED = 1e-3  # of errors, the precision to which they are estimated
# Of round-off itself, or of the reduction's own way.
NOT_COMPARED = {"conditioning/mode_orthogonality", "conditioning/mode_residual", "conditioning/reduced_rigid_forces", "conditioning/rigid_forces",
                "conditioning/reduced_mass", "conditioning/reduced_mass_scaled", "conditioning/smallest_pivot"}


def contents(path):
    found = {}
    with h5py.File(path, "r") as file:
        file.visititems(lambda name, item: found.update({name: item[()]}) if isinstance(item, h5py.Dataset) else None)
        found.update({f"attribute {name}": value for name, value in file.attrs.items()})
    return found


def aligned(x, sign, name):
    """The sign of each mode is that of its row of M_kc in the other file."""
    k = len(sign)
    if name == "matrices/M_kc":
        return sign[:, None] * x
    if name == "recovery/Phi":
        return sign * x
    if name == "spin_moments" or name.startswith("loads/") and x.ndim == 2:
        return np.concatenate([sign[:, None] * x[:k], x[k:]])
    return x


def length(x, name, size):
    """What differences are measured by: a centre by the size of the part, all else by the largest of its kind."""
    return size if name == "rigid_body/center" else np.abs(x).max()


def differences(one, other):
    a, b = contents(one), contents(other)
    has_shapes = "characteristic/V" in a and "characteristic/V" in b
    sign = np.ones(0) if has_shapes else np.sign(np.sum(a["matrices/M_kc"] * b["matrices/M_kc"], axis=1))
    size = np.ptp(a["nodes/coordinates"], axis=0).max()
    for name in sorted(a.keys() | b.keys()):
        if name in NOT_COMPARED or name in ("diagonal/V", "characteristic/V", "spin_couplings") or has_shapes and name == "recovery/Phi":
            continue
        if name not in a or name not in b:
            yield f"{name} is in one file alone"
            continue
        x, y = np.asarray(a[name]), np.asarray(b[name])
        if x.dtype.kind != "f" or x.size == 0 or x.shape != y.shape:
            if not np.array_equal(x, y):
                yield f"{name} is not the same"
            continue
        error = np.abs(x - aligned(y, sign, name)).max() / max(length(x, name, size), 1e-300)
        if not error <= (ESTIMATED if name.startswith("accuracy/") else TOLERANCE):
            yield f"{name} differs by {error:.1e}"
    if "diagonal/V" in a and "diagonal/V" in b:
        yield from modes(a, b, sign)
    if has_shapes:
        yield from shapes(a, b)


def shapes(a, b):
    """The interface in the coordinates: rigid motions span the same, elastic modes that stand alone are the same up to their signs."""
    V, W, eigenvalues = a["characteristic/V"], b["characteristic/V"], a["matrices/eigenvalues"]
    if V.shape != W.shape:
        yield "characteristic/V has another shape"
        return
    rigid = eigenvalues == 0
    left = W[:, rigid] - V[:, rigid] @ np.linalg.lstsq(V[:, rigid], W[:, rigid], rcond=None)[0]
    elastic = np.flatnonzero(~rigid)
    alone = [j for j in elastic[:-1] if j > elastic[0] and min(eigenvalues[j + 1] - eigenvalues[j], eigenvalues[j] - eigenvalues[j - 1]) > 1e-3 * eigenvalues[j]]
    apart = np.minimum(np.abs(V - W).max(axis=0), np.abs(V + W).max(axis=0))[alone]
    worst = max(np.abs(left).max(initial=0), apart.max(initial=0)) / np.abs(V).max()
    if not worst <= TOLERANCE:
        yield f"characteristic/V differs by {worst:.1e}"
    if "recovery/Phi" in a:
        sign = np.sign(np.sum(V * W, axis=0))
        inside = np.abs(a["recovery/Phi"] - sign * b["recovery/Phi"])[:, alone].max(initial=0) / np.abs(a["recovery/Phi"]).max()
        if not inside <= TOLERANCE:
            yield f"recovery/Phi differs by {inside:.1e}"


def modes(a, b, sign):
    """Elastic modes that stand alone: (V1^T M V2)^2 = 1, by products with the other file's coordinates aligned."""
    k = len(sign)
    V, W = a["diagonal/V"], np.concatenate([sign[:, None] * b["diagonal/V"][:k], b["diagonal/V"][k:]])
    M = np.block([[np.eye(k), a["matrices/M_kc"]], [a["matrices/M_kc"].T, a["matrices/M_cc"]]])
    omega = a["diagonal/omega"]
    alone = [j for j in range(6, min(40, len(omega) - 1)) if min(omega[j + 1] - omega[j], omega[j] - omega[j - 1]) > 1e-3 * omega[j]]
    overlap = np.sum(V[:, alone] * (M @ W[:, alone]), axis=0)
    if not np.all(np.abs(np.abs(overlap) - 1) < TOLERANCE):
        yield f"diagonal/V: modes overlap by {np.abs(overlap).min():.12f} of 1"
    if "spin_couplings" not in a:
        return
    coupled = [(j, s) for j, s in zip(alone, np.sign(overlap)) if 3 * (j - 6) < len(a["spin_couplings"])]
    rows = np.ix_(*2 * [[3 * (j - 6) + d for j, _ in coupled for d in range(3)]])
    signs = np.repeat([s for _, s in coupled], 3)
    P, Q = a["spin_couplings"][rows], np.outer(signs, signs) * b["spin_couplings"][rows]
    apart = np.abs(P - Q).max(initial=0) / np.abs(a["spin_couplings"]).max()
    if not apart <= TOLERANCE:
        yield f"spin_couplings differ by {apart:.1e}"
