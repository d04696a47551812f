//! Functions of a grid whose cells are cut by the body that follow others: extended B-splines (see [`Extension`]).
//!
//! Fields keep a value for each function. Those that follow take theirs from the ones that they follow ([`Ties::spread`]), and hand on to them
//! the forces that they get ([`Ties::fold`]): with E the matrix of the weights, fields are E x, forces E^T f, and matrices E^T M E.

use super::reference::Reference;
use crate::basis::Extension;
use crate::implicit::Matrix;
use std::collections::{BTreeMap, BTreeSet};

/// A function is stable where it has a cell in its support of which at least this much is in the body. Where no such cells are near, those
/// with half as much must do, down to the last of these.
///
/// Measured on a rectangle at 50 places and 50 angles (`slivers.rs`, `tests/cut_cells.rs`): from 0.25 over 0.35 to 0.5 the worst stable step at
/// degree 3 grows from 2.1 over 2.6 to 3.1 ms, the worst over the best condition of its mass goes from 11 over 5 to 8, and the worst over
/// the best error at degree 2 from 1.6 over 1.8 to 2.4: who follows is further from whom it follows.
const SHARES: [f64; 5] = [0.35, 0.175, 0.0875, 0.04375, 0.021875];
/// How far a point may stray from its cell by round-off, in cells.
const ROUND_OFF: f64 = 1e-9;

/// What becomes of a function.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Role {
    /// It stands for itself.
    Own,
    /// It follows others: place in the list.
    Follows(u32),
    /// It takes no part.
    Out,
}

/// Which functions of a grid follow which.
#[derive(Debug)]
pub(super) struct Ties {
    roles: Vec<Role>,
    /// A function, and those that it follows with their weights.
    follow: Vec<(u32, Vec<(u32, f64)>)>,
    /// First functions of the cells in which the body or its edge is.
    cells: Vec<[usize; 3]>,
    /// Functions with support in the body that found none to follow.
    alone: usize,
    in_space: bool,
}

impl Ties {
    /// `volumes` are those of the particles \[m2, m3\], `edge` the points of the edge or surface \[m\]. Where `extends` is false all functions
    /// stand for themselves.
    pub(super) fn new(reference: &Reference, volumes: &[f64], edge: impl Iterator<Item = [f64; 3]>, extends: bool) -> Self {
        let axes = &reference.axes;
        let whole: f64 = axes.iter().map(crate::basis::Axis::cell_size).product();
        let mut shares = BTreeMap::<[usize; 3], f64>::new();
        for (p, volume) in volumes.iter().enumerate() {
            *shares.entry(reference.particle(p).cell()).or_default() += volume / whole;
        }
        for point in edge {
            // all sides that it may be on
            for sides in 0..1 << axes.len() {
                let side = |a: usize| if sides >> a & 1 == 1 { ROUND_OFF } else { -ROUND_OFF };
                let mut place = point;
                (0..axes.len()).for_each(|a| place[a] += side(a) * axes[a].cell_size());
                shares.entry(reference.point(place).cell()).or_default();
            }
        }
        let cells: Vec<[usize; 3]> = shares.keys().copied().collect();
        let functions = |cell: [usize; 3]| reference.functions(cell);
        let mut best = BTreeMap::<usize, f64>::new();
        for (cell, share) in &shares {
            for node in functions(*cell) {
                let most = best.entry(node).or_default();
                *most = most.max(*share);
            }
        }
        let mut roles = vec![Role::Out; reference.len()];
        let mut follow = Vec::new();
        if extends {
            // a cell more all around: points on the edge, and those that are watched near it, may fall there
            let widths = reference.widths();
            let near = |cell: [usize; 3], a: usize| if widths[a] > 1 { cell[a].saturating_sub(1)..=cell[a] + 1 } else { cell[a]..=cell[a] };
            let beside =
                |cell: [usize; 3]| near(cell, 0).flat_map(move |i| near(cell, 1).flat_map(move |j| near(cell, 2).map(move |k| [i, j, k])));
            let inside = |cell: &[usize; 3]| (0..3).all(|a| cell[a] + widths[a] <= reference.counts[a]);
            let all: BTreeSet<[usize; 3]> = cells.iter().flat_map(|cell| beside(*cell)).filter(inside).collect();
            let mut open: BTreeSet<usize> = all.into_iter().flat_map(functions).collect();
            let extension = Extension::new(axes);
            for share in SHARES {
                open.retain(|&node| {
                    let stable = best.get(&node).is_some_and(|best| *best >= share);
                    if stable {
                        roles[node] = Role::Own;
                    }
                    !stable
                });
                let counts = reference.counts;
                let number = |[i, j, k]: [i32; 3]| (i as usize * counts[1] + j as usize) * counts[2] + k as usize;
                let is_stable =
                    |node: [i32; 3]| (0..3).all(|a| (0..counts[a] as i32).contains(&node[a])) && roles[number(node)] == Role::Own;
                let found: Vec<_> = open.iter().filter_map(|&node| Some((node, extension.of(reference.index(node), is_stable)?))).collect();
                for (node, masters) in found {
                    open.remove(&node);
                    roles[node] = Role::Follows(follow.len() as u32);
                    follow.push((node as u32, masters.into_iter().map(|(master, weight)| (number(master) as u32, weight)).collect()));
                }
            }
        }
        let mut alone = 0;
        for (&node, &share) in &best {
            if share > 0.0 && roles[node] == Role::Out {
                roles[node] = Role::Own;
                alone += 1;
            }
        }
        Self { roles, follow, cells, alone: if extends { alone } else { 0 }, in_space: axes.len() == 3 }
    }

    /// Functions with support in the body that found none to follow.
    pub(super) fn alone(&self) -> usize {
        self.alone
    }

    /// In words.
    pub(super) fn describe(&self) -> String {
        let own = self.roles.iter().filter(|role| **role == Role::Own).count();
        let edge = if self.in_space { "surface" } else { "edge" };
        let mut text = format!("cells of the scene, cut by its {edge}: {own} functions");
        if !self.follow.is_empty() {
            text += &format!(", {} more follow them (extended B-splines)", self.follow.len());
        }
        if self.alone > 0 {
            text += &format!("; {} of them have little of the body and nothing to follow near", self.alone);
        }
        text
    }

    pub(super) fn cells(&self) -> &[[usize; 3]] {
        &self.cells
    }

    /// Whether a function stands for itself.
    pub(super) fn is_own(&self, node: usize) -> bool {
        self.roles[node] == Role::Own
    }

    /// Functions that follow others hand on what they got.
    pub(super) fn fold<const N: usize>(&self, field: &mut [[f64; N]]) {
        for (node, masters) in &self.follow {
            let got = std::mem::replace(&mut field[*node as usize], [0.0; N]);
            for (master, weight) in masters {
                (0..N).for_each(|a| field[*master as usize][a] += weight * got[a]);
            }
        }
        for (value, role) in field.iter_mut().zip(&self.roles) {
            if *role == Role::Out {
                *value = [0.0; N];
            }
        }
    }

    /// Functions that follow others get their values.
    pub(super) fn spread<const N: usize>(&self, field: &mut [[f64; N]]) {
        for (node, masters) in &self.follow {
            let mut value = [0.0; N];
            for (master, weight) in masters {
                (0..N).for_each(|a| value[a] += weight * field[*master as usize][a]);
            }
            field[*node as usize] = value;
        }
    }

    /// The functions that these, all of a cell, come to: ascending.
    pub(super) fn ends(&self, nodes: impl Iterator<Item = u32>) -> Vec<u32> {
        let mut ends = Vec::new();
        for node in nodes {
            match self.roles[node as usize] {
                Role::Own => ends.push(node),
                Role::Follows(place) => ends.extend(self.follow[place as usize].1.iter().map(|(master, _)| *master)),
                Role::Out => {}
            }
        }
        ends.sort_unstable();
        ends.dedup();
        ends
    }

    /// Adds a dense block over `d` components of functions of a cell, which are numbered from `start` on, to a matrix.
    pub(super) fn add(&self, matrix: &mut Matrix, nodes: &[u32], start: u32, d: usize, block: &[f64]) {
        if nodes.iter().all(|node| self.roles[(node - start) as usize] == Role::Own) {
            return matrix.add(nodes, block);
        }
        let ends = self.ends(nodes.iter().map(|node| node - start));
        let place = |node: u32| ends.partition_point(|end| *end < node);
        let shares: Vec<Vec<(usize, f64)>> = nodes
            .iter()
            .map(|node| match self.roles[(node - start) as usize] {
                Role::Own => vec![(place(node - start), 1.0)],
                Role::Follows(at) => self.follow[at as usize].1.iter().map(|(master, weight)| (place(*master), *weight)).collect(),
                Role::Out => Vec::new(),
            })
            .collect();
        let (rows, size) = (nodes.len() * d, ends.len() * d);
        let mut folded = vec![0.0; size * size];
        let mut column = vec![0.0; size];
        for (b, to) in shares.iter().enumerate() {
            for k in 0..d {
                column.fill(0.0);
                let from = &block[(b * d + k) * rows..][..rows];
                for (a, shares) in shares.iter().enumerate() {
                    for (end, weight) in shares {
                        (0..d).for_each(|i| column[end * d + i] += weight * from[a * d + i]);
                    }
                }
                for (end, weight) in to {
                    let to = &mut folded[(end * d + k) * size..][..size];
                    to.iter_mut().zip(&column).for_each(|(to, from)| *to += weight * from);
                }
            }
        }
        let ends: Vec<u32> = ends.iter().map(|end| end + start).collect();
        matrix.add(&ends, &folded);
    }
}
