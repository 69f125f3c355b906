"""Open, sample and plot the results of a run of sphecs.

    from sphecs_results import open_run, frame, profile, plot

    run = open_run("runs/quickstart")            # an xarray.Dataset of particles.nc
    now = frame(run, time=1.0, zone="fluid")     # particles of one zone at one time
    u = profile(now, points, "u", h=run.attrs["smoothing_length"])
    plot(run, "pressure", time=1.0).savefig("pressure.png")
"""

from pathlib import Path

import numpy as np
import xarray as xr


def open_run(folder, file="particles.nc"):
    """Dataset of a packed run (`sphecs pack` packs a run that was killed)."""
    path = Path(folder) / file
    if not path.exists():
        raise FileNotFoundError(f"{path}: not there, `sphecs pack {folder}` makes it from the journal")
    return xr.open_dataset(path)


def zones(run):
    """Numbers of the zones by name."""
    meanings = run.zone.attrs["flag_meanings"].split()
    return dict(zip(meanings, np.atleast_1d(run.zone.attrs["flag_values"]).tolist()))


def frame(run, time, zone=None):
    """The particles of the frame nearest to a time (s), of one zone or of all that are somewhere."""
    now = run.sel(time=time, method="nearest").load()
    if zone is None:
        keep = np.isfinite(now.x)
    else:
        keep = now.zone == zones(run)[zone]
    return now.isel(particle=np.flatnonzero(keep))


def profile(now, points, field, h):
    """A field at points (rows of x, y, m) by weighted least squares of a linear field over the particles within 2h.

    NaN where fewer than four particles are near. Exact for linear fields, as the probes of sphecs are.
    """
    x = np.stack([now.x.values, now.y.values], axis=1)
    values = now[field].values.astype(float)
    result = np.full(len(points), np.nan)
    for index, point in enumerate(np.asarray(points, dtype=float)):
        offset = x - point
        q = np.hypot(offset[:, 0], offset[:, 1]) / h
        near = q < 2.0
        if near.sum() < 4:
            continue
        q = q[near]
        weight = (1 - q / 2) ** 4 * (1 + 2 * q)
        basis = np.column_stack([np.ones(near.sum()), offset[near] / h])
        moment = basis.T @ (weight[:, None] * basis)
        # A point beside the fluid has neighbours on one side only.
        if np.linalg.cond(moment) < 1e8:
            result[index] = np.linalg.solve(moment, basis.T @ (weight * values[near]))[0]
    return result


def plot(run, field, time, size=4.0):
    """A scatter plot of a field over the particles of the frame nearest to a time (s), with the walls."""
    import matplotlib.pyplot as plt

    now = frame(run, time)
    figure, axes = plt.subplots(figsize=(10, 4), layout="constrained")
    if "wall_x" in run:
        axes.scatter(run.wall_x, run.wall_y, s=size, color="0.6", linewidths=0)
    values = np.hypot(now.u, now.v) if field == "speed" else now[field]
    dots = axes.scatter(now.x, now.y, c=values, s=size, linewidths=0)
    units = now.u.units if field == "speed" else now[field].attrs.get("units", "")
    figure.colorbar(dots, ax=axes, label=f"{field} [{units}]")
    axes.set(aspect="equal", xlabel="x [m]", ylabel="y [m]", title=f"t = {float(now.time):.3f} s")
    return figure
