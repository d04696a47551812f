//! Faces of bodies that cut cells, held where they are by Nitsche's method: no function is alone at such a face, so that none can be held.
//!
//! To the stored energy comes, over the held face and for the held components of u - g,
//!
//! ```text
//! - int (P N) . (u - g) dA + 1/2 beta int |u - g|^2 dA
//! ```
//!
//! with the prescribed displacement g (Nitsche 1971; for large strain and its consistent derivatives for example Mlika, Renard and Chouly 2017,
//! An unbiased Nitsche's formulation of large deformation frictional contact and self-contact, section 2). A solution of the problem makes its
//! derivative vanish whatever beta is, which keeps the order of the functions; and as it is an energy, symplectic steps keep the sum. Nothing
//! can drift: forces know the place, not the velocity. beta must be above the constant of the inverse estimate |P N|^2_face <= C |grad u|^2,
//! which extended B-splines have independent of how cells are cut (Embar, Dolbow and Harari 2010; Rueberg and Cirak 2012).

use super::Total;
use super::reference::{Point, Reference, Vectors};
use crate::component::StepError;
use crate::implicit::Matrix;
use crate::material::point::{Plane, Start, Tangent, Trouble, identity};
use crate::model::{Boundary, Cut, CutPoint, Model};
use crate::quadrature::gauss_legendre;
use crate::state::State;

/// beta over the modulus of compression over the cell, for each function along an axis squared. Measured for degree 1 to 3 on a rectangle at 50
/// places and 50 angles (`slivers.rs`): the stiffness at rest is positive from 0.43 of it on. More of it takes from the stable step with its
/// square root; this one takes up to two thirds of it. With half as much the condition of the stiffness varies 38 times instead of 8.
const PENALTY: f64 = 4.0;
/// Panels in which prescribed velocities are summed up.
const PANELS: usize = 1024;
/// Gauss points in a panel.
const IN_PANEL: usize = 5;

/// Integral of a prescribed velocity. It is the same whichever times it was asked for before.
#[derive(Debug)]
struct Travel {
    axis: usize,
    /// Length of a panel \[s\].
    panel: f64,
    /// At the start of each panel \[m\].
    sums: Vec<f64>,
}

impl Travel {
    fn new(boundary: &Boundary, axis: usize, end: f64) -> Self {
        let mut travel = Self { axis, panel: end / PANELS as f64, sums: vec![0.0] };
        for k in 0..PANELS {
            let sum = travel.sums[k] + travel.part(boundary, k, travel.panel);
            travel.sums.push(sum);
        }
        travel
    }

    /// From the start of a panel, for a time.
    fn part(&self, boundary: &Boundary, panel: usize, time: f64) -> f64 {
        let velocity = |share: f64| boundary.velocity(self.axis, self.panel * panel as f64 + share * time).unwrap_or(0.0);
        gauss_legendre(IN_PANEL).iter().map(|(share, weight)| weight * time * velocity(*share)).sum()
    }

    /// Displacement at a time \[m\].
    fn at(&self, boundary: &Boundary, time: f64) -> f64 {
        let number = (time / self.panel).floor().max(0.0) as usize;
        let last = number.min(PANELS);
        let beyond: f64 = (last..number).map(|panel| self.part(boundary, panel, self.panel)).sum();
        self.sums[last] + beyond + self.part(boundary, number, time - self.panel * number as f64)
    }
}

/// A piece of a held face.
#[derive(Debug)]
struct Piece {
    at: Point,
    /// Outward at time 0.
    normal: [f64; 3],
    /// \[m2\], in a plane \[m\].
    area: f64,
    position: [f64; 3],
}

/// A held face.
#[derive(Debug)]
pub(super) struct Surface {
    pub(super) boundary: usize,
    pub(super) body: usize,
    travels: Vec<Travel>,
    /// \[Pa/m\]
    pub(super) penalty: f64,
    pieces: Vec<Piece>,
}

/// What a piece answers to its displacement.
struct Answer<const D: usize> {
    /// Force of the boundary on the body \[Pa\].
    traction: [f64; D],
    /// What slopes of functions get \[Pa m\].
    back: Plane<D>,
    moduli: Tangent<D>,
}

impl Surface {
    pub(super) fn new(model: &Model, boundary: usize, body: usize, cut: &Cut, face: &str, reference: &Reference) -> Self {
        let held = &model.boundaries[boundary];
        let piece = |point: &CutPoint| {
            let area = point.area.iter().map(|a| a * a).sum::<f64>().sqrt();
            Piece { at: reference.point(point.position), normal: point.area.map(|a| a / area), area, position: point.position }
        };
        let axes = &reference.axes;
        let functions = axes[0].width() as f64;
        let modulus = model.bodies[body].material.lame().wave_modulus();
        Self {
            boundary,
            body,
            travels: (0..model.dimension).filter(|&axis| held.holds_axis(axis)).map(|axis| Travel::new(held, axis, model.end)).collect(),
            penalty: PENALTY * functions * functions * modulus / crate::basis::Axis::smallest_cell(axes),
            pieces: cut.face(face).map(piece).collect(),
        }
    }

    pub(super) fn holds_axis(&self, axis: usize) -> bool {
        self.travels.iter().any(|travel| travel.axis == axis)
    }

    /// Prescribed displacement of the held components \[m\].
    pub(super) fn travel(&self, model: &Model, time: f64) -> [f64; 3] {
        let mut at = [0.0; 3];
        self.travels.iter().for_each(|travel| at[travel.axis] = travel.at(&model.boundaries[self.boundary], time));
        at
    }

    fn answer<const D: usize>(
        &self,
        piece: &Piece,
        model: &Model,
        goal: &[f64; 3],
        reference: &Reference,
        displacement: &[[f64; 3]],
    ) -> Result<Answer<D>, Trouble> {
        let material = &model.bodies[self.body].material;
        let (mut new, mut place) = (identity::<D>(), [0.0; D]);
        reference.each_slowly(&piece.at, |node, weight, slope| {
            for i in 0..D {
                place[i] += weight * displacement[node][i];
                (0..D).for_each(|k| new[i][k] += displacement[node][i] * slope[k]);
            }
        });
        let start = Start { deformation: identity(), history: Default::default(), lateral: 1.0 };
        let answer = material.answer(model.embedding, &start, &new)?;
        let moduli = material.tangent(model.embedding, &start, &new, &answer)?;
        let (mut traction, mut back) = ([0.0; D], [[0.0; D]; D]);
        for i in self.travels.iter().map(|travel| travel.axis) {
            let miss = place[i] - goal[i];
            traction[i] = (0..D).map(|j| answer.stress[i][j] * piece.normal[j]).sum::<f64>() - self.penalty * miss;
            for j in 0..D {
                for k in 0..D {
                    (0..D).for_each(|l| back[k][l] += miss * piece.normal[j] * moduli[i][j][k][l]);
                }
            }
        }
        Ok(Answer { traction, back, moduli })
    }

    /// Adds the forces on the nodes at a time and displacement; their sum is that of the boundary on the body \[N\].
    fn pull<const D: usize>(
        &self,
        model: &Model,
        reference: &Reference,
        time: f64,
        displacement: &[[f64; 3]],
        force: &mut Vectors,
    ) -> Result<[f64; 3], (usize, Trouble)> {
        let goal = self.travel(model, time);
        let mut sum = [0.0; 3];
        for (number, piece) in self.pieces.iter().enumerate() {
            let answer = self.answer::<D>(piece, model, &goal, reference, displacement).map_err(|why| (number, why))?;
            (0..D).for_each(|i| sum[i] += piece.area * answer.traction[i]);
            reference.each_slowly(&piece.at, |node, weight, slope| {
                for i in 0..D {
                    let turned: f64 = (0..D).map(|k| answer.back[i][k] * slope[k]).sum();
                    force[node][i] += piece.area * (weight * answer.traction[i] + turned);
                }
            });
        }
        Ok(sum)
    }

    /// Adds this share of minus the derivative of the forces by the displacement \[N/m\], but for the change of the moduli: that is times
    /// u - g, which is next to nothing when Newton's method is near its end.
    fn add_stiffness<const D: usize>(
        &self,
        model: &Model,
        reference: &Reference,
        time: f64,
        displacement: &[[f64; 3]],
        share: f64,
        matrix: &mut Matrix,
    ) -> Result<(), (usize, Trouble)> {
        let goal = self.travel(model, time);
        let held: [f64; D] = std::array::from_fn(|axis| if self.holds_axis(axis) { 1.0 } else { 0.0 });
        let mut functions: Vec<(f64, Plane<D>)> = Vec::new();
        // pieces of the same cell share their nodes: their shares are summed in a dense block first
        let (mut nodes, mut block) = (Vec::new(), Vec::new());
        let mut cell = None;
        for (number, piece) in self.pieces.iter().enumerate() {
            let Answer { moduli, .. } = self.answer::<D>(piece, model, &goal, reference, displacement).map_err(|why| (number, why))?;
            if cell != Some(piece.at.cell()) {
                if cell.is_some() {
                    reference.add(matrix, &nodes, D, &block);
                }
                cell = Some(piece.at.cell());
                nodes.clear();
                reference.each_slowly(&piece.at, |node, _, _| nodes.push(node as u32));
                block.clear();
                block.resize((D * nodes.len()).pow(2), 0.0);
            }
            functions.clear();
            reference.each_slowly(&piece.at, |_, weight, slope| {
                // traction on a held component by a displacement of the function
                let along = |i: usize, j: usize, k: usize| (0..D).map(|l| moduli[i][j][k][l] * slope[l]).sum::<f64>();
                let traction = |i: usize, k: usize| held[i] * (0..D).map(|j| piece.normal[j] * along(i, j, k)).sum::<f64>();
                functions.push((weight, std::array::from_fn(|i| std::array::from_fn(|k| traction(i, k)))));
            });
            let rows = D * nodes.len();
            let factor = share * piece.area;
            for (b, (weight_b, traction_b)) in functions.iter().enumerate() {
                for k in 0..D {
                    let column = &mut block[(D * b + k) * rows..][..rows];
                    for (a, (weight_a, traction_a)) in functions.iter().enumerate() {
                        for i in 0..D {
                            let spring = if i == k { self.penalty * held[i] * weight_a * weight_b } else { 0.0 };
                            column[D * a + i] += factor * (spring - weight_a * traction_b[i][k] - weight_b * traction_a[k][i]);
                        }
                    }
                }
            }
        }
        if cell.is_some() {
            reference.add(matrix, &nodes, D, &block);
        }
        Ok(())
    }
}

impl Total {
    /// Adds the forces of held faces; returns those of each boundary on the bodies \[N\].
    pub(super) fn pull(
        &self,
        model: &Model,
        state: &State,
        time: f64,
        displacement: &[[f64; 3]],
        force: &mut Vectors,
    ) -> Result<Vec<[f64; 3]>, StepError> {
        let mut pulls = vec![[0.0; 3]; model.boundaries.len()];
        for surface in &self.surfaces {
            let reference = &self.bodies[surface.body].reference;
            let pull = if model.dimension == 3 { Surface::pull::<3> } else { Surface::pull::<2> };
            let own = pull(surface, model, reference, time, displacement, force);
            let own = own.map_err(|(piece, why)| self.explain_piece(model, state, time, surface, piece, why))?;
            (0..3).for_each(|a| pulls[surface.boundary][a] += own[a]);
        }
        Ok(pulls)
    }

    /// Adds this share of minus the derivative of [`Self::pull`].
    pub(super) fn pull_stiffness(
        &self,
        model: &Model,
        state: &State,
        time: f64,
        displacement: &[[f64; 3]],
        share: f64,
        matrix: &mut Matrix,
    ) -> Result<(), StepError> {
        for surface in &self.surfaces {
            let add = if model.dimension == 3 { Surface::add_stiffness::<3> } else { Surface::add_stiffness::<2> };
            let added = add(surface, model, &self.bodies[surface.body].reference, time, displacement, share, matrix);
            added.map_err(|(piece, why)| self.explain_piece(model, state, time, surface, piece, why))?;
        }
        Ok(())
    }

    /// Adds up what held faces do from one time to another: impulse of some forces, work of others \[N\].
    pub(super) fn reap(&mut self, model: &Model, state: &mut State, [pushing, working]: [&[[f64; 3]]; 2], [from, to]: [f64; 2]) {
        for (b, pull) in pushing.iter().enumerate() {
            (0..3).for_each(|a| self.impulse[b][a] += (to - from) * pull[a]);
        }
        // all faces of a boundary go where it goes
        let mut seen = vec![false; working.len()];
        for surface in &self.surfaces {
            if !std::mem::replace(&mut seen[surface.boundary], true) {
                let [start, end] = [from, to].map(|time| surface.travel(model, time));
                state.external_work += (0..3).map(|a| working[surface.boundary][a] * (end[a] - start[a])).sum::<f64>();
            }
        }
    }

    /// What goes wrong at a face goes wrong at the particle next to it.
    fn explain_piece(&self, model: &Model, state: &State, time: f64, surface: &Surface, piece: usize, why: Trouble) -> StepError {
        let at = surface.pieces[piece].position;
        let far = |p: usize| {
            let place: [f64; 3] = model.reference(p as u32);
            (0..3).map(|a| (place[a] - at[a]).powi(2)).sum::<f64>()
        };
        let particle = model.bodies[surface.body].particles.clone().min_by(|p, q| far(*p).total_cmp(&far(*q))).unwrap_or_default();
        self.explain(model, state, time, &super::Trouble { particle, why })
    }
}
