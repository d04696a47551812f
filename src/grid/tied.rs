//! Nodes that follow others: a serendipity element is a Lagrange element whose inner nodes take the blend of its other nodes that its shape
//! functions imply. What particles give to a tied node is handed on to its masters, and it moves as they do.

use super::{Grid, Lanes};
use crate::basis::{is_tied, serendipity_weight};
use crate::model::Model;

#[derive(Debug, Clone, Default)]
pub(super) struct Tied {
    /// Tied node, and where its masters end in the list; they begin where those of the node before end.
    nodes: Vec<(u32, u32)>,
    masters: Vec<(u32, f64)>,
}

impl Tied {
    fn for_each(&self, mut f: impl FnMut(usize, &[(u32, f64)])) {
        let mut start = 0;
        for &(node, end) in &self.nodes {
            f(node as usize, &self.masters[start..end as usize]);
            start = end as usize;
        }
    }
}

impl Grid {
    /// Lists the tied nodes of the active blocks.
    pub(super) fn tie(&mut self, model: &Model) {
        let mut tied = std::mem::take(&mut self.tied);
        tied.nodes.clear();
        tied.masters.clear();
        for index in 0..if model.needs.tied { self.momentum.len() } else { 0 } {
            let (field, node) = self.place(index);
            if !is_tied(model.dimension, node) {
                continue;
            }
            let start = tied.masters.len();
            let beside = |k: usize| [0, 1, 2].map(|s| node[s] + [k / 9, k / 3 % 3, k % 3][s] as i32 - 1);
            // slots that are not used have no neighbours
            let around = (0..27).map(beside).filter(|master| master[..3 - model.dimension] == node[..3 - model.dimension]);
            let masters = around.map(|master| (master, serendipity_weight(model.dimension, node, master))).filter(|(_, w)| *w != 0.0);
            let mut complete = true;
            for (master, weight) in masters {
                match self.node(field, master) {
                    Some(master) => tied.masters.push((master as u32, weight)),
                    None => complete = false,
                }
            }
            // particles touch all nodes of their element: one with nodes in no active block has no particle
            if complete {
                tied.nodes.push((index as u32, tied.masters.len() as u32));
            } else {
                tied.masters.truncate(start);
            }
        }
        self.tied = tied;
    }

    /// Hands on to their masters what tied nodes were given.
    pub(crate) fn fold_tied(&mut self, forces_too: bool) {
        let Self { tied, momentum, force, .. } = self;
        let fold = |lanes: &mut [Lanes]| {
            tied.for_each(|node, masters| {
                let given = std::mem::take(&mut lanes[node]);
                for &(master, weight) in masters {
                    for lane in 0..4 {
                        lanes[master as usize][lane] += weight * given[lane];
                    }
                }
            });
        };
        fold(momentum);
        if forces_too {
            fold(force);
        }
    }

    /// Moves tied nodes as their masters do: velocities, and accelerations where they are wanted.
    pub(crate) fn spread_tied(&mut self, forces_too: bool) {
        let Self { tied, momentum, force, .. } = self;
        let spread = |lanes: &mut [Lanes]| {
            tied.for_each(|node, masters| {
                for lane in 1..4 {
                    lanes[node][lane] = masters.iter().map(|&(master, weight)| weight * lanes[master as usize][lane]).sum();
                }
            });
        };
        spread(momentum);
        if forces_too {
            spread(force);
        }
    }
}
