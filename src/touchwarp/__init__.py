"""touchwarp: touch one thing, see another.

A map of space f(x) = x + u(x) shows the hand touching a virtual object exactly when the real hand
touches a prop of another shape, size or pose. A `Scene` goes in; `solve` makes a `TableWarp` of it;
`check` writes the certificate. All lengths are metres in the scene's frame.

    import touchwarp as tw

    scene = tw.load_scene("mug.toml")
    warp = tw.solve(scene)
    shown = warp(hands)  # (..., 3) m, the positions to display
    warp.save("mug.warp")
    print(tw.check(scene, warp).status)

Names are loaded when first used, so that `import touchwarp` costs next to nothing. Three of them,
`goals`, `solve` and `check`, are also the names of rooms (sub-packages): as attributes of
`touchwarp` they are always the functions, and a room's modules are reached by
`from touchwarp.solve.grid import ...`.
"""

from __future__ import annotations

import sys
from importlib import import_module
from types import ModuleType
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from touchwarp.check import Report, check
    from touchwarp.errors import (
        GoalError,
        LiveError,
        OutputError,
        SceneError,
        SolveError,
        StudyError,
        TouchwarpError,
        WarpFileError,
    )
    from touchwarp.export import write_goal
    from touchwarp.goals import Goal, goals
    from touchwarp.scene import (
        AreaPreservingGoal,
        DirectionGoal,
        Fixed,
        Interaction,
        Landmark,
        MatchGoal,
        Objective,
        Outer,
        Patch,
        PlaneProjectionGoal,
        Prop,
        Scene,
        Surface,
        TextureGoal,
        Tracking,
        TransformGoal,
        UvMesh,
        VerticesGoal,
        load_scene,
        read_mesh,
        read_uv_mesh,
    )
    from touchwarp.warp import (
        AffineBases,
        Inverse,
        TableWarp,
        Warp,
        WarpSolver,
        load_warp,
        solve,
        solve_bases,
    )

__version__ = "0.1.0"

_ROOM_OF = {
    "AffineBases": "warp",
    "AreaPreservingGoal": "scene",
    "DirectionGoal": "scene",
    "Fixed": "scene",
    "Goal": "goals",
    "GoalError": "errors",
    "Interaction": "scene",
    "Inverse": "warp",
    "Landmark": "scene",
    "MatchGoal": "scene",
    "LiveError": "errors",
    "Objective": "scene",
    "Outer": "scene",
    "OutputError": "errors",
    "Patch": "scene",
    "PlaneProjectionGoal": "scene",
    "Prop": "scene",
    "Report": "check",
    "Scene": "scene",
    "SceneError": "errors",
    "SolveError": "errors",
    "StudyError": "errors",
    "Surface": "scene",
    "TableWarp": "warp",
    "TextureGoal": "scene",
    "TouchwarpError": "errors",
    "Tracking": "scene",
    "TransformGoal": "scene",
    "UvMesh": "scene",
    "VerticesGoal": "scene",
    "Warp": "warp",
    "WarpFileError": "errors",
    "WarpSolver": "warp",
    "check": "check",
    "goals": "goals",
    "load_scene": "scene",
    "load_warp": "warp",
    "read_mesh": "scene",
    "read_uv_mesh": "scene",
    "solve": "warp",
    "solve_bases": "warp",
    "write_goal": "export",
}

__all__ = [
    "AffineBases",
    "AreaPreservingGoal",
    "DirectionGoal",
    "Fixed",
    "Goal",
    "GoalError",
    "Interaction",
    "Inverse",
    "Landmark",
    "MatchGoal",
    "LiveError",
    "Objective",
    "Outer",
    "OutputError",
    "Patch",
    "PlaneProjectionGoal",
    "Prop",
    "Report",
    "Scene",
    "SceneError",
    "SolveError",
    "StudyError",
    "Surface",
    "TableWarp",
    "TextureGoal",
    "TouchwarpError",
    "Tracking",
    "TransformGoal",
    "UvMesh",
    "VerticesGoal",
    "Warp",
    "WarpFileError",
    "WarpSolver",
    "__version__",
    "check",
    "goals",
    "load_scene",
    "load_warp",
    "read_mesh",
    "read_uv_mesh",
    "solve",
    "solve_bases",
    "write_goal",
]


def __getattr__(name: str) -> Any:
    if name not in _ROOM_OF:
        raise AttributeError(f"module 'touchwarp' has no attribute '{name}'")
    value = getattr(import_module(f"touchwarp.{_ROOM_OF[name]}"), name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})


class _Package(ModuleType):
    """Keeps `touchwarp.solve` the function when Python binds the sub-package of that name."""

    def __setattr__(self, name: str, value: object) -> None:
        if not (name in _ROOM_OF and isinstance(value, ModuleType)):
            super().__setattr__(name, value)


sys.modules[__name__].__class__ = _Package
