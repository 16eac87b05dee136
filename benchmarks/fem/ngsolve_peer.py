"""NGSolve: quadratic elements on netgen's mesh, graded to the prop's sharp edges.

.venv/bin/python ngsolve_peer.py CASE [--edge-mm 5] [--far-mm 120] [--grading 0.4] [--face-mm 8]

With --face-mm it is netgen's mesh between the prop's own triangles, none longer than that, and the
box: netgen's own surface mesh of a curved prop strays from it, by which no finer one gets better.
"""

from __future__ import annotations

import netgen.meshing as meshing
import ngsolve as ng
import numpy as np
import trimesh
from case import Case, Stopwatch, run_package
from netgen.stl import STLGeometry
from surfaces import split_triangles
from tetrahedra import EDGES, compile_kernels, evaluate, rasterise


def mesh_domain(case: Case, edge_mm: float, far_mm: float, grading: float) -> ng.Mesh:
    """Tetrahedra between prop and box, mm."""
    prop = trimesh.load(case.mesh)
    box = trimesh.creation.box(bounds=1e3 * case.box)
    both = case.mesh.with_name("prop_in_box.stl")
    turned = trimesh.Trimesh(prop.vertices, prop.faces[:, ::-1], process=False)
    trimesh.util.concatenate([box, turned]).export(both)
    wanted = meshing.MeshingParameters(
        maxh=far_mm, minh=0.2 * edge_mm, grading=grading, curvaturesafety=1.5, segmentsperedge=1
    )
    for edge in prop.face_adjacency_edges[prop.face_adjacency_angles > np.radians(30)]:
        start, stop = prop.vertices[edge]
        steps = int(np.ceil(np.linalg.norm(stop - start) / edge_mm))
        for x, y, z in np.linspace(start, stop, steps + 1):
            wanted.RestrictH(x=x, y=y, z=z, h=edge_mm)
    return ng.Mesh(STLGeometry(str(both)).GenerateMesh(wanted))


def mesh_around(case: Case, face_mm: float) -> meshing.Mesh:
    """Tetrahedra between the prop's own triangles, split to edges of `face_mm`, and the box, mm."""
    prop = trimesh.load(split_triangles(trimesh.load(case.mesh), face_mm, case.mesh))
    box = trimesh.creation.box(bounds=1e3 * case.box).subdivide().subdivide().subdivide()
    points = np.concatenate([box.vertices, prop.vertices])
    sides = np.concatenate([box.faces, prop.faces[:, ::-1] + len(box.vertices)])
    mesh = meshing.Mesh(dim=3)
    mesh.AddPoints(np.ascontiguousarray(points))
    mesh.Add(meshing.FaceDescriptor(surfnr=1, domin=1, domout=0, bc=1))
    mesh.AddElements(dim=2, index=1, data=sides.astype(np.int32), base=0)
    mesh.SetMaterial(1, "space")
    mesh.GenerateVolumeMesh(meshing.MeshingParameters(maxh=60, grading=0.4, optsteps3d=2))
    return mesh


def solve_laplace(
    mesh: ng.Mesh, case: Case, preconditioner: str
) -> tuple[ng.H1, list[ng.GridFunction]]:
    """One grid function a component, mm, on a mesh in mm.

    "local" is the fastest preconditioner on good meshes; "multigrid", which factorises the linear
    part, is on meshes with slivers.
    """
    space = ng.H1(mesh, order=2, dirichlet=".*")
    u, v = space.TnT()
    form = ng.BilinearForm(ng.grad(u) * ng.grad(v) * ng.dx, symmetric=True)
    chosen = ng.Preconditioner(form, preconditioner)
    form.Assemble()
    middle, half = 500 * case.box.sum(axis=0), 500 * (case.box[1] - case.box[0])
    axes = (ng.x, ng.y, ng.z)
    inside = ng.CF(1.0)
    for axis, m, h in zip(axes, middle, half, strict=True):
        inside *= ng.IfPos(h * h * (1 - 1e-5) - (axis - m) ** 2, 1.0, 0.0)
    fields = []
    solver = ng.CGSolver(form.mat, chosen.mat, tol=1e-7, maxiter=5000)
    for row in range(3):
        data = sum(float(case.matrix[row, k] - (row == k)) * axes[k] for k in range(3))
        field = ng.GridFunction(space)
        field.Set(inside * (data + 1e3 * float(case.matrix[row, 3])), ng.BND)
        residual = (-form.mat * field.vec).Evaluate()
        free = ng.Projector(space.FreeDofs(), True)
        residual = (free * residual).Evaluate()
        field.vec.data += solver * residual
        fields.append(field)
    return space, fields


def nodal_values(mesh: ng.Mesh, fields: list[ng.GridFunction]) -> tuple[np.ndarray, np.ndarray]:
    """Corners (t, 4, 3) m and values (t, 10, 3) m at corners and middles of edges."""
    reference = np.array([[1, 0, 0], [0, 1, 0], [0, 0, 1], [0, 0, 0]], dtype=float)
    reference = np.concatenate([reference, reference[EDGES].mean(axis=1)])
    rule = ng.IntegrationRule(points=reference.tolist(), weights=[0.1] * 10)
    places = mesh.MapToAllElements(rule, ng.VOL)
    x = 1e-3 * ng.CF((ng.x, ng.y, ng.z))(places).reshape(-1, 10, 3)
    values = 1e-3 * ng.CF(tuple(fields))(places).reshape(-1, 10, 3)
    return np.ascontiguousarray(x[:, :4]), values


def run(
    case: Case, watch: Stopwatch, edge_mm: float, far_mm: float, grading: float, face_mm: float
) -> tuple[np.ndarray, int]:
    compile_kernels()
    watch.restart()
    with ng.TaskManager():
        if face_mm > 0:  # its slivers want a stronger preconditioner
            mesh, preconditioner = ng.Mesh(mesh_around(case, face_mm)), "multigrid"
        else:
            mesh, preconditioner = mesh_domain(case, edge_mm, far_mm, grading), "local"
        watch.lap("mesh")
        space, fields = solve_laplace(mesh, case, preconditioner)
        watch.lap("solve")
        corners, values = nodal_values(mesh, fields)
        rasterise(corners, values, case.table_axes())
        watch.lap("table")
    return evaluate(corners, values, case.points), space.ndof


if __name__ == "__main__":
    run_package("NGSolve P2 + netgen", run, edge_mm=5.0, far_mm=120.0, grading=0.4, face_mm=0.0)
