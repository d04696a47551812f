//! A field of the nodes.

use super::Lanes;
use crate::lines::Lines;
use std::ops::{Deref, DerefMut};

/// Numbers of nodes, two nodes to a line of the cache. There is an even number of them.
#[derive(Debug, Clone, Default)]
pub(crate) struct Nodes(Lines);

impl Nodes {
    /// The same for so many nodes; new ones are zero.
    pub(crate) fn resize(&mut self, nodes: usize) {
        self.0.resize(nodes * size_of::<Lanes>() / size_of::<f64>());
    }
}

impl Deref for Nodes {
    type Target = [Lanes];
    #[inline(always)]
    fn deref(&self) -> &[Lanes] {
        self.0.numbers().as_chunks().0
    }
}

impl DerefMut for Nodes {
    #[inline(always)]
    fn deref_mut(&mut self) -> &mut [Lanes] {
        self.0.numbers_mut().as_chunks_mut().0
    }
}

impl<'a> IntoIterator for &'a Nodes {
    type Item = &'a Lanes;
    type IntoIter = std::slice::Iter<'a, Lanes>;
    fn into_iter(self) -> Self::IntoIter {
        self.iter()
    }
}

impl<'a> IntoIterator for &'a mut Nodes {
    type Item = &'a mut Lanes;
    type IntoIter = std::slice::IterMut<'a, Lanes>;
    fn into_iter(self) -> Self::IntoIter {
        self.iter_mut()
    }
}
