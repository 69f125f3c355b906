//! A formula as a program for a small stack machine.
//!
//! The tree of an expression is written in postfix order: `x*(y + 2)` becomes `x y 2 + *`. Operands
//! are evaluated from the left, each operator and function once per node of the tree.

use super::operators::{binary, unary};
use super::syntax::{Syntax, VARIABLES};

/// Largest stack of a program; the parser bounds the nesting of an expression below it.
const STACK: usize = 64;

/// Instruction of a program.
#[derive(Clone, Copy, Debug)]
enum Instruction {
    /// Pushes a number.
    Number(f64),
    /// Pushes x, y, z or t, by index.
    Variable(usize),
    /// Changes the sign of the last value.
    Negate,
    /// Applies a function to the last value.
    Unary(fn(f64) -> f64),
    /// Applies an operator or function to the last two values.
    Binary(fn(f64, f64) -> f64),
}

/// A compiled formula of x, y, z, t.
#[derive(Clone, Debug)]
pub struct Program {
    instructions: Box<[Instruction]>,
}

impl Program {
    /// Compiles a tree; None where it holds a number that is not finite or is nested too deeply.
    pub fn new(tree: &Syntax) -> Option<Self> {
        let mut instructions = Vec::new();
        let depth = append(tree, &mut instructions)?;
        (depth <= STACK).then(|| Self { instructions: instructions.into() })
    }

    /// Returns the value at x, y, z (m) and t (s).
    pub fn value(&self, place: [f64; 4]) -> f64 {
        let mut stack = [0.0; STACK];
        let mut top = 0;
        for instruction in &self.instructions {
            match *instruction {
                Instruction::Number(value) => {
                    stack[top] = value;
                    top += 1;
                }
                Instruction::Variable(variable) => {
                    stack[top] = place[variable];
                    top += 1;
                }
                Instruction::Negate => stack[top - 1] = -stack[top - 1],
                Instruction::Unary(apply) => stack[top - 1] = apply(stack[top - 1]),
                Instruction::Binary(apply) => {
                    top -= 1;
                    stack[top - 1] = apply(stack[top - 1], stack[top]);
                }
            }
        }
        stack[0]
    }

    /// Returns true if the value depends on any of these variables, given by their indices in x, y,
    /// z, t.
    pub fn depends_on(&self, places: &[usize]) -> bool {
        let is_one_of = |instruction: &Instruction| matches!(instruction, Instruction::Variable(place) if places.contains(place));
        self.instructions.iter().any(is_one_of)
    }
}

/// Appends the instructions of a tree; returns the stack that they need.
fn append(tree: &Syntax, instructions: &mut Vec<Instruction>) -> Option<usize> {
    match tree {
        Syntax::Number(value) if !value.is_finite() => return None,
        Syntax::Number(value) => instructions.push(Instruction::Number(*value)),
        Syntax::Variable(name) => {
            let place = VARIABLES.iter().position(|known| known == name)?;
            instructions.push(Instruction::Variable(place));
        }
        Syntax::Unary(name, a) => {
            let depth = append(a, instructions)?;
            let apply = unary(name).map(|(_, apply)| Instruction::Unary(*apply));
            instructions.push(apply.unwrap_or(Instruction::Negate));
            return Some(depth);
        }
        Syntax::Binary(name, a, b) => {
            let (left, right) = (append(a, instructions)?, append(b, instructions)?);
            instructions.push(Instruction::Binary(binary(name)?.1));
            return Some(left.max(right + 1));
        }
    }
    Some(1)
}

#[cfg(test)]
mod tests {
    use proptest::prelude::{Just, Strategy, any, prop_assert_eq, prop_oneof, proptest};
    use proptest::sample::select;

    use super::super::operators::{FUNCTIONS, OPERATORS, PAIR_FUNCTIONS};
    use super::*;

    fn naive(tree: &Syntax, place: [f64; 4]) -> f64 {
        match tree {
            Syntax::Number(value) => *value,
            Syntax::Variable(name) => {
                place[VARIABLES.iter().position(|known| known == name).expect("a variable")]
            }
            Syntax::Unary("-", a) => -naive(a, place),
            Syntax::Unary(name, a) => unary(name).expect("a function").1(naive(a, place)),
            Syntax::Binary(name, a, b) => {
                binary(name).expect("an operator").1(naive(a, place), naive(b, place))
            }
        }
    }

    fn trees() -> impl Strategy<Value = Syntax> {
        let leaf = prop_oneof![
            (-100.0..100.0_f64).prop_map(Syntax::Number),
            select(vec![0.0, -0.0, 1.0, 2.0, -3.0, 0.5, 17.0]).prop_map(Syntax::Number),
            select(VARIABLES.to_vec()).prop_map(Syntax::Variable),
        ];
        leaf.prop_recursive(6, 64, 2, |inner| {
            let functions: Vec<&str> = FUNCTIONS.iter().map(|(name, _)| *name).chain(["-"]).collect();
            let pairs: Vec<&str> = PAIR_FUNCTIONS.iter().chain(OPERATORS).map(|(name, _)| *name).collect();
            prop_oneof![
                (select(functions), inner.clone()).prop_map(|(name, a)| Syntax::Unary(name, Box::new(a))),
                (select(pairs), inner.clone(), inner).prop_map(|(name, a, b)| Syntax::Binary(
                    name,
                    Box::new(a),
                    Box::new(b)
                )),
            ]
        })
    }

    fn variable() -> impl Strategy<Value = f64> {
        prop_oneof![any::<f64>(), -10.0..10.0_f64, Just(0.0), Just(-0.0), Just(1.0), Just(2.0)]
    }

    proptest! {
        #[test]
        fn program_equals_recursive_evaluation_bitwise(
            tree in trees(), x in variable(), y in variable(), z in variable(), t in variable()
        ) {
            let place = [x, y, z, t];
            let program = Program::new(&tree).expect("a tree of finite numbers");
            prop_assert_eq!(program.value(place).to_bits(), naive(&tree, place).to_bits());
        }
    }

    #[test]
    fn every_depth_the_parser_accepts_compiles() {
        let constants = super::super::Constants::default();
        let mut text = "x".to_owned();
        let mut depths = 0;
        for depth in 1..200 {
            text = format!("min(x, 1 + ({text}))");
            let Ok(tree) = super::super::parser::read(&text, &constants) else { break };
            let program = Program::new(&tree).unwrap_or_else(|| panic!("no program at depth {depth}"));
            assert_eq!(program.value([1.0, 0.0, 0.0, 0.0]), 1.0, "at depth {depth}");
            depths = depth;
        }
        assert!(depths > 0, "not even one call is read");
    }
}
