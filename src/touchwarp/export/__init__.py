"""Goals as files for other tools: arrays, glTF with a morph target, displacement textures."""

from touchwarp.export.goal_file import GOAL_SUFFIXES, write_goal
from touchwarp.export.morph_target import write_morph_target
from touchwarp.export.shape_texture import ShapeTexture, paint_texture
from touchwarp.export.texture_image import write_exr, write_png

__all__ = [
    "GOAL_SUFFIXES",
    "ShapeTexture",
    "paint_texture",
    "write_exr",
    "write_goal",
    "write_morph_target",
    "write_png",
]
