//! Derivative of an expression with respect to t, as an expression.
//!
//! ```text
//! (u + v)' = u' + v'        (u v)' = u' v + u v'        (u/v)' = (u' − v' u/v)/v
//! f(u)'    = u' f'(u)       (u^v)' = u' v u^(v−1) + v' u^v ln u
//! min(u, v)' = u' where u = min(u, v), v' elsewhere;  max in the same way
//! mod(u, v)' = u' − k v',   k = (u − mod(u, v))/v
//! ```
//!
//! Comparisons, `&&`, `||`, `floor`, `ceil`, `round` and `sign` have the derivative 0: a jump has
//! none that a wall could follow. At a kink the derivative is that of one side.
//!
//! Sums with 0 and products with 0 and 1 are left out, so that the second derivatives of usual
//! motions stay short. The other products are [`PRODUCT`]s: 0 wherever a factor is 0, even where
//! the other one is infinite.

use super::operators::{PRODUCT, binary, unary};
use super::syntax::Syntax;

/// Returns the derivative of a tree with respect to t, without the parts that are 0.
pub fn derivative(tree: &Syntax) -> Syntax {
    match tree {
        Syntax::Number(_) => number(0.0),
        Syntax::Variable(name) => number(if *name == "t" { 1.0 } else { 0.0 }),
        Syntax::Unary(name, u) => {
            let du = derivative(u);
            if is(&du, 0.0) { du } else { of_function(name, u, du) }
        }
        Syntax::Binary(name, u, v) => {
            let (du, dv) = (derivative(u), derivative(v));
            if is(&du, 0.0) && is(&dv, 0.0) { du } else { of_pair(name, [u, v], [du, dv]) }
        }
    }
}

/// Returns the number of nodes of a tree.
pub fn size(tree: &Syntax) -> usize {
    match tree {
        Syntax::Number(_) | Syntax::Variable(_) => 1,
        Syntax::Unary(_, a) => 1 + size(a),
        Syntax::Binary(_, a, b) => 1 + size(a) + size(b),
    }
}

/// Returns the derivative of a function of u.
fn of_function(name: &'static str, u: &Syntax, du: Syntax) -> Syntax {
    let u = || u.clone();
    let one = || number(1.0);
    let slope = match name {
        "-" => return negated(du),
        "abs" => call("sign", u()),
        "sqrt" => quotient(number(0.5), call("sqrt", u())),
        "exp" => call("exp", u()),
        "ln" => return quotient(du, u()),
        "log10" => return quotient(du, product(number(std::f64::consts::LN_10), u())),
        "sin" => call("cos", u()),
        "cos" => negated(call("sin", u())),
        "tan" => sum(one(), square(call("tan", u()))),
        "asin" => quotient(one(), call("sqrt", difference(one(), square(u())))),
        "acos" => quotient(number(-1.0), call("sqrt", difference(one(), square(u())))),
        "atan" => quotient(one(), sum(one(), square(u()))),
        "sinh" => call("cosh", u()),
        "cosh" => call("sinh", u()),
        // 1/cosh² would give ∞/∞ in the next derivative.
        "tanh" => difference(one(), square(call("tanh", u()))),
        "floor" | "ceil" | "round" | "sign" => return number(0.0),
        _ => number(f64::NAN),
    };
    product(du, slope)
}

/// Returns the derivative of a function or operator of u and v.
fn of_pair(name: &'static str, [u, v]: [&Syntax; 2], [du, dv]: [Syntax; 2]) -> Syntax {
    let (u, v) = (|| u.clone(), || v.clone());
    match name {
        "+" => sum(du, dv),
        "-" => difference(du, dv),
        "*" | PRODUCT => sum(product(du, v()), product(dv, u())),
        "/" => {
            let of_v = product(dv, quotient(u(), v()));
            quotient(difference(du, of_v), v())
        }
        "^" => {
            let of_u = product(du, product(v(), power(u(), difference(v(), number(1.0)))));
            let of_v = if is(&dv, 0.0) { dv } else { product(dv, product(power(u(), v()), call("ln", u()))) };
            sum(of_u, of_v)
        }
        "min" | "max" => {
            let found = || pair(name, u(), v());
            let of_u = product(pair("==", found(), u()), du);
            let of_v = product(pair("!=", found(), u()), dv);
            sum(of_u, of_v)
        }
        "atan2" => {
            let above = difference(product(du, v()), product(dv, u()));
            product(above, quotient(number(1.0), sum(square(u()), square(v()))))
        }
        "hypot" => {
            let above = sum(product(du, u()), product(dv, v()));
            product(above, quotient(number(1.0), pair("hypot", u(), v())))
        }
        "mod" => {
            // Rounding makes the number of periods a constant for the next derivative.
            let rest = difference(u(), pair("mod", u(), v()));
            difference(du, product(dv, call("round", quotient(rest, v()))))
        }
        "||" | "&&" | "<=" | ">=" | "==" | "!=" | "<" | ">" => number(0.0),
        _ => number(f64::NAN),
    }
}

fn number(value: f64) -> Syntax {
    Syntax::Number(value)
}

/// Returns true for this number.
fn is(tree: &Syntax, value: f64) -> bool {
    matches!(tree, Syntax::Number(found) if *found == value)
}

/// Returns a function of a tree, computed where it is a number.
fn call(name: &'static str, a: Syntax) -> Syntax {
    match (&a, unary(name)) {
        (Syntax::Number(a), Some((_, apply))) => number(apply(*a)),
        _ => Syntax::Unary(name, Box::new(a)),
    }
}

/// Returns an operator between trees, computed where both are numbers.
fn pair(name: &'static str, a: Syntax, b: Syntax) -> Syntax {
    match (&a, &b, binary(name)) {
        (Syntax::Number(a), Syntax::Number(b), Some((_, apply))) => number(apply(*a, *b)),
        _ => Syntax::Binary(name, Box::new(a), Box::new(b)),
    }
}

fn negated(a: Syntax) -> Syntax {
    match a {
        Syntax::Number(value) => number(-value),
        Syntax::Unary("-", inner) => *inner,
        a => Syntax::Unary("-", Box::new(a)),
    }
}

fn sum(a: Syntax, b: Syntax) -> Syntax {
    match (a, b) {
        (a, b) if is(&b, 0.0) => a,
        (a, b) if is(&a, 0.0) => b,
        (a, b) => pair("+", a, b),
    }
}

fn difference(a: Syntax, b: Syntax) -> Syntax {
    match (a, b) {
        (a, b) if is(&b, 0.0) => a,
        (a, b) if is(&a, 0.0) => negated(b),
        (a, b) => pair("-", a, b),
    }
}

/// Returns a product, by a number outside a product in its factor: `2*(3*a)` is `6*a`.
fn product(a: Syntax, b: Syntax) -> Syntax {
    match (a, b) {
        (a, b) if is(&a, 0.0) || is(&b, 0.0) => number(0.0),
        (a, b) if is(&a, 1.0) => b,
        (a, b) if is(&b, 1.0) => a,
        (a, b) if is(&a, -1.0) => negated(b),
        (a, b) if is(&b, -1.0) => negated(a),
        (Syntax::Number(a), Syntax::Number(b)) => number(a * b),
        (a, b @ Syntax::Number(_)) => product(b, a),
        (Syntax::Number(a), Syntax::Binary("*", b, c)) if matches!(*b, Syntax::Number(_)) => {
            product(pair("*", number(a), *b), *c)
        }
        (a @ Syntax::Number(_), b) => pair("*", a, b),
        (a, b) => pair(PRODUCT, a, b),
    }
}

fn quotient(a: Syntax, b: Syntax) -> Syntax {
    match (a, b) {
        (a, _) if is(&a, 0.0) => a,
        (a, b) if is(&b, 1.0) => a,
        (a, b) => pair("/", a, b),
    }
}

fn power(a: Syntax, b: Syntax) -> Syntax {
    match (a, b) {
        (_, b) if is(&b, 0.0) => number(1.0),
        (a, b) if is(&b, 1.0) => a,
        (a, b) => pair("^", a, b),
    }
}

fn square(a: Syntax) -> Syntax {
    power(a, number(2.0))
}

#[cfg(test)]
mod tests {
    use super::super::operators::{FUNCTIONS, OPERATORS, PAIR_FUNCTIONS};
    use super::super::program::Program;
    use super::super::{Constants, parser};
    use super::*;

    fn tree(text: &str) -> Syntax {
        parser::read(text, &Constants::default()).expect("an expression").folded()
    }

    fn value(tree: &Syntax, time: f64) -> f64 {
        Program::new(tree).expect("a program").value([0.0, 0.0, 0.0, time])
    }

    /// Compares two derivatives of a text with differences of the expression and of the first one.
    fn check(text: &str, time: f64) {
        // Error h⁴/30 times the fifth derivative, which is 1e6 for the slope of asin near 1.
        const STEP: f64 = 1e-3;
        let mut current = tree(text);
        for order in 1..=2 {
            let next = derivative(&current);
            let at = |steps: f64| value(&current, time + steps * STEP);
            let expected = (8.0 * (at(1.0) - at(-1.0)) - (at(2.0) - at(-2.0))) / (12.0 * STEP);
            let found = value(&next, time);
            assert!(
                (found - expected).abs() < 3e-7 * expected.abs().max(1.0),
                "derivative {order} of {text} at {time}: {found}, differences give {expected}"
            );
            current = next;
        }
    }

    #[test]
    fn derivatives_of_every_function_are_those_of_differences() {
        for (name, _) in FUNCTIONS {
            for inner in ["t", "-t + 0.1", "0.3*t^2", "0.5*sin(2*t)", "exp(-t)"] {
                for time in [0.37, 0.61, 0.93] {
                    let inside = if matches!(*name, "ln" | "log10" | "sqrt") { "abs" } else { "" };
                    check(&format!("{name}({inside}({inner}))"), time);
                }
            }
        }
    }

    #[test]
    fn derivatives_of_every_pair_function_and_operator_are_those_of_differences() {
        let names = PAIR_FUNCTIONS.iter().chain(OPERATORS).map(|(name, _)| *name);
        for name in names {
            for [a, b] in [["1 + t", "2*t"], ["t^2", "1.3 + t"], ["exp(t)", "2"], ["2", "cos(t)"]] {
                for time in [0.37, 0.61, 0.93] {
                    if name.chars().all(char::is_alphanumeric) {
                        check(&format!("{name}({a}, {b})"), time);
                    } else {
                        check(&format!("({a}) {name} ({b})"), time);
                    }
                }
            }
        }
    }

    /// A factor of a divisor once made the simplification endless.
    #[test]
    fn derivatives_of_scaled_times_are_those_of_differences() {
        for text in ["1 - exp(-(t/0.3)^2)", "(t/0.3)^4", "(2*t/3)^3", "exp(-(2*t)^4)*sin(7*t/2)", "(5*t)^2*3"]
        {
            check(text, 0.37);
        }
    }

    #[test]
    fn derivatives_of_usual_motions_are_those_of_differences() {
        for text in [
            "2*pi*3*(t - 0.1*tanh(t/0.1))",
            "0.01*sin(2*pi*t)*exp(-t)",
            "(t < 0.5)*t^3 + (t >= 0.5)*(t^2 - 0.125)",
            "min(t/0.7, 1)^2*(3 - 2*min(t/0.7, 1))",
            "sqrt(1 + 0.1*t^2) - mod(3*t, 1.1)",
            "(1 + t)^-3/(2 - t)^0.5",
        ] {
            for time in [0.1, 0.37, 0.61, 0.93] {
                check(text, time);
            }
        }
    }

    #[test]
    fn derivatives_are_finite_where_the_expression_is_smooth() {
        for (text, time, expected) in [
            ("t^2", 0.0, [0.0, 2.0]),
            ("t^3 - 4*t", 0.0, [-4.0, 0.0]),
            ("sqrt(max(t - 1, 0))", 0.5, [0.0, 0.0]),
            ("(t > 1)*(t - 1)^2.5", 1.0, [0.0, 0.0]),
            ("asin(min(t, 1))", 2.0, [0.0, 0.0]),
            ("max(t - 1, 0)^1.5", 0.5, [0.0, 0.0]),
            ("tanh(1e4*t)", 1.0, [0.0, 0.0]),
            ("hypot(0*t, 0*t) + 3*t", 1.0, [3.0, 0.0]),
            ("(-2)^round(t)", 1.1, [0.0, 0.0]),
            ("t*sqrt(t)", 1.0, [1.5, 0.75]),
        ] {
            let first = derivative(&tree(text));
            let second = derivative(&first);
            assert_eq!([value(&first, time), value(&second, time)], expected, "{text}");
        }
    }

    #[test]
    fn other_variables_are_constants() {
        assert!(is(&derivative(&tree("x*y + sin(z)")), 0.0));
        let found = Program::new(&derivative(&tree("x*t^2"))).expect("a program");
        assert_eq!(found.value([5.0, 0.0, 0.0, 3.0]), 30.0);
    }

    #[test]
    fn second_derivatives_of_usual_motions_are_short() {
        for (text, most) in [
            ("0.01*sin(2*pi*t)", 8),
            ("0.5*3*t^2", 1),
            ("t^3 - 2*t + 1", 3),
            ("exp(-t/0.1)", 12),
            ("t - 0.1*tanh(t/0.1)", 25),
        ] {
            let second = derivative(&derivative(&tree(text)));
            assert!(size(&second) <= most, "{text}: {} nodes, {second:?}", size(&second));
        }
    }
}
