//! Which functions at the edge of a body follow others, so that neither the stable step nor the condition of the mass matrix depends on how
//! its edge cuts the cells (extended B-splines, [`Extension`]).

use super::Stepper;
use super::integrate::Integration;
use crate::basis::Extension;
use crate::model::Model;

/// Share of a cell from which on its functions are well supported.
///
/// A square that slides through a cell, degree 2: with 0.5 the stable step falls from 0.32 to 0.21 h / c at worst (the tests of
/// `step/limit.rs` print it).
const SUPPORTED: f64 = 0.5;

/// How much of the body a node has in its support.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Support {
    Nothing,
    /// Parts of cells.
    Little,
    /// A cell that is mostly full.
    Much,
}

/// Nodes by their support, and what looks for nodes to follow.
#[derive(Debug, Default)]
pub(super) struct Extender {
    extension: Option<Extension>,
    /// By node as stored.
    support: Vec<Support>,
    /// Nodes with little support and none to follow.
    pub(super) ragged: Vec<usize>,
}

impl Stepper {
    /// Ties the nodes with little of the body in their support.
    pub(super) fn extend(&mut self, model: &Model, all: &mut Integration) {
        let Integration { extender, rows, bodies, .. } = all;
        let extension = extender.extension.get_or_insert_with(|| Extension::new(&model.axes));
        let support = &mut extender.support;
        support.clear();
        support.resize(self.grid.momentum.len(), Support::Nothing);
        // bodies with one velocity field may share a cell
        let mut shares: std::collections::HashMap<(u16, [i32; 2]), (f64, usize)> = std::collections::HashMap::new();
        let mut first = 0;
        for (b, body) in bodies.iter().enumerate() {
            for cell in body.cells() {
                let known = shares.entry((model.field(b as u16), cell.index)).or_insert((0.0, first + cell.points.start));
                known.0 += cell.share;
            }
            first += body.points().len();
        }
        for (share, point) in shares.values() {
            let found = if *share >= SUPPORTED { Support::Much } else { Support::Little };
            for (node, _) in rows.row(*point) {
                if support[node] != Support::Much {
                    support[node] = found;
                }
            }
        }
        let d = model.dimension;
        let mut tied = std::mem::take(&mut self.grid.tied);
        tied.clear();
        extender.ragged.clear();
        for node in (0..support.len()).filter(|node| support[*node] == Support::Little) {
            let (field, place) = self.grid.place(node);
            // from slots to axes, and back
            let stored = |at: [i32; 3]| {
                let mut slots = [0; 3];
                slots[3 - d..].copy_from_slice(&at[..d]);
                self.grid.node(field, slots)
            };
            let mut own = [0; 3];
            own[..d].copy_from_slice(&place[3 - d..]);
            match extension.of(own, |at| stored(at).is_some_and(|node| support[node] == Support::Much)) {
                Some(masters) => tied.push(node, masters.iter().filter_map(|(at, weight)| Some((stored(*at)?, *weight)))),
                None => extender.ragged.push(node),
            }
        }
        self.grid.tied = tied;
    }
}
