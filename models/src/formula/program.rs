//! A formula as a list of steps on a stack: what a law runs at each bend, over whichever scalar.

use super::{FormulaError, FormulaProblem, Function, Node, Operator, Term};
use super::{exponent, max, min, power, root, sign, whole};
use crate::effects::Real;

/// Where the value of a name comes from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Source {
    /// What the law sees.
    Seen(u8),
    /// A parameter.
    Parameter(u8),
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Step {
    Number(f64),
    Seen(u8),
    Parameter(u8),
    Negative,
    Add,
    Subtract,
    Multiply,
    Divide,
    /// The same with a parameter or a number on the right, which need no place on the stack.
    TimesParameter(u8),
    TimesNumber(f64),
    TimesSeen(u8),
    Whole(i32),
    Power,
    Call(Function),
}

/// Values that may wait on the stack.
const STACK: usize = 12;
/// Values that wait in nearly all laws: a shorter stack is set up faster.
const SHORT: usize = 4;

/// A formula that can be evaluated.
#[derive(Clone, Debug)]
pub struct Program {
    steps: Vec<Step>,
    depth: usize,
}

impl Program {
    /// Compiles a formula whose names `of` knows.
    /// # Errors
    /// [`FormulaError`] at a name that `of` refuses, or if too many values would have to wait.
    pub fn compile(
        term: &Term,
        of: &dyn Fn(&str) -> Result<Source, FormulaProblem>,
    ) -> Result<Program, FormulaError> {
        let mut steps = Vec::new();
        let depth = put(term, of, &mut steps)?;
        if depth > STACK {
            return Err(FormulaError { span: term.span.clone(), problem: FormulaProblem::TooLarge });
        }
        Ok(Program { steps, depth })
    }

    /// Its value; `seen` gives what the law sees.
    #[inline]
    pub fn value<T: Real>(&self, seen: &impl Fn(u8) -> T, theta: &[T]) -> T {
        if self.depth <= SHORT {
            self.run::<T, SHORT>(seen, theta)
        } else {
            self.run::<T, STACK>(seen, theta)
        }
    }

    #[inline]
    fn run<T: Real, const N: usize>(&self, seen: &impl Fn(u8) -> T, theta: &[T]) -> T {
        let mut stack = [T::from(0.0); N];
        // The topmost value is `stack[top - 1]`.
        let mut top = 0;
        for step in &self.steps {
            match *step {
                Step::Number(_) | Step::Seen(_) | Step::Parameter(_) => {
                    stack[top] = match *step {
                        Step::Number(number) => T::from(number),
                        Step::Seen(k) => seen(k),
                        Step::Parameter(k) => theta[usize::from(k)],
                        _ => unreachable!("no value"),
                    };
                    top += 1;
                }
                Step::Add | Step::Subtract | Step::Multiply | Step::Divide | Step::Power => {
                    top -= 1;
                    let right = stack[top];
                    let left = stack[top - 1];
                    stack[top - 1] = match step {
                        Step::Add => left + right,
                        Step::Subtract => left - right,
                        Step::Multiply => left * right,
                        Step::Divide => left / right,
                        _ => power(left, right),
                    };
                }
                Step::Call(function @ (Function::Min | Function::Max)) => {
                    top -= 1;
                    let [left, right] = [stack[top - 1], stack[top]];
                    stack[top - 1] =
                        if function == Function::Min { min(left, right) } else { max(left, right) };
                }
                Step::Negative => stack[top - 1] = -stack[top - 1],
                Step::TimesParameter(k) => stack[top - 1] *= theta[usize::from(k)],
                Step::TimesNumber(number) => stack[top - 1] *= number,
                Step::TimesSeen(k) => stack[top - 1] *= seen(k),
                Step::Whole(exponent) => stack[top - 1] = stack[top - 1].powi(exponent),
                Step::Call(function) => stack[top - 1] = call(function, stack[top - 1]),
            }
        }
        stack[0]
    }
}

fn call<T: Real>(function: Function, x: T) -> T {
    match function {
        Function::Abs => x.abs(),
        Function::Sign => sign(x),
        Function::Sqrt => root(x),
        Function::Exp => x.exp(),
        Function::Log => x.ln(),
        Function::Sin => x.sin(),
        Function::Cos => x.cos(),
        Function::Tan => x.tan(),
        Function::Asin => x.asin(),
        Function::Acos => x.acos(),
        Function::Atan => x.atan(),
        Function::Sinh => x.sinh(),
        Function::Cosh => x.cosh(),
        Function::Tanh => x.tanh(),
        Function::Min | Function::Max => unreachable!("they have two arguments"),
    }
}

/// Puts the steps of a term behind others; the most values that wait meanwhile, its own included.
fn put(
    term: &Term,
    of: &dyn Fn(&str) -> Result<Source, FormulaProblem>,
    steps: &mut Vec<Step>,
) -> Result<usize, FormulaError> {
    let alone = |step: Step, inner: &Term, steps: &mut Vec<Step>| {
        let depth = put(inner, of, steps)?;
        steps.push(step);
        Ok(depth)
    };
    let pair = |step: Step, left: &Term, right: &Term, steps: &mut Vec<Step>| {
        let left = put(left, of, steps)?;
        let right = put(right, of, steps)?;
        steps.push(step);
        Ok(left.max(right + 1))
    };
    match &term.node {
        Node::Number(number) => {
            steps.push(Step::Number(*number));
            Ok(1)
        }
        Node::Name(name) => {
            let source = of(name).map_err(|problem| FormulaError { span: term.span.clone(), problem })?;
            steps.push(match source {
                Source::Seen(k) => Step::Seen(k),
                Source::Parameter(k) => Step::Parameter(k),
            });
            Ok(1)
        }
        Node::Negative(inner) => alone(Step::Negative, inner, steps),
        Node::Binary(operator, sides) => {
            let [left, right] = &**sides;
            match (operator, exponent(right).and_then(whole)) {
                (Operator::Power, Some(exponent)) => alone(Step::Whole(exponent), left, steps),
                (Operator::Power, None) => pair(Step::Power, left, right, steps),
                (Operator::Add, _) => pair(Step::Add, left, right, steps),
                (Operator::Subtract, _) => pair(Step::Subtract, left, right, steps),
                (Operator::Divide, _) => pair(Step::Divide, left, right, steps),
                (Operator::Multiply, _) => {
                    let depth = pair(Step::Multiply, left, right, steps)?;
                    // A factor that needed no step of its own is multiplied in place.
                    let at = steps.len() - 2;
                    let fused = match steps[at] {
                        Step::Parameter(k) => Some(Step::TimesParameter(k)),
                        Step::Number(number) => Some(Step::TimesNumber(number)),
                        Step::Seen(k) => Some(Step::TimesSeen(k)),
                        _ => None,
                    };
                    if let Some(fused) = fused {
                        steps.truncate(at);
                        steps.push(fused);
                    }
                    Ok(depth)
                }
            }
        }
        Node::Call(function, arguments) => match &arguments[..] {
            [left, right] => pair(Step::Call(*function), left, right, steps),
            [inner, ..] => alone(Step::Call(*function), inner, steps),
            [] => unreachable!("the parser counts arguments"),
        },
    }
}
