//! Values of command line arguments.

use std::ops::RangeInclusive;
use std::path::PathBuf;

use clap::builder::{PathBufValueParser, PossibleValuesParser, TypedValueParser};

use sphecs_core::particles::zone::Zone;
use sphecs_output::drawing::FORMATS;
use sphecs_output::picture::{Colours, Field, Slice};

/// Returns the parser of a field, whose names stand in help and messages.
pub(super) fn fields() -> impl TypedValueParser<Value = Field> {
    PossibleValuesParser::new(Field::ALL.map(Field::name)).try_map(|name| name.parse::<Field>())
}

/// Returns the parser of a colour map.
pub(super) fn colours() -> impl TypedValueParser<Value = Colours> {
    PossibleValuesParser::new(Colours::ALL.map(|(name, _)| name)).try_map(|name| {
        let found = Colours::ALL.into_iter().find(|(known, _)| *known == name);
        found.map(|(_, colours)| colours).ok_or("is not a colour map")
    })
}

/// Returns the parser of a picture's path: it ends in `.png`, which is added to a name without an
/// ending.
pub(super) fn picture_file() -> impl TypedValueParser<Value = PathBuf> {
    PathBufValueParser::new().try_map(|path| match path.extension() {
        None if path.file_name().is_some() => Ok(path.with_extension("png")),
        Some(ending) if ending.eq_ignore_ascii_case("png") => Ok(path),
        _ => Err("pictures are PNG files: the name must end in `.png`"),
    })
}

/// Returns the parser of a drawing's path: it ends in one of its formats, `.png` without an ending.
pub(super) fn drawing_file() -> impl TypedValueParser<Value = PathBuf> {
    PathBufValueParser::new().try_map(|path| match path.extension() {
        None if path.file_name().is_some() => Ok(path.with_extension("png")),
        Some(ending) if FORMATS.iter().any(|format| ending.eq_ignore_ascii_case(format)) => Ok(path),
        _ => Err("is a picture: the name must end in `.png`, `.svg` or `.pdf`"),
    })
}

/// Returns the parser of a movie's path: it ends in `.gif`, which is added to a name without an
/// ending, or in `.mp4` if that is built in.
pub(super) fn movie_file() -> impl TypedValueParser<Value = PathBuf> {
    PathBufValueParser::new().try_map(|path| match path.extension() {
        None if path.file_name().is_some() => Ok(path.with_extension("gif")),
        Some(ending) if ending.eq_ignore_ascii_case("gif") => Ok(path),
        Some(ending) if ending.eq_ignore_ascii_case("mp4") && cfg!(feature = "mp4") => Ok(path),
        Some(ending) if ending.eq_ignore_ascii_case("mp4") => Err(
            "this program was built without MP4: name a `.gif`, build it by `cargo build --release --features mp4`, \
             or draw the frames by `--all` and encode them, as `ffmpeg -i speed-%04d.png -pix_fmt yuv420p speed.mp4`",
        ),
        _ => Err("is a movie: the name must end in `.gif`"),
    })
}

/// Endings of files, by which a folder is not called.
const FILES: [&str; 12] =
    ["ron", "nc", "csv", "json", "png", "vtu", "vtk", "pvd", "zip", "svg", "pdf", "gif"];

/// Returns the parser of the path of a folder that is written.
pub(super) fn result_folder() -> impl TypedValueParser<Value = PathBuf> {
    PathBufValueParser::new().try_map(|path| {
        let ending = path.extension().unwrap_or_default().to_string_lossy().to_ascii_lowercase();
        match FILES.contains(&ending.as_str()) && !path.is_dir() {
            true => Err(format!("is the name of a folder: must not end in `.{ending}`")),
            false => Ok(path),
        }
    })
}

/// Returns a plane from `z` or `y=0.01`.
pub(super) fn slice(text: &str) -> Result<Slice, String> {
    let (axis, at) = match text.split_once('=') {
        Some((axis, at)) => (axis, Some(finite(at)?)),
        None => (text, None),
    };
    let axis = ["x", "y", "z"].iter().position(|name| *name == axis.trim());
    axis.map(|axis| Slice { axis, at })
        .ok_or_else(|| "must be `x`, `y` or `z`, with a position as in `y=0.01`".to_owned())
}

/// Returns path and value of `path=value`.
pub(super) fn assignment(text: &str) -> Result<(String, String), String> {
    match text.split_once('=') {
        Some((path, value)) if !path.trim().is_empty() && !value.trim().is_empty() => {
            Ok((path.trim().to_owned(), value.trim().to_owned()))
        }
        _ => Err("must be `path=value`, as `fluid.sound_speed=1.0`".to_owned()),
    }
}

/// Returns a finite number.
pub(super) fn finite(text: &str) -> Result<f64, String> {
    let value: f64 = text.trim().parse().map_err(|_| "is not a number".to_owned())?;
    if value.is_finite() { Ok(value) } else { Err("must be finite".to_owned()) }
}

/// Returns a finite number above zero.
pub(super) fn positive(text: &str) -> Result<f64, String> {
    finite(text).and_then(|value| if value > 0.0 { Ok(value) } else { Err("must be above zero".to_owned()) })
}

/// Returns the ends of `0,0.3`.
pub(super) fn range(text: &str) -> Result<(f64, f64), String> {
    let (lower, upper) =
        text.split_once(',').ok_or("must be two numbers separated by a comma, as `0,0.3`")?;
    let (lower, upper) = (finite(lower)?, finite(upper)?);
    if lower < upper {
        Ok((lower, upper))
    } else {
        Err(format!("the lower end `{lower}` must be below the upper end `{upper}`"))
    }
}

/// Returns the range of `100-200`, or of the single number `17`.
pub(super) fn numbers(text: &str) -> Result<RangeInclusive<u32>, String> {
    let (first, last) = text.split_once('-').unwrap_or((text, text));
    let number =
        |text: &str| text.trim().parse::<u32>().map_err(|_| format!("`{text}` is not a whole number"));
    let (first, last) = (number(first)?, number(last)?);
    if first <= last { Ok(first..=last) } else { Err(format!("{first} must not be above {last}")) }
}

/// Returns the lower and the upper corner of `0,0,0.1,0.04` or `0,0,0,0.1,0.04,0.04`, m; in 2D z is
/// unlimited.
pub(super) fn corners(text: &str) -> Result<[[f64; 3]; 2], String> {
    let numbers = text.split(',').map(finite).collect::<Result<Vec<_>, _>>()?;
    let (low, high) = match *numbers {
        [x0, y0, x1, y1] => ([x0, y0, f64::NEG_INFINITY], [x1, y1, f64::INFINITY]),
        [x0, y0, z0, x1, y1, z1] => ([x0, y0, z0], [x1, y1, z1]),
        _ => {
            return Err("must be the lower and the upper corner, as `0,0,0.1,0.04` or `0,0,0,0.1,0.04,0.04`"
                .to_owned());
        }
    };
    match (0..3).find(|&axis| low[axis] >= high[axis]) {
        Some(axis) => {
            Err(format!("the lower corner must be below the upper one along {}", ["x", "y", "z"][axis]))
        }
        None => Ok([low, high]),
    }
}

/// Returns the parser of the zones whose particles have positions.
pub(super) fn zones() -> impl TypedValueParser<Value = Zone> {
    let placed = Zone::ALL.into_iter().filter(|&zone| zone != Zone::Reservoir);
    PossibleValuesParser::new(placed.map(Zone::name))
        .try_map(|name| Zone::ALL.into_iter().find(|zone| zone.name() == name).ok_or("is not a zone"))
}

/// Returns the finite numbers of `0,0.3,…`, `N` of them.
fn finite_numbers<const N: usize>(text: &str) -> Result<Option<[f64; N]>, String> {
    let found = text.split(',').map(finite).collect::<Result<Vec<f64>, String>>()?;
    Ok(found.try_into().ok())
}

/// Returns the edges of a part of the flow, left, right, below, above.
pub(super) fn frame_box(text: &str) -> Result<[f64; 4], String> {
    let edges: [f64; 4] = finite_numbers(text)?.ok_or("must be four numbers, as `0,0.2,-0.02,0.02`")?;
    match edges.chunks(2).find(|pair| pair[0] >= pair[1]) {
        Some(pair) => Err(format!("the lower end `{}` must be below the upper end `{}`", pair[0], pair[1])),
        None => Ok(edges),
    }
}

/// Returns the direction from the flow towards the viewer.
pub(super) fn towards_viewer(text: &str) -> Result<[f64; 3], String> {
    let direction: [f64; 3] = finite_numbers(text)?.ok_or("must be three numbers, as `1,1,2`")?;
    if direction.iter().all(|&part| part == 0.0) {
        return Err("needs a number that is not zero".to_owned());
    }
    Ok(direction)
}

/// Number of levels that `auto` stands for.
const LEVELS: u32 = 10;

/// Returns a number of levels, or the default one of `auto`.
pub(super) fn count_or_automatic(text: &str) -> Result<u32, String> {
    match text.trim() {
        "auto" => Ok(LEVELS),
        count => match count.parse::<u32>() {
            Ok(count @ 1..=100) => Ok(count),
            _ => Err("must be `auto` or a whole number from 1 to 100".to_owned()),
        },
    }
}
