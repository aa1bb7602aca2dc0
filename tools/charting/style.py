"""Colours, sizes and files of all charts."""
import matplotlib

matplotlib.use("agg")
import matplotlib.pyplot as plt  # noqa: E402

# Okabe and Ito's colours, which colour-blind people can distinguish; in grey, the markers differ.
COLORS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9", "#000000", "#8C6D31")
MARKERS = ("o", "s", "^", "D", "v", "P", "X", "*")
GUIDE = "#9A9A9A"

plt.rcParams.update({
    "font.family": "DejaVu Sans", "font.size": 10, "axes.titlesize": 11, "axes.labelsize": 10,
    "legend.fontsize": 9, "axes.spines.top": False, "axes.spines.right": False,
    "axes.grid": True, "grid.color": "#E4E4E4", "grid.linewidth": 0.7, "lines.linewidth": 1.4,
    "lines.markersize": 6, "svg.fonttype": "none", "svg.hashsalt": "sightline",
    "figure.facecolor": "white",
})


def panels(rows, columns, width, height, heights=None):
    """A figure and its panels as a list of rows; `heights` are relative heights of the rows."""
    figure, axes = plt.subplots(rows, columns, figsize=(width, height), squeeze=False,
                                constrained_layout=True, height_ratios=heights)
    return figure, axes


def save(figure, out):
    """Writes OUT.svg and OUT.png; the same data give the same bytes."""
    figure.savefig(out + ".svg", bbox_inches="tight", metadata={"Date": None})
    figure.savefig(out + ".png", dpi=110, bbox_inches="tight", metadata={"Software": None})
    plt.close(figure)
