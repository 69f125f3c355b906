//! References of profiles as functions of position and time.

use crate::case::Case;
use crate::exact::{couette, duct, poiseuille_startup};
use crate::schema::{AxisFile, ReferenceFile};
use sphecs_scene::schema::{Formula, FormulaText};

/// Reference as a function of position (m) and time (s).
pub type Reference = Box<dyn Fn([f64; 3], f64) -> f64>;

/// Returns the run that a reference is taken from.
pub fn run_of(reference: &ReferenceFile) -> Option<&str> {
    match reference {
        ReferenceFile::Run(run) => Some(&run.value),
        _ => None,
    }
}

/// Returns the function of a reference; None for another run and for other members.
///
/// # Errors
/// Reason why a formula or a table cannot be parsed.
pub fn function(reference: &ReferenceFile, case: &Case) -> Result<Option<Reference>, String> {
    let function: Reference = match reference {
        ReferenceFile::Run(_) | ReferenceFile::Members => return Ok(None),
        ReferenceFile::Formula(written) => formula(written, case)?,
        ReferenceFile::PoiseuilleStartup { half_width, body_force, viscosity } => {
            let (d, force, nu) = (half_width.value, body_force.value, viscosity.value);
            Box::new(move |[_, y, _], t| poiseuille_startup(y, t, d, force, nu))
        }
        ReferenceFile::CouetteStartup { bottom, gap, velocity, viscosity } => {
            let (bottom, gap) = (bottom.value, gap.value);
            let (velocity, nu) = (velocity.value, viscosity.value);
            Box::new(move |[_, y, _], t| couette::startup_velocity(y - bottom, t, gap, velocity, nu))
        }
        ReferenceFile::RectangularDuct { half_width, half_height, body_force, viscosity } => {
            let (a, b, drive) = (half_width.value, half_height.value, body_force.value / viscosity.value);
            Box::new(move |[_, y, z], _| duct::developed_velocity(y, z, a, b, drive))
        }
        ReferenceFile::Table { file, along, axis, value } => {
            let points = read_table(&case.table(&file.value)?, &along.value, &value.value)
                .map_err(|reason| format!("{}: {reason}", file.value))?;
            let axis = *axis;
            Box::new(move |place, _| between(&points, coordinate(place, axis)))
        }
    };
    Ok(Some(function))
}

/// Returns a formula as a function.
///
/// # Errors
/// The formula cannot be parsed.
pub fn formula(formula: &Formula, case: &Case) -> Result<Reference, String> {
    Ok(match &formula.value {
        FormulaText::Number(number) => {
            let number = *number;
            Box::new(move |_, _| number)
        }
        FormulaText::Text(text) => {
            let expression = case.constants.field(text).map_err(|_| format!("`{text}` cannot be parsed"))?;
            Box::new(move |[x, y, z], t| expression.value(x, y, z, t))
        }
    })
}

/// Returns a component of a position.
pub fn coordinate(place: [f64; 3], axis: AxisFile) -> f64 {
    match axis {
        AxisFile::X => place[0],
        AxisFile::Y => place[1],
        AxisFile::Z => place[2],
    }
}

/// Returns two columns of a CSV text with `#` comments, in ascending order of the first.
fn read_table(text: &str, along: &str, value: &str) -> Result<Vec<(f64, f64)>, String> {
    let mut reader = csv::ReaderBuilder::new().comment(Some(b'#')).from_reader(text.as_bytes());
    let headers = reader.headers().map_err(|error| error.to_string())?.clone();
    let column = |name: &str| {
        headers.iter().position(|header| header == name).ok_or_else(|| format!("has no column `{name}`"))
    };
    let (along, value) = (column(along)?, column(value)?);
    let mut points = Vec::new();
    for record in reader.records() {
        let record = record.map_err(|error| error.to_string())?;
        // Rows without the value belong to other columns.
        if let (Ok(x), Ok(y)) = (record[along].trim().parse(), record[value].trim().parse()) {
            points.push((x, y));
        }
    }
    points.sort_by(|a: &(f64, f64), b| a.0.total_cmp(&b.0));
    if points.len() < 2 { Err("has fewer than two rows".to_owned()) } else { Ok(points) }
}

/// Returns the linear interpolation in a table; NaN outside it.
fn between(points: &[(f64, f64)], x: f64) -> f64 {
    let above = points.partition_point(|point| point.0 < x).clamp(1, points.len() - 1);
    let (low, high) = (points[above - 1], points[above]);
    // The end of a probe may differ from that of the table by rounding.
    let slack = 1e-9 * (points[points.len() - 1].0 - points[0].0);
    if x < low.0 - slack || x > high.0 + slack {
        return f64::NAN;
    }
    low.1 + (high.1 - low.1) * (x - low.0) / (high.0 - low.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tables_are_read_by_name_and_interpolated() {
        let text = "# a comment\ny,u,other\n0.0,1.0,\n1.0,3.0,5\n2.0,,7\n4.0,9.0,\n";
        let points = read_table(text, "y", "u").expect("a table");
        assert_eq!(points, [(0.0, 1.0), (1.0, 3.0), (4.0, 9.0)]);
        assert_eq!(between(&points, 0.5), 2.0);
        assert_eq!(between(&points, 2.5), 6.0);
        assert_eq!(between(&points, 4.0 + 1e-10), 9.0 + 2e-10);
        assert!(between(&points, 4.1).is_nan());
        assert_eq!(read_table(text, "y", "v").expect_err("no column"), "has no column `v`");
    }
}
