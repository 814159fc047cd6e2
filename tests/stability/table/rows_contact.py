# SPDX-License-Identifier: GPL-3.0-or-later
"""Contact: singular, redundant, deep, fast, on edges."""
import h5py
import numpy as np

from parts import box
from runs import STEEL, reduction
from table import below, holds, refused, row

CHAPTER = "Contact"
KINDS = ("superelement", "mesh")


def scene(folder, instances, contact=None, end=1.0, part=None, interface=("x_min", "x_max"), modes=6, every=None, step="auto", integrator="exact",
          material=None, **more):
    """Blocks of one mesh; `instances`: name -> what the scene says of it."""
    mesh = folder.mesh(part or box((2, 2, 2)))
    return {"materials": {"steel": dict(STEEL, **(material or {}))},
            "components": {"block": {"mesh": mesh, "material": "steel", "reduction": reduction(interface, modes)}},
            "instances": {name: {"component": "block", **options} for name, options in instances.items()},
            **({"contact": contact} if contact else {}), "time": {"end": end, "step": step, "integrator": integrator},
            "output": {"every": every or end / 20}, **more}


def names(ran):
    with h5py.File(ran.file) as f:
        return list(f["instances"])


def momentum_lost(ran):
    """Change of the sum of momenta, of the largest sum of magnitudes."""
    p = sum(ran[f"instances/{n}/momentum"] for n in names(ran))
    return np.abs(p - p[0]).max() / max(sum(np.abs(ran[f"instances/{n}/momentum"]).max() for n in names(ran)), 1e-300)


def energy_gained(ran):
    """Beyond what loads gave, of the largest energy. While nodes are held they swing between the ends of exact steps, which counts as
    energy until they are let go: such outputs are left out, but for the last."""
    E = ran["energy/total"] - ran["energy/work_external"]
    loose = ran["contact/active"] == 0
    loose[-1] = True
    return max((E - E[0])[loose].max(), 0) / np.abs(ran["energy/total"]).max()


FACE = 0.5  # of two equal blocks that meet over a whole face


def reduced_mass(*arms):
    """Of two equal unit cubes of mass 1 that meet, along an axis, at a point so far sideways of the middle of both (a face's middle: FACE)."""
    return 1 / (2 * (1 + 6 * sum(arm**2 for arm in arms)))


def impact(ran, gain=1e-12, mass=FACE, speed=0.1, axis=0, lost=0.5, body="b", drift=4e-14):
    """Momentum kept to `drift`; no energy gained beyond `gain`; and a hit: of the plastic hit of rigid bodies of this reduced mass and speed of
    approach `body` is given the impulse at least (an elastic hit gives twice that, no contact 0), and the share `lost` of its loss of energy
    is lost at most. What is lost is what mesh or basis cannot hold: of a mesh of two layers the relative motion of the nodes that touch, a
    quarter of the mass (0.25); with six modes rather more."""
    off, gained = momentum_lost(ran), energy_gained(ran)
    p, E = ran[f"instances/{body}/momentum"][:, axis], ran["energy/total"] - ran["energy/work_external"]
    given, taken = abs(p[-1] - p[0]) / (mass * speed), (E[0] - E[-1]) / (0.5 * mass * speed**2)
    touched = abs(ran["energy/work_contact"]).max() > 0
    return (f"momentum {off:.0e}, energy {gained:.0e}; impulse {given:.2f}, loss {taken:.2f} of a plastic hit's" + ("" if touched else ", no contact"),
            f"{drift:g}, {gain:g}; from 1, to {lost:.2g}", off < drift and gained < gain and touched and given >= 1 and taken <= lost)


def both(run):
    return [(kind, *run(kind)) for kind in KINDS]


PAIR = [{"between": ["a.x_max", "b.x_min"]}]


@row(CHAPTER, "Contacts more than coordinates: eight floors at one place under a block, 32 rows on 24 dofs; weight carried, and sinking")
def many_floors(folder):
    def run(kind):
        n = 8
        ran = folder.dyn(scene(folder, {"a": {"as": kind}}, [{"between": ["a.z_min", f"floor{i}"]} for i in range(n)], 10.0, box((1, 1, 1)), ["z_min", "z_max"], 0,
                               walls={f"floor{i}": {"plane": {"point": [0, 0, 0], "normal": [0, 0, 1]}} for i in range(n)},
                               loads=[{"gravity": [0, 0, -0.1]}])).done()
        force = sum(ran[f"contact/a.z_min - floor{i}/force"] for i in range(n))[:, 2]
        sink = max(ran[f"contact/a.z_min - floor{i}/penetration"].max() for i in range(n))
        weight = 0.1 * 1.0
        mean = force[10:].mean()
        return holds(f"{mean / weight:.2f} of the weight, {sink:.0e}", "0.9 to 1.1, 1e-17", 0.9 < mean / weight < 1.1 and sink < 1e-17)
    return both(run)


@row(CHAPTER, "Duplicate contacts: the same two faces under two names; speeds after the impact against one name's")
def duplicate(folder):
    def run(kind):
        part = box((2, 2, 2))
        part.faces["again"] = list(part.faces["x_max"])
        blocks = {"a": {"as": kind, "velocity": [0.1, 0, 0]}, "b": {"as": kind, "position": [1.001, 0, 0]}}
        one = folder.dyn(scene(folder, blocks, PAIR, part=part, interface=["x_min", "x_max", "again"])).done()
        two = folder.dyn(scene(folder, blocks, PAIR + [{"between": ["a.again", "b.x_min"]}], part=part, interface=["x_min", "x_max", "again"])).done()
        p, q = one["instances/b/momentum"], two["instances/b/momentum"]
        return below(np.abs(p - q).max() / np.abs(p).max(), 5e-14)
    return both(run)


@row(CHAPTER, "Closed at the start, at rest: nothing moves")
def closed(folder):
    def run(kind):
        ran = folder.dyn(scene(folder, {"a": {"as": kind}, "b": {"as": kind, "position": [1, 0, 0]}}, PAIR)).done()
        return below(max(abs(ran["instances/a/momentum"]).max(), ran["energy/total"].max()), 0)
    return both(run)


@row(CHAPTER, "Closed at the start, pressed by a speed: momentum, energy gained; impulse and loss over a plastic hit's")
def pressed(folder):
    def run(kind):
        return impact(folder.dyn(scene(folder, {"a": {"as": kind, "velocity": [0.1, 0, 0]}, "b": {"as": kind, "position": [1, 0, 0]}}, PAIR)).done())
    return both(run)


def overlapping(folder, kind, depth, **options):
    return folder.dyn(scene(folder, {"a": {"as": kind}, "b": {"as": kind, "position": [1 - depth, 0, 0]}}, [dict(PAIR[0], **options)]))


@row(CHAPTER, "Initial overlap of 0.2 of a face: kept, with a warning that tells the depth; energy that comes of it")
def overlap(folder):
    def run(kind):
        ran = overlapping(folder, kind, 0.1).done()
        energy = ran["energy/total"].max()
        return holds(f"{'; '.join(ran.warnings())}; energy {energy:.0e}", "a warning with 0.1, 0", ran.warned("overlap by 0.1") and energy == 0)
    return both(run)


@row(CHAPTER, "Deep initial overlap, more than a face")
def deep(folder):
    def run(kind):
        ran = overlapping(folder, kind, 0.7)
        if ran.code == 2:
            return refused(ran, "overlap", "0.7")
        energy = ran.done()["energy/total"].max()
        return holds(f"{'; '.join(ran.warnings()) or 'no warning'}; energy {energy:.0e}", "an error, or a warning with the depth, 0",
                     ran.warned("0.7") and energy == 0)
    return both(run)


@row(CHAPTER, "Deep in a rigid wall at the start")
def deep_in_wall(folder):
    return refused(folder.dyn(scene(folder, {"a": {}}, [{"between": ["a.x_min", "wall"]}], walls={"wall": {"plane": {"point": [0.7, 0, 0], "normal": [1, 0, 0]}}})),
                   "wall", "a.x_min", "0.7")


EXACT_HITS = ("edges half over", 0.5, 0), ("edge on edge", 1, 0), ("corner on corner", 1, 1), ("nodes on edges", 0.25, 0.25)


@row(CHAPTER, "Exact hits: edge on edge, corner on corner, a node on an edge; momentum, energy gained; impulse and loss over a plastic hit's")
def exact_hits(folder):
    answers = []
    for name, y, z in EXACT_HITS:
        for kind in KINDS:
            ran = folder.dyn(scene(folder, {"a": {"as": kind, "velocity": [0.1, 0, 0]}, "b": {"as": kind, "position": [1.001, y, z]}}, PAIR)).done()
            answers.append((f"{name}, {kind}", *impact(ran, mass=reduced_mass(y / 2, z / 2))))
    return answers


@row(CHAPTER, "Sliding off an edge: momentum, energy gained; impulse and loss over a plastic hit's")
def sliding_off(folder):
    def run(kind):
        ran = folder.dyn(scene(folder, {"a": {"as": kind, "velocity": [0, 0, -0.02]}, "b": {"as": kind, "position": [0.5, 0, 1.0], "velocity": [1, 0, -0.1]}},
                               [{"between": ["a.z_max", "b.z_min"]}], 1.0, interface=["z_min", "z_max"])).done()
        return impact(ran, mass=reduced_mass(0.25), speed=0.08, axis=2)
    return both(run)


@row(CHAPTER, "Sliding with friction 1e6: momentum, energy gained; impulse and loss over a plastic hit's; stuck (largest relative slide over the way without friction)")
def friction(folder):
    def slide(kind, friction):
        ran = folder.dyn(scene(folder, {"a": {"as": kind}, "b": {"as": kind, "position": [0, 0, 1.0], "velocity": [0.1, 0, -0.01]}},
                               [{"between": ["a.z_max", "b.z_min"], "friction": friction}], 0.2, interface=["z_min", "z_max"],
                               output={"every": 0.01, "history": ["a.z_max", "b.z_min"]})).done()
        way = (ran["surfaces/b.z_min/mean_position"] - ran["surfaces/a.z_max/mean_position"])[:, 0]
        return ran, np.abs(way - way[0]).max()

    def run(kind):
        (ran, stuck), (_, free) = slide(kind, 1e6), slide(kind, 0.0)
        figure, bound, held = impact(ran, mass=reduced_mass(0.5), body="a", lost=1)  # stuck, it is a plastic hit along the faces
        expected = 0.1 * 0.2  # speed by time: nothing holds them
        return f"{figure}; {stuck / free:.0e}, free {free / expected:.2f}", f"{bound}; 6e-6, 1", held and stuck / free < 6e-6 and abs(free / expected - 1) < 0.01
    return both(run)


@row(CHAPTER, "A fast body in a large step, through the other within one step: no tunnelling")
def fast(folder):
    def run(kind):
        ran = folder.dyn(scene(folder, {"a": {"as": kind, "velocity": [60, 0, 0]}, "b": {"as": kind, "position": [2.5, 0, 0]}}, PAIR, 0.4,
                               output={"every": 0.01, "history": ["a.x_max", "b.x_min"]}))
        if ran.code != 0:
            return refused(ran, "step", code=ran.code)
        gap = (ran.done()["surfaces/b.x_min/mean_position"] - ran["surfaces/a.x_max/mean_position"])[:, 0]
        figure, bound, held = impact(ran, speed=60)
        return f"{figure}; least distance of the faces {gap.min():.0e}", f"{bound}; -4e-14", held and gap.min() > -4e-14
    return both(run)


@row(CHAPTER, "A fast body at a thin wall of elements, in the steps that the wall allows, and in ten thicknesses each (newmark): no tunnelling; how deep the "
              "body's nodes are in the wall at any output, in thicknesses (gaps are linear within a step, so that some is left); thicknesses in a step")
def thin_target(folder):
    answers, thick = [], 0.02
    plate = box((1, 4, 4), (thick, 2, 2))
    for v, name, least in ((20.0, "exact", 0), (20.0, "newmark", 10), (2.0, "newmark", 10)):
        for kind in KINDS:
            h = 10.5 * thick / v
            s = scene(folder, {"a": {"as": kind, "velocity": [v, 0, 0]}}, [{"between": ["a.x_max", "plate.x_min"]}], 20 * h, integrator=name,
                      step=h if least else "auto")
            s["components"]["plate"] = {"mesh": folder.mesh(plate, "plate.msh"), "material": "steel", "reduction": reduction(["x_min"], 4)}
            s["instances"]["plate"] = {"component": "plate", "as": kind, "position": [2.03, -0.5, -0.5]}
            s["output"] = {"every": h, "fields": ["displacement"]}
            ran = folder.dyn(s).done()
            # Plastic hits: impulse of one on what of the wall is before the body, loss of one on all of it
            front, whole = (1 / (1 + 1 / m) for m in (thick, 4 * thick))
            figure, bound, held = impact(ran, mass=front, speed=v, body="plate", lost=whole / front, drift=4e-12 if least else 4e-14)  # of a stiff solve
            gap, wide = distances(ran), v * 20 * h / int(ran.attribute("steps")) / thick
            deep = max(-np.nanmin(gap) / thick, 0)
            answers.append((f"{name}, speed {v:g}, {kind}", f"{figure}; {deep:.1g}; {wide:.2g}", f"{bound}; 1; " + (f"from {least}" if least else "any"),
                            held and deep < 1 and wide >= least and not np.isnan(gap).any()))
    return answers


def distances(ran, n=4):
    """Of the nodes of a's face x_max from the deformed front of the plate of n x n faces, at right angles: outputs x nodes; nan beside the plate."""
    with h5py.File(ran.file.with_suffix(".fields.h5")) as f:
        body, plate = (f[f"grids/{i}/points"][()] for i in (0, 1))
        face = np.flatnonzero(np.isclose(body[:, 0], body[:, 0].max()))
        front = np.flatnonzero(np.isclose(plate[:, 0], plate[:, 0].min()))
        front = front[np.lexsort((plate[front, 1].round(6), plate[front, 2].round(6)))].reshape(n + 1, n + 1)
        quads = [front[np.ix_((j, j + 1), (i, i + 1))].ravel() for j in range(n) for i in range(n)]
        answer = []
        for k in sorted(f["steps"], key=int):
            x, y = (p + f[f"steps/{k}/{g}/displacement"][()] for g, p in ((0, body), (1, plate)))
            answer.append([min((above(y[quad], x[i]) for quad in quads), key=lambda d: (np.isnan(d), d)) for i in face])
    return np.array(answer)


def above(quad, point):
    """Distance of a point from a bilinear face (corners 00 10 01 11), which is before it along x, at right angles to the face there; nan beside the face."""
    at = np.array([0.5, 0.5])
    base, a, b, ab = quad[0], quad[1] - quad[0], quad[2] - quad[0], quad[3] - quad[1] - quad[2] + quad[0]
    for _ in range(8):  # Newton
        miss = (base + a * at[0] + b * at[1] + ab * at[0] * at[1] - point)[1:]
        at = np.clip(at - np.linalg.solve(np.column_stack([a + ab * at[1], b + ab * at[0]])[1:], miss), -2, 3)
    inside = np.abs(miss).max() < 1e-9 and (at > -1e-9).all() and (at < 1 + 1e-9).all()
    normal = np.cross(a + ab * at[1], b + ab * at[0])
    gap = (base + a * at[0] + b * at[1] + ab * at[0] * at[1] - point)[0]
    return gap * normal[0] / np.linalg.norm(normal) if inside else np.nan


@row(CHAPTER, "A stack of 10 blocks on a floor under gravity: load on the floor, penetration over the sag")
def stack(folder):
    def run(kind):
        n, g = 10, 0.01
        blocks = {f"b{i}": {"as": kind, "position": [0, 0, i]} for i in range(n)}
        contact = [{"between": ["b0.z_min", "floor"]}] + [{"between": [f"b{i}.z_max", f"b{i + 1}.z_min"]} for i in range(n - 1)]
        ran = folder.dyn(scene(folder, blocks, contact, 40.0, box((1, 1, 1)), ["z_min", "z_max"], 0, every=1.0,
                               walls={"floor": {"plane": {"point": [0, 0, 0], "normal": [0, 0, 1]}}}, loads=[{"gravity": [0, 0, -g]}])).done()
        force = ran["contact/b0.z_min - floor/force"][:, 2].mean() / (n * g)
        sag, deep = n * n * g / 100 / 2, max(ran[f"contact/b{i}.z_max - b{i + 1}.z_min/penetration"].max() for i in range(n - 1))
        return holds(f"{force:.2f} of the weight, {deep / sag:.0e}", "0.9 to 1.1, 1e-11", 0.9 < force < 1.1 and deep < 1e-11 * sag)
    return both(run)


@row(CHAPTER, "Newton's cradle, five bars: momentum, energy gained; impulse and loss over a plastic hit's; speed of the last bar over the first's")
def cradle(folder):
    def run(kind):
        bar = box((12, 1, 1), (1, 0.1, 0.1))
        bars = {f"b{i}": {"as": kind, "position": [1.0 * i, 0, 0], **({"velocity": [0.1, 0, 0]} if i == 0 else {})} for i in range(5)}
        ran = folder.dyn(scene(folder, bars, [{"between": [f"b{i}.x_max", f"b{i + 1}.x_min"]} for i in range(4)], 0.8, bar, modes=60,
                               material={"poissons_ratio": 0.0})).done()
        figure, bound, held = impact(ran, mass=0.5 * 0.01, body="b4")
        speed = ran["instances/b4/momentum"][-1, 0] / ran["instances/b0/momentum"][0, 0]
        return f"{figure}; {speed:.2f}", f"{bound}; 0.85 to 1.001", held and 0.85 < speed < 1.001
    return both(run)


@row(CHAPTER, "Coincident surfaces of both bodies (one inside the other, exactly): refused or warned of")
def coincident(folder):
    ran = folder.dyn(scene(folder, {"a": {"velocity": [0.1, 0, 0]}, "b": {}}, PAIR))
    if ran.code != 0:
        return refused(ran, "overlap")
    return holds("; ".join(ran.done().warnings()) or "no warning", "an error or a warning", ran.warned("behind the faces"))


@row(CHAPTER, "A body at 1e6 from the origin: its impact against the same at the origin")
def far(folder):
    def run(kind):
        runs = [folder.dyn(scene(folder, {"a": {"as": kind, "position": [x, x, 0], "velocity": [0.1, 0, 0]}, "b": {"as": kind, "position": [x + 1.001, x, 0]}},
                                 PAIR)).done()["instances/b/momentum"] for x in (0.0, 1e6)]
        return below(np.abs(runs[1] - runs[0]).max() / np.abs(runs[0]).max(), 5e-8)
    return both(run)


@row(CHAPTER, "The mesh itself at 1e6 from the origin: its impact against the same at the origin")
def far_mesh(folder):
    def run(kind):
        answer = []
        for x in (0.0, 1e6):
            part = box((2, 2, 2), origin=(x, 0, 0))
            answer.append(folder.dyn(scene(folder, {"a": {"as": kind, "velocity": [0.1, 0, 0]}, "b": {"as": kind, "position": [1.001, 0, 0]}}, PAIR, part=part))
                          .done()["instances/b/momentum"])
        return below(np.abs(answer[1] - answer[0]).max() / np.abs(answer[0]).max(), 5e-8)
    return both(run)


@row(CHAPTER, "Penalty: an impact; momentum, energy gained; impulse and loss over a plastic hit's")
def penalty(folder):
    def run(kind):
        return impact(folder.dyn(scene(folder, {"a": {"as": kind, "velocity": [0.1, 0, 0]}, "b": {"as": kind, "position": [1.001, 0, 0]}},
                                       [dict(PAIR[0], enforcement="penalty")])).done(), 0.02, lost=0)
    return both(run)


@row(CHAPTER, "Mortar on faces that match, are shifted by 1e-12, by half a face, and hardly touch: momentum, energy gained; impulse and loss over a plastic hit's")
def mortar(folder):
    answers = []
    for name, shift in (("match", 0), ("1e-12", 1e-12), ("half a face", 0.25), ("touch by 1e-9", 1 - 1e-9)):
        ran = folder.dyn(scene(folder, {"a": {"velocity": [0.1, 0, 0]}, "b": {"position": [1.001, shift, 0]}}, [dict(PAIR[0], formulation="mortar")])).done()
        answers.append((name, *impact(ran, mass=reduced_mass(shift / 2))))
    return answers


@row(CHAPTER, "Quasi-static modes, steps up to 20 times the critical one, where little is left of the rebound: momentum, energy gained; impulse and loss over a plastic hit's")
def long_steps(folder):
    answers = []
    for cfl in (0.5, 1, 2, 5, 20):
        ran = folder.dyn(scene(folder, {"a": {"velocity": [0.1, 0, 0]}, "b": {"position": [1.001, 0, 0]}}, PAIR, 2.0, every=2.0, modes=12,
                               step={"cfl": cfl}, part=box((3, 3, 3))) | {"time": {"end": 2.0, "step": {"cfl": cfl}}})
        answers.append((f"cfl {cfl}", *impact(ran.done(), lost=0.5 if cfl <= 1 else 1)))
    return answers
