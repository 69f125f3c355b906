//! Commands that draw: `sphecs render` and `sphecs plot`.

use super::commands::{counter, make_parent};
use super::failure::{DONE, Failure};
use super::picture_arguments::{PlotArguments, RenderArguments};
use sphecs_core::format::{grouped, significant};
use sphecs_output::disk;
use sphecs_output::error::OutputError;
use sphecs_output::picture::{self, RenderOptions, all_frames, movie};
use sphecs_output::plot::{self as plotting, PlotOptions};
use sphecs_output::results::Results;
use sphecs_run::console::Console;

/// Draws frames of a run.
///
/// # Errors
/// [`Failure::Output`].
pub fn render(arguments: &RenderArguments) -> Result<u8, Failure> {
    let results = Results::open(&arguments.run)?;
    let options = RenderOptions {
        field: arguments.field,
        range: arguments.range,
        colours: arguments.colours,
        width: arguments.width(),
        slice: arguments.slice,
        part: arguments.part,
        arrows: arguments.arrows,
        streamlines: arguments.streamlines,
        contours: arguments.contours,
        perspective: arguments.perspective,
    };
    let name = || arguments.run.join(arguments.field.name()).with_extension("png");
    let given = arguments.movie.as_ref().or(arguments.output.as_ref());
    let path = given.cloned().unwrap_or_else(name);
    make_parent(&path)?;
    if arguments.all {
        let pictures = all_frames::render_all(&results, &options, &path, counter("pictures"))?;
        let (first, last) = (pictures.first().unwrap_or(&path), pictures.last().unwrap_or(&path));
        let count = grouped(pictures.len() as u64);
        Console::Normal.print(&format!("{count} pictures, {} to {}", first.display(), last.display()));
        return Ok(DONE);
    }
    let target = if given.is_some() { disk::target(&path) } else { path.clone() };
    if arguments.movie.is_some() {
        let frames = movie::render_movie(&results, &options, &target, arguments.fps, counter("frames"))?;
        Console::Normal.print(&format!("{} frames in {}", grouped(frames as u64), path.display()));
        return Ok(DONE);
    }
    let when = match arguments.mean {
        Some(interval) => {
            let (from, to) = picture::render_mean(&results, interval, &options, &target)?;
            format!("mean of {} to {} s", significant(from), significant(to))
        }
        None => {
            format!("at t = {} s", significant(picture::render(&results, arguments.time, &options, &target)?))
        }
    };
    Console::Normal.print(&format!("{} {when}: {}", arguments.field.name(), path.display()));
    Ok(DONE)
}

/// Plots what runs measured.
///
/// # Errors
/// [`Failure::Output`].
pub fn plot(arguments: &PlotArguments) -> Result<u8, Failure> {
    let (runs, names) = arguments.runs_and_names();
    let Some(first) = runs.first() else {
        let message = "no run folder is given: name one before the results, as `sphecs plot runs/quickstart \
                       monitor.kinetic_energy`";
        return Err(OutputError::Request(message.to_owned()).into());
    };
    if names.is_empty() {
        for run in &runs {
            Console::Normal.print(&format!("{} has\n{}", run.display(), plotting::results_of(run)?));
        }
        return Ok(DONE);
    }
    let options = PlotOptions {
        names,
        times: arguments.time.clone(),
        mean: arguments.mean,
        over: arguments.over,
        is_logarithmic: arguments.logarithmic,
        width: arguments.width,
    };
    let drawing = plotting::plot(&runs, &options)?;
    let path = arguments.output.clone().unwrap_or_else(|| first.join("plot.svg"));
    make_parent(&path)?;
    drawing.save(&disk::target(&path))?;
    Console::Normal.print(&format!("the plot is {}", path.display()));
    Ok(DONE)
}
