//! The sums of [`force`](super::force) with the volume ratio of each cell in the place of those of its particles: what keeps nearly
//! incompressible bodies from locking (Nagtegaal et al. 1974; de Souza Neto et al. 1996; here with a potential, Simo et al. 1985).
//!
//! F* = (theta / J)^(1/3) F with theta the mean of J over the cell. The energy is that of F*, and forces are its derivatives.

use super::force::{Sweeps, Task, Trouble};
use super::reference::Point;
use crate::implicit::Matrix;
use crate::material::embed;
use crate::material::point::{self, Moduli, Plane, Trouble as Why};
use crate::state::Particles;
use nalgebra::Matrix3;

pub(super) const fn sweeps<const D: usize, const W: usize>() -> Sweeps {
    Sweeps { advance: advance::<D, W>, force: force::<D, W>, stiffness: stiffness::<D, W>, linear: None }
}

/// A particle of a cell.
struct Member {
    particle: usize,
    at: Point,
    volume: f64,
    jacobian: f64,
    /// F^-T.
    back: Matrix3<f64>,
    /// F*.
    mean: Matrix3<f64>,
    /// Kirchhoff stress of F* \[Pa\].
    stress: Matrix3<f64>,
}

/// A cell with its particles.
struct Cell {
    members: Vec<Member>,
    volume: f64,
    /// Mean volume ratio.
    theta: f64,
    /// Mean of a third of the trace of the stress \[Pa\].
    pressure: f64,
}

impl Cell {
    /// The particles from `first` on that share their nodes.
    fn new<const D: usize, const W: usize>(task: &Task<'_>, particles: &Particles, first: usize) -> Result<Self, Trouble> {
        let mut cell = Self { members: Vec::new(), volume: 0.0, theta: 0.0, pressure: 0.0 };
        let nodes = task.reference.particle(first - task.offset).cell();
        for particle in first..task.last {
            let at = task.reference.particle(particle - task.offset);
            if at.cell() != nodes {
                break;
            }
            let (_, plane) = task.deform::<D, W>(particles, particle, &at);
            let f = embed(&plane, 1.0);
            let jacobian = f.determinant();
            // not `<= 0`: NaN is trouble too
            let inverse = if jacobian > 0.0 { f.try_inverse() } else { None };
            let back = inverse.ok_or(Trouble { particle, why: Why::Inverted(jacobian) })?.transpose();
            let volume = particles.volume[particle];
            cell.volume += volume;
            cell.theta += volume * jacobian;
            cell.members.push(Member { particle, at, volume, jacobian, back, mean: f, stress: Matrix3::zeros() });
        }
        cell.theta /= cell.volume;
        for member in &mut cell.members {
            member.mean *= (cell.theta / member.jacobian).cbrt();
            member.stress = task.material.kirchhoff(&member.mean, &[0.0; 7]);
            cell.pressure += member.volume * member.stress.trace() / 3.0;
        }
        cell.pressure /= cell.volume;
        Ok(cell)
    }

    /// First Piola-Kirchhoff stress of a member \[Pa\].
    fn first_piola(&self, member: &Member) -> Matrix3<f64> {
        self.kirchhoff(member) * member.back
    }

    fn kirchhoff(&self, member: &Member) -> Matrix3<f64> {
        deviator(&member.stress) + Matrix3::from_diagonal_element(self.pressure * member.jacobian / self.theta)
    }
}

fn deviator(a: &Matrix3<f64>) -> Matrix3<f64> {
    a - Matrix3::from_diagonal_element(a.trace() / 3.0)
}

fn cells<const D: usize, const W: usize>(
    task: &Task<'_>,
    particles: &Particles,
    mut each: impl FnMut(&Cell) -> Result<(), Trouble>,
) -> Result<(), Trouble> {
    let mut first = task.first;
    while first < task.last {
        let cell = Cell::new::<D, W>(task, particles, first)?;
        each(&cell)?;
        first += cell.members.len();
    }
    Ok(())
}

fn push<const D: usize, const W: usize>(task: &Task<'_>, cell: &Cell, force: &mut [[f64; 3]]) {
    for member in &cell.members {
        let stress: Plane<D> = point::cut(&cell.first_piola(member));
        task.push::<D, W>(&member.at, member.volume, &stress, force);
    }
}

fn advance<const D: usize, const W: usize>(task: &Task<'_>, particles: &mut Particles, force: &mut [[f64; 3]]) -> Result<(), Trouble> {
    let mut kept = Vec::new();
    cells::<D, W>(task, particles, |cell| {
        push::<D, W>(task, cell, force);
        kept.extend(cell.members.iter().map(|member| (member.particle, member.mean)));
        Ok(())
    })?;
    // particles show F*: stress and energy follow from it
    for (p, mean) in kept {
        for i in 0..D {
            for k in 0..D {
                particles.deformation.column_mut(i * D + k)[p] = mean[(i, k)];
            }
        }
        if particles.lateral.width() > 0 {
            particles.lateral.column_mut(0)[p] = mean[(2, 2)];
        }
    }
    Ok(())
}

fn force<const D: usize, const W: usize>(task: &Task<'_>, particles: &Particles, force: &mut [[f64; 3]]) -> Result<(), Trouble> {
    cells::<D, W>(task, particles, |cell| {
        push::<D, W>(task, cell, force);
        Ok(())
    })
}

fn stiffness<const D: usize, const W: usize>(
    task: &Task<'_>,
    particles: &Particles,
    share: f64,
    matrix: &mut Matrix,
) -> Result<(), Trouble> {
    let size = W.pow(D as u32) * D;
    let mut block = vec![0.0; size * size];
    let (mut nodes, mut slopes) = (Vec::new(), Vec::new());
    cells::<D, W>(task, particles, |cell| {
        block.fill(0.0);
        nodes.clear();
        task.reference.each::<D, W>(&cell.members[0].at, |node, _, _| nodes.push(node as u32));
        // derivatives by the displacements: of theta, of the pressure at fixed theta; and forces for a unit of theta
        let (mut of_theta, mut of_pressure, mut by_theta) = (vec![0.0; size], vec![0.0; size], vec![0.0; size]);
        let mut pressure_by_theta = 0.0;
        for member in &cell.members {
            slopes.clear();
            task.reference.each::<D, W>(&member.at, |_, _, slope: [f64; D]| slopes.push(slope));
            let moduli = Moduli::new(task.material, &member.mean);
            let kirchhoff = cell.kirchhoff(member);
            let weight = member.volume / cell.volume;
            // what a growth of theta does: F* grows alike in all directions
            let growth = moduli.change(&Matrix3::from_diagonal_element(1.0 / (3.0 * cell.theta)));
            pressure_by_theta += weight * growth.trace() / 3.0;
            let fall = cell.pressure * member.jacobian / (cell.theta * cell.theta);
            let piola_by_theta = (deviator(&growth) - Matrix3::from_diagonal_element(fall)) * member.back;
            let mut local = [[[[0.0; D]; D]; D]; D];
            let (mut theta, mut pressure) = ([[0.0; D]; D], [[0.0; D]; D]);
            for k in 0..D {
                for l in 0..D {
                    let mut df = Matrix3::zeros();
                    df[(k, l)] = 1.0;
                    let motion = df * member.back.transpose();
                    let trace = motion.trace();
                    let change = moduli.change(&deviator(&motion));
                    let grows = Matrix3::from_diagonal_element(cell.pressure * member.jacobian / cell.theta * trace);
                    let piola = (deviator(&change) + grows - kirchhoff * motion.transpose()) * member.back;
                    for i in 0..D {
                        for j in 0..D {
                            local[i][j][k][l] = piola[(i, j)];
                        }
                    }
                    theta[k][l] = weight * member.jacobian * trace;
                    pressure[k][l] = weight * change.trace() / 3.0;
                }
            }
            for (b, gb) in slopes.iter().enumerate() {
                for k in 0..D {
                    let column = b * D + k;
                    for l in 0..D {
                        of_theta[column] += theta[k][l] * gb[l];
                        of_pressure[column] += pressure[k][l] * gb[l];
                        by_theta[column] += member.volume * piola_by_theta[(k, l)] * gb[l];
                    }
                    for (a, ga) in slopes.iter().enumerate() {
                        for i in 0..D {
                            let mut sum = 0.0;
                            for j in 0..D {
                                for l in 0..D {
                                    sum += local[i][j][k][l] * ga[j] * gb[l];
                                }
                            }
                            block[column * size + a * D + i] += share * member.volume * sum;
                        }
                    }
                }
            }
        }
        // forces for a unit of pressure are those of theta, times the volume of the cell over theta
        let by_pressure = cell.volume / cell.theta;
        for column in 0..size {
            let change = of_pressure[column] + pressure_by_theta * of_theta[column];
            for row in 0..size {
                block[column * size + row] += share * (by_theta[row] * of_theta[column] + by_pressure * of_theta[row] * change);
            }
        }
        task.reference.add(matrix, &nodes, D, &block);
        Ok(())
    })
}
