"""Functions that open, sample and plot the results of a run of sphecs.

    from sphecs_results import open_run, frame, profile, plot

    run = open_run("runs/quickstart")            # an xarray.Dataset of particles.nc
    now = frame(run, time=1.0, zone="fluid")     # particles of one zone at one time
    u = profile(now, points, "u", h=run.attrs["smoothing_length"])
    plot(run, "pressure", time=1.0).savefig("pressure.png")
"""

from pathlib import Path

import numpy as np
import xarray as xr


def open_run(folder, file="particles.nc", group=None):
    """Opens a dataset of a packed run, or the group of a probe or body; `sphecs pack` packs a run that was killed."""
    path = Path(folder) / file
    if not path.exists():
        raise FileNotFoundError(f"{path} does not exist; `sphecs pack {folder}` creates it from the journal")
    return xr.open_dataset(path, group=group)


def zones(run):
    """Returns the number of each zone by its name."""
    meanings = run.zone.attrs["flag_meanings"].split()
    return dict(zip(meanings, np.atleast_1d(run.zone.attrs["flag_values"]).tolist()))


def frame(run, time, zone=None):
    """Returns the particles of the frame nearest to a time (s), of one zone or of all zones with positions."""
    now = run.sel(time=time, method="nearest").load()
    if zone is None:
        keep = np.isfinite(now.x)
    else:
        keep = now.zone == zones(run)[zone]
    return now.isel(particle=np.flatnonzero(keep))


# Largest amplification of particle noise by a quadratic fit, as in the engine.
MAX_GAIN = 5.0


def profile(now, points, field, h):
    """Samples a field at points (rows of x, y, m) by weighted least squares over the particles within 2h, as probes do.

    Velocities use a quadratic fit where the particles allow one, other fields a linear fit. The result is NaN where
    fewer than four particles are within 2h.
    """
    x = np.stack([now.x.values, now.y.values], axis=1)
    values = now[field].values.astype(float)
    result = np.full(len(points), np.nan)
    for index, point in enumerate(np.asarray(points, dtype=float)):
        offset = (x - point) / h
        q = np.hypot(offset[:, 0], offset[:, 1])
        near = q < 2.0
        if near.sum() < 4:
            continue
        weight = (1 - q[near] / 2) ** 4 * (1 + 2 * q[near])
        first, second = offset[near].T
        linear = [np.ones(near.sum()), first, second]
        weights = fit_weights([*linear, first**2, first * second, second**2], weight) if field in "uvw" else None
        if weights is None or (weights**2).sum() > MAX_GAIN:
            weights = fit_weights(linear, weight)
        if weights is not None:
            result[index] = weights @ values[near]
    return result


def fit_weights(functions, weight):
    """Returns the weight of each particle in a fit at the origin of the basis; None if the fit is singular."""
    basis = np.column_stack(functions)
    moment = basis.T @ (weight[:, None] * basis)
    # A point outside the fluid has neighbours on one side only.
    if np.linalg.cond(moment) > 1e8:
        return None
    return weight * (basis @ np.linalg.inv(moment)[0])


def plot(run, field, time, size=4.0):
    """Draws a scatter plot of a field over the particles of the frame nearest to a time (s), with the walls."""
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
