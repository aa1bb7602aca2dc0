"""Colours, sizes and files of all charts."""
import json
import os
import re

import matplotlib

matplotlib.use("agg")
import matplotlib.pyplot as plt  # noqa: E402
from matplotlib.lines import Line2D  # noqa: E402

# Okabe and Ito's colours, which colour-blind people can distinguish; in grey, the markers differ.
COLORS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9", "#000000", "#8C6D31")
MARKERS = ("o", "s", "^", "D", "v", "P", "X", "*")
GUIDE = "#8A8A8A"
RIGHT = "#1B6E2D"  # what was never wrong

# The colour and marker of each method, and the colours of heat maps: the reports' pages have the same.
with open(os.path.join(os.path.dirname(os.path.realpath(__file__)), "looks.json"), encoding="utf-8") as looks:
    LOOKS = json.load(looks)

plt.rcParams.update({
    "font.family": "DejaVu Sans", "font.size": 9, "axes.titlesize": 10, "axes.labelsize": 9,
    "legend.fontsize": 8, "axes.spines.top": False, "axes.spines.right": False,
    "axes.grid": True, "grid.color": "#E4E4E4", "grid.linewidth": 0.7, "lines.linewidth": 1.4,
    "lines.markersize": 5.5, "svg.fonttype": "none", "figure.facecolor": "white",
})


def look_of(name):
    """Colour, marker and fill of a method: variants share a colour, in double and single they are hollow."""
    plain = re.sub("[@:].*", "", name)
    for base in (plain, re.sub("-(double|single)$", "", plain)):
        if base in LOOKS["methods"]:
            color, marker = LOOKS["methods"][base]
            return color, marker, color if base == plain else "white"
    color, marker = LOOKS["foreign"][sum(map(ord, plain)) % len(LOOKS["foreign"])]
    return color, marker, color


def plain_text(name):
    """A name of the user's as text: matplotlib takes what is between two dollars for a formula."""
    return name.replace("$", r"\$")


def panels(rows, columns, width, height, heights=None):
    """A figure and its panels as a list of rows; `heights` are relative heights of the rows."""
    figure, axes = plt.subplots(rows, columns, figsize=(width, height), squeeze=False,
                                constrained_layout=True, height_ratios=heights)
    return figure, axes


def method_panel(names, guide=None):
    """A figure of one panel with the looks of all methods below it; `guide` names the grey line."""
    columns = 3 if max(map(len, names)) < 22 else 2
    entries = len(names) + (guide is not None)
    lines = -(-entries // columns)
    figure, ((axes,),) = panels(1, 1, 5.4, 3.5 + 0.16 * lines)
    handles = [Line2D([], [], color=color, marker=marker, mfc=fill, label=plain_text(name), lw=1.2, ms=4.5)
               for name, (color, marker, fill) in ((name, look_of(name)) for name in names)]
    if guide:
        handles.append(Line2D([], [], color=GUIDE, label=guide, ls=(0, (4, 3))))
    figure.legend(handles=handles, loc="upper center", ncol=columns,
                  frameon=False, fontsize=7, bbox_to_anchor=(0.5, 0), columnspacing=1.2,
                  handlelength=2.2, labelspacing=0.35)
    return figure, axes


def save(figure, out, endings=(".svg", ".png")):
    """Writes OUT.svg and OUT.png, each whole or not at all; the same data give the same bytes."""
    # Charts of one page share no ids.
    plt.rcParams["svg.hashsalt"] = os.path.basename(out)
    options = {".svg": {"metadata": {"Date": None}}, ".png": {"dpi": 110, "metadata": {"Software": None}}}
    for ending in endings:
        temporary = f"{out}.{os.getpid()}{ending}"
        try:
            figure.savefig(temporary, bbox_inches="tight", **options[ending])
            os.replace(temporary, out + ending)
        finally:
            if os.path.exists(temporary):
                os.remove(temporary)
    plt.close(figure)
