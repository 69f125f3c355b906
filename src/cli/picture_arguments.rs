//! Arguments of `sphecs render` and `sphecs plot`.

use std::path::PathBuf;

use clap::Args;

use super::values::{
    colours, count_or_automatic, drawing_file, fields, finite, frame_box, movie_file, positive, range, slice,
    towards_viewer,
};
use sphecs_output::drawing::chart;
use sphecs_output::picture::{Colours, Field, Slice};

/// Default width of a picture, pixels.
const PICTURE_WIDTH: u32 = 1600;

/// Default width of a movie, pixels.
const MOVIE_WIDTH: u32 = 960;

/// `sphecs render`.
#[derive(Args, Debug)]
#[command(after_help = "Examples:\n  \
    sphecs render runs/constricted_r2 --field speed --time 4.65 -o flow.png\n  \
    sphecs render runs/constricted_r2 --mean 3,6 --streamlines -o mean.pdf\n  \
    sphecs render runs/constricted_r2 --field vorticity --box 0.05,0.15,-0.02,0.02 --contours=8 -o wake.png\n  \
    sphecs render runs/constricted_r2 --field pressure --movie pressure.gif --range=-60,60\n  \
    sphecs render runs/pipe_bend --perspective=1,1,2 -o bend.png\n\n\
    With `--all` the pictures are numbered: pressure-0000.png, pressure-0001.png, …")]
pub struct RenderArguments {
    /// Run folder
    #[arg(value_name = "RUN")]
    pub run: PathBuf,
    /// Field to draw
    #[arg(long, default_value = Field::Speed.name(), value_parser = fields())]
    pub field: Field,
    /// Time of the frame, s; the nearest one is drawn, at most one interval away [default: the last
    /// frame]
    #[arg(long, value_name = "T", conflicts_with_all = ["all", "movie", "mean"], value_parser = finite,
        allow_negative_numbers = true)]
    pub time: Option<f64>,
    /// Draw the mean of the frames in this interval, s
    #[arg(long, value_name = "FROM,TO", conflicts_with_all = ["all", "movie", "perspective"], value_parser = range)]
    pub mean: Option<(f64, f64)>,
    /// Draw every frame with one colour scale
    #[arg(long, conflicts_with = "movie")]
    pub all: bool,
    /// Write a movie of all frames: GIF, or MP4 if the program was built with it
    #[arg(long, value_name = "FILE", conflicts_with = "output", value_parser = movie_file())]
    pub movie: Option<PathBuf>,
    /// Frames of the movie per second
    #[arg(long, value_name = "N", default_value_t = 12.0, value_parser = positive, requires = "movie")]
    pub fps: f64,
    /// Picture to write: PNG, SVG or PDF [default: name of the field, PNG, in the run folder]
    #[arg(short, long, value_name = "FILE", value_parser = drawing_file())]
    pub output: Option<PathBuf>,
    /// Ends of the colour scale, in the unit of the field [default: range of the field]
    #[arg(long, value_name = "MIN,MAX", value_parser = range, allow_hyphen_values = true)]
    pub range: Option<(f64, f64)>,
    /// Colour map [default: depends on the field]
    #[arg(long, value_name = "NAME", value_parser = colours())]
    pub colours: Option<Colours>,
    /// Part of the flow along the axes of the picture, m [default: all]
    #[arg(long = "box", value_name = "XMIN,XMAX,YMIN,YMAX", value_parser = frame_box, allow_hyphen_values = true,
        conflicts_with = "perspective")]
    pub part: Option<[f64; 4]>,
    /// Plane of a 3D flow, in 2D refused, as `z` or `y=0.01` (m); in perspective the flow in front
    /// of it is left out [default: z in the middle]
    #[arg(long, value_name = "AXIS[=AT]", value_parser = slice)]
    pub slice: Option<Slice>,
    /// Draw velocity arrows on a regular grid, this many across [default: none; 32 without a
    /// number]
    #[arg(long, value_name = "N", num_args = 0..=1, require_equals = true, default_missing_value = "32",
        value_parser = clap::value_parser!(u32).range(2..=400), conflicts_with = "perspective")]
    pub arrows: Option<u32>,
    /// Draw streamlines of the velocity in the plane, this many across a square picture [default:
    /// none; 36 without a number]
    #[arg(long, value_name = "N", num_args = 0..=1, require_equals = true, default_missing_value = "36",
        value_parser = clap::value_parser!(u32).range(2..=200), conflicts_with_all = ["perspective", "arrows"])]
    pub streamlines: Option<u32>,
    /// Draw lines of equal value at this many round levels [default: none; 10 without a number]
    #[arg(long, value_name = "N", num_args = 0..=1, require_equals = true, default_missing_value = "auto",
        value_parser = count_or_automatic, conflicts_with = "perspective")]
    pub contours: Option<u32>,
    /// Draw the particles of a 3D flow in perspective, seen from this direction [default: none;
    /// 1,1,2 without a direction]
    #[arg(long, value_name = "X,Y,Z", num_args = 0..=1, require_equals = true, default_missing_value = "1,1,2",
        value_parser = towards_viewer, allow_hyphen_values = true)]
    pub perspective: Option<[f64; 3]>,
    /// Width of the picture, pixels [default: 1600, of a movie 960]
    #[arg(long, value_name = "PX", value_parser = clap::value_parser!(u32).range(200..=16384))]
    pub width: Option<u32>,
}

impl RenderArguments {
    /// Returns the width of the pictures, pixels.
    pub fn width(&self) -> u32 {
        self.width.unwrap_or(if self.movie.is_some() { MOVIE_WIDTH } else { PICTURE_WIDTH })
    }
}

/// `sphecs plot`.
#[derive(Args, Debug)]
#[command(after_help = "Examples:\n  \
    sphecs plot runs/quickstart monitor.kinetic_energy probes.gap.mass_flow -o energy.svg\n  \
    sphecs plot runs/coarse runs/fine probes.axis.u --mean 1,2 -o axis.pdf\n  \
    sphecs plot runs/quickstart probes.axis.u --time 0.5,1,2 -o axis.png\n\n\
    A name is `monitor.COLUMN`, `forces.COLUMN` or `probes.PROBE.QUANTITY`; all other words are run folders. A run alone \
    lists its names. Results of different units are in panels of their own, several runs in each of them.")]
pub struct PlotArguments {
    /// Run folders, and names of results
    #[arg(value_name = "RUN_OR_NAME", required = true)]
    pub words: Vec<String>,
    /// Plot to write: SVG, PDF or PNG [default: plot.svg in the first run folder]
    #[arg(short, long, value_name = "FILE", value_parser = drawing_file())]
    pub output: Option<PathBuf>,
    /// Times of profiles along lines, s; the nearest samples are drawn [default: the last one]
    #[arg(long, value_name = "T,…", value_delimiter = ',', value_parser = finite, allow_negative_numbers = true,
        conflicts_with = "mean")]
    pub time: Vec<f64>,
    /// Interval of the mean of profiles along lines, s
    #[arg(long, value_name = "FROM,TO", value_parser = range, conflicts_with = "over")]
    pub mean: Option<(f64, f64)>,
    /// Part of the time axis to draw, s [default: all]
    #[arg(long, value_name = "FROM,TO", value_parser = range, conflicts_with = "time")]
    pub over: Option<(f64, f64)>,
    /// Draw magnitudes on a logarithmic axis
    #[arg(long)]
    pub logarithmic: bool,
    /// Width of the plot, pixels
    #[arg(long, value_name = "PX", default_value_t = chart::WIDTH, value_parser = clap::value_parser!(u32).range(200..=16384))]
    pub width: u32,
}

impl PlotArguments {
    /// Returns the run folders and the names of results.
    pub fn runs_and_names(&self) -> (Vec<PathBuf>, Vec<String>) {
        const TABLES: [&str; 3] = ["monitor.", "forces.", "probes."];
        let is_name = |word: &&String| TABLES.iter().any(|table| word.starts_with(table));
        let (names, runs): (Vec<_>, Vec<_>) = self.words.iter().partition(is_name);
        (runs.into_iter().map(PathBuf::from).collect(), names.into_iter().cloned().collect())
    }
}

#[cfg(test)]
mod tests {
    use std::ffi::OsString;

    use super::super::arguments::{Arguments, Command};
    use super::*;

    fn parse(line: &str) -> Result<Command, clap::Error> {
        Arguments::read(line.split(' ').map(OsString::from)).map(|arguments| arguments.command)
    }

    fn refused(line: &str, word: &str) {
        let message = parse(line).expect_err(line).to_string();
        assert!(message.contains(word), "`{line}` gave:\n{message}");
    }

    fn rendered(line: &str) -> RenderArguments {
        match parse(line).expect(line) {
            Command::Render(render) => render,
            other => panic!("{other:?} is not a render"),
        }
    }

    #[test]
    fn negative_numbers_are_values() {
        let render = rendered("sphecs render runs/a --field u --range -2.5,3e1 -o u.png");
        assert_eq!((render.range, render.field), (Some((-2.5, 30.0)), Field::U));
        let render = rendered("sphecs render runs/a --slice y=-0.01 --colours turbo");
        assert_eq!(render.slice, Some(Slice { axis: 1, at: Some(-0.01) }));
        assert_eq!(render.colours, Some(Colours::Turbo));
        let render = rendered("sphecs render runs/a --box -1,1,-0.5,0.5 --contours --arrows=20");
        assert_eq!(render.part, Some([-1.0, 1.0, -0.5, 0.5]));
        assert_eq!((render.contours, render.arrows, render.streamlines), (Some(10), Some(20), None));
        assert_eq!(
            rendered("sphecs render runs/a --perspective=-1,0,0.5").perspective,
            Some([-1.0, 0.0, 0.5])
        );
        assert_eq!(rendered("sphecs render runs/a --perspective").perspective, Some([1.0, 1.0, 2.0]));
    }

    #[test]
    fn picture_ends_in_its_format_and_is_png_without_one() {
        for (given, written) in [
            ("flow", "flow.png"),
            ("flow.PNG", "flow.PNG"),
            ("a.b/flow.png", "a.b/flow.png"),
            ("f.pdf", "f.pdf"),
        ] {
            let render = rendered(&format!("sphecs render runs/a -o {given}"));
            assert_eq!(render.output, Some(PathBuf::from(written)));
        }
        assert_eq!(rendered("sphecs render runs/a").width(), 1600);
        assert_eq!(rendered("sphecs render runs/a --movie a").movie, Some(PathBuf::from("a.gif")));
        assert_eq!(rendered("sphecs render runs/a --movie a.gif").width(), 960);
    }

    #[test]
    fn words_of_a_plot_are_runs_or_names() {
        let Command::Plot(plot) =
            parse("sphecs plot runs/a monitor.kinetic_energy runs/b.2 probes.gap.u -o p.svg")
                .expect("a plot")
        else {
            panic!("not a plot");
        };
        let (runs, names) = plot.runs_and_names();
        assert_eq!(runs, [PathBuf::from("runs/a"), PathBuf::from("runs/b.2")]);
        assert_eq!(names, ["monitor.kinetic_energy", "probes.gap.u"]);
    }

    #[test]
    fn invalid_arguments_are_refused_with_the_valid_ones() {
        refused("sphecs render runs/a --field sped", "speed");
        refused("sphecs render runs/a --slice q", "`x`, `y` or `z`");
        refused("sphecs render runs/a --range 3,1", "below");
        refused("sphecs render runs/a --all --time 3", "cannot be used with");
        refused("sphecs render runs/a --mean 1,2 --time 3", "cannot be used with");
        refused("sphecs render runs/a --mean 1,2 --all", "cannot be used with");
        refused("sphecs render runs/a --movie a.gif --mean 1,2", "cannot be used with");
        refused("sphecs render runs/a --movie a.gif -o a.png", "cannot be used with");
        refused("sphecs render runs/a --perspective --streamlines", "cannot be used with");
        refused("sphecs render runs/a --arrows --streamlines", "cannot be used with");
        refused("sphecs render runs/a --fps 10", "--movie");
        refused("sphecs render runs/a --movie a.avi", "`.gif`");
        match cfg!(feature = "mp4") {
            true => assert!(rendered("sphecs render runs/a --movie a.mp4").movie.is_some()),
            false => refused("sphecs render runs/a --movie a.mp4", "--features mp4"),
        }
        refused("sphecs render runs/a --box 1,0,0,1", "below");
        refused("sphecs render runs/a --box 0,1", "four numbers");
        refused("sphecs render runs/a --perspective=0,0,0", "not zero");
        refused("sphecs render runs/a -o flow.jpg", "`.svg`");
        refused("sphecs render runs/a -o flow.v2", "`.png`");
        refused("sphecs plot", "RUN_OR_NAME");
        refused("sphecs plot runs/a probes.a.u --time 1 --mean 1,2", "cannot be used with");
        refused("sphecs plot runs/a probes.a.u -o a.nc", "`.pdf`");
    }
}
