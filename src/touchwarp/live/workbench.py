"""The server's workbench: one thread that solves, prepares instant goals and certifies, in turn.

After each change of the scene it makes what the page can use soonest: the bases, coarse, from which
every placement of a virtual object follows at once; then the warp, to the scene's tolerance; then
its certificate. A newer change stops the work that it makes worthless.
"""

from __future__ import annotations

import threading
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

from touchwarp.check import check
from touchwarp.errors import SceneError, TouchwarpError
from touchwarp.goals import goals, validate
from touchwarp.live.document import SceneDocument
from touchwarp.live.messages import (
    Certificate,
    ChangeScene,
    Failed,
    FromServer,
    Progress,
    Saved,
    SceneState,
    Task,
)
from touchwarp.live.picture import Picture, certificate_of, picture_of, state_of
from touchwarp.live.published import Published, publish_bases, publish_warp
from touchwarp.scene import Scene
from touchwarp.warp import AffineBases, TableWarp, WarpSolver, solve_bases

Tell = Callable[[str, float], None]

BASES_TOLERANCE_MM = 0.5
"""While a virtual object is dragged; what is let go of is solved to the scene's own tolerance."""


class _Superseded(Exception):
    """The task's result is no longer wanted."""


class Workbench:
    """One scene, what has been made of it, and the thread that makes it.

    Args:
        document: the scene.
        warp: one that belongs to it, or None to have it solved.
        bases: the same for instant goals.
        folder: an existing one, for files to be served.
        publish: told of progress and, in their order, of new states, from whichever thread; nobody
            changes the scene before it returns.
    """

    def __init__(
        self,
        document: SceneDocument,
        warp: TableWarp | None,
        bases: AffineBases | None,
        folder: Path,
        publish: Callable[[FromServer], None],
        recording: bool = True,
    ) -> None:
        self._document = document
        self._folder = folder
        self._publish = publish
        self._recording = recording
        self._revision = 0
        self._solver: WarpSolver | None = None
        self._changed = threading.Condition()
        self._closing = False
        self._failed_at: dict[Task, int] = {}
        self._news: dict[Task, Progress | Failed] = {}
        self._files: dict[str, Path] = {}
        self._warp: tuple[int, TableWarp, Published] | None = None
        self._bases: tuple[int, AffineBases, Published] | None = None
        self._certificate: tuple[int, Certificate] | None = None
        self._solvable = True
        try:
            self._picture = picture_of(document.scene)
        except SceneError as error:
            # A warp file that travelled without its meshes can be seen, but not solved anew.
            if warp is None:
                raise
            self._solvable = False
            self._why_not = str(error)
            self._picture = Picture.of_meta(warp.meta)
        self._surfaces = dict(self._picture.surfaces)
        if warp is not None:
            self._warp = (0, warp, self._serve(publish_warp(warp, folder)))
        if bases is not None:
            self._bases = (0, bases, self._serve(publish_bases(bases, folder)))
        self._thread = threading.Thread(target=self._work, name="workbench", daemon=True)

    def start(self) -> None:
        """Begin to work on whatever is missing."""
        self._thread.start()

    def finish(self) -> None:
        """Do all the work that is missing, here and now, instead of in the thread.

        Raises:
            SceneError, GoalError, SolveError: a task fails.
        """
        while (task := self._next()) is not None:
            self._run(task, self._revision, self._scene())

    def close(self) -> bool:
        """Stop the work, at its next step; whether that came within a second."""
        with self._changed:
            self._closing = True
            self._revision += 1
            self._changed.notify_all()
        if self._thread.is_alive():
            self._thread.join(timeout=1.0)
        return not self._thread.is_alive()

    @property
    def state(self) -> SceneState:
        """What the page shows."""
        with self._changed:
            now = self._revision
            warp, bases, certificate = self._warp, self._bases, self._certificate
            return state_of(
                self._document,
                self._picture,
                revision=now,
                solvable=self._solvable,
                warp=None if warp is None else warp[2].file,
                warp_current=warp is not None and warp[0] == now,
                bases=None if bases is None or bases[0] > now else bases[2].file,
                certificate=certificate[1] if certificate and certificate[0] == now else None,
                recording=self._recording,
            )

    @property
    def news(self) -> list[Progress | Failed]:
        """What a page that comes now has missed: how far the work is, and what has failed."""
        with self._changed:
            return list(self._news.values())

    def file(self, identity: str) -> Path | None:
        """A published file by its identity; earlier ones too, for a page that is slow to ask."""
        return self._files.get(identity)

    def surface(self, key: str) -> bytes | None:
        """A packed surface by its key; earlier ones too, as with files."""
        return self._surfaces.get(key)

    def change(self, change: ChangeScene) -> int:
        """Change the scene and begin to solve it anew; the revision from which states hold it.

        Raises:
            SceneError, GoalError: the changed scene is no usable one; nothing is changed.
        """
        if not self._solvable:
            raise SceneError(f"This warp can be seen but not solved anew: {self._why_not}")
        with self._changed:
            document = self._document.changed(
                mismatch_weight=change.mismatch_weight, goals=change.goals, poses=change.poses
            )
            if document.text == self._document.text:
                return self._revision
            picture = picture_of(document.scene, self._picture)
            validate(document.scene, goals(document.scene))  # told at once, not by the solve
            same_fields = not change.poses and change.mismatch_weight is None
            self._document, self._picture = document, picture
            self._surfaces |= picture.surfaces
            self._revision = revision = self._revision + 1
            self._news.clear()
            if self._bases is not None:
                if same_fields:
                    self._bases = (revision, *self._bases[1:])
                else:
                    self._bases = None
            if not same_fields:
                self._solver = None
            self._changed.notify_all()
            self._publish(self.state)
        return revision

    def save(self) -> None:
        """Write the changed scene back to its file.

        Raises:
            SceneError, OutputError: see `SceneDocument.save`.
        """
        with self._changed:
            self._document = self._document.save()
            path = self._document.path
            self._publish(self.state)
        self._publish(Saved(path=path.name if path else ""))

    # ------------------------------------------------------------------------- the thread's side

    def _work(self) -> None:
        while True:
            with self._changed:
                task = self._next()
                while task is None and not self._closing:
                    self._changed.wait()
                    task = self._next()
                if self._closing:
                    return
                revision, scene = self._revision, self._scene()
            assert task is not None
            try:
                self._run(task, revision, scene)
            except _Superseded:
                self._solver = None
                continue
            except (TouchwarpError, MemoryError) as error:
                self._solver = None
                self._failed_at[task] = revision
                reason = str(error) or "the machine ran out of memory"
                self._tell(revision, Failed(task=task, reason=reason))
            with self._changed:  # else a newer state may be told before this one
                self._publish(self.state)

    def _tell(self, revision: int, news: Progress | Failed) -> None:
        with self._changed:
            if self._revision == revision:
                self._news[news.task] = news
        self._publish(news)

    def _serve(self, published: Published) -> Published:
        self._files[published.file.identity] = published.path
        return published

    def _scene(self) -> Scene | None:
        return self._document.scene if self._solvable else None

    def _next(self) -> Task | None:
        """What is missing, soonest useful first."""
        now = self._revision
        if not self._solvable:
            return None
        wanted: list[Task] = []
        if self._bases is None and self._picture.affine:
            wanted.append("bases")
        if self._warp is None or self._warp[0] != now:
            wanted.append("solve")
        elif self._certificate is None or self._certificate[0] != now:
            wanted.append("check")
        return next((task for task in wanted if self._failed_at.get(task) != now), None)

    def _run(self, task: Task, revision: int, scene: Scene | None) -> None:
        assert scene is not None

        def tell(step: str, done: float) -> None:
            if self._revision != revision:
                raise _Superseded
            self._tell(revision, Progress(task=task, step=step, done=min(max(done, 0.0), 1.0)))

        if task == "bases":
            tolerance = max(BASES_TOLERANCE_MM, scene.objective.tolerance_mm)
            bases = solve_bases(scene, tolerance_mm=tolerance, progress=tell)
            published = self._serve(publish_bases(bases, self._folder))
            self._accept(revision, bases=(revision, bases, published))
        elif task == "solve":
            warp = self._solve(scene, tell)
            warp = TableWarp(warp.bricks, replace(warp.meta, scene_text=scene.text), warp.solution)
            published = self._serve(publish_warp(warp, self._folder))
            self._accept(revision, warp=(revision, warp, published))
        else:
            assert self._warp is not None
            _, warp, published = self._warp
            found = certificate_of(check(scene, warp, progress=tell), published.file.identity)
            self._accept(revision, certificate=(revision, found))

    def _solve(self, scene: Scene, tell: Tell) -> TableWarp:
        if self._solver is None:
            self._solver = WarpSolver(scene, progress=tell)
            return self._solver.solve()
        return self._solver.solve({prop.name: prop.goal for prop in scene.props}, progress=tell)

    def _accept(
        self,
        revision: int,
        warp: tuple[int, TableWarp, Published] | None = None,
        bases: tuple[int, AffineBases, Published] | None = None,
        certificate: tuple[int, Certificate] | None = None,
    ) -> None:
        with self._changed:
            if self._revision != revision:
                raise _Superseded
            self._warp = warp or self._warp
            self._bases = bases or self._bases
            self._certificate = certificate or self._certificate
            self._news.pop("bases" if bases else "solve" if warp else "check", None)
