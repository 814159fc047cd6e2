# SPDX-License-Identifier: GPL-3.0-or-later
"""The least time that a phase can take on this machine: flops that it needs over the rate of dgemm, bytes over the rate of triad,
whichever is longer. docs/benchmarks.md says where each formula comes from. Sizes in bytes, 8 to a number."""
SECOND_CACHE = 2 << 20  # bytes of a core's; set by main from the machine


class Rates:
    """flops(): dgemm; bytes(working set): triad in the second caches or beyond them. Of all threads that the machine has."""

    def __init__(self, rows, second_cache=SECOND_CACHE):
        threads = max(row["threads"] for row in rows)
        self.threads, self.second_cache = threads, second_cache
        self.of = {row["name"]: row["value"] for row in rows if row["threads"] == threads}
        self.single = {row["name"]: row["value"] for row in rows if row["threads"] == 1}

    def flops(self):
        return self.of["dgemm"]

    def bytes(self, working_set):
        return self.of["triad_l2" if working_set < self.threads * self.second_cache else "triad_large"]

    def reading(self, working_set):
        """Bytes a second of what is only read: gemv's rate."""
        return max(self.bytes(working_set), self.of["gemv_l2" if working_set < self.threads * self.second_cache else "gemv_large"])

    def seconds(self, flops=0.0, data=0.0, working_set=None):
        return max(flops / self.flops(), data / self.bytes(data if working_set is None else working_set))


def mesh_step(rates, n_elements, n_nodes):
    """A step of central differences of a mesh of 8-node hexes, lumped mass: the least of
    equal boxes, 288 flops each (Walsh transforms, eight 3 x 3 products, the sums; decisions/full-mesh.md) and no numbers,
    element by element, 2 x 24 x 24 flops and 8 node numbers (4 bytes) each, and
    assembled, the symmetric half of 27 blocks of 3 x 3 a node with a number (4 bytes) each;
    and either way u and v read and written, the mass read: 13 numbers a node."""
    vectors = 13 * 8 * n_nodes
    boxes = rates.seconds(flops=288 * n_elements, data=vectors)
    by_element = rates.seconds(flops=1152 * n_elements, data=32 * n_elements + vectors)
    assembled = rates.seconds(flops=27 * 18 * n_nodes, data=14 * 76 * n_nodes + vectors)
    return min(boxes, by_element, assembled)


def flight_step(rates, n):
    """A jump of a body of n coordinates in diagonal form: q, v read and written, omega read: 5 numbers a coordinate."""
    return rates.seconds(flops=6 * n, data=40 * n)


def contact_step(rates, n, m, rows):
    """A step of two instances of one superelement of n coordinates that move whose m nodes each are in contact,
    `rows` of them active: the flight of both; V's 3 m rows, shared, read once for the end and once for the impulse; half of the
    symmetric response of 3 m dofs read once."""
    data = 2 * 8 * 3 * m * n + 4 * (3 * m) ** 2
    flops = 2 * data / 8 + 2 * rows**2
    return 2 * flight_step(rates, n) + max(flops / rates.flops(), data / rates.reading(data))


def shapes_step(rates, n, m, rows):
    """As contact_step(), of basis characteristic without friction: V's normal rows of m nodes read for
    the gaps and for the impulse, a triangle of the constant factor of `rows` read forward and back."""
    data = 2 * 8 * m * n + 8 * rows**2
    flops = 2 * data / 8
    return 2 * flight_step(rates, n) + max(flops / rates.flops(), data / rates.reading(data))


def reading(rates, size):
    """A file of that many bytes, in the page cache."""
    return size / rates.bytes(1 << 40)


def diagonal_flops(n):
    """(K^, M^) -> omega, V: Cholesky and the two-sided update 7/3 n^3, tridiagonal form 4/3, vectors back 2 and 1 (LAPACK users' guide)."""
    return 20 / 3 * n**3


def reduction(rates, counts):
    """{phase: seconds} of one component without domains."""
    c, k = counts["interface_dofs"], counts["modes"]
    n = c + k
    return {
        "factorisation": counts["factor_flops"] / rates.flops(),
        "factorisation and condensation": (counts["factor_flops"] + counts["front_flops"]) / rates.flops(),
        "condensation": (counts["solve_flops"] + counts["product_flops"]) / rates.flops(),
        # Two triangular solves with a vector for each mode sought, at the least, in blocks; L is read twice
        "fixed-interface modes": rates.seconds(flops=4 * counts["factor_nonzeros"] * max(counts["mode_candidates"], k), data=16 * counts["factor_nonzeros"]),
        "diagonal form": diagonal_flops(n) / rates.flops(),
    }
