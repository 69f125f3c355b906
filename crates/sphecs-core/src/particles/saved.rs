//! The sorted arrays as named columns: what a checkpoint keeps of them.
//!
//! Both directions name every field of [`ParticleArrays`] and have no rest: a new column that is forgotten here does not compile.

use super::arrays::ParticleArrays;
use super::zone::Zone;
use crate::math::column::{ColumnMismatch, Columns, Element};
use crate::math::real::Real;

/// In which order rows are kept.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Order {
    /// As they stand: by cell, behind them those that came in since the last sort.
    AsTheyStand,
    /// By the number of the particle.
    ByNumber,
}

/// Puts every column that the next step depends on. Rows on their way to the reservoir, which the next sort drops, are left out.
pub fn save<R: Real, const D: usize>(arrays: &ParticleArrays<R, D>, order: Order, to: &mut Columns) {
    let ParticleArrays {
        id,
        zone,
        patch,
        fresh,
        position,
        velocity,
        velocity_before,
        // Written and read within a step.
        acceleration: _,
        density,
        pressure,
        evolves_pressure,
        pressure_before,
        drifts,
        drift,
        wall_distance,
        wall_normal,
    } = arrays;
    let rows = Rows::of(id, zone, order);
    to.put("arrays.id", rows.pick(id));
    to.put("arrays.zone", rows.pick(zone).into_iter().map(|zone| zone as u8).collect());
    to.put("arrays.patch", rows.pick(patch));
    to.put("arrays.fresh", rows.pick(fresh).into_iter().map(u8::from).collect());
    for axis in 0..D {
        to.put(format!("arrays.position.{axis}"), rows.pick(&position[axis]));
        to.put(format!("arrays.velocity.{axis}"), rows.pick(&velocity[axis]));
        to.put(format!("arrays.velocity_before.{axis}"), rows.pick(&velocity_before[axis]));
        // Empty where there is no wall, and where nothing drifts.
        to.put(format!("arrays.wall_normal.{axis}"), rows.pick_if_any(&wall_normal[axis]));
        to.put(format!("arrays.drift.{axis}"), rows.pick_if_any(&drift[axis]));
    }
    to.put("arrays.evolves_pressure", vec![u8::from(*evolves_pressure)]);
    to.put("arrays.drifts", vec![u8::from(*drifts)]);
    to.put("arrays.pressure_before", rows.pick_if_any(pressure_before));
    to.put("arrays.density", rows.pick(density));
    to.put("arrays.pressure", rows.pick(pressure));
    to.put("arrays.wall_distance", rows.pick(wall_distance));
}

/// The arrays of [`save`].
///
/// # Errors
/// [`ColumnMismatch`] when a column is missing, of another type or length, or holds no zone.
pub fn restore<R: Real, const D: usize>(from: &mut Columns) -> Result<ParticleArrays<R, D>, ColumnMismatch> {
    let id = from.take::<u32>("arrays.id")?;
    let rows = id.len();
    let zones = from.take_exactly::<u8>("arrays.zone", rows)?;
    let zone = zones.into_iter().map(moving_or_wall).collect::<Result<Vec<Zone>, ColumnMismatch>>()?;
    let wall_normal = vector::<R, D>("wall_normal", from)?;
    if wall_normal
        .iter()
        .any(|column| column.len() != wall_normal[0].len() || ![0, rows].contains(&column.len()))
    {
        return Err(ColumnMismatch("its walls have normals for some rows only".to_owned()));
    }
    let whole = |columns: [Vec<R>; D], name: &str| match columns.iter().all(|column| column.len() == rows) {
        true => Ok(columns),
        false => {
            Err(ColumnMismatch(format!("its column `{name}` has not one value for each of {rows} rows")))
        }
    };
    let position = vector::<f64, D>("position", from)?;
    if position.iter().any(|column| column.len() != rows) {
        return Err(ColumnMismatch(format!("its positions are not one for each of {rows} rows")));
    }
    let evolves_pressure = from.take_exactly::<u8>("arrays.evolves_pressure", 1)? == [1];
    let evolving = if evolves_pressure { rows } else { 0 };
    let drifts = from.take_exactly::<u8>("arrays.drifts", 1)? == [1];
    let drifting = if drifts { rows } else { 0 };
    let drift = vector::<R, D>("drift", from)?;
    if drift.iter().any(|column| column.len() != drifting) {
        return Err(ColumnMismatch(format!("its drifts are not one for each of {drifting} rows")));
    }
    Ok(ParticleArrays {
        evolves_pressure,
        pressure_before: from.take_exactly("arrays.pressure_before", evolving)?,
        drifts,
        drift,
        zone,
        patch: from.take_exactly("arrays.patch", rows)?,
        fresh: from.take_exactly::<u8>("arrays.fresh", rows)?.into_iter().map(|flag| flag != 0).collect(),
        position,
        velocity: whole(vector("velocity", from)?, "arrays.velocity")?,
        velocity_before: whole(vector("velocity_before", from)?, "arrays.velocity_before")?,
        acceleration: std::array::from_fn(|_| vec![R::default(); rows]),
        density: from.take_exactly("arrays.density", rows)?,
        pressure: from.take_exactly("arrays.pressure", rows)?,
        wall_distance: from.take_exactly("arrays.wall_distance", rows)?,
        wall_normal,
        id,
    })
}

fn moving_or_wall(number: u8) -> Result<Zone, ColumnMismatch> {
    let zone = Zone::from_number(number).filter(|zone| *zone != Zone::Reservoir);
    zone.ok_or_else(|| ColumnMismatch(format!("it has a row of zone `{number}`")))
}

fn vector<T: Element, const D: usize>(name: &str, from: &mut Columns) -> Result<[Vec<T>; D], ColumnMismatch> {
    let mut columns = std::array::from_fn(|_| Vec::new());
    for (axis, column) in columns.iter_mut().enumerate() {
        *column = from.take(&format!("arrays.{name}.{axis}"))?;
    }
    Ok(columns)
}

/// The rows that are kept; None: all of them as they stand.
struct Rows(Option<Vec<u32>>);

impl Rows {
    fn of(id: &[u32], zone: &[Zone], order: Order) -> Self {
        if order == Order::AsTheyStand && zone.iter().all(|zone| *zone != Zone::Reservoir) {
            return Self(None);
        }
        let rows = (0_u32..).zip(zone).filter(|(_, zone)| **zone != Zone::Reservoir);
        let mut rows: Vec<u32> = rows.map(|(row, _)| row).collect();
        if order == Order::ByNumber {
            rows.sort_unstable_by_key(|&row| id[row as usize]);
        }
        Self(Some(rows))
    }

    fn pick_if_any<T: Copy>(&self, column: &[T]) -> Vec<T> {
        if column.is_empty() { Vec::new() } else { self.pick(column) }
    }

    fn pick<T: Copy>(&self, column: &[T]) -> Vec<T> {
        match &self.0 {
            None => column.to_vec(),
            Some(rows) => rows.iter().map(|&row| column[row as usize]).collect(),
        }
    }
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::super::arrays::SpareColumns;
    use super::super::rows::Row;
    use super::*;

    #[test]
    fn arrays_come_back_without_what_is_on_its_way_to_the_reservoir() {
        let mut arrays = ParticleArrays::<f32, 3>::default();
        let row = |id: u32, zone: Zone| Row {
            id,
            zone,
            patch: id as u16,
            fresh: id == 1,
            position: DVec3::new(0.1, 0.2, f64::from(id)),
            velocity: DVec3::new(0.3, -0.0, 0.0),
            velocity_before: DVec3::new(0.4, 0.0, f64::from(id)),
            density: 1000.0,
            pressure: -1.5,
            pressure_before: 0.0,
            drift: DVec3::ZERO,
            wall_distance: f64::INFINITY,
            wall_normal: DVec3::ZERO,
        };
        let zones = [Zone::Fluid, Zone::Outflow, Zone::Reservoir, Zone::Wall, Zone::Inflow];
        (0..).zip(zones).for_each(|(id, zone)| arrays.push(&row(id, zone)));
        let mut columns = Columns::default();
        save(&arrays, Order::AsTheyStand, &mut columns);
        let back: ParticleArrays<f32, 3> = restore(&mut columns.clone()).expect("whole");
        assert_eq!(back.id, [0, 1, 3, 4]);
        for (at, before) in [0, 1, 3, 4].into_iter().enumerate() {
            assert_eq!(back.row(at), arrays.row(before));
        }
        let mut again = Columns::default();
        save(&back, Order::AsTheyStand, &mut again);
        assert_eq!(again, columns);
        assert!(restore::<f64, 3>(&mut columns.clone()).is_err(), "of another precision");
        arrays.reorder(&[3, 0, 4, 1], &mut SpareColumns::default());
        let mut by_number = Columns::default();
        save(&arrays, Order::ByNumber, &mut by_number);
        assert_eq!(by_number, columns);
        columns.take::<f32>("arrays.pressure").expect("there");
        let misfit = restore::<f32, 3>(&mut columns).expect_err("incomplete").to_string();
        assert!(misfit.contains("arrays.pressure"), "{misfit}");
    }
}
