"""Figures of a run of the constricted channel (scenes/constricted_r*.ron): python constricted_figures.py RUN

Prints the figures of docs/results.md: flow, largest mean velocity in the throat, pressure drop, and the counts
that must be zero. Means are over 4 to 6 s, or the last third of a shorter run.
"""

import json
import pathlib
import sys

import numpy as np
import pandas as pd
import xarray as xr

V0, D1, RHO = 4.45e-2, 0.0889, 1000.0  # m/s, m, kg/m³: peak of the inflow, its width, density
THROAT = 0.0778  # m, length
BIN = 2.0e-3  # m, size of the cells for the time-averaged velocity


def mean_velocity_in_throat(frames):
    """Returns the largest time average of u over cells of BIN in the throat, m/s, and its position, m."""
    x, y, u = (frames[name].values.ravel() for name in ("x", "y", "u"))
    keep = (frames.zone.values.ravel() == 0) & (x > 0.0) & (x < THROAT)
    cells = pd.DataFrame({"i": np.floor(x[keep] / BIN), "j": np.floor(y[keep] / BIN), "u": u[keep]})
    means = cells.groupby(["i", "j"]).u.agg(["mean", "size"])
    # A cell with few particles is a sample, not an average.
    means = means[means["size"] > 0.5 * means["size"].median()]
    best = means["mean"].idxmax()
    return means["mean"].max(), [(index + 0.5) * BIN for index in best]


def main(folder):
    run = pathlib.Path(folder)
    monitor = pd.read_csv(run / "monitor.csv")
    monitor.columns = [name.split(" [")[0] for name in monitor.columns]
    end = monitor.time.max()
    begin = 4.0 if end >= 5.9 else 2.0 * end / 3.0

    def section(name):
        samples = pd.read_csv(run / "probes" / f"{name}.csv")
        samples.columns = [column.split(" [")[0] for column in samples.columns]
        return samples[samples.time >= begin]

    inlet = 2.0 / 3.0 * V0 * D1 * RHO
    print(f"means from {begin:.2f} to {end:.2f} s")
    print(f"inlet, as prescribed           {inlet:.4f} kg/(m s)")
    counted = monitor[monitor.time >= begin]
    print(f"inlet, crossings / prescribed  {counted.inlet_mass_flow_inlet_0.mean() / inlet:.4f}")
    print(f"outlet, crossings / prescribed {counted.outlet_mass_flow_outlet_0.mean() / inlet:.4f}")
    for name in ("throat_start", "throat_middle", "throat_end", "downstream", "before_outlet"):
        flow = section(name).mass_flow
        print(f"{name:14s} flow / inlet    {flow.mean() / inlet:.4f} (std {flow.std() / inlet:.3f})")
    with xr.open_dataset(run / "particles.nc") as frames:
        largest, (x, y) = mean_velocity_in_throat(frames.sel(time=slice(begin, None)))
    print(f"largest mean u in the throat   {largest:.4f} m/s at x = {x:.3f}, y = {y:.4f} m")
    drop = section("upstream").mean_pressure.mean() - section("throat_end").mean_pressure.mean()
    print(f"pressure drop to throat's end  {drop:.2f} Pa")
    means = pd.read_csv(run / "probes_mean.csv")
    means.columns = [name.split(" [")[0] for name in means.columns]
    axis = means[(means.probe == "axis") & means.x.between(0.0, THROAT)]
    print(f"largest mean u on its axis     {axis.u.max():.4f} m/s (probe `axis`)")
    deviation = monitor.largest_density_deviation
    print(f"largest density deviation      {deviation.max():.4f}, time average {deviation.mean():.4f}")
    print(f"set back onto a wall, total    {monitor.held_at_walls.sum()}")
    print(f"most particles behind a wall   {monitor.through_walls.max()}")
    print(f"most pairs closer than 0.5 Δ   {monitor.close_pairs.max()}")
    summary = json.loads((run / "summary.json").read_text())
    print(f"status {summary['status']}, wall time {summary.get('wall_time', summary.get('wall_time_s'))} s")


if __name__ == "__main__":
    main(sys.argv[1])
