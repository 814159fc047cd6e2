#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""What happens to the energy of impacts, in three dimensions: a quarter of the paper's block (T1; planes of symmetry held, 20 x 5 x 8 hexes) meets a
rigid wall at half the speed, and goes to and fro between two. Figures of ../energy.md, 2.

    /usr/bin/python3 block.py        needs numpy, scipy; two minutes

Models are lists of modes as in bar.py: frequencies w, rows V of the nodes that touch (outward), their compliance F (None: they have mass), b of a
rigid motion. References: tests/benchmarks/reference/t1.txt and rattle.txt. Plain on purpose: dense eigenvectors, every formula in sight.
"""
import pathlib

import numpy as np
import scipy.linalg as la
import scipy.sparse as sp
import scipy.sparse.linalg as spla

E, NU, RHO, SPEED, H = 5.17e12, 0.3, 7836.0, 1905.0, 2.5e-8
REFERENCE = pathlib.Path(__file__).resolve().parents[3] / "tests" / "benchmarks" / "reference"
CORNER = np.array([[-1, -1, -1], [1, -1, -1], [1, 1, -1], [-1, 1, -1], [-1, -1, 1], [1, -1, 1], [1, 1, 1], [-1, 1, 1]], float)
N, SIZE = (20, 5, 8), (0.0508, 0.0127, 0.01905)


def brick(h):
    """Stiffness (24 x 24) and mass (8 x 8) of a brick of edges h, 2 x 2 x 2 points."""
    lam, mu = E * NU / (1 + NU) / (1 - 2 * NU), E / 2 / (1 + NU)
    D = np.zeros((6, 6))
    D[:3, :3] = lam
    D += np.diag([2 * mu] * 3 + [mu] * 3)
    K, M, w = np.zeros((24, 24)), np.zeros((8, 8)), np.prod(h) / 8
    for p in CORNER / 3**0.5:
        f = 1 + CORNER * p
        shape = np.prod(f, 1) / 8
        d = np.stack([CORNER[:, i] * np.prod(np.delete(f, i, 1), 1) / 8 * 2 / h[i] for i in range(3)])
        B = np.zeros((6, 24))
        for row, column, of in ((0, 0, 0), (1, 1, 1), (2, 2, 2), (3, 0, 1), (3, 1, 0), (4, 1, 2), (4, 2, 1), (5, 0, 2), (5, 2, 0)):
            B[row, column::3] = d[of]
        K += B.T @ D @ B * w
        M += np.outer(shape, shape) * RHO * w
    return K, M


class Block:
    """Full mesh: K, lumped mass m, x (1 for dofs along x), its free modes, dofs of the faces x_max and x_min."""

    def __init__(self):
        node = np.arange(np.prod(np.add(N, 1))).reshape(np.add(N, 1))
        a, b = slice(None, -1), slice(1, None)
        con = np.stack([node[s] for s in ((a, a, a), (b, a, a), (b, b, a), (a, b, a), (a, a, b), (b, a, b), (b, b, b), (a, b, b))], -1).reshape(-1, 8)
        Ke, Me = brick(np.divide(SIZE, N))
        dof, n = (3 * con[:, :, None] + np.arange(3)).reshape(len(con), 24), 3 * node.size
        K = sp.csr_matrix((np.tile(Ke.ravel(), len(con)), (np.repeat(dof, 24, 1).ravel(), np.tile(dof, (1, 24)).ravel())), shape=(n, n))
        m = np.zeros(n)
        np.add.at(m, dof, np.repeat(Me.sum(1), 3))
        keep = np.ones(n, bool)
        keep[3 * node[:, 0].ravel() + 1] = keep[3 * node[:, :, 0].ravel() + 2] = False
        free = np.flatnonzero(keep)
        new = np.full(n, -1)
        new[free] = np.arange(len(free))
        self.K, self.m, self.x = K[free][:, free].tocsc(), m[free], (free % 3 == 0).astype(float)
        self.ends = [node[-1].ravel(), node[0].ravel()]
        self.dofs = [[d for d in new[(3 * nodes[:, None] + np.arange(3)).ravel()] if d >= 0] for nodes in self.ends]
        self.normal = [new[3 * nodes] for nodes in self.ends]
        s = 1 / np.sqrt(self.m)
        w2, U = la.eigh(self.K.toarray() * s[:, None] * s)
        self.w, self.Phi = np.sqrt(np.maximum(w2, 0)), U * s[:, None]
        self.w[0] = 0
        self.mass = self.m @ self.x


class Bases:
    """Bases of the block with one face kept, or both."""

    def __init__(self, block, faces):
        self.block, self.c = block, np.concatenate([block.dofs[f] for f in faces])
        self.normal = np.concatenate([block.normal[f] for f in faces])
        self.sign = np.concatenate([np.full(len(block.normal[f]), 1 - 2 * f) for f in faces])[:, None]
        I = np.setdiff1d(np.arange(len(block.m)), self.c)
        K, m = block.K, block.m
        lu, K_IC = spla.splu(K[I][:, I].tocsc()), K[I][:, self.c].toarray()
        Psi = -lu.solve(K_IC)
        P = m[I][:, None] * Psi
        s = 1 / np.sqrt(m[I])
        self.lam, Y = la.eigh(K[I][:, I].toarray() * s[:, None] * s, subset_by_index=[0, 799])
        self.alpha = (Y * s[:, None]).T @ P
        self.M_cc, self.K_cc = np.diag(m[self.c]) + Psi.T @ P, K[self.c][:, self.c].toarray() + K_IC.T @ Psi
        self.S2 = P.T @ lu.solve(P)
        place = {dof: i for i, dof in enumerate(self.c)}
        self.at = np.array([place[dof] for dof in self.normal])

    def craig_bampton(self, k):
        """k modes picked by participation."""
        pick = np.argsort(-(self.alpha**2).sum(1))[:k]
        a = self.alpha[pick]
        M = np.block([[np.eye(k), a], [a.T, self.M_cc]])
        w2, Q = la.eigh(la.block_diag(np.diag(self.lam[pick]), self.K_cc), M)
        w2[0] = 0
        return np.sqrt(np.maximum(w2, 0)), self.sign * Q[k + self.at], None, (M @ np.r_[np.zeros(k), self.block.x[self.c]]) @ Q

    def free(self, n, taper=None):
        w, V = self.block.w, self.sign * self.block.Phi[self.normal]
        F = (V[:, n:] / w[n:] ** 2) @ V[:, n:].T
        V = V[:, :n].copy()
        if taper:
            t = taper(w[:n] / w[n])
            F += (V[:, 1:] * (1 - t[1:]) / w[1:n] ** 2) @ V[:, 1:].T
            V *= np.sqrt(t)
        return w[:n], V, F, ((self.block.m * self.block.x) @ self.block.Phi)[:n]

    def held(self, a, lam):
        """Modes of the held body that carry all mass."""
        F = la.inv(self.K_cc + a.T @ (lam[:, None] * a))
        U = F @ (a.T * lam)
        w2, Q = la.eigh(np.diag(lam) - (a * lam[:, None]) @ U)
        w2[0] = 0
        return np.sqrt(np.maximum(w2, 0)), self.sign * (U @ Q)[self.at], self.sign * F[np.ix_(self.at, self.at)] * self.sign.T, (a @ self.block.x[self.c]) @ Q

    def fixed(self, k):
        a = self.alpha[:k]
        return self.held(a * np.sqrt(self.block.mass / np.sum((a @ self.block.x[self.c]) ** 2)), self.lam[:k])

    def matched(self, k):
        """M_res on as many oscillators as there are interface dofs, S2 right too; frequencies cut at 1 / H."""
        a, lam = self.alpha[:k], self.lam[:k]
        S2 = self.S2 - a.T @ (a / lam[:, None])
        O2, X = la.eigh(self.M_cc - a.T @ a, S2 + 1e-12 * np.trace(S2) / len(S2) * np.eye(len(S2)))
        return self.held(np.vstack([a, (S2 @ X * np.sqrt(np.maximum(O2, 0))).T]), np.r_[lam, np.minimum(O2, 1 / H**2)])


def active_set(W, g, guess):
    """p >= 0, g + W p >= 0, p . (g + W p) = 0"""
    active = guess | (g < 0)
    for _ in range(200):
        p = np.zeros(len(g))
        if active.any():
            p[active] = la.solve(W[np.ix_(active, active)], -g[active], assume_a="sym")
        new = (active & (p > 0)) | (~active & (g + W @ p < -1e-14))
        if (new == active).all():
            break
        active = new
    return np.maximum(p, 0)


def run(model, mass, gap, end, give=None):
    """Exact between kicks. give: weights of modes, to which what impulses took is given back while something touches.
    Rows of t, mean of the nodes that can touch (outward), position and velocity of the centre of mass, share of the energy."""
    w, V, F, b = model
    x = np.maximum(w * H / 2, 1e-30)
    c, s, ws, gain = np.cos(w * H), np.where(w > 0, np.sin(w * H) / np.maximum(w, 1e-30), H), w * np.sin(w * H), np.tan(x) / x
    kick, a1, a2 = (V * gain).T, V * c, V * s
    W = a2 @ kick if F is None else F / H
    q, v, p, owed, out = 0 * w, SPEED * b, np.zeros(len(V)), 0.0, []
    f = give(w / w.max()) if give else None
    for step in range(int(round(end / H)) + 1):
        g = gap - (a1 @ q + a2 @ v if F is None else V @ q)
        p = active_set(W, g, p > 0) if (g < 0).any() else 0 * p
        face = (V @ q if F is None else V @ q - F @ p / H).mean()
        out.append((step * H, face, b @ q / mass, b @ v / mass, ((v / gain) @ v + (w * q / gain) @ (w * q)) / (mass * SPEED**2)))
        if p.any():
            k = kick @ p
            owed += (k / gain) @ (v - 0.5 * k)  # the energy that contact cannot raise weighs modes by 1 / gain
            v = v - k
            if give:
                A, d = a2[p > 0], f * v
                d = d - f**2 * (A.T @ la.lstsq((A * f**2) @ A.T, A @ d)[0])  # what does not move the nodes that touch
                dd, vd = (d / gain) @ d, (v / gain) @ d
                if owed > 0 and vd > 0:
                    scale = min((np.sqrt(vd**2 + 2 * dd * owed) - vd) / dd, 0.3)
                    v = v + scale * d
                    owed -= scale * vd + 0.5 * scale**2 * dd
        q, v = c * q + s * v, c * v - ws * q
    return np.array(out)


def power(p, q=1.0):
    return lambda x: np.maximum(1 - x**p, 0) ** q


def main():
    block = Block()
    one, both = Bases(block, [0]), Bases(block, [0, 1])
    t1, rattle = np.loadtxt(REFERENCE / "t1.txt"), np.loadtxt(REFERENCE / "rattle.txt")
    tapers = {"no taper": None, "1 - x^2": power(2), "1 - x^2.5": power(2.5), "1 - x^3": power(3), "(1 - x^3)^1.5": power(3, 1.5), "1 - x^4": power(4), "(1 - x^4)^2": power(4, 2)}
    gives = {"as it is": None, "given back to all": np.ones_like, "to elastic modes": lambda x: (x > 0) * 1.0, "by w": lambda x: x, "by w^2": lambda x: x**2, "by w^4": lambda x: x**4,
             "above w_max / 3": lambda x: (x > 1 / 3) * 1.0}

    def impact(model, give=None):
        o = run(model, block.mass, 0, 7e-6, give)
        error = o[:, 1] - np.interp(0.0076 / SPEED + o[:, 0], t1[:, 0], t1[:, 1])
        return -o[-1, 3] / SPEED, 100 * np.sqrt(np.mean(error**2)) / (SPEED * 4.25e-6), o[-1, 4]

    print("one impact: rebound (0.8423), rms % of the face's position, energy kept")
    for k in (10, 20, 80):
        for name, give in gives.items():
            print(f"  craig-bampton, {k} modes picked, energy {name:18s} %.4f %.2f %.4f" % impact(one.craig_bampton(k), give))
    for k in (20, 80, 160):
        print(f"  massless, {k} fixed modes %.4f %.2f %.4f" % impact(one.fixed(k)))
        print(f"  massless, {k} fixed modes and matched oscillators %.4f %.2f %.4f" % impact(one.matched(k)))
    print("massless, free modes n = 30, 45, ... 300: rebound less 0.8423, mean and worst; rms, median and worst, of n < 100 and above")
    for name, taper in tapers.items():
        ns = np.arange(30, 301, 15)
        figures = np.array([impact(one.free(n, taper))[:2] for n in ns]) - [0.8423, 0]
        for part in (ns < 100, ns > 100):
            f = figures[part]
            print(f"  {name:14s} {f[:, 0].mean():+.4f} {abs(f[:, 0]).max():.4f}   {np.median(f[:, 1]):.2f} {f[:, 1].max():.2f}")
    print("to and fro: rms % of the gap to 25, 50, 100 us; speeds after six impacts (0.842 0.821 0.702 0.610 0.497 0.362)")

    def to_and_fro(name, model, give=None):
        o = run(model, block.mass, 0.0076, 1e-4, give)
        error = 100 * (o[:, 2] - np.interp(o[:, 0], *rattle.T)) / 0.0076
        rms = [np.sqrt(np.mean(error[o[:, 0] < end] ** 2)) for end in (2.5e-5, 5e-5, 1.01e-4)]
        speeds = [abs(o[int(t / H), 3]) / SPEED for t in (1.5e-5, 2.85e-5, 4.3e-5, 6e-5, 7.6e-5, 9.6e-5)]
        print(f"  {name:58s}", *(f"{r:5.2f}" for r in rms), " ", *(f"{s:.3f}" for s in speeds), f"  energy {o[-1, 4]:.3f}", flush=True)

    for k in (20, 80):
        for name, give in gives.items():
            to_and_fro(f"craig-bampton, {k} modes picked, energy {name}", both.craig_bampton(k), give)
    for n in (40, 80, 120, 160, 240):
        for name in ("no taper", "1 - x^2", "1 - x^3"):
            to_and_fro(f"massless, {n} free modes, {name}", both.free(n, tapers[name]))


if __name__ == "__main__":
    main()
