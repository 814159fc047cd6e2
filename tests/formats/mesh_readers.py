#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Meshes of other programs: .inp, .bdf and .unv files that gmsh wrote, and .med files that libmed wrote, become the same superelement as
gmsh's .msh; sets, surfaces and materials count, and damaged files are refused with one line.
usage: mesh_readers.py CBR_REDUCE CBR_SKIN CBR_DYN FOLDER_OF_MESHES. Exit 77 without h5py or numpy."""
import random
import shutil
import subprocess
import sys
from pathlib import Path

sys.dont_write_bytecode = True
from netcdf3 import Netcdf  # noqa: E402
from running import check_in_turn, ended, h5py, np, run  # noqa: E402

E, NU, RHO = 2.1e11, 0.3, 7850.0
MATERIAL = ["--youngs-modulus", str(E), "--poissons-ratio", str(NU), "--density", str(RHO)]


def reduce(folder, mesh, name, *more, interface="contact", expect=0):
    return run(folder, sys.argv[1], mesh, "--interface", interface, "--modes", "6", *more, "-o", name, expect=expect)


def gmsh(folder, *names, **numbers):
    options = [word for key, value in numbers.items() for word in ("-setnumber", key, str(value))]
    for name in names:
        subprocess.run(["gmsh", "-3", Path(sys.argv[4]) / "block.geo", *options, "-o", name], cwd=folder, check=True,
                       stdout=subprocess.DEVNULL)


def superelement(path):
    with h5py.File(path) as file:
        names = ("matrices/K_cc", "matrices/M_cc", "matrices/eigenvalues", "nodes/id", "nodes/coordinates", "rigid_body/mass")
        faces = {name: file[f"interface/{name}/faces"][()] for name in file.get("interface", {})}
        return {name: file[name][()] for name in names}, faces, dict(file["provenance"].attrs)


def mesh_of(folder, mesh, *sidesets):
    """The mesh as our reader sees it, through cbr-skin, which writes Exodus: blocks, sidesets, nodesets."""
    run(folder, sys.argv[2], mesh, *(word for name in sidesets for word in ("--sideset", name)), "-o", "seen.exo")
    file = Netcdf(folder / "seen.exo")
    ids = file["node_num_map"]
    sides, nodes = {}, {}
    for i, name in enumerate(file.strings("ss_names") if "ss_names" in file else [], 1):
        sides[name] = sorted(zip(file["elem_num_map"][file[f"elem_ss{i}"] - 1], file[f"side_ss{i}"]))
    for i, name in enumerate(file.strings("ns_names") if "ns_names" in file else [], 1):
        nodes[name] = sorted(ids[file[f"node_ns{i}"] - 1]) if f"node_ns{i}" in file else []
    return file.strings("eb_names"), sides, nodes


def check_same(folder, mesh, reference, **options):
    reduce(folder, mesh, "other.cbr.h5", *MATERIAL, interface=options.get("interface", "contact"))
    found, faces, _ = superelement(folder / "other.cbr.h5")
    tolerance = options.get("tolerance", 1e-11)
    for key, values in reference.items():
        np.testing.assert_allclose(found[key], values, rtol=0, atol=tolerance * np.abs(values).max(), err_msg=f"{mesh} {key}")
    return faces


def check_gmsh_files(folder):
    for order in (1, 2):
        gmsh(folder, *(f"h{order}.{suffix}" for suffix in ("msh", "inp", "bdf", "unv", "vtk")), nx=3, ny=2, nz=2, order=order)
        reduce(folder, f"h{order}.msh", "block.cbr.h5", *MATERIAL)
        reference, faces, _ = superelement(folder / "block.cbr.h5")
        for name, found in (("inp", check_same(folder, f"h{order}.inp", reference)),
                            ("unv", check_same(folder, f"h{order}.unv", reference))):
            assert {"contact", "x_max"} <= set(found), (name, found)
            np.testing.assert_array_equal(np.sort(found["contact"], axis=0), np.sort(faces["contact"], axis=0))
    # gmsh's .bdf has eight columns a number, and no names: a property is a surface of the geometry
    blocks, sides, _ = mesh_of(folder, "h1.bdf", "surface_5")
    assert "volume_1" in blocks and len(sides) >= 6, (blocks, sides)
    with_contact = [name for name, faces in sides.items() if len(faces) == 4]
    reference = superelement_of_msh(folder)
    found = [name for name in with_contact if same_interface(folder, name, reference)]
    assert len(found) >= 1, with_contact


def superelement_of_msh(folder):
    reduce(folder, "h1.msh", "block.cbr.h5", *MATERIAL)
    return superelement(folder / "block.cbr.h5")[0]


def same_interface(folder, name, reference):
    reduce(folder, "h1.bdf", "other.cbr.h5", *MATERIAL, interface=name)
    found = superelement(folder / "other.cbr.h5")[0]
    if not np.array_equal(found["nodes/id"], reference["nodes/id"]):
        return False
    np.testing.assert_allclose(found["matrices/K_cc"], reference["matrices/K_cc"], rtol=0,
                               atol=1e-4 * np.abs(reference["matrices/K_cc"]).max())
    return True


# A part as Abaqus/CAE writes it: sets and surfaces of the assembly, faces by their labels, a material, a section.
CAE = """*Heading
** a comment
*Part, name=Part-1
*Node
NODES*Element, type=C3D8R
1, 1, 2, 3, 4, 5, 6,
7, 8
2, 5, 6, 7, 8, 9, 10, 11, 12
*Elset, elset=Set-All, generate
1, 2, 1
*Solid Section, elset=Set-All, material=Steel
,
*End Part
*Assembly, name=Assembly
*Instance, name=Part-1-1, part=Part-1
*End Instance
*Node
1, 9., 9., 9.
*Nset, nset=Reference
1,
*Nset, nset=Corner, instance=Part-1-1
1, 2
*Elset, elset=_Top_S2, internal, instance=Part-1-1
2,
*Elset, elset=_Top_S1, internal, instance=Part-1-1
1,
*Surface, type=ELEMENT, name=Top
_Top_S2, S2
*Surface, type=ELEMENT, name=Bottom
_Top_S1, S1
*Surface, type=ELEMENT, name=Skin
Part-1-1.Set-All,
*End Assembly
*Material, name=Steel
*Density
7850.,
*Elastic
 2.1e+11, 0.3
*Step, name=Load
*Static
*Boundary
Corner, 1, 3
*End Step
"""
# The same two hexes in small, large and free fields.
BDF = """SOL 103
CEND
BEGIN BULK
$ two hexes
PARAM,POST,-1
NODESCHEXA   1       7       1       2       3       4       5       6       +
+       7       8
CHEXA,2,7,5,6,7,8,9,10,+
+,11,12
CQUAD4  11      9       9       10      11      12
PSOLID  7       3
PSHELL  9       3       .1
MAT1*   3               2.1+11                          .3
*       7850.
ASET1,123,9,THRU,12
SPC1    4       123     1       2
ENDDATA
"""
CORNERS = [(x, y, z) for z in (0, 1, 2.5) for x, y in ((0, 0), (1, 0), (1, 0.5), (0, 0.5))]


def write_hand_made(folder):
    inp = "".join(f"{i}, {x}, {y}, {z}\n" for i, (x, y, z) in enumerate(CORNERS, 1))
    (folder / "cae.inp").write_text(CAE.replace("NODES", inp))
    bdf = "".join(f"GRID,{i},,{x:.1f},{y:.1f},{z:.1f}\n" if i % 2 else f"{'GRID*':8}{i:16}{'':16}{x:16.8f}{y:16.8f}\n{'*':8}{z:16.8f}\n"
                  for i, (x, y, z) in enumerate(CORNERS, 1))
    (folder / "hand.bdf").write_text(BDF.replace("NODES", bdf))


def check_sets(folder):
    write_hand_made(folder)
    blocks, sides, nodes = mesh_of(folder, "cae.inp", "Top")
    assert blocks == ["Set-All", "skin.Top"] or blocks[0] == "Set-All", blocks
    assert sides["Top"] == [(2, 6)] and sides["Bottom"] == [(1, 5)], sides  # Exodus's numbers: 5 below, 6 above
    assert len(sides["Skin"]) == 10, sides["Skin"]
    assert nodes == {"Corner": [1, 2]}, nodes
    blocks, sides, nodes = mesh_of(folder, "hand.bdf", "surface_9")
    assert blocks[0] == "volume_7" and sides["surface_9"] == [(2, 6)], (blocks, sides)
    assert nodes == {"aset": [9, 10, 11, 12], "spc_4": [1, 2]}, nodes


def check_materials(folder):
    """Taken from the file without a word, overruled by the scene, and refused where they are of no use."""
    expected = RHO * 1 * 0.5 * 2.5
    for mesh, interface in (("cae.inp", "Top"), ("hand.bdf", "surface_9")):
        reduce(folder, mesh, "own.cbr.h5", interface=interface)
        own, _, provenance = superelement(folder / "own.cbr.h5")
        np.testing.assert_allclose(own["rigid_body/mass"], expected, rtol=1e-12)
        reduce(folder, mesh, "given.cbr.h5", *MATERIAL, interface=interface)
        for key, values in superelement(folder / "given.cbr.h5")[0].items():
            np.testing.assert_array_equal(own[key], values, err_msg=f"{mesh} {key}")
        reduce(folder, mesh, "given.cbr.h5", *MATERIAL[:-1], "1000", interface=interface)
        np.testing.assert_allclose(superelement(folder / "given.cbr.h5")[0]["rigid_body/mass"], 1000 * 1.25, rtol=1e-12)
        # In a scene, with stress recovered from the file's material
        (folder / "scene.yaml").write_text(
            f"components: {{c: {{mesh: {mesh}, reduction: {{interface: [{interface}], modes: 6, recovery: true}}}}}}\n"
            f"instances: {{a: {{component: c, velocity: [1, 0, 0]}}}}\ntime: {{end: 1.0e-5}}\noutput: {{fields: [stress]}}\n")
        run(folder, sys.argv[1], "scene.yaml")
        run(folder, sys.argv[3], "scene.yaml", "-o", "r.h5")
        with h5py.File(folder / "r.h5") as file:
            np.testing.assert_allclose(file["instances/a/momentum"][0], [expected, 0, 0], rtol=1e-12, atol=1e-9)
    text = (folder / "cae.inp").read_text()
    for change, words in ((("*Density\n7850.,\n", ""), "density"), (("2.1e+11, 0.3", "2.1e+11, 0.3, 20.\n 2.0e+11, 0.3, 90."), "temperature"),
                          (("material=Steel", "material=Brass"), "is not defined"), (("*Elastic\n", "*Elastic, type=ORTHO\n"), "ORTHO")):
        (folder / "odd.inp").write_text(text.replace(*change))
        error = reduce(folder, "odd.inp", "odd.cbr.h5", interface="Top", expect=2)
        assert words in error and "odd.inp" in error and error.count("\n") == 1, error
        reduce(folder, "odd.inp", "odd.cbr.h5", *MATERIAL, interface="Top")


def check_refusals(folder):
    text = (folder / "cae.inp").read_text()
    bulk = (folder / "hand.bdf").read_text()
    cases = [("odd.inp", text.replace("C3D8R", "C3D27"), ["odd.inp:", "C3D27", "C3D20"]),
             ("odd.inp", text.replace("*Step", "*Tie, name=t\nTop, Bottom\n*Step"), ["odd.inp:", "*TIE found", "tied: true"]),
             ("odd.inp", text.replace("_Top_S2, S2", "_Top_S2, S9"), ["odd.inp:", "S9"]),
             ("odd.inp", text.replace("_Top_S2, S2", "Nowhere, S2"), ["odd.inp:", "NOWHERE"]),
             ("odd.inp", text.replace("5, 6, 7, 8, 9, 10, 11, 12", "5, 6, 7, 8, 9, 10, 11, 99"), ["element 2", "node 99"]),
             ("odd.inp", text.replace("*End Instance", "1., 0., 0.\n*End Instance"), ["INSTANCE", "position"]),
             ("odd.inp", text.replace("*End Step\n", ""), ["odd.inp:", "*END STEP", "cut short"]),
             ("odd.inp", text[:text.index("*Step")].replace("*End Assembly\n", ""), ["odd.inp:", "*END ASSEMBLY", "cut short"]),
             ("odd.inp", text[:text.index(" 2.1e+11")], ["odd.inp:", "*ELASTIC", "without its data"]),
             ("odd.inp", text.replace("2.1e+11", "2.1x+11"), ["error: odd.inp:", "'2.1x+11' found, expected a finite number"]),
             ("odd.bdf", bulk.replace("ENDDATA\n", ""), ["odd.bdf:", "ENDDATA", "cut short"]),
             ("odd.bdf", bulk[:bulk.index("PSOLID")], ["odd.bdf:", "ENDDATA", "cut short"]),
             ("odd.bdf", bulk.replace("ENDDATA", "RBAR,5,1,2\nENDDATA"), ["odd.bdf:", "RBAR: found", "points"]),
             ("odd.bdf", bulk.replace("MAT1*   3", "MAT8*   3"), ["MAT8", "material"]),
             ("odd.bdf", bulk.replace("+,11,12", "+,11,99"), ["element 2", "node 99"]),
             ("odd.bdf", bulk.replace("GRID,1,,", "GRID,1,4,"), ["coordinate system 4"])]
    for name, changed, words in cases:
        (folder / name).write_text(changed)
        interface = "Top" if name.endswith("inp") else "surface_9"
        error = reduce(folder, name, "odd.cbr.h5", interface=interface, expect=2)
        assert error.count("\n") == 1 and all(word in error for word in words), (words, error)
        assert error.count("odd.") == 1, error  # the file's name once
    # Bulk data alone need no ENDDATA, and an input file no step
    (folder / "whole.bdf").write_text(bulk[bulk.index("$ two"):].replace("ENDDATA\n", ""))
    reduce(folder, "whole.bdf", "whole.cbr.h5", interface="surface_9")
    (folder / "whole.inp").write_text(text[:text.index("*Step")])
    reduce(folder, "whole.inp", "whole.cbr.h5", interface="Top")
    error = run(folder, sys.argv[2], "cae.inp", "--sideset", "Top", "-o", "out.inp", expect=2)
    assert "out.inp" in error and error.count("\n") == 1, error


DECK = """*NODE, NSET=NALL
NODES*ELEMENT, TYPE=C3D8, ELSET=EALL
1, 1, 2, 3, 4, 5, 6, 7, 8
2, 5, 6, 7, 8, 9, 10, 11, 12
*N SET, NSET=TIP
9, 10, 11, 12
*BOUNDARY
TIP, 1, 3
*MATERIAL, NAME=STEEL
*ELASTIC
2.1e11, 0.3
*DENSITY
7850
*DAMPING, ALPHA=0, BETA=1e-5
*PLASTIC
300, 0
*SOLIDSECTION, ELSET=EALL, MATERIAL=STEEL
*PRE-TENSION SECTION, SURFACE=S, NODE=1
*BOUNDARY
TIP, 1, 1
*STEP
*STATIC
*END STEP
"""


def note_of(folder, program, *arguments):
    return [line for line in run(folder, program, *arguments).splitlines() if "warning: component" in line and "not read:" in line]


def check_decks(folder):
    """Blanks inside keywords do not count; what a deck says and is not read is one warning; its damping counts."""
    write_hand_made(folder)
    nodes = "".join(f"{i}, {x}, {y}, {z}\n" for i, (x, y, z) in enumerate(CORNERS, 1))
    deck = DECK.replace("NODES", nodes)
    line = {word: deck.splitlines().index(word) + 1 for word in ("*BOUNDARY", "*PLASTIC", "*STEP")}
    (folder / "deck.inp").write_text(deck)
    told = note_of(folder, sys.argv[1], "deck.inp", "--interface", "TIP", "--modes", "6", "-o", "deck.cbr.h5")
    assert len(told) == 1, told
    for words in (f"*BOUNDARY (line {line['*BOUNDARY']}, and 1 more)", f"*PLASTIC (line {line['*PLASTIC']})", "*PRE-TENSION SECTION (line ",
                  f"*STEP (line {line['*STEP']} and all after it)"):
        assert words in told[0], (words, told)
    assert "DAMPING" not in told[0], told
    for keyword in ("*RIGIDBODY", "*RIGID BODY", "*rigid  body", "*R IGIDBODY"):
        (folder / "odd.inp").write_text(deck.replace("*STEP", f"{keyword}, NSET=TIP, REF NODE=9\n*STEP"))
        error = reduce(folder, "odd.inp", "odd.cbr.h5", interface="TIP", expect=2)
        assert "the reference node 9 is a node of an element" in error and error.count("\n") == 1, error
    at, end = deck.index("*MATERIAL"), deck.index("*SOLIDSECTION")
    (folder / "steel.inp").write_text(deck[at:end])
    (folder / "deck.inp").write_text(f"{deck[:at]}*INCLUDE, INPUT=steel.inp\n{deck[end:]}")
    ratios = {}
    for name, material, component in (("deck", "", ""), ("scene", "materials: {m: {youngs_modulus: 2.1e11, poissons_ratio: 0.3, "
                                                         "density: 7850, damping: {beta: 1.0e-5}}}\n", "material: m, ")):
        for kind in ("mesh", "superelement"):
            reduction = f", reduction: {{interface: [TIP], modes: 6, superelement: {name}.own.h5}}" if kind == "superelement" else ""
            (folder / "scene.yaml").write_text(f"{material}components: {{c: {{{component}mesh: deck.inp{reduction}}}}}\n"
                                               f"instances: {{a: {{component: c, as: {kind}}}}}\ntime: {{end: 1.0e-5}}\n")
            if reduction:
                run(folder, sys.argv[1], "scene.yaml")
            done = ended(folder, sys.argv[3], "scene.yaml", "--modes", "8")
            ratios[name, kind] = [float(row.split(",")[3]) for row in done.stdout.split()[1:]]
    assert max(ratios["scene", "mesh"]) > 0.001, ratios
    for kind in ("mesh", "superelement"):
        assert ratios["deck", kind] == ratios["scene", kind], ratios
    for words in ("up to date", "reducing c (deck.inp)"):
        done = subprocess.run([sys.argv[1], "scene.yaml"], cwd=folder, capture_output=True, text=True, check=True)
        assert words in done.stderr, done.stderr
        (folder / "steel.inp").write_text("** another\n" + deck[at:end])
    # Two materials that are damped unlike each other
    text = deck.replace("*SOLIDSECTION, ELSET=EALL, MATERIAL=STEEL", """*MATERIAL, NAME=SOFT
*ELASTIC
1e9, 0.3
*DENSITY
1000
*ELSET, ELSET=ONE
1
*ELSET, ELSET=TWO
2
*SOLID SECTION, ELSET=ONE, MATERIAL=STEEL
*SOLID SECTION, ELSET=TWO, MATERIAL=SOFT""")
    (folder / "deck.inp").write_text(text)
    (folder / "scene.yaml").write_text("components: {c: {mesh: deck.inp}}\ninstances: {a: {component: c, as: mesh}}\ntime: {end: 1.0e-5}\n")
    error = run(folder, sys.argv[3], "scene.yaml", "--modes", "2", expect=2)
    assert "'SOFT' and 'STEEL' are damped differently" in error, error


BAR_CELLS, BAR_LENGTH, BAR_WIDTH = 6, 1.2, 0.1


def bar(folder, name, density, cards):
    """A bar of hexes without lateral strain along x, its root the set spc_1 and its tip to be joined to node 100 in the middle."""
    nodes = [(i * BAR_LENGTH / BAR_CELLS, y * BAR_WIDTH, z * BAR_WIDTH) for i in range(BAR_CELLS + 1) for y, z in ((0, 0), (1, 0), (1, 1), (0, 1))]
    cells = [[4 * i + j for j in (1, 5, 6, 2, 4, 8, 7, 3)] for i in range(BAR_CELLS)]
    text = "".join(f"GRID,{i},,{x:.6f},{y:.6f},{z:.6f}\n" for i, (x, y, z) in enumerate(nodes + [(BAR_LENGTH, 0.05, 0.05)], 1)).replace("GRID,29,", "GRID,100,")
    text += "".join(f"CHEXA,{i},1,{','.join(map(str, c[:6]))},\n,{c[6]},{c[7]}\n" for i, c in enumerate(cells, 1))
    (folder / name).write_text(text + f"PSOLID,1,1\nMAT1,1,{E:.6E},,0.,{density:.6E}\nSPC1,1,123,1,2,3,4\n{cards}")
    inp = "*NODE\n" + "".join(f"{i},{x},{y},{z}\n" for i, (x, y, z) in enumerate(nodes, 1)) + f"100,{BAR_LENGTH},0.05,0.05\n*ELEMENT,TYPE=C3D8I,ELSET=E\n"
    return (inp + "".join(f"{i},{','.join(map(str, c))}\n" for i, c in enumerate(cells, 1)) + f"*MATERIAL,NAME=M\n*ELASTIC\n{E},0\n*DENSITY\n{density}\n"
            "*SOLID SECTION,ELSET=E,MATERIAL=M\n*NSET,NSET=spc_1\n1,2,3,4\n*NSET,NSET=TIP\n25,26,27,28\n")


def bar_frequencies(folder, mesh, number, reduction=""):
    kind = "superelement" if reduction else "mesh"
    (folder / "bar.yaml").write_text(f"materials: {{m: {{youngs_modulus: {E}, poissons_ratio: 0.3, density: {RHO}}}}}\ncomponents: {{bar: {{mesh: {mesh}, mass: consistent{reduction}}}}}\ninstances: {{a: {{component: bar, as: {kind}}}}}\n"
                                     "boundary: [{instance: a, nodes: spc_1, fix: [x, y, z]}]\n")
    if reduction:
        run(folder, sys.argv[1], "bar.yaml")
    return np.array([float(row.split(",")[2]) for row in ended(folder, sys.argv[3], "bar.yaml", "--modes", str(number), "-o", "bar.h5").stdout.split()[1:]])


def check_points(folder):
    """RBE2 and CONM2 against the matrices of a bar, the same by *RIGID BODY and *MASS, a mass beside its grid, RBE3 as a point of the scene."""
    mass, J = 30.0, np.array([[0.4, 0.1, -0.05], [0.1, 0.5, 0.02], [-0.05, 0.02, 0.6]])
    entries = f"{J[0, 0]},{-J[0, 1]},{J[1, 1]},{-J[0, 2]},{-J[1, 2]},{J[2, 2]}"  # of CONM2: int rho x y dV
    rbe2 = "RBE2,7,100,123456,25,26,27,28\n"
    inp = bar(folder, "bar.bdf", RHO, rbe2 + f"CONM2,8,100,,{mass},,,,,\n,{entries}\n")
    kept = ", reduction: {interface: [spc_1], points: [node_100], modes: 60, superelement: bar.cbr.h5}"
    found = bar_frequencies(folder, "bar.bdf", 40)
    h, area = BAR_LENGTH / BAR_CELLS, BAR_WIDTH**2  # along the axis: linear elements of a rod
    K, M = (np.zeros((BAR_CELLS + 1,) * 2) for _ in "KM")
    for i in range(BAR_CELLS):
        K[i:i + 2, i:i + 2] += E * area / h * np.array([[1, -1], [-1, 1]])
        M[i:i + 2, i:i + 2] += RHO * area * h / 6 * np.array([[2, 1], [1, 2]])
    M[-1, -1] += mass
    along = np.sqrt(np.sort(np.linalg.eigvals(np.linalg.solve(M[1:, 1:], K[1:, 1:])).real)[:2]) / (2 * np.pi)
    for wanted in along:
        assert np.abs(found / wanted - 1).min() < 1e-9, (wanted, found)
    np.testing.assert_allclose(bar_frequencies(folder, "bar.bdf", 40, kept), found, rtol=1e-8)
    rows = f"{J[0, 0]},{J[1, 1]},{J[2, 2]},{J[0, 1]},{J[0, 2]},{J[1, 2]}"
    (folder / "bar.inp").write_text(f"{inp}*RIGID BODY,NSET=TIP,REF NODE=100\n*ELEMENT,TYPE=MASS,ELSET=P\n501,100\n*MASS,ELSET=P\n{mass}\n"
                                    f"*ELEMENT,TYPE=ROTARYI,ELSET=Q\n502,100\n*ROTARY INERTIA,ELSET=Q\n{rows}\n")
    np.testing.assert_allclose(bar_frequencies(folder, "bar.inp", 40), found, rtol=1e-10)
    # Beside its grid: added to the matrices of the superelement, whose last six coordinates are the grid's
    d = np.array([0.3, -0.2, 0.1])
    cross = np.array([[0, -d[2], d[1]], [d[2], 0, -d[0]], [-d[1], d[0], 0]])
    bar(folder, "beside.bdf", RHO, rbe2 + f"CONM2,8,100,,{mass},{d[0]},{d[1]},{d[2]},,\n,{entries}\n")
    found = bar_frequencies(folder, "beside.bdf", 20, kept)
    with h5py.File(folder / "bar.cbr.h5") as file:
        K_cc, M_cc, M_kc = (file[f"matrices/{name}"][()][..., 12:] for name in ("K_cc", "M_cc", "M_kc"))
        omega2 = file["matrices/eigenvalues"][()]
    M_cc = M_cc[12:] + np.block([[mass * np.eye(3), -mass * cross], [mass * cross, J - mass * cross @ cross]])
    K, M = np.diag(np.append(np.zeros(6), omega2)), np.block([[M_cc, M_kc.T], [M_kc, np.eye(len(omega2))]])
    K[:6, :6] = K_cc[12:]
    wanted = np.sqrt(np.sort(np.linalg.eigvals(np.linalg.solve(M, K)).real)[:20]) / (2 * np.pi)
    np.testing.assert_allclose(found, wanted, rtol=1e-8)
    np.testing.assert_allclose(bar_frequencies(folder, "beside.bdf", 20), wanted, rtol=1e-8)
    # RBE3: as a point of the scene
    bar(folder, "mean.bdf", RHO, f"RBE3,7,,100,123456,1.,123,25,26,\n,27,28\nCONM2,8,100,,{mass},,,,,\n,{entries}\n")
    bar(folder, "plain.bdf", RHO, "SET1,3,25,26,27,28\n")
    point = f"{{surface: set_3, at: [{BAR_LENGTH}, 0.05, 0.05], mass: {mass}, inertia: [{J[0, 0]}, {J[1, 1]}, {J[2, 2]}, {J[0, 1]}, {J[1, 2]}, {J[0, 2]}]}}"
    np.testing.assert_array_equal(bar_frequencies(folder, "mean.bdf", 20), bar_frequencies(folder, f"plain.bdf, points: {{p: {point}}}", 20))
    # C3D20R, whose reduced mass is singular: with points the mesh has the exact one, as its superelement has
    gmsh(folder, "quad.inp", nx=3, ny=2, nz=2, order=2)
    text = (folder / "quad.inp").read_text().replace("C3D20", "C3D20R")
    (folder / "quad.inp").write_text(text + "*NODE\n99999,2,0.2,0\n*NSET,NSET=spc_1,ELSET=x_min\n*NSET,NSET=TIP,ELSET=x_max\n*ELEMENT,TYPE=MASS,ELSET=P\n"
                                     "99999,99999\n*MASS,ELSET=P\n500\n*RIGID BODY,NSET=TIP,REF NODE=99999\n")
    quad = "quad.inp, material: m"
    whole = bar_frequencies(folder, quad, 4)
    np.testing.assert_allclose(bar_frequencies(folder, quad, 4, kept.replace("node_100", "node_99999")), whole, rtol=1e-4)
    # Idle points need no interface, rigid ones do, and a file alone says what it lacks
    bar(folder, "idle.bdf", RHO, "RBE3,7,,100,123456,1.,123,25,26,\n,27,28\n")
    assert "points of the deck" not in reduce(folder, "idle.bdf", "idle.cbr.h5", interface="spc_1")
    error = reduce(folder, "bar.bdf", "odd.cbr.h5", interface="spc_1", expect=2)
    assert "bar.bdf:" in error and "keeps 0 of its 4 nodes" in error and "or 'node_100' to reduction.points" in error and error.count("\n") == 1, error
    told = reduce(folder, "bar.bdf", "told.cbr.h5", "--interface", "rbe2_7", interface="spc_1")
    assert "points of the deck that the file does not hold: node_100 (rigid) (mass)" in told, told


def check_texts(folder):
    """A byte order mark counts for nothing, and so do places on the geometry's curves and surfaces; a part of a split mesh is refused."""
    write_hand_made(folder)
    for name, interface in (("cae.inp", "Top"), ("hand.bdf", "surface_9")):
        text = (folder / name).read_bytes()
        reduce(folder, name, "plain.cbr.h5", interface=interface)
        (folder / name).write_bytes(b"\xef\xbb\xbf" + text.replace(b"*Heading\n", b"").replace(b"** a comment\n", b""))
        reduce(folder, name, "marked.cbr.h5", interface=interface)
        for key, values in superelement(folder / "plain.cbr.h5")[0].items():
            np.testing.assert_array_equal(superelement(folder / "marked.cbr.h5")[0][key], values, err_msg=key)
    (folder / "box.geo").write_text('SetFactory("OpenCASCADE");\nBox(1) = {0, 0, 0, 1, 1, 1};\nMesh.MeshSizeMax = 0.5;\n'
                                    'Physical Volume("v") = {1};\nPhysical Surface("contact") = {1};\n')

    def box(name, *options):
        subprocess.run(["gmsh", "-3", "box.geo", *options, "-o", name], cwd=folder, check=True, stdout=subprocess.DEVNULL)
    box("plain.msh")
    reduce(folder, "plain.msh", "plain.cbr.h5", *MATERIAL)
    reference = superelement(folder / "plain.cbr.h5")[0]
    for more in (["-format", "msh22"], ["-format", "msh22", "-bin"], ["-format", "msh41"]):
        box("parametric.msh", *more, "-setnumber", "Mesh.SaveParametric", "1")
        assert (b"$ParametricNodes" in (folder / "parametric.msh").read_bytes()) == ("msh22" in more), more
        check_same(folder, "parametric.msh", reference)
    for more in (["-format", "msh41"], ["-format", "msh22"], ["-format", "msh22", "-bin"], ["-format", "msh22", "-part_ghosts"]):
        box("parted.msh", "-part", "2", *more)
        reduce(folder, "parted.msh", "parted.cbr.h5", *MATERIAL)
        box("parted.msh", "-part", "2", "-part_split", *more)
        for part in ("parted_1.msh", "parted_2.msh"):
            error = reduce(folder, part, "part.cbr.h5", *MATERIAL, expect=2)
            assert "is one file of a mesh that is split into 2" in error and "and holds 1" in error and error.count("\n") == 1, error


def check_names(folder):
    """Names of sets that no results can hold are refused where they are read."""
    gmsh(folder, "plain.msh", nx=1, ny=1, nz=1)
    text = (folder / "plain.msh").read_bytes()
    for name, words in ((b"x\x01max", "holds a control character (code 1)"), (b"x\xe9max", "holds bytes that are not UTF-8"),
                        (b"x\0max", "holds a control character (code 0)"), (b"x\xed\xa0\x80", "not UTF-8"), (b"x\x7f", "(code 127)")):
        (folder / "odd.msh").write_bytes(text.replace(b'"x_max"', b'"' + name + b'"'))
        error = reduce(folder, "odd.msh", "odd.cbr.h5", *MATERIAL, expect=2)
        assert "odd.msh: the name of sideset" in error and words in error and error.count("\n") == 1, error
    (folder / "good.msh").write_bytes(text.replace(b'"x_max"', '"gr\u00fcn \U0001f600"'.encode()))
    reduce(folder, "good.msh", "good.cbr.h5", *MATERIAL)


STEP = "ENS_MAA/mesh/-0000000000000000001-0000000000000000001"


def med(folder, name):
    shutil.copy(Path(__file__).parent / "med" / name, folder / name)
    return folder / name


def check_med(folder):
    """Files of libmed (med/make_med.py) against gmsh's, and what they must hold."""
    for order, name in ((1, "hex8"), (2, "hex20")):
        med(folder, f"{name}.med")
        gmsh(folder, f"{name}.msh", nx=2, ny=1, nz=1, order=order)
        reduce(folder, f"{name}.msh", "block.cbr.h5", *MATERIAL)
        reference, faces, _ = superelement(folder / "block.cbr.h5")
        found = check_same(folder, f"{name}.med", reference)
        assert set(found) == set(faces) == {"contact", "x_max"}, found  # the kept set, and another of the same nodes
        for key, values in faces.items():
            np.testing.assert_array_equal(np.sort(found[key]), np.sort(values), err_msg=key)
    blocks, sides, nodes = mesh_of(folder, "hex8.med", "contact")
    assert blocks[0] == "block" and len(sides["surface"]) == 10, (blocks, sides)
    assert nodes == {"clamp": [1, 3, 5, 8]}, nodes
    for name in ("hex8.med", "hex20.med"):  # a program that does not know that solids are reflected
        with h5py.File(folder / name, "r+") as file:
            for kind, n, order in (("HE8", 8, HEX), ("H20", 20, HEX + [11, 10, 9, 8, 15, 14, 13, 12, 16, 19, 18, 17])):
                if f"{STEP}/MAI/{kind}" in file:
                    cells = file[f"{STEP}/MAI/{kind}/NOD"]
                    cells[:] = cells[:].reshape(n, -1)[order].ravel()
        reduce(folder, name.replace("med", "msh"), "block.cbr.h5", *MATERIAL)
        check_same(folder, name, superelement(folder / "block.cbr.h5")[0])


HEX = [0, 3, 2, 1, 4, 7, 6, 5]


def check_med_sets(folder):
    med(folder, "mixed.med")
    blocks, sides, nodes = mesh_of(folder, "mixed.med", "floor")
    # `roof` is smaller than `all`; each type is a block of its own; numbers as libmed counts them
    assert blocks == ["roof_tet4", "roof_pyramid5", "all_wedge6", "all_hex8", "skin.floor_quad4", "skin.floor_tri3"], blocks
    tet, pyramid, wedge, hexahedron = 7, 8, 9, 10
    assert sides["floor"] == [(wedge, 4), (hexahedron, 5)], sides
    assert sides["floor and wall"] == [(wedge, 1), (wedge, 4), (hexahedron, 5)], sides
    assert nodes == {"ar\u00eate": [1, 4], "clamp": [1, 4, 5, 8], "corner": [10], "edge": [1, 4]}, nodes
    reduce(folder, "mixed.med", "mixed.cbr.h5", *MATERIAL, interface="floor")
    volume = 1 + 1 / 2 + 1 / 6 + 1 / 12  # hexahedron, wedge, pyramid, tetrahedron
    np.testing.assert_allclose(superelement(folder / "mixed.cbr.h5")[0]["rigid_body/mass"], RHO * volume, rtol=1e-12)
    med(folder, "tet10.med")
    reduce(folder, "tet10.med", "tet.cbr.h5", *MATERIAL, interface="floor")
    found, faces, _ = superelement(folder / "tet.cbr.h5")
    np.testing.assert_allclose(found["rigid_body/mass"], RHO / 6, rtol=1e-12)
    assert faces["floor"].shape == (1, 6) and found["matrices/eigenvalues"].min() > 0
    middle = found["nodes/coordinates"][faces["floor"][0]]
    np.testing.assert_allclose(middle[3:], (middle[:3] + middle[[1, 2, 0]]) / 2, atol=1e-15)


def check_med_refusals(folder):
    def changed(change):
        with h5py.File(med(folder, "mixed.med"), "r+") as file:
            change(file)
        error = reduce(folder, "mixed.med", "odd.cbr.h5", *MATERIAL, interface="floor", expect=2)
        assert error.count("\n") == 1 and error.startswith("cbr-reduce: error: mixed.med: "), error
        return error

    def put(name, place, value):
        return lambda file: file[f"{STEP}/{name}"].__setitem__(place, value)

    def cut(name):
        def change(file):
            values = file[f"{STEP}/{name}"][:-1]
            del file[f"{STEP}/{name}"]
            file[f"{STEP}/{name}"] = values
        return change

    for change, words in (
            (put("MAI/HE8/NOD", 3, 13), ["HE8/NOD", "node 13", "1 to 12"]), (put("MAI/HE8/NOD", 3, 0), ["node 0"]),
            (put("MAI/QU4/FAM", 1, -99), ["QU4/FAM", "family -99"]), (put("NOE/FAM", 0, 77), ["NOE/FAM", "family 77"]),
            (cut("MAI/HE8/NOD"), ["HE8/NOD", "7 entries"]), (cut("MAI/QU4/FAM"), ["QU4/FAM", "1 entries, expected 2"]),
            (cut("NOE/COO"), ["NOE/COO", "35 numbers"]), (put("NOE/COO", 0, np.nan), ["finite"]),
            (lambda file: file.move(f"{STEP}/MAI/PE6", f"{STEP}/MAI/P18"), ["P18", "PE6"]),
            (lambda file: file.__delitem__(f"{STEP}/MAI"), ["no elements"]),
            (lambda file: file.copy("ENS_MAA/mesh", "ENS_MAA/other"), ["2 meshes", "mesh, other"]),
            (lambda file: file.copy(STEP, f"{STEP}2"), ["2 times"]),
            (lambda file: file["ENS_MAA/mesh"].attrs.modify("ESP", 2), ["ESP"]),
            (lambda file: file["ENS_MAA/mesh"].attrs.modify("TYP", 1), ["grid"]),
            (lambda file: file["INFOS_GENERALES"].attrs.modify("MAJ", 2), ["MED 2", "medimport"]),
            (lambda file: file.__delitem__("ENS_MAA"), ["no mesh of MED"])):
        error = changed(change)
        assert all(word in error for word in words), (words, error)


def check_cut(folder):
    """Files of gmsh cut between two lines: refused, or it is said that faces and nodes have no solid. Of sets alone nothing tells."""
    for name, interface in (("h1.inp", "Surface5"), ("h1.bdf", "surface_5"), ("h1.unv", "x_max")):
        lines = (folder / name).read_text().splitlines(keepends=True)
        for share in (0.5, 0.6, 0.7, 0.8, 0.9):
            (folder / f"cut{Path(name).suffix}").write_text("".join(lines[: int(share * len(lines))]))
            done = subprocess.run([sys.argv[1], "-q", f"cut{Path(name).suffix}", "--interface", interface, "--modes", "2", *MATERIAL, "-o", "d.cbr.h5"],
                                  cwd=folder, capture_output=True, text=True)
            told = done.returncode == 2 or ": left out: " in done.stderr
            sets_alone = name == "h1.inp" and lines[int(share * len(lines)) - 1].strip() and int(share * len(lines)) > lines.index("*ELSET,ELSET=z_min\n")
            assert told or sets_alone, (name, share, done.stderr)


def check_damage(folder):
    """Cut and changed files: a mesh, or one line with exit code 2."""
    dice = random.Random(1)
    for name, trials in (("cae.inp", 30), ("hand.bdf", 30), ("h1.unv", 6), ("h1.vtk", 6), ("mixed.med", 40)):
        whole = (med(folder, name) if name.endswith("med") else folder / name).read_bytes()
        damaged = folder / f"damaged{Path(name).suffix}"
        for trial in range(trials):
            at = dice.randrange(len(whole))
            changed = whole[:at] if trial % 2 else whole[:at] + bytes([dice.randrange(256)]) + whole[at + 1:]
            damaged.write_bytes(changed)
            done = subprocess.run([sys.argv[1], "-q", damaged.name, "--interface", "Top", "--modes", "2", *MATERIAL, "-o", "d.cbr.h5"],
                                  cwd=folder, capture_output=True, text=True, errors="replace")
            errors = [line for line in done.stderr.splitlines() if "cbr-reduce: error: " in line]
            assert (done.returncode, len(errors)) in ((0, 0), (2, 1)), (name, at, done.stderr)


if __name__ == "__main__":
    check_in_turn(check_gmsh_files, check_sets, check_materials, check_refusals, check_decks, check_points, check_texts,
                  check_names, write_hand_made, check_med, check_med_sets, check_med_refusals, check_cut, check_damage)
