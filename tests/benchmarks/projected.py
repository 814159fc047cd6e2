# SPDX-License-Identifier: GPL-3.0-or-later
"""How much of the energy after T1's impact a basis can hold.

The full mesh's last state (fields displacement and velocity of the left block) is projected, in the product of the mass matrix, on the space
of each superelement (written with `recovery: true`), and the energy of the projection is set beside the kinetic energy at the start, in the frame of the common
centre of mass. A run of that superelement that loses as much has lost what its basis cannot hold, and nothing more.
"""
import h5py
import numpy as np

import t1

COLUMNS = ["row", "dofs", "modes", "rms_percent", "rms_percent_of_half_speed", "energy_kept", "energy_of_projection", "difference_percent"]
SPEED, LEFT = 3810.0, np.array([-0.0279, 0, 0])


def final_state(fields):
    """Points in the component's axes, displacement and velocity (n x 3) of the first grid at the last output; cells."""
    with h5py.File(fields) as f:
        last = max(f["steps"], key=int)
        of = f["steps"][last]["0"]
        return f["grids/0/points"][:] - LEFT, of["displacement"][:], of["velocity"][:], f["grids/0/cells"][:]


def lumped_mass(points, cells, density):
    """Of a mesh of equal bricks: each node has an eighth of each of its bricks."""
    edges = points[cells].max(axis=1) - points[cells].min(axis=1)
    mass = np.zeros(len(points))
    np.add.at(mass, cells, (density * edges.prod(axis=1) / 8)[:, None])
    return mass


def order(points, wanted):
    """Index into points of each wanted point."""
    def key(p):
        return [tuple(row) for row in np.round(p / 1e-9).astype(int)]
    place = {k: i for i, k in enumerate(key(points))}
    return np.array([place[k] for k in key(wanted)])


def projected_energy(fields, superelement):
    """Dofs; shares of the energy at the start: kinetic of the full state, kinetic and strain of its projection."""
    points, u, v, cells = final_state(fields)
    v = v - [SPEED / 2, 0, 0]
    with h5py.File(superelement) as f:
        nodes, inner = order(points, f["nodes/coordinates"][:]), order(points, f["recovery/nodes/coordinates"][:])
        Psi, Phi = f["recovery/Psi"][:], f["recovery/Phi"][:]
        lam, K_cc, M_cc, M_kc = (f[f"matrices/{name}"][:] for name in ("eigenvalues", "K_cc", "M_cc", "M_kc"))
    mass = lumped_mass(points, cells, 7836.0)
    k = len(lam)
    M = np.block([[np.eye(k), M_kc], [M_kc.T, M_cc]])  # M^, in the order [k; c]

    def coordinates(x):
        """q = M^^-1 T^T M x"""
        at_c, at_I = (mass[:, None] * x)[nodes].ravel(), (mass[:, None] * x)[inner].ravel()
        return np.linalg.solve(M, np.concatenate([Phi.T @ at_I, at_c + Psi.T @ at_I]))

    q, rate = coordinates(u), coordinates(v)
    strain = 0.5 * (lam @ q[:k] ** 2 + q[k:] @ K_cc @ q[k:])
    start = 0.5 * mass.sum() * (SPEED / 2) ** 2
    return k + len(K_cc), 0.5 * np.sum(mass[:, None] * v**2) / start, 0.5 * rate @ M @ rate / start, strain / start


def measure(settings, say=print):
    """Rows of projected.csv."""
    folder, hexes = settings.out / "projected", (6, 4, 5) if settings.smoke else (20, 10, 15)
    folder.mkdir(parents=True, exist_ok=True)
    t1.make_mesh(1, hexes, folder)
    full = t1.Case(1, ("full", 0, "frequency", "impulse", ""), hexes, folder, settings.bin)
    full.write_scene(t1.END / 4, fields=", fields: [displacement, velocity]")
    full.dyn()
    rows = []
    for modes in (5,) if settings.smoke else (10, 20, 40, 80):
        case = t1.Case(1, ("a", modes, "participation", "impulse", ""), hexes, folder, settings.bin)
        case.write_scene(t1.END / 31, recovery=", recovery: true")
        case.reduce()
        case.dyn()
        rms, kept = t1.errors(folder / f"{case.stem}.h5")
        dofs, full_kinetic, kinetic, strain = projected_energy(folder / f"{full.stem}.fields.h5", folder / case.superelement)
        rows.append({"row": case.name, "dofs": dofs, "modes": modes, "rms_percent": rms, "rms_percent_of_half_speed": 2 * rms, "energy_kept": kept,
                     "energy_of_projection": kinetic + strain, "difference_percent": 100 * (kept - kinetic - strain)})
        say(f"  {case.name}: kept {kept:.4f}, projection {kinetic + strain:.4f}")
    return rows
