"""The scene: one TOML file, or objects made in code."""

from touchwarp.scene.distance import closest_props
from touchwarp.scene.goal_spec import TransformGoal
from touchwarp.scene.inspect import MeshFacts, describe, inspect_mesh
from touchwarp.scene.interaction import Interaction, Tracking
from touchwarp.scene.mesh_file import read_mesh
from touchwarp.scene.objective import Objective
from touchwarp.scene.pose import pose_matrix
from touchwarp.scene.read import load_scene, parse_scene
from touchwarp.scene.scene import Fixed, Outer, Prop, Scene
from touchwarp.scene.surface import Surface

__all__ = [
    "Fixed",
    "Interaction",
    "MeshFacts",
    "Objective",
    "Outer",
    "Prop",
    "Scene",
    "Surface",
    "Tracking",
    "TransformGoal",
    "closest_props",
    "describe",
    "inspect_mesh",
    "load_scene",
    "parse_scene",
    "pose_matrix",
    "read_mesh",
]
