//! Sums over the particles of a body: deformation, stress, internal forces, and for implicit steps the stiffness.

use super::dilatation;
use super::reference::{Point, Reference};
use crate::implicit::Matrix;
use crate::material::point::{self, Answer, Plane, Start, Tangent, Trouble as Why};
use crate::material::{Embedding, Material};
use crate::state::Particles;

/// A body and how its nodes have moved.
pub(crate) struct Task<'a> {
    pub(crate) reference: &'a Reference,
    pub(crate) material: &'a Material,
    pub(crate) embedding: Embedding,
    /// Its particles in memory.
    pub(crate) first: usize,
    pub(crate) last: usize,
    /// Particle in memory whose functions are the first of the reference.
    pub(crate) offset: usize,
    /// Displacement of the nodes \[m\]: since time 0, or since the start of the step.
    pub(crate) displacement: &'a [[f64; 3]],
    /// Whether the functions are those of the configuration at the start of the step.
    pub(crate) updated: bool,
    /// Whether the stress is the one that makes the work of a step the change of the stored energy.
    pub(crate) conserving: bool,
}

/// Why a particle cannot be gone on with.
pub(crate) struct Trouble {
    pub(crate) particle: usize,
    pub(crate) why: Why,
}

/// A vector for each node.
type Nodal = [[f64; 3]];
type Summed = Result<(), Trouble>;

/// The sums for a dimension and a width.
#[derive(Clone, Copy)]
pub(crate) struct Sweeps {
    /// Adds the internal forces f_i = -sum_p V_p P_p grad N_i \[N\], and carries deformation and history of the particles along.
    pub(crate) advance: fn(&Task<'_>, &mut Particles, &mut Nodal) -> Summed,
    /// Adds the internal forces \[N\].
    pub(crate) force: fn(&Task<'_>, &Particles, &mut Nodal) -> Summed,
    /// Adds this much of minus the derivative of the internal forces by the displacement \[N/m\].
    pub(crate) stiffness: fn(&Task<'_>, &Particles, f64, &mut Matrix) -> Summed,
    /// The same without a matrix; not where particles of a cell depend on each other.
    pub(crate) linear: Option<Linear>,
}

/// The stiffness as a sum over the particles.
#[derive(Clone, Copy)]
pub(crate) struct Linear {
    /// Appends the moduli of the particles, times their volumes \[J\].
    pub(crate) moduli: fn(&Task<'_>, &Particles, &mut Vec<f64>) -> Summed,
    /// Adds the stiffness of these moduli times a nodal field \[N\].
    pub(crate) times: fn(&Task<'_>, &[f64], &Nodal, &mut Nodal),
}

/// `mean`: with the mean volume ratio of cells.
pub(crate) fn sweeps(dimension: usize, width: usize, mean: bool) -> Sweeps {
    fn of<const D: usize, const W: usize>() -> [Sweeps; 2] {
        [
            Sweeps {
                advance: advance::<D, W>,
                force: force::<D, W>,
                stiffness: stiffness::<D, W>,
                linear: Some(Linear { moduli: moduli::<D, W>, times: stiffness_times::<D, W> }),
            },
            dilatation::sweeps::<D, W>(),
        ]
    }
    let both = match (dimension, width) {
        (1, 2) => of::<1, 2>(),
        (1, 3) => of::<1, 3>(),
        (1, 4) => of::<1, 4>(),
        (1, 5) => of::<1, 5>(),
        (1, _) => of::<1, 6>(),
        (2, 2) => of::<2, 2>(),
        (2, 3) => of::<2, 3>(),
        (2, 4) => of::<2, 4>(),
        (2, 5) => of::<2, 5>(),
        (2, _) => of::<2, 6>(),
        (_, 2) => of::<3, 2>(),
        (_, 3) => of::<3, 3>(),
        (_, 4) => of::<3, 4>(),
        (_, 5) => of::<3, 5>(),
        (_, _) => of::<3, 6>(),
    };
    both[usize::from(mean)]
}

impl Task<'_> {
    /// What particle `p` comes from, and its deformation gradient.
    #[inline(always)]
    pub(super) fn deform<const D: usize, const W: usize>(&self, particles: &Particles, p: usize, at: &Point) -> (Start<D>, Plane<D>) {
        let mut gradient = [[0.0; D]; D];
        self.reference.each::<D, W>(at, |node, _, slope| {
            for i in 0..D {
                for k in 0..D {
                    gradient[i][k] += self.displacement[node][i] * slope[k];
                }
            }
        });
        let start = Start {
            deformation: rows(particles, p),
            history: particles.history.row(p),
            lateral: if self.embedding.stress_free { particles.lateral.column(0)[p] } else { 1.0 },
        };
        let moved = point::combine(1.0, &point::identity(), 1.0, &gradient);
        let new = if self.updated { times(&moved, &start.deformation) } else { moved };
        (start, new)
    }

    fn stress<const D: usize>(&self, start: &Start<D>, new: &Plane<D>, p: usize) -> Result<Plane<D>, Trouble> {
        let stress = if self.conserving {
            self.material.conserving_stress(self.embedding, start, new)
        } else {
            self.material.answer(self.embedding, start, new).map(|answer| answer.stress)
        };
        let stress = stress.map_err(|why| Trouble { particle: p, why })?;
        Ok(if self.updated { times(&stress, &transposed(&start.deformation)) } else { stress })
    }

    #[inline(always)]
    pub(super) fn push<const D: usize, const W: usize>(&self, at: &Point, volume: f64, stress: &Plane<D>, force: &mut [[f64; 3]]) {
        self.reference.each::<D, W>(at, |node, _, slope| {
            for i in 0..D {
                for k in 0..D {
                    force[node][i] -= volume * stress[i][k] * slope[k];
                }
            }
        });
    }
}

fn advance<const D: usize, const W: usize>(task: &Task<'_>, particles: &mut Particles, force: &mut [[f64; 3]]) -> Result<(), Trouble> {
    for p in task.first..task.last {
        let at = task.reference.particle(p - task.offset);
        let (start, new) = task.deform::<D, W>(particles, p, &at);
        let answer = task.material.answer(task.embedding, &start, &new).map_err(|why| Trouble { particle: p, why })?;
        keep(particles, p, &new, &answer, task.embedding.stress_free);
        let stress = if task.updated { times(&answer.stress, &transposed(&start.deformation)) } else { answer.stress };
        task.push::<D, W>(&at, particles.volume[p], &stress, force);
    }
    Ok(())
}

fn force<const D: usize, const W: usize>(task: &Task<'_>, particles: &Particles, force: &mut [[f64; 3]]) -> Result<(), Trouble> {
    for p in task.first..task.last {
        let at = task.reference.particle(p - task.offset);
        let (start, new) = task.deform::<D, W>(particles, p, &at);
        let stress = task.stress(&start, &new, p)?;
        task.push::<D, W>(&at, particles.volume[p], &stress, force);
    }
    Ok(())
}

/// Particles of the same cell share their nodes: their shares are summed in a dense block first.
fn stiffness<const D: usize, const W: usize>(
    task: &Task<'_>,
    particles: &Particles,
    share: f64,
    matrix: &mut Matrix,
) -> Result<(), Trouble> {
    let most = W.pow(D as u32);
    let (mut nodes, mut slopes): (Vec<u32>, Vec<[f64; D]>) = (Vec::with_capacity(most), Vec::with_capacity(most));
    let mut block = vec![0.0; (most * D) * (most * D)];
    let mut cell = None;
    for p in task.first..task.last {
        let at = task.reference.particle(p - task.offset);
        if cell != Some(at.cell()) {
            if cell.is_some() {
                task.reference.add(matrix, &nodes, D, &block);
                block.fill(0.0);
            }
            cell = Some(at.cell());
            nodes.clear();
            task.reference.each::<D, W>(&at, |node, _, _| nodes.push(node as u32));
        }
        slopes.clear();
        task.reference.each::<D, W>(&at, |_, _, slope| slopes.push(slope));
        let (start, new) = task.deform::<D, W>(particles, p, &at);
        let moduli = task.moduli(&start, &new).map_err(|why| Trouble { particle: p, why })?;
        let volume = share * particles.volume[p];
        let rows = most * D;
        for (b, gb) in slopes.iter().enumerate() {
            for k in 0..D {
                // columns of the block are contiguous
                let column = &mut block[(b * D + k) * rows..(b * D + k + 1) * rows];
                let mut part = [[0.0; D]; D];
                for i in 0..D {
                    for j in 0..D {
                        for l in 0..D {
                            part[i][j] += volume * moduli[i][j][k][l] * gb[l];
                        }
                    }
                }
                for (ga, rows) in slopes.iter().zip(column.chunks_exact_mut(D)) {
                    for i in 0..D {
                        for j in 0..D {
                            rows[i] += part[i][j] * ga[j];
                        }
                    }
                }
            }
        }
    }
    if cell.is_some() {
        task.reference.add(matrix, &nodes, D, &block);
    }
    Ok(())
}

fn moduli<const D: usize, const W: usize>(task: &Task<'_>, particles: &Particles, all: &mut Vec<f64>) -> Result<(), Trouble> {
    for p in task.first..task.last {
        let at = task.reference.particle(p - task.offset);
        let (start, new) = task.deform::<D, W>(particles, p, &at);
        let moduli = task.moduli(&start, &new).map_err(|why| Trouble { particle: p, why })?;
        let volume = particles.volume[p];
        all.extend(moduli.as_flattened().as_flattened().as_flattened().iter().map(|a| volume * a));
    }
    Ok(())
}

fn stiffness_times<const D: usize, const W: usize>(task: &Task<'_>, moduli: &[f64], x: &[[f64; 3]], y: &mut [[f64; 3]]) {
    for (p, moduli) in (task.first..task.last).zip(moduli.chunks_exact(D * D * D * D)) {
        let at = task.reference.particle(p - task.offset);
        let mut gradient = [[0.0; D]; D];
        task.reference.each::<D, W>(&at, |node, _, slope: [f64; D]| {
            for i in 0..D {
                for k in 0..D {
                    gradient[i][k] += x[node][i] * slope[k];
                }
            }
        });
        let change = gradient.as_flattened();
        let dot = |row: &[f64]| row.iter().zip(change).map(|(a, b)| a * b).sum::<f64>();
        let stress: Plane<D> = std::array::from_fn(|i| std::array::from_fn(|j| dot(&moduli[(i * D + j) * D * D..][..D * D])));
        // forces of a stress are minus its work, stiffness is minus the derivative of forces
        task.push::<D, W>(&at, -1.0, &stress, y);
    }
}

impl Task<'_> {
    fn moduli<const D: usize>(&self, start: &Start<D>, new: &Plane<D>) -> Result<Tangent<D>, Why> {
        let moduli = if self.conserving {
            self.material.conserving_tangent(self.embedding, start, new)?
        } else {
            let answer = self.material.answer(self.embedding, start, new)?;
            self.material.tangent(self.embedding, start, new, &answer)?
        };
        Ok(if self.updated { pushed(&moduli, &start.deformation) } else { moduli })
    }
}

fn keep<const D: usize>(particles: &mut Particles, p: usize, new: &Plane<D>, answer: &Answer<D>, stress_free: bool) {
    for i in 0..D {
        for k in 0..D {
            particles.deformation.column_mut(i * D + k)[p] = new[i][k];
        }
    }
    particles.history.set_row(p, &answer.history);
    if stress_free {
        particles.lateral.column_mut(0)[p] = answer.lateral;
    }
}

fn rows<const D: usize>(particles: &Particles, p: usize) -> Plane<D> {
    std::array::from_fn(|i| std::array::from_fn(|k| particles.deformation.column(i * D + k)[p]))
}

fn times<const D: usize>(a: &Plane<D>, b: &Plane<D>) -> Plane<D> {
    std::array::from_fn(|i| std::array::from_fn(|k| (0..D).map(|j| a[i][j] * b[j][k]).sum()))
}

fn transposed<const D: usize>(a: &Plane<D>) -> Plane<D> {
    std::array::from_fn(|i| std::array::from_fn(|k| a[k][i]))
}

/// Moduli of the configuration at time 0, seen from a later one with deformation gradient `f`: both second indices are carried along.
fn pushed<const D: usize>(moduli: &Tangent<D>, f: &Plane<D>) -> Tangent<D> {
    let mut out = [[[[0.0; D]; D]; D]; D];
    for i in 0..D {
        for k in 0..D {
            let inner: Plane<D> = std::array::from_fn(|m| std::array::from_fn(|n| moduli[i][m][k][n]));
            // f inner f^T
            let carried = times(&times(f, &inner), &transposed(f));
            for j in 0..D {
                for l in 0..D {
                    out[i][j][k][l] = carried[j][l];
                }
            }
        }
    }
    out
}
