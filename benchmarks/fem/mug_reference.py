"""A fine finite-element solution for the mug: points and their displacement, with its own error.

    .venv/bin/python mug_reference.py [-o ../results/mug_reference.npz]

Quadratic elements of NGSolve on netgen's tetrahedra between the mug's own triangles, split, and the
outer box: the mug's shape is kept to 0.002 mm. Solved twice, the second time with the
tetrahedra of the greatest estimated error split; their difference is told as the error. The second,
which is saved, is the better one. Both meshes are kept beside the result; the first is used again.
"""

from __future__ import annotations

import argparse
import tempfile
import time
from pathlib import Path

import igl
import ngsolve as ng
import numpy as np
import trimesh
from case import Case
from ngsolve_peer import mesh_around, solve_laplace

import touchwarp as tw
from touchwarp.goals import outer_box
from touchwarp.scene.shapes import make_shape

GOAL = tw.TransformGoal(
    pivot="base", scale=(1.15, 0.9, 1.1), rotation_deg=(0, 0, 8), translation=(0.014, 0, 0)
)


def mug_case(folder: Path) -> Case:
    """The mug, its goal and its box, with no points yet; the mesh file is written to `folder`."""
    surface = make_shape("mug", {})
    file = folder / "mug.stl"
    trimesh.Trimesh(1e3 * surface.vertices, surface.faces, process=False).export(file)
    scene = tw.Scene([tw.Prop("mug", surface, GOAL)], outer=tw.Outer(box_scale=4.0))
    goals = tw.goals(scene)
    none = np.empty((0, 3))
    box = outer_box(scene, goals)
    return Case("mug", file, goals["mug"].matrix, box, none, none, np.empty(0))


def scatter_points(
    surface: tw.Surface, box: np.ndarray, count: int, seed: int = 20
) -> tuple[np.ndarray, np.ndarray]:
    """Points (count, 3) m in Ω, 0.5–150 mm from a surface, evenly over log distance; distances."""
    rng = np.random.default_rng(seed)
    vertices, faces = np.array(surface.vertices), np.array(surface.faces)
    points, distances = np.empty((0, 3)), np.empty(0)
    while len(points) < count:
        near = trimesh.sample.sample_surface(
            trimesh.Trimesh(vertices, faces, process=False), count, seed=int(rng.integers(1 << 30))
        )[0]
        away = rng.normal(size=(count, 3))
        away /= np.linalg.norm(away, axis=1, keepdims=True)
        x = near + away * np.exp(rng.uniform(np.log(5e-4), np.log(0.15), count))[:, None]
        x = x[((x > box[0] + 1e-3) & (x < box[1] - 1e-3)).all(axis=1)]
        x = x[np.abs(igl.fast_winding_number(vertices, faces, x)) < 0.5]
        distance = np.sqrt(igl.point_mesh_squared_distance(x, vertices, faces)[0])
        kept = (distance > 5e-4) & (distance < 0.15)
        points = np.concatenate([points, x[kept]])
        distances = np.concatenate([distances, distance[kept]])
    return points[:count], distances[:count]


def solve(
    mesh: ng.Mesh, case: Case, points: np.ndarray
) -> tuple[list[ng.GridFunction], np.ndarray]:
    """u by quadratic elements: a grid function a component, mm, and (n, 3) m at points (n, 3) m."""
    started = time.perf_counter()
    with ng.TaskManager():
        space, fields = solve_laplace(mesh, case, "multigrid")
        values = 1e-3 * ng.CF(tuple(fields))(mesh(*(1e3 * points.T)))
    seconds = time.perf_counter() - started
    print(f"{mesh.ne} elements, {space.ndof} unknowns, {seconds:.0f} s", flush=True)
    return fields, np.asarray(values).reshape(-1, 3)


def split_worst(mesh: ng.Mesh, fields: list[ng.GridFunction], share: float, kept: Path) -> ng.Mesh:
    """The mesh with a share of its tetrahedra cut in eight, by way of the file `kept`.

    Cut are those where the fields' gradients differ most from their continuous means (Zienkiewicz
    and Zhu), and what keeps their neighbours conforming.
    """
    error = np.zeros(mesh.ne)
    with ng.TaskManager():
        smooth = ng.GridFunction(ng.VectorH1(mesh, order=1))
        for field in fields:
            smooth.Set(ng.grad(field))
            jump = smooth - ng.grad(field)
            error += ng.Integrate(jump * jump, mesh, element_wise=True).NumPy()
    mesh.SetRefinementFlags(error > np.quantile(error, 1 - share))
    mesh.Refine()
    mesh.ngmesh.Save(str(kept))
    return ng.Mesh(str(kept))  # multigrid on one level


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    here = Path(__file__).resolve().parent
    parser.add_argument("-o", type=Path, default=here.parent / "results" / "mug_reference.npz")
    parser.add_argument("--points", type=int, default=40_000)
    parser.add_argument("--face-mm", type=float, default=8.0, help="longest edge after splitting")
    parser.add_argument("--share", type=float, default=0.3, help="of the tetrahedra, to be cut")
    options = parser.parse_args()
    options.o.parent.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory() as folder:
        case = mug_case(Path(folder))
        surface = make_shape("mug", {})
        points, distance = scatter_points(surface, case.box, options.points)
        kept = options.o.with_suffix(".vol")
        if not kept.exists():
            mesh_around(case, options.face_mm).Save(str(kept))
        mesh = ng.Mesh(str(kept))
        fields, coarse = solve(mesh, case, points)
        finer = split_worst(mesh, fields, options.share, options.o.with_suffix(".fine.vol"))
        fine = solve(finer, case, points)[1]
    gap = 1e3 * np.linalg.norm(fine - coarse, axis=1)
    rms, most = float(np.sqrt((gap**2).mean())), float(gap.max())
    print(f"coarse against fine mesh: rms {rms:.4f} mm, max {most:.4f} mm")
    np.savez_compressed(
        options.o,
        V=surface.vertices,
        F=surface.faces,
        matrix=case.matrix,
        box=case.box,
        points=points,
        distance=distance.astype(np.float32),
        displacement=fine,
        refinement_rms_mm=rms,
        refinement_max_mm=most,
    )
    print(f"saved {options.o}")


if __name__ == "__main__":
    main()
