"""What the server and the page say to each other, as JSON; the one source of both sides' types.

`touchwarp.live.typescript` writes them for the page. All lengths are m, matrices are rows, frames
are the scene's. A message that does not fit these models is refused.
"""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import BaseModel, ConfigDict, Field, TypeAdapter

Vector = tuple[float, float, float]
Row = tuple[float, float, float, float]
Matrix = tuple[Row, Row, Row, Row]

Status = Literal["pass", "warn", "fail", "unknown"]
Task = Literal["solve", "bases", "check"]
Asked = Literal["change_scene", "save_scene", "begin_recording", "end_recording", "chunk"]

PARTICIPANT = r"^[A-Za-z0-9][A-Za-z0-9_-]{0,31}$"
"""Pseudonyms: short, and safe as the name of a folder on any system."""
IDENTIFIER = r"^[A-Za-z0-9-]{8,64}$"


class Message(BaseModel):
    """Unknown keys, and numbers that are not finite, are refused."""

    model_config = ConfigDict(extra="forbid", allow_inf_nan=False, frozen=True)


# ---------------------------------------------------------------------------- what the page shows


class Placement(Message):
    """An affine goal as the scene file writes it: pivot + translation + R·S·(x − pivot).

    R = Rz·Ry·Rx of `rotation_deg`; `scale` along the prop's own axes before the turn.
    """

    scale: Vector
    rotation_deg: Vector
    translation: Vector


class Pose(Message):
    """Where a prop stands: R = Rz·Ry·Rx of `rotation_deg`."""

    position: Vector
    rotation_deg: Vector


class PropState(Message):
    """One prop.

    `pose` is the one that the scene file gives it; `pivot` is of the goal, m, scene frame.
    `goal` is the affine goal, scene to scene, or null where the goal is not affine. `placement` is
    the same where the scene file writes it so, and can be changed so; else null.
    """

    name: str
    pose: Pose
    pivot: Vector
    goal: Matrix | None
    placement: Placement | None
    surface: str


class Plane(Message):
    """A fixed plane."""

    name: str
    point: Vector
    normal: Vector


class WarpFile(Message):
    """Where a warp (or bases) can be fetched, as float16 and in byte ranges, and how exact it is.

    `storage_error_mm` is what float16 adds; for bases, over their stated range of goals.
    """

    identity: str
    url: str
    size: int
    estimated_error_max_mm: float | None
    storage_error_mm: float


class CheckLine(Message):
    """One line of the certificate; `where` is the place it is about, `nowhere` why it has none."""

    name: str
    title: str
    subject: str
    group: Literal["hard", "judged", "told"]
    status: Status
    value: str
    limit: str
    where: Vector | None
    nowhere: str
    detail: str
    source: str


class Certificate(Message):
    """The certificate of the warp `identity`."""

    identity: str
    status: Status
    checks: tuple[CheckLine, ...]


class Mark(Message):
    """A threshold to draw on a colour scale, in the scale's unit; null where no number is known."""

    scale: Literal["mismatch", "gain", "error"]
    value: float | None
    label: str
    source: str


class SceneState(Message):
    """The scene as it now is, and what has been made of it."""

    kind: Literal["state"] = "state"
    name: str
    version: str
    revision: int
    live: bool
    solvable: bool
    unsaved: bool
    props: tuple[PropState, ...]
    planes: tuple[Plane, ...]
    outer_box: tuple[Vector, Vector]
    outer_fixed: bool
    mismatch_weight: float
    tolerance_mm: float
    interaction: str
    marks: tuple[Mark, ...]
    warp: WarpFile | None
    warp_current: bool
    bases: WarpFile | None
    certificate: Certificate | None
    recording: bool


class Progress(Message):
    """How far a task is, 0 to 1."""

    kind: Literal["progress"] = "progress"
    task: Task
    step: str
    done: float


class Failed(Message):
    """A task that ended without a result, and why."""

    kind: Literal["failed"] = "failed"
    task: Task
    reason: str


class Changed(Message):
    """The change of this number was taken up: states of this revision, or newer, hold it."""

    kind: Literal["changed"] = "changed"
    number: int
    revision: int


class Saved(Message):
    """The scene file now holds the changed scene."""

    kind: Literal["saved"] = "saved"
    path: str


class Acknowledged(Message):
    """A chunk of a recording is on disk (or was already)."""

    kind: Literal["acknowledged"] = "acknowledged"
    recording: str
    sequence: int


class Finished(Message):
    """A recording is whole on disk."""

    kind: Literal["finished"] = "finished"
    recording: str
    path: str


class Deleted(Message):
    """A recording was deleted, and nothing more of it is kept: the page forgets what it has."""

    kind: Literal["deleted"] = "deleted"
    recording: str


class Refused(Message):
    """A message of the page's that was not carried out, and why.

    `about` is its kind, "chunk" for a binary one, null where that cannot be told.
    """

    kind: Literal["refused"] = "refused"
    about: Asked | None
    reason: str


FromServer = (
    SceneState | Progress | Failed | Changed | Saved | Acknowledged | Finished | Deleted | Refused
)


# ------------------------------------------------------------------------------ what the page asks


class ChangeScene(Message):
    """Change the scene and solve it anew; what is not given stays.

    `number` is the page's own, for the answer to repeat.
    """

    kind: Literal["change_scene"] = "change_scene"
    number: Annotated[int, Field(ge=0)] = 0
    mismatch_weight: Annotated[float, Field(ge=0.0, le=1e6)] | None = None
    goals: dict[str, Placement] = {}
    poses: dict[str, Pose] = {}


class SaveScene(Message):
    """Write the changed scene back to its file."""

    kind: Literal["save_scene"] = "save_scene"


class BeginRecording(Message):
    """The person has consented to this recording, under this pseudonym.

    `columns` names the float64 numbers of each row of the chunks that follow as binary messages.
    """

    kind: Literal["begin_recording"] = "begin_recording"
    recording: Annotated[str, Field(pattern=IDENTIFIER)]
    participant: Annotated[str, Field(pattern=PARTICIPANT)]
    consent: Literal[True]
    started: Annotated[str, Field(max_length=40)]
    columns: Annotated[tuple[Annotated[str, Field(max_length=80)], ...], Field(max_length=4000)]
    device: Annotated[str, Field(max_length=300)]


class EndRecording(Message):
    """The recording has this many chunks; once they are all there it is whole."""

    kind: Literal["end_recording"] = "end_recording"
    recording: Annotated[str, Field(pattern=IDENTIFIER)]
    chunks: Annotated[int, Field(ge=0)]


class ChunkHeader(Message):
    """Begins a binary message: u32 length of this as JSON, this, padding to 8 bytes, float64 rows.

    `warp` is the identity of the warp in use throughout the chunk. `notes` are events in it as
    text, such as "touch audit" lines.
    """

    recording: Annotated[str, Field(pattern=IDENTIFIER)]
    sequence: Annotated[int, Field(ge=0, lt=1_000_000)]
    rows: Annotated[int, Field(ge=0, le=100_000)]
    warp: Annotated[str, Field(max_length=80)]
    notes: tuple[Annotated[str, Field(max_length=2000)], ...] = ()


FromPage = Annotated[
    ChangeScene | SaveScene | BeginRecording | EndRecording,
    Field(discriminator="kind"),
]

FROM_PAGE: TypeAdapter[ChangeScene | SaveScene | BeginRecording | EndRecording] = TypeAdapter(
    FromPage
)
