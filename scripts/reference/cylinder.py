#!/usr/bin/env python3
"""Drag, lift and Strouhal number of a cylinder in a box, by finite elements.

The plane incompressible Navier-Stokes equations with the diameter D = 1 and the stream U = 1:

    du/dt + u . grad u = -grad p + (1/Re) lap u,    div u = 0

in a box with uniform inflow, sides that slip and do-nothing outflow. Taylor-Hood elements of third
order, curved at the cylinder; the second-order backward difference in time, with the convection
extrapolated from two steps. Forces are residuals of the discrete equations, tested with a function
that is 1 on the cylinder.

    python3 -m venv fem && fem/bin/pip install ngsolve
    fem/bin/python scripts/reference/cylinder.py            # the box of scenes/cylinder_re200.ron
    fem/bin/python scripts/reference/cylinder.py --upstream 3 --length 10 --width 6

Prints means over whole periods of the second half of the run. With the defaults (some 25 minutes on
one core) the drag is 1.443, the lift 0.747 (root of 2 times its standard deviation), the Strouhal
number 0.2061. From 30 to 60 times they are 1.441, 0.742 and 0.2060.
"""

import argparse
import math
import statistics

import ngsolve as ng
from netgen.occ import Circle, Glue, MoveTo, OCCGeometry


def arguments():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--reynolds", type=float, default=200.0)
    parser.add_argument("--upstream", type=float, default=5.0, help="inlet to centre, D")
    parser.add_argument("--length", type=float, default=15.0, help="D")
    parser.add_argument("--width", type=float, default=15.0, help="D")
    parser.add_argument("--surface", type=float, default=0.06, help="element size at the cylinder, D")
    parser.add_argument("--wake", type=float, default=0.25, help="element size in the wake, D")
    parser.add_argument("--order", type=int, default=3, help="of the velocity")
    parser.add_argument("--step", type=float, default=0.004, help="D/U")
    parser.add_argument("--end", type=float, default=110.0, help="D/U")
    return parser.parse_args()


def mesh_of(given):
    """Returns the mesh, with the boundaries inlet, outlet, side and cylinder."""
    box = MoveTo(-given.upstream, -given.width / 2).Rectangle(given.length, given.width).Face()
    downstream = given.length - given.upstream
    wake = MoveTo(-1.2, -1.8).Rectangle(downstream + 1.2, 3.6).Face()
    fluid = Glue([box - wake, wake - Circle((0, 0), 0.5).Face()])
    for edge in fluid.edges:
        centre = edge.center
        if math.hypot(centre.x, centre.y) < 0.55:
            edge.name, edge.maxh = "cylinder", given.surface
        elif abs(centre.x + given.upstream) < 1e-6:
            edge.name = "inlet"
        elif abs(centre.x - downstream) < 1e-6:
            edge.name = "outlet"
        elif abs(abs(centre.y) - given.width / 2) < 1e-6:
            edge.name = "side"
    for face in fluid.faces:
        if face.mass < 3.6 * (downstream + 1.2):
            face.maxh = given.wake
    mesh = ng.Mesh(OCCGeometry(fluid, dim=2).GenerateMesh(maxh=0.7, grading=0.2))
    mesh.Curve(given.order)
    return mesh


def coefficients(given):
    """Yields time, drag and lift coefficient of every step, and the function for its pressure drag."""
    mesh = mesh_of(given)
    u_space = ng.H1(mesh, order=given.order, dirichlet="inlet|cylinder")
    v_space = ng.H1(mesh, order=given.order, dirichlet="inlet|cylinder|side")
    space = u_space * v_space * ng.H1(mesh, order=given.order - 1)
    print(f"{mesh.ne} elements, {space.ndof} unknowns", flush=True)
    (u, v, p), (a, b, q) = space.TnT()
    grad, dx, step = ng.grad, ng.dx, given.step
    friction = (grad(u) * grad(a) + grad(v) * grad(b)) / given.reynolds
    stokes = (friction - p * (grad(a)[0] + grad(b)[1]) - q * (grad(u)[0] + grad(v)[1])) * dx
    inertia = (u * a + v * b) * dx
    mass, forces = ng.BilinearForm(inertia).Assemble(), ng.BilinearForm(stokes).Assemble()
    system = ng.BilinearForm(1.5 / step * inertia + stokes - 1e-9 * p * q * dx).Assemble()
    inverse = system.mat.Inverse(space.FreeDofs(), inverse="sparsecholesky")
    flow, tests = ng.GridFunction(space), [ng.GridFunction(space) for _ in range(2)]
    for axis, test in enumerate(tests):
        on_cylinder = mesh.BoundaryCF({"cylinder": 1.0}, default=0.0)
        test.components[axis].Set(on_cylinder, definedon=mesh.Boundaries("cylinder"))
    # The potential flow, with a disturbance that starts the shedding.
    x, y = ng.x, ng.y
    squared = (x * x + y * y) ** 2
    flow.components[0].Set(1 - 0.25 * (x * x - y * y) / squared)
    flow.components[1].Set(-0.5 * x * y / squared + 0.2 * ng.exp(-4 * ((x - 1.5) ** 2 + y * y)))
    bounds = ng.GridFunction(space)
    inflow = mesh.BoundaryCF({"inlet": 1.0}, default=0.0)
    bounds.components[0].Set(inflow, definedon=mesh.Boundaries("inlet|cylinder"))
    for index in range(space.ndof):
        if not space.FreeDofs()[index]:
            flow.vec[index] = bounds.vec[index]
    now_u, now_v = flow.components[0], flow.components[1]
    convection = ng.LinearForm(space)
    convection += (now_u * grad(now_u)[0] + now_v * grad(now_u)[1]) * a * dx
    convection += (now_u * grad(now_v)[0] + now_v * grad(now_v)[1]) * b * dx
    convection.Assemble()
    last, before = flow.vec.Copy(), flow.vec.Copy()
    last_convection, before_convection = convection.vec.Copy(), convection.vec.Copy()
    work = flow.vec.CreateVector()

    def pressure_drag():
        # The force of the pressure is inwards, against the direction x/r from the axis.
        surface = ng.ds(definedon=mesh.Boundaries("cylinder"))
        return -2 * ng.Integrate(flow.components[2] * x / ng.sqrt(x * x + y * y) * surface, mesh)

    for index in range(1, round(given.end / step) + 1):
        work.data = mass.mat * (2 / step * last - 0.5 / step * before)
        work.data += before_convection - 2 * last_convection
        work.data -= system.mat * flow.vec
        flow.vec.data += inverse * work
        convection.Assemble()
        work.data = mass.mat * (1.5 / step * flow.vec - 2 / step * last + 0.5 / step * before)
        work.data += forces.mat * flow.vec
        work.data += convection.vec
        drag, lift = (-2 * ng.InnerProduct(work, test.vec) for test in tests)
        before.data, last.data = last, flow.vec
        before_convection.data, last_convection.data = last_convection, convection.vec
        yield index * step, drag, lift, pressure_drag


def main():
    given = arguments()
    rows = []
    pressures = []
    for time, drag, lift, pressure_drag in coefficients(given):
        rows.append((time, drag, lift))
        if len(rows) % 10 == 0:
            pressures.append((time, pressure_drag()))
        if len(rows) % 1000 == 0:
            print(f"t = {time:.2f} D/U: drag {drag:.4f}, lift {lift:.4f}", flush=True)
    rows = [row for row in rows if row[0] >= 0.5 * given.end]
    starts = [later[0] for row, later in zip(rows, rows[1:]) if row[2] < 0 <= later[2]]
    if len(starts) < 2:
        raise SystemExit(f"drag {drag:.4f} at the end; fewer than two periods, give a later --end")
    rows = [row for row in rows if starts[0] <= row[0] <= starts[-1]]
    print(f"drag {statistics.mean(row[1] for row in rows):.4f}")
    pressure = [part for time, part in pressures if starts[0] <= time <= starts[-1]]
    print(f"of it by the pressure {statistics.mean(pressure):.4f}")
    print(f"lift {math.sqrt(2) * statistics.pstdev(row[2] for row in rows):.4f}")
    print(f"Strouhal number {(len(starts) - 1) / (starts[-1] - starts[0]):.4f}")


if __name__ == "__main__":
    main()
