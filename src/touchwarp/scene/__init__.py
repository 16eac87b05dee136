"""The scene: one TOML file, or objects made in code."""

from touchwarp.scene.distance import closest_props
from touchwarp.scene.inspect import MeshFacts, describe, inspect_mesh
from touchwarp.scene.interaction import Interaction, Tracking
from touchwarp.scene.map_goals import AreaPreservingGoal, Landmark, MatchGoal
from touchwarp.scene.mesh_file import read_mesh
from touchwarp.scene.objective import Objective
from touchwarp.scene.pose import pose_matrix
from touchwarp.scene.projection_goals import DirectionGoal, Patch, PlaneProjectionGoal
from touchwarp.scene.read import load_scene, parse_scene
from touchwarp.scene.scene import Fixed, Outer, Prop, Scene
from touchwarp.scene.surface import Surface
from touchwarp.scene.texture_goal import TextureGoal
from touchwarp.scene.transform_goal import TransformGoal
from touchwarp.scene.uv_mesh import UvMesh, read_uv_mesh
from touchwarp.scene.vertices_goal import VerticesGoal

__all__ = [
    "AreaPreservingGoal",
    "DirectionGoal",
    "Fixed",
    "Interaction",
    "Landmark",
    "MatchGoal",
    "MeshFacts",
    "Objective",
    "Outer",
    "Patch",
    "PlaneProjectionGoal",
    "Prop",
    "Scene",
    "Surface",
    "TextureGoal",
    "Tracking",
    "TransformGoal",
    "UvMesh",
    "VerticesGoal",
    "closest_props",
    "describe",
    "inspect_mesh",
    "load_scene",
    "parse_scene",
    "pose_matrix",
    "read_mesh",
    "read_uv_mesh",
]
