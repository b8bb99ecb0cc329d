# SPDX-License-Identifier: GPL-3.0-or-later
"""Thumbnails of the variations of a solve in the box "Result": made one by one while the window rests, and kept.

They are asked for when they are drawn, never made then; where the view has turned since, they are made again.
"""

import math
from dataclasses import dataclass, field, replace

import bpy
import bpy.utils.previews
import numpy as np
from scipy.spatial.distance import cdist

from ...core.extract.pictures.thumbnails import Seen
from ...core.fields import Pattern
from ..blender.defect_empties import COLORS
from ..blender.timers import Timer
from ..blender.translations import translate
from ..jobs.lru_cache import LruCache
from ..nodes.stripes import INK_BLUE, WARM_IVORY
from ..patterns import memory

# Variations that have one, in a row; pixels across; how large they are drawn, in icons.
MOST, PIXELS, SCALE = 3, 128, 3.6
_BLANK = bpy.types.UILayout.bl_rna.functions["prop"].parameters["icon"].enum_items["BLANK1"].value
# Times the best energy from which on it is not told how much.
_MUCH = 10
# Share of the line ends that may lie elsewhere in variations that look alike.
_MOST_APART = 0.1
# Seconds after the last turn of a view at which its thumbnails follow.
_STILL = 0.3
# The view of an object before its thumbnails are drawn in a window: from its front. Of a turn, as much is not followed.
FRONT, _SAME_VIEW = np.array([[1.0, 0, 0], [0, 0, 1], [0, -1, 0]]), 0.02


@dataclass(frozen=True)
class Variation:
    """A variation in a picture.

    Attributes
    ----------
    number : of :func:`api.vary`
    energy : of what is shown
    more : of the energy of the best one, as a share of that
    defects : dislocations
    picture : (PIXELS, PIXELS, 4) float32, rows from below
    """

    number: int
    energy: float
    more: float
    defects: int
    picture: np.ndarray


@dataclass
class Gallery:
    """The variations of a solve, best first, as far as they are made: of those that look alike the best one.

    Attributes
    ----------
    spacing : line ends that are nearer than half of it to one another count as the same
    view : (3, 3) map of the mesh's space to the right, upwards and towards the viewer
    """

    shown: Pattern
    spacing: float
    view: np.ndarray = field(default_factory=FRONT.copy)
    made: list[Variation] = field(default_factory=list)
    _ends: list[dict[int, np.ndarray]] = field(default_factory=list)
    _old: list[int] = field(default_factory=list)
    _tried: int = 0
    _seen: Seen | None = None

    @property
    def count(self):
        """How many there are, or may be as long as some are not made."""
        return min(len(self.made) + len(self.shown.solution.variations) - self._tried, MOST)

    @property
    def is_complete(self):
        """Whether all are made, as they are seen now."""
        return len(self.made) >= self.count and not self._old

    def look_from(self, view):
        """Make the pictures again if they are of another view."""
        if np.linalg.norm(view - self.view) > _SAME_VIEW * np.linalg.norm(view):
            self.view, self._seen, self._old = view, None, list(range(len(self.made)))

    def make_next(self):
        """Make one more, or what all of them are made from; whether there is more to be done."""
        if self.is_complete:
            return False
        mesh, solution = self.shown.mesh, self.shown.solution
        if self._seen is None:
            self._seen = Seen.of(mesh.vertices, mesh.triangles, PIXELS, self.view)
            return True
        if self._old:
            place = self._old.pop(0)
            varied = self.shown.with_phases(solution.variations[self.made[place].number])
            self.made[place] = replace(self.made[place], picture=self._picture(varied))
            return not self.is_complete
        number, varied = self._tried, self.shown.with_phases(solution.variations[self._tried])
        self._tried += 1
        ends = {sign: mesh.vertices[mesh.triangles[at]].mean(axis=1) for sign, at in _line_ends(varied).items()}
        if any(_are_alike(ends, others, self.spacing) for others in self._ends):
            return not self.is_complete
        self._ends.append(ends)
        energy = varied.energy
        more = energy / solution.energy - 1 if solution.energy > 0 else 0.0
        self.made.append(Variation(number, energy, more, len(varied.dislocations), self._picture(varied)))
        return not self.is_complete

    def _picture(self, varied):
        ends, colours = _line_ends(varied), COLORS["dislocation"]
        dots = [(ends[sign], _seen_colour(colour)) for sign, colour in zip((1, -1), colours, strict=True)]
        ink = self._seen.ink(varied.edge_phases)
        return self._seen.picture(_seen_colour(INK_BLUE), _seen_colour(WARM_IVORY), ink, dots)


class _Galleries:
    """The galleries of the objects that were looked at last, and their pictures as icons."""

    def __init__(self):
        self._kept, self._wanted = LruCache(memory.MOST), None
        self._icons, self._pictured = None, {}
        self._timer, self._rest = Timer(self._make, first=0.05), Timer(_draw_panels, first=_STILL)
        self._handler, self._turns = None, {}

    def register(self):
        """Begin to keep icons, and to notice views that turn."""
        self._icons = bpy.utils.previews.new()
        self._handler = bpy.types.SpaceView3D.draw_handler_add(self._look, (), "WINDOW", "POST_PIXEL")

    def unregister(self):
        """Make nothing more, and give the icons back."""
        bpy.types.SpaceView3D.draw_handler_remove(self._handler, "WINDOW")
        self._timer.stop()
        self._rest.stop()
        self._wanted = None
        bpy.utils.previews.remove(self._icons)

    def of(self, obj, view=None):
        """The gallery of an object's solve, as a (3, 3) ``view`` sees its space, or as before; what of it is missing
        is made when the window rests.

        None where the solve has no pattern or no variations.
        """
        shown = memory.solve_of(obj).pattern
        if shown is None or len(shown.solution.variations) < 2:
            return None
        found = self._kept.get(obj.session_uid)
        if found is None or found.shown.solution is not shown.solution:
            found = Gallery(shown, memory.solve_of(obj).request.spacing)
            self._kept.put(obj.session_uid, found)
        if view is not None:
            found.look_from(view @ np.linalg.inv(memory.solve_of(obj).request.given.stretch))
        if not found.is_complete:
            self._wanted = found
            self._timer.start()
        return found

    def icon(self, obj, variation):
        """Number of the icon of a variation in a picture."""
        name = f"{obj.session_uid} {variation.number}"
        if self._pictured.get(name) is not variation:
            if len(self._icons) >= memory.MOST * MOST:
                self._give_back()
            icon = self._icons[name] if name in self._icons else self._icons.new(name)
            icon.image_size = PIXELS, PIXELS
            icon.image_pixels_float = variation.picture.ravel()
            self._pictured[name] = variation
        return self._icons[name].icon_id

    def _give_back(self):
        """Give back the icons of objects without a gallery: those of the others may be part of what is being drawn."""
        for name in [name for name in self._icons if self._kept.get(int(name.split()[0])) is None]:
            del self._icons[name], self._pictured[name]

    def _look(self):
        """Have the panels drawn again once a view that turned is still."""
        view = bpy.context.region_data
        turn, key = tuple(view.view_rotation), view.as_pointer()
        if self._turns.setdefault(key, turn) != turn:
            self._turns[key] = turn
            self._rest.stop()
            self._rest.start()

    def _make(self):
        goes_on = self._wanted.make_next()
        _draw_panels()
        return 0.02 if goes_on else None


def _draw_panels():
    for window in bpy.context.window_manager.windows:
        for area in window.screen.areas:
            for region in area.regions if area.type == "VIEW_3D" else ():
                if region.type == "UI":
                    region.tag_redraw()


galleries = _Galleries()
register, unregister = galleries.register, galleries.unregister


def draw_variations(layout, obj, result):
    """A picture of each variation of an object's solve, and below it a button that shows it, with what it costs."""
    view = bpy.context.space_data.region_3d.view_matrix @ obj.matrix_world
    gallery = galleries.of(obj, np.array(view.to_3x3()))
    if gallery is None:
        return
    grid = layout.grid_flow(row_major=True, columns=MOST, even_columns=True, align=True)
    for number in range(MOST):
        cell = grid.column(align=True)
        if number >= len(gallery.made):  # the box of a picture to come, or of one that looks like another
            cell.template_icon(icon_value=_BLANK, scale=SCALE)
            cell.label(text="…" if number < gallery.count else "", translate=False)
            continue
        variation = gallery.made[number]
        number = variation.number
        cell.template_icon(icon_value=galleries.icon(obj, variation), scale=SCALE)
        text = _cost(variation)
        is_shown = obj.synch_shown.variation == number and math.isclose(result["energy"], variation.energy)
        cell.operator("synch.variation", text=text, translate=False, depress=is_shown).number = number


def _line_ends(varied):
    """Triangles of the line ends, by their signs."""
    return {sign: [d.triangle for d in varied.dislocations if sign * d.index > 0] for sign in (1, -1)}


def _cost(variation):
    """How much more energy a variation has than the best, short enough for a third of the panel."""
    if variation.number == 0:
        return translate("Best")
    if variation.more >= _MUCH - 1:
        return f">{_MUCH}×"
    return f"+{variation.more:.{int(variation.more < 0.1)}%}"


def _are_alike(first, second, spacing):
    """Whether most line ends of two variations, by their signs, are near to one of the other."""
    apart = []
    for sign in first:
        if (len(first[sign]) == 0) != (len(second[sign]) == 0):
            return False
        if len(first[sign]):
            distances = cdist(first[sign], second[sign])
            apart += [*distances.min(axis=0), *distances.min(axis=1)]
    return np.mean(np.array(apart) > spacing / 2) <= _MOST_APART if apart else True


def _seen_colour(colour):
    """(3,) what a screen shows of a linear colour, about."""
    return np.array(colour[:3]) ** (1 / 2.2)
