//! Formulas as a list of operations without repeats, evaluated at many places at once.

use super::{Binary, Formula, Function, Term};
use std::collections::HashMap;

/// Places that are evaluated at once.
pub(crate) const PLACES: usize = 16;

/// An operation on results of earlier ones, by their number.
#[derive(Debug, Clone, Copy)]
enum Operation {
    Number(f64),
    Variable(usize),
    Negative(usize),
    Binary(Binary, usize, usize),
    /// The product of a number with itself: `a^2`.
    Square(usize),
    Function(Function, usize),
    Select([usize; 4]),
}

/// Several formulas of the same variables, the last of which is the same at all places. What depends on it alone, and numbers, are worked out
/// once; what formulas have in common, too.
#[derive(Debug, Clone)]
pub(crate) struct Tape {
    /// First those that are the same everywhere.
    operations: Vec<Operation>,
    /// How many are.
    same: usize,
    /// The operation that gives each formula.
    outputs: Vec<usize>,
}

/// Results of the operations; the same memory serves many places.
#[derive(Debug, Default)]
pub(crate) struct Results {
    values: Vec<[f64; PLACES]>,
}

impl Tape {
    /// `variables` is the number of variables.
    pub(crate) fn new(formulas: &[Formula], variables: usize) -> Self {
        let mut builder = Builder { last: variables - 1, operations: Vec::new(), differs: Vec::new(), known: HashMap::new() };
        let outputs: Vec<usize> = formulas.iter().map(|formula| builder.add(&formula.root)).collect();
        // those that are the same everywhere first, else in the order in which they were made
        let mut order: Vec<usize> = (0..builder.operations.len()).collect();
        order.sort_by_key(|i| builder.differs[*i]);
        let mut place = vec![0; order.len()];
        order.iter().enumerate().for_each(|(new, old)| place[*old] = new);
        let moved = |operation: Operation| match operation {
            Operation::Number(_) | Operation::Variable(_) => operation,
            Operation::Negative(a) => Operation::Negative(place[a]),
            Operation::Square(a) => Operation::Square(place[a]),
            Operation::Function(function, a) => Operation::Function(function, place[a]),
            Operation::Binary(binary, a, b) => Operation::Binary(binary, place[a], place[b]),
            Operation::Select(all) => Operation::Select(all.map(|a| place[a])),
        };
        Self {
            operations: order.iter().map(|i| moved(builder.operations[*i])).collect(),
            same: builder.differs.iter().filter(|differs| !**differs).count(),
            outputs: outputs.into_iter().map(|i| place[i]).collect(),
        }
    }

    /// Works out what is the same everywhere; `last` is the last variable.
    pub(crate) fn begin(&self, last: f64, results: &mut Results) {
        results.values.resize(self.operations.len(), [0.0; PLACES]);
        self.run(0, self.same, &[], last, results);
    }

    /// Works out the formulas at some places, after [`begin`](Self::begin); `variables` are all but the last.
    pub(crate) fn evaluate(&self, variables: &[[f64; PLACES]], results: &mut Results) {
        self.run(self.same, self.operations.len(), variables, f64::NAN, results);
    }

    /// The values of a formula.
    pub(crate) fn output<'a>(&self, formula: usize, results: &'a Results) -> &'a [f64; PLACES] {
        &results.values[self.outputs[formula]]
    }

    fn run(&self, start: usize, end: usize, variables: &[[f64; PLACES]], last: f64, results: &mut Results) {
        for (i, operation) in self.operations.iter().enumerate().take(end).skip(start) {
            let (before, rest) = results.values.split_at_mut(i);
            let out = &mut rest[0];
            match *operation {
                Operation::Number(value) => out.fill(value),
                Operation::Variable(variable) => match variables.get(variable) {
                    Some(values) => *out = *values,
                    None => out.fill(last),
                },
                Operation::Negative(a) => one(out, &before[a], |a| -a),
                Operation::Square(a) => one(out, &before[a], |a| a * a),
                Operation::Function(function, a) => one(out, &before[a], |a| function.value(a)),
                Operation::Binary(binary, a, b) => {
                    let (a, b) = (&before[a], &before[b]);
                    match binary {
                        Binary::Add => two(out, a, b, |a, b| a + b),
                        Binary::Subtract => two(out, a, b, |a, b| a - b),
                        Binary::Multiply => two(out, a, b, |a, b| a * b),
                        Binary::Divide => two(out, a, b, |a, b| a / b),
                        other => two(out, a, b, |a, b| other.value(a, b)),
                    }
                }
                Operation::Select([a, b, at_most, above]) => {
                    for k in 0..PLACES {
                        out[k] = if before[a][k] <= before[b][k] { before[at_most][k] } else { before[above][k] };
                    }
                }
            }
        }
    }
}

#[inline(always)]
fn one(out: &mut [f64; PLACES], a: &[f64; PLACES], f: impl Fn(f64) -> f64) {
    for k in 0..PLACES {
        out[k] = f(a[k]);
    }
}

#[inline(always)]
fn two(out: &mut [f64; PLACES], a: &[f64; PLACES], b: &[f64; PLACES], f: impl Fn(f64, f64) -> f64) {
    for k in 0..PLACES {
        out[k] = f(a[k], b[k]);
    }
}

/// What an operation is, to find it again: its kind, and what it works on.
type Key = (u8, u8, [u64; 4]);

struct Builder {
    /// Number of the variable that is the same everywhere.
    last: usize,
    operations: Vec<Operation>,
    /// Whether each differs from place to place.
    differs: Vec<bool>,
    known: HashMap<Key, usize>,
}

impl Builder {
    fn add(&mut self, term: &Term) -> usize {
        match term {
            Term::Number(value) => self.operation(Operation::Number(*value), false, (0, 0, [value.to_bits(), 0, 0, 0])),
            Term::Variable(v) => self.operation(Operation::Variable(*v), *v != self.last, (1, 0, [*v as u64, 0, 0, 0])),
            Term::Negative(a) => {
                let a = self.add(a);
                self.on(Operation::Negative(a), 2, 0, &[a])
            }
            Term::Function(function, a) => {
                let a = self.add(a);
                self.on(Operation::Function(*function, a), 3, *function as u8, &[a])
            }
            Term::Binary(Binary::Power, operands) if operands[1].is(2.0) => {
                let a = self.add(&operands[0]);
                self.on(Operation::Square(a), 4, 0, &[a])
            }
            Term::Binary(binary, operands) => {
                let (a, b) = (self.add(&operands[0]), self.add(&operands[1]));
                self.on(Operation::Binary(*binary, a, b), 5, *binary as u8, &[a, b])
            }
            Term::Select(terms) => {
                let all = [0, 1, 2, 3].map(|i| self.add(&terms[i]));
                self.on(Operation::Select(all), 6, 0, &all)
            }
        }
    }

    fn on(&mut self, operation: Operation, kind: u8, which: u8, operands: &[usize]) -> usize {
        let mut key = [0; 4];
        key.iter_mut().zip(operands).for_each(|(key, operand)| *key = *operand as u64);
        let differs = operands.iter().any(|i| self.differs[*i]);
        self.operation(operation, differs, (kind, which, key))
    }

    fn operation(&mut self, operation: Operation, differs: bool, key: Key) -> usize {
        if let Some(known) = self.known.get(&key) {
            return *known;
        }
        self.operations.push(operation);
        self.differs.push(differs);
        self.known.insert(key, self.operations.len() - 1);
        self.operations.len() - 1
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A tape gives what the formulas give, and has what they share once.
    #[test]
    fn a_tape_gives_what_the_formulas_give() {
        let names = ["x", "y", "t"];
        let texts = [
            "sin(PI*x)*cos(2*t) + y^2 - 3",
            "-(sin(PI*x)^3) / (1 + exp(-t)*y) + atan2(y, x)",
            "min(x, y*t) + max(sin(PI*x), cos(2*t)) - abs(y - 0.5)",
            "2^0.5",
            "t^3",
        ];
        let mut formulas: Vec<Formula> = texts.iter().map(|text| Formula::parse(text, &names).unwrap()).collect();
        formulas.push(formulas[2].derivative(0).unwrap());
        formulas.push(formulas[1].derivative(2).unwrap());
        let tape = Tape::new(&formulas, names.len());
        let sines = tape.operations.iter().filter(|o| matches!(o, Operation::Function(Function::Sin, _))).count();
        assert_eq!(sines, 1);
        let mut results = Results::default();
        for time in [0.0, 0.7, 2.0] {
            tape.begin(time, &mut results);
            for batch in 0..3 {
                let place = |k: usize, a: usize| 0.01 + ((batch * PLACES + k) as f64 * (0.37 + a as f64)).sin().abs();
                let variables: [[f64; PLACES]; 2] = [0, 1].map(|a| std::array::from_fn(|k| place(k, a)));
                tape.evaluate(&variables, &mut results);
                for (i, formula) in formulas.iter().enumerate() {
                    for k in 0..PLACES {
                        let (value, wanted) = (tape.output(i, &results)[k], formula.eval(&[place(k, 0), place(k, 1), time]));
                        // squares are products, where the formula has a power
                        assert!((value - wanted).abs() <= 1e-14 * (1.0 + wanted.abs()), "{i} at {time}: {value}, not {wanted}");
                    }
                }
            }
        }
    }
}
