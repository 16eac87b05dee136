"""What touchwarp raises.

    TouchwarpError
    ├── SceneError      the scene file, its meshes, its geometry
    ├── GoalError       a retargeting goal that is no usable map
    ├── SolveError      the solver: memory, convergence, numbers out of range
    ├── WarpFileError   a warp file that is truncated, foreign, newer or of another scene
    ├── OutputError     a file that cannot be written
    ├── StudyError      experiments, and recordings of people
    └── LiveError       the page and the server behind it

Every message says what came, what was needed and what to do.
"""


class TouchwarpError(Exception):
    """Any error that a user of touchwarp can cause and mend."""


class SceneError(TouchwarpError):
    """The scene, one of its meshes or their geometry cannot be used."""


class GoalError(TouchwarpError):
    """A retargeting goal is not a usable map."""


class SolveError(TouchwarpError):
    """The equation cannot be solved as asked."""


class WarpFileError(TouchwarpError):
    """A warp file cannot be read, or does not belong to the scene at hand."""


class OutputError(TouchwarpError):
    """A file cannot be written."""


class StudyError(TouchwarpError):
    """An experiment's plan or its data cannot be used."""


class LiveError(TouchwarpError):
    """The page cannot be served or exported."""
