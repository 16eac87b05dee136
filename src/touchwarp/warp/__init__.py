"""The warp: a table that is evaluated, differentiated, inverted, carried, saved and combined."""

from touchwarp.warp.bases import AffineBases
from touchwarp.warp.bricks import Bricks
from touchwarp.warp.file import load_warp
from touchwarp.warp.plane_table import PlaneTableWarp
from touchwarp.warp.protocol import Inverse, Warp
from touchwarp.warp.solve_bases import solve_bases
from touchwarp.warp.solver import WarpSolver, solve
from touchwarp.warp.table import TableWarp

__all__ = [
    "AffineBases",
    "Bricks",
    "Inverse",
    "PlaneTableWarp",
    "TableWarp",
    "Warp",
    "WarpSolver",
    "load_warp",
    "solve",
    "solve_bases",
]
