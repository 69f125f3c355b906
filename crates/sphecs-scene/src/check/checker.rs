//! Checks of single numbers, vectors and expressions.

use std::path::PathBuf;

use glam::DVec3;

use super::meshes::ReadSurface;
use super::outlines::ReadOutline;
use crate::expression::syntax::SyntaxFault;
use crate::expression::{Constants, Expression, TimeFunction};
use crate::faults::Fault;
use crate::meshes::{MeshFile, MeshReport};
use crate::model::UnopenedPart;
use crate::notation::tree::Span;
use crate::notation::typed::Spanned;
use crate::schema::{Formula, FormulaText, Number, Vector};
use sphecs_core::physics::parameter_fault::ParameterFault;

/// Collects faults and replaces faulty values by harmless ones.
pub struct Checker<'a> {
    constants: &'a Constants,
    text: &'a str,
    /// 2 or 3.
    pub dimensions: usize,
    /// Faults found so far.
    pub faults: Vec<Fault>,
    /// Tables given or already read: the path as written, and the text.
    pub tables: Vec<(String, String)>,
    /// Parts of the domain's ends that no opening covers.
    pub unopened: Vec<UnopenedPart>,
    /// Folder of tables, meshes and outlines.
    pub folder: PathBuf,
    /// Particle spacing, m.
    pub spacing: f64,
    /// Factor by which the shapes around a part scale it.
    pub scale: f64,
    /// True if fields that seem to be left out may only be misspelt, which is reported elsewhere.
    pub has_reading_faults: bool,
    /// Files of meshes and outlines given or already read.
    pub meshes: Vec<MeshFile>,
    /// Surfaces of meshes that were already made.
    pub surfaces: Vec<ReadSurface>,
    /// Outlines that were already read.
    pub outlines: Vec<ReadOutline>,
    /// Reports on the meshes and outlines.
    pub mesh_reports: Vec<MeshReport>,
    /// Number of placeholders found in place of faulty values.
    placeholders: usize,
}

impl<'a> Checker<'a> {
    /// Returns a checker without faults.
    pub fn new(constants: &'a Constants, text: &'a str) -> Self {
        Self {
            constants,
            text,
            dimensions: 2,
            faults: Vec::new(),
            tables: Vec::new(),
            unopened: Vec::new(),
            folder: PathBuf::from("."),
            spacing: 1.0,
            scale: 1.0,
            has_reading_faults: false,
            meshes: Vec::new(),
            surfaces: Vec::new(),
            outlines: Vec::new(),
            mesh_reports: Vec::new(),
            placeholders: 0,
        }
    }

    /// Returns the number of faults and placeholders so far. If it does not change while a part of
    /// the file is checked, that part has no faults.
    pub fn fault_count(&self) -> usize {
        self.faults.len() + self.placeholders
    }

    /// Adds a fault, unless it is the consequence of an earlier one.
    pub fn report(&mut self, fault: Fault) {
        if fault.span.is_some_and(Span::is_placeholder) {
            self.placeholders += 1;
        } else {
            self.faults.push(fault);
        }
    }

    /// Reports a parameter of `owner`, such as "the noise damping", that is out of range.
    pub fn report_parameter(&mut self, fault: &ParameterFault, owner: &str, span: Span) {
        let title = format!("`{}` of {owner} is out of range", fault.field);
        let found = Fault::new(title, span, format!("is {}, must be {}", fault.value, fault.must_be));
        self.report(if fault.advice.is_empty() { found } else { found.help(fault.advice) });
    }

    /// Counts a placeholder for a faulty value.
    pub fn note_placeholder(&mut self, span: Span) {
        self.placeholders += usize::from(span.is_placeholder());
    }

    fn require(&mut self, number: &Number, unit: &str, holds: bool, rule: &str) -> f64 {
        self.note_placeholder(number.span);
        if holds {
            return number.value;
        }
        let name = self.name_before(number.span);
        self.report(Fault::new(
            format!("{name} {rule}"),
            number.span,
            format!("is `{}` {unit}, {rule}", number.value),
        ));
        1.0
    }

    /// Returns the name of the field of a value, such as `spacing`, from the text before it.
    fn name_before(&self, span: Span) -> String {
        let before = self.text.get(..span.start).unwrap_or("").trim_end();
        let name = before
            .strip_suffix(':')
            .map(|before| before.trim_end().rsplit(|c: char| !(c.is_alphanumeric() || c == '_')))
            .and_then(|mut words| words.next())
            .filter(|name| !name.is_empty());
        name.map_or("the number".to_owned(), |name| format!("`{name}`"))
    }

    /// Returns the span, with its quotes, of the first quoted text of this content inside a span.
    pub fn span_of_text(&self, content: &str, inside: Span) -> Option<Span> {
        let quoted = format!("\"{content}\"");
        let at = self.text.get(inside.start..inside.end)?.find(&quoted)?;
        Some(Span::new(inside.start + at, inside.start + at + quoted.len()))
    }

    /// Returns a finite number above zero.
    pub fn positive(&mut self, number: &Number, unit: &str) -> f64 {
        let holds = number.value.is_finite() && number.value > 0.0;
        self.require(number, unit, holds, "must be finite and greater than 0")
    }

    /// Returns a finite number of at least zero.
    pub fn not_negative(&mut self, number: &Number, unit: &str) -> f64 {
        let holds = number.value.is_finite() && number.value >= 0.0;
        self.require(number, unit, holds, "must be finite and not negative")
    }

    /// Returns a finite number.
    pub fn finite(&mut self, number: &Number, unit: &str) -> f64 {
        let holds = number.value.is_finite();
        self.require(number, unit, holds, "must be finite")
    }

    /// Returns a number above zero and up to `most`.
    pub fn fraction(&mut self, number: &Number, most: f64) -> f64 {
        let holds = number.value > 0.0 && number.value <= most;
        let rule = format!("must be greater than 0 and at most `{most}`");
        self.require(number, "", holds, &rule)
    }

    /// Returns a finite vector with one component per dimension; z = 0 in 2D.
    pub fn vector(&mut self, vector: &Vector, unit: &str) -> DVec3 {
        self.components_of(vector, self.dimensions, unit)
    }

    /// Returns a finite vector of `count` components.
    pub fn components_of(&mut self, vector: &Vector, count: usize, unit: &str) -> DVec3 {
        let mut result = DVec3::ZERO;
        if !self.has_components(vector, count) {
            return DVec3::X;
        }
        for (axis, number) in vector.value.iter().enumerate() {
            result[axis] = self.finite(number, unit);
        }
        result
    }

    fn has_components<T>(&mut self, list: &Spanned<Vec<T>>, count: usize) -> bool {
        self.note_placeholder(list.span);
        if list.is_placeholder() || list.value.len() == count {
            return !list.is_placeholder();
        }
        let name = self.name_before(list.span);
        self.report(
            Fault::new(
                format!("{name} has the wrong number of components"),
                list.span,
                format!("has {}, must have {count}", list.value.len()),
            )
            .help(format!("the scene has `dimensions: {}`", self.dimensions)),
        );
        false
    }

    /// Returns a unit vector.
    pub fn direction(&mut self, vector: &Vector) -> DVec3 {
        let direction = self.vector(vector, "").normalize_or_zero();
        if direction == DVec3::ZERO && !vector.is_placeholder() {
            let name = self.name_before(vector.span);
            self.report(Fault::new(format!("{name} has no direction"), vector.span, "must not be zero"));
        }
        // Rounding must not tilt a direction along an axis.
        let snapped = direction.map(|c| if c.abs() < 1e-12 { 0.0 } else { c });
        snapped.try_normalize().unwrap_or(DVec3::X)
    }

    /// Returns the direction of an axis of rotation, z if it is left out; in 2D it must be.
    pub fn axis(&mut self, axis: Option<&Vector>) -> DVec3 {
        match axis {
            Some(axis) if self.dimensions == 3 => self.direction(axis),
            Some(axis) => {
                let label = "must be left out: in 2D rotations are about z";
                self.report(Fault::new("`axis` has no meaning in 2D", axis.span, label));
                DVec3::Z
            }
            None => DVec3::Z,
        }
    }

    /// Returns an expression of x, y, z, t.
    pub fn formula(&mut self, formula: &Formula) -> Expression {
        match &formula.value {
            FormulaText::Number(value) => {
                if !value.is_finite() {
                    self.report(Fault::new(
                        "a number is not finite",
                        formula.span,
                        format!("is `{value}`, must be finite"),
                    ));
                }
                Expression::Constant(*value)
            }
            FormulaText::Text(text) => match self.constants.field(text) {
                Ok(Expression::Constant(value)) if !value.is_finite() => {
                    self.report(Fault::new(
                        "an expression is not finite",
                        formula.span,
                        format!("gives `{value}`, must be finite"),
                    ));
                    Expression::Constant(0.0)
                }
                Ok(expression) => expression,
                Err(fault) => {
                    self.report_syntax(fault, formula, text);
                    Expression::Constant(0.0)
                }
            },
        }
    }

    /// Returns a function of time alone; None if it has a fault.
    pub fn time_function(&mut self, formula: &Formula) -> Option<TimeFunction> {
        match &formula.value {
            FormulaText::Number(value) => Some(TimeFunction::constant(*value)),
            FormulaText::Text(text) => match TimeFunction::read(text, self.constants) {
                Ok(function) => Some(function),
                Err(fault) => {
                    self.report_syntax(fault, formula, text);
                    None
                }
            },
        }
    }

    /// Returns functions of time alone with one component per dimension; z = 0 in 2D.
    pub fn time_functions(&mut self, components: &Spanned<Vec<Formula>>) -> Option<[TimeFunction; 3]> {
        if !self.has_components(components, self.dimensions) {
            return None;
        }
        let mut result = std::array::from_fn(|_| TimeFunction::constant(0.0));
        let functions: Vec<_> = components.value.iter().map(|formula| self.time_function(formula)).collect();
        for (slot, function) in result.iter_mut().zip(functions) {
            *slot = function?;
        }
        Some(result)
    }

    /// Reports a fault of an expression at its place.
    fn report_syntax(&mut self, fault: SyntaxFault, formula: &Formula, text: &str) {
        let inner = formula.span.start.saturating_add(1);
        let plain = inner
            .checked_add(text.len())
            .and_then(|end| self.text.get(inner..end))
            .is_some_and(|found| found == text);
        self.report(fault.into_fault(formula.span, plain.then_some(inner)));
    }

    /// Returns an expression, 0 if not given.
    pub fn formula_or_zero(&mut self, formula: Option<&Formula>) -> Expression {
        formula.map_or(Expression::Constant(0.0), |formula| self.formula(formula))
    }

    /// Returns a vector of expressions with one component per dimension; z = 0 in 2D.
    pub fn components(&mut self, components: &Spanned<Vec<Formula>>) -> [Expression; 3] {
        let mut result = std::array::from_fn(|_| Expression::Constant(0.0));
        self.has_components(components, self.dimensions);
        for (slot, formula) in result.iter_mut().zip(&components.value) {
            *slot = self.formula(formula);
        }
        result
    }

    /// Returns a vector of expressions, 0 if not given.
    pub fn components_or_zero(&mut self, components: Option<&Spanned<Vec<Formula>>>) -> [Expression; 3] {
        match components {
            Some(components) => self.components(components),
            None => std::array::from_fn(|_| Expression::Constant(0.0)),
        }
    }
}
