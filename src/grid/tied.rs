//! Nodes that follow others. At the edge of a body they are those of extended B-splines (`step/extend.rs`). And a serendipity element is a
//! Lagrange element whose inner nodes take the blend of its other nodes that its shape functions imply. What particles give to a tied node is
//! handed on to its masters, and it moves as they do.

use super::{Grid, Lanes};
use crate::basis::{is_tied, serendipity_weight};
use crate::model::Model;

#[derive(Debug, Clone, Default)]
pub(crate) struct Tied {
    /// Tied node, and where its masters end in the list; they begin where those of the node before end.
    nodes: Vec<(u32, u32)>,
    masters: Vec<(u32, f64)>,
}

impl Tied {
    pub(crate) fn is_empty(&self) -> bool {
        self.nodes.is_empty()
    }

    /// No node follows another.
    pub(crate) fn clear(&mut self) {
        self.nodes.clear();
        self.masters.clear();
    }

    /// Tied nodes with their masters.
    pub(crate) fn iter(&self) -> impl Iterator<Item = (usize, &[(u32, f64)])> {
        self.nodes.iter().enumerate().map(|(place, &(node, _))| (node as usize, self.masters(place)))
    }

    /// Masters of the tied node at this place of the list.
    pub(crate) fn masters(&self, place: usize) -> &[(u32, f64)] {
        let start = if place == 0 { 0 } else { self.nodes[place - 1].1 };
        &self.masters[start as usize..self.nodes[place].1 as usize]
    }

    /// Makes a node follow others.
    pub(crate) fn push(&mut self, node: usize, masters: impl Iterator<Item = (usize, f64)>) {
        self.masters.extend(masters.map(|(master, weight)| (master as u32, weight)));
        self.nodes.push((node as u32, self.masters.len() as u32));
    }

    /// Hands on to their masters what tied nodes were given.
    pub(crate) fn fold(&self, lanes: &mut [Lanes]) {
        for (node, masters) in self.iter() {
            let given = std::mem::take(&mut lanes[node]);
            for &(master, weight) in masters {
                for lane in 0..4 {
                    lanes[master as usize][lane] += weight * given[lane];
                }
            }
        }
    }

    /// Gives tied nodes what their masters have, in all lanes but the first.
    pub(crate) fn spread(&self, lanes: &mut [Lanes]) {
        for (node, masters) in self.iter() {
            for lane in 1..4 {
                lanes[node][lane] = masters.iter().map(|&(master, weight)| weight * lanes[master as usize][lane]).sum();
            }
        }
    }
}

impl Grid {
    /// Lists the tied nodes of the active blocks.
    pub(super) fn tie(&mut self, model: &Model) {
        let mut tied = std::mem::take(&mut self.tied);
        tied.clear();
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
        self.tied.fold(&mut self.momentum);
        if forces_too {
            self.tied.fold(&mut self.force);
        }
    }

    /// Moves tied nodes as their masters do: velocities, and accelerations where they are wanted.
    pub(crate) fn spread_tied(&mut self, forces_too: bool) {
        self.tied.spread(&mut self.momentum);
        if forces_too {
            self.tied.spread(&mut self.force);
        }
    }
}
