//! Arguments of `export`.

use std::num::NonZeroUsize;
use std::ops::RangeInclusive;
use std::path::{Path, PathBuf};

use clap::Args;

use super::values::{corners, numbers, positive, range, zones};
use sphecs_core::particles::zone::Zone;

/// `sphecs export`.
#[derive(Args, Debug)]
#[command(after_help = "Examples:\n  sphecs export runs/quickstart --vtkhdf\n  \
    sphecs export runs/quickstart --vtu -o quickstart_vtu\n  \
    sphecs export runs/quickstart --grid 1.25e-3 --mean 1,2\n  \
    sphecs export runs/quickstart --tracks --every 2 --box 0.06,-0.01,0.1,0.01\n\n\
    ParaView opens the `.vtkhdf` file, or the `.pvd` file of the folder: both have the times of all frames. A grid is the file that \
    `output: (fields: …)` of a scene writes during a run, from its frames.")]
pub struct ExportArguments {
    /// Run folder
    #[arg(value_name = "RUN")]
    pub run: PathBuf,
    #[command(flatten)]
    #[expect(
        missing_docs,
        reason = "a doc comment on a flattened group would become the help of the command"
    )]
    pub form: FormArguments,
    /// Interval of means and Reynolds stresses on the grid, from the frames in it, s
    #[arg(long, value_name = "FROM,TO", value_parser = range, conflicts_with_all = ["vtu", "vtkhdf", "tracks"])]
    pub mean: Option<(f64, f64)>,
    /// Write every N-th frame only
    #[arg(long, value_name = "N", default_value = "1", conflicts_with_all = ["vtu", "grid"])]
    pub every: NonZeroUsize,
    /// Zones in which particles have tracks; of walls those that move
    #[arg(long, value_name = "ZONE,…", value_delimiter = ',', default_value = "fluid", value_parser = zones(), conflicts_with_all = ["vtu", "vtkhdf", "grid"])]
    pub zones: Vec<Zone>,
    /// Numbers of the particles that have tracks, as `17,100-200` [default: all]
    #[arg(long, value_name = "ID,…", value_delimiter = ',', value_parser = numbers, conflicts_with_all = ["vtu", "vtkhdf", "grid"])]
    pub ids: Vec<RangeInclusive<u32>>,
    /// Lower and upper corner of a box, m, which tracks pass in one of the frames [default:
    /// everywhere]
    #[arg(long, value_name = "X,Y[,Z],X,Y[,Z]", value_parser = corners, conflicts_with_all = ["vtu", "vtkhdf", "grid"], allow_hyphen_values = true)]
    pub r#box: Option<[[f64; 3]; 2]>,
    /// Folder of `--vtu`, or file of the others, to write [default: particles.vtkhdf, vtu,
    /// fields.nc or tracks.nc in the run folder]
    #[arg(short, long, value_name = "PATH")]
    pub output: Option<PathBuf>,
}

/// Form of an export.
#[derive(Args, Debug)]
#[group(required = true, multiple = false)]
pub struct FormArguments {
    /// One VTKHDF file of all frames for ParaView, and one of the walls at rest
    #[arg(long)]
    pub vtkhdf: bool,
    /// VTK unstructured grids, one per frame, with a `.pvd` series for older programs
    #[arg(long)]
    pub vtu: bool,
    /// Fields on a regular grid, NetCDF, with this distance of its nodes, m
    #[arg(long, value_name = "SPACING", value_parser = positive)]
    pub grid: Option<f64>,
    /// Particles as trajectories, NetCDF, one for each piece of fluid
    #[arg(long)]
    pub tracks: bool,
}

impl ExportArguments {
    /// Returns the fault of the path to write; None if its ending is that of the form.
    pub fn fault_of_output(&self) -> Option<String> {
        let path = self.output.as_deref().filter(|path| !path.is_dir())?;
        let (wanted, is_right) = if self.form.vtu {
            ("`--vtu` writes a folder: the name must not end as a file does", !is_file(path))
        } else if self.form.vtkhdf {
            ("the name must end in `.vtkhdf`", has_ending(path, "vtkhdf"))
        } else {
            ("the name must end in `.nc`", has_ending(path, "nc"))
        };
        (!is_right).then(|| format!("`{}`: {wanted}", path.display()))
    }
}

/// Endings of files, by which a folder is not called.
const FILES: [&str; 9] = ["ron", "nc", "csv", "json", "png", "vtu", "vtk", "pvd", "vtkhdf"];

fn is_file(path: &Path) -> bool {
    FILES.iter().any(|ending| has_ending(path, ending))
}

fn has_ending(path: &Path, ending: &str) -> bool {
    path.extension().is_some_and(|found| found.eq_ignore_ascii_case(ending))
}

#[cfg(test)]
mod tests {
    use std::ffi::OsString;

    use super::super::arguments::{Arguments, Command};
    use super::*;

    fn parse(line: &str) -> Result<ExportArguments, String> {
        let words = line.split(' ').map(OsString::from);
        match Arguments::read(words).map_err(|error| error.to_string())?.command {
            Command::Export(export) => Ok(export),
            other => Err(format!("{other:?}")),
        }
    }

    fn refused(line: &str, word: &str) {
        let message = parse(line).map(|export| export.fault_of_output().unwrap_or_default());
        let message = message.unwrap_or_else(|message| message);
        assert!(message.contains(word), "`{line}` gave:\n{message}");
    }

    #[test]
    fn tracks_take_numbers_zones_and_a_box() {
        let export = parse(
            "sphecs export runs/a --tracks --every 5 --ids 17,100-200 --zones fluid,inflow --box -1,0,1,0.5 -o a.nc",
        )
        .expect("an export");
        assert!(export.form.tracks && export.fault_of_output().is_none());
        assert_eq!(export.ids, [17..=17, 100..=200]);
        assert_eq!((export.every.get(), export.zones), (5, vec![Zone::Fluid, Zone::Inflow]));
        let infinite = f64::INFINITY;
        assert_eq!(export.r#box, Some([[-1.0, 0.0, -infinite], [1.0, 0.5, infinite]]));
        let export = parse("sphecs export runs/a --tracks --box 0,0,0,1,1,1").expect("an export");
        assert_eq!(export.r#box, Some([[0.0; 3], [1.0; 3]]));
        assert_eq!(export.zones, [Zone::Fluid]);
    }

    #[test]
    fn invalid_arguments_are_refused_with_the_valid_ones() {
        refused("sphecs export runs/a", "--vtu");
        refused("sphecs export runs/a --vtu --tracks", "cannot be used with");
        refused("sphecs export runs/a --vtu -o flow.vtu", "a folder");
        refused("sphecs export runs/a --tracks -o flow", "`.nc`");
        refused("sphecs export runs/a --vtkhdf -o flow.nc", "`.vtkhdf`");
        refused("sphecs export runs/a --grid 1 --every 2", "cannot be used with");
        refused("sphecs export runs/a --tracks --ids 9-3", "above");
        refused("sphecs export runs/a --tracks --ids 1.5", "whole number");
        refused("sphecs export runs/a --tracks --box 0,0,1", "corner");
        refused("sphecs export runs/a --tracks --box 0,1,1,1", "along y");
        refused("sphecs export runs/a --tracks --zones reservoir", "outflow");
        refused("sphecs export runs/a --tracks --every 0", "--every");
        refused("sphecs export runs/a --vtu --ids 3", "cannot be used with");
        refused("sphecs export runs/a --tracks --mean 0,1", "cannot be used with");
    }
}
