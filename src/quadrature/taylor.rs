//! Least squares with a Taylor basis in one cell (Wobbes, Moller, Galavi, Vuik 2019, IJNME 117, 271-290).
//!
//! In local coordinates, -1 to 1 over the cell, the functions are 1, the coordinates, and halves of their squares and products, each less
//! its mean over the cell. All but the first thus integrate to 0: the first coefficient alone is the mean of the field.

/// Functions of the quadratic basis in three dimensions.
pub(crate) const MOST: usize = 10;

/// Share of a function's mean square over the cell that must remain at the particles after the functions before it are taken out.
/// Below, the fit would amplify what the particles do not resolve by more than 1 / sqrt(share), and goes down a degree.
///
/// Chosen by experiment on smooth fields with 3 and 4 particles a cell and axis. Moved by up to half their spacing: up to 0.003 the error
/// is that without a threshold, from 0.01 on a few cells go down and raise it up to 16 times. Placed at random: within 1 % from 0.001 to
/// 0.003, growing beyond.
const WELL_PLACED: f64 = 0.003;

/// Number of functions up to a degree.
pub(crate) fn functions(dimension: usize, degree: usize) -> usize {
    match degree {
        0 => 1,
        1 => 1 + dimension,
        _ => (1 + dimension) * (2 + dimension) / 2,
    }
}

/// The functions at a place in local coordinates; 0 for functions the dimension does not have.
pub(crate) fn basis(dimension: usize, local: &[f64; 3]) -> [f64; MOST] {
    let mut psi = [0.0; MOST];
    psi[0] = 1.0;
    let mut next = 1 + dimension;
    for a in 0..dimension {
        psi[1 + a] = local[a];
        psi[next] = 0.5 * local[a] * local[a] - 1.0 / 6.0;
        next += 1;
        for b in 0..a {
            psi[next] = local[a] * local[b];
            next += 1;
        }
    }
    psi
}

/// Mean squares of the functions over the cell, in the order of [`basis`].
fn mean_squares(dimension: usize) -> [f64; MOST] {
    let mut squares = [1.0 / 9.0; MOST];
    squares[0] = 1.0;
    let mut next = 1 + dimension;
    for a in 0..dimension {
        squares[1 + a] = 1.0 / 3.0;
        squares[next] = 1.0 / 45.0;
        next += 1 + a;
    }
    squares
}

/// Cholesky factor of the normal equations of a cell.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Factor {
    /// Functions up to the degree that the particles carry: 2, else 1, else 0.
    pub(crate) functions: usize,
}

/// Numbers that the factor of a cell needs.
pub(crate) fn factor_length(dimension: usize) -> usize {
    let n = functions(dimension, 2);
    n * (n + 1) / 2
}

/// Place of a number in a lower triangle stored row by row.
fn at(row: usize, column: usize) -> usize {
    row * (row + 1) / 2 + column
}

impl Factor {
    /// Factors the system for particles at `local` coordinates into `lower`, of [`factor_length`].
    ///
    /// Functions come by degree, so that a smaller fit is a leading block. Each pivot is what remains at the particles of the square of
    /// its function: too little, and the fit ends with the degree before.
    pub(crate) fn new(dimension: usize, local: &[[f64; 3]], lower: &mut [f64]) -> Self {
        let n = functions(dimension, 2);
        lower.fill(0.0);
        for place in local {
            let psi = basis(dimension, place);
            for i in 0..n {
                for j in 0..=i {
                    lower[at(i, j)] += psi[i] * psi[j];
                }
            }
        }
        let required = mean_squares(dimension).map(|square| WELL_PLACED * local.len() as f64 * square);
        let up_to = |degree: usize| Self { functions: functions(dimension, degree) };
        for i in 0..n {
            for j in 0..i {
                let known: f64 = (0..j).map(|k| lower[at(i, k)] * lower[at(j, k)]).sum();
                lower[at(i, j)] = (lower[at(i, j)] - known) / lower[at(j, j)];
            }
            let pivot = lower[at(i, i)] - (0..i).map(|k| lower[at(i, k)].powi(2)).sum::<f64>();
            if pivot < required[i] {
                return up_to(usize::from(i > dimension));
            }
            lower[at(i, i)] = pivot.sqrt();
        }
        up_to(2)
    }

    /// Coefficients of fields from their `values` at the particles.
    pub(crate) fn solve<const K: usize>(
        &self,
        dimension: usize,
        lower: &[f64],
        local: &[[f64; 3]],
        values: impl Iterator<Item = [f64; K]>,
    ) -> [[f64; K]; MOST] {
        let n = self.functions;
        let mut c = [[0.0; K]; MOST];
        for (place, value) in local.iter().zip(values) {
            let psi = basis(dimension, place);
            for i in 0..n {
                for k in 0..K {
                    c[i][k] += psi[i] * value[k];
                }
            }
        }
        for i in 0..n {
            for k in 0..K {
                let known: f64 = (0..i).map(|j| lower[at(i, j)] * c[j][k]).sum();
                c[i][k] = (c[i][k] - known) / lower[at(i, i)];
            }
        }
        for i in (0..n).rev() {
            for k in 0..K {
                let known: f64 = (i + 1..n).map(|j| lower[at(j, i)] * c[j][k]).sum();
                c[i][k] = (c[i][k] - known) / lower[at(i, i)];
            }
        }
        c
    }
}
