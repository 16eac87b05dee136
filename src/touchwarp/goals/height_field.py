"""Prop and virtual object as height fields over one plane."""

from __future__ import annotations

from typing import Literal

import numpy as np
from numpy.typing import NDArray

from touchwarp.errors import GoalError
from touchwarp.goals.line_crossings import ParallelLines, across
from touchwarp.goals.places import spell_direction, spell_point
from touchwarp.goals.surface_tree import SurfaceTree
from touchwarp.scene.surface import Surface

Float = NDArray[np.float64]

# Lengths below this are rounding.
NO_LENGTH = 1e-7


class HeightFields:
    """A prop and a virtual object over a plane, line by line along its normal.

    On a line where the prop reaches from height a to b and the virtual object from a′ to b′, height
    h shows at a′ + (h − a)(b′ − a′)/(b − a). So what is on the prop's surface keeps its projected
    position, and walls along the normal are stretched. A sheet has b = a.

    Args:
        prop: the prop, m, scene frame.
        virtual: the virtual object, m, scene frame.
        normal: (3,) unit vector.
        reach: where both begin and end on a line. A height, m: from that plane to where they lie in
            front of it. "body": from where the line enters to where it leaves. "front": both at the
            last place that the line crosses, seen against the normal the foremost.
        gap: m: how far aside a partner may be looked for.
    """

    def __init__(
        self,
        prop: Surface,
        virtual: Surface,
        normal: Float,
        reach: float | Literal["body", "front"],
        gap: float,
    ) -> None:
        self.normal, self.reach, self.gap = normal, reach, gap
        self._across = across(normal)
        self._prop = ParallelLines(prop, normal)
        self._virtual = ParallelLines(virtual, normal)
        self._shadow = SurfaceTree(self._feet(virtual.vertices), virtual.faces)
        if reach == "body":
            self._check_sheets(prop, virtual)

    def images(self, points: Float) -> Float:
        """g at points (n, 3) m of the prop.

        Raises:
            GoalError: a point has no partner; prop or virtual object lies over itself.
        """
        feet = self._moved_to_shadow(points)
        low, high = self._span(points, self._prop, "prop")
        low_virtual, high_virtual = self._span(feet, self._virtual, "virtual object")
        thick, thick_virtual = high - low, high_virtual - low_virtual
        torn = (thick <= NO_LENGTH) & (thick_virtual > max(self.gap, NO_LENGTH))
        if isinstance(self.reach, float) and torn.any():
            n = int(np.where(torn, thick_virtual, 0.0).argmax())
            raise GoalError(
                f"at {spell_point(points[n])} the prop leaves the patch's plane, but the virtual "
                f"object is {thick_virtual[n] * 1e3:.3g} mm in front of it, which would open a "
                "gap; put the plane where both surfaces meet it in the same curve."
            )
        share = np.clip((points @ self.normal - low) / np.maximum(thick, NO_LENGTH), 0.0, 1.0)
        rise = low_virtual + share * thick_virtual - feet @ self.normal
        return np.asarray(feet + rise[:, None] * self.normal)

    def _span(self, points: Float, lines: ParallelLines, what: str) -> tuple[Float, Float]:
        """From where to where (n,) m a surface reaches on the lines through points (n, 3) m."""
        found = lines.crossings(points)
        places, count = found.places, found.count
        height = points @ self.normal
        if self.reach == "front":
            foremost = np.where(count > 0, found.last, height)
            if lines is self._prop:
                self._check_foremost(points, foremost - height)
            return foremost, foremost
        if isinstance(self.reach, float):
            in_front = places > self.reach + NO_LENGTH
            places = np.sort(np.where(in_front, places, np.nan), axis=1)
            count = in_front.sum(axis=1)
            most, told = 1, "once in front of its plane"
        else:
            most, told = 2, "twice, in and out"
        over = count > most
        if over.any():
            n = int(np.flatnonzero(over)[0])
            raise GoalError(
                f"the {what} is no height field: the line along {spell_direction(self.normal)} "
                f"through {spell_point(points[n])} crosses it {count[n]} times, and so do "
                f"{over.mean():.2g} of all; a height field is crossed at most {told}. Choose "
                "another normal, more patches, or another kind of goal."
            )
        if isinstance(self.reach, float):
            floor = np.full(len(points), self.reach)
            # A point of the prop in the plane itself, or a hair behind, is its own top.
            return floor, np.where(count > 0, places[:, 0], floor)
        low = np.where(count > 0, places[:, 0], height)
        return low, np.where(count > 1, places[:, 1], low)

    def _check_sheets(self, prop: Surface, virtual: Surface) -> None:
        """Raise unless both have one side, or both have two."""
        low, high = self._span(prop.used_vertices, self._prop, "prop")
        low_virtual, high_virtual = self._span(
            virtual.used_vertices, self._virtual, "virtual object"
        )
        thickest = [(high - low).max(), (high_virtual - low_virtual).max()]
        if (thickest[0] <= NO_LENGTH) != (thickest[1] <= NO_LENGTH):
            sheet, body = ("prop", "virtual object")[:: 1 if thickest[0] <= NO_LENGTH else -1]
            raise GoalError(
                f"the {sheet} is a sheet over the plane, but the {body} has two sides, up to "
                f"{max(thickest) * 1e3:.3g} mm apart along {spell_direction(self.normal)}; cut the "
                f"{body} open, or close the {sheet}."
            )

    def _check_foremost(self, points: Float, behind: Float) -> None:
        """Raise where points (n, 3) m of the prop lie (n,) m behind another part of it."""
        n = int(behind.argmax())
        if behind[n] > max(self.gap, NO_LENGTH):
            raise GoalError(
                f"the prop's patch along {spell_direction(self.normal)} is no height field: "
                f"{spell_point(points[n])} lies {behind[n] * 1e3:.3g} mm behind another part of "
                "it. Choose another normal, more patches, or another kind of goal."
            )

    def _feet(self, points: Float) -> Float:
        """(n, 3) m: the points' places in the plane, as the tree of the shadow has them."""
        return np.asarray(np.c_[points @ self._across.T, np.zeros(len(points))])

    def _moved_to_shadow(self, points: Float) -> Float:
        """The points (n, 3) m, moved aside by up to the gap to meet the virtual object."""
        nearest = self._shadow.nearest(self._feet(points))
        alone = nearest.distance > max(self.gap, NO_LENGTH)
        if alone.any():
            n = int(np.where(alone, nearest.distance, 0.0).argmax())
            raise GoalError(
                f"{alone.sum()} of {len(points)} points have no partner: on the line along "
                f"{spell_direction(self.normal)} through {spell_point(points[n])} there is nothing "
                f"of the virtual object, which is {nearest.distance[n] * 1e3:.3g} mm aside. Move "
                "or scale it so that both have one outline over the plane, or choose another kind "
                "of goal."
            )
        aside = np.where(nearest.distance[:, None] > 0, nearest.points - self._feet(points), 0.0)
        return np.asarray(points + aside[:, :2] @ self._across)
