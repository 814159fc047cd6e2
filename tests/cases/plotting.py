# SPDX-License-Identifier: GPL-3.0-or-later
"""Pictures of the cases: matplotlib without a window, and one style of axes."""
import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np
from matplotlib.collections import PolyCollection

INK, GREY = "#222222", "#999999"


def bare(axis, which="major"):
    """A light grid at the major ticks or at both kinds, and no frame at the top and at the right."""
    axis.spines[["top", "right"]].set_visible(False)
    axis.grid(True, which, color="#e6e6e6", linewidth=0.6)


def style(axis, title, x, y, which="major"):
    """Bare axes with their title and labels."""
    axis.set_title(title, fontsize=10, loc="left", color=INK)
    axis.set_xlabel(x)
    axis.set_ylabel(y)
    bare(axis, which)


def save(fig, path, dpi=110):
    fig.savefig(path, dpi=dpi)
    plt.close(fig)


def side_view(axis, quads, colours, title):
    """Quads (n x 4 x 3, m) above the floor as seen along y, in mm, near ones last; colours: 4, or n x 4."""
    order = np.argsort(-quads[:, :, 1].mean(axis=1))
    colours = np.broadcast_to(colours, (len(quads), 4))[order]
    axis.add_collection(PolyCollection(1e3 * quads[order][:, :, [0, 2]], facecolor=colours, edgecolor="#ffffff", linewidth=0.25))
    axis.axhline(0, color="#444444", linewidth=1.5)
    axis.set_title(title, fontsize=10, loc="left")
    axis.set_aspect("equal")
    axis.autoscale_view()
    axis.spines[["top", "right"]].set_visible(False)
