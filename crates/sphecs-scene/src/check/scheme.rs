//! Checks of the numerical scheme of a scene file, with defaults.

use super::checker::Checker;
use crate::faults::Fault;
use crate::model::{EdacTvf, Scheme, Wcsph};
use crate::notation::typed::Spanned;
use crate::schema::{Number, SchemeFile};
use sphecs_core::math::kernel::Kernel;
use sphecs_core::physics::edac::Edac;
use sphecs_core::physics::integrator::Integrator;

/// Returns the default h/Δ, the best measured for the kernel with lattice-normalised sums.
fn default_ratio(kernel: Kernel, dimensions: usize) -> f64 {
    match (kernel, dimensions) {
        (Kernel::WendlandC2, 2) => 1.5,
        (Kernel::WendlandC2, _) => 1.7,
        (Kernel::QuinticSpline, _) => 1.2,
    }
}

/// Returns h/Δ, given or by default.
fn ratio(number: Option<&Number>, kernel: Kernel, dimensions: usize, check: &mut Checker<'_>) -> f64 {
    match number {
        Some(number) if !(0.8..=4.0).contains(&number.value) => {
            check.report(
                Fault::new(
                    "`smoothing_ratio` is out of range",
                    number.span,
                    format!("is `{}`, must be from `0.8` to `4`", number.value),
                )
                .help("h/Δ: `1.2` to `2.2` is usual"),
            );
            1.5
        }
        Some(number) => number.value,
        None => default_ratio(kernel, dimensions),
    }
}

/// Returns a number from zero to `most`, given or by default.
fn up_to(number: Option<&Number>, usual: f64, most: f64, name: &str, check: &mut Checker<'_>) -> f64 {
    match number {
        Some(number) if !(0.0..=most).contains(&number.value) => {
            check.report(
                Fault::new(
                    format!("`{name}` of the scheme is out of range"),
                    number.span,
                    format!("is `{}`, must be from `0` to `{most}`", number.value),
                )
                .help(format!("`{usual}` is usual")),
            );
            usual
        }
        Some(number) => number.value,
        None => usual,
    }
}

/// Checks that a corrective step occurs at all.
fn check_integrator(file: Option<&Spanned<Integrator>>, check: &mut Checker<'_>) {
    if let Some(integrator) = file
        && integrator.value == (Integrator::Verlet { corrective_step_every: 0 })
    {
        check.report(Fault::new(
            "`corrective_step_every` must be at least 1",
            integrator.span,
            "is `0`".to_owned(),
        ));
    }
}

/// Returns the scheme, with defaults for missing parameters.
pub fn scheme(file: &SchemeFile, dimensions: usize, check: &mut Checker<'_>) -> Scheme {
    match file {
        SchemeFile::Wcsph {
            kernel,
            smoothing_ratio,
            viscosity,
            noise_damping,
            shifting,
            tensile_control,
            integrator,
        } => {
            let kernel = kernel.unwrap_or(Kernel::WendlandC2);
            let smoothing_ratio = ratio(smoothing_ratio.as_ref(), kernel, dimensions, check);
            check_integrator(integrator.as_ref(), check);
            if let Some(viscosity) = viscosity {
                for fault in viscosity.value.faults() {
                    check.report_parameter(&fault, "the viscous term", viscosity.span);
                }
            }
            if let Some(shifting) = shifting {
                for fault in shifting.value.faults() {
                    check.report_parameter(&fault, "the shifting", shifting.span);
                }
            }
            if let Some(damping) = noise_damping {
                for fault in damping.value.faults() {
                    check.report_parameter(&fault, "the noise damping", damping.span);
                }
            }
            Scheme::Wcsph(Wcsph {
                kernel,
                smoothing_ratio,
                viscosity: viscosity.as_ref().map(|v| v.value).unwrap_or_default(),
                noise_damping: noise_damping.as_ref().map(|damping| damping.value).unwrap_or_default(),
                shifting: shifting.as_ref().map(|s| s.value).unwrap_or_default(),
                tensile_control: tensile_control.unwrap_or(true),
                integrator: integrator.as_ref().map(|integrator| integrator.value).unwrap_or_default(),
            })
        }
        SchemeFile::EdacTvf {
            kernel,
            smoothing_ratio,
            alpha,
            background,
            average_pressure,
            lattice_normalised,
            relaxation,
            as_published,
        } => {
            let kernel = kernel.unwrap_or(Kernel::QuinticSpline);
            let smoothing_ratio = ratio(smoothing_ratio.as_ref(), kernel, dimensions, check);
            let usual = Edac::default();
            let terms = Edac {
                alpha: up_to(alpha.as_ref(), usual.alpha, Edac::LARGEST_ALPHA, "alpha", check),
                background: up_to(
                    background.as_ref(),
                    usual.background,
                    Edac::LARGEST_BACKGROUND,
                    "background",
                    check,
                ),
                average_pressure: average_pressure.unwrap_or(usual.average_pressure),
                lattice_normalised: lattice_normalised.unwrap_or(usual.lattice_normalised),
                relaxation: up_to(
                    relaxation.as_ref(),
                    usual.relaxation,
                    Edac::LARGEST_RELAXATION,
                    "relaxation",
                    check,
                ),
                as_published: as_published.unwrap_or(usual.as_published),
            };
            Scheme::EdacTvf(EdacTvf { kernel, smoothing_ratio, terms })
        }
    }
}
