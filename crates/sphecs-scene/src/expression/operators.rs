//! Functions and operators of expressions.
//!
//! Comparisons and `&&`, `||` give 1 for true and 0 for false.

/// A function of one argument.
type Unary = (&'static str, fn(f64) -> f64);
/// An operator or function of two arguments.
type Binary = (&'static str, fn(f64, f64) -> f64);

/// Functions of one argument.
pub const FUNCTIONS: &[Unary] = &[
    ("abs", f64::abs),
    ("sqrt", f64::sqrt),
    ("exp", f64::exp),
    ("ln", f64::ln),
    ("log10", f64::log10),
    ("sin", f64::sin),
    ("cos", f64::cos),
    ("tan", f64::tan),
    ("asin", f64::asin),
    ("acos", f64::acos),
    ("atan", f64::atan),
    ("sinh", f64::sinh),
    ("cosh", f64::cosh),
    ("tanh", f64::tanh),
    ("floor", f64::floor),
    ("ceil", f64::ceil),
    ("round", f64::round),
    ("sign", sign),
];

/// Functions of two arguments.
pub const PAIR_FUNCTIONS: &[Binary] = &[
    ("min", f64::min),
    ("max", f64::max),
    ("atan2", f64::atan2),
    ("hypot", f64::hypot),
    ("mod", f64::rem_euclid),
];

/// Operators between two values; `<=` must precede `<`.
pub const OPERATORS: &[Binary] = &[
    ("||", |a, b| truth(a != 0.0 || b != 0.0)),
    ("&&", |a, b| truth(a != 0.0 && b != 0.0)),
    ("<=", |a, b| truth(a <= b)),
    (">=", |a, b| truth(a >= b)),
    ("==", |a, b| truth(a == b)),
    ("!=", |a, b| truth(a != b)),
    ("<", |a, b| truth(a < b)),
    (">", |a, b| truth(a > b)),
    ("+", |a, b| a + b),
    ("-", |a, b| a - b),
    ("*", |a, b| a * b),
    ("/", |a, b| a / b),
    ("^", power),
];

/// Operator of derivatives alone, which the text of an expression cannot have: the product, but 0
/// wherever a factor is 0.
///
/// A formula may be constant where its parts have no derivative: `sqrt(max(t - 1, 0))` until 1 s.
pub const PRODUCT: &str = "·";

const DERIVED: &[Binary] = &[(PRODUCT, |a, b| if a == 0.0 || b == 0.0 { 0.0 } else { a * b })];

fn truth(holds: bool) -> f64 {
    f64::from(u8::from(holds))
}

fn sign(a: f64) -> f64 {
    if a == 0.0 { 0.0 } else { a.signum() }
}

/// Returns a^b, whole powers by multiplication: `y^2` is y·y to the last bit.
fn power(a: f64, b: f64) -> f64 {
    if b.fract() == 0.0 && b.abs() <= 16.0 { a.powi(b as i32) } else { a.powf(b) }
}

/// Returns the function or operator of two values with a name.
pub fn binary(name: &str) -> Option<&'static Binary> {
    PAIR_FUNCTIONS.iter().chain(OPERATORS).chain(DERIVED).find(|(known, _)| *known == name)
}

/// Returns the function of one argument with a name.
pub fn unary(name: &str) -> Option<&'static Unary> {
    FUNCTIONS.iter().find(|(known, _)| *known == name)
}
