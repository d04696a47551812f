//! Formulas of a few variables, with exact derivatives: `"0.1*sin(PI*x/25)"`.
//!
//! The rules are those of paper: `^` binds tighter than a sign before it (`-x^2` is `-(x^2)`) and groups to the right, then come
//! `*` and `/`, then `+` and `-`; `1e-3` is a number. (Crates that evaluate formulas differ in these: exmex 0.21 reads `-x^2` as
//! `(-x)^2` and does not know `1e-3`, which is why the parser is our own.)

mod tape;

pub(crate) use tape::{PLACES, Results, Tape};

use super::Expr;
use super::fault::{hint, plain};
use std::f64::consts;

/// Longest text of a formula, in characters: a manufactured body force takes thousands.
const LONGEST: usize = 5000;
/// Most parentheses, signs and powers inside each other.
const DEEPEST: usize = 64;
/// Most operations of a derivative: products of products grow with every derivative.
const LARGEST: usize = 100_000;

const CONSTANTS: [(&str, f64); 6] =
    [("PI", consts::PI), ("pi", consts::PI), ("π", consts::PI), ("E", consts::E), ("e", consts::E), ("TAU", consts::TAU)];

/// A formula that is ready to be evaluated, in variables that are known by their number.
#[derive(Debug, Clone, PartialEq)]
pub struct Formula {
    root: Term,
}

#[derive(Debug, Clone, PartialEq)]
enum Term {
    Number(f64),
    Variable(usize),
    Negative(Box<Term>),
    Binary(Binary, Box<[Term; 2]>),
    Function(Function, Box<Term>),
    /// The third where the first is at most the second, else the fourth: the derivative of `min` and `max`.
    Select(Box<[Term; 4]>),
}

#[derive(Debug, Clone, Copy, PartialEq)]
enum Binary {
    Add,
    Subtract,
    Multiply,
    Divide,
    Power,
    Min,
    Max,
    Atan2,
}

/// Functions of two arguments, as they are written.
const BINARY_FUNCTIONS: [(&str, Binary); 3] = [("min", Binary::Min), ("max", Binary::Max), ("atan2", Binary::Atan2)];

/// Declares the functions of one argument: name in a formula, name here, value.
macro_rules! functions {
    ($($text:literal $name:ident $method:ident,)*) => {
        #[derive(Debug, Clone, Copy, PartialEq)]
        enum Function { $($name,)* }
        const FUNCTIONS: &[(&str, Function)] = &[$(($text, Function::$name),)*];
        impl Function {
            fn value(self, x: f64) -> f64 {
                match self { $(Self::$name => x.$method(),)* }
            }
        }
    };
}
functions! {
    "sin" Sin sin, "cos" Cos cos, "tan" Tan tan, "asin" Asin asin, "acos" Acos acos, "atan" Atan atan,
    "sinh" Sinh sinh, "cosh" Cosh cosh, "tanh" Tanh tanh,
    "exp" Exp exp, "ln" Ln ln, "log10" Log10 log10, "sqrt" Sqrt sqrt, "cbrt" Cbrt cbrt,
    "abs" Abs abs, "sign" Signum signum, "floor" Floor floor, "ceil" Ceil ceil, "round" Round round,
}

impl Formula {
    /// Reads a formula of the given variables.
    ///
    /// # Errors
    /// Says what is wrong and at which character: an unknown name (with those allowed), a missing operand, a number that is not
    /// finite, or too long or too deep a text. A formula without variables must have a finite value.
    pub fn parse(text: &str, variables: &[&'static str]) -> Result<Self, String> {
        if text.chars().count() > LONGEST {
            return Err(format!("is a formula of more than {LONGEST} characters"));
        }
        let mut parser = Parser { text, position: 0, depth: 0, variables };
        let root = parser.sum().map_err(|message| format!("is not a formula: \"{text}\": {message}"))?;
        parser.end().map_err(|message| format!("is not a formula: \"{text}\": {message}"))?;
        let formula = Self { root };
        if (0..variables.len()).all(|variable| !formula.uses(variable)) {
            let value = formula.root.value(&[]);
            if !value.is_finite() {
                return Err(format!("\"{text}\" is {}; must be a finite number", plain(value)));
            }
        }
        Ok(formula)
    }

    /// A formula that always has this value.
    pub fn constant(value: f64) -> Self {
        Self { root: Term::Number(value) }
    }

    /// The value where the variables, in the order given to [`parse`](Self::parse), have these values. Allocates nothing.
    ///
    /// # Panics
    /// Where a variable that the formula uses has no value.
    pub fn eval(&self, values: &[f64]) -> f64 {
        self.root.value(values)
    }

    /// The partial derivative by the variable of that number. Steps (`sign`, `floor`, ...) count as flat.
    ///
    /// # Errors
    /// Where the derivative has more than a hundred thousand operations.
    pub fn derivative(&self, variable: usize) -> Result<Self, String> {
        let root = self.root.derivative(variable);
        let size = root.size();
        if size > LARGEST { Err(format!("the derivative has {size} operations, more than {LARGEST}")) } else { Ok(Self { root }) }
    }

    /// Whether the variable of that number occurs.
    pub fn uses(&self, variable: usize) -> bool {
        self.root.uses(variable)
    }
}

impl Expr {
    /// The formula that a number or text stands for.
    ///
    /// # Errors
    /// As [`Formula::parse`]; also for a number that is not finite.
    pub fn compile(&self, variables: &[&'static str]) -> Result<Formula, String> {
        match self {
            Self::Number(value) if !value.is_finite() => Err(format!("is {}; must be a finite number", plain(*value))),
            Self::Number(value) => Ok(Formula { root: Term::Number(*value) }),
            Self::Formula(text) => Formula::parse(text, variables),
        }
    }
}

impl Term {
    fn value(&self, values: &[f64]) -> f64 {
        match self {
            Self::Number(value) => *value,
            Self::Variable(variable) => values[*variable],
            Self::Negative(a) => -a.value(values),
            Self::Function(function, a) => function.value(a.value(values)),
            Self::Binary(operator, operands) => operator.value(operands[0].value(values), operands[1].value(values)),
            Self::Select(terms) => {
                let [a, b, at_most, above] = terms.as_ref();
                if a.value(values) <= b.value(values) { at_most.value(values) } else { above.value(values) }
            }
        }
    }

    fn parts(&self) -> &[Self] {
        match self {
            Self::Number(_) | Self::Variable(_) => &[],
            Self::Negative(a) | Self::Function(_, a) => std::slice::from_ref(a),
            Self::Binary(_, terms) => terms.as_ref(),
            Self::Select(terms) => terms.as_ref(),
        }
    }

    fn uses(&self, variable: usize) -> bool {
        matches!(self, Self::Variable(v) if *v == variable) || self.parts().iter().any(|part| part.uses(variable))
    }

    fn size(&self) -> usize {
        1 + self.parts().iter().map(Self::size).sum::<usize>()
    }

    fn derivative(&self, variable: usize) -> Self {
        if !self.uses(variable) {
            return Self::Number(0.0);
        }
        match self {
            Self::Number(_) => Self::Number(0.0),
            Self::Variable(_) => Self::Number(1.0),
            Self::Negative(a) => negative(a.derivative(variable)),
            Self::Function(function, a) => multiply(function.derivative(a), a.derivative(variable)),
            Self::Binary(operator, operands) => {
                let [a, b] = operands.as_ref();
                let [da, db] = [a.derivative(variable), b.derivative(variable)];
                operator.derivative(a, b, da, db)
            }
            Self::Select(terms) => {
                let [a, b, at_most, above] = terms.as_ref();
                Self::Select(Box::new([a.clone(), b.clone(), at_most.derivative(variable), above.derivative(variable)]))
            }
        }
    }

    fn is(&self, value: f64) -> bool {
        matches!(self, Self::Number(v) if *v == value)
    }
}

impl Binary {
    fn value(self, a: f64, b: f64) -> f64 {
        match self {
            Self::Add => a + b,
            Self::Subtract => a - b,
            Self::Multiply => a * b,
            Self::Divide => a / b,
            Self::Power => a.powf(b),
            Self::Min => a.min(b),
            Self::Max => a.max(b),
            Self::Atan2 => a.atan2(b),
        }
    }

    fn derivative(self, a: &Term, b: &Term, da: Term, db: Term) -> Term {
        let (a, b) = (a.clone(), b.clone());
        match self {
            Self::Add => add(da, db),
            Self::Subtract => add(da, negative(db)),
            Self::Multiply => add(multiply(da, b), multiply(a, db)),
            Self::Divide if db.is(0.0) => divide(da, b),
            Self::Divide => divide(add(multiply(da, b.clone()), negative(multiply(a, db))), power(b, Term::Number(2.0))),
            Self::Power if db.is(0.0) => multiply(multiply(b.clone(), power(a, add(b, Term::Number(-1.0)))), da),
            Self::Power => {
                let log = Term::Function(Function::Ln, Box::new(a.clone()));
                let inner = add(multiply(db, log), divide(multiply(b.clone(), da), a.clone()));
                multiply(power(a, b), inner)
            }
            Self::Min => Term::Select(Box::new([a, b, da, db])),
            Self::Max => Term::Select(Box::new([a, b, db, da])),
            Self::Atan2 => {
                let square = |term: &Term| power(term.clone(), Term::Number(2.0));
                let radius2 = add(square(&a), square(&b));
                divide(add(multiply(b, da), negative(multiply(a, db))), radius2)
            }
        }
    }
}

impl Function {
    /// The derivative at the argument `a`.
    fn derivative(self, a: &Term) -> Term {
        let number = Term::Number;
        let of = |function| Term::Function(function, Box::new(a.clone()));
        let square = |term| power(term, number(2.0));
        match self {
            Self::Sin => of(Self::Cos),
            Self::Cos => negative(of(Self::Sin)),
            Self::Tan => divide(number(1.0), square(of(Self::Cos))),
            Self::Asin => power(add(number(1.0), negative(square(a.clone()))), number(-0.5)),
            Self::Acos => negative(Self::Asin.derivative(a)),
            Self::Atan => divide(number(1.0), add(number(1.0), square(a.clone()))),
            Self::Sinh => of(Self::Cosh),
            Self::Cosh => of(Self::Sinh),
            Self::Tanh => divide(number(1.0), square(of(Self::Cosh))),
            Self::Exp => of(Self::Exp),
            Self::Ln => divide(number(1.0), a.clone()),
            Self::Log10 => divide(number(consts::LOG10_E), a.clone()),
            Self::Sqrt => divide(number(0.5), of(Self::Sqrt)),
            Self::Cbrt => divide(number(1.0 / 3.0), square(of(Self::Cbrt))),
            Self::Abs => of(Self::Signum),
            Self::Signum | Self::Floor | Self::Ceil | Self::Round => number(0.0),
        }
    }
}

// Derivatives are full of zeros and ones; these leave them out.

fn negative(a: Term) -> Term {
    match a {
        Term::Number(0.0) => Term::Number(0.0),
        Term::Number(value) => Term::Number(-value),
        Term::Negative(inner) => *inner,
        a => Term::Negative(Box::new(a)),
    }
}

fn add(a: Term, b: Term) -> Term {
    match (a, b) {
        (Term::Number(a), Term::Number(b)) => Term::Number(a + b),
        (a, b) if a.is(0.0) => b,
        (a, b) if b.is(0.0) => a,
        (a, b) => Term::Binary(Binary::Add, Box::new([a, b])),
    }
}

fn multiply(a: Term, b: Term) -> Term {
    match (a, b) {
        (a, b) if a.is(0.0) || b.is(0.0) => Term::Number(0.0),
        (a, b) if a.is(1.0) => b,
        (a, b) if b.is(1.0) => a,
        (a, b) => Term::Binary(Binary::Multiply, Box::new([a, b])),
    }
}

fn divide(a: Term, b: Term) -> Term {
    if a.is(0.0) { a } else { Term::Binary(Binary::Divide, Box::new([a, b])) }
}

fn power(a: Term, b: Term) -> Term {
    if b.is(1.0) { a } else { Term::Binary(Binary::Power, Box::new([a, b])) }
}

/// Reads by recursive descent; messages name the place in the text.
struct Parser<'a> {
    text: &'a str,
    /// Byte offset of what comes next.
    position: usize,
    depth: usize,
    variables: &'a [&'static str],
}

impl<'a> Parser<'a> {
    fn sum(&mut self) -> Result<Term, String> {
        self.chain(&[('+', Binary::Add), ('-', Binary::Subtract)], Self::product)
    }

    fn product(&mut self) -> Result<Term, String> {
        self.chain(&[('*', Binary::Multiply), ('/', Binary::Divide)], Self::signed)
    }

    /// Operators of one rank, grouped to the left.
    fn chain(&mut self, operators: &[(char, Binary)], operand: fn(&mut Self) -> Result<Term, String>) -> Result<Term, String> {
        let mut term = operand(self)?;
        while let Some(&(_, operator)) = operators.iter().find(|(sign, _)| self.take(*sign)) {
            term = Term::Binary(operator, Box::new([term, operand(self)?]));
        }
        Ok(term)
    }

    fn signed(&mut self) -> Result<Term, String> {
        self.depth += 1;
        if self.depth > DEEPEST {
            return Err(format!("is nested deeper than {DEEPEST}"));
        }
        let term = if self.take('-') {
            Term::Negative(Box::new(self.signed()?))
        } else if self.take('+') {
            self.signed()?
        } else {
            let base = self.operand()?;
            if self.take('^') { Term::Binary(Binary::Power, Box::new([base, self.signed()?])) } else { base }
        };
        self.depth -= 1;
        Ok(term)
    }

    fn operand(&mut self) -> Result<Term, String> {
        match self.next() {
            Some('(') => {
                self.take('(');
                let term = self.sum()?;
                self.expect(')')?;
                Ok(term)
            }
            Some(c) if c.is_ascii_digit() || c == '.' => self.number(),
            Some(c) if c.is_alphabetic() || c == '_' => self.name(),
            _ => Err(format!("a number, a name or ( is wanted {}", self.place())),
        }
    }

    fn number(&mut self) -> Result<Term, String> {
        let rest = &self.text[self.position..];
        let digits = |from: usize| rest[from..].bytes().take_while(u8::is_ascii_digit).count();
        let mut length = digits(0);
        if rest[length..].starts_with('.') {
            length += 1 + digits(length + 1);
        }
        if rest[length..].starts_with(['e', 'E']) {
            let sign = usize::from(rest[length + 1..].starts_with(['+', '-']));
            let exponent = digits(length + 1 + sign);
            // Without digits the letter is a name: `2e` is then told that an operator is missing.
            if exponent > 0 {
                length += 1 + sign + exponent;
            }
        }
        match rest[..length].parse::<f64>() {
            Ok(value) if value.is_finite() => {
                self.position += length;
                Ok(Term::Number(value))
            }
            Ok(_) => Err(format!("{} is too large for a number", &rest[..length])),
            Err(_) => Err(format!("a number is wanted {}", self.place())),
        }
    }

    fn name(&mut self) -> Result<Term, String> {
        let rest = &self.text[self.position..];
        let length = rest.find(|c: char| !c.is_alphanumeric() && c != '_').unwrap_or(rest.len());
        let name = &rest[..length];
        self.position += length;
        if self.next() == Some('(') {
            return self.call(name);
        }
        let variable = self.variables.iter().position(|v| *v == name).map(Term::Variable);
        let constant = || CONSTANTS.iter().find(|(constant, _)| *constant == name).map(|&(_, value)| Term::Number(value));
        variable.or_else(constant).ok_or_else(|| {
            let known: Vec<&str> = self.variables.iter().copied().chain(["PI", "E", "TAU"]).collect();
            format!("unknown variable `{name}`{}", hint(name, &known))
        })
    }

    fn call(&mut self, name: &str) -> Result<Term, String> {
        let one = FUNCTIONS.iter().find(|(text, _)| *text == name).map(|&(_, function)| function);
        let two = BINARY_FUNCTIONS.iter().find(|(text, _)| *text == name).map(|&(_, function)| function);
        self.expect('(')?;
        let term = match (one, two) {
            (Some(function), _) => Term::Function(function, Box::new(self.sum()?)),
            (None, Some(function)) => {
                let first = self.sum()?;
                self.expect(',')?;
                Term::Binary(function, Box::new([first, self.sum()?]))
            }
            (None, None) => {
                let known: Vec<&str> = FUNCTIONS.iter().map(|f| f.0).chain(BINARY_FUNCTIONS.iter().map(|f| f.0)).collect();
                return Err(format!("unknown function `{name}`{}", hint(name, &known)));
            }
        };
        self.expect(')')?;
        Ok(term)
    }

    fn end(&mut self) -> Result<(), String> {
        match self.next() {
            None => Ok(()),
            Some(_) => Err(format!("an operator is wanted {}", self.place())),
        }
    }

    /// The next character that is not a space.
    fn next(&mut self) -> Option<char> {
        let rest = &self.text[self.position..];
        self.position += rest.len() - rest.trim_start().len();
        self.text[self.position..].chars().next()
    }

    fn take(&mut self, wanted: char) -> bool {
        let found = self.next() == Some(wanted);
        if found {
            self.position += wanted.len_utf8();
        }
        found
    }

    fn expect(&mut self, wanted: char) -> Result<(), String> {
        if self.take(wanted) { Ok(()) } else { Err(format!("{wanted} is wanted {}", self.place())) }
    }

    fn place(&self) -> String {
        let number = self.text[..self.position].chars().count() + 1;
        match self.text[self.position..].chars().next() {
            Some(found) => format!("at character {number}, where there is {found}"),
            None => "at the end".into(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const XT: [&str; 4] = ["x", "y", "z", "t"];

    fn value(text: &str) -> f64 {
        Formula::parse(text, &XT).unwrap().eval(&[0.3, 0.7, -1.1, 2.0])
    }

    fn fault(text: &str) -> String {
        Formula::parse(text, &XT).unwrap_err()
    }

    #[test]
    fn values_follow_the_rules_of_paper() {
        let (x, y, t) = (0.3f64, 0.7f64, 2.0f64);
        assert_eq!(value("-x^2"), -x.powi(2));
        assert_eq!(value("2^-1"), 0.5);
        assert_eq!(value("2^3^2"), 512.0);
        assert_eq!(value("1-2-3"), -4.0);
        assert_eq!(value("12/2*3"), 18.0);
        assert_eq!(value("1e-3*t + 2.5E2 + .5 + 5."), 1e-3 * t + 250.0 + 0.5 + 5.0);
        assert_eq!(value("2*e - E"), consts::E);
        assert_eq!(value(" sin( PI * x ) * cos(2*π*y)"), (consts::PI * x).sin() * (2.0 * consts::PI * y).cos());
        assert_eq!(value("max(x, y) + min(x, y) - atan2(x, y)"), x.max(y) + x.min(y) - x.atan2(y));
        assert_eq!(value("--+x"), x);
    }

    #[test]
    fn derivatives_agree_with_differences() {
        let texts = "x^3*y - x/y | sin(x*t)^2 | exp(-x^2/2)*cos(t) | x^y | 2^x | sqrt(1+x^2) | tan(x) | atan(x*y) | asin(x) | acos(x/2) \
            | ln(x*x+1) | log10(x+3) | abs(z*x) | sinh(x)*cosh(x) | tanh(2*x) | cbrt(x) | atan2(x*y, t) | min(x^2, y) | max(x^2, x^3) \
            | (x+y)/(x*y+2) | floor(x)*x + sign(y)*x | -x*-(x+1) | min(max(x, y), t)*x";
        let at = [0.31, 0.7, -1.1, 2.0];
        for text in texts.split('|') {
            let formula = Formula::parse(text, &XT).unwrap();
            for variable in 0..4 {
                let shifted = |step: f64| {
                    let mut values = at;
                    values[variable] += step;
                    formula.eval(&values)
                };
                let difference = (shifted(1e-5) - shifted(-1e-5)) / 2e-5;
                let exact = formula.derivative(variable).unwrap().eval(&at);
                // second-order differences: 1e-10 of the third derivative, and round-off 1e-16 / 1e-5
                assert!((exact - difference).abs() < 1e-8 * (1.0 + exact.abs()), "{text} by {variable}: {exact} {difference}");
            }
        }
        let third = Formula::parse("x^3", &XT).and_then(|f| f.derivative(0)?.derivative(0)?.derivative(0)).unwrap();
        assert_eq!((third.eval(&[0.0]), third.uses(0)), (6.0, false));
    }

    #[test]
    fn variables_are_known_by_number() {
        let formula = Formula::parse("z - 0*x", &XT).unwrap();
        assert_eq!([0, 1, 2, 3].map(|v| formula.uses(v)), [true, false, true, false]);
        assert_eq!(Expr::Number(4.0).compile(&[]).unwrap().eval(&[]), 4.0);
        assert!(Expr::Number(f64::NAN).compile(&[]).unwrap_err().contains("is NaN; must be a finite number"));
    }

    #[test]
    fn faults_say_what_is_wanted() {
        let cases = [
            ("", "a number, a name or ( is wanted at the end"),
            ("sin(x", ") is wanted at the end"),
            ("2 x", "an operator is wanted at character 3, where there is x"),
            ("2e", "an operator is wanted at character 2"),
            ("x + * y", "wanted at character 5, where there is *"),
            ("q", "unknown variable `q`; allowed: x, y, z, t, PI, E, TAU"),
            ("sine(x)", "unknown function `sine`; did you mean `sin`?"),
            ("atan2(x)", ", is wanted"),
            ("1e400", "1e400 is too large for a number"),
            ("1/0", "is inf; must be a finite number"),
            ("x % 2", "an operator is wanted at character 3"),
            (".", "a number is wanted at character 1"),
            ("nan", "unknown variable `nan`"),
            ("x)", "an operator is wanted at character 2"),
        ];
        for (text, message) in cases {
            assert!(fault(text).contains(message), "{text}: {}", fault(text));
        }
        assert!(fault(&"(".repeat(500)).contains("nested deeper than 64"));
        assert!(fault(&"-".repeat(500)).contains("nested deeper than 64"));
        assert!(fault(&"x+".repeat(3000)).contains("more than 5000 characters"));
        let long = Formula::parse(&vec!["sin(x*y)"; 111].join("*"), &XT).unwrap();
        assert!(long.derivative(0).and_then(|f| f.derivative(0)).unwrap_err().contains("more than 100000"));
    }
}
