//! Checks of dimensions, time, output, probes and references.

use glam::DVec3;

use super::checker::Checker;
use super::field_grids;
use super::names::{Named, names};
use super::wall_quantities::wall_quantities;
use crate::expression::Expression;
use crate::faults::Fault;
use crate::fill;
use crate::given_speed::largest_given_speed;
use crate::model::{
    BodyForce, OutputSettings, Patch, Probe, ProbeKind, Reservoir, Scene, Scheme, TimeSettings, Walls,
    WhenEmpty,
};
use crate::notation::typed::Spanned;
use crate::schema::{Number, OutputFile, ProbeKindFile, ReservoirFile, SceneFile, TimeFile};
use sphecs_core::boundary::inlet::Feed;

/// Returns the number of dimensions, 2 or 3.
pub fn dimensions(file: &SceneFile, check: &mut Checker<'_>) -> usize {
    match file.dimensions.value {
        2 => 2,
        3 => 3,
        other => {
            check.report(Fault::new(
                "`dimensions` must be 2 or 3",
                file.dimensions.span,
                format!("is `{other}`, must be 2 or 3"),
            ));
            2
        }
    }
}

/// Returns the body force, constant if its components are.
pub fn body_force(components: [Expression; 3]) -> BodyForce {
    match components.each_ref().map(Expression::constant) {
        [Some(x), Some(y), Some(z)] => BodyForce::Constant(DVec3::new(x, y, z)),
        _ => BodyForce::Expression(components),
    }
}

/// Returns end and time step, with defaults.
pub fn time(file: &TimeFile, scheme: &Scheme, check: &mut Checker<'_>) -> TimeSettings {
    let usual = match scheme {
        Scheme::Wcsph(scheme) => scheme.integrator.courant_factor(),
        Scheme::EdacTvf(_) => 0.25,
    };
    TimeSettings {
        end: check.positive(&file.end, "s"),
        cfl: file.cfl.as_ref().map_or(usual, |cfl| check.fraction(cfl, 1.0)),
        viscous: file.viscous.as_ref().map_or(0.125, |viscous| check.fraction(viscous, 0.5)),
    }
}

/// Default interval of checkpoints, s of wall time: the loss when a run is killed, compared with 1
/// s of writing per million particles.
const CHECKPOINT_EVERY: f64 = 600.0;

/// Returns output and probes; `walls` are the walls, and false if there are none.
pub fn output(
    file: &OutputFile,
    end: Option<f64>,
    walls: (&Walls, bool),
    check: &mut Checker<'_>,
) -> OutputSettings {
    let every = check.positive(&file.every, "s");
    let monitor_every =
        file.monitor_every.as_ref().map_or(every / 10.0, |number| check.positive(number, "s"));
    let given = file.probes.iter().map(|probe| Named::Given(&probe.name));
    names(&given.collect::<Vec<_>>(), "probes", check);
    let mut probes: Vec<Probe> = Vec::new();
    for probe in &file.probes {
        let mean = probe.mean.as_ref().map(|mean| mean_interval(mean, end, check));
        let kind = probe_kind(&probe.kind.value, check);
        let usual = if matches!(kind, ProbeKind::Line { .. }) { every } else { monitor_every };
        let every = probe.every.as_ref().map_or(usual, |number| check.positive(number, "s"));
        probes.push(Probe { name: probe.name.value.clone(), kind, every, mean, sees: probe.sees });
    }
    let checkpoint_every =
        file.checkpoint_every.as_ref().map_or(CHECKPOINT_EVERY, |number| check.positive(number, "s"));
    let fields = file.fields.as_ref().map(|fields| field_grids::fields(fields, every, end, check));
    let at_walls = |written| wall_quantities(written, walls, (every, end), check);
    let walls = file.walls.as_ref().map(at_walls);
    OutputSettings { every, monitor_every, checkpoint_every, forces: file.forces, probes, fields, walls }
}

/// Returns the interval of a time mean, s, which must rise and end with the run.
pub(super) fn mean_interval(
    mean: &Spanned<(Number, Number)>,
    end: Option<f64>,
    check: &mut Checker<'_>,
) -> (f64, f64) {
    let (from, to) = &mean.value;
    let interval = (check.not_negative(from, "s"), check.positive(to, "s"));
    let rises = interval.0 < interval.1;
    if let Some(end) = end.filter(|end| !rises || interval.1 > end * (1.0 + 1e-9)) {
        let label = format!("must rise and end by the end of the run, `{end}` s");
        check.report(Fault::new("the interval of a time mean is wrong", mean.span, label));
    }
    interval
}

/// Returns the interval of means, s, and that between their samples, s, which needs the former.
pub(super) fn sampled_mean(
    mean: Option<&Spanned<(Number, Number)>>,
    every: Option<&Number>,
    end: Option<f64>,
    check: &mut Checker<'_>,
) -> (Option<(f64, f64)>, Option<f64>) {
    if let (Some(number), None) = (every, mean) {
        let label = "has no meaning without `mean`";
        let fault = Fault::new("`mean_every` is given, but no mean", number.span, label);
        check.report(fault.help("give the interval of time, `mean: (from, to)`, or leave out `mean_every`"));
    }
    let mean = mean.map(|mean| mean_interval(mean, end, check));
    (mean, every.map(|number| check.positive(number, "s")))
}

fn probe_kind(file: &ProbeKindFile, check: &mut Checker<'_>) -> ProbeKind {
    match file {
        ProbeKindFile::Point { at } => ProbeKind::Point(check.vector(at, "m")),
        ProbeKindFile::Line { from, to, count } => {
            if !(2..=1_000_000).contains(&count.value) {
                check.report(Fault::new(
                    "a line has the wrong number of points",
                    count.span,
                    format!("is `{}`, must be from 2 to 1000000", count.value),
                ));
            }
            ProbeKind::Line {
                from: check.vector(from, "m"),
                to: check.vector(to, "m"),
                count: count.value as usize,
            }
        }
        ProbeKindFile::Section { at, normal } => {
            ProbeKind::Section { at: check.vector(at, "m"), normal: check.direction(normal) }
        }
    }
}

/// Returns the reservoir; [`derive()`] sets the number of its particles, which is 0 without
/// recycling.
pub fn reservoir(file: &ReservoirFile, check: &mut Checker<'_>) -> Reservoir {
    let recycle = file.recycle.as_ref().is_none_or(|recycle| recycle.value);
    if let Some(recycle) = file.recycle.as_ref().filter(|recycle| !recycle.value) {
        let mut excluded = |what: &str| {
            check.report(Fault::new(
                format!("`{what}` of a reservoir that takes nothing"),
                recycle.span,
                format!("is `false`: particles that leave are deleted, so that `{what}` must not be given"),
            ));
        };
        if file.particles.is_some() {
            excluded("particles");
        }
        if file.when_empty == WhenEmpty::Stop {
            excluded("when_empty: Stop");
        }
    }
    Reservoir { initial: 0, when_empty: file.when_empty, recycle }
}

/// Checks that given references are positive.
pub fn references(file: &SceneFile, check: &mut Checker<'_>) {
    if let Some(velocity) = &file.reference.velocity {
        check.positive(velocity, "m/s");
    }
    if let Some(length) = &file.reference.length {
        check.positive(length, "m");
    }
}

/// Derives the values that follow from the rest of a scene without faults: reservoir and
/// references.
pub fn derive(scene: &mut Scene, file: &SceneFile) {
    let cell = scene.spacing.powi(scene.dimensions as i32 - 1);
    // An inlet that is filled once takes no particles from the reservoir.
    let fed = scene.inlets.iter().filter(|inlet| inlet.feed == Feed::Fed);
    let inflow: f64 = fed.map(|inlet| inlet.patch.area / cell * (inlet.patch.depth / scene.spacing)).sum();
    let emitted: usize = scene.emitters.iter().map(|emitter| emitter.particles(scene).count()).sum();
    let particles = file.reservoir.particles.as_ref().map(|p| p.value as usize);
    let usual = if scene.reservoir.recycle { (inflow - 1e-6).ceil() as usize + emitted } else { 0 };
    scene.reservoir.initial = particles.unwrap_or(usual);
    let length = file.reference.length.as_ref().map(|n| n.value);
    scene.reference_length = length.unwrap_or_else(|| narrowest(scene));
    let velocity = file.reference.velocity.as_ref().map(|n| n.value);
    scene.reference_velocity = velocity.unwrap_or_else(|| largest_given_speed(scene));
}

/// Returns the width of the narrowest patch, or of the domain across periodic directions, m.
fn narrowest(scene: &Scene) -> f64 {
    let width = |patch: &Patch| {
        let plates = if scene.dimensions == 2 { 0.5 } else { 1.0 };
        let (width, hydraulic) = (2.0 * patch.half_extent[0], plates * patch.hydraulic_diameter());
        // Of a section in parts or with a hole. The measures of others agree up to rounding.
        if patch.raster.is_some() && hydraulic < 0.999 * width { hydraulic } else { width }
    };
    let narrowest = fill::patches(scene).map(|(patch, _)| width(patch)).fold(f64::INFINITY, f64::min);
    if narrowest.is_finite() {
        return narrowest;
    }
    let (low, high) = scene.domain.bounds();
    let extent = |axis: usize| high[axis] - low[axis];
    let across = (0..scene.dimensions).filter(|axis| scene.periodic[*axis].is_none());
    let width = across.map(extent).fold(f64::INFINITY, f64::min);
    if width.is_finite() { width } else { extent(0) }
}
