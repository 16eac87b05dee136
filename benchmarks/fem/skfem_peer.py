"""scikit-fem: quadratic elements on gmsh's mesh, graded to the prop's sharp edges, with pyamg.

.venv/bin/python skfem_peer.py CASE [--edge-mm 5] [--far-mm 120] [--grading 0.4]
"""

from __future__ import annotations

import gmsh
import ngsolve_peer
import numpy as np
import pyamg
import skfem
import trimesh
from case import Case, Stopwatch, run_package
from scipy.sparse.linalg import cg
from skfem.models.poisson import laplace
from tetrahedra import EDGES, compile_kernels, evaluate, rasterise


def mesh_domain(
    case: Case, edge_mm: float, face_mm: float, far_mm: float, grading: float
) -> skfem.MeshTet:
    """Tetrahedra between prop and box, m; by netgen for curved props, on which gmsh's fails."""
    if len(trimesh.load(case.mesh).faces) > 1000:
        mesh = ngsolve_peer.mesh_domain(case, edge_mm, far_mm, grading).ngmesh
        points = 1e-3 * np.array([p.p for p in mesh.Points()])
        nodes = mesh.Elements3D().NumPy()["nodes"][:, :4].astype(np.int64) - 1
        return skfem.MeshTet(np.ascontiguousarray(points.T), np.ascontiguousarray(nodes.T))
    gmsh.initialize()
    try:
        gmsh.option.setNumber("General.Terminal", 0)
        gmsh.merge(str(case.mesh))
        gmsh.model.mesh.classifySurfaces(np.radians(30), True, True, np.radians(180))
        gmsh.model.mesh.createGeometry()
        skin = [tag for _, tag in gmsh.model.getEntities(2)]
        _enclose(1e3 * case.box, skin, far_mm)
        _grade(skin, edge_mm, face_mm, far_mm, grading)
        gmsh.option.setNumber("Mesh.Algorithm3D", 10)
        gmsh.model.mesh.generate(3)
        tags, points, _ = gmsh.model.mesh.getNodes()
        _, nodes = gmsh.model.mesh.getElementsByType(4)
    finally:
        gmsh.finalize()
    number = np.zeros(int(tags.max()) + 1, dtype=np.int64)
    number[tags.astype(np.int64)] = np.arange(len(tags))
    tetrahedra = number[nodes.astype(np.int64)].reshape(-1, 4)
    used, tetrahedra = np.unique(tetrahedra, return_inverse=True)
    return skfem.MeshTet(
        np.ascontiguousarray(1e-3 * points.reshape(-1, 3)[used].T),
        np.ascontiguousarray(tetrahedra.reshape(-1, 4).T),
    )


def _enclose(box: np.ndarray, skin: list[int], far_mm: float) -> None:
    """A volume between a box (2, 3) mm and the prop's surfaces."""
    geo = gmsh.model.geo
    corner = [geo.addPoint(*box[list(b), [0, 1, 2]], far_mm) for b in np.ndindex(2, 2, 2)]
    line = {}
    for a, b in ((a, a ^ bit) for a in range(8) for bit in (4, 2, 1) if not a & bit):
        line[a, b] = geo.addLine(corner[a], corner[b])
        line[b, a] = -line[a, b]
    walls = []
    for side in (
        (0, 2, 3, 1),
        (4, 5, 7, 6),
        (0, 1, 5, 4),
        (2, 6, 7, 3),
        (0, 4, 6, 2),
        (1, 3, 7, 5),
    ):
        loop = [line[side[k], side[(k + 1) % 4]] for k in range(4)]
        walls.append(geo.addPlaneSurface([geo.addCurveLoop(loop)]))
    geo.addVolume([geo.addSurfaceLoop(walls), geo.addSurfaceLoop(skin)])
    geo.synchronize()


def _grade(skin: list[int], edge_mm: float, face_mm: float, far_mm: float, grading: float) -> None:
    """Size edge_mm at the prop's edges and face_mm on its faces, growing by `grading` a mm."""
    field = gmsh.model.mesh.field
    edges = sorted({t for _, t in gmsh.model.getBoundary([(2, s) for s in skin], False, False)})
    sizes = []
    for kind, tags, size in (("CurvesList", edges, edge_mm), ("SurfacesList", skin, face_mm)):
        near = field.add("Distance")
        field.setNumbers(near, kind, tags)
        field.setNumber(near, "Sampling", 60)
        sizes.append(field.add("MathEval"))
        field.setString(sizes[-1], "F", f"Min({size} + {grading} * F{near}, {far_mm})")
    least = field.add("Min")
    field.setNumbers(least, "FieldsList", sizes)
    field.setAsBackgroundMesh(least)
    for option in ("MeshSizeExtendFromBoundary", "MeshSizeFromPoints", "MeshSizeFromCurvature"):
        gmsh.option.setNumber(f"Mesh.{option}", 0)


def run(
    case: Case,
    watch: Stopwatch,
    edge_mm: float,
    face_mm: float,
    far_mm: float,
    grading: float,
) -> tuple[np.ndarray, int]:
    compile_kernels()
    watch.restart()
    mesh = mesh_domain(case, edge_mm, face_mm, far_mm, grading)
    watch.lap("mesh")
    basis = skfem.Basis(mesh, skfem.ElementTetP2())
    matrix = laplace.assemble(basis)
    x = basis.doflocs.T
    boundary = basis.get_dofs().flatten()
    on_box = (np.abs(x - case.box[0]) < 1e-6) | (np.abs(x - case.box[1]) < 1e-6)
    on_prop = boundary[~on_box[boundary].any(axis=1)]
    u = np.zeros((len(x), 3))
    u[on_prop] = case.goal_displacement(x[on_prop])
    inner = basis.complement_dofs(boundary)
    stiff = matrix[inner][:, inner].tocsr()
    right = -(matrix[inner] @ u)
    cycle = pyamg.smoothed_aggregation_solver(stiff).aspreconditioner()
    for component in range(3):
        u[inner, component], failed = cg(stiff, right[:, component], rtol=1e-7, M=cycle)
        if failed:
            raise RuntimeError(f"Conjugate gradients stopped after {failed} iterations.")
    watch.lap("solve")
    corners = mesh.p.T[mesh.t.T]
    middle = basis.doflocs.T[basis.element_dofs[4:].T]
    wanted = corners[:, EDGES].mean(axis=2)  # scikit-fem numbers the six edges otherwise
    gap = np.abs(middle[:1, None, :] - wanted[:1, :, None]).sum(axis=-1)[0]
    order = gap.argmin(axis=1)
    values = np.concatenate([u[mesh.t.T], u[basis.element_dofs[4:].T[:, order]]], axis=1)
    rasterise(corners, values, case.table_axes())
    watch.lap("table")
    return evaluate(corners, values, case.points), len(x)


if __name__ == "__main__":
    run_package(
        "scikit-fem P2 + gmsh + pyamg", run, edge_mm=5.0, face_mm=15.0, far_mm=120.0, grading=0.4
    )
