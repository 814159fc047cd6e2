#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""What happens to the energy of impacts, in one dimension: a bar's end meets a wall, or another bar's. Figures of ../energy.md, 1.

    /usr/bin/python3 bar.py          needs numpy, scipy; four minutes

Every model is a list of modes: frequencies w, values V at the end that touches, its static compliance F beside the modes (0: the end has mass),
and b, how a rigid motion is made of the modes (all mass: b . b). n is the number of moving coordinates. References are exact: waves run through a bar unchanged.
"""
import numpy as np
import scipy.linalg as la
from scipy.special import zeta

L, C, RHO, G = 10.0, 30.0, 1.0, 10.0  # the bar of Doyen, Ern, Piperno 2011
HEIGHTS = (5.0, 3.7, 4.3, 6.1, 2.2)   # theirs, whose motion repeats itself, and four more


# ---- bases ----------------------------------------------------------------------------------------------------------------------
def fixed(k, L=L):
    """alpha (interface participation) and frequencies of the bar held at the end that touches."""
    j = np.arange(1, k + 1) - 0.5
    return np.sqrt(2 * RHO * L) / (j * np.pi), j * np.pi * C / L


def fixed_rest(k, p, L=L):
    """Sum of alpha^2 / omega^(2 p) over the modes after the first k."""
    return 2 * RHO * L / np.pi**2 * (L / (np.pi * C)) ** (2 * p) * zeta(2 * p + 2, k + 0.5)


def free_rest(k, p, L=L):
    """Sum of V^2 / omega^(2 p) over the free modes after the first k, the rigid one counted."""
    return 2 / (RHO * L) * (L / (np.pi * C)) ** (2 * p) * zeta(2 * p, max(k, 1))


def massless(a, w):
    """Held modes that carry all mass, the end none: as free modes and compliance."""
    S = np.sum((a * w) ** 2)
    lam, U = la.eigh(np.diag(w**2) - np.outer(a * w**2, a * w**2) / S)
    lam[0] = 0
    return np.sqrt(np.maximum(lam, 0)), (a * w**2) @ U / S, 1 / S, a @ U


def craig_bampton(n, L=L):
    a, w = fixed(n - 1, L)
    M, K = np.eye(n), np.diag(np.r_[w**2, 0])
    M[-1, :-1] = M[:-1, -1] = a
    M[-1, -1] = RHO * L
    lam, P = la.eigh(K, M)
    lam[0] = 0
    return np.sqrt(np.maximum(lam, 0)), P[-1], 0.0, M[-1] @ P


def free(n, L=L, taper=None):
    """MacNeal: n free modes, the static rest as compliance. taper(omega / first omega left out) = share of V^2 that stays in the mode."""
    j = np.arange(n)
    w, V = j * np.pi * C / L, np.sqrt(np.where(j == 0, 1, 2) / (RHO * L))
    F, b = free_rest(n, 1, L), np.where(j == 0, np.sqrt(RHO * L), 0)
    if taper:
        t = taper(j / n)
        F, V = F + np.sum((1 - t[1:]) * V[1:] ** 2 / w[1:] ** 2), V * np.sqrt(t)
    return w, V, F, b


def fixed_massless(n, L=L):
    """Modified Craig-Bampton with rigid-mass correction."""
    a, w = fixed(n, L)
    return massless(a * np.sqrt(RHO * L / np.sum(a * a)), w)


def matched(n, L=L):
    """The mass M_res that the modes leave hangs on one oscillator, whose frequency makes the next moment of the rest right too."""
    a, w = fixed(n - 1, L)
    m, s = fixed_rest(n - 1, 0, L), fixed_rest(n - 1, 1, L)
    return massless(np.r_[a, np.sqrt(m)], np.r_[w, np.sqrt(m / s)])


def matched_twice(n, L=L):
    """Two oscillators, for four moments (Gauss)."""
    a, w = fixed(n - 2, L)
    t = [fixed_rest(n - 2, p, L) for p in range(4)]
    s = t[0] / t[1]
    mu = [t[p] * s**p / t[0] for p in range(4)]
    c = np.linalg.solve([[mu[0], mu[1]], [mu[1], mu[2]]], [-mu[2], -mu[3]])
    x = np.sort(np.roots([1, c[1], c[0]]).real)
    weight = np.linalg.solve([[1, 1], x], mu[:2])
    return massless(np.r_[a, np.sqrt(weight * t[0])], np.r_[w, np.sqrt(s / x)])


def on_the_next(n, L=L):
    """M_res on the frequency of the mode after the last."""
    a, w = fixed(n, L)
    a[-1] = np.sqrt(fixed_rest(n - 1, 0, L))
    return massless(a, w)


def free_matched(n, L=L):
    """n - 1 free modes, and of their rest one oscillator and a compliance, for three moments (Radau)."""
    w, V, _, b = free(n - 1, L)
    f1, f2, f3 = (free_rest(n - 1, p, L) for p in (1, 2, 3))
    w2 = f2 / f3
    return np.r_[w, np.sqrt(w2)], np.r_[V, np.sqrt(f2) * w2], f1 - f2 * w2, np.r_[b, 0]


def layer(n, elements, fineness, L=L):
    """Elements of length L / (fineness n) kept next to the contact, the end node's mass moved inwards; the rest held modes."""
    m, d = elements, L / (fineness * n)
    a, w = fixed(n - m, L - m * d)
    N = n + 1
    K, M = np.zeros((N, N)), np.zeros((N, N))
    for e in range(m):
        K[e : e + 2, e : e + 2] += RHO * C * C / d * np.array([[1, -1], [-1, 1]])
        M[e, e] += RHO * d / 2
        M[e + 1, e + 1] += RHO * d / 2
    M[m, m] += RHO * (L - m * d)
    M[m, m + 1 :] = M[m + 1 :, m] = a
    M[range(m + 1, N), range(m + 1, N)], K[range(m + 1, N), range(m + 1, N)] = 1, w**2
    end, M[0, 0] = M[0, 0], 0
    M[1, 1] += 2 * end if m > 1 else end
    if m > 1:
        M[2, 2] -= end  # with the first moment kept
    lam, P = la.eigh(K[1:, 1:] - np.outer(K[1:, 0], K[0, 1:]) / K[0, 0], M[1:, 1:])
    lam[0] = 0
    rigid = np.r_[np.ones(m), np.zeros(n - m)]
    return np.sqrt(np.maximum(lam, 0)), -(K[0, 1:] @ P) / K[0, 0], 1 / K[0, 0], (M[1:, 1:] @ rigid) @ P


def power(p, q=1.0):
    return lambda x: (1 - x**p) ** q


GIVEN_BACK = {"craig-bampton, given back to all": 0, "craig-bampton, given back by w": 1, "craig-bampton, given back by w^2": 2, "craig-bampton, given back by w^4": 4}
MODELS = {
    "craig-bampton": craig_bampton, "craig-bampton, landing reflected": craig_bampton, **dict.fromkeys(GIVEN_BACK, craig_bampton),
    "massless, free modes": free, "massless, fixed modes": fixed_massless, "one matched oscillator": matched, "two matched oscillators": matched_twice,
    "mass on the next mode": on_the_next, "free modes, matched oscillator": free_matched,
    "layer of 2 elements, L/2n": lambda n, L=L: layer(n, 2, 2, L), "layer of 2 elements, L/3n": lambda n, L=L: layer(n, 2, 3, L),
    "layer of 4 elements, L/2n": lambda n, L=L: layer(n, 4, 2, L),
    "free, cos(pi x/2)^2": lambda n, L=L: free(n, L, lambda x: np.cos(np.pi * x / 2) ** 2), "free, 1 - x^2": lambda n, L=L: free(n, L, power(2)),
    "free, 1 - x^2.5": lambda n, L=L: free(n, L, power(2.5)), "free, 1 - x^3": lambda n, L=L: free(n, L, power(3)), "free, 1 - x^4": lambda n, L=L: free(n, L, power(4)),
    "free, (1 - x^4)^2": lambda n, L=L: free(n, L, power(4, 2)),
}


# ---- runs -----------------------------------------------------------------------------------------------------------------------
def run(names, models, position, velocity, gravity, h, steps, every):
    """Many models at once, exact between kicks; contact u >= 0 by impulses at the end of the step (mass) or by the compliance (none).
    Times, end's position, energy, momentum: outputs x models."""
    n = max(len(m[0]) for m in models)
    w, V, b = (np.array([np.pad(m[i], (0, n - len(m[i]))) for m in models]) for i in (0, 1, 3))
    F = np.array([m[2] for m in models])
    mass, mirror = F == 0, np.array(["reflected" in s for s in names])
    weight = np.array([GIVEN_BACK.get(s, -1) for s in names])[:, None]  # energy goes to modes by (w / highest)^weight
    back = weight[:, 0] >= 0
    x = np.maximum(w * h / 2, 1e-30)
    c, s, ws, gain = np.cos(w * h), np.where(w > 0, np.sin(w * h) / np.maximum(w, 1e-30), h), w * np.sin(w * h), np.where(weight >= 0, 1, np.tan(x) / x)
    kick, fall, a1, a2 = gain * V, h * gravity * b, V * c, V * s
    stiff, W = np.where(mass, 0, h / np.where(mass, 1, F)), np.where(mass, (a2 * kick).sum(1), 1)
    q, v, open_ = position * b, velocity * b - 0.5 * fall, np.ones(len(F), bool)
    f = np.where(weight > 0, (w / w.max(1, keepdims=True)) ** np.maximum(weight, 0), 1)
    f2_a2 = f**2 * a2
    scale, owed = (f2_a2 * a2).sum(1), np.zeros(len(F))
    out = []
    for step in range(1, steps + 1):
        v = v + fall
        p = np.maximum(0, np.where(mass, -(a1 * q + a2 * v).sum(1) / W, -(V * q).sum(1) * stiff))
        p = np.where(mirror & open_, 2 * p, p)
        open_ = p == 0
        lost = -(p * (kick * v).sum(1) + 0.5 * p * p * (kick * kick).sum(1))
        v = v + kick * p[:, None]
        if back.any():  # along f v, less what would move the end; at most 0.3 of it in a step, the rest is owed
            owed = owed + np.where(back, lost, 0)
            d = f * v
            d = d - f2_a2 * ((a2 * d).sum(1) / scale)[:, None]
            dd, vd = (d * d).sum(1), (v * d).sum(1)
            can = back & (p > 0) & (owed > 0) & (vd > 0)
            give = np.where(can, np.minimum((np.sqrt(np.maximum(0, vd**2 + 2 * dd * owed)) - vd) / np.maximum(dd, 1e-300), 0.3), 0)
            owed = owed - give * vd - 0.5 * give**2 * dd
            v = v + give[:, None] * d
        q, v = c * q + s * v, c * v - ws * q
        if step % every == 0:
            force = np.maximum(0, -(V * q).sum(1) * stiff) / h
            mid = v + 0.5 * fall + 0.5 * h * kick * force[:, None]
            energy = 0.5 * (mid**2).sum(1) + 0.5 * ((w * q) ** 2).sum(1) + 0.5 * F * force**2 - gravity * (b * q).sum(1)
            out.append(((V * q).sum(1) + F * force, energy, (b * mid).sum(1)))
    u, energy, momentum = (np.array([o[i] for o in out]) for i in range(3))
    return np.arange(1, len(u) + 1) * every * h, u, energy, momentum


def staged(ns, height, h, steps, every):
    """Held modes while closed, free ones while open, the state projected (in the product of the mass) at each change: end's position, energy; outputs x ns."""
    n = max(ns)
    i, j = np.arange(1, n + 1) - 0.5, np.arange(n)
    a, w_held = fixed(n)
    w_free, V, _, b = free(n)
    share = np.where(j == 0, np.sqrt(0.5), 1) * 2 / np.pi * i[:, None] / (i[:, None] ** 2 - j**2)  # held mode i, free mode j
    has = np.arange(n) < np.array(ns)[:, None]  # of n coordinates
    held = lambda y: has * (y @ share.T)
    free_of = lambda y: has * (y @ share)
    rest, n_models = -G * a / w_held**2, len(ns)  # under gravity, held
    q, v, closed = np.where(has, height * b, 0), np.zeros((n_models, n)), np.zeros(n_models, bool)
    c0, s0 = np.cos(w_free * h), np.where(j > 0, np.sin(w_free * h) / np.maximum(w_free, 1e-30), h)
    c1, s1 = np.cos(w_held * h), np.sin(w_held * h) / w_held
    out = []
    for step in range(1, steps + 1):
        if not closed.all():
            fall = -0.5 * h * G * b
            v0 = v + fall
            q, v = np.where(closed[:, None], q, c0 * q + s0 * v0), np.where(closed[:, None], v, c0 * v0 - w_free**2 * s0 * q + fall)
        if closed.any():
            d = q - rest
            q, v = np.where(closed[:, None], rest + c1 * d + s1 * v, q), np.where(closed[:, None], c1 * v - w_held**2 * s1 * d, v)
        u, rate = np.where(closed, 0, (has * V * q).sum(1)), (has * V * v).sum(1)
        force = -(has * a * w_held**2 * q).sum(1) + G * (RHO * L - (has * a**2).sum(1))
        lands, opens = ~closed & (u < 0) & (rate < 0), closed & (force < 0)
        if lands.any() or opens.any():
            q = np.where(lands[:, None], held(q), np.where(opens[:, None], free_of(q), q))
            v = np.where(lands[:, None], held(v), np.where(opens[:, None], free_of(v), v))
            q, v = q * has, v * has
            closed = (closed | lands) & ~opens
        if step % every == 0:
            w = np.where(closed[:, None], w_held, w_free)
            out.append((np.where(closed, 0, (has * V * q).sum(1)), 0.5 * (v**2).sum(1) + 0.5 * ((w * q) ** 2).sum(1) + G * (has * np.where(closed[:, None], a, b) * q).sum(1)))
    return np.array([o[0] for o in out]), np.array([o[1] for o in out])


def exact_drop(height, end, per_transit=16000):
    """Position of the lower end: what arrives is what was sent 2 L / C before; it leaves as it came, or so that the end stays."""
    dt, N = 2 * L / C / per_transit, per_transit
    n = int(end / dt) + 2
    sent, u = np.empty(n), np.empty(n)
    sent[0], u[0] = height / 2, height
    for i in range(1, n):
        arrives, before = (sent[i - N] if i >= N else height / 2), (sent[i - 1 - N] if i > N else height / 2)
        fallen = G * (i * dt) ** 2 / 2
        sent[i] = sent[i - 1] + arrives - before
        u[i] = sent[i] + arrives - fallen
        if u[i] < 0:
            sent[i], u[i] = fallen - arrives, 0.0
    return np.arange(n) * dt, u


def strike(n):
    """A bar strikes one 1.618 times as long: it stops, the other leaves at 1 / 1.618 of its speed and rings. Restitution, energy kept, per model."""
    end, ratio = 2.9 * 1.618 * L / C, 1.618
    models = []
    for make in MODELS.values():
        one, two = make(n), make(int(round(n * ratio)), L=ratio * L)
        models.append((np.r_[one[0], two[0]], np.r_[one[1], -two[1]], one[2] + two[2], np.r_[one[3], 0 * two[3]]))
    h = 2.5e-4
    _, _, energy, momentum = run(list(MODELS), models, 0, -1, 0, h, int(end / h), int(end / h))
    striker = momentum[-1] / (RHO * L)
    return striker + (1 + striker) / ratio, energy[-1] / (0.5 * RHO * L)


def main():
    ns = list(range(10, 41, 2))
    print("a bar strikes one 1.618 times as long, n = 15, 16, 30: restitution (exact 0.618), energy kept (exact 1)")
    figures = [strike(n) for n in (15, 16, 30)]
    for i, name in enumerate(MODELS):
        print(f"  {name:34s}", *(f"{r[i]:.3f} {e[i]:.3f}  " for r, e in figures))
    print(f"\nfalls from {HEIGHTS}: relative L2 error of the end's position, n = 10 to 40: median and worst; first over the first third (10 periods: fifth), then all")
    cases = [(name, n) for name in MODELS for n in ns]
    models, rows = [MODELS[name](n) for name, n in cases], []
    for height in HEIGHTS:
        end, part = (160 / 3, 0.2) if height == 5 else (14 * np.sqrt(2 * height / G) + 4, 0.3)
        h = 5e-4
        t, u, energy, _ = run([name for name, _ in cases], models, height, 0, -G, h, int(end / h), 4)
        exact = np.interp(t, *exact_drop(height, end))[:, None]
        k = int(part * len(t))
        errors = [np.sqrt(((u - exact)[:i] ** 2).sum(0) / (exact[:i] ** 2).sum()).reshape(len(MODELS), -1) for i in (k, len(t))]
        kept = (energy[-1] / energy[0]).reshape(len(MODELS), -1)
        u, energy = staged(ns, height, h, int(end / h), 4)
        errors = [np.vstack([e, np.sqrt(((u - exact)[:i] ** 2).sum(0) / (exact[:i] ** 2).sum())]) for e, i in zip(errors, (k, len(t)))]
        rows.append((*errors, np.vstack([kept, energy[-1] / energy[0]])))
    for i, name in enumerate([*MODELS, "staged: held modes, free modes"]):
        print(f"  {name:34s}", *(f"{np.median(early[i]):.3f}<{early[i].max():.3f} {np.median(whole[i]):.3f}<{whole[i].max():.3f} |" for early, whole, _ in rows),
              f"energy kept {min(kept[i].min() for _, _, kept in rows):.3f} to {max(kept[i].max() for _, _, kept in rows):.3f}")


if __name__ == "__main__":
    main()
